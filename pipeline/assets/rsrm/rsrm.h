// Gradients, painted or averaged from an environment, as radially symmetric reflection maps; and their verification.
#pragma once

#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// "rsrm". Input "source"; parameters: colors, exponents, width, format, dither, textures, repair, and of a painted gradient encoding, of
/// an environment axis and zones.
formats::Result<ActionOutcome> cookRsrm(const ActionContext& context);
/// "verify-rsrm": upstream the cooked asset; parameters: max_error. Measures: code_error, step_codes, step_contrast, band_codes (see
/// verify::RsrmBanding), and of an environment asymmetric_energy and gradient_uncertainty (over the gradient's largest value).
formats::Result<ActionOutcome> verifyRsrm(const ActionContext& context);

}  // namespace lightcook::pipeline

// Fit of the first stage of a learned layout: the quadratic decode of each cluster, and the codes of the sample. Private to compress/.
//
// 1. Start: the codes are the principal coordinates of each cluster's ratios (error_space.h), kDeviationsAcross standard deviations wide.
// 2. Alternate kRounds times: tables by least squares for these codes (table_fit.h), then codes by Levenberg-Marquardt for these tables
//    (code_solver.h).
// 3. Stretch the codes of each cluster to fill [0, 1], beyond kRangeDeviations clamped, and fit tables and codes once more.
// 4. kEncodeRounds times: send the codes through the block encoder, fit the tables to the decoded codes, solve the codes. Codes then
//    converge to values that blocks can hold. A last pass through the encoder gives the error that the residual layers start from.
#pragma once

#include "compress/light_map/basis/sample.h"

namespace lightcook::compress {

/// Codes beyond this number of standard deviations are clamped, so that a few texels do not make the quantization of all codes coarse.
inline constexpr float kRangeDeviations = 6;

/// Fits model.code, model.seeds and model.codeWeights to the sample, whose texels have clusters. Then subtracts the decoded codes from the
/// texels' ratios.
void fitCodes(BasisSample& sample, BasisModel& model);

}  // namespace lightcook::compress

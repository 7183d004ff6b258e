// Facts of a gradient that its plausibility is judged by. A cached action.
#pragma once

#include <optional>
#include <string>

#include "formats/color.h"
#include "pipeline/document/json_fields.h"
#include "pipeline/graph/action.h"
#include "pipeline/lint/stated_primaries.h"

namespace lightcook::pipeline {

struct GradientFacts {
    double largest = 0;  ///< largest channel of any texel
    std::optional<formats::StatedPrimaries> primaries = {};
};
template <class Fields, Is<GradientFacts> Self>
void describe(Fields& fields, Self& facts) {
    fields.required("largest", facts.largest, "largest channel of any texel");
    fields.optional("primaries", facts.primaries, "primaries that the file states");
}

/// Parameters of the action. Its input is "source", one file or the first of six.
struct GradientLintParameters {
    formats::ColorSpaces colors;
    bool repair = false;
    std::string encoding;        ///< of a painted gradient
    bool isEnvironment = false;  ///< the file is averaged around an axis
};
template <class Fields, Is<GradientLintParameters> Self>
void describe(Fields& fields, Self& parameters) {
    fields.required("colors", parameters.colors, "colour spaces");
    fields.required("repair", parameters.repair, "true to replace texels that are not finite");
    fields.required("encoding", parameters.encoding, "encoding of a painted gradient");
    fields.required("is_environment", parameters.isEnvironment, "true if the file is averaged around an axis");
}

/// Action "lint-gradient". Its result is GradientFacts.
formats::Result<ActionOutcome> lintGradient(const ActionContext& context);

}  // namespace lightcook::pipeline

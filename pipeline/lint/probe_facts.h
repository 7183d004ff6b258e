// Facts of a probe that its plausibility is judged by. A cached action.
#pragma once

#include <optional>
#include <string>

#include "formats/color.h"
#include "pipeline/document/json_fields.h"
#include "pipeline/graph/action.h"
#include "pipeline/lint/stated_primaries.h"

namespace lightcook::pipeline {

struct ProbeFacts {
    bool isEightBit = false;                         ///< every value is one of 256 levels in [0, 1], linear or under the sRGB curve
    double largest = 0;                              ///< largest channel of any texel
    double atLargest = 0;                            ///< share of the texels with a channel of that value
    double meanRadiance = 0;                         ///< mean luminance over the sphere
    std::optional<double> shDifference = {};         ///< RMS of image's SH minus given SH, over the RMS of the given SH
    std::optional<double> shDifferenceDecoded = {};  ///< the same after a gamma curve of 2.2 is undone in the image
    std::optional<formats::StatedPrimaries> primaries = {};
};
template <class Fields, Is<ProbeFacts> Self>
void describe(Fields& fields, Self& facts) {
    fields.required("is_eight_bit", facts.isEightBit, "true if every value is one of 256 levels in [0, 1], linear or under the sRGB curve");
    fields.required("largest", facts.largest, "largest channel of any texel");
    fields.required("at_largest", facts.atLargest, "share of the texels with a channel of that value");
    fields.required("mean_radiance", facts.meanRadiance, "mean luminance over the sphere");
    fields.optional("sh_difference", facts.shDifference, "RMS of the image's SH minus the given SH, over the RMS of the given SH");
    fields.optional("sh_difference_decoded", facts.shDifferenceDecoded, "the same after a gamma curve of 2.2 is undone in the image");
    fields.optional("primaries", facts.primaries, "primaries that the file states");
}

/// Parameters of the action. Its inputs are "source" (one file or the first of six) and optionally "sh".
struct ProbeLintParameters {
    formats::ColorSpaces colors;
    bool repair = false;
    std::optional<std::string> probeFile = {};  ///< name by which input "sh" knows the probe
};
template <class Fields, Is<ProbeLintParameters> Self>
void describe(Fields& fields, Self& parameters) {
    fields.required("colors", parameters.colors, "colour spaces");
    fields.required("repair", parameters.repair, "true to replace texels that are not finite");
    fields.optional("probe_file", parameters.probeFile, "name of the probe in the SH file");
}

/// Action "lint-probe". Its result is ProbeFacts.
formats::Result<ActionOutcome> lintProbe(const ActionContext& context);

}  // namespace lightcook::pipeline

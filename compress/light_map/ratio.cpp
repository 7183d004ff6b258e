// Families ratio and sh4: coefficient 0 as HDR colour in texture "l0", the other coefficients divided by the decoded l0 in the layers of
// texture "ratio".
//
// Dividing by the decoded l0 and not by the true one makes the error of l0 cancel in the product. An error of a ratio is seen
// multiplied by l0, so texels weigh by its square. Where l0 decodes to black every ratio gives black; 0 is stored.
#include <algorithm>

#include "compress/light_map/families.h"

namespace lightcook::compress::rows {

namespace {

using formats::Image;

/// Returns the texels of a layer of texture "ratio": a coefficient over the decoded coefficient 0, mapped to [0, 1]. Counts in `report`
/// what lies outside. values  of the coefficient dc      decoded coefficient 0
Image<glm::vec4> ratioTexels(const Source& source, const Image<glm::vec3>& values, const Image<glm::vec3>& dc, float scale, float bias,
                             EncodeReport& report) {
    Image<glm::vec4> texels(source.width, source.height, glm::vec4(0, 0, 0, 1));
    for (int y = 0; y < source.height; ++y)
        for (int x = 0; x < source.width; ++x)
            for (int channel = 0; channel < 3; ++channel) {
                const float decoded = dc.at(x, y)[channel];
                const float ratio = decoded > 0 ? values.at(x, y)[channel] / decoded : 0;
                const float unit = scale > 0 ? (ratio - bias) / scale : 0;
                if (source.coverage.at(x, y) == 1) {
                    report.clampedHigh += unit > 1.0001f ? 1 : 0;
                    report.clampedNegative += unit < -0.0001f ? 1 : 0;
                }
                texels.at(x, y)[channel] = std::clamp(unit, 0.0f, 1.0f);
            }
    return texels;
}

}  // namespace

void planRatio(LightMapPlan& plan, const LightMapMeasure& measure) {
    plan.constants["range"] = {halfRange(measure.maximumAbsolute(0))};
    for (int i = 1; i <= plan.textures[1].layerCount; ++i) {
        plan.constants["scale"].push_back(measure.maximumRatio(i) - measure.minimumRatio(i));
        plan.constants["bias"].push_back(measure.minimumRatio(i));
    }
}

EncodedLightMapRows encodeRatio(const LightMapPlan& plan, const Source& source, const EncodeOptions& options) {
    EncodedLightMapRows out;
    out.textures.resize(2);
    const float range = constant(plan, "range", 0);
    Layer l0 = encodeHdr(plan, source, source.values[0], range, options, true, out.report);
    out.textures[0].layers.push_back(std::move(l0.bytes));
    Image<glm::vec3> dc(source.width, source.height, glm::vec3(0));
    Image<float> significance(source.width, source.height, 0);
    for (int y = 0; y < source.height; ++y)
        for (int x = 0; x < source.width; ++x) {
            dc.at(x, y) = range * glm::vec3(l0.decoded.at(x, y));
            significance.at(x, y) = ratioSignificance(plan, source, x, y, dc.at(x, y));
        }
    for (std::size_t i = 0; i < static_cast<std::size_t>(plan.textures[1].layerCount); ++i) {
        Image<glm::vec4> texels =
            ratioTexels(source, source.values[i + 1], dc, constant(plan, "scale", i), constant(plan, "bias", i), out.report);
        Layer layer = encodeLayer(plan.textures[1].format, texels, significance, options, false, out.report);
        out.textures[1].layers.push_back(std::move(layer.bytes));
    }
    return out;
}

}  // namespace lightcook::compress::rows

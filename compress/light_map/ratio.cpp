// Families ratio, sh4 and zh3: coefficient 0 as HDR colour in texture "l0", the other coefficients divided by the decoded l0 in the layers
// of texture "ratio".
//
// Dividing by the decoded l0 and not by the true one makes the error of l0 cancel in the product. An error of a ratio is seen
// multiplied by l0, so texels weigh by its square. Where l0 decodes to black every ratio gives black; 0 is stored.
// The layout zh3 stores band 2 as one zonal number along the axis of the decoded band 1 (zonal.h), so band 1 is encoded first.
#include <algorithm>
#include <array>

#include "compress/light_map/families.h"
#include "compress/light_map/zonal.h"

namespace lightcook::compress::rows {

namespace {

using formats::Image;

/// Returns the number of layers of texture "ratio" that hold a coefficient each. The last layer of a zonal layout holds band 2.
std::size_t ratioCoefficients(const LightMapPlan& plan) {
    return static_cast<std::size_t>(plan.textures[1].layerCount - (formats::info(plan.layout).isZonal ? 1 : 0));
}

class RatioLayers {
public:
    /// Encodes texture "l0".
    RatioLayers(const LightMapPlan& plan, const Source& source, const EncodeOptions& options)
        : plan_(plan), source_(source), options_(options), range_(constant(plan, "range", 0)) {
        out_.textures.resize(2);
        Layer l0 = encodeHdr(plan, source, source.values[0], range_, options, true, out_.report);
        out_.textures[0].layers.push_back(std::move(l0.bytes));
        l0_ = std::move(l0.decoded);
        significance_ = Image<float>(source.width, source.height, 0);
        for (int y = 0; y < source.height; ++y)
            for (int x = 0; x < source.width; ++x) {
                significance_.at(x, y) = ratioSignificance(plan, source, x, y, range_ * glm::vec3(l0_.at(x, y)));
            }
    }

    /// Encodes the next layer of texture "ratio" from values of a coefficient. Returns its decoded texels if they are wanted.
    Image<glm::vec4> add(const Image<glm::vec3>& values, bool wantsDecoded) {
        const std::size_t index = out_.textures[1].layers.size();
        const float scale = constant(plan_, "scale", index), bias = constant(plan_, "bias", index);
        Image<glm::vec4> texels(source_.width, source_.height, glm::vec4(0, 0, 0, 1));
        for (int y = 0; y < source_.height; ++y)
            for (int x = 0; x < source_.width; ++x) {
                const glm::vec4& dc = l0_.at(x, y);
                for (int channel = 0; channel < 3; ++channel) {
                    const float decoded = range_ * dc[channel];
                    const float ratio = decoded > 0 ? values.at(x, y)[channel] / decoded : 0;
                    const float unit = scale > 0 ? (ratio - bias) / scale : 0;
                    if (source_.coverage.at(x, y) == 1) {
                        out_.report.clampedHigh += unit > 1.0001f ? 1 : 0;
                        out_.report.clampedNegative += unit < -0.0001f ? 1 : 0;
                    }
                    texels.at(x, y)[channel] = std::clamp(unit, 0.0f, 1.0f);
                }
            }
        Layer layer = encodeLayer(plan_.textures[1].format, texels, significance_, options_, wantsDecoded, out_.report);
        out_.textures[1].layers.push_back(std::move(layer.bytes));
        return std::move(layer.decoded);
    }

    /// Returns coefficient index + 1 as the shader decodes it.
    glm::vec3 decoded(const Image<glm::vec4>& ratio, std::size_t index, int x, int y) const {
        return range_ * glm::vec3(l0_.at(x, y)) *
               (constant(plan_, "scale", index) * glm::vec3(ratio.at(x, y)) + constant(plan_, "bias", index));
    }
    EncodedLightMapRows finish() && { return std::move(out_); }

private:
    const LightMapPlan& plan_;
    const Source& source_;
    const EncodeOptions& options_;
    float range_;
    Image<glm::vec4> l0_;
    Image<float> significance_;
    EncodedLightMapRows out_;
};

}  // namespace

void planRatio(LightMapPlan& plan, const LightMapMeasure& measure) {
    plan.constants["range"] = {halfRange(measure.maximumAbsolute(0))};
    const auto add = [&](float minimum, float maximum) {
        plan.constants["scale"].push_back(maximum - minimum);
        plan.constants["bias"].push_back(minimum);
    };
    for (int i = 1; i <= static_cast<int>(ratioCoefficients(plan)); ++i) add(measure.minimumRatio(i), measure.maximumRatio(i));
    if (!formats::info(plan.layout).isZonal) return;
    add(measure.minimumZonal(), measure.maximumZonal());
    const glm::vec3& weights = measure.luminanceWeights();
    plan.constants["luminance"] = {weights.x, weights.y, weights.z};
}

EncodedLightMapRows encodeRatio(const LightMapPlan& plan, const Source& source, const EncodeOptions& options) {
    RatioLayers layers(plan, source, options);
    const bool isZonal = formats::info(plan.layout).isZonal;
    std::vector<Image<glm::vec4>> decoded;
    for (std::size_t i = 0; i < ratioCoefficients(plan); ++i) decoded.push_back(layers.add(source.values[i + 1], isZonal));
    if (isZonal) {
        const auto band1 = [&](std::size_t i, int x, int y) { return layers.decoded(decoded[i - 1], i - 1, x, y); };
        layers.add(alongAxis(plan, source, band1, zonalAlong), false);
    }
    return std::move(layers).finish();
}

}  // namespace lightcook::compress::rows

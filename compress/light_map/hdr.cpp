// Family hdr: all nine coefficients as HDR colours. Coefficient i is stored as lambda_i - bias_i lambda_0, where bias_i is the least ratio
// of the two in the map: a value that is not negative, for formats that hold no sign. The decode is linear, so light between texels is the
// filtered light of the texels, also at hard edges, where the products of other layouts err most.
//
// The decoded coefficient 0 is subtracted, so that its error does not enter twice.
#include <algorithm>
#include <glm/common.hpp>

#include "compress/light_map/families.h"

namespace lightcook::compress::rows {

namespace {

using formats::Image;

/// The bias lies below the least ratio by this factor, so that an error of the decoded coefficient 0 makes no value negative.
constexpr float kHeadroom = 1.02f;

class HdrLayers {
public:
    HdrLayers(const LightMapPlan& plan, const Source& source, const EncodeOptions& options)
        : plan_(plan), source_(source), options_(options), range_(constant(plan, "range", 0)) {
        options_.hdrMetric = HdrMetric::Linear;
        out_.textures.resize(plan.textures.size());
        significance_ = linearSignificance(source);
    }

    EncodedLightMapRows encode() && {
        const bool hasSecond = plan_.textures.size() > 1;
        std::vector<Image<glm::vec4>> first;
        Image<glm::vec4> decoded0;
        for (std::size_t i = 0; i < source_.values.size(); ++i) {
            first.push_back(addFirst(valuesOf(i, decoded0), i == 0 || hasSecond));
            if (i == 0) decoded0 = first[0].copy();
        }
        for (std::size_t i = 0; i < source_.values.size() && hasSecond; ++i) {
            const float share = constant(plan_, "share", 0);
            Layer second = encodeSecond(plan_, source_, valuesOf(i, decoded0), out_.textures[0].layers[i], first[i], options_, out_.report);
            for (int y = 0; i == 0 && y < source_.height; ++y)
                for (int x = 0; x < source_.width; ++x) decoded0.at(x, y) = glm::mix(first[0].at(x, y), second.decoded.at(x, y), share);
            out_.textures[1].layers.push_back(std::move(second.bytes));
        }
        return std::move(out_);
    }

private:
    /// Returns what the texels of coefficient i store beside a decoded coefficient 0 (over range).
    Image<glm::vec4> valuesOf(std::size_t i, const Image<glm::vec4>& decoded0) const {
        Image<glm::vec4> values(source_.width, source_.height);
        for (int y = 0; y < source_.height; ++y)
            for (int x = 0; x < source_.width; ++x) {
                const glm::vec3 value = source_.values[i].at(x, y) / range_;
                values.at(x, y) = glm::vec4(i == 0 ? value : value - constant(plan_, "bias", i - 1) * glm::vec3(decoded0.at(x, y)), 1);
            }
        return values;
    }
    /// Encodes the next layer of the first texture. Returns its decoded texels if they are wanted.
    Image<glm::vec4> addFirst(Image<glm::vec4> texels, bool wantsDecoded) {
        for (int y = 0; y < source_.height; ++y)
            for (int x = 0; x < source_.width; ++x) {
                glm::vec4& texel = texels.at(x, y);
                for (int channel = 0; channel < 3 && source_.coverage.at(x, y) == 1; ++channel)
                    out_.report.clampedNegative += texel[channel] < 0 ? 1 : 0;
                texel = glm::vec4(glm::max(glm::vec3(texel), glm::vec3(0)), 1);
            }
        Layer layer = encodeLayer(plan_.textures[0].format, texels, significance_, options_, wantsDecoded, out_.report);
        out_.textures[0].layers.push_back(std::move(layer.bytes));
        return std::move(layer.decoded);
    }

    const LightMapPlan& plan_;
    const Source& source_;
    EncodeOptions options_;
    float range_;
    Image<float> significance_;
    EncodedLightMapRows out_;
};

}  // namespace

void planHdrCoefficients(LightMapPlan& plan, const LightMapMeasure& measure) {
    float largest = measure.maximumAbsolute(0);
    for (int i = 1; i < lighting::kShCount; ++i) {
        const float bias = kHeadroom * measure.minimumRatio(i);
        plan.constants["bias"].push_back(bias);
        largest = std::max(largest, measure.maximumAbsolute(i) - bias * measure.maximumAbsolute(0));
    }
    plan.constants["range"] = {halfRange(largest)};
    if (plan.textures.size() > 1) plan.constants["share"] = {kSecondShare};
}

EncodedLightMapRows encodeHdrCoefficients(const LightMapPlan& plan, const Source& source, const EncodeOptions& options) {
    return HdrLayers(plan, source, options).encode();
}

}  // namespace lightcook::compress::rows

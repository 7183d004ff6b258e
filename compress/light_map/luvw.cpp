// Family luvw: each coefficient as its length L and its signed colour uvw, in two textures (Hu 2008).
//
//   L = largest absolute channel, uvw = value / L in [-1, 1]
//   first texture:  rgb0 = (uvw + 1) / 2, a0 = L over its range
//   second texture: rgb1 = the residual of uvw over span, a1 = the factor that corrects L
//   decode: RANGE a0 a1 (2 rgb0 - 1 + 2 SPAN (rgb1 - NEUTRAL.rgb))
//
// Stages run in this order, each against the decoded texels of those before it: rgb0, a0, rgb1, a1. a1 is the least-squares length for the
// uvw that both textures really give. In BC3 colour and alpha are separate blocks with separate weights. An error of uvw is seen multiplied
// by L and weighs by L^2. An error of L is not: weighed by L^2 too, dark texels beside bright ones became black, and the second
// texture cannot repair black.
// a0 is at least one code: below it a1 alone holds L, so that two times 8 bits reach from the brightest texel down to 1/65025 of it. Roots
// of L (constant "root", Halo 3) reach as far, but the filter of a GPU does not commute with them: beside a bright texel they are far too
// dark.
#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "compress/light_map/families.h"
#include "compress/light_map/zonal.h"

namespace lightcook::compress {

namespace rows {

namespace {

using formats::Image;
using formats::PixelFormat;

/// Half the range of the residual of uvw. Halo 3 has 1; the residuals of BC1 colours are far smaller.
/// docs/lab/compress-light-maps.md has error against span.
constexpr float kLuvwSpan = 0.125f;
constexpr float kHalfCode = 0.5f / 255;
/// Least weight over the coverage, in place of kLeastWeight. It is smaller, since the weights fall with the square of L.
constexpr float kLeastLuvwWeight = 1e-9f;

/// The constants of the form that are the same for all coefficients.
struct LuvwForm {
    glm::vec4 neutral;  ///< second texel that leaves the first as it is
    bool isRoot;        ///< both alphas hold the square root of L
};

bool isHalo3(const LightMapPlan& plan) {
    return plan.layout == formats::LightMapLayout::Halo3 || plan.layout == formats::LightMapLayout::Halo3Linear;
}

LuvwForm formOf(const LightMapPlan& plan) {
    if (isHalo3(plan)) return {glm::vec4(0.5f, 0.5f, 0.5f, 1), true};
    // Neutral a1 is 4/5, so that the second texture can raise an L that the first one rounded down; 204/255 is exact in 8 bits. Neutral
    // rgb1 is the code nearest to 1/2 that 5 and 6 bits hold exactly: a texel without residual has no error there.
    constexpr float neutral = 0.8f;
    const bool isBc = plan.target == formats::Target::Bc;
    return {isBc ? glm::vec4(16.0f / 31, 32.0f / 63, 16.0f / 31, neutral) : glm::vec4(glm::vec3(128.0f / 255), neutral), false};
}

/// Returns half the range of the residual of uvw.
float spanOf(const LightMapPlan& plan) {
    return isHalo3(plan) ? 1 : kLuvwSpan;
}

class LuvwCoefficient {
public:
    /// values  of a coefficient, or intensities
    /// index   of its layers and constants
    LuvwCoefficient(const LightMapPlan& plan, const Source& source, const Image<glm::vec3>& values, std::size_t index,
                    const EncodeOptions& options, EncodeReport& report)
        : source_(source),
          values_(values),
          options_(options),
          report_(report),
          format_(plan.textures[0].format),
          range_(constant(plan, "range", index)),
          span_(spanOf(plan)),
          isRoot_(formOf(plan).isRoot),
          hasCodes_(plan.target != formats::Target::Float),
          neutral_(formOf(plan).neutral) {}

    void encode(std::vector<std::byte>& first, std::vector<std::byte>& second) {
        Layer firstLayer = encodeFirst();
        Layer secondLayer = encodeSecond(firstLayer.decoded);
        second = std::move(secondLayer.bytes);
        first = std::move(firstLayer.bytes);
        firstDecoded_ = std::move(firstLayer.decoded);
        secondDecoded_ = std::move(secondLayer.decoded);
    }
    /// Returns the value as the shader decodes it. Call after encode.
    glm::vec3 decoded(int x, int y) const {
        const glm::vec4 &first = firstDecoded_.at(x, y), &second = secondDecoded_.at(x, y);
        return range_ * first.w * second.w * uvwOf(first, second);
    }

private:
    float length(int x, int y) const {
        const glm::vec3 v = glm::abs(values_.at(x, y));
        return std::max({v.x, v.y, v.z});
    }

    /// Weights of uvw: the importance times L^2.
    Image<float> colorSignificance() const {
        Image<float> significance(source_.width, source_.height, 0);
        for (int y = 0; y < source_.height; ++y)
            for (int x = 0; x < source_.width; ++x) {
                const float l = range_ > 0 ? length(x, y) / (range_ * neutral_.w) : 0;
                significance.at(x, y) = significanceOf(source_, x, y, source_.importance.at(x, y) * l * l, kLeastLuvwWeight);
            }
        return significance;
    }

    Layer encodeFirst() {
        Image<glm::vec4> texels(source_.width, source_.height, glm::vec4(0.5f, 0.5f, 0.5f, 0));
        for (int y = 0; y < source_.height; ++y)
            for (int x = 0; x < source_.width; ++x) {
                const float l = length(x, y);
                if (!(l > 0)) continue;
                const float a0 = std::min(1.0f, l / (range_ * neutral_.w));
                texels.at(x, y) = glm::vec4(0.5f + (0.5f / l) * values_.at(x, y), isRoot_ ? std::sqrt(a0) : raised(a0));
            }
        EncodeOptions options = options_;
        // ASTC encodes alpha with the colours. A code of a dark a0 is a large part of its light.
        constexpr float kAlphaWeight = 256;
        if (format_ != PixelFormat::Bc3) options.channelWeights[3] = kAlphaWeight;
        Layer layer = encodeLayer(format_, texels, colorSignificance(), options, true, report_);
        if (format_ != PixelFormat::Bc3) return layer;
        return withAlpha(std::move(layer), texels, alphaSignificance(texels));
    }

    /// Returns a0. If it is only a few codes, returns the least code from which a1 can lower it to a0: a dark texel whose a0 is rounded
    /// down to 0 would be black, and a1 can raise by a quarter at most.
    float raised(float a0) const {
        constexpr float kFewCodes = 8;
        const float code = 255 * a0, nearest = std::max(1.0f, std::round(code));
        if (!hasCodes_ || code >= kFewCodes) return a0;
        return (neutral_.w * code > nearest ? nearest + 1 : nearest) / 255;
    }

    /// Weights of a0: the importance times the squared slope dL / da0. With roots the slope is 2 a0; half a code is added, since in the
    /// dark only the second-order term of an error of that size remains.
    Image<float> alphaSignificance(const Image<glm::vec4>& texels) const {
        Image<float> significance(source_.width, source_.height, 0);
        for (int y = 0; y < source_.height; ++y)
            for (int x = 0; x < source_.width; ++x) {
                const float slope = isRoot_ ? 2 * (texels.at(x, y).w + kHalfCode) : 1;
                significance.at(x, y) = source_.importance.at(x, y) * slope * slope;
            }
        return significance;
    }

    Layer encodeSecond(const Image<glm::vec4>& first) {
        Image<glm::vec4> texels = residualColors(first);
        Layer layer = encodeLayer(format_, texels, colorSignificance(), options_, true, report_);
        Image<float> significance(source_.width, source_.height, 0);
        for (int y = 0; y < source_.height; ++y)
            for (int x = 0; x < source_.width; ++x) {
                const float a0 = first.at(x, y).w;
                significance.at(x, y) = significanceOf(source_, x, y, source_.importance.at(x, y) * a0 * a0, kLeastLuvwWeight);
                texels.at(x, y).w = a0 > 0 ? bestLength(x, y, first.at(x, y), layer.decoded.at(x, y)) / (range_ * a0) : neutral_.w;
                texels.at(x, y).w = std::clamp(texels.at(x, y).w, 0.0f, 1.0f);
            }
        if (format_ != PixelFormat::Bc3) return encodeLayer(format_, texels, significance, options_, true, report_);
        return withAlpha(std::move(layer), texels, significance);
    }

    /// Returns rgb1 against the decoded rgb0, with a1 neutral.
    Image<glm::vec4> residualColors(const Image<glm::vec4>& first) const {
        Image<glm::vec4> texels(source_.width, source_.height, neutral_);
        for (int y = 0; y < source_.height; ++y)
            for (int x = 0; x < source_.width; ++x) {
                const float l = length(x, y);
                if (!(l > 0)) continue;
                const glm::vec3 residual = values_.at(x, y) / l - (2.0f * glm::vec3(first.at(x, y)) - 1.0f);
                texels.at(x, y) = glm::vec4(glm::clamp(glm::vec3(neutral_) + residual / (2 * span_), 0.0f, 1.0f), neutral_.w);
            }
        return texels;
    }

    /// Returns the L >= 0 that minimises |L uvw - value|, for the uvw that the two decoded textures give.
    float bestLength(int x, int y, const glm::vec4& first, const glm::vec4& second) const {
        const glm::vec3 uvw = uvwOf(first, second);
        const float squared = glm::dot(uvw, uvw);
        return squared > 0.01f ? std::max(0.0f, glm::dot(uvw, values_.at(x, y)) / squared) : length(x, y);
    }

    glm::vec3 uvwOf(const glm::vec4& first, const glm::vec4& second) const {
        return 2.0f * glm::vec3(first) - 1.0f + (2 * span_) * (glm::vec3(second) - glm::vec3(neutral_));
    }

    /// Replaces the alpha half of BC3 blocks by one encoded from the alpha of `texels`.
    Layer withAlpha(Layer color, const Image<glm::vec4>& texels, const Image<float>& significance) const {
        putAlpha(color, encodeAlpha(texels, significance, options_, report_));
        return color;
    }

    const Source& source_;
    const Image<glm::vec3>& values_;
    const EncodeOptions& options_;
    EncodeReport& report_;
    PixelFormat format_;
    float range_, span_;
    bool isRoot_;
    bool hasCodes_;  ///< alphas have 8 bits
    glm::vec4 neutral_;
    Image<glm::vec4> firstDecoded_, secondDecoded_;
};

/// Returns the number of layers of either texture that hold a coefficient each. The last layer of a zonal layout holds the intensity.
std::size_t luvwCoefficients(const LightMapPlan& plan) {
    return static_cast<std::size_t>(plan.textures[0].layerCount - (formats::info(plan.layout).isZonal ? 1 : 0));
}

}  // namespace

void planLuvw(LightMapPlan& plan, const LightMapMeasure& measure) {
    const LuvwForm form = formOf(plan);
    const float largestRange = form.neutral.w * std::numeric_limits<float>::max();
    const auto add = [&](float largest) { plan.constants["range"].push_back(std::min(largest, largestRange) / form.neutral.w); };
    for (int i = 0; i < static_cast<int>(luvwCoefficients(plan)); ++i) add(measure.maximumAbsolute(i));
    const bool isZonal = formats::info(plan.layout).isZonal;
    if (isZonal) {
        add(measure.maximumIntensity());
        const glm::vec3& weights = measure.luminanceWeights();
        plan.constants["luminance"] = {weights.x, weights.y, weights.z};
    }
    if (isHalo3(plan)) return;  // the engine's shader has the others
    plan.constants["span"].assign(plan.constants["range"].size(), spanOf(plan));
    plan.constants["neutral"] = {form.neutral.x, form.neutral.y, form.neutral.z, form.neutral.w};
    plan.constants["root"] = {form.isRoot ? 1.0f : 0.0f};
}

EncodedLightMapRows encodeLuvw(const LightMapPlan& plan, const Source& source, const EncodeOptions& options) {
    EncodedLightMapRows out;
    out.textures.resize(2);
    for (EncodedLightMapTexture& texture : out.textures) texture.layers.resize(static_cast<std::size_t>(plan.textures[0].layerCount));
    const auto encode = [&](const Image<glm::vec3>& values, std::size_t layer) {
        LuvwCoefficient coefficient(plan, source, values, layer, options, out.report);
        coefficient.encode(out.textures[0].layers[layer], out.textures[1].layers[layer]);
        return coefficient;
    };
    const bool isZonal = formats::info(plan.layout).isZonal;
    const std::size_t count = luvwCoefficients(plan);
    std::vector<LuvwCoefficient> decoded;
    for (std::size_t i = 0; i < count; ++i) {
        LuvwCoefficient coefficient = encode(source.values[i], i);
        if (isZonal) decoded.push_back(std::move(coefficient));
    }
    if (isZonal) {
        const auto band1 = [&](std::size_t i, int x, int y) { return decoded[i].decoded(x, y); };
        encode(alongAxis(plan, source, band1, intensityAlong), count);
    }
    return out;
}

}  // namespace rows

}  // namespace lightcook::compress

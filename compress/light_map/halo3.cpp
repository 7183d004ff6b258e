// Layout halo3: each coefficient as its length L and its signed colour uvw, in two textures (Hu 2008).
//
//   L = largest absolute channel, uvw = value / L in [-1, 1]
//   first texture:  rgb0 = (uvw + 1) / 2, a0 = the square root of L over its range
//   second texture: rgb1 = (the residual of uvw + 1) / 2, a1 = the factor that corrects L
//   decode: RANGE a0 a1 (2 rgb0 - 1 + 2 rgb1 - 1)
//
// Stages run in this order, each against the decoded texels of those before it: rgb0, a0, rgb1, a1. a1 is the least-squares length for the
// uvw that both textures really give. In BC3 colour and alpha are separate blocks with separate weights. An error of uvw is seen multiplied
// by L and weighs by L^2. An error of a0 is not: weighed by L^2 too, dark texels beside bright ones became black, and the second
// texture cannot repair black.
#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "compress/light_map/families.h"

namespace lightcook::compress::rows {

namespace {

using formats::Image;
using formats::PixelFormat;

constexpr float kHalfCode = 0.5f / 255;
/// Least weight over the coverage, in place of kLeastWeight. It is smaller, since the weights fall with the square of L.
constexpr float kLeastHalo3Weight = 1e-9f;

class Halo3Coefficient {
public:
    /// values  of a coefficient
    /// index   of its layers and constants
    Halo3Coefficient(const LightMapPlan& plan, const Source& source, const Image<glm::vec3>& values, std::size_t index,
                     const EncodeOptions& options, EncodeReport& report)
        : source_(source),
          values_(values),
          options_(options),
          report_(report),
          format_(plan.textures[0].format),
          range_(constant(plan, "range", index)) {}

    void encode(std::vector<std::byte>& first, std::vector<std::byte>& second) {
        Layer layer = encodeFirst();
        second = encodeSecond(layer.decoded).bytes;
        first = std::move(layer.bytes);
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
                const float l = range_ > 0 ? length(x, y) / range_ : 0;
                significance.at(x, y) = significanceOf(source_, x, y, source_.importance.at(x, y) * l * l, kLeastHalo3Weight);
            }
        return significance;
    }

    Layer encodeFirst() {
        Image<glm::vec4> texels(source_.width, source_.height, glm::vec4(0.5f, 0.5f, 0.5f, 0));
        for (int y = 0; y < source_.height; ++y)
            for (int x = 0; x < source_.width; ++x) {
                const float l = length(x, y);
                if (l > 0) texels.at(x, y) = glm::vec4(0.5f + (0.5f / l) * values_.at(x, y), std::sqrt(std::min(1.0f, l / range_)));
            }
        EncodeOptions options = options_;
        // ASTC encodes alpha with the colours. A code of a dark a0 is a large part of its light.
        constexpr float kAlphaWeight = 256;
        if (format_ != PixelFormat::Bc3) options.channelWeights[3] = kAlphaWeight;
        Layer layer = encodeLayer(format_, texels, colorSignificance(), options, true, report_);
        if (format_ != PixelFormat::Bc3) return layer;
        return withAlpha(std::move(layer), texels, alphaSignificance(texels));
    }

    /// Weights of a0: the importance times the squared slope dL / da0 = 2 a0. Half a code is added, since in the dark only the second-order
    /// term of an error of that size remains.
    Image<float> alphaSignificance(const Image<glm::vec4>& texels) const {
        Image<float> significance(source_.width, source_.height, 0);
        for (int y = 0; y < source_.height; ++y)
            for (int x = 0; x < source_.width; ++x) {
                const float slope = 2 * (texels.at(x, y).w + kHalfCode);
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
                significance.at(x, y) = significanceOf(source_, x, y, source_.importance.at(x, y) * a0 * a0, kLeastHalo3Weight);
                if (a0 > 0)
                    texels.at(x, y).w = std::clamp(bestLength(x, y, first.at(x, y), layer.decoded.at(x, y)) / (range_ * a0), 0.0f, 1.0f);
            }
        if (format_ != PixelFormat::Bc3) return encodeLayer(format_, texels, significance, options_, true, report_);
        return withAlpha(std::move(layer), texels, significance);
    }

    /// Returns rgb1 against the decoded rgb0, with a1 = 1.
    Image<glm::vec4> residualColors(const Image<glm::vec4>& first) const {
        constexpr glm::vec4 kNone(0.5f, 0.5f, 0.5f, 1);
        Image<glm::vec4> texels(source_.width, source_.height, kNone);
        for (int y = 0; y < source_.height; ++y)
            for (int x = 0; x < source_.width; ++x) {
                const float l = length(x, y);
                if (!(l > 0)) continue;
                const glm::vec3 residual = values_.at(x, y) / l - (2.0f * glm::vec3(first.at(x, y)) - 1.0f);
                texels.at(x, y) = glm::vec4(glm::clamp(0.5f + residual / 2.0f, 0.0f, 1.0f), 1);
            }
        return texels;
    }

    /// Returns the L >= 0 that minimises |L uvw - value|, for the uvw that the two decoded textures give.
    float bestLength(int x, int y, const glm::vec4& first, const glm::vec4& second) const {
        const glm::vec3 uvw = 2.0f * glm::vec3(first) - 1.0f + 2.0f * (glm::vec3(second) - 0.5f);
        const float squared = glm::dot(uvw, uvw);
        return squared > 0.01f ? std::max(0.0f, glm::dot(uvw, values_.at(x, y)) / squared) : length(x, y);
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
    float range_;
};

}  // namespace

void planHalo3(LightMapPlan& plan, const LightMapMeasure& measure) {
    for (int i = 0; i < lighting::kShCount; ++i) plan.constants["range"].push_back(measure.maximumAbsolute(i));
}

EncodedLightMapRows encodeHalo3(const LightMapPlan& plan, const Source& source, const EncodeOptions& options) {
    EncodedLightMapRows out;
    out.textures.resize(2);
    for (EncodedLightMapTexture& texture : out.textures) texture.layers.resize(lighting::kShCount);
    for (std::size_t i = 0; i < lighting::kShCount; ++i)
        Halo3Coefficient(plan, source, source.values[i], i, options, out.report)
            .encode(out.textures[0].layers[i], out.textures[1].layers[i]);
    return out;
}

}  // namespace lightcook::compress::rows

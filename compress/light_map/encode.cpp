// The stages of each layout. A stage that codes what another one left looks at that one's decoded texels, never at its own hopes.
#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>

#include "compress/light_map/rows.h"
#include "compress/light_map/zonal.h"

namespace lightcook::compress {

namespace {

using formats::Image;
using formats::LightMapFamily;
using formats::PixelFormat;
using rows::constant;
using rows::encodeHdr;
using rows::encodeLayer;
using rows::Layer;
using rows::Source;

EncodedLightMapRows encodeRaw(const LightMapPlan& plan, const Source& source, const EncodeOptions& options) {
    EncodedLightMapRows out;
    out.textures.resize(1);
    // Halves need no metric: signed values go in as they are.
    for (std::size_t i = 0; i < source.values.size(); ++i) {
        Layer layer = encodeHdr(plan.textures[0].format, source, i, constant(plan, "range", 0), static_cast<float>(plan.key), options,
                                false, out.report);
        out.textures[0].layers.push_back(std::move(layer.bytes));
    }
    return out;
}

/// Texture "l0", and the layers of texture "ratio" over what it decodes to.
class RatioLayers {
public:
    RatioLayers(const LightMapPlan& plan, const Source& source, const EncodeOptions& options)
        : plan_(plan), source_(source), options_(options), range_(constant(plan, "range", 0)) {
        out_.textures.resize(2);
        Layer l0 = encodeHdr(plan.textures[0].format, source, 0, range_, static_cast<float>(plan.key), options, true, out_.report);
        out_.textures[0].layers.push_back(std::move(l0.bytes));
        l0_ = std::move(l0.decoded);
        significance_ = Image<float>(source.width, source.height, 0);
        // An error of a ratio is seen through the decoded L0 that it is multiplied with.
        for (int y = 0; y < source.height; ++y)
            for (int x = 0; x < source.width; ++x) {
                const glm::vec3 dc = range_ * glm::vec3(l0_.at(x, y));
                const float unit = glm::dot(dc, dc) / static_cast<float>(plan.key * plan.key + 1e-24);
                const float importance = source.importance.at(x, y);
                significance_.at(x, y) = importance > 0 ? std::max(importance * unit, 1e-6f * source.coverage.at(x, y)) : 0;
            }
    }

    /// The next layer, of these values. Returns its decoded texels if they are wanted.
    Image<glm::vec4> add(const Image<glm::vec3>& values, bool wantsDecoded) {
        const std::size_t index = out_.textures[1].layers.size();
        const float scale = constant(plan_, "scale", index), bias = constant(plan_, "bias", index);
        Image<glm::vec4> texels(source_.width, source_.height, glm::vec4(0, 0, 0, 1));
        for (int y = 0; y < source_.height; ++y)
            for (int x = 0; x < source_.width; ++x) {
                const glm::vec4& dc = l0_.at(x, y);
                for (int channel = 0; channel < 3; ++channel) {
                    const float decoded = range_ * dc[channel];
                    // Where the decoded L0 is black the product is black: any ratio will do, and that of no light costs least.
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

    /// Coefficient index + 1 as the shader sees it.
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

EncodedLightMapRows encodeRatio(const LightMapPlan& plan, const Source& source, const EncodeOptions& options) {
    RatioLayers layers(plan, source, options);
    for (std::size_t i = 1; i <= static_cast<std::size_t>(plan.textures[1].layerCount); ++i) layers.add(source.values[i], false);
    return std::move(layers).finish();
}

/// One number a texel and channel that `along` finds for the axis of a decoded band 1. band1(i, x, y): its coefficient i, 1 to 3.
template <class Band1, class Along>
Image<glm::vec3> alongAxis(const LightMapPlan& plan, const Source& source, Band1&& band1, Along&& along) {
    const glm::vec3 luminance(constant(plan, "luminance", 0), constant(plan, "luminance", 1), constant(plan, "luminance", 2));
    Image<glm::vec3> out(source.width, source.height, glm::vec3(0));
    for (int y = 0; y < source.height; ++y)
        for (int x = 0; x < source.width; ++x) {
            if (!(source.coverage.at(x, y) > 0)) continue;
            lighting::ShRgb sh;
            for (std::size_t i = 0; i < sh.size(); ++i) sh[i] = source.values[i].at(x, y);
            out.at(x, y) = along(sh, rows::linearAxis(band1(1, x, y), band1(2, x, y), band1(3, x, y), luminance));
        }
    return out;
}

EncodedLightMapRows encodeZh3(const LightMapPlan& plan, const Source& source, const EncodeOptions& options) {
    RatioLayers layers(plan, source, options);
    std::array<Image<glm::vec4>, 3> linear;
    for (std::size_t i = 0; i < linear.size(); ++i) linear[i] = layers.add(source.values[i + 1], true);
    const auto band1 = [&](std::size_t i, int x, int y) { return layers.decoded(linear[i - 1], i - 1, x, y); };
    layers.add(alongAxis(plan, source, band1, rows::zonalAlong), false);
    return std::move(layers).finish();
}

/// One coefficient, or one intensity, on its way through the two textures of luvw.
class LuvwCoefficient {
public:
    LuvwCoefficient(const LightMapPlan& plan, const Source& source, const Image<glm::vec3>& values, std::size_t index,
                    const EncodeOptions& options, EncodeReport& report)
        : source_(source),
          values_(values),
          options_(options),
          report_(report),
          format_(plan.textures[0].format),
          range_(constant(plan, "range", index)),
          span_(constant(plan, "span", index)),
          isRoot_(constant(plan, "root", 0) > 0),
          neutral_(constant(plan, "neutral", 0), constant(plan, "neutral", 1), constant(plan, "neutral", 2), constant(plan, "neutral", 3)) {
    }

    void encode(std::vector<std::byte>& first, std::vector<std::byte>& second) {
        Layer firstLayer = encodeFirst();
        Layer secondLayer = encodeSecond(firstLayer.decoded);
        second = std::move(secondLayer.bytes);
        first = std::move(firstLayer.bytes);
        firstDecoded_ = std::move(firstLayer.decoded);
        secondDecoded_ = std::move(secondLayer.decoded);
    }
    /// As the shader sees it, once it is encoded.
    glm::vec3 decoded(int x, int y) const {
        const glm::vec4 &first = firstDecoded_.at(x, y), &second = secondDecoded_.at(x, y);
        return range_ * first.w * second.w * uvwOf(first, second);
    }

private:
    float length(int x, int y) const {
        const glm::vec3 v = glm::abs(values_.at(x, y));
        return std::max({v.x, v.y, v.z});
    }

    /// Errors of uvw are seen through L.
    Image<float> colorSignificance() const {
        Image<float> significance(source_.width, source_.height, 0);
        for (int y = 0; y < source_.height; ++y)
            for (int x = 0; x < source_.width; ++x) {
                const float l = range_ > 0 ? length(x, y) / (range_ * neutral_.w) : 0;
                const float importance = source_.importance.at(x, y);
                significance.at(x, y) = importance > 0 ? std::max(importance * l * l, 1e-9f * source_.coverage.at(x, y)) : 0;
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
                texels.at(x, y) = glm::vec4(0.5f + (0.5f / l) * values_.at(x, y), isRoot_ ? std::sqrt(a0) : a0);
            }
        Layer layer = encodeLayer(format_, texels, colorSignificance(), options_, true, report_);
        if (format_ != PixelFormat::Bc3) return layer;
        // L itself, unlike uvw, is not seen through L: weighed so, dark texels beside bright ones became black, which no second texture
        // mends.
        return withAlpha(std::move(layer), texels, alphaSignificance(texels));
    }

    /// Where L goes by the square of what is stored, a step at the top of the range changes it by far more than one in the dark, where half
    /// a code's own change is what remains.
    Image<float> alphaSignificance(const Image<glm::vec4>& texels) const {
        constexpr float kHalfCode = 0.5f / 255;
        Image<float> significance(source_.width, source_.height, 0);
        for (int y = 0; y < source_.height; ++y)
            for (int x = 0; x < source_.width; ++x) {
                const float slope = isRoot_ ? 2 * (texels.at(x, y).w + kHalfCode) : 1;
                significance.at(x, y) = source_.importance.at(x, y) * slope * slope;
            }
        return significance;
    }

    Layer encodeSecond(const Image<glm::vec4>& first) {
        Image<glm::vec4> texels(source_.width, source_.height, neutral_);
        for (int y = 0; y < source_.height; ++y)
            for (int x = 0; x < source_.width; ++x) {
                const float l = length(x, y);
                if (!(l > 0)) continue;
                const glm::vec3 left = values_.at(x, y) / l - (2.0f * glm::vec3(first.at(x, y)) - 1.0f);
                texels.at(x, y) = glm::vec4(glm::clamp(glm::vec3(neutral_) + left / (2 * span_), 0.0f, 1.0f), neutral_.w);
            }
        const Image<float> color = colorSignificance();
        Layer layer = encodeLayer(format_, texels, color, options_, true, report_);
        Image<float> significance(source_.width, source_.height, 0);
        for (int y = 0; y < source_.height; ++y)
            for (int x = 0; x < source_.width; ++x) {
                const float a0 = first.at(x, y).w;
                const float importance = source_.importance.at(x, y);
                significance.at(x, y) = importance > 0 ? std::max(importance * a0 * a0, 1e-9f * source_.coverage.at(x, y)) : 0;
                texels.at(x, y).w = a0 > 0 ? bestLength(x, y, first.at(x, y), layer.decoded.at(x, y)) / (range_ * a0) : neutral_.w;
                texels.at(x, y).w = std::clamp(texels.at(x, y).w, 0.0f, 1.0f);
            }
        if (format_ != PixelFormat::Bc3) return encodeLayer(format_, texels, significance, options_, true, report_);
        return withAlpha(std::move(layer), texels, significance);
    }

    /// The L that brings L uvw nearest to the value, for the uvw that the two textures really give.
    float bestLength(int x, int y, const glm::vec4& first, const glm::vec4& second) const {
        const glm::vec3 uvw = uvwOf(first, second);
        const float squared = glm::dot(uvw, uvw);
        return squared > 0.01f ? std::max(0.0f, glm::dot(uvw, values_.at(x, y)) / squared) : length(x, y);
    }

    glm::vec3 uvwOf(const glm::vec4& first, const glm::vec4& second) const {
        return 2.0f * glm::vec3(first) - 1.0f + (2 * span_) * (glm::vec3(second) - glm::vec3(neutral_));
    }

    /// The two halves of a BC3 block know nothing of each other: alpha is put in with weights of its own, and after the colour that it may
    /// have to fit is known.
    Layer withAlpha(Layer color, const Image<glm::vec4>& texels, const Image<float>& significance) const {
        Image<glm::vec4> alpha(source_.width, source_.height);
        for (int y = 0; y < source_.height; ++y)
            for (int x = 0; x < source_.width; ++x) alpha.at(x, y) = glm::vec4(texels.at(x, y).w, 0, 0, 1);
        const Layer layer = encodeLayer(PixelFormat::Bc4, alpha, significance, options_, true, report_);
        constexpr std::size_t half = 8;
        for (std::size_t block = 0; block * half < layer.bytes.size(); ++block)
            std::memcpy(color.bytes.data() + 2 * half * block, layer.bytes.data() + half * block, half);
        for (int y = 0; y < source_.height; ++y)
            for (int x = 0; x < source_.width; ++x) color.decoded.at(x, y).w = layer.decoded.at(x, y).x;
        return color;
    }

    const Source& source_;
    const Image<glm::vec3>& values_;
    const EncodeOptions& options_;
    EncodeReport& report_;
    PixelFormat format_;
    float range_, span_;
    bool isRoot_;
    glm::vec4 neutral_;
    Image<glm::vec4> firstDecoded_, secondDecoded_;
};

EncodedLightMapRows encodeLuvw(const LightMapPlan& plan, const Source& source, const EncodeOptions& options) {
    EncodedLightMapRows out;
    out.textures.resize(2);
    for (EncodedLightMapTexture& texture : out.textures) texture.layers.resize(source.values.size());
    for (std::size_t i = 0; i < source.values.size(); ++i)
        LuvwCoefficient(plan, source, source.values[i], i, options, out.report)
            .encode(out.textures[0].layers[i], out.textures[1].layers[i]);
    return out;
}

EncodedLightMapRows encodeLuvwLinear(const LightMapPlan& plan, const Source& source, const EncodeOptions& options) {
    EncodedLightMapRows out;
    out.textures.resize(2);
    for (EncodedLightMapTexture& texture : out.textures) texture.layers.resize(5);
    const auto encode = [&](const Image<glm::vec3>& values, std::size_t i) {
        LuvwCoefficient coefficient(plan, source, values, i, options, out.report);
        coefficient.encode(out.textures[0].layers[i], out.textures[1].layers[i]);
        return coefficient;
    };
    std::vector<LuvwCoefficient> linear;
    for (std::size_t i = 0; i < 4; ++i) linear.push_back(encode(source.values[i], i));
    const auto band1 = [&](std::size_t i, int x, int y) { return linear[i].decoded(x, y); };
    encode(alongAxis(plan, source, band1, rows::intensityAlong), 4);
    return out;
}

}  // namespace

EncodedLightMapRows encodeLightMapRows(const LightMapPlan& plan, const formats::LightMapStrip& band, int firstRow, int rowCount,
                                       const EncodeOptions& options) {
    assert(band.sh.width() == plan.width);
    assert(firstRow % plan.blockHeight() == 0 && (rowCount % plan.blockHeight() == 0 || firstRow + rowCount == plan.height));
    assert(band.firstRow <= std::max(0, firstRow - kLightMapPaddingRows));
    assert(band.firstRow + band.sh.height() >= std::min(plan.height, firstRow + rowCount + kLightMapPaddingRows));
    const Source source = rows::makeSource(plan, band, firstRow, rowCount);
    switch (formats::info(plan.layout).family) {
        case LightMapFamily::Raw:
        case LightMapFamily::Flat:
            return encodeRaw(plan, source, options);
        case LightMapFamily::Luvw:
            return formats::info(plan.layout).isZonal ? encodeLuvwLinear(plan, source, options) : encodeLuvw(plan, source, options);
        case LightMapFamily::Ratio:
            return encodeRatio(plan, source, options);
        case LightMapFamily::Zh3:
            return encodeZh3(plan, source, options);
        case LightMapFamily::Basis:
            return rows::encodeBasis(plan, band, source, options);
    }
    return {};
}

}  // namespace lightcook::compress

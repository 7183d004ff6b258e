// The stages of each layout. A stage that codes what another one left looks at that one's decoded texels, never at its own hopes.
#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>

#include "compress/light_map_rows.h"

namespace compress {

namespace {

using formats::Image;
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

EncodedLightMapRows encodeRatio(const LightMapPlan& plan, const Source& source, const EncodeOptions& options) {
    EncodedLightMapRows out;
    out.textures.resize(2);
    const float range = constant(plan, "range", 0);
    Layer l0 = encodeHdr(plan.textures[0].format, source, 0, range, static_cast<float>(plan.key), options, true, out.report);
    out.textures[0].layers.push_back(std::move(l0.bytes));

    // An error of a ratio is seen through the decoded L0 that it is multiplied with.
    Image<float> significance(source.width, source.height, 0);
    for (int y = 0; y < source.height; ++y)
        for (int x = 0; x < source.width; ++x) {
            const glm::vec3 dc = range * glm::vec3(l0.decoded.at(x, y));
            const float unit = glm::dot(dc, dc) / static_cast<float>(plan.key * plan.key + 1e-24);
            const float importance = source.importance.at(x, y);
            significance.at(x, y) = importance > 0 ? std::max(importance * unit, 1e-6f * source.coverage.at(x, y)) : 0;
        }
    for (std::size_t i = 1; i < source.values.size(); ++i) {
        const float scale = constant(plan, "scale", i - 1), bias = constant(plan, "bias", i - 1);
        Image<glm::vec4> texels(source.width, source.height, glm::vec4(0, 0, 0, 1));
        for (int y = 0; y < source.height; ++y)
            for (int x = 0; x < source.width; ++x) {
                const glm::vec4& dc = l0.decoded.at(x, y);
                for (int channel = 0; channel < 3; ++channel) {
                    const float decoded = range * dc[channel];
                    // Where the decoded L0 is black the product is black: any ratio will do, and that of no light costs least.
                    const float ratio = decoded > 0 ? source.values[i].at(x, y)[channel] / decoded : 0;
                    const float unit = scale > 0 ? (ratio - bias) / scale : 0;
                    if (source.coverage.at(x, y) == 1) {
                        out.report.clampedHigh += unit > 1.0001f ? 1 : 0;
                        out.report.clampedNegative += unit < -0.0001f ? 1 : 0;
                    }
                    texels.at(x, y)[channel] = std::clamp(unit, 0.0f, 1.0f);
                }
            }
        Layer layer = encodeLayer(plan.textures[1].format, texels, significance, options, false, out.report);
        out.textures[1].layers.push_back(std::move(layer.bytes));
    }
    return out;
}

/// One coefficient on its way through the two textures of luvw.
class LuvwCoefficient {
public:
    LuvwCoefficient(const LightMapPlan& plan, const Source& source, std::size_t index, const EncodeOptions& options, EncodeReport& report)
        : source_(source),
          values_(source.values[index]),
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
        second = encodeSecond(firstLayer.decoded);
        first = std::move(firstLayer.bytes);
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
        return encodeLayer(format_, texels, colorSignificance(), options_, true, report_);
    }

    std::vector<std::byte> encodeSecond(const Image<glm::vec4>& first) {
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
        return encodeSecondAlpha(std::move(layer.bytes), texels, significance);
    }

    /// The L that brings L uvw nearest to the value, for the uvw that the two textures really give.
    float bestLength(int x, int y, const glm::vec4& first, const glm::vec4& second) const {
        const glm::vec3 uvw = 2.0f * glm::vec3(first) - 1.0f + (2 * span_) * (glm::vec3(second) - glm::vec3(neutral_));
        const float squared = glm::dot(uvw, uvw);
        return squared > 0.01f ? std::max(0.0f, glm::dot(uvw, values_.at(x, y)) / squared) : length(x, y);
    }

    /// The two halves of a BC3 block know nothing of each other: alpha is put in after the colour it has to fit is known. Other formats
    /// are encoded again as a whole.
    std::vector<std::byte> encodeSecondAlpha(std::vector<std::byte> colorBytes, Image<glm::vec4>& texels,
                                             const Image<float>& significance) {
        if (format_ != PixelFormat::Bc3) return encodeLayer(format_, texels, significance, options_, false, report_).bytes;
        Image<glm::vec4> alpha(source_.width, source_.height);
        for (int y = 0; y < source_.height; ++y)
            for (int x = 0; x < source_.width; ++x) alpha.at(x, y) = glm::vec4(texels.at(x, y).w, 0, 0, 1);
        const Layer layer = encodeLayer(PixelFormat::Bc4, alpha, significance, options_, false, report_);
        constexpr std::size_t half = 8;
        for (std::size_t block = 0; block * half < layer.bytes.size(); ++block)
            std::memcpy(colorBytes.data() + 2 * half * block, layer.bytes.data() + half * block, half);
        return colorBytes;
    }

    const Source& source_;
    const Image<glm::vec3>& values_;
    const EncodeOptions& options_;
    EncodeReport& report_;
    PixelFormat format_;
    float range_, span_;
    bool isRoot_;
    glm::vec4 neutral_;
};

EncodedLightMapRows encodeLuvw(const LightMapPlan& plan, const Source& source, const EncodeOptions& options) {
    EncodedLightMapRows out;
    out.textures.resize(2);
    for (EncodedLightMapTexture& texture : out.textures) texture.layers.resize(source.values.size());
    for (std::size_t i = 0; i < source.values.size(); ++i)
        LuvwCoefficient(plan, source, i, options, out.report).encode(out.textures[0].layers[i], out.textures[1].layers[i]);
    return out;
}

}  // namespace

EncodedLightMapRows encodeLightMapRows(const LightMapPlan& plan, const formats::LightMapBand& band, int firstRow, int rowCount,
                                       const EncodeOptions& options) {
    assert(band.sh.width() == plan.width);
    assert(firstRow % plan.blockHeight() == 0 && (rowCount % plan.blockHeight() == 0 || firstRow + rowCount == plan.height));
    assert(band.firstRow <= std::max(0, firstRow - kLightMapPaddingRows));
    assert(band.firstRow + band.sh.height() >= std::min(plan.height, firstRow + rowCount + kLightMapPaddingRows));
    const Source source = rows::makeSource(plan, band, firstRow, rowCount);
    EncodedLightMapRows out;
    switch (plan.layout) {
        case LightMapLayout::Raw:
        case LightMapLayout::Flat:
            return encodeRaw(plan, source, options);
        case LightMapLayout::Luvw:
            return encodeLuvw(plan, source, options);
        case LightMapLayout::Ratio:
            return encodeRatio(plan, source, options);
        case LightMapLayout::Basis3:
        case LightMapLayout::Basis4:
        case LightMapLayout::Basis8:
        case LightMapLayout::Basis12:
        case LightMapLayout::Basis16:
            return rows::encodeBasis(plan, band, source, options);
    }
    return out;
}

}  // namespace compress

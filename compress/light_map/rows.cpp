#include "compress/light_map/rows.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <utility>

#include "formats/padding.h"
#include "lighting/radiometry.h"

namespace lightcook::compress::rows {

namespace {

using formats::Image;
using formats::ImageView;
using formats::PixelFormat;

/// Weights of padded texels beside charts, and of texels one further away. Their values matter to filters at chart edges, but must not cost
/// precision of a covered texel.
constexpr float kPaddingSignificance = 0x1p-8f, kSecondSignificance = 0x1p-16f;

/// Factor between the light of a second-ring texel and that of its block beyond which the texel would cost the block precision.
constexpr float kFarLight = 8;

/// The knee of the weights, as a share of the key: above it errors count by their ratio to the light, below it by their size. Learned
/// layouts need the smaller one, because the same tables decode all light levels, and errors in dark texels would hardly count. So do
/// families hdr and lit and flat-2, whose dark texels share blocks with lit ones.
constexpr float kKnee = 1.0f, kSmallKnee = 0.1f;

float kneeOf(const formats::LightMapLayoutInfo& layout) {
    const bool isLinear = layout.family == formats::LightMapFamily::Hdr || layout.id == formats::LightMapLayout::Flat2;
    return layout.isLearned() || isLinear || layout.family == formats::LightMapFamily::Lit ? kSmallKnee : kKnee;
}

/// Sets `out` to the values of one texel that layouts store: nine coefficients, or the exit radiance.
void texelValues(const formats::LightMapStrip& strip, bool isFlat, int x, int y, std::span<glm::vec3> out) {
    const lighting::ShRgb& sh = strip.sh.at(x, y);
    if (isFlat)
        out[0] = lighting::evaluate(lighting::convolve(sh, lighting::kExitRadianceBands), strip.normal.at(x, y));
    else
        std::ranges::copy(sh, out.begin());
}

/// Sets `out` to the mean of the covered texels on the smallest ring (1, then 2 texels away) that has any, and `owner` to the first of
/// them. Returns false if both rings are empty.
bool padTexel(const formats::LightMapStrip& strip, bool isFlat, int x, int y, std::span<glm::vec3> out, glm::ivec2& owner) {
    std::array<glm::vec3, lighting::kShCount> neighbour;
    const auto values = std::span(neighbour).first(out.size());
    std::ranges::fill(out, glm::vec3(0));
    const int count = formats::visitNearestCovered(strip.covered.view(), x, y, kLightMapPaddingRows, [&](int nearX, int nearY) {
        if (owner.x < 0) owner = {nearX, nearY + strip.firstRow};
        texelValues(strip, isFlat, nearX, nearY, values);
        for (std::size_t i = 0; i < out.size(); ++i) out[i] += values[i];
    });
    if (count == 0) return false;
    for (glm::vec3& value : out) value /= static_cast<float>(count);
    return true;
}

/// The texels of a block that lie in the image: columns [left, right), rows [top, bottom).
struct BlockArea {
    int left, top, right, bottom;

    int texelCount() const { return (right - left) * (bottom - top); }
    template <class Visit>
    void forEachTexel(Visit visit) const {
        for (int y = top; y < bottom; ++y)
            for (int x = left; x < right; ++x) visit(x, y);
    }
};

/// Calls visit(area) for the blocks of an image, row by row.
/// block  width and height of a block [texels]
template <class Visit>
void forEachBlockArea(int width, int height, const glm::ivec2& block, Visit visit) {
    for (int top = 0; top < height; top += block.y)
        for (int left = 0; left < width; left += block.x)
            visit(BlockArea{left, top, std::min(left + block.x, width), std::min(top + block.y, height)});
}

/// Sets the texels without significance to the mean of the others of their 4 x 4 block, so that the block encoder sees no edge between
/// them.
void fillBlocks(Image<glm::vec4>& texels, const Image<float>& significance) {
    forEachBlockArea(texels.width(), texels.height(), glm::ivec2(4), [&](const BlockArea& area) {
        glm::vec4 sum(0);
        int count = 0;
        area.forEachTexel([&](int x, int y) {
            if (!(significance.at(x, y) > 0)) return;
            sum += texels.at(x, y);
            ++count;
        });
        if (count == 0 || count == area.texelCount()) return;
        area.forEachTexel([&](int x, int y) {
            if (!(significance.at(x, y) > 0)) texels.at(x, y) = sum / static_cast<float>(count);
        });
    });
}

/// Returns the texels of a second texture of HDR light: see secondOf.
Image<glm::vec4> secondTexels(const Image<glm::vec4>& wanted, const Image<glm::vec4>& firstDecoded, float share) {
    Image<glm::vec4> texels(wanted.width(), wanted.height(), glm::vec4(0, 0, 0, 1));
    for (int y = 0; y < texels.height(); ++y)
        for (int x = 0; x < texels.width(); ++x) {
            const glm::vec3 second = secondOf(glm::vec3(wanted.at(x, y)), glm::vec3(firstDecoded.at(x, y)), share);
            texels.at(x, y) = glm::vec4(glm::max(second, glm::vec3(0)), 1);
        }
    return texels;
}

template <class T>
Image<T> rowsOf(const Image<T>& image, int first, int count) {
    Image<T> out(image.width(), count);
    for (int y = 0; y < count; ++y) std::copy_n(&image.at(0, first + y), image.width(), &out.at(0, y));
    return out;
}

}  // namespace

Source Source::rowsFrom(int first, int count) const {
    Source out;
    out.width = width;
    out.height = count;
    for (const Image<glm::vec3>& value : values) out.values.push_back(rowsOf(value, first, count));
    out.coverage = rowsOf(coverage, first, count);
    out.importance = rowsOf(importance, first, count);
    out.owner = rowsOf(owner, first, count);
    return out;
}

void weigh(const LightMapPlan& plan, Source& source, int x, int y) {
    const formats::LightMapLayoutInfo& layout = formats::info(plan.layout);
    const float floor = std::max(kneeOf(layout) * static_cast<float>(plan.key), 1e-12f);
    const float exit = exitOf(layout.family, source.values[0].at(x, y));
    const float local = floor / (exit + floor);
    source.importance.at(x, y) = source.coverage.at(x, y) * local * local;
}

Source makeSource(const LightMapPlan& plan, const formats::LightMapStrip& strip, int firstRow, int rowCount) {
    const bool isFlat = formats::info(plan.layout).family == formats::LightMapFamily::Flat;
    const std::size_t valueCount = isFlat ? 1 : lighting::kShCount;
    Source source;
    source.width = plan.width;
    source.height = rowCount;
    for (std::size_t i = 0; i < valueCount; ++i) source.values.emplace_back(plan.width, rowCount, glm::vec3(0));
    source.coverage = Image<float>(plan.width, rowCount, 0);
    source.importance = Image<float>(plan.width, rowCount, 0);
    source.owner = Image<glm::ivec2>(plan.width, rowCount, glm::ivec2(-1));
    std::array<glm::vec3, lighting::kShCount> texel;
    const auto values = std::span(texel).first(valueCount);
    for (int y = 0; y < rowCount; ++y) {
        const int stripRow = firstRow - strip.firstRow + y;
        for (int x = 0; x < plan.width; ++x) {
            float coverage = 1;
            glm::ivec2& owner = source.owner.at(x, y);
            if (strip.covered.at(x, stripRow) != 0) {
                texelValues(strip, isFlat, x, stripRow, values);
                owner = {x, firstRow + y};
            } else if (!plan.hasCoverage() && padTexel(strip, isFlat, x, stripRow, values, owner)) {
                const bool isBeside = std::max(std::abs(owner.x - x), std::abs(owner.y - firstRow - y)) == 1;
                coverage = isBeside ? kPaddingSignificance : kSecondSignificance;
            } else {
                continue;
            }
            for (std::size_t i = 0; i < valueCount; ++i) source.values[i].at(x, y) = values[i];
            source.coverage.at(x, y) = coverage;
            weigh(plan, source, x, y);
        }
    }
    return source;
}

void dropFarPadding(Source& source, int blockSize) {
    const auto lightAt = [&](int x, int y) {
        const glm::vec3& v = source.values[0].at(x, y);
        return std::max({v.x, v.y, v.z, 0.0f});
    };
    forEachBlockArea(source.width, source.height, glm::ivec2(blockSize), [&](const BlockArea& area) {
        float sum = 0, weights = 0;
        area.forEachTexel([&](int x, int y) {
            if (source.coverage.at(x, y) <= kSecondSignificance) return;
            sum += source.coverage.at(x, y) * lightAt(x, y);
            weights += source.coverage.at(x, y);
        });
        if (!(weights > 0)) return;
        const float mean = sum / weights;
        area.forEachTexel([&](int x, int y) {
            const float light = lightAt(x, y);
            const bool isNear = light * kFarLight >= mean && light <= kFarLight * mean;
            if (source.coverage.at(x, y) > kSecondSignificance || isNear) return;
            source.coverage.at(x, y) = 0;
            source.importance.at(x, y) = 0;
        });
    });
}

Layer encodeLayer(PixelFormat format, Image<glm::vec4>& texels, const Image<float>& significance, const EncodeOptions& options,
                  bool wantsDecoded, EncodeReport& report) {
    fillBlocks(texels, significance);
    Layer layer;
    layer.bytes.resize(static_cast<std::size_t>(formats::blocksDown(format, texels.height())) *
                       formats::bytesPerBlockRow(format, texels.width()));
    if (wantsDecoded) layer.decoded = Image<glm::vec4>(texels.width(), texels.height());
    report.add(encodeRows(format, texels.view(), significance.view(), options, layer.bytes,
                          wantsDecoded ? layer.decoded.view() : ImageView<glm::vec4>{}));
    return layer;
}

Layer encodeHdr(const LightMapPlan& plan, const Source& source, const Image<glm::vec3>& values, float range, const EncodeOptions& options,
                bool wantsDecoded, EncodeReport& report) {
    Image<glm::vec4> texels(source.width, source.height, glm::vec4(0, 0, 0, 1));
    for (int y = 0; y < source.height; ++y)
        for (int x = 0; x < source.width; ++x) texels.at(x, y) = glm::vec4(values.at(x, y) / range, 1);
    EncodeOptions hdr = options;
    hdr.hdrMetric = HdrMetric::Log;
    hdr.hdrScale = std::max(0.1f * static_cast<float>(plan.key) / range, 1e-6f);
    return encodeLayer(plan.textures[0].format, texels, source.coverage, hdr, wantsDecoded, report);
}

Layer encodeSecond(const LightMapPlan& plan, const Source& source, const Image<glm::vec4>& wanted, std::span<const std::byte> first,
                   const Image<glm::vec4>& firstDecoded, EncodeOptions options, EncodeReport& report) {
    const float share = constant(plan, "share", 0);
    Image<glm::vec4> texels = secondTexels(wanted, firstDecoded, share);
    options.hdrMetric = HdrMetric::Linear;
    const PixelFormat format = plan.textures[1].format;
    const Image<float> significance = linearSignificance(source);
    Layer layer = encodeLayer(format, texels, significance, options, true, report);

    const formats::PixelFormatInfo& block = formats::info(format);
    const auto blockBytes = static_cast<std::ptrdiff_t>(block.bytesPerBlock);
    std::ptrdiff_t offset = 0;  // of the block's bytes
    forEachBlockArea(source.width, source.height, {block.blockWidth, block.blockHeight}, [&](const BlockArea& area) {
        const std::ptrdiff_t from = std::exchange(offset, offset + blockBytes);
        double alone = 0, mixed = 0;  // weighted squared errors
        area.forEachTexel([&](int x, int y) {
            const auto weight = static_cast<double>(significance.at(x, y));
            const glm::vec3 target(wanted.at(x, y)), one(firstDecoded.at(x, y)), two(layer.decoded.at(x, y));
            const glm::vec3 errorAlone = one - target, errorMixed = glm::mix(one, two, share) - target;
            alone += weight * static_cast<double>(glm::dot(errorAlone, errorAlone));
            mixed += weight * static_cast<double>(glm::dot(errorMixed, errorMixed));
        });
        if (mixed <= alone) return;
        std::copy_n(first.begin() + from, blockBytes, layer.bytes.begin() + from);
        area.forEachTexel([&](int x, int y) { layer.decoded.at(x, y) = firstDecoded.at(x, y); });
    });
    return layer;
}

Layer encodeAlpha(const Image<glm::vec4>& texels, const Image<float>& significance, const EncodeOptions& options, EncodeReport& report) {
    Image<glm::vec4> alpha(texels.width(), texels.height());
    for (int y = 0; y < texels.height(); ++y)
        for (int x = 0; x < texels.width(); ++x) alpha.at(x, y) = glm::vec4(texels.at(x, y).w, 0, 0, 1);
    return encodeLayer(PixelFormat::Bc4, alpha, significance, options, true, report);
}

void putAlpha(Layer& color, const Layer& alpha) {
    constexpr std::size_t half = 8;
    for (std::size_t block = 0; block * half < alpha.bytes.size(); ++block)
        std::memcpy(color.bytes.data() + 2 * half * block, alpha.bytes.data() + half * block, half);
    for (int y = 0; y < color.decoded.height(); ++y)
        for (int x = 0; x < color.decoded.width(); ++x) color.decoded.at(x, y).w = alpha.decoded.at(x, y).x;
}

Image<float> linearSignificance(const Source& source) {
    Image<float> significance(source.width, source.height, 0);
    for (int y = 0; y < source.height; ++y)
        for (int x = 0; x < source.width; ++x)
            significance.at(x, y) = std::max(source.importance.at(x, y), kLeastWeight * source.coverage.at(x, y));
    return significance;
}

float ratioSignificance(const LightMapPlan& plan, const Source& source, int x, int y, const glm::vec3& dc) {
    // In units of a power of two near the key, which keeps every bit, the squares of any light are floats.
    const double key = std::max(plan.key, 1e-12);
    const double unit = std::ldexp(1.0, -std::ilogb(key));
    const glm::vec3 light = static_cast<float>(unit) * dc;
    const float square = glm::dot(light, light) / static_cast<float>(unit * key * unit * key);
    return significanceOf(source, x, y, source.importance.at(x, y) * square);
}

float constant(const LightMapPlan& plan, const char* name, std::size_t index) {
    return plan.constants.at(name).at(index);
}

}  // namespace lightcook::compress::rows

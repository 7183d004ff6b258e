// Shared by the light-map encoders: rows of a map, padded and with weights, and layers of texels to encode. Private to compress/.
#pragma once

#include <algorithm>
#include <cstddef>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "compress/light_map.h"

namespace lightcook::compress::rows {

/// The rows to encode, padded.
struct Source {
    int width = 0, height = 0;
    std::vector<formats::Image<glm::vec3>> values;  ///< nine coefficients; exit radiance alone for family flat
    /// 1 inside charts, 1/256 beside them, 1/65536 one texel further, 0 elsewhere. Texels beside charts that are solved for the filter have
    /// 1/16, or 1/512 in layouts that divide by coefficient 0 (kSolvedCoverage and kDividedCoverage in filter_fit.cpp).
    formats::Image<float> coverage;
    formats::Image<float> importance;  ///< weight of a squared absolute error: coverage (knee / (exit radiance + knee))^2
    formats::Image<glm::ivec2> owner;  ///< texel of the map whose normal counts: itself, or its nearest covered neighbour

    /// Returns the values of a texel over `range`.
    std::array<glm::vec3, lighting::kShCount> lightAt(int x, int y, float range) const {
        std::array<glm::vec3, lighting::kShCount> light{};
        for (std::size_t i = 0; i < values.size(); ++i) light[i] = values[i].at(x, y) / range;
        return light;
    }
    /// Returns rows [first, first + count).
    Source rowsFrom(int first, int count) const;
};
/// Y_0 as the shaders have it, one unit in the last place below lighting::kShConstant as a float.
inline constexpr float kShaderY0 = 0.28209479f;
/// Returns the largest channel of the exit radiance that value 0 of a texel stands for, at least 0. Family flat stores the exit radiance
/// itself; others coefficient 0, of which it is Y_0 lambda_0.
inline float exitOf(formats::LightMapFamily family, const glm::vec3& value) {
    return (family == formats::LightMapFamily::Flat ? 1.0f : kShaderY0) * std::max({value.x, value.y, value.z, 0.0f});
}
/// Calls visit(x, y) for the covered texels and those that pad them.
template <class Visit>
void forEachPadded(const Source& source, Visit visit) {
    for (int y = 0; y < source.height; ++y)
        for (int x = 0; x < source.width; ++x)
            if (source.coverage.at(x, y) > 0) visit(x, y);
}
/// Sets the importance of a texel from its values and coverage.
void weigh(const LightMapPlan& plan, Source& source, int x, int y);
/// Returns the rows [firstRow, firstRow + rowCount), with texels outside charts padded with the mean of their nearest covered neighbours.
Source makeSource(const LightMapPlan& plan, const formats::LightMapStrip& strip, int firstRow, int rowCount);

/// Sets the weight of padded texels of the second ring to 0 if their light is far (kFarLight) from that of the covered texels and the first
/// ring in the same block: holding it would cost the block the precision of texels that are seen. A filter reads the second ring only where
/// a triangle leaves its chart's texels.
/// blockSize  side of the encoded blocks [texels]
void dropFarPadding(Source& source, int blockSize);

/// One encoded layer; `decoded` holds its texels as a decoder sees them, if they were asked for.
struct Layer {
    std::vector<std::byte> bytes;
    formats::Image<glm::vec4> decoded;
};
/// Encodes texels. Those without significance are overwritten: each takes the mean of the others of its block.
Layer encodeLayer(formats::PixelFormat format, formats::Image<glm::vec4>& texels, const formats::Image<float>& significance,
                  const EncodeOptions& options, bool wantsDecoded, EncodeReport& report);
/// Encodes values / range as HDR colour, a layer of the plan's first texture. The metric is log2(1 + x / (key / 10)): above a tenth of the
/// plan's key, errors count by their ratio.
Layer encodeHdr(const LightMapPlan& plan, const Source& source, const formats::Image<glm::vec3>& values, float range,
                const EncodeOptions& options, bool wantsDecoded, EncodeReport& report);

/// Encodes the alphas of texels as BC4, the alpha half of BC3.
Layer encodeAlpha(const formats::Image<glm::vec4>& texels, const formats::Image<float>& significance, const EncodeOptions& options,
                  EncodeReport& report);
/// Replaces the alpha halves of BC3 blocks.
/// alpha  BC4, decoded
void putAlpha(Layer& color, const Layer& alpha);

/// Layouts of two HDR textures decode mix(first, second, share). The second texture stores the first one plus its error over the share,
/// clamped to 0 and above: a larger share can correct larger errors, a smaller one adds less of the second texture's own error.
inline constexpr float kSecondShare = 1.0f / 8;
/// Returns what the second texture stores for a value that the first one decodes as `first`.
inline glm::vec3 secondOf(const glm::vec3& value, const glm::vec3& first, float share) {
    return first + (value - first) / share;
}
/// Encodes a layer of the second texture. Blocks whose correction adds to the error get the bytes of the first texture, which mixes to the
/// first one alone: a fast search may miss the range of a block of large corrections.
/// wanted   what the mix should decode to
/// first    layer of the first texture, and its decoded texels
/// Returns the layer with its decoded texels.
Layer encodeSecond(const LightMapPlan& plan, const Source& source, const formats::Image<glm::vec4>& wanted,
                   std::span<const std::byte> first, const formats::Image<glm::vec4>& firstDecoded, EncodeOptions options,
                   EncodeReport& report);
/// Returns the significance of each texel under a linear metric: its importance, and at least a little where it is covered.
formats::Image<float> linearSignificance(const Source& source);

/// Weights of covered and padded texels are at least this share of their coverage, so that no texel loses its weight beside far darker or
/// brighter ones.
inline constexpr float kLeastWeight = 1e-6f;
/// Returns the significance of a texel whose number weighs `weight`: at least leastShare of its coverage; 0 without importance.
inline float significanceOf(const Source& source, int x, int y, float weight, float leastShare = kLeastWeight) {
    return source.importance.at(x, y) > 0 ? std::max(weight, leastShare * source.coverage.at(x, y)) : 0;
}
/// Returns the significance of a texel's ratios to a coefficient 0 that decodes as `dc`: an error of a ratio is seen multiplied by it.
float ratioSignificance(const LightMapPlan& plan, const Source& source, int x, int y, const glm::vec3& dc);

/// Returns element `index` of a constant of the plan.
float constant(const LightMapPlan& plan, const char* name, std::size_t index);

}  // namespace lightcook::compress::rows

// Detail of a light map: tiles whose error would be large are stored once more, in a finer layout. A tile is what a texel of texture
// "coverage" stands for: 8 x 4 texels of the map. The second layer of that texture says where the tile's detail lies, and the shader reads
// each of its four texels (LightMapFilter::Decoded) from the map or from there. A map with detail has one mip level.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "formats/layout_cost.h"
#include "formats/light_map_layout.h"

namespace lightcook::formats {

/// Layout of the tiles: the smallest of those that err least. Its textures lie in two arrays, by the role of their texels.
inline constexpr LightMapLayout kDetailLayout = LightMapLayout::Lit;

struct DetailTextureInfo {
    std::string_view name;  ///< in manifest and shader
    TexelRole role;
};
inline constexpr std::array kDetailTextures = {DetailTextureInfo{"detail_hdr", TexelRole::Hdr},
                                               DetailTextureInfo{"detail_ldr", TexelRole::Ldr}};
/// Returns the layers of one of them: those of the layout's textures of that role, in their order.
constexpr int layersOf(const DetailTextureInfo& detail) {
    int layers = 0;
    for (const LightMapTextureInfo& texture : info(kDetailLayout).textures)
        if (texture.role == detail.role) layers += texture.layerCount;
    return layers;
}
static_assert(layersOf(kDetailTextures[0]) + layersOf(kDetailTextures[1]) == info(kDetailLayout).layerCount());
/// Layers of texture "coverage" of a map with detail.
inline constexpr int kDetailedCoverageLayers = 2;
/// Returns true for the roles of a map's detail.
constexpr bool isOfDetail(std::string_view role) {
    return std::ranges::find(kDetailTextures, role, &DetailTextureInfo::name) != kDetailTextures.end();
}

/// Tiles with detail, side by side in the order of the map.
struct DetailAtlas {
    int tiles = 0;

    int columns() const {
        constexpr int kMost = 256;  ///< a byte of the second layer
        return std::clamp(static_cast<int>(std::ceil(std::sqrt(0.5 * tiles))), 1, kMost);
    }
    int rows() const { return std::max(1, (tiles + columns() - 1) / columns()); }
    int width() const { return kCoverageColumns * columns(); }  ///< [texels]
    int height() const { return kCoverageRows * rows(); }       ///< [texels]
};
/// Largest number of tiles with detail: textures of 2048 x 16384 texels.
inline constexpr int kMostDetailTiles = 1 << 20;

/// Returns the fetches and operations of a sample whose four texels all have detail, or all have none: those of the dearer.
constexpr std::pair<int, int> costWithDetail(const LightMapLayoutInfo& layout) {
    constexpr LightMapFilter kDecoded = LightMapFilter::Decoded;
    const LightMapLayoutInfo& detail = info(kDetailLayout);
    return {4 + std::max(layout.fetchCount(kDecoded), detail.fetchCount(kDecoded)),
            std::max(layout.operations(kDecoded), detail.operations(kDecoded))};
}

/// Returns true if a map of this layout may have detail: its texels are decoded before they are filtered, hold light of all directions,
/// take fewer bits than the detail's, and both decodes are within the limits.
inline bool mayHaveDetail(const LightMapLayoutInfo& layout, const DecodeLimits& decode, const TargetInfo& target) {
    const auto [fetches, operations] = costWithDetail(layout);
    return decode.filterOf(layout) == LightMapFilter::Decoded && !layout.isFlat() &&
           textureBits(layout, target) < textureBits(info(kDetailLayout), target) && fetches <= decode.maxFetches.value_or(fetches) &&
           operations <= decode.maxDecodeOps.value_or(operations);
}

}  // namespace lightcook::formats

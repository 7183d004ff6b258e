// Charts placed in one rectangle of texels.
#pragma once

#include <atomic>
#include <cstdint>
#include <glm/vec2.hpp>
#include <optional>
#include <span>
#include <vector>

#include "formats/image.h"

namespace lightcook::atlas {

struct Packing {
    glm::ivec2 size{0};                   ///< [texels] multiples of 4, the side of a compressed block
    std::vector<glm::ivec2> places = {};  ///< of the first texel of each chart
    double occupancy = 0;                 ///< share of the texels that charts read
};

/// Places charts so that no texel is read by two of them. Charts go to the lowest row, then column, where they fit (bottom left), also into
/// holes of others. Of many orders and widths the smallest page is kept. Charts of kAlignedSide texels or more on both sides begin at a
/// corner of a block.
/// isRead       of each chart: 1 for texels that filters read
/// interrupted  ends the search when it becomes true; then nothing is returned
std::optional<Packing> packCharts(std::span<const formats::ImageView<const std::uint8_t>> isRead, const std::atomic<bool>& interrupted);
inline constexpr int kAlignedSide = 4;

}  // namespace lightcook::atlas

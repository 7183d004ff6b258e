// Mip levels of a light map that keep its charts apart.
//
// A texel of level k stands for 2^k x 2^k texels of the map. Charts are here those that the bake numbers, or else sets of covered texels
// that touch, also by a corner; not those of a mesh (charts.h). A chart is seen at places within its texels; there a bilinear filter of
// level k reads up to four texels of that level. A level is safe if none of the texels that are read from within a chart holds a covered
// texel of another chart. Level k is safe wherever the charts lie if these are 3 * 2^(k - 1) - 1 texels apart along both axes. Closer
// charts may be safe, too, if they lie well in the grid of 2^k.
//
// Use: call coveredRuns() for each strip and join the runs in the order of rows. If the bake numbers no charts, call findMipCharts(). Then
// call safeMipLevels().
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "formats/light_map.h"

namespace lightcook::atlas {

/// Covered texels [begin, end) of a row and a chart, with other texels or the map's border on both sides.
struct CoveredRun {
    int row, begin, end;                       ///< [texels] of level 0
    std::uint32_t chart = formats::kAnyChart;  ///< of the bake, or of findMipCharts()
};

/// Returns the runs of a strip, by row, then column.
std::vector<CoveredRun> coveredRuns(const formats::LightMapStrip& strip);

/// Numbers the charts of the runs of a whole map, in the order of coveredRuns(), from 1 on. The numbers have gaps.
void findMipCharts(std::span<CoveredRun> runs);

/// Sides of levels from 1 on are multiples of this [texels]: whole blocks, as WebGL demands of compressed textures, and each texel stands
/// for whole texels of level 0.
inline constexpr int kLevelStep = 4;

/// The mip levels that a map can have, and what ends them.
struct MipLevels {
    enum class End {
        Size,   ///< a side of the next level would be no multiple of kLevelStep
        Charts  ///< the next level is not safe
    };
    int count = 1;  ///< with level 0
    End end = End::Size;
    glm::ivec2 texel{0};  ///< of the level after the last: the first that is read from within a chart and holds another one
};

/// Returns the levels up to the first that is not safe, or not of a size that a level may have.
/// runs  of findMipCharts()
MipLevels safeMipLevels(std::span<const CoveredRun> runs, int width, int height);

}  // namespace lightcook::atlas

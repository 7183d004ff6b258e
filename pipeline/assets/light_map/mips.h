// Mip levels of a light map: how many it may have, and which chart and cluster their texels belong to. atlas/mips.h has the rule.
//
// Each level is a light map of its own (LightMapSource::mip), encoded and verified as level 0 is, with the constants and tables of level 0.
// Only the containers join them.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "atlas/mips.h"
#include "formats/error.h"
#include "formats/image.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

class LightMapSource;

/// The mip levels that a light map may have.
struct MipSurvey {
    std::vector<atlas::CoveredRun> runs;  ///< of level 0, with their charts
    int count = 1;                        ///< of levels, with level 0
    std::string end;                      ///< why there is no further one
};

/// Reads the coverage of a map, and finds its levels. There is level 0 alone for a map of constant light, and for one whose file does not
/// say which texels lie inside charts.
formats::Result<MipSurvey> surveyMips(LightMapSource& source, const ActionContext& context);

/// Returns the number of levels that a map is cooked with.
/// isWanted  false: level 0 alone, and the coverage is not read
formats::Result<int> mipCountOf(LightMapSource& source, bool isWanted, const ActionContext& context);

/// Sides of levels of a map with a texture "coverage" are multiples of this [texels], so that its levels have whole texels too.
inline constexpr int kCoverageLevelStep = 8;
/// Returns how many of the first `count` levels such a map may have.
int coverageLevels(int width, int height, int count);
/// Returns why it has no more than `count`.
std::string coverageEnd(int width, int height, int count);

/// Returns the chart of each covered texel of rows [firstRow, firstRow + rowCount) of a level.
formats::Image<std::uint32_t> chartsOfMip(const MipSurvey& survey, int level, int width, int firstRow, int rowCount);

/// Returns the cluster of each texel of a level, row by row: that of the blocks of level 0 that its covered texels lie in, which the
/// vertices of the chart name; 0 where none is covered.
/// clusterOfBlock  of the blocks of 4 x 4 texels of level 0, row by row
std::vector<std::uint8_t> clustersOfMip(const MipSurvey& survey, int level, int mapWidth, int mapHeight,
                                        std::span<const std::uint8_t> clusterOfBlock);

}  // namespace lightcook::pipeline

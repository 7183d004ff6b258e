#include "pipeline/assets/light_map/mips.h"

#include <fmt/format.h>

#include <algorithm>

#include "formats/chart_clusters.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/graph/parallel_for.h"

namespace lightcook::pipeline {
namespace {

using atlas::CoveredRun;
using formats::Result;

/// Returns the words for a map whose levels end for the size of the next one, a multiple of `step`.
std::string sizeWords(int width, int height, int count, int step) {
    const int last = count - 1;
    return fmt::format("half of the {} x {} texels of level {} would be no multiple of {}", width >> last, height >> last, last, step);
}

/// Returns why a map has no more levels.
std::string endWords(const atlas::MipLevels& levels, int width, int height) {
    if (levels.end == atlas::MipLevels::End::Size) return sizeWords(width, height, levels.count, atlas::kLevelStep);
    return fmt::format("level {} would mix charts, at its texel ({}, {})", levels.count, levels.texel.x, levels.texel.y);
}

/// Calls visit(run, x, y) for each texel of a level that holds texels of a run, in rows [firstRow, firstRow + rowCount) of the level.
template <class Visit>
void forEachHeld(const MipSurvey& survey, int level, int firstRow, int rowCount, Visit visit) {
    const auto first = std::ranges::lower_bound(survey.runs, firstRow << level, {}, &CoveredRun::row);
    const int end = (firstRow + rowCount) << level;
    for (auto run = first; run != survey.runs.end() && run->row < end; ++run)
        for (int x = run->begin >> level; x <= (run->end - 1) >> level; ++x) visit(*run, x, run->row >> level);
}

}  // namespace

Result<MipSurvey> surveyMips(LightMapSource& source, const ActionContext& context) {
    if (source.constantTexels()) return MipSurvey{{}, 1, "the map holds the same light everywhere"};
    if (source.hasTangents()) return MipSurvey{{}, 1, "the layout is relative to tangents, of which a texel of a level may have several"};
    if (!source.hasCoverage()) return MipSurvey{{}, 1, "the bake does not say which texels lie inside charts"};
    MipSurvey survey;
    using Runs = std::vector<CoveredRun>;
    const auto found = foldInOrder<Runs>(
        source.chunkCount(), context, fmt::format("find the mip levels of {}", context.action.asset),
        [&](int index) -> Result<Runs> {
            LC_TRY(chunk, source.chunk(index));
            return atlas::coveredRuns(**chunk);
        },
        [&](const Runs& runs) { survey.runs.insert(survey.runs.end(), runs.begin(), runs.end()); });
    if (!found) return tl::make_unexpected(found.error());
    if (std::ranges::any_of(survey.runs, [](const CoveredRun& run) { return run.chart == formats::kAnyChart; }))
        atlas::findMipCharts(survey.runs);
    const atlas::MipLevels levels = atlas::safeMipLevels(survey.runs, source.width(), source.height());
    survey.count = levels.count;
    survey.end = endWords(levels, source.width(), source.height());
    return survey;
}

Result<int> mipCountOf(LightMapSource& source, bool isWanted, const ActionContext& context) {
    if (!isWanted) return 1;
    LC_TRY(found, source.mipSurvey(context));
    return (*found)->count;
}

int coverageLevels(int width, int height, int count) {
    const auto isWhole = [&](int level) {
        return (width >> level) % kCoverageLevelStep == 0 && (height >> level) % kCoverageLevelStep == 0;
    };
    int levels = 1;
    while (levels < count && isWhole(levels)) ++levels;
    return levels;
}

std::string coverageEnd(int width, int height, int count) {
    return sizeWords(width, height, count, kCoverageLevelStep);
}

formats::Image<std::uint32_t> chartsOfMip(const MipSurvey& survey, int level, int width, int firstRow, int rowCount) {
    formats::Image<std::uint32_t> charts(width, rowCount, formats::kAnyChart);
    forEachHeld(survey, level, firstRow, rowCount, [&](const CoveredRun& run, int x, int y) { charts.at(x, y - firstRow) = run.chart; });
    return charts;
}

std::vector<std::uint8_t> clustersOfMip(const MipSurvey& survey, int level, int mapWidth, int mapHeight,
                                        std::span<const std::uint8_t> clusterOfBlock) {
    constexpr int kBlock = formats::kClusterBlock;
    const int width = mapWidth >> level, height = mapHeight >> level, across = (mapWidth + kBlock - 1) / kBlock;
    std::vector<std::uint8_t> clusters(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0);
    forEachHeld(survey, level, 0, height, [&](const CoveredRun& run, int x, int y) {
        const int texelX = std::max(run.begin, x << level);
        clusters[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)] =
            clusterOfBlock[static_cast<std::size_t>(run.row / kBlock) * static_cast<std::size_t>(across) +
                           static_cast<std::size_t>(texelX / kBlock)];
    });
    return clusters;
}

}  // namespace lightcook::pipeline

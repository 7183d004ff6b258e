#include "pipeline/assets/light_map/mip_errors.h"

#include <fmt/format.h>

#include <algorithm>

#include "formats/chart_clusters.h"
#include "formats/light_map_layout.h"
#include "pipeline/assets/light_map/cooked_light_map.h"
#include "pipeline/assets/light_map/mips.h"
#include "pipeline/assets/light_map/texel_squares.h"
#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/assets/verdict.h"
#include "pipeline/graph/parallel_for.h"
#include "verify/block_errors.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Result;

/// Returns the clusters of the blocks of level 0, from the texture "index" or from the runs that the mesh was made from. Empty for layouts
/// that are not learned.
Result<std::vector<std::uint8_t>> clustersOfLevel0(const MippedLightMap& map) {
    auto clusters = clustersOfBlocks(map.folder, map.asset);
    if (!clusters || !clusters->empty()) return clusters;
    const auto constants = constantsOf(map.folder, map.asset);
    if (!constants) return tl::make_unexpected(constants.error());
    const auto runs = constants->find(kIndexRuns);
    if (runs == constants->end()) return clusters;
    auto found = formats::ClusterMap::fromRuns(map.asset.width, map.asset.height, runs->second);
    if (!found) return failure(ErrorCode::Verification, map.asset.name + ", constant index_runs", found.error());
    return std::move(found->ofBlock);
}

/// Errors of some rows of a level.
struct MipPart {
    verify::LightMapErrors errors;
    verify::BlockErrors blocks;
};

Result<MipPart> compareStrip(LightMapSource& level, const CookedLightMapReader& cooked, bool isFlat, int index) {
    const auto strip = readStrip(level, cooked, index);
    if (!strip) return tl::make_unexpected(strip.error());
    const auto& [firstRow, rowCount, reference, texels, seen] = *strip;
    verify::BlockErrors blocks(level.width(), rowCount, firstRow);
    for (int y = 0; y < rowCount; ++y)
        for (int x = 0; x < level.width(); ++x) {
            if (reference.covered.at(x, y) == 0) continue;
            const TexelSquares squares = squaresOf(reference.sh.at(x, y), seen.at(x, y), reference.normal.at(x, y), isFlat);
            blocks.add(x, firstRow + y, squares.error, squares.reference);
        }
    return MipPart{cooked.verifier().verifyRows(texels, reference, firstRow, rowCount), std::move(blocks)};
}

/// Adds a violation for each limit that a level is over.
void holdToLimits(const verify::StageError& level, const MippedLightMap& map, std::vector<verify::Violation>& violations) {
    const auto hold = [&](const char* shading, const verify::ErrorFigures& figures) {
        const auto add = [&](const char* figure, double found, double limit, const char* key) {
            if (!(found <= limit))
                violations.push_back({fmt::format("{}, {}", level.name, shading), fmt::format("{} {:.4g}", figure, found),
                                      fmt::format("at most {:.4g} ({}), as at level 0: a lower limit chooses a layout with less error "
                                                  "there, mips = false cooks level 0 alone",
                                                  limit, key)});
        };
        add("rel_rms", figures.relRms, map.maxError, "max_error");
        if (figures.visible && map.parameters.maxVisible)
            add("a visible error (p99) of", figures.visible->p99, *map.parameters.maxVisible, "max_visible");
        if (figures.visible && figures.visible->bound && map.parameters.maxVisibleBound)
            add("a visible error (proven bound) of up to", *figures.visible->bound, *map.parameters.maxVisibleBound, "max_visible_bound");
        if (!isFinite(figures))
            violations.push_back({fmt::format("{}, {}", level.name, shading), "figures that are not finite", "every figure finite"});
    };
    hold("diffuse", level.diffuse);
    hold("specular", level.specular);
    if (map.parameters.maxVisibleBound && !hasVisibleBound(level))
        violations.push_back(unknownBound(level.name, *map.parameters.maxVisibleBound));
}

}  // namespace

Result<std::vector<verify::StageError>> mipErrors(const MippedLightMap& map, std::vector<verify::Violation>& violations,
                                                  const ActionContext& context) {
    std::vector<verify::StageError> levels;
    int count = 1;
    for (const CookedTexture& texture : map.asset.textures) count = std::max(count, texture.mips);
    if (count == 1) return levels;
    const auto survey = map.bake.mipSurvey(context);
    if (!survey) return tl::make_unexpected(survey.error());
    if (count > (*survey)->count)
        return failure(ErrorCode::Verification, map.asset.name,
                       fmt::format("found {} mip levels, expected at most {}: {}", count, (*survey)->count, (*survey)->end));
    const auto clusters = clustersOfLevel0(map);
    if (!clusters) return tl::make_unexpected(clusters.error());
    const bool isFlat = formats::isFlat(map.asset.layout);
    verify::LightMapSampling sampling;
    sampling.placesPerTexel = map.parameters.samples;
    for (int mip = 1; mip < count; ++mip) {
        LightMapSource& level = map.bake.mip(mip);
        auto ofTexels =
            clusters->empty() ? std::vector<std::uint8_t>() : clustersOfMip(**survey, mip, map.asset.width, map.asset.height, *clusters);
        const auto cooked = CookedLightMapReader::openMip(map.folder, map.asset, mip, std::move(ofTexels),
                                                          {map.parameters.shading, sampling, map.key, map.viewing});
        if (!cooked) return tl::make_unexpected(cooked.error());
        MipPart whole{cooked->verifier().noErrors(), verify::BlockErrors(level.width(), 0)};
        const auto compared = foldInOrder<MipPart>(
            level.stripCount(), context, fmt::format("verify mip {} of {}", mip, context.action.asset),
            [&](int index) { return compareStrip(level, *cooked, isFlat, index); },
            [&](const MipPart& part) {
                whole.errors.merge(part.errors);
                whole.blocks.merge(part.blocks);
            });
        if (!compared) return tl::make_unexpected(compared.error());
        verify::StageError total = whole.errors.figures().back();
        total.name = fmt::format("mip {}", mip);
        checkBlocks(whole.blocks, total.name + ", ", map.maxError, violations);
        holdToLimits(total, map, violations);
        levels.push_back(std::move(total));
    }
    return levels;
}

}  // namespace lightcook::pipeline

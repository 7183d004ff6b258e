// Verification of the mip levels of a cooked light map. Each level from 1 on is decoded from the file and held against the bake's mean over
// its texels, at texel centres and at places between them, with the certified bounds of level 0. All limits on the error hold for each
// level. Places between the texels of two charts count nowhere: no surface lies there (atlas/mips.h). So do the limits on sampled errors
// between two levels, where a trilinear sampler mixes the texels of both.
#include <fmt/format.h>

#include <algorithm>

#include "formats/chart_clusters.h"
#include "pipeline/assets/light_map/checked_light_map.h"
#include "pipeline/assets/light_map/lit_row.h"
#include "pipeline/assets/light_map/mips.h"
#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/graph/parallel_for.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Result;

/// Returns the clusters of the blocks of level 0, from the texture "index" or from the runs that the mesh was made from. Empty for layouts
/// that are not learned.
Result<std::vector<std::uint8_t>> clustersOfLevel0(const CheckedLightMap& map) {
    auto clusters = clustersOfBlocks(map.context.upstreamFolder, map.asset);
    if (!clusters || !clusters->empty()) return clusters;
    LC_TRY(constants, constantsOf(map.context.upstreamFolder, map.asset));
    const auto runs = constants->find(kIndexRuns);
    if (runs == constants->end()) return clusters;
    auto found = formats::ClusterMap::fromRuns(map.asset.width, map.asset.height, runs->second);
    if (!found) return failure(ErrorCode::Verification, map.asset.name + ", constant index_runs", found.error());
    return std::move(found->ofBlock);
}

/// Errors of some rows of a level.
struct MipPart {
    verify::LightMapErrors errors;
    verify::ShadedErrors blend;  ///< between this level and the larger one
    WorstBlock block;
};

/// A level of a map, as it was baked and cooked.
struct Level {
    LightMapSource& bake;
    const CookedLightMapReader& cooked;
};

/// Returns the errors between some rows of a level and the larger one beside them.
Result<verify::ShadedErrors> compareBetween(const Level& larger, const Level& smaller, const CookedStrip& strip) {
    const int first = 2 * strip.firstRow, count = std::min(2 * strip.rowCount + 2, larger.bake.height() - first);
    LC_TRY(reference, larger.bake.rows(first, count));
    LC_TRY(texels, larger.cooked.read(first, count));
    return larger.cooked.verifier().verifyBetween({*texels, *reference}, smaller.cooked.verifier(), {strip.texels, strip.reference},
                                                  strip.firstRow, strip.rowCount);
}

Result<MipPart> compareStrip(const Level& larger, const Level& level, const verify::Viewing& viewing, double key, int index) {
    LC_TRY(strip, readStrip(level.bake, level.cooked, index));
    const auto& [firstRow, rowCount, reference, texels, seen] = *strip;
    VisibleBlocks blocks(level.bake.width(), rowCount, firstRow);
    LC_CHECK(blocks.addRims(level.bake, level.cooked, *strip, viewing, key));
    LC_TRY(blend, compareBetween(larger, level, *strip));
    LitRow lit(level.bake.width(), viewing);
    for (int y = 0; y < rowCount; ++y) {
        for (int x = 0; x < level.bake.width(); ++x)
            if (reference.covered.at(x, y) != 0) lit.set(x, reference.sh.at(x, y), seen.at(x, y), reference.normal.at(x, y));
        lit.compare();
        for (int x = 0; x < level.bake.width(); ++x)
            if (reference.covered.at(x, y) != 0) blocks.add(x, firstRow + y, lit.visible(x));
    }
    WorstBlock block;
    block.merge(blocks);
    return MipPart{level.cooked.verifier().verifyRows(texels, reference, firstRow, rowCount), std::move(*blend), block};
}

}  // namespace

/// Levels are called "mip 1" and on; the mix of each with the larger one before it "mip 0 to 1" and on.
Result<void> checkMips(CheckedLightMap& map) {
    const ActionContext& context = map.context;
    const int count = map.mipCount();
    LC_TRY(survey, map.bake.mipSurvey(context));
    if (count > (*survey)->count)
        return failure(ErrorCode::Verification, map.asset.name,
                       fmt::format("found {} mip levels, expected at most {}: {}", count, (*survey)->count, (*survey)->end));
    LC_TRY(clusters, clustersOfLevel0(map));
    verify::LightMapSampling sampling;
    sampling.placesPerTexel = map.parameters.samples;
    std::vector<CookedLightMapReader> readers;  // of the levels from 1 on
    readers.reserve(static_cast<std::size_t>(count));
    for (int mip = 1; mip < count; ++mip) {
        LightMapSource& bake = map.bake.mip(mip);
        auto ofTexels =
            clusters->empty() ? std::vector<std::uint8_t>() : clustersOfMip(**survey, mip, map.asset.width, map.asset.height, *clusters);
        LC_TRY(cooked, CookedLightMapReader::openMip(context.upstreamFolder, map.asset, mip, std::move(ofTexels),
                                                     {map.parameters.shading, sampling, map.key, map.viewing}));
        const Level larger{mip == 1 ? map.bake : map.bake.mip(mip - 1), readers.empty() ? map.cooked : readers.back()};
        const Level level{bake, *cooked};
        MipPart whole{cooked->verifier().noErrors(), {}, {}};
        LC_CHECK(foldInOrder<MipPart>(
            bake.stripCount(), context.between(kTexelsEnd, 1), fmt::format("verify mip {} of {}", mip, context.action.asset),
            [&](int index) { return compareStrip(larger, level, map.viewing, map.key, index); },
            [&](const MipPart& part) {
                whole.errors.merge(part.errors);
                whole.blend.merge(part.blend);
                whole.block.merge(part.block);
            }));
        verify::StageError total = whole.errors.figures().back();
        total.name = fmt::format("mip {}", mip);
        whole.block.check(total.name + ", ", map.parameters.limits, total, map.violations());
        if (const auto& limit = map.parameters.limits[Limit::VisibleBound]; limit && !hasVisibleBound(total))
            map.violations().push_back(unknownBound(total.name, *limit));
        map.result.mips.push_back(std::move(total));
        if (map.parameters.samples > 0)
            map.result.mipBlends.push_back(
                {fmt::format("mip {} to {}", mip - 1, mip), whole.blend.diffuseFigures(), whole.blend.specularFigures()});
        readers.push_back(std::move(*cooked));
    }
    return {};
}

}  // namespace lightcook::pipeline

// The pass over all texels of a cooked light map: their errors, by block, by chart and the worst of them, and the light that they are a
// part of.
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "formats/light_map_layout.h"
#include "pipeline/assets/light_map/checked_light_map.h"
#include "pipeline/assets/light_map/lit_row.h"
#include "pipeline/assets/light_map/strip_digest.h"
#include "pipeline/graph/parallel_for.h"
#include "pipeline/graph/part_cache.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

/// Returns the RMS of the light that the map's errors are a part of. The verifier works in units of the key, where there is one.
LightFigures lightOf(const LightMapSource& bake, const verify::LightMapErrors& errors, double key, const LightMoments& light) {
    const double unit = key > 0 ? key : 1.0;
    // Without places on the surface the verdict is that of the texel centres.
    const bool isOnSurface = errors.surface.diffuse.sampleCount() > 0 || errors.stages.empty();
    const verify::ShadedErrors& shaded = isOnSurface ? errors.surface : errors.stages.back().errors;
    LightFigures figures;
    figures.diffuseRms = unit * shaded.diffuse.referenceRms();
    figures.specularRms = unit * shaded.specular.referenceRms();
    const Moments moments = light.moments();
    figures.moments.emplace(moments.begin(), moments.end());
    figures.texels = bake.constantTexels().value_or(light.texels());
    return figures;
}

/// Returns the tilt of the normal maps whose errors a map is compared under [degrees]. Empty: surfaces show light at their own normals
/// alone.
std::optional<double> comparedTilt(const verify::LightMapShading& shading, bool isFlat) {
    const bool hasNormalMaps = shading.normalCount > 1 && shading.normalMapTilt > 0 && !isFlat;
    return hasNormalMaps ? std::optional(shading.normalMapTilt) : std::nullopt;
}

/// Returns the first texel of a strip at which texture "coverage" is not that of the bake. Empty for maps without it.
std::optional<glm::ivec2> otherCoverage(const CookedStrip& strip) {
    const formats::Image<std::uint8_t>& covered = strip.texels.covered;
    for (int y = 0; y < std::min(strip.rowCount, covered.height()); ++y)
        for (int x = 0; x < covered.width(); ++x)
            if ((covered.at(x, y) != 0) != (strip.reference.covered.at(x, y) != 0)) return glm::ivec2(x, strip.firstRow + y);
    return std::nullopt;
}

/// Returns the errors of a strip. Those of a strip that an earlier cook has compared come from the cache.
verify::LightMapErrors errorsOfStrip(const CheckedLightMap& map, const CookedStrip& strip) {
    return cachedPart(
        map.context.parts,
        [&] {
            return digestOf(map.cooked.verifierDigest(), strip.firstRow, strip.rowCount, digestOfRows(strip.texels),
                            digestOfStrip(strip.reference));
        },
        [&] { return map.cooked.verifier().verifyRows(strip.texels, strip.reference, strip.firstRow, strip.rowCount); });
}

/// Compares one strip of a cooked map with the bake.
/// tilt  of normal maps [degrees]; empty: surfaces show light at their own normals alone
Result<TexelErrors> compareStrip(CheckedLightMap& map, const std::optional<double>& tilt, int index) {
    LightMapSource& bake = map.bake;
    LC_TRY(strip, readStrip(bake, map.cooked, index));
    const auto& [firstRow, rowCount, reference, texels, seen] = *strip;
    VisibleBlocks blocks(bake.width(), rowCount, firstRow);
    LightMoments light;
    LitRow lit(bake.width(), map.viewing);
    std::optional<NormalCap> cap;
    if (tilt) cap.emplace(*tilt, map.viewing);
    WorstTexels worst(bake.width(), firstRow, rowCount);
    ChartErrors chartErrors;
    const auto groups = map.charts ? map.charts->groupsOf(firstRow, rowCount) : formats::Image<std::uint8_t>();
    for (int y = 0; y < rowCount; ++y) {
        for (int x = 0; x < bake.width(); ++x) {
            if (reference.covered.at(x, y) == 0) continue;
            const glm::vec3 normal = reference.normal.at(x, y);
            light.add(reference.sh.at(x, y), normal);
            lit.set(x, reference.sh.at(x, y), seen.at(x, y), normal);
        }
        lit.compare();
        for (int x = 0; x < bake.width(); ++x)
            if (reference.covered.at(x, y) != 0) {
                map.preview.set(x, firstRow + y, lit.reference(x), lit.found(x), lit.visible(x));
                worst.add(x, firstRow + y, lit.visible(x));
                blocks.add(x, firstRow + y, lit.visible(x));
                if (map.charts) chartErrors.add(groups.at(x, y), x, firstRow + y, lit.visible(x));
                if (cap && map.preview.shows(x, firstRow + y))
                    map.preview.setAtAnyNormal(x, firstRow + y,
                                               cap->worst(reference.sh.at(x, y), seen.at(x, y), reference.normal.at(x, y)));
            }
    }
    LC_TRY(traced, map.truth.within(reference, firstRow, rowCount));
    LC_CHECK(blocks.addRims(bake, map.cooked, *strip, map.viewing, map.key));
    WorstBlock block;
    block.merge(blocks);
    return TexelErrors{
        errorsOfStrip(map, *strip), block, lightMapPlaces(*traced, reference, seen, firstRow), light, worst, std::move(chartErrors),
        otherCoverage(*strip)};
}

}  // namespace

Result<void> checkTexels(CheckedLightMap& map) {
    const auto tilt = comparedTilt(map.parameters.shading, formats::isFlat(map.asset.layout));
    LC_CHECK(foldInOrder<TexelErrors>(
        map.bake.stripCount(), map.context.between(kSurveyEnd, kTexelsEnd), "verify " + map.context.action.asset,
        [&](int index) { return compareStrip(map, tilt, index); }, [&](const TexelErrors& part) { map.texels.merge(part); }));
    map.result.verdict.stages = map.texels.errors.figures();
    if (const auto& texel = map.texels.otherCoverage)
        map.violations().push_back({fmt::format("texture {} at texel ({}, {})", formats::kCoverageRole, texel->x, texel->y),
                                    "another coverage", "that of the bake"});
    if (map.texels.block.figures().isKnown()) map.result.worstBlock = map.texels.block.figures();
    map.result.light = lightOf(map.bake, map.texels.errors, map.key, map.texels.light);
    return {};
}

}  // namespace lightcook::pipeline

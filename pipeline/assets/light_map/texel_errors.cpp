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

/// A strip that is read when it is first asked for.
class LazyStrip {
public:
    LazyStrip(const CheckedLightMap& map, int index) : map_(map), index_(index) {}
    Result<const CookedStrip*> get() {
        if (!strip_) {
            LC_TRY(strip, readStrip(map_.bake, map_.cooked, index_));
            strip_ = std::move(*strip);
        }
        return &*strip_;
    }

private:
    const CheckedLightMap& map_;
    int index_;
    std::optional<CookedStrip> strip_;
};

/// Returns what the texels of a strip show.
/// tilt    of normal maps [degrees]; empty: surfaces show light at their own normals alone
/// groups  of charts: MapCharts::groupsOf()
Result<ShownTexels> shownTexels(const CheckedLightMap& map, const std::optional<double>& tilt, const formats::Image<std::uint8_t>& groups,
                                const CookedStrip& strip) {
    LightMapSource& bake = map.bake;
    const auto& [firstRow, rowCount, reference, texels, seen] = strip;
    VisibleBlocks blocks(bake.width(), rowCount, firstRow);
    LitRow lit(bake.width(), map.viewing);
    std::optional<NormalCap> cap;
    if (tilt) cap.emplace(*tilt, map.viewing);
    ShownTexels shown;
    shown.worst = WorstTexels(bake.width(), firstRow, rowCount);
    shown.preview = Preview(bake.width(), bake.height(), map.key, firstRow, rowCount);
    for (int y = 0; y < rowCount; ++y) {
        for (int x = 0; x < bake.width(); ++x) {
            if (reference.covered.at(x, y) == 0) continue;
            const glm::vec3 normal = reference.normal.at(x, y);
            shown.light.add(reference.sh.at(x, y), normal);
            lit.set(x, reference.sh.at(x, y), seen.at(x, y), normal);
        }
        lit.compare();
        for (int x = 0; x < bake.width(); ++x)
            if (reference.covered.at(x, y) != 0) {
                shown.preview.set(x, firstRow + y, lit.reference(x), lit.found(x), lit.visible(x));
                shown.worst.add(x, firstRow + y, lit.visible(x));
                blocks.add(x, firstRow + y, lit.visible(x));
                if (map.charts) shown.charts.add(groups.at(x, y), x, firstRow + y, lit.visible(x));
                if (cap && shown.preview.shows(x, firstRow + y))
                    shown.preview.setAtAnyNormal(x, firstRow + y,
                                                 cap->worst(reference.sh.at(x, y), seen.at(x, y), reference.normal.at(x, y)));
            }
    }
    LC_TRY(traced, map.truth.within(reference, firstRow, rowCount));
    LC_CHECK(blocks.addRims(bake, map.cooked, strip, map.viewing, map.key));
    shown.block.merge(blocks);
    shown.truthPlaces = lightMapPlaces(*traced, reference, seen, firstRow);
    shown.otherCoverage = otherCoverage(strip);
    return shown;
}

/// Compares one strip of a cooked map with the bake. What an earlier cook has compared comes from the cache.
Result<TexelErrors> compareStrip(const CheckedLightMap& map, const std::optional<double>& tilt, int index) {
    LightMapSource& bake = map.bake;
    const int firstRow = bake.stripFirstRow(index), rowCount = bake.stripRows(index);
    const auto groups = map.charts ? map.charts->groupsOf(firstRow, rowCount) : formats::Image<std::uint8_t>();
    const PartCache* const parts = map.context.parts;
    LazyStrip strip(map, index);
    // Digest of the rows, with some of those around them.
    const auto digestWith = [&](int above, int below) -> Result<std::string> {
        LC_TRY(ofBake, bake.digestOfStrip(index, above, below, *parts));
        LC_TRY(ofCooked, map.cooked.digestOfRows(firstRow, rowCount + std::min(below, 1)));
        return digestOf(map.cooked.verifierDigest(), *ofBake, *ofCooked);
    };
    const bool hasRims = !map.cooked.hasCoverage();
    LC_TRY(shown, cachedPart(
                      parts,
                      [&]() -> Result<std::string> {
                          LC_TRY(rows, hasRims ? digestWith(VisibleBlocks::kRowsAbove, VisibleBlocks::kRowsBelow) : digestWith(0, 0));
                          return digestOf("shown", *rows, tilt.value_or(-1), digestOfImage(groups), map.truth.digest());
                      },
                      [&]() -> Result<ShownTexels> {
                          LC_TRY(read, strip.get());
                          return shownTexels(map, tilt, groups, **read);
                      }));
    LC_TRY(errors, cachedPart(
                       parts, [&]() { return digestWith(0, 1); },
                       [&]() -> Result<verify::LightMapErrors> {
                           LC_TRY(read, strip.get());
                           return map.cooked.verifier().verifyRows((*read)->texels, (*read)->reference, firstRow, rowCount);
                       }));
    return TexelErrors{std::move(*errors), std::move(*shown)};
}

}  // namespace

Result<void> checkTexels(CheckedLightMap& map) {
    const auto tilt = comparedTilt(map.parameters.shading, formats::isFlat(map.asset.layout));
    LC_CHECK(foldInOrder<TexelErrors>(
        map.bake.stripCount(), map.context.between(kSurveyEnd, kTexelsEnd), "verify " + map.context.action.asset,
        [&](int index) { return compareStrip(map, tilt, index); }, [&](const TexelErrors& part) { map.texels.merge(part); }));
    map.result.verdict.stages = map.texels.errors.figures();
    if (const auto& texel = map.texels.shown.otherCoverage)
        map.violations().push_back({fmt::format("texture {} at texel ({}, {})", formats::kCoverageRole, texel->x, texel->y),
                                    "another coverage", "that of the bake"});
    if (map.texels.shown.block.figures().isKnown()) map.result.worstBlock = map.texels.shown.block.figures();
    map.result.light = lightOf(map.bake, map.texels.errors, map.key, map.texels.shown.light);
    return {};
}

}  // namespace lightcook::pipeline

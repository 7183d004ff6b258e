#include "pipeline/command/compare_light_maps.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "formats/light_map.h"
#include "lighting/display.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/light_map/survey.h"
#include "pipeline/graph/parallel_for.h"
#include "verify/light_map.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Result;

Result<LightMapSource*> open(LightMapSources& sources, const ComparedMap& map) {
    const auto known = formats::LightMapReader::recognize(map.file, map.description);
    if (known && known->format->needsMesh() && map.description.mesh.empty())
        return failure(
            ErrorCode::FormatUnsupported, map.file,
            fmt::format("found bake format {}, whose light depends on a mesh, expected --mesh FILE; or cook it, and compare what "
                        "`lightcook reconstruct` writes",
                        known->format->name));
    formats::LightMapDescription description = map.description;
    description.isCompressed = true;
    description.fireflyLimit = 0;
    return sources.open(map.file, description);
}

/// A light map and the reference that it is compared with. What the reference does not say of the surface, coverage or normals, is that of
/// the other light map.
class ComparedMaps {
public:
    ComparedMaps(LightMapSource& reference, LightMapSource& other)
        : reference_(reference),
          other_(other),
          takesCoverage_(!reference.hasCoverage() && other.hasCoverage()),
          takesNormals_(!reference.hasNormals() && other.hasNormals()) {}

    bool hasCoverage() const { return reference_.hasCoverage() || takesCoverage_; }
    bool hasNormals() const { return reference_.hasNormals() || takesNormals_; }

    /// Returns rows of the reference, with the coverage and the normals that count.
    Result<std::shared_ptr<const formats::LightMapStrip>> chunk(int index) const {
        auto rows = reference_.chunk(index);
        if (!rows || !(takesCoverage_ || takesNormals_)) return rows;
        LC_TRY(surface, other_.chunk(index));
        const formats::LightMapStrip& own = **rows;
        auto strip = std::make_shared<formats::LightMapStrip>();
        strip->firstRow = own.firstRow;
        strip->sh = own.sh.copy();
        strip->covered = (takesCoverage_ ? **surface : own).covered.copy();
        strip->normal = (takesNormals_ ? **surface : own).normal.copy();
        return strip;
    }

private:
    LightMapSource &reference_, &other_;
    bool takesCoverage_, takesNormals_;
};

/// Warns of a comparison at other texels, or about other normals, than those that a viewer sees.
void warnOfSurface(const ComparedMaps& maps, const std::filesystem::path& reference, const RunState& state) {
    if (!state.warning || (maps.hasCoverage() && maps.hasNormals())) return;
    std::vector<std::string> lacks, results;
    if (!maps.hasCoverage()) {
        lacks.emplace_back("coverage (coverage.Y, or alpha)");
        results.emplace_back("texels outside charts count");
    }
    if (!maps.hasNormals()) {
        lacks.emplace_back("normals (normal.X, normal.Y, normal.Z)");
        results.emplace_back("light is compared about (0, 0, 1)");
    }
    state.warning(reference.string(), fmt::format("found no {} in it or in the other light map, expected them in one of the two: {}",
                                                  fmt::join(lacks, " and no "), fmt::join(results, ", and ")));
}

Json toJson(const verify::ErrorFigures& figures) {
    Json json = {{"rel_rms", figures.relRms}, {"p99", figures.p99}, {"max", figures.maxSampled}};
    if (const auto& visible = figures.visible)
        json["visible"] = {{"rms", visible->rms}, {"p50", visible->p50},   {"p95", visible->p95},
                           {"p99", visible->p99}, {"p999", visible->p999}, {"max", visible->max}};
    return json;
}

}  // namespace

bool isCertainLightMap(const ComparedMap& map) {
    if (map.description.bake != formats::kAutoBake) return true;
    const auto known = formats::LightMapReader::recognize(map.file, map.description);
    return known && known->isCertain;
}

Result<Json> compareLightMaps(const ComparedMap& a, const ComparedMap& b, const RunState& state) {
    LightMapSources sources;
    LC_TRY(reference, open(sources, a), found = open(sources, b));
    if (!found) return tl::make_unexpected(found.error());
    LightMapSource &bake = **reference, &other = **found;
    if (bake.width() != other.width() || bake.height() != other.height())
        return failure(ErrorCode::WrongShape, b.file,
                       fmt::format("found {} x {} texels, expected {} x {} as in {}", other.width(), other.height(), bake.width(),
                                   bake.height(), a.file.string()));

    SharedObjects shared;
    const Action action{"compare", "compare", a.file.filename().string(), {}, {}, {}};
    const ActionContext context{action, {}, {}, {}, shared, state};
    const ComparedMaps maps(bake, other);
    warnOfSurface(maps, a.file, state);
    const auto key = surveyKey(
        bake, [&](int index) { return maps.chunk(index); }, context);
    if (!key) return tl::make_unexpected(key.error());
    if (key->coveredTexels() == 0)
        return failure(ErrorCode::WrongShape, a.file, "found no covered texel, expected some: there is nothing to compare");
    const verify::Viewing viewing{lighting::DisplaySettings{}.of(key->displayKey()), bake.bt2020FromWorking()};
    LC_TRY(score, verify::LightMapScore::create({}, key->key(), viewing));
    verify::ShadedErrors errors;
    const auto scored = foldInOrder<verify::ShadedErrors>(
        bake.chunkCount(), context, fmt::format("compare {}", action.asset),
        [&](int index) -> Result<verify::ShadedErrors> {
            LC_TRY(expected, maps.chunk(index), result = other.chunk(index));
            if (!result) return tl::make_unexpected(result.error());
            return score->score(**expected, (*result)->sh.view(), (*expected)->firstRow);
        },
        [&](const verify::ShadedErrors& part) { errors.merge(part); });
    if (!scored) return tl::make_unexpected(scored.error());
    return Json{{"width", bake.width()},
                {"height", bake.height()},
                {"texels", key->coveredTexels()},
                {"diffuse", toJson(errors.diffuseFigures())},
                {"specular", toJson(errors.specularFigures())}};
}

}  // namespace lightcook::pipeline

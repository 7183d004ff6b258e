#include "pipeline/command/compare_light_maps.h"

#include <fmt/format.h>

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

Result<LightMapSource*> open(LightMapSources& sources, const std::filesystem::path& file) {
    const auto known = formats::LightMapReader::recognize(file, {});
    if (known && known->format->needsMesh())
        return failure(ErrorCode::FormatUnsupported, file.string(),
                       fmt::format("found bake format {}, whose light depends on a mesh, expected a light map in world space. Cook it, and "
                                   "compare what `lightcook reconstruct` writes",
                                   known->format->name));
    formats::LightMapDescription description;
    description.isCompressed = true;
    description.fireflyLimit = 0;
    return sources.open(file, description);
}

Json toJson(const verify::ErrorFigures& figures) {
    Json json = {{"rel_rms", figures.relRms}, {"p99", figures.p99}, {"max", figures.maxSampled}};
    if (const auto& visible = figures.visible)
        json["visible"] = {{"rms", visible->rms}, {"p50", visible->p50},   {"p95", visible->p95},
                           {"p99", visible->p99}, {"p999", visible->p999}, {"max", visible->max}};
    return json;
}

}  // namespace

bool isCertainLightMap(const std::filesystem::path& file) {
    const auto known = formats::LightMapReader::recognize(file, {});
    return known && known->isCertain;
}

Result<Json> compareLightMaps(const std::filesystem::path& a, const std::filesystem::path& b, const RunState& state) {
    LightMapSources sources;
    const auto reference = open(sources, a), found = open(sources, b);
    if (!reference) return tl::make_unexpected(reference.error());
    if (!found) return tl::make_unexpected(found.error());
    LightMapSource &bake = **reference, &other = **found;
    if (bake.width() != other.width() || bake.height() != other.height())
        return failure(ErrorCode::WrongShape, b.string(),
                       fmt::format("found {} x {} texels, expected {} x {} as in {}", other.width(), other.height(), bake.width(),
                                   bake.height(), a.string()));

    SharedObjects shared;
    const Action action{"compare", "compare", a.filename().string(), {}, {}, {}};
    const ActionContext context{action, {}, {}, {}, shared, state};
    const auto key = surveyKey(bake, context);
    if (!key) return tl::make_unexpected(key.error());
    if (key->coveredTexels() == 0)
        return failure(ErrorCode::WrongShape, a.string(), "found no covered texel, expected some: there is nothing to compare");
    const verify::Viewing viewing{lighting::DisplaySettings{}.of(key->displayKey()), bake.bt2020FromWorking()};
    const auto score = verify::LightMapScore::create({}, key->key(), viewing);
    if (!score) return tl::make_unexpected(score.error());
    verify::ShadedErrors errors;
    const auto scored = foldInOrder<verify::ShadedErrors>(
        bake.chunkCount(), context, fmt::format("compare {}", action.asset),
        [&](int index) -> Result<verify::ShadedErrors> {
            const auto expected = bake.chunk(index), result = other.chunk(index);
            if (!expected) return tl::make_unexpected(expected.error());
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

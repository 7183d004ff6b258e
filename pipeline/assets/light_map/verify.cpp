#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "pipeline/assets/light_map/checked_light_map.h"
#include "pipeline/assets/light_map/mesh_view.h"
#include "pipeline/assets/light_map/survey.h"
#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/assets/mesh/mesh_inputs.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Result;

/// Refuses a bake of another size.
Result<void> checkSize(const LightMapSource& bake, const std::filesystem::path& file, const glm::ivec2& size, const char* as) {
    if (glm::ivec2(bake.width(), bake.height()) == size) return {};
    return failure(ErrorCode::Verification, file,
                   fmt::format("found {} x {} texels, expected {} x {} as {}", bake.width(), bake.height(), size.x, size.y, as));
}

/// Returns the map's mesh; none without one, or where it cannot be read: the mesh's own actions refuse it.
/// places  of the light map
std::optional<formats::GltfScene> meshOf(const ActionContext& context, const std::vector<formats::NodePlace>& places) {
    const auto mesh = context.action.inputs.find(kSurfaceRole);
    if (mesh == context.action.inputs.end()) return std::nullopt;
    auto scene = loadMesh(context.action.inputs, kSurfaceRole, places);
    return scene ? std::optional(std::move(*scene)) : std::nullopt;
}

/// Opens the bake from before charts were packed. Empty where charts are those of the bake, and for a map of constant light.
Result<std::optional<BakeBefore>> openBakeBefore(const ActionContext& context, const formats::LightMapDescription& description) {
    LC_TRY(parameter, parametersOf<UnpackedParameter>(context));
    if (!parameter->unpacked || description.constantOf) return std::optional<BakeBefore>();
    UnpackedBake& unpacked = *parameter->unpacked;
    std::map<std::string, std::filesystem::path> inputs;
    for (const auto& [role, file] : context.action.inputs) {
        if (role == kUnpackedRole || role.starts_with(std::string(kUnpackedRole) + "-"))
            inputs[kSourceRole + role.substr(std::string_view(kUnpackedRole).size())] = file;
        if (!role.starts_with(kSourceRole) && !role.starts_with(kUnpackedRole)) inputs[role] = file;
    }
    const auto file = inputs.find(kSourceRole);
    if (file == inputs.end())
        return failure(ErrorCode::Verification, context.action.asset,
                       "found no bake from before its charts were packed, expected its file");
    LC_TRY(opened, context.shared.get<LightMapSources>().open(file->second, withFiles(unpacked.description, inputs)));
    LC_CHECK(checkSize(**opened, file->second, {unpacked.packing.widthBefore, unpacked.packing.heightBefore}, "packed"));
    return std::optional(BakeBefore{**opened, std::move(unpacked)});
}

Result<CheckedLightMap> openMap(const ActionContext& context) {
    const Stopwatch watch;
    LC_TRY(asset, upstreamAsset(context));
    LC_TRY(parameters, parametersOf<LightMapVerifyParameters>(context));
    LC_TRY(description, descriptionOf(*asset));
    LC_TRY(source, openLightMap(context, *description));
    LightMapSource& bake = **source;
    LC_CHECK(checkSize(bake, context.action.inputs.at(kSourceRole), {asset->width, asset->height}, "cooked"));
    LC_TRY(before, openBakeBefore(context, *description));
    LC_TRY(survey, (*before ? (*before)->source : bake).survey(context.between(0, kSurveyEnd)));
    LC_TRY(keys, keysOf(context.action.asset, parameters->kept, (*survey)->key));
    const double key = keys->key;
    const verify::Viewing viewing{parameters->display.of(keys->displayKey), bake.bt2020FromWorking()};
    verify::LightMapSampling sampling;
    sampling.placesPerTexel = parameters->samples;
    LC_TRY(cooked, CookedLightMapReader::open(context.upstreamFolder, *asset, {parameters->shading, sampling, key, viewing}));
    LC_TRY(truth, GroundTruth::open(context, bake, description->colors));
    auto mesh = meshOf(context, description->places);
    auto triangles = mesh ? litTriangles(*mesh) : std::vector<verify::SurfaceTriangle>();
    turn(triangles, description->outputAxes);
    // A map of constant light stands for texels that no chart names.
    auto charts = mesh && !bake.constantTexels() ? MapCharts::of(lightMapMeshes(*mesh), bake.width(), bake.height()) : std::nullopt;
    TexelErrors none{cooked->verifier().noErrors()};
    none.shown.preview = Preview(bake.width(), bake.height(), key);
    CheckedLightMap map{context,
                        watch,
                        std::move(*asset),
                        std::move(*parameters),
                        bake,
                        std::move(*before),
                        key,
                        viewing,
                        std::move(*cooked),
                        std::move(*truth),
                        mesh.has_value(),
                        std::move(triangles),
                        std::move(charts),
                        std::move(none)};
    map.result.key = key;
    return map;
}

/// Judges the stages by the limits, and adds to the violations.
Result<void> judgeStages(CheckedLightMap& map) {
    Verdict& verdict = map.result.verdict;
    verdict = judged(std::move(verdict.stages), map.parameters.limits, map.watch, std::move(verdict.violations)).verdict;
    return {};
}

/// A check, and whether a map has what it needs.
struct LightMapCheck {
    Result<void> (*run)(CheckedLightMap& map);
    bool (*isNeeded)(const CheckedLightMap& map) = [](const CheckedLightMap&) { return true; };
};
/// Returns true if filters may read past small charts of the mesh: those of a sampler.
bool mayReadPastCharts(const CheckedLightMap& map) {
    return map.charts && !map.before && map.asset.filter != formats::LightMapFilter::Decoded;
}
constexpr std::array kChecks = {
    LightMapCheck{checkTexels},
    LightMapCheck{checkPacking, [](const CheckedLightMap& map) { return map.before.has_value(); }},
    LightMapCheck{checkBlocks},
    LightMapCheck{checkResiduals},
    LightMapCheck{checkLayout},
    LightMapCheck{checkMips, [](const CheckedLightMap& map) { return map.mipCount() > 1; }},
    LightMapCheck{judgeStages},
    LightMapCheck{checkGroundTruth, [](const CheckedLightMap& map) { return !map.truth.isEmpty(); }},
    LightMapCheck{checkCharts, [](const CheckedLightMap& map) { return map.charts.has_value(); }},
    LightMapCheck{checkSmallCharts, mayReadPastCharts},
    LightMapCheck{drawWorstPlaces},
    LightMapCheck{checkSeams},
};

}  // namespace

Result<ActionOutcome> verifyLightMap(const ActionContext& context) {
    LC_TRY(map, openMap(context));
    for (const LightMapCheck& check : kChecks)
        if (check.isNeeded(*map)) LC_CHECK(check.run(*map));
    map->result.verdict.passed = passes(map->result);
    return outcomeWithPreview(std::move(map->result), map->texels.shown.preview, context, std::move(map->worstPlaces),
                              std::move(map->seamViews));
}

}  // namespace lightcook::pipeline

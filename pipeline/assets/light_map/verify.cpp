#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <string_view>
#include <utility>

#include "formats/light_map_layout.h"
#include "lighting/radiometry.h"
#include "lighting/sphere.h"
#include "pipeline/assets/light_map/block_errors.h"
#include "pipeline/assets/light_map/chart_errors.h"
#include "pipeline/assets/light_map/cooked_light_map.h"
#include "pipeline/assets/light_map/ground_truth.h"
#include "pipeline/assets/light_map/light_map.h"
#include "pipeline/assets/light_map/lit_row.h"
#include "pipeline/assets/light_map/mesh_view.h"
#include "pipeline/assets/light_map/mip_errors.h"
#include "pipeline/assets/light_map/seams.h"
#include "pipeline/assets/light_map/small_charts.h"
#include "pipeline/assets/light_map/survey.h"
#include "pipeline/assets/light_map/unpacked_errors.h"
#include "pipeline/assets/light_map/worst_places.h"
#include "pipeline/assets/lut/light_moments.h"
#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/assets/mesh/mesh_inputs.h"
#include "pipeline/assets/note_keys.h"
#include "pipeline/assets/preview.h"
#include "pipeline/assets/verification.h"
#include "pipeline/graph/parallel_for.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Result;

/// Returns true if a stage of a layout encodes what the stage before it leaves.
bool isResidual(std::string_view stage) {
    return stage == "stage 2" || stage.starts_with("residual ");
}

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

/// Errors and light of some strips.
struct LightMapPart {
    verify::LightMapErrors errors;
    WorstBlock block;
    std::vector<verify::LightMapTruthPlace> truthPlaces;
    LightMoments light;
    WorstTexels worst;
    ChartErrors charts;
    void merge(const LightMapPart& other) {
        errors.merge(other.errors);
        block.merge(other.block);
        light.merge(other.light);
        worst.merge(other.worst);
        charts.merge(other.charts);
        truthPlaces.insert(truthPlaces.end(), other.truthPlaces.begin(), other.truthPlaces.end());
    }
};

/// A cooked map beside its bake.
struct Comparison {
    LightMapSource& bake;
    const CookedLightMapReader& cooked;
    const GroundTruth& truth;
    verify::Viewing viewing;
    double key;
    std::optional<double> tilt;  ///< of normal maps [degrees]; empty: surfaces show light at their own normals alone
    const std::optional<MapCharts>& charts;
    Preview& preview;
};

/// Compares one strip of a cooked map with the bake.
Result<LightMapPart> compareStrip(const Comparison& comparison, int index) {
    const auto& [bake, cooked, truth, viewing, key, tilt, charts, preview] = comparison;
    LC_TRY(strip, readStrip(bake, cooked, index));
    const auto& [firstRow, rowCount, reference, texels, seen] = *strip;
    VisibleBlocks blocks(bake.width(), rowCount, firstRow);
    LightMoments light;
    LitRow lit(bake.width(), viewing);
    std::optional<NormalCap> cap;
    if (tilt) cap.emplace(*tilt, viewing);
    WorstTexels worst(bake.width(), firstRow, rowCount);
    ChartErrors chartErrors;
    const auto groups = charts ? charts->groupsOf(firstRow, rowCount) : formats::Image<std::uint8_t>();
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
                preview.set(x, firstRow + y, lit.reference(x), lit.found(x), lit.visible(x));
                worst.add(x, firstRow + y, lit.visible(x));
                blocks.add(x, firstRow + y, lit.visible(x));
                if (charts) chartErrors.add(groups.at(x, y), x, firstRow + y, lit.visible(x));
                if (cap && preview.shows(x, firstRow + y))
                    preview.setAtAnyNormal(x, firstRow + y, cap->worst(reference.sh.at(x, y), seen.at(x, y), reference.normal.at(x, y)));
            }
    }
    LC_TRY(traced, truth.within(reference, firstRow, rowCount));
    LC_CHECK(blocks.addRims(bake, cooked, *strip, viewing, key));
    WorstBlock block;
    block.merge(blocks);
    return LightMapPart{cooked.verifier().verifyRows(texels, reference, firstRow, rowCount),
                        block,
                        lightMapPlaces(*traced, reference, seen, firstRow),
                        light,
                        worst,
                        std::move(chartErrors)};
}

/// Opens the bake of a cooked map, and refuses one of another size.
Result<LightMapSource*> openBake(const ActionContext& context, const CookedAsset& asset, const formats::LightMapDescription& description) {
    LC_TRY(source, openLightMap(context, description));
    if ((*source)->width() != asset.width || (*source)->height() != asset.height)
        return failure(ErrorCode::Verification, context.action.inputs.at("source"),
                       fmt::format("found {} x {} texels, expected {} x {} as cooked", (*source)->width(), (*source)->height(), asset.width,
                                   asset.height));
    return source;
}

/// Returns the error that the codes of a residual stage have beside a first stage that is exact. No code of halo3's second texture leaves
/// the first one as it is: the nearest to 1/2 are half a step of 8 bits away, of a residual from -1 to 1 in units of coefficient 0. Over
/// all directions, nine coefficients of an orthonormal basis that are off by half a step each miss by three of them.
double roundingOfResidual(const std::string& name) {
    const auto layout = formats::lightMapLayoutFromName(name);
    const bool isHalo3 = layout && formats::info(*layout).family == formats::LightMapFamily::Halo3;
    constexpr double kHalfStep = 1.0 / 255;
    constexpr double kFirstStage = kHalfStep;  // that is not exact: light of one colour has 0.0122 where 3 half steps are 0.0118
    return isHalo3 ? 3 * kHalfStep + kFirstStage : 0;
}

/// Returns true if stage `after` was measured on the surface, and does not add to the error of stage `before` there: a residual that is
/// fitted to the places between texels need not be right at texel centres.
bool isRightOnSurface(const std::vector<verify::LightMapErrors::Stage>& stages, const std::string& before, const std::string& after) {
    const auto first = std::ranges::find(stages, before, &verify::LightMapErrors::Stage::name);
    const auto second = std::ranges::find(stages, after, &verify::LightMapErrors::Stage::name);
    if (first == stages.end() || second == stages.end() || !(second->surface.reference > 0)) return false;
    return !addsError(first->surface.relRms(), second->surface.relRms());
}

/// Returns the faults of a map: a block that lost its light, or a residual stage that adds to the error both at texel centres and on the
/// surface.
std::vector<verify::Violation> violationsOf(const MippedLightMap& map, const LightMapPart& whole,
                                            const std::vector<verify::StageError>& stages) {
    std::vector<verify::Violation> violations;
    whole.block.check("", map.parameters.limits, stages.back(), violations);
    for (std::size_t i = 1; i < stages.size(); ++i) {
        const std::string &before = stages[i - 1].name, &after = stages[i].name;
        if (isResidual(after) && !isRightOnSurface(whole.errors.stages, before, after))
            checkStage(stages, before, after, roundingOfResidual(map.asset.layout), violations);
    }
    return violations;
}

/// Returns the map's mesh; none without one, or where it cannot be read: the mesh's own actions refuse it.
/// places  of the light map
std::optional<formats::GltfScene> meshOf(const ActionContext& context, const std::vector<formats::NodePlace>& places) {
    const auto mesh = context.action.inputs.find(kSurfaceRole);
    if (mesh == context.action.inputs.end()) return std::nullopt;
    auto scene = loadMesh(context.action.inputs, kSurfaceRole, places);
    return scene ? std::optional(std::move(*scene)) : std::nullopt;
}

/// Returns the tilt of the normal maps whose errors a map is compared under [degrees]. Empty: surfaces show light at their own normals
/// alone.
std::optional<double> comparedTilt(const verify::LightMapShading& shading, bool isFlat) {
    const bool hasNormalMaps = shading.normalCount > 1 && shading.normalMapTilt > 0 && !isFlat;
    return hasNormalMaps ? std::optional(shading.normalMapTilt) : std::nullopt;
}

/// Adds the seams of a surface with one light map to its result. Under a limit, seams that cannot be measured are a violation.
/// hasMesh  see measureSeams
Result<void> addSeams(const LitSurface& surface, bool hasMesh, VerifyResult& result, const ActionContext& context) {
    LC_TRY(seams, measureSeams(surface, hasMesh, context));
    const bool isConstant = surface.maps.front().bake.constantTexels().has_value();
    if (isConstant) seams->note = "all texels hold the same light: no edge can have a step";
    if (result.verdict.limits[Limit::Seam] && seams->isUnmeasured() && !isConstant)
        result.verdict.violations.push_back({"seams", *seams->note,
                                             seams->edges > 0 ? "coverage that reaches the edges of charts: max_seam limits the steps there"
                                                              : "a mesh with light-map UVs: max_seam limits the steps at its edges"});
    result.seams = std::move(*seams);
    return {};
}

/// Adds the verdict against the bake from before its charts were packed. Where charts were moved only, the light of the repacked bake at
/// every place of the surface is that of the bake, and so are the bounds, also at the bake's texels. Else nothing bounds the errors against
/// the bake (docs/guide/memory-budgets.md).
void addUnpackedStage(std::vector<verify::StageError>& stages, verify::StageError total, bool isMovedOnly) {
    verify::StageError& repacked = stages.back();
    const auto takeBound = [&](verify::ErrorFigures& figures, const verify::ErrorFigures& known) {
        figures.maxBound = isMovedOnly ? known.maxBound : std::nullopt;
    };
    const auto takeBounds = [&](verify::ErrorFigures& figures, const verify::ErrorFigures& known) {
        takeBound(figures, known);
        if (isMovedOnly && figures.visible && known.visible) figures.visible->bound = known.visible->bound;
    };
    takeBounds(total.diffuse, repacked.diffuse);
    takeBounds(total.specular, repacked.specular);
    if (total.atTexels) {
        takeBound(total.atTexels->diffuse, repacked.diffuse);
        takeBound(total.atTexels->specular, repacked.specular);
    }
    total.name = std::exchange(repacked.name, kRepackedStage);
    stages.push_back(std::move(total));
}

/// Adds a violation to a map over its limit whose layout lacks light that the materials need.
void checkLayout(const std::string& name, const verify::LightMapShading& shading, const verify::StageError& total, const Limits& limits,
                 std::vector<verify::Violation>& violations) {
    const auto layout = formats::lightMapLayoutFromName(name);
    const std::vector<Figure> errors = {{Limit::Error, std::max(total.diffuse.relRms, total.specular.relRms), "", ""}};
    if (!layout || areKept(judge(errors, limits)) || !shading.needsDirections()) return;
    const std::string lacks(formats::info(*layout).lacks);
    if (lacks.empty()) return;
    violations.insert(violations.begin(),
                      {fmt::format("layout {}", name), fmt::format("a layout without {}", lacks),
                       "a layout that has it, or materials that do not need it (normal_map = false, specular = false)"});
}

/// The bake from before its charts were packed. The verdict on a repacked map is against it, and so are key and display.
struct BakeBefore {
    LightMapSource& source;
    UnpackedBake unpacked;
};
/// Opens it. Empty where charts are those of the bake, and for a map of constant light.
Result<std::optional<BakeBefore>> openBakeBefore(const ActionContext& context, const formats::LightMapDescription& description) {
    LC_TRY(parameter, parametersOf<UnpackedParameter>(context));
    if (!parameter->unpacked || description.constantOf) return std::optional<BakeBefore>();
    LC_TRY(source, openUnpacked(*parameter->unpacked, context));
    return std::optional(BakeBefore{**source, std::move(*parameter->unpacked)});
}

/// Compares all strips of a cooked map with the bake.
Result<LightMapPart> compareStrips(const Comparison& comparison, const ActionContext& context) {
    LightMapPart whole{comparison.cooked.verifier().noErrors(), {}, {}, {}, {}, {}};
    const auto compared = foldInOrder<LightMapPart>(
        comparison.bake.stripCount(), context, "verify " + context.action.asset, [&](int index) { return compareStrip(comparison, index); },
        [&](const LightMapPart& part) { whole.merge(part); });
    if (!compared) return tl::make_unexpected(compared.error());
    return whole;
}

/// Returns the verdict on a map: on its stages, with that against the bake from before packing, and on its mip levels.
Result<VerifyResult> judgeMap(const MippedLightMap& map, const LightMapPart& whole, const std::optional<BakeBefore>& before,
                              const CookedLightMapReader& cooked, const Stopwatch& watch, const ActionContext& context) {
    const LightMapVerifyParameters& parameters = map.parameters;
    std::vector<verify::StageError> stages = whole.errors.figures();
    Json measures;
    if (before) {
        LC_TRY(errors, unpackedErrors({before->source, map.bake, map.key, map.viewing}, before->unpacked, parameters, cooked, context));
        measures = {{note_keys::kUnreadTexels, errors->unreadTexels}};
        addUnpackedStage(stages, std::move(errors->total), before->unpacked.packing.reducedCharts == 0);
    }
    auto violations = violationsOf(map, whole, stages);
    checkLayout(map.asset.layout, parameters.shading, stages.back(), parameters.limits, violations);
    LC_TRY(mips, mipErrors(map, cooked, violations, context));
    VerifyResult result = judged(stages, parameters.limits, watch, std::move(violations));
    if (whole.block.figures().isKnown()) result.worstBlock = whole.block.figures();
    result.key = map.key;
    result.mips = std::move(mips->levels);
    result.mipBlends = std::move(mips->blends);
    if (!measures.is_null()) result.measures = std::move(measures);
    result.light = lightOf(map.bake, whole.errors, map.key, whole.light);
    return result;
}

}  // namespace

Result<ActionOutcome> verifyLightMap(const ActionContext& context) {
    const Stopwatch watch;
    LC_TRY(asset, upstreamAsset(context));
    LC_TRY(parameters, parametersOf<LightMapVerifyParameters>(context));
    LC_TRY(description, descriptionOf(*asset));
    LC_TRY(source, openBake(context, *asset, *description));
    LightMapSource& bake = **source;
    LC_TRY(before, openBakeBefore(context, *description));
    LC_TRY(surveyed, surveyKey(*before ? (*before)->source : bake, context));
    const double key = surveyed->key();
    const verify::Viewing viewing{parameters->display.of(surveyed->displayKey()), bake.bt2020FromWorking()};
    verify::LightMapSampling sampling;
    sampling.placesPerTexel = parameters->samples;
    LC_TRY(cooked, CookedLightMapReader::open(context.upstreamFolder, *asset, {parameters->shading, sampling, key, viewing}));
    LC_TRY(truth, GroundTruth::open(context, bake, description->colors));

    Preview preview(bake.width(), bake.height(), key);
    const auto mesh = meshOf(context, description->places);
    // A map of constant light stands for texels that no chart names.
    const auto charts = mesh && !bake.constantTexels() ? MapCharts::of(lightMapMeshes(*mesh), bake.width(), bake.height()) : std::nullopt;
    const auto tilt = comparedTilt(parameters->shading, formats::isFlat(asset->layout));
    LC_TRY(whole, compareStrips({bake, *cooked, *truth, viewing, key, tilt, charts, preview}, context));

    const MippedLightMap map{context.upstreamFolder, *asset, bake, *parameters, key, viewing};
    LC_TRY(result, judgeMap(map, *whole, *before, *cooked, watch, context));
    if (!truth->isEmpty()) result->groundTruth = toJson(verify::lightMapTruth(whole->truthPlaces, parameters->shading.lobe, viewing));
    if (charts) result->charts = whole->charts.summary(*charts, asset->totalBytesGpu(), std::int64_t{bake.width()} * bake.height());
    const auto triangles = mesh ? litTriangles(*mesh) : std::vector<verify::SurfaceTriangle>();
    // The triangles are those of the cooked mesh. The places of the last stage lie in the bake as it was before charts were packed.
    if (charts && !*before) result->charts->few = fewTexelsOf(result->verdict.stages.back(), triangles, {bake.width(), bake.height()});
    const std::array maps = {ComparedMap{context.action.asset, bake, *cooked}};
    const LitSurface surface{maps, triangles, viewing};
    LC_TRY(pictures, writeWorstPlaces(whole->worst, surface, context));
    LC_CHECK(addSeams(surface, mesh.has_value(), *result, context));
    result->verdict.passed = passes(*result);
    LC_TRY(seamViews, writeSeamViews(*result->seams, surface, context, context.action.asset + "_seam"));
    return outcomeWithPreview(std::move(*result), preview, context, std::move(*pictures), std::move(*seamViews));
}

}  // namespace lightcook::pipeline

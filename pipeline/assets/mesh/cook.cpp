#include "pipeline/assets/mesh/mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "formats/gltf_scene.h"
#include "pipeline/assets/light_map/light_map.h"
#include "pipeline/assets/preview.h"
#include "pipeline/assets/verdict.h"
#include "pipeline/assets/verification.h"
#include "pipeline/graph/parallel_for.h"
#include "verify/mesh.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

/// Bytes of GPU memory that the light map asks of a vertex: two 16-bit UVs.
constexpr std::int64_t kLightMapUvBytes = 4, kFloatUvBytes = 8;
constexpr std::int64_t kBasisBytes = 4;  ///< one that counts, and what glTF pads it with

Json toJson(const formats::MaterialNeeds& material) {
    return {{"name", material.name},
            {"normal_map", material.hasNormalMap},
            {"specular", material.isSpecular},
            {"m", {material.mMin, material.mMax}},
            {"f0", {material.f0Min, material.f0Max}}};
}

Json toJson(const formats::DracoOptions& options) {
    return {{"position_bits", options.positionBits},
            {"normal_bits", options.normalBits},
            {"uv_bits", options.uvBits},
            {"light_map_uv_bits", options.lightMapUvBits}};
}

/// The clusters of a light map with learned bases, from its manifest entry.
Result<formats::ClusterMap> clusterMapOf(const Json& lightMap) {
    const auto runs = lightMap.at("constants").at("index_runs").get<std::vector<float>>();
    auto map = formats::ClusterMap::fromRuns(lightMap.at("width").get<int>(), lightMap.at("height").get<int>(), runs);
    if (!map)
        return formats::failure(formats::ErrorCode::Verification, lightMap.at("name").get<std::string>() + ", constant index_runs",
                                map.error());
    return std::move(*map);
}

/// What the manifest says of the cluster that each vertex bears; absent where the light map has no learned bases.
Json basisEntry(const Json& lightMap) {
    return {{"attribute", formats::kBasisAttribute}, {"light_map", lightMap.at("name")}};
}

Result<verify::CoveredTexels> coverageOf(LightMapSource& bake, const ActionContext& context) {
    verify::CoveredTexels covered(bake.width(), bake.height());
    const auto walked = forEachBand<int>(bake.bandCount(), context, "survey " + context.action.asset, [&](int index) -> Result<int> {
        const auto band = bake.band(index);
        if (!band) return tl::make_unexpected(band.error());
        covered.add(**band, (*band)->firstRow, bake.bandRows(index));
        return 0;
    });
    if (!walked) return tl::make_unexpected(walked.error());
    return covered;
}

/// uvShift  how far quantization moved light-map UVs [UV units]
Result<void> verifyClusters(const ActionContext& context, const formats::GltfScene& cooked, double uvShift, LightMapSource& bake) {
    const Json& mesh = context.upstream.at(0)->result.at("asset");
    const Json& lightMap = context.upstream.at(1)->result.at("asset");
    if (lightMap.at("width") != bake.width() || lightMap.at("height") != bake.height())
        return formats::failure(formats::ErrorCode::Verification, context.action.inputs.at("source").string(),
                                fmt::format("found {} x {} texels, expected {} x {} as cooked", bake.width(), bake.height(),
                                            lightMap.at("width").dump(), lightMap.at("height").dump()));
    const auto map = clusterMapOf(lightMap);
    if (!map) return tl::make_unexpected(map.error());
    const auto covered = coverageOf(bake, context);
    if (!covered) return tl::make_unexpected(covered.error());
    constexpr double kRounding = 1e-2;  // of edges, beside what quantization moved
    const double inset = uvShift * std::max(map->width, map->height) + kRounding;
    for (const formats::TriangleMesh* primitive : cooked.triangleMeshes())
        if (const auto mistake = verify::clusterMistake(*primitive, *map, *covered, inset))
            return formats::failure(formats::ErrorCode::Verification, mesh.at("file").get<std::string>(), *mistake);
    return {};
}

/// Of a lattice with so many bits a component.
double latticeSteps(int bits) {
    return std::exp2(bits) - 1;
}
/// How far quantization moves at most, in steps of the lattice: half a step of each component, and rounding. The octahedral map stretches
/// the steps of its square unevenly: normals of the public scenes stay under 4.2 of them [radians].
constexpr double kSlack = 1.01, kUvSteps = kSlack * 0.5 * std::numbers::sqrt2, kNormalSteps = kSlack * 6;

/// How much of the scene's limit a mesh may use up: its error comes on top of the light map's.
constexpr double kShareOfLimit = 0.1;
/// Light-map UVs stay well inside their texel.
constexpr double kMostTexels = 0.25;

struct ChosenBits {
    formats::DracoOptions options;
    double bound = 0;  ///< of rel_rms
};

/// The least bits whose bound keeps the limit, UVs and normals weighed alike; the finest if none does.
ChosenBits chooseBits(const verify::MeshShiftBound& bound, double uvExtent, double texels, double limit) {
    constexpr int kFewestUv = 8, kMostUv = 16, kFewestNormal = 6, kMostNormal = 14;
    const auto shiftOf = [&](int uvBits, int normalBits) {
        const double uv = uvExtent * texels * kUvSteps / latticeSteps(uvBits);
        return verify::MeshShift{uv, uv, kNormalSteps / latticeSteps(normalBits)};
    };
    ChosenBits chosen;
    chosen.options.lightMapUvBits = kMostUv;
    chosen.options.normalBits = kMostNormal;
    chosen.bound = bound.relRms(shiftOf(kMostUv, kMostNormal));
    for (int uv = kFewestUv; uv <= kMostUv; ++uv)
        for (int normal = kFewestNormal; normal <= kMostNormal; ++normal) {
            const verify::MeshShift shift = shiftOf(uv, normal);
            const double found = bound.relRms(shift);
            if (found > limit || shift.uTexels > kMostTexels) continue;
            const int bits = uv + normal, fewest = chosen.options.lightMapUvBits + chosen.options.normalBits;
            if (bits > fewest || (bits == fewest && found >= chosen.bound)) continue;
            chosen.options.lightMapUvBits = uv;
            chosen.options.normalBits = normal;
            chosen.bound = found;
        }
    return chosen;
}

Result<ChosenBits> bitsFor(const formats::GltfScene& scene, const ActionContext& context) {
    const Json& parameters = context.action.parameters;
    const auto bake = openLightMap(context, parameters.at("description"));
    if (!bake) return tl::make_unexpected(bake.error());
    const auto extent = scene.errorOf(scene);
    if (!extent) return tl::make_unexpected(extent.error());
    verify::MeshShiftBound bound;
    const auto surveyed = foldBands<verify::MeshShiftBound>((*bake)->stripCount(), context, "survey " + context.action.asset,
                                                            [&](int index) -> Result<verify::MeshShiftBound> {
                                                                const auto band = (*bake)->stripWithMargin(index, 0, 1);
                                                                if (!band) return tl::make_unexpected(band.error());
                                                                verify::MeshShiftBound part;
                                                                part.add(*band, (*bake)->stripFirstRow(index), (*bake)->stripRows(index));
                                                                return part;
                                                            },
                                                            [&](const verify::MeshShiftBound& part) { bound.merge(part); });
    if (!surveyed) return tl::make_unexpected(surveyed.error());
    return chooseBits(bound, extent->lightMapUvExtent, std::max((*bake)->width(), (*bake)->height()),
                      kShareOfLimit * parameters.at("max_error").get<double>());
}

/// Vertices lie no farther from their source than half a step of the lattice that the manifest names, where it names none not at all, and
/// light-map UVs stay in their texel: beyond that another chart may begin, and the gradient that tells the error says nothing.
std::vector<verify::Violation> brokenLaws(const formats::MeshError& moved, const verify::MeshShift& shift, const Json& quantization) {
    std::vector<verify::Violation> violations;
    const auto expect = [&](const char* place, const std::string& unit, double found, double allowed, const std::string& why) {
        if (found > allowed)
            violations.push_back(
                {place, fmt::format("{:.4g} {} from the source", found, unit), fmt::format("at most {:.4g}{}", allowed, why)});
    };
    constexpr double kFloats = 1e-6;
    // stepsAllowed  of a lattice that divides the extent
    const auto expectWithinBits = [&](const char* place, const std::string& unit, double found, double extent, const char* bits,
                                      double stepsAllowed) {
        const int count = quantization.value(bits, 0);
        const double share = count > 0 ? stepsAllowed / latticeSteps(count) : 0;
        expect(place, unit, found, extent * (share + kFloats), count > 0 ? fmt::format(" with {} bits", count) : ": not quantized");
    };
    expectWithinBits("positions", "scene units", moved.position, moved.positionExtent, "position_bits", kSlack * 0.5 * std::sqrt(3.0));
    expectWithinBits("light-map UVs", "of their range", moved.lightMapUv, moved.lightMapUvExtent, "light_map_uv_bits", kUvSteps);
    expectWithinBits("normals", "radians", moved.normalRadians, 1, "normal_bits", kNormalSteps);
    expect("light-map UVs", "texels", std::max(shift.uTexels, shift.vTexels), 0.5, " texels");
    return violations;
}

}  // namespace

Result<ActionOutcome> readMaterials(const ActionContext& context) {
    const auto scene = formats::GltfScene::load(context.action.inputs.at(kMeshRole));
    if (!scene) return tl::make_unexpected(scene.error());
    ActionOutcome outcome;
    std::size_t vertices = 0;
    for (const formats::TriangleMesh* primitive : scene->triangleMeshes()) vertices += primitive->vertexCount();
    outcome.result["most_bytes_gpu"] = static_cast<std::int64_t>(vertices) * (kFloatUvBytes + kBasisBytes);
    outcome.result["materials"] = Json::array();
    for (const formats::MaterialNeeds& material : scene->materials()) outcome.result["materials"].push_back(toJson(material));
    return outcome;
}

Result<ActionOutcome> cookMesh(const ActionContext& context) {
    const auto& source = context.action.inputs.at(kMeshRole);
    const auto scene = formats::GltfScene::load(source);
    if (!scene) return tl::make_unexpected(scene.error());
    if (!scene->hasLightMapUvs())
        return formats::failure(formats::ErrorCode::WrongShape, source.string(),
                                "found a primitive without TEXCOORD_1, expected light-map UVs on every primitive");
    std::optional<formats::ClusterMap> clusters;
    if (!context.upstream.empty()) {
        auto map = clusterMapOf(context.upstream[0]->result.at("asset"));
        if (!map) return tl::make_unexpected(map.error());
        clusters = std::move(*map);
    }
    const bool isDraco = context.action.parameters.at("draco").get<bool>();
    ChosenBits bits;
    if (isDraco) {
        const auto chosen = bitsFor(*scene, context);
        if (!chosen) return tl::make_unexpected(chosen.error());
        bits = *chosen;
    }
    const std::string file = context.action.asset + ".glb";
    const formats::ClusterMap* given = clusters ? &*clusters : nullptr;
    const auto size =
        isDraco ? scene->writeDraco(context.folder / file, bits.options, given) : scene->writePlain(context.folder / file, given);
    if (!size) return tl::make_unexpected(size.error());
    ActionOutcome outcome;
    outcome.files = {file};
    outcome.result["asset"] = {
        {"name", context.action.asset},
        {"kind", "mesh"},
        {"layout", isDraco ? "glb-draco" : "glb"},
        {"width", 0},
        {"height", 0},
        {"file", file},
        {"bytes_gpu", size->vertexCount * ((isDraco ? kLightMapUvBytes : kFloatUvBytes) + (clusters ? kBasisBytes : 0))},
        {"bytes_disk", size->fileBytesOut},
        {"vertices", size->vertexCount},
        {"triangles", size->triangleCount},
        {"quantization", isDraco ? toJson(bits.options) : Json::object()},
        {"textures", Json::array()},
        {"source", {{"description", context.action.parameters.at("description")}}}};
    if (clusters) outcome.result["asset"]["basis"] = basisEntry(context.upstream[0]->result.at("asset"));
    outcome.result["bytes_in"] = size->fileBytesIn;
    if (isDraco)
        outcome.result["notes"] = {
            {"light_map_uv_bits", bits.options.lightMapUvBits}, {"normal_bits", bits.options.normalBits}, {"bound_of_rel_rms", bits.bound}};
    return outcome;
}

Result<ActionOutcome> verifyMesh(const ActionContext& context) {
    const Json& asset = context.upstream.at(0)->result.at("asset");
    const auto source = formats::GltfScene::load(context.action.inputs.at(kMeshRole));
    if (!source) return tl::make_unexpected(source.error());
    const auto cooked = formats::GltfScene::load(context.upstreamFolder / asset.at("file").get<std::string>());
    if (!cooked) return tl::make_unexpected(cooked.error());
    const auto moved = source->errorOf(*cooked);
    if (!moved) return tl::make_unexpected(moved.error());
    const auto opened = openLightMap(context, asset.at("source").at("description"));
    if (!opened) return tl::make_unexpected(opened.error());
    LightMapSource& bake = **opened;
    if (asset.contains("basis"))
        if (auto same = verifyClusters(context, *cooked, moved->lightMapUv, bake); !same) return tl::make_unexpected(same.error());
    const auto surveyed = surveyKey(bake, context);
    if (!surveyed) return tl::make_unexpected(surveyed.error());
    const double key = *surveyed;
    const verify::MeshShift shift{moved->lightMapUv * bake.width(), moved->lightMapUv * bake.height(), moved->normalRadians};
    using verify::ErrorAccumulator;
    ErrorAccumulator errors(key);
    Preview preview(bake.width(), bake.height(), key);  // over the light map: where what quantization moved is seen
    const auto verified = foldBands<ErrorAccumulator>(
        bake.stripCount(), context, "verify " + context.action.asset,
        [&](int index) -> Result<ErrorAccumulator> {
            const auto band = bake.stripWithMargin(index, 0, 1);
            if (!band) return tl::make_unexpected(band.error());
            ErrorAccumulator part(key);
            verify::addMeshShiftErrors(*band, bake.stripFirstRow(index), bake.stripRows(index), shift, key, part,
                                       [&](int x, int y, const glm::vec3& lit, const glm::vec3& seen) { preview.set(x, y, lit, seen); });
            return part;
        },
        [&](const ErrorAccumulator& part) { errors.merge(part); });
    if (!verified) return tl::make_unexpected(verified.error());
    verify::StageError stage;
    stage.name = "quantize";
    stage.diffuse = errors.figures();
    ActionOutcome outcome;
    outcome.result["verdict"] = verdict({stage}, maxErrorOf(context), brokenLaws(*moved, shift, asset.at("quantization")));
    outcome.result["light"] = {{"diffuse_rms", errors.referenceRms()}};
    outcome.result["mesh_error"] = {
        {"position", moved->position}, {"normal_radians", moved->normalRadians}, {"light_map_uv", moved->lightMapUv}};
    if (auto written = preview.write(context.folder, context.action.asset, outcome); !written) return tl::make_unexpected(written.error());
    return outcome;
}

}  // namespace lightcook::pipeline

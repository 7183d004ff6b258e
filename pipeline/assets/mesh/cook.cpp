#include <algorithm>
#include <cmath>
#include <optional>

#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/assets/mesh/quantization.h"
#include "pipeline/assets/results.h"
#include "pipeline/graph/parallel_for.h"
#include "verify/mesh.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

/// GPU memory of a vertex for its light-map UV [bytes]: two 16-bit numbers, or two floats.
constexpr std::uint64_t kLightMapUvBytes = 4, kFloatUvBytes = 8;

/// Part of the scene's limit that a mesh may use: its error adds to that of the light map.
constexpr double kShareOfLimit = 0.1;
/// Largest distance of a light-map UV, well inside its texel.
constexpr double kMostTexels = 0.25;

struct ChosenBits {
    formats::DracoOptions options;
    double bound = 0;  ///< of rel_rms
};

/// Returns the fewest bits of UVs and normals together whose bound keeps the limit; the finest lattice if none does.
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

/// Chooses the bits for a mesh from the gradients of its light map.
Result<ChosenBits> bitsFor(const formats::GltfScene& scene, const MeshParameters& parameters, const ActionContext& context) {
    const auto opened = openLightMap(context, parameters.description);
    if (!opened) return tl::make_unexpected(opened.error());
    LightMapSource& bake = **opened;
    const auto extent = scene.errorOf(scene);
    if (!extent) return tl::make_unexpected(extent.error());
    const auto boundStrip = [&](int index) -> Result<verify::MeshShiftBound> {
        const auto strip = bake.stripWithMargin(index, 0, 1);
        if (!strip) return tl::make_unexpected(strip.error());
        verify::MeshShiftBound part;
        part.add(*strip, bake.stripFirstRow(index), bake.stripRows(index));
        return part;
    };
    verify::MeshShiftBound bound;
    const auto surveyed = foldInOrder<verify::MeshShiftBound>(bake.stripCount(), context, "survey " + context.action.asset, boundStrip,
                                                              [&](const verify::MeshShiftBound& part) { bound.merge(part); });
    if (!surveyed) return tl::make_unexpected(surveyed.error());
    return chooseBits(bound, extent->lightMapUvExtent, std::max(bake.width(), bake.height()), kShareOfLimit * parameters.maxError);
}

/// Returns the clusters of the light map that the mesh depends on, or nothing without learned bases.
Result<std::optional<formats::ClusterMap>> upstreamClusters(const ActionContext& context) {
    if (context.upstream.empty()) return std::optional<formats::ClusterMap>();
    const auto lightMap = upstreamAsset(context);
    if (!lightMap) return tl::make_unexpected(lightMap.error());
    if (!hasClustersInMesh(*lightMap)) return std::optional<formats::ClusterMap>();
    auto map = clusterMapOf(*lightMap);
    if (!map) return tl::make_unexpected(map.error());
    return std::optional(std::move(*map));
}

CookedAsset manifestEntry(const ActionContext& context, const MeshParameters& parameters, const std::string& file,
                          const formats::MeshSize& size, const formats::DracoOptions& bits, bool hasClusters) {
    CookedAsset asset = makeCookedAsset(context.action.asset, AssetKind::Mesh, parameters.draco ? "glb-draco" : "glb", 0, 0);
    asset.file = file;
    asset.lightMap = parameters.lightMap;
    asset.bytesGpu = size.vertexCount * ((parameters.draco ? kLightMapUvBytes : kFloatUvBytes) + (hasClusters ? kBasisBytes : 0));
    asset.bytesDisk = size.fileBytesOut;
    asset.vertices = size.vertexCount;
    asset.triangles = size.triangleCount;
    asset.quantization.emplace();
    if (parameters.draco) asset.quantization = {bits.positionBits, bits.normalBits, bits.uvBits, bits.lightMapUvBits};
    asset.source.description = toJson(parameters.description);
    return asset;
}

}  // namespace

bool hasClustersInMesh(const CookedAsset& lightMap) {
    return lightMap.constants && lightMap.constants->is_object() && lightMap.constants->contains(kIndexRuns);
}

Result<formats::ClusterMap> clusterMapOf(const CookedAsset& lightMap) {
    const std::string place = lightMap.name + ", constants";
    const Json constants = lightMap.constants.value_or(Json());
    const auto runs = checkedJson(constants, place, [](const JsonPlace& root) {
        std::vector<float> values;
        readValue(root[kIndexRuns], values, {});
        return values;
    });
    if (!runs) return tl::make_unexpected(runs.error());
    auto map = formats::ClusterMap::fromRuns(lightMap.width, lightMap.height, *runs);
    if (!map) return formats::failure(formats::ErrorCode::Verification, lightMap.name + ", constant index_runs", map.error());
    return std::move(*map);
}

Result<ActionOutcome> readMaterials(const ActionContext& context) {
    const auto scene = formats::GltfScene::load(context.action.inputs.at(kMeshRole));
    if (!scene) return tl::make_unexpected(scene.error());
    std::size_t vertices = 0;
    for (const formats::TriangleMesh* primitive : scene->triangleMeshes()) vertices += primitive->vertexCount();
    MaterialsResult result;
    result.mostBytesGpu = vertices * kFloatUvBytes;
    for (const formats::MaterialNeeds& material : scene->materials())
        result.materials.push_back(
            {material.name, material.hasNormalMap, material.isSpecular, {material.mMin, material.mMax}, {material.f0Min, material.f0Max}});
    return outcomeWith(result);
}

Result<ActionOutcome> cookMesh(const ActionContext& context) {
    const auto parameters = parametersOf<MeshParameters>(context);
    if (!parameters) return tl::make_unexpected(parameters.error());
    const auto& source = context.action.inputs.at(kMeshRole);
    const auto scene = formats::GltfScene::load(source);
    if (!scene) return tl::make_unexpected(scene.error());
    if (!scene->hasLightMapUvs())
        return formats::failure(formats::ErrorCode::WrongShape, source.string(),
                                "found a primitive without TEXCOORD_1, expected light-map UVs on every primitive");
    const auto clusters = upstreamClusters(context);
    if (!clusters) return tl::make_unexpected(clusters.error());
    ChosenBits bits;
    if (parameters->draco) {
        const auto chosen = bitsFor(*scene, *parameters, context);
        if (!chosen) return tl::make_unexpected(chosen.error());
        bits = *chosen;
    }
    const std::string file = context.action.asset + ".glb";
    const formats::ClusterMap* given = *clusters ? &**clusters : nullptr;
    const auto size =
        parameters->draco ? scene->writeDraco(context.folder / file, bits.options, given) : scene->writePlain(context.folder / file, given);
    if (!size) return tl::make_unexpected(size.error());

    CookResult result{manifestEntry(context, *parameters, file, *size, bits.options, given != nullptr), size->fileBytesIn, {}};
    if (given != nullptr) {
        const auto lightMap = upstreamAsset(context);
        if (!lightMap) return tl::make_unexpected(lightMap.error());
        result.asset.basis = {formats::kBasisAttribute, lightMap->name};
    }
    if (parameters->draco)
        result.notes = {
            {"light_map_uv_bits", bits.options.lightMapUvBits}, {"normal_bits", bits.options.normalBits}, {"bound_of_rel_rms", bits.bound}};
    return outcomeWith(result, {file});
}

}  // namespace lightcook::pipeline

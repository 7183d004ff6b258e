#include <fmt/format.h>

#include <optional>

#include "pipeline/assets/mesh/bit_choice.h"
#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/assets/mesh/mesh_inputs.h"
#include "pipeline/assets/note_keys.h"
#include "pipeline/assets/results.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

/// Returns the clusters of the light map that the mesh depends on, or nothing without learned bases.
Result<std::optional<formats::ClusterMap>> upstreamClusters(const ActionContext& context) {
    if (context.upstream.empty()) return std::optional<formats::ClusterMap>();
    LC_TRY(lightMap, upstreamAsset(context));
    if (!hasClustersInMesh(*lightMap)) return std::optional<formats::ClusterMap>();
    LC_TRY(map, clusterMapOf(*lightMap));
    return std::optional(std::move(*map));
}

CookedAsset manifestEntry(const ActionContext& context, const MeshParameters& parameters, const std::string& file,
                          const formats::MeshSize& size, const formats::DracoOptions& bits, bool hasClusters) {
    CookedAsset asset = makeCookedAsset(context.action.asset, AssetKind::Mesh, parameters.draco ? kDracoMeshLayout : "glb", 0, 0);
    asset.file = file;
    asset.lightMap = parameters.lightMap;
    // Lines and points have no light map.
    asset.bytesGpu = size.triangleVertexCount * bytesOfVertex(parameters.draco, hasClusters);
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
    LC_TRY(scene, loadMesh(context.action.inputs, kMeshRole, {}));
    MaterialsResult result;
    for (const formats::TriangleMesh* primitive : scene->triangleMeshes()) result.mostVertices += primitive->vertexCount();
    for (const formats::MaterialNeeds& material : scene->materials())
        result.materials.push_back(
            {material.name, material.hasNormalMap, material.isSpecular, {material.mMin, material.mMax}, {material.f0Min, material.f0Max}});
    return outcomeWith(result);
}

Result<formats::GltfScene> loadLitMesh(const std::map<std::string, std::filesystem::path>& inputs,
                                       const std::vector<formats::NodePlace>& places) {
    auto scene = loadMesh(inputs, kMeshRole, places);
    if (!scene || scene->hasLightMapUvs()) return scene;
    const auto& match = scene->lmbakeMatch();
    const std::string found =
        match && !match->unplaced.empty()
            ? countOfNames(match->unplaced, "node(s) without a rectangle in " + lmbakeOf(inputs, kMeshRole).filename().string())
            : "triangles without TEXCOORD_1";
    return formats::failure(formats::ErrorCode::WrongShape, inputs.at(kMeshRole),
                            fmt::format("found {}, expected light-map UVs on all triangles", found));
}

Result<ActionOutcome> cookMesh(const ActionContext& context) {
    LC_TRY(parameters, parametersOf<MeshParameters>(context));
    LC_TRY(scene, loadLitMesh(context.action.inputs, parameters->description.places));
    LC_TRY(clusters, upstreamClusters(context));
    MeshBits bits;
    if (parameters->draco) {
        LC_TRY(chosen, chooseMeshBits(*scene, *parameters, context));
        bits = *chosen;
    }
    const std::string file = context.action.asset + ".glb";
    const formats::ClusterMap* given = *clusters ? &**clusters : nullptr;
    const auto size =
        parameters->draco ? scene->writeDraco(context.folder / file, bits.options, given) : scene->writePlain(context.folder / file, given);
    if (!size) return tl::make_unexpected(size.error());

    CookResult result{manifestEntry(context, *parameters, file, *size, bits.options, given != nullptr), size->fileBytesIn, {}};
    if (given != nullptr) {
        LC_TRY(lightMap, upstreamAsset(context));
        result.asset.basis = {formats::kBasisAttribute, lightMap->name};
    }
    if (parameters->draco)
        result.notes = {{note_keys::kLightMapUvBits, bits.options.lightMapUvBits},
                        {note_keys::kNormalBits, bits.options.normalBits},
                        {note_keys::kBoundOfRelRms, bits.bound}};
    return outcomeWith(result, {file});
}

}  // namespace lightcook::pipeline

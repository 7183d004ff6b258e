// Meshes: the same mesh with quantized vertices for the engine, and the needs of its materials.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/gltf_scene.h"
#include "pipeline/assets/cooked_asset.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/verification.h"
#include "pipeline/document/json_fields.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Input of an action that reads a mesh.
inline constexpr const char* kMeshRole = "mesh";
/// Input of a light map's verification: the mesh, whose edges may show seams.
inline constexpr const char* kSurfaceRole = "surface";
/// GPU memory of a vertex for the index of its basis [bytes], with the padding of glTF.
inline constexpr std::uint64_t kBasisBytes = 4;

/// Layout of a mesh under Draco.
inline constexpr const char* kDracoMeshLayout = "glb-draco";
/// GPU memory of a vertex for its light-map UV [bytes]: two 16-bit numbers of a mesh under Draco, or two floats.
inline constexpr std::uint64_t kLightMapUvBytes = 4, kFloatUvBytes = 8;
/// Returns the GPU memory that a light map adds to a vertex of its mesh [bytes].
/// hasBases  its vertices name bases
constexpr std::uint64_t bytesOfVertex(bool isDraco, bool hasBases) {
    return (isDraco ? kLightMapUvBytes : kFloatUvBytes) + (hasBases ? kBasisBytes : 0);
}

/// Parameters of the cook action. Its inputs are "mesh", and "source" (the light map) where it chooses bits. It depends on the light map
/// where bases are learned: vertices name their clusters.
struct MeshParameters {
    formats::LightMapDescription description;
    bool draco = true;
    VisibleParameters visible;  ///< limits of the light map: a mesh may use a part of them
    std::optional<std::string> lightMap = {};
};
template <class Fields, Is<MeshParameters> Self>
void describe(Fields& fields, Self& parameters) {
    fields.required("description", parameters.description, "conventions of the light map");
    fields.required("draco", parameters.draco, "true for Draco compression");
    describe(fields, parameters.visible);
    fields.optional("light_map", parameters.lightMap, "name of the light map");
}

/// Needs of one material of a mesh.
struct MaterialRecord {
    std::string name;
    bool hasNormalMap = false, isSpecular = true;
    std::array<double, 2> m{}, f0{};
};
template <class Fields, Is<MaterialRecord> Self>
void describe(Fields& fields, Self& material) {
    fields.required("name", material.name, "name of the material");
    fields.required("normal_map", material.hasNormalMap, "true if it has a normal map");
    fields.required("specular", material.isSpecular, "true if it is specular");
    fields.required("m", material.m, "range of the Beckmann roughness");
    fields.required("f0", material.f0, "range of the reflectance at normal incidence");
}

/// Result of action "materials".
struct MaterialsResult {
    std::uint64_t mostVertices = 0;  ///< upper bound of the vertices of the triangles of the cooked mesh
    std::vector<MaterialRecord> materials;
};
template <class Fields, Is<MaterialsResult> Self>
void describe(Fields& fields, Self& result) {
    fields.required("most_vertices", result.mostVertices, "upper bound of the vertices of the triangles of the cooked mesh");
    fields.required("materials", result.materials, "materials of the mesh");
}

/// Action "materials" reads the needs of each material. Its input is "mesh".
formats::Result<ActionOutcome> readMaterials(const ActionContext& context);
/// Reads a mesh that a light map is shown on. Refuses one of whose triangles some have no light-map UVs.
/// inputs  of an action
/// places  of the light map
formats::Result<formats::GltfScene> loadLitMesh(const std::map<std::string, std::filesystem::path>& inputs,
                                                const std::vector<formats::NodePlace>& places);
formats::Result<ActionOutcome> cookMesh(const ActionContext& context);
/// Verifies how far quantization moved vertices, and what that changes of the light map's shading. Its inputs are "mesh" and "source"; it
/// depends on the light map again.
formats::Result<ActionOutcome> verifyMesh(const ActionContext& context);

/// The constant of a learned layout with the clusters of blocks, as runs.
inline constexpr const char* kIndexRuns = "index_runs";
/// Returns true if the vertices of a mesh name the bases of a light map: their clusters are runs in the manifest, not a texture.
bool hasClustersInMesh(const CookedAsset& lightMap);
/// Returns the clusters of such a light map.
formats::Result<formats::ClusterMap> clusterMapOf(const CookedAsset& lightMap);

}  // namespace lightcook::pipeline

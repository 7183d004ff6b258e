// glTF scenes as far as lighting needs them: lighting needs of the materials, light-map UVs (TEXCOORD_1), and writing the scene back with
// its geometry compressed by Draco (KHR_draco_mesh_compression).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "formats/chart_clusters.h"
#include "formats/error.h"
#include "formats/gltf/triangle_mesh.h"
#include "formats/light_map_places.h"
#include "formats/lmbake.h"

namespace lightcook::formats {

/// Lighting needs of one material: the union of its specular lobes, which are those of metallic-roughness (with KHR_materials_specular and
/// KHR_materials_ior), KHR_materials_pbrSpecularGlossiness and KHR_materials_clearcoat.
struct MaterialNeeds {
    std::string name;
    bool hasNormalMap = false;
    bool isSpecular = true;             ///< false: no lobe reflects anything, or KHR_materials_unlit
    double mMin = 1, mMax = 1;          ///< Beckmann roughness m; a texture widens it
    double f0Min = 0.04, f0Max = 0.04;  ///< reflectance at normal incidence; a texture widens it
    /// Extensions that may change the reflection and are not read.
    std::vector<std::string> unreadExtensions = {};
};

/// Draco's quantization [bits]; edgebreaker, lossy.
struct DracoOptions {
    int positionBits = 14;
    int normalBits = 10;
    int uvBits = 12;          ///< TEXCOORD_0
    int lightMapUvBits = 16;  ///< TEXCOORD_1
    int speed = 3;            ///< 0 smallest .. 10 fastest
};
struct MeshSize {
    std::size_t fileBytesIn = 0;  ///< the file and the buffers beside it
    std::size_t fileBytesOut = 0;
    std::int64_t vertexCount = 0, triangleCount = 0;  ///< as written: vertices split per primitive, degenerate triangles gone
    std::int64_t triangleVertexCount = 0;             ///< vertices without those of lines and points
};
/// The largest quantization error of any vertex of a written mesh, measured by reading it back.
struct MeshError {
    double position = 0;  ///< [scene units]
    double normalRadians = 0;
    double lightMapUv = 0;  ///< [UV units]
    /// Longest side of the bounds of any mesh of the source; the bits of the lattice divide it.
    double positionExtent = 0, lightMapUvExtent = 0;
    /// Quantization of float positions, normals and UVs in Draco streams that are not those of the source, by semantic [bits]; 0: none.
    std::map<std::string, std::set<int>> dracoBits = {};
};

struct BuiltGlb;
struct GlbChanges;

/// A glTF or GLB file, Draco-compressed or not. load() refuses missing buffers, indices out of range, positions or UVs that are not finite,
/// vertices with a world coordinate beyond 1e9, and what breaks the rules of gltf/scene_rules.h; the error names the file and the accessor,
/// node or material.
class GltfScene {
public:
    /// Light-map UVs that are stored otherwise than as TEXCOORD_1 of the whole map become this: see gltf/light_map_uvs.h. Draco streams of
    /// such a scene become plain.
    static Result<GltfScene> load(const std::filesystem::path& file);
    /// Loads a scene with its light-map UVs where an lmbake or a scene file puts them in the whole map; in a mesh for each node that draws
    /// them. Draco streams become plain. Of a scene with places, nodes without one draw nothing. Fails if no node is in the lmbake, or if a
    /// place fits no node or several.
    /// lmbake, places  at most one of them; both empty: load(file)
    static Result<GltfScene> load(const std::filesystem::path& file, const std::filesystem::path& lmbake,
                                  const std::vector<NodePlace>& places = {});
    GltfScene(GltfScene&&) noexcept;
    GltfScene& operator=(GltfScene&&) noexcept;
    ~GltfScene();

    /// Returns every material in the order of the file, then glTF's default one, named "default", if a primitive has none.
    const std::vector<MaterialNeeds>& materials() const;
    /// Returns true if every triangle primitive has TEXCOORD_1, and any primitive at all. Lines and points have no surface and need none.
    bool hasLightMapUvs() const;
    std::int64_t vertexCount() const;
    std::int64_t triangleCount() const;
    /// Returns which nodes an lmbake placed; nothing for a scene that was loaded without one.
    const std::optional<LmbakeMatch>& lmbakeMatch() const;
    /// Returns the nodes with light-map UVs that draw nothing since they have no place, by their paths; none of a scene without places.
    const std::vector<std::string>& nodesWithoutPlace() const;

    /// Writes the scene as a GLB whose triangle primitives are Draco meshes. Nodes, materials, lights, animations, extras and extensions
    /// are kept; images beside the scene are embedded. Float POSITION, NORMAL and TEXCOORD_n are quantized on one lattice a mesh, so that
    /// no gaps open between its primitives; every other attribute is kept bit for bit. Lines, points and primitives with morph targets
    /// (whose vertices must keep their order) stay as they are. The file appears when it is complete. clusters  if given, adds
    /// kBasisAttribute to every triangle primitive, without loss; clustersOfVertices() says when it fails
    Result<MeshSize> writeDraco(const std::filesystem::path& file, const DracoOptions& options, const ClusterMap* clusters = nullptr) const;
    /// Writes the scene as a GLB that differs by kBasisAttribute only. All values are kept bit for bit. Vertices and triangles keep their
    /// order, except in Draco streams, which are encoded again without loss.
    Result<MeshSize> writePlain(const std::filesystem::path& file, const ClusterMap* clusters) const;
    /// Writes the scene as a GLB that differs by its light-map UVs (TEXCOORD_1) only, which are floats then; those that it had become the
    /// first free TEXCOORD_n. Lines and points have none any more, and are refused if they have a TEXCOORD_2 too. All other values are kept
    /// bit for bit, and so is the order of vertices and triangles: Draco streams are written plain. uvs  new UVs of the vertices of each of
    /// triangleMeshes()
    Result<MeshSize> writeLightMapUvs(const std::filesystem::path& file, const std::vector<std::vector<glm::vec2>>& uvs) const;
    /// Returns the attribute that writeLightMapUvs() keeps the old UVs in.
    std::string oldUvsAttribute() const;
    /// Returns the triangle primitives in the order of the file; they live as long as the scene.
    std::vector<const TriangleMesh*> triangleMeshes() const;
    /// A triangle primitive in the world. Meshes that several nodes draw come several times; those that no node draws are left out.
    struct Placed {
        const TriangleMesh* mesh;  ///< one of triangleMeshes()
        glm::dmat4 worldFromMesh;
        bool isDoubleSided = false;  ///< its material shows both sides
        std::size_t node = 0;        ///< that draws it
        std::size_t primitive = 0;   ///< index in the mesh of that node
    };
    std::vector<Placed> placedMeshes() const;
    /// Returns "node 5 'Dome'", for messages.
    std::string nameOfNode(std::size_t node) const;
    /// Returns how often the scene draws one of its triangle meshes, at most: once for each node, or for each of the instances that the
    /// node has (EXT_mesh_gpu_instancing).
    std::int64_t mostDrawn() const;
    /// Compares this scene with one that writeDraco() made of it. Draco reorders vertices and triangles, so matchTriangles() pairs them by
    /// the distance of their corners. Fails with ErrorCode::Verification if a triangle has no counterpart, or if nodes, materials or
    /// animations differ.
    Result<MeshError> errorOf(const GltfScene& cooked) const;

private:
    struct State;
    explicit GltfScene(std::unique_ptr<State> state);
    /// Returns the scene with its Draco streams decoded. Images beside it are still found there. Fails with ErrorCode::FormatUnsupported
    /// for streams whose vertices have to keep their order (Primitive::canCompress).
    Result<GltfScene> plain() const;
    /// Returns the scene after change(document), without Draco streams.
    template <class Change>
    Result<GltfScene> changed(Change change) &&;
    /// file  for errors
    Result<BuiltGlb> build(const GlbChanges& changes, const std::filesystem::path& file) const;
    Result<MeshSize> write(const std::filesystem::path& file, const GlbChanges& changes) const;
    std::unique_ptr<State> state_;
};

enum class GltfFiles { All, Geometry };  ///< buffers and images, or buffers alone
/// Returns the existing files beside a glTF that hold its buffers and images, each once, in the order of the file. They are inputs of a
/// cook like the scene itself. Empty for a scene that cannot be read; load() says why.
std::vector<std::filesystem::path> gltfFilesBeside(const std::filesystem::path& file, GltfFiles which = GltfFiles::All);
/// Fails for a file that is no glTF, and for one without triangles that a bake can lie on: none that a node draws has TEXCOORD_1. Reads no
/// buffers.
Result<void> checkLightMapUvs(const std::filesystem::path& file);
/// Fails for a glTF of whose triangles some have light-map UVs and some have none, with the names of these meshes. Reads no buffers.
/// places  of the nodes that count; empty: all triangles do
Result<void> checkAllLightMapUvs(const std::filesystem::path& file, const std::vector<NodePlace>& places);
/// Returns the error of a glTF without light-map UVs.
Error withoutLightMapUvs(const std::filesystem::path& file);

}  // namespace lightcook::formats

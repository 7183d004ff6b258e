// glTF scenes as far as lighting needs them: what the materials ask for, the light-map UV set (TEXCOORD_1), and writing the same
// scene back with its geometry quantized by Draco (KHR_draco_mesh_compression).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "formats/chart_clusters.h"
#include "formats/error.h"

namespace lightcook::formats {

/// What one glTF material asks of the lighting (metallic-roughness, KHR_materials_specular, KHR_materials_ior).
struct MaterialNeeds {
    std::string name;
    bool hasNormalMap = false;
    bool isSpecular = true;             ///< false: KHR_materials_specular with specularFactor 0 and no metal, or KHR_materials_unlit
    double mMin = 1, mMax = 1;          ///< Beckmann roughness m = roughnessFactor squared; a roughness texture makes it [0, factor^2]
    double f0Min = 0.04, f0Max = 0.04;  ///< from ior, specularFactor, metallicFactor and baseColorFactor; a texture widens it
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
};
/// The quantization error that a written mesh really has, found by reading it back: largest over the vertices.
struct MeshError {
    double position = 0;  ///< [scene units]
    double normalRadians = 0;
    double lightMapUv = 0;  ///< [UV units]
    /// Of the source: the longest side of any mesh's bounds, which the bits of its lattice divide.
    double positionExtent = 0, lightMapUvExtent = 0;
};

/// A glTF or GLB file, Draco-compressed or not. Refused with file and accessor: missing buffers, indices out of range, TEXCOORD_1 missing
/// where a light map needs it, positions or UVs that are not finite.
class GltfScene {
public:
    static Result<GltfScene> load(const std::filesystem::path& file);
    GltfScene(GltfScene&&) noexcept;
    GltfScene& operator=(GltfScene&&) noexcept;
    ~GltfScene();

    /// Every material in the order of the file; then glTF's default one, named "default", if a primitive has none.
    const std::vector<MaterialNeeds>& materials() const;
    bool hasLightMapUvs() const;  ///< every primitive has TEXCOORD_1
    std::int64_t vertexCount() const;
    std::int64_t triangleCount() const;

    /// The same scene as a GLB whose triangle primitives are Draco meshes; nodes, materials, lights, animations, extras and extensions are
    /// kept, images beside the scene move in. float POSITION, NORMAL and TEXCOORD_n are quantized, on one lattice a mesh, so that borders
    /// between primitives stay shut; every other attribute is kept bit for bit. Primitives with morph targets (whose vertices must keep
    /// their order), lines and points stay as they are. Whole or absent.
    /// clusters  where given, every triangle primitive gains kBasisAttribute, kept exact; see clustersOfVertices for what is refused
    Result<MeshSize> writeDraco(const std::filesystem::path& file, const DracoOptions& options, const ClusterMap* clusters = nullptr) const;
    /// The same scene as a GLB, values bit for bit: only kBasisAttribute comes in. Vertices and triangles stay where they are, but for
    /// primitives that were Draco streams, which are coded anew without loss.
    Result<MeshSize> writePlain(const std::filesystem::path& file, const ClusterMap* clusters) const;
    /// Of the triangle primitives, in the order of the file; they live as long as the scene.
    std::vector<const TriangleMesh*> triangleMeshes() const;
    /// Compares vertex by vertex with a scene that writeDraco made of this one. Draco reorders vertices and triangles, so triangles are
    /// matched one to one by how close their corners are (see matchTriangles); one without a counterpart is an ErrorCode::Verification, and
    /// so are nodes, materials or animations that are not those of this scene.
    Result<MeshError> errorOf(const GltfScene& cooked) const;

private:
    struct State;
    explicit GltfScene(std::unique_ptr<State> state);
    Result<MeshSize> write(const std::filesystem::path& file, const DracoOptions* options, const ClusterMap* clusters) const;
    std::unique_ptr<State> state_;
};

enum class GltfFiles { All, Geometry };  ///< buffers and images, or buffers alone
/// The files beside a glTF that it takes buffers and images from, those that exist, each once, in the order of the file: a change in one
/// is a change of the scene. Empty for a scene that cannot be read; load() tells why.
std::vector<std::filesystem::path> gltfFilesBeside(const std::filesystem::path& file, GltfFiles which = GltfFiles::All);

}  // namespace lightcook::formats

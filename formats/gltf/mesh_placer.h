// Changes light-map UVs of a glTF document in memory: for nodes that lie in a rectangle of a map, and for UVs that are stored otherwise
// than as TEXCOORD_1.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <map>
#include <span>
#include <tuple>
#include <vector>

#include "formats/gltf/gltf_document.h"

namespace lightcook::formats {

/// Light-map UVs that are added to a document, as accessors of two floats.
class AddedUvs {
public:
    explicit AddedUvs(GltfDocument& document);
    /// Returns the accessor of new UVs. Throws GltfFault if a file needs far more of them than it has bytes.
    std::size_t add(std::span<const glm::vec2> uvs);
    /// Adds the buffer of the new UVs.
    void finish();

private:
    GltfDocument& document_;
    std::vector<std::byte> values_;
    std::vector<std::size_t> views_;
};

/// A place of light-map UVs in a map: uv * scale + offset.
struct UvRectangle {
    glm::dvec2 scale{1}, offset{0};
    auto order() const { return std::tuple(scale.x, scale.y, offset.x, offset.y); }
    bool operator<(const UvRectangle& other) const { return order() < other.order(); }
};

/// Gives meshes of a document their places in a map. The document follows the rules of scene_rules.h and has no Draco streams.
class MeshPlacer {
public:
    explicit MeshPlacer(GltfDocument& document) : document_(document), added_(document) {}

    /// Gives a node a mesh of its own in a rectangle.
    void place(std::size_t node, const UvRectangle& rectangle);
    /// Gives a node a mesh without light-map UVs, which it shares with others that have none.
    void strip(std::size_t node);
    /// Lets a node draw nothing.
    void leaveOut(std::size_t node);
    /// Adds the new UVs, and removes the meshes that nodes drew which draw nothing now, with their values.
    void finish();

private:
    Json& ownMesh(std::size_t node, bool isShared);
    std::size_t placedUvs(std::uint64_t accessor, const UvRectangle& rectangle);
    void removeMeshes();

    GltfDocument& document_;
    AddedUvs added_;
    std::map<std::size_t, Json> originals_;                                ///< the document's meshes that nodes have, as they were
    std::map<std::size_t, std::size_t> stripped_;                          ///< by the document's mesh: the one without light-map UVs
    std::map<std::pair<std::uint64_t, UvRectangle>, std::size_t> placed_;  ///< accessors
    std::size_t copies_ = 0;
    bool hasLeftOut_ = false;
};

}  // namespace lightcook::formats

// The .lmbake file of Godot 4 (class LightmapGIData): where each mesh of a scene lies in the light map. Each has a rectangle of one slice;
// its own light-map UVs (UV2 in Godot, TEXCOORD_1 in glTF) run over the whole rectangle.
#pragma once

#include <cstddef>
#include <filesystem>
#include <glm/vec4.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "formats/error.h"

namespace lightcook::formats {

/// A mesh of the bake.
struct LmbakeUser {
    std::vector<std::string> path;  ///< from the node LightmapGI: "..", "Room", "Wall"
    glm::dvec4 rectangle{0};        ///< x, y, width and height [share of the slice], y down as in a picture
    int slice = 0;                  ///< of the map: a page of four pictures if it has directions
    int subInstance = -1;           ///< number of a mesh that the node has several of, as GridMap; -1: the node is the mesh

    /// Returns "../Room/Wall", and which of several meshes is meant.
    std::string name() const;
};

struct Lmbake {
    std::vector<LmbakeUser> users;
    bool isDirectional = false;  ///< property uses_spherical_harmonics: the map has slices of L1
    /// They are L1 / (8 L0) + 0.5, as property _uses_packed_directional says; or Godot 4.4 or later saved the file, and the values tell.
    bool isPacked = false;

    /// Returns true for a bake of Godot 4.0 to 4.3, whose slices of L1 are no packed ones. No reader is for them.
    bool hasOldDirections() const { return isDirectional && !isPacked; }

    /// Returns the number of slices that meshes lie in: those of the map, which has none without a mesh.
    int sliceCount() const;
};

/// Reads a binary resource of Godot 4, compressed with Zstandard or not. Fails for files of another class, and for damaged ones: those that
/// are cut off, and rectangles that lie outside their slice. Memory grows with the file, not with the counts that it states.
Result<Lmbake> readLmbake(const std::filesystem::path& file);

/// Value of the scene key `lmbake` for a mesh whose TEXCOORD_1 are UVs in the whole map already.
inline constexpr std::string_view kNoLmbake = "none";
/// Returns false for a value of the scene key `bake` that names a format which Godot does not write.
bool mayTakeLmbake(std::string_view bake);
bool isLmbakeFile(const std::filesystem::path& file);
/// Returns the lmbake that belongs to a light map by its name, "room.lmbake" of "room.exr"; empty if there is none, or if the light map is
/// of a bake format that Godot does not write.
/// bake  value of the scene key
std::filesystem::path lmbakeBeside(const std::filesystem::path& lightMap, const std::string& bake);

/// Returns the lmbake that a map of Godot lacks by name, "room.lmbake"; empty for a map that Godot did not import as an array of slices.
/// lightMap  whose settings of the import lie beside it
std::filesystem::path lmbakeOfImport(const std::filesystem::path& lightMap);
/// Returns the lmbake beside a map that Godot split into several files: "room.lmbake" of "room_0.exr"; empty if there is none.
std::filesystem::path lmbakeOfSplitBake(const std::filesystem::path& lightMap);

/// Result of a search for the nodes of a glTF in an lmbake. Nodes are named by themselves and their parents: "Room/Wall".
struct LmbakeMatch {
    std::size_t placed = 0;             ///< nodes with a rectangle
    std::vector<std::string> unplaced;  ///< nodes that draw light-map UVs and have none: they have no light-map UVs any more
    std::vector<std::string> unread;    ///< rectangles without a node, as LmbakeUser::name()
};

}  // namespace lightcook::formats

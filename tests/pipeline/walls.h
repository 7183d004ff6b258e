// Two walls of two triangles each, as two meshes of two nodes, each with a chart of its own.
#pragma once

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>

#include "tests/formats/temporary_folder.h"

namespace lightcook::pipeline {

/// The corners of each wall, and its light-map UVs, go around it. The left one is at x from 0 to 2 and y from 0 to 7.
struct Walls {
    std::array<float, 8> leftUvs, rightUvs;
    std::array<float, 12> right;
    std::array<float, 3> rightTranslation = {0, 0, 0};
    std::string uvs = "TEXCOORD_1";  ///< attribute with the light-map UVs
};

/// Writes the walls as "walls.gltf" and "walls.bin".
inline void writeWalls(const std::filesystem::path& folder, const Walls& walls) {
    std::string bytes;
    const auto add = [&](const auto& values) { bytes.append(reinterpret_cast<const char*>(values.data()), sizeof(values)); };
    add(std::array<float, 12>{0, 7, 0, 0, 0, 0, 2, 0, 0, 2, 7, 0});
    add(walls.right);
    add(walls.leftUvs);
    add(walls.rightUvs);
    add(std::array<std::uint16_t, 6>{0, 1, 2, 0, 2, 3});
    const auto& [x, y, z] = walls.rightTranslation;
    const std::array<float, 12>& at = walls.right;
    formats::writeContent(folder / "walls.bin", bytes);
    formats::writeContent(folder / "walls.gltf",
                          fmt::format(R"({{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0, 1]}}],
"nodes": [{{"mesh": 0, "name": "left"}}, {{"mesh": 1, "name": "right", "translation": [{1}, {2}, {3}]}}],
"meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0, "{0}": 2}}, "indices": 4}}]}},
  {{"primitives": [{{"attributes": {{"POSITION": 1, "{0}": 3}}, "indices": 4}}]}}],
"buffers": [{{"uri": "walls.bin", "byteLength": 172}}],
"bufferViews": [{{"buffer": 0, "byteOffset": 0, "byteLength": 48}}, {{"buffer": 0, "byteOffset": 48, "byteLength": 48}},
  {{"buffer": 0, "byteOffset": 96, "byteLength": 32}}, {{"buffer": 0, "byteOffset": 128, "byteLength": 32}},
  {{"buffer": 0, "byteOffset": 160, "byteLength": 12}}],
"accessors": [{{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [2, 7, 0]}},
  {{"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3", "min": [{4}, {5}, {6}], "max": [{7}, {8}, {9}]}},
  {{"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2"}},
  {{"bufferView": 3, "componentType": 5126, "count": 4, "type": "VEC2"}},
  {{"bufferView": 4, "componentType": 5123, "count": 6, "type": "SCALAR"}}]}})",
                                      walls.uvs, x, y, z, at[3], at[4], at[5], at[9], at[1], at[2]));
}

}  // namespace lightcook::pipeline

// A mesh of one square under a light map, for the tests of bakes that depend on the surface.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tests/formats/gltf/glb.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::formats {

/// The square (x, 0, z), x and z in [0, 1], that faces +y. Its light-map UVs are (x, z) times `lightMap`.
struct Square {
    glm::vec2 lightMap{1, 1};
    std::optional<glm::mat2> texture = glm::mat2(1);  ///< TEXCOORD_0 = texture (x, z); empty: it has none
    std::optional<glm::vec4> tangent = {};            ///< TANGENT of each corner
    glm::mat4 node{1};
    bool hasNormals = true;  ///< else those of the file are zero
    std::string name = {};   ///< of the node; empty: it has none
};

inline void writeSquare(const std::filesystem::path& file, const Square& square) {
    using Json = nlohmann::json;
    const std::array<glm::vec2, 4> corners = {glm::vec2(0, 0), glm::vec2(0, 1), glm::vec2(1, 1), glm::vec2(1, 0)};
    std::string binary;
    Json views = Json::array(), accessors = Json::array(), attributes = Json::object();
    const auto add = [&](const std::string& name, const std::string& type, int width, const std::vector<float>& values) {
        views.push_back({{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", values.size() * sizeof(float)}});
        attributes[name] = accessors.size();
        accessors.push_back({{"bufferView", views.size() - 1}, {"componentType", 5126}, {"count", 4}, {"type", type}});
        if (name == "POSITION") {
            accessors.back()["min"] = {0, 0, 0};
            accessors.back()["max"] = {1, 0, 1};
        }
        EXPECT_EQ(values.size(), 4u * static_cast<std::size_t>(width));
        binary.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
    };
    std::vector<float> positions, normals, lightMap, texture, tangents;
    for (const glm::vec2& at : corners) {
        positions.insert(positions.end(), {at.x, 0, at.y});
        normals.insert(normals.end(), {0, square.hasNormals ? 1.0f : 0.0f, 0});
        lightMap.insert(lightMap.end(), {at.x * square.lightMap.x, at.y * square.lightMap.y});
        const glm::vec2 uv = square.texture.value_or(glm::mat2(1)) * at;
        texture.insert(texture.end(), {uv.x, uv.y});
        const glm::vec4 tangent = square.tangent.value_or(glm::vec4(0));
        tangents.insert(tangents.end(), {tangent.x, tangent.y, tangent.z, tangent.w});
    }
    add("POSITION", "VEC3", 3, positions);
    add("NORMAL", "VEC3", 3, normals);
    add("TEXCOORD_1", "VEC2", 2, lightMap);
    if (square.texture) add("TEXCOORD_0", "VEC2", 2, texture);
    if (square.tangent) add("TANGENT", "VEC4", 4, tangents);
    const std::array<std::uint16_t, 6> indices = {0, 1, 2, 0, 2, 3};
    views.push_back({{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", sizeof indices}});
    accessors.push_back({{"bufferView", views.size() - 1}, {"componentType", 5123}, {"count", 6}, {"type", "SCALAR"}});
    binary.append(reinterpret_cast<const char*>(indices.data()), sizeof indices);
    std::vector<float> node;
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row) node.push_back(square.node[column][row]);
    Json placed = {{"mesh", 0}, {"matrix", node}};
    if (!square.name.empty()) placed["name"] = square.name;
    const Json json = {{"asset", {{"version", "2.0"}}},
                       {"scene", 0},
                       {"scenes", {{{"nodes", {0}}}}},
                       {"nodes", Json::array({placed})},
                       {"meshes", {{{"primitives", {{{"attributes", attributes}, {"indices", accessors.size() - 1}}}}}}},
                       {"buffers", {{{"byteLength", binary.size()}}}},
                       {"bufferViews", views},
                       {"accessors", accessors}};
    writeContent(file, glbOf(json.dump(), binary));
}

}  // namespace lightcook::formats

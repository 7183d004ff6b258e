// Scenes of quads with light-map UVs, written as GLB by tests.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <glm/vec2.hpp>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>
#include <vector>

#include "tests/formats/gltf/glb.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::formats {

/// A quad of side 1 in the plane x, z, at a height of its own. Its light-map UVs fill a rectangle.
struct Quad {
    std::string name;
    glm::dvec2 low{0}, high{1};  ///< light-map UVs
    bool hasUvs = true;
};

/// A scene with a node and a mesh for each quad; all have material 0.
class QuadScene {
public:
    nlohmann::json json = {{"asset", {{"version", "2.0"}}},          {"accessors", nlohmann::json::array()},
                           {"bufferViews", nlohmann::json::array()}, {"meshes", nlohmann::json::array()},
                           {"nodes", nlohmann::json::array()},       {"materials", nlohmann::json::array({{{"name", "m"}}})}};
    std::string binary;
    /// Encoding of an attribute: component type of glTF, factor of the values, and "normalized".
    struct Encoding {
        int type = 5126;
        double factor = 1;
        bool isNormalized = false;
    };
    Encoding positions = {}, normals = {}, uvs = {};
    std::string uvSet = "TEXCOORD_1";

    void add(const Quad& quad) {
        const double height = 0.25 * static_cast<double>(json["nodes"].size());
        std::vector<double> position, normal, uv, base;
        for (const glm::dvec2& corner : {glm::dvec2(0, 0), glm::dvec2(1, 0), glm::dvec2(1, 1), glm::dvec2(0, 1)}) {
            const glm::dvec2 at = quad.low + corner * (quad.high - quad.low);
            position.insert(position.end(), {corner.x, height, corner.y});
            normal.insert(normal.end(), {0, 1, 0});
            base.insert(base.end(), {corner.x, corner.y});
            uv.insert(uv.end(), {at.x, at.y});
        }
        nlohmann::json attributes = {{"POSITION", accessor(position, 3, positions)},
                                     {"NORMAL", accessor(normal, 3, normals)},
                                     {"TEXCOORD_0", accessor(base, 2, {})}};
        if (quad.hasUvs) attributes[uvSet] = accessor(uv, 2, uvs);
        const std::array<std::uint16_t, 6> indices = {0, 2, 1, 0, 3, 2};
        const std::size_t index = json["accessors"].size();
        json["accessors"].push_back({{"bufferView", view(std::string(reinterpret_cast<const char*>(indices.data()), sizeof indices), 0)},
                                     {"componentType", 5123},
                                     {"count", 6},
                                     {"type", "SCALAR"}});
        json["meshes"].push_back(
            {{"name", quad.name + "Mesh"}, {"primitives", {{{"attributes", attributes}, {"indices", index}, {"material", 0}}}}});
        json["nodes"].push_back({{"name", quad.name}, {"mesh", json["meshes"].size() - 1}});
    }

    void write(const std::filesystem::path& file) const {
        nlohmann::json whole = json;
        if (!whole.contains("buffers")) whole["buffers"] = nlohmann::json::array({{{"byteLength", binary.size()}}});
        if (!whole.contains("scenes")) {
            // Nodes that no other names are roots.
            std::vector<bool> isChild(whole["nodes"].size(), false);
            for (const auto& node : whole["nodes"])
                for (const auto& child : node.value("children", nlohmann::json::array())) isChild[child.get<std::size_t>()] = true;
            nlohmann::json roots = nlohmann::json::array();
            for (std::size_t i = 0; i < isChild.size(); ++i)
                if (!isChild[i]) roots.push_back(i);
            whole["scenes"] = nlohmann::json::array({{{"nodes", roots}}});
        }
        if (positions.type != 5126 || normals.type != 5126 || uvs.type != 5126)
            for (const char* list : {"extensionsUsed", "extensionsRequired"}) whole[list].push_back("KHR_mesh_quantization");
        writeContent(file, glbOf(whole.dump(), binary));
    }

    std::size_t accessor(const std::vector<double>& values, std::size_t componentCount, const Encoding& encoding) {
        std::string bytes;
        std::vector<double> stored;
        const std::size_t componentBytes = encoding.type == 5126 ? 4 : encoding.type >= 5122 ? 2 : 1;
        const std::size_t stride = (componentBytes * componentCount + 3) / 4 * 4;
        for (std::size_t i = 0; i < values.size(); ++i) {
            stored.push_back(append(values[i] * encoding.factor, encoding, bytes));
            if ((i + 1) % componentCount == 0) bytes.resize((i + 1) / componentCount * stride, '\0');
        }
        nlohmann::json made = {{"bufferView", view(bytes, stride)},
                               {"componentType", encoding.type},
                               {"count", values.size() / componentCount},
                               {"type", "VEC" + std::to_string(componentCount)}};
        if (encoding.isNormalized) made["normalized"] = true;
        if (componentCount == 3) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                double low = stored[axis], high = low;
                for (std::size_t i = axis; i < stored.size(); i += 3) low = std::min(low, stored[i]), high = std::max(high, stored[i]);
                made["min"].push_back(low);
                made["max"].push_back(high);
            }
        }
        json["accessors"].push_back(std::move(made));
        return json["accessors"].size() - 1;
    }
    std::size_t view(const std::string& bytes, std::size_t stride) {
        binary.resize((binary.size() + 3) / 4 * 4, '\0');
        json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", bytes.size()}});
        if (stride > 0) json["bufferViews"].back()["byteStride"] = stride;
        binary += bytes;
        return json["bufferViews"].size() - 1;
    }

private:
    template <class T>
    static double appendAs(double value, bool isNormalized, std::string& bytes) {
        T stored{};
        if constexpr (std::is_integral_v<T>)
            stored = static_cast<T>(std::lround(isNormalized ? value * std::numeric_limits<T>::max() : value));
        else
            stored = static_cast<T>(value);
        bytes.append(reinterpret_cast<const char*>(&stored), sizeof stored);
        return static_cast<double>(stored);
    }
    static double append(double value, const Encoding& encoding, std::string& bytes) {
        switch (encoding.type) {
            case 5120:
                return appendAs<std::int8_t>(value, encoding.isNormalized, bytes);
            case 5121:
                return appendAs<std::uint8_t>(value, encoding.isNormalized, bytes);
            case 5122:
                return appendAs<std::int16_t>(value, encoding.isNormalized, bytes);
            case 5123:
                return appendAs<std::uint16_t>(value, encoding.isNormalized, bytes);
            default:
                return appendAs<float>(value, encoding.isNormalized, bytes);
        }
    }
};

}  // namespace lightcook::formats

#include "formats/gltf/scene_rules.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

#include "formats/file/one_line.h"
#include "formats/gltf/primitive.h"

namespace lightcook::formats {
namespace {

/// Extensions that change the geometry and are read, and beginnings of the names of those that leave it as it is.
constexpr std::array<std::string_view, 2> kRead = {kDracoExtension, "KHR_mesh_quantization"};
constexpr std::array<std::string_view, 9> kHarmless = {"KHR_materials_", "KHR_texture_",   "EXT_texture_",
                                                       "MSFT_texture_",  "KHR_lights_",    "KHR_xmp",
                                                       "EXT_lights_",    "EPIC_lightmap_", "KHR_node_visibility"};

class SceneRules {
public:
    explicit SceneRules(const GltfDocument& document) : document_(document) {}

    void check() const {
        checkExtensions();
        checkNodes();
        const Json& materials = document_.array("materials");
        for (std::size_t i = 0; i < materials.size(); ++i) checkMaterial(materials[i], fmt::format("material {}", i));
    }

private:
    [[noreturn]] void fail(const std::string& place, const std::string& detail) const {
        document_.fail(ErrorCode::WrongShape, place, detail);
    }

    /// EXT_meshopt_compression was refused before its buffers were read.
    void checkExtensions() const {
        for (const Json& extension : document_.array("extensionsRequired")) {
            const auto name = extension.get<std::string>();
            const auto begins = [&](std::string_view start) { return name.starts_with(start); };
            if (std::ranges::find(kRead, name) == kRead.end() && std::ranges::none_of(kHarmless, begins))
                document_.fail(
                    ErrorCode::FormatUnsupported, "extensionsRequired",
                    fmt::format("found {}, expected a scene that can be read without it: its geometry may be another", oneLine(name)));
        }
    }

    /// Checks a member that names an entry of a top-level array, if it is there.
    void checkReference(const Json& owner, const char* key, const char* array, const std::string& place) const {
        if (!owner.contains(key)) return;
        const std::uint64_t index = document_.number(owner, key, 0, place), count = document_.array(array).size();
        if (index >= count) fail(place, fmt::format("found {} = {}, expected less than {}", key, index, count));
    }

    void checkNodes() const {
        const Json& nodes = document_.array("nodes");
        constexpr std::size_t kNone = SIZE_MAX;
        std::vector<std::size_t> parents(nodes.size(), kNone);
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            const std::string place = fmt::format("node {}", i);
            checkTransform(nodes[i], place);
            checkReference(nodes[i], "mesh", "meshes", place);
            for (const Json& child : nodes[i].value("children", Json::array())) {
                if (!child.is_number_unsigned() || child.get<std::uint64_t>() >= nodes.size())
                    fail(place, fmt::format("found child {}, expected a node below {}", oneLine(child.dump()), nodes.size()));
                std::size_t& parent = parents[child.get<std::size_t>()];
                if (parent != kNone)
                    fail(place,
                         fmt::format("found child {}, which is one of node {} too, expected a tree", child.get<std::size_t>(), parent));
                parent = i;
            }
        }
        // Each node has one parent at most, so the way up ends or runs in a circle.
        std::vector<std::size_t> seenFrom(nodes.size(), kNone);
        for (std::size_t start = 0; start < nodes.size(); ++start) {
            std::size_t node = start;
            for (; node != kNone && seenFrom[node] == kNone; node = parents[node]) seenFrom[node] = start;
            if (node != kNone && seenFrom[node] == start)
                fail(fmt::format("node {}", node), "found the node below itself, expected a tree");
        }
    }

    void checkTransform(const Json& node, const std::string& place) const {
        for (const auto& [key, count] : {std::pair("matrix", 16), {"translation", 3}, {"rotation", 4}, {"scale", 3}}) {
            if (!node.contains(key)) continue;
            const Json& values = node[key];
            const auto isNumber = [](const Json& value) { return value.is_number(); };
            if (!values.is_array() || values.size() != static_cast<std::size_t>(count) || !std::ranges::all_of(values, isNumber))
                fail(place, fmt::format("found {} = {}, expected {} numbers", key, oneLine(values.dump()), count));
        }
        if (!node.contains("rotation")) return;
        double square = 0;
        for (const Json& value : node["rotation"]) square += value.get<double>() * value.get<double>();
        constexpr double kTolerance = 0.05;
        if (!(std::abs(square - 1) <= kTolerance))
            fail(place, fmt::format("found a rotation of length {:.3g}, expected a unit quaternion", std::sqrt(square)));
    }

    void checkMaterial(const Json& material, const std::string& place) const {
        const Json pbr = material.value("pbrMetallicRoughness", Json::object()), extensions = material.value("extensions", Json::object());
        checkFactor(pbr, "metallicFactor", 0, 1, place);
        checkFactor(pbr, "roughnessFactor", 0, 1, place);
        checkFactors(pbr, "baseColorFactor", 4, 1, place);
        checkTexture(material, "normalTexture", place);
        checkTexture(pbr, "metallicRoughnessTexture", place);
        checkTexture(pbr, "baseColorTexture", place);
        const Json specular = extensions.value("KHR_materials_specular", Json::object());
        checkFactor(specular, "specularFactor", 0, 1, place);
        checkFactors(specular, "specularColorFactor", 3, HUGE_VAL, place);
        checkTexture(specular, "specularTexture", place);
        checkTexture(specular, "specularColorTexture", place);
        const Json glossiness = extensions.value("KHR_materials_pbrSpecularGlossiness", Json::object());
        checkFactor(glossiness, "glossinessFactor", 0, 1, place);
        checkFactors(glossiness, "specularFactor", 3, 1, place);
        checkTexture(glossiness, "specularGlossinessTexture", place);
        const Json clearcoat = extensions.value("KHR_materials_clearcoat", Json::object());
        checkFactor(clearcoat, "clearcoatFactor", 0, 1, place);
        checkFactor(clearcoat, "clearcoatRoughnessFactor", 0, 1, place);
        checkTexture(clearcoat, "clearcoatTexture", place);
        checkTexture(clearcoat, "clearcoatRoughnessTexture", place);
        checkTexture(clearcoat, "clearcoatNormalTexture", place);
        const Json ior = extensions.value("KHR_materials_ior", Json::object());
        // 0 stands for a reflectance of 1.
        if (ior.contains("ior") && ior["ior"] != 0) checkFactor(ior, "ior", 1, HUGE_VAL, place);
    }
    void checkTexture(const Json& owner, const char* key, const std::string& place) const {
        if (owner.contains(key)) checkReference(owner[key], "index", "textures", place + ", " + key);
    }
    void checkFactor(const Json& owner, const char* key, double low, double high, const std::string& place) const {
        if (owner.contains(key)) checkValue(owner[key], key, low, high, place);
    }
    void checkFactors(const Json& owner, const char* key, std::size_t count, double high, const std::string& place) const {
        if (!owner.contains(key)) return;
        const Json& values = owner[key];
        if (!values.is_array() || values.size() != count)
            fail(place, fmt::format("found {} = {}, expected {} numbers", key, oneLine(values.dump()), count));
        for (const Json& value : values) checkValue(value, key, 0, high, place);
    }
    void checkValue(const Json& value, const char* key, double low, double high, const std::string& place) const {
        if (value.is_number() && value.get<double>() >= low && value.get<double>() <= high) return;
        fail(place, fmt::format("found {} = {}, expected {}", key, oneLine(value.dump()),
                                std::isfinite(high) ? fmt::format("{:g} to {:g}", low, high) : fmt::format("at least {:g}", low)));
    }

    const GltfDocument& document_;
};

}  // namespace

void checkSceneRules(const GltfDocument& document) {
    SceneRules(document).check();
}

}  // namespace lightcook::formats

#include "formats/gltf_light_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "formats/file/one_line.h"
#include "formats/gltf/gltf_document.h"
#include "formats/pending_file.h"

namespace lightcook::formats {
namespace {

constexpr const char *kFallbackExtension = "MOZ_lightmap", *kEnvironmentExtension = "EXT_lights_image_based";
constexpr int kLinear = 9729, kClampToEdge = 33071;  // of OpenGL, as glTF's samplers name them

/// Returns the extension of a node that the light map lights.
Json bindingOfNode() {
    return {{"map", 0}, {"texCoord", 1}, {"coordinateScaleBias", {1, 1, 0, 0}}};
}

/// Returns false for lines and points without light-map UVs.
bool isLit(const Json& primitive) {
    return primitive.at("attributes").contains("TEXCOORD_1");
}

class LightMapBinder {
public:
    LightMapBinder(const GltfDocument& document, const GltfLightMap& lightMap) : json_(document.json()), lightMap_(lightMap) {
        if (json_.contains("buffers") && !json_["buffers"].empty()) {
            // bufferViews of the scene lie in the one buffer in front of what is added.
            for (std::size_t view = 0; json_.contains("bufferViews") && view < json_["bufferViews"].size(); ++view) {
                const auto part = document.bufferView(view);
                align();
                json_["bufferViews"][view]["byteOffset"] = buffer_.size();
                buffer_.insert(buffer_.end(), part.begin(), part.end());
            }
        }
    }

    std::vector<std::byte> bind() && {
        json_["extensions"][kLightMapExtension]["maps"] = Json::array({Json::parse(lightMap_.description)});
        declare(kLightMapExtension);
        for (Json& node : listOf("nodes"))
            if (node.contains("mesh") &&
                std::ranges::any_of(json_.at("meshes").at(node.at("mesh").get<std::size_t>()).at("primitives"), isLit))
                node["extensions"][kLightMapExtension] = bindingOfNode();
        bindFallback();
        if (lightMap_.environment) bindEnvironment(*lightMap_.environment);
        if (!buffer_.empty()) json_["buffers"] = Json::array({{{"byteLength", buffer_.size()}}});
        return assembleGlb(json_, buffer_);
    }

private:
    Json& listOf(const char* key) {
        if (!json_.contains(key)) json_[key] = Json::array();
        return json_[key];
    }
    void align() { buffer_.resize((buffer_.size() + 3) / 4 * 4); }
    void declare(const char* extension) {
        Json& used = listOf("extensionsUsed");
        if (std::find(used.begin(), used.end(), extension) == used.end()) used.push_back(extension);
    }
    static std::size_t append(Json& list, Json element) {
        list.push_back(std::move(element));
        return list.size() - 1;
    }

    /// Returns the index of a new image.
    std::size_t addImage(const std::string& name, const GltfLightMap::Png& png) {
        align();
        const std::size_t view = append(listOf("bufferViews"), {{"buffer", 0}, {"byteOffset", buffer_.size()}, {"byteLength", png.size()}});
        buffer_.insert(buffer_.end(), png.begin(), png.end());
        return append(listOf("images"), {{"bufferView", view}, {"mimeType", "image/png"}, {"name", name}});
    }

    /// Returns the index of a material for the primitives that have none, which look like glTF's default.
    std::size_t defaultMaterial() {
        if (!defaultMaterial_) defaultMaterial_ = append(listOf("materials"), {{"name", "default"}});
        return *defaultMaterial_;
    }

    void bindFallback() {
        const std::size_t sampler =
            append(listOf("samplers"), {{"magFilter", kLinear}, {"minFilter", kLinear}, {"wrapS", kClampToEdge}, {"wrapT", kClampToEdge}});
        const std::size_t image = addImage(lightMap_.name + "_flat", lightMap_.fallback);
        const std::size_t texture =
            append(listOf("textures"), {{"sampler", sampler}, {"source", image}, {"name", lightMap_.name + "_flat"}});
        listOf("materials");  // before there are references: a new key of the document would move its lists
        const std::set<std::size_t> unlit = separateUnlit();
        for (Json& mesh : listOf("meshes"))
            for (Json& primitive : mesh["primitives"])
                if (isLit(primitive) && !primitive.contains("material")) primitive["material"] = defaultMaterial();
        Json& materials = listOf("materials");
        for (std::size_t i = 0; i < materials.size(); ++i)
            if (!unlit.contains(i))
                materials[i]["extensions"][kFallbackExtension] = {
                    {"index", texture}, {"texCoord", 1}, {"intensity", lightMap_.fallbackIntensity}};
        declare(kFallbackExtension);
    }

    /// Returns the materials that only primitives without light-map UVs have. A material of both kinds of primitives gets a copy for these.
    std::set<std::size_t> separateUnlit() {
        std::set<std::size_t> lit, unlit;
        std::vector<Json*> unlitPrimitives;
        for (Json& mesh : listOf("meshes"))
            for (Json& primitive : mesh["primitives"]) {
                if (!primitive.contains("material")) continue;
                if (isLit(primitive))
                    lit.insert(primitive["material"].get<std::size_t>());
                else
                    unlitPrimitives.push_back(&primitive);
            }
        std::map<std::size_t, std::size_t> copies;
        for (Json* primitive : unlitPrimitives) {
            Json& material = (*primitive)["material"];
            const auto index = material.get<std::size_t>();
            if (lit.contains(index)) {
                if (!copies.contains(index)) {
                    Json& materials = json_["materials"];
                    copies[index] = append(materials, Json(materials.at(index)));
                }
                material = copies[index];
            }
            unlit.insert(material.get<std::size_t>());
        }
        return unlit;
    }

    void bindEnvironment(const GltfLightMap::Environment& environment) {
        if (json_["extensions"].contains(kEnvironmentExtension)) return;
        Json coefficients = Json::array(), levels = Json::array();
        for (const glm::vec3& rgb : environment.irradiance) coefficients.push_back({rgb.x, rgb.y, rgb.z});
        for (const auto& level : environment.levels) {
            Json faces = Json::array();
            for (const GltfLightMap::Png& face : level)
                faces.push_back(addImage(fmt::format("{}_{}_{}", environment.name, levels.size(), faces.size()), face));
            levels.push_back(std::move(faces));
        }
        json_["extensions"][kEnvironmentExtension]["lights"] = Json::array({{{"name", environment.name},
                                                                             {"intensity", 1},
                                                                             {"irradianceCoefficients", std::move(coefficients)},
                                                                             {"specularImageSize", environment.size},
                                                                             {"specularImages", std::move(levels)}}});
        for (Json& scene : listOf("scenes")) scene["extensions"][kEnvironmentExtension] = {{"light", 0}};
        declare(kEnvironmentExtension);
    }

    Json json_;
    const GltfLightMap& lightMap_;
    std::vector<std::byte> buffer_;
    std::optional<std::size_t> defaultMaterial_;
};

}  // namespace

Result<std::uint64_t> bindLightMap(const std::filesystem::path& scene, const std::filesystem::path& file, const GltfLightMap& lightMap) {
    const auto glb = resultOf(scene, [&] { return LightMapBinder(GltfDocument(scene), lightMap).bind(); });
    if (!glb) return tl::make_unexpected(glb.error());
    LC_CHECK(checkGlbSize(glb->size(), file));
    LC_CHECK(writeWholeFile(file, *glb));
    return glb->size();
}

Result<std::string> boundLightMaps(const std::filesystem::path& file) {
    return resultOf(file, [&]() -> std::string {
        const GltfDocument document(file);
        const Json& json = document.json();
        const auto extensions = json.find("extensions");
        if (extensions == json.end() || !extensions->is_object() || !extensions->contains(kLightMapExtension)) return "[]";
        const Json& extension = extensions->at(kLightMapExtension);
        return extension.is_object() && extension.contains("maps") ? extension.at("maps").dump() : "[]";
    });
}

Result<std::optional<std::string>> wrongBinding(const std::filesystem::path& file) {
    return resultOf(file, [&]() -> std::optional<std::string> {
        const GltfDocument document(file);
        const Json& nodes = document.array("nodes");
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            const Json& node = nodes.at(i);
            Json found, expected;
            if (node.contains("extensions")) found = node.at("extensions").value(kLightMapExtension, Json());
            if (node.contains("mesh") &&
                std::ranges::any_of(document.entry("meshes", node.at("mesh").get<std::uint64_t>()).at("primitives"), isLit))
                expected = bindingOfNode();
            if (found != expected) return fmt::format("node {}: found {}, expected {}", i, oneLine(found.dump()), expected.dump());
        }
        return std::nullopt;
    });
}

}  // namespace lightcook::formats

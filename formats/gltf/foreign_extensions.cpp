#include "formats/gltf/foreign_extensions.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "formats/file/one_line.h"

namespace lightcook::formats {
namespace {

constexpr std::string_view kInstancing = "EXT_mesh_gpu_instancing";
/// Beginnings of the names of extensions whose numbers are no indices of accessors, buffer views, buffers or meshes, beside "bufferView";
/// those of instances are accessors.
constexpr std::array<std::string_view, 15> kKnown = {
    "KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "KHR_lights_",           "KHR_xmp",         "EXT_lights_", "EPIC_",
    "MOZ_",           "LIGHTCOOK_",   "MSFT_lod",     "KHR_node_",     "KHR_mesh_quantization", "KHR_draco_mesh_", kInstancing};
/// Beginnings of the names of extensions of primitives that do not depend on the order of vertices or triangles.
constexpr std::array<std::string_view, 5> kUnordered = {"KHR_materials_", "KHR_draco_mesh_", "EXT_mesh_features", "EXT_structural_metadata",
                                                        "LIGHTCOOK_"};

template <std::size_t N>
bool beginsWithAny(std::string_view name, const std::array<std::string_view, N>& beginnings) {
    return std::ranges::any_of(beginnings, [&](std::string_view each) { return name.starts_with(each); });
}

/// Calls visit(name, extension) for each extension below `json`. Skips "extras", which belong to the user.
template <class JsonOrConst, class Visit>
void visitExtensions(JsonOrConst& json, const Visit& visit) {
    if (json.is_array()) {
        for (auto& value : json) visitExtensions(value, visit);
    } else if (json.is_object()) {
        for (auto& [key, value] : json.items()) {
            if (key == "extras") continue;
            if (key == "extensions" && value.is_object())
                for (auto& [name, extension] : value.items()) visit(name, extension);
            visitExtensions(value, visit);
        }
    }
}

/// Calls visit(name, extension) for each extension below `json` that is not known.
template <class JsonOrConst, class Visit>
void visitForeign(JsonOrConst& json, const Visit& visit) {
    visitExtensions(json, [&](const std::string& name, auto& extension) {
        if (!beginsWithAny(name, kKnown)) visit(name, extension);
    });
}

/// Calls visit(key, number) for each whole number below a value; key is that of the member, or of the array that it is in.
template <class JsonOrConst, class Visit>
void visitIntegers(const std::string& key, JsonOrConst& json, const Visit& visit) {
    if (json.is_number_unsigned()) {
        visit(key, json);
    } else if (json.is_array()) {
        for (auto& value : json) visitIntegers(key, value, visit);
    } else if (json.is_object()) {
        for (auto& [name, value] : json.items())
            if (name != "extras") visitIntegers(name, value, visit);
    }
}

}  // namespace

std::set<std::uint64_t> foreignIntegers(const Json& gltf) {
    std::set<std::uint64_t> numbers;
    visitForeign(gltf, [&](const std::string&, const Json& extension) {
        visitIntegers("", extension, [&](const std::string&, const Json& number) { numbers.insert(number.get<std::uint64_t>()); });
    });
    return numbers;
}

std::set<std::uint64_t> foreignAccessors(const Json& gltf) {
    std::set<std::uint64_t> numbers = foreignIntegers(gltf);
    visitExtensions(gltf, [&](const std::string& name, const Json& extension) {
        if (name == kInstancing)
            visitIntegers("", extension, [&](const std::string&, const Json& number) { numbers.insert(number.get<std::uint64_t>()); });
    });
    return numbers;
}

bool hasOrderedExtension(const Json& primitive) {
    const auto extensions = primitive.find("extensions");
    if (extensions == primitive.end() || !extensions->is_object()) return false;
    for (const auto& [name, extension] : extensions->items())
        if (!beginsWithAny(name, kUnordered)) return true;
    return false;
}

void renumberForeignMeshes(const GltfDocument& document, Json& gltf, const std::vector<std::size_t>& newIndexOf) {
    visitForeign(gltf, [&](const std::string& name, Json& extension) {
        visitIntegers("", extension, [&](const std::string& key, Json& number) {
            const auto index = number.get<std::uint64_t>();
            if (key != "mesh" || index >= newIndexOf.size()) return;
            if (newIndexOf[index] == kNoMesh)
                document.fail(
                    ErrorCode::FormatUnsupported, oneLine(name),
                    fmt::format("found a reference to mesh {}, which is left out, expected a scene without this extension", index));
            number = newIndexOf[index];
        });
    });
}

void checkNoForeignBuffers(const GltfDocument& document, const Json& gltf) {
    visitForeign(gltf, [&](const std::string& name, const Json& extension) {
        visitIntegers("", extension, [&](const std::string& key, const Json& number) {
            if (key == "buffer")
                document.fail(ErrorCode::FormatUnsupported, oneLine(name),
                              fmt::format("found a reference to buffer {} in an extension that lightcook does not read, expected a scene "
                                          "without it: the written file has one buffer of its own",
                                          number.get<std::uint64_t>()));
        });
    });
}

}  // namespace lightcook::formats

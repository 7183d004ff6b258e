#include "formats/gltf/mesh_placer.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

#include "formats/gltf/foreign_extensions.h"
#include "formats/gltf/light_map_uvs.h"

namespace lightcook::formats {
namespace {

/// Primitives of meshes that are copied for further nodes, and their UVs: a small file may have a mesh that many nodes draw.
constexpr std::size_t kMostCopies = 1u << 20, kMostUvBytes = std::size_t{256} << 20, kMostUvSharing = 64;

/// Returns the accessors of the primitives of a mesh.
std::set<std::uint64_t> accessorsOf(const Json& mesh) {
    std::set<std::uint64_t> accessors;
    const auto add = [&](const Json& index) {
        if (index.is_number_unsigned()) accessors.insert(index.get<std::uint64_t>());
    };
    for (const Json& primitive : mesh.value("primitives", Json::array())) {
        for (const Json& index : primitive.value("attributes", Json::object())) add(index);
        if (primitive.contains("indices")) add(primitive["indices"]);
        for (const Json& target : primitive.value("targets", Json::array()))
            for (const Json& index : target) add(index);
    }
    return accessors;
}

}  // namespace

AddedUvs::AddedUvs(GltfDocument& document) : document_(document) {
    Json& json = document.changedJson();
    if (!json.contains("bufferViews")) json["bufferViews"] = Json::array();  // none of sparse accessors alone
}

std::size_t AddedUvs::add(std::span<const glm::vec2> uvs) {
    static_assert(sizeof(glm::vec2) == 2 * sizeof(float));
    Json& json = document_.changedJson();
    const std::span<const std::byte> bytes = std::as_bytes(uvs);
    const std::size_t first = values_.size(), most = kMostUvBytes + kMostUvSharing * document_.fileBytes();
    if (first + bytes.size() > most)
        document_.fail(ErrorCode::FormatUnsupported, "",
                       fmt::format("found nodes that need more than {} MiB of light-map UVs, expected less in a file of {} bytes",
                                   most >> 20, document_.fileBytes()));
    values_.insert(values_.end(), bytes.begin(), bytes.end());
    constexpr unsigned kArrayBuffer = 34962;  // readers take whole numbers that are unsigned
    views_.push_back(json["bufferViews"].size());
    json["bufferViews"].push_back({{"byteOffset", first}, {"byteLength", bytes.size()}, {"target", kArrayBuffer}});
    json["accessors"].push_back({{"bufferView", views_.back()},
                                 {"componentType", static_cast<unsigned>(ComponentType::Float32)},
                                 {"count", uvs.size()},
                                 {"type", "VEC2"}});
    return json["accessors"].size() - 1;
}

void AddedUvs::finish() {
    if (values_.empty()) return;
    const std::uint64_t buffer = document_.addBuffer(std::move(values_));
    for (const std::size_t view : views_) document_.changedJson()["bufferViews"][view]["buffer"] = buffer;
    values_.clear();
    views_.clear();
}

void MeshPlacer::place(std::size_t node, const UvRectangle& rectangle) {
    for (Json& primitive : ownMesh(node, false)["primitives"]) {
        Json& attributes = primitive["attributes"];
        if (attributes.contains(kLightMapUvs))
            attributes[kLightMapUvs] = placedUvs(attributes[kLightMapUvs].get<std::uint64_t>(), rectangle);
    }
}

void MeshPlacer::strip(std::size_t node) {
    for (Json& primitive : ownMesh(node, true)["primitives"]) primitive["attributes"].erase(kLightMapUvs);
}

void MeshPlacer::leaveOut(std::size_t node) {
    Json& json = document_.changedJson()["nodes"][node];
    for (const char* ofMesh : {"mesh", "skin", "weights"}) json.erase(ofMesh);
    if (json.contains("extensions")) {
        json["extensions"].erase("EXT_mesh_gpu_instancing");
        if (json["extensions"].empty()) json.erase("extensions");
    }
    hasLeftOut_ = true;
}

void MeshPlacer::finish() {
    added_.finish();
    if (hasLeftOut_) removeMeshes();
}

/// Returns the mesh that a node gets: the document's for the first node, a copy of it for each further one.
Json& MeshPlacer::ownMesh(std::size_t node, bool isShared) {
    Json& json = document_.changedJson();
    Json& index = json["nodes"][node]["mesh"];
    const auto source = index.get<std::size_t>();
    const auto known = stripped_.find(source);
    std::size_t own = source;
    if (isShared && known != stripped_.end()) {
        own = known->second;
    } else if (const auto [original, isFirst] = originals_.try_emplace(source, json["meshes"][source]); !isFirst) {
        own = json["meshes"].size();
        copies_ += original->second["primitives"].size();
        if (copies_ > kMostCopies)
            document_.fail(ErrorCode::FormatUnsupported, fmt::format("node {}", node),
                           fmt::format("found nodes that need more than {} primitives of their own, expected less", kMostCopies));
        json["meshes"].push_back(original->second);
    }
    if (isShared) stripped_[source] = own;
    index = own;
    return json["meshes"][own];
}

/// Returns the accessor of the UVs of another one in a rectangle.
std::size_t MeshPlacer::placedUvs(std::uint64_t accessor, const UvRectangle& rectangle) {
    const auto [known, isNew] = placed_.try_emplace({accessor, rectangle}, 0);
    if (!isNew) return known->second;
    const MeshAttribute uvs = document_.readAccessor(accessor, kLightMapUvs);
    std::vector<glm::vec2> made;
    for (std::size_t vertex = 0; vertex < uvs.vertexCount(); ++vertex)
        made.emplace_back(glm::dvec2(uvs.at(vertex)) * rectangle.scale + rectangle.offset);
    known->second = added_.add(made);
    return known->second;
}

void MeshPlacer::removeMeshes() {
    Json& json = document_.changedJson();
    std::vector<bool> isDrawn(json["meshes"].size(), false);
    for (const Json& node : json["nodes"])
        if (node.contains("mesh")) isDrawn[node["mesh"].get<std::size_t>()] = true;
    std::set<std::uint64_t> kept = foreignAccessors(json), gone;
    std::vector<std::size_t> newIndexOf;
    Json meshes = Json::array();
    for (std::size_t i = 0; i < isDrawn.size(); ++i) {
        const std::set<std::uint64_t> accessors = accessorsOf(json["meshes"][i]);
        (isDrawn[i] ? kept : gone).insert(accessors.begin(), accessors.end());
        newIndexOf.push_back(isDrawn[i] ? meshes.size() : kNoMesh);
        if (isDrawn[i]) meshes.push_back(std::move(json["meshes"][i]));
    }
    json["meshes"] = std::move(meshes);
    for (Json& node : json["nodes"])
        if (node.contains("mesh")) node["mesh"] = newIndexOf[node["mesh"].get<std::size_t>()];
    renumberForeignMeshes(document_, json, newIndexOf);
    for (const std::uint64_t accessor : gone) {
        if (kept.contains(accessor) || accessor >= json["accessors"].size()) continue;
        for (const char* value : {"bufferView", "byteOffset", "sparse", "min", "max"}) json["accessors"][accessor].erase(value);
    }
}

}  // namespace lightcook::formats

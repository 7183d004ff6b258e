#include "formats/gltf_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vector_relational.hpp>
#include <map>
#include <set>
#include <span>
#include <utility>

#include "formats/file/one_line.h"
#include "formats/gltf/attribute_bounds.h"
#include "formats/gltf/draco_mesh.h"
#include "formats/gltf/glb_builder.h"
#include "formats/gltf/gltf_document.h"
#include "formats/gltf/light_map_uvs.h"
#include "formats/gltf/lmbake_nodes.h"
#include "formats/gltf/material_needs.h"
#include "formats/gltf/node_placement.h"
#include "formats/gltf/node_places.h"
#include "formats/gltf/primitive.h"
#include "formats/gltf/scene_rules.h"
#include "formats/pending_file.h"

namespace lightcook::formats {
namespace {

/// Largest world coordinate of a vertex. One that is further away is a broken export: its triangles would have nearly all of the scene's
/// area, and so nearly all samples of a surface.
constexpr double kFarthest = 1e9;

/// Returns the largest absolute coordinate of any vertex.
double reachOf(const MeshAttribute& position) {
    double reach = 0;
    for (std::size_t vertex = 0; vertex < position.vertexCount(); ++vertex) {
        const glm::dvec3 distance = glm::abs(position.at(vertex));
        reach = std::max({reach, distance.x, distance.y, distance.z});
    }
    return reach;
}

/// Returns a bound on the absolute coordinates of points in the world, each of whose own coordinates is at most `reach`.
double reachOf(const glm::dmat4& toWorld, double reach) {
    double largest = 0;
    for (int row = 0; row < 3; ++row) {
        double sum = std::abs(toWorld[3][row]);
        for (int column = 0; column < 3; ++column) sum += std::abs(toWorld[column][row]) * reach;
        largest = std::max(largest, std::isnan(sum) ? HUGE_VAL : sum);
    }
    return largest;
}

/// Returns the first part of the JSON, other than geometry, in which a copy differs from the original; empty if none. Ignores the indices
/// of buffer views: writing renumbers them.
std::string otherThanGeometry(const Json& original, const Json& copy) {
    for (const char* part : {"scene", "scenes", "nodes", "skins", "animations", "cameras", "materials", "textures", "samplers"}) {
        Json ours = original.value(part, Json()), theirs = copy.value(part, Json());
        for (Json* each : {&ours, &theirs}) visitBufferViews(*each, [](Json& reference) { reference = 0; });
        if (ours != theirs) return part;
    }
    const Json ours = original.value("meshes", Json::array()), theirs = copy.value("meshes", Json::array());
    for (std::size_t mesh = 0; mesh < ours.size(); ++mesh)
        for (std::size_t i = 0; i < ours[mesh]["primitives"].size(); ++i)
            if (mesh >= theirs.size() || i >= theirs[mesh]["primitives"].size() ||
                ours[mesh]["primitives"][i].value("material", Json()) != theirs[mesh]["primitives"][i].value("material", Json()))
                return "materials of a primitive";
    return {};
}

/// Sets the extents of the source in `error`: the longest side of any mesh's bounds.
void setExtents(const std::vector<Primitive>& primitives, MeshError& error) {
    const auto isTriangles = [](const Primitive& primitive) { return primitive.isTriangles; };
    for (const auto& [mesh, bounds] : boundsOfMeshes(primitives, isTriangles))
        for (const auto& [semantic, each] : bounds) {
            if (semantic == "POSITION")
                error.positionExtent = std::max(error.positionExtent, static_cast<double>(each.lattice(1, 3).range));
            if (semantic == "TEXCOORD_1")
                error.lightMapUvExtent = std::max(error.lightMapUvExtent, static_cast<double>(each.lattice(1, 2).range));
        }
}

/// Adds the quantization of a Draco primitive to `error`.
void addBits(const Primitive& primitive, const DracoLattices& lattices, MeshError& error) {
    for (const MeshAttribute& attribute : primitive.geometry.attributes) {
        if (!mustBeFinite(attribute)) continue;
        const auto bits = lattices.bitsOfId.find(primitive.dracoIds.at(attribute.semantic));
        error.dracoBits[attribute.semantic].insert(bits == lattices.bitsOfId.end() ? 0 : bits->second);
    }
}

/// Returns the number of instances that a node draws: the elements of the accessors that place them, or 1.
std::int64_t instancesOf(const Json& gltf, const Json& node) {
    const auto member = [](const Json* owner, const char* key) -> const Json* {
        if (owner == nullptr || !owner->is_object()) return nullptr;
        const auto found = owner->find(key);
        return found == owner->end() ? nullptr : &*found;
    };
    const Json* const attributes = member(member(member(&node, "extensions"), "EXT_mesh_gpu_instancing"), "attributes");
    const Json* const accessors = member(&gltf, "accessors");
    std::int64_t most = 1;
    if (attributes == nullptr || !attributes->is_object() || accessors == nullptr || !accessors->is_array()) return most;
    for (const Json& index : *attributes) {
        if (!index.is_number_unsigned() || index.get<std::uint64_t>() >= accessors->size()) continue;
        const Json* const count = member(&(*accessors)[index.get<std::size_t>()], "count");
        if (count != nullptr && count->is_number_unsigned()) most = std::max(most, count->get<std::int64_t>());
    }
    return most;
}

/// Returns "node 5 'Dome'", or "mesh 3 'Sky'" of array "meshes".
std::string nameOfEntry(const Json& gltf, const char* array, const char* kind, std::size_t index) {
    const Json& entry = gltf[array][index];
    const auto name = entry.find("name");
    return fmt::format("{} {}{}", kind, index,
                       name != entry.end() && name->is_string() ? " '" + oneLine(name->get<std::string>()) + "'" : std::string());
}

/// Returns "mesh 3 'Sky' of node 5 'Dome'".
std::string nameOfMesh(const Json& gltf, std::uint64_t mesh) {
    std::string text = nameOfEntry(gltf, "meshes", "mesh", mesh);
    for (const std::size_t node : drawingNodes(gltf))
        if (gltf["nodes"][node]["mesh"] == mesh) return fmt::format("{} of {}", text, nameOfEntry(gltf, "nodes", "node", node));
    return text;
}

Result<void> checkOptions(const DracoOptions& options) {
    const auto outside = [](int value, int low, int high) { return value < low || value > high; };
    for (const auto& [name, bits] : {std::pair{"position", options.positionBits},
                                     {"normal", options.normalBits},
                                     {"uv", options.uvBits},
                                     {"light-map uv", options.lightMapUvBits}}) {
        if (outside(bits, 2, 30))
            return failure(ErrorCode::InvalidRequest, fmt::format("Draco {} bits", name), fmt::format("found {}, expected 2 to 30", bits));
    }
    if (outside(options.speed, 0, 10))
        return failure(ErrorCode::InvalidRequest, "Draco speed", fmt::format("found {}, expected 0 to 10", options.speed));
    return {};
}

}  // namespace

struct GltfScene::State {
    GltfDocument document;
    std::vector<Primitive> primitives;
    std::vector<MaterialNeeds> materials;
    std::int64_t vertexCount = 0, triangleCount = 0;
    bool hasLightMapUvs = false;
    std::optional<LmbakeMatch> lmbakeMatch = {};
    std::vector<std::string> nodesWithoutPlace = {};

    explicit State(GltfDocument read) : document(std::move(read)), primitives(readPrimitives(document)) {
        checkSceneRules(document);
        checkPlaces();
        readMaterials();
        std::set<std::uint64_t> counted;
        bool hasAny = false, hasAllTriangles = true;
        for (const Primitive& primitive : primitives) {
            const Json& json = document.json()["meshes"][primitive.mesh]["primitives"][primitive.index];
            if (counted.insert(json["attributes"]["POSITION"].get<std::uint64_t>()).second)
                vertexCount += static_cast<std::int64_t>(primitive.vertexCount);
            triangleCount += static_cast<std::int64_t>(primitive.geometry.triangleCount());
            const bool hasUvs = primitive.geometry.find("TEXCOORD_1") != nullptr;
            hasAny |= hasUvs;
            hasAllTriangles &= hasUvs || !primitive.isTriangles;
        }
        hasLightMapUvs = hasAny && hasAllTriangles;
    }

    /// Returns true if the material of a primitive shows both sides.
    bool isDoubleSided(const Primitive& primitive) const {
        const Json& json = document.json();
        const Json& own = json["meshes"][primitive.mesh]["primitives"][primitive.index];
        const auto list = json.find("materials"), index = own.find("material");
        if (index == own.end() || list == json.end() || !index->is_number_unsigned() || *index >= list->size()) return false;
        const Json& material = (*list)[index->get<std::size_t>()];
        const auto sides = material.find("doubleSided");
        return sides != material.end() && *sides == true;
    }

    /// Refuses vertices that lie too far away in the world.
    void checkPlaces() const {
        const auto places = placesOfMeshes(document.json());
        for (const Primitive& primitive : primitives) {
            const auto placed = places.find(primitive.mesh);
            const double reach = reachOf(*primitive.geometry.find("POSITION"));
            for (const NodePlacement& each : placed == places.end() ? std::vector{NodePlacement{0, glm::dmat4(1)}} : placed->second)
                if (!(reachOf(each.worldFromMesh, reach) <= kFarthest)) checkPlaces(primitive, each.worldFromMesh);
        }
    }
    void checkPlaces(const Primitive& primitive, const glm::dmat4& toWorld) const {
        const MeshAttribute& position = *primitive.geometry.find("POSITION");
        for (std::size_t vertex = 0; vertex < position.vertexCount(); ++vertex) {
            const glm::dvec3 at(toWorld * glm::dvec4(position.at(vertex), 1));
            if (glm::all(glm::lessThanEqual(glm::abs(at), glm::dvec3(kFarthest)))) continue;
            document.fail(ErrorCode::ValueOutOfRange, fmt::format("{}, POSITION, vertex {}", primitive.place(), vertex),
                          fmt::format("found ({:g}, {:g}, {:g}) in world space, expected coordinates from -{:g} to {:g}", at.x, at.y, at.z,
                                      kFarthest, kFarthest));
        }
    }

    /// Reads every material of the file, then glTF's default one if a primitive has none.
    void readMaterials() {
        for (const Json& material : document.json().value("materials", Json::array())) materials.push_back(materialNeeds(material));
        for (const Primitive& primitive : primitives) {
            const Json& json = document.json()["meshes"][primitive.mesh]["primitives"][primitive.index];
            const auto material = json.find("material");
            if (material == json.end() || (material->is_number_unsigned() && material->get<std::uint64_t>() < materials.size())) continue;
            document.fail(ErrorCode::ValueOutOfRange, fmt::format("{}, material", primitive.place()),
                          fmt::format("found {}, expected the index of one of {} materials", material->dump(), materials.size()));
        }
        const bool needsDefault = std::any_of(primitives.begin(), primitives.end(), [this](const Primitive& primitive) {
            return !document.json()["meshes"][primitive.mesh]["primitives"][primitive.index].contains("material");
        });
        if (!needsDefault) return;
        materials.push_back(materialNeeds(Json::object()));
        materials.back().name = "default";
    }
};

GltfScene::GltfScene(std::unique_ptr<State> state) : state_(std::move(state)) {}
GltfScene::GltfScene(GltfScene&&) noexcept = default;
GltfScene& GltfScene::operator=(GltfScene&&) noexcept = default;
GltfScene::~GltfScene() = default;

const std::vector<MaterialNeeds>& GltfScene::materials() const {
    return state_->materials;
}
bool GltfScene::hasLightMapUvs() const {
    return state_->hasLightMapUvs;
}
std::int64_t GltfScene::vertexCount() const {
    return state_->vertexCount;
}
std::int64_t GltfScene::triangleCount() const {
    return state_->triangleCount;
}

std::vector<std::filesystem::path> gltfFilesBeside(const std::filesystem::path& file, GltfFiles which) {
    constexpr std::array<const char*, 2> kArrays = {"buffers", "images"};
    const auto files = resultOf(
        file, [&] { return GltfDocument::withoutBuffers(file).filesBeside(std::span(kArrays).first(which == GltfFiles::All ? 2 : 1)); });
    return files.value_or(std::vector<std::filesystem::path>());
}

Result<void> checkLightMapUvs(const std::filesystem::path& file) {
    const auto hasUvs = resultOf(file, [&] {
        const GltfDocument document = GltfDocument::withoutBuffers(file);
        const std::set<std::uint64_t> meshes = meshesWithLightMapUvs(document);
        return std::ranges::any_of(placesOfMeshes(document.json()), [&](const auto& placed) { return meshes.contains(placed.first); });
    });
    if (!hasUvs) return tl::make_unexpected(hasUvs.error());
    if (!*hasUvs) return tl::make_unexpected(withoutLightMapUvs(file));
    return {};
}

Result<void> checkAllLightMapUvs(const std::filesystem::path& file, const std::vector<NodePlace>& places) {
    const auto faults = resultOf(file, [&] {
        const GltfDocument document = GltfDocument::withoutBuffers(file);
        const std::set<std::uint64_t> lit = meshesWithLightMapUvs(document);
        std::set<std::uint64_t> unlit = meshesWithoutLightMapUvs(document);
        // Without any, a light map is refused otherwise, with what its format offers in place of them.
        std::vector<std::string> names;
        if (lit.empty()) return names;
        if (!places.empty()) {
            const std::vector<std::size_t> drawing = drawingNodes(document.json()), placeOf = placesOfNodes(document, places);
            std::set<std::uint64_t> placed;
            for (std::size_t i = 0; i < drawing.size(); ++i)
                if (placeOf[i] != SIZE_MAX) placed.insert(document.json()["nodes"][drawing[i]]["mesh"].get<std::uint64_t>());
            std::erase_if(unlit, [&](std::uint64_t mesh) { return !placed.contains(mesh); });
        }
        for (const std::uint64_t mesh : unlit) names.push_back(nameOfMesh(document.json(), mesh));
        return names;
    });
    // The reader of the mesh says why it cannot be read.
    if (!faults || faults->empty()) return {};
    constexpr std::size_t kMostShown = 4;
    std::string list;
    for (std::size_t i = 0; i < std::min(faults->size(), kMostShown); ++i) list += (i > 0 ? ", " : "") + (*faults)[i];
    if (faults->size() > kMostShown) list += fmt::format(" and {} more", faults->size() - kMostShown);
    return failure(
        ErrorCode::WrongShape, file,
        fmt::format("found triangles without TEXCOORD_1 in {}, expected light-map UVs on all triangles: unwrap these too, put what no "
                    "light map lies on into a file of its own, or name the nodes that the light map lies on with "
                    "[[light_map.place]]",
                    list));
}

Error withoutLightMapUvs(const std::filesystem::path& file) {
    return {ErrorCode::WrongShape, file,
            "found no triangles with TEXCOORD_1, expected the light-map UVs of the surfaces that the bake lies on"};
}

Result<GltfScene> GltfScene::load(const std::filesystem::path& file) {
    auto scene = resultOf(file, [&] { return GltfScene(std::make_unique<State>(GltfDocument(file))); });
    if (!scene || !hasOtherLightMapUvs(scene->state_->document)) return scene;
    return std::move(*scene).changed(storeLightMapUvs);
}

Result<GltfScene> GltfScene::load(const std::filesystem::path& file, const std::filesystem::path& lmbake,
                                  const std::vector<NodePlace>& places) {
    auto scene = load(file);
    if (!scene || (lmbake.empty() && places.empty())) return scene;
    if (lmbake.empty()) {
        std::vector<std::string> unplaced;
        auto placed = std::move(*scene).changed([&](GltfDocument& document) { unplaced = placeNodes(document, places); });
        if (placed) placed->state_->nodesWithoutPlace = std::move(unplaced);
        return placed;
    }
    LC_TRY(baked, readLmbake(lmbake));
    LmbakeMatch match;
    auto placed = std::move(*scene).changed([&](GltfDocument& document) { match = placeNodes(document, *baked, lmbake); });
    if (placed) placed->state_->lmbakeMatch = std::move(match);
    return placed;
}

template <class Change>
Result<GltfScene> GltfScene::changed(Change change) && {
    const std::filesystem::path file = state_->document.file();
    if (std::ranges::any_of(state_->primitives, [](const Primitive& primitive) { return primitive.dracoView.has_value(); })) {
        LC_TRY(decoded, plain());
        *this = std::move(*decoded);
    }
    return resultOf(file, [&] {
        GltfDocument document = std::move(state_->document);
        change(document);
        return GltfScene(std::make_unique<State>(std::move(document)));
    });
}

const std::vector<std::string>& GltfScene::nodesWithoutPlace() const {
    return state_->nodesWithoutPlace;
}

Result<GltfScene> GltfScene::plain() const {
    const std::filesystem::path& file = state_->document.file();
    LC_TRY(glb, build({.isWithoutDraco = true}, file));
    return resultOf(file, [&] { return GltfScene(std::make_unique<State>(GltfDocument(state_->document, glb->bytes))); });
}

const std::optional<LmbakeMatch>& GltfScene::lmbakeMatch() const {
    return state_->lmbakeMatch;
}

std::vector<const TriangleMesh*> GltfScene::triangleMeshes() const {
    std::vector<const TriangleMesh*> meshes;
    for (const Primitive& primitive : state_->primitives)
        if (primitive.isTriangles) meshes.push_back(&primitive.geometry);
    return meshes;
}

std::string GltfScene::oldUvsAttribute() const {
    return freeUv(state_->primitives);
}

std::vector<GltfScene::Placed> GltfScene::placedMeshes() const {
    const auto places = placesOfMeshes(state_->document.json());
    std::vector<Placed> placed;
    for (const Primitive& primitive : state_->primitives) {
        const auto found = places.find(primitive.mesh);
        if (!primitive.isTriangles || found == places.end()) continue;
        const bool isDoubleSided = state_->isDoubleSided(primitive);
        for (const auto& [node, worldFromMesh] : found->second)
            placed.push_back({&primitive.geometry, worldFromMesh, isDoubleSided, node, primitive.index});
    }
    return placed;
}

std::string GltfScene::nameOfNode(std::size_t node) const {
    return nameOfEntry(state_->document.json(), "nodes", "node", node);
}

std::int64_t GltfScene::mostDrawn() const {
    const Json& gltf = state_->document.json();
    std::set<std::uint64_t> withTriangles;
    for (const Primitive& primitive : state_->primitives)
        if (primitive.isTriangles) withTriangles.insert(primitive.mesh);
    std::map<std::uint64_t, std::int64_t> draws;
    for (const std::size_t node : drawingNodes(gltf)) {
        const auto mesh = gltf["nodes"][node]["mesh"].get<std::uint64_t>();
        if (withTriangles.contains(mesh)) draws[mesh] += instancesOf(gltf, gltf["nodes"][node]);
    }
    std::int64_t most = 0;
    for (const auto& [mesh, count] : draws) most = std::max(most, count);
    return most;
}

Result<MeshSize> GltfScene::writeDraco(const std::filesystem::path& file, const DracoOptions& options, const ClusterMap* clusters) const {
    LC_CHECK(checkOptions(options));
    return write(file, {.draco = &options, .clusters = clusters});
}

Result<MeshSize> GltfScene::writePlain(const std::filesystem::path& file, const ClusterMap* clusters) const {
    return write(file, {.clusters = clusters});
}

Result<MeshSize> GltfScene::writeLightMapUvs(const std::filesystem::path& file, const std::vector<std::vector<glm::vec2>>& uvs) const {
    return write(file, {.lightMapUvs = &uvs});
}

Result<BuiltGlb> GltfScene::build(const GlbChanges& changes, const std::filesystem::path& file) const {
    auto glb = resultOf(state_->document.file(), [&] { return buildGlb(state_->document, state_->primitives, changes); });
    if (!glb) return glb;
    LC_CHECK(checkGlbSize(glb->bytes.size(), file));
    return glb;
}

Result<MeshSize> GltfScene::write(const std::filesystem::path& file, const GlbChanges& changes) const {
    LC_TRY(glb, build(changes, file));
    LC_CHECK(writeWholeFile(file, glb->bytes));
    return glb->size;
}

Result<MeshError> GltfScene::errorOf(const GltfScene& cooked) const {
    const std::vector<Primitive>& ours = state_->primitives;
    const std::vector<Primitive>& theirs = cooked.state_->primitives;
    const Subject subject(cooked.state_->document.file());
    if (ours.size() != theirs.size()) {
        return failure(ErrorCode::Verification, subject, fmt::format("found {} primitives, expected {}", theirs.size(), ours.size()));
    }
    if (const std::string what = otherThanGeometry(state_->document.json(), cooked.state_->document.json()); !what.empty())
        return failure(ErrorCode::Verification, subject, fmt::format("found other {}, expected those of the source", what));
    MeshError worst;
    setExtents(ours, worst);
    for (std::size_t i = 0; i < ours.size(); ++i) {
        if (!ours[i].isTriangles) continue;
        double step = 0;
        if (theirs[i].dracoView) {
            const auto stream = cooked.state_->document.bufferView(*theirs[i].dracoView);
            const auto found = dracoLattices(stream);
            if (!found) return failure(ErrorCode::Verification, subject, fmt::format("found \"{}\", expected a Draco mesh", found.error()));
            step = found->positionStep;
            if (!ours[i].dracoView || !std::ranges::equal(stream, state_->document.bufferView(*ours[i].dracoView)))
                addBits(theirs[i], *found, worst);
        }
        const auto match = matchTriangles(ours[i].geometry, theirs[i].geometry, step);
        if (!match) return failure(ErrorCode::Verification, subject.at(theirs[i].place()), match.error());
        worst.position = std::max(worst.position, match->position);
        worst.normalRadians = std::max(worst.normalRadians, match->normalRadians);
        worst.lightMapUv = std::max(worst.lightMapUv, match->lightMapUv);
    }
    return worst;
}

}  // namespace lightcook::formats

#include "pipeline/lint/mesh_facts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <set>

#include "formats/epic_light_maps.h"
#include "formats/gltf_scene.h"
#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/assets/mesh/mesh_inputs.h"
#include "pipeline/assets/results.h"
#include "pipeline/graph/parallel_for.h"
#include "pipeline/json/json.h"
#include "pipeline/lint/uv_raster.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

/// Distance from [0, 1] that rounding explains.
constexpr double kUvTolerance = 1e-4;
/// Length below which a normal counts as none.
constexpr double kShortestNormal = 0.5;
/// Visits for each texel of the map after which the rest of the triangles is left out: by then the mesh overlaps many times.
constexpr std::int64_t kMostVisits = 64;

/// Counts vertices and rasterizes the triangles of a mesh. Returns false after an interrupt.
bool addMesh(const formats::TriangleMesh& mesh, UvRaster& raster, MeshFacts& facts, const ActionContext& context) {
    const formats::MeshAttribute& uvs = *mesh.find("TEXCOORD_1");
    const formats::MeshAttribute* const normals = mesh.find("NORMAL");
    const auto isOutside = [](double value) { return value < -kUvTolerance || value > 1 + kUvTolerance; };
    facts.vertices += static_cast<std::int64_t>(mesh.vertexCount());
    for (std::size_t vertex = 0; vertex < mesh.vertexCount(); ++vertex) {
        const glm::dvec3 uv = uvs.at(vertex);
        facts.outside += isOutside(uv.x) || isOutside(uv.y) ? 1 : 0;
        facts.withoutNormal += normals != nullptr && glm::length(normals->at(vertex)) < kShortestNormal ? 1 : 0;
    }
    const std::int64_t most = kMostVisits * raster.read().width() * raster.read().height();
    for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
        if (context.state.interrupted) return false;
        if (raster.visits() > most) break;
        std::array<glm::dvec2, 3> corners;
        for (std::size_t k = 0; k < 3; ++k) corners[k] = glm::dvec2(uvs.at(mesh.indices[i + k]));
        raster.add(corners);
    }
    return true;
}

/// Measures the triangles of a mesh as a node draws them.
void addPlaced(const formats::GltfScene::Placed& placed, MeshFacts& facts) {
    const formats::MeshAttribute &uvs = *placed.mesh->find("TEXCOORD_1"), &positions = *placed.mesh->find("POSITION");
    const auto areaOf = [](const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
        return glm::length(glm::cross(b - a, c - a)) / 2;
    };
    const auto world = [&](std::uint32_t vertex) { return glm::dvec3(placed.worldFromMesh * glm::dvec4(positions.at(vertex), 1)); };
    const auto uv = [&](std::uint32_t vertex) { return glm::dvec3(glm::dvec2(uvs.at(vertex)), 0); };
    for (std::size_t i = 0; i + 2 < placed.mesh->indices.size(); i += 3) {
        const std::uint32_t* const corner = &placed.mesh->indices[i];
        const double area = areaOf(uv(corner[0]), uv(corner[1]), uv(corner[2]));
        facts.uvArea += area;
        if (areaOf(world(corner[0]), world(corner[1]), world(corner[2])) == 0) facts.flatUvArea += area;
    }
}

std::vector<UnreadMaterial> unreadMaterialsOf(const formats::GltfScene& scene) {
    std::vector<UnreadMaterial> unread;
    for (std::size_t i = 0; i < scene.materials().size(); ++i) {
        const formats::MaterialNeeds& each = scene.materials()[i];
        if (each.unreadExtensions.empty()) continue;
        unread.push_back({i, each.name, each.unreadExtensions, each.isSpecular, {each.mMin, each.mMax}, {each.f0Min, each.f0Max}});
    }
    return unread;
}

/// Fails for a scene that shows no triangles.
Result<void> checkShown(bool hasTriangles, bool isDrawn, const std::string& file) {
    using formats::ErrorCode, formats::failure;
    if (!hasTriangles) return failure(ErrorCode::WrongShape, file, "found no triangles, expected the mesh that was baked");
    if (!isDrawn)
        return failure(ErrorCode::WrongShape, file, "found no node that draws a mesh of triangles, expected the scene that was baked");
    return {};
}

/// Returns the covered texels of a light map.
Result<TexelSet> coverageOf(LightMapSource& source, const ActionContext& context) {
    TexelSet covered(source.width(), source.height());
    using Chunk = std::shared_ptr<const formats::LightMapStrip>;
    const auto read = foldInOrder<Chunk>(
        source.chunkCount(), context, "lint " + context.action.asset, [&](int index) { return source.chunk(index); },
        [&](const Chunk& chunk) {
            for (int y = 0; y < chunk->covered.height(); ++y)
                for (int x = 0; x < chunk->covered.width(); ++x)
                    if (chunk->covered.at(x, y) != 0) covered.add(x, chunk->firstRow + y);
        });
    if (!read) return tl::make_unexpected(read.error());
    return covered;
}

}  // namespace

Result<ActionOutcome> lintMesh(const ActionContext& context) {
    const auto parameters = parametersOf<MeshLintParameters>(context);
    if (!parameters) return tl::make_unexpected(parameters.error());
    const auto scene = loadMesh(context.action.inputs, kMeshRole, parameters->description.places);
    if (!scene) return tl::make_unexpected(scene.error());
    const auto uvs =
        formats::checkEpicUvs(context.action.inputs.at("source"), context.action.inputs.at(kMeshRole), parameters->description.image);
    if (!uvs) return tl::make_unexpected(uvs.error());
    MeshFacts facts;
    if (const auto& match = scene->lmbakeMatch()) {
        for (const std::string& node : match->unplaced) facts.unplaced.push_back(asUtf8(node));
        for (const std::string& user : match->unread) facts.unread.push_back(asUtf8(user));
    }
    facts.unreadMaterials = unreadMaterialsOf(*scene);
    const std::vector<const formats::TriangleMesh*> meshes = scene->triangleMeshes();
    const auto placed = scene->placedMeshes();
    if (auto shown = checkShown(!meshes.empty(), !placed.empty(), context.action.inputs.at(kMeshRole).string()); !shown)
        return tl::make_unexpected(shown.error());
    facts.mostDrawn = scene->mostDrawn();
    std::set<const formats::TriangleMesh*> drawn;
    for (const auto& each : placed) drawn.insert(each.mesh);
    facts.hasUvs = std::ranges::all_of(meshes, [](const auto* mesh) { return mesh->find("TEXCOORD_1") != nullptr; });
    if (!facts.hasUvs) return outcomeWith(facts);
    const auto source = openLightMap(context, parameters->description);
    if (!source) return tl::make_unexpected(source.error());
    const auto covered = coverageOf(**source, context);
    if (!covered) return tl::make_unexpected(covered.error());
    const int width = (*source)->width(), height = (*source)->height();
    UvRaster raster(width, height);
    for (const auto& each : placed) {
        if (context.state.interrupted) return interrupted(context);
        addPlaced(each, facts);
    }
    for (const formats::TriangleMesh* mesh : meshes)
        if (drawn.contains(mesh) && !addMesh(*mesh, raster, facts, context)) return interrupted(context);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            if (!raster.read().has(x, y)) continue;
            facts.uncovered += covered->has(x, y) ? 0 : 1;
            facts.uncoveredIfFlipped += covered->has(x, height - 1 - y) ? 0 : 1;
        }
    facts.read = raster.read().count();
    facts.shared = raster.shared().count();
    return outcomeWith(facts);
}

}  // namespace lightcook::pipeline

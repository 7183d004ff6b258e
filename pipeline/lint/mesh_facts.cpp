#include "pipeline/lint/mesh_facts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <optional>
#include <set>
#include <utility>

#include "formats/bake_format.h"
#include "formats/epic_light_maps.h"
#include "formats/gltf_scene.h"
#include "formats/vocabulary.h"
#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/assets/mesh/mesh_inputs.h"
#include "pipeline/assets/results.h"
#include "pipeline/document/json.h"
#include "pipeline/graph/parallel_for.h"
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
Result<void> checkShown(bool hasTriangles, bool isDrawn, const std::filesystem::path& file) {
    using formats::ErrorCode, formats::failure;
    if (!hasTriangles) return failure(ErrorCode::WrongShape, file, "found no triangles, expected the mesh that was baked");
    if (!isDrawn)
        return failure(ErrorCode::WrongShape, file, "found no node that draws a mesh of triangles, expected the scene that was baked");
    return {};
}

/// Largest shares of unread and of empty texels of a mesh that fits its map, above which other UVs are tried.
constexpr double kTryOthers = 0.005;

/// A change of light-map UVs.
struct UvChange {
    std::string name;
    bool isExchanged = false;  ///< U and V
    glm::dvec2 scale{1}, offset{0};
    glm::dvec2 operator()(const glm::dvec2& uv) const { return (isExchanged ? glm::dvec2(uv.y, uv.x) : uv) * scale + offset; }
};

/// The lowest and the highest of some places.
struct Box {
    glm::dvec2 low{HUGE_VAL}, high{-HUGE_VAL};
    void add(const glm::dvec2& place) {
        low = glm::min(low, place);
        high = glm::max(high, place);
    }
    glm::dvec2 size() const { return high - low; }
};

/// Light-map UVs of the triangles of drawn meshes, against the texels of their map that hold something.
class UvFit {
public:
    UvFit(std::vector<const formats::TriangleMesh*> meshes, const TexelSet& marked) : meshes_(std::move(meshes)), marked_(marked) {}

    /// Returns how UVs fit after changes: the turns and reflections of a square, and a scale and an offset, which bring the bounds of the
    /// UVs to those of the texels less a margin.
    std::vector<OtherUvs> others() const {
        std::vector<OtherUvs> found;
        for (const UvChange& change : {UvChange{kFlippedV, false, {1, -1}, {0, 1}}, UvChange{"U upside down", false, {-1, 1}, {1, 0}},
                                       UvChange{"U and V upside down", false, {-1, -1}, {1, 1}}, UvChange{"U and V exchanged", true},
                                       UvChange{"U and V exchanged and then V upside down", true, {1, -1}, {0, 1}},
                                       UvChange{"U and V exchanged and then U upside down", true, {-1, 1}, {1, 0}},
                                       UvChange{"U and V exchanged and then both upside down", true, {-1, -1}, {1, 1}}})
            found.push_back({change.name, matchAfter(change), true});
        std::optional<OtherUvs> best;
        for (const double margin : {0.0, 1.0, 2.0, 4.0, 8.0})
            if (const auto change = toBoundsOf(margin)) {
                constexpr double kSameScale = 0.02;
                const bool keepsArea = glm::length(change->scale - 1.0) <= kSameScale;
                OtherUvs other{change->name, matchAfter(*change), keepsArea};
                if (!best || faults(other.match) < faults(best->match)) best = std::move(other);
            }
        if (best) found.push_back(std::move(*best));
        return found;
    }

private:
    static std::int64_t faults(const MapMatch& match) { return match.empty + match.unread; }

    template <class Visit>
    void visitUvs(Visit visit) const {
        for (const formats::TriangleMesh* mesh : meshes_) {
            const formats::MeshAttribute& uvs = *mesh->find("TEXCOORD_1");
            for (const std::uint32_t index : mesh->indices) visit(glm::dvec2(uvs.at(index)));
        }
    }
    MapMatch matchAfter(const UvChange& change) const {
        UvRaster raster(marked_.width(), marked_.height());
        std::array<glm::dvec2, 3> corners;
        std::size_t corner = 0;
        visitUvs([&](const glm::dvec2& uv) {
            corners[corner++ % 3] = change(uv);
            if (corner % 3 == 0) raster.add(corners);
        });
        return matchOf(raster, marked_);
    }
    /// margin  of the charts in the map [texels]
    std::optional<UvChange> toBoundsOf(double margin) const {
        const glm::dvec2 texels(marked_.width(), marked_.height());
        Box uvs, lit;
        visitUvs([&](const glm::dvec2& uv) { uvs.add(uv); });
        for (int y = 0; y < marked_.height(); ++y)
            for (int x = 0; x < marked_.width(); ++x)
                if (marked_.has(x, y)) {
                    lit.add(glm::dvec2(x, y) + margin);
                    lit.add(glm::dvec2(x + 1, y + 1) - margin);
                }
        if (!(uvs.size().x > 0 && uvs.size().y > 0 && lit.size().x > 0 && lit.size().y > 0)) return std::nullopt;
        UvChange change;
        change.scale = lit.size() / texels / uvs.size();
        change.offset = lit.low / texels - uvs.low * change.scale;
        change.name = fmt::format("UVs times ({:.3g}, {:.3g}) plus ({:.2g}, {:.2g})", change.scale.x, change.scale.y, change.offset.x,
                                  change.offset.y);
        return change;
    }

    std::vector<const formats::TriangleMesh*> meshes_;
    const TexelSet& marked_;
};

/// Returns the description by which the light of a map is read everywhere, also outside the mesh. Nothing that is not finite is refused.
formats::LightMapDescription everywhere(const formats::LightMapDescription& source, const std::string& bake) {
    const formats::BakeFormatInfo* const format = formats::findByName(formats::allBakeFormats(), bake);
    formats::LightMapDescription description;
    // The light of a bake that is relative to surfaces is in its first picture.
    description.bake = format != nullptr && format->needsMesh() ? "flat" : source.bake;
    description.encoding = source.encoding;
    description.image = source.image;
    description.colors = source.colors;
    description.parts = source.parts;
    description.partFiles = source.partFiles;
    description.fireflyLimit = 0;
    description.repair = true;
    description.isCompressed = true;
    return description;
}

/// Share of the mean light (of logarithms) of the texels that the mesh reads, below which a texel holds none: noise of a denoiser.
constexpr double kLeastLight = 0.01;

/// Returns the texels that hold light, or are covered if the file says which are.
/// read  texels of the mesh
Result<TexelSet> markedTexels(const ActionContext& context, const formats::LightMapDescription& description, const std::string& bake,
                              const TexelSet& read) {
    LC_TRY(source, openLightMap(context, everywhere(description, bake)));
    const int width = (*source)->width(), height = (*source)->height();
    std::vector<float> light(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0.0f);
    TexelSet marked(width, height);
    double logSum = 0;
    std::int64_t lit = 0;
    using Chunk = std::shared_ptr<const formats::LightMapStrip>;
    std::size_t index = 0;
    const bool hasCoverage = (*source)->hasCoverage();
    const auto done = foldInOrder<Chunk>((*source)->chunkCount(), context, "lint " + context.action.asset,
                                         [&](int chunk) { return (*source)->chunk(chunk); },
                                         [&](const Chunk& chunk) {
                                             for (int y = 0; y < chunk->sh.height(); ++y)
                                                 for (int x = 0; x < width; ++x, ++index) {
                                                     const glm::vec3& rgb = chunk->sh.at(x, y)[0];
                                                     light[index] = std::max({rgb.x, rgb.y, rgb.z, 0.0f});
                                                     if (hasCoverage && chunk->covered.at(x, y) != 0) marked.add(x, chunk->firstRow + y);
                                                     if (!(light[index] > 0) || !read.has(x, chunk->firstRow + y)) continue;
                                                     logSum += std::log(static_cast<double>(light[index]));
                                                     ++lit;
                                                 }
                                         });
    if (!done) return tl::make_unexpected(done.error());
    if (hasCoverage) return marked;
    const double least = lit > 0 ? kLeastLight * std::exp(logSum / static_cast<double>(lit)) : 0.0;
    index = 0;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x, ++index)
            if (light[index] > least) marked.add(x, y);
    return marked;
}

/// Compares the mesh with its map.
Result<void> fitToMap(const ActionContext& context, const formats::LightMapDescription& description, const std::string& bake,
                      std::vector<const formats::TriangleMesh*> drawn, const UvRaster& raster, MeshFacts& facts) {
    const auto marked = markedTexels(context, description, bake, raster.read());
    if (!marked && context.state.interrupted) return tl::make_unexpected(marked.error());
    // A map that can be read on its mesh alone is not compared.
    if (!marked || marked->width() != raster.read().width() || marked->height() != raster.read().height()) return {};
    facts.match = matchOf(raster, *marked);
    const auto isSmall = [](std::int64_t part, std::int64_t whole) {
        return static_cast<double>(part) <= kTryOthers * static_cast<double>(whole);
    };
    if (isSmall(facts.match.unread, facts.match.marked) && isSmall(facts.match.empty, facts.match.read)) return {};
    facts.others = UvFit(std::move(drawn), *marked).others();
    return {};
}

/// Returns the covered texels of a light map.
Result<TexelSet> texelsOf(LightMapSource& source, const ActionContext& context) {
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
    LC_TRY(parameters, parametersOf<MeshLintParameters>(context));
    LC_TRY(scene, loadMesh(context.action.inputs, kMeshRole, parameters->description.places));
    const auto uvs =
        formats::checkEpicUvs(context.action.inputs.at("source"), context.action.inputs.at(kMeshRole), parameters->description.image);
    if (!uvs) return tl::make_unexpected(uvs.error());
    MeshFacts facts;
    if (const auto& match = scene->lmbakeMatch()) {
        for (const std::string& node : match->unplaced) facts.unplaced.push_back(asUtf8(node));
        for (const std::string& user : match->unread) facts.unread.push_back(asUtf8(user));
    }
    for (const std::string& node : scene->nodesWithoutPlace()) facts.withoutPlace.push_back(asUtf8(node));
    facts.unreadMaterials = unreadMaterialsOf(*scene);
    const std::vector<const formats::TriangleMesh*> meshes = scene->triangleMeshes();
    const auto placed = scene->placedMeshes();
    LC_CHECK(checkShown(!meshes.empty(), !placed.empty(), context.action.inputs.at(kMeshRole)));
    facts.mostDrawn = scene->mostDrawn();
    std::set<const formats::TriangleMesh*> drawn;
    for (const auto& each : placed) drawn.insert(each.mesh);
    facts.hasUvs = std::ranges::all_of(meshes, [](const auto* mesh) { return mesh->find("TEXCOORD_1") != nullptr; });
    if (!facts.hasUvs) return outcomeWith(facts);
    LC_TRY(source, openLightMap(context, parameters->description));
    LC_TRY(covered, texelsOf(**source, context));
    const int width = (*source)->width(), height = (*source)->height();
    UvRaster raster(width, height);
    for (const auto& each : placed) {
        if (context.state.interrupted) return interrupted(context);
        addPlaced(each, facts);
    }
    std::vector<const formats::TriangleMesh*> drawnMeshes;
    for (const formats::TriangleMesh* mesh : meshes) {
        if (!drawn.contains(mesh)) continue;
        drawnMeshes.push_back(mesh);
        if (!addMesh(*mesh, raster, facts, context)) return interrupted(context);
    }
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            if (!raster.read().has(x, y)) continue;
            facts.uncovered += covered->has(x, y) ? 0 : 1;
            facts.uncoveredIfFlipped += covered->has(x, height - 1 - y) ? 0 : 1;
        }
    facts.read = raster.read().count();
    facts.shared = raster.shared().count();
    // A mesh whose triangles overlap many times is not read to its end.
    if (const std::int64_t all = std::int64_t{width} * height; raster.visits() <= kMostVisits * all)
        LC_CHECK(fitToMap(context, parameters->description, (*source)->reading().bake, std::move(drawnMeshes), raster, facts));
    return outcomeWith(facts);
}

}  // namespace lightcook::pipeline

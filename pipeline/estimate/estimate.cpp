// Steps: read the surfaces (readSurfaces), find out whether their UVs share one image (useOf), form the images (imagesOf), count charts and
// shared texels in each (measure), place the images on pages, and add up memory and time (layoutsOf).
#include "pipeline/estimate/estimate.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <set>
#include <utility>

#include "atlas/charts.h"
#include "atlas/pages.h"
#include "formats/gltf_scene.h"
#include "pipeline/cook/plan.h"
#include "pipeline/estimate/cook_rates.h"
#include "pipeline/graph/work_rates.h"
#include "pipeline/lint/uv_raster.h"
#include "pipeline/report/words.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::GltfScene;
using formats::Result;
using formats::TriangleMesh;

constexpr const char* kUvs = "TEXCOORD_1";
/// Share of the texels that nodes read, above which those that several read say that each node has an image of its own. Lint warns from
/// 0.03 on; two nodes that each fill a fifth of an image of their own share 0.11.
constexpr double kMostSharedByNodes = 0.1;
/// Side of the image in which that is looked at [texels].
constexpr int kSideOfUse = 256;
/// Side from which on an image is not larger: beyond what its memory is a number for [texels].
constexpr double kLargestSide = 1 << 20;

/// A triangle primitive as a node draws it.
struct Surface {
    const TriangleMesh* mesh;
    formats::Subject name;  ///< "room.glb, node 3 'Wall', primitive 2"
    std::size_t node = 0;   ///< over all files
    std::size_t primitive = 0;
    double area = 0, uvArea = 0;
    std::size_t part = 0;  ///< index in Estimate::parts
    bool hasUvs() const { return uvArea > 0; }
};

struct Surfaces {
    std::vector<GltfScene> scenes;  ///< own the meshes
    std::vector<Surface> all;
    std::vector<std::string> nodes;  ///< names
};

/// Adds the areas of a surface's triangles.
void measureArea(const GltfScene::Placed& placed, Surface& surface) {
    const formats::MeshAttribute *const uvs = placed.mesh->find(kUvs), &positions = *placed.mesh->find("POSITION");
    const auto twice = [](const std::array<glm::dvec3, 3>& corners) {
        return glm::length(glm::cross(corners[1] - corners[0], corners[2] - corners[0]));
    };
    for (std::size_t i = 0; i + 2 < placed.mesh->indices.size(); i += 3) {
        std::array<glm::dvec3, 3> world, uv{};
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t vertex = placed.mesh->indices[i + k];
            world[k] = glm::dvec3(placed.worldFromMesh * glm::dvec4(positions.at(vertex), 1));
            if (uvs != nullptr) uv[k] = glm::dvec3(glm::dvec2(uvs->at(vertex)), 0);
        }
        surface.area += twice(world) / 2;
        surface.uvArea += twice(uv) / 2;
    }
}

Result<Surfaces> readSurfaces(const std::vector<std::filesystem::path>& files) {
    Surfaces surfaces;
    for (const std::filesystem::path& file : files) {
        LC_TRY(scene, GltfScene::load(file));
        const std::vector<GltfScene::Placed> placed = scene->placedMeshes();
        if (placed.empty()) return failure(ErrorCode::WrongShape, file, "found no node that draws a mesh of triangles, expected a scene");
        std::map<std::size_t, std::size_t> nodes;  // of the file, to those of all files
        for (const GltfScene::Placed& each : placed) {
            const std::string name = scene->nameOfNode(each.node);
            const auto [node, isNew] = nodes.try_emplace(each.node, surfaces.nodes.size());
            if (isNew) surfaces.nodes.push_back(fmt::format("{}, {}", file.filename().string(), name));
            const formats::Subject place = formats::Subject(file).at(fmt::format("{}, primitive {}", name, each.primitive));
            measureArea(each, surfaces.all.emplace_back(Surface{each.mesh, place, node->second, each.primitive}));
        }
        surfaces.scenes.push_back(std::move(*scene));
    }
    return surfaces;
}

void addTo(UvRaster& raster, const TriangleMesh& mesh) {
    const formats::MeshAttribute& uvs = *mesh.find(kUvs);
    for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
        std::array<glm::dvec2, 3> corners;
        for (std::size_t k = 0; k < 3; ++k) corners[k] = glm::dvec2(uvs.at(mesh.indices[i + k]));
        raster.add(corners);
    }
}

UvUse useOf(const Surfaces& surfaces) {
    std::vector<int> readers(static_cast<std::size_t>(kSideOfUse) * kSideOfUse, 0);  // nodes that read each texel
    for (std::size_t node = 0; node < surfaces.nodes.size(); ++node) {
        UvRaster raster(kSideOfUse, kSideOfUse);
        for (const Surface& surface : surfaces.all)
            if (surface.node == node && surface.hasUvs()) addTo(raster, *surface.mesh);
        for (int y = 0; y < kSideOfUse; ++y)
            for (int x = 0; x < kSideOfUse; ++x) readers[static_cast<std::size_t>(y * kSideOfUse + x)] += raster.read().has(x, y) ? 1 : 0;
    }
    const auto read = std::ranges::count_if(readers, [](int nodes) { return nodes > 0; });
    const auto shared = std::ranges::count_if(readers, [](int nodes) { return nodes > 1; });
    return static_cast<double>(shared) > kMostSharedByNodes * static_cast<double>(read) ? UvUse::Each : UvUse::Shared;
}

/// Surfaces whose light-map UVs are places in one image.
struct LightMapImage {
    std::string name;  ///< for errors
    std::vector<const Surface*> surfaces;
    double side = 0;  ///< that the density asks for [texels]

    bool hasUvs() const { return surfaces.front()->hasUvs(); }
    /// Returns the side in whole blocks.
    int blockSide() const { return static_cast<int>(std::ceil(std::min(side, kLargestSide) / atlas::kPageStep)) * atlas::kPageStep; }
};

LightMapImage imageOf(std::string name, std::vector<const Surface*> surfaces, double density) {
    double area = 0, uvArea = 0;
    for (const Surface* surface : surfaces) {
        area += surface->area;
        uvArea += surface->uvArea;
    }
    return {std::move(name), std::move(surfaces), std::max(1.0, density * std::sqrt(area / (uvArea > 0 ? uvArea : 1)))};
}

std::vector<LightMapImage> imagesOf(const Surfaces& surfaces, UvUse use, double density) {
    std::map<std::size_t, std::vector<const Surface*>> together;  // all, or by node
    std::vector<LightMapImage> images;
    for (const Surface& surface : surfaces.all)
        if (surface.hasUvs()) together[use == UvUse::Shared ? 0 : surface.node].push_back(&surface);
    for (auto& [node, members] : together) {
        const bool isOfOne = use == UvUse::Each || surfaces.nodes.size() == 1;
        std::string name = isOfOne ? surfaces.nodes[node] : std::string("the image of all nodes");
        images.push_back(imageOf(std::move(name), std::move(members), density));
    }
    for (const Surface& surface : surfaces.all)
        if (!surface.hasUvs() && surface.area > 0) images.push_back(imageOf(surface.name.text, {&surface}, density));
    return images;
}

/// Returns the number of texels of an image in a chart's quads, of which each reaches `reach` texels to the right and down.
std::int64_t texelsWithin(const atlas::Chart& chart, int reach, int side) {
    const auto inside = [side](int place) { return std::clamp(place, 0, side); };
    // Of each column of the rows above: the rows down to which quads reach.
    std::vector<int> until(static_cast<std::size_t>(chart.quads.x), -1);
    std::int64_t texels = 0;
    for (int y = 0; y < chart.quads.y + reach; ++y) {
        const int row = chart.first.y + y;
        int end = 0;  // of the texels of this row that are counted
        for (int x = 0; x < chart.quads.x; ++x) {
            int& reached = until[static_cast<std::size_t>(x)];
            if (y < chart.quads.y && chart.reaches(x, y)) reached = y + reach;
            if (reached < y) continue;
            const int begin = std::max(x, std::exchange(end, x + reach + 1));
            if (row >= 0 && row < side) texels += inside(chart.first.x + end) - inside(chart.first.x + begin);
        }
    }
    return texels;
}

/// Counts charts and shared texels of an image.
Result<void> measure(const LightMapImage& image, const EstimateOptions& options, const RunState& state, std::vector<EstimatedPart>& parts) {
    std::vector<const TriangleMesh*> meshes;
    std::vector<formats::Subject> names;
    for (const Surface* surface : image.surfaces) {
        meshes.push_back(surface->mesh);
        names.push_back(surface->name);
    }
    const int side = std::min(image.blockSide(), options.largestPage);
    // Of an image beyond the largest page: what its texels are to those that are looked at.
    const double scale = static_cast<double>(image.blockSide()) / side;
    const auto scaled = [](std::int64_t texels, double by) { return std::llround(static_cast<double>(texels) * by); };
    LC_TRY(found, atlas::findCharts(meshes, names, side, side));
    for (const atlas::Chart& chart : found->charts) {
        EstimatedPart& part = parts[image.surfaces[chart.mesh]->part];
        const std::int64_t read = texelsWithin(chart, 1, side), padding = texelsWithin(chart, 1 + options.padding, side) - read;
        part.texels += scaled(read, scale * scale);
        part.paddingTexels += scaled(padding, scale);
        part.smallCharts += padding > read ? 1 : 0;
        ++part.charts;
    }
    UvRaster raster(side, side);
    std::int64_t shared = 0;
    for (const Surface* surface : image.surfaces) {
        if (state.interrupted) return failure(ErrorCode::Interrupted, image.name, "interrupted");
        addTo(raster, *surface->mesh);
        const std::int64_t before = std::exchange(shared, raster.shared().count());
        parts[surface->part].sharedTexels += scaled(shared - before, scale * scale);
    }
    return {};
}

/// Returns the parts, and sets those of the surfaces.
std::vector<EstimatedPart> partsOf(Surfaces& surfaces) {
    std::vector<EstimatedPart> parts;
    const bool isOneNode = surfaces.nodes.size() == 1;
    if (!isOneNode)
        for (const std::string& node : surfaces.nodes) parts.push_back({.name = node});
    for (Surface& surface : surfaces.all) {
        surface.part = isOneNode ? parts.size() : surface.node;
        if (isOneNode) parts.push_back({.name = fmt::format("{}, primitive {}", surfaces.nodes.front(), surface.primitive)});
        parts[surface.part].area += surface.area;
    }
    return parts;
}

/// Sets density and side of the parts of an image.
void setDensities(const LightMapImage& image, UvUse use, std::vector<EstimatedPart>& parts) {
    std::map<std::size_t, std::pair<double, double>> areas;  // of each part, in the world and of UVs
    for (const Surface* surface : image.surfaces) {
        areas[surface->part].first += surface->area;
        areas[surface->part].second += surface->uvArea;
    }
    for (const auto& [part, area] : areas) {
        if (area.first > 0) parts[part].density = image.side * std::sqrt(area.second / area.first);
        if (use == UvUse::Each) parts[part].side = image.blockSide();
    }
}

/// Returns the most that the tables of a learned layout take of a page: a sixth of its first textures, and not those of more than 64
/// clusters (compress::LightMapTraining).
std::uint64_t mostTableBytes(const formats::LightMapLayoutInfo& layout, formats::Target target, const glm::ivec2& page) {
    if (!layout.isLearned()) return 0;
    std::uint64_t first = 0;
    for (const formats::LightMapTextureInfo& texture : layout.textures.first(2))
        first += static_cast<std::uint64_t>(texture.layerCount) *
                 formats::bytesPerImage(formats::formatFor(texture.role, formats::info(target)), page.x, page.y);
    return std::min<std::uint64_t>(first / 6, std::uint64_t{64} * static_cast<std::uint64_t>(layout.clusterTableBytes()));
}

std::vector<EstimatedLayout> layoutsOf(const EstimateOptions& options, const Estimate& estimate, const WorkRates& rates) {
    std::vector<EstimatedLayout> layouts;
    const auto texels = static_cast<double>(estimate.texels);
    for (const formats::LightMapLayoutInfo& info : formats::allLightMapLayouts()) {
        if (options.layout && *options.layout != info.id) continue;
        EstimatedLayout layout{.layout = std::string(info.name)};
        const std::vector<SkippedImages> images = texturesOf(info, options.target, info.usualFilter());
        for (const EstimatedPage& page : estimate.pages) {
            const glm::ivec2 size(page.width, page.height);
            layout.bytesGpu += bytesOf(images, size) + mostTableBytes(info, options.target, size);
        }
        layout.bitsPerTexel = 8 * static_cast<double>(layout.bytesGpu) / texels;
        const std::optional<double> seconds = rates.secondsOf(kLayoutWork + layout.layout, texels);
        layout.seconds = seconds.value_or(measuredSecondsPerMegatexel(info.id) * texels * 1e-6);
        layout.isMeasuredHere = seconds.has_value();
        if (options.budgetBytes) layout.passed = layout.bytesGpu <= *options.budgetBytes;
        layouts.push_back(std::move(layout));
    }
    return layouts;
}

/// Returns the errors of images that no page holds: bakers find it out when all light is computed.
std::vector<formats::Error> errorsOfSize(const std::vector<LightMapImage>& images, const EstimateOptions& options) {
    std::vector<formats::Error> errors;
    for (const LightMapImage& image : images) {
        if (image.blockSide() <= options.largestPage) continue;
        errors.push_back(
            {ErrorCode::WrongShape, image.name,
             fmt::format("found {0:.0f} x {0:.0f} texels, expected at most {1} x {1}, the largest page: a bake of it fails at "
                         "its end. Divide the mesh, or ask for a density of at most {2:.3g}",
                         std::ceil(image.side), options.largestPage, options.texelDensity * options.largestPage / image.side)});
    }
    return errors;
}

/// Returns the error of a budget that no layout keeps.
std::optional<formats::Error> errorOfBudget(const Estimate& estimate) {
    const auto smallest = std::ranges::min_element(estimate.layouts, {}, &EstimatedLayout::bytesGpu);
    if (smallest->passed.value_or(true)) return std::nullopt;
    const double fitting = std::sqrt(static_cast<double>(*estimate.budgetBytes) / static_cast<double>(smallest->bytesGpu));
    return formats::Error{
        ErrorCode::OverBudget, "--budget",
        fmt::format("{}, in layout {}{}. A density of about {:.3g} fits", overBudgetWords(smallest->bytesGpu, *estimate.budgetBytes),
                    smallest->layout, estimate.layouts.size() > 1 ? ", the smallest" : "", fitting * estimate.texelDensity)};
}

/// Returns the pages of images. One beyond the largest page counts as a page of its own size.
std::vector<EstimatedPage> pagesOf(const std::vector<LightMapImage>& images, const EstimateOptions& options) {
    std::vector<EstimatedPage> pages;
    std::vector<int> sides;
    for (const LightMapImage& image : images) {
        const int side = image.blockSide();
        if (side <= options.largestPage)
            sides.push_back(side);
        else
            pages.push_back({side, side});
    }
    for (const glm::ivec2& size : atlas::packSquares(sides, options.padding, options.largestPage).sizes) pages.push_back({size.x, size.y});
    return pages;
}

}  // namespace

Result<Estimate> estimateLightMaps(const EstimateOptions& options, const RunState& state) {
    LC_TRY(surfaces, readSurfaces(options.meshes));
    Estimate estimate{.texelDensity = options.texelDensity,
                      .padding = options.padding,
                      .largestPage = options.largestPage,
                      .target = options.target,
                      .uvs = useOf(*surfaces),
                      .budgetBytes = options.budgetBytes};
    estimate.parts = partsOf(*surfaces);
    const std::vector<LightMapImage> images = imagesOf(*surfaces, estimate.uvs, options.texelDensity);
    if (images.empty()) return failure(ErrorCode::WrongShape, options.meshes.front(), "found no triangle with an area, expected a surface");
    for (const LightMapImage& image : images) {
        if (image.hasUvs()) {
            LC_CHECK(measure(image, options, state, estimate.parts));
            setDensities(image, estimate.uvs, estimate.parts);
        } else {
            ++estimate.withoutUvs;
            estimate.parts[image.surfaces.front()->part].texels += std::int64_t{image.blockSide()} * image.blockSide();
        }
    }
    estimate.pages = pagesOf(images, options);
    for (const EstimatedPage& page : estimate.pages) estimate.texels += std::int64_t{page.width} * page.height;
    for (const EstimatedPart& part : estimate.parts) {
        estimate.readTexels += part.texels;
        estimate.paddingTexels += part.paddingTexels;
    }
    std::ranges::stable_sort(estimate.parts, std::ranges::greater{}, &EstimatedPart::texels);

    const WorkRates rates(options.rates);
    estimate.layouts = layoutsOf(options, estimate, rates);
    const auto trial = rates.secondsOf(kTrialWork, static_cast<double>(estimate.texels));
    estimate.trialSeconds = trial.value_or(measuredTrialSecondsPerMegatexel() * static_cast<double>(estimate.texels) * 1e-6);
    estimate.isTrialMeasuredHere = trial.has_value();
    estimate.errors = errorsOfSize(images, options);
    if (auto error = errorOfBudget(estimate)) estimate.errors.push_back(std::move(*error));
    return estimate;
}

}  // namespace lightcook::pipeline

#include "pipeline/assets/light_map/seams.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <utility>

#include "pipeline/assets/light_map/checked_light_map.h"
#include "pipeline/assets/light_map/rendered_view.h"
#include "pipeline/graph/parallel_for.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;
using verify::SeamStep;

constexpr std::size_t kBatchBytes = std::size_t{48} << 20;
constexpr std::size_t kPlacesOfTask = 1024;
constexpr std::size_t kWorst = 4;
constexpr double kApartTexels = 24;

/// A place of an edge. Side s of place i has the lights [(2 i + s) lightCount, ...).
struct Place {
    std::uint32_t edge = 0;
    double along = 0;
    std::array<bool, 2> isLit{};
};

/// Places of consecutive edges, and the light on both sides of each: that of the bake, and that of the last stages of its map.
class Batch {
public:
    Batch(const verify::SplitEdges& edges, std::span<const ComparedMap> maps, std::size_t lightCount)
        : edges_(edges), lightCount_(lightCount) {
        for (const ComparedMap& map : maps) sizes_.emplace_back(map.bake.width(), map.bake.height());
    }

    /// Takes places from the next edges, as many as the memory of a batch holds. Returns false after the last edge.
    bool next() {
        places_.clear();
        const std::size_t most = std::max<std::size_t>(kBatchBytes / (2 * lightCount_ * sizeof(lighting::ShRgb)), 1);
        for (; edge_ < edges_.edges.size() && places_.size() < most; place_ = 0, ++edge_) {
            const verify::SplitEdge& edge = edges_.edges[edge_];
            const int count = edge.placeCount(std::array{sizes_[edge.map[0]], sizes_[edge.map[1]]});
            for (; place_ < count && places_.size() < most; ++place_)
                places_.push_back({static_cast<std::uint32_t>(edge_), static_cast<double>(place_) / (count - 1), {}});
            if (place_ < count) break;
        }
        lights_.resize(2 * lightCount_ * places_.size());
        return !places_.empty();
    }
    const std::vector<Place>& places() const { return places_; }
    std::size_t mapOf(std::size_t place, std::size_t side) const { return edges_.edges[places_[place].edge].map[side]; }
    glm::dvec2 texelOf(std::size_t place, std::size_t side) const {
        return edges_.edges[places_[place].edge].texelAt(side, places_[place].along, sizes_[mapOf(place, side)]);
    }
    /// light  of LightMapVerifier::lightAt
    void setLit(std::size_t place, std::size_t side, std::span<const lighting::ShRgb> light) {
        const std::span<lighting::ShRgb> kept = lightOf(place, side);
        kept.front() = light.front();
        std::ranges::copy(light.last(lightCount_ - 1), kept.begin() + 1);
        places_[place].isLit[side] = true;
    }
    /// Returns the places [first, last) that both sides light.
    std::vector<verify::LitSeamPlace> lit(std::size_t first, std::size_t last) {
        std::vector<verify::LitSeamPlace> out;
        for (std::size_t i = first; i < last; ++i) {
            const Place& place = places_[i];
            if (!place.isLit[0] || !place.isLit[1]) continue;
            out.push_back({place.edge,
                           place.along,
                           edges_.edges[place.edge].normalAt(place.along),
                           {texelOf(i, 0), texelOf(i, 1)},
                           {lightOf(i, 0), lightOf(i, 1)}});
        }
        return out;
    }

private:
    std::span<lighting::ShRgb> lightOf(std::size_t place, std::size_t side) {
        return std::span(lights_).subspan((2 * place + side) * lightCount_, lightCount_);
    }

    const verify::SplitEdges& edges_;
    std::size_t lightCount_;
    std::vector<glm::dvec2> sizes_;  ///< [map]
    std::size_t edge_ = 0;
    int place_ = 0;
    std::vector<Place> places_;
    std::vector<lighting::ShRgb> lights_;
};

/// One side of a place.
struct PlaceSide {
    std::size_t place, side;
};
/// A strip of a map, with the sides whose rows it has.
struct SeamStrip {
    const ComparedMap& map;
    int strip;
    std::vector<PlaceSide> sides;
};

/// Returns the strips that light a batch, map by map.
std::vector<SeamStrip> stripsOf(const Batch& batch, std::span<const ComparedMap> maps) {
    std::vector<std::map<int, std::vector<PlaceSide>>> sides(maps.size());
    for (std::size_t place = 0; place < batch.places().size(); ++place)
        for (std::size_t side = 0; side < 2; ++side) {
            const std::size_t map = batch.mapOf(place, side);
            const int row = std::max(0, static_cast<int>(std::floor(batch.texelOf(place, side).y)));
            sides[map][row / maps[map].bake.stripRows(0)].push_back({place, side});
        }
    std::vector<SeamStrip> strips;
    for (std::size_t map = 0; map < maps.size(); ++map)
        for (auto& [strip, ofStrip] : sides[map]) strips.push_back({maps[map], strip, std::move(ofStrip)});
    return strips;
}

/// Lights both sides of all places of a batch, each in the strip of its row.
Result<void> light(Batch& batch, std::span<const ComparedMap> maps, const ActionContext& context) {
    const std::vector<SeamStrip> strips = stripsOf(batch, maps);
    const auto lightStrip = [&](int index) -> Result<int> {
        const auto& [map, strip, sides] = strips[static_cast<std::size_t>(index)];
        LC_TRY(reference, map.bake.stripWithMargin(strip, 0, 1));
        LC_TRY(texels, map.cooked.read(map.bake.stripFirstRow(strip), map.bake.stripRows(strip) + 1));
        std::vector<lighting::ShRgb> light(map.cooked.verifier().lightCount());
        for (const auto& [place, side] : sides)
            if (map.cooked.verifier().lightAt(*texels, *reference, batch.texelOf(place, side), light)) batch.setLit(place, side, light);
        return index;
    };
    return foldInOrder<int>(static_cast<int>(strips.size()), context, "light the seams of " + context.action.asset, lightStrip, [](int) {});
}

/// Errors of some places.
struct SeamPart {
    verify::SeamErrors errors;
    std::size_t dark = 0;
};

/// none  errors of no places
Result<void> measure(Batch& batch, const verify::LightMapVerifier& verifier, const verify::SeamErrors& none, const ActionContext& context,
                     verify::SeamErrors& errors, SeamFigures& figures) {
    const std::size_t count = batch.places().size();
    const auto tasks = static_cast<int>((count + kPlacesOfTask - 1) / kPlacesOfTask);
    const auto work = [&](int task) -> Result<SeamPart> {
        const std::size_t first = static_cast<std::size_t>(task) * kPlacesOfTask, last = std::min(first + kPlacesOfTask, count);
        const auto lit = batch.lit(first, last);
        return SeamPart{verifier.seamErrors(lit, none), last - first - lit.size()};
    };
    return foldInOrder<SeamPart>(tasks, context, "measure the seams of " + context.action.asset, work, [&](const SeamPart& part) {
        errors.merge(part.errors);
        figures.darkPlaces += static_cast<std::int64_t>(part.dark);
    });
}

verify::SplitEdges splitEdgesOf(const LitSurface& surface) {
    std::vector<glm::dvec2> sizes;
    for (const ComparedMap& map : surface.maps) sizes.emplace_back(map.bake.width(), map.bake.height());
    verify::SeamFinder finder(std::move(sizes));
    for (const verify::SurfaceTriangle& triangle : surface.triangles) finder.add(triangle);
    return std::move(finder).finish();
}

StepFigures figuresOf(const verify::VisibleAccumulator& steps) {
    const verify::VisibleFigures figures = steps.figures();
    return {figures.p99, figures.max};
}

std::optional<StepFigures> figuresIfAny(const verify::VisibleAccumulator& steps) {
    return steps.sampleCount() > 0 ? std::optional(figuresOf(steps)) : std::nullopt;
}

SeamSteps figuresOf(const verify::SeamErrors::Kind& kind) {
    return {figuresOf(kind.added), figuresOf(kind.cooked)};
}

/// Edges with the light maps that they lie in.
struct MappedEdges {
    const verify::SplitEdges& edges;
    std::span<const ComparedMap> maps;
    const verify::SplitEdge& at(std::size_t edge) const { return edges.edges[edge]; }
};

SeamPlace placeOf(const SeamStep& step, const MappedEdges& edges) {
    const verify::SplitEdge& edge = edges.at(step.edge);
    const bool isSpecular = step.view != glm::dvec3(0);
    SeamPlace place;
    place.shading = isSpecular ? "specular" : "diffuse";
    place.added = step.added;
    place.bakeStep = step.bakeStep;
    place.cookedStep = step.cookedStep;
    place.position = edge.positionAt(step.along);
    place.edge = edge.position;
    for (std::size_t side = 0; side < 2; ++side) place.texels[side] = {step.texel[side].x, step.texel[side].y};
    place.normal = step.normal;
    if (isSpecular) {
        place.view = step.view;
        place.m = step.m;
        place.f0 = step.f0;
    }
    place.reference = step.bake;
    place.found = step.cooked;
    if (edge.isBetweenMaps()) {
        place.maps = std::array{edges.maps[edge.map[0]].name, edges.maps[edge.map[1]].name};
        place.errors = step.error;
    }
    return place;
}

/// Returns the largest added steps of both kinds of shading, each at an edge of its own and away from those before it.
std::vector<SeamPlace> worstOf(const verify::SeamErrors& errors, const MappedEdges& edges) {
    std::vector<SeamStep> all = errors.worstDiffuse, chosen;
    all.insert(all.end(), errors.worstSpecular.begin(), errors.worstSpecular.end());
    std::ranges::stable_sort(all, std::ranges::greater(), &SeamStep::added);
    const auto isApart = [&](const SeamStep& a, const SeamStep& b) {
        const auto isNear = [&](std::size_t side) {
            return edges.at(a.edge).map[0] == edges.at(b.edge).map[side] && glm::distance(a.texel[0], b.texel[side]) <= kApartTexels;
        };
        return a.edge != b.edge && !isNear(0) && !isNear(1);
    };
    std::vector<SeamPlace> places;
    for (const SeamStep& step : all) {
        if (places.size() == kWorst || !(step.added > 0)) break;
        if (!std::ranges::all_of(chosen, [&](const SeamStep& other) { return isApart(step, other); })) continue;
        chosen.push_back(step);
        places.push_back(placeOf(step, edges));
    }
    return places;
}

void fill(SeamFigures& figures, const verify::SeamErrors& errors, const MappedEdges& edges) {
    for (const verify::SeamErrors::Stage& stage : errors.stages) {
        SeamStage& made = figures.stages.emplace_back(SeamStage{stage.name, figuresOf(stage.diffuse), {}});
        if (stage.specular.cooked.sampleCount() > 0) made.specular = figuresOf(stage.specular);
    }
    figures.bakeDiffuse = figuresIfAny(errors.bakeDiffuse);
    figures.bakeSpecular = figuresIfAny(errors.bakeSpecular);
    for (const SeamStep* step : {&errors.worstBakeDiffuse, &errors.worstBakeSpecular})
        if (step->isKnown()) figures.worstOfBake.emplace_back(placeOf(*step, edges)).errors.reset();  // of the bake against itself
    figures.worst = worstOf(errors, edges);
}

/// Returns why a mesh has no figures; empty if it has edges to measure.
std::string whyNot(bool hasMesh, std::span<const verify::SurfaceTriangle> triangles, const verify::SplitEdges& edges) {
    if (!hasMesh) return "the light map has no mesh whose edges could be looked at";
    if (triangles.empty()) return "the mesh has no light-map UVs (TEXCOORD_1)";
    return edges.edges.empty() ? "no edge of the mesh is shared by two charts" : "";
}

/// Measures edges that lie in some maps.
/// none  errors of no places, with the last stages of the maps
Result<SeamFigures> measureEdges(const verify::SplitEdges& edges, std::span<const ComparedMap> maps, const verify::SeamErrors& none,
                                 const ActionContext& context) {
    SeamFigures figures;
    figures.edges = static_cast<std::int64_t>(edges.edges.size());
    figures.joinedEdges = edges.joined;
    figures.hardEdges = edges.hard;
    figures.openEdges = edges.open;
    verify::SeamErrors errors = none;
    Batch batch(edges, maps, 1 + none.stages.size());
    while (batch.next()) {
        LC_CHECK(light(batch, maps, context));
        LC_CHECK(measure(batch, maps.front().cooked.verifier(), none, context, errors, figures));
        figures.places += static_cast<std::int64_t>(batch.places().size());
    }
    figures.places -= figures.darkPlaces;
    if (figures.places > 0) fill(figures, errors, {edges, maps});
    if (figures.places == 0 && figures.edges > 0)
        figures.note = fmt::format("no place of the {} edges has a covered texel in reach of the filter on both sides", figures.edges);
    return figures;
}

/// Measures the seams of a surface with one light map. Places are lit strip by strip, in batches of a bounded size, so that a map or mesh
/// of any size takes the memory of one batch. The result is the same on any number of threads.
Result<SeamFigures> measureSeams(const LitSurface& surface, bool hasMesh, const ActionContext& context) {
    const verify::SplitEdges edges = splitEdgesOf(surface);
    LC_TRY(figures, measureEdges(edges, surface.maps, surface.maps.front().cooked.verifier().noSeamErrors(), context));
    if (const std::string why = whyNot(hasMesh, surface.triangles, edges); !why.empty()) figures->note = why;
    return figures;
}

}  // namespace

Result<SeamFigures> measureSeamsBetween(const LitSurface& surface, const ActionContext& context) {
    verify::SplitEdges edges = splitEdgesOf(surface);
    std::erase_if(edges.edges, [](const verify::SplitEdge& edge) { return !edge.isBetweenMaps(); });
    auto figures =
        measureEdges(edges, surface.maps, verify::SeamErrors(std::vector<verify::SeamErrors::Stage>{{"total", {}, {}}}), context);
    if (figures && edges.edges.empty()) figures->note = "no edge of the mesh lies between two of the maps";
    return figures;
}

Result<std::vector<RenderedView>> writeSeamViews(const SeamFigures& seams, const LitSurface& surface, const ActionContext& context,
                                                 const std::string& name) {
    std::vector<RenderedView> views;
    for (const SeamPlace& place : seams.worst) {
        if (place.added < kLeastShown) break;
        const auto map = place.maps ? std::ranges::find(surface.maps, place.maps->front(), &ComparedMap::name) : surface.maps.begin();
        const MapTexel texel{static_cast<std::size_t>(map - surface.maps.begin()),
                             {static_cast<int>(std::clamp(std::round(place.texels[0][0]), 0.0, map->bake.width() - 1.0)),
                              static_cast<int>(std::clamp(std::round(place.texels[0][1]), 0.0, map->bake.height() - 1.0))}};
        LC_TRY(view, writeRenderedView(surface, texel, context, fmt::format("{}_{}", name, views.size() + 1)));
        if (!*view) break;
        views.push_back(std::move(**view));
    }
    return views;
}

Result<void> checkSeams(CheckedLightMap& map) {
    const std::array maps = {map.compared()};
    const LitSurface surface{maps, map.triangles, map.viewing};
    LC_TRY(seams, measureSeams(surface, map.hasMesh, map.context));
    const bool isConstant = map.bake.constantTexels().has_value();
    if (isConstant) seams->note = "all texels hold the same light: no edge can have a step";
    if (map.parameters.limits[Limit::Seam] && seams->isUnmeasured() && !isConstant)
        map.violations().push_back({"seams", *seams->note,
                                    seams->edges > 0 ? "coverage that reaches the edges of charts: max_seam limits the steps there"
                                                     : "a mesh with light-map UVs: max_seam limits the steps at its edges"});
    LC_TRY(views, writeSeamViews(*seams, surface, map.context, map.context.action.asset + "_seam"));
    map.seamViews = std::move(*views);
    map.result.seams = std::move(*seams);
    return {};
}

}  // namespace lightcook::pipeline

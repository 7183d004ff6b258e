// Seams of a light map: steps of light between both sides of the edges that two charts share, in the bake and cooked.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
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

/// Places of consecutive edges, and the light on both sides of each: that of the bake, then that of each stage.
class Batch {
public:
    /// size  of the light map [texels]
    Batch(const verify::SplitEdges& edges, const glm::dvec2& size, std::size_t lightCount)
        : edges_(edges), size_(size), lightCount_(lightCount) {}

    /// Takes places from the next edges, as many as the memory of a batch holds. Returns false after the last edge.
    bool next() {
        places_.clear();
        const std::size_t most = std::max<std::size_t>(kBatchBytes / (2 * lightCount_ * sizeof(lighting::ShRgb)), 1);
        for (; edge_ < edges_.edges.size() && places_.size() < most; place_ = 0, ++edge_) {
            const verify::SplitEdge& edge = edges_.edges[edge_];
            const int count = edge.placeCount(size_);
            for (; place_ < count && places_.size() < most; ++place_)
                places_.push_back({static_cast<std::uint32_t>(edge_), static_cast<double>(place_) / (count - 1), {}});
            if (place_ < count) break;
        }
        lights_.resize(2 * lightCount_ * places_.size());
        return !places_.empty();
    }
    const std::vector<Place>& places() const { return places_; }
    glm::dvec2 texelOf(std::size_t place, std::size_t side) const {
        return edges_.edges[places_[place].edge].texelAt(side, places_[place].along, size_);
    }
    /// Returns the light of one side, for LightMapVerifier::lightAt.
    std::span<lighting::ShRgb> lightOf(std::size_t place, std::size_t side) {
        return std::span(lights_).subspan((2 * place + side) * lightCount_, lightCount_);
    }
    void setLit(std::size_t place, std::size_t side) { places_[place].isLit[side] = true; }
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
    const verify::SplitEdges& edges_;
    glm::dvec2 size_;
    std::size_t lightCount_;
    std::size_t edge_ = 0;
    int place_ = 0;
    std::vector<Place> places_;
    std::vector<lighting::ShRgb> lights_;
};

/// One side of a place.
struct PlaceSide {
    std::size_t place, side;
};

/// Lights both sides of all places of a batch, each in the strip of its row.
Result<void> light(Batch& batch, const CheckedLightMap& map) {
    std::map<int, std::vector<PlaceSide>> sidesOfStrips;
    for (std::size_t place = 0; place < batch.places().size(); ++place)
        for (std::size_t side = 0; side < 2; ++side) {
            const int row = std::max(0, static_cast<int>(std::floor(batch.texelOf(place, side).y)));
            sidesOfStrips[row / map.bake.stripRows(0)].push_back({place, side});
        }
    const std::vector<std::pair<int, std::vector<PlaceSide>>> strips(sidesOfStrips.begin(), sidesOfStrips.end());
    const verify::LightMapVerifier& verifier = map.cooked.verifier();
    const auto lightStrip = [&](int index) -> Result<int> {
        const auto& [strip, sides] = strips[static_cast<std::size_t>(index)];
        LC_TRY(reference, map.bake.stripWithMargin(strip, 0, 1));
        LC_TRY(texels, map.cooked.read(map.bake.stripFirstRow(strip), map.bake.stripRows(strip) + 1));
        for (const auto& [place, side] : sides)
            if (verifier.lightAt(*texels, *reference, batch.texelOf(place, side), batch.lightOf(place, side))) batch.setLit(place, side);
        return index;
    };
    return foldInOrder<int>(static_cast<int>(strips.size()), map.context.between(kTexelsEnd, 1),
                            "light the seams of " + map.context.action.asset, lightStrip, [](int) {});
}

/// Errors of some places.
struct SeamPart {
    verify::SeamErrors errors;
    std::size_t dark = 0;
};

Result<void> measure(Batch& batch, const CheckedLightMap& map, verify::SeamErrors& errors, SeamFigures& figures) {
    const std::size_t count = batch.places().size();
    const auto tasks = static_cast<int>((count + kPlacesOfTask - 1) / kPlacesOfTask);
    const auto work = [&](int task) -> Result<SeamPart> {
        const std::size_t first = static_cast<std::size_t>(task) * kPlacesOfTask, last = std::min(first + kPlacesOfTask, count);
        const auto lit = batch.lit(first, last);
        return SeamPart{map.cooked.verifier().seamErrors(lit), last - first - lit.size()};
    };
    return foldInOrder<SeamPart>(tasks, map.context.between(kTexelsEnd, 1), "measure the seams of " + map.context.action.asset, work,
                                 [&](const SeamPart& part) {
                                     errors.merge(part.errors);
                                     figures.darkPlaces += static_cast<std::int64_t>(part.dark);
                                 });
}

glm::ivec2 sizeOf(const CheckedLightMap& map) {
    return {map.bake.width(), map.bake.height()};
}

verify::SplitEdges splitEdgesOf(const CheckedLightMap& map) {
    verify::SeamFinder finder(sizeOf(map));
    for (const verify::SurfaceTriangle& triangle : map.triangles) finder.add(triangle);
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

SeamPlace placeOf(const SeamStep& step, const verify::SplitEdges& edges) {
    const verify::SplitEdge& edge = edges.edges[step.edge];
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
    return place;
}

/// Returns the largest added steps of both kinds of shading, each at an edge of its own and away from those before it.
std::vector<SeamPlace> worstOf(const verify::SeamErrors& errors, const verify::SplitEdges& edges) {
    std::vector<SeamStep> all = errors.worstDiffuse, chosen;
    all.insert(all.end(), errors.worstSpecular.begin(), errors.worstSpecular.end());
    std::ranges::stable_sort(all, std::ranges::greater(), &SeamStep::added);
    const auto isApart = [&](const SeamStep& a, const SeamStep& b) {
        const auto isNear = [&](std::size_t side) { return glm::distance(a.texel[0], b.texel[side]) <= kApartTexels; };
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

void fill(SeamFigures& figures, const verify::SeamErrors& errors, const verify::SplitEdges& edges) {
    for (const verify::SeamErrors::Stage& stage : errors.stages) {
        SeamStage& made = figures.stages.emplace_back(SeamStage{stage.name, figuresOf(stage.diffuse), {}});
        if (stage.specular.cooked.sampleCount() > 0) made.specular = figuresOf(stage.specular);
    }
    figures.bakeDiffuse = figuresIfAny(errors.bakeDiffuse);
    figures.bakeSpecular = figuresIfAny(errors.bakeSpecular);
    for (const SeamStep* step : {&errors.worstBakeDiffuse, &errors.worstBakeSpecular})
        if (step->isKnown()) figures.worstOfBake.push_back(placeOf(*step, edges));
    figures.worst = worstOf(errors, edges);
}

/// Returns why a mesh has no figures; empty if it has edges to measure.
std::string whyNot(bool hasMesh, std::span<const verify::SurfaceTriangle> triangles, const verify::SplitEdges& edges) {
    if (!hasMesh) return "the light map has no mesh whose edges could be looked at";
    if (triangles.empty()) return "the mesh has no light-map UVs (TEXCOORD_1)";
    return edges.edges.empty() ? "no edge of the mesh is shared by two charts" : "";
}

/// Measures the seams. Places are lit strip by strip, in batches of a bounded size, so that a map or mesh of any size takes the memory of
/// one batch. The result is the same on any number of threads.
Result<SeamFigures> measureSeams(const CheckedLightMap& map) {
    const verify::SplitEdges edges = splitEdgesOf(map);
    SeamFigures figures;
    figures.edges = static_cast<std::int64_t>(edges.edges.size());
    figures.joinedEdges = edges.joined;
    figures.hardEdges = edges.hard;
    figures.openEdges = edges.open;
    verify::SeamErrors errors = map.cooked.verifier().noSeamErrors();
    Batch batch(edges, sizeOf(map), map.cooked.verifier().lightCount());
    while (batch.next()) {
        LC_CHECK(light(batch, map));
        LC_CHECK(measure(batch, map, errors, figures));
        figures.places += static_cast<std::int64_t>(batch.places().size());
    }
    figures.places -= figures.darkPlaces;
    if (figures.places > 0) fill(figures, errors, edges);
    if (figures.places == 0 && figures.edges > 0)
        figures.note = fmt::format("no place of the {} edges has a covered texel in reach of the filter on both sides", figures.edges);
    if (const std::string why = whyNot(map.hasMesh, map.triangles, edges); !why.empty()) figures.note = why;
    return figures;
}

/// Draws the worst seams as a camera in front of each sees them, in the order of SeamFigures::worst. Steps below half of a just noticeable
/// difference get no picture.
Result<std::vector<RenderedView>> writeSeamViews(const SeamFigures& seams, const CheckedLightMap& map) {
    const glm::dvec2 last(sizeOf(map) - 1);
    std::vector<RenderedView> views;
    for (const SeamPlace& place : seams.worst) {
        if (place.added < kLeastShown) break;
        const glm::ivec2 texel(glm::clamp(glm::round(glm::dvec2(place.texels[0][0], place.texels[0][1])), glm::dvec2(0), last));
        LC_TRY(view, writeRenderedView(map, texel, fmt::format("{}_seam_{}", map.context.action.asset, views.size() + 1)));
        if (!*view) break;
        views.push_back(std::move(**view));
    }
    return views;
}

}  // namespace

Result<void> checkSeams(CheckedLightMap& map) {
    LC_TRY(seams, measureSeams(map));
    const bool isConstant = map.bake.constantTexels().has_value();
    if (isConstant) seams->note = "all texels hold the same light: no edge can have a step";
    if (map.parameters.limits[Limit::Seam] && seams->isUnmeasured() && !isConstant)
        map.violations().push_back({"seams", *seams->note,
                                    seams->edges > 0 ? "coverage that reaches the edges of charts: max_seam limits the steps there"
                                                     : "a mesh with light-map UVs: max_seam limits the steps at its edges"});
    LC_TRY(views, writeSeamViews(*seams, map));
    map.seamViews = std::move(*views);
    map.result.seams = std::move(*seams);
    return {};
}

}  // namespace lightcook::pipeline

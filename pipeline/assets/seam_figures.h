// Seams of a light map, as reports have them. docs/theory/visible.md defines the figures.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/assets/rendered_view_files.h"
#include "pipeline/document/json_fields.h"
#include "pipeline/limits/limits.h"

namespace lightcook::pipeline {

/// Steps of light between both sides of an edge [Delta E ITP].
struct StepFigures {
    double p99 = 0, max = 0;
};
template <class Fields, Is<StepFigures> Self>
void describe(Fields& fields, Self& steps) {
    fields.required("p99", steps.p99, kFigure, "99th percentile over the places");
    fields.required("max", steps.max, kFigure, "largest");
}

/// Steps of one kind of shading.
struct SeamSteps {
    StepFigures added, cooked;
};
template <class Fields, Is<SeamSteps> Self>
void describe(Fields& fields, Self& steps) {
    fields.required("added", steps.added, "cooked step less that of the bake, at least 0: the new seam");
    fields.required("cooked", steps.cooked, "step of the cooked map");
}

struct SeamStage {
    std::string name;
    SeamSteps diffuse;
    std::optional<SeamSteps> specular;
};
template <class Fields, Is<SeamStage> Self>
void describe(Fields& fields, Self& stage) {
    fields.required("name", stage.name, "name of the stage");
    fields.required("diffuse", stage.diffuse, "Lambert shading");
    fields.optional("specular", stage.specular, "area-specular shading");
}

/// The step at one place of an edge, for one normal or view.
struct SeamPlace {
    std::string shading;                             ///< diffuse or specular
    double added = 0, bakeStep = 0, cookedStep = 0;  ///< Delta E ITP
    glm::dvec3 position{0};                          ///< world of the mesh
    std::array<glm::dvec3, 2> edge{};                ///< its ends
    std::array<std::array<double, 2>, 2> texels{};   ///< of each side: x and y
    glm::dvec3 normal{0};
    std::optional<glm::dvec3> view;
    std::optional<double> m, f0;
    std::array<glm::dvec3, 2> reference{}, found{};  ///< light of each side
};
template <class Fields, Is<SeamPlace> Self>
void describe(Fields& fields, Self& place) {
    fields.required("shading", place.shading, "diffuse or specular");
    fields.required("added", place.added, kFigure, "step of the cooked map less that of the bake, at least 0");
    fields.required("bake_step", place.bakeStep, kFigure, "step of the bake");
    fields.required("cooked_step", place.cookedStep, kFigure, "step of the cooked map");
    fields.required("position", place.position, "place in the mesh's world, turned by `output_axes`");
    fields.required("edge", place.edge, "both ends of the edge");
    fields.required("texels", place.texels, "x and y of each side; fractions lie between texel centres");
    fields.required("normal", place.normal, "normal of the shading");
    fields.optional("view", place.view, "direction to the viewer");
    fields.optional("m", place.m, "roughness");
    fields.optional("f0", place.f0, "reflectance at normal incidence");
    fields.required("reference", place.reference, kNumberOrNull, "light of the bake on each side: red, green, blue");
    fields.required("found", place.found, kNumberOrNull, "light of the cooked map on each side: red, green, blue");
}

struct SeamFigures {
    std::int64_t edges = 0, joinedEdges = 0, hardEdges = 0, openEdges = 0;
    std::int64_t places = 0, darkPlaces = 0;
    std::optional<std::string> note;  ///< why there are no figures
    std::vector<SeamStage> stages;    ///< empty without places
    std::optional<StepFigures> bakeDiffuse, bakeSpecular;
    std::vector<SeamPlace> worstOfBake;
    std::vector<SeamPlace> worst;  ///< of the last stage, the largest added step first

    /// Returns true if there is no mesh, or one without light-map UVs, or if no place of any edge could be measured.
    bool isUnmeasured() const { return note && (edges > 0 || joinedEdges + hardEdges + openEdges == 0); }
    /// Returns the largest added step of the last stage, of diffuse and specular light; 0 without places.
    double largestAdded() const {
        if (stages.empty()) return 0;
        const SeamStage& last = stages.back();
        return std::max(last.diffuse.added.max, last.specular ? last.specular->added.max : 0.0);
    }
    /// Returns the figure that a limit on seams holds: the largest added step. Empty without places.
    std::vector<Figure> figures() const {
        if (stages.empty()) return {};
        return {{Limit::Seam, largestAdded(), stages.back().name, worst.empty() ? "" : worst.front().shading}};
    }
};
template <class Fields, Is<SeamFigures> Self>
void describe(Fields& fields, Self& seams) {
    fields.required("edges", seams.edges, "edges that two charts share: both sides read other texels");
    fields.required("joined_edges", seams.joinedEdges, "edges inside charts: both sides read the same texels");
    fields.required("hard_edges", seams.hardEdges, "edges whose sides have different normals: no seam is looked for");
    fields.required("open_edges", seams.openEdges, "edges of one triangle alone");
    fields.required("places", seams.places, "places of the edges that were measured");
    fields.required("dark_places", seams.darkPlaces, "places with no covered texel in reach of the filter on a side, which were not");
    fields.optional("note", seams.note, "why there are no figures");
    fields.presentIf(!seams.stages.empty(), "stages", seams.stages, "steps after each stage, in just noticeable differences (Delta E ITP)");
    fields.optional("bake_diffuse", seams.bakeDiffuse, "steps of the bake itself, Lambert shading");
    fields.optional("bake_specular", seams.bakeSpecular, "steps of the bake itself, area-specular shading");
    fields.presentIf(!seams.worstOfBake.empty(), "worst_of_bake", seams.worstOfBake, "largest steps of the bake itself");
    fields.presentIf(!seams.worst.empty(), "worst", seams.worst, "edges with the largest added steps, the worst first");
}

}  // namespace lightcook::pipeline

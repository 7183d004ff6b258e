// Facts of a mesh on its light map: which texels its light-map UVs read, and whether charts cover them. A cached action.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/assets/light_map/source.h"
#include "pipeline/graph/action.h"
#include "pipeline/lint/map_match.h"

namespace lightcook::pipeline {

/// A material with extensions that may change its reflection and are not read, and the needs that are assumed without them.
struct UnreadMaterial {
    std::size_t index = 0;  ///< in the file
    std::string name;
    std::vector<std::string> extensions;
    bool isSpecular = true;
    std::array<double, 2> m{}, f0{};
};
template <class Fields, Is<UnreadMaterial> Self>
void describe(Fields& fields, Self& material) {
    fields.required("index", material.index, "index of the material");
    fields.required("name", material.name, "name of the material");
    fields.required("extensions", material.extensions, "extensions that are not read");
    fields.required("specular", material.isSpecular, "true if it is specular without them");
    fields.required("m", material.m, "range of the Beckmann roughness without them");
    fields.required("f0", material.f0, "range of the reflectance at normal incidence without them");
}

/// How light-map UVs would fit the map after a change that a mistake undoes.
struct OtherUvs {
    std::string change;  ///< "V upside down"
    MapMatch match;
    bool keepsArea = true;  ///< a mesh of the same area; of another, shadows may look like a mesh that is smaller
};
template <class Fields, Is<OtherUvs> Self>
void describe(Fields& fields, Self& other) {
    fields.required("change", other.change, "change of the UVs");
    fields.required("match", other.match, "texels that the mesh reads then, and those of the map with light");
    fields.required("keeps_area", other.keepsArea, "true if the mesh has the same area then");
}

/// Change of `V upside down`.
inline constexpr const char* kFlippedV = "V upside down";

struct MeshFacts {
    bool hasUvs = false;                  ///< every triangle has TEXCOORD_1; nothing else is counted without it
    std::int64_t vertices = 0;            ///< that triangles use
    std::int64_t outside = 0;             ///< of these, vertices whose UV lies outside [0, 1]
    std::int64_t read = 0;                ///< texels whose centre lies in a triangle
    std::int64_t uncovered = 0;           ///< of these, texels outside charts
    std::int64_t uncoveredIfFlipped = 0;  ///< the same with V upside down
    std::int64_t shared = 0;              ///< texels that two or more triangles read
    std::int64_t withoutNormal = 0;       ///< vertices whose normal is shorter than 1/2
    std::int64_t mostDrawn = 0;           ///< nodes, or instances of nodes, that draw one mesh, at most
    MapMatch match;                       ///< with the texels of the map that hold light, or coverage
    /// The same after changes that may explain why mesh and map do not fit; none if they do.
    std::vector<OtherUvs> others = {};
    double uvArea = 0, flatUvArea = 0;  ///< [UV units squared] of all triangles as drawn, and of those without area in the world
    /// Nodes without a rectangle in the lmbake, and rectangles of it without a node. Known for meshes without UVs, too.
    std::vector<std::string> unplaced = {}, unread = {};
    std::vector<std::string> withoutPlace = {};  ///< nodes with light-map UVs that have no [[light_map.place]], if any node has one
    /// Materials with extensions that are not read; known also without UVs.
    std::vector<UnreadMaterial> unreadMaterials = {};
};
template <class Fields, Is<MeshFacts> Self>
void describe(Fields& fields, Self& facts) {
    fields.required("has_uvs", facts.hasUvs, "true if every triangle has TEXCOORD_1");
    fields.required("vertices", facts.vertices, "vertices that triangles use");
    fields.required("outside", facts.outside, "of these, vertices whose UV lies outside [0, 1]");
    fields.required("read", facts.read, "texels whose centre lies in a triangle");
    fields.required("uncovered", facts.uncovered, "of these, texels outside charts");
    fields.required("uncovered_if_flipped", facts.uncoveredIfFlipped, "the same with V upside down");
    fields.required("shared", facts.shared, "texels that two or more triangles read");
    fields.required("without_normal", facts.withoutNormal, "vertices whose normal is shorter than 1/2");
    fields.required("most_drawn", facts.mostDrawn, "nodes, or instances of nodes, that draw one mesh, at most");
    fields.required("match", facts.match, "texels that the mesh reads, and those of the map with light or coverage");
    fields.presentIf(!facts.others.empty(), "others", facts.others, "the same after changes of the UVs");
    fields.presentIf(!facts.withoutPlace.empty(), "without_place", facts.withoutPlace, "nodes with light-map UVs and without a place");
    fields.required("uv_area", facts.uvArea, "light-map UV area of all triangles as nodes draw them");
    fields.required("flat_uv_area", facts.flatUvArea, "the same of those without area in the world");
    fields.presentIf(!facts.unplaced.empty(), "unplaced", facts.unplaced, "nodes with light-map UVs that the lmbake does not have");
    fields.presentIf(!facts.unread.empty(), "unread", facts.unread, "rectangles of the lmbake without a node");
    fields.required("unread_materials", facts.unreadMaterials, "materials with extensions that are not read");
}

/// Parameters of the action. Its inputs are "source" (the light map) and "mesh".
struct MeshLintParameters {
    formats::LightMapDescription description;
};
template <class Fields, Is<MeshLintParameters> Self>
void describe(Fields& fields, Self& parameters) {
    fields.required("description", parameters.description, "conventions of the light map");
}

/// Action "lint-mesh". Its result is MeshFacts.
formats::Result<ActionOutcome> lintMesh(const ActionContext& context);

}  // namespace lightcook::pipeline

// The pictures of a view of a mesh, as reports name them. light_map/rendered_view.h draws them.
#pragma once

#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "pipeline/document/json_fields.h"

namespace lightcook::pipeline {

/// A place of a mesh as a camera in front of it sees it, lit by the bake and by the cooked light map.
struct RenderedView {
    std::string reference, cooked;
    glm::dvec3 position{0}, normal{0};  ///< of the place, in the mesh's world
    double distance = 0;                ///< of the camera [scene units]
};
template <class Fields, Is<RenderedView> Self>
void describe(Fields& fields, Self& view) {
    fields.required("reference", view.reference, kFileInFolder, "the mesh lit by the bake");
    fields.required("cooked", view.cooked, kFileInFolder, "the mesh lit by the cooked map");
    fields.required("position", view.position, "place at the centre of the picture, in the mesh's world, turned by `output_axes`");
    fields.required("normal", view.normal, "normal of the mesh there, along which the camera looks back");
    fields.required("distance", view.distance, "distance of the camera [scene units]");
}

/// Adds the files of some views.
inline void appendFiles(const std::vector<RenderedView>& views, std::vector<std::string>& files) {
    for (const RenderedView& view : views) files.insert(files.end(), {view.reference, view.cooked});
}

}  // namespace lightcook::pipeline

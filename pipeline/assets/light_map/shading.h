// Materials that light maps, dominant lights and tables are shaded with, as a parameter of verify actions.
#pragma once

#include "lighting/display.h"
#include "pipeline/document/enum_names.h"
#include "pipeline/document/json_fields.h"
#include "verify/light_map.h"

namespace lightcook::pipeline {

template <class Fields, Is<verify::LightMapShading> Self>
void describe(Fields& fields, Self& shading) {
    fields.required("specular", shading.specular, "true if area specular is shaded");
    fields.required("m", shading.m, "roughness of each material: m of Beckmann, alpha of GGX");
    fields.required("f0", shading.f0, "reflectance at normal incidence of each material");
    fields.required("views", shading.viewCount, "views of each texel");
    fields.required("normals", shading.normalCount, "normals of each texel");
    fields.required("lobe", shading.lobe, "microfacet distribution");
    fields.required("normal_map_tilt", shading.normalMapTilt, between(0, 90),
                    "largest angle of a normal map's normal from the surface's [degrees]");
}

template <class Fields, Is<lighting::DisplaySettings> Self>
void describe(Fields& fields, Self& display) {
    fields.optional("white", display.white, between(lighting::kLeastWhite, lighting::kMostWhite),
                    "exit radiance shown as diffuse white; absent: the key at 18 % of it");
    fields.required("stops", display.stops, between(-lighting::kMostStops, lighting::kMostStops), "exposure compensation [stops]");
    fields.required("black", display.black, between(lighting::kLeastBlack, lighting::kMostBlack), "luminance of black [cd/m^2]");
}

/// The materials of a scene and the display that it is shown on: visible errors are judged by both.
struct SceneView {
    verify::LightMapShading shading;
    lighting::DisplaySettings display;
};
template <class Fields, Is<SceneView> Self>
void describe(Fields& fields, Self& view) {
    fields.required("shading", view.shading, "materials that are shaded");
    fields.required("display", view.display, "display that visible errors are judged on");
}

}  // namespace lightcook::pipeline

// Data of the page of `lightcook view` beside the cooked folder: viewer/scene.json and the float bakes (viewer/README.md).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/error.h"
#include "lighting/display.h"
#include "pipeline/document/json_fields.h"
#include "pipeline/graph/action.h"
#include "pipeline/manifest/manifest.h"

namespace lightcook::pipeline {

template <class Fields, Is<lighting::Display> Self>
void describe(Fields& fields, Self& display) {
    fields.required("nits", display.nitsPerUnit, "luminance of a white with exit radiance 1 [cd/m^2]");
    fields.required("black", display.black, "luminance of black, which is added to all light [cd/m^2]");
}

/// Materials that the errors of a light map were measured for.
struct ViewedShading {
    double normalMapTilt = 0;
    std::vector<double> m, f0;
};
template <class Fields, Is<ViewedShading> Self>
void describe(Fields& fields, Self& shading) {
    fields.required("normal_map_tilt", shading.normalMapTilt, "largest angle of a normal map's normal from the surface's [degrees]");
    fields.required("m", shading.m, "Beckmann roughness");
    fields.required("f0", shading.f0, "reflectance at normal incidence");
}

/// A light map of the scene.
struct ViewedLightMap {
    std::string name;
    std::optional<std::string> reference;         ///< file with the float bake
    std::optional<std::string> referenceMissing;  ///< why there is none
    double referenceScale = 1;
    int referenceLayers = 0;          ///< of `reference`; 0 without one
    std::optional<std::string> mesh;  ///< asset of the mesh that it lies on
    std::optional<lighting::Display> display;
    std::optional<ViewedShading> shading;
};
template <class Fields, Is<ViewedLightMap> Self>
void describe(Fields& fields, Self& map) {
    fields.required("name", map.name, "name of the light map");
    fields.optional("reference", map.reference,
                    "KTX2 file with the float bake: RGBA16F, an array of `reference_layers` layers, layer k the SH coefficient k times "
                    "`reference_scale`; alpha of layer 0 is the coverage, and uncovered texels are 0");
    fields.optional("reference_missing", map.referenceMissing, "why there is no `reference`");
    fields.required("reference_scale", map.referenceScale, "power of two that keeps the coefficients in the range of half floats");
    fields.required("reference_layers", map.referenceLayers, between(0, 9),
                    "coefficients up to the last one that is not 0, which the others are; 0 without `reference`");
    fields.optional("mesh", map.mesh, "mesh asset that the map lies on");
    fields.optional("display", map.display, "display that visible errors are judged on; absent without `reference`");
    fields.optional("shading", map.shading, "materials that the errors were measured for");
}

/// The scene under another layout, which the cook kept.
struct ViewedCandidate {
    std::string layout, folder;
    std::uint64_t bytesGpu = 0;
    double visible = 0;
};
template <class Fields, Is<ViewedCandidate> Self>
void describe(Fields& fields, Self& candidate) {
    fields.required("layout", candidate.layout, "layout of its light maps");
    fields.required("folder", candidate.folder, "its cooked folder, with a slash at the end");
    fields.required("bytes_gpu", candidate.bytesGpu, "GPU memory of its light maps");
    fields.required("visible", candidate.visible, kFigure, "99th percentile of visible errors of its worst light map");
}

struct ViewedScene {
    int schema = 1;
    std::string scene;
    Tool tool;
    std::vector<ViewedLightMap> lightMaps;
    std::vector<ViewedCandidate> candidates;
};
template <class Fields, Is<ViewedScene> Self>
void describe(Fields& fields, Self& scene) {
    fields.required("schema", scene.schema, between(1, 1), "version of this form");
    fields.required("scene", scene.scene, "name of the scene");
    fields.required("tool", scene.tool, "program that cooked the scene");
    fields.required("light_maps", scene.lightMaps, "light maps, in the order of the manifest");
    fields.required("candidates", scene.candidates, "the scene under other layouts: of `cook --keep-candidates`");
}

/// Largest number of texels of a bake, of all its layers together, that is written for the page: 300 MB of half floats. Nine coefficients
/// of 2048 x 2048 texels, or a flat map of 6144 x 6144.
inline constexpr std::int64_t kMostReferenceTexels = std::int64_t{9} * 2048 * 2048;

/// Folder of scene.json and the float bakes on the site.
inline constexpr const char* kViewerFolder = "viewer";

struct ViewFolders {
    std::filesystem::path cooked;
    std::filesystem::path sceneDirectory;  ///< that the manifest's sources are relative to
    std::filesystem::path bakes;           ///< gets the bake of each light map
};

/// Describes the scene, and writes the bake of each light map. A bake that is absent, has changed or is too large is not written, and
/// `referenceMissing` says why: the cooked scene is shown without it.
formats::Result<ViewedScene> describeForView(const Manifest& manifest, const ViewFolders& folders, const RunState& state);

}  // namespace lightcook::pipeline

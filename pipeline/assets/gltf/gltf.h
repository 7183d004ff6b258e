// The scene as glTF with its light map bound: action "gltf". Its inputs are "mesh", the bake as of the light map, and of a probe
// "probe-source" and "probe-sh". It depends on the cook and the verification of the light map.
#pragma once

#include <glm/gtc/type_precision.hpp>
#include <optional>
#include <string>

#include "formats/gltf_light_map.h"
#include "formats/image.h"
#include "formats/light_map_layout.h"
#include "pipeline/assets/cooked_asset.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/verdict.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

inline constexpr const char *kProbeSourceRole = "probe-source", *kProbeShRole = "probe-sh";

/// The probe of the image-based light: it lights objects without a light map.
struct GltfProbe {
    std::string name;
    formats::ColorSpaces colors;
    std::string file;  ///< name by which input "probe-sh" knows it
};
template <class Fields, Is<GltfProbe> Self>
void describe(Fields& fields, Self& probe) {
    fields.required("name", probe.name, "name of the probe");
    fields.required("colors", probe.colors, "colour spaces of its image");
    fields.required("file", probe.file, "name of the probe in the SH file");
}

struct GltfParameters {
    formats::LightMapDescription description;
    std::string shader;  ///< file of the shader include
    bool repair = false;
    std::optional<GltfProbe> probe = {};
};
template <class Fields, Is<GltfParameters> Self>
void describe(Fields& fields, Self& parameters) {
    fields.required("description", parameters.description, "conventions of the light map");
    fields.required("shader", parameters.shader, "file of the shader include");
    fields.required("repair", parameters.repair, "true to replace texels that are not finite");
    fields.optional("probe", parameters.probe, "probe of the image-based light");
}

/// Returns the name of the file without extension.
std::string gltfNameOf(const std::string& lightMap);

formats::Result<ActionOutcome> cookGltf(const ActionContext& context);

/// Returns the element of the extension's `maps` without `bound`, the errors of the map.
/// workingColor  colour space of the textures
/// shader        file of the shader include
formats::Result<Json> boundMapOf(const CookedAsset& asset, const std::string& workingColor, const std::string& shader);

/// Returns `bound` of that element: the proven and the measured errors of the whole map.
Json boundFiguresOf(const Verdict& verdict);

/// Returns the functions of lightcook.glsl that decode a layout, the first one first.
std::vector<std::string> decodeFunctions(const formats::LightMapLayoutInfo& layout);

/// The irradiance of a light map at the normals of its texels.
struct FlatPicture {
    formats::Image<glm::u8vec3> texels;  ///< irradiance over intensity, linear
    double intensity = 1;                ///< 99.9 % of the covered texels are not brighter
};
formats::Result<FlatPicture> flatPictureOf(LightMapSource& source, const ActionContext& context);

/// Returns the image-based light of a probe: SH of its irradiance, and levels of 64, 32 and 16 texels prefiltered by GGX.
formats::Result<formats::GltfLightMap::Environment> environmentOf(const GltfProbe& probe, bool repair, const ActionContext& context);

}  // namespace lightcook::pipeline

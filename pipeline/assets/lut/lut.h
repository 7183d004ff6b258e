// Specular tables: the Cook-Torrance kernel in SH over view angle and roughness. docs/theory/lighting.md, "Specular tables".
#pragma once

#include <array>
#include <optional>
#include <string>

#include "lighting/area_specular.h"
#include "pipeline/assets/light_map/shading.h"
#include "pipeline/assets/textures.h"
#include "pipeline/assets/verification.h"
#include "pipeline/document/json_fields.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Textures of the tables: entries C 0, 2, 3, 6, then D 0, 2, 3, 6, then C 7, C 8, D 7, D 8.
inline constexpr std::array<const char*, 3> kLutRoles = {"c0236", "d0236", "cd78"};

/// Parameters of the cook action. It has no input.
struct LutParameters {
    lighting::SpecularLobe lobe = lighting::SpecularLobe::Beckmann;
    std::string normalization;  ///< energy or halo3
    int viewCount = 8, roughnessCount = 16;
    double minimumM = 0, maximumM = 1;
    std::string viewAxis, roughnessAxis;  ///< a mapping of fit/specular_tables.h, or "auto"
    std::array<double, 2> f0{};           ///< range that "auto" chooses for
    std::string format = "rgba16-unorm";  ///< of the target (formats::TargetInfo::table): rgba16-unorm or rgba16f
    TextureSettings textures;
};
template <class Fields, Is<LutParameters> Self>
void describe(Fields& fields, Self& parameters) {
    fields.required("lobe", parameters.lobe, "specular lobe");
    fields.required("normalization", parameters.normalization, "energy or halo3");
    fields.required("view_count", parameters.viewCount, "columns");
    fields.required("roughness_count", parameters.roughnessCount, "rows");
    fields.required("minimum_m", parameters.minimumM, "roughness of the first row");
    fields.required("maximum_m", parameters.maximumM, "roughness of the last row");
    fields.required("view_axis", parameters.viewAxis, "mapping of NoV to columns");
    fields.required("roughness_axis", parameters.roughnessAxis, "mapping of m to rows");
    fields.required("f0", parameters.f0, "range of F0 that mappings are chosen for");
    fields.required("format", parameters.format, "pixel format: rgba16-unorm or rgba16f");
    fields.required("textures", parameters.textures, "settings of the files");
}

/// Constants of the shader's decode.
struct LutConstants {
    struct Axis {
        std::string mapping;
        std::array<double, 4> factors{};
        int count = 0;
        double minimum = 0, maximum = 0, scale = 0, offset = 0;
    };
    Axis view, roughness;
    std::array<glm::vec4, 3> scale{}, bias{};  ///< by texture, in the order of kLutRoles
};
template <class Fields, Is<LutConstants::Axis> Self>
void describe(Fields& fields, Self& axis) {
    fields.required("of", axis.mapping, "name of the mapping, in terms of NoV or m");
    fields.required("factors", axis.factors, "p0, p1, q0, q1 of the mapping");
    fields.required("count", axis.count, between(1, kLargestSide), "texels");
    fields.required("minimum", axis.minimum, "value at the first texel");
    fields.required("maximum", axis.maximum, "value at the last texel");
    fields.required("scale", axis.scale, "factor of the texture coordinate");
    fields.required("offset", axis.offset, "offset of the texture coordinate");
}
template <class Fields, Is<LutConstants> Self>
void describe(Fields& fields, Self& constants) {
    fields.required("view", constants.view, "axis of the columns");
    fields.required("roughness", constants.roughness, "axis of the rows");
    for (std::size_t i = 0; i < kLutRoles.size(); ++i) {
        fields.required(std::string(kLutRoles[i]) + "_scale", constants.scale[i], "factor of the stored channels");
        fields.required(std::string(kLutRoles[i]) + "_bias", constants.bias[i], "offset of the stored channels");
    }
}

/// Parameters of the verify action.
struct LutVerifyParameters {
    std::optional<verify::LightMapShading> shading;  ///< of the scene's light maps: for the error of the whole scene
    VisibleParameters visible = {};
};
template <class Fields, Is<LutVerifyParameters> Self>
void describe(Fields& fields, Self& parameters) {
    fields.optional("shading", parameters.shading, "materials that light maps are shaded with");
    describe(fields, parameters.visible);
}

formats::Result<ActionOutcome> cookLut(const ActionContext& context);
/// Verifies cooked tables against numerical integration, with a certified bound between texels.
formats::Result<ActionOutcome> verifyLut(const ActionContext& context);

/// Returns true for the formats that tables are stored in.
bool isLutFormat(formats::PixelFormat format);
/// Returns the normalization of a name: energy or halo3.
std::optional<lighting::CookTorranceNormalization> normalizationOf(const std::string& name);

}  // namespace lightcook::pipeline

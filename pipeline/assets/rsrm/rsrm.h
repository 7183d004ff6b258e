// Radially symmetric reflection maps of gradients, painted or averaged from an environment. docs/theory/lighting.md, "Radially symmetric
// reflection maps".
#pragma once

#include <string>
#include <vector>

#include "fit/rsrm.h"
#include "formats/environment.h"
#include "pipeline/assets/textures.h"
#include "pipeline/document/json_fields.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

inline constexpr int kRsrmWidth = 256;  ///< columns: those of the paper

/// Parameters of the cook action. Its input is "source".
struct RsrmParameters {
    formats::ColorSpaces colors;
    std::vector<double> exponents;
    int width = kRsrmWidth;
    std::vector<std::string> formats;  ///< see rsrmFormatsToTry
    double limit = 0;                  ///< error that the choice among several formats keeps
    bool dither = false;
    TextureSettings textures;
    bool repair = false;
    std::optional<glm::dvec3> axis;        ///< of an environment, which is averaged around it
    std::optional<int> zones;              ///< of that average
    std::optional<std::string> encoding;   ///< of a painted gradient
    std::optional<glm::dvec3> north = {};  ///< world direction of the first column
};
template <class Fields, Is<RsrmParameters> Self>
void describe(Fields& fields, Self& parameters) {
    fields.required("colors", parameters.colors, "colour spaces");
    fields.required("exponents", parameters.exponents, "Phong exponents, one a row");
    fields.required("width", parameters.width, "columns");
    fields.required("formats", parameters.formats, "formats to try, in order");
    fields.required("limit", parameters.limit, "largest error of the format that is taken");
    fields.required("dither", parameters.dither, "true to dither the codes");
    fields.required("textures", parameters.textures, "settings of the files");
    fields.required("repair", parameters.repair, "true to replace texels that are not finite");
    fields.optional("axis", parameters.axis, "axis that the environment is averaged around");
    fields.optional("zones", parameters.zones, "zones of that average");
    fields.optional("encoding", parameters.encoding, "encoding of a painted gradient");
    fields.optional("north", parameters.north, "world direction of the first column");
}

/// Constants of the shader's decode: light = color * texel.
struct RsrmConstants {
    glm::vec3 color{0};
    std::vector<double> exponents;
    std::optional<int> channels;  ///< 1 where the texture has one channel
};
template <class Fields, Is<RsrmConstants> Self>
void describe(Fields& fields, Self& constants) {
    fields.required("color", constants.color, "HDR colour of the whole map");
    fields.required("exponents", constants.exponents, "Phong exponent of each row");
    fields.optional("channels", constants.channels, "1 if the texture has one channel for all three");
}

formats::Result<ActionOutcome> cookRsrm(const ActionContext& context);
/// Verifies a cooked map against integrals of its source. Measures: code_error, step_codes, step_contrast, band_codes (see
/// verify::RsrmBanding); of an environment also asymmetric_energy, and gradient_uncertainty over the gradient's largest value.
formats::Result<ActionOutcome> verifyRsrm(const ActionContext& context);

/// Returns the encoding of a name; an unknown name is "auto".
formats::GradientEncoding encodingOf(const std::string& name);

}  // namespace lightcook::pipeline

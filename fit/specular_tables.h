// Cook-Torrance as SH tables: C and D of the area-specular sum over view and roughness, as three RGBA images.
// Source: Chen and Liu, Lighting and Material of Halo 3, section 1.4.3 and Listing 3, with the errata of lighting-math section 4.
#pragma once

#include <array>
#include <glm/gtc/type_precision.hpp>
#include <glm/vec4.hpp>
#include <vector>

#include "formats/error.h"
#include "formats/image.h"
#include "lighting/brdf.h"

namespace fit {

/// What the x axis measures: sin(theta_v) (Listing 3: V.X of the local frame), or cos(theta_v) = NoV.
enum class ViewMapping { Sine, Cosine };
/// What the y axis measures: m (alpha for GGX), or perceptual roughness, sqrt(m).
enum class RoughnessMapping { Linear, Perceptual };

struct SpecularTableOptions {
    lighting::NormalDistribution distribution = lighting::NormalDistribution::Beckmann;
    lighting::CookTorranceNormalization normalization = lighting::CookTorranceNormalization::Energy;
    int viewCount = 8, roughnessCount = 16;       ///< 2..1024 each; roughnessCount may be 1 where minimum == maximum
    ViewMapping viewMapping = ViewMapping::Sine;  ///< the axis runs from 0 to 1
    RoughnessMapping roughnessMapping = RoughnessMapping::Linear;
    double minimumM = 1.0 / 16, maximumM = 1.0;  ///< the range of m that the scene uses; 0.005 <= minimumM <= maximumM <= 1
    int sampleCount = 512;                       ///< of lighting::integrateAreaSpecular, per axis
};

/// An axis of a table: texel i of `count` holds the value at `minimum + (maximum - minimum) i / (count - 1)`, of sin(theta_v), NoV, m or
/// sqrt(m). Ends lie on the centres of the outer texels: the texture coordinate is value * coordinateScale + coordinateOffset.
struct TableAxis {
    int count = 0;
    double minimum = 0, maximum = 0;
    double coordinateScale = 0, coordinateOffset = 0;

    double value(int texelIndex) const;
};

/// One RGBA texture, 16 bits a channel: stored = (value - bias) / scale in [0, 1], code = round(65535 stored). A shader does code * scale +
/// bias.
struct SpecularTexture {
    formats::Image<glm::vec4> values;     ///< before quantization; x: view, y: roughness
    formats::Image<glm::u16vec4> stored;  ///< UNORM
    glm::vec4 scale{1}, bias{0};          ///< per channel, from the data; scale 1 where a channel is constant
};

struct SpecularTables {
    SpecularTableOptions options;
    TableAxis view, roughness;
    SpecularTexture c0236, d0236;  ///< C and D for i = 0, 2, 3, 6
    SpecularTexture cd78;          ///< C7, C8, D7, D8
};

/// Refuses sizes, ranges and sample counts outside the limits above.
formats::Result<void> checkSpecularTableOptions(const SpecularTableOptions& options);
/// One row of roughness, viewCount kernels: pure, so that rows can run on threads. Views at grazing incidence are evaluated at NoV >= 1e-3.
std::vector<lighting::AreaSpecularKernel> integrateSpecularTableRow(const SpecularTableOptions& options, int roughnessIndex);
/// Puts roughnessCount rows together, chooses scales and quantizes.
SpecularTables assembleSpecularTables(const SpecularTableOptions& options,
                                      const std::vector<std::vector<lighting::AreaSpecularKernel>>& rows);
/// Both steps on the calling thread. options must pass the check.
SpecularTables makeSpecularTables(const SpecularTableOptions& options);

/// Bilinear fetch of a texture, as the hardware does it on the quantized values (edge clamped).
glm::vec4 sampleSpecularTexture(const SpecularTexture& texture, double u, double v);

}  // namespace fit

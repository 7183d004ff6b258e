// Specular tables: the area-specular kernel C and D (lighting/brdf.h) over view and roughness, as three RGBA textures.
// docs/theory/lighting.md, "Specular tables", has the definitions and the corrections to the source.
// Source: Chen and Liu 2008, Lighting and Material of Halo 3, section 1.4.3 and Listing 3.
#pragma once

#include <array>
#include <glm/gtc/type_precision.hpp>
#include <glm/vec4.hpp>
#include <string>
#include <vector>

#include "formats/error.h"
#include "formats/image.h"
#include "lighting/area_specular.h"

namespace lightcook::fit {

inline constexpr double kSmallestNoV = 1e-3;  ///< of a view in the tables

/// Mapping of t (NoV or m) to an axis of the table: sqrt((p0 + p1 t) (q0 + q1 t)), monotone over [0, 1]. A shader decodes it from four
/// numbers, in single precision, too. The form covers sines, cosines, roots, offsets, and steps that grow away from grazing angles.
struct AxisMapping {
    std::string name;                    ///< as in the manifest, in terms of NoV or m
    std::array<double, 4> factors{};     ///< p0, p1, q0, q1
    double of(double t) const;           ///< 0 <= t <= 1
    double inverse(double value) const;  ///< t, clamped to [0, 1]
};
/// Return the mappings that chooseMappings compares. The first one is plain NoV or plain m.
const std::vector<AxisMapping>& viewMappings();
const std::vector<AxisMapping>& roughnessMappings();
/// Return the mapping of a name. Throw std::out_of_range for a name that the list does not have.
const AxisMapping& viewMapping(const std::string& name);
const AxisMapping& roughnessMapping(const std::string& name);

struct SpecularTableOptions {
    lighting::SpecularLobe lobe = lighting::SpecularLobe::Beckmann;
    lighting::CookTorranceNormalization normalization = lighting::CookTorranceNormalization::Energy;
    int viewCount = 8, roughnessCount = 16;  ///< 2..1024 each; roughnessCount may be 1 where minimum == maximum
    AxisMapping view = viewMappings().front(), roughness = roughnessMappings().front();
    double minimumM = 1.0 / 16, maximumM = 1.0;  ///< the range of m that the scene uses; 1e-4 <= minimumM <= maximumM <= 1
    int pointCount = lighting::AreaSpecularColumn::kDefaultPoints;  ///< Gauss points a piece, 4 to 32
};

/// Errors of a bilinear filter between ideal nodes under a pair of mappings.
struct MappingFigure {
    std::string view, roughness;
    double c = 0, d = 0;   ///< RMS error over the RMS of all C, and of all D; uniform in NoV and m
    double worst = 0;      ///< largest absolute error of an entry
    double reflected = 0;  ///< relative RMS error of F0 C + (1 - F0) D, over both F0
};
/// Returns the figures of every pair at the size and range of the options, for the two F0.
std::vector<MappingFigure> mappingFigures(const SpecularTableOptions& options, double lowF0, double highF0);
/// Sets both mappings of the options to those of least `reflected`. Plain NoV or m is kept unless the best is 3 % better, since it costs
/// the shader no square root.
void chooseMappings(SpecularTableOptions& options, double lowF0, double highF0);

/// An axis of a table: texel i of `count` holds the value at `minimum + (maximum - minimum) i / (count - 1)` of its mapping. Ends lie on
/// the centres of the outer texels: the texture coordinate is value * coordinateScale + coordinateOffset.
struct TableAxis {
    int count = 0;
    double minimum = 0, maximum = 0;
    double coordinateScale = 0, coordinateOffset = 0;

    double value(int texelIndex) const;
};

/// One RGBA texture, 16 bits a channel: stored = (value - bias) / scale in [0, 1], code = round(65535 stored). A shader computes
/// stored * scale + bias.
struct SpecularTexture {
    formats::Image<glm::vec4> values;     ///< before quantization; x: view, y: roughness
    formats::Image<glm::u16vec4> stored;  ///< UNORM
    glm::vec4 scale{1}, bias{0};          ///< per channel, from the data; scale 1 for a constant channel
};

struct SpecularTables {
    SpecularTableOptions options;
    TableAxis view, roughness;
    SpecularTexture c0236, d0236;  ///< C and D for i = 0, 2, 3, 6
    SpecularTexture cd78;          ///< C7, C8, D7, D8
};

/// Refuses sizes, ranges and point counts outside the limits above.
formats::Result<void> checkSpecularTableOptions(const SpecularTableOptions& options);
/// Returns the viewCount kernels of one row of roughness. Pure, so that threads can share the rows. A NoV below kSmallestNoV
/// counts as that.
std::vector<lighting::AreaSpecularKernel> integrateSpecularTableRow(const SpecularTableOptions& options, int roughnessIndex);
/// Assembles roughnessCount rows, chooses scales and quantizes.
SpecularTables assembleSpecularTables(const SpecularTableOptions& options,
                                      const std::vector<std::vector<lighting::AreaSpecularKernel>>& rows);
/// Does both steps on the calling thread. The options must pass the check.
SpecularTables makeSpecularTables(const SpecularTableOptions& options);

/// Returns a bilinear sample of the quantized texture with clamped edges, as hardware computes it.
glm::vec4 sampleSpecularTexture(const SpecularTexture& texture, double u, double v);

}  // namespace lightcook::fit

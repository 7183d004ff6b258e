// Cook-Torrance as SH tables: C and D of the area-specular sum over view and roughness, as three RGBA images.
// Source: Chen and Liu, Lighting and Material of Halo 3, section 1.4.3 and Listing 3, with the errata of lighting-math section 4.
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

/// What an axis measures of t, NoV or m: sqrt((p0 + p1 t) (q0 + q1 t)), monotone over [0, 1]. Four numbers that a shader can decode by, in
/// single precision too, and enough for sines, cosines, roots, offsets, and steps that grow with the distance from grazing.
struct AxisMapping {
    std::string name;                    ///< as the manifest tells it, in terms of NoV or m
    std::array<double, 4> factors{};     ///< p0, p1, q0, q1
    double of(double t) const;           ///< 0 <= t <= 1
    double inverse(double value) const;  ///< t, clamped to [0, 1]
};
/// Every mapping that chooseMappings looks at. The first one is plain NoV or plain m.
const std::vector<AxisMapping>& viewMappings();
const std::vector<AxisMapping>& roughnessMappings();
/// By name: one of the lists. Throws std::out_of_range where there is none.
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

/// A pair of mappings and what a bilinear filter of ideal nodes loses under it.
struct MappingFigure {
    std::string view, roughness;
    double c = 0, d = 0;   ///< RMS over the RMS of all C, of all D; uniform in NoV and m
    double worst = 0;      ///< of an entry, absolute
    double reflected = 0;  ///< of F0 C + (1 - F0) D, both F0 together
};
/// The figures of every pair at the size and range of the options, for F0 from low to high.
std::vector<MappingFigure> mappingFigures(const SpecularTableOptions& options, double lowF0, double highF0);
/// Sets both mappings of the options to those of least `reflected`. Plain NoV or m stays where the best is not 3 % better: its root costs a
/// shader more than that is worth.
void chooseMappings(SpecularTableOptions& options, double lowF0, double highF0);

/// An axis of a table: texel i of `count` holds the value at `minimum + (maximum - minimum) i / (count - 1)` of its mapping. Ends lie on
/// the centres of the outer texels: the texture coordinate is value * coordinateScale + coordinateOffset.
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

/// Refuses sizes, ranges and point counts outside the limits above.
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

}  // namespace lightcook::fit

// Radially symmetric reflection maps (RSRM): a gradient over zones of equal solid angle, convolved with normalised Phong lobes, one row for
// each exponent. docs/theory/lighting.md, "Radially symmetric reflection maps", has the formulas and the corrections to the source.
// Source: Stone 2009, Radially-Symmetric Reflection Maps.
#pragma once

#include <glm/gtc/type_precision.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "formats/error.h"
#include "formats/image.h"

namespace lightcook::fit {

struct RsrmOptions {
    int width = 256;  ///< [texels] of a row, 1..65536; texel j is the lobe around r with z = 1 - (2j + 1) / width, north to south
    std::vector<double> exponents = {1, 4, 16, 64, 256, 1024, 4096, 16384};  ///< each in [1, 65536]; exponent 1 is Lambert exit radiance
    bool dither = false;  ///< error diffusion along each row: the rounding error of a texel is added to the next, channel by channel
};

struct Rsrm {
    std::vector<double> exponents;      ///< row by row
    formats::Image<glm::dvec3> values;  ///< L_o before quantization: x over z, y over exponents
    glm::vec3 color{0};                 ///< largest value of each channel, rounded up to a float: value = code / 255 * color
    formats::Image<glm::u8vec3> codes;  ///< round(255 value / color), or dithered; 0 if the channel is black
};

/// Refuses exponents and widths outside the limits, an empty gradient and values that are negative or not finite.
formats::Result<void> checkRsrm(const std::vector<glm::vec3>& gradient, const RsrmOptions& options);

/// Returns L_o(z_o) = (s + 1)/2pi * integral L_i(z) max(0, r.l)^s dw for a gradient that is constant over each zone. By Legendre series:
/// the lobe's factors and the zone integrals are closed forms. Error below 1e-6 of the brightest zone; a constant stays
/// constant.
formats::Image<glm::dvec3> convolveGradient(const std::vector<glm::vec3>& gradient, const RsrmOptions& options);

/// Convolves and quantizes. The arguments must pass the check. Codes differ from the values by at most half a code. Dithered codes differ
/// by at most one, and their sum over any first texels of a row by at most half: steps one code high become a pattern one texel wide.
Rsrm makeRsrm(const std::vector<glm::vec3>& gradient, const RsrmOptions& options);

/// Returns value / color in [0, 1], without rounding: the input of block encoders. 0 if the channel is black.
formats::Image<glm::vec3> scaledValues(const Rsrm& map);

/// Returns the power of two that floating-point formats divide a map by: it brings the largest value to [2^14, 2^15), with one octave below
/// the largest half left to filters and encoders, and 28 octaves down to its smallest normal one. 1 for black.
float floatRange(const Rsrm& map);
/// Returns value / floatRange(map): the input of floating-point encoders.
formats::Image<glm::vec3> floatValues(const Rsrm& map);

/// Returns the first zone whose hue differs from the others', which a single-channel map cannot hold. None if the channels are proportional
/// to each other within 1e-4 of each one's largest value; a black channel is proportional to any.
std::optional<std::size_t> firstZoneOfAnotherHue(const std::vector<glm::vec3>& gradient);

}  // namespace lightcook::fit

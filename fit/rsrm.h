// Radially symmetric reflection maps: a gradient over zones of equal solid angle, convolved with normalised Phong lobes, one row an
// exponent. Source: Stone, Radially-Symmetric Reflection Maps (2009), with the errata of lighting-math section 6.
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
    bool dither = false;  ///< what rounding leaves of a texel is carried to the next of its row, channel by channel
};

struct Rsrm {
    std::vector<double> exponents;      ///< row by row
    formats::Image<glm::dvec3> values;  ///< L_o before quantization: x over z, y over exponents
    glm::vec3 color{0};                 ///< the least float that no value of a channel is above: value = code / 255 * color
    formats::Image<glm::u8vec3> codes;  ///< round(255 value / color), or dithered; 0 where the channel is black
};

/// Refuses exponents and widths outside the limits, an empty gradient and values that are negative or not finite.
formats::Result<void> checkRsrm(const std::vector<glm::vec3>& gradient, const RsrmOptions& options);

/// L_o(z_o) = (s + 1)/2pi * integral L_i(z) max(0, r.l)^s dw, exact for a gradient that is constant over each zone, by Legendre series:
/// the lobe's factors and the zone integrals are both closed forms. Error below 1e-6 of the row's maximum; a constant stays constant.
formats::Image<glm::dvec3> convolveGradient(const std::vector<glm::vec3>& gradient, const RsrmOptions& options);

/// Convolves and quantizes. The arguments must pass the check. Codes are within half a code of the values; dithered ones within one, and
/// within half a code in sum over any texels from the row's beginning: bands a code high become a pattern a texel wide.
Rsrm makeRsrm(const std::vector<glm::vec3>& gradient, const RsrmOptions& options);

/// The map as what block encoders take: value / color in [0, 1], before any rounding; 0 where the channel is black.
formats::Image<glm::vec3> scaledValues(const Rsrm& map);

/// The first zone whose colour is not that of the others, brightness aside: one channel cannot hold such a gradient. None if all channels
/// are multiples of one, to 1e-4 of each one's largest value. Black channels are multiples of anything.
std::optional<std::size_t> firstZoneOfAnotherHue(const std::vector<glm::vec3>& gradient);

}  // namespace lightcook::fit

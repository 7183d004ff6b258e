// What a cooked radially symmetric reflection map is worth: codes times colour, fetched as the shader does, against a convolution of the
// gradient by quadrature around the reflection vector.
#pragma once

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <vector>

#include "formats/image.h"
#include "verify/figures.h"

namespace verify {

/// A map as its manifest describes it, decoded.
struct CookedRsrm {
    glm::vec3 color{0};
    std::vector<double> exponents;     ///< a row each, >= 1
    formats::Image<glm::vec4> texels;  ///< as fetched, in [0, 1]
};

/// L_o(z) = (s + 1)/2pi * integral L_i max(0, r.l)^s dw of a gradient that is constant over zones of equal solid angle, north to south.
/// Rings around r, exact along each of them: within 2e-4 of the gradient's largest value.
glm::dvec3 convolvePhong(const std::vector<glm::vec3>& gradient, double exponent, double z);

/// One row's comparison: at texel centres, and at `between` places from each centre to the next and from the outer ones to the poles.
struct RsrmRow {
    struct Point {
        double z = 0;
        bool isCentre = false;
        glm::dvec3 reference{0}, cooked{0};
    };
    std::vector<Point> points;  ///< north to south
    double bandingCodes = 0;    ///< largest step between neighbouring texels, in codes of 255
};
/// Pure, safe on several threads.
RsrmRow compareRsrmRow(const CookedRsrm& map, const std::vector<glm::vec3>& gradient, int row, int between = 1);

/// The largest error at a texel centre, in codes of 255 of the map's colour, beyond the half code that rounding takes and what the
/// reference itself may be off.
struct RsrmCodeError {
    double codes = 0;
    int row = 0, column = 0;
};
RsrmCodeError rsrmCodeError(const CookedRsrm& map, const std::vector<glm::vec3>& gradient, const std::vector<RsrmRow>& rows);

/// Stages "quantize" (texel centres) and "total" (between them too). The row of exponent 1 is diffuse, the others specular. Between rows a
/// shader blends lobes: that is its choice and no error of the map. Key: log-average luminance of the references at texel centres.
std::vector<StageError> rsrmStages(const CookedRsrm& map, const std::vector<glm::vec3>& gradient, const std::vector<RsrmRow>& rows,
                                   const glm::vec3& luminanceWeights);

}  // namespace verify

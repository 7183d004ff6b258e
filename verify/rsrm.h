// What a cooked radially symmetric reflection map is worth: codes times colour, fetched as the shader does, against a convolution of the
// gradient by quadrature around the reflection vector.
#pragma once

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <vector>

#include "formats/image.h"
#include "verify/figures.h"
#include "verify/sampler_tolerance.h"

namespace lightcook::verify {

/// How far a texel's centre may be off: what its codes are.
enum class RsrmCodes {
    Rounded,   ///< within half a code of 255
    Dithered,  ///< within one: what rounding left went to the next texel of the row
    Blocks     ///< as near as the block format brings it
};

/// A map as its manifest describes it, decoded.
struct CookedRsrm {
    glm::vec3 color{0};
    std::vector<double> exponents;     ///< a row each, >= 1
    formats::Image<glm::vec4> texels;  ///< as fetched, in [0, 1]
    bool isGrey = false;               ///< one channel, which every channel of the colour is multiplied by
    RsrmCodes codes = RsrmCodes::Rounded;
    FormatFreedom freedom;            ///< what samplers may do with its format; none: they are ideal
    formats::Image<glm::vec4> spans;  ///< blockSpans of its blocks
};

/// What a map was made from. uncertainty: by channel, what the gradient itself may be off by, where it was not painted but averaged.
struct RsrmSource {
    std::vector<glm::vec3> gradient;
    glm::dvec3 uncertainty{0};
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
        glm::dvec3 freedom{0};  ///< at a centre: how far a sampler may be off there, and up to the next one
    };
    std::vector<Point> points;  ///< north to south
};
/// Pure, safe on several threads.
RsrmRow compareRsrmRow(const CookedRsrm& map, const RsrmSource& source, int row, int between = 1);

/// The largest error at a texel centre, in codes of 255 of the map's colour, beyond what its kind of codes may be off and what the
/// reference itself may be. Not positive where all is well; maps in blocks have no such law.
struct RsrmCodeError {
    double codes = 0;
    int row = 0, column = 0;
};
RsrmCodeError rsrmCodeError(const CookedRsrm& map, const RsrmSource& source, const std::vector<RsrmRow>& rows);

/// What the eye could take for bands, over all rows and channels. Codes are those of 255 of the map's colour.
struct RsrmBanding {
    double codeError = 0;  ///< largest error at a texel centre, in codes
    /// Largest step between neighbouring texels beyond the step that the exact values make there: in codes, and as a part of the light
    /// there (the larger of the two, and 0.02 of the map's key).
    double stepCodes = 0, stepContrast = 0;
    /// Largest mean error of kWindow neighbouring texels, in codes. Rounding leaves half a code wherever the light changes slowly, which is
    /// a band as wide as that; dithering leaves at most 1 / kWindow of a code, as the pattern inside the window is not counted.
    double bandCodes = 0;
    static constexpr int kWindow = 8;
};
RsrmBanding rsrmBanding(const CookedRsrm& map, const std::vector<RsrmRow>& rows, const glm::vec3& luminanceWeights);

/// Two maps of the same exponents blended as the shader does it, against the convolution of the blended gradients (of one length), at the
/// texel centres and between them.
struct RsrmBlend {
    ErrorFigures figures;  ///< key: as for the stages, of the blended references
    double codeError = 0;  ///< largest error at a texel centre of `first`, over the sum of both maps' codes of 255, each times its weight
};
RsrmBlend compareRsrmBlend(const CookedRsrm& first, const std::vector<glm::vec3>& firstGradient, const CookedRsrm& second,
                           const std::vector<glm::vec3>& secondGradient, double weight, int between = 1);

/// Stages "quantize" (texel centres) and "total" (between them too). The row of exponent 1 is diffuse, the others specular. Between rows a
/// shader blends lobes: that is its choice and no error of the map. Key: log-average luminance of the references at texel centres.
std::vector<StageError> rsrmStages(const CookedRsrm& map, const RsrmSource& source, const std::vector<RsrmRow>& rows,
                                   const glm::vec3& luminanceWeights);

}  // namespace lightcook::verify

// Verification of a radially symmetric reflection map (RSRM): code times colour, fetched as the shader does, against a convolution of the
// gradient by quadrature around the reflection vector. docs/theory/lighting.md, "Radially symmetric reflection maps", describes the map.
//
// Use: axialGradient if the gradient came from an environment -> compareRsrmRow for each row -> rsrmCodeError, rsrmBanding, rsrmStages.
#pragma once

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <optional>
#include <vector>

#include "formats/environment.h"
#include "formats/image.h"
#include "verify/figures.h"
#include "verify/sampler_tolerance.h"

namespace lightcook::verify {

/// Codes of a map and their rounding, which bounds the error at the centre of a texel. A code is a step of the format there: 1/255 of the
/// colour, or of floats the distance to the next one.
enum class RsrmCodes {
    Rounded,         ///< of 8 bits: at most half a code
    Dithered,        ///< of 8 bits: at most one code, since each rounding error is carried to the next texel of the row
    Blocks,          ///< of 8 bits, no bound: whatever the block format gives
    HalfBlocks,      ///< of halves, no bound: whatever the block format gives
    SharedExponent,  ///< 9 bits of mantissa under the exponent of the largest channel: at most kSharedExponentCodes
    Halves           ///< at most half a code
};
/// Largest rounding error of a shared exponent that minimizes the summed square over three channels: nearest rounding at the exponent that
/// holds the largest channel has 3/4 in all, or 3/2 where that channel is within half a code of the next exponent.
inline constexpr double kSharedExponentCodes = 1.225;

/// A map as its manifest describes it, decoded.
struct CookedRsrm {
    glm::vec3 color{0};
    std::vector<double> exponents;     ///< one for each row, >= 1
    formats::Image<glm::vec4> texels;  ///< as fetched; in [0, 1], except for floats
    bool isGrey = false;               ///< one channel, multiplied by every channel of the colour
    RsrmCodes codes = RsrmCodes::Rounded;
    FormatTolerance tolerance;        ///< of samplers, for the map's format; default: ideal samplers
    formats::Image<glm::vec4> spans;  ///< blockSpans of the map's blocks
};

/// The gradient that a map was made from.
struct RsrmSource {
    std::vector<glm::vec3> gradient;
    glm::dvec3 uncertainty{0};  ///< largest error of the gradient by channel, if it was averaged from an environment
};

/// Radiance of an environment around an axis, by polar angle.
struct AxialGradient {
    std::vector<glm::vec3> gradient;  ///< zones of equal solid angle, from the axis to its opposite
    glm::dvec3 uncertainty{0};        ///< error estimate by channel: twice the largest difference to a result with half as many lines
    double asymmetricEnergy = 0;      ///< share of the squared radiance that the zones' means do not hold
};
/// Returns the mean radiance of each zone, independently of the fit: along lines through the texels, cut exactly where zones begin.
/// axis  any length but 0
AxialGradient axialGradient(const formats::Environment& environment, const glm::dvec3& axis, int zoneCount);

/// Returns L_o(z) = (s + 1) / 2pi * integral L_i max(0, r.l)^s dw for a gradient that is constant over zones of equal solid angle, north to
/// south. The error is below 4e-7 of the sum of the steps between zones, for any number of zones.
glm::dvec3 convolvePhong(const std::vector<glm::vec3>& gradient, double exponent, double z);

/// Comparison of one row: at texel centres, and at `between` places from each centre to the next and from the outer centres to the poles.
struct RsrmRow {
    struct Point {
        double z = 0;
        bool isCentre = false;
        glm::dvec3 reference{0}, cooked{0};
        glm::dvec3 tolerance{0};  ///< at a centre: largest sampler error there and up to the next centre
    };
    std::vector<Point> points;  ///< north to south
};
/// Pure, safe on several threads.
RsrmRow compareRsrmRow(const CookedRsrm& map, const RsrmSource& source, int row, int between = 1);

/// Returns the size of a code of the map at some light, by channel [light].
glm::dvec3 rsrmCodeSize(const CookedRsrm& map, const glm::dvec3& light);

/// The largest error at a texel centre beyond what RsrmCodes and the source's uncertainty allow, in codes. At most 0 for a correct map, and
/// the largest double for a texel that is not finite.
/// Maps in block formats are not checked.
struct RsrmCodeError {
    double codes = 0;
    int row = 0, column = 0;
};
RsrmCodeError rsrmCodeError(const CookedRsrm& map, const RsrmSource& source, const std::vector<RsrmRow>& rows);
/// Checks that the codes of a map that is called dithered are dithered. Error diffusion carries each rounding error to the next texel, so
/// that the errors of any texels from the first one on sum to at most half a code. Rounded codes pass one by one, but their sums grow along
/// a band. Returns the largest sum beyond half a code, the rounding of the check and the source's uncertainty, in codes; at most 0 for a
/// dithered map and for one that is not called so.
RsrmCodeError rsrmDitherError(const CookedRsrm& map, const RsrmSource& source, const std::vector<RsrmRow>& rows);

/// Visibility of banding, over all rows and channels.
struct RsrmBanding {
    double codeError = 0;  ///< largest error at a texel centre, in codes
    /// Largest step between neighbouring texels beyond the exact step: in codes, and relative to the light there (the larger of the two
    /// texels, and 0.02 key).
    double stepCodes = 0, stepContrast = 0;
    /// Largest mean error of kWindow neighbouring texels, in codes. Rounding leaves half a code wherever light changes slowly, which shows
    /// as a band of that width. Dithering leaves at most 1 / kWindow of a code: errors inside the window cancel.
    double bandCodes = 0;
    static constexpr int kWindow = 8;
};
RsrmBanding rsrmBanding(const CookedRsrm& map, const std::vector<RsrmRow>& rows, const glm::vec3& luminanceWeights);

/// Result of compareRsrmBlend.
struct RsrmBlend {
    ErrorFigures figures;  ///< their key is that of the blended references
    double codeError = 0;  ///< largest error at a texel centre of `first`, over the weighted sum of both maps' codes of 255
};
/// Compares the shader's blend of two maps with the convolution of the blended gradients, at texel centres and between them. Both maps have
/// the same exponents, both gradients the same length.
RsrmBlend compareRsrmBlend(const CookedRsrm& first, const std::vector<glm::vec3>& firstGradient, const CookedRsrm& second,
                           const std::vector<glm::vec3>& secondGradient, double weight, int between = 1);

/// Returns stages "quantize" (texel centres) and "total" (between them too). The row of exponent 1 is diffuse, the others are specular.
/// Blending of lobes between rows is the shader's choice and counts as no error. Key: log-average luminance of the references at centres.
/// viewing  display for visible errors, of the light of a row as it is: a white Lambert surface, or a lobe that reflects all light; empty:
///          none
std::vector<StageError> rsrmStages(const CookedRsrm& map, const RsrmSource& source, const std::vector<RsrmRow>& rows,
                                   const glm::vec3& luminanceWeights, const std::optional<Viewing>& viewing = std::nullopt);

/// Returns the key that a display shows a gradient's light with (docs/theory/visible.md): displayKeyOf the exit radiance of white Lambert
/// surfaces that it lights, for 64 normals at heights of equal solid angle.
double rsrmDisplayKey(const std::vector<glm::vec3>& gradient, const glm::vec3& luminanceWeights);

}  // namespace lightcook::verify

// Pre-divided cubemaps: stored(r) = prefiltered(r) / S_mip(r), the prefiltered cubemap divided by its own area lighting. A shader
// multiplies by the area lighting of the shaded point instead. S_mip is the probe's SH convolved with the kernel of the mip, windowed until
// it is positive everywhere. docs/theory/lighting.md, "Pre-divided cubemaps". Sources: Chen and Liu 2008, Lighting and Material of Halo 3,
// section 1.4.2; Sloan 2008, Stupid Spherical Harmonics (SH) Tricks (window).
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "formats/image.h"
#include "lighting/sh.h"

namespace lightcook::fit {

/// S of a channel whose mean is smaller than this: a black probe stores zero and stays finite.
inline constexpr double kBlackDenominator = 1e-30;

struct PreDivideOptions {
    double epsilon = 0.05;  ///< S >= epsilon * its mean over the sphere, in every direction, channel and mip; in (0, 1)
};

/// The denominator, with everything that a shader needs to multiply back. S_mip(r) = sum_i bands_l(i) windowedSh_i Y_i(r).
struct PreDivide {
    double epsilon = 0;
    /// Lambda of the window w_l = 1 / (1 + lambda l^2 (l + 1)^2), which minimises the squared Laplacian (Sloan 2008): the smallest
    /// lambda >= 0 that keeps S >= epsilon * mean. 0: no window.
    double windowLambda = 0;
    lighting::ShBands window{1, 1, 1};
    lighting::ShRgb windowedSh{};          ///< canonical signs, radiance; black channels hold kBlackDenominator
    std::vector<lighting::ShBands> bands;  ///< of each mip's kernel

    /// Returns S_mip(direction), > 0 in every channel; direction is unit.
    glm::dvec3 denominator(int mip, const glm::dvec3& direction) const;
};

/// Finds the window.
/// incident  SH of the probe, finite
/// bands     zonal factors of the kernel of each mip
PreDivide makePreDivide(const lighting::ShRgb& incident, const std::vector<lighting::ShBands>& bands, const PreDivideOptions& options);

/// Divides rows of a face in place: stored * S == prefiltered up to float rounding. Returns the count of channel values whose quotient
/// exceeds the largest float and is clamped to it.
/// rows  [firstRow, firstRow + rows.height) of the face; as wide as the face
std::int64_t preDivideRows(const PreDivide& preDivide, int mip, int face, int firstRow, formats::ImageView<glm::vec3> rows);

}  // namespace lightcook::fit

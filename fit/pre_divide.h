// Division of a prefiltered cubemap by its own area lighting: stored(r) = prefiltered(r) / S_mip(r), so that a shader can multiply by the
// pixel's own instead. S_mip is the probe's SH, windowed until it is positive everywhere, through the mip's kernel. Source: Chen and Liu,
// Lighting and Material of Halo 3, section 1.4.2; lighting-math section 5.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "formats/image.h"
#include "lighting/sh.h"

namespace lightcook::fit {

/// S of a channel whose mean is smaller than this is this constant: a black probe stores zero and stays finite.
inline constexpr double kBlackDenominator = 1e-30;

struct PreDivideOptions {
    double epsilon = 0.05;  ///< S >= epsilon * its mean over the sphere, in every direction, channel and mip; in (0, 1)
};

/// Everything that is needed to multiply back; a manifest writes all of it. S_mip(r) = sum_i bands_l(i) windowedSh_i Y_i(r).
struct PreDivide {
    double epsilon = 0;
    /// Window w_l = 1 / (1 + lambda l^2 (l + 1)^2): the smallest lambda >= 0 that keeps S >= epsilon * mean (Sloan 2008, Stupid Spherical
    /// Harmonics Tricks: minimal squared Laplacian). 0: nothing was windowed.
    double windowLambda = 0;
    lighting::ShBands window{1, 1, 1};
    lighting::ShRgb windowedSh{};          ///< canonical phase, radiance; black channels hold kBlackDenominator
    std::vector<lighting::ShBands> bands;  ///< of each mip's kernel

    /// S_mip(direction), > 0 in every channel; direction unit.
    glm::dvec3 denominator(int mip, const glm::dvec3& direction) const;
};

/// incident: SH of the probe, finite. bands: one entry a mip. epsilon in (0, 1).
PreDivide makePreDivide(const lighting::ShRgb& incident, const std::vector<lighting::ShBands>& bands, const PreDivideOptions& options);

/// Divides rows [firstRow, firstRow + prefiltered.height) of a face of `size` texels; in place is allowed. stored * S == prefiltered to
/// float rounding, but for the channel values that are returned: so many quotients were larger than any float and are held at the largest.
std::int64_t preDivideRows(const PreDivide& preDivide, int mip, int face, int size, int firstRow,
                           formats::ImageView<const glm::vec3> prefiltered, formats::ImageView<glm::vec3> stored);

}  // namespace lightcook::fit

// Diffuse light of an environment as a cubemap, without the truncation of nine SH coefficients.
#pragma once

#include <glm/vec3.hpp>

#include "formats/environment.h"
#include "formats/error.h"
#include "formats/image.h"

namespace lightcook::fit {

struct IrradianceOptions {
    int size = 32;    ///< [texels] of a face, 1..1024
    double wrap = 0;  ///< in [0, 1]; 0: Lambert
    /// Cells of the source on a side of a face: a power of two, 4 to 128. Only cells that the horizon crosses cause an error.
    /// docs/lab/fit.md has time against error.
    int cellsPerSide = 32;
};

/// Returns the exit radiance of a white surface for every normal, at texel centres of a strip of six faces +X -X +Y -Y +Z -Z:
///   integral of L(l) max(0, n.l + w) / (pi (1 + w)^2) dl.
/// Energy conserving: a constant stays constant. Irradiance is pi times that; its zonal factors are lighting::wrappedLambertBands(wrap).
/// Results lie between zero and the brightest source value. The kernel is linear in l except at its horizon, so cells with exact solid
/// angle and centroid cause an error only there.
formats::Result<formats::Image<glm::vec3>> irradianceCubemap(const formats::Environment& environment, const IrradianceOptions& options);

}  // namespace lightcook::fit

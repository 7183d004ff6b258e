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
    /// A power of two, 4..128: cells of the source on a side of a face, of which the horizon crosses few. docs/fits.md has time against
    /// error.
    int cellsPerSide = 32;
};

/// Exit radiance of a white surface for every normal, at texel centres of a strip of six faces +X -X +Y -Y +Z -Z:
///   integral of L(l) max(0, n.l + w) / (pi (1 + w)^2) dl,
/// energy conserving: a constant stays what it is (the grey test). Irradiance is pi times that; its SH bands are
/// lighting::wrappedLambertBands(wrap). Results lie between zero and the brightest source value.
/// Source: lighting-math section 1; the kernel is linear but for its horizon, so cells with exact moments err only there.
formats::Result<formats::Image<glm::vec3>> irradianceCubemap(const formats::Environment& environment, const IrradianceOptions& options);

}  // namespace lightcook::fit

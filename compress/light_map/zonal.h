// Zonal band 2: the layouts luvw-linear and zh3 store one number for the five coefficients of band 2 and take its axis from band 1, which
// the decoder has. Exact for light that is rotationally symmetric about that axis. Private to compress/.
#pragma once

#include <glm/vec3.hpp>

#include "compress/light_map/rows.h"
#include "lighting/sh.h"

namespace lightcook::compress::rows {

/// Returns the unit direction of the luminance of band 1 (coefficients 1, 2, 3), or 0 if that is 0. Light of any unit.
glm::vec3 linearAxis(const glm::vec3& c1, const glm::vec3& c2, const glm::vec3& c3, const glm::vec3& luminanceWeights);
/// Returns for each channel the z that brings z sqrt(4 pi / 5) Y_2m(axis) nearest to band 2: the projection of band 2 on the axis. Returns
/// 0 for axis 0.
glm::vec3 zonalAlong(const lighting::ShRgb& sh, const glm::vec3& axis);
/// Returns the same as the intensity of a directional light from the axis, at least 0. Halo 3 fits the intensity to all nine coefficients.
/// But only band 2 is restored from it, and a fit to all would give ambient light a spurious light source along its noise in band 1.
glm::vec3 intensityAlong(const lighting::ShRgb& sh, const glm::vec3& axis);

/// Returns along(sh, axis) for each texel, where the axis is that of a decoded band 1.
/// band1(i, x, y)  coefficient i of it, 1 to 3
template <class Band1, class Along>
formats::Image<glm::vec3> alongAxis(const LightMapPlan& plan, const Source& source, Band1&& band1, Along&& along) {
    const glm::vec3 luminance(constant(plan, "luminance", 0), constant(plan, "luminance", 1), constant(plan, "luminance", 2));
    formats::Image<glm::vec3> out(source.width, source.height, glm::vec3(0));
    for (int y = 0; y < source.height; ++y)
        for (int x = 0; x < source.width; ++x) {
            if (!(source.coverage.at(x, y) > 0)) continue;
            lighting::ShRgb sh;
            for (std::size_t i = 0; i < sh.size(); ++i) sh[i] = source.values[i].at(x, y);
            out.at(x, y) = along(sh, linearAxis(band1(1, x, y), band1(2, x, y), band1(3, x, y), luminance));
        }
    return out;
}

}  // namespace lightcook::compress::rows

// The residual of layouts in tangent space: max(0, b_i . n), which the engine shows for R_i = 1, less the light of the coefficients that
// the verifier takes for it, over the hemisphere of the surface. Private to verify/.
//
// The differences of the three directions are one function, turned by 120 degrees about the normal. It has the extremes kLowest and
// kHighest and the largest slope kSlope, all rounded outwards, so that over the normals within an angle of one it is an interval of values.
// tests/verify/light_map/rnm_test.cpp holds all three against dense samples.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/vec3.hpp>

#include "shaders/lightcook_cpp.h"

namespace lightcook::verify {

struct RnmResidual {
    static constexpr double kLowest = -0.1253, kHighest = 0.0544, kSlope = 0.66;
    static constexpr double kLargest = std::max(-kLowest, kHighest);  ///< magnitude
    /// Rounding of the shader's floats.
    static constexpr double kRounding = 2e-6;

    std::array<double, 3> centre{}, radius{};  ///< of each direction

    /// Returns the range over the normals within `reach` [rad] of one, in the right-handed frame of tangent and normal. For a surface whose
    /// bitangent is on the other side, the second and third direction change places.
    static RnmResidual around(const glm::dvec3& normal, double reach) {
        RnmResidual out;
        const glm::vec3 n(normal), weights = shaders::lcRnmWeights(n);
        for (std::size_t i = 0; i < 3; ++i) {
            shaders::LcRnmTexels one{glm::vec4(i == 0 ? 1.0f : 0.0f), glm::vec4(i == 1 ? 1.0f : 0.0f), glm::vec4(i == 2 ? 1.0f : 0.0f)};
            const shaders::LcSh sh = shaders::lcLightMapRnm(one, glm::vec3(1, 0, 0), glm::vec3(0, 1, 0), glm::vec3(0, 0, 1));
            const auto middle = static_cast<double>(weights[static_cast<int>(i)] - shaders::lcExitRadiance(sh, n).x);
            const double low = std::max(middle - kSlope * reach - kRounding, kLowest),
                         high = std::min(middle + kSlope * reach + kRounding, kHighest);
            out.centre[i] = 0.5 * (low + high);
            out.radius[i] = 0.5 * (high - low);
        }
        return out;
    }
};

}  // namespace lightcook::verify

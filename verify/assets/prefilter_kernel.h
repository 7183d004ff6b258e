// The kernels of prefiltered cubemaps: D(NoH) c for n = v = r, where c is the cosine to the kernel's axis. Private to verify/.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <numbers>

#include "lighting/brdf.h"

namespace lightcook::verify {

/// Unnormalized directions of faces are major + u right + v down (the table in lighting/cube.h, as signed axes).
struct FaceAxes {
    glm::dvec3 major, right, down;
};
inline constexpr FaceAxes kFaceAxes[6] = {{{1, 0, 0}, {0, 0, -1}, {0, -1, 0}}, {{-1, 0, 0}, {0, 0, 1}, {0, -1, 0}},
                                          {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}},   {{0, -1, 0}, {1, 0, 0}, {0, 0, -1}},
                                          {{0, 0, 1}, {1, 0, 0}, {0, -1, 0}},  {{0, 0, -1}, {-1, 0, 0}, {0, -1, 0}}};

/// Returns exp(max(x, -700)) for x <= 0, to a relative 3e-10: 2^n by its bits, the rest by a Taylor series up to x^8 / 8!. It has no branch
/// and no call, so that loops over it are vectorized.
inline double expOfNegative(double x) {
    constexpr double kRounder = 0x1.8p52;  // a number added to it is rounded to an integer in the lowest bits
    const double scaled = (x < -700 ? -700 : x) * std::numbers::log2e;
    const double shifted = scaled + kRounder, r = (scaled - (shifted - kRounder)) * std::numbers::ln2;
    const double power = std::bit_cast<double>((std::bit_cast<std::uint64_t>(shifted) + 1023) << 52);
    const double even = 1 + r * r * (1.0 / 2 + r * r * (1.0 / 24 + r * r * (1.0 / 720 + r * r * (1.0 / 40320))));
    return power * (even + r * (1 + r * r * (1.0 / 6 + r * r * (1.0 / 120 + r * r * (1.0 / 5040)))));
}

/// Returns the unnormalized kernel, where NoH is the cosine of half the angle: NoH^2 = (1 + c) / 2, tan^2 = 1 / NoH^2 - 1; 0 behind the
/// plane. GGX: D is 1 / (tan^2 + m^2)^2 / NoH^4.
template <lighting::NormalDistribution kLobe>
inline double kernelShape(double cosine, double squaredM) {
    const double c = cosine < 0 ? 0 : cosine, inverse = 2 / (1 + c);
    if constexpr (kLobe == lighting::NormalDistribution::Ggx) {
        const double scaled = inverse / (inverse - 1 + squaredM);
        return scaled * scaled * c;
    } else {
        return expOfNegative((1 - inverse) * (1 / squaredM)) * inverse * inverse * c;
    }
}

/// Returns the angle [rad] beyond which the kernel is 0 or below 1e-7 of its peak.
inline double kernelSupport(double m, lighting::NormalDistribution lobe) {
    return lobe == lighting::NormalDistribution::Ggx ? 0.5 * std::numbers::pi : std::min(2 * std::atan(4 * m), 0.5 * std::numbers::pi);
}

}  // namespace lightcook::verify

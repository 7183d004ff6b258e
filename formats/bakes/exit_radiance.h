// Coefficients of radiance that show given exit radiance. Under radiance SH of order 1 a white surface shows
//   E(n) / pi = Y_0 lambda_0 + (2/3) sum_m Y_1m(n) lambda_1m = L0 + n . L1
// so lambda_0 = L0 / 0.282095 and lambda_1 = L1 / 0.325735, in the order y, z, x.
#pragma once

#include <numbers>

namespace lightcook::formats {

/// lambda_0 of L0 = 1: 2 sqrt(pi).
inline constexpr float kFirstOfExit = 2 / std::numbers::inv_sqrtpi_v<float>;
/// lambda_1 of |L1| = 1: sqrt(3 pi).
inline constexpr float kLinearOfExit = std::numbers::sqrt3_v<float> / std::numbers::inv_sqrtpi_v<float>;

}  // namespace lightcook::formats

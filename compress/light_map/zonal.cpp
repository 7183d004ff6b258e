#include "compress/light_map/zonal.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>

namespace lightcook::compress::rows {

glm::vec3 linearAxis(const glm::vec3& c1, const glm::vec3& c2, const glm::vec3& c3, const glm::vec3& luminanceWeights) {
    const glm::vec3 v(glm::dot(luminanceWeights, c3), glm::dot(luminanceWeights, c1), glm::dot(luminanceWeights, c2));
    const float largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
    return largest > 0 ? glm::normalize(v / largest) : glm::vec3(0);
}

glm::vec3 zonalAlong(const lighting::ShRgb& sh, const glm::vec3& axis) {
    const float root3 = std::numbers::sqrt3_v<float>;
    const std::array<float, 5> y = {root3 * axis.x * axis.y, root3 * axis.y * axis.z,
                                    axis.z * axis.z - 0.5f * (axis.x * axis.x + axis.y * axis.y), root3 * axis.x * axis.z,
                                    0.5f * root3 * (axis.x * axis.x - axis.y * axis.y)};
    glm::vec3 zonal(0);
    for (std::size_t m = 0; m < y.size(); ++m) zonal += y[m] * sh[4 + m];
    return zonal;
}

glm::vec3 intensityAlong(const lighting::ShRgb& sh, const glm::vec3& axis) {
    constexpr float lengthOfBand2 = 0.63078313f;  // sqrt(5 / 4 pi): |Y_2(axis)|
    return glm::max(zonalAlong(sh, axis) / lengthOfBand2, 0.0f);
}

}  // namespace lightcook::compress::rows

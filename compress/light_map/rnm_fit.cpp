#include "compress/light_map/rnm_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace lightcook::compress::rows {

namespace {

/// Means over the ring: of w_0^2, of w_0 w_1, and of w_0 times what coefficients 0, 2, 3, 6, 7 and 8 show; the others have none.
/// tests/compress/light_map/rnm_fit_test.cpp derives them.
constexpr double kOwn = 0.3245762, kOther = 0.1312267;
constexpr double kConstant = 0.1242113, kZ = 0.1017042, kX = 0.0575714, kZz = 0.0190507, kXz = 0.0324599, kXx = 0.0020458;

constexpr double kHalfRoot3 = 0.86602540378443864676;

}  // namespace

RnmFit::RnmFit(const lighting::ShDouble& light) {
    // Azimuths 0, -120 and 120 degrees: twice the angle is the opposite angle.
    constexpr std::array<double, 3> kCosine = {1, -0.5, -0.5}, kSine = {0, -kHalfRoot3, kHalfRoot3};
    for (std::size_t i = 0; i < 3; ++i)
        moments_[static_cast<int>(i)] = kConstant * light[0] + kZ * light[2] + kX * (kCosine[i] * light[3] + kSine[i] * light[1]) +
                                        kZz * light[6] + kXz * (kCosine[i] * light[7] + kSine[i] * light[5]) +
                                        kXx * (kCosine[i] * light[8] - kSine[i] * light[4]);
}

glm::dvec3 RnmFit::best(std::span<const double> known) const {
    const int first = static_cast<int>(known.size());
    glm::dvec3 found(0);
    double least = std::numeric_limits<double>::infinity();
    for (unsigned zeros = 0; zeros < (1u << (3 - first)); ++zeros) {
        glm::dvec3 each(0);
        double knownSum = 0, momentSum = 0;
        int count = 0;
        for (int i = 0; i < 3; ++i) {
            if (i < first) {
                each[i] = known[static_cast<std::size_t>(i)];
                knownSum += each[i];
            } else if ((zeros >> (i - first) & 1u) == 0) {
                momentSum += moments_[i];
                ++count;
            }
        }
        // (kOwn - kOther) R_i + kOther (sum of all R) = h_i for the free ones.
        const double sum = (momentSum - count * kOther * knownSum) / (kOwn - kOther + count * kOther);
        for (int i = first; i < 3; ++i)
            if ((zeros >> (i - first) & 1u) == 0) each[i] = (moments_[i] - kOther * (knownSum + sum)) / (kOwn - kOther);
        if (std::min({each.x, each.y, each.z}) < 0) continue;
        if (zeros == 0) return each;
        const double cost = this->cost(each);
        if (!(cost < least)) continue;
        least = cost;
        found = each;
    }
    return found;
}

double RnmFit::cost(const glm::dvec3& light) const {
    const double sum = light.x + light.y + light.z;
    return (kOwn - kOther) * glm::dot(light, light) + kOther * sum * sum - 2 * glm::dot(moments_, light);
}

}  // namespace lightcook::compress::rows

#include "lighting/display.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace lightcook::lighting {
namespace {

/// Returns a matrix from its rows, as standards print them.
glm::dmat3 fromRows(const glm::dvec3& first, const glm::dvec3& second, const glm::dvec3& third) {
    return glm::transpose(glm::dmat3(first, second, third));
}

}  // namespace

Display DisplaySettings::of(double key) const {
    const double nits = white ? kDiffuseWhite / *white : kKeyOfDiffuseWhite * kDiffuseWhite / (key > 0 ? key : 1);
    return {nits * std::exp2(stops), black};
}

glm::dmat3 bt2020FromRec709() {
    return fromRows({0.627404, 0.329283, 0.043313}, {0.069097, 0.919540, 0.011362}, {0.016391, 0.088013, 0.895595});
}

glm::dmat3 lmsFromBt2020() {
    return fromRows({1688, 2146, 262}, {683, 2951, 462}, {99, 309, 3688}) / 4096.0;
}

double perceptualQuantizer(double nits) {
    constexpr double kM1 = 2610.0 / 16384, kM2 = 2523.0 / 32, kC1 = 3424.0 / 4096, kC2 = 2413.0 / 128, kC3 = 2392.0 / 128;
    const double y = std::pow(std::clamp(nits, 0.0, kMostNits) / kMostNits, kM1);
    return std::pow((kC1 + kC2 * y) / (1 + kC3 * y), kM2);
}

glm::dmat3 itpFromLms() {
    return fromRows({2048, 2048, 0}, {6610 / 2.0, -13613 / 2.0, 7003 / 2.0}, {17933, -17390, -543}) / 4096.0;
}

glm::dvec3 ictcpItp(const glm::dvec3& bt2020) {
    const glm::dvec3 lms = lmsFromBt2020() * bt2020;
    return itpFromLms() * glm::dvec3(perceptualQuantizer(lms.x), perceptualQuantizer(lms.y), perceptualQuantizer(lms.z));
}

double visibleDifference(const glm::dvec3& a, const glm::dvec3& b, const Display& display, const glm::dmat3& bt2020FromWorking) {
    const auto shown = [&](const glm::dvec3& light) {
        return ictcpItp(bt2020FromWorking * (glm::max(light, 0.0) * display.nitsPerUnit + display.black));
    };
    return kVisibleScale * glm::distance(shown(a), shown(b));
}

}  // namespace lightcook::lighting

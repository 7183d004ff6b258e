#include "fit/dominant_light.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

namespace fit {
namespace {

/// Sums leave float's range where coefficients are near its end; the light stays finite.
float toFiniteFloat(double value) {
    constexpr double kLargest = std::numeric_limits<float>::max();
    return static_cast<float>(std::clamp(value, -kLargest, kLargest));
}

double smoothStep(double start, double end, double x) {
    const double t = std::clamp((x - start) / (end - start), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

/// Luminance of the band-1 coefficients as a vector (x, y, z) over sqrt(3) lambda_0, inside the unit ball; zero where there is no light.
glm::dvec3 linearDirection(const lighting::ShRgb& incident, const glm::dvec3& weights) {
    const auto luminance = [&](int i) { return glm::dot(glm::dvec3(incident[static_cast<std::size_t>(i)]), weights); };
    const double dc = luminance(0);
    if (!(dc > 0)) return glm::dvec3(0);
    const glm::dvec3 vector = glm::dvec3(luminance(3), luminance(1), luminance(2)) / (std::numbers::sqrt3 * dc);
    const double length = std::hypot(vector.x, vector.y, vector.z);
    if (!std::isfinite(length)) return glm::dvec3(0);  // a denormal DC under huge linear terms: nothing that a light explains
    return length > 1 ? vector / length : vector;
}

}  // namespace

DominantLight dominantLight(const lighting::ShRgb& incident, const glm::vec3& normal, const DominantLightOptions& options) {
    assert(0 <= options.fadeStart && options.fadeStart < options.fadeEnd && options.fadeEnd <= 1);
    const glm::dvec3 linear = linearDirection(incident, glm::dvec3(options.luminanceWeights));
    const double directionality = std::min(1.0, glm::length(linear));
    const double normalLength = glm::length(glm::dvec3(normal));
    const glm::dvec3 unitNormal = normalLength > 0 ? glm::dvec3(normal) / normalLength : glm::dvec3(0, 0, 1);

    const double fade = smoothStep(options.fadeStart, options.fadeEnd, directionality);
    const double floorLength = options.fadeEnd;
    glm::dvec3 stored = fade * linear + (1 - fade) * floorLength * unitNormal;
    // Light from straight behind the normal (leaks, negative lobes) can cancel the two parts: the normal alone is then as good as any.
    double storedLength = glm::length(stored);
    if (storedLength < 1e-3 * floorLength) {
        stored = floorLength * unitNormal;
        storedLength = floorLength;
    }

    DominantLight light;
    light.direction = glm::vec3(stored);
    light.directionality = static_cast<float>(directionality);
    if (fade == 0) return light;
    const lighting::ShDouble basis = lighting::evaluateBasis(stored / storedLength);
    glm::dvec3 sum(0);
    for (std::size_t i = 0; i < basis.size(); ++i) sum += basis[i] * glm::dvec3(incident[i]);
    const double scale = fade * 4 * std::numbers::pi / lighting::kShCount;
    for (int channel = 0; channel < 3; ++channel) light.intensity[channel] = toFiniteFloat(std::max(0.0, scale * sum[channel]));
    return light;
}

void dominantLight(formats::ImageView<const lighting::ShRgb> sh, formats::ImageView<const std::uint8_t> covered,
                   formats::ImageView<const glm::vec3> normal, const DominantLightOptions& options, formats::ImageView<glm::vec3> direction,
                   formats::ImageView<glm::vec3> intensity) {
    for (int y = 0; y < sh.height; ++y) {
        for (int x = 0; x < sh.width; ++x) {
            const bool inside = covered.at(x, y) != 0;
            const DominantLight light = inside ? dominantLight(sh.at(x, y), normal.at(x, y), options) : DominantLight{};
            direction.at(x, y) = light.direction;
            intensity.at(x, y) = light.intensity;
        }
    }
}

}  // namespace fit

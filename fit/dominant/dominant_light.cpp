#include "fit/dominant_light.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

#include "fit/light_search.h"

namespace lightcook::fit {
namespace {

/// Clamps to the range of floats: sums exceed it if coefficients are near its end.
float toFiniteFloat(double value) {
    constexpr double kLargest = std::numeric_limits<float>::max();
    return static_cast<float>(std::clamp(value, -kLargest, kLargest));
}

double smoothStep(double start, double end, double x) {
    const double t = std::clamp((x - start) / (end - start), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

/// Returns the luminance of band 1 as a vector (x, y, z) over sqrt(3) lambda_0, clamped to the unit ball; zero for black.
glm::dvec3 linearDirection(const lighting::ShRgb& incident, const glm::dvec3& weights) {
    const auto luminance = [&](int i) { return glm::dot(glm::dvec3(incident[static_cast<std::size_t>(i)]), weights); };
    const double dc = luminance(0);
    if (!(dc > 0)) return glm::dvec3(0);
    const glm::dvec3 vector = glm::dvec3(luminance(3), luminance(1), luminance(2)) / (std::numbers::sqrt3 * dc);
    const double length = std::hypot(vector.x, vector.y, vector.z);
    if (!std::isfinite(length)) return glm::dvec3(0);  // a denormal DC with huge linear terms
    return length > 1 ? vector / length : vector;
}

/// The linear direction turned to that of the best light, or unchanged if the closed form is provably as good.
struct Turned {
    glm::dvec3 direction;
    bool isSearched = false;
};
Turned turnedToBestLight(const lighting::ShRgb& incident, const glm::dvec3& linear, const DominantLightOptions& options) {
    const double length = glm::length(linear);
    if (!(length > 0)) return {linear};
    const bool hasAmbient = options.fit == DominantFit::RefinedAmbient;
    const glm::dvec3 closed = linear / length;
    const double left = lightTowards(incident, closed, hasAmbient).unexplained, least = leastUnexplained(incident, hasAmbient);
    if (std::sqrt(left) - std::sqrt(least) <= static_cast<double>(options.tolerance)) return {linear};
    return {length * bestLight(incident, closed, hasAmbient).direction, true};
}

/// Returns the least-squares intensity for a unit direction, times `fade`.
glm::dvec3 intensityFrom(const lighting::ShRgb& incident, const glm::dvec3& direction, double fade, DominantFit fit) {
    if (fit == DominantFit::RefinedAmbient) return fade * lightTowards(incident, direction, true).intensity;
    const lighting::ShDouble basis = lighting::evaluateBasis(direction);
    glm::dvec3 sum(0);
    for (std::size_t i = 0; i < basis.size(); ++i) sum += basis[i] * glm::dvec3(incident[i]);
    return glm::max(fade * 4 * std::numbers::pi / lighting::kShCount * sum, glm::dvec3(0));
}

}  // namespace

DominantLight dominantLight(const lighting::ShRgb& incident, const glm::vec3& normal, const DominantLightOptions& options) {
    assert(0 <= options.fadeStart && options.fadeStart < options.fadeEnd && options.fadeEnd <= 1);
    const glm::dvec3 linear = linearDirection(incident, glm::dvec3(options.luminanceWeights));
    const double directionality = std::min(1.0, glm::length(linear));
    const double normalLength = glm::length(glm::dvec3(normal));
    const glm::dvec3 unitNormal = normalLength > 0 ? glm::dvec3(normal) / normalLength : glm::dvec3(0, 0, 1);

    double fade = smoothStep(options.fadeStart, options.fadeEnd, directionality);
    const double floorLength = options.fadeEnd;
    Turned turned{linear};
    if (options.fit != DominantFit::Closed && fade > 0) turned = turnedToBestLight(incident, linear, options);
    glm::dvec3 stored = fade * turned.direction + (1 - fade) * floorLength * unitNormal;
    // Light from exactly behind the surface (leaks, negative lobes) can cancel the two terms: store the normal.
    double storedLength = glm::length(stored);
    if (storedLength < 1e-3 * floorLength) {
        stored = floorLength * unitNormal;
        storedLength = floorLength;
    }

    DominantLight light;
    light.direction = glm::vec3(stored);
    light.directionality = static_cast<float>(directionality);
    light.isSearched = turned.isSearched;
    if (fade == 0) return light;
    if (options.fit == DominantFit::Explained)
        fade *=
            1 - smoothStep(options.dimStart, options.dimEnd, std::sqrt(lightTowards(incident, stored / storedLength, false).unexplained));
    const glm::dvec3 intensity = intensityFrom(incident, stored / storedLength, fade, options.fit);
    for (int channel = 0; channel < 3; ++channel) light.intensity[channel] = toFiniteFloat(intensity[channel]);
    return light;
}

DominantCounts fitDominantLights(const DominantLightRows& rows, const DominantLightOptions& options) {
    DominantCounts counts;
    for (int y = 0; y < rows.sh.height; ++y) {
        for (int x = 0; x < rows.sh.width; ++x) {
            const bool isCovered = rows.covered.at(x, y) != 0;
            const DominantLight light = isCovered ? dominantLight(rows.sh.at(x, y), rows.normal.at(x, y), options) : DominantLight{};
            rows.direction.at(x, y) = light.direction;
            rows.intensity.at(x, y) = light.intensity;
            if (isCovered) ++(light.isSearched ? counts.refined : counts.skipped);
        }
    }
    return counts;
}

float largestIntensity(const lighting::ShRgb& incident) {
    double largest = 0;
    for (int channel = 0; channel < 3; ++channel) {
        double squared[3] = {};
        for (std::size_t i = 0; i < incident.size(); ++i)
            squared[lighting::kShBand[i]] += static_cast<double>(incident[i][channel]) * static_cast<double>(incident[i][channel]);
        // Factor 4pi / 9 over all bands, or with ambient light pi / 2 over bands 1 and 2, times the norms sqrt((2l + 1) / 4pi) of Y_l.
        const double above = std::sqrt(3 * squared[1]) + std::sqrt(5 * squared[2]);
        const double whole = (std::sqrt(squared[0]) + above) * 2 / 9, withoutDc = above / 4;
        largest = std::max(largest, std::sqrt(std::numbers::pi) * std::max(whole, withoutDc));
    }
    return toFiniteFloat(largest);
}

}  // namespace lightcook::fit

#include "verify/irradiance.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <vector>

#include "lighting/cube.h"
#include "lighting/sphere.h"

namespace verify {
namespace {

constexpr int kTexels = 96;
constexpr double kDarkest = 0.02;  ///< of the mean radiance: below it errors count as if it were the reference

struct Place {
    glm::dvec3 normal;
    glm::dvec3 cooked, reference{0};
    double weight = 0;
};

/// Adds one source texel to every reference.
void addLight(std::vector<Place>& places, double wrap, const glm::dvec3& direction, double solidAngle, const glm::dvec3& radiance) {
    for (Place& place : places) {
        const double weight = std::max(0.0, glm::dot(place.normal, direction) + wrap) * solidAngle;
        place.weight += weight;
        place.reference += weight * radiance;
    }
}

}  // namespace

IrradianceFigures compareIrradiance(std::span<const formats::Image<glm::vec4>> faces, float range, double wrap,
                                    const formats::Environment& environment) {
    assert(faces.size() == 6);
    const int size = faces[0].width(), count = 6 * size * size;
    std::vector<Place> places;
    for (int i = 0; i < std::min(kTexels, count); ++i) {
        const int texel = static_cast<int>(static_cast<long long>(i) * count / std::min(kTexels, count));
        const int face = texel / (size * size), y = texel / size % size, x = texel % size;
        const glm::vec4& stored = faces[static_cast<std::size_t>(face)].at(x, y);
        places.push_back({lighting::cubeTexelDirection(face, x, y, size), static_cast<double>(range) * glm::dvec3(stored)});
    }
    const formats::Image<glm::vec3>& texels = environment.texels;
    const int width = texels.width(), height = texels.height();
    const bool isPanorama = environment.projection == formats::Environment::Projection::Equirectangular;
    glm::dvec3 all(0);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double solidAngle = isPanorama ? lighting::equirectangularTexelSolidAngle(y, width, height)
                                                 : lighting::cubeTexelSolidAngle(x, y % width, width);
            const glm::dvec3 radiance(texels.at(x, y));
            all += solidAngle * radiance;
            addLight(places, wrap,
                     isPanorama ? lighting::directionFromEquirectangular({(x + 0.5) / width, (y + 0.5) / height})
                                : lighting::cubeTexelDirection(y / width, x, y % width, width),
                     solidAngle, radiance);
        }
    const double floor = kDarkest * (all.x + all.y + all.z) / 3 / (4 * std::numbers::pi);
    IrradianceFigures figures;
    figures.texelCount = static_cast<int>(places.size());
    double squares = 0, references = 0;
    for (const Place& place : places)
        for (int channel = 0; channel < 3; ++channel) {
            const double reference = place.reference[channel] / place.weight;
            const double error = std::abs(place.cooked[channel] - reference);
            squares += error * error;
            references += reference * reference;
            if (error > 0) figures.worst = std::max(figures.worst, error / (reference + floor));
        }
    figures.relRms = squares > 0 ? std::sqrt(squares / references) : 0;
    return figures;
}

}  // namespace verify

// Slow references for the fits. They share no code with fit/: even the kernels are written out again.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <numbers>
#include <vector>

#include "fit/environment_sh.h"
#include "formats/environment.h"
#include "lighting/cube.h"
#include "lighting/sphere.h"

namespace lightcook::truth {

inline constexpr double kPi = std::numbers::pi;
inline constexpr long double kLongPi = std::numbers::pi_v<long double>;

/// A source texel, or a piece of one: direction, solid angle and radiance.
struct Sample {
    glm::dvec3 direction;
    double solidAngle;
    glm::dvec3 radiance;
};

/// Returns every texel as pieces x pieces midpoints with exact solid angles.
inline std::vector<Sample> samplesOf(const formats::Environment& environment, int pieces) {
    const formats::Image<glm::vec3>& texels = environment.texels;
    const int width = texels.width() * pieces, height = texels.height() * pieces;
    std::vector<Sample> samples;
    samples.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const glm::dvec3 radiance(texels.at(x / pieces, y / pieces));
            if (environment.projection == formats::Environment::Projection::Equirectangular) {
                samples.push_back({lighting::directionFromEquirectangular({(x + 0.5) / width, (y + 0.5) / height}),
                                   lighting::equirectangularTexelSolidAngle(y, width, height), radiance});
            } else {
                samples.push_back({lighting::cubeTexelDirection(y / width, x, y % width, width),
                                   lighting::cubeTexelSolidAngle(x, y % width, width), radiance});
            }
        }
    }
    return samples;
}

/// Returns D(h) n.l for n = v = r, or the Phong lobe, up to a constant factor.
inline double kernel(fit::PrefilterKernel which, double m, double RoL) {
    if (RoL <= 0) return 0;
    const double NoH2 = (1 + RoL) / 2, tan2 = (1 - RoL) / (1 + RoL);
    if (which == fit::PrefilterKernel::Beckmann) return std::exp(-tan2 / (m * m)) / (NoH2 * NoH2) * RoL;
    if (which == fit::PrefilterKernel::Ggx) {
        const double d = NoH2 * (m * m - 1) + 1;
        return RoL / (d * d);
    }
    return std::pow(RoL, (1 / (m * m) + 1) / 2);
}

inline glm::dvec3 prefilter(const std::vector<Sample>& samples, fit::PrefilterKernel which, double m, const glm::dvec3& r) {
    glm::dvec3 sum(0);
    double weight = 0;
    // Far from the lobe Beckmann's and Phong's weights are below 1e-12 of the peak.
    const double closest = which == fit::PrefilterKernel::Ggx ? 0 : std::max(0.0, 1 - 60 * m * m);
    for (const Sample& sample : samples) {
        const double RoL = glm::dot(r, sample.direction);
        if (RoL <= closest) continue;
        const double w = kernel(which, m, RoL) * sample.solidAngle;
        weight += w;
        sum += w * sample.radiance;
    }
    return sum / weight;
}

inline glm::dvec3 meanRadiance(const std::vector<Sample>& samples) {
    glm::dvec3 sum(0);
    double solidAngle = 0;
    for (const Sample& sample : samples) {
        sum += sample.solidAngle * sample.radiance;
        solidAngle += sample.solidAngle;
    }
    return sum / solidAngle;
}

/// Returns the mean radiance of a level, by exact solid angles of its texels.
inline glm::dvec3 meanOfStrip(const formats::Image<glm::vec3>& strip) {
    glm::dvec3 sum(0);
    const int size = strip.width();
    for (int y = 0; y < strip.height(); ++y) {
        for (int x = 0; x < size; ++x) sum += lighting::cubeTexelSolidAngle(x, y % size, size) * glm::dvec3(strip.at(x, y));
    }
    return sum / (4 * kPi);
}

/// Xorshift: the same numbers on every platform.
class Random {
public:
    explicit Random(std::uint64_t seed) : state_(seed * 0x9e3779b97f4a7c15ULL + 1) {}
    std::uint64_t next() {
        state_ ^= state_ << 13;
        state_ ^= state_ >> 7;
        state_ ^= state_ << 17;
        return state_;
    }
    double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }
    int below(int count) { return static_cast<int>(next() % static_cast<std::uint64_t>(count)); }
    glm::dvec3 direction() {
        const double z = 2 * uniform() - 1, phi = 2 * kPi * uniform(), s = std::sqrt(1 - z * z);
        return {s * std::cos(phi), s * std::sin(phi), z};
    }

private:
    std::uint64_t state_;
};

inline formats::Environment constantEquirectangular(int width, int height, const glm::vec3& value) {
    return {formats::Environment::Projection::Equirectangular, formats::Image<glm::vec3>(width, height, value)};
}
inline formats::Environment constantStrip(int size, const glm::vec3& value) {
    return {formats::Environment::Projection::CubeStrip, formats::Image<glm::vec3>(size, 6 * size, value)};
}

}  // namespace lightcook::truth

#include "fit/light_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <numbers>
#include <numeric>

#include "lighting/sphere.h"

namespace lightcook::fit {
namespace {

using std::numbers::pi;

/// 1 / sum_i Y_i^2 over all nine coefficients, and over the eight without coefficient 0.
constexpr double kPerDelta = 4 * pi / 9, kPerDeltaAboveDc = pi / 2;
constexpr double kAmbientDc = 2 / std::numbers::inv_sqrtpi;  // coefficient 0 of constant radiance 1

/// The coefficients divided by the largest magnitude, so that squares neither overflow nor underflow.
struct Texel {
    std::array<glm::dvec3, lighting::kShCount> coefficients;
    double scale = 0, energy = 0;  ///< energy: sum of squares of the scaled coefficients, in [1, 27]
    bool hasAmbient = false;

    bool isBlack() const { return scale == 0; }
};

Texel texelOf(const lighting::ShRgb& incident, bool hasAmbient) {
    Texel texel;
    texel.hasAmbient = hasAmbient;
    float largest = 0;
    for (const glm::vec3& c : incident) largest = std::max({largest, std::abs(c.x), std::abs(c.y), std::abs(c.z)});
    texel.scale = largest;
    if (texel.isBlack()) return texel;
    for (std::size_t i = 0; i < incident.size(); ++i) {
        texel.coefficients[i] = glm::dvec3(incident[i]) / texel.scale;
        texel.energy += glm::dot(texel.coefficients[i], texel.coefficients[i]);
    }
    return texel;
}

/// The best c and a of one channel for a direction with projection f = sum_i lambda_i Y_i(d).
struct ChannelFit {
    double intensity, ambient;
    double gain;       ///< decrease of E
    double curvature;  ///< k of gain = k f^2 + constant; 0 if the intensity is clamped to 0
};

ChannelFit fitChannel(double projection, double dc, bool hasAmbient) {
    if (hasAmbient) {
        const double above = projection - lighting::kShConstant * dc;
        const double intensity = kPerDeltaAboveDc * std::max(0.0, above), ambient = (dc - lighting::kShConstant * intensity) / kAmbientDc;
        if (ambient >= 0) return {intensity, ambient, dc * dc + intensity * above, above > 0 ? kPerDeltaAboveDc : 0.0};
    }
    const double intensity = kPerDelta * std::max(0.0, projection);
    return {intensity, 0, intensity * projection, projection > 0 ? kPerDelta : 0.0};
}

glm::dvec3 projectionOf(const Texel& texel, const glm::dvec3& direction) {
    const lighting::ShDouble basis = lighting::evaluateBasis(direction);
    glm::dvec3 sum(0);
    for (std::size_t i = 0; i < basis.size(); ++i) sum += basis[i] * texel.coefficients[i];
    return sum;
}

double gainOf(const Texel& texel, const glm::dvec3& direction) {
    const glm::dvec3 projection = projectionOf(texel, direction);
    double gain = 0;
    for (int k = 0; k < 3; ++k) gain += fitChannel(projection[k], texel.coefficients[0][k], texel.hasAmbient).gain;
    return gain;
}

/// Returns the light for a direction, in the units of the input.
LightFit lightOf(const Texel& texel, const glm::dvec3& direction) {
    LightFit light;
    light.direction = direction;
    if (texel.isBlack()) return light;
    const glm::dvec3 projection = projectionOf(texel, direction);
    double gain = 0;
    for (int k = 0; k < 3; ++k) {
        const ChannelFit channel = fitChannel(projection[k], texel.coefficients[0][k], texel.hasAmbient);
        light.intensity[k] = texel.scale * channel.intensity;
        light.ambient[k] = texel.scale * channel.ambient;
        gain += channel.gain;
    }
    light.unexplained = std::clamp(1 - gain / texel.energy, 0.0, 1.0);
    return light;
}

/// Directions in antipodal pairs with the rows of their basis, for vector lanes. No direction is farther than 11 degrees from one of them.
struct Grid {
    static constexpr std::size_t kPairs = 128, kCount = 2 * kPairs, kNeighbours = 8;
    using Row = std::array<float, kPairs>;
    std::array<glm::dvec3, kCount> directions;                             ///< the upper half, then their opposites
    std::array<Row, lighting::kShCount> basis;                             ///< of the upper half
    std::array<std::array<std::uint8_t, kNeighbours>, kCount> neighbours;  ///< the nearest

    Grid() {
        for (std::size_t j = 0; j < kPairs; ++j) {
            directions[j] = lighting::fibonacciHemisphere(static_cast<int>(j), static_cast<int>(kPairs));
            directions[j + kPairs] = -directions[j];
            const lighting::ShDouble values = lighting::evaluateBasis(directions[j]);
            for (std::size_t i = 0; i < values.size(); ++i) basis[i][j] = static_cast<float>(values[i]);
        }
        for (std::size_t j = 0; j < kCount; ++j) findNeighbours(j);
    }

private:
    void findNeighbours(std::size_t centre) {
        std::array<std::uint8_t, kCount> order;
        std::iota(order.begin(), order.end(), std::uint8_t{0});
        const auto cosine = [&](std::size_t j) { return glm::dot(directions[centre], directions[j]); };
        std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return cosine(a) > cosine(b); });
        std::copy_n(order.begin() + 1, kNeighbours, neighbours[centre].begin());
    }
};
using GridGains = std::array<float, Grid::kCount>;

const Grid& grid() {
    static const Grid kGrid;
    return kGrid;
}

/// Returns the gain of fitChannel minus that of ambient light alone, in float: it only ranks starts.
inline float roughGain(float projection, float dc, bool hasAmbient) {
    const float light = projection > 0 ? projection : 0, alone = static_cast<float>(kPerDelta) * light * light;
    if (!hasAmbient) return alone;
    constexpr float kDc = static_cast<float>(lighting::kShConstant);
    const float above = projection - kDc * dc, lifted = above > 0 ? above : 0, intensity = static_cast<float>(kPerDeltaAboveDc) * lifted;
    const float positive = dc > 0 ? dc : 0;
    return dc >= kDc * intensity ? intensity * lifted : alone - positive * positive;
}

template <bool hasAmbient>
void addRoughGains(const std::array<float, lighting::kShCount>& channel, GridGains& gains) {
    const Grid& g = grid();
    for (std::size_t j = 0; j < Grid::kPairs; ++j) {
        const float even = channel[0] * g.basis[0][j] + channel[4] * g.basis[4][j] + channel[5] * g.basis[5][j] +
                           channel[6] * g.basis[6][j] + channel[7] * g.basis[7][j] + channel[8] * g.basis[8][j];
        const float odd = channel[1] * g.basis[1][j] + channel[2] * g.basis[2][j] + channel[3] * g.basis[3][j];
        gains[j] += roughGain(even + odd, channel[0], hasAmbient);
        gains[j + Grid::kPairs] += roughGain(even - odd, channel[0], hasAmbient);
    }
}

GridGains roughGains(const Texel& texel) {
    GridGains gains{};
    for (int k = 0; k < 3; ++k) {
        std::array<float, lighting::kShCount> channel;
        for (std::size_t i = 0; i < channel.size(); ++i) channel[i] = static_cast<float>(texel.coefficients[i][k]);
        if (texel.hasAmbient)
            addRoughGains<true>(channel, gains);
        else
            addRoughGains<false>(channel, gains);
    }
    return gains;
}

/// The projection of a channel as a polynomial on the sphere: constant + linear . d + d' quadratic d.
struct Polynomial {
    double constant;
    glm::dvec3 linear;
    glm::dmat3 quadratic;
};

Polynomial polynomialOf(const Texel& texel, int channel) {
    const auto at = [&](std::size_t i) { return texel.coefficients[i][channel]; };
    const double xy = 0.5 * lighting::kShProduct * at(4), yz = 0.5 * lighting::kShProduct * at(5), xz = 0.5 * lighting::kShProduct * at(7);
    const double zonal = lighting::kShZonal * at(6), difference = lighting::kShDifference * at(8);
    return {lighting::kShConstant * at(0),
            lighting::kShLinear * glm::dvec3(at(3), at(1), at(2)),
            {{difference - zonal, xy, xz}, {xy, -difference - zonal, yz}, {xz, yz, 2 * zonal}}};
}

/// The gain near a direction, in two coordinates of its tangent plane.
struct Slope {
    double gain = 0;
    double first[2] = {};   ///< derivatives
    double second[3] = {};  ///< 00, 01, 11
    glm::dvec3 axes[2] = {};
};

class Ascent {
public:
    explicit Ascent(const Texel& texel) : texel_(texel) {
        for (int k = 0; k < 3; ++k) channels_[static_cast<std::size_t>(k)] = polynomialOf(texel, k);
    }

    /// A local maximum of the gain, to about 1e-12 of the energy.
    struct Peak {
        glm::dvec3 direction;
        double gain;
    };
    Peak climb(const glm::dvec3& start) const {
        constexpr int kMostSteps = 24;
        Peak peak{start, 0};
        for (int step = 0; step < kMostSteps; ++step) {
            const Slope slope = slopeAt(peak.direction);
            peak.gain = slope.gain;
            double move[2];
            const double promised = newtonMove(slope, move);
            // Newton converges quadratically: stop once the predicted gain is below 1e-10.
            const bool isLast = promised <= 1e-10 * texel_.energy;
            if (!follow(slope, move, isLast ? 1 : 8, peak) || isLast) break;
        }
        return peak;
    }

private:
    Slope slopeAt(const glm::dvec3& d) const {
        Slope slope;
        const glm::dmat3 frame = lighting::worldFromTangentFrame(d);
        slope.axes[0] = frame[0], slope.axes[1] = frame[1];
        double radial = 0;
        for (int k = 0; k < 3; ++k) {
            const Polynomial& channel = channels_[static_cast<std::size_t>(k)];
            const glm::dvec3 qd = channel.quadratic * d, q0 = channel.quadratic * slope.axes[0], q1 = channel.quadratic * slope.axes[1];
            const glm::dvec3 gradient = channel.linear + 2.0 * qd;
            const double projection = channel.constant + glm::dot(channel.linear, d) + glm::dot(qd, d);
            const ChannelFit fit = fitChannel(projection, texel_.coefficients[0][k], texel_.hasAmbient);
            const double g0 = glm::dot(gradient, slope.axes[0]), g1 = glm::dot(gradient, slope.axes[1]);
            slope.gain += fit.gain;
            slope.first[0] += 2 * fit.intensity * g0;
            slope.first[1] += 2 * fit.intensity * g1;
            slope.second[0] += 2 * fit.curvature * g0 * g0 + 4 * fit.intensity * glm::dot(slope.axes[0], q0);
            slope.second[1] += 2 * fit.curvature * g0 * g1 + 4 * fit.intensity * glm::dot(slope.axes[0], q1);
            slope.second[2] += 2 * fit.curvature * g1 * g1 + 4 * fit.intensity * glm::dot(slope.axes[1], q1);
            radial += 2 * fit.intensity * glm::dot(gradient, d);
        }
        slope.second[0] -= radial;  // curvature of the sphere
        slope.second[2] -= radial;
        return slope;
    }

    /// Computes Newton's move if the Hessian is negative definite; otherwise shifts its eigenvalues first, so that the move goes uphill.
    /// Returns the gain predicted by the quadratic model.
    static double newtonMove(const Slope& slope, double move[2]) {
        constexpr double kLongest = 0.5;  // [rad] half the distance between two maxima
        const double mean = 0.5 * (slope.second[0] + slope.second[2]), half = 0.5 * (slope.second[0] - slope.second[2]);
        const double radius = std::sqrt(half * half + slope.second[1] * slope.second[1]), largest = mean + radius;
        const double steepest = std::sqrt(slope.first[0] * slope.first[0] + slope.first[1] * slope.first[1]);
        const double least = std::max(1e-3 * (std::abs(mean) + radius), 1e-12);
        const double shift = largest > -least ? largest + std::max(least, radius) + steepest : 0;
        const double a = shift - slope.second[0], b = -slope.second[1], c = shift - slope.second[2];  // positive definite
        const double determinant = a * c - b * b;
        move[0] = (c * slope.first[0] - b * slope.first[1]) / determinant;
        move[1] = (a * slope.first[1] - b * slope.first[0]) / determinant;
        const double promised = 0.5 * (move[0] * slope.first[0] + move[1] * slope.first[1]);
        const double length = std::sqrt(move[0] * move[0] + move[1] * move[1]);
        if (length > kLongest) move[0] *= kLongest / length, move[1] *= kLongest / length;
        return promised;
    }

    /// Moves the peak by the longest tried share of the move that increases the gain. Returns false if none does.
    bool follow(const Slope& slope, const double move[2], int mostAttempts, Peak& peak) const {
        double share = 1;
        for (int attempt = 0; attempt < mostAttempts; ++attempt, share *= 0.3) {
            const glm::dvec3 next = glm::normalize(peak.direction + share * (move[0] * slope.axes[0] + move[1] * slope.axes[1]));
            const double gain = gainAt(next);
            if (gain <= slope.gain) continue;
            peak = {next, gain};
            return true;
        }
        return false;
    }

    double gainAt(const glm::dvec3& d) const {
        double gain = 0;
        for (int k = 0; k < 3; ++k) {
            const Polynomial& channel = channels_[static_cast<std::size_t>(k)];
            const double projection = channel.constant + glm::dot(channel.linear, d) + glm::dot(channel.quadratic * d, d);
            gain += fitChannel(projection, texel_.coefficients[0][k], texel_.hasAmbient).gain;
        }
        return gain;
    }

    const Texel& texel_;
    std::array<Polynomial, 3> channels_;
};

/// Returns the best of the local maxima reached from the local maxima of the grid.
glm::dvec3 bestDirection(const Texel& texel, const glm::dvec3& hint) {
    constexpr float kHighEnough = 0.75f;  // a maximum falls by less than 25 % to the nearest grid direction
    const Ascent ascent(texel);
    const GridGains gains = roughGains(texel);
    const float highest = *std::max_element(gains.begin(), gains.end());
    Ascent::Peak best{hint, gainOf(texel, hint)};
    for (std::size_t j = 0; j < gains.size(); ++j) {
        if (gains[j] <= 0 || gains[j] < kHighEnough * highest) continue;
        const auto& neighbours = grid().neighbours[j];
        if (std::any_of(neighbours.begin(), neighbours.end(), [&](std::size_t other) { return gains[other] > gains[j]; })) continue;
        const Ascent::Peak peak = ascent.climb(grid().directions[j]);
        if (peak.gain > best.gain) best = peak;
    }
    return best.direction;
}

/// Returns the texel minus a light, without its ambient part. The scale stays, so that intensities of both have the same unit.
Texel without(const Texel& texel, const LightFit& light) {
    Texel rest = texel;
    const lighting::ShDouble basis = lighting::evaluateBasis(light.direction);
    for (std::size_t i = 0; i < basis.size(); ++i) rest.coefficients[i] -= basis[i] / texel.scale * light.intensity;
    rest.energy = 0;
    for (const glm::dvec3& c : rest.coefficients) rest.energy += glm::dot(c, c);
    return rest;
}

}  // namespace

LightFit lightTowards(const lighting::ShRgb& incident, const glm::dvec3& direction, bool hasAmbient) {
    return lightOf(texelOf(incident, hasAmbient), direction);
}

LightFit bestLight(const lighting::ShRgb& incident, const glm::dvec3& hint, bool hasAmbient) {
    const Texel texel = texelOf(incident, hasAmbient);
    return lightOf(texel, texel.isBlack() ? hint : bestDirection(texel, hint));
}

double leastUnexplained(const lighting::ShRgb& incident, bool hasAmbient) {
    const Texel texel = texelOf(incident, hasAmbient);
    if (texel.isBlack()) return 0;
    double squared[3] = {};
    for (std::size_t i = 0; i < texel.coefficients.size(); ++i)
        squared[lighting::kShBand[i]] += glm::dot(texel.coefficients[i], texel.coefficients[i]);
    const double above = std::sqrt(3 / (4 * pi) * squared[1]) + std::sqrt(5 / (4 * pi) * squared[2]);
    if (hasAmbient) return std::max(0.0, squared[1] + squared[2] - kPerDeltaAboveDc * above * above) / texel.energy;
    const double whole = std::sqrt(1 / (4 * pi) * squared[0]) + above;
    return std::max(0.0, texel.energy - kPerDelta * whole * whole) / texel.energy;
}

TwoLights bestTwoLights(const lighting::ShRgb& incident, const glm::dvec3& hint, bool hasAmbient) {
    constexpr int kMostRounds = 60;
    const Texel texel = texelOf(incident, hasAmbient);
    TwoLights lights;
    lights.first.direction = lights.second.direction = hint;
    if (texel.isBlack()) return lights;
    lights.first = lightOf(texel, bestDirection(texel, hint));
    lights.unexplained = lights.first.unexplained;
    for (int round = 0; round < kMostRounds; ++round) {
        // After the first round each light only follows its local maximum.
        const Texel forSecond = without(texel, lights.first);
        if (!(forSecond.energy > 1e-15 * texel.energy)) break;
        lights.second =
            lightOf(forSecond, round == 0 ? bestDirection(forSecond, hint) : Ascent(forSecond).climb(lights.second.direction).direction);
        const Texel forFirst = without(texel, lights.second);
        if (!(forFirst.energy > 1e-15 * texel.energy)) break;
        lights.first = lightOf(forFirst, Ascent(forFirst).climb(lights.first.direction).direction);
        const double unexplained = std::min(1.0, lights.first.unexplained * forFirst.energy / texel.energy);
        const double gained = lights.unexplained - unexplained;
        lights.unexplained = std::min(lights.unexplained, unexplained);
        if (round > 0 && gained < 1e-9) break;
    }
    const auto sum = [](const glm::dvec3& c) { return c.x + c.y + c.z; };
    if (sum(lights.second.intensity) > sum(lights.first.intensity)) {
        lights.second.ambient = lights.first.ambient;
        std::swap(lights.first, lights.second);
    }
    lights.first.unexplained = lights.second.unexplained = lights.unexplained;
    return lights;
}

}  // namespace lightcook::fit

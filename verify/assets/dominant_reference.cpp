#include "verify/dominant.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>

#include "lighting/sphere.h"

namespace lightcook::verify {
namespace {

using std::numbers::pi;

/// Range of |v| over which the light fades in: below it, the direction is noise.
constexpr double kFadeStart = 0.02, kFadeEnd = 0.08;
/// Coefficient 0 of constant radiance 1.
constexpr double kAmbientDc = 2 / std::numbers::inv_sqrtpi;

/// Returns v of the closed form: band 1 / (sqrt(3) lambda_0), at most of length 1.
glm::dvec3 linearVector(const lighting::ShRgb& incident, const glm::vec3& weights) {
    const auto luminance = [&](std::size_t i) { return glm::dot(glm::dvec3(incident[i]), glm::dvec3(weights)); };
    const double dc = luminance(0);
    if (!(dc > 0)) return glm::dvec3(0);
    const glm::dvec3 vector = glm::dvec3(luminance(3), luminance(1), luminance(2)) / (std::numbers::sqrt3 * dc);
    const double length = glm::length(vector);
    if (!std::isfinite(length)) return glm::dvec3(0);
    return length > 1 ? vector / length : vector;
}

double smoothStep(double start, double end, double at) {
    const double x = std::clamp((at - start) / (end - start), 0.0, 1.0);
    return x * x * (3 - 2 * x);
}

double fadeOf(const glm::dvec3& vector) {
    return smoothStep(kFadeStart, kFadeEnd, glm::length(vector));
}

glm::dvec3 storedDirection(const glm::dvec3& vector, double fade, const glm::dvec3& normal) {
    const glm::dvec3 direction = fade * vector + (1 - fade) * kFadeEnd * normal;
    return glm::length(direction) < 1e-3 * kFadeEnd ? kFadeEnd * normal : direction;  // both parts cancel
}

/// Least squares of one channel for a fixed direction, with intensity and ambient light >= 0: the best of all choices of which unknowns are
/// zero. No branches, so that loops over it are vectorized.
template <class T>
struct ChannelFit {
    T intensity = 0, gain = 0;
};
template <class T>
inline ChannelFit<T> fitChannel(T projection, T dc, bool hasAmbient) {
    constexpr T kPerNorm = static_cast<T>(4 * pi / lighting::kShCount), kNorm = static_cast<T>(lighting::kShCount / (4 * pi));
    const T positive = projection > 0 ? projection : 0, alone = positive * positive * kPerNorm;
    if (!hasAmbient) return {positive * kPerNorm, alone};
    constexpr T kDc = static_cast<T>(kAmbientDc), kCross = static_cast<T>(lighting::kShConstant) * kDc, kOwn = kDc * kDc;
    constexpr T kPerDeterminant = 1 / (kNorm * kOwn - kCross * kCross);
    const T intensity = (kOwn * projection - kCross * kDc * dc) * kPerDeterminant;
    const T ambient = (kNorm * kDc * dc - kCross * projection) * kPerDeterminant;
    const T light = dc > 0 ? dc * dc : 0;  // ambient light alone
    const T smaller = intensity < ambient ? intensity : ambient, both = smaller >= 0 ? intensity * projection + ambient * kDc * dc : 0;
    const T one = alone > light ? alone : light;
    const T intensityOfOne = alone > light ? positive * kPerNorm : 0;
    return {both >= one ? intensity : intensityOfOne, both >= one ? both : one};
}

/// The coefficients, scaled by the largest, and the part of their squared norm (gain) that a light from a direction explains.
class Light {
public:
    Light(const lighting::ShRgb& incident, bool hasAmbient) : hasAmbient_(hasAmbient) {
        for (const glm::vec3& c : incident)
            scale_ = std::max(
                {scale_, std::abs(static_cast<double>(c.x)), std::abs(static_cast<double>(c.y)), std::abs(static_cast<double>(c.z))});
        if (scale_ == 0) return;
        for (std::size_t i = 0; i < incident.size(); ++i) {
            coefficients_[i] = glm::dvec3(incident[i]) / scale_;
            energy_ += glm::dot(coefficients_[i], coefficients_[i]);
        }
    }
    bool isBlack() const { return scale_ == 0; }
    double gain(const glm::dvec3& direction) const {
        const glm::dvec3 projection = projectionOn(direction);
        double sum = 0;
        for (int channel = 0; channel < 3; ++channel) sum += fitChannel(projection[channel], coefficients_[0][channel], hasAmbient_).gain;
        return sum;
    }
    glm::dvec3 intensity(const glm::dvec3& direction) const {
        const glm::dvec3 projection = projectionOn(direction);
        glm::dvec3 result;
        for (int channel = 0; channel < 3; ++channel)
            result[channel] = scale_ * fitChannel(projection[channel], coefficients_[0][channel], hasAmbient_).intensity;
        return result;
    }
    double coefficient(std::size_t i, int channel) const { return coefficients_[i][channel]; }
    bool hasAmbient() const { return hasAmbient_; }
    /// Returns the root of the squared error over the norm of the coefficients.
    double residual(double gain) const { return std::sqrt(std::max(0.0, 1 - gain / energy_)); }

private:
    glm::dvec3 projectionOn(const glm::dvec3& direction) const {
        const lighting::ShDouble basis = lighting::evaluateBasis(direction);
        glm::dvec3 sum(0);
        for (std::size_t i = 0; i < basis.size(); ++i) sum += basis[i] * coefficients_[i];
        return sum;
    }

    bool hasAmbient_;
    double scale_ = 0, energy_ = 0;
    std::array<glm::dvec3, lighting::kShCount> coefficients_{};
};

struct Peak {
    glm::dvec3 direction;
    double gain;
};

/// Moves to the maximum of a paraboloid through six directions around the peak, or uphill if it has no maximum nearby. Returns true once
/// the maximum was near, or nothing improves.
bool moveUphill(const Light& light, double width, Peak& peak) {
    constexpr double kFarthest = 3;
    const glm::dmat3 frame = lighting::worldFromTangentFrame(peak.direction);
    const auto at = [&](double x, double y) { return glm::normalize(peak.direction + width * (x * frame[0] + y * frame[1])); };
    const auto rise = [&](double x, double y) { return light.gain(at(x, y)) - peak.gain; };
    const double right = rise(1, 0), left = rise(-1, 0), up = rise(0, 1), down = rise(0, -1), corner = rise(1, 1);
    const double gx = 0.5 * (right - left), gy = 0.5 * (up - down), xx = right + left, yy = up + down;
    const double xy = corner - gx - gy - 0.5 * (xx + yy), determinant = xx * yy - xy * xy;
    const bool hasSummit = xx < 0 && determinant > 0;
    double x = gx, y = gy;
    if (hasSummit) x = -(yy * gx - xy * gy) / determinant, y = -(xx * gy - xy * gx) / determinant;
    const double length = glm::length(glm::dvec2(x, y)), scale = length > kFarthest || (!hasSummit && length > 0) ? kFarthest / length : 1;
    for (double share = 1; share > 0.1; share *= 0.4) {
        const glm::dvec3 next = at(share * scale * x, share * scale * y);
        const double gain = light.gain(next);
        if (gain <= peak.gain) continue;
        peak = {next, gain};
        return hasSummit && scale == 1;
    }
    return true;
}

/// Climbs to the local maximum with ever narrower paraboloids. Tries narrow ones first: directions stored in textures are near a maximum.
Peak polish(const Light& light, const glm::dvec3& start) {
    constexpr int kMaximumMoves = 6;
    Peak peak{start, light.gain(start)};
    if (moveUphill(light, 0.01, peak) && moveUphill(light, 0.001, peak)) return peak;
    for (const double width : {0.1, 0.03, 0.005, 0.0005})
        for (int move = 0; move < kMaximumMoves; ++move)
            if (moveUphill(light, width, peak)) break;
    return peak;
}

/// Directions over the whole sphere in opposite pairs, with the basis at the first of each pair as rows.
struct Sphere {
    static constexpr std::size_t kPairs = 120, kCount = 2 * kPairs;
    using Row = std::array<float, kPairs>;
    std::array<glm::dvec3, kCount> directions;
    std::array<Row, lighting::kShCount> basis;
    Sphere() {
        for (std::size_t j = 0; j < kPairs; ++j) {
            directions[j] = lighting::fibonacciHemisphere(static_cast<int>(j), static_cast<int>(kPairs));
            directions[j + kPairs] = -directions[j];
            const lighting::ShDouble values = lighting::evaluateBasis(directions[j]);
            for (std::size_t i = 0; i < values.size(); ++i) basis[i][j] = static_cast<float>(values[i]);
        }
    }
};

/// Returns the gain of every direction. Floats suffice to find the local maxima. All arrays are local, so that the compiler knows that they
/// do not overlap.
template <bool hasAmbient>
std::array<float, Sphere::kCount> gainsOverSphere(const Light& light, const Sphere& sphere) {
    Sphere::Row gains{}, gainsOfOpposites{};
    for (int channel = 0; channel < 3; ++channel) {
        Sphere::Row parts[2] = {};  // even bands, and band 1, which changes sign in the opposite direction
        for (std::size_t i = 0; i < sphere.basis.size(); ++i) {
            const float coefficient = static_cast<float>(light.coefficient(i, channel));
            Sphere::Row& part = parts[lighting::kShBand[i] % 2];
            for (std::size_t j = 0; j < Sphere::kPairs; ++j) part[j] += coefficient * sphere.basis[i][j];
        }
        const float dc = static_cast<float>(light.coefficient(0, channel));
        for (std::size_t j = 0; j < Sphere::kPairs; ++j) gains[j] += fitChannel(parts[0][j] + parts[1][j], dc, hasAmbient).gain;
        for (std::size_t j = 0; j < Sphere::kPairs; ++j) gainsOfOpposites[j] += fitChannel(parts[0][j] - parts[1][j], dc, hasAmbient).gain;
    }
    std::array<float, Sphere::kCount> both;
    std::copy(gains.begin(), gains.end(), both.begin());
    std::copy(gainsOfOpposites.begin(), gainsOfOpposites.end(), both.begin() + Sphere::kPairs);
    return both;
}

/// Returns the best direction of the sphere, and the best one away from it.
std::array<glm::dvec3, 2> twoStarts(const Light& light) {
    static const Sphere kSphere;
    constexpr double kOtherStart = 0.8;  // cosine
    const auto gains = light.hasAmbient() ? gainsOverSphere<true>(light, kSphere) : gainsOverSphere<false>(light, kSphere);
    const std::size_t best = static_cast<std::size_t>(std::max_element(gains.begin(), gains.end()) - gains.begin());
    std::size_t other = best;
    float highest = -1;
    for (std::size_t j = 0; j < gains.size(); ++j)
        if (gains[j] > highest && glm::dot(kSphere.directions[j], kSphere.directions[best]) < kOtherStart) other = j, highest = gains[j];
    return {kSphere.directions[best], kSphere.directions[other]};
}

/// Returns the best direction. Climbs from `seen`, and from other starts only if they may lead higher.
glm::dvec3 bestDirection(const Light& light, const glm::dvec3& seen) {
    constexpr double kEqual = 1e-3;
    constexpr double kSameMaximum = 0.95;  // cosine: closer than two steps between the sphere's directions
    constexpr double kLargestRise = 1.3;   // gain of a maximum relative to the nearest direction of the sphere, at most
    const std::array<glm::dvec3, 2> starts = twoStarts(light);
    const double length = glm::length(seen);
    const bool isSeen = length > 0;
    const Peak near = polish(light, isSeen ? seen / length : starts[0]);
    Peak best = near;
    for (const glm::dvec3& start : starts) {
        const double gain = light.gain(start);
        if (gain <= near.gain && (glm::dot(near.direction, start) > kSameMaximum || gain * kLargestRise < near.gain)) continue;
        const Peak found = polish(light, start);
        if (found.gain > best.gain) best = found;
    }
    return isSeen && light.residual(near.gain) <= light.residual(best.gain) + kEqual ? near.direction : best.direction;
}

}  // namespace

DominantLightSample dominantReference(const lighting::ShRgb& incident, const glm::dvec3& normal, const glm::vec3& luminanceWeights) {
    const glm::dvec3 vector = linearVector(incident, luminanceWeights);
    const double fade = fadeOf(vector);
    DominantLightSample result;
    result.direction = storedDirection(vector, fade, normal);
    const lighting::ShDouble basis = lighting::evaluateBasis(glm::normalize(result.direction));
    for (std::size_t i = 0; i < basis.size(); ++i) result.intensity += basis[i] * glm::dvec3(incident[i]);
    result.intensity = glm::max(fade * 4 * pi / lighting::kShCount * result.intensity, glm::dvec3(0));
    return result;
}

DominantLightSample refinedReference(const lighting::ShRgb& incident, const glm::dvec3& normal, const glm::vec3& luminanceWeights,
                                     bool hasAmbient, const glm::dvec3& seen) {
    glm::dvec3 vector = linearVector(incident, luminanceWeights);
    const double fade = fadeOf(vector);
    const Light light(incident, hasAmbient);
    DominantLightSample result;
    if (fade > 0 && !light.isBlack()) vector = glm::length(vector) * bestDirection(light, seen);
    result.direction = storedDirection(vector, fade, normal);
    if (fade > 0) result.intensity = fade * light.intensity(glm::normalize(result.direction));
    return result;
}

DominantLightSample explainedReference(const lighting::ShRgb& incident, const glm::dvec3& normal, const glm::vec3& luminanceWeights,
                                       const glm::dvec3& seen) {
    constexpr double kDimStart = 0.3, kDimEnd = 0.4;
    DominantLightSample result = refinedReference(incident, normal, luminanceWeights, false, seen);
    const Light light(incident, false);
    if (light.isBlack()) return result;
    result.intensity *= 1 - smoothStep(kDimStart, kDimEnd, light.residual(light.gain(glm::normalize(result.direction))));
    return result;
}

Unexplained unexplainedBy(const lighting::ShRgb& incident, const DominantLightSample& light, bool hasAmbient) {
    const double length = glm::length(light.direction);
    const lighting::ShDouble basis = lighting::evaluateBasis(length > 0 ? light.direction / length : glm::dvec3(0, 0, 1));
    Unexplained sum;
    for (std::size_t i = 0; i < basis.size(); ++i) {
        const glm::dvec3 truth(incident[i]);
        glm::dvec3 left = truth - basis[i] * light.intensity;
        if (i == 0 && hasAmbient) left = glm::min(left, glm::dvec3(0));
        sum.error += glm::dot(left, left);
        sum.energy += glm::dot(truth, truth);
    }
    return sum;
}

}  // namespace lightcook::verify

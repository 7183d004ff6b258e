#include "compress/light_map/lit_fit.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "lighting/brdf.h"

namespace lightcook::compress::rows {

namespace {

/// Times that ratios, directions and intensities are solved. More gains nothing (docs/lab/compress-light-maps.md).
constexpr int kTurns = 6;
/// The light takes at most this share of coefficient 0, so that the rest keeps ratios.
constexpr float kMostOfDc = 0.98f;
/// Weights of squared errors, by band. Each is about the mean of two shares: diffuse light shows (2/3)^2 and (1/4)^2 of bands 1 and 2, a
/// mirror all of them.
constexpr std::array<float, 3> kBandWeights = {1, 0.7f, 0.5f};

float bandWeight(std::size_t i) {
    return kBandWeights[static_cast<std::size_t>(lighting::kShBand[i])];
}

/// Two unit vectors that are perpendicular to a third and to each other.
std::array<glm::vec3, 2> tangentsOf(const glm::vec3& direction) {
    const glm::vec3 beside = std::abs(direction.z) < 0.9f ? glm::vec3(0, 0, 1) : glm::vec3(1, 0, 0);
    const glm::vec3 u = glm::normalize(glm::cross(direction, beside));
    return {u, glm::cross(direction, u)};
}

/// Returns the derivative of the basis functions along a tangent.
lighting::Sh slopeOf(const glm::vec3& direction, const glm::vec3& tangent) {
    constexpr float kStep = 0.01f;
    const lighting::Sh before = lighting::evaluateBasis(glm::normalize(direction - kStep * tangent)),
                       after = lighting::evaluateBasis(glm::normalize(direction + kStep * tangent));
    lighting::Sh slope;
    for (std::size_t i = 0; i < slope.size(); ++i) slope[i] = (after[i] - before[i]) / (2 * kStep);
    return slope;
}

}  // namespace

LitFit::LitFit(const Source& source, float range, int side, const std::array<float, kHigher>& largest)
    : source_(source),
      perRange_(1 / range),
      side_(side),
      largest_(largest),
      dc_(source.width, source.height, glm::vec3(0)),
      intensity_(source.width, source.height, glm::vec3(0)),
      direction_(source.width, source.height, glm::vec3(0, 0, 1)),
      basis_(source.width, source.height),
      ratios_(formats::textureSize(source.width, source.height, side).x, formats::textureSize(source.width, source.height, side).y) {
    forEachCovered([&](int x, int y) {
        dc_.at(x, y) = glm::max(coefficient(0, x, y), glm::vec3(0));
        setDirection(x, y, linearAxis(x, y));
        intensity_.at(x, y) = projectedIntensity(x, y);
    });
}

void LitFit::solve(bool isDirectionFixed) {
    for (int turn = 0; turn < kTurns; ++turn) {
        solveRatios();
        if (!isDirectionFixed) forEachCovered([&](int x, int y) { turnDirection(x, y); });
        solveIntensities();
    }
}

void LitFit::solveIntensities() {
    forEachCovered([&](int x, int y) {
        glm::vec3 product(0);
        for (std::size_t i = 0; i < kHigher; ++i)
            product += bandWeight(i + 1) * changeOf(i, x, y) * (coefficient(i + 1, x, y) - dc_.at(x, y) * ratiosAt(x, y)[i]);
        intensity_.at(x, y) = limited(product / glm::max(changeSquare(x, y), glm::vec3(1e-9f)), x, y);
    });
}

void LitFit::solveRatios() {
    for (int v = 0; v < down(); ++v)
        for (int u = 0; u < across(); ++u) solveRatiosOf(u, v);
}

/// Solves the ratios of a texel of "rest" for its covered texels.
void LitFit::solveRatiosOf(int u, int v) {
    std::array<glm::vec3, kHigher> product{};
    glm::vec3 square(0);
    for (int y = v * side_; y < std::min((v + 1) * side_, source_.height); ++y)
        for (int x = u * side_; x < std::min((u + 1) * side_, source_.width); ++x) {
            if (!(source_.coverage.at(x, y) > 0)) continue;
            const glm::vec3 rest = restAt(x, y), weighted = source_.importance.at(x, y) * rest;
            square += weighted * rest;
            for (std::size_t i = 0; i < kHigher; ++i)
                product[i] += weighted * (coefficient(i + 1, x, y) - basis_.at(x, y)[i + 1] * intensity_.at(x, y));
        }
    for (std::size_t i = 0; i < kHigher; ++i)
        for (int c = 0; c < 3; ++c)
            ratios_.at(u, v)[i][c] = square[c] > 0 ? std::clamp(product[i][c] / square[c], -largest_[i], largest_[i]) : 0;
}

void LitFit::setDirection(int x, int y, const glm::vec3& direction) {
    direction_.at(x, y) = direction;
    basis_.at(x, y) = lighting::evaluateBasis(direction);
}

glm::vec3 LitFit::restAt(int x, int y) const {
    return glm::max(dc_.at(x, y) - kShaderY0 * intensity_.at(x, y), glm::vec3(0));
}

glm::vec3 LitFit::changeSquare(int x, int y) const {
    glm::vec3 square(0);
    for (std::size_t i = 0; i < kHigher; ++i) square += bandWeight(i + 1) * changeOf(i, x, y) * changeOf(i, x, y);
    return square;
}

/// Returns the change of coefficient i + 1 under a unit of intensity.
glm::vec3 LitFit::changeOf(std::size_t i, int x, int y) const {
    return basis_.at(x, y)[i + 1] - kShaderY0 * ratiosAt(x, y)[i];
}

glm::vec3 LitFit::limited(const glm::vec3& intensity, int x, int y) const {
    return glm::clamp(intensity, glm::vec3(0), kMostOfDc / kShaderY0 * dc_.at(x, y));
}

/// Returns the axis of band 1 as luminance sees it.
glm::vec3 LitFit::linearAxis(int x, int y) const {
    const auto luminance = [&](std::size_t i) { return glm::dot(coefficient(i, x, y), lighting::kRec709Luminance); };
    const glm::vec3 axis(luminance(3), luminance(1), luminance(2));
    const float length = glm::length(axis);
    return length > 0 ? axis / length : glm::vec3(0, 0, 1);
}

/// Returns the intensity of a light whose bands 1 and 2 are nearest to the texel's.
glm::vec3 LitFit::projectedIntensity(int x, int y) const {
    const lighting::Sh& basis = basis_.at(x, y);
    glm::vec3 product(0);
    float square = 0;
    for (std::size_t i = 1; i < lighting::kShCount; ++i) {
        product += bandWeight(i) * basis[i] * coefficient(i, x, y);
        square += bandWeight(i) * basis[i] * basis[i];
    }
    return limited(product / square, x, y);
}

/// Returns the squared error of a texel with its light in another direction.
float LitFit::errorUnder(const lighting::Sh& basis, int x, int y) const {
    const glm::vec3 rest = restAt(x, y);
    float sum = 0;
    for (std::size_t i = 0; i < kHigher; ++i) {
        const glm::vec3 off = coefficient(i + 1, x, y) - rest * ratiosAt(x, y)[i] - basis[i + 1] * intensity_.at(x, y);
        sum += bandWeight(i + 1) * glm::dot(off, off);
    }
    return sum;
}

/// Turns the direction by a damped step of Gauss and Newton, if that reduces the error.
void LitFit::turnDirection(int x, int y) {
    constexpr float kFarthest = 0.3f, kDamping = 0.05f;
    const glm::vec3 intensity = intensity_.at(x, y), rest = restAt(x, y), direction = direction_.at(x, y);
    const auto [u, v] = tangentsOf(direction);
    const lighting::Sh alongU = slopeOf(direction, u), alongV = slopeOf(direction, v);
    float uu = 0, uv = 0, vv = 0, ue = 0, ve = 0;
    for (std::size_t i = 1; i < lighting::kShCount; ++i) {
        const glm::vec3 error = coefficient(i, x, y) - rest * ratiosAt(x, y)[i - 1] - basis_.at(x, y)[i] * intensity;
        const float weight = bandWeight(i), square = weight * glm::dot(intensity, intensity), off = weight * glm::dot(intensity, error);
        uu += square * alongU[i] * alongU[i];
        uv += square * alongU[i] * alongV[i];
        vv += square * alongV[i] * alongV[i];
        ue += alongU[i] * off;
        ve += alongV[i] * off;
    }
    const float damping = kDamping * (uu + vv);
    uu += damping;
    vv += damping;
    const float determinant = uu * vv - uv * uv;
    if (!(determinant > 0)) return;
    const float stepU = (vv * ue - uv * ve) / determinant, stepV = (uu * ve - uv * ue) / determinant;
    const float length = std::sqrt(stepU * stepU + stepV * stepV), share = std::min(1.0f, kFarthest / std::max(length, 1e-9f));
    const glm::vec3 turned = glm::normalize(direction + share * (stepU * u + stepV * v));
    if (errorUnder(lighting::evaluateBasis(turned), x, y) < errorUnder(basis_.at(x, y), x, y)) setDirection(x, y, turned);
}

}  // namespace lightcook::compress::rows

#include "fit/environment_sh.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <glm/vec3.hpp>
#include <limits>
#include <numbers>
#include <vector>

#include "fit/quadrature.h"
#include "lighting/cube.h"

namespace fit {
namespace {

using ShRgbDouble = std::array<glm::dvec3, lighting::kShCount>;
using std::numbers::pi;

const double kBand0 = 0.5 * std::sqrt(1 / pi), kBand1 = std::sqrt(3 / (4 * pi)), kBand2 = 0.5 * std::sqrt(15 / pi),
             kBand20 = 0.25 * std::sqrt(5 / pi);

/// Integrals over psi of a texel, psi = 2 pi (u - 0.5), so that x = sin(theta) sin(psi), z = -sin(theta) cos(psi), y = cos(theta).
struct AzimuthIntegrals {
    double one, sine, cosine, cosineSquared, sineCosine;
};
AzimuthIntegrals azimuthIntegrals(double begin, double end) {
    const double middle = 0.5 * (begin + end), half = 0.5 * (end - begin);
    const double chord = 2 * std::sin(half), doubleChord = std::sin(2 * half);
    return {end - begin, chord * std::sin(middle), chord * std::cos(middle), half + 0.5 * doubleChord * std::cos(2 * middle),
            0.5 * doubleChord * std::sin(2 * middle)};
}

/// Integrals over theta of a row, with the measure sin(theta) d(theta).
struct PolarIntegrals {
    double one, y, yy, sine, sineY, sineSquared;
};
PolarIntegrals polarIntegrals(double begin, double end) {
    const double y0 = std::cos(begin), y1 = std::cos(end), s0 = std::sin(begin), s1 = std::sin(end);
    const double one = 2 * std::sin(0.5 * (begin + end)) * std::sin(0.5 * (end - begin));
    return {one,
            0.5 * (s1 - s0) * (s1 + s0),
            one * (y0 * y0 + y0 * y1 + y1 * y1) / 3,
            0.5 * (end - begin) - 0.25 * (std::sin(2 * end) - std::sin(2 * begin)),
            (s1 - s0) * (s0 * s0 + s0 * s1 + s1 * s1) / 3,
            one - one * (y0 * y0 + y0 * y1 + y1 * y1) / 3};
}

void addRow(ShRgbDouble& sum, const PolarIntegrals& polar, const glm::dvec3& one, const glm::dvec3& sine, const glm::dvec3& cosine,
            const glm::dvec3& cosineSquared, const glm::dvec3& sineCosine) {
    sum[0] += kBand0 * polar.one * one;
    sum[1] += kBand1 * polar.y * one;
    sum[2] -= kBand1 * polar.sine * cosine;
    sum[3] += kBand1 * polar.sine * sine;
    sum[4] += kBand2 * polar.sineY * sine;
    sum[5] -= kBand2 * polar.sineY * cosine;
    sum[6] += kBand20 * (3.0 * polar.sineSquared * cosineSquared - polar.one * one);
    sum[7] -= kBand2 * polar.sineSquared * sineCosine;
    sum[8] += 0.5 * kBand2 * (polar.sineSquared * (one - cosineSquared) - polar.yy * one);
}

ShRgbDouble projectEquirectangular(formats::ImageView<const glm::vec3> texels) {
    std::vector<AzimuthIntegrals> columns;
    columns.reserve(static_cast<std::size_t>(texels.width));
    for (int x = 0; x < texels.width; ++x) {
        columns.push_back(azimuthIntegrals(2 * pi * x / texels.width - pi, 2 * pi * (x + 1) / texels.width - pi));
    }
    ShRgbDouble sum{};
    for (int y = 0; y < texels.height; ++y) {
        glm::dvec3 one(0), sine(0), cosine(0), cosineSquared(0), sineCosine(0);
        const glm::vec3* row = texels.row(y);
        for (int x = 0; x < texels.width; ++x) {
            const AzimuthIntegrals& column = columns[static_cast<std::size_t>(x)];
            const glm::dvec3 radiance(row[x]);
            one += column.one * radiance;
            sine += column.sine * radiance;
            cosine += column.cosine * radiance;
            cosineSquared += column.cosineSquared * radiance;
            sineCosine += column.sineCosine * radiance;
        }
        addRow(sum, polarIntegrals(pi * y / texels.height, pi * (y + 1) / texels.height), one, sine, cosine, cosineSquared, sineCosine);
    }
    return sum;
}

ShRgbDouble projectCubeStrip(formats::ImageView<const glm::vec3> texels) {
    static const GaussRule<3> rule = gaussLegendre<3>();
    const int size = texels.width;
    const int pieces = std::max(1, 48 / size);  // three points err by 1e-10 on a 48th of a face
    const double step = 2.0 / (static_cast<double>(size) * pieces);
    ShRgbDouble sum{};
    for (int row = 0; row < 6 * size; ++row) {
        const int face = row / size;
        for (int x = 0; x < size; ++x) {
            lighting::ShDouble weights{};
            for (int subRow = 0; subRow < 3 * pieces; ++subRow) {
                const auto j = static_cast<std::size_t>(subRow % 3);
                const double v = -1 + step * ((row % size) * pieces + subRow / 3 + rule.point[j]);
                for (int subColumn = 0; subColumn < 3 * pieces; ++subColumn) {
                    const auto i = static_cast<std::size_t>(subColumn % 3);
                    const double u = -1 + step * (x * pieces + subColumn / 3 + rule.point[i]);
                    const double squared = 1 + u * u + v * v;
                    const double solidAngle = step * step * rule.weight[i] * rule.weight[j] / (squared * std::sqrt(squared));
                    const lighting::ShDouble basis = lighting::evaluateBasis(lighting::directionFromCube({face, {u, v}}));
                    for (std::size_t k = 0; k < basis.size(); ++k) weights[k] += solidAngle * basis[k];
                }
            }
            const glm::dvec3 radiance(texels.at(x, row));
            for (std::size_t k = 0; k < weights.size(); ++k) sum[k] += weights[k] * radiance;
        }
    }
    return sum;
}

/// integral of shape P_l dw for l = 0, 1, 2. Intervals of 1 - c halve towards the peak, so that a lobe of any width meets its own scale.
std::array<double, 3> shapeMoments(PrefilterKernel kernel, double m) {
    static const GaussRule<20> rule = gaussLegendre<20>();
    std::array<double, 3> moments{};
    double end = 1;
    const double smallest = std::max(1e-4 * m * m, 1e-30);
    while (end > 0) {
        const double begin = end > smallest ? end / 2 : 0;
        for (std::size_t i = 0; i < rule.point.size(); ++i) {
            double versine = begin + (end - begin) * rule.point[i], width = end - begin;
            if (end == 1) {  // c = t^3 / 2: a fractional power of c, Phong's, is smooth enough in t
                const double t = rule.point[i];
                versine = 1 - 0.5 * t * t * t;
                width = 1.5 * t * t;
            }
            const double c = 1 - versine;
            const double value = 2 * pi * width * rule.weight[i] * prefilterKernelShapeAt(kernel, m, versine);
            moments[0] += value;
            moments[1] += value * c;
            moments[2] += value * (1.5 * c * c - 0.5);
        }
        end = begin;
    }
    return moments;
}

}  // namespace

lighting::ShRgb projectEnvironment(const formats::Environment& environment) {
    const formats::ImageView<const glm::vec3> texels = environment.texels.view();
    const bool equirectangular = environment.projection == formats::Environment::Projection::Equirectangular;
    assert(texels.width > 0 && (equirectangular ? texels.height > 0 : texels.height == 6 * texels.width));
    const ShRgbDouble sum = equirectangular ? projectEquirectangular(texels) : projectCubeStrip(texels);
    constexpr double kLargest = std::numeric_limits<float>::max();
    lighting::ShRgb coefficients;
    for (std::size_t i = 0; i < sum.size(); ++i) {
        for (int channel = 0; channel < 3; ++channel) {
            coefficients[i][channel] = static_cast<float>(std::clamp(sum[i][channel], -kLargest, kLargest));
        }
    }
    return coefficients;
}

double prefilterKernelShapeAt(PrefilterKernel kernel, double m, double versine) {
    assert(0 < m && m <= 1);
    const double c = 1 - versine;
    if (c <= 0) return 0;
    const double sinHalfSquared = 0.5 * versine, NoHSquared = 1 - sinHalfSquared;
    switch (kernel) {
        case PrefilterKernel::Beckmann:
            return std::exp(-sinHalfSquared / (NoHSquared * m * m)) / (NoHSquared * NoHSquared) * c;
        case PrefilterKernel::Ggx: {
            const double ratio = m * m / (m * m + sinHalfSquared * (1 - m * m));
            return ratio * ratio * c;
        }
        case PrefilterKernel::Phong:
            return std::exp(phongExponent(m) * std::log1p(-versine));
    }
    return 0;
}

double phongExponent(double m) {
    return 0.5 * (1 / (m * m) + 1);
}

double prefilterKernelShape(PrefilterKernel kernel, double m, double c) {
    return prefilterKernelShapeAt(kernel, m, 1 - c);
}

double prefilterKernelIntegral(PrefilterKernel kernel, double m) {
    return shapeMoments(kernel, m)[0];
}

lighting::ShBands prefilterKernelBands(PrefilterKernel kernel, double m) {
    if (m == 0) return {1, 1, 1};
    const std::array<double, 3> moments = shapeMoments(kernel, m);
    return {1, moments[1] / moments[0], moments[2] / moments[0]};
}

}  // namespace fit

#include "fit/environment_sh.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <numbers>
#include <vector>

#include "fit/cubemap/gauss_legendre.h"
#include "lighting/cube.h"

namespace lightcook::fit {
namespace {

using ShRgbDouble = std::array<glm::dvec3, lighting::kShCount>;
using lighting::kShConstant;
using lighting::kShDifference;
using lighting::kShLinear;
using lighting::kShProduct;
using lighting::kShZonal;
using std::numbers::pi;

/// Integrals over the azimuth psi of a texel, psi = 2 pi (u - 0.5), so that x = sin(theta) sin(psi), z = -sin(theta) cos(psi), y =
/// cos(theta).
struct AzimuthIntegrals {
    double one, sine, cosine, cosineSquared, sineCosine;
};
AzimuthIntegrals azimuthIntegrals(double begin, double end) {
    const double middle = 0.5 * (begin + end), half = 0.5 * (end - begin);
    const double chord = 2 * std::sin(half), doubleChord = std::sin(2 * half);
    return {end - begin, chord * std::sin(middle), chord * std::cos(middle), half + 0.5 * doubleChord * std::cos(2 * middle),
            0.5 * doubleChord * std::sin(2 * middle)};
}

/// Integrals over the polar angle theta of a row, with the measure sin(theta) d(theta).
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

/// Sums over a row of the radiance of each texel times its integrals over the azimuth.
struct RowSums {
    glm::dvec3 one{0}, sine{0}, cosine{0}, cosineSquared{0}, sineCosine{0};
    void add(const AzimuthIntegrals& column, const glm::dvec3& radiance) {
        one += column.one * radiance;
        sine += column.sine * radiance;
        cosine += column.cosine * radiance;
        cosineSquared += column.cosineSquared * radiance;
        sineCosine += column.sineCosine * radiance;
    }
};

void addRow(ShRgbDouble& sum, const PolarIntegrals& polar, const RowSums& row) {
    sum[0] += kShConstant * polar.one * row.one;
    sum[1] += kShLinear * polar.y * row.one;
    sum[2] -= kShLinear * polar.sine * row.cosine;
    sum[3] += kShLinear * polar.sine * row.sine;
    sum[4] += kShProduct * polar.sineY * row.sine;
    sum[5] -= kShProduct * polar.sineY * row.cosine;
    sum[6] += kShZonal * (3.0 * polar.sineSquared * row.cosineSquared - polar.one * row.one);
    sum[7] -= kShProduct * polar.sineSquared * row.sineCosine;
    sum[8] += kShDifference * (polar.sineSquared * (row.one - row.cosineSquared) - polar.yy * row.one);
}

ShRgbDouble projectEquirectangular(formats::ImageView<const glm::vec3> texels) {
    std::vector<AzimuthIntegrals> columns;
    columns.reserve(static_cast<std::size_t>(texels.width));
    for (int x = 0; x < texels.width; ++x) {
        columns.push_back(azimuthIntegrals(2 * pi * x / texels.width - pi, 2 * pi * (x + 1) / texels.width - pi));
    }
    ShRgbDouble sum{};
    for (int y = 0; y < texels.height; ++y) {
        RowSums row;
        for (int x = 0; x < texels.width; ++x) row.add(columns[static_cast<std::size_t>(x)], glm::dvec3(texels.row(y)[x]));
        addRow(sum, polarIntegrals(pi * y / texels.height, pi * (y + 1) / texels.height), row);
    }
    return sum;
}

/// Integrals over a texel of a face with respect to solid angle: of 1, of the direction's components along the face's axes (major, right,
/// down), and of their products. The same for all six faces.
struct FaceMoments {
    double one = 0, major = 0, right = 0, down = 0, rightRight = 0, downDown = 0, majorRight = 0, majorDown = 0, rightDown = 0;
};

FaceMoments momentsOf(double left, double top, double size, int pieces) {
    static const GaussRule<3> rule = gaussLegendre<3>();
    const double step = size / pieces;
    FaceMoments moments;
    for (int subRow = 0; subRow < 3 * pieces; ++subRow)
        for (int subColumn = 0; subColumn < 3 * pieces; ++subColumn) {
            const auto i = static_cast<std::size_t>(subColumn % 3), j = static_cast<std::size_t>(subRow % 3);
            const int column = subColumn / 3, row = subRow / 3;
            const double u = left + step * (column + rule.point[i]), v = top + step * (row + rule.point[j]);
            const double major = 1 / std::sqrt(1 + u * u + v * v), right = u * major, down = v * major;
            const double solidAngle = step * step * rule.weight[i] * rule.weight[j] * (major * major * major);
            moments.one += solidAngle;
            moments.major += solidAngle * major;
            moments.right += solidAngle * right;
            moments.down += solidAngle * down;
            moments.rightRight += solidAngle * (right * right);
            moments.downDown += solidAngle * (down * down);
            moments.majorRight += solidAngle * (major * right);
            moments.majorDown += solidAngle * (major * down);
            moments.rightDown += solidAngle * (right * down);
        }
    return moments;
}

/// Integrals over a face of L, of L times a component of the direction, and of L times the product of two.
struct FaceSums {
    glm::dvec3 one{0}, major{0}, right{0}, down{0}, rightRight{0}, downDown{0}, majorRight{0}, majorDown{0}, rightDown{0};
    void add(const FaceMoments& moments, const glm::dvec3& radiance) {
        one += moments.one * radiance;
        major += moments.major * radiance;
        right += moments.right * radiance;
        down += moments.down * radiance;
        rightRight += moments.rightRight * radiance;
        downDown += moments.downDown * radiance;
        majorRight += moments.majorRight * radiance;
        majorDown += moments.majorDown * radiance;
        rightDown += moments.rightDown * radiance;
    }
};

/// Converts the sums of a face to x, y and z, and these to coefficients.
void addFace(ShRgbDouble& sum, int face, const FaceSums& sums) {
    const glm::dvec3 major = lighting::directionFromCube({face, {0, 0}});
    // (major + right) / sqrt 2 minus its major component, rounded: exactly the right axis.
    const glm::dvec3 right = glm::round(lighting::directionFromCube({face, {1, 0}}) * std::sqrt(2.0) - major),
                     down = glm::round(lighting::directionFromCube({face, {0, 1}}) * std::sqrt(2.0) - major);
    std::array<glm::dvec3, 3> linear;                  // of x, y, z
    std::array<std::array<glm::dvec3, 3>, 3> product;  // of xx, xy, ...
    const glm::dvec3 majorMajor = sums.one - sums.rightRight - sums.downDown;
    for (int a = 0; a < 3; ++a) {
        linear[static_cast<std::size_t>(a)] = major[a] * sums.major + right[a] * sums.right + down[a] * sums.down;
        for (int b = 0; b < 3; ++b)
            product[static_cast<std::size_t>(a)][static_cast<std::size_t>(b)] =
                major[a] * major[b] * majorMajor + right[a] * right[b] * sums.rightRight + down[a] * down[b] * sums.downDown +
                (major[a] * right[b] + right[a] * major[b]) * sums.majorRight + (major[a] * down[b] + down[a] * major[b]) * sums.majorDown +
                (right[a] * down[b] + down[a] * right[b]) * sums.rightDown;
    }
    const auto& [x, y, z] = linear;
    sum[0] += kShConstant * sums.one;
    sum[1] += kShLinear * y;
    sum[2] += kShLinear * z;
    sum[3] += kShLinear * x;
    sum[4] += kShProduct * product[0][1];
    sum[5] += kShProduct * product[1][2];
    sum[6] += kShZonal * (3.0 * product[2][2] - sums.one);
    sum[7] += kShProduct * product[0][2];
    sum[8] += kShDifference * (product[0][0] - product[1][1]);
}

ShRgbDouble projectCubeStrip(formats::ImageView<const glm::vec3> texels) {
    const int size = texels.width;
    const int pieces = std::max(1, 48 / size);  // error of three points on 1/48 of a face: 1e-10
    const double step = 2.0 / size;
    std::array<FaceSums, 6> sums{};
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            const FaceMoments moments = momentsOf(step * x - 1, step * y - 1, step, pieces);
            for (int face = 0; face < 6; ++face)
                sums[static_cast<std::size_t>(face)].add(moments, glm::dvec3(texels.at(x, face * size + y)));
        }
    ShRgbDouble sum{};
    for (int face = 0; face < 6; ++face) addFace(sum, face, sums[static_cast<std::size_t>(face)]);
    return sum;
}

/// The factors of a narrower lobe differ from 1 by less than 1e-20.
constexpr double kSmallestKernel = 1e-12;

/// Returns the integral of shape P_l dw for l = 0, 1, 2. Intervals of 1 - c halve towards the peak, so that they fit a lobe of any width.
std::array<double, 3> shapeMoments(PrefilterKernel kernel, double m) {
    static const GaussRule<20> rule = gaussLegendre<20>();
    std::array<double, 3> moments{};
    double end = 1;
    const double smallest = 1e-4 * m * m;
    while (end > 0) {
        const double begin = end > smallest ? end / 2 : 0;
        for (std::size_t i = 0; i < rule.point.size(); ++i) {
            double versine = begin + (end - begin) * rule.point[i], width = end - begin;
            if (end == 1) {  // c = t^3 / 2: Phong's fractional power of c is smooth in t
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
    if (m < kSmallestKernel) return {1, 1, 1};
    const std::array<double, 3> moments = shapeMoments(kernel, m);
    return {1, moments[1] / moments[0], moments[2] / moments[0]};
}

}  // namespace lightcook::fit

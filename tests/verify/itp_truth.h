// Delta E ITP in long double, written from the standards alone: the truth that visible errors are tested against.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "verify/visible.h"

namespace lightcook::verify {

namespace itp {

using Real = long double;
using Vector = std::array<Real, 3>;
using Matrix = std::array<Vector, 3>;  ///< rows

inline Vector times(const Matrix& m, const Vector& v) {
    Vector out{};
    for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t k = 0; k < 3; ++k) out[row] += m[row][k] * v[k];
    return out;
}
/// Returns the inverse by cofactors.
inline Matrix inverse(const Matrix& m) {
    const auto minor = [&](std::size_t row, std::size_t column) {
        const std::size_t r = (row + 1) % 3, s = (row + 2) % 3, c = (column + 1) % 3, d = (column + 2) % 3;
        return m[r][c] * m[s][d] - m[r][d] * m[s][c];
    };
    const Real determinant = m[0][0] * minor(0, 0) + m[0][1] * minor(0, 1) + m[0][2] * minor(0, 2);
    Matrix out{};
    for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t column = 0; column < 3; ++column) out[row][column] = minor(column, row) / determinant;
    return out;
}
/// Returns XYZ of linear RGB with the chromaticities (x, y) of red, green and blue, and D65 (0.3127, 0.3290) as white.
inline Matrix xyzFromRgb(const std::array<std::array<Real, 2>, 3>& primaries) {
    Matrix columns{};
    for (std::size_t k = 0; k < 3; ++k) {
        const auto [x, y] = primaries[k];
        columns[0][k] = x / y, columns[1][k] = 1, columns[2][k] = (1 - x - y) / y;
    }
    const Real x = 0.3127L, y = 0.3290L;
    const Vector scale = times(inverse(columns), {x / y, 1, (1 - x - y) / y});
    for (Vector& row : columns)
        for (std::size_t k = 0; k < 3; ++k) row[k] *= scale[k];
    return columns;
}
/// The inverse EOTF of SMPTE ST 2084.
inline Real pq(Real nits) {
    const Real y = std::pow(std::clamp(nits / 10000, Real(0), Real(1)), Real(2610) / 16384);
    return std::pow((Real(3424) / 4096 + Real(2413) / 128 * y) / (1 + Real(2392) / 128 * y), Real(2523) / 32);
}
/// Returns I, T and P of linear Rec.709 light [cd/m^2].
inline Vector itpOf(const Vector& rec709) {
    static const Matrix to = xyzFromRgb({{{0.64L, 0.33L}, {0.30L, 0.60L}, {0.15L, 0.06L}}});
    static const Matrix from = inverse(xyzFromRgb({{{0.708L, 0.292L}, {0.170L, 0.797L}, {0.131L, 0.046L}}}));
    const Vector rgb = times(from, times(to, rec709));
    const Real l = pq((1688 * rgb[0] + 2146 * rgb[1] + 262 * rgb[2]) / 4096), m = pq((683 * rgb[0] + 2951 * rgb[1] + 462 * rgb[2]) / 4096),
               s = pq((99 * rgb[0] + 309 * rgb[1] + 3688 * rgb[2]) / 4096);
    return {(l + m) / 2, (6610 * l - 13613 * m + 7003 * s) / 8192, (17933 * l - 17390 * m - 543 * s) / 4096};
}

}  // namespace itp

/// Returns the difference of two lights of Rec.709 on a display that shows `nits` cd/m^2 for a unit, and 0.5 cd/m^2 for black.
inline double visibleTruth(const glm::dvec3& a, const glm::dvec3& b, double nits) {
    itp::Vector first{}, second{};
    for (int c = 0; c < 3; ++c) {
        first[static_cast<std::size_t>(c)] = static_cast<itp::Real>(std::max(a[c], 0.0) * nits + 0.5);
        second[static_cast<std::size_t>(c)] = static_cast<itp::Real>(std::max(b[c], 0.0) * nits + 0.5);
    }
    const itp::Vector x = itp::itpOf(first), y = itp::itpOf(second);
    itp::Real squares = 0;
    for (std::size_t k = 0; k < 3; ++k) squares += (x[k] - y[k]) * (x[k] - y[k]);
    return static_cast<double>(720 * std::sqrt(squares));
}

/// Primaries of the display, and of ones that a working space may have: those of Rec.709, of BT.2020, and of ACES AP0, two of which lower
/// L, M or S.
inline const std::array<glm::dmat3, 3>& testedPrimaries() {
    static const std::array<glm::dmat3, 3> kMatrices = {
        lighting::bt2020FromRec709(), glm::dmat3(1),
        glm::dmat3(1.4905, -0.0802, 0.0033, -0.2661, 1.1823, -0.0347, -0.2244, -0.1021, 1.0314)};
    return kMatrices;
}
/// L, M and S as the metric has them, X_k = black + sum of M_kc max(x_c, 0), and Delta E ITP.
inline itp::Vector shownOf(const itp::Vector& light, const Viewing& viewing) {
    constexpr itp::Real kLms[3][3] = {{1688, 2146, 262}, {683, 2951, 462}, {99, 309, 3688}};
    itp::Vector out{};
    for (std::size_t k = 0; k < 3; ++k) {
        out[k] = static_cast<itp::Real>(viewing.display.black);
        for (int row = 0; row < 3; ++row)
            for (int c = 0; c < 3; ++c)
                out[k] += kLms[k][row] / 4096 * static_cast<itp::Real>(viewing.bt2020FromWorking[c][row]) *
                          static_cast<itp::Real>(viewing.display.nitsPerUnit) * std::max(light[static_cast<std::size_t>(c)], itp::Real(0));
    }
    return out;
}
inline itp::Real truthOf(const itp::Vector& a, const itp::Vector& b, const Viewing& viewing) {
    const auto x = shownOf(a, viewing), y = shownOf(b, viewing);
    // The verifier's curve begins at 2^-8 cd/m^2, below the black of every display: only primaries that lower L, M or S reach it.
    const auto code = [](itp::Real nits) { return itp::pq(std::max(nits, itp::Real(0x1p-8L))); };
    itp::Vector d{};
    for (std::size_t k = 0; k < 3; ++k) d[k] = code(x[k]) - code(y[k]);
    const itp::Real i = (d[0] + d[1]) / 2, t = (6610 * d[0] - 13613 * d[1] + 7003 * d[2]) / 8192,
                    p = (17933 * d[0] - 17390 * d[1] - 543 * d[2]) / 4096;
    return 720 * std::sqrt(i * i + t * t + p * p);
}

}  // namespace lightcook::verify

#include "compress/light_map/basis/table_fit.h"

#include <Eigen/Cholesky>
#include <array>
#include <cmath>
#include <utility>

namespace lightcook::compress {

namespace {

/// Approximate standard deviation of a code's error in block compression.
constexpr double kCodeNoise = 0.006;

/// The 15 monomials and their products, padded by a zero to whole registers.
constexpr Eigen::Index kPadded = 16;
using Monomials = Eigen::Matrix<double, kPadded, 1>;
using Products = Eigen::Matrix<double, kPadded, kPadded>;

Monomials monomialsOf(const glm::vec4& code) {
    const glm::dvec4 u(code);
    Monomials m;
    m << 1, u.x, u.y, u.z, u.x * u.x, u.x * u.y, u.x * u.z, u.y * u.y, u.y * u.z, u.z * u.z, u.w, u.x * u.w, u.y * u.w, u.z * u.w,
        u.w * u.w, 0;
    return m;
}

/// Adds the expected effect of code noise to the products of the monomials.
void addNoise(const glm::vec4& code, int codeChannels, Products& products) {
    const glm::dvec4 u(code);
    using Term = std::pair<int, double>;  // monomial, its derivative
    const std::array<std::array<Term, 5>, 4> derivatives = {{
        {{{1, 1}, {4, 2 * u.x}, {5, u.y}, {6, u.z}, {11, u.w}}},     // by code channel 0
        {{{2, 1}, {5, u.x}, {7, 2 * u.y}, {8, u.z}, {12, u.w}}},     // 1
        {{{3, 1}, {6, u.x}, {8, u.y}, {9, 2 * u.z}, {13, u.w}}},     // 2
        {{{10, 1}, {11, u.x}, {12, u.y}, {13, u.z}, {14, 2 * u.w}}}  // 3
    }};
    const std::size_t terms = codeChannels == 3 ? 4 : 5;
    for (std::size_t k = 0; k < static_cast<std::size_t>(codeChannels); ++k)
        for (std::size_t a = 0; a < terms; ++a)
            for (std::size_t b = 0; b < terms; ++b)
                products(derivatives[k][a].first, derivatives[k][b].first) +=
                    kCodeNoise * kCodeNoise * derivatives[k][a].second * derivatives[k][b].second;
}

/// Normal equations of one channel: eight coefficients share the matrix.
struct Equations {
    Products matrix = Products::Zero();
    Eigen::Matrix<double, kPadded, 8> right = Eigen::Matrix<double, kPadded, 8>::Zero();
};

std::array<Equations, 3> equationsOf(const std::vector<SampleTexel*>& members, int codeChannels) {
    std::array<Equations, 3> out;
    for (const SampleTexel* texel : members) {
        const Monomials m = monomialsOf(texel->code);
        Products products = m * m.transpose();
        addNoise(texel->code, codeChannels, products);
        for (std::size_t c = 0; c < 3; ++c) {
            const double weight = static_cast<double>(texel->weight * texel->light[c]);
            out[c].matrix += weight * products;
            for (Eigen::Index i = 0; i < 8; ++i)
                out[c].right.col(i) += (weight * static_cast<double>(texel->ratio[c][static_cast<std::size_t>(i) + 1])) * m;
        }
    }
    return out;
}

}  // namespace

void fitTable(const std::vector<SampleTexel*>& members, const BasisShape& shape, CodeTable& table) {
    const std::array<Equations, 3> equations = equationsOf(members, shape.codeChannels);
    const Eigen::Index count = shape.monomialCount();
    for (std::size_t c = 0; c < 3; ++c) {
        Eigen::MatrixXd matrix = equations[c].matrix.topLeftCorner(count, count);
        matrix.diagonal().array() += 1e-7 * matrix.trace() / static_cast<double>(count) + 1e-300;
        const Eigen::MatrixXd solved = matrix.ldlt().solve(equations[c].right.topRows(count));
        for (Eigen::Index m = 0; m < count; ++m)
            for (Eigen::Index i = 0; i < 8; ++i)
                table[static_cast<std::size_t>(m)][c][static_cast<std::size_t>(i)] =
                    std::isfinite(solved(m, i)) ? roundedToHalf(solved(m, i)) : 0;
    }
}

}  // namespace lightcook::compress

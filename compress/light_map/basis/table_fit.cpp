#include "compress/light_map/basis/table_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/vec4.hpp>
#include <utility>

#include "compress/light_map/basis/form_regression.h"

namespace lightcook::compress {

namespace {

/// Approximate standard deviation of a code's error in block compression.
constexpr double kCodeNoise = 0.006;

/// The 15 monomials and their products, padded by a zero to whole registers.
constexpr Eigen::Index kPadded = 16;
using Monomials = Eigen::Matrix<double, kPadded, 1>;
using Products = Eigen::Matrix<double, kPadded, kPadded>;

Monomials monomialsOf(const glm::dvec4& u) {
    Monomials m;
    m << 1, u.x, u.y, u.z, u.x * u.x, u.x * u.y, u.x * u.z, u.y * u.y, u.y * u.z, u.z * u.z, u.w, u.x * u.w, u.y * u.w, u.z * u.w,
        u.w * u.w, 0;
    return m;
}

/// Adds the expected effect of code noise to the products of the monomials.
void addNoise(const glm::dvec4& u, const glm::dvec4& noise, int codeChannels, Products& products) {
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
                    noise[static_cast<int>(k)] * noise[static_cast<int>(k)] * derivatives[k][a].second * derivatives[k][b].second;
}

/// The map of a cluster's codes to mean 0 and standard deviation 1, whose monomials are less correlated: the normal equations are better
/// conditioned.
struct Normalization {
    glm::dvec4 centre{0.5}, scale{1};
    explicit Normalization(const std::vector<SampleTexel*>& members) {
        glm::dvec4 first(0), second(0);
        double sum = 1e-300;
        for (const SampleTexel* texel : members) {
            const auto weight = static_cast<double>(texel->totalWeight());
            const glm::dvec4 code(texel->code);
            sum += weight;
            first += weight * code;
            second += weight * code * code;
        }
        centre = first / sum;
        for (int k = 0; k < 4; ++k) scale[k] = 1 / std::max(std::sqrt(std::max(second[k] / sum - centre[k] * centre[k], 0.0)), 1e-3);
    }
    glm::dvec4 of(const glm::vec4& code) const { return scale * (glm::dvec4(code) - centre); }
};

using Table = Eigen::Matrix<double, 24, kCodeMonomials>;
/// Returns the polynomial p' with p'(u) = p(scale (u - centre)).
Table substituted(const Table& p, const glm::dvec4& scale, const glm::dvec4& centre) {
    constexpr std::array<int, 4> kLinear = {1, 2, 3, 10};
    constexpr std::array<std::array<int, 3>, 10> kQuadratic = {
        {{4, 0, 0}, {5, 0, 1}, {6, 0, 2}, {7, 1, 1}, {8, 1, 2}, {9, 2, 2}, {11, 0, 3}, {12, 1, 3}, {13, 2, 3}, {14, 3, 3}}};
    Table out = Table::Zero();
    out.col(0) = p.col(0);
    for (int k = 0; k < 4; ++k) {
        const Eigen::Matrix<double, 24, 1> linear = scale[k] * p.col(kLinear[static_cast<std::size_t>(k)]);
        out.col(kLinear[static_cast<std::size_t>(k)]) += linear;
        out.col(0) -= centre[k] * linear;
    }
    for (const auto& [m, k, l] : kQuadratic) {
        const Eigen::Matrix<double, 24, 1> quadratic = scale[k] * scale[l] * p.col(m);
        out.col(m) += quadratic;
        out.col(kLinear[static_cast<std::size_t>(k)]) -= centre[l] * quadratic;
        out.col(kLinear[static_cast<std::size_t>(l)]) -= centre[k] * quadratic;
        out.col(0) += centre[k] * centre[l] * quadratic;
    }
    return out;
}

/// Returns the table as [unknown][monomial].
Table matrixOf(const CodeTable& table) {
    Table out;
    for (Eigen::Index m = 0; m < kCodeMonomials; ++m)
        for (Eigen::Index k = 0; k < 24; ++k)
            out(k, m) =
                static_cast<double>(table[static_cast<std::size_t>(m)][static_cast<std::size_t>(k / 8)][static_cast<std::size_t>(k % 8)]);
    return out;
}
/// Returns the table of a matrix, rounded to 16-bit floats.
CodeTable tableOf(const Table& matrix) {
    CodeTable out{};
    for (Eigen::Index m = 0; m < kCodeMonomials; ++m)
        for (Eigen::Index k = 0; k < 24; ++k)
            out[static_cast<std::size_t>(m)][static_cast<std::size_t>(k / 8)][static_cast<std::size_t>(k % 8)] =
                roundedToHalf(matrix(k, m));
    return out;
}

}  // namespace

void fitTable(const std::vector<SampleTexel*>& members, const BasisShape& shape, CodeTable& table) {
    constexpr int kSteps = 20;
    constexpr double kRidge = 1e-6;
    const Normalization normalization(members);
    const Eigen::Index count = shape.monomialCount();
    FormRegression regression(static_cast<int>(count), 1);
    Eigen::VectorXd features(count), products(count * (count + 1) / 2);
    for (const SampleTexel* texel : members) {
        const glm::dvec4 v = normalization.of(texel->code);
        const Monomials m = monomialsOf(v);
        Products all = m * m.transpose();
        addNoise(v, kCodeNoise * normalization.scale, shape.codeChannels, all);
        features = m.head(count);
        for (Eigen::Index a = 0, i = 0; a < count; ++a)
            for (Eigen::Index b = 0; b <= a; ++b) products(i++) = all(a, b);
        regression.add(BasisSample::targetOf(*texel), static_cast<double>(texel->weight), features, products);
    }
    const Table start = substituted(matrixOf(table), 1.0 / normalization.scale, -normalization.scale * normalization.centre);
    Eigen::MatrixXd factors = start.leftCols(count);
    regression.solve(factors, kSteps, kRidge);
    Table found = Table::Zero();
    found.leftCols(count) = factors;
    table = tableOf(substituted(found, normalization.scale, normalization.centre));
}

}  // namespace lightcook::compress

#include "compress/light_map/basis/model.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "lighting/brdf.h"
#include "lighting/radiometry.h"
#include "lighting/sphere.h"

namespace lightcook::compress {

namespace {

constexpr std::size_t kCount = lighting::kShCount;

/// Rows whose outer products add up to the metric in the frame whose z is the normal.
std::vector<lighting::ShDouble> localRows() {
    std::vector<lighting::ShDouble> rows;
    constexpr int kNormals = 16, kViews = 6;
    for (int i = 0; i < kNormals; ++i) {
        lighting::ShDouble row = lighting::evaluateBasis(lighting::fibonacciHemisphere(i, kNormals));
        for (std::size_t c = 0; c < kCount; ++c)
            row[c] *= lighting::kExitRadianceBands[static_cast<std::size_t>(lighting::kShBand[c])] / std::sqrt(double{kNormals});
        rows.push_back(row);
    }
    for (int i = 0; i < kViews; ++i) {
        const glm::dvec3 view = lighting::fibonacciHemisphere(i, kViews);
        const double cosine = view.x / std::hypot(view.x, view.y), sine = view.y / std::hypot(view.x, view.y);
        const lighting::ShRotation turn(glm::dmat3(glm::dvec3(cosine, sine, 0), glm::dvec3(-sine, cosine, 0), glm::dvec3(0, 0, 1)));
        for (const double m : {0.1, 0.25, 0.5}) {
            const lighting::AreaSpecularKernel kernel = lighting::integrateAreaSpecular(view.z, m, lighting::NormalDistribution::Beckmann,
                                                                                        lighting::CookTorranceNormalization::Energy, 48);
            for (const double f0 : {0.04, 0.6}) {
                lighting::ShDouble row;
                for (std::size_t c = 0; c < kCount; ++c) row[c] = f0 * kernel.c[c] + (1 - f0) * kernel.d[c];
                row = turn.apply(row);
                // A material of 4 % shows little light and is asked for no less: each counts by its own answer to constant light.
                const double unit = std::max(row[0], 1e-3) / lighting::kShConstant * std::sqrt(6.0 * kViews);
                for (double& value : row) value /= unit;
                rows.push_back(row);
            }
        }
    }
    return rows;
}

/// The same metric as nine rows: the rows of its Cholesky factor, transposed.
std::array<lighting::ShDouble, kCount> localFactor() {
    Eigen::Matrix<double, 9, 9> sum = Eigen::Matrix<double, 9, 9>::Zero();
    for (const lighting::ShDouble& row : localRows()) {
        const Eigen::Map<const Eigen::Matrix<double, 9, 1>> r(row.data());
        sum += r * r.transpose();
    }
    const Eigen::Matrix<double, 9, 9> factor = sum.llt().matrixL();
    std::array<lighting::ShDouble, kCount> columns{};
    for (int c = 0; c < 9; ++c)
        for (int r = 0; r < 9; ++r) columns[static_cast<std::size_t>(c)][static_cast<std::size_t>(r)] = factor(r, c);
    return columns;
}

using Quartet = Eigen::Matrix<float, 4, 4>;
using Four = Eigen::Matrix<float, 4, 1>;

std::array<float, kCount> timesAll(const Metric& metric, const std::array<float, kCount>& v) {
    std::array<float, kCount> out{};
    for (std::size_t j = 0; j < kCount; ++j)
        for (std::size_t i = 0; i < kCount; ++i) out[i] += metric[j][i] * v[j];
    return out;
}
template <std::size_t kSize>
float dot(const std::array<float, kSize>& a, const std::array<float, kSize>& b) {
    std::array<float, kSize> products;
    for (std::size_t i = 0; i < kSize; ++i) products[i] = a[i] * b[i];
    float sum = 0;
    for (const float product : products) sum += product;
    return sum;
}

/// out += factor * in
void accumulate(HigherByChannel& out, float factor, const HigherByChannel& in) {
    for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t i = 0; i < 8; ++i) out[c][i] += factor * in[c][i];
}

}  // namespace

std::size_t BasisModel::tableBytes() const {
    const std::size_t codeTable = 2 * 24 * static_cast<std::size_t>(shape.monomialCount());
    return code.size() * (codeTable + static_cast<std::size_t>(shape.residualLayers) * kResidualTableBytes);
}

const Metric& ShadingMetric::at(const glm::vec3& normal) {
    if (normal == normal_) return metric_;
    static const std::array<lighting::ShDouble, kCount> factor = localFactor();
    normal_ = normal;
    const lighting::ShRotation turn(lighting::worldFromTangentFrame(glm::dvec3(normal)));
    metric_ = {};
    for (const lighting::ShDouble& column : factor) {
        const lighting::ShDouble world = turn.apply(column);
        for (std::size_t i = 0; i < kCount; ++i)
            for (std::size_t j = 0; j < kCount; ++j) metric_.matrix[i][j] += static_cast<float>(world[i] * world[j]);
    }
    Eigen::Matrix<float, 8, 8> higher;
    for (int i = 0; i < 8; ++i)
        for (int j = 0; j < 8; ++j) higher(i, j) = metric_[static_cast<std::size_t>(i) + 1][static_cast<std::size_t>(j) + 1];
    const Eigen::Matrix<float, 8, 8> root = higher.llt().matrixU();
    for (int i = 0; i < 8; ++i)
        for (int j = 0; j < 8; ++j) metric_.higherRoot[static_cast<std::size_t>(j)][static_cast<std::size_t>(i)] = root(i, j);
    return metric_;
}

HigherByChannel evaluateCode(const CodeTable& table, int monomialCount, const glm::vec4& u) {
    const std::array<float, kCodeMonomials> monomials = {1,         u.x,       u.y, u.z,       u.x * u.x, u.x * u.y, u.x * u.z, u.y * u.y,
                                                         u.y * u.z, u.z * u.z, u.w, u.x * u.w, u.y * u.w, u.z * u.w, u.w * u.w};
    HigherByChannel out = table[0];
    for (std::size_t m = 1; m < static_cast<std::size_t>(monomialCount); ++m) accumulate(out, monomials[m], table[m]);
    return out;
}

void addResidual(const ResidualTable& table, const glm::vec4& texel, ByChannel& ratio) {
    for (std::size_t k = 0; k < 4; ++k) {
        const float factor = texel[static_cast<int>(k)] - kResidualNeutral;
        for (std::size_t c = 0; c < 3; ++c)
            for (std::size_t i = 0; i < kCount; ++i) ratio[c][i] += factor * table[k][c][i];
    }
}

glm::vec4 solveResidual(const ResidualTable& table, const BasisTarget& target) {
    Quartet matrix = Quartet::Zero();
    Four right = Four::Zero();
    for (std::size_t c = 0; c < 3; ++c)
        for (int k = 0; k < 4; ++k) {
            std::array<float, kCount> weighted = timesAll(*target.metric, table[static_cast<std::size_t>(k)][c]);
            for (float& value : weighted) value *= target.weight[c];
            right(k) += dot(weighted, target.ratio[c]);
            for (int l = 0; l <= k; ++l) matrix(k, l) += dot(weighted, table[static_cast<std::size_t>(l)][c]);
        }
    matrix.triangularView<Eigen::StrictlyUpper>() = matrix.transpose();
    const float mean = matrix.trace() / 4 + 1e-30f;
    for (int k = 0; k < 4; ++k) matrix(k, k) += 1e-5f * mean;
    const Four found = matrix.ldlt().solve(right);
    if (!found.allFinite()) return glm::vec4(kResidualNeutral);
    return glm::clamp(glm::vec4(found(0), found(1), found(2), found(3)) + kResidualNeutral, 0.0f, 1.0f);
}

glm::vec4 residualSensitivity(const ResidualTable& table, const BasisTarget& target) {
    glm::vec4 sum(0);
    for (std::size_t k = 0; k < 4; ++k)
        for (std::size_t c = 0; c < 3; ++c)
            sum[static_cast<int>(k)] += target.weight[c] * dot(table[k][c], timesAll(*target.metric, table[k][c]));
    return sum;
}

}  // namespace lightcook::compress

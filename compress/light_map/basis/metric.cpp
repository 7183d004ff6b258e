#include "compress/light_map/basis/metric.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "lighting/brdf.h"
#include "lighting/radiometry.h"
#include "lighting/sphere.h"

namespace lightcook::compress {

namespace {

constexpr std::size_t kCount = lighting::kShCount;

/// Returns rows r whose outer products r r' add up to the metric in the frame whose z is the normal: one for each sampled normal, and one
/// for each view and material.
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
                // Relative to the response to constant light, so that a material of F0 = 4 % counts as much as one of 60 %.
                const double unit = std::max(row[0], 1e-3) / lighting::kShConstant * std::sqrt(6.0 * kViews);
                for (double& value : row) value /= unit;
                rows.push_back(row);
            }
        }
    }
    return rows;
}

/// Returns the same metric as nine rows: the columns of its Cholesky factor.
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

}  // namespace

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

}  // namespace lightcook::compress

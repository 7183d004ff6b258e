#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <glm/vector_relational.hpp>
#include <random>
#include <set>

#include "compress/light_map/basis/clusters.h"
#include "compress/light_map/basis/code_solver.h"
#include "compress/light_map/basis/model.h"
#include "lighting/sphere.h"
#include "shaders/lightcook_cpp.h"

namespace lightcook {
namespace {

using compress::BasisShape;
using compress::BasisTarget;
using compress::ByChannel;
using compress::CodeTable;
using compress::Metric;
using compress::ResidualTable;

class BasisTest : public testing::Test {
protected:
    float uniform(float low, float high) { return std::uniform_real_distribution<float>(low, high)(random_); }
    glm::vec4 randomCode() { return {uniform(0, 1), uniform(0, 1), uniform(0, 1), uniform(0, 1)}; }
    CodeTable randomTable(float bend) {
        CodeTable table;
        for (std::size_t m = 0; m < table.size(); ++m)
            for (auto& channel : table[m])
                for (float& value : channel) value = uniform(-1, 1) * (m >= 4 && m != 10 ? bend : 1.0f);
        return table;
    }
    ResidualTable randomResidual() {
        ResidualTable table;
        for (ByChannel& k : table)
            for (auto& channel : k)
                for (float& value : channel) value = uniform(-1, 1);
        return table;
    }
    glm::vec3 randomNormal() { return glm::vec3(lighting::fibonacciSphere(static_cast<int>(random_() % 1000), 1000)); }

    std::mt19937 random_{11};
};

double cost(const Metric& metric, const std::array<double, 9>& error) {
    double sum = 0;
    for (std::size_t i = 0; i < 9; ++i)
        for (std::size_t j = 0; j < 9; ++j) sum += static_cast<double>(metric[i][j]) * error[i] * error[j];
    return sum;
}

TEST_F(BasisTest, DecodesAsTheShaderDoes) {
    for (int round = 0; round < 100; ++round) {
        const CodeTable table = randomTable(1);
        const ResidualTable residual = randomResidual();
        shaders::LcBasisFirst3 first3;
        shaders::LcBasisFirst4 first4;
        shaders::LcBasisResidual added;
        for (std::size_t m = 0; m < 15; ++m)
            for (std::size_t i = 0; i < 8; ++i) {
                const glm::vec3 value(table[m][0][i], table[m][1][i], table[m][2][i]);
                first4.v[8 * m + i] = value;
                if (m < 10) first3.v[8 * m + i] = value;
            }
        for (std::size_t k = 0; k < 4; ++k)
            for (std::size_t i = 0; i < 9; ++i) added.v[9 * k + i] = glm::vec3(residual[k][0][i], residual[k][1][i], residual[k][2][i]);
        const glm::vec4 l0(uniform(0, 2), uniform(0, 2), uniform(0, 2), 1), code = randomCode(), texel = randomCode();
        for (const int codes : {3, 4}) {
            const shaders::LcSh plain =
                codes == 3 ? shaders::lcLightMapBasis3(l0, code, first3, 2) : shaders::lcLightMapBasis4(l0, code, first4, 2);
            const shaders::LcSh sh = shaders::lcLightMapBasisAdd(plain, l0, texel, added, 2, compress::kResidualNeutral);
            const compress::HigherByChannel higher = compress::evaluateCode(table, BasisShape{codes, 0}.monomialCount(), code);
            ByChannel ratio{};
            for (std::size_t c = 0; c < 3; ++c) {
                ratio[c][0] = 1;
                for (std::size_t i = 0; i < 8; ++i) ratio[c][i + 1] = higher[c][i];
            }
            compress::addResidual(residual, texel, ratio);
            for (int c = 0; c < 3; ++c)
                for (std::size_t i = 0; i < 9; ++i)
                    EXPECT_NEAR(sh.c[i][c], 2 * l0[c] * ratio[static_cast<std::size_t>(c)][i], 1e-4f) << codes << ' ' << i;
        }
    }
}

TEST_F(BasisTest, TheMetricTurnsWithTheNormal) {
    compress::ShadingMetric metric;
    const Metric up = metric.at(glm::vec3(0, 0, 1));
    for (int round = 0; round < 50; ++round) {
        const glm::vec3 normal = randomNormal();
        const Metric turned = metric.at(normal);
        const lighting::ShRotation rotation(lighting::worldFromTangentFrame(glm::dvec3(normal)));
        lighting::ShDouble local;
        for (double& value : local) value = static_cast<double>(uniform(-1, 1));
        const double expected = cost(up, local);
        EXPECT_GT(expected, 0);
        EXPECT_NEAR(cost(turned, rotation.apply(local)), expected, 1e-4 * expected);
    }
    // Constant light has Y0 in every normal and, by its own answer, in every material.
    EXPECT_NEAR(static_cast<double>(up[0][0]), 2 * lighting::kShConstant * lighting::kShConstant, 1e-6);
}

TEST_F(BasisTest, ACodeThatMadeTheTargetIsFoundFromNearby) {
    compress::ShadingMetric metrics;
    for (int round = 0; round < 300; ++round) {
        const BasisShape shape{round % 2 == 0 ? 4 : 3, 0};
        const CodeTable table = randomTable(0.3f);
        glm::vec4 truth = randomCode();
        if (shape.codeChannels == 3) truth.w = 1;
        const Metric metric = metrics.at(randomNormal());
        BasisTarget target{{}, {1, 0.5f, 2}, &metric};
        const compress::HigherByChannel made = compress::evaluateCode(table, shape.monomialCount(), truth);
        for (std::size_t c = 0; c < 3; ++c) std::copy(made[c].begin(), made[c].end(), target.ratio[c].begin() + 1);
        glm::vec4 start = glm::clamp(truth + 0.15f * (randomCode() - 0.5f), 0.0f, 1.0f);
        if (shape.codeChannels == 3) start.w = 1;
        const compress::SolvedCode solved = compress::CodeSpace(table, shape, metric).solve(target, start);
        EXPECT_LT(solved.error, 1e-5f);
        for (int k = 0; k < shape.codeChannels; ++k) EXPECT_NEAR(solved.code[k], truth[k], 2e-2f);
    }
}

TEST_F(BasisTest, ResidualTexelsAreTheLeastSquares) {
    compress::ShadingMetric metrics;
    for (int round = 0; round < 300; ++round) {
        const ResidualTable table = randomResidual();
        const Metric metric = metrics.at(randomNormal());
        BasisTarget target{{}, {1, 0.3f, 3}, &metric};
        for (auto& channel : target.ratio)
            for (float& value : channel) value = uniform(-0.2f, 0.2f);
        const auto costOf = [&](const glm::vec4& texel) {
            ByChannel taken{};
            compress::addResidual(table, texel, taken);
            double sum = 0;
            for (std::size_t c = 0; c < 3; ++c) {
                std::array<double, 9> left;
                for (std::size_t i = 0; i < 9; ++i) left[i] = static_cast<double>(target.ratio[c][i] - taken[c][i]);
                sum += static_cast<double>(target.weight[c]) * cost(metric, left);
            }
            return sum;
        };
        const glm::vec4 found = compress::solveResidual(table, target);
        const bool isInside = glm::all(glm::lessThan(glm::abs(found - 0.5f), glm::vec4(0.49f)));
        if (!isInside) continue;
        const double least = costOf(found);
        for (int k = 0; k < 4; ++k)
            for (const float step : {-0.01f, 0.01f}) {
                glm::vec4 other = found;
                other[k] += step;
                EXPECT_GE(costOf(other), least * (1 - 1e-5));
            }
    }
}

TEST_F(BasisTest, ChartsOfOneSubspaceShareACluster) {
    constexpr int kDimension = 24, kCharts = 30, kPerChart = 40, kKinds = 3;
    compress::ChartPoints points;
    points.chartCount = kCharts;
    points.points.resize(kDimension, kCharts * kPerChart);
    points.weights = Eigen::VectorXf::Ones(kCharts * kPerChart);
    std::array<Eigen::MatrixXf, kKinds> bases;
    std::array<Eigen::VectorXf, kKinds> means;
    const auto randomMatrix = [&](int rows, int columns) {
        Eigen::MatrixXf m(rows, columns);
        for (Eigen::Index c = 0; c < m.cols(); ++c)
            for (Eigen::Index r = 0; r < m.rows(); ++r) m(r, c) = uniform(-1, 1);
        return m;
    };
    for (int kind = 0; kind < kKinds; ++kind) {
        bases[static_cast<std::size_t>(kind)] = randomMatrix(kDimension, 4);
        means[static_cast<std::size_t>(kind)] = randomMatrix(kDimension, 1);
    }
    for (int i = 0; i < kCharts * kPerChart; ++i) {
        const int chart = i / kPerChart;
        const auto kind = static_cast<std::size_t>(chart % kKinds);
        points.chartOf.push_back(chart);
        points.points.col(i) = means[kind] + bases[kind] * randomMatrix(4, 1) + 1e-4f * randomMatrix(kDimension, 1);
    }
    const std::vector<int> clusters = compress::clusterCharts(points, 4, kKinds);
    for (int chart = 0; chart < kCharts; ++chart)
        EXPECT_EQ(clusters[static_cast<std::size_t>(chart)], clusters[static_cast<std::size_t>(chart % kKinds)]) << chart;
    EXPECT_EQ(std::set<int>(clusters.begin(), clusters.end()), (std::set<int>{0, 1, 2}));
    // More clusters than there is anything to tell apart stay few, numbered without gaps.
    const std::vector<int> many = compress::clusterCharts(points, 4, 64);
    const std::set<int> names(many.begin(), many.end());
    EXPECT_EQ(*names.rbegin() + 1, static_cast<int>(names.size()));
    EXPECT_LE(names.size(), 30u);
}

TEST_F(BasisTest, SubspacesAreThoseOfTheSingularValues) {
    const Eigen::MatrixXf points = Eigen::MatrixXf::NullaryExpr(9, 200, [&](Eigen::Index, Eigen::Index) { return uniform(-1, 1); });
    const compress::Subspace subspace = compress::fitSubspace(points, Eigen::VectorXf::Ones(200), 3, true);
    const Eigen::MatrixXf centred = points.colwise() - points.rowwise().mean().eval();
    const Eigen::JacobiSVD<Eigen::MatrixXf> svd(centred, Eigen::ComputeThinU);
    for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(std::abs(svd.matrixU().col(k).dot(subspace.directions.col(k))), 1, 1e-3f);
        EXPECT_NEAR(svd.singularValues()(k) / std::sqrt(200.0f), subspace.deviations(k), 1e-4f);
    }
}

}  // namespace
}  // namespace lightcook

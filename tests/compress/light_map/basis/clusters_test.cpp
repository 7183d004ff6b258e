#include "compress/light_map/basis/clusters.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <set>

#include "tests/compress/light_map/basis/random_basis.h"

namespace lightcook {
namespace {

using ClustersTest = synthetic::BasisTest;

/// Else learned layouts would have other bytes on another machine.
TEST_F(ClustersTest, BlocksOfProductsAreThoseOfNoMachine) {
    EXPECT_EQ(Eigen::l1CacheSize(), compress::kProductCaches[0]);
    EXPECT_EQ(Eigen::l2CacheSize(), compress::kProductCaches[1]);
    EXPECT_EQ(Eigen::l3CacheSize(), compress::kProductCaches[2]);
}

TEST_F(ClustersTest, ChartsOfOneSubspaceShareACluster) {
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
    // No more clusters than distinct subspaces, numbered without gaps.
    const std::vector<int> many = compress::clusterCharts(points, 4, 64);
    const std::set<int> names(many.begin(), many.end());
    EXPECT_EQ(*names.rbegin() + 1, static_cast<int>(names.size()));
    EXPECT_LE(names.size(), 30u);
}

TEST_F(ClustersTest, SubspacesEqualTheSingularVectors) {
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

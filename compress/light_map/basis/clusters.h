// Clusters of charts that share a basis: k-subspaces, that is k-means whose centres are affine subspaces. Private to compress/.
//
// 1. One cluster of all charts: its subspace has the mean and the leading principal components of their points.
// 2. Add a cluster: of the chart that gains most from a subspace of its own. A chart gains at most its cost, so charts are tried from the
//    largest cost down and the search ends at the first cost below the best gain. Then each chart moves to its cheapest cluster, and the
//    clusters that changed are fitted again. Repeat until there are enough, or until the gain is rounding (1e-6 of the total).
// 3. Up to kRounds more of these moves, until no chart moves.
// Source: Bradley and Mangasarian 2000, k-Plane Clustering.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

namespace lightcook::compress {

/// Sizes of the caches, first level first, that Eigen cuts products by [bytes].
inline constexpr std::array<std::ptrdiff_t, 3> kProductCaches = {std::ptrdiff_t{48} << 10, std::ptrdiff_t{2} << 20,
                                                                 std::ptrdiff_t{32} << 20};

/// Weighted points, each of a chart, in a space whose squared distances are costs (error_space.h).
struct ChartPoints {
    Eigen::MatrixXf points;    ///< [dimension][point]
    Eigen::VectorXf weights;   ///< >= 0
    std::vector<int> chartOf;  ///< [point], 0 .. chartCount - 1
    int chartCount = 0;
};

/// Returns the cluster of each chart: numbers from 0 without gaps, at most clusterCount of them. The charts of a cluster lie near one
/// affine subspace of `dimension` directions.
std::vector<int> clusterCharts(const ChartPoints& points, int dimension, int clusterCount);

/// Principal components of weighted points, in descending order. Columns of `directions` are unit.
struct Subspace {
    Eigen::VectorXf mean;
    Eigen::MatrixXf directions;  ///< [dimension of the space][direction]
    Eigen::VectorXf deviations;  ///< standard deviation along each direction
};
/// isCentred  directions from the mean; false: from 0, and the mean is 0
Subspace fitSubspace(const Eigen::MatrixXf& points, const Eigen::VectorXf& weights, int dimension, bool isCentred);

}  // namespace lightcook::compress

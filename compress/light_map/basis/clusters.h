// Charts gathered into clusters that share a basis: k-subspaces, a k-means whose centres are affine subspaces.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace lightcook::compress {

/// Points in a space whose squared distances are costs, each of a chart.
struct ChartPoints {
    Eigen::MatrixXf points;    ///< [dimension][point]
    Eigen::VectorXf weights;   ///< >= 0
    std::vector<int> chartOf;  ///< [point], 0 .. chartCount - 1
    int chartCount = 0;
};

/// A cluster for each chart, 0 .. at most clusterCount - 1, none of them empty. Charts that share a cluster lie near one affine subspace of
/// `dimension` directions. Grown one cluster at a time from the chart that fits worst.
std::vector<int> clusterCharts(const ChartPoints& points, int dimension, int clusterCount);

/// Mean and leading directions of the weighted points, with their standard deviations. Columns of `directions` are unit.
struct Subspace {
    Eigen::VectorXf mean;
    Eigen::MatrixXf directions;
    Eigen::VectorXf deviations;
};
Subspace fitSubspace(const Eigen::MatrixXf& points, const Eigen::VectorXf& weights, int dimension, bool isCentred);

}  // namespace lightcook::compress

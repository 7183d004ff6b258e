// Ratios as points of a space in which squared distances are about the cost of errors, so that principal components and k-subspaces
// (clusters.h) minimise that cost. Private to compress/.
//
// The exact cost has a metric and three channel weights for each texel. The space uses one for all: the Cholesky root of the mean metric
// in each channel, times the root of the channel's share of the light.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "compress/light_map/basis/sample.h"

namespace lightcook::compress {

class ErrorSpace {
public:
    /// members           texels that the means are taken over
    /// firstCoefficient  0: all nine coefficients; 1: without coefficient 0
    ErrorSpace(const BasisSample& sample, const std::vector<SampleTexel*>& members, int firstCoefficient);

    Eigen::Index dimension() const { return 3 * size_; }
    Eigen::VectorXf pointOf(const ByChannel& ratio) const;
    /// Inverse of pointOf; coefficients before the first are 0.
    ByChannel ratioOf(const Eigen::VectorXf& point) const;

private:
    int first_;
    Eigen::Index size_;                ///< coefficients a channel
    Eigen::Matrix<float, 9, 9> root_;  ///< upper; its bottom right corner of size_ is used
    std::array<float, 3> channel_{};   ///< root of each channel's share
};

/// The ratios of some texels as points, with the weights of the texels.
struct SamplePoints {
    Eigen::MatrixXf points;  ///< [dimension][texel]
    Eigen::VectorXf weights;
};
SamplePoints pointsOf(const ErrorSpace& space, const std::vector<SampleTexel*>& members);

}  // namespace lightcook::compress

// Ratios as points of a space in which squared distances are about the cost of errors, so that principal components and k-subspaces
// (clusters.h) minimise that cost. Private to compress/.
//
// The exact cost has a form for each texel. The space uses one for all: the Cholesky root of their weighted mean.
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
    ErrorSpace(const std::vector<SampleTexel*>& members, int firstCoefficient);

    Eigen::Index dimension() const { return 3 * size_; }
    Eigen::VectorXf pointOf(const ByChannel& ratio) const;
    /// Inverse of pointOf; coefficients before the first are 0.
    ByChannel ratioOf(const Eigen::VectorXf& point) const;

private:
    int first_;
    Eigen::Index size_;     ///< coefficients a channel
    Eigen::MatrixXf root_;  ///< upper
};

/// The ratios of some texels as points, with the weights of the texels.
struct SamplePoints {
    Eigen::MatrixXf points;  ///< [dimension][texel]
    Eigen::VectorXf weights;
};
SamplePoints pointsOf(const ErrorSpace& space, const std::vector<SampleTexel*>& members);

}  // namespace lightcook::compress

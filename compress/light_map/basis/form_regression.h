// Weighted least squares with a quadratic form for each observation: the tables of learned layouts. Private to compress/.
//
// Minimises the sum over texels of weight (y - F p)' Q (y - F p), where p are the features of a texel (monomials of its code, or numbers of
// its residual), y its ratios and Q the cost of their errors (RatioCost). The normal matrix has a block Q for each pair of features:
// products of features and forms are collected for some texels at a time, and one matrix product adds them.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "compress/light_map/basis/model.h"

namespace lightcook::compress {

class FormRegression {
public:
    /// features          number of features
    /// firstCoefficient  0: ratios of all nine coefficients; 1: without coefficient 0, whose ratio is 1. Its error still counts, since
    ///                   others can make up for it
    FormRegression(int features, int firstCoefficient);

    /// products  lower triangle of the features' products, row by row; may contain the expected effect of noise
    void add(const BasisTarget& target, double weight, const Eigen::VectorXd& features, const Eigen::VectorXd& products);

    /// Improves F [unknown][feature] by up to `steps` conjugate gradients, preconditioned by the blocks of the channels.
    /// ridge  pulls each number towards its start: this share of its channel's mean diagonal is added to the diagonal
    void solve(Eigen::MatrixXd& factors, int steps, double ridge);

    /// Unknowns: coefficients 1 to 8 of r, g and b, then coefficients 0 if they are unknown.
    Eigen::Index dimension() const { return 3 * size_; }

private:
    static constexpr Eigen::Index kBatch = 64;
    static Eigen::Index pairCount(Eigen::Index n) { return n * (n + 1) / 2; }
    static Eigen::Index pairOf(Eigen::Index i, Eigen::Index j) { return i < j ? pairOf(j, i) : i * (i + 1) / 2 + j; }
    static constexpr Eigen::Index kHigher = RatioCost::kUnknowns;
    static Eigen::Index channelOf(Eigen::Index unknown) { return unknown < kHigher ? unknown / 8 : unknown - kHigher; }
    /// Returns the place of a number of F in the normal matrix, where each channel's numbers lie together.
    Eigen::Index placeOf(Eigen::Index unknown, Eigen::Index feature) const {
        return size_ * (features_ * channelOf(unknown) + feature) + (unknown < kHigher ? unknown % 8 : 8);
    }
    void flush();
    /// Returns the normal matrix, in the order of placeOf.
    Eigen::MatrixXd normalMatrix() const;

    Eigen::Index features_, first_, size_;  ///< size_: coefficients a channel
    Eigen::MatrixXf matrix_;                ///< [pair of unknowns][pair of features], both with zeros up to whole tiles
    Eigen::MatrixXd right_;                 ///< [feature][unknown]: features of an unknown side by side
    Eigen::MatrixXf forms_, products_;      ///< of the texels not yet added: [pair][texel]
    Eigen::Index waiting_ = 0;
};

}  // namespace lightcook::compress

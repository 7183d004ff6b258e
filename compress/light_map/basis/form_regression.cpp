#include "compress/light_map/basis/form_regression.h"

#include <hwy/highway.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

namespace lightcook::compress {

namespace {

// No dynamic dispatch: the program is built for the lanes that are used here, and each sum adds its products one after another.
namespace hn = hwy::HWY_NAMESPACE;
using RowTag = hn::CappedTag<float, 8>;

/// Rows and columns that are summed together: their sums stay in registers.
constexpr Eigen::Index kTile = 8;
Eigen::Index wholeTiles(Eigen::Index count) {
    return (count + kTile - 1) / kTile * kTile;
}

/// Adds the first `count` columns of left times the transposed ones of right to sums, [row of left][row of right]. The rows of all are
/// whole tiles.
void addProducts(const Eigen::MatrixXf& left, const Eigen::MatrixXf& right, Eigen::Index count, Eigen::MatrixXf& sums) {
    constexpr RowTag tag;
    constexpr auto lanes = static_cast<Eigen::Index>(hn::MaxLanes(tag)), parts = kTile / lanes;
    for (Eigen::Index column = 0; column < sums.cols(); column += kTile)
        for (Eigen::Index row = 0; row < sums.rows(); row += kTile) {
            hn::Vec<RowTag> sum[kTile][parts];
            for (Eigen::Index c = 0; c < kTile; ++c)
                for (Eigen::Index p = 0; p < parts; ++p) sum[c][p] = hn::LoadU(tag, &sums(row + p * lanes, column + c));
            for (Eigen::Index k = 0; k < count; ++k)
                for (Eigen::Index p = 0; p < parts; ++p) {
                    const auto values = hn::LoadU(tag, &left(row + p * lanes, k));
                    for (Eigen::Index c = 0; c < kTile; ++c) sum[c][p] = hn::MulAdd(hn::Set(tag, right(column + c, k)), values, sum[c][p]);
                }
            for (Eigen::Index c = 0; c < kTile; ++c)
                for (Eigen::Index p = 0; p < parts; ++p) hn::StoreU(sum[c][p], tag, &sums(row + p * lanes, column + c));
        }
}

}  // namespace

FormRegression::FormRegression(int features, int firstCoefficient)
    : features_(features),
      first_(firstCoefficient),
      size_(9 - firstCoefficient),
      matrix_(Eigen::MatrixXf::Zero(wholeTiles(pairCount(dimension())), wholeTiles(pairCount(features_)))),
      right_(Eigen::MatrixXd::Zero(features_, dimension())),
      forms_(Eigen::MatrixXf::Zero(matrix_.rows(), kBatch)),
      products_(Eigen::MatrixXf::Zero(matrix_.cols(), kBatch)) {}

void FormRegression::add(const BasisTarget& target, double weight, const Eigen::VectorXd& features, const Eigen::VectorXd& products) {
    float* out = forms_.col(waiting_).data();
    for (std::size_t k = 0; k < RatioCost::kUnknowns; ++k) out = std::copy_n(target.cost.higher[k].begin(), k + 1, out);
    for (std::size_t c = 0; c < (first_ == 0 ? 3 : 0); ++c) {
        out = std::ranges::copy(target.cost.zero[c], out).out;
        out = std::copy_n(target.cost.zeroZero[c].begin(), c + 1, out);
    }
    products_.col(waiting_).head(products.size()) = (weight * products).cast<float>();
    ByChannel wanted = target.ratio;
    if (first_ == 1)
        for (auto& channel : wanted) channel[0] -= 1;
    const WeightedRatios pull = times(target.cost, wanted);
    for (Eigen::Index k = 0; k < dimension(); ++k) {
        const float value = k < kHigher ? pull.higher[static_cast<std::size_t>(k / 8)][static_cast<std::size_t>(k % 8)]
                                        : pull.zero[static_cast<std::size_t>(k - kHigher)];
        right_.col(k) += (weight * static_cast<double>(value)) * features;
    }
    if (++waiting_ == kBatch) flush();
}

void FormRegression::flush() {
    addProducts(forms_, products_, waiting_, matrix_);
    waiting_ = 0;
}

Eigen::MatrixXd FormRegression::normalMatrix() const {
    const Eigen::Index block = size_ * features_;
    Eigen::MatrixXd matrix(3 * block, 3 * block);
    for (Eigen::Index a = 0; a < features_; ++a)
        for (Eigen::Index b = 0; b < features_; ++b)
            for (Eigen::Index l = 0; l < dimension(); ++l)
                for (Eigen::Index k = 0; k < dimension(); ++k)
                    matrix(placeOf(k, a), placeOf(l, b)) = static_cast<double>(matrix_(pairOf(k, l), pairOf(a, b)));
    return matrix;
}

void FormRegression::solve(Eigen::MatrixXd& factors, int steps, double ridge) {
    flush();
    const Eigen::Index block = size_ * features_;
    Eigen::MatrixXd matrix = normalMatrix();
    std::array<Eigen::LDLT<Eigen::MatrixXd>, 3> inverse;
    for (Eigen::Index c = 0; c < 3; ++c) {
        auto own = matrix.block(block * c, block * c, block, block);
        own.diagonal().array() += ridge * own.trace() / static_cast<double>(block) + 1e-300;
        inverse[static_cast<std::size_t>(c)].compute(own);
    }
    const auto stacked = [&](const Eigen::MatrixXd& byUnknown) {
        Eigen::VectorXd out(3 * block);
        for (Eigen::Index a = 0; a < features_; ++a)
            for (Eigen::Index k = 0; k < dimension(); ++k) out(placeOf(k, a)) = byUnknown(k, a);
        return out;
    };
    const auto preconditioned = [&](const Eigen::VectorXd& v) {
        Eigen::VectorXd out(v.size());
        for (Eigen::Index c = 0; c < 3; ++c)
            out.segment(block * c, block) = inverse[static_cast<std::size_t>(c)].solve(v.segment(block * c, block));
        return out;
    };
    const Eigen::VectorXd start = stacked(factors);
    // The ridge draws towards the start, so the change has no ridge on its right-hand side.
    Eigen::VectorXd change = Eigen::VectorXd::Zero(start.size());
    Eigen::VectorXd left = stacked(right_.transpose()) - matrix * start;
    for (Eigen::Index c = 0; c < 3; ++c) {
        const auto own = matrix.block(block * c, block * c, block, block);
        const double pull = ridge / (1 + ridge) * own.trace() / static_cast<double>(block);
        left.segment(block * c, block) += pull * start.segment(block * c, block);
    }
    Eigen::VectorXd step = preconditioned(left), direction = step;
    double gain = left.dot(step);
    const double enough = 1e-8 * gain;
    for (int i = 0; i < steps && gain > enough; ++i) {
        const Eigen::VectorXd turned = matrix * direction;
        const double length = gain / direction.dot(turned);
        if (!std::isfinite(length)) break;
        change += length * direction;
        left -= length * turned;
        step = preconditioned(left);
        const double next = left.dot(step);
        direction = step + next / gain * direction;
        gain = next;
    }
    if (!change.allFinite()) return;
    for (Eigen::Index a = 0; a < features_; ++a)
        for (Eigen::Index k = 0; k < dimension(); ++k) factors(k, a) += change(placeOf(k, a));
}

}  // namespace lightcook::compress

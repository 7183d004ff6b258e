#include "compress/light_map/basis/clusters.h"

#include <hwy/highway.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cassert>
#include <functional>
#include <numeric>
#include <optional>

#include "compress/light_map/basis/parallel.h"

namespace lightcook::compress {

namespace {

// Eigen cuts products by the caches that it finds, and each cut adds in another order: learned layouts had other bytes on a machine with
// 32 KiB of first level than on one with 48 KiB. These sizes are for all products of the program.
[[maybe_unused]] const bool kHasFixedBlocks = [] {
    Eigen::setCpuCacheSizes(kProductCaches[0], kProductCaches[1], kProductCaches[2]);
    return true;
}();

// No dynamic dispatch: lanes hold different points, and each sum adds its products in one order.
namespace hn = hwy::HWY_NAMESPACE;
using ChartPointTag = hn::CappedTag<float, 8>;
using ChartPointLanes = hn::Vec<ChartPointTag>;

/// Returns the products of `kRows` rows with all points. Each is the sum of the products of even numbers plus that of the odd ones.
/// byNumber  the points transposed, and padded to whole registers
template <std::size_t kRows>
Eigen::MatrixXf productsOf(const Eigen::MatrixXf& rows, const Eigen::MatrixXf& byNumber, Eigen::Index count) {
    constexpr ChartPointTag tag;
    constexpr std::size_t kLanes = hn::MaxLanes(tag);
    Eigen::MatrixXf out(rows.rows(), count);
    std::array<std::array<float, kLanes>, kRows> products;
    for (Eigen::Index point = 0; point < count; point += static_cast<Eigen::Index>(kLanes)) {
        ChartPointLanes sums[kRows][2];
        for (auto& [even, odd] : sums) even = odd = hn::Zero(tag);
        for (Eigen::Index k = 0; k < rows.cols(); k += 2)
            for (Eigen::Index s = 0; s < 2; ++s) {
                const ChartPointLanes values = hn::LoadU(tag, &byNumber(point, k + s));
                for (std::size_t r = 0; r < kRows; ++r)
                    sums[r][s] = hn::Add(sums[r][s], hn::Mul(hn::Set(tag, rows(static_cast<Eigen::Index>(r), k + s)), values));
            }
        for (std::size_t r = 0; r < kRows; ++r) hn::StoreU(hn::Add(sums[r][0], sums[r][1]), tag, products[r].data());
        const std::size_t here = std::min(kLanes, static_cast<std::size_t>(count - point));
        for (std::size_t p = 0; p < here; ++p)
            for (std::size_t r = 0; r < kRows; ++r)
                out(static_cast<Eigen::Index>(r), point + static_cast<Eigen::Index>(p)) = products[r][p];
    }
    return out;
}
Eigen::MatrixXf productsOf(const Eigen::MatrixXf& rows, const Eigen::MatrixXf& byNumber, Eigen::Index count) {
    // A mean, and a direction for each number of a code.
    return rows.rows() == 4 ? productsOf<4>(rows, byNumber, count) : productsOf<5>(rows, byNumber, count);
}

/// Points, and what costs() needs of them.
struct CostPoints {
    Eigen::MatrixXf byNumber;  ///< transposed, and padded to whole registers
    Eigen::VectorXf squaredNorms, weights;

    CostPoints(const Eigen::MatrixXf& points, const Eigen::VectorXf& weightsOfPoints, const Eigen::VectorXf& norms)
        : squaredNorms(norms), weights(weightsOfPoints) {
        constexpr Eigen::Index kWhole = 8;
        byNumber = Eigen::MatrixXf::Zero((points.cols() + kWhole - 1) / kWhole * kWhole, points.rows());
        byNumber.topRows(points.cols()) = points.transpose();
    }
};

/// Returns the cost of each point under a subspace, |p - mean|^2 - |directions' (p - mean)|^2.
Eigen::VectorXf costs(const CostPoints& points, const Subspace& subspace) {
    Eigen::MatrixXf rows(subspace.directions.cols() + 1, points.byNumber.cols());
    rows << subspace.mean.transpose(), subspace.directions.transpose();
    assert(rows.cols() % 2 == 0 && (rows.rows() == 4 || rows.rows() == 5));
    const Eigen::MatrixXf products = productsOf(rows, points.byNumber, points.weights.size());
    const Eigen::VectorXf offsets = subspace.directions.transpose() * subspace.mean;
    Eigen::VectorXf residual = points.squaredNorms - 2 * products.row(0).transpose();
    residual.array() += subspace.mean.squaredNorm();
    residual -= (products.bottomRows(offsets.size()).colwise() - offsets).colwise().squaredNorm().transpose();
    return residual.cwiseMax(0.0f).cwiseProduct(points.weights);
}

/// Returns the points minus their mean, so that the squares that costs() subtracts are not much larger than their differences.
ChartPoints centred(const ChartPoints& points) {
    ChartPoints out = points;
    const float weight = points.weights.sum();
    if (weight > 0) out.points.colwise() -= Eigen::VectorXf(points.points * points.weights / weight);
    return out;
}

class Clusters {
public:
    Clusters(const ChartPoints& points, int dimension)
        : points_(centred(points)),
          squaredNorms_(points_.points.colwise().squaredNorm().transpose()),
          costPoints_(points_.points, points_.weights, squaredNorms_),
          dimension_(dimension),
          clusterOf_(static_cast<std::size_t>(points.chartCount), 0),
          ownCosts_(clusterOf_.size(), -1),
          pointsOfChart_(clusterOf_.size()),
          total_(static_cast<double>(points.weights.dot(points.points.colwise().squaredNorm().transpose()))) {
        for (std::size_t i = 0; i < points.chartOf.size(); ++i)
            pointsOfChart_[static_cast<std::size_t>(points.chartOf[i])].push_back(static_cast<Eigen::Index>(i));
    }

    void grow(int clusterCount) {
        constexpr int kRounds = 4;
        addCluster({});
        while (static_cast<int>(chartCosts_.size()) < clusterCount) {
            const int seed = bestSeed();
            if (seed < 0) break;
            addCluster(seed);
            round();
        }
        for (int i = 0; i < kRounds && chartCosts_.size() > 1; ++i)
            if (!round()) break;
    }

    /// Returns the cluster of each chart, numbered without gaps in the order of the charts.
    std::vector<int> result() const {
        std::vector<int> names(chartCosts_.size(), -1);
        int next = 0;
        std::vector<int> out;
        for (const int cluster : clusterOf_) {
            int& name = names[static_cast<std::size_t>(cluster)];
            if (name < 0) name = next++;
            out.push_back(name);
        }
        return out;
    }

private:
    double cost(int chart, std::size_t cluster) const { return chartCosts_[cluster][static_cast<std::size_t>(chart)]; }

    /// Returns the chart that gains most from a subspace of its own, or -1 if the gain is only rounding.
    int bestSeed() {
        std::vector<int> charts(clusterOf_.size());
        std::iota(charts.begin(), charts.end(), 0);
        const auto costNow = [&](int chart) { return cost(chart, static_cast<std::size_t>(clusterOf_[static_cast<std::size_t>(chart)])); };
        std::ranges::stable_sort(charts, std::greater(), costNow);
        int best = -1;
        double largestGain = 1e-6 * total_;
        for (const int chart : charts) {
            if (costNow(chart) <= largestGain) break;  // no chart after this one can gain more
            const double gain = costNow(chart) - ownCost(chart);
            if (gain <= largestGain) continue;
            best = chart;
            largestGain = gain;
        }
        return best;
    }
    /// Returns the cost of a chart under the subspace fitted to it alone.
    double ownCost(int chart) {
        double& known = ownCosts_[static_cast<std::size_t>(chart)];
        if (known >= 0) return known;
        const std::vector<Eigen::Index>& members = pointsOfChart_[static_cast<std::size_t>(chart)];
        const Eigen::MatrixXf own = points_.points(Eigen::all, members);
        const CostPoints costPoints(own, points_.weights(members), squaredNorms_(members));
        known = static_cast<double>(costs(costPoints, fitSubspace(own, costPoints.weights, dimension_, true)).sum());
        return known;
    }

    /// Adds a cluster of one chart, or of all charts.
    void addCluster(std::optional<int> chart) {
        chartCosts_.emplace_back(static_cast<std::size_t>(points_.chartCount));
        fit(chartCosts_.size() - 1, [&](int other) { return !chart || other == *chart; });
    }

    /// Fits a cluster to the charts with isMember(chart), and computes the costs of all charts under it.
    template <class IsMember>
    void fit(std::size_t cluster, IsMember isMember) {
        std::vector<Eigen::Index> members;
        for (std::size_t i = 0; i < points_.chartOf.size(); ++i)
            if (isMember(points_.chartOf[i])) members.push_back(static_cast<Eigen::Index>(i));
        if (members.empty()) return;
        const Eigen::MatrixXf own = points_.points(Eigen::all, members);
        const Eigen::VectorXf weights = points_.weights(members);
        const Eigen::VectorXf pointCosts = costs(costPoints_, fitSubspace(own, weights, dimension_, true));
        std::ranges::fill(chartCosts_[cluster], 0.0);
        for (std::size_t i = 0; i < points_.chartOf.size(); ++i)
            chartCosts_[cluster][static_cast<std::size_t>(points_.chartOf[i])] +=
                static_cast<double>(pointCosts(static_cast<Eigen::Index>(i)));
    }

    /// Moves each chart to its cheapest cluster and fits the changed clusters again. Returns false if no chart moved.
    bool round() {
        std::vector<bool> changed(chartCosts_.size(), false);
        for (int chart = 0; chart < points_.chartCount; ++chart) {
            int& own = clusterOf_[static_cast<std::size_t>(chart)];
            int best = own;
            for (std::size_t cluster = 0; cluster < chartCosts_.size(); ++cluster)
                if (cost(chart, cluster) < cost(chart, static_cast<std::size_t>(best))) best = static_cast<int>(cluster);
            if (best == own) continue;
            changed[static_cast<std::size_t>(own)] = changed[static_cast<std::size_t>(best)] = true;
            own = best;
        }
        forEachInParallel(changed.size(), [&](std::size_t cluster) {
            if (changed[cluster])
                fit(cluster, [&](int chart) { return clusterOf_[static_cast<std::size_t>(chart)] == static_cast<int>(cluster); });
        });
        return std::ranges::find(changed, true) != changed.end();
    }

    ChartPoints points_;
    Eigen::VectorXf squaredNorms_;  ///< [point]
    CostPoints costPoints_;
    int dimension_;
    std::vector<int> clusterOf_;
    std::vector<std::vector<double>> chartCosts_;  ///< [cluster][chart]
    std::vector<double> ownCosts_;                 ///< [chart], -1 if not computed yet
    std::vector<std::vector<Eigen::Index>> pointsOfChart_;
    double total_;  ///< weighted sum of the squared points: scale of the rounding error
};

}  // namespace

Subspace fitSubspace(const Eigen::MatrixXf& points, const Eigen::VectorXf& weights, int dimension, bool isCentred) {
    const Eigen::MatrixXd wide = points.cast<double>();
    const Eigen::VectorXd shares = weights.cast<double>() / std::max(static_cast<double>(weights.sum()), 1e-300);
    Eigen::VectorXd mean = Eigen::VectorXd::Zero(points.rows());
    if (isCentred) mean = wide * shares;
    const Eigen::MatrixXd centred = wide.colwise() - mean;
    const Eigen::MatrixXd covariance = centred * shares.asDiagonal() * centred.transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(covariance);
    // Eigenvalues come in ascending order.
    return {mean.cast<float>(), solver.eigenvectors().rightCols(dimension).rowwise().reverse().cast<float>(),
            solver.eigenvalues().tail(dimension).reverse().cwiseMax(0.0).cwiseSqrt().cast<float>()};
}

std::vector<int> clusterCharts(const ChartPoints& points, int dimension, int clusterCount) {
    Clusters clusters(points, dimension);
    clusters.grow(std::min(clusterCount, points.chartCount));
    return clusters.result();
}

}  // namespace lightcook::compress

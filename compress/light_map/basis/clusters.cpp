#include "compress/light_map/basis/clusters.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <functional>
#include <numeric>
#include <optional>

namespace lightcook::compress {

namespace {

/// What each point costs under a subspace: |p - mean|^2 less what the directions take of it, by one product with all points.
Eigen::VectorXf costs(const ChartPoints& points, const Eigen::VectorXf& squaredNorms, const Subspace& subspace) {
    Eigen::MatrixXf rows(subspace.directions.cols() + 1, points.points.rows());
    rows << subspace.mean.transpose(), subspace.directions.transpose();
    const Eigen::MatrixXf products = rows * points.points;
    const Eigen::VectorXf offsets = subspace.directions.transpose() * subspace.mean;
    Eigen::VectorXf missed = squaredNorms - 2 * products.row(0).transpose();
    missed.array() += subspace.mean.squaredNorm();
    missed -= (products.bottomRows(offsets.size()).colwise() - offsets).colwise().squaredNorm().transpose();
    return missed.cwiseMax(0.0f).cwiseProduct(points.weights);
}

/// Around their mean, so that the squares above are of differences.
ChartPoints aroundTheirMean(const ChartPoints& points) {
    ChartPoints centred = points;
    const float weight = points.weights.sum();
    if (weight > 0) centred.points.colwise() -= Eigen::VectorXf(points.points * points.weights / weight);
    return centred;
}

class Clusters {
public:
    Clusters(const ChartPoints& points, int dimension)
        : points_(aroundTheirMean(points)),
          squaredNorms_(points_.points.colwise().squaredNorm().transpose()),
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
            const int worst = worstChart();
            if (worst < 0) break;
            addCluster(worst);
            round();
        }
        for (int i = 0; i < kRounds && chartCosts_.size() > 1; ++i)
            if (!round()) break;
    }

    /// Numbers without gaps.
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

    /// The chart that would gain most from a subspace of its own; none where that is nothing but rounding.
    int worstChart() {
        std::vector<int> charts(clusterOf_.size());
        std::iota(charts.begin(), charts.end(), 0);
        const auto costNow = [&](int chart) { return cost(chart, static_cast<std::size_t>(clusterOf_[static_cast<std::size_t>(chart)])); };
        std::ranges::stable_sort(charts, std::greater(), costNow);
        int worst = -1;
        double largestGain = 1e-6 * total_;
        for (const int chart : charts) {
            if (costNow(chart) <= largestGain) break;  // no chart after this one can gain more
            const double gain = costNow(chart) - ownCost(chart);
            if (gain <= largestGain) continue;
            worst = chart;
            largestGain = gain;
        }
        return worst;
    }
    /// A chart's cost under the subspace that fits it best.
    double ownCost(int chart) {
        double& known = ownCosts_[static_cast<std::size_t>(chart)];
        if (known >= 0) return known;
        const std::vector<Eigen::Index>& members = pointsOfChart_[static_cast<std::size_t>(chart)];
        ChartPoints own;
        own.points = points_.points(Eigen::all, members);
        own.weights = points_.weights(members);
        known = static_cast<double>(costs(own, squaredNorms_(members), fitSubspace(own.points, own.weights, dimension_, true)).sum());
        return known;
    }

    /// A new cluster of one chart, or of all of them.
    void addCluster(std::optional<int> chart) {
        chartCosts_.emplace_back(static_cast<std::size_t>(points_.chartCount));
        fit(chartCosts_.size() - 1, [&](int other) { return !chart || other == *chart; });
    }

    template <class IsMember>
    void fit(std::size_t cluster, IsMember isMember) {
        std::vector<Eigen::Index> members;
        for (std::size_t i = 0; i < points_.chartOf.size(); ++i)
            if (isMember(points_.chartOf[i])) members.push_back(static_cast<Eigen::Index>(i));
        if (members.empty()) return;
        const Eigen::MatrixXf own = points_.points(Eigen::all, members);
        const Eigen::VectorXf weights = points_.weights(members);
        const Eigen::VectorXf missed = costs(points_, squaredNorms_, fitSubspace(own, weights, dimension_, true));
        std::ranges::fill(chartCosts_[cluster], 0.0);
        for (std::size_t i = 0; i < points_.chartOf.size(); ++i)
            chartCosts_[cluster][static_cast<std::size_t>(points_.chartOf[i])] += static_cast<double>(missed(static_cast<Eigen::Index>(i)));
    }

    /// Every chart to its best cluster, every changed cluster fitted again. False where nothing moved.
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
        bool any = false;
        for (std::size_t cluster = 0; cluster < changed.size(); ++cluster) {
            if (!changed[cluster]) continue;
            any = true;
            fit(cluster, [&](int chart) { return clusterOf_[static_cast<std::size_t>(chart)] == static_cast<int>(cluster); });
        }
        return any;
    }

    ChartPoints points_;
    Eigen::VectorXf squaredNorms_;  ///< [point]
    int dimension_;
    std::vector<int> clusterOf_;
    std::vector<std::vector<double>> chartCosts_;  ///< [cluster][chart]
    std::vector<double> ownCosts_;                 ///< [chart], -1 where not known yet
    std::vector<std::vector<Eigen::Index>> pointsOfChart_;
    double total_;  ///< what all points cost under no subspace at all
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

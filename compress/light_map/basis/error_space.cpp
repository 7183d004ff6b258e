#include "compress/light_map/basis/error_space.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace lightcook::compress {

ErrorSpace::ErrorSpace(const BasisSample& sample, const std::vector<SampleTexel*>& members, int firstCoefficient)
    : first_(firstCoefficient), size_(9 - firstCoefficient), root_(Eigen::Matrix<float, 9, 9>::Zero()) {
    Eigen::Matrix<double, 9, 9> sum = Eigen::Matrix<double, 9, 9>::Identity() * 1e-30;
    std::array<double, 3> light = {1e-30, 1e-30, 1e-30};
    for (const SampleTexel* texel : members) {
        const Metric& metric = sample.metricOf(*texel);
        const double weight = static_cast<double>(texel->totalWeight());
        for (int i = 0; i < 9; ++i)
            for (int j = 0; j < 9; ++j)
                sum(i, j) += weight * static_cast<double>(metric[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)]);
        for (std::size_t c = 0; c < 3; ++c) light[c] += static_cast<double>(texel->weight * texel->light[c]);
    }
    sum /= sum.trace();
    sum += Eigen::Matrix<double, 9, 9>::Identity() * 1e-5;
    const double all = light[0] + light[1] + light[2];
    const Eigen::MatrixXd part = sum.bottomRightCorner(size_, size_);
    root_.bottomRightCorner(size_, size_) = Eigen::MatrixXd(part.llt().matrixU()).cast<float>();
    for (std::size_t c = 0; c < 3; ++c) channel_[c] = static_cast<float>(std::sqrt(light[c] / all + 1e-6));
}

Eigen::VectorXf ErrorSpace::pointOf(const ByChannel& ratio) const {
    Eigen::VectorXf out(dimension());
    for (std::size_t c = 0; c < 3; ++c) {
        const Eigen::Map<const Eigen::Matrix<float, 9, 1>> r(ratio[c].data());
        const Eigen::VectorXf turned = root_.bottomRightCorner(size_, size_) * r.tail(size_);
        out.segment(static_cast<Eigen::Index>(c) * size_, size_) = channel_[c] * turned;
    }
    return out;
}

ByChannel ErrorSpace::ratioOf(const Eigen::VectorXf& point) const {
    ByChannel out{};
    for (std::size_t c = 0; c < 3; ++c) {
        const Eigen::VectorXf r = root_.bottomRightCorner(size_, size_)
                                      .triangularView<Eigen::Upper>()
                                      .solve(point.segment(static_cast<Eigen::Index>(c) * size_, size_)) /
                                  channel_[c];
        for (Eigen::Index i = 0; i < size_; ++i) out[c][static_cast<std::size_t>(first_ + i)] = r(i);
    }
    return out;
}

SamplePoints pointsOf(const ErrorSpace& space, const std::vector<SampleTexel*>& members) {
    SamplePoints out;
    out.points.resize(space.dimension(), static_cast<Eigen::Index>(members.size()));
    out.weights.resize(static_cast<Eigen::Index>(members.size()));
    for (std::size_t i = 0; i < members.size(); ++i) {
        out.points.col(static_cast<Eigen::Index>(i)) = space.pointOf(members[i]->ratio);
        out.weights(static_cast<Eigen::Index>(i)) = members[i]->totalWeight();
    }
    return out;
}

}  // namespace lightcook::compress

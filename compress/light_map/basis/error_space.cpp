#include "compress/light_map/basis/error_space.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace lightcook::compress {

ErrorSpace::ErrorSpace(const std::vector<SampleTexel*>& members, int firstCoefficient)
    : first_(firstCoefficient), size_(9 - firstCoefficient) {
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(dimension(), dimension());
    const auto first = static_cast<std::size_t>(first_), size = static_cast<std::size_t>(size_);
    for (const SampleTexel* texel : members) {
        const auto weight = static_cast<double>(texel->weight);
        const ErrorForm form = texel->form.unpacked();
        for (std::size_t c = 0; c < 3; ++c)
            for (std::size_t d = 0; d < 3; ++d) {
                const double scale = weight * static_cast<double>(texel->dc[static_cast<int>(c)] * texel->dc[static_cast<int>(d)]);
                for (std::size_t i = 0; i < size; ++i)
                    for (std::size_t j = 0; j < size; ++j)
                        sum(static_cast<Eigen::Index>(c * size + i), static_cast<Eigen::Index>(d * size + j)) +=
                            scale * static_cast<double>(form.of(c, d)[first + i][first + j]);
            }
    }
    sum += Eigen::MatrixXd::Identity(dimension(), dimension()) * (1e-5 * sum.trace() / static_cast<double>(dimension()) + 1e-30);
    sum /= sum.trace();
    root_ = Eigen::MatrixXd(sum.llt().matrixU()).cast<float>();
}

Eigen::VectorXf ErrorSpace::pointOf(const ByChannel& ratio) const {
    Eigen::VectorXf stacked(dimension());
    for (std::size_t c = 0; c < 3; ++c) {
        const Eigen::Map<const Eigen::Matrix<float, 9, 1>> r(ratio[c].data());
        stacked.segment(static_cast<Eigen::Index>(c) * size_, size_) = r.tail(size_);
    }
    return root_.triangularView<Eigen::Upper>() * stacked;
}

ByChannel ErrorSpace::ratioOf(const Eigen::VectorXf& point) const {
    ByChannel out{};
    const Eigen::VectorXf stacked = root_.triangularView<Eigen::Upper>().solve(point);
    for (std::size_t c = 0; c < 3; ++c)
        for (Eigen::Index i = 0; i < size_; ++i)
            out[c][static_cast<std::size_t>(first_ + i)] = stacked(static_cast<Eigen::Index>(c) * size_ + i);
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

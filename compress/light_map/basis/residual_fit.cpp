#include "compress/light_map/basis/residual_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "compress/light_map/basis/clusters.h"
#include "compress/light_map/basis/code_fit.h"
#include "compress/light_map/basis/error_space.h"

namespace lightcook::compress {

namespace {

constexpr std::size_t kCount = lighting::kShCount;

ResidualTable principalDirections(const BasisSample& sample, const std::vector<SampleTexel*>& members) {
    ResidualTable table{};
    if (members.empty()) return table;
    const ErrorSpace space(sample, members, 0);
    const SamplePoints points = pointsOf(space, members);
    const Subspace subspace = fitSubspace(points.points, points.weights, 4, false);
    const Eigen::MatrixXf coordinates = subspace.directions.transpose() * points.points;
    for (int k = 0; k < 4; ++k) {
        const float reach = std::min(coordinates.row(k).cwiseAbs().maxCoeff(), kRangeDeviations * subspace.deviations(k));
        // The shorter side of the box, 127/255 long, has to hold `reach`.
        const ByChannel direction = space.ratioOf(subspace.directions.col(k) * (reach / (1 - kResidualNeutral)));
        for (std::size_t c = 0; c < 3; ++c)
            for (std::size_t i = 0; i < kCount; ++i)
                table[static_cast<std::size_t>(k)][c][i] = roundedToHalf(static_cast<double>(direction[c][i]));
    }
    return table;
}

/// Fits the directions to the texels' codes by least squares, with a ridge towards the directions given, for channels that the codes hardly
/// use.
void fitDirections(const std::vector<SampleTexel*>& members, ResidualTable& table) {
    for (std::size_t c = 0; c < 3; ++c) {
        Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
        Eigen::Matrix<double, 4, 9> right = Eigen::Matrix<double, 4, 9>::Zero();
        for (const SampleTexel* texel : members) {
            Eigen::Vector4d b;
            for (int k = 0; k < 4; ++k) b(k) = static_cast<double>(texel->code[k] - kResidualNeutral);
            const double weight = static_cast<double>(texel->weight * texel->light[c]);
            normal += weight * b * b.transpose();
            for (int i = 0; i < 9; ++i) right.col(i) += (weight * static_cast<double>(texel->ratio[c][static_cast<std::size_t>(i)])) * b;
        }
        const double ridge = 1e-4 * normal.trace() / 4 + 1e-300;
        for (int k = 0; k < 4; ++k) {
            normal(k, k) += ridge;
            for (int i = 0; i < 9; ++i)
                right(k, i) += ridge * static_cast<double>(table[static_cast<std::size_t>(k)][c][static_cast<std::size_t>(i)]);
        }
        const Eigen::Matrix<double, 4, 9> solved = normal.ldlt().solve(right);
        if (!solved.allFinite()) continue;
        for (int k = 0; k < 4; ++k)
            for (int i = 0; i < 9; ++i) table[static_cast<std::size_t>(k)][c][static_cast<std::size_t>(i)] = roundedToHalf(solved(k, i));
    }
}

}  // namespace

void addResidualLayer(BasisSample& sample, BasisModel& model) {
    std::vector<ResidualTable> tables;
    for (const std::vector<SampleTexel*>& members : sample.clusters()) tables.push_back(principalDirections(sample, members));
    const auto tableOf = [&](const SampleTexel& texel) -> const ResidualTable& { return tables[static_cast<std::size_t>(texel.cluster)]; };
    for (SampleTexel& texel : sample.texels()) texel.code = solveResidual(tableOf(texel), sample.targetOf(texel));
    glm::dvec4 sensitivity(0);
    for (const SampleTexel& texel : sample.texels())
        sensitivity += static_cast<double>(texel.weight) * glm::dvec4(residualSensitivity(tableOf(texel), sample.targetOf(texel)));
    model.residualWeights.push_back(channelWeightsOf(sensitivity));
    sample.encodeCodes(2, model.residualWeights.back());
    for (std::size_t cluster = 0; cluster < tables.size(); ++cluster) fitDirections(sample.clusters()[cluster], tables[cluster]);
    for (SampleTexel& texel : sample.texels()) subtractResidual(tableOf(texel), texel.code, texel.ratio);
    model.residual.push_back(std::move(tables));
}

}  // namespace lightcook::compress

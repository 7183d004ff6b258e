#include "compress/light_map/basis/residual_fit.h"

#include <algorithm>

#include "compress/light_map/basis/clusters.h"
#include "compress/light_map/basis/code_fit.h"
#include "compress/light_map/basis/error_space.h"
#include "compress/light_map/basis/form_regression.h"
#include "compress/light_map/basis/parallel.h"

namespace lightcook::compress {

namespace {

constexpr int kRounds = 1;  ///< fits of the directions before the block encoder

ResidualTable principalDirections(const std::vector<SampleTexel*>& members) {
    ResidualTable table{};
    if (members.empty()) return table;
    const ErrorSpace space(members, 0);
    const SamplePoints points = pointsOf(space, members);
    const Subspace subspace = fitSubspace(points.points, points.weights, 4, false);
    const Eigen::MatrixXf coordinates = subspace.directions.transpose() * points.points;
    for (int k = 0; k < 4; ++k) {
        const float reach = std::min(coordinates.row(k).cwiseAbs().maxCoeff(), kRangeDeviations * subspace.deviations(k));
        // The shorter side of the box, 127/255 long, has to hold `reach`.
        const ByChannel direction = space.ratioOf(subspace.directions.col(k) * (reach / (1 - kResidualNeutral)));
        for (std::size_t c = 0; c < 3; ++c)
            for (std::size_t i = 0; i < kCoefficientCount; ++i)
                table[static_cast<std::size_t>(k)][c][i] = roundedToHalf(static_cast<double>(direction[c][i]));
    }
    return table;
}

/// Fits the directions to the texels' codes, with a ridge towards the directions given, for channels that the codes hardly use.
void fitDirections(const std::vector<SampleTexel*>& members, ResidualTable& table) {
    constexpr int kSteps = 20;
    constexpr double kRidge = 1e-4;
    FormRegression regression(4, 0);
    Eigen::VectorXd features(4), products(10);
    for (const SampleTexel* texel : members) {
        for (int k = 0; k < 4; ++k) features(k) = static_cast<double>(texel->code[k] - kResidualNeutral);
        for (Eigen::Index a = 0, i = 0; a < 4; ++a)
            for (Eigen::Index b = 0; b <= a; ++b) products(i++) = features(a) * features(b);
        regression.add(BasisSample::targetOf(*texel), static_cast<double>(texel->weight), features, products);
    }
    // [coefficient 1 to 8 of r, g, b, then coefficients 0][channel of the texel]
    Eigen::MatrixXd factors(27, 4);
    const auto numberOf = [&](Eigen::Index i, Eigen::Index k) -> float& {
        ByChannel& direction = table[static_cast<std::size_t>(k)];
        return i < 24 ? direction[static_cast<std::size_t>(i / 8)][static_cast<std::size_t>(i % 8) + 1]
                      : direction[static_cast<std::size_t>(i - 24)][0];
    };
    for (Eigen::Index k = 0; k < 4; ++k)
        for (Eigen::Index i = 0; i < 27; ++i) factors(i, k) = static_cast<double>(numberOf(i, k));
    regression.solve(factors, kSteps, kRidge);
    for (Eigen::Index k = 0; k < 4; ++k)
        for (Eigen::Index i = 0; i < 27; ++i) numberOf(i, k) = roundedToHalf(factors(i, k));
}

}  // namespace

void addResidualLayer(BasisSample& sample, BasisModel& model) {
    std::vector<ResidualTable> tables(sample.clusters().size());
    forEachInParallel(tables.size(), [&](std::size_t cluster) { tables[cluster] = principalDirections(sample.clusters()[cluster]); });
    const auto tableOf = [&](const SampleTexel& texel) -> const ResidualTable& { return tables[static_cast<std::size_t>(texel.cluster)]; };
    const auto solveTexels = [&] {
        forEachInParallel(sample.texels().size(), [&](std::size_t i) {
            SampleTexel& texel = sample.texels()[i];
            texel.code = solveResidual(tableOf(texel), BasisSample::targetOf(texel));
        });
    };
    const auto fitTables = [&] {
        forEachInParallel(tables.size(), [&](std::size_t cluster) { fitDirections(sample.clusters()[cluster], tables[cluster]); });
    };
    solveTexels();
    for (int round = 0; round < kRounds; ++round) {
        fitTables();
        solveTexels();
    }
    glm::dvec4 sensitivity(0);
    for (const SampleTexel& texel : sample.texels())
        sensitivity += static_cast<double>(texel.weight) * glm::dvec4(residualSensitivity(tableOf(texel), BasisSample::targetOf(texel)));
    model.residualWeights.push_back(channelWeightsOf(sensitivity));
    sample.encodeCodes(2, model.residualWeights.back());
    fitTables();
    for (SampleTexel& texel : sample.texels()) subtractResidual(tableOf(texel), texel.code, texel.ratio);
    model.residual.push_back(std::move(tables));
}

}  // namespace lightcook::compress

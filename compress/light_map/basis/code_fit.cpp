#include "compress/light_map/basis/code_fit.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "compress/light_map/basis/clusters.h"
#include "compress/light_map/basis/code_solver.h"
#include "compress/light_map/basis/error_space.h"
#include "compress/light_map/basis/parallel.h"
#include "compress/light_map/basis/table_fit.h"

namespace lightcook::compress {

namespace {

constexpr int kRounds = 6, kEncodeRounds = 2;
constexpr float kDeviationsAcross = 12;
constexpr std::size_t kSeeds = 16;  ///< seeds that lie far apart, and as many that are spaced evenly: see chooseSeeds()

class CodeFitter {
public:
    CodeFitter(BasisSample& sample, BasisModel& model) : sample_(sample), model_(model) {}

    void run() {
        startCodes();
        for (int round = 0; round < kRounds; ++round) fitTablesAndCodes();
        stretchCodes();
        fitTablesAndCodes();
        for (int round = 0; round < kEncodeRounds; ++round) {
            encodeCodes();
            fitTablesAndCodes();
        }
        encodeCodes();
        chooseSeeds();
        solveCoefficients0();
        sample_.encodeDc();
        subtractCodes();
    }

private:
    /// Sets the codes of each cluster to the principal coordinates of its ratios.
    void startCodes() {
        for (const std::vector<SampleTexel*>& members : sample_.clusters()) {
            if (members.empty()) continue;
            const SamplePoints points = pointsOf(ErrorSpace(members, 1), members);
            const Subspace subspace = fitSubspace(points.points, points.weights, model_.shape.codeChannels, true);
            const Eigen::MatrixXf coordinates = subspace.directions.transpose() * (points.points.colwise() - subspace.mean);
            for (std::size_t i = 0; i < members.size(); ++i)
                for (int k = 0; k < model_.shape.codeChannels; ++k) {
                    const float unit = kDeviationsAcross * std::max(subspace.deviations(k), 1e-12f);
                    members[i]->code[k] = std::clamp(0.5f + coordinates(k, static_cast<Eigen::Index>(i)) / unit, 0.0f, 1.0f);
                }
        }
    }

    /// Fits the tables to the codes, then the codes and coefficients 0 to the tables.
    void fitTablesAndCodes() {
        forEachInParallel(sample_.clusters().size(),
                          [&](std::size_t cluster) { fitTable(sample_.clusters()[cluster], model_.shape, model_.code[cluster]); });
        forEachCluster([](const std::vector<SampleTexel*>& members, const CodeSpace& space) {
            forEachInParallel(members.size(), [&](std::size_t i) {
                SampleTexel& texel = *members[i];
                texel.code = space.solve(BasisSample::targetOf(texel), texel.code).code;
            });
        });
        solveCoefficients0();
    }

    /// Sets the coefficients 0 to those that suit the codes best.
    void solveCoefficients0() {
        forEachInParallel(sample_.texels().size(), [&](std::size_t i) {
            SampleTexel& texel = sample_.texels()[i];
            const HigherByChannel decode = evaluateCode(tableOf(texel), model_.shape.monomialCount(), texel.code);
            BasisSample::setDc(texel, solveDc(texel.form.unpacked(), texel.light, decode));
        });
    }

    const CodeTable& tableOf(const SampleTexel& texel) const { return model_.code[static_cast<std::size_t>(texel.cluster)]; }

    /// Calls visit(texels, decode) for each cluster in turn.
    template <class Visit>
    void forEachCluster(Visit visit) {
        for (std::size_t cluster = 0; cluster < sample_.clusters().size(); ++cluster)
            visit(sample_.clusters()[cluster], CodeSpace(model_.code[cluster], model_.shape));
    }

    /// Stretches each channel of the codes of a cluster to [0, 1].
    void stretchCodes() {
        for (const std::vector<SampleTexel*>& members : sample_.clusters())
            for (int k = 0; k < model_.shape.codeChannels; ++k) stretchChannel(members, k);
    }
    static void stretchChannel(const std::vector<SampleTexel*>& members, int k) {
        double sum = 0, first = 0, second = 0;
        float low = 1, high = 0;
        for (const SampleTexel* texel : members) {
            const double weight = static_cast<double>(texel->totalWeight()), value = static_cast<double>(texel->code[k]);
            sum += weight;
            first += weight * value;
            second += weight * value * value;
            low = std::min(low, texel->code[k]);
            high = std::max(high, texel->code[k]);
        }
        if (!(sum > 0)) return;
        const double mean = first / sum, deviation = std::sqrt(std::max(second / sum - mean * mean, 0.0));
        low = std::max(low, static_cast<float>(mean - static_cast<double>(kRangeDeviations) * deviation));
        high = std::min(high, static_cast<float>(mean + static_cast<double>(kRangeDeviations) * deviation));
        const float span = std::max(high - low, 1e-6f);
        for (SampleTexel* texel : members) texel->code[k] = std::clamp((texel->code[k] - low) / span, 0.0f, 1.0f);
    }

    /// Updates the channel weights and sends the codes through the block encoder.
    void encodeCodes() {
        glm::dvec4 sensitivity(0);
        forEachCluster([&](const std::vector<SampleTexel*>& members, const CodeSpace& space) {
            for (const SampleTexel* texel : members)
                sensitivity +=
                    static_cast<double>(texel->weight) * glm::dvec4(space.sensitivity(BasisSample::targetOf(*texel), texel->code));
        });
        model_.codeWeights = channelWeightsOf(sensitivity);
        sample_.encodeCodes(1, model_.codeWeights);
    }

    /// Chooses codes of each cluster to start a search from. Half of them lie far apart: each is the farthest from all before it. The
    /// others are spaced evenly over the sample, so that most lie where most texels do.
    void chooseSeeds() {
        model_.seeds.resize(sample_.clusters().size());
        for (std::size_t cluster = 0; cluster < model_.seeds.size(); ++cluster) {
            const std::vector<SampleTexel*>& members = sample_.clusters()[cluster];
            std::vector<glm::vec4>& seeds = model_.seeds[cluster];
            std::vector<float> distance(members.size(), 1e30f);
            while (seeds.size() < kSeeds && seeds.size() < members.size()) {
                const auto farthest = static_cast<std::size_t>(std::ranges::max_element(distance) - distance.begin());
                if (!(distance[farthest] > 0)) break;
                seeds.push_back(members[farthest]->code);
                for (std::size_t i = 0; i < members.size(); ++i) {
                    const glm::vec4 apart = members[i]->code - seeds.back();
                    distance[i] = std::min(distance[i], glm::dot(apart, apart));
                }
            }
            for (std::size_t i = 0; i < kSeeds && members.size() > kSeeds; ++i) seeds.push_back(members[i * members.size() / kSeeds]->code);
        }
    }

    void subtractCodes() {
        for (SampleTexel& texel : sample_.texels()) {
            subtractCode(evaluateCode(tableOf(texel), model_.shape.monomialCount(), texel.code), texel.ratio);
        }
    }

    BasisSample& sample_;
    BasisModel& model_;
};

}  // namespace

void fitCodes(BasisSample& sample, BasisModel& model) {
    CodeFitter(sample, model).run();
}

}  // namespace lightcook::compress

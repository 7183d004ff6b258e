// The best single light and lights fitted for the filter, against what Ceres finds.
#include <ceres/ceres.h>
#include <ceres/sphere_manifold.h>
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "fit/light_search.h"
#include "tests/fit/brute_force.h"
#include "tests/fit/dominant/lit_map.h"
#include "tests/fit/dominant/random_light.h"

namespace lightcook {
namespace {

using lighting::ShRgb;
using test::energyOf;
using test::explained;
using test::Map;
using test::randomLight;

/// Residuals of nine coefficients and three channels after one light and ambient light.
struct CeresResidual {
    ShRgb sh;
    template <class T>
    bool operator()(const T* direction, const T* intensity, const T* ambient, T* left) const {
        const T x = direction[0], y = direction[1], z = direction[2];
        const T basis[9] = {T(lighting::kShConstant),
                            lighting::kShLinear * y,
                            lighting::kShLinear * z,
                            lighting::kShLinear * x,
                            lighting::kShProduct * x * y,
                            lighting::kShProduct * y * z,
                            lighting::kShZonal * (3.0 * z * z - 1.0),
                            lighting::kShProduct * x * z,
                            lighting::kShDifference * (x * x - y * y)};
        for (int i = 0; i < 9; ++i)
            for (int channel = 0; channel < 3; ++channel) {
                T& each = left[3 * i + channel];
                each = static_cast<double>(sh[static_cast<std::size_t>(i)][channel]) - intensity[channel] * basis[i];
                if (i == 0) each -= 2 * std::sqrt(truth::kPi) * ambient[channel];
            }
        return true;
    }
};

/// Solves for all unknowns together by Ceres, from a start.
double errorByCeres(const ShRgb& sh, const fit::LightFit& start, bool hasAmbient) {
    double direction[3] = {start.direction.x, start.direction.y, start.direction.z};
    double intensity[3] = {start.intensity.x, start.intensity.y, start.intensity.z};
    double ambient[3] = {start.ambient.x, start.ambient.y, start.ambient.z};
    ceres::Problem problem;
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<CeresResidual, 27, 3, 3, 3>(new CeresResidual{sh}), nullptr, direction,
                             intensity, ambient);
    problem.SetManifold(direction, new ceres::SphereManifold<3>);
    for (int channel = 0; channel < 3; ++channel) {
        problem.SetParameterLowerBound(intensity, channel, 0);
        problem.SetParameterLowerBound(ambient, channel, 0);
    }
    if (!hasAmbient) problem.SetParameterBlockConstant(ambient);
    ceres::Solver::Options options;
    options.logging_type = ceres::SILENT;
    options.max_num_iterations = 200;
    options.function_tolerance = 1e-14;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    return 2 * summary.final_cost / energyOf(sh);
}

TEST(LightSearchByCeres, FindsNothingBetterFromManyStartsNorFromTheResult) {
    truth::Random random(7);
    for (int i = 0; i < 200; ++i) {
        const ShRgb sh = randomLight(random);
        const bool hasAmbient = i % 2 == 0;
        const fit::LightFit found = fit::bestLight(sh, random.direction(), hasAmbient);
        double least = errorByCeres(sh, found, hasAmbient);
        EXPECT_NEAR(least, found.unexplained, 1e-9) << i;
        for (int start = 0; start < 6; ++start)
            least = std::min(least, errorByCeres(sh, fit::lightTowards(sh, lighting::fibonacciSphere(start, 6), hasAmbient), hasAmbient));
        EXPECT_LT(found.unexplained, least + 1e-9) << i;
    }
}

/// The sum that the fit minimises, written a second time: residuals whose squares are E.
struct PlaceResidual {
    int count;
    glm::dvec3 direction, intensity;
    double weight;

    template <class T>
    bool operator()(const T* const* lights, T* residuals) const {
        using std::sqrt;
        T towards[3] = {T(0), T(0), T(0)}, light[3] = {T(0), T(0), T(0)}, squared(1e-18), apart(0);
        for (int i = 0; i < count; ++i)
            for (int k = 0; k < 3; ++k) towards[k] += lights[2 * i][k] / T(count), light[k] += lights[2 * i + 1][k] / T(count);
        for (const T& each : towards) squared += each * each;
        for (int k = 0; k < 3; ++k) towards[k] = towards[k] / sqrt(squared) - T(direction[k]), apart += towards[k] * towards[k];
        const T spread = T(1) + T(5.35) * apart, overlap = T(1) / (spread * spread);
        // (1 - g^2) / |d - d*|^2 without a division by zero.
        const T turned = T(5.35) * (spread + T(1)) * (spread * spread + T(1)) * overlap * overlap;
        const double scale = std::sqrt(weight);
        for (int k = 0; k < 3; ++k) {
            residuals[k] = T(scale) * (light[k] - overlap * T(intensity[k]));
            residuals[3 + k] = T(scale * glm::length(intensity)) * sqrt(turned) * towards[k];
        }
        return true;
    }
};

/// All places of a fully covered map with their light.
class CeresFit {
public:
    CeresFit(const Map& map, const fit::FilteredLightOptions& options) : map_(map) {
        for (int y = 0; y < map.height(); ++y)
            for (int x = 0; x < map.width(); ++x)
                for (int kind = 0; kind < 4; ++kind) {
                    const int right = kind % 2, below = kind / 2;
                    if (x + right < map.width() && y + below < map.height()) add(x, y, right, below, options);
                }
    }

    /// Returns the sum for some lights, before or after a minimisation.
    double sumOf(const Map& lights, bool isMinimised) const {
        std::vector<double> values;
        for (std::size_t i = 0; i < lights.direction.texels().size(); ++i) {
            for (int k = 0; k < 3; ++k) values.push_back(static_cast<double>(lights.direction.texels()[i][k]));
            for (int k = 0; k < 3; ++k) values.push_back(static_cast<double>(lights.intensity.texels()[i][k]));
        }
        ceres::Problem problem;
        for (const auto& [residual, texels] : places_) {
            auto* cost = new ceres::DynamicAutoDiffCostFunction<PlaceResidual, 6>(new PlaceResidual(residual));
            std::vector<double*> blocks;
            for (const int texel : texels)
                for (const int at : {6 * texel, 6 * texel + 3}) {
                    cost->AddParameterBlock(3);
                    blocks.push_back(&values[static_cast<std::size_t>(at)]);
                }
            cost->SetNumResiduals(6);
            problem.AddResidualBlock(cost, nullptr, blocks);
        }
        for (std::size_t i = 0; i < values.size(); i += 6) {
            problem.SetManifold(&values[i], new ceres::SphereManifold<3>);  // keeps the length
            for (int k = 0; k < 3; ++k) problem.SetParameterLowerBound(&values[i + 3], k, 0);
        }
        ceres::Solver::Options options;
        options.logging_type = ceres::SILENT;
        options.max_num_iterations = isMinimised ? 200 : 0;
        ceres::Solver::Summary summary;
        ceres::Solve(options, &problem, &summary);
        return 2 * summary.final_cost;
    }

private:
    void add(int x, int y, int right, int below, const fit::FilteredLightOptions& options) {
        const int count = (1 + right) * (1 + below);
        lighting::ShRgb sh{};
        std::vector<int> texels;
        for (int i = 0; i <= below; ++i)
            for (int j = 0; j <= right; ++j) {
                texels.push_back((y + i) * map_.width() + x + j);
                for (std::size_t k = 0; k < sh.size(); ++k) sh[k] += map_.sh.at(x + j, y + i)[k] / static_cast<float>(count);
            }
        const fit::DominantLight light = fit::dominantLight(sh, glm::vec3(0, 0, 1), options.light);
        const double scale = glm::length(glm::dvec3(light.intensity)) + options.floor;
        places_.push_back({{count, glm::normalize(glm::dvec3(light.direction)), glm::dvec3(light.intensity),
                            (count == 1 ? options.centreWeight : 1) / (scale * scale)},
                           texels});
    }

    struct PlaceOfTexels {
        PlaceResidual residual;
        std::vector<int> texels;
    };
    const Map& map_;
    std::vector<PlaceOfTexels> places_;
};

/// Ceres moves all lights together until nothing changes, and knows no limits of lengths. A few sweeps, texel by texel, gain most of what
/// it gains.
TEST(FilteredLightByCeres, GainsHardlyMoreFromTheSameStart) {
    truth::Random random(5);
    for (int trial = 0; trial < 12; ++trial) {
        Map map(7, 6);
        const double jitter = trial < 6 ? 0.02 : 0.2;
        const glm::dvec3 first = random.direction(), second = random.direction();
        for (int y = 0; y < map.height(); ++y)
            for (int x = 0; x < map.width(); ++x) {
                const bool isLit = x + 0.4 * y < 4.5;
                const glm::dvec3 towards = (isLit ? first : second) + jitter * random.direction();
                const double brightness = (isLit ? 2 : 0.2) * (1 + 5 * jitter * (random.uniform() - 0.5));
                map.sh.at(x, y) =
                    lighting::projectDirectional(glm::vec3(glm::normalize(towards)), glm::vec3(static_cast<float>(brightness)));
                map.sh.at(x, y)[0] += glm::vec3(0.02f);
            }
        fit::FilteredLightOptions options = explained();
        options.light.fit = fit::DominantFit::Refined;
        options.tolerance = 0, options.mostAtCentre = 1e3;
        map.fitTexels(options.light);
        fit::FilteredLightOptions lengthsAlone = options;
        lengthsAlone.tolerance = 1e9;
        map.fitForFilter(lengthsAlone);
        const CeresFit truth(map, options);
        const double before = truth.sumOf(map, false), byCeres = truth.sumOf(map, true);
        map.fitTexels(options.light);
        map.fitForFilter(options);
        const double found = truth.sumOf(map, false);
        EXPECT_GT(before - found, 0.85 * (before - byCeres)) << trial << ": " << before << ", " << found;
        EXPECT_GT(found, 0.99 * std::min(byCeres, truth.sumOf(map, true))) << trial;
    }
}

}  // namespace
}  // namespace lightcook

#include "fit/azimuthal_average.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <ctime>
#include <limits>

#include "tests/fit/brute_force.h"

namespace lightcook {
namespace {

using formats::Environment;

/// Averages by pieces of texels, each counted in the zone of its centre.
std::vector<glm::dvec3> bruteForce(const Environment& environment, const glm::dvec3& axis, int zoneCount, int pieces) {
    std::vector<glm::dvec3> sums(static_cast<std::size_t>(zoneCount), glm::dvec3(0));
    for (const truth::Sample& sample : truth::samplesOf(environment, pieces)) {
        const double z = glm::dot(glm::normalize(axis), sample.direction);
        const int zone = std::clamp(static_cast<int>(0.5 * (1 - z) * zoneCount), 0, zoneCount - 1);
        sums[static_cast<std::size_t>(zone)] += sample.solidAngle * sample.radiance;
    }
    for (glm::dvec3& sum : sums) sum *= zoneCount / (4 * truth::kPi);
    return sums;
}

Environment randomEnvironment(truth::Random& random, Environment::Projection projection, int size) {
    const bool isPanorama = projection == Environment::Projection::Equirectangular;
    Environment environment{projection, formats::Image<glm::vec3>(isPanorama ? 2 * size : size, isPanorama ? size : 6 * size)};
    for (glm::vec3& texel : environment.texels.texels())
        texel = glm::vec3(static_cast<float>(random.uniform()), static_cast<float>(random.below(2)), 1.0f);
    return environment;
}

const std::vector<glm::dvec3> kAxes = {{0, 1, 0}, {0, -1, 0}, {1, 0, 0},  {0, 0, 1},         {0, 0, -3},
                                       {1, 1, 1}, {1, 1, 0},  {-1, 0, 1}, {0.3, -0.2, 0.93}, {0.01, 1, 0.02}};

TEST(AzimuthalAverage, AgreesWithPiecesOfTexels) {
    truth::Random random(1);
    for (const auto projection : {Environment::Projection::Equirectangular, Environment::Projection::CubeStrip})
        for (const int size : {1, 2, 5})
            for (const glm::dvec3& axis : kAxes)
                for (const int zoneCount : {1, 2, 7, 16}) {
                    const Environment environment = randomEnvironment(random, projection, size);
                    const int pieces = 120 / size;
                    const auto expected = bruteForce(environment, axis, zoneCount, pieces);
                    const auto found = fit::averageAroundAxis(environment, axis, zoneCount);
                    // The brute force errs on pieces that a zone's edge cuts: by half a piece at either edge if the grid is aligned with
                    // the axis, hardly otherwise.
                    const bool isOblique = axis == kAxes[8];
                    const double tolerance = isOblique ? 1e-3 * zoneCount : 0.5 * truth::kPi / 120 * zoneCount;
                    for (int zone = 0; zone < zoneCount; ++zone)
                        for (int channel = 0; channel < 3; ++channel)
                            ASSERT_NEAR(found.gradient[static_cast<std::size_t>(zone)][channel],
                                        expected[static_cast<std::size_t>(zone)][channel], tolerance)
                                << "size " << size << " zones " << zoneCount << " axis " << axis.x << " " << axis.y << " " << axis.z;
                }
}

/// Zones around the axis of a panorama: the reference is the overlap of height intervals of rows and zones.
TEST(AzimuthalAverage, AlongAPanoramasOwnAxisRowsAreSharedByTheirHeights) {
    truth::Random random(2);
    for (const double sign : {1.0, -1.0}) {
        const Environment environment = randomEnvironment(random, Environment::Projection::Equirectangular, 33);
        const int zoneCount = 20, height = 33;
        const auto found = fit::averageAroundAxis(environment, {0, sign, 0}, zoneCount);
        for (int zone = 0; zone < zoneCount; ++zone) {
            glm::dvec3 sum(0);
            const double top = 1 - 2.0 * zone / zoneCount, bottom = 1 - 2.0 * (zone + 1) / zoneCount;
            for (int y = 0; y < height; ++y) {
                double rowTop = std::cos(truth::kPi * y / height), rowBottom = std::cos(truth::kPi * (y + 1) / height);
                if (sign < 0) rowTop = -std::exchange(rowBottom, -rowTop);
                const double overlap = std::max(0.0, std::min(top, rowTop) - std::max(bottom, rowBottom));
                for (int x = 0; x < 2 * height; ++x) sum += overlap / (2 * height) * glm::dvec3(environment.texels.at(x, y));
            }
            sum *= zoneCount / 2.0;
            for (int channel = 0; channel < 3; ++channel)
                ASSERT_NEAR(found.gradient[static_cast<std::size_t>(zone)][channel], sum[channel], 3e-7) << zone;
        }
    }
}

TEST(AzimuthalAverage, KeepsTheFluxForAnyAxis) {
    truth::Random random(3);
    for (const auto projection : {Environment::Projection::Equirectangular, Environment::Projection::CubeStrip})
        for (int trial = 0; trial < 200; ++trial) {
            const Environment environment = randomEnvironment(random, projection, 1 + random.below(16));
            const glm::dvec3 mean = truth::meanRadiance(truth::samplesOf(environment, 1));
            const int zoneCount = 1 + random.below(300);
            const auto found = fit::averageAroundAxis(
                environment, trial % 4 == 0 ? kAxes[static_cast<std::size_t>(trial / 4 % 10)] : random.direction(), zoneCount);
            glm::dvec3 sum(0);
            for (const glm::vec3& zone : found.gradient) sum += glm::dvec3(zone) / static_cast<double>(zoneCount);
            for (int channel = 0; channel < 3; ++channel) ASSERT_NEAR(sum[channel], mean[channel], 1e-6) << trial;
            for (const glm::vec3& zone : found.gradient) ASSERT_NEAR(zone.z, 1, 1e-6) << "a constant channel stays constant";
            ASSERT_GE(found.asymmetricEnergy, 0);
            ASSERT_LE(found.asymmetricEnergy, 1);
        }
}

/// Light that depends on the height alone loses almost no energy; light of two equal halves a known part.
TEST(AzimuthalAverage, ReportsTheAsymmetricEnergy) {
    const glm::dvec3 axis = glm::normalize(glm::dvec3(1, 2, -1)), side = glm::normalize(glm::cross(axis, glm::dvec3(0, 1, 0)));
    for (const auto projection : {Environment::Projection::Equirectangular, Environment::Projection::CubeStrip}) {
        const bool isPanorama = projection == Environment::Projection::Equirectangular;
        const int size = 64;
        Environment smooth{projection, formats::Image<glm::vec3>(isPanorama ? 2 * size : size, isPanorama ? size : 6 * size)};
        Environment halves{projection, smooth.texels.copy()};
        const auto samples = truth::samplesOf(smooth, 1);
        for (std::size_t i = 0; i < samples.size(); ++i) {
            smooth.texels.texels()[i] = glm::vec3(static_cast<float>(2 + glm::dot(axis, samples[i].direction)));
            halves.texels.texels()[i] = glm::vec3(glm::dot(side, samples[i].direction) > 0 ? 1.0f : 0.0f);
        }
        const auto kept = fit::averageAroundAxis(smooth, axis, 32), lost = fit::averageAroundAxis(halves, axis, 32);
        EXPECT_LT(kept.asymmetricEnergy, 1e-3);
        EXPECT_NEAR(lost.asymmetricEnergy, 0.5, 5e-3);  // the seam between the halves is a texel rough
        EXPECT_NEAR(lost.gradient[10].x, 0.5, 0.02);
    }
}

TEST(AzimuthalAverage, ExtremesStayFinite) {
    for (const float value : {0.0f, std::numeric_limits<float>::denorm_min(), 1e30f, std::numeric_limits<float>::max()}) {
        Environment environment = truth::constantStrip(8, glm::vec3(0));
        environment.texels.at(3, 20) = glm::vec3(value);
        const auto found = fit::averageAroundAxis(environment, {0, 1, 0}, 64);
        for (const glm::vec3& zone : found.gradient) {
            ASSERT_TRUE(std::isfinite(zone.x));
            ASSERT_GE(zone.x, 0);
            ASSERT_LE(zone.x, value);
        }
        ASSERT_TRUE(found.asymmetricEnergy >= 0 && found.asymmetricEnergy <= 1) << value;
    }
}

TEST(AzimuthalAverage, BadRequestsAreRefusedByName) {
    EXPECT_FALSE(fit::checkAzimuthalAverage({0, 0, 0}, 16));
    EXPECT_FALSE(fit::checkAzimuthalAverage({0, NAN, 0}, 16));
    EXPECT_FALSE(fit::checkAzimuthalAverage({0, 1, 0}, 0));
    EXPECT_FALSE(fit::checkAzimuthalAverage({0, 1, 0}, 4097));
    EXPECT_TRUE(fit::checkAzimuthalAverage({0, 1e-100, 0}, 4096));
}

TEST(AzimuthalAverageSoak, APanoramaTakesLessThanFiveSeconds) {
    truth::Random random(5);
    const Environment environment = randomEnvironment(random, Environment::Projection::Equirectangular, 512);
    for (const glm::dvec3& axis : {glm::dvec3(0, 1, 0), glm::dvec3(0.3, 0.8, 0.2)}) {
        const std::clock_t begin = std::clock();
        const auto found = fit::averageAroundAxis(environment, axis, 256);
        const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
        std::printf("[ figures  ] azimuthal average, 1024 x 512 to 256 zones: %.3f CPU s\n", seconds);
        EXPECT_LT(seconds, 5);
        ASSERT_EQ(found.gradient.size(), 256u);
    }
}

}  // namespace
}  // namespace lightcook

#include "fit/environment_sh.h"

#include <gtest/gtest.h>

#include <cmath>

#include "lighting/radiometry.h"
#include "tests/fit/brute_force.h"

namespace lightcook {
namespace {

using truth::kPi;

lighting::ShDouble channel0(const lighting::ShRgb& sh) {
    lighting::ShDouble result;
    for (std::size_t i = 0; i < result.size(); ++i) result[i] = sh[i].x;
    return result;
}

/// Projects by midpoints of many pieces a texel.
lighting::ShDouble bruteForce(const formats::Environment& environment, int pieces) {
    lighting::ShDouble sum{};
    for (const truth::Sample& sample : truth::samplesOf(environment, pieces)) {
        const lighting::ShDouble basis = lighting::evaluateBasis(sample.direction);
        for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += sample.solidAngle * sample.radiance.x * basis[i];
    }
    return sum;
}

formats::Environment noise(formats::Environment environment, std::uint64_t seed) {
    truth::Random random(seed);
    for (glm::vec3& texel : environment.texels.texels()) texel = glm::vec3(static_cast<float>(std::pow(random.uniform(), 8) * 10));
    return environment;
}

void expectGreyExit(const formats::Environment& environment) {
    const lighting::ShRgb sh = fit::projectEnvironment(environment);
    truth::Random random(5);
    for (int trial = 0; trial < 50; ++trial) {
        const auto exit = lighting::lambertExitRadiance(sh, glm::vec3(random.direction()), glm::vec3(1));
        for (int channel = 0; channel < 3; ++channel) EXPECT_NEAR(exit.value[channel], 0.5, 0.5e-6);
    }
    EXPECT_NEAR(sh[0].x, 0.5 * std::sqrt(4 * kPi), 1e-6);
    for (std::size_t i = 1; i < sh.size(); ++i) EXPECT_NEAR(sh[i].x, 0, 1e-7) << i;
}

TEST(ProjectEnvironment, GreyPanoramaGivesGreyLambert) {
    expectGreyExit(truth::constantEquirectangular(256, 128, glm::vec3(0.5f)));
    expectGreyExit(truth::constantEquirectangular(2, 1, glm::vec3(0.5f)));
    expectGreyExit(truth::constantEquirectangular(1024, 512, glm::vec3(0.5f)));
}

TEST(ProjectEnvironment, GreyStripGivesGreyLambert) {
    for (const int size : {1, 3, 16, 128}) expectGreyExit(truth::constantStrip(size, glm::vec3(0.5f)));
}

TEST(ProjectEnvironment, NoisyPanoramaMatchesBruteForce) {
    for (const int height : {1, 2, 8, 33}) {
        const auto environment = noise(truth::constantEquirectangular(2 * height, height, glm::vec3(0)), 11);
        const auto sh = channel0(fit::projectEnvironment(environment));
        const auto expected = bruteForce(environment, 1024 / height);
        for (std::size_t i = 0; i < sh.size(); ++i) EXPECT_NEAR(sh[i], expected[i], 1e-5 * expected[0]) << height << " " << i;
    }
}

TEST(ProjectEnvironment, NoisyStripMatchesBruteForce) {
    for (const int size : {1, 2, 7, 32}) {
        const auto environment = noise(truth::constantStrip(size, glm::vec3(0)), 12);
        const auto sh = channel0(fit::projectEnvironment(environment));
        const auto expected = bruteForce(environment, 512 / size);
        for (std::size_t i = 0; i < sh.size(); ++i) EXPECT_NEAR(sh[i], expected[i], 1e-5 * expected[0]) << size << " " << i;
    }
}

/// L = max(0, w.d): coefficients A_l sqrt(4pi / (2l+1)) times Y_i(d) sqrt((2l+1)/4pi) = A_l Y_i(d).
TEST(ProjectEnvironment, CosineLobeHasItsClosedForm) {
    const glm::dvec3 axis = glm::normalize(glm::dvec3(0.3, 0.8, -0.5));
    formats::Environment panorama = truth::constantEquirectangular(1024, 512, glm::vec3(0));
    for (int y = 0; y < 512; ++y) {
        for (int x = 0; x < 1024; ++x) {
            const glm::dvec3 direction = lighting::directionFromEquirectangular({(x + 0.5) / 1024, (y + 0.5) / 512});
            panorama.texels.at(x, y) = glm::vec3(static_cast<float>(std::max(0.0, glm::dot(direction, axis))));
        }
    }
    formats::Environment strip = truth::constantStrip(256, glm::vec3(0));
    for (int y = 0; y < 6 * 256; ++y) {
        for (int x = 0; x < 256; ++x) {
            const glm::dvec3 direction = lighting::cubeTexelDirection(y / 256, x, y % 256, 256);
            strip.texels.at(x, y) = glm::vec3(static_cast<float>(std::max(0.0, glm::dot(direction, axis))));
        }
    }
    const lighting::ShDouble basis = lighting::evaluateBasis(axis);
    for (const formats::Environment* environment : {&panorama, &strip}) {
        const auto sh = channel0(fit::projectEnvironment(*environment));
        for (std::size_t i = 0; i < sh.size(); ++i) {
            const double expected = lighting::kIrradianceBands[static_cast<std::size_t>(lighting::kShBand[i])] * basis[i];
            EXPECT_NEAR(sh[i], expected, 2e-5) << i;  // texels are constant, the lobe is not
        }
    }
}

TEST(ProjectEnvironment, SmallSunKeepsItsEnergyAndDirection) {
    formats::Environment environment = truth::constantEquirectangular(1024, 512, glm::vec3(0));
    double solidAngle = 0;
    for (int y = 150; y < 152; ++y) {
        for (int x = 700; x < 702; ++x) {
            environment.texels.at(x, y) = glm::vec3(60000);
            solidAngle += lighting::equirectangularTexelSolidAngle(y, 1024, 512);
        }
    }
    const auto sh = channel0(fit::projectEnvironment(environment));
    const lighting::ShDouble basis = lighting::evaluateBasis(lighting::directionFromEquirectangular({701.0 / 1024, 151.0 / 512}));
    for (std::size_t i = 0; i < sh.size(); ++i) EXPECT_NEAR(sh[i], 60000 * solidAngle * basis[i], 1e-4 * 60000 * solidAngle) << i;
}

TEST(ProjectEnvironment, HugeTexelsStayFinite) {
    const auto sh = fit::projectEnvironment(truth::constantEquirectangular(8, 4, glm::vec3(3e38f)));
    for (const glm::vec3& coefficient : sh) EXPECT_TRUE(std::isfinite(coefficient.x));
}

TEST(PrefilterKernel, BandsMatchFineIntegration) {
    for (const auto kernel : {fit::PrefilterKernel::Beckmann, fit::PrefilterKernel::Ggx, fit::PrefilterKernel::Phong}) {
        for (const double m : {0.003, 0.02, 0.1, 0.35, 0.7, 1.0}) {
            long double moments[3] = {0, 0, 0};
            const int count = 300000;
            const long double reach = kernel == fit::PrefilterKernel::Ggx ? 1.0L : std::min(1.0L, 80.0L * m * m);
            for (int i = 0; i < count; ++i) {
                const long double t = (i + 0.5L) / count;
                const long double versine = reach * t * t * t;  // points gather at the peak
                const long double c = 1 - versine;
                const long double tan2 = versine / (2 - versine), NoH2 = 1 - versine / 2;
                long double shape = 0;
                if (kernel == fit::PrefilterKernel::Beckmann) shape = std::exp(-tan2 / (m * m)) / (NoH2 * NoH2) * c;
                if (kernel == fit::PrefilterKernel::Ggx) {
                    const long double d = NoH2 * m * m + versine / 2;
                    shape = c / (d * d);
                }
                if (kernel == fit::PrefilterKernel::Phong) shape = std::pow(c, (1.0L / (static_cast<long double>(m) * m) + 1) / 2);
                const long double value = shape * t * t;
                moments[0] += value;
                moments[1] += value * versine;  // 1 - P_1: a difference that narrow lobes keep their digits in
                moments[2] += value * 1.5L * versine * (2 - versine);
            }
            const lighting::ShBands bands = fit::prefilterKernelBands(kernel, m);
            EXPECT_EQ(bands[0], 1);
            EXPECT_NEAR(bands[1], static_cast<double>(1 - moments[1] / moments[0]), 1e-9) << static_cast<int>(kernel) << " m " << m;
            EXPECT_NEAR(bands[2], static_cast<double>(1 - moments[2] / moments[0]), 1e-9) << static_cast<int>(kernel) << " m " << m;
        }
    }
}

TEST(PrefilterKernel, PhongOfRoughness1IsLambert) {
    const lighting::ShBands bands = fit::prefilterKernelBands(fit::PrefilterKernel::Phong, 1);
    for (std::size_t l = 0; l < 3; ++l) EXPECT_NEAR(bands[l], lighting::kExitRadianceBands[l], 1e-9);
    EXPECT_NEAR(fit::prefilterKernelIntegral(fit::PrefilterKernel::Phong, 1), kPi, 1e-9);
}

TEST(PrefilterKernel, RoughnessZeroChangesNothing) {
    EXPECT_EQ(fit::prefilterKernelBands(fit::PrefilterKernel::Ggx, 0), (lighting::ShBands{1, 1, 1}));
    // Narrower than doubles can tell.
    for (const auto kernel : {fit::PrefilterKernel::Beckmann, fit::PrefilterKernel::Ggx, fit::PrefilterKernel::Phong})
        for (const double m : {1e-11, 1e-16, 1e-300})
            for (const double band : fit::prefilterKernelBands(kernel, m)) EXPECT_DOUBLE_EQ(band, 1);
}

}  // namespace
}  // namespace lightcook

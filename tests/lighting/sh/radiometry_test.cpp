#include "lighting/radiometry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <random>

#include "tests/lighting/quadrature.h"

namespace lightcook::lighting {
namespace {

using test::gaussLegendre;
using test::kPi;
using test::randomDirection;

/// Returns 2 pi integral over [from, 1] of kernel(z) P_l(z): the factor of a zonal kernel on band l.
template <class Kernel>
ShBands zonalBands(double from, Kernel kernel) {
    const test::Rule rule = gaussLegendre(16, from, 1);
    ShBands bands{};
    for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
        const double z = rule.nodes[i], value = 2 * kPi * rule.weights[i] * kernel(z);
        bands[0] += value;
        bands[1] += value * z;
        bands[2] += value * (1.5 * z * z - 0.5);
    }
    return bands;
}

ShRgb randomLight(std::mt19937_64& random) {
    std::uniform_real_distribution<float> uniform(-1, 1);
    ShRgb light{};
    for (glm::vec3& c : light) c = {uniform(random), uniform(random), uniform(random)};
    return light;
}

/// Listing 1 of Chen and Liu 2008 with its packing step, for one channel; sh with Condon-Shortley signs.
double listingOne(const double (&sh)[9], const glm::dvec3& n) {
    const double c1 = 0.429043, c2 = 0.511664, c4 = 0.886227, root3 = 1.7320508;
    const double linear = n.x * sh[3] + n.y * sh[1] - n.z * sh[2];
    const double mixed = -n.x * n.y * sh[4] + n.y * n.z * sh[5] + n.z * n.x * sh[7];
    const double squares = -n.x * n.x * sh[8] + n.y * n.y * sh[8] - n.z * n.z * sh[6] * root3 + sh[6] * root3 / 3;
    return (c4 * sh[0] - 2 * c2 * linear - 2 * c1 * mixed - c1 * squares) / 3.1415926535;
}

TEST(CosineLobe, ZonalCoefficientsAreThePapers) {
    const ShBands bands = zonalBands(0, [](double z) { return z; });
    for (std::size_t l = 0; l < 3; ++l) {
        EXPECT_NEAR(kIrradianceBands[l], bands[l], 1e-13);
        EXPECT_NEAR(kExitRadianceBands[l], bands[l] / kPi, 1e-13);
        // Eq. 5 gives the projection on Y_l0, which is sqrt((2l + 1) / 4pi) times the factor.
        const double paper[3] = {std::sqrt(kPi / 4), std::sqrt(kPi / 3), std::sqrt(5 * kPi / 64)};
        EXPECT_NEAR(kIrradianceBands[l] * std::sqrt((2 * static_cast<double>(l) + 1) / (4 * kPi)), paper[l], 1e-13);
    }
}

TEST(WrappedLambert, BandsMatchIntegrationOfTheLobe) {
    for (const double wrap : {0.0, 0.1, 0.25, 0.5, 0.77, 1.0}) {
        const ShBands expected = zonalBands(-wrap, [wrap](double z) { return (z + wrap) / (kPi * (1 + wrap) * (1 + wrap)); });
        const ShBands bands = wrappedLambertBands(wrap);
        for (std::size_t l = 0; l < 3; ++l) EXPECT_NEAR(bands[l], expected[l], 1e-13) << wrap << ' ' << l;
    }
}

TEST(Irradiance, IsTheIntegralOfRadianceAndCosine) {
    std::mt19937_64 random(21);
    for (int trial = 0; trial < 5; ++trial) {
        const ShRgb light = randomLight(random);
        const glm::dvec3 n = randomDirection(random);
        glm::dvec3 sum(0);
        // In a frame around n, so that the clamp of the cosine lies between the two quadrature rules.
        const glm::dvec3 t = glm::normalize(glm::cross(n, std::abs(n.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
        const glm::dvec3 b = glm::cross(n, t);
        const test::Rule heights = gaussLegendre(8, 0, 1);
        for (std::size_t i = 0; i < heights.nodes.size(); ++i)
            for (int j = 0; j < 16; ++j) {
                const double z = heights.nodes[i], r = std::sqrt(1 - z * z), phi = kPi * j / 8;
                const glm::dvec3 w = r * std::cos(phi) * t + r * std::sin(phi) * b + z * n;
                sum += glm::dvec3(evaluate(light, glm::vec3(w))) * (z * heights.weights[i] * kPi / 8);
            }
        const glm::vec3 albedo(0.2f, 0.5f, 1);
        for (int channel = 0; channel < 3; ++channel) {
            EXPECT_NEAR(irradiance(light, glm::vec3(n)).value[channel], sum[channel], 5e-6);
            EXPECT_NEAR(lambertExitRadiance(light, glm::vec3(n), albedo).value[channel], albedo[channel] * sum[channel] / kPi, 2e-6);
        }
    }
}

TEST(ListingOne, EqualsTheCosineBandsUnderCondonShortleySigns) {
    std::mt19937_64 random(22);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (int trial = 0; trial < 1000; ++trial) {
        ShDouble light{};
        double signedLight[9];
        for (std::size_t i = 0; i < kShCount; ++i) {
            light[i] = uniform(random);
            signedLight[i] = i % 2 == 1 ? -light[i] : light[i];
        }
        const glm::dvec3 n = randomDirection(random);
        const ShDouble basis = evaluateBasis(n);
        double exitRadiance = 0;
        for (std::size_t i = 0; i < kShCount; ++i)
            exitRadiance += kIrradianceBands[static_cast<std::size_t>(kShBand[i])] * light[i] * basis[i] / kPi;
        EXPECT_NEAR(listingOne(signedLight, n), exitRadiance, 1e-6);
    }
}

TEST(ListingOne, EqualsLambertExitRadianceOfAFileWithCondonShortleySigns) {
    std::mt19937_64 random(23);
    for (int trial = 0; trial < 100; ++trial) {
        const ShRgb light = randomLight(random), inFile = flipCondonShortley(light);
        const glm::dvec3 n = randomDirection(random);
        const ExitRadiance shown = lambertExitRadiance(light, glm::vec3(n), glm::vec3(1));
        for (int channel = 0; channel < 3; ++channel) {
            double signedLight[9];
            for (std::size_t i = 0; i < kShCount; ++i) signedLight[i] = inFile[i][channel];
            EXPECT_NEAR(shown.value[channel], listingOne(signedLight, n), 2e-6);
        }
    }
}

TEST(GreyTest, ConstantRadianceOfAHalfGivesExitRadianceOfAHalf) {
    ShRgb grey{};
    grey[0] = glm::vec3(static_cast<float>(0.5 * std::sqrt(4 * kPi)));
    std::mt19937_64 random(24);
    for (int trial = 0; trial < 100; ++trial) {
        const glm::vec3 n(randomDirection(random));
        const ExitRadiance shown = lambertExitRadiance(grey, n, glm::vec3(1));
        EXPECT_NEAR(shown.value.x, 0.5, 1e-6);
        EXPECT_NEAR(shown.value.y, 0.5, 1e-6);
        EXPECT_NEAR(shown.value.z, 0.5, 1e-6);
        for (const double wrap : {0.0, 0.5, 1.0}) EXPECT_NEAR(evaluate(convolve(grey, wrappedLambertBands(wrap)), n).x, 0.5, 1e-6);
        EXPECT_NEAR(irradiance(grey, n).value.x, 0.5 * kPi, 4e-6);
    }
}

TEST(GameLight, FacingAWhiteSurfaceShowsSeventeenSixteenths) {
    std::mt19937_64 random(25);
    for (int trial = 0; trial < 100; ++trial) {
        const glm::vec3 n(randomDirection(random));
        const GameLight light{{1, 0.5f, 2}};
        const glm::vec3 plain = lambertExitRadiance(projectGameLight(light, n, GameLightNormalization::None), n, glm::vec3(1)).value;
        const glm::vec3 scaled = lambertExitRadiance(projectGameLight(light, n, GameLightNormalization::D3dx), n, glm::vec3(1)).value;
        for (int channel = 0; channel < 3; ++channel) {
            EXPECT_NEAR(plain[channel] / light.value[channel], 17.0 / 16, 1e-6);
            EXPECT_NEAR(scaled[channel] / light.value[channel], 1, 1e-6);
        }
    }
}

TEST(Rgb, AddsAndScales) {
    const Radiance sum = Radiance{{1, 2, 3}} + 2.0f * Radiance{{1, 0, -1}};
    EXPECT_EQ(sum.value, glm::vec3(3, 2, 1));
}

}  // namespace
}  // namespace lightcook::lighting

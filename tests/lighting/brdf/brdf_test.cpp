#include "lighting/brdf.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <random>

#include "lighting/sphere.h"
#include "tests/lighting/quadrature.h"

namespace lightcook::lighting {
namespace {

using test::gaussLegendre;
using test::kPi;
using test::randomDirection;

constexpr auto kBeckmann = NormalDistribution::Beckmann;
constexpr auto kGgx = NormalDistribution::Ggx;
constexpr auto kEnergy = CookTorranceNormalization::Energy;
constexpr auto kHalo3 = CookTorranceNormalization::Halo3;

const char* name(NormalDistribution distribution) {
    return distribution == kBeckmann ? "Beckmann" : "GGX";
}

/// Integrates lobe(cos) over the hemisphere around z, with points dense near the pole.
template <class Lobe>
double hemisphereIntegral(Lobe lobe) {
    const test::Rule rule = gaussLegendre(400, 0, 1);
    double sum = 0;
    for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
        const double s = rule.nodes[i], theta = kPi / 2 * s * s * s;
        sum += rule.weights[i] * 1.5 * kPi * s * s * 2 * kPi * std::sin(theta) * lobe(std::cos(theta));
    }
    return sum;
}

/// Integrates cookTorrance over all light directions, without half vector and symmetry: midpoints in polar coordinates around the
/// reflection vector, dense near it, for a view of any azimuth.
AreaSpecularKernel bruteForce(double NoV, double m, NormalDistribution distribution, CookTorranceNormalization normalization, int steps) {
    const double azimuth = 0.61, sinV = std::sqrt(1 - NoV * NoV);
    const glm::dvec3 normal(0, 0, 1), view(sinV * std::cos(azimuth), sinV * std::sin(azimuth), NoV);
    const glm::dmat3 frame = worldFromTangentFrame({-view.x, -view.y, view.z});
    AreaSpecularKernel kernel;
    for (int row = 0; row < steps; ++row) {
        const double s = (row + 0.5) / steps, alpha = kPi * s * s * s;
        const double weight = 3 * kPi * s * s * std::sin(alpha) * 2 * kPi / (static_cast<double>(steps) * steps);
        for (int column = 0; column < steps; ++column) {
            const double phi = 2 * kPi * (column + 0.3) / steps;
            const glm::dvec3 light = frame * glm::dvec3(std::sin(alpha) * std::cos(phi), std::sin(alpha) * std::sin(phi), std::cos(alpha));
            const double c = cookTorrance(view, light, normal, m, 1, distribution, normalization);
            if (c == 0) continue;
            const double d = cookTorrance(view, light, normal, m, 0, distribution, normalization);
            const glm::dvec3 local(std::cos(azimuth) * light.x + std::sin(azimuth) * light.y,
                                   std::cos(azimuth) * light.y - std::sin(azimuth) * light.x, light.z);
            const ShDouble basis = evaluateBasis(local);
            for (std::size_t i = 0; i < kShCount; ++i) {
                kernel.c[i] += weight * c * light.z * basis[i];
                kernel.d[i] += weight * d * light.z * basis[i];
            }
        }
    }
    return kernel;
}

double albedo(const AreaSpecularKernel& kernel) {
    return kernel.c[0] * std::sqrt(4 * kPi);
}

TEST(Schlick, RunsFromF0ToOne) {
    EXPECT_DOUBLE_EQ(schlick(0.04, 1), 0.04);
    EXPECT_DOUBLE_EQ(schlick(0.04, 0), 1);
    EXPECT_DOUBLE_EQ(schlick(0.2, 0.5), 0.2 + 0.8 / 32);  // not (1 - LoH^5), as the paper prints
}

TEST(Distribution, CosineWeightedIntegralIsOne) {
    for (const double m : {0.001, 0.01, 0.1, 0.25, 0.5, 1.0, 2.0}) {
        EXPECT_NEAR(hemisphereIntegral([m](double c) { return c * distributionBeckmann(c, m); }), 1, 1e-8) << m;
        EXPECT_NEAR(hemisphereIntegral([m](double c) { return c * distributionGgx(c, m); }), 1, 1e-8) << m;
    }
}

TEST(Distribution, IsFiniteToTheHorizonAndZeroBehindIt) {
    for (const double m : {0.001, 0.1, 1.0})
        for (const double c : {1.0, 0.5, 1e-3, 1e-8, 1e-100, 1e-300}) {
            EXPECT_TRUE(std::isfinite(distributionBeckmann(c, m))) << c << ' ' << m;
            EXPECT_TRUE(std::isfinite(distributionGgx(c, m))) << c << ' ' << m;
        }
    EXPECT_EQ(distributionBeckmann(0, 0.5), 0);
    EXPECT_EQ(distributionBeckmann(-0.5, 0.5), 0);
    EXPECT_EQ(distributionGgx(-0.5, 0.5), 0);
}

TEST(Attenuation, IsTheSmallestOfThree) {
    EXPECT_DOUBLE_EQ(attenuationCookTorrance(0.9, 0.8, 0.7, 0.75), 1);
    EXPECT_DOUBLE_EQ(attenuationCookTorrance(0.5, 0.1, 0.7, 0.8), 2 * 0.5 * 0.1 / 0.8);
    EXPECT_DOUBLE_EQ(attenuationCookTorrance(0.5, 0.7, 0.2, 0.8), 2 * 0.5 * 0.2 / 0.8);
}

TEST(CookTorrance, IsTheProductOfItsFactorsAndReciprocal) {
    std::mt19937_64 random(51);
    for (int trial = 0; trial < 2000; ++trial) {
        const glm::dvec3 n = randomDirection(random), v = randomDirection(random), l = randomDirection(random);
        const double NoV = glm::dot(n, v), NoL = glm::dot(n, l);
        const double value = cookTorrance(v, l, n, 0.4, 0.3, kGgx, kEnergy);
        if (NoV <= 0 || NoL <= 0) {
            EXPECT_EQ(value, 0);
            continue;
        }
        const glm::dvec3 h = glm::normalize(v + l);
        const double NoH = glm::dot(n, h), VoH = glm::dot(v, h);
        for (const auto distribution : {kBeckmann, kGgx}) {
            const double D = distribution == kBeckmann ? distributionBeckmann(NoH, 0.4) : distributionGgx(NoH, 0.4);
            const double expected = schlick(0.3, VoH) * D * attenuationCookTorrance(NoH, NoV, NoL, VoH) / (4 * NoL * NoV);
            EXPECT_NEAR(cookTorrance(v, l, n, 0.4, 0.3, distribution, kEnergy), expected, 1e-12 * (1 + expected));
            EXPECT_NEAR(cookTorrance(v, l, n, 0.4, 0.3, distribution, kHalo3), 4 * expected, 1e-12 * (1 + 4 * expected));
            EXPECT_NEAR(cookTorrance(l, v, n, 0.4, 0.3, distribution, kEnergy), expected, 1e-12 * (1 + expected));
        }
    }
}

// Listing 2 without its Fresnel term, times the cosine that the listing cancels.
TEST(CookTorrance, Halo3NormalizationIsListingTwo) {
    std::mt19937_64 random(52);
    const glm::dvec3 n(0, 0, 1);
    for (int trial = 0; trial < 1000; ++trial) {
        const glm::dvec3 v = randomDirection(random), l = randomDirection(random);
        if (std::min(v.z, l.z) < 0.01) continue;
        const double m = 0.05 + 0.9 * (trial / 1000.0);
        const glm::dvec3 h = glm::normalize(v + l);
        const double G = 2 * h.z * std::min(l.z, v.z) / std::clamp(glm::dot(v, h), 0.0, 1.0), c2 = h.z * h.z;
        const double D = std::exp((c2 - 1) / (m * m * c2)) / (m * m * c2 * c2);
        const double listing = D * std::clamp(G, 0.0, 1.0) / (3.14159265 * v.z);
        EXPECT_NEAR(cookTorrance(v, l, n, m, 1, kBeckmann, kHalo3) * l.z, listing, 1e-7 * (1 + listing));
    }
}

TEST(CookTorrance, StaysFiniteAndNonNegativeAtGrazingAngles) {
    const glm::dvec3 n(0, 0, 1);
    for (const double m : {0.001, 0.01, 0.3, 1.0})
        for (const double viewZ : {1.0, 0.5, 1e-3, 1e-9, 1e-29, 1e-160, 1e-310, 0.0, -1e-9})
            for (const double lightZ : {1.0, 0.5, 1e-3, 1e-9, 1e-29, 1e-160, 1e-310, 0.0, -1e-9})
                for (const double phi : {0.0, 1.0, kPi / 2, kPi})
                    for (const auto distribution : {kBeckmann, kGgx}) {
                        const glm::dvec3 v(std::sqrt(1 - viewZ * viewZ), 0, viewZ);
                        const double r = std::sqrt(1 - lightZ * lightZ);
                        const glm::dvec3 l(r * std::cos(phi), r * std::sin(phi), lightZ);
                        const double value = cookTorrance(v, l, n, m, 0.04, distribution, kHalo3);
                        EXPECT_TRUE(std::isfinite(value)) << m << ' ' << viewZ << ' ' << lightZ << ' ' << phi;
                        EXPECT_GE(value, 0);
                    }
}

TEST(Phong, LobesAreNormalized) {
    for (const double s : {0.0, 1.0, 2.0, 7.0, 16.0, 256.0, 1024.0, 16384.0}) {
        EXPECT_NEAR(hemisphereIntegral([s](double c) { return phongLobe(c, s); }), 1, 1e-8) << s;
        EXPECT_NEAR(hemisphereIntegral([s](double c) { return phongLobeGame(c, s); }), kPi, 1e-7) << s;
    }
    EXPECT_DOUBLE_EQ(phongLobe(0.5, 1), 2 / (2 * kPi) * 0.5);  // exponent 1 is Lambert around the reflection vector
    EXPECT_EQ(phongLobe(-0.5, 2), 0);                          // an even power would count the back side
    EXPECT_EQ(phongLobeGame(-0.5, 2), 0);
}

TEST(Phong, AppendixBLobeIsNormalizedOverItsHemisphere) {
    for (const double m : {0.001, 0.02, 0.1, 0.25, 0.5, 1.0})
        EXPECT_NEAR(hemisphereIntegral([m](double c) { return phongBeckmannLobe(c, m); }), 1, 1e-8) << m;
    EXPECT_EQ(phongBeckmannLobe(0, 0.5), 0);
    EXPECT_EQ(phongBeckmannLobe(-0.3, 0.5), 0);  // cos^3 would be negative there
    EXPECT_TRUE(std::isfinite(phongBeckmannLobe(1e-200, 0.5)));
}

// The reference of 800 steps is within 6e-7 of the one of 1600 steps; at 3200 steps and a kernel of 8192 samples both agree to 5e-8.
TEST(AreaSpecular, AgreesWithBruteForceOverTheSphere) {
    struct Case {
        double NoV, m;
    };
    for (const auto distribution : {kBeckmann, kGgx})
        for (const auto& [NoV, m] : {Case{1, 0.1}, {0.9, 0.25}, {0.5, 0.05}, {0.35, 0.5}, {0.7, 1}, {0.1, 0.2}}) {
            const AreaSpecularKernel expected = bruteForce(NoV, m, distribution, kEnergy, 800);
            const AreaSpecularKernel kernel = integrateAreaSpecular(NoV, m, distribution, kEnergy, 512);
            for (std::size_t i = 0; i < kShCount; ++i) {
                EXPECT_NEAR(kernel.c[i], expected.c[i], 1e-6) << name(distribution) << ' ' << NoV << ' ' << m << ' ' << i;
                EXPECT_NEAR(kernel.d[i], expected.d[i], 1e-6) << name(distribution) << ' ' << NoV << ' ' << m << ' ' << i;
            }
        }
}

TEST(AreaSpecular, CoefficientsOneFourAndFiveVanishInBruteForce) {
    for (const auto distribution : {kBeckmann, kGgx})
        for (const double NoV : {0.2, 0.6, 0.95}) {
            const AreaSpecularKernel kernel = bruteForce(NoV, 0.3, distribution, kHalo3, 400);
            for (const std::size_t i : {1, 4, 5}) {
                EXPECT_NEAR(kernel.c[i], 0, 2e-5) << NoV << ' ' << i;
                EXPECT_NEAR(kernel.d[i], 0, 2e-5) << NoV << ' ' << i;
            }
        }
}

TEST(AreaSpecular, FurnaceAlbedoOfASmoothSurfaceIsOneAndFour) {
    for (const auto distribution : {kBeckmann, kGgx})
        for (const double NoV : {0.3, 0.7, 1.0}) {
            const double tolerance = distribution == kBeckmann ? 1e-6 : 3e-4;  // GGX's tail is shadowed at any roughness
            EXPECT_NEAR(albedo(integrateAreaSpecular(NoV, 0.005, distribution, kEnergy, 256)), 1, tolerance);
            EXPECT_NEAR(albedo(integrateAreaSpecular(NoV, 0.005, distribution, kHalo3, 256)), 4, 4 * tolerance);
        }
    EXPECT_NEAR(albedo(bruteForce(0.7, 0.02, kBeckmann, kEnergy, 600)), 1, 1e-5);
    EXPECT_NEAR(albedo(bruteForce(0.7, 0.02, kBeckmann, kHalo3, 600)), 4, 4e-5);
}

TEST(AreaSpecular, NeverReflectsMoreThanItReceives) {
    for (const auto distribution : {kBeckmann, kGgx})
        for (const double m : {0.001, 0.03, 0.1, 0.3, 0.6, 1.0})
            for (const double NoV : {0.02, 0.1, 0.4, 0.8, 1.0}) {
                const AreaSpecularKernel kernel = integrateAreaSpecular(NoV, m, distribution, kEnergy, 128);
                EXPECT_LE(albedo(kernel), 1 + 1e-5) << m << ' ' << NoV;
                EXPECT_GT(albedo(kernel), 0.2);
                EXPECT_LE(kernel.d[0], kernel.c[0]);
                EXPECT_GE(kernel.d[0], 0);
            }
}

TEST(AreaSpecular, HasTheMeasuredRangesOfTheNotes) {
    EXPECT_NEAR(integrateAreaSpecular(1, 1.0 / 16, kBeckmann, kHalo3, 512).c[6], 2.465, 5e-4);
    EXPECT_NEAR(integrateAreaSpecular(1, 0.1, kBeckmann, kHalo3, 512).c[6], 2.3775, 5e-4);
    // The course notes do not give the range of views and roughness of their suprema; m >= 1/32 (the centre of the first of 16 rows) and
    // NoV >= 0.02 give all six to the last printed digit.
    ShBands highestC{}, highestD{};
    double highestEnergy = 0;
    for (int row = 0; row < 16; ++row)
        for (int column = 0; column < 33; ++column) {
            const double m = (row + 0.5) / 16, NoV = 0.02 + 0.98 * column / 32;
            const AreaSpecularKernel kernel = integrateAreaSpecular(NoV, m, kBeckmann, kHalo3, 256);
            const AreaSpecularKernel energy = integrateAreaSpecular(NoV, m, kBeckmann, kEnergy, 256);
            for (std::size_t l = 0; l < 3; ++l) {
                highestC[l] = std::max(highestC[l], bandLengths(kernel.c)[l]);
                highestD[l] = std::max(highestD[l], bandLengths(kernel.d)[l]);
            }
            for (std::size_t i = 0; i < kShCount; ++i) {
                highestEnergy = std::max({highestEnergy, std::abs(energy.c[i]), std::abs(energy.d[i])});
                EXPECT_NEAR(4 * energy.c[i], kernel.c[i], 1e-14);
                EXPECT_NEAR(4 * energy.d[i], kernel.d[i], 1e-14);
            }
        }
    const ShBands notesC = {1.128, 1.952, 2.515}, notesD = {0.889, 1.539, 1.985};
    for (std::size_t l = 0; l < 3; ++l) {
        EXPECT_NEAR(highestC[l], notesC[l], 1e-3);
        EXPECT_NEAR(highestD[l], notesD[l], 1e-3);
    }
    EXPECT_LT(highestEnergy, 0.63);
    EXPECT_GT(highestEnergy, 0.62);
}

// Integrals of shared/tools/score_light_map.py for the fourth of its eight views, m = 0.25, F0 = 0.6. Its plain midpoints in the
// cumulative distribution err by 0.35 m^2 / 512 of the derivative, hence 1e-4; its view is not in the x-z plane, hence the rotation.
TEST(AreaSpecular, AgreesWithTheScoringTool) {
    const ShDouble tool = {0.16323483252092796,  -0.1771351726459652,  0.14774621404921567, -0.13580623370527503, 0.19072643926572286,
                           -0.18971319428538158, -0.00677196447369604, -0.1454495598742124, -0.051271220529735206};
    const glm::dvec3 view = fibonacciHemisphere(3, 8);
    const AreaSpecularKernel kernel = integrateAreaSpecular(view.z, 0.25, kBeckmann, kEnergy, 512);
    const glm::dvec3 x = glm::normalize(glm::dvec3(view.x, view.y, 0)), z(0, 0, 1);
    const ShRotation toolFromLocal(glm::dmat3(x, glm::cross(z, x), z));
    const ShDouble c = toolFromLocal.apply(kernel.c), d = toolFromLocal.apply(kernel.d);
    for (std::size_t i = 0; i < kShCount; ++i) EXPECT_NEAR(0.6 * c[i] + 0.4 * d[i], tool[i], 1e-4) << i;
}

TEST(AreaSpecular, ConvergesWithTheSampleCount) {
    for (const auto distribution : {kBeckmann, kGgx})
        for (const double m : {0.001, 0.02, 0.1, 0.5, 1.0})
            for (const double NoV : {0.05, 0.5, 1.0}) {
                const AreaSpecularKernel fine = integrateAreaSpecular(NoV, m, distribution, kEnergy, 2000);
                for (const int count : {511, 512}) {
                    const AreaSpecularKernel kernel = integrateAreaSpecular(NoV, m, distribution, kEnergy, count);
                    for (std::size_t i = 0; i < kShCount; ++i) {
                        EXPECT_NEAR(kernel.c[i], fine.c[i], 2e-6) << name(distribution) << ' ' << m << ' ' << NoV << ' ' << count;
                        EXPECT_NEAR(kernel.d[i], fine.d[i], 2e-6) << name(distribution) << ' ' << m << ' ' << NoV << ' ' << count;
                    }
                }
            }
}

TEST(AreaSpecular, IsFiniteAtGrazingViewsAndTinyRoughness) {
    for (const auto distribution : {kBeckmann, kGgx})
        for (const double m : {0.001, 0.01, 0.1, 1.0})
            for (const double NoV : {0.0, 1e-12, 1e-6, 1e-3, 1.0})
                for (const int count : {1, 2, 3, 64}) {
                    const AreaSpecularKernel kernel = integrateAreaSpecular(NoV, m, distribution, kEnergy, count);
                    for (std::size_t i = 0; i < kShCount; ++i) {
                        EXPECT_TRUE(std::isfinite(kernel.c[i])) << name(distribution) << ' ' << m << ' ' << NoV << ' ' << count;
                        EXPECT_TRUE(std::isfinite(kernel.d[i])) << name(distribution) << ' ' << m << ' ' << NoV << ' ' << count;
                    }
                }
}

TEST(AreaSpecular, ANarrowLobeIsADeltaAlongTheReflection) {
    for (const double NoV : {0.2, 0.6, 1.0}) {
        const AreaSpecularKernel kernel = integrateAreaSpecular(NoV, 0.001, kBeckmann, kEnergy, 128);
        const ShDouble mirror = evaluateBasis(glm::dvec3(-std::sqrt(1 - NoV * NoV), 0, NoV));
        for (std::size_t i = 0; i < kShCount; ++i) {
            EXPECT_NEAR(kernel.c[i], mirror[i], 2e-5) << NoV << ' ' << i;
            EXPECT_NEAR(kernel.d[i], std::pow(1 - NoV, 5) * mirror[i], 2e-5) << NoV << ' ' << i;
        }
    }
}

}  // namespace
}  // namespace lightcook::lighting

#include "lighting/sh.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <random>

#include "tests/lighting/quadrature.h"

namespace lightcook::lighting {
namespace {

using test::kPi;
using test::overSphere;
using test::randomDirection;
using test::randomRotation;

template <class Function>
ShDouble project(Function function) {
    ShDouble result{};
    overSphere(40, [&](const glm::dvec3& w, double weight) {
        const ShDouble basis = evaluateBasis(w);
        for (std::size_t i = 0; i < kShCount; ++i) result[i] += weight * function(w) * basis[i];
    });
    return result;
}

/// A function without band limit and symmetry; 40 heights integrate it up to rounding.
double lopsided(const glm::dvec3& w) {
    return std::exp(glm::dot(w, glm::dvec3(0.7, -1.1, 0.4))) * (1 + 0.5 * w.x * w.y * w.y);
}

TEST(ShBasis, IsOrthonormal) {
    double gram[kShCount][kShCount] = {};
    overSphere(8, [&](const glm::dvec3& w, double weight) {
        const ShDouble basis = evaluateBasis(w);
        for (std::size_t i = 0; i < kShCount; ++i)
            for (std::size_t j = 0; j < kShCount; ++j) gram[i][j] += weight * basis[i] * basis[j];
    });
    for (std::size_t i = 0; i < kShCount; ++i)
        for (std::size_t j = 0; j < kShCount; ++j) EXPECT_NEAR(gram[i][j], i == j ? 1 : 0, 1e-13) << i << ' ' << j;
}

TEST(ShBasis, HasTheCanonicalSignsAndOrder) {
    const glm::dvec3 w = glm::normalize(glm::dvec3(0.3, 0.5, 0.7));
    const ShDouble expected = {std::sqrt(1 / kPi) / 2,
                               std::sqrt(3 / (4 * kPi)) * w.y,
                               std::sqrt(3 / (4 * kPi)) * w.z,
                               std::sqrt(3 / (4 * kPi)) * w.x,
                               std::sqrt(15 / kPi) / 2 * w.x * w.y,
                               std::sqrt(15 / kPi) / 2 * w.y * w.z,
                               std::sqrt(5 / kPi) / 4 * (3 * w.z * w.z - 1),
                               std::sqrt(15 / kPi) / 2 * w.x * w.z,
                               std::sqrt(15 / kPi) / 4 * (w.x * w.x - w.y * w.y)};
    const ShDouble basis = evaluateBasis(w);
    const Sh basisFloat = evaluateBasis(glm::vec3(w));
    for (std::size_t i = 0; i < kShCount; ++i) {
        EXPECT_NEAR(basis[i], expected[i], 1e-15) << i;
        EXPECT_NEAR(basisFloat[i], expected[i], 2e-7) << i;
    }
}

TEST(ShBasis, AdditionTheoremHoldsInEachBand) {
    std::mt19937_64 random(11);
    for (int trial = 0; trial < 100; ++trial) {
        const ShDouble basis = evaluateBasis(randomDirection(random));
        double squared[3] = {};
        for (std::size_t i = 0; i < kShCount; ++i) squared[kShBand[i]] += basis[i] * basis[i];
        for (int l = 0; l < 3; ++l) EXPECT_NEAR(squared[l], (2 * l + 1) / (4 * kPi), 1e-14);
        EXPECT_NEAR(squared[0] + squared[1] + squared[2], 9 / (4 * kPi), 1e-14);
    }
}

TEST(Evaluate, ThreeOverloadsAgreeAndReproduceAProjectedQuadratic) {
    const auto quadratic = [](const glm::dvec3& w) { return 0.4 + 0.3 * w.x - 0.2 * w.z + w.x * w.y + 0.6 * w.z * w.z; };
    const ShDouble coefficients = project(quadratic);
    Sh narrow{};
    ShRgb colour{};
    for (std::size_t i = 0; i < kShCount; ++i) {
        narrow[i] = static_cast<float>(coefficients[i]);
        colour[i] = {narrow[i], 2 * narrow[i], -narrow[i]};
    }
    std::mt19937_64 random(12);
    for (int trial = 0; trial < 50; ++trial) {
        const glm::dvec3 w = randomDirection(random);
        EXPECT_NEAR(evaluate(coefficients, w), quadratic(w), 1e-13);
        const float value = evaluate(narrow, glm::vec3(w));
        EXPECT_NEAR(value, quadratic(w), 2e-6);
        const glm::vec3 rgb = evaluate(colour, glm::vec3(w));
        EXPECT_FLOAT_EQ(rgb.x, value);
        EXPECT_FLOAT_EQ(rgb.y, 2 * value);
        EXPECT_FLOAT_EQ(rgb.z, -value);
    }
}

TEST(ProjectDirectional, ReachesTheBandBoundsOfNonNegativeLight) {
    std::mt19937_64 random(13);
    for (int trial = 0; trial < 50; ++trial) {
        const ShRgb light = projectDirectional(glm::vec3(randomDirection(random)), {1, 2, 3});
        for (int channel = 0; channel < 3; ++channel) {
            double squared[3] = {};
            for (std::size_t i = 0; i < kShCount; ++i) squared[kShBand[i]] += light[i][channel] * light[i][channel];
            EXPECT_NEAR(std::sqrt(squared[1] / squared[0]), std::sqrt(3.0), 1e-6);
            EXPECT_NEAR(std::sqrt(squared[2] / squared[0]), std::sqrt(5.0), 1e-6);
            EXPECT_NEAR(std::sqrt(squared[0]), (channel + 1) / std::sqrt(4 * kPi), 1e-6);
        }
    }
}

TEST(ProjectDirectional, IsInsideTheBandBoundsForAnyMixOfLights) {
    std::mt19937_64 random(14);
    std::uniform_real_distribution<float> uniform(0, 1);
    for (int trial = 0; trial < 200; ++trial) {
        ShDouble sum{};
        for (int light = 0; light < 5; ++light) {
            const ShRgb one = projectDirectional(glm::vec3(randomDirection(random)), glm::vec3(uniform(random)));
            for (std::size_t i = 0; i < kShCount; ++i) sum[i] += one[i].x;
        }
        double squared[3] = {};
        for (std::size_t i = 0; i < kShCount; ++i) squared[kShBand[i]] += sum[i] * sum[i];
        EXPECT_LE(squared[1], 3 * squared[0] * (1 + 1e-5));
        EXPECT_LE(squared[2], 5 * squared[0] * (1 + 1e-5));
    }
}

TEST(Convolve, ScalesEachCoefficientByItsBand) {
    const ShBands bands = {0.5, -2, 4};
    Sh scalar{};
    ShRgb colour{};
    for (std::size_t i = 0; i < kShCount; ++i) {
        scalar[i] = static_cast<float>(i + 1);
        colour[i] = {scalar[i], 0, -scalar[i]};
    }
    const float expected[kShCount] = {0.5f, -4, -6, -8, 20, 24, 28, 32, 36};
    for (std::size_t i = 0; i < kShCount; ++i) {
        EXPECT_EQ(convolve(scalar, bands)[i], expected[i]);
        EXPECT_EQ(convolve(colour, bands)[i], glm::vec3(expected[i], 0, -expected[i]));
    }
}

TEST(ShRotation, EqualsProjectionOfTheRotatedFunction) {
    std::mt19937_64 random(15);
    const ShDouble source = project(lopsided);
    for (int trial = 0; trial < 10; ++trial) {
        const glm::dmat3 rotation = randomRotation(random);
        const glm::dmat3 inverse = glm::transpose(rotation);
        const ShDouble expected = project([&](const glm::dvec3& w) { return lopsided(inverse * w); });
        const ShDouble rotated = ShRotation(rotation).apply(source);
        for (std::size_t i = 0; i < kShCount; ++i) EXPECT_NEAR(rotated[i], expected[i], 1e-12) << i;
    }
}

TEST(ShRotation, FloatAndColourAgreeWithDouble) {
    std::mt19937_64 random(16);
    const ShDouble source = project(lopsided);
    Sh narrow{};
    ShRgb colour{};
    for (std::size_t i = 0; i < kShCount; ++i) {
        narrow[i] = static_cast<float>(source[i]);
        colour[i] = narrow[i] * glm::vec3(1, 0.5f, -2);
    }
    const ShRotation rotation(randomRotation(random));
    const ShDouble expected = rotation.apply(source);
    const Sh rotatedNarrow = rotation.apply(narrow);
    const ShRgb rotatedColour = rotation.apply(colour);
    for (std::size_t i = 0; i < kShCount; ++i) {
        EXPECT_NEAR(rotatedNarrow[i], expected[i], 2e-6);
        for (int channel = 0; channel < 3; ++channel)
            EXPECT_NEAR(rotatedColour[i][channel], expected[i] * glm::vec3(1, 0.5f, -2)[channel], 4e-6);
    }
}

TEST(ShRotation, ComposesAndInverts) {
    std::mt19937_64 random(17);
    const ShDouble source = project(lopsided);
    const glm::dmat3 first = randomRotation(random), second = randomRotation(random);
    const ShDouble inTwo = ShRotation(second).apply(ShRotation(first).apply(source));
    const ShDouble atOnce = ShRotation(second * first).apply(source);
    const ShDouble back = ShRotation(glm::transpose(first)).apply(ShRotation(first).apply(source));
    for (std::size_t i = 0; i < kShCount; ++i) {
        EXPECT_NEAR(inTwo[i], atOnce[i], 1e-13);
        EXPECT_NEAR(back[i], source[i], 1e-13);
    }
}

TEST(ShRotation, IdentityChangesNoBit) {
    const ShDouble source = project(lopsided);
    Sh narrow{};
    for (std::size_t i = 0; i < kShCount; ++i) narrow[i] = static_cast<float>(source[i]);
    EXPECT_EQ(ShRotation(glm::dmat3(1)).apply(narrow), narrow);
}

TEST(CondonShortley, FlipNegatesOddIndicesAndIsItsOwnInverse) {
    ShRgb source{};
    for (std::size_t i = 0; i < kShCount; ++i) source[i] = glm::vec3(static_cast<float>(i) + 1, 0.5f, -1);
    const ShRgb flipped = flipCondonShortley(source);
    for (std::size_t i = 0; i < kShCount; ++i) EXPECT_EQ(flipped[i], (i == 1 || i == 3 || i == 5 || i == 7) ? -source[i] : source[i]);
    EXPECT_EQ(flipCondonShortley(flipped), source);
}

TEST(Luminance, WeighsTheChannels) {
    ShRgb source{};
    source[4] = {1, 2, 3};
    const Sh weighed = luminance(source, kRec709Luminance);
    EXPECT_FLOAT_EQ(weighed[4], 0.2126f + 2 * 0.7152f + 3 * 0.0722f);
    EXPECT_EQ(weighed[0], 0);
}

}  // namespace
}  // namespace lightcook::lighting

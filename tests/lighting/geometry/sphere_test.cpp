#include "lighting/sphere.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "tests/lighting/quadrature.h"

namespace lightcook::lighting {
namespace {

using test::kPi;
using test::randomDirection;

void expectNear(const glm::dvec3& a, const glm::dvec3& b, double tolerance) {
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], tolerance);
}

TEST(TangentFrame, IsOrthonormalAndRightHandedEverywhere) {
    std::mt19937_64 random(31);
    std::vector<glm::dvec3> normals = {{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {0, -1, 0}, {1, 0, -0.0}, {1e-9, 0, -1}, {0, 1e-12, -1}};
    for (int trial = 0; trial < 1000; ++trial) normals.push_back(randomDirection(random));
    for (const glm::dvec3& n : normals) {
        const glm::dmat3 frame = worldFromTangentFrame(n);
        EXPECT_EQ(frame[2], n);
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) EXPECT_NEAR(glm::dot(frame[i], frame[j]), i == j ? 1 : 0, 1e-15);
        expectNear(glm::cross(frame[0], frame[1]), frame[2], 1e-15);
    }
}

// Values of frames() in shared/tools/score_light_map.py: the figures of the report use this frame.
TEST(TangentFrame, EqualsTheScoringToolsFrame) {
    const auto expectFrame = [](const glm::dvec3& n, const glm::dvec3& t, const glm::dvec3& b) {
        const glm::dmat3 frame = worldFromTangentFrame(n);
        expectNear(frame[0], t, 1e-15);
        expectNear(frame[1], b, 1e-15);
    };
    expectFrame({0, 0, 1}, {1, 0, 0}, {0, 1, 0});
    expectFrame({0, 0, -1}, {1, 0, 0}, {0, -1, 0});
    expectFrame({0.6, 0, 0.8}, {0.8, 0, -0.6}, {0, 1, 0});
    expectFrame({-0.48, 0.64, -0.6}, {0.856, 0.192, -0.48}, {-0.192, -0.744, -0.64});
    expectFrame({0.28, -0.96, 0}, {0.9216, 0.2688, -0.28}, {0.2688, 0.0784, 0.96});
}

// Values of the same tool's hemisphere(32).
TEST(Fibonacci, HemisphereEqualsTheScoringToolsPoints) {
    expectNear(fibonacciHemisphere(0, 32), {0.9998779222360098, 0, 0.015625}, 1e-14);
    expectNear(fibonacciHemisphere(1, 32), {-0.73655833494445588, 0.67474777035485689, 0.046875}, 1e-14);
    expectNear(fibonacciHemisphere(5, 32), {0.83119917536671273, -0.52874087722124963, 0.171875}, 1e-14);
    expectNear(fibonacciHemisphere(17, 32), {-0.83649933451751712, 0.034591873709749928, 0.546875}, 1e-13);
    expectNear(fibonacciHemisphere(31, 32), {0.095233308959486909, -0.14810967638755715, 0.984375}, 1e-13);
}

TEST(Fibonacci, PointsFollowTheGoldenAngle) {
    // The golden angle is the full turn minus its golden section.
    const double golden = 2 * kPi * (1 - 2 / (1 + std::sqrt(5.0)));
    for (int i = 0; i < 100; ++i) {
        const glm::dvec3 upper = fibonacciHemisphere(i, 100), whole = fibonacciSphere(i, 100);
        const double turn = std::remainder(std::atan2(upper.y, upper.x) - i * golden, 2 * kPi);
        EXPECT_NEAR(turn, 0, 1e-12);
        EXPECT_NEAR(std::remainder(std::atan2(whole.y, whole.x) - i * golden, 2 * kPi), 0, 1e-12);
        EXPECT_DOUBLE_EQ(upper.z, (i + 0.5) / 100);
        EXPECT_NEAR(whole.z, 1 - (2 * i + 1) / 100.0, 1e-15);
        EXPECT_NEAR(glm::length(upper), 1, 1e-15);
        EXPECT_NEAR(glm::length(whole), 1, 1e-15);
    }
}

TEST(Fibonacci, SphereIntegratesLowHarmonicsToZero) {
    glm::dvec3 mean(0), squares(0);
    for (int i = 0; i < 10000; ++i) {
        const glm::dvec3 w = fibonacciSphere(i, 10000);
        mean += w / 10000.0;
        squares += w * w / 10000.0;
    }
    expectNear(mean, {0, 0, 0}, 1e-4);
    expectNear(squares, glm::dvec3(1.0 / 3), 1e-4);
}

TEST(Equirectangular, LooksAlongMinusZInItsMiddle) {
    expectNear(directionFromEquirectangular({0.5, 0.5}), {0, 0, -1}, 1e-15);
    expectNear(directionFromEquirectangular({0.75, 0.5}), {1, 0, 0}, 1e-15);
    expectNear(directionFromEquirectangular({0.25, 0.5}), {-1, 0, 0}, 1e-15);
    expectNear(directionFromEquirectangular({0.1, 0}), {0, 1, 0}, 1e-15);
    expectNear(directionFromEquirectangular({0.9, 1}), {0, -1, 0}, 1e-15);
}

TEST(Equirectangular, RoundTrips) {
    std::mt19937_64 random(32);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (int trial = 0; trial < 10000; ++trial) {
        const glm::dvec3 w = randomDirection(random);
        const glm::dvec2 uv = equirectangularFromDirection(w);
        EXPECT_GE(uv.x, 0);
        EXPECT_LE(uv.x, 1);
        EXPECT_GE(uv.y, 0);
        EXPECT_LE(uv.y, 1);
        EXPECT_NEAR(uv.y, std::acos(w.y) / kPi, 1e-9);
        expectNear(directionFromEquirectangular(uv), w, 2e-15);
        const glm::dvec2 source(uniform(random), 0.001 + 0.998 * uniform(random));
        const glm::dvec2 back = equirectangularFromDirection(directionFromEquirectangular(source));
        EXPECT_NEAR(back.x, source.x, 1e-12);
        EXPECT_NEAR(back.y, source.y, 1e-14);
    }
    const glm::dvec2 pole = equirectangularFromDirection({0, 1, 0});
    EXPECT_EQ(pole.y, 0);
    EXPECT_TRUE(std::isfinite(pole.x));
    expectNear(directionFromEquirectangular(equirectangularFromDirection({1e-12, 1, 0})), {1e-12, 1, 0}, 1e-26);
    expectNear(directionFromEquirectangular(equirectangularFromDirection({1e-12, -1, 0})), {1e-12, -1, 0}, 1e-15);
}

TEST(Equirectangular, SolidAnglesAreTheExactZones) {
    for (const glm::ivec2 size : {glm::ivec2(1, 1), glm::ivec2(8, 4), glm::ivec2(7, 5), glm::ivec2(2048, 1024)}) {
        double sum = 0;
        for (int y = 0; y < size.y; ++y) {
            const double angle = equirectangularTexelSolidAngle(y, size.x, size.y);
            const double exact = 2 * kPi / size.x * (std::cos(kPi * y / size.y) - std::cos(kPi * (y + 1) / size.y));
            EXPECT_NEAR(angle, exact, 1e-15);
            sum += angle * size.x;
        }
        EXPECT_NEAR(sum, 4 * kPi, 1e-11);
    }
}

}  // namespace
}  // namespace lightcook::lighting

#include "fit/irradiance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <limits>

#include "lighting/radiometry.h"
#include "tests/fit/brute_force.h"

namespace lightcook {
namespace {

using truth::kPi;

formats::Image<glm::vec3> irradiance(const formats::Environment& environment, int size, double wrap = 0) {
    return fit::irradianceCubemap(environment, {size, wrap}).value();
}

glm::dvec3 bruteForce(const std::vector<truth::Sample>& samples, const glm::dvec3& normal, double wrap) {
    glm::dvec3 sum(0);
    for (const truth::Sample& sample : samples)
        sum += std::max(0.0, glm::dot(normal, sample.direction) + wrap) * sample.solidAngle * sample.radiance;
    return sum / (kPi * (1 + wrap) * (1 + wrap));
}

/// Largest relative error of a cubemap's texels against a reference function.
double worstError(const formats::Image<glm::vec3>& strip, const std::vector<truth::Sample>& samples, double wrap, int count) {
    truth::Random random(3);
    double worst = 0;
    const int size = strip.width();
    for (int i = 0; i < count; ++i) {
        const int x = random.below(size), row = random.below(6 * size);
        const glm::dvec3 expected = bruteForce(samples, lighting::cubeTexelDirection(row / size, x, row % size, size), wrap);
        for (int channel = 0; channel < 3; ++channel) worst = std::max(worst, std::abs(strip.at(x, row)[channel] / expected[channel] - 1));
    }
    return worst;
}

TEST(IrradianceCubemap, GreyStaysGreyForEveryWrap) {
    for (const double wrap : {0.0, 0.3, 1.0}) {
        for (const auto& environment :
             {truth::constantEquirectangular(256, 128, glm::vec3(0.5f)), truth::constantEquirectangular(2, 1, glm::vec3(0.5f)),
              truth::constantStrip(16, glm::vec3(0.5f)), truth::constantStrip(1, glm::vec3(0.5f))}) {
            const auto strip = irradiance(environment, 8, wrap);
            for (const glm::vec3& texel : strip.texels()) ASSERT_NEAR(texel.x, 0.5, 0.5e-6) << wrap;
        }
    }
}

TEST(IrradianceCubemap, MatchesBruteForceWithASunAndWithoutOne) {
    truth::Random random(8);
    for (const bool isStrip : {false, true}) {
        formats::Environment environment =
            isStrip ? truth::constantStrip(64, glm::vec3(0)) : truth::constantEquirectangular(256, 128, glm::vec3(0));
        for (glm::vec3& texel : environment.texels.texels()) {
            const float light = 0.2f + static_cast<float>(std::pow(random.uniform(), 8));
            texel = glm::vec3(light, 0.3f, 2 * light);
        }
        environment.texels.at(50, 40) = glm::vec3(20000, 10000, 5);
        const auto samples = truth::samplesOf(environment, 2);
        for (const double wrap : {0.0, 0.5})
            EXPECT_LT(worstError(irradiance(environment, 16, wrap), samples, wrap, 60), 0.003) << isStrip << wrap;
    }
}

/// The nine SH coefficients of the cubemap are those of the source times the zonal factors.
TEST(IrradianceCubemap, ItsHarmonicsAreTheSourcesTimesTheWrappedBands) {
    formats::Environment environment = truth::constantEquirectangular(256, 128, glm::vec3(0.1f));
    environment.texels.at(70, 30) = glm::vec3(3000);
    const lighting::ShRgb source = fit::projectEnvironment(environment);
    for (const double wrap : {0.0, 0.25, 1.0}) {
        const formats::Environment level{formats::Environment::Projection::CubeStrip, irradiance(environment, 64, wrap)};
        const lighting::ShRgb found = fit::projectEnvironment(level),
                              expected = lighting::convolve(source, lighting::wrappedLambertBands(wrap));
        for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i].x, expected[i].x, 1e-3 * expected[0].x) << wrap << " " << i;
    }
}

/// A game light of 1 as a small sun: a white surface that faces it gives exactly 1 here, 17/16 with nine coefficients, and 1 with D3DX's
/// factor.
TEST(IrradianceCubemap, AGameLightOfOneShowsOneAndItsNineCoefficientsDoNot) {
    formats::Environment environment = truth::constantStrip(513, glm::vec3(0));
    const double radiance = kPi / lighting::cubeTexelSolidAngle(256, 256, 513);
    environment.texels.at(256, 2 * 513 + 256) = glm::vec3(static_cast<float>(radiance));  // +Y
    EXPECT_NEAR(irradiance(environment, 1).at(0, 2).x, 1, 1e-4);
    EXPECT_NEAR(irradiance(environment, 1).at(0, 0).x, 0, 1e-2);
    EXPECT_EQ(irradiance(environment, 1).at(0, 3).x, 0);
    const glm::vec3 up(0, 1, 0);
    const lighting::ShRgb projected = fit::projectEnvironment(environment);
    for (const auto normalization : {lighting::GameLightNormalization::None, lighting::GameLightNormalization::D3dx}) {
        const lighting::ShRgb light = lighting::projectGameLight({glm::vec3(1)}, up, normalization);
        const double white = lighting::lambertExitRadiance(light, up, glm::vec3(1)).value.x;
        const bool isRescaled = normalization == lighting::GameLightNormalization::D3dx;
        EXPECT_NEAR(white, isRescaled ? 1.0 : 17.0 / 16, 1e-6);
        for (std::size_t i = 0; i < light.size(); ++i) EXPECT_NEAR(light[i].x, projected[i].x * (isRescaled ? 16.0 / 17 : 1.0), 1e-4) << i;
    }
}

TEST(IrradianceCubemap, ExtremesStayFiniteAndInRange) {
    constexpr float kLargest = std::numeric_limits<float>::max();
    for (const float sun : {0.0f, 1e-42f, 1e6f, 1e30f, kLargest}) {
        formats::Environment environment = truth::constantEquirectangular(64, 32, glm::vec3(0));
        environment.texels.at(40, 10) = glm::vec3(sun, 0, sun / 2);
        const auto strip = irradiance(environment, 4);
        for (const glm::vec3& texel : strip.texels()) {
            ASSERT_TRUE(texel.x >= 0 && texel.x <= sun) << texel.x;
            ASSERT_EQ(texel.y, 0);
        }
    }
    EXPECT_FALSE(fit::irradianceCubemap(truth::constantStrip(4, glm::vec3(1)), {0, 0}));
    EXPECT_FALSE(fit::irradianceCubemap(truth::constantStrip(4, glm::vec3(1)), {8, 1.5}));
    EXPECT_FALSE(fit::irradianceCubemap(truth::constantStrip(4, glm::vec3(1)), {8, -0.1}));
    EXPECT_FALSE(fit::irradianceCubemap({}, {8, 0}));
    for (const int cells : {0, 2, 33, 256}) EXPECT_FALSE(fit::irradianceCubemap(truth::constantStrip(4, glm::vec3(1)), {8, 0, cells}));
}

TEST(IrradianceCubemapSoak, OfSharedPanoramasMatchesBruteForceInHalfASecond) {
    const std::filesystem::path data = LIGHTCOOK_SHARED_DATA;
    for (const char* name : {"rooitou_park_1k", "kiara_1_dawn_1k"}) {
        const auto file = data / "env" / (std::string(name) + ".hdr");
        if (!std::filesystem::exists(file)) GTEST_SKIP() << "shared data is absent: " << file;
        const auto loaded = formats::loadEnvironment(file, {});
        ASSERT_TRUE(loaded) << loaded.error().line();
        const std::clock_t begin = std::clock();
        const auto strip = irradiance(loaded->environment, 32);
        const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
        const double worst = worstError(strip, truth::samplesOf(loaded->environment, 1), 0, 60);
        std::printf("[ figures  ] %s, irradiance 32x32x6: %.4f CPU s, worst of 60 texels %.4f %%\n", name, seconds, 100 * worst);
        EXPECT_LT(worst, 0.002);
        EXPECT_LT(seconds, 0.5);  // ten times the usual duration, for slow machines
    }
}

}  // namespace
}  // namespace lightcook

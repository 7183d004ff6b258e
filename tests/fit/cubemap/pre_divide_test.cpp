#include "fit/pre_divide.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "fit/cubemap.h"
#include "lighting/quadratic.h"
#include "tests/fit/brute_force.h"

namespace lightcook {
namespace {

using truth::kPi;

std::vector<lighting::ShBands> chainBands(fit::PrefilterKernel kernel = fit::PrefilterKernel::Beckmann) {
    std::vector<lighting::ShBands> bands;
    for (int mip = 0; mip < 8; ++mip) bands.push_back(fit::prefilterKernelBands(kernel, mip * mip / 49.0));
    return bands;
}

double smallestOverMean(const fit::PreDivide& preDivide, int mip, int channel) {
    const lighting::ShBands& bands = preDivide.bands[static_cast<std::size_t>(mip)];
    lighting::ShDouble sh;
    for (std::size_t i = 0; i < sh.size(); ++i)
        sh[i] = static_cast<double>(preDivide.windowedSh[i][channel]) / preDivide.windowedSh[0][channel];
    return lighting::extremaOnSphere(lighting::sphereQuadratic(sh, bands)).minimum / (0.5 * std::sqrt(1 / kPi));
}

formats::Environment sunOverBlack(float radiance) {
    formats::Environment environment = truth::constantEquirectangular(256, 128, glm::vec3(0));
    environment.texels.at(150, 40) = glm::vec3(radiance, 0.8f * radiance, 0);
    return environment;
}

/// Divides a whole filtered chain and multiplies it back.
void expectProductReturns(const formats::Environment& environment, int size) {
    fit::CubemapOptions options;
    options.size = size;
    const auto filter = fit::CubemapPrefilter::create(environment, options);
    ASSERT_TRUE(filter);
    std::vector<lighting::ShBands> bands;
    for (const fit::MipKernel& mip : filter->mips()) bands.push_back(mip.bands);
    const fit::PreDivide preDivide = fit::makePreDivide(fit::projectEnvironment(environment), bands, {});
    for (int mip = 0; mip < filter->mipCount(); ++mip) {
        const int mipSize = filter->mips()[static_cast<std::size_t>(mip)].size;
        const auto prefiltered = filter->filterMip(mip);
        formats::Image<glm::vec3> divided = prefiltered.copy();
        for (int face = 0; face < 6; ++face) {
            const auto rows = prefiltered.view().rows(face * mipSize, mipSize);
            const auto stored = divided.view().rows(face * mipSize, mipSize);
            fit::preDivideRows(preDivide, mip, face, 0, stored);
            for (int y = 0; y < mipSize; ++y) {
                for (int x = 0; x < mipSize; ++x) {
                    const glm::dvec3 s = preDivide.denominator(mip, lighting::cubeTexelDirection(face, x, y, mipSize));
                    for (int channel = 0; channel < 3; ++channel) {
                        const double value = stored.at(x, y)[channel], expected = rows.at(x, y)[channel];
                        ASSERT_TRUE(std::isfinite(value) && value >= 0);
                        ASSERT_GT(s[channel], 0);
                        // Rounding of a float; its smallest step for a denormal quotient.
                        ASSERT_NEAR(value * s[channel], expected, 1e-6 * expected + 1.5e-45 * s[channel]);
                    }
                }
            }
        }
    }
}

TEST(PreDivide, ProductReturnsThePrefilteredValue) {
    truth::Random random(3);
    formats::Environment noise = truth::constantEquirectangular(64, 32, glm::vec3(0));
    for (glm::vec3& texel : noise.texels.texels()) texel = glm::vec3(static_cast<float>(std::pow(random.uniform(), 20) * 1000), 0.1f, 1);
    expectProductReturns(noise, 16);
    expectProductReturns(truth::constantStrip(16, glm::vec3(0.5f)), 16);
}

TEST(PreDivide, SunOfAMillionOverBlackStaysFinite) {
    expectProductReturns(sunOverBlack(1e6f), 32);
}
TEST(PreDivide, TexelOf1e30StaysFinite) {
    expectProductReturns(sunOverBlack(1e30f), 8);
}
TEST(PreDivide, DenormalProbeStaysFinite) {
    expectProductReturns(truth::constantEquirectangular(16, 8, glm::vec3(1e-40f)), 4);
}

TEST(PreDivide, AProbeOfHardlyAnyMeanKeepsTheFloor) {
    lighting::ShRgb incident{};
    incident[0] = glm::vec3(1e-20f);
    incident[6] = glm::vec3(1e30f);
    const fit::PreDivide preDivide = fit::makePreDivide(incident, {{1, 1, 1}}, {});
    EXPECT_GE(smallestOverMean(preDivide, 0, 0), 0.05 - 1e-6);
}

TEST(PreDivide, BlackProbeStoresZero) {
    const fit::PreDivide preDivide = fit::makePreDivide({}, chainBands(), {});
    EXPECT_EQ(preDivide.windowLambda, 0);
    formats::Image<glm::vec3> black(8, 8, glm::vec3(0));
    fit::preDivideRows(preDivide, 3, 2, 0, black.view());
    for (const glm::vec3& texel : black.texels()) EXPECT_EQ(texel, glm::vec3(0));
    const glm::dvec3 s = preDivide.denominator(3, glm::dvec3(0, 1, 0));
    for (int channel = 0; channel < 3; ++channel) EXPECT_NEAR(s[channel], fit::kBlackDenominator, 1e-6 * fit::kBlackDenominator);
}

TEST(PreDivide, ConstantEnvironmentStoresOneAndNeedsNoWindow) {
    const auto sh = fit::projectEnvironment(truth::constantEquirectangular(128, 64, glm::vec3(0.5f)));
    const fit::PreDivide preDivide = fit::makePreDivide(sh, chainBands(), {});
    EXPECT_EQ(preDivide.windowLambda, 0);
    formats::Image<glm::vec3> grey(16, 16, glm::vec3(0.5f));
    fit::preDivideRows(preDivide, 2, 4, 0, grey.view());
    for (const glm::vec3& texel : grey.texels()) EXPECT_NEAR(texel.x, 1, 1e-6);
}

TEST(PreDivide, WindowIsTheSmallestThatKeepsTheFloor) {
    const auto sun = lighting::projectDirectional(glm::normalize(glm::vec3(1, 2, -0.5f)), glm::vec3(5, 3, 1));
    for (const double epsilon : {0.01, 0.05, 0.3}) {
        const fit::PreDivide preDivide = fit::makePreDivide(sun, chainBands(), {epsilon});
        ASSERT_GT(preDivide.windowLambda, 0);
        double smallest = 1;
        for (int mip = 0; mip < 8; ++mip) {
            for (int channel = 0; channel < 3; ++channel) smallest = std::min(smallest, smallestOverMean(preDivide, mip, channel));
        }
        EXPECT_GE(smallest, epsilon - 1e-9);
        EXPECT_LT(smallest, epsilon + 1e-4);  // no wider than it has to be
        EXPECT_NEAR(preDivide.window[1], 1 / (1 + 4 * preDivide.windowLambda), 1e-12);
        EXPECT_NEAR(preDivide.window[2], 1 / (1 + 36 * preDivide.windowLambda), 1e-12);
        EXPECT_EQ(preDivide.windowedSh[0], sun[0]);  // energy stays
    }
}

TEST(PreDivide, RandomProbesKeepTheFloorInEveryDirection) {
    truth::Random random(9);
    for (int trial = 0; trial < 300; ++trial) {
        lighting::ShRgb sh{};
        for (int light = 0; light < 3; ++light) {
            const auto one = lighting::projectDirectional(
                glm::vec3(random.direction()),
                glm::vec3(static_cast<float>(std::pow(random.uniform(), 6) * 100), 1, static_cast<float>(random.uniform())));
            for (std::size_t i = 0; i < sh.size(); ++i) sh[i] += one[i];
        }
        const auto kernel = static_cast<fit::PrefilterKernel>(trial % 3);
        const fit::PreDivide preDivide = fit::makePreDivide(sh, chainBands(kernel), {});
        const glm::dvec3 mean = glm::dvec3(preDivide.windowedSh[0]) * (0.5 * std::sqrt(1 / kPi));
        for (int sample = 0; sample < 300; ++sample) {
            const glm::dvec3 s = preDivide.denominator(sample % 8, random.direction());
            for (int channel = 0; channel < 3; ++channel) ASSERT_GE(s[channel], (0.05 - 1e-6) * mean[channel]);
        }
    }
}

TEST(PreDivide, QuotientsBeyondFloatAreClampedAndCounted) {
    const fit::PreDivide black = fit::makePreDivide({}, chainBands(), {});  // S is 1e-30 everywhere
    formats::Image<glm::vec3> bright(4, 4, glm::vec3(1e6f, 1e9f, 0));
    EXPECT_EQ(fit::preDivideRows(black, 2, 0, 0, bright.view()), 16) << "1e39 in green alone";
    for (const glm::vec3& texel : bright.texels()) {
        EXPECT_NEAR(texel.x, 1e36f, 1e30f);
        EXPECT_EQ(texel.y, std::numeric_limits<float>::max());
        EXPECT_EQ(texel.z, 0);
    }
}

TEST(PreDivide, SingleRowsGiveTheSameAsTheWholeFace) {
    const auto sh = fit::projectEnvironment(sunOverBlack(100));
    const fit::PreDivide preDivide = fit::makePreDivide(sh, chainBands(), {});
    formats::Image<glm::vec3> image(8, 8);
    truth::Random random(2);
    for (glm::vec3& texel : image.texels()) texel = glm::vec3(static_cast<float>(random.uniform()));
    formats::Image<glm::vec3> whole = image.copy();
    fit::preDivideRows(preDivide, 1, 5, 0, whole.view());
    for (const int row : {5, 0, 1, 2, 3, 4, 6, 7}) fit::preDivideRows(preDivide, 1, 5, row, image.view().rows(row, 1));
    EXPECT_EQ(image.texels(), whole.texels());
}

}  // namespace
}  // namespace lightcook

#include "fit/dominant_light.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <ctime>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "fit/light_search.h"
#include "tests/fit/brute_force.h"
#include "tests/soak/soak.h"

namespace lightcook {
namespace {

lighting::ShRgb randomSh(truth::Random& random, double magnitude) {
    lighting::ShRgb sh;
    for (glm::vec3& coefficient : sh) {
        for (int channel = 0; channel < 3; ++channel) coefficient[channel] = static_cast<float>(magnitude * (2 * random.uniform() - 1));
    }
    return sh;
}

bool isFinite(const glm::vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// A light of random magnitude whose coefficients are finite floats.
void checkOneLight(std::uint64_t seed, std::int64_t count) {
    truth::Random random(seed);
    for (std::int64_t trial = 0; trial < count; ++trial) {
        const glm::vec3 direction(random.direction());
        const double magnitude = random.below(4) == 0 ? std::pow(10, 60 * random.uniform() - 30) : 1;
        const glm::vec3 intensity(static_cast<float>(magnitude * random.uniform()), static_cast<float>(100 * magnitude * random.uniform()),
                                  static_cast<float>(0.25 * magnitude));
        const auto light = fit::dominantLight(lighting::projectDirectional(direction, intensity), glm::vec3(0, 0, 1), {});
        ASSERT_NEAR(glm::length(glm::dvec3(light.direction)), 1, 1e-6) << trial << " of seed " << seed;
        ASSERT_LT(glm::distance(light.direction, direction), 2e-6) << trial << " of seed " << seed;
        ASSERT_LT(glm::length(glm::dvec3(light.intensity) - glm::dvec3(intensity)), 1e-6 * glm::length(glm::dvec3(intensity)));
        ASSERT_NEAR(light.directionality, 1, 1e-6);
    }
}

TEST(DominantLight, OneDirectionalLightIsRecoveredExactlyManyTimes) {
    checkOneLight(1, 100000);
}

TEST(DominantLightSoak, OneDirectionalLightIsRecoveredExactly) {
    test::repeatInSoak("random cases", 100000, [](std::uint64_t seed) { checkOneLight(seed, 100000); });
}

TEST(DominantLight, IntensityIsTheLeastSquaresFitForItsDirection) {
    truth::Random random(2);
    for (int trial = 0; trial < 200; ++trial) {
        lighting::ShRgb sh = randomSh(random, 1);
        sh[0] = glm::vec3(4);  // light enough for a direction, and for intensities above zero
        for (std::size_t i = 4; i < sh.size(); ++i) sh[i] *= 0.1f;
        fit::DominantLightOptions options;
        options.fadeStart = 0;
        options.fadeEnd = 1e-6f;
        const auto light = fit::dominantLight(sh, glm::vec3(0, 0, 1), options);
        const lighting::ShDouble basis = lighting::evaluateBasis(glm::normalize(glm::dvec3(light.direction)));
        const auto error = [&](double c) {
            double sum = 0;
            for (std::size_t i = 0; i < basis.size(); ++i) sum += std::pow(sh[i].x - c * basis[i], 2);
            return sum;
        };
        ASSERT_GT(light.intensity.x, 0.1f);
        EXPECT_LT(error(light.intensity.x), error(light.intensity.x * 1.001));
        EXPECT_LT(error(light.intensity.x), error(light.intensity.x * 0.999));
    }
}

TEST(DominantLight, UniformLightFadesToTheNormalAndToNoIntensity) {
    lighting::ShRgb sh{};
    sh[0] = glm::vec3(3);
    const glm::vec3 normal = glm::normalize(glm::vec3(1, -2, 0.5f));
    const fit::DominantLightOptions options;
    const auto light = fit::dominantLight(sh, normal, options);
    EXPECT_LT(glm::distance(glm::normalize(light.direction), normal), 1e-6);
    EXPECT_EQ(light.intensity, glm::vec3(0));
    EXPECT_EQ(light.directionality, 0);
}

TEST(DominantLight, FadeHasNoJump) {
    const glm::vec3 normal(0, 0, 1);
    fit::DominantLight previous;
    for (int step = 0; step <= 2000; ++step) {
        lighting::ShRgb sh{};
        sh[0] = glm::vec3(1);
        sh[3] = glm::vec3(static_cast<float>(std::sqrt(3.0) * 0.2 * step / 2000));  // directionality from 0 to 0.2, sideways
        const auto light = fit::dominantLight(sh, normal, {});
        if (step > 0) {
            EXPECT_LT(glm::distance(light.direction, previous.direction), 1e-3) << step;
            EXPECT_LT(glm::distance(light.intensity, previous.intensity), 0.02) << step;
        }
        previous = light;
    }
    EXPECT_GT(previous.direction.x, 0.19f);
    EXPECT_LT(std::abs(previous.direction.z), 1e-6);
}

/// Zeros, denormals, the ends of float, single bands and single coefficients, either sign.
void checkClosedForm(std::uint64_t seed, std::int64_t count) {
    truth::Random random(seed);
    const double magnitudes[] = {0, 1e-45, 1e-40, 1e-38, 1e-10, 1, 1e10, 1e30, 3e38};
    for (std::int64_t trial = 0; trial < count; ++trial) {
        lighting::ShRgb sh = randomSh(random, magnitudes[random.below(9)]);
        const int kind = random.below(4), band = random.below(3), coefficient = random.below(9);
        for (int i = 0; i < 9; ++i) {
            const int own = i == 0 ? 0 : i < 4 ? 1 : 2;
            if ((kind == 1 && own != band) || (kind == 2 && i != coefficient)) sh[static_cast<std::size_t>(i)] = glm::vec3(0);
        }
        if (kind == 3) sh[static_cast<std::size_t>(coefficient)] = glm::vec3(static_cast<float>(magnitudes[random.below(9)]));
        const glm::vec3 normal = trial % 5 == 0 ? glm::vec3(0) : glm::vec3(random.direction());
        const auto light = fit::dominantLight(sh, normal, {});
        ASSERT_TRUE(isFinite(light.direction) && isFinite(light.intensity) && std::isfinite(light.directionality)) << trial;
        const double length = glm::length(glm::dvec3(light.direction));
        ASSERT_LE(length, 1 + 1e-6) << trial;
        ASSERT_GT(length, 1e-5) << trial << ": a shader could not make it unit";
        const float most = fit::largestIntensity(sh);
        for (int channel = 0; channel < 3; ++channel) {
            ASSERT_GE(light.intensity[channel], 0) << trial;
            ASSERT_LE(light.intensity[channel], most * 1.000001f) << trial;
        }
        ASSERT_TRUE(light.directionality >= 0 && light.directionality <= 1) << trial;
        // Without band 1 there is no direction, and so no light.
        if (kind == 1 && band != 1) {
            ASSERT_EQ(light.intensity, glm::vec3(0)) << trial;
        }
    }
}

TEST(DominantLight, AnyFiniteInputGivesAFiniteLightInsideTheBallManyTimes) {
    checkClosedForm(3, 100000);
}

TEST(DominantLightSoak, AnyFiniteInputGivesAFiniteLightInsideTheBall) {
    test::repeatInSoak("random cases", 100000, [](std::uint64_t seed) { checkClosedForm(seed, 100000); });
}

TEST(DominantLight, NegativeChannelIsClampedWithoutTouchingTheOthers) {
    lighting::ShRgb sh = lighting::projectDirectional(glm::vec3(0, 1, 0), glm::vec3(1, 2, 3));
    for (glm::vec3& coefficient : sh) coefficient.z = -0.1f * coefficient.z;
    const auto light = fit::dominantLight(sh, glm::vec3(0, 0, 1), {});
    EXPECT_EQ(light.intensity.z, 0);
    EXPECT_NEAR(light.intensity.x, 1, 1e-6);
    EXPECT_NEAR(light.intensity.y, 2, 2e-6);
}

TEST(DominantLight, LightFromBehindTheNormalKeepsADirection) {
    lighting::ShRgb sh{};
    sh[0] = glm::vec3(1);
    for (int step = 0; step <= 1000; ++step) {
        sh[2] = glm::vec3(static_cast<float>(-std::sqrt(3.0) * 0.1 * step / 1000));
        const auto light = fit::dominantLight(sh, glm::vec3(0, 0, 1), {});
        ASSERT_GT(glm::length(light.direction), 1e-5) << step;
    }
}

TEST(DominantLight, ImagesEqualTheTexelsAndAreZeroOutsideCharts) {
    truth::Random random(4);
    const int width = 7, height = 5;
    formats::Image<lighting::ShRgb> sh(width, height);
    formats::Image<std::uint8_t> covered(width, height);
    formats::Image<glm::vec3> normal(width, height), direction(width, height, glm::vec3(9)), intensity(width, height, glm::vec3(9));
    for (std::size_t i = 0; i < sh.texels().size(); ++i) {
        sh.texels()[i] = randomSh(random, 1);
        sh.texels()[i][0] = glm::vec3(2);
        covered.texels()[i] = i % 3 != 0;
        normal.texels()[i] = glm::vec3(random.direction());
    }
    fit::fitDominantLights({sh.view(), covered.view(), normal.view(), direction.view(), intensity.view()}, {});
    for (std::size_t i = 0; i < sh.texels().size(); ++i) {
        const auto light = covered.texels()[i] ? fit::dominantLight(sh.texels()[i], normal.texels()[i], {}) : fit::DominantLight{};
        EXPECT_EQ(direction.texels()[i], light.direction);
        EXPECT_EQ(intensity.texels()[i], light.intensity);
    }
}

fit::DominantLightOptions refinedOptions(bool hasAmbient) {
    fit::DominantLightOptions options;
    options.fit = hasAmbient ? fit::DominantFit::RefinedAmbient : fit::DominantFit::Refined;
    return options;
}

void checkRefined(std::uint64_t seed, std::int64_t count) {
    truth::Random random(seed);
    const double magnitudes[] = {0, 1e-45, 1e-38, 1e-10, 1, 1e10, 1e30, 3e38};
    for (std::int64_t trial = 0; trial < count; ++trial) {
        lighting::ShRgb sh = randomSh(random, magnitudes[random.below(8)]);
        if (trial % 3 != 0) sh[0] = glm::abs(sh[0]);
        const glm::vec3 normal = trial % 5 == 0 ? glm::vec3(0) : glm::vec3(random.direction());
        const auto light = fit::dominantLight(sh, normal, refinedOptions(trial % 2 == 0));
        ASSERT_TRUE(isFinite(light.direction) && isFinite(light.intensity) && std::isfinite(light.directionality));
        ASSERT_LE(glm::length(glm::dvec3(light.direction)), 1 + 1e-6);
        ASSERT_GT(glm::length(glm::dvec3(light.direction)), 1e-5);
        for (int channel = 0; channel < 3; ++channel) ASSERT_GE(light.intensity[channel], 0);
        const float most = fit::largestIntensity(sh);
        ASSERT_TRUE(std::isfinite(most));
        for (int channel = 0; channel < 3; ++channel) ASSERT_LE(light.intensity[channel], most * 1.000001f);
    }
}

TEST(RefinedDominantLight, AnyFiniteInputGivesAFiniteLightInsideTheBallManyTimes) {
    checkRefined(5, 100000);
}

TEST(RefinedDominantLightSoak, AnyFiniteInputGivesAFiniteLightInsideTheBall) {
    test::repeatInSoak("random cases", 100000, [](std::uint64_t seed) { checkRefined(seed, 100000); });
}

TEST(RefinedDominantLight, IsNeverWorseThanTheClosedForm) {
    truth::Random random(6);
    int skipped = 0;
    for (int trial = 0; trial < 200000; ++trial) {
        lighting::ShRgb sh = randomSh(random, trial % 4 == 0 ? 1e-3 : 1);
        const lighting::ShRgb source = lighting::projectDirectional(glm::vec3(random.direction()), glm::vec3(3, 2, 1));
        for (std::size_t i = 0; i < sh.size(); ++i) sh[i] += source[i];
        sh[0] += glm::vec3(1);
        const bool hasAmbient = trial % 2 == 0;
        fit::DominantLightOptions options = refinedOptions(hasAmbient), closedOptions;
        options.fadeStart = closedOptions.fadeStart = 0;
        options.fadeEnd = closedOptions.fadeEnd = 1e-6f;
        const auto refined = fit::dominantLight(sh, glm::vec3(0, 0, 1), options),
                   closed = fit::dominantLight(sh, glm::vec3(0, 0, 1), closedOptions);
        const auto left = [&](const fit::DominantLight& light) {
            return fit::lightTowards(sh, glm::normalize(glm::dvec3(light.direction)), hasAmbient).unexplained;
        };
        ASSERT_LE(left(refined), left(closed) + 1e-9) << trial;
        EXPECT_EQ(refined.directionality, closed.directionality);
        EXPECT_NEAR(glm::length(refined.direction), glm::length(closed.direction), 1e-6);
        if (!refined.isSearched) {
            ++skipped;
            EXPECT_EQ(refined.direction, closed.direction);
            const double best = fit::bestLight(sh, {0, 0, 1}, hasAmbient).unexplained;
            EXPECT_LT(std::sqrt(left(refined)), std::sqrt(best) + 1e-3 + 1e-6) << "left alone though it was worth a search";
        }
    }
    EXPECT_GT(skipped, 1000);
    EXPECT_LT(skipped, 60000);
}

TEST(RefinedDominantLight, FindsTheLightSourceThatBand1Misses) {
    // A light source and a dimmer one at its side: band 1 points between the two, the best light at the brighter.
    const glm::vec3 direction(0, 0, 1);
    lighting::ShRgb sh = lighting::projectDirectional(direction, glm::vec3(4));
    const lighting::ShRgb side = lighting::projectDirectional(glm::vec3(1, 0, 0), glm::vec3(2));
    for (std::size_t i = 0; i < sh.size(); ++i) sh[i] += side[i];
    const auto closed = fit::dominantLight(sh, direction, {});
    const auto refined = fit::dominantLight(sh, direction, refinedOptions(false));
    EXPECT_LT(glm::dot(glm::normalize(closed.direction), direction), 0.92f);
    EXPECT_GT(glm::dot(glm::normalize(refined.direction), direction), 0.98f);
    EXPECT_TRUE(refined.isSearched);
}

TEST(RefinedDominantLight, AmbientLightIsLeftOutOfTheIntensity) {
    lighting::ShRgb sh = lighting::projectDirectional(glm::vec3(0, 1, 0), glm::vec3(1, 2, 3));
    sh[0] += glm::vec3(2);
    const auto light = fit::dominantLight(sh, glm::vec3(0, 1, 0), refinedOptions(true));
    EXPECT_LT(glm::distance(light.intensity, glm::vec3(1, 2, 3)), 1e-5f);
}

TEST(RefinedDominantLight, ImagesCountTheSearchedTexels) {
    truth::Random random(7);
    const int width = 9, height = 8;
    formats::Image<lighting::ShRgb> sh(width, height);
    formats::Image<std::uint8_t> covered(width, height, 1);
    formats::Image<glm::vec3> normal(width, height, glm::vec3(0, 0, 1)), direction(width, height), intensity(width, height);
    for (int x = 0; x < width; ++x)
        for (int y = 0; y < height; ++y) {
            sh.at(x, y) = lighting::projectDirectional(glm::vec3(random.direction()), glm::vec3(1));  // row 0 and 1: one light
            if (y == 1) sh.at(x, y) = {};
            if (y < 2) continue;
            const auto other = lighting::projectDirectional(glm::vec3(random.direction()), glm::vec3(0.5f, 0.9f, 0.4f));
            for (std::size_t i = 0; i < other.size(); ++i) sh.at(x, y)[i] += other[i];
            covered.at(x, y) = y < 7;
        }
    const auto counts =
        fit::fitDominantLights({sh.view(), covered.view(), normal.view(), direction.view(), intensity.view()}, refinedOptions(false));
    EXPECT_EQ(counts.skipped, 2 * width);
    EXPECT_EQ(counts.refined, 5 * width);
    EXPECT_EQ(direction.at(3, 7), glm::vec3(0));
    const auto closed = fit::fitDominantLights({sh.view(), covered.view(), normal.view(), direction.view(), intensity.view()}, {});
    EXPECT_EQ(closed.refined, 0);
    EXPECT_EQ(closed.skipped, 7 * width);
}

TEST(DominantLightSoak, AMegapixelTakesSecondsByEveryFit) {
    truth::Random random(8);
    const int size = 512;
    formats::Image<lighting::ShRgb> sh(size, size);
    for (auto& texel : sh.texels()) {
        texel = randomSh(random, 0.5);
        texel[0] = glm::vec3(1);
    }
    formats::Image<std::uint8_t> covered(size, size, 1);
    formats::Image<glm::vec3> normal(size, size, glm::vec3(0, 0, 1)), direction(size, size), intensity(size, size);
    for (const fit::DominantFit which : {fit::DominantFit::Closed, fit::DominantFit::Refined, fit::DominantFit::RefinedAmbient}) {
        fit::DominantLightOptions options;
        options.fit = which;
        const std::clock_t begin = std::clock();
        fit::fitDominantLights({sh.view(), covered.view(), normal.view(), direction.view(), intensity.view()}, options);
        const double seconds = 4 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
        std::printf("[ figures  ] dominant light, 1024 x 1024 texels, %s: %.3f CPU s\n",
                    which == fit::DominantFit::Closed    ? "closed form"
                    : which == fit::DominantFit::Refined ? "refined"
                                                         : "refined with ambient",
                    seconds);
        EXPECT_LT(seconds, which == fit::DominantFit::Closed ? 2 : 30);
    }
}

}  // namespace
}  // namespace lightcook

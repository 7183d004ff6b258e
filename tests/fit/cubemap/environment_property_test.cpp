// Properties of SH projection, pre-division and kernels over millions of random inputs.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "fit/cubemap.h"
#include "fit/cubemap/kernel.h"
#include "fit/irradiance.h"
#include "fit/pre_divide.h"
#include "tests/fit/brute_force.h"
#include "tests/soak/soak.h"

namespace lightcook {
namespace {

constexpr long long kCases = 100'000;
constexpr fit::PrefilterKernel kKernels[] = {fit::PrefilterKernel::Beckmann, fit::PrefilterKernel::Ggx, fit::PrefilterKernel::Phong};

/// Zero, denormal, ordinary or enormous.
float anyLight(truth::Random& random) {
    switch (random.below(5)) {
        case 0:
            return 0;
        case 1:
            return static_cast<float>(1e-44 * std::pow(10, 8 * random.uniform()));
        case 2:
            return static_cast<float>(1e30 * random.uniform());
        default:
            return static_cast<float>(std::pow(10, 8 * random.uniform() - 4));
    }
}

/// Non-negative light has |band 1| <= sqrt(3) band 0 and |band 2| <= sqrt(5) band 0, and the projection is linear.
void projectAnything(long long cases, std::uint64_t seed) {
    truth::Random random(seed);
    for (long long i = 0; i < cases; i += 3) {  // three channels, three cases
        formats::Environment environment =
            random.below(2) == 0 ? truth::constantEquirectangular(4, 2, glm::vec3(0)) : truth::constantEquirectangular(2, 1, glm::vec3(0));
        for (glm::vec3& texel : environment.texels.texels()) texel = {anyLight(random), anyLight(random), anyLight(random)};
        const lighting::ShRgb sh = fit::projectEnvironment(environment);
        for (int channel = 0; channel < 3; ++channel) {
            double linear = 0, quadratic = 0;
            for (std::size_t k = 1; k < sh.size(); ++k)
                (k < 4 ? linear : quadratic) += static_cast<double>(sh[k][channel]) * sh[k][channel];
            const double constant = sh[0][channel], slack = 1e-5 * constant + 1e-43;
            ASSERT_TRUE(std::isfinite(constant) && constant >= 0) << i;
            ASSERT_LE(std::sqrt(linear), std::sqrt(3.0) * constant + slack) << i;
            ASSERT_LE(std::sqrt(quadratic), std::sqrt(5.0) * constant + slack) << i;
        }
    }
}

/// stored * S == prefiltered and S >= epsilon * mean (deringing), for light of any magnitude and SH with negative lobes.
void divideAnything(long long cases, std::uint64_t seed) {
    constexpr int kSize = 16, kTexels = 3 * kSize * kSize;
    truth::Random random(seed);
    for (long long done = 0; done < cases; done += kTexels) {
        lighting::ShRgb sh{};
        for (int channel = 0; channel < 3; ++channel) {
            const float light = anyLight(random);
            for (std::size_t k = 0; k < sh.size(); ++k)
                sh[k][channel] = k == 0 ? light : light * static_cast<float>(4 * random.uniform() - 2);
        }
        std::vector<lighting::ShBands> bands;
        for (int mip = 0; mip < 2; ++mip)
            bands.push_back(
                fit::prefilterKernelBands(kKernels[random.below(3)], random.below(8) == 0 ? 0 : 1e-4 + 0.9999 * random.uniform()));
        const fit::PreDivide divide = fit::makePreDivide(sh, bands, {});
        const int mip = random.below(2), face = random.below(6);
        formats::Image<glm::vec3> prefiltered(kSize, kSize);
        for (glm::vec3& texel : prefiltered.texels()) texel = {anyLight(random), anyLight(random), anyLight(random)};
        formats::Image<glm::vec3> stored = prefiltered.copy();
        std::int64_t clamped = fit::preDivideRows(divide, mip, face, 0, stored.view());
        for (int i = 0; i < kSize * kSize; ++i) {
            const glm::dvec3 s = divide.denominator(mip, lighting::cubeTexelDirection(face, i % kSize, i / kSize, kSize));
            for (int channel = 0; channel < 3; ++channel) {
                const double value = stored.at(i % kSize, i / kSize)[channel], expected = prefiltered.at(i % kSize, i / kSize)[channel];
                ASSERT_GT(s[channel], 0) << done;
                const double mean = static_cast<double>(divide.windowedSh[0][channel]) * 0.5 * std::sqrt(1 / truth::kPi);
                ASSERT_GE(s[channel], (divide.epsilon - 1e-5) * mean) << done;
                ASSERT_TRUE(std::isfinite(value) && value >= 0) << done;
                if (value == static_cast<double>(std::numeric_limits<float>::max()) && expected / s[channel] > value) {
                    --clamped;  // light 1e68 times its own area specular is held at the largest float, and counted
                    continue;
                }
                ASSERT_NEAR(value * s[channel], expected, 1e-6 * expected + 1.5e-45 * s[channel]) << done;
            }
        }
        ASSERT_EQ(clamped, 0) << done;
    }
}

/// Eight lanes against the definition in double, relative to the peak, at random angle, roughness and softening.
template <fit::PrefilterKernel kKernel>
void evaluateAnything(long long cases, std::uint64_t seed) {
    truth::Random random(seed);
    for (long long done = 0; done < cases; done += 64) {
        const double m = std::pow(10, -4 * random.uniform());
        const fit::KernelScale scale = fit::makeKernelScale(kKernel, m);
        ASSERT_TRUE(std::isfinite(scale.integral) && scale.integral > 0 && scale.integral < 4 * truth::kPi) << m;
        for (int group = 0; group < 8; ++group) {
            fit::Float8 chordSquared{};
            for (int lane = 0; lane < 8; ++lane) {
                const double reach = scale.supportChord * scale.supportChord * (scale.isNarrow ? 1.0 : 1.5);
                chordSquared[lane] = static_cast<float>(std::min(4.0, reach * std::pow(random.uniform(), 3)));
            }
            const float sharpness = scale.softened(0).sharpness;
            const fit::Float8 wide = fit::kernelShape<kKernel, false>(chordSquared, sharpness, scale);
            const fit::Float8 shape = scale.isNarrow ? fit::kernelShape<kKernel, true>(chordSquared, sharpness, scale) : wide;
            for (int lane = 0; lane < 8; ++lane) {
                const double expected = fit::prefilterKernelShapeAt(kKernel, m, 0.5 * static_cast<double>(chordSquared[lane]));
                ASSERT_NEAR(shape[lane], expected, 4e-6 * expected + 1e-7) << m << " chord^2 " << chordSquared[lane];
                ASSERT_NEAR(wide[lane], expected, 4e-6 * expected + 1e-7) << m << " chord^2 " << chordSquared[lane];
            }
        }
    }
}
void evaluateAnyKernel(long long cases, std::uint64_t seed) {
    evaluateAnything<fit::PrefilterKernel::Beckmann>(cases, seed);
    evaluateAnything<fit::PrefilterKernel::Ggx>(cases, seed + 1);
    evaluateAnything<fit::PrefilterKernel::Phong>(cases, seed + 2);
}

TEST(EnvironmentProperties, ProjectedBandsKeepTheirBounds) {
    projectAnything(kCases, 101);
}
TEST(EnvironmentProperties, DivisionMultipliesBack) {
    divideAnything(kCases, 102);
}
TEST(EnvironmentProperties, KernelsInLanesAreTheKernels) {
    evaluateAnyKernel(kCases, 103);
}
TEST(EnvironmentSoak, ProjectedBandsKeepTheirBounds) {
    test::repeatInSoak("random cases", kCases, [](std::uint64_t seed) { projectAnything(kCases, seed); });
}
TEST(EnvironmentSoak, DivisionMultipliesBack) {
    test::repeatInSoak("random cases", kCases, [](std::uint64_t seed) { divideAnything(kCases, seed); });
}
TEST(EnvironmentSoak, KernelsInLanesAreTheKernels) {
    test::repeatInSoak("random cases", 3 * kCases, [](std::uint64_t seed) { evaluateAnyKernel(kCases, 3 * seed); });
}

/// Faces of 1 x 1 and panoramas of 1 x 2 texels, black, denormal and enormous, at all allowed roughnesses: results are finite, within the
/// source's range and of its mean.
TEST(EnvironmentProperties, TheSmallestSourcesFilterToTheirMean) {
    truth::Random random(106);
    for (int trial = 0; trial < 300; ++trial) {
        formats::Environment environment =
            trial % 2 == 0 ? truth::constantStrip(1, glm::vec3(0)) : truth::constantEquirectangular(2, 1, glm::vec3(0));
        for (glm::vec3& texel : environment.texels.texels()) texel = {anyLight(random), anyLight(random), anyLight(random)};
        const glm::dvec3 mean = truth::meanRadiance(truth::samplesOf(environment, 1));
        fit::CubemapOptions options;
        options.size = 4;
        options.mipCount = 3;
        options.roughness = {0, 1e-4, 1};
        options.kernel = kKernels[trial % 3];
        const auto filter = fit::CubemapPrefilter::create(environment, options);
        ASSERT_TRUE(filter);
        float brightest = 0;
        for (const glm::vec3& texel : environment.texels.texels()) brightest = std::max({brightest, texel.x, texel.y, texel.z});
        for (int mip = 0; mip < 3; ++mip) {
            const auto strip = filter->filterMip(mip);
            for (const glm::vec3& texel : strip.texels())
                for (int channel = 0; channel < 3; ++channel) {
                    ASSERT_TRUE(std::isfinite(texel[channel]) && texel[channel] >= 0) << trial;
                    ASSERT_LE(texel[channel], brightest * (1 + 1e-6f)) << trial;
                }
            const glm::dvec3 found = truth::meanOfStrip(strip);
            // A channel far darker than the brightest loses digits: fluxes are floats relative to the brightest.
            for (int channel = 0; channel < 3; ++channel)
                ASSERT_NEAR(found[channel], mean[channel], 1e-4 * mean[channel] + 1e-40 * std::max(1.0f, brightest)) << trial << " " << mip;
        }
    }
}

}  // namespace
}  // namespace lightcook

// The fits on real environments and probes of shared/data, against brute force. Skipped without the data.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <string>

#include "fit/cubemap.h"
#include "fit/pre_divide.h"
#include "tests/fit/brute_force.h"

namespace lightcook {
namespace {

const std::filesystem::path kData = LIGHTCOOK_SHARED_DATA;

double cpuSeconds() {
    return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

struct LevelErrors {
    double median, p95, worst;
};
LevelErrors errorsOf(const formats::Image<glm::vec3>& strip, const fit::MipKernel& level, fit::PrefilterKernel kernel,
                     const std::vector<truth::Sample>& samples) {
    truth::Random random(static_cast<std::uint64_t>(level.size));
    std::vector<double> errors;
    for (int i = 0; i < 16; ++i) {
        const int face = random.below(6), x = random.below(level.size), y = random.below(level.size);
        const glm::dvec3 expected = truth::prefilter(samples, kernel, level.m, lighting::cubeTexelDirection(face, x, y, level.size));
        for (int channel = 0; channel < 3; ++channel)
            errors.push_back(std::abs(strip.at(x, face * level.size + y)[channel] - expected[channel]) / expected[channel]);
    }
    std::sort(errors.begin(), errors.end());
    return {errors[errors.size() / 2], errors[errors.size() * 95 / 100], errors.back()};
}

void checkChain(const std::filesystem::path& file, fit::PrefilterKernel kernel, const char* kernelName) {
    if (!std::filesystem::exists(file)) GTEST_SKIP() << "shared data is absent: " << file;
    const auto loaded = formats::loadEnvironment(file, {});
    ASSERT_TRUE(loaded) << loaded.error().line();
    const formats::Environment& environment = loaded->environment;
    fit::CubemapOptions options;
    options.kernel = kernel;
    double seconds = -cpuSeconds();
    const auto filter = fit::CubemapPrefilter::create(environment, options);
    ASSERT_TRUE(filter);
    std::vector<formats::Image<glm::vec3>> strips;
    for (int mip = 0; mip < filter->mipCount(); ++mip) strips.push_back(filter->filterMip(mip));
    seconds += cpuSeconds();
    std::printf("[ figures  ] %s, %s: %.2f CPU s\n", file.filename().c_str(), kernelName, seconds);

    const auto samples = truth::samplesOf(environment, 1), fine = truth::samplesOf(environment, 2);
    const glm::dvec3 mean = truth::meanRadiance(samples);
    for (int mip = 0; mip < filter->mipCount(); ++mip) {
        const fit::MipKernel& level = filter->mips()[static_cast<std::size_t>(mip)];
        const glm::dvec3 energy = truth::meanOfStrip(strips[static_cast<std::size_t>(mip)]) / mean - 1.0;
        const double worstEnergy = std::max({std::abs(energy.x), std::abs(energy.y), std::abs(energy.z)});
        EXPECT_LT(worstEnergy, 1e-5) << "mip " << mip;
        if (level.m == 0) continue;
        // The extent of a source texel matters for narrow lobes only.
        const LevelErrors errors = errorsOf(strips[static_cast<std::size_t>(mip)], level, kernel, mip == 1 ? fine : samples);
        std::printf("[ figures  ]   mip %d, m %.4f: median %.4f %%, p95 %.4f %%, worst %.4f %%; energy %.4f %%\n", mip, level.m,
                    100 * errors.median, 100 * errors.p95, 100 * errors.worst, 100 * worstEnergy);
        if (level.size < 4) continue;  // 24 or 6 values at centres cannot have the source's mean and be the kernel's: they have the mean
        EXPECT_LT(errors.median, 0.001) << "mip " << mip;
        EXPECT_LT(errors.p95, 0.005) << "mip " << mip;
    }
    EXPECT_LT(seconds, 8);  // ten times the usual duration, for slow machines
}

TEST(EnvironmentFilesSoak, BeckmannLevelsOfKiaraKeepTheMeanAndMatchBruteForce) {
    checkChain(kData / "env/kiara_1_dawn_1k.hdr", fit::PrefilterKernel::Beckmann, "Beckmann");
}
TEST(EnvironmentFilesSoak, GgxLevelsOfKiaraKeepTheMeanAndMatchBruteForce) {
    checkChain(kData / "env/kiara_1_dawn_1k.hdr", fit::PrefilterKernel::Ggx, "GGX");
}
TEST(EnvironmentFilesSoak, BeckmannLevelsOfRooitouKeepTheMeanAndMatchBruteForce) {
    checkChain(kData / "env/rooitou_park_1k.hdr", fit::PrefilterKernel::Beckmann, "Beckmann");
}
TEST(EnvironmentFiles, GgxLevelsOfRooitouKeepTheMeanAndMatchBruteForce) {
    checkChain(kData / "env/rooitou_park_1k.hdr", fit::PrefilterKernel::Ggx, "GGX");
}
TEST(EnvironmentFilesSoak, PhongLevelsOfRooitouKeepTheMeanAndMatchBruteForce) {
    checkChain(kData / "env/rooitou_park_1k.hdr", fit::PrefilterKernel::Phong, "Phong");
}

TEST(EnvironmentFiles, ProjectionOfCornellProbesAgreesWithTheirOwnSh) {
    const auto json = kData / "scenes/cornell_probes.json";
    if (!std::filesystem::exists(json)) GTEST_SKIP() << "shared data is absent: " << json;
    for (int probe = 0; probe < 8; ++probe) {
        const std::string name = "cornell_probe" + std::to_string(probe) + ".exr";
        const auto loaded = formats::loadEnvironment(kData / "scenes" / name, {});
        ASSERT_TRUE(loaded) << loaded.error().line();
        const auto stored = formats::loadProbeSh(json, name);
        ASSERT_TRUE(stored) << stored.error().line();
        const lighting::ShRgb projected = fit::projectEnvironment(loaded->environment);
        double error = 0, reference = 0;
        for (std::size_t i = 0; i < projected.size(); ++i) {
            error += static_cast<double>(glm::dot(projected[i] - (*stored)[i], projected[i] - (*stored)[i]));
            reference += static_cast<double>(glm::dot((*stored)[i], (*stored)[i]));
        }
        const double relative = std::sqrt(error / reference);
        std::printf("[ figures  ] %s: %.2f %% from the SH of the JSON\n", name.c_str(), 100 * relative);
        EXPECT_LT(relative, 0.05) << name;  // noise of both: 36 samples a texel here, 65,536 directions there
    }
}

TEST(EnvironmentFiles, PreDivisionOfEveryProbeMultipliesBack) {
    if (!std::filesystem::exists(kData / "scenes")) GTEST_SKIP() << "shared data is absent: " << kData / "scenes";
    for (const char* scene : {"cornell", "interior", "outdoor", "zdm2_sun"}) {
        const auto loaded = formats::loadEnvironment(kData / "scenes" / (std::string(scene) + "_probe0.exr"), {});
        ASSERT_TRUE(loaded) << loaded.error().line();
        std::vector<lighting::ShBands> bands;
        for (int mip = 0; mip < 8; ++mip) bands.push_back(fit::prefilterKernelBands(fit::PrefilterKernel::Beckmann, mip * mip / 49.0));
        const fit::PreDivide preDivide = fit::makePreDivide(fit::projectEnvironment(loaded->environment), bands, {});
        std::printf("[ figures  ] %s_probe0: window lambda %.4f, bands %.3f %.3f\n", scene, preDivide.windowLambda, preDivide.window[1],
                    preDivide.window[2]);
        const auto texels = loaded->environment.texels.view();
        formats::Image<glm::vec3> divided = loaded->environment.texels.copy();
        for (int face = 0; face < 6; ++face) {
            const auto stored = divided.view().rows(face * 128, 128);
            fit::preDivideRows(preDivide, 0, face, 0, stored);
            for (int i = 0; i < 128 * 128; ++i) {
                const int x = i % 128, y = i / 128;
                const glm::dvec3 product =
                    glm::dvec3(stored.at(x, y)) * preDivide.denominator(0, lighting::cubeTexelDirection(face, x, y, 128));
                for (int channel = 0; channel < 3; ++channel) {
                    const double expected = texels.at(x, face * 128 + y)[channel];
                    ASSERT_NEAR(product[channel], expected, 1e-6 * expected);
                }
            }
        }
    }
}

/// Purpose of the division: a divided cubemap times the area specular of another place is nearer to that place's cubemap than the undivided
/// one. For wide lobes; narrow ones depend on parallax.
TEST(EnvironmentFiles, RelightingAnotherPlaceComesNearerThanBorrowing) {
    for (const char* scene : {"cornell", "interior", "zdm2_sun"}) {
        std::vector<formats::Image<glm::vec3>> levels;
        std::vector<fit::PreDivide> divides;
        std::vector<lighting::ShRgb> own;
        for (int probe = 0; probe < 8; ++probe) {
            const auto file = kData / "scenes" / (std::string(scene) + "_probe" + std::to_string(probe) + ".exr");
            if (!std::filesystem::exists(file)) GTEST_SKIP() << "shared data is absent: " << file;
            const auto loaded = formats::loadEnvironment(file, {});
            ASSERT_TRUE(loaded) << loaded.error().line();
            fit::CubemapOptions options;
            options.size = 8;
            options.mipCount = 1;
            options.roughness = {0.33};
            const auto filter = fit::CubemapPrefilter::create(loaded->environment, options);
            ASSERT_TRUE(filter);
            levels.push_back(filter->filterMip(0));
            own.push_back(fit::projectEnvironment(loaded->environment));
            divides.push_back(fit::makePreDivide(own.back(), {filter->mips()[0].bands}, {}));
        }
        double relit = 0, borrowed = 0, right = 0;
        for (std::size_t a = 0; a < levels.size(); ++a) {
            for (std::size_t b = 0; b < levels.size(); ++b) {
                if (a == b) continue;
                fit::PreDivide pixel = divides[b];
                pixel.windowedSh = own[b];
                for (int i = 0; i < 6 * 64; ++i) {
                    const glm::dvec3 direction = lighting::cubeTexelDirection(i / 64, i % 8, i / 8 % 8, 8);
                    const glm::dvec3 other(levels[a].at(i % 8, i / 8)), expected(levels[b].at(i % 8, i / 8));
                    const glm::dvec3 found = other / divides[a].denominator(0, direction) * glm::max(pixel.denominator(0, direction), 0.0);
                    relit += glm::dot(found - expected, found - expected);
                    borrowed += glm::dot(other - expected, other - expected);
                    right += glm::dot(expected, expected);
                }
            }
        }
        std::printf("[ figures  ] %s, m 0.33: relit %.1f %%, borrowed %.1f %% from the place's own\n", scene,
                    100 * std::sqrt(relit / right), 100 * std::sqrt(borrowed / right));
        EXPECT_LT(relit, borrowed) << scene;
    }
}

}  // namespace
}  // namespace lightcook

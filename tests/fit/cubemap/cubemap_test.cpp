#include "fit/cubemap.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/vec2.hpp>
#include <limits>

#include "lighting/radiometry.h"
#include "tests/fit/brute_force.h"

namespace lightcook {
namespace {

using fit::CubemapOptions;
using fit::PrefilterKernel;

fit::CubemapPrefilter makeFilter(const formats::Environment& environment, int size, PrefilterKernel kernel) {
    CubemapOptions options;
    options.size = size;
    options.kernel = kernel;
    return std::move(fit::CubemapPrefilter::create(environment, options).value());
}

/// Smooth sky with coloured lobes, and a sun of 2 x 2 texels at 60000.
formats::Environment sunnySky(int width, bool strip) {
    formats::Environment environment =
        strip ? truth::constantStrip(width / 4, glm::vec3(0)) : truth::constantEquirectangular(width, width / 2, glm::vec3(0));
    const int rows = environment.texels.height(), columns = environment.texels.width();
    for (int y = 0; y < rows; ++y) {
        for (int x = 0; x < columns; ++x) {
            const glm::dvec3 d = strip ? lighting::cubeTexelDirection(y / columns, x, y % columns, columns)
                                       : lighting::directionFromEquirectangular({(x + 0.5) / columns, (y + 0.5) / rows});
            const double red = 0.4 + 0.3 * d.y + 3 * std::exp(20 * (d.x - 1)), blue = 0.6 + 0.4 * d.y + 0.2 * d.x * d.z;
            environment.texels.at(x, y) = glm::vec3(static_cast<float>(red), d.y > 0 ? 0.7f : 0.2f, static_cast<float>(blue));
        }
    }
    const int sunX = columns * 11 / 16, sunY = strip ? 4 * columns + columns / 3 : rows / 3;
    for (int i = 0; i < 4; ++i) environment.texels.at(sunX + i % 2, sunY + i / 2) = glm::vec3(60000);
    return environment;
}

/// Returns a filtered level before keepMean.
formats::Image<glm::vec3> atCentres(const fit::CubemapPrefilter& filter, int mip) {
    const int size = filter.mips()[static_cast<std::size_t>(mip)].size;
    formats::Image<glm::vec3> strip(size, 6 * size);
    for (int face = 0; face < 6; ++face) filter.filterRows(mip, face, 0, strip.view().rows(face * size, size));
    return strip;
}

struct Errors {
    double median, p95;
};
/// Relative errors of random texels of a level against the sum over all pieces of all source texels. Before keepMean, since on maps this
/// small a sun's lobe falls between the centres. environment_files_test.cpp tests whole maps of the usual size.
Errors errorsOfMip(const fit::CubemapPrefilter& filter, int mip, PrefilterKernel kernel, const std::vector<truth::Sample>& samples,
                   int count) {
    const fit::MipKernel& level = filter.mips()[static_cast<std::size_t>(mip)];
    const auto strip = atCentres(filter, mip);
    truth::Random random(static_cast<std::uint64_t>(mip) + 1);
    std::vector<double> errors;
    for (int i = 0; i < count; ++i) {
        const int face = random.below(6), x = random.below(level.size), y = random.below(level.size);
        const glm::dvec3 expected = truth::prefilter(samples, kernel, level.m, lighting::cubeTexelDirection(face, x, y, level.size));
        for (int channel = 0; channel < 3; ++channel)
            errors.push_back(std::abs(strip.at(x, face * level.size + y)[channel] / expected[channel] - 1));
    }
    std::sort(errors.begin(), errors.end());
    return {errors[errors.size() / 2], errors[errors.size() * 95 / 100]};
}

class EveryKernel : public testing::TestWithParam<PrefilterKernel> {};
INSTANTIATE_TEST_SUITE_P(Cubemap, EveryKernel, testing::Values(PrefilterKernel::Beckmann, PrefilterKernel::Ggx));
INSTANTIATE_TEST_SUITE_P(Soak, EveryKernel, testing::Values(PrefilterKernel::Phong));

TEST_P(EveryKernel, GreyStaysGreyAtEveryLevel) {
    const glm::vec3 grey(0.5f, 0.7f, 0.001f);
    const formats::Environment environments[] = {truth::constantEquirectangular(200, 100, grey), truth::constantStrip(24, grey),
                                                 truth::constantEquirectangular(2, 1, grey), truth::constantStrip(1, grey)};
    for (const formats::Environment& environment : environments) {
        const auto filter = makeFilter(environment, 16, GetParam());
        for (int mip = 0; mip < filter.mipCount(); ++mip) {
            const auto levelTexels = filter.filterMip(mip);
            for (const glm::vec3& texel : levelTexels.texels()) {
                ASSERT_NEAR(texel.x, 0.5, 0.5e-6) << mip;
                ASSERT_NEAR(texel.y, 0.7f, 0.7e-6) << mip;
                ASSERT_NEAR(texel.z, 0.001f, 1e-9) << mip;
            }
        }
    }
}

TEST_P(EveryKernel, PanoramaMatchesBruteForce) {
    const auto environment = sunnySky(256, false);
    const auto samples = truth::samplesOf(environment, 4);
    const auto filter = makeFilter(environment, 64, GetParam());
    for (int mip = 1; mip < filter.mipCount(); ++mip) {
        const Errors errors = errorsOfMip(filter, mip, GetParam(), samples, 25);
        EXPECT_LT(errors.median, 0.001) << mip;
        EXPECT_LT(errors.p95, 0.005) << mip;
    }
}

TEST_P(EveryKernel, StripMatchesBruteForce) {
    const auto environment = sunnySky(256, true);
    const auto samples = truth::samplesOf(environment, 4);
    const auto filter = makeFilter(environment, 32, GetParam());
    for (int mip = 1; mip < filter.mipCount(); ++mip) {
        const Errors errors = errorsOfMip(filter, mip, GetParam(), samples, 25);
        EXPECT_LT(errors.median, 0.001) << mip;
        EXPECT_LT(errors.p95, 0.005) << mip;
    }
}

TEST_P(EveryKernel, SmallSunKeepsItsEnergy) {
    const auto environment = sunnySky(1024, false);
    const glm::dvec3 mean = truth::meanRadiance(truth::samplesOf(environment, 1));
    const auto filter = makeFilter(environment, 128, GetParam());
    for (int mip = 0; mip < filter.mipCount(); ++mip) {
        const glm::dvec3 level = truth::meanOfStrip(filter.filterMip(mip));
        for (int channel = 0; channel < 3; ++channel) EXPECT_NEAR(level[channel] / mean[channel], 1, 1e-5) << mip;
    }
}

/// A sun in the middle of a face and one at an edge: the worst cases for the mean of few texels.
TEST_P(EveryKernel, TheMeanIsKeptAndTexelsHardlyChange) {
    for (const glm::ivec2 place : {glm::ivec2(127, 63), glm::ivec2(159, 45)}) {
        formats::Environment environment = truth::constantEquirectangular(256, 128, glm::vec3(0.2f, 0, 0.2f));
        environment.texels.at(place.x, place.y) = glm::vec3(60000, 0, 0.2f);
        const glm::dvec3 mean = truth::meanRadiance(truth::samplesOf(environment, 1));
        const auto filter = makeFilter(environment, 128, GetParam());
        for (int mip = 1; mip < filter.mipCount(); ++mip) {
            const auto before = atCentres(filter, mip), after = filter.filterMip(mip);
            const glm::dvec3 found = truth::meanOfStrip(after);
            EXPECT_NEAR(found.x / mean.x, 1, 1e-6) << mip;
            EXPECT_EQ(found.y, 0) << mip;
            EXPECT_NEAR(found.z, 0.2, 1e-6) << mip;
            const double lack = std::abs(mean.x / truth::meanOfStrip(before).x - 1);
            if (before.width() >= 4) {
                EXPECT_LT(lack, 0.004) << mip;
            }
            for (std::size_t i = 0; i < before.texels().size(); ++i) {
                const double change = after.texels()[i].x / static_cast<double>(before.texels()[i].x) - 1;
                ASSERT_LE(std::abs(change), 4.0 / 3 * lack + 1e-6) << mip;
                ASSERT_GE(after.texels()[i].x, 0) << mip;
            }
        }
    }
}

/// The means of levels of 8 x 8 and 4 x 4 texels err most on a sun, by up to 0.3 %. The correction must not reach every second texel.
TEST_P(EveryKernel, SunsAnywhereLeaveTheMedianTexelAlone) {
    for (const glm::ivec2 place : {glm::ivec2(255, 127), glm::ivec2(319, 90), glm::ivec2(260, 120)}) {
        formats::Environment environment = truth::constantEquirectangular(512, 256, glm::vec3(0.2f, 0.5f, 0.9f));
        for (int i = 0; i < 4; ++i) environment.texels.at(place.x + i % 2, place.y + i / 2) = glm::vec3(60000);
        const auto samples = truth::samplesOf(environment, 1);
        const auto filter = makeFilter(environment, 128, GetParam());
        for (const int mip : {4, 5}) {
            const fit::MipKernel& level = filter.mips()[static_cast<std::size_t>(mip)];
            const auto strip = filter.filterMip(mip);
            std::vector<double> errors;
            for (int texel = 0; texel < 6 * level.size * level.size; texel += level.size == 8 ? 7 : 2) {
                const int x = texel % level.size, row = texel / level.size;
                const glm::dvec3 expected = truth::prefilter(
                    samples, GetParam(), level.m, lighting::cubeTexelDirection(row / level.size, x, row % level.size, level.size));
                for (int channel = 0; channel < 3; ++channel) errors.push_back(std::abs(strip.at(x, row)[channel] / expected[channel] - 1));
            }
            std::sort(errors.begin(), errors.end());
            EXPECT_LT(errors[errors.size() / 2], 0.001) << place.x << ", mip " << mip;
            EXPECT_LT(errors[errors.size() * 95 / 100], 0.005) << place.x << ", mip " << mip;
        }
    }
}

TEST(Cubemap, KeepingTheMeanOfAStrangeLevelStaysInRange) {
    formats::Environment environment = truth::constantEquirectangular(64, 32, glm::vec3(0));
    environment.texels.at(9, 9) = glm::vec3(1, 1, 1e-3f);
    const auto filter = makeFilter(environment, 16, PrefilterKernel::Ggx);
    for (int mip = 1; mip < filter.mipCount(); ++mip) {
        const int size = filter.mips()[static_cast<std::size_t>(mip)].size;
        for (const float value : {0.0f, 1e-6f, 1.0f}) {  // nothing, far too little and far too much
            formats::Image<glm::vec3> level(size, 6 * size, glm::vec3(value));
            filter.keepMean(mip, level.view());
            for (const glm::vec3& texel : level.texels()) {
                ASSERT_TRUE(texel.x >= 0 && texel.x <= 1) << mip << " " << value;
                ASSERT_EQ(texel.x == 0, value == 0);
            }
        }
    }
}

/// Convolution theorem: the SH of a level are those of the source times the kernel's bands.
TEST_P(EveryKernel, BandsEqualTheSpectrumOfTheLevel) {
    const auto environment = sunnySky(256, false);
    const lighting::ShRgb source = fit::projectEnvironment(environment);
    const auto filter = makeFilter(environment, 128, GetParam());
    for (const int mip : {1, 2, 3}) {
        formats::Environment level{formats::Environment::Projection::CubeStrip, filter.filterMip(mip)};
        const lighting::ShRgb actual = fit::projectEnvironment(level);
        const lighting::ShRgb expected = lighting::convolve(source, filter.mips()[static_cast<std::size_t>(mip)].bands);
        for (std::size_t i = 0; i < actual.size(); ++i) EXPECT_NEAR(actual[i].x, expected[i].x, 0.004 * expected[0].x) << mip << " " << i;
    }
}

TEST_P(EveryKernel, NoValueLeavesTheSourcesRange) {
    truth::Random random(21);
    formats::Environment environment = truth::constantEquirectangular(64, 32, glm::vec3(0));
    for (glm::vec3& texel : environment.texels.texels())
        texel = glm::vec3(random.below(20) == 0 ? 1e6f : 0.0f, 1 + static_cast<float>(random.uniform()), 3);
    const auto filter = makeFilter(environment, 32, GetParam());
    for (int mip = 0; mip < filter.mipCount(); ++mip) {
        const auto levelTexels = filter.filterMip(mip);
        for (const glm::vec3& texel : levelTexels.texels()) {
            ASSERT_GE(texel.x, 0);
            ASSERT_LE(texel.x, 1e6f);
            ASSERT_GE(texel.y, 0.999f);
            ASSERT_LE(texel.y, 2.001f);
            ASSERT_NEAR(texel.z, 3, mip == 0 ? 1e-6 : 0.02);
        }
    }
}

TEST(Cubemap, LevelZeroIsTheMeanOverEachFootprint) {
    truth::Random random(31);
    formats::Environment environment = truth::constantEquirectangular(64, 32, glm::vec3(0));
    for (glm::vec3& texel : environment.texels.texels()) texel = glm::vec3(static_cast<float>(random.uniform()));
    for (const int size : {1, 2, 8, 32}) {
        CubemapOptions options;
        options.size = size;
        options.mipCount = 1;
        const auto filter = fit::CubemapPrefilter::create(environment, options);
        ASSERT_TRUE(filter);
        const auto strip = filter->filterMip(0);
        const int pieces = 512 / size;
        for (int trial = 0; trial < 40; ++trial) {
            const int face = random.below(6), x = random.below(size), y = random.below(size);
            double sum = 0, solidAngle = 0;
            for (int i = 0; i < pieces * pieces; ++i) {
                const int px = x * pieces + i % pieces, py = y * pieces + i / pieces;
                const glm::dvec2 uv = lighting::equirectangularFromDirection(lighting::cubeTexelDirection(face, px, py, size * pieces));
                const double weight = lighting::cubeTexelSolidAngle(px, py, size * pieces);
                const auto& texels = environment.texels;
                sum += weight * texels.at(std::clamp(static_cast<int>(uv.x * 64), 0, 63), std::clamp(static_cast<int>(uv.y * 32), 0, 31)).x;
                solidAngle += weight;
            }
            EXPECT_NEAR(strip.at(x, face * size + y).x, sum / solidAngle, 20.0 / (pieces * pieces) + 2e-3)
                << size << " face " << face << " " << x << " " << y;
        }
    }
}

TEST(Cubemap, LevelZeroKeepsTheMeanOfAnySource) {
    truth::Random random(32);
    for (const int height : {1, 3, 16, 200}) {
        formats::Environment environment = truth::constantEquirectangular(2 * height, height, glm::vec3(0));
        for (glm::vec3& texel : environment.texels.texels()) texel = glm::vec3(static_cast<float>(std::pow(random.uniform(), 30) * 1e5));
        const glm::dvec3 mean = truth::meanRadiance(truth::samplesOf(environment, 1));
        for (const int size : {1, 4, 64})
            EXPECT_NEAR(truth::meanOfStrip(makeFilter(environment, size, PrefilterKernel::Beckmann).filterMip(0)).x / mean.x, 1, 2e-4)
                << height << " " << size;
    }
    for (const int sourceSize : {1, 3, 48}) {
        formats::Environment environment = truth::constantStrip(sourceSize, glm::vec3(0));
        for (glm::vec3& texel : environment.texels.texels()) texel = glm::vec3(static_cast<float>(std::pow(random.uniform(), 30) * 1e5));
        const glm::dvec3 mean = truth::meanRadiance(truth::samplesOf(environment, 1));
        for (const int size : {1, 4, 64})
            EXPECT_NEAR(truth::meanOfStrip(makeFilter(environment, size, PrefilterKernel::Beckmann).filterMip(0)).x / mean.x, 1, 1e-6)
                << sourceSize << " " << size;
    }
}

TEST(Cubemap, StripOfTheSameSizeIsReturnedUnchanged) {
    const auto environment = sunnySky(128, true);
    const auto strip = makeFilter(environment, 32, PrefilterKernel::Ggx).filterMip(0);
    EXPECT_EQ(strip.texels(), environment.texels.texels());
}

TEST(Cubemap, RowsDoNotDependOnTheCut) {
    const auto environment = sunnySky(128, false);
    const auto filter = makeFilter(environment, 32, PrefilterKernel::Beckmann);
    for (int mip = 0; mip < filter.mipCount(); ++mip) {
        const int size = filter.mips()[static_cast<std::size_t>(mip)].size;
        const auto whole = filter.filterMip(mip);
        formats::Image<glm::vec3> pieces(size, 6 * size, glm::vec3(-1));
        for (int face = 5; face >= 0; --face) {
            for (int row = 0; row < size; row += 3) {
                const int count = std::min(3, size - row);
                filter.filterRows(mip, face, row, pieces.view().rows(face * size + row, count));
            }
        }
        filter.keepMean(mip, pieces.view());
        EXPECT_EQ(whole.texels(), pieces.texels()) << mip;
    }
}

TEST(Cubemap, FacesAgreeAcrossTheirEdges) {
    // The right edge of +Z meets the left edge of +X: texels across it differ by at most as much as neighbours inside a face.
    const auto environment = sunnySky(256, false);
    const auto filter = makeFilter(environment, 64, PrefilterKernel::Beckmann);
    for (const int mip : {2, 3, 4}) {
        const int size = filter.mips()[static_cast<std::size_t>(mip)].size;
        const auto strip = filter.filterMip(mip);
        double across = 0, inside = 0;
        for (int y = 0; y < size; ++y) {
            across += std::abs(strip.at(size - 1, 4 * size + y).z - strip.at(0, y).z);
            inside += 0.5 * (std::abs(strip.at(size - 1, 4 * size + y).z - strip.at(size - 2, 4 * size + y).z) +
                             std::abs(strip.at(0, y).z - strip.at(1, y).z));
        }
        EXPECT_LT(across, 1.5 * inside) << mip;
    }
}

TEST(Cubemap, ExtremesStayFinite) {
    for (const float sun : {1e6f, 1e30f, std::numeric_limits<float>::max()}) {
        formats::Environment environment = truth::constantEquirectangular(64, 32, glm::vec3(0));
        environment.texels.at(5, 9) = glm::vec3(sun, 0, 1e-42f);
        const auto filter = makeFilter(environment, 16, PrefilterKernel::Beckmann);
        for (int mip = 0; mip < filter.mipCount(); ++mip) {
            double sum = 0;
            const auto levelTexels = filter.filterMip(mip);
            for (const glm::vec3& texel : levelTexels.texels()) {
                for (int channel = 0; channel < 3; ++channel) ASSERT_TRUE(std::isfinite(texel[channel]) && texel[channel] >= 0);
                ASSERT_EQ(texel.y, 0);
                sum += texel.x;
            }
            EXPECT_GT(sum, 0) << mip;
        }
    }
    const auto black = truth::constantStrip(8, glm::vec3(0));
    const auto filter = makeFilter(black, 16, PrefilterKernel::Ggx);
    for (int mip = 0; mip < filter.mipCount(); ++mip) {
        const auto levelTexels = filter.filterMip(mip);
        for (const glm::vec3& texel : levelTexels.texels()) ASSERT_EQ(texel, glm::vec3(0));
    }
    const auto full = truth::constantStrip(2, glm::vec3(std::numeric_limits<float>::max()));
    const auto fullFilter = makeFilter(full, 4, PrefilterKernel::Phong);
    const auto levelTexels = fullFilter.filterMip(1);
    for (const glm::vec3& texel : levelTexels.texels()) ASSERT_TRUE(std::isfinite(texel.x));
}

TEST(Cubemap, ChainIsPerceptuallySpaced) {
    const auto environment = truth::constantEquirectangular(8, 4, glm::vec3(1));
    const auto filter = makeFilter(environment, 128, PrefilterKernel::Beckmann);
    ASSERT_EQ(filter.mipCount(), 8);
    for (int mip = 0; mip < 8; ++mip) {
        const fit::MipKernel& level = filter.mips()[static_cast<std::size_t>(mip)];
        EXPECT_EQ(level.size, 128 >> mip);
        EXPECT_NEAR(level.perceptualRoughness, mip / 7.0, 1e-12);
        EXPECT_NEAR(level.m, mip * mip / 49.0, 1e-12);
        EXPECT_EQ(level.bands, fit::prefilterKernelBands(PrefilterKernel::Beckmann, level.m));
    }
}

TEST(Cubemap, KernelsNarrowerThanATexelBecomeItsFootprint) {
    const auto environment = truth::constantEquirectangular(8, 4, glm::vec3(1));
    CubemapOptions options;
    options.size = 8;
    options.mipCount = 2;
    options.roughness = {1e-4, 0.5};
    const auto filter = fit::CubemapPrefilter::create(environment, options);
    ASSERT_TRUE(filter);
    EXPECT_EQ(filter->mips()[0].m, 0);
    EXPECT_EQ(filter->mips()[0].bands, (lighting::ShBands{1, 1, 1}));
    EXPECT_EQ(filter->mips()[1].m, 0.5);
}

TEST(Cubemap, BadRequestsAreRefused) {
    const auto environment = truth::constantEquirectangular(8, 4, glm::vec3(1));
    const auto refused = [&](auto&& change) {
        CubemapOptions options;
        options.size = 8;
        change(options);
        return !fit::CubemapPrefilter::create(environment, options).has_value();
    };
    EXPECT_FALSE(refused([](CubemapOptions&) {}));
    EXPECT_TRUE(refused([](CubemapOptions& o) { o.size = 0; }));
    EXPECT_TRUE(refused([](CubemapOptions& o) { o.size = 100; }));
    EXPECT_TRUE(refused([](CubemapOptions& o) { o.size = 8192; }));
    EXPECT_TRUE(refused([](CubemapOptions& o) { o.mipCount = 5; }));
    EXPECT_TRUE(refused([](CubemapOptions& o) { o.mipCount = -1; }));
    EXPECT_TRUE(refused([](CubemapOptions& o) { o.roughness = {0, 1}; }));
    EXPECT_TRUE(refused([](CubemapOptions& o) { o.roughness = {0, 0.5, 1.5, 1}; }));
    EXPECT_TRUE(refused([](CubemapOptions& o) { o.cellsPerKernelWidth = 0; }));
    EXPECT_FALSE(fit::CubemapPrefilter::create(formats::Environment{}, {}));
    formats::Environment crooked{formats::Environment::Projection::CubeStrip, formats::Image<glm::vec3>(4, 20)};
    EXPECT_FALSE(fit::CubemapPrefilter::create(crooked, {}));
}

}  // namespace
}  // namespace lightcook

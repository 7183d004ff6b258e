// BC1, and the colour of BC3: blocks of one and two colours have the least possible error. Searches here are exhaustive, and written from
// the specification of the format without code of compress/.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "tests/compress/few_colours.h"

namespace lightcook::compress::test {
namespace {

using formats::PixelFormat;

double bestBc1Channel(double value, int largest, bool halves) {
    double best = 1;
    for (int a = 0; a <= largest; ++a)
        for (int b = 0; b <= largest; ++b)
            best = std::min(best, std::abs((halves ? (a + b) / 2.0 : (2.0 * a + b) / 3.0) / largest - value));
    return best;
}

TEST(Bc1, OneColourEqualsBruteForceOnEachChannel) {
    Random random(31);
    for (int i = 0; i < 500; ++i) {
        const glm::vec4 colour(random.unit(), random.unit(), random.unit(), 1);
        double thirds = 0, halves = 0;
        for (int c = 0; c < 3; ++c) {
            thirds += std::pow(bestBc1Channel(static_cast<double>(colour[c]), c == 1 ? 63 : 31, false), 2);
            halves += std::pow(bestBc1Channel(static_cast<double>(colour[c]), c == 1 ? 63 : 31, true), 2);
        }
        const TexelImage image = coloured(colour);
        const auto errorOf = [&](PixelFormat format) { return std::pow(rmsError(encode(format, image).decoded, image, 3), 2) * 3; };
        ASSERT_NEAR(errorOf(PixelFormat::Bc1), std::min(thirds, halves), 1e-9);
        ASSERT_NEAR(errorOf(PixelFormat::Bc3), thirds, 1e-9);
    }
}

/// Returns the least error over every pair of codes of every channel and every pair of indices. The index that some readers decode to
/// transparent black is not used.
double leastBc1(const FewColours& block, bool mayUseThree) {
    double best = INFINITY;
    const double weights[2] = {block.weightOf(0), block.weightOf(1)};
    for (const int steps : {3, 2})
        for (int i = 0; i <= steps; ++i)
            for (int j = 0; j <= steps; ++j) {
                if (steps == 2 && !mayUseThree) continue;
                double error = 0;
                for (int c = 0; c < 3; ++c) {
                    const int largest = c == 1 ? 63 : 31;
                    double least = INFINITY;
                    for (int a = 0; a <= largest; ++a)
                        for (int b = 0; b <= largest; ++b) {
                            const double atI = (a + (b - a) * double(i) / steps) / largest - block.colour[0][c];
                            const double atJ = (a + (b - a) * double(j) / steps) / largest - block.colour[1][c];
                            least = std::min(least, weights[0] * atI * atI + weights[1] * atJ * atJ);
                        }
                    error += least;
                }
                best = std::min(best, error);
            }
    return best;
}

TEST(Bc1, TwoColoursEqualExhaustiveSearchAtHighestEffort) {
    Random random(91);
    for (int i = 0; i < 400; ++i) {
        const FewColours block = twoUnitColours(random, i);
        const double four = leastBc1(block, false), any = leastBc1(block, true), weight = block.weightOf(0) + block.weightOf(1);
        ASSERT_NEAR(weightedError(block, decodedOf(PixelFormat::Bc1, block, 9), 0, 3), any, roundingOf(any, 3 * weight, 2e-7)) << i;
        ASSERT_NEAR(weightedError(block, decodedOf(PixelFormat::Bc3, block, 9), 0, 3), four, roundingOf(four, 3 * weight, 2e-7)) << i;
    }
}

TEST(Bc1, OneColourEqualsExhaustiveSearchAtEveryEffort) {
    Random random(92);
    for (int i = 0; i < 60; ++i) {
        FewColours block = twoUnitColours(random, i);
        block.colour[1] = block.colour[0];
        block.paint();
        const double four = leastBc1(block, false), any = leastBc1(block, true), weight = block.weightOf(0) + block.weightOf(1);
        for (int level = 0; level <= 9; ++level) {
            ASSERT_NEAR(weightedError(block, decodedOf(PixelFormat::Bc1, block, level), 0, 3), any, roundingOf(any, 3 * weight, 2e-7)) << i;
            ASSERT_NEAR(weightedError(block, decodedOf(PixelFormat::Bc3, block, level), 0, 3), four, roundingOf(four, 3 * weight, 2e-7))
                << i;
        }
    }
}

/// Returns the palette of a block's eight bytes of colour, in the order of the indices, from the specification of the format.
std::vector<glm::dvec3> paletteOf(const std::byte* bytes, bool mayHaveThree) {
    const auto end = [&](int at) { return std::to_integer<int>(bytes[at]) | std::to_integer<int>(bytes[at + 1]) << 8; };
    const auto colour = [](int packed) { return glm::dvec3((packed >> 11) / 31.0, (packed >> 5 & 63) / 63.0, (packed & 31) / 31.0); };
    const glm::dvec3 a = colour(end(0)), b = colour(end(2));
    if (mayHaveThree && end(0) <= end(2)) return {a, b, (a + b) / 2.0};
    return {a, b, (2.0 * a + b) / 3.0, (a + 2.0 * b) / 3.0};
}

TEST(Bc1, EveryTexelHasItsNearestPaletteEntryAtEveryEffort) {
    Random random(93);
    const TexelImage image = imageOf(32, 64, [&](int x, int y) {
        const int kind = y / 4 % 4;
        const float base = static_cast<float>(x / 4 * 7 % 11) / 11, step = kind == 1 ? 0.02f : kind == 2 ? 0.3f : 1.0f;
        const auto value = [&](int turn) {
            return kind == 3 ? static_cast<float>((x + turn * y) % 2) * base : std::clamp(base + step * (random.unit() - 0.5f), 0.0f, 1.0f);
        };
        return glm::vec4(value(1), value(2), value(3), value(4));
    });
    formats::Image<float> significance(32, 64, 1.0f);
    for (int y = 32; y < 64; ++y)
        for (int x = 0; x < 32; ++x) significance.at(x, y) = static_cast<float>(random.below(3));
    for (const PixelFormat format : {PixelFormat::Bc1, PixelFormat::Bc3})
        for (int level = 0; level <= 9; ++level) {
            const Encoded coded = encode(format, image, effort(level), significance.view());
            const std::size_t bytesPerBlock = format == PixelFormat::Bc1 ? 8 : 16;
            for (int block = 0; block < 128; ++block) {
                const std::byte* bytes = coded.bytes.data() + static_cast<std::size_t>(block) * bytesPerBlock + bytesPerBlock - 8;
                const std::vector<glm::dvec3> palette = paletteOf(bytes, format == PixelFormat::Bc1);
                for (int t = 0; t < kTexelCount; ++t) {
                    const auto index = static_cast<std::size_t>(std::to_integer<int>(bytes[4 + t / 4]) >> 2 * (t % 4) & 3);
                    ASSERT_LT(index, palette.size()) << "the index that some readers decode to transparent black";
                    const glm::dvec3 colour(image.at(block % 8 * 4 + t % 4, block / 8 * 4 + t / 4));
                    double nearest = INFINITY;
                    for (const glm::dvec3& entry : palette) nearest = std::min(nearest, glm::distance(entry, colour));
                    ASSERT_LE(glm::distance(palette[index], colour), nearest + 1e-5)
                        << formats::info(format).name << " effort " << level << " block " << block << " texel " << t;
                }
            }
        }
}

TEST(Bc1, ValuesOutsideTheRangeAreClampedAndCounted) {
    Random random(94);
    const TexelImage image = imageOf(40, 8, [&](int, int) {
        return glm::vec4(3 * random.unit() - 1, 3 * random.unit() - 1, 3 * random.unit() - 1, 3 * random.unit() - 1);
    });
    const TexelImage clamped = imageOf(40, 8, [&](int x, int y) { return glm::clamp(image.at(x, y), 0.0f, 1.0f); });
    for (const PixelFormat format : {PixelFormat::Bc1, PixelFormat::Bc3}) {
        std::int64_t high = 0, negative = 0;
        for (const glm::vec4& texel : image.texels())
            for (int c = 0; c < formats::info(format).channelCount; ++c) high += texel[c] > 1, negative += texel[c] < 0;
        for (const int level : {0, 5, 9}) {
            const Encoded found = encode(format, image, effort(level));
            EXPECT_EQ(found.bytes, encode(format, clamped, effort(level)).bytes) << formats::info(format).name << ' ' << level;
            EXPECT_EQ(found.report.clampedHigh, high) << formats::info(format).name << ' ' << level;
            EXPECT_EQ(found.report.clampedNegative, negative) << formats::info(format).name << ' ' << level;
        }
    }
}

}  // namespace
}  // namespace lightcook::compress::test

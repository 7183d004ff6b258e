// Blocks of one colour, against every pair of ends that a format has.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "compress/texel/half.h"
#include "tests/compress/codec_images.h"

namespace lightcook::compress::test {
namespace {

using formats::PixelFormat;

/// A block of one colour where it counts; the other texels must not matter.
TexelImage coloured(const glm::vec4& colour) {
    return imageOf(4, 4, [&](int, int) { return colour; });
}

double bestBc1Channel(double value, int largest, bool halves) {
    double best = 1;
    for (int a = 0; a <= largest; ++a)
        for (int b = 0; b <= largest; ++b)
            best = std::min(best, std::abs((halves ? (a + b) / 2.0 : (2.0 * a + b) / 3.0) / largest - value));
    return best;
}

TEST(SingleColour, Bc1AndBc3EqualBruteForce) {
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

TEST(SingleColour, Bc7IsExactForWholeCodesAndNearestForOthers) {
    Random random(32);
    for (int i = 0; i < 2000; ++i) {
        glm::vec4 colour(random.unit(), random.unit(), random.unit(), random.unit());
        if (i < 256) colour = glm::vec4(i, 255 - i, (i * 7) % 256, (i * 31) % 256) / 255.0f;
        const glm::vec4 decoded = encode(PixelFormat::Bc7, coloured(colour)).decoded.at(1, 3);
        for (int c = 0; c < 4; ++c) ASSERT_NEAR(decoded[c] * 255, colour[c] * 255, i < 256 ? 1e-4 : 0.5001) << i;
    }
}

TEST(SingleColour, Bc6hHoldsEveryHalf) {
    for (int bits = 0; bits < 0x7C00; bits += 3) {
        glm::vec4 colour(0, 0, 0, 1);
        for (int c = 0; c < 3; ++c) colour[c] = floatFromHalf(static_cast<std::uint16_t>(std::min(bits + c, 0x7BFF)));
        ASSERT_EQ(encode(PixelFormat::Bc6hUf16, coloured(colour)).decoded.at(0, 0), colour) << bits;
        colour.g = -colour.g;
        ASSERT_EQ(encode(PixelFormat::Bc6hSf16, coloured(colour)).decoded.at(0, 0), colour) << bits;
    }
}

TEST(SingleColour, NegativeZeroAndNegativesBecomeZeroInUnsignedBc6h) {
    const Encoded zero = encode(PixelFormat::Bc6hUf16, coloured({-0.0f, -0.0f, 0.0f, 1}));
    EXPECT_EQ(zero.decoded.at(0, 0), glm::vec4(0, 0, 0, 1));
    EXPECT_EQ(zero.report.clampedNegative, 0);
    const Encoded negative = encode(PixelFormat::Bc6hUf16, coloured({-0.00006f, -3, -65504, 1}));
    EXPECT_EQ(negative.decoded.at(0, 0), glm::vec4(0, 0, 0, 1));
    EXPECT_EQ(negative.report.clampedNegative, 48);
    const Encoded high = encode(PixelFormat::Bc6hUf16, coloured({1e30f, 65505, 65504, 1}));
    EXPECT_EQ(high.decoded.at(0, 0), glm::vec4(65504, 65504, 65504, 1));
    EXPECT_EQ(high.report.clampedHigh, 32);
}

TEST(SingleColour, TexelsWithoutSignificanceDoNotMatter) {
    Random random(33);
    for (const PixelFormat format :
         {PixelFormat::Bc1, PixelFormat::Bc3, PixelFormat::Bc4, PixelFormat::Bc5, PixelFormat::Bc6hUf16, PixelFormat::Bc7}) {
        const glm::vec4 colour(0.3f, 0.6f, 0.1f, 0.8f);
        const TexelImage clean = coloured(colour);
        const TexelImage dirty =
            imageOf(4, 4, [&](int x, int) { return x == 2 ? glm::vec4(random.unit(), random.unit(), random.unit(), 0) : colour; });
        formats::Image<float> significance(4, 4, 1.0f);
        for (int y = 0; y < 4; ++y) significance.at(2, y) = 0;
        const Encoded expected = encode(format, clean), found = encode(format, dirty, {}, significance.view());
        EXPECT_EQ(found.decoded.at(0, 0), expected.decoded.at(0, 0)) << formats::info(format).name;
        EXPECT_EQ(found.decoded.at(3, 3), expected.decoded.at(0, 0)) << formats::info(format).name;
    }
}

}  // namespace
}  // namespace lightcook::compress::test

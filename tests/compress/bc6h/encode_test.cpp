// BC6H: blocks of one colour.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/vec3.hpp>

#include "compress/texel/half.h"
#include "tests/compress/few_colours.h"

namespace lightcook::compress::test {
namespace {

using formats::PixelFormat;

TEST(Bc6h, OneColourOfHalvesIsExact) {
    for (int bits = 0; bits < 0x7C00; bits += 3) {
        glm::vec4 colour(0, 0, 0, 1);
        for (int c = 0; c < 3; ++c) colour[c] = floatFromHalf(static_cast<std::uint16_t>(std::min(bits + c, 0x7BFF)));
        ASSERT_EQ(encode(PixelFormat::Bc6hUf16, coloured(colour)).decoded.at(0, 0), colour) << bits;
        colour.g = -colour.g;
        ASSERT_EQ(encode(PixelFormat::Bc6hSf16, coloured(colour)).decoded.at(0, 0), colour) << bits;
    }
}

TEST(Bc6h, NegativeZeroAndNegativeValuesBecomeZeroInTheUnsignedFormat) {
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

/// A block of one colour decodes to halves, so the least error of a channel is that of the nearest half. The kernel of efforts 0 to 2
/// rounds with a precision of 1/256 of the step between halves, so it may choose either of two halves that are almost equally near.
TEST(Bc6h, OneColourIsTheNearestHalfAtEveryEffort) {
    Random random(96);
    for (int i = 0; i < 300; ++i) {
        glm::vec4 colour(0, 0, 0, 1);
        for (int c = 0; c < 3; ++c) colour[c] = std::min(65504.0f, std::exp2(random.unit() * 44 - 28));
        if (i % 7 == 0) colour[i % 3] = 0;
        for (const PixelFormat format : {PixelFormat::Bc6hUf16, PixelFormat::Bc6hSf16}) {
            const float sign = formats::info(format).isSigned && i % 2 ? -1.0f : 1.0f;
            const TexelImage image = imageOf(4, 4, [&](int, int) { return glm::vec4(sign * glm::vec3(colour), 1); });
            for (int level = 0; level <= 9; ++level) {
                const TexelImage decoded = encode(format, image, effort(level)).decoded;
                for (const glm::vec4& texel : decoded.texels())
                    for (int c = 0; c < 3; ++c) {
                        double least = INFINITY, halfStep = 0;
                        for (int exponent = -24; exponent <= 5; ++exponent) {
                            // Halves are integers of up to eleven bits times a power of two, at least 2^-24.
                            const double step = std::exp2(exponent), steps = std::nearbyint(static_cast<double>(colour[c]) / step);
                            if (steps >= 2048) continue;
                            least = std::min(least, std::abs(steps * step - static_cast<double>(colour[c])));
                            halfStep = halfStep > 0 ? halfStep : step / 2;
                        }
                        ASSERT_LE(std::abs(static_cast<double>(texel[c]) - static_cast<double>(sign * colour[c])),
                                  level < 3 ? least + halfStep / 256 : least)
                            << formats::info(format).name << " effort " << level << ' ' << colour[c];
                    }
            }
        }
    }
}

}  // namespace
}  // namespace lightcook::compress::test

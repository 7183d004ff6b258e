// Formats without blocks, against arithmetic in double and exhaustive searches over the codes.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "compress/texel/half.h"
#include "tests/compress/codec_images.h"
#include "tests/lighting/worst_search.h"

namespace lightcook::compress::test {
namespace {

using formats::PixelFormat;

/// Returns the nearest float with ten, six or five bits of mantissa and the exponents of a half, ties to even.
double nearestSmallFloat(double value, int mantissaBits) {
    if (value == 0) return 0;
    const double step = std::ldexp(1.0, std::max(std::ilogb(value), -14) - mantissaBits);
    return std::nearbyint(value / step) * step;
}

glm::vec4 roundTrip(PixelFormat format, const glm::vec4& texel, const EncodeOptions& options = {}) {
    return encode(format, imageOf(1, 1, [&](int, int) { return texel; }), options).decoded.at(0, 0);
}

/// Returns values of every magnitude, and the ties between halves.
float anyPositive(Random& random, float largest) {
    const float value = std::ldexp(1 + random.unit(), random.below(44) - 28);
    const float onGrid = static_cast<float>(
        std::ldexp(std::nearbyint(std::ldexp(static_cast<double>(value), 11 - std::ilogb(value))), std::ilogb(value) - 11));
    return std::min(largest, random.below(2) ? onGrid : value);
}

TEST(PackedTexels, HalvesAreTheNearestWithTiesToEven) {
    Random random(1);
    for (int i = 0; i < 100000; ++i) {
        const float x = anyPositive(random, 65504);
        const glm::vec4 decoded = roundTrip(PixelFormat::Rgba16f, {x, -x, 0, 1});
        ASSERT_EQ(decoded.r, static_cast<float>(nearestSmallFloat(static_cast<double>(x), 10))) << x;
        ASSERT_EQ(decoded.g, -decoded.r) << x;
    }
}

TEST(PackedTexels, SmallFloatsAreTheNearestWithTiesToEven) {
    Random random(2);
    for (int i = 0; i < 100000; ++i) {
        const float x = anyPositive(random, 64512);
        const glm::vec4 decoded = roundTrip(PixelFormat::R11g11b10f, {x, x, x, 1});
        ASSERT_EQ(decoded.r, static_cast<float>(nearestSmallFloat(static_cast<double>(x), 6))) << x;
        ASSERT_EQ(decoded.g, decoded.r);
        ASSERT_EQ(decoded.b, static_cast<float>(nearestSmallFloat(static_cast<double>(x), 5))) << x;
    }
}

double logError(const glm::vec4& a, const glm::vec4& b) {
    double sum = 0;
    for (int c = 0; c < 3; ++c) sum += std::pow(std::log2(1 + static_cast<double>(a[c])) - std::log2(1 + static_cast<double>(b[c])), 2);
    return sum;
}

TEST(PackedTexels, SharedExponentIsTheBestOfAll32) {
    Random random(3);
    for (int i = 0; i < 20000; ++i) {
        glm::vec4 texel(0, 0, 0, 1);
        for (int c = 0; c < 3; ++c) texel[c] = anyPositive(random, 65408);
        double best = std::numeric_limits<double>::infinity();
        for (int e = 0; e < 32; ++e) {
            glm::vec4 trial(0, 0, 0, 1);
            const double unit = std::ldexp(1.0, e - 24);
            for (int c = 0; c < 3; ++c)
                trial[c] = static_cast<float>(std::min(511.0, std::floor(static_cast<double>(texel[c]) / unit + 0.5)) * unit);
            best = std::min(best, logError(trial, texel));
        }
        const glm::vec4 decoded = roundTrip(PixelFormat::Rgb9e5, texel);
        ASSERT_LE(logError(decoded, texel), best * (1 + 1e-9) + 1e-18) << texel.r << ' ' << texel.g << ' ' << texel.b;
    }
}

TEST(PackedTexels, UnormErrsByAtMostHalfAStep) {
    Random random(4);
    for (int i = 0; i < 50000; ++i) {
        const glm::vec4 texel(random.unit(), random.unit(), random.unit(), random.unit());
        const glm::vec4 sixteen = roundTrip(PixelFormat::Rgba16Unorm, texel), eight = roundTrip(PixelFormat::Rgba8Unorm, texel);
        for (int c = 0; c < 4; ++c) {
            ASSERT_NEAR(sixteen[c], texel[c], 0.5 / 65535 + 6e-8);
            ASSERT_NEAR(eight[c], texel[c], 0.5 / 255 + 6e-8);
        }
    }
    EXPECT_EQ(roundTrip(PixelFormat::R16Unorm, {1, 0.3f, 0.3f, 0.3f}), glm::vec4(1, 0, 0, 1));
    EXPECT_EQ(roundTrip(PixelFormat::Rg16Unorm, {0, 1, 0.3f, 0.3f}), glm::vec4(0, 1, 0, 1));
}

double srgbFromLinear(double x) {
    return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
}

TEST(PackedTexels, SrgbTakesTheNearestCodeOfTheCurve) {
    Random random(5);
    for (int i = 0; i < 20000; ++i) {
        const float x = random.unit() * (random.below(2) ? 1.0f : 0.02f);
        const Encoded result = encode(PixelFormat::Rgba8Srgb, imageOf(1, 1, [&](int, int) { return glm::vec4(x, x, x, x); }));
        const double code = srgbFromLinear(static_cast<double>(x)) * 255;
        ASSERT_NEAR(std::to_integer<int>(result.bytes[0]), code, 0.5 + 1e-6);
        ASSERT_NEAR(srgbFromLinear(static_cast<double>(result.decoded.at(0, 0).r)) * 255, code, 0.5 + 1e-3);
        ASSERT_NEAR(std::to_integer<int>(result.bytes[3]), static_cast<double>(x) * 255, 0.5 + 1e-6) << "alpha is linear";
    }
}

/// The error of a value is at most `share` of it, or `step` where that is more. docs/lab/formats.md states both for each format of light.
struct StatedError {
    PixelFormat format;
    long double share[3], step[3];  ///< of each channel
};
constexpr StatedError kStatedErrors[] = {
    {PixelFormat::Rgba16f, {}, {}},
    {PixelFormat::Bc6hUf16, {}, {}},
    {PixelFormat::Bc6hSf16, {}, {}},
    {PixelFormat::R11g11b10f, {0x1p-7L, 0x1p-7L, 0x1p-6L}, {0x1p-21L, 0x1p-21L, 0x1p-20L}},
    {PixelFormat::Rgb9e5, {0x1p-9L, 0x1p-9L, 0x1p-9L}, {0x1p-25L, 0x1p-25L, 0x1p-25L}},
};

TEST(PackedTexels, EveryHalfHasTheStatedErrorInEveryFormatOfLight) {
    for (const StatedError& stated : kStatedErrors)
        for (std::uint32_t bits = 0; bits < 0x7c00; ++bits)
            for (const float sign : {1.0f, -1.0f}) {
                const float value = sign * floatFromHalf(static_cast<std::uint16_t>(bits));
                const bool holdsSign = stated.format == PixelFormat::Rgba16f || formats::info(stated.format).isSigned;
                if (sign < 0 && !holdsSign) continue;
                for (int c = 0; c < 3; ++c) {
                    glm::vec4 texel(0, 0, 0, 1);
                    texel[c] = value;
                    const glm::vec4 decoded = encode(stated.format, imageOf(1, 1, [&](int, int) { return texel; })).decoded.at(0, 0);
                    const long double most = std::max(stated.share[c] * std::abs(static_cast<long double>(value)), stated.step[c]);
                    ASSERT_LE(std::abs(static_cast<long double>(decoded[c]) - static_cast<long double>(value)), most)
                        << formats::info(stated.format).name << ", half " << bits << ", channel " << c;
                    texel[c] = decoded[c];
                    ASSERT_EQ(decoded, texel) << formats::info(stated.format).name << ": the other channels stay 0";
                }
            }
}

/// Any three floats in a block of one colour: light beyond the largest value becomes that value. (RGB9E5 is the best of all exponents for
/// the logarithms of all three, which is no share of one.)
void searchColours(const lightcook::test::SearchBudget& budget) {
    struct Format {
        PixelFormat format;
        long double largest[3], share[3], step[3];
    };
    constexpr Format kColourFormats[] = {
        {PixelFormat::Rgba16f, {65504, 65504, 65504}, {0x1p-11L, 0x1p-11L, 0x1p-11L}, {0x1p-25L, 0x1p-25L, 0x1p-25L}},
        {PixelFormat::R11g11b10f, {65024, 65024, 64512}, {0x1p-7L, 0x1p-7L, 0x1p-6L}, {0x1p-21L, 0x1p-21L, 0x1p-20L}},
        {PixelFormat::Bc6hUf16, {65504, 65504, 65504}, {0x1p-11L, 0x1p-11L, 0x1p-11L}, {0x1p-25L, 0x1p-25L, 0x1p-25L}},
    };
    const std::vector<lightcook::test::SearchRange> ranges(3, {1e-45, 3.4028234663852886e38});
    for (const Format& stated : kColourFormats)
        lightcook::test::expectHolds(
            std::string(formats::info(stated.format).name) + ", any colour", ranges, budget, [&](const std::vector<double>& in) {
                const glm::vec4 texel(static_cast<float>(in[0]), static_cast<float>(in[1]), static_cast<float>(in[2]), 1);
                const glm::vec4 decoded = encode(stated.format, imageOf(4, 4, [&](int, int) { return texel; })).decoded.at(1, 2);
                long double worst = 0;
                for (int c = 0; c < 3; ++c) {
                    const long double value = std::min(static_cast<long double>(texel[c]), stated.largest[c]);
                    worst = std::max(
                        worst, std::abs(static_cast<long double>(decoded[c]) - value) / std::max(stated.share[c] * value, stated.step[c]));
                }
                return worst;
            });
}
TEST(PackedTexelNumbers, AnyColourHasTheStatedError) {
    searchColours({4000});
}
TEST(PackedTexelNumbersSoak, AnyColourHasTheStatedError) {
    searchColours(lightcook::test::soakBudget(3));
}

TEST(PackedTexels, ValuesBeyondTheFormatAreClampedAndCounted) {
    const float huge = std::numeric_limits<float>::max();
    const auto pair = imageOf(2, 1, [&](int x, int) { return x ? glm::vec4(-1, 2, huge, 1) : glm::vec4(70000, 65504, 0, 1); });
    const Encoded half = encode(PixelFormat::Rgba16f, pair);
    EXPECT_EQ(half.report.clampedHigh, 2);
    EXPECT_EQ(half.report.clampedNegative, 0);
    EXPECT_EQ(half.decoded.at(0, 0), glm::vec4(65504, 65504, 0, 1));
    EXPECT_EQ(half.decoded.at(1, 0), glm::vec4(-1, 2, 65504, 1));
    const Encoded shared = encode(PixelFormat::Rgb9e5, pair);
    EXPECT_EQ(shared.report.clampedHigh, 3);
    EXPECT_EQ(shared.report.clampedNegative, 1);
    EXPECT_EQ(shared.decoded.at(1, 0).b, 65408);
    const Encoded small = encode(PixelFormat::R11g11b10f, pair);
    EXPECT_EQ(small.report.clampedHigh, 3);
    EXPECT_EQ(small.decoded.at(0, 0).r, 65024);
    EXPECT_EQ(small.decoded.at(1, 0), glm::vec4(0, 2, 64512, 1));
}

}  // namespace
}  // namespace lightcook::compress::test

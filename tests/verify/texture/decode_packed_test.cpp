// Formats without blocks against independent closed forms: every half, every code of the small floats, every unorm.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "verify/texture/decode.h"
#include "verify/texture_unit.h"

namespace lightcook::verify {
namespace {

using formats::PixelFormat;

/// Returns sign * 2^(e - bias) * (1 + m / 2^bits) by ldexp, with subnormals and special values.
double smallFloatValue(std::uint32_t code, int exponentBits, int mantissaBits, bool hasSign) {
    const std::uint32_t mantissa = code & ((1u << mantissaBits) - 1), exponent = code >> mantissaBits & ((1u << exponentBits) - 1);
    const double sign = hasSign && (code >> (mantissaBits + exponentBits) & 1) != 0 ? -1 : 1;
    const int bias = (1 << (exponentBits - 1)) - 1;
    if (exponent == (1u << exponentBits) - 1)
        return mantissa == 0 ? sign * std::numeric_limits<double>::infinity() : std::numeric_limits<double>::quiet_NaN();
    if (exponent == 0) return sign * std::ldexp(mantissa, 1 - bias - mantissaBits);
    return sign * std::ldexp(1.0 + std::ldexp(mantissa, -mantissaBits), static_cast<int>(exponent) - bias);
}

void expectSame(double found, double expected, std::uint32_t code) {
    if (std::isnan(expected))
        EXPECT_TRUE(std::isnan(found)) << std::hex << code;
    else
        EXPECT_EQ(found, expected) << std::hex << code;
}

glm::vec4 decodeWord(PixelFormat format, std::uint64_t word) {
    std::vector<std::byte> bytes;
    for (int i = 0; i < formats::info(format).bytesPerBlock; ++i) bytes.push_back(static_cast<std::byte>(word >> (8 * i)));
    glm::vec4 texel(-7);
    decodeBlock(format, bytes, std::span(&texel, 1));
    return texel;
}

TEST(PackedFormats, EveryHalfHasItsValue) {
    for (std::uint32_t half = 0; half < 65536; ++half) {
        const double expected = smallFloatValue(half, 5, 10, true);
        expectSame(floatFromHalf(static_cast<std::uint16_t>(half)), expected, half);
        EXPECT_EQ(std::signbit(floatFromHalf(static_cast<std::uint16_t>(half))), half >= 0x8000);
        expectSame(decodeWord(PixelFormat::Rgba16f, static_cast<std::uint64_t>(half) << 48).a, expected, half);
        expectSame(decodeWord(PixelFormat::Rgb16f, static_cast<std::uint64_t>(half) << 32).b, expected, half);
    }
    EXPECT_EQ(decodeWord(PixelFormat::Rgba16f, 0x4400'4200'4000'3c00).r, 1.0f);
    EXPECT_EQ(decodeWord(PixelFormat::Rgba16f, 0x4400'4200'4000'3c00), glm::vec4(1, 2, 3, 4));
    EXPECT_EQ(decodeWord(PixelFormat::Rgb16f, 0x4200'4000'3c00), glm::vec4(1, 2, 3, 1));
}

TEST(PackedFormats, EveryCodeOfTheSmallFloatsHasItsValue) {
    for (std::uint32_t code = 0; code < 2048; ++code) {
        const double eleven = smallFloatValue(code, 5, 6, false);
        expectSame(decodeWord(PixelFormat::R11g11b10f, code).r, eleven, code);
        expectSame(decodeWord(PixelFormat::R11g11b10f, code << 11).g, eleven, code);
        if (code < 1024) expectSame(decodeWord(PixelFormat::R11g11b10f, code << 22).b, smallFloatValue(code, 5, 5, false), code);
    }
    EXPECT_EQ(decodeWord(PixelFormat::R11g11b10f, 0).a, 1.0f);
}

TEST(PackedFormats, EveryExponentAndMantissaOfRgb9e5HasItsValue) {
    for (std::uint32_t exponent = 0; exponent < 32; ++exponent)
        for (std::uint32_t mantissa = 0; mantissa < 512; ++mantissa) {
            const std::uint32_t other = 511 - mantissa;
            const glm::vec4 texel = decodeWord(PixelFormat::Rgb9e5, exponent << 27 | mantissa << 18 | other << 9 | mantissa);
            const double unit = std::pow(2.0, static_cast<double>(exponent) - 24);
            EXPECT_EQ(texel, glm::vec4(mantissa * unit, other * unit, mantissa * unit, 1));
        }
    EXPECT_EQ(decodeWord(PixelFormat::Rgb9e5, 0xffffffff).r, 65408.0f);  // the format's largest value
}

TEST(PackedFormats, EveryUnormIsItsFraction) {
    for (std::uint32_t code = 0; code < 65536; ++code) {
        const float expected = static_cast<float>(code / 65535.0);
        EXPECT_EQ(decodeWord(PixelFormat::R16Unorm, code), glm::vec4(expected, 0, 0, 1));
        EXPECT_EQ(decodeWord(PixelFormat::Rg16Unorm, code << 16), glm::vec4(0, expected, 0, 1));
        EXPECT_EQ(decodeWord(PixelFormat::Rgba16Unorm, static_cast<std::uint64_t>(code) << 48 | 0xffff), glm::vec4(1, 0, 0, expected));
    }
    for (std::uint32_t code = 0; code < 256; ++code)
        EXPECT_EQ(decodeWord(PixelFormat::Rgba8Unorm, code << 16 | 0xff), glm::vec4(1, 0, static_cast<float>(code / 255.0), 0));
}

/// encode(decode(code)) == code for every code, and alpha is linear.
TEST(PackedFormats, EverySrgbCodeEncodesBack) {
    for (std::uint32_t code = 0; code < 256; ++code) {
        const glm::vec4 texel = decodeWord(PixelFormat::Rgba8Srgb, code | code << 24);
        const double linear = texel.r, encoded = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
        EXPECT_NEAR(encoded * 255, code, 1e-3);
        EXPECT_EQ(texel.a, static_cast<float>(code / 255.0));
    }
}

}  // namespace
}  // namespace lightcook::verify

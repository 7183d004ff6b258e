#include "compress/texel/packed_texels.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>

#include "compress/texel/half.h"

namespace lightcook::compress {
namespace {

using formats::PixelFormat;

void store(std::uint64_t value, std::size_t byteCount, std::byte* out) {
    for (std::size_t i = 0; i < byteCount; ++i) out[i] = static_cast<std::byte>(value >> (8 * i));
}

/// Returns the nearest float with five bits of exponent, no sign and mantissaBits of mantissa, ties to even. value is in [0, largest].
std::uint32_t smallFloat(float value, int mantissaBits) {
    const int shift = 23 - mantissaBits;
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(value);
    if (bits >= 0x38800000u) {
        const std::uint32_t rebased = bits - 0x38000000u;
        const std::uint32_t half = (1u << (shift - 1)) - 1;
        return (rebased + half + ((rebased >> shift) & 1u)) >> shift;
    }
    // Steps of 2^(-14 - mantissaBits); nearbyint ties to even.
    return static_cast<std::uint32_t>(std::nearbyint(std::ldexp(value, 14 + mantissaBits)));
}

float fromSmallFloat(std::uint32_t packed, int mantissaBits) {
    const std::uint32_t exponent = packed >> mantissaBits, mantissa = packed & ((1u << mantissaBits) - 1);
    if (exponent == 0) return std::ldexp(static_cast<float>(mantissa), -14 - mantissaBits);
    return std::ldexp(static_cast<float>(mantissa + (1u << mantissaBits)), static_cast<int>(exponent) - 15 - mantissaBits);
}

glm::vec4 encodeR11g11b10f(const glm::vec4& texel, std::byte* out) {
    const std::uint32_t r = smallFloat(texel.r, 6), g = smallFloat(texel.g, 6), b = smallFloat(texel.b, 5);
    store(r | g << 11 | b << 22, 4, out);
    return {fromSmallFloat(r, 6), fromSmallFloat(g, 6), fromSmallFloat(b, 5), 1};
}

/// Returns the squared error of one channel in the metric.
double squaredError(double decoded, double value, const EncodeOptions& options) {
    const auto scale = static_cast<double>(options.hdrScale);
    double difference = decoded - value;
    if (options.hdrMetric == HdrMetric::Log) difference = std::log2((1 + decoded / scale) / (1 + value / scale));
    if (options.hdrMetric == HdrMetric::Relative) difference /= value + scale;
    return difference * difference;
}

constexpr int kRgb9e5Bias = 15, kRgb9e5MantissaBits = 9, kRgb9e5LargestMantissa = 511;

/// Searches for the exponent with the least error. The smallest exponent that holds the largest channel clamps nothing. Below it the step
/// is finer, and clamping the largest channel may cost less than the other channels gain. The search goes down until the error of clamping
/// alone is not below the best error.
glm::vec4 encodeRgb9e5(const glm::vec4& texel, const EncodeOptions& options, std::byte* out) {
    const float largest = std::max({texel.r, texel.g, texel.b});
    const auto unitOf = [](int exponent) { return std::ldexp(1.0, exponent - kRgb9e5Bias - kRgb9e5MantissaBits); };
    int exponent = std::clamp(largest > 0 ? std::ilogb(largest) + 1 + kRgb9e5Bias : 0, 0, 31);
    if (exponent < 31 && std::floor(static_cast<double>(largest) / unitOf(exponent) + 0.5) > kRgb9e5LargestMantissa) ++exponent;
    double bestError = std::numeric_limits<double>::infinity();
    std::uint32_t bestPacked = 0;
    glm::vec4 bestDecoded(0, 0, 0, 1);
    for (int e = exponent; e >= 0; --e) {
        const double unit = unitOf(e);
        double error = 0, cut = 0;
        auto packed = static_cast<std::uint32_t>(e) << 27;
        glm::vec4 decoded(0, 0, 0, 1);
        for (int c = 0; c < 3; ++c) {
            const auto value = static_cast<double>(texel[c]);
            const double below = std::min(std::floor(value / unit), double{kRgb9e5LargestMantissa});
            const double above = std::min(below + 1, double{kRgb9e5LargestMantissa});
            const bool up = squaredError(above * unit, value, options) < squaredError(below * unit, value, options);
            const double mantissa = up ? above : below;
            packed |= static_cast<std::uint32_t>(mantissa) << (9 * c);
            decoded[c] = static_cast<float>(mantissa * unit);
            const double channelError =
                static_cast<double>(options.channelWeights[static_cast<std::size_t>(c)]) * squaredError(mantissa * unit, value, options);
            error += channelError;
            if (value > kRgb9e5LargestMantissa * unit) cut += channelError;
        }
        if (error < bestError) {
            bestError = error;
            bestPacked = packed;
            bestDecoded = decoded;
        }
        if (cut >= bestError) break;
    }
    store(bestPacked, 4, out);
    return bestDecoded;
}

glm::vec4 encodeHalves(const glm::vec4& texel, int channelCount, std::byte* out) {
    glm::vec4 decoded(0, 0, 0, 1);
    for (int c = 0; c < channelCount; ++c) {
        const std::uint16_t half = halfFromFloat(texel[c]);
        store(half, 2, out + 2 * c);
        decoded[c] = floatFromHalf(half);
    }
    return decoded;
}

glm::vec4 encodeUnorm(const glm::vec4& texel, int channelCount, int bits, std::byte* out) {
    const float largest = static_cast<float>((1 << bits) - 1);
    glm::vec4 decoded(0, 0, 0, 1);
    for (int c = 0; c < channelCount; ++c) {
        const auto code = static_cast<std::uint32_t>(static_cast<double>(texel[c]) * static_cast<double>(largest) + 0.5);
        store(code, static_cast<std::size_t>(bits / 8), out + c * bits / 8);
        decoded[c] = static_cast<float>(code) / largest;
    }
    return decoded;
}

double linearFromSrgb(double code) {
    return code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4);
}
double srgbFromLinear(double value) {
    return value <= 0.0031308 ? value * 12.92 : 1.055 * std::pow(value, 1 / 2.4) - 0.055;
}

/// Encodes to the nearest code in the sRGB domain, whose steps are perceptually uniform.
glm::vec4 encodeSrgb(const glm::vec4& texel, std::byte* out) {
    static const std::array<float, 256> linearFromCode = [] {
        std::array<float, 256> table{};
        for (std::size_t i = 0; i < 256; ++i) table[i] = static_cast<float>(linearFromSrgb(static_cast<double>(i) / 255));
        return table;
    }();
    glm::vec4 decoded = encodeUnorm(texel, 4, 8, out);
    for (int c = 0; c < 3; ++c) {
        const auto code = static_cast<std::uint32_t>(srgbFromLinear(static_cast<double>(texel[c])) * 255 + 0.5);
        out[c] = static_cast<std::byte>(code);
        decoded[c] = linearFromCode[code];
    }
    return decoded;
}

/// Returns the largest value of a channel that the format holds.
float largestValue(PixelFormat format, int channel) {
    switch (format) {
        case PixelFormat::Rgb9e5:
            return 65408.0f;  // 511/512 * 2^16
        case PixelFormat::R11g11b10f:
            return channel == 2 ? 64512.0f : 65024.0f;  // (2 - 2^-5) and (2 - 2^-6) * 2^15
        case PixelFormat::Astc4x4Hdr:
        case PixelFormat::Astc6x6Hdr:
        case PixelFormat::Astc8x8Hdr:
            return channel == 3 ? 1.0f : kLargestHalf;
        default:
            return formats::info(format).isFloat ? kLargestHalf : 1.0f;
    }
}

}  // namespace

glm::vec4 encodeTexel(PixelFormat format, const glm::vec4& texel, const EncodeOptions& options, std::byte* out) {
    switch (format) {
        case PixelFormat::Rgb9e5:
            return encodeRgb9e5(texel, options, out);
        case PixelFormat::R11g11b10f:
            return encodeR11g11b10f(texel, out);
        case PixelFormat::Rgba16f:
            return encodeHalves(texel, 4, out);
        case PixelFormat::Rgb16f:
            return encodeHalves(texel, 3, out);
        case PixelFormat::R16Unorm:
            return encodeUnorm(texel, 1, 16, out);
        case PixelFormat::Rg16Unorm:
            return encodeUnorm(texel, 2, 16, out);
        case PixelFormat::Rgba16Unorm:
            return encodeUnorm(texel, 4, 16, out);
        case PixelFormat::Rgba8Unorm:
            return encodeUnorm(texel, 4, 8, out);
        case PixelFormat::Rgba8Srgb:
            return encodeSrgb(texel, out);
        default:
            assert(false && "a format made of blocks");
            return glm::vec4(0);
    }
}

ChannelRange rangeOf(PixelFormat format) {
    ChannelRange range;
    for (int c = 0; c < 4; ++c) range.high[c] = largestValue(format, c);
    // Halves keep their sign.
    const bool isSigned = formats::info(format).isSigned || format == PixelFormat::Rgba16f || format == PixelFormat::Rgb16f;
    range.low = isSigned ? -range.high : glm::vec4(0);
    return range;
}

}  // namespace lightcook::compress

// The sampler tolerance of BC1 to BC5 covers the decoders of three GPU vendors, as found by F. Giesen, GPU BCn decoding, 2021
// (fgiesen.wordpress.com/2021/10/04/gpu-bcn-decoding). Every pair of endpoints, every palette entry.
#include "verify/sampler_tolerance.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>

#include "verify/texture/decode.h"

namespace lightcook::verify {
namespace {

using formats::PixelFormat;

/// A GPU's rule for one channel of a palette entry: returns the value in [0, 1] or [-1, 1] at numerator / steps from a to b.
/// numerator  1 to steps - 1
using Entry = std::function<double(int a, int b, int numerator, int steps)>;

int expanded(int value, int bits) {
    return value << (8 - bits) | value >> (2 * bits - 8);
}
/// The rule of a vendor that rounds the weight to 2^bits-ths, and the sum to the endpoints' unit.
int blended(int a, int b, int numerator, int steps, int bits) {
    const int one = 1 << bits, weight = static_cast<int>(std::lround(static_cast<double>(numerator) * one / steps));
    return ((one - weight) * a + weight * b + one / 2) >> bits;
}
/// The rule of a vendor that adds the difference of the endpoints times a short factor over a power of two: `start` and `difference` of an
/// entry.
struct FromAnEnd {
    int start, difference;
};
FromAnEnd fromAnEnd(int a, int b, int numerator, int steps) {
    const auto isPower = [](int value) { return (value & (value - 1)) == 0; };
    const int rest = steps - numerator;
    return isPower(numerator) && !(isPower(rest) && rest < numerator) ? FromAnEnd{a, (b - a) * numerator} : FromAnEnd{b, (a - b) * rest};
}

struct Gpu {
    const char* name;
    Entry red, green, alpha, scalar, scalarSigned;
};

Entry eightBits(int endBits, int weightBits) {
    return [=](int a, int b, int numerator, int steps) {
        const int left = endBits == 8 ? a : expanded(a, endBits), right = endBits == 8 ? b : expanded(b, endBits);
        return blended(left, right, numerator, steps, weightBits) / 255.0;
    };
}
/// The rule of a vendor whose BC4 has weights in 2^bits-ths and an unrounded sum.
Entry exactSum(int weightBits, double scale) {
    return [=](int a, int b, int numerator, int steps) {
        const int one = 1 << weightBits;
        const double weight = std::round(static_cast<double>(numerator) * one / steps);
        return ((one - weight) * a + weight * b) / (scale * one);
    };
}

std::vector<Gpu> gpus() {
    const auto factor = [](int steps) { return steps == 7 ? 36 : 48; };
    const Entry shortRed = [](int a, int b, int numerator, int steps) {
        return steps == 3 ? (((3 - numerator) * a + numerator * b) * 22 >> 3) / 255.0 : ((a + b) * 33 >> 3) / 255.0;
    };
    const Entry shortGreen = [](int a, int b, int numerator, int steps) {
        const int left = expanded(a, 6), right = expanded(b, 6), difference = right - left;
        const int scaled = (steps == 3 ? 80 : 128) * difference + (difference >> 2);
        return (numerator == 1 ? left + ((128 + scaled) >> 8) : right + ((128 - scaled) >> 8)) / 255.0;
    };
    const Entry shortAlpha = [=](int a, int b, int numerator, int steps) {
        const FromAnEnd from = fromAnEnd(a, b, numerator, steps);
        return (from.start + ((factor(steps) * from.difference + (from.difference >> 3) + 128) >> 8)) / 255.0;
    };
    const Entry shortScalar = [=](int a, int b, int numerator, int steps) {
        const FromAnEnd from = fromAnEnd(a, b, numerator, steps);
        return (from.start * 257 + factor(steps) * from.difference) / 65535.0;
    };
    const Entry shortSigned = [=](int a, int b, int numerator, int steps) {
        const FromAnEnd from = fromAnEnd(a, b, numerator, steps);
        const int start = std::abs(from.start) * ((1 << 14) + (1 << 7) + 1) >> 6;
        return ((from.start < 0 ? -start : start) + factor(steps) * from.difference) / 32767.0;
    };
    return {{"weights of 8 bits", eightBits(5, 8), eightBits(6, 8), eightBits(8, 8), exactSum(16, 255), exactSum(16, 127)},
            {"weights of 6 bits", eightBits(5, 6), eightBits(6, 6), eightBits(8, 6), exactSum(6, 255), exactSum(6, 127)},
            {"short factors", shortRed, shortGreen, shortAlpha, shortScalar, shortSigned}};
}

/// Largest difference relative to the tolerance, and in codes of 255.
struct Off {
    double part = 0, codes = 0;
    void add(double gpu, double ours, double allowed) {
        part = std::max(part, std::abs(gpu - ours) / allowed);
        codes = std::max(codes, 255 * std::abs(gpu - ours));
    }
};

/// Compares all BC4 blocks with endpoints a and b under a GPU's rule.
Off scalarOff(PixelFormat format, const Entry& gpu) {
    const bool isSigned = formats::info(format).isSigned;
    const FormatTolerance tolerance = toleranceOf(format);
    const bool isAlpha = format == PixelFormat::Bc3;
    const int channel = isAlpha ? 3 : 0;
    Off off;
    for (int a = isSigned ? -127 : 0; a <= (isSigned ? 127 : 255); ++a)
        for (int b = isSigned ? -127 : 0; b <= (isSigned ? 127 : 255); ++b) {
            std::array<std::byte, 16> block{static_cast<std::byte>(a), static_cast<std::byte>(b)};
            std::uint64_t indices = 0;
            for (std::uint64_t texel = 0; texel < 8; ++texel) indices |= texel << (3 * texel);
            for (std::size_t i = 0; i < 6; ++i) block[2 + i] = static_cast<std::byte>(indices >> (8 * i));
            std::array<glm::vec4, 16> ours;
            if (isAlpha)
                decodeBc3(block, ours);
            else if (isSigned)
                decodeBc4Snorm(std::span(block).first<8>(), ours);
            else
                decodeBc4(std::span(block).first<8>(), ours);
            const std::size_t bytes = isAlpha ? 16 : 8;
            const glm::vec4 span = blockSpans(format, std::span(block).first(bytes), 4).at(0, 0);
            const double allowed = static_cast<double>(tolerance.decoded[channel] + tolerance.perSpan[channel] * span[channel]);
            const int steps = a > b ? 7 : 5;
            for (int numerator = 1; numerator < steps; ++numerator)
                off.add(gpu(a, b, numerator, steps), static_cast<double>(ours[static_cast<std::size_t>(numerator + 1)][channel]), allowed);
        }
    return off;
}

/// Compares all BC1 blocks, one channel at a time. The order of the complete endpoints selects the palette.
Off colourOff(int channel, const Entry& gpu) {
    const int bits = channel == 1 ? 6 : 5, shift = channel == 0 ? 11 : channel == 1 ? 5 : 0;
    const FormatTolerance tolerance = toleranceOf(PixelFormat::Bc1);
    Off off;
    for (int a = 0; a < 1 << bits; ++a)
        for (int b = 0; b < 1 << bits; ++b) {
            const int first = a << shift, second = b << shift;
            const std::array<std::byte, 8> block = {static_cast<std::byte>(first), static_cast<std::byte>(first >> 8),
                                                    static_cast<std::byte>(second), static_cast<std::byte>(second >> 8), std::byte{0xe4}};
            std::array<glm::vec4, 16> ours;
            decodeBc1(block, ours);
            const glm::vec4 span = blockSpans(PixelFormat::Bc1, block, 4).at(0, 0);
            const double allowed = static_cast<double>(tolerance.decoded[channel] + tolerance.perSpan[channel] * span[channel]);
            const int steps = first > second ? 3 : 2;
            for (int numerator = 1; numerator < steps; ++numerator)
                off.add(gpu(a, b, numerator, steps), static_cast<double>(ours[static_cast<std::size_t>(numerator + 1)][channel]), allowed);
        }
    return off;
}

TEST(FormatTolerance, CoversEveryGpuWithAKnownDecoder) {
    double most = 0;
    for (const Gpu& gpu : gpus()) {
        const std::array<std::pair<const char*, Off>, 6> offs = {{{"red", colourOff(0, gpu.red)},
                                                                  {"green", colourOff(1, gpu.green)},
                                                                  {"blue", colourOff(2, gpu.red)},
                                                                  {"BC3's alpha", scalarOff(PixelFormat::Bc3, gpu.alpha)},
                                                                  {"BC4", scalarOff(PixelFormat::Bc4, gpu.scalar)},
                                                                  {"BC4 snorm", scalarOff(PixelFormat::Bc4Snorm, gpu.scalarSigned)}}};
        for (const auto& [what, off] : offs) {
            std::printf("figures %-18s %-12s %.2f codes off, %.2f of what is allowed\n", gpu.name, what, off.codes, off.part);
            EXPECT_LE(off.part, 1) << gpu.name << ", " << what;
            most = std::max(most, off.codes);
        }
    }
    EXPECT_GT(most, 4) << "two codes alone would do: the share of the ends is not tested";
}

}  // namespace
}  // namespace lightcook::verify

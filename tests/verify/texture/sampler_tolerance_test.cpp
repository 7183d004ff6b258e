// The tolerance that the bounds leave to a sampler's BC1 to BC5, held against what GPUs of three makers were found to do: F. Giesen, GPU
// BCn decoding, 2021 (fgiesen.wordpress.com/2021/10/04/gpu-bcn-decoding). Every pair of ends, every palette entry.
#include "verify/sampler_tolerance.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>

#include "verify/texture/decode.h"

namespace lightcook::verify {
namespace {

using formats::PixelFormat;

/// One channel's palette entry as a GPU sees it, in [0, 1] or [-1, 1].
/// numerator  of steps, the way from a to b: 1 to steps - 1
using Entry = std::function<double(int a, int b, int numerator, int steps)>;

int expanded(int value, int bits) {
    return value << (8 - bits) | value >> (2 * bits - 8);
}
/// A weight in 2^bits-ths, rounded, and the sum rounded to the ends' own unit.
int blended(int a, int b, int numerator, int steps, int bits) {
    const int one = 1 << bits, weight = static_cast<int>(std::lround(static_cast<double>(numerator) * one / steps));
    return ((one - weight) * a + weight * b + one / 2) >> bits;
}
/// The maker that goes from one of the ends by the least power of two there is, times a short factor: `start` and `difference` of such an
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
/// BC4 with weights in 2^bits-ths and a sum that keeps all its bits.
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

/// Largest part of what is allowed, and largest difference in codes of 255.
struct Off {
    double part = 0, codes = 0;
    void add(double gpu, double ours, double allowed) {
        part = std::max(part, std::abs(gpu - ours) / allowed);
        codes = std::max(codes, 255 * std::abs(gpu - ours));
    }
};

/// All of BC4's blocks, whose ends are a and b, under a GPU's rule.
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

/// All of BC1's, one channel at a time; which of the two palettes a block has is told by the whole of its ends.
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

TEST(FormatTolerance, EveryGpuWhoseDecoderIsKnownStaysInsideIt) {
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

// Signed BC4 and BC5: both decoders against the formula of the format (OpenImageIO 2.4 cannot read such files), the encoder against an
// exhaustive search.
#include "compress/block/highway_targets.h"

#include <gtest/gtest.h>

#include <hwy/targets.h>

#include <algorithm>
#include <cmath>

#include "compress/block/decode.h"
#include "tests/compress/codec_images.h"
#include "verify/texture_unit.h"

namespace lightcook::compress::test {
namespace {

using formats::PixelFormat;
using Bytes8 = std::array<std::byte, 8>;

/// Returns the sixteen values of one channel, from the formula: endpoints / 127, -128 as -127; seven steps if the first byte is larger.
std::array<long double, kTexelCount> byFormula(const std::byte* block) {
    const int first = static_cast<signed char>(block[0]), second = static_cast<signed char>(block[1]);
    const long double a = std::max(first, -127) / 127.0L, b = std::max(second, -127) / 127.0L;
    std::uint64_t indices = 0;
    for (int i = 7; i >= 2; --i) indices = indices * 256 + std::to_integer<std::uint64_t>(block[i]);
    std::array<long double, kTexelCount> values;
    for (long double& value : values) {
        const auto index = static_cast<long double>(indices % 8);
        if (index == 0)
            value = a;
        else if (index == 1)
            value = b;
        else if (first > second)
            value = ((8 - index) * a + (index - 1) * b) / 7;
        else
            value = index == 6 ? -1 : index == 7 ? 1 : ((6 - index) * a + (index - 1) * b) / 5;
        indices /= 8;
    }
    return values;
}

void expectFormula(PixelFormat format, std::span<const std::byte> block) {
    DecodedBlock ours, theirs;
    (format == PixelFormat::Bc4Snorm ? decodeBc4Snorm : decodeBc5Snorm)(block.data(), ours);
    verify::decodeBlock(format, block, theirs);
    const int channels = formats::info(format).channelCount;
    for (int c = 0; c < channels; ++c) {
        const auto expected = byFormula(block.data() + 8 * c);
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            ASSERT_NEAR(static_cast<double>(ours[t][c]), static_cast<double>(expected[t]), 3e-7);
            ASSERT_NEAR(static_cast<double>(theirs[t][c]), static_cast<double>(expected[t]), 3e-7);
        }
    }
    for (std::size_t t = 0; t < kTexelCount; ++t)
        for (int c = channels; c < 4; ++c) ASSERT_EQ(ours[t][c], theirs[t][c]);
}

TEST(BcSnorm, DecodersFollowTheFormulaAtEveryPairOfEnds) {
    // Every index is used.
    Bytes8 block = {std::byte{0},    std::byte{0},    std::byte{0x88}, std::byte{0xc6},
                    std::byte{0xfa}, std::byte{0x88}, std::byte{0xc6}, std::byte{0xfa}};
    for (int first = 0; first < 256; ++first)
        for (int second = 0; second < 256; ++second) {
            block[0] = static_cast<std::byte>(first);
            block[1] = static_cast<std::byte>(second);
            expectFormula(PixelFormat::Bc4Snorm, block);
        }
}

TEST(BcSnorm, DecodersFollowTheFormulaOnAnyBytes) {
    Random random(71);
    for (int i = 0; i < 200000; ++i) {
        std::array<std::byte, 16> block;
        for (std::byte& byte : block) byte = static_cast<std::byte>(random.bits());
        expectFormula(PixelFormat::Bc4Snorm, std::span(block).first<8>());
        expectFormula(PixelFormat::Bc5Snorm, block);
    }
}

TEST(BcSnorm, EveryCodeComesBackExactly) {
    for (int code = -127; code <= 127; ++code)
        for (const int level : {0, 5, 9}) {
            const float value = static_cast<float>(code) / 127;
            const Encoded result =
                encode(PixelFormat::Bc4Snorm, imageOf(4, 4, [&](int, int) { return glm::vec4(value, 0, 0, 1); }), effort(level));
            for (const glm::vec4& texel : result.decoded.texels()) ASSERT_NEAR(texel.r, value, 1e-6f) << code;
        }
}

TEST(BcSnorm, OneValueErrsByAtMostAFourteenthOfACode) {
    Random random(72);
    for (int i = 0; i < 4000; ++i) {
        const float value = random.unit() * 2 - 1;
        const Encoded result = encode(PixelFormat::Bc4Snorm, imageOf(4, 4, [&](int, int) { return glm::vec4(value, 0, 0, 1); }));
        ASSERT_NEAR(result.decoded.at(1, 3).r * 127, value * 127, 1.0 / 14 + 1e-4) << value;
    }
}

/// Returns values of every kind: ramps through zero and below, extremes, both zeros, noise.
TexelImage signedImage(int kind) {
    Random random(73);
    return imageOf(64, 64, [&](int x, int y) {
        const float u = static_cast<float>(x) / 63, v = static_cast<float>(y) / 63;
        const float noise = random.unit() * 2 - 1, other = random.unit() * 2 - 1;
        if (kind == 0) return glm::vec4(-u, -0.5f * v - 0.25f * u, 0, 1);
        if (kind == 1) return glm::vec4(2 * u - 1, 1 - 2 * v, 0, 1);
        if (kind == 2) return glm::vec4(random.below(3) - 1, noise < 0 ? -0.0f : 0.0f, 0, 1);
        return glm::vec4(noise, other * other * other, 0, 1);
    });
}

/// Returns the least error of any block [codes^2], by trying every pair of endpoints in both modes.
double leastError(const std::array<double, kTexelCount>& codes, double limit) {
    double best = limit;
    for (int low = -127; low <= 127; ++low)
        for (int high = low; high <= 127; ++high)
            for (const int steps : {5, 7}) {
                if (steps == 7 && low == high) continue;
                double error = 0;
                for (std::size_t t = 0; t < kTexelCount && error < best; ++t) {
                    double nearest = steps == 5 ? std::min(codes[t] + 127, 127 - codes[t]) : 1e9;
                    for (int i = 0; i <= steps; ++i)
                        nearest = std::min(nearest, std::abs(low + (high - low) * i / static_cast<double>(steps) - codes[t]));
                    error += nearest * nearest;
                }
                best = std::min(best, error);
            }
    return best;
}

TEST(BcSnorm, HighestEffortEqualsExhaustiveSearch) {
    for (int kind = 0; kind < 4; ++kind) {
        const TexelImage image = signedImage(kind);
        const Encoded result = encode(PixelFormat::Bc4Snorm, image, effort(9));
        for (int at = 0; at < 64; at += 12) {
            std::array<double, kTexelCount> codes;
            double error = 0;
            for (int t = 0; t < kTexelCount; ++t) {
                const int x = at + t % 4, y = at + t / 4;
                codes[static_cast<std::size_t>(t)] = static_cast<double>(image.at(x, y).r) * 127;
                error += std::pow(static_cast<double>(result.decoded.at(x, y).r) * 127 - codes[static_cast<std::size_t>(t)], 2);
            }
            ASSERT_LE(error, leastError(codes, error) * (1 + 1e-4) + 1e-4) << "kind " << kind << " at " << at;
        }
    }
}

/// Negative values get the same precision as positive ones.
TEST(BcSnorm, MirroredValuesAreCodedAsWell) {
    constexpr std::array kMost = {0.002, 0.004, 1e-7, 0.055};
    for (int kind = 0; kind < 4; ++kind) {
        const TexelImage image = signedImage(kind);
        const TexelImage mirrored = imageOf(64, 64, [&](int x, int y) { return glm::vec4(-image.at(x, y).r, -image.at(x, y).g, 0, 1); });
        const double error = rmsError(encode(PixelFormat::Bc5Snorm, image, effort(9)).decoded, image, 2);
        EXPECT_NEAR(error, rmsError(encode(PixelFormat::Bc5Snorm, mirrored, effort(9)).decoded, mirrored, 2), 1e-5) << "kind " << kind;
        EXPECT_LE(error, kMost[static_cast<std::size_t>(kind)]) << "kind " << kind;
    }
}

TEST(BcSnorm, MinusOneIsNeverWrittenAsMinus128) {
    for (int kind = 0; kind < 4; ++kind)
        for (int level = 0; level <= 9; ++level) {
            const Encoded result = encode(PixelFormat::Bc4Snorm, signedImage(kind), effort(level));
            for (std::size_t at = 0; at < result.bytes.size(); at += 8) {
                ASSERT_NE(result.bytes[at], std::byte{0x80});
                ASSERT_NE(result.bytes[at + 1], std::byte{0x80});
            }
        }
}

TEST(BcSnorm, EveryInstructionSetGivesTheSameBytes) {
    const std::vector<std::int64_t> targets = hwy::SupportedAndGeneratedTargets();
    if (targets.size() < 2) GTEST_SKIP() << "this machine has one instruction set";
    for (int kind = 0; kind < 4; ++kind)
        for (const int level : {0, 3, 5, 8}) {
            std::vector<std::byte> first;
            for (const std::int64_t target : targets) {
                hwy::GetChosenTarget().Update(target);
                const std::vector<std::byte> bytes = encode(PixelFormat::Bc5Snorm, signedImage(kind), effort(level)).bytes;
                if (first.empty()) first = bytes;
                EXPECT_EQ(bytes, first) << "kind " << kind << " effort " << level;
            }
        }
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

TEST(BcSnorm, ValuesBeyondOneAreClampedAndCounted) {
    const auto image = imageOf(4, 4, [](int x, int) {
        return glm::vec4(x == 0 ? -1.5f : x == 1 ? 2.0f : -1.0f, x == 2 ? -3.0f : 0.5f, 9, 9);
    });
    const Encoded red = encode(PixelFormat::Bc4Snorm, image), both = encode(PixelFormat::Bc5Snorm, image);
    EXPECT_EQ(red.report.clampedHigh, 8);
    EXPECT_EQ(both.report.clampedHigh, 12);
    EXPECT_EQ(both.report.clampedNegative, 0);
    for (int x = 0; x < 4; ++x) EXPECT_EQ(red.decoded.at(x, 2).r, x == 1 ? 1.0f : -1.0f);
}

TEST(BcSnorm, ChannelsOfBc5AreThoseOfTwoBc4) {
    const TexelImage image = signedImage(3);
    const TexelImage green = imageOf(64, 64, [&](int x, int y) { return glm::vec4(image.at(x, y).g, 0, 0, 1); });
    const auto both = encode(PixelFormat::Bc5Snorm, image).bytes, first = encode(PixelFormat::Bc4Snorm, image).bytes,
               second = encode(PixelFormat::Bc4Snorm, green).bytes;
    for (std::size_t at = 0; at < first.size(); ++at) {
        ASSERT_EQ(both[at / 8 * 16 + at % 8], first[at]);
        ASSERT_EQ(both[at / 8 * 16 + 8 + at % 8], second[at]);
    }
}

}  // namespace
}  // namespace lightcook::compress::test

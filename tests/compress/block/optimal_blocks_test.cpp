// Blocks of one and of two colours, and hostile ones in BC4, against the least error that any block of the format could have. Every search
// here is the plain one, written from the format and from nothing in compress/. Errors are compared and not bytes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/compress/hostile_blocks.h"

namespace lightcook::compress::test {
namespace {

using formats::PixelFormat;

/// Sixteen texels of one or two colours, and what each texel weighs.
struct FewColours {
    std::array<glm::dvec4, 2> colour;
    std::uint32_t second = 0;  ///< texels that have the second colour
    TexelImage image = TexelImage(4, 4);
    formats::Image<float> significance = formats::Image<float>(4, 4, 1.0f);

    double weightOf(int which) const {
        double sum = 0;
        for (int t = 0; t < kTexelCount; ++t)
            if (static_cast<int>(second >> t & 1) == which) sum += static_cast<double>(significance.at(t % 4, t / 4));
        return sum;
    }
    void paint() {
        for (int t = 0; t < kTexelCount; ++t) image.at(t % 4, t / 4) = glm::vec4(colour[second >> t & 1]);
    }
};

/// Colours of whole bytes, of any value, near one another, and extremes; patterns of every kind; weights in half of them.
FewColours twoUnitColours(Random& random, int number) {
    FewColours block;
    const auto any = [&] { return static_cast<double>(random.unit()); };
    for (int c = 0; c < 4; ++c) {
        double a = any(), b = number % 4 == 1 ? std::clamp(a + (any() - 0.5) * 0.1, 0.0, 1.0) : any();
        if (number % 4 == 2) a = std::nearbyint(a * 255) / 255, b = std::nearbyint(b * 255) / 255;
        if (number % 4 == 3) a = random.below(3) / 2.0, b = random.below(3) / 2.0;
        block.colour[0][c] = static_cast<double>(static_cast<float>(a));
        block.colour[1][c] = static_cast<double>(static_cast<float>(b));
    }
    // Straight edges, checks, single texels, anything.
    constexpr std::array<std::uint32_t, 6> kPatterns = {0xCCCC, 0xFF00, 0xA5A5, 0x8000, 0xFFFE, 0x8CEF};
    block.second = number % 3 ? random.bits() & 0xFFFF : kPatterns[static_cast<std::size_t>(random.below(6))];
    block.second = block.second == 0 || block.second == 0xFFFF ? 0x00F0 : block.second;
    if (number % 2)
        for (float& weight : block.significance.texels()) weight = 0.25f * static_cast<float>(1 + random.below(8));
    block.paint();
    return block;
}

double weightedError(const FewColours& block, const TexelImage& decoded, int firstChannel, int endChannel) {
    double sum = 0;
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x)
            for (int c = firstChannel; c < endChannel; ++c) {
                const double miss = static_cast<double>(decoded.at(x, y)[c]) - static_cast<double>(block.image.at(x, y)[c]);
                sum += static_cast<double>(block.significance.at(x, y)) * miss * miss;
            }
    return sum;
}
TexelImage decodedOf(PixelFormat format, const FewColours& block, int level) {
    return encode(format, block.image, effort(level), block.significance.view()).decoded;
}

/// What an error may be above the least, where the encoder's values and the decoder's are floats that are off by as much as `away` each:
/// sum w (m + a)^2 - sum w m^2 <= 2 a sqrt(sum w sum w m^2) + a^2 sum w.
double roundingOf(double least, double weight, double away) {
    return 2 * away * std::sqrt(least * weight) + away * away * weight;
}

// ---- BC1 and the colour of BC3 ------------------------------------------------------------------------------------------------------

/// Every pair of codes of every channel for every pair of places on the line. The index that is black, or transparent, is not a place.
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

TEST(TwoColours, Bc1AndBc3EqualEveryPairOfEnds) {
    Random random(91);
    for (int i = 0; i < 400; ++i) {
        const FewColours block = twoUnitColours(random, i);
        const double four = leastBc1(block, false), any = leastBc1(block, true), weight = block.weightOf(0) + block.weightOf(1);
        ASSERT_NEAR(weightedError(block, decodedOf(PixelFormat::Bc1, block, 9), 0, 3), any, roundingOf(any, 3 * weight, 2e-7)) << i;
        ASSERT_NEAR(weightedError(block, decodedOf(PixelFormat::Bc3, block, 9), 0, 3), four, roundingOf(four, 3 * weight, 2e-7)) << i;
    }
}

TEST(OneColour, Bc1AndBc3EqualEveryPairOfEndsAtEveryEffort) {
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

// ---- BC4, BC5 and the alpha of BC3 --------------------------------------------------------------------------------------------------

/// Least error of sixteen weighed values, in codes squared, over every pair of ends in both layouts.
double leastBc4(const std::array<double, 16>& codes, const std::array<double, 16>& weights, int largest, double limit) {
    double best = limit;
    for (int low = 0; low <= largest; ++low)
        for (int high = low; high <= largest; ++high)
            for (const int steps : {5, 7}) {
                if (steps == 7 && low == high) continue;
                double error = 0;
                for (std::size_t t = 0; t < 16 && error < best; ++t) {
                    if (!(weights[t] > 0)) continue;
                    double nearest = steps == 5 ? std::min(codes[t], largest - codes[t]) : 1e9;
                    for (int i = 0; i <= steps; ++i)
                        nearest = std::min(nearest, std::abs(low + (high - low) * i / static_cast<double>(steps) - codes[t]));
                    error += weights[t] * nearest * nearest;
                }
                best = std::min(best, error);
            }
    return best;
}

/// Holds one channel of a decoded block against the least.
void expectLeastBc4(const TexelImage& image, const formats::Image<float>& significance, const TexelImage& decoded, int channel,
                    bool isSigned, int left, int top, const std::string& what) {
    std::array<double, 16> codes, weights;
    const double scale = isSigned ? 127 : 255, offset = isSigned ? 127 : 0;
    double error = 0, total = 0;
    for (int t = 0; t < 16; ++t) {
        const int x = left + t % 4, y = top + t / 4;
        const auto at = static_cast<std::size_t>(t);
        const double value = std::clamp(static_cast<double>(image.at(x, y)[channel]), isSigned ? -1.0 : 0.0, 1.0);
        codes[at] = value * scale + offset;
        weights[at] = static_cast<double>(significance.at(x, y));
        error += weights[at] * std::pow(static_cast<double>(decoded.at(x, y)[channel]) * scale + offset - codes[at], 2);
        total += weights[at];
    }
    const double least = leastBc4(codes, weights, isSigned ? 254 : 255, error);
    ASSERT_LE(error, least + roundingOf(least, total, 5e-5)) << what;
}

constexpr PixelFormat kBc4Formats[] = {PixelFormat::Bc4, PixelFormat::Bc5, PixelFormat::Bc4Snorm, PixelFormat::Bc5Snorm, PixelFormat::Bc3};

void expectLeastBc4(const FewColours& block, PixelFormat format, int level, const std::string& what) {
    const bool isSigned = formats::info(format).isSigned;
    TexelImage image = block.image.copy();
    if (isSigned)
        for (glm::vec4& texel : image.texels()) texel = 2.0f * texel - 1.0f;
    const TexelImage decoded = encode(format, image, effort(level), block.significance.view()).decoded;
    const int first = format == PixelFormat::Bc3 ? 3 : 0, end = format == PixelFormat::Bc3 ? 4 : formats::info(format).channelCount;
    for (int c = first; c < end; ++c) expectLeastBc4(image, block.significance, decoded, c, isSigned, 0, 0, what);
}

TEST(TwoColours, Bc4AndBc5EqualEveryPairOfEnds) {
    Random random(93);
    for (int i = 0; i < 200; ++i) {
        const FewColours block = twoUnitColours(random, i);
        for (const PixelFormat format : kBc4Formats) expectLeastBc4(block, format, 9, std::to_string(i));
    }
}

TEST(OneColour, Bc4AndBc5EqualEveryPairOfEndsAtEveryEffort) {
    Random random(94);
    for (int i = 0; i < 100; ++i) {
        FewColours block = twoUnitColours(random, i);
        block.colour[1] = block.colour[0];
        block.paint();
        for (const PixelFormat format : kBc4Formats)
            for (int level = 0; level <= 9; ++level) expectLeastBc4(block, format, level, std::to_string(i));
    }
}

TEST(OptimalBc4, HostileBlocksOfAnyWeightEqualEveryPairOfEnds) {
    for (const PixelFormat format : {PixelFormat::Bc4, PixelFormat::Bc4Snorm}) {
        Random random(95);
        HostileImage image = makeHostileImage(random, 1024, 9);
        for (float& weight : image.significance.texels()) weight = static_cast<float>(random.below(4)) / 3;
        ASSERT_TRUE(expectSound(format, image));
        const Encoded result = encode(format, image.texels, image.options, image.significance.view());
        for (int y = 0; y < image.texels.height(); y += 4)
            for (int x = 0; x < image.texels.width(); x += 4)
                expectLeastBc4(image.texels, image.significance, result.decoded, 0, format == PixelFormat::Bc4Snorm, x, y,
                               describeBlock(image, format, x, y));
    }
}

// ---- BC6H ---------------------------------------------------------------------------------------------------------------------------

/// A block of one colour decodes to halves, so the least error of a channel is that of the nearest half: no more than half a step. The
/// kernel of efforts 0 to 2 rounds in floats of a half's bits and so may take the other of two halves that are as near to a 256th of a
/// step.
TEST(OneColour, Bc6hIsTheNearestHalfAtEveryEffort) {
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
                            // Halves are whole multiples of a power of two, 2^-24 at the least, of at most eleven bits.
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

// ---- BC7 ----------------------------------------------------------------------------------------------------------------------------

/// BC7 decodes to whole bytes in every mode, so nothing is nearer than the nearest byte of each channel.
TEST(OneColour, Bc7IsTheNearestByteAtEveryEffort) {
    Random random(97);
    for (int i = 0; i < 300; ++i) {
        FewColours block = twoUnitColours(random, i);
        block.colour[1] = block.colour[0];
        block.paint();
        double least = 0;
        const double weight = block.weightOf(0) + block.weightOf(1);
        for (int c = 0; c < 4; ++c) least += weight * std::pow(std::nearbyint(block.colour[0][c] * 255) / 255 - block.colour[0][c], 2);
        for (int level = 0; level <= 9; ++level)
            ASSERT_LE(weightedError(block, decodedOf(PixelFormat::Bc7, block, level), 0, 4), least + roundingOf(least, 4 * weight, 2e-7))
                << i << " effort " << level;
    }
}

}  // namespace
}  // namespace lightcook::compress::test

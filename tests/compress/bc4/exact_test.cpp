// BC4, BC5 and the alpha of BC3 at effort 9 have the least possible error. Searches here are exhaustive, and written from the
// specification of the format without code of compress/.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "tests/compress/few_colours.h"
#include "tests/compress/hostile_blocks.h"

namespace lightcook::compress::test {
namespace {

using formats::PixelFormat;

/// Returns the least error of sixteen weighted values [codes^2] over every pair of endpoints in both modes.
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

/// Expects one channel of a decoded block to have the least error.
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

TEST(Bc4Exact, TwoValuesEqualExhaustiveSearch) {
    Random random(93);
    for (int i = 0; i < 200; ++i) {
        const FewColours block = twoUnitColours(random, i);
        for (const PixelFormat format : kBc4Formats) expectLeastBc4(block, format, 9, std::to_string(i));
    }
}

TEST(Bc4Exact, OneValueEqualsExhaustiveSearchAtEveryEffort) {
    Random random(94);
    for (int i = 0; i < 100; ++i) {
        FewColours block = twoUnitColours(random, i);
        block.colour[1] = block.colour[0];
        block.paint();
        for (const PixelFormat format : kBc4Formats)
            for (int level = 0; level <= 9; ++level) expectLeastBc4(block, format, level, std::to_string(i));
    }
}

TEST(Bc4Exact, HostileBlocksOfAnyWeightEqualExhaustiveSearch) {
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

}  // namespace
}  // namespace lightcook::compress::test

// BC1, and the colour of BC3: blocks of one and two colours have the least possible error. Searches here are exhaustive, and written from
// the specification of the format without code of compress/.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/compress/few_colours.h"

namespace lightcook::compress::test {
namespace {

using formats::PixelFormat;

double bestBc1Channel(double value, int largest, bool halves) {
    double best = 1;
    for (int a = 0; a <= largest; ++a)
        for (int b = 0; b <= largest; ++b)
            best = std::min(best, std::abs((halves ? (a + b) / 2.0 : (2.0 * a + b) / 3.0) / largest - value));
    return best;
}

TEST(Bc1, OneColourEqualsBruteForceOnEachChannel) {
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

/// Returns the least error over every pair of codes of every channel and every pair of indices. The index that some readers decode to
/// transparent black is not used.
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

TEST(Bc1, TwoColoursEqualExhaustiveSearchAtHighestEffort) {
    Random random(91);
    for (int i = 0; i < 400; ++i) {
        const FewColours block = twoUnitColours(random, i);
        const double four = leastBc1(block, false), any = leastBc1(block, true), weight = block.weightOf(0) + block.weightOf(1);
        ASSERT_NEAR(weightedError(block, decodedOf(PixelFormat::Bc1, block, 9), 0, 3), any, roundingOf(any, 3 * weight, 2e-7)) << i;
        ASSERT_NEAR(weightedError(block, decodedOf(PixelFormat::Bc3, block, 9), 0, 3), four, roundingOf(four, 3 * weight, 2e-7)) << i;
    }
}

TEST(Bc1, OneColourEqualsExhaustiveSearchAtEveryEffort) {
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

}  // namespace
}  // namespace lightcook::compress::test

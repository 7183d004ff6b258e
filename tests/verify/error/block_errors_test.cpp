#include "verify/block_errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace lightcook::verify {
namespace {

constexpr int kBlocksWidth = 22, kBlocksHeight = 10;  ///< not a whole number of blocks

/// Returns sums for light of 1 and an error of 1 % everywhere, with a larger error in one texel.
BlockErrors blocksWith(int x, int y, double error, double light = 1) {
    BlockErrors blocks(kBlocksWidth, kBlocksHeight);
    for (int row = 0; row < kBlocksHeight; ++row)
        for (int column = 0; column < kBlocksWidth; ++column) {
            const bool isHere = column / 4 == x / 4 && row / 4 == y / 4;
            const double reference = isHere ? light : 1, wrong = isHere ? error * light : 0.01;
            blocks.add(column, row, wrong * wrong, reference * reference);
        }
    return blocks;
}

TEST(BlockErrors, FindsTheOneBlockThatIsAllWrong) {
    for (const auto& [x, y] : {std::pair{0, 0}, std::pair{9, 5}, std::pair{21, 9}}) {
        const auto worst = blocksWith(x, y, 1).worst();
        ASSERT_TRUE(worst.has_value());
        EXPECT_EQ(worst->x, x / 4 * 4);
        EXPECT_EQ(worst->y, y / 4 * 4);
    }
    EXPECT_NEAR(blocksWith(9, 5, 1).worst()->error, 1 / std::sqrt(1.1), 1e-12);
    EXPECT_GT(blocksWith(9, 5, 1).worst()->error, BlockErrors::allowed(0.02));
    // The corner block has 2 x 2 texels: a quarter of the light of a full block.
    EXPECT_NEAR(blocksWith(21, 9, 1).worst()->error, std::sqrt(4 / (4 + 1.6)), 1e-12);
}

TEST(BlockErrors, AnEvenErrorIsNotReported) {
    EXPECT_NEAR(blocksWith(9, 5, 0.01).worst()->error, 0.01 / std::sqrt(1.1), 1e-12);
}

TEST(BlockErrors, ErrorsInTheDarkCountLessAndLightInsteadOfBlackCountsInFull) {
    EXPECT_LT(blocksWith(9, 5, 1, 0.28).worst()->error, BlockErrors::allowed(0.02));
    EXPECT_GT(blocksWith(9, 5, 1, 0.34).worst()->error, BlockErrors::allowed(0.02));
    EXPECT_GT(blocksWith(9, 5, 1000, 0.01).worst()->error, 10);
}

TEST(BlockErrors, MergedRowsGiveTheResultOfTheWhole) {
    std::mt19937 random(5);
    for (int round = 0; round < 200; ++round) {
        BlockErrors whole(kBlocksWidth, kBlocksHeight), merged(kBlocksWidth, 0);
        std::uniform_real_distribution<double> exponent(-6, 2);
        for (int row = 0; row < kBlocksHeight; row += 4) {
            const int count = std::min(4, kBlocksHeight - row);
            BlockErrors rows(kBlocksWidth, count, row);
            for (int y = row; y < row + count; ++y)
                for (int x = 0; x < kBlocksWidth; ++x) {
                    const double error = std::pow(10, exponent(random)), reference = std::pow(10, exponent(random));
                    whole.add(x, y, error, reference);
                    rows.add(x, y, error, reference);
                }
            merged.merge(rows);
        }
        EXPECT_EQ(merged.worst()->x, whole.worst()->x);
        EXPECT_EQ(merged.worst()->y, whole.worst()->y);
        EXPECT_NEAR(merged.worst()->error, whole.worst()->error, 1e-12 * whole.worst()->error);
    }
}

TEST(BlockErrors, NonFiniteIsTheLargestError) {
    for (const double error : {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
        const auto worst = blocksWith(9, 5, error).worst();
        EXPECT_EQ(worst->error, std::numeric_limits<double>::max());
        EXPECT_EQ(worst->x, 8);
    }
}

TEST(BlockErrors, BlackImagesHaveNoWorstBlock) {
    BlockErrors black(8, 8);
    EXPECT_FALSE(black.worst().has_value());
    black.add(3, 3, 1, 0);
    EXPECT_FALSE(black.worst().has_value());
}

/// A wrong block in a face that is a billionth as bright as the others is invisible.
TEST(BlockErrors, ADarkImageAmongBrightOnesCountsForLittle) {
    BlockErrors dark(8, 8);
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x) dark.add(x, y, x < 4 && y < 4 ? 9e-18 : 0, 1e-18);
    EXPECT_DOUBLE_EQ(dark.meanSquare(), 1e-18);
    EXPECT_GT(dark.worst()->error, 2.5);
    EXPECT_LT(dark.worst(1e-4)->error, 1e-5);
    EXPECT_EQ(dark.worst(1e-19)->error, dark.worst()->error) << "it is bright enough by itself";
}

}  // namespace
}  // namespace lightcook::verify

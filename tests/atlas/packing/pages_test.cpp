// Squares on pages, checked pair by pair.
#include "atlas/pages.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <random>
#include <vector>

namespace lightcook::atlas {
namespace {

/// Expects every square on its page, `padding` texels from each other one there, and pages within the largest one that no square leaves
/// larger than it must be. Returns the share of the pages that squares take.
double expectPlaced(const std::vector<int>& sides, int padding, int largest) {
    const Pages pages = packSquares(sides, padding, largest);
    EXPECT_EQ(pages.places.size(), sides.size());
    std::vector<glm::ivec2> ends(pages.sizes.size(), glm::ivec2(0));
    double taken = 0, all = 0;
    for (std::size_t i = 0; i < sides.size(); ++i) {
        const PlaceOnPage& a = pages.places[i];
        EXPECT_LT(a.page, pages.sizes.size());
        EXPECT_TRUE(a.first.x >= 0 && a.first.y >= 0 && a.first % kPageStep == glm::ivec2(0)) << i;
        ends[a.page] = glm::max(ends[a.page], a.first + sides[i]);
        taken += std::pow(sides[i], 2);
        for (std::size_t j = 0; j < i; ++j) {
            const PlaceOnPage& b = pages.places[j];
            if (a.page != b.page) continue;
            const glm::ivec2 gap = glm::max(b.first - (a.first + sides[i]), a.first - (b.first + sides[j]));
            EXPECT_GE(std::max(gap.x, gap.y), padding) << i << " and " << j;
        }
    }
    for (std::size_t page = 0; page < pages.sizes.size(); ++page) {
        EXPECT_EQ(pages.sizes[page], ends[page]);
        EXPECT_LE(std::max(pages.sizes[page].x, pages.sizes[page].y), largest);
        all += static_cast<double>(pages.sizes[page].x) * pages.sizes[page].y;
    }
    return taken / all;
}

TEST(PackSquares, OneSquareIsAPageWithoutPadding) {
    const std::vector<int> one = {200};
    const Pages pages = packSquares(one, 8, 200);
    ASSERT_EQ(pages.sizes.size(), 1u);
    EXPECT_EQ(pages.sizes[0], glm::ivec2(200));
}

TEST(PackSquares, RandomSquaresKeepTheirPaddingAndFillPages) {
    std::mt19937 random(7);
    for (const int largest : {128, 512, 4096}) {
        std::vector<int> sides;
        for (int i = 0; i < 300; ++i) sides.push_back(kPageStep * (1 + static_cast<int>(random() % (i % 10 == 0 ? 30u : 12u))));
        EXPECT_GT(expectPlaced(sides, 0, largest), 0.85) << largest;
        EXPECT_GT(expectPlaced(sides, 4, largest), 0.6) << largest;
        EXPECT_GT(expectPlaced(sides, 3, largest), 0.6) << largest;
    }
}

TEST(PackSquares, WhatFillsAPageAlonePutsTheRestOnOthers) {
    const std::vector<int> sides = {512, 16, 512, 16};
    const Pages pages = packSquares(sides, 2, 512);
    ASSERT_EQ(pages.sizes.size(), 3u);
    EXPECT_EQ(pages.places[1].page, 2u);
    EXPECT_EQ(pages.places[3].page, 2u);
    expectPlaced(sides, 2, 512);
    EXPECT_TRUE(packSquares({}, 2, 512).sizes.empty());
}

}  // namespace
}  // namespace lightcook::atlas

// Packed charts, checked texel by texel.
#include "atlas/packing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace lightcook::atlas {
namespace {

using Mask = formats::Image<std::uint8_t>;

Packing packed(const std::vector<Mask>& masks) {
    std::vector<formats::ImageView<const std::uint8_t>> views;
    for (const Mask& mask : masks) views.push_back(mask.view());
    const auto packing = packCharts(views, std::atomic<bool>(false));
    EXPECT_TRUE(packing);
    return packing.value_or(Packing{});
}

/// Every read texel of every chart lies on the page and is that of no other. Returns the share of the page that is read.
double expectDisjoint(const std::vector<Mask>& masks, const Packing& packing) {
    EXPECT_EQ(packing.places.size(), masks.size());
    EXPECT_EQ(packing.size % 4, glm::ivec2(0));
    Mask page(packing.size.x, packing.size.y, 0);
    for (std::size_t chart = 0; chart < masks.size(); ++chart)
        for (int y = 0; y < masks[chart].height(); ++y)
            for (int x = 0; x < masks[chart].width(); ++x) {
                if (masks[chart].at(x, y) == 0) continue;
                const glm::ivec2 at = packing.places[chart] + glm::ivec2(x, y);
                EXPECT_TRUE(at.x >= 0 && at.y >= 0 && at.x < packing.size.x && at.y < packing.size.y) << chart;
                if (at.x < 0 || at.y < 0 || at.x >= packing.size.x || at.y >= packing.size.y) continue;
                EXPECT_EQ(page.at(at.x, at.y), 0) << "chart " << chart << " at " << at.x << " " << at.y;
                page.at(at.x, at.y) = 1;
            }
    return static_cast<double>(std::count(page.texels().begin(), page.texels().end(), 1)) / static_cast<double>(page.texels().size());
}

TEST(PackCharts, RandomShapesAreDisjointAndFillThePage) {
    std::mt19937 random(3);
    const auto below = [&](int end) { return static_cast<int>(random() % static_cast<unsigned>(end)); };
    std::vector<Mask> masks;
    for (int i = 0; i < 400; ++i) {
        const int width = 2 + below(i % 20 == 0 ? 150 : 30), height = 2 + below(i % 20 == 0 ? 150 : 30);
        Mask mask(width, height, 1);
        // Corners and some texels of the middle are cut out.
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                if (x + y < below(width) / 2 || (below(6) == 0 && i % 3 == 0)) mask.at(x, y) = 0;
        masks.push_back(std::move(mask));
    }
    const Packing packing = packed(masks);
    const double share = expectDisjoint(masks, packing);
    EXPECT_NEAR(share, packing.occupancy, 1e-9);
    EXPECT_GT(share, 0.7);
    for (std::size_t chart = 0; chart < masks.size(); ++chart) {
        if (std::min(masks[chart].width(), masks[chart].height()) < kAlignedSide) continue;
        EXPECT_EQ(packing.places[chart] % 4, glm::ivec2(0)) << chart;
    }
    EXPECT_EQ(packed(masks).places, packing.places) << "the same charts get the same places";
}

TEST(PackCharts, RectanglesOfWholeBlocksFillNineTenths) {
    std::mt19937 random(11);
    std::vector<Mask> masks;
    const auto side = [&] { return 4 * (1 + static_cast<int>(random() % 10)); };
    for (int i = 0; i < 300; ++i) {
        const int width = side(), height = side();
        masks.emplace_back(width, height, std::uint8_t{1});
    }
    EXPECT_GT(expectDisjoint(masks, packed(masks)), 0.9);
}

TEST(PackCharts, AHoleHoldsOtherCharts) {
    std::vector<Mask> masks;
    masks.emplace_back(64, 64, std::uint8_t{1});
    for (int y = 4; y < 60; ++y)
        for (int x = 4; x < 60; ++x) masks[0].at(x, y) = 0;
    for (int i = 0; i < 4; ++i) masks.emplace_back(28, 28, std::uint8_t{1});
    const Packing packing = packed(masks);
    expectDisjoint(masks, packing);
    EXPECT_EQ(packing.size, glm::ivec2(64));
    EXPECT_EQ(packing.occupancy, 1);
}

TEST(PackCharts, APuzzleIsSolved) {
    // A page of 96 x 96 texels, cut into rectangles of whole blocks: sorted by height alone they fill 80 x 144.
    std::vector<Mask> masks;
    for (const glm::ivec2& size :
         {glm::ivec2(40, 56), glm::ivec2(56, 24), glm::ivec2(24, 48), glm::ivec2(32, 48), glm::ivec2(40, 40), glm::ivec2(56, 24)})
        masks.emplace_back(size.x, size.y, std::uint8_t{1});
    const Packing packing = packed(masks);
    expectDisjoint(masks, packing);
    EXPECT_EQ(packing.size, glm::ivec2(96));
    EXPECT_EQ(packing.occupancy, 1);
}

TEST(PackCharts, OneTexelAndNothingArePages) {
    EXPECT_EQ(packed({}).size, glm::ivec2(4));
    std::vector<Mask> one;
    one.emplace_back(1, 1, std::uint8_t{1});
    EXPECT_EQ(packed(one).size, glm::ivec2(4));
    std::vector<Mask> wide;
    wide.emplace_back(1000, 1, std::uint8_t{1});
    EXPECT_EQ(packed(wide).size, glm::ivec2(1000, 4));
}

TEST(PackCharts, AnInterruptReturnsNothing) {
    std::vector<Mask> masks;
    masks.emplace_back(8, 8, std::uint8_t{1});
    const std::vector<formats::ImageView<const std::uint8_t>> views = {masks[0].view()};
    EXPECT_FALSE(packCharts(views, std::atomic<bool>(true)));
}

}  // namespace
}  // namespace lightcook::atlas

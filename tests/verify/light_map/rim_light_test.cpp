// Light at the rims of charts, where a filter weighs a texel outside the chart most.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/compress/synthetic_light_map.h"
#include "tests/verify/cooked_light_map.h"

namespace lightcook {
namespace {

constexpr int kRimSide = 12, kRimFirst = 4, kRimEnd = 8;

/// A square chart of grey light in the middle of a map.
test::Cooked squareChart(formats::LightMapLayout layout = formats::LightMapLayout::Raw) {
    formats::LightMapStrip strip;
    strip.sh = formats::Image<lighting::ShRgb>(kRimSide, kRimSide, lighting::ShRgb{});
    strip.covered = formats::Image<std::uint8_t>(kRimSide, kRimSide, 0);
    strip.normal = formats::Image<glm::vec3>(kRimSide, kRimSide, glm::vec3(0, 0, 1));
    strip.tangent = formats::Image<glm::vec4>(kRimSide, kRimSide, glm::vec4(1, 0, 0, 1));
    for (int y = kRimFirst; y < kRimEnd; ++y)
        for (int x = kRimFirst; x < kRimEnd; ++x) {
            strip.covered.at(x, y) = 1;
            strip.sh.at(x, y) = synthetic::constantLight(glm::vec3(1));
        }
    return test::cook(std::move(strip), layout, formats::Target::Float, 3);
}

std::vector<verify::RimPlace> rimsOf(const test::Cooked& cooked, int firstRow = 0, int rowCount = kRimSide) {
    return cooked.verifier().rimPlaces({cooked.texels, cooked.reference}, firstRow, rowCount);
}

TEST(RimPlaces, EachTexelBesideAChartHasOne) {
    const auto places = rimsOf(squareChart());
    formats::Image<int> count(kRimSide, kRimSide, 0);
    for (const verify::RimPlace& place : places) {
        ++count.at(place.outside.x, place.outside.y);
        EXPECT_NEAR(place.found[0].x, place.reference[0].x, 2e-3f * place.reference[0].x) << "the padding continues the chart";
    }
    for (int y = 0; y < kRimSide; ++y)
        for (int x = 0; x < kRimSide; ++x) {
            const bool isInside = x >= kRimFirst && x < kRimEnd && y >= kRimFirst && y < kRimEnd;
            const bool isBeside = !isInside && x >= kRimFirst - 1 && x <= kRimEnd && y >= kRimFirst - 1 && y <= kRimEnd;
            EXPECT_EQ(count.at(x, y) > 0, isBeside) << x << ", " << y;
        }
}

TEST(RimPlaces, ATexelOutsideWeighsHalfBesideAnEdgeAndAQuarterAtACorner) {
    for (const auto& [outside, weight] : {std::pair(glm::ivec2(kRimFirst - 1, 5), 0.5f), std::pair(glm::ivec2(6, kRimEnd), 0.5f),
                                          std::pair(glm::ivec2(kRimEnd, kRimFirst - 1), 0.25f)}) {
        test::Cooked cooked = squareChart();
        for (auto& layer : cooked.texels.textures[0]) layer.at(outside.x, outside.y) = glm::vec4(0);
        float darkest = 1e30f;
        for (const verify::RimPlace& place : rimsOf(cooked)) {
            if (place.outside != outside) continue;
            darkest = std::min(darkest, place.found[0].x / place.reference[0].x);
        }
        EXPECT_NEAR(darkest, 1 - weight, 2e-3f);
    }
}

/// Even light is symmetric about the normal, so that it has the same coefficients in every tangent frame.
TEST(RimPlaces, ALayoutInTangentSpaceIsDecodedInTheFrameOfItsSurface) {
    const test::Cooked cooked = squareChart(formats::LightMapLayout::Rnm);
    const auto places = rimsOf(cooked);
    ASSERT_EQ(places.size(), rimsOf(squareChart()).size());
    for (const verify::RimPlace& place : places) {
        EXPECT_NEAR(place.found[0].x, places.front().found[0].x, 2e-3f * place.reference[0].x);
        EXPECT_NEAR(place.found[0].x, place.reference[0].x, 0.3f * place.reference[0].x);
    }
}

TEST(RimPlaces, StripsHaveThoseOfTheMap) {
    const test::Cooked cooked = squareChart();
    std::size_t count = 0;
    for (int row = 0; row < kRimSide; row += 4) count += rimsOf(cooked, row, 4).size();
    EXPECT_EQ(count, rimsOf(cooked).size());
}

/// Nothing is seen between the texels of two charts.
TEST(RimPlaces, NoneLieBetweenTwoCharts) {
    test::Cooked cooked = squareChart();
    cooked.reference.chart = formats::Image<std::uint32_t>(kRimSide, kRimSide, formats::kNoChart);
    EXPECT_TRUE(rimsOf(cooked).empty());
}

}  // namespace
}  // namespace lightcook

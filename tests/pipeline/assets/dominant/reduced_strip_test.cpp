#include "pipeline/assets/dominant/reduced_strip.h"

#include <gtest/gtest.h>

namespace lightcook::pipeline {
namespace {

/// Rows without light or coverage.
formats::LightMapStrip emptyStrip(int firstRow, int width, int rowCount) {
    formats::LightMapStrip strip;
    strip.firstRow = firstRow;
    strip.sh = formats::Image<lighting::ShRgb>(width, rowCount);
    strip.covered = formats::Image<std::uint8_t>(width, rowCount);
    strip.normal = formats::Image<glm::vec3>(width, rowCount);
    return strip;
}

TEST(ReducedStrip, ATexelIsTheMeanOfTheCoveredTexelsUnderIt) {
    formats::LightMapStrip strip = emptyStrip(4, 6, 4);
    const auto cover = [&](int x, int y, float light, const glm::vec3& normal) {
        strip.sh.at(x, y)[0] = glm::vec3(light);
        strip.covered.at(x, y) = 1;
        strip.normal.at(x, y) = normal;
    };
    cover(0, 0, 1, {0, 0, 1});
    cover(1, 1, 4, {1, 0, 0});
    cover(2, 0, 2, {0, 1, 0});
    cover(3, 0, 6, {0, -1, 0});
    cover(4, 2, 7, {0, 1, 0});
    const formats::LightMapStrip half = reducedStrip(strip, 8, {3, 4}, 2, 2);
    EXPECT_EQ(half.firstRow, 2);
    ASSERT_EQ(half.sh.width(), 3);
    ASSERT_EQ(half.sh.height(), 2);
    EXPECT_FLOAT_EQ(half.sh.at(0, 0)[0].x, 2.5f) << "two of four";
    EXPECT_FLOAT_EQ(half.normal.at(0, 0).x, half.normal.at(0, 0).z);
    EXPECT_FLOAT_EQ(half.sh.at(1, 0)[0].x, 4);
    EXPECT_FLOAT_EQ(half.normal.at(1, 0).y, 1) << "opposite normals: the first";
    EXPECT_EQ(half.covered.at(2, 0), 0);
    EXPECT_FLOAT_EQ(half.sh.at(2, 1)[0].x, 7) << "one of four";
    EXPECT_EQ(half.covered.at(0, 1), 0);
}

TEST(ReducedStrip, ATexelIsOfTheChartOfTheTexelsUnderIt) {
    formats::LightMapStrip strip = emptyStrip(0, 8, 2);
    EXPECT_EQ(reducedStrip(strip, 2, {4, 1}, 0, 1).chart.width(), 0) << "the bake tells no charts apart";
    strip.chart = formats::Image<std::uint32_t>(8, 2, formats::kNoChart);
    const auto cover = [&](int x, int y, std::uint32_t chart) {
        strip.covered.at(x, y) = 1;
        strip.chart.at(x, y) = chart;
    };
    cover(0, 0, 3), cover(1, 0, 3), cover(0, 1, 3);
    cover(2, 1, 3), cover(3, 0, 5), cover(3, 1, 5);
    cover(5, 1, 5);
    const formats::LightMapStrip half = reducedStrip(strip, 2, {4, 1}, 0, 1);
    ASSERT_EQ(half.chart.width(), 4);
    EXPECT_EQ(half.chart.at(0, 0), 3u);
    EXPECT_EQ(half.chart.at(1, 0), formats::kAnyChart) << "of both: surfaces of either lie beside it";
    EXPECT_EQ(half.chart.at(2, 0), 5u);
    EXPECT_EQ(half.chart.at(3, 0), formats::kAnyChart) << "not covered";
}

TEST(ReducedStrip, ATexelOfTheMapCountsByThePartUnderEachTexelOfTheTexture) {
    formats::LightMapStrip strip = emptyStrip(0, 3, 1);
    for (int x = 0; x < 3; ++x) {
        strip.covered.at(x, 0) = 1;
        strip.normal.at(x, 0) = {0, 0, 1};
        strip.sh.at(x, 0)[0] = glm::vec3(static_cast<float>(x));
    }
    const formats::LightMapStrip half = reducedStrip(strip, 1, {2, 1}, 0, 1);
    EXPECT_FLOAT_EQ(half.sh.at(0, 0)[0].x, 1.0f / 3) << "texel 0 and half of texel 1";
    EXPECT_FLOAT_EQ(half.sh.at(1, 0)[0].x, 5.0f / 3) << "half of texel 1, and texel 2";
}

/// The coefficient is the UV itself: texel i of n has to hold (i + 0.5) / n, to the quarter of a texel that a cut texel of the map can err.
TEST(ReducedStrip, LightStaysAtItsUvsWhereNoDivisorDividesTheMap) {
    for (const int divisor : {2, 4})
        for (const int size : {5, 9, 13, 33, 61, 62, 63}) {
            formats::LightMapStrip strip = emptyStrip(0, size, size);
            for (int y = 0; y < size; ++y)
                for (int x = 0; x < size; ++x) {
                    strip.covered.at(x, y) = 1;
                    strip.normal.at(x, y) = {0, 0, 1};
                    strip.sh.at(x, y)[0] = glm::vec3((static_cast<float>(x) + 0.5f) / static_cast<float>(size),
                                                     (static_cast<float>(y) + 0.5f) / static_cast<float>(size), 0);
                }
            const glm::ivec2 texture = reducedSize({size, size}, divisor);
            const formats::LightMapStrip whole = reducedStrip(strip, size, texture, 0, texture.y);
            for (int i = 0; i < texture.x; ++i) {
                const float uv = (static_cast<float>(i) + 0.5f) / static_cast<float>(texture.x);
                EXPECT_NEAR(whole.sh.at(i, 0)[0].x, uv, 0.25f / static_cast<float>(size)) << size << " / " << divisor << ", column " << i;
                EXPECT_NEAR(whole.sh.at(0, i)[0].y, uv, 0.25f / static_cast<float>(size)) << size << " / " << divisor << ", row " << i;
            }
        }
}

TEST(ReducedStrip, ReadsTheRowsUnderATextureAndNoOthers) {
    EXPECT_EQ(rowsUnder(2, 3, 64, 32).first, 4);
    EXPECT_EQ(rowsUnder(2, 3, 64, 32).count, 6);
    EXPECT_EQ(rowsUnder(0, 17, 33, 17).count, 33);
    // Rows 8 to 11 of 17 lie at [15.53, 23.29) of 33 rows.
    EXPECT_EQ(rowsUnder(8, 4, 33, 17).first, 15);
    EXPECT_EQ(rowsUnder(8, 4, 33, 17).count, 9);
}

}  // namespace
}  // namespace lightcook::pipeline

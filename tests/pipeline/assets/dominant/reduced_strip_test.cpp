#include "pipeline/assets/dominant/reduced_strip.h"

#include <gtest/gtest.h>

namespace lightcook::pipeline {
namespace {

TEST(ReducedStrip, ATexelIsTheMeanOfTheCoveredTexelsThatItStandsFor) {
    formats::LightMapStrip strip;
    strip.firstRow = 4;
    strip.sh = formats::Image<lighting::ShRgb>(5, 3);
    strip.covered = formats::Image<std::uint8_t>(5, 3);
    strip.normal = formats::Image<glm::vec3>(5, 3);
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
    const formats::LightMapStrip half = reducedStrip(strip, 2);
    EXPECT_EQ(half.firstRow, 2);
    ASSERT_EQ(half.sh.width(), 3);
    ASSERT_EQ(half.sh.height(), 2);
    EXPECT_FLOAT_EQ(half.sh.at(0, 0)[0].x, 2.5f) << "two of four";
    EXPECT_FLOAT_EQ(half.normal.at(0, 0).x, half.normal.at(0, 0).z);
    EXPECT_FLOAT_EQ(half.sh.at(1, 0)[0].x, 4);
    EXPECT_FLOAT_EQ(half.normal.at(1, 0).y, 1) << "opposite normals: the first";
    EXPECT_EQ(half.covered.at(2, 0), 0);
    EXPECT_FLOAT_EQ(half.sh.at(2, 1)[0].x, 7) << "the rim has fewer texels";
    EXPECT_EQ(half.covered.at(0, 1), 0);
}

}  // namespace
}  // namespace lightcook::pipeline

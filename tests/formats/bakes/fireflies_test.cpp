#include "formats/fireflies.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

namespace lightcook::formats {
namespace {

LightMapStrip darkRoom(int width, int height, float light) {
    LightMapStrip strip;
    strip.firstRow = 64;
    strip.sh = Image<lighting::ShRgb>(width, height, lighting::ShRgb{});
    for (lighting::ShRgb& sh : strip.sh.texels()) sh[0] = glm::vec3(light);
    strip.covered = Image<std::uint8_t>(width, height, 1);
    strip.normal = Image<glm::vec3>(width, height, glm::vec3(0, 0, 1));
    return strip;
}

TEST(Fireflies, AreSingleTexelsAmongCoveredOnes) {
    LightMapStrip strip = darkRoom(16, 8, 1);
    strip.sh.at(5, 3)[0] = {1, 2000, 1};
    strip.sh.at(9, 0)[0] = {1001, 0, 0};
    const std::vector<Firefly> found = findFireflies(strip, 1000);
    ASSERT_EQ(found.size(), 2u);
    EXPECT_EQ(found[0].x, 9);
    EXPECT_EQ(found[0].y, 64);
    EXPECT_EQ(found[1].y, 67);
    EXPECT_EQ(found[1].found, 2000);
    EXPECT_EQ(found[1].beside, 1);
    EXPECT_EQ(found[0].colour, 0);
    EXPECT_EQ(found[1].colour, 1);
    EXPECT_EQ(findFireflies(strip, 1500).size(), 1u);
}

TEST(Fireflies, LightSourcesOfTwoTexelsSmallChartsAndEdgesOfTheMapAreKept) {
    LightMapStrip strip = darkRoom(16, 8, 1);
    strip.sh.at(5, 3)[0] = strip.sh.at(6, 4)[0] = glm::vec3(60000);  // two that touch
    strip.sh.at(0, 4)[0] = strip.sh.at(15, 2)[0] = glm::vec3(60000);
    EXPECT_TRUE(findFireflies(strip, 1000).empty());
    strip = darkRoom(16, 8, 1);
    strip.sh.at(10, 4)[0] = glm::vec3(60000);
    strip.covered.at(11, 5) = 0;  // at a chart's edge
    EXPECT_TRUE(findFireflies(strip, 1000).empty());
}

TEST(Fireflies, AtRimsTheyAreBeyondTheRangeOfLight) {
    LightMapStrip strip = darkRoom(16, 8, 1);
    strip.covered.at(11, 5) = 0;
    for (const glm::ivec2 rim : {glm::ivec2(10, 4), glm::ivec2(0, 4), glm::ivec2(15, 0)}) {
        strip.sh.at(rim.x, rim.y)[0].g = 1e9f;
        EXPECT_TRUE(findFireflies(strip, 1000).empty());
        strip.sh.at(rim.x, rim.y)[0].g = 1.1e9f;
        const std::vector<Firefly> found = findFireflies(strip, 1000);
        ASSERT_EQ(found.size(), 1u);
        EXPECT_EQ(found[0].ratio, 1e9);
        ASSERT_TRUE(checkFireflies(strip, 1000, true, [](const Firefly&) { return std::string("map.exr"); }));
        EXPECT_EQ(strip.sh.at(rim.x, rim.y)[0], glm::vec3(1)) << "the mean of the covered neighbours";
    }
    // A chart of one texel has none, and in the dark nothing says what light is.
    strip = darkRoom(16, 8, 1);
    for (int v = 3; v <= 5; ++v)
        for (int u = 9; u <= 11; ++u) strip.covered.at(u, v) = u == 10 && v == 4 ? 1 : 0;
    strip.sh.at(10, 4)[0] = glm::vec3(1e30f);
    EXPECT_TRUE(findFireflies(strip, 1000).empty());
    strip = darkRoom(16, 8, 0);
    strip.sh.at(0, 4)[0] = glm::vec3(1e30f);
    EXPECT_TRUE(findFireflies(strip, 1000).empty());
}

TEST(Fireflies, FaintOnesInTheDarkAreLeft) {
    LightMapStrip strip = darkRoom(16, 8, 0);
    strip.sh.at(2, 1)[0] = glm::vec3(1e-9f);
    EXPECT_EQ(findFireflies(strip, 1000).size(), 1u) << "all that shines in these rows";
    for (int x = 0; x < 16; ++x) strip.sh.at(x, 6)[0] = glm::vec3(1);
    EXPECT_TRUE(findFireflies(strip, 1000).empty()) << "less than an eighth of these rows has";
}

TEST(Fireflies, RepairedOnesHaveTheirNeighboursMeanAndAreCounted) {
    const auto lit = [] {
        std::mt19937 random(7);
        std::uniform_real_distribution<float> light(0.5f, 1.5f);
        LightMapStrip strip = darkRoom(12, 12, 0);
        for (lighting::ShRgb& sh : strip.sh.texels())
            for (glm::vec3& coefficient : sh) coefficient = {light(random), light(random), light(random)};
        return strip;
    };
    LightMapStrip strip = lit();
    const LightMapStrip before = lit();
    strip.sh.at(4, 4)[0].b = 1e30f;
    strip.sh.at(8, 11)[0].r = 1e5f;
    ASSERT_TRUE(checkFireflies(strip, 1000, true, [](const Firefly&) { return std::string("map.exr"); }));
    EXPECT_EQ(strip.repairs.fireflies, 2);
    for (int y = 0; y < 12; ++y)
        for (int x = 0; x < 12; ++x) {
            const bool isRepaired = (x == 4 && y == 4) || (x == 8 && y == 11);
            EXPECT_EQ(strip.sh.at(x, y) == before.sh.at(x, y), !isRepaired) << x << ' ' << y;
        }
    for (std::size_t i = 0; i < 9; ++i)
        for (int channel = 0; channel < 3; ++channel) {
            double eight = 0, five = 0;
            for (int v = 3; v <= 5; ++v)
                for (int u = 3; u <= 5; ++u)
                    if (u != 4 || v != 4) eight += before.sh.at(u, v)[i][channel];
            for (int v = 10; v <= 11; ++v)
                for (int u = 7; u <= 9; ++u)
                    if (u != 8 || v != 11) five += before.sh.at(u, v)[i][channel];
            EXPECT_NEAR(strip.sh.at(4, 4)[i][channel], eight / 8, 1e-6);
            EXPECT_NEAR(strip.sh.at(8, 11)[i][channel], five / 5, 1e-6);
        }
    EXPECT_TRUE(findFireflies(strip, 1000).empty());
}

}  // namespace
}  // namespace lightcook::formats

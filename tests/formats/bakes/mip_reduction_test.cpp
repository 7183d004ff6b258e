// Mip levels of a light map, against a mean over the whole map in another order.
#include "formats/mip_reduction.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <random>

namespace lightcook::formats {
namespace {

constexpr int kMipWidth = 24, kMipHeight = 40;

/// Random light, normals and coverage; texels that are not covered hold light that no mean may have.
LightMapStrip randomMap() {
    std::mt19937 random(11);
    std::uniform_real_distribution<float> light(-1, 3);
    LightMapStrip map;
    map.sh = Image<lighting::ShRgb>(kMipWidth, kMipHeight);
    map.covered = Image<std::uint8_t>(kMipWidth, kMipHeight, 0);
    map.normal = Image<glm::vec3>(kMipWidth, kMipHeight, glm::vec3(0, 0, 1));
    for (int y = 0; y < kMipHeight; ++y)
        for (int x = 0; x < kMipWidth; ++x) {
            const bool isCovered = x + y > 20 && random() % 3 != 0;
            map.covered.at(x, y) = isCovered ? 1 : 0;
            for (glm::vec3& coefficient : map.sh.at(x, y))
                coefficient = isCovered ? glm::vec3(light(random), light(random), light(random)) : glm::vec3(1e20f);
            map.normal.at(x, y) = glm::normalize(glm::vec3(light(random), light(random), 4));
        }
    return map;
}

LightMapStrip rowsOf(const LightMapStrip& map, int first, int count) {
    LightMapStrip strip;
    strip.firstRow = first;
    strip.sh = Image<lighting::ShRgb>(kMipWidth, count);
    strip.covered = Image<std::uint8_t>(kMipWidth, count);
    strip.normal = Image<glm::vec3>(kMipWidth, count);
    for (int y = 0; y < count; ++y)
        for (int x = 0; x < kMipWidth; ++x) {
            strip.sh.at(x, y) = map.sh.at(x, first + y);
            strip.covered.at(x, y) = map.covered.at(x, first + y);
            strip.normal.at(x, y) = map.normal.at(x, first + y);
        }
    return strip;
}

TEST(MipReduction, IsTheMeanOfCoveredTexels) {
    const LightMapStrip map = randomMap();
    for (int level = 1; level <= 3; ++level) {
        const int side = 1 << level, width = kMipWidth / side, height = kMipHeight / side;
        MipReduction reduction(width, 0, height, level);
        reduction.add(map);
        const LightMapStrip mip = reduction.finish();
        ASSERT_EQ(mip.sh.width(), width);
        ASSERT_EQ(mip.sh.height(), height);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                double count = 0;
                std::array<glm::dvec3, 9> sum{};
                glm::dvec3 normal(0);
                for (int dx = side - 1; dx >= 0; --dx)
                    for (int dy = side - 1; dy >= 0; --dy) {
                        const int fromX = x * side + dx, fromY = y * side + dy;
                        if (map.covered.at(fromX, fromY) == 0) continue;
                        ++count;
                        for (std::size_t i = 0; i < 9; ++i) sum[i] += glm::dvec3(map.sh.at(fromX, fromY)[i]);
                        normal += glm::dvec3(map.normal.at(fromX, fromY));
                    }
                ASSERT_EQ(mip.covered.at(x, y) != 0, count > 0) << x << ", " << y;
                for (std::size_t i = 0; i < 9; ++i) {
                    const glm::dvec3 expected = count > 0 ? sum[i] / count : glm::dvec3(0);
                    EXPECT_LT(glm::length(glm::dvec3(mip.sh.at(x, y)[i]) - expected), 1e-6) << x << ", " << y << ", " << i;
                }
                if (count > 0) {
                    EXPECT_LT(glm::length(glm::dvec3(mip.normal.at(x, y)) - glm::normalize(normal)), 1e-6);
                }
            }
    }
}

TEST(MipReduction, StripsGiveTheBitsOfTheWholeMap) {
    const LightMapStrip map = randomMap();
    constexpr int kLevel = 2, kRows = kMipHeight >> kLevel, kFirst = 3, kCount = 5;
    MipReduction whole(kMipWidth >> kLevel, 0, kRows, kLevel), part(kMipWidth >> kLevel, kFirst, kCount, kLevel);
    whole.add(map);
    for (int row = 0; row < kMipHeight; row += 7) part.add(rowsOf(map, row, std::min(7, kMipHeight - row)));
    const LightMapStrip expected = whole.finish(), found = part.finish();
    EXPECT_EQ(found.firstRow, kFirst);
    for (int y = 0; y < kCount; ++y)
        for (int x = 0; x < kMipWidth >> kLevel; ++x) {
            EXPECT_EQ(found.sh.at(x, y), expected.sh.at(x, kFirst + y));
            EXPECT_EQ(found.normal.at(x, y), expected.normal.at(x, kFirst + y));
            EXPECT_EQ(found.covered.at(x, y), expected.covered.at(x, kFirst + y));
        }
}

TEST(MipReduction, OppositeNormalsGiveTheFirst) {
    LightMapStrip map = randomMap();
    for (int y = 0; y < kMipHeight; ++y)
        for (int x = 0; x < kMipWidth; ++x) {
            map.covered.at(x, y) = 1;
            map.normal.at(x, y) = glm::vec3(x % 2 == 0 ? 1 : -1, 0, 0);
        }
    MipReduction reduction(kMipWidth / 2, 0, kMipHeight / 2, 1);
    reduction.add(map);
    EXPECT_EQ(reduction.finish().normal.at(3, 3), glm::vec3(1, 0, 0));
}

}  // namespace
}  // namespace lightcook::formats

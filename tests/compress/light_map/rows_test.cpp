#include "compress/light_map/rows.h"

#include <gtest/gtest.h>

namespace lightcook::compress {
namespace {

constexpr float kFirstRing = 0x1p-8f, kSolvedRing = 0x1p-9f, kSecondRing = 0x1p-16f;

rows::Source sourceOf(int width, int height) {
    rows::Source source;
    source.width = width;
    source.height = height;
    source.values.emplace_back(width, height, glm::vec3(0));
    source.coverage = formats::Image<float>(width, height, 0);
    source.importance = formats::Image<float>(width, height, 0);
    return source;
}

void set(rows::Source& source, int x, int y, float light, float coverage) {
    source.values[0].at(x, y) = glm::vec3(light);
    source.coverage.at(x, y) = source.importance.at(x, y) = coverage;
}

/// Padding of the second ring loses its weight beside light that is more than 8 times away, and only in the same block.
TEST(DropFarPadding, TakesTheWeightOfTheSecondRingAlone) {
    rows::Source source = sourceOf(8, 4);
    set(source, 0, 0, 1000, 1);
    set(source, 1, 0, 900, kFirstRing);
    set(source, 2, 0, 0.01f, kFirstRing);   // beside a dark chart: a filter reads it
    set(source, 3, 0, 0.01f, kSolvedRing);  // solved for the filter, in a layout that divides by coefficient 0
    set(source, 0, 3, 0.01f, kSecondRing);
    set(source, 1, 3, 130, kSecondRing);
    set(source, 2, 3, 120, kSecondRing);
    set(source, 3, 3, 9000, kSecondRing);
    set(source, 4, 3, 0.01f, kSecondRing);  // a block that holds nothing nearer
    rows::dropFarPadding(source, 4);
    EXPECT_EQ(source.coverage.at(0, 0), 1);
    EXPECT_EQ(source.coverage.at(1, 0), kFirstRing);
    EXPECT_EQ(source.coverage.at(2, 0), kFirstRing);
    EXPECT_EQ(source.coverage.at(3, 0), kSolvedRing);
    EXPECT_EQ(source.coverage.at(0, 3), 0);
    EXPECT_EQ(source.importance.at(0, 3), 0);
    EXPECT_EQ(source.coverage.at(1, 3), kSecondRing);
    EXPECT_EQ(source.coverage.at(2, 3), 0);
    EXPECT_EQ(source.coverage.at(3, 3), 0);
    EXPECT_EQ(source.coverage.at(4, 3), kSecondRing);
}

}  // namespace
}  // namespace lightcook::compress

#include "formats/bakes/lit_coverage.h"

#include <gmock/gmock.h>

#include <limits>
#include <string>

#include "tests/formats/light_map_fixture.h"

namespace lightcook::formats {
namespace {

/// A picture of light 1 in the columns from 6 on, but for shadows of two columns and of five, and in texel (2, 2).
ExrRecipe picture() {
    ExrRecipe recipe;
    recipe.width = 20;
    recipe.height = 70;
    for (int c = 0; c < 3; ++c)
        recipe.channels[std::string(1, "RGB"[c])] = [](int x, int y) {
            const bool isShadow = x == 8 || x == 9 || (x >= 12 && x < 17);
            return (x >= 6 && !isShadow) || (x == 2 && y == 2) ? 1.0f : 0.0f;
        };
    return recipe;
}

LightMapDescription byLight() {
    LightMapDescription description;
    description.bake = "flat";
    description.coverage = CoverageSource::Light;
    return description;
}

TEST(LitCoverage, BlackIsAGapUnlessItLiesBetweenLight) {
    const MapFile map(picture());
    const LightMapStrip strip = readAll(map.path, byLight());
    for (int y = 0; y < 70; ++y)
        for (int x = 0; x < 20; ++x) {
            const bool isWide = x >= 12 && x < 17, isTexel = x == 2 && y == 2;
            // Between the texel and the columns: along the row, and along a diagonal.
            const bool isBetween = x == 4 && (y == 2 || y == 4);
            ASSERT_EQ(strip.covered.at(x, y), (x >= 6 && !isWide) || isTexel || isBetween ? 1 : 0) << x << ' ' << y;
        }
}

TEST(LitCoverage, StripsAreThoseOfTheWhole) {
    const MapFile map(picture());
    const auto reader = LightMapReader::open(map.path, byLight());
    ASSERT_TRUE(reader);
    EXPECT_TRUE(reader->hasCoverage());
    const LightMapStrip whole = readAll(map.path, byLight());
    for (const auto& [first, count] :
         {std::pair(0, 2), std::pair(2, 1), std::pair(3, 1), std::pair(4, 1), std::pair(5, 60), std::pair(69, 1)}) {
        const auto part = reader->read(first, count);
        ASSERT_TRUE(part);
        ASSERT_EQ(part->sh.height(), count);
        for (int y = 0; y < count; ++y)
            for (int x = 0; x < 20; ++x) {
                ASSERT_EQ(part->covered.at(x, y), whole.covered.at(x, first + y)) << x << ' ' << first + y;
                ASSERT_EQ(part->sh.at(x, y)[0], whole.sh.at(x, first + y)[0]);
            }
    }
}

TEST(LitCoverage, TakesThePlaceOfTheCoverageOfTheFile) {
    ExrRecipe recipe = picture();
    recipe.channels["coverage.Y"] = [](int, int) { return 1.0f; };
    const MapFile map(recipe);
    EXPECT_EQ(readAll(map.path, byLight()).covered.at(0, 10), 0);
}

TEST(LitCoverage, NoNumberIsNoGap) {
    ExrRecipe recipe = picture();
    recipe.channels["R"] = [](int x, int y) { return x == 0 && y == 50 ? std::numeric_limits<float>::quiet_NaN() : 0.0f; };
    const MapFile map(recipe);
    EXPECT_THAT(refusal(map.path, byLight()).line(), testing::HasSubstr("texel (0, 50)"));
}

}  // namespace
}  // namespace lightcook::formats

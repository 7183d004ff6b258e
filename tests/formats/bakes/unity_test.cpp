#include "formats/bakes/unity.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/vec4.hpp>
#include <limits>
#include <string>
#include <utility>

#include "tests/formats/light_map_fixture.h"
#include "tests/formats/picture_fixture.h"

namespace lightcook::formats {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr int kUnityWidth = 20, kUnityHeight = 66;

/// The four bytes of a direction: inside the ball of radius 0.5, with an alpha from 0.5 to 0.9.
int directionByte(int channel, int x, int y) {
    const double seed = static_cast<double>(seededSh(1 + channel, 0, x, y));
    return static_cast<int>(std::lround(255 * (channel < 3 ? 0.5 + 0.28 * seed : 0.7 + 0.2 * seed)));
}

ExrRecipe colours(int width = kUnityWidth, int height = kUnityHeight) {
    ExrRecipe recipe;
    recipe.width = width;
    recipe.height = height;
    for (int c = 0; c < 3; ++c) recipe.channels[std::string(1, "RGB"[c])] = [c](int x, int y) { return seededSh(0, c, x, y); };
    return recipe;
}

/// A bake with the names that Unity gives.
struct UnityBake {
    TemporaryFolder folder;
    std::filesystem::path light = folder / "Lightmap-0_comp_light.exr", direction = folder / "Lightmap-0_comp_dir.png";

    explicit UnityBake(const ExrRecipe& recipe = colours(), const ByteValue& bytes = directionByte, int channelCount = 4) {
        writeRecipe(light, recipe);
        writePng(direction, kUnityWidth, kUnityHeight, channelCount, bytes);
    }
};

/// The directional light map of Unity's shader, written out: half Lambert over the rebalancing coefficient.
double shownByUnity(double colour, const glm::dvec4& stored, const glm::dvec3& n) {
    const double halfLambert = n.x * (stored.x - 0.5) + n.y * (stored.y - 0.5) + n.z * (stored.z - 0.5) + 0.5;
    return colour * halfLambert / std::max(1e-4, stored.w);
}

TEST(UnityDirectional, ATexelShadesAsTheShaderOfTheEngineShowsIt) {
    const UnityBake bake;
    const LightMapStrip strip = readAll(bake.light);
    ASSERT_EQ(strip.sh.height(), kUnityHeight);
    double largest = 0, brightest = 0;
    for (int y = 0; y < kUnityHeight; ++y)
        for (int x = 0; x < kUnityWidth; ++x) {
            for (std::size_t i = 4; i < 9; ++i) ASSERT_EQ(strip.sh.at(x, y)[i], glm::vec3(0));
            glm::dvec4 stored;
            for (int channel = 0; channel < 4; ++channel) stored[channel] = directionByte(channel, x, y) / 255.0;
            for (int c = 0; c < 3; ++c)
                for (const glm::dvec3& n : kShadedNormals) {
                    const double shown = shownByUnity(static_cast<double>(seededSh(0, c, x, y)), stored, n);
                    largest = std::max(largest, std::abs(exitRadianceOfOrder1(strip.sh.at(x, y), c, n) - shown));
                    brightest = std::max(brightest, shown);
                }
        }
    RecordProperty("deviation", fmt::format("{:.2g}", largest / brightest));
    EXPECT_LT(largest, 1e-6 * brightest);
}

TEST(UnityDirectional, TheNamesOfTheFilesSayWhatTheyAre) {
    const UnityBake bake;
    const auto reader = LightMapReader::open(bake.light, {});
    ASSERT_TRUE(reader) << reader.error().line();
    EXPECT_EQ(reader->bake(), "unity-directional");
    EXPECT_EQ(reader->recognition().evidence, "the 2 files Lightmap-0_comp_light.exr to Lightmap-0_comp_dir.png");
    EXPECT_THAT(reader->recognition().otherReadings, testing::ElementsAre("flat"));
    EXPECT_THAT(std::string(reader->recognition().format->assumes), HasSubstr("left-handed"));
    EXPECT_THAT(bakeFilesBeside(bake.light, kAutoBake), testing::ElementsAre(bake.direction));
    EXPECT_THAT(bakeFilesBeside(bake.light, "flat"), testing::IsEmpty());
    LightMapDescription description;
    description.bake = "flat";
    EXPECT_EQ(readAll(bake.light, description).sh.at(3, 3)[1], glm::vec3(0)) << "of the colour alone";
    std::filesystem::remove(bake.direction);
    const auto alone = LightMapReader::open(bake.light, {});
    ASSERT_TRUE(alone) << alone.error().line();
    EXPECT_EQ(alone->bake(), "flat") << "a light map that is not directional has the same name";
    EXPECT_THAT(alone->recognition().incompleteSets, testing::IsEmpty()) << "and nothing is missing";
}

/// Archives and file systems change the case of names.
TEST(UnityDirectional, TheCaseOfTheNamesDoesNotMatter) {
    using Names = std::pair<const char*, const char*>;
    for (const auto& [light, direction] :
         {Names("Lightmap-0_comp_light.exr", "Lightmap-0_comp_dir.PNG"), Names("LIGHTMAP-0_COMP_LIGHT.EXR", "LIGHTMAP-0_COMP_DIR.PNG"),
          Names("Room_Light.exr", "Room_Dir.png"), Names("room_LIGHT.EXR", "room_dir.png"), Names("ROOM_light.exr", "room_dir.png"),
          Names("Room_light.exr", "ROOM_DIR.PNG")}) {
        const TemporaryFolder folder;
        writeRecipe(folder / light, colours());
        writePng(folder / direction, kUnityWidth, kUnityHeight, 4, directionByte);
        const auto reader = LightMapReader::open(folder / light, {});
        ASSERT_TRUE(reader) << reader.error().line();
        EXPECT_EQ(reader->bake(), "unity-directional") << light;
        EXPECT_THAT(bakeFilesBeside(folder / light, kAutoBake), testing::ElementsAre(folder / direction));
        EXPECT_EQ(nameOfBake(folder / light, "unity-directional"), std::string(light).substr(0, std::string(light).size() - 10));
        EXPECT_NE(readAll(folder / light).sh.at(3, 3)[1], glm::vec3(0));
    }
}

/// The stem of the light differs from that of its directions: only all capitals or all small letters are looked for.
TEST(UnityDirectional, ADirectionMapLeadsToItsLightInAnyCase) {
    const TemporaryFolder folder;
    writeRecipe(folder / "Hall_Light.EXR", colours());
    writePng(folder / "Hall_Dir.PNG", kUnityWidth, kUnityHeight, 4, directionByte);
    EXPECT_EQ(leadingFile(folder / "Hall_Dir.PNG", kAutoBake), folder / "Hall_Light.EXR");
}

TEST(BakeryDominant, ATexelShadesAsTheShaderOfUnityShowsIt) {
    for (const int channelCount : {4, 3}) {
        const TemporaryFolder folder;
        writeRecipe(folder / "level_LMA1_final.exr", colours());
        writePng(folder / "level_LMA1_dir.png", kUnityWidth, kUnityHeight, channelCount, directionByte);
        const auto reader = LightMapReader::open(folder / "level_LMA1_final.exr", {});
        ASSERT_TRUE(reader) << reader.error().line();
        EXPECT_EQ(reader->bake(), "bakery-dominant");
        EXPECT_EQ(reader->recognition().evidence, "the 2 files level_LMA1_final.exr to level_LMA1_dir.png");
        const LightMapStrip strip = readAll(folder / "level_LMA1_dir.png");
        for (int x = 0; x < kUnityWidth; ++x)
            for (int c = 0; c < 3; ++c)
                for (const glm::dvec3& n : kShadedNormals) {
                    glm::dvec4 stored(1);
                    for (int channel = 0; channel < channelCount; ++channel) stored[channel] = directionByte(channel, x, 7) / 255.0;
                    const double shown = shownByUnity(static_cast<double>(seededSh(0, c, x, 7)), stored, n);
                    ASSERT_NEAR(exitRadianceOfOrder1(strip.sh.at(x, 7), c, n), shown, 1e-5 * std::max(1.0, shown)) << channelCount;
                }
    }
}

TEST(BakeryDominant, TheColourAloneIsAFlatMap) {
    const TemporaryFolder folder;
    writeRecipe(folder / "level_LMA1_final.exr", colours());
    const auto reader = LightMapReader::open(folder / "level_LMA1_final.exr", {});
    ASSERT_TRUE(reader) << reader.error().line();
    EXPECT_EQ(reader->bake(), "flat");
    EXPECT_THAT(reader->recognition().incompleteSets, testing::IsEmpty()) << "directions are off";
    LightMapDescription description;
    description.bake = "bakery-dominant";
    EXPECT_THAT(refusal(folder / "level_LMA1_final.exr", description).line(),
                HasSubstr("found 1 of the 2 files of bake format bakery-dominant, level_LMA1_dir (.exr, .hdr, .tga or .png) is missing"));
}

TEST(UnityDirectional, AMapFourTimesAsHighAsWideIsNoStackBesideItsDirections) {
    const TemporaryFolder folder;
    writeRecipe(folder / "a_light.exr", colours(8, 32));
    writePng(folder / "a_dir.png", 8, 32, 4, directionByte);
    const auto reader = LightMapReader::open(folder / "a_light.exr", {});
    ASSERT_TRUE(reader) << reader.error().line();
    EXPECT_EQ(reader->bake(), "unity-directional");
}

TEST(UnityDirectional, FilesThatDoNotFitAreNamed) {
    {
        const UnityBake bake(colours(), directionByte, 3);
        EXPECT_THAT(refusal(bake.light).line(), AllOf(HasSubstr("Lightmap-0_comp_dir.png: found no alpha"), HasSubstr("Export the map")));
    }
    const UnityBake bake(colours(kUnityWidth, kUnityHeight - 2));
    EXPECT_THAT(refusal(bake.light).line(),
                AllOf(HasSubstr("Lightmap-0_comp_dir.png"), HasSubstr("found 20 x 66 texels, expected 20 x 64")));
    std::filesystem::remove(bake.direction);
    LightMapDescription description;
    description.bake = "unity-directional";
    EXPECT_THAT(
        refusal(bake.light, description).line(),
        HasSubstr("found 1 of the 2 files of bake format unity-directional, Lightmap-0_comp_dir (.exr, .hdr, .tga or .png) is missing"));
    const MapFile other(colours());
    EXPECT_THAT(refusal(other.path, description).line(),
                HasSubstr("found no light map of bake format unity-directional, expected files _light and _dir; it holds R, G, B"));
}

TEST(UnityDirectional, LightWithoutADirectionIsNamed) {
    const auto without = [](int channel, int x, int y) { return x == 3 && y == 65 ? 0 : directionByte(channel, x, y); };
    {
        const UnityBake bake(colours(), without);
        const Error error = refusal(bake.light);
        EXPECT_EQ(error.code, ErrorCode::ValueOutOfRange);
        EXPECT_THAT(error.line(), AllOf(HasSubstr("Lightmap-0_comp_dir.png, texel (3, 65): found (0, 0, 0, 0), expected a direction"),
                                        HasSubstr("Lightmap-0_comp_light.exr")));
    }
    // Black, or outside the charts, a texel needs none.
    ExrRecipe recipe = colours();
    for (const char* channel : {"R", "G", "B"}) poke(recipe, channel, 3, 65, 0);
    EXPECT_EQ(readAll(UnityBake(recipe, without).light).sh.at(3, 65)[0], glm::vec3(0));
    recipe = colours();
    recipe.channels["A"] = [](int x, int y) { return x == 3 && y == 65 ? 0.0f : 1.0f; };
    EXPECT_EQ(readAll(UnityBake(recipe, without).light).covered.at(3, 65), 0);
}

TEST(UnityDirectional, ValuesThatAreNoLightAreNamed) {
    for (const auto& [value, code] :
         {std::pair(std::numeric_limits<float>::quiet_NaN(), ErrorCode::ValueNotFinite), std::pair(-1.0f, ErrorCode::ValueOutOfRange)}) {
        ExrRecipe recipe = colours();
        poke(recipe, "G", 3, 4, value);
        const Error error = refusal(UnityBake(recipe).light);
        EXPECT_EQ(error.code, code);
        EXPECT_THAT(error.line(), HasSubstr(fmt::format("Lightmap-0_comp_light.exr, channel G, texel (3, 4): found {}, expected", value)));
    }
}

/// A number in the directions that is not finite makes coefficients of a texel NaN or infinite; the error names the number itself.
TEST(UnityDirectional, DirectionsThatAreNoNumbersAreNamed) {
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInfinity = std::numeric_limits<float>::infinity();
    for (const auto& [channel, value] : {std::pair("B", kNan), std::pair("A", kNan), std::pair("A", kInfinity)}) {
        const TemporaryFolder folder;
        writeRecipe(folder / "a_light.exr", colours());
        ExrRecipe directions;
        directions.width = kUnityWidth;
        directions.height = kUnityHeight;
        for (int c = 0; c < 4; ++c)
            directions.channels[std::string(1, "RGBA"[c])] = [c](int x, int y) { return static_cast<float>(directionByte(c, x, y)) / 255; };
        poke(directions, channel, 3, 65, value);
        writeRecipe(folder / "a_dir.exr", directions);
        const Error error = refusal(folder / "a_light.exr");
        EXPECT_EQ(error.code, ErrorCode::ValueNotFinite);
        EXPECT_THAT(error.line(), HasSubstr(fmt::format("a_dir.exr, channel {}, texel (3, 65): found {}", channel, value)));
    }
}

}  // namespace
}  // namespace lightcook::formats

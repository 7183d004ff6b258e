#include "formats/bakes/sh_baker.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "tests/formats/light_map_fixture.h"

namespace lightcook::formats {
namespace {

using lighting::ShRgb;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

/// The names that the baker has for coefficients 0 to 8.
constexpr std::array kNames = {"L0", "L1m1", "L10", "L11", "L2m2", "L2m1", "L20", "L21", "L22"};

ExrRecipe combined(int width, int height) {
    ExrRecipe recipe;
    recipe.width = width;
    recipe.height = height;
    for (int i = 0; i < 9; ++i)
        for (int c = 0; c < 3; ++c)
            recipe.channels[fmt::format("{}.{}", kNames.at(static_cast<std::size_t>(i)), "RGB"[c])] = [i, c](int x, int y) {
                return seededSh(i, c, x, y);
            };
    recipe.channels["EnvVisibility"] = [](int x, int) { return 0.25f * static_cast<float>(x % 4); };
    return recipe;
}

/// A picture of one coefficient.
ExrRecipe split(int coefficient, int width, int height) {
    ExrRecipe recipe;
    recipe.width = width;
    recipe.height = height;
    for (int c = 0; c < 3; ++c) recipe.channels[std::string(1, "RGB"[c])] = [=](int x, int y) { return seededSh(coefficient, c, x, y); };
    return recipe;
}

void writeSplit(const TemporaryFolder& folder, int width, int height) {
    for (int i = 0; i < 9; ++i)
        writeRecipe(folder / fmt::format("room_{}.exr", kNames.at(static_cast<std::size_t>(i))), split(i, width, height));
}

double luminanceOf(int coefficient, int x, int y) {
    return 0.2126 * static_cast<double>(seededSh(coefficient, 0, x, y)) + 0.7152 * static_cast<double>(seededSh(coefficient, 1, x, y)) +
           0.0722 * static_cast<double>(seededSh(coefficient, 2, x, y));
}

void writePacked(const TemporaryFolder& folder, int width, int height) {
    for (int file = 0; file < 3; ++file) {
        ExrRecipe recipe = split(0, width, height);
        if (file == 0) recipe.channels["A"] = [](int, int) { return 0.0f; };  // the visibility of the environment is no coverage
        for (int i = 0; i < 4 && file > 0; ++i)
            recipe.channels[std::string(1, "RGBA"[i])] = [coefficient = 4 * file - 3 + i](int x, int y) {
                return static_cast<float>(luminanceOf(coefficient, x, y));
            };
        writeRecipe(folder / fmt::format("room_packed_{}.exr", file), recipe);
    }
}

void expectSeeded(const LightMapStrip& strip, int width, int height) {
    ASSERT_EQ(strip.sh.width(), width);
    ASSERT_EQ(strip.sh.height(), height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            ASSERT_EQ(strip.sh.at(x, y), seededTexel(x, y)) << x << ' ' << y;
            ASSERT_EQ(strip.covered.at(x, y), 1);
        }
}

TEST(ShBaker, OneFileIsRecognisedByItsChannelsAndReadExactly) {
    for (const bool isHalf : {false, true}) {
        ExrRecipe recipe = combined(70, 81);
        recipe.isHalf = isHalf;
        const MapFile map(recipe);
        const auto reader = LightMapReader::open(map.path, {});
        ASSERT_TRUE(reader) << reader.error().line();
        EXPECT_EQ(reader->bake(), "sh-baker");
        EXPECT_EQ(reader->recognition().evidence, "channels L0.R .. L22.B");
        EXPECT_FALSE(reader->hasCoverage());
        expectSeeded(readAll(map.path), 70, 81);
    }
}

TEST(ShBaker, SplitFilesAreFoundFromAnyOfThem) {
    const TemporaryFolder folder;
    writeSplit(folder, 20, 66);
    for (const char* name : {"room_L0.exr", "room_L22.exr"}) {
        const auto reader = LightMapReader::open(folder / name, {});
        ASSERT_TRUE(reader) << reader.error().line();
        EXPECT_EQ(reader->bake(), "sh-baker");
        EXPECT_EQ(reader->recognition().evidence, "the 9 files room_L0.exr to room_L22.exr");
        expectSeeded(readAll(folder / name), 20, 66);
    }
    EXPECT_EQ(bakeFilesBeside(folder / "room_L0.exr", kAutoBake).size(), 8u);
    EXPECT_THAT(bakeFilesBeside(folder / "room_L0.exr", "sh9"), testing::IsEmpty()) << "sh9 is one file";
    EXPECT_THAT(bakeFilesBeside(folder / "room.exr", kAutoBake), testing::IsEmpty());
}

TEST(ShBaker, PackedFilesTakeTheColourOfTheFirstCoefficient) {
    const TemporaryFolder folder;
    writePacked(folder, 12, 9);
    EXPECT_THAT(bakeFilesBeside(folder / "room_packed_1.exr", "sh-baker"),
                ElementsAre(folder / "room_packed_0.exr", folder / "room_packed_2.exr"));
    const LightMapStrip strip = readAll(folder / "room_packed_0.exr");
    ASSERT_EQ(strip.sh.height(), 9);
    for (int y = 0; y < 9; ++y)
        for (int x = 0; x < 12; ++x) {
            ASSERT_EQ(strip.covered.at(x, y), 1);
            for (int c = 0; c < 3; ++c) {
                const double first = static_cast<double>(seededSh(0, c, x, y));
                ASSERT_EQ(strip.sh.at(x, y)[0][c], seededSh(0, c, x, y));
                for (int i = 1; i < 9; ++i)
                    ASSERT_NEAR(strip.sh.at(x, y)[static_cast<std::size_t>(i)][c], luminanceOf(i, x, y) * first / luminanceOf(0, x, y),
                                1e-5)
                        << i;
            }
        }
}

/// Writes packed files whose L0 is black at texel (1, 2), and whose luminances there are `luminance`.
void writePackedWithBlack(const TemporaryFolder& folder, float luminance) {
    writePacked(folder, 4, 4);
    for (int file = 0; file < 3; ++file) {
        ExrRecipe recipe = split(0, 4, 4);
        recipe.channels["A"] = [](int, int) { return 0.25f; };
        for (const char* channel : {"R", "G", "B", "A"}) {
            if (file > 0) recipe.channels[channel] = [](int, int) { return 0.0f; };
            if (file > 0 || std::string(channel) != "A") poke(recipe, channel, 1, 2, file == 0 ? 0.0f : luminance);
        }
        writeRecipe(folder / fmt::format("room_packed_{}.exr", file), recipe);
    }
}

TEST(ShBaker, ABlackTexelOfPackedFilesStaysBlack) {
    const TemporaryFolder folder;
    for (const float luminance : {0.0f, 5e-7f}) {
        writePackedWithBlack(folder, luminance);
        EXPECT_EQ(readAll(folder / "room_packed_0.exr").sh.at(1, 2), ShRgb{}) << luminance;
    }
}

TEST(ShBaker, LuminancesBesideABlackFirstCoefficientAreRefused) {
    const TemporaryFolder folder;
    writePackedWithBlack(folder, 0.1f);
    LightMapDescription description;
    const auto reader = LightMapReader::open(folder / "room_packed_0.exr", description);
    ASSERT_TRUE(reader) << reader.error().line();
    const auto refused = reader->read(0, 4);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::ValueOutOfRange);
    EXPECT_THAT(refused.error().line(), testing::AllOf(HasSubstr("room_packed_1.exr"), HasSubstr("(1, 2)")));
    description.repair = true;
    const auto repairing = LightMapReader::open(folder / "room_packed_0.exr", description);
    ASSERT_TRUE(repairing);
    const auto strip = repairing->read(0, 4);
    ASSERT_TRUE(strip);
    EXPECT_EQ(strip->sh.at(1, 2), ShRgb{});
    EXPECT_EQ(strip->repairs.bandsBeyond, 6);
}

TEST(ShBaker, MissingAndForeignFilesAreNamed) {
    const TemporaryFolder folder;
    writeSplit(folder, 8, 8);
    writeRecipe(folder / "room_L20.exr", split(6, 8, 9));
    EXPECT_THAT(refusal(folder / "room_L0.exr").line(), AllOf(HasSubstr("room_L20.exr"), HasSubstr("found 8 x 9 texels, expected 8 x 8")));
    ExrRecipe other = split(6, 8, 8);
    other.channels.erase("G");
    writeRecipe(folder / "room_L20.exr", other);
    EXPECT_THAT(refusal(folder / "room_L0.exr").line(), AllOf(HasSubstr("room_L20.exr"), HasSubstr("found no channel G")));
    std::filesystem::remove(folder / "room_L20.exr");
    const Error error = refusal(folder / "room_L0.exr");
    EXPECT_EQ(error.code, ErrorCode::WrongShape);
    EXPECT_THAT(error.line(), AllOf(HasSubstr("room_L0.exr: found 8 of the 9 files of bake format sh-baker, room_L20.exr is missing"),
                                    HasSubstr("expected it in the same folder")));
    std::filesystem::remove(folder / "room_L21.exr");
    EXPECT_THAT(refusal(folder / "room_L0.exr").line(), HasSubstr("room_L20.exr and 1 more are missing"));
}

TEST(ShBaker, MissingChannelsAndValuesThatAreNoLightAreNamed) {
    ExrRecipe recipe = combined(8, 8);
    recipe.channels.erase("L2m1.G");
    EXPECT_THAT(refusal(MapFile(recipe).path).line(),
                HasSubstr("found 26 of the 27 channels of bake format sh-baker, L2m1.G is missing, expected L0.R .. L22.B"));
    recipe = combined(8, 8);
    poke(recipe, "L11.B", 3, 4, std::numeric_limits<float>::quiet_NaN());
    const Error error = refusal(MapFile(recipe).path);
    EXPECT_EQ(error.code, ErrorCode::ValueNotFinite);
    EXPECT_THAT(error.line(), AllOf(HasSubstr("texel (3, 4)"), HasSubstr("channel L11.B")));
}

}  // namespace
}  // namespace lightcook::formats

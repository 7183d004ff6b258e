#include "formats/bakes/bakery.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "tests/formats/light_map_fixture.h"
#include "tests/formats/picture_fixture.h"

namespace lightcook::formats {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr int kBakeryWidth = 24, kBakeryHeight = 70;

double firstOf(int c, int x, int y) {
    return 0.25 * static_cast<double>(seededSh(0, c, x, y));
}
/// The stored direction t along axis 0, 1 or 2, as 8 bits have it.
int storedDirection(int axis, int c, int x, int y) {
    return static_cast<int>(std::lround(255 * (0.5 + 0.25 * static_cast<double>(seededSh(1 + axis, c, x, y)))));
}

/// poked  value of the green of texel (3, 4)
void writeFirst(const std::filesystem::path& file, int height = kBakeryHeight, std::optional<float> poked = {}) {
    ExrRecipe recipe;
    recipe.width = kBakeryWidth;
    recipe.height = height;
    for (int c = 0; c < 3; ++c)
        recipe.channels[std::string(1, "RGB"[c])] = [c](int x, int y) { return static_cast<float>(firstOf(c, x, y)); };
    if (poked) poke(recipe, "G", 3, 4, *poked);
    writeRecipe(file, recipe);
}

void writeBake(const TemporaryFolder& folder) {
    writeFirst(folder / "room_L0.exr");
    for (int axis = 0; axis < 3; ++axis)
        writePng(folder / (std::string("room_L1") + "xyz"[axis] + ".png"), kBakeryWidth, kBakeryHeight, 3,
                 [axis](int c, int x, int y) { return storedDirection(axis, c, x, y); });
}

/// The direction that the colours share: that of the red of the other format.
void writeMonoBake(const TemporaryFolder& folder) {
    writeFirst(folder / "room_L0.exr");
    writePng(folder / "room_L1.png", kBakeryWidth, kBakeryHeight, 3, [](int axis, int x, int y) { return storedDirection(axis, 0, x, y); });
}

/// Returns the largest difference between a map's shading and L0 + n . 2 L0 (2 t - 1), relative to the brightest value.
/// isMono  t is that of the red for all colours
double largestDeviation(const LightMapStrip& strip, bool isMono) {
    double largest = 0, brightest = 0;
    for (int y = 0; y < kBakeryHeight; ++y)
        for (int x = 0; x < kBakeryWidth; ++x)
            for (int c = 0; c < 3; ++c)
                for (const glm::dvec3& n : {glm::dvec3(0, 0, 1), glm::dvec3(0, -1, 0), glm::normalize(glm::dvec3(1, 2, -2))}) {
                    double shown = firstOf(c, x, y);
                    for (int axis = 0; axis < 3; ++axis)
                        shown += n[axis] * (2 * (storedDirection(axis, isMono ? 0 : c, x, y) / 255.0) - 1) * firstOf(c, x, y) * 2;
                    largest = std::max(largest, std::abs(exitRadianceOfOrder1(strip.sh.at(x, y), c, n) - shown));
                    brightest = std::max(brightest, shown);
                }
    return largest / brightest;
}

TEST(BakerySh, ATexelShadesAsTheShaderOfTheBakerShowsIt) {
    const TemporaryFolder folder;
    writeBake(folder);
    const auto reader = LightMapReader::open(folder / "room_L0.exr", {});
    ASSERT_TRUE(reader) << reader.error().line();
    EXPECT_EQ(reader->bake(), "bakery-sh");
    EXPECT_EQ(reader->recognition().evidence, "the 4 files room_L0.exr to room_L1z.png");
    EXPECT_THAT(reader->recognition().incompleteSets, testing::IsEmpty()) << "sh-baker and mono-sh have a file of this name too";
    EXPECT_EQ(bakeFilesBeside(folder / "room_L0.exr", kAutoBake).size(), 3u);
    const LightMapStrip strip = readAll(folder / "room_L0.exr");
    ASSERT_EQ(strip.sh.height(), kBakeryHeight);
    const double deviation = largestDeviation(strip, false);
    RecordProperty("deviation", fmt::format("{:.2g}", deviation));
    EXPECT_LT(deviation, 1e-6);
}

TEST(BakerySh, MissingAndForeignFilesAreNamed) {
    const TemporaryFolder folder;
    writeBake(folder);
    writeFirst(folder / "room_L0.exr", kBakeryHeight - 1);
    EXPECT_THAT(refusal(folder / "room_L0.exr").line(),
                AllOf(HasSubstr("room_L1x.png"), HasSubstr("found 24 x 70 texels, expected 24 x 69")));
    writeContent(folder / "room_L1y.png", "no picture");
    writeFirst(folder / "room_L0.exr");
    EXPECT_THAT(refusal(folder / "room_L0.exr").line(), HasSubstr("room_L1y.png"));
    std::filesystem::remove(folder / "room_L1y.png");
    EXPECT_THAT(refusal(folder / "room_L0.exr").line(),
                HasSubstr("found 3 of the 4 files of bake format bakery-sh, room_L1y (.exr, .hdr, .tga or .png) is missing, expected it"));
}

TEST(BakerySh, NumbersOfDirectionsThatAreNoLightAreNamed) {
    for (const float value : {std::numeric_limits<float>::quiet_NaN(), 90.0f}) {
        const TemporaryFolder folder;
        writeBake(folder);
        std::filesystem::remove(folder / "room_L1y.png");
        writeFirst(folder / "room_L1y.exr", kBakeryHeight, value);
        const Error error = refusal(folder / "room_L0.exr");
        const bool isNumber = value == value;
        EXPECT_EQ(error.code, isNumber ? ErrorCode::ValueOutOfRange : ErrorCode::ValueNotFinite);
        EXPECT_THAT(error.line(), HasSubstr("room_L1y.exr, channel G, texel (3, 4)")) << "coefficient 1";
        if (isNumber) {
            EXPECT_THAT(error.line(), AllOf(HasSubstr("room_L1x.png, channel G, texel (3, 4): found a length of"))) << "coefficient 3";
        }
    }
}

TEST(BakeryMonoSh, ATexelShadesAsTheShaderOfTheBakerShowsIt) {
    const TemporaryFolder folder;
    writeMonoBake(folder);
    const auto reader = LightMapReader::open(folder / "room_L0.exr", {});
    ASSERT_TRUE(reader) << reader.error().line();
    EXPECT_EQ(reader->bake(), "bakery-mono-sh");
    EXPECT_EQ(reader->recognition().evidence, "the 2 files room_L0.exr to room_L1.png");
    EXPECT_THAT(reader->recognition().otherReadings, testing::ElementsAre("flat"));
    EXPECT_THAT(reader->recognition().incompleteSets, testing::IsEmpty());
    EXPECT_THAT(bakeFilesBeside(folder / "room_L0.exr", kAutoBake), testing::ElementsAre(folder / "room_L1.png"));
    const LightMapStrip strip = readAll(folder / "room_L0.exr");
    ASSERT_EQ(strip.sh.height(), kBakeryHeight);
    for (std::size_t i = 4; i < 9; ++i) ASSERT_EQ(strip.sh.at(5, 60)[i], glm::vec3(0));
    const double deviation = largestDeviation(strip, true);
    RecordProperty("deviation", fmt::format("{:.2g}", deviation));
    EXPECT_LT(deviation, 1e-6);
}

TEST(BakeryMonoSh, FilesOfBothFormatsAreAChoice) {
    const TemporaryFolder folder;
    writeBake(folder);
    writeMonoBake(folder);
    const Error error = refusal(folder / "room_L0.exr");
    EXPECT_EQ(error.code, ErrorCode::WrongShape);
    EXPECT_THAT(error.line(), AllOf(HasSubstr("bakery-sh (the 4 files room_L0.exr to room_L1z.png)"),
                                    HasSubstr("bakery-mono-sh (the 2 files room_L0.exr to room_L1.png)"),
                                    HasSubstr("bake = \"bakery-sh\" or bake = \"bakery-mono-sh\"")));
    LightMapDescription description;
    description.bake = "bakery-sh";
    EXPECT_LT(largestDeviation(readAll(folder / "room_L0.exr", description), false), 1e-6);
    description.bake = "bakery-mono-sh";
    EXPECT_LT(largestDeviation(readAll(folder / "room_L0.exr", description), true), 1e-6);
}

TEST(BakeryMonoSh, MissingAndForeignFilesAreNamed) {
    const TemporaryFolder folder;
    writeMonoBake(folder);
    writeFirst(folder / "room_L0.exr", kBakeryHeight - 1);
    EXPECT_THAT(refusal(folder / "room_L0.exr").line(),
                AllOf(HasSubstr("room_L1.png"), HasSubstr("found 24 x 70 texels, expected 24 x 69")));
    writeFirst(folder / "room_L0.exr");
    std::filesystem::remove(folder / "room_L1.png");
    LightMapDescription description;
    description.bake = "bakery-mono-sh";
    EXPECT_THAT(refusal(folder / "room_L0.exr", description).line(),
                HasSubstr("found 1 of the 2 files of bake format bakery-mono-sh, room_L1 (.exr, .hdr, .tga or .png) is missing"));
}

TEST(BakeryMonoSh, ValuesThatAreNoLightAreNamed) {
    for (const auto& [value, code] :
         {std::pair(std::numeric_limits<float>::quiet_NaN(), ErrorCode::ValueNotFinite), std::pair(-1.0f, ErrorCode::ValueOutOfRange)}) {
        const TemporaryFolder folder;
        writeMonoBake(folder);
        writeFirst(folder / "room_L0.exr", kBakeryHeight, value);
        const Error error = refusal(folder / "room_L0.exr");
        EXPECT_EQ(error.code, code);
        EXPECT_THAT(error.line(), HasSubstr(fmt::format("room_L0.exr, channel G, texel (3, 4): found {}, expected", value)));
    }
}

TEST(BakeryMonoSh, LightBeyondFloatsAndFirefliesAreNamedByTheirFile) {
    const TemporaryFolder folder;
    writeMonoBake(folder);
    writeFirst(folder / "room_L0.exr", kBakeryHeight, 3.2e37f);
    const auto reader = LightMapReader::open(folder / "room_L0.exr", {});
    ASSERT_TRUE(reader) << reader.error().line();
    EXPECT_THAT(reader->placeOf(0, 1, 3, 4).text, testing::EndsWith("room_L0.exr, channel G, texel (3, 4)"));
    LightMapDescription description;
    description.lightUnits = LightUnits::Game;
    const Error error = refusal(folder / "room_L0.exr", description);
    EXPECT_EQ(error.code, ErrorCode::ValueOutOfRange);
    EXPECT_THAT(error.line(), HasSubstr("room_L0.exr, channel G, texel (3, 4): found light that leaves the range of float"));
}

}  // namespace
}  // namespace lightcook::formats

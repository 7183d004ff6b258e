#include "formats/bakes/deluxe.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <string>

#include "lighting/radiometry.h"
#include "lighting/sphere.h"
#include "tests/formats/light_map_fixture.h"
#include "tests/formats/picture_fixture.h"
#include "tests/formats/surface_fixture.h"

namespace lightcook::formats {
namespace {

using glm::dvec3;
using testing::HasSubstr;

constexpr int kDeluxeSide = 12;
const dvec3 kNormal(0, 1, 0);

int lightAt(int c, int x, int y) {
    return 45 + 14 * x + 3 * y - 20 * c;
}
/// Directions all around: from straight above to far below the surface, and none in the last row.
int directionAt(int c, int x, int y) {
    if (y == kDeluxeSide - 1) return 128;
    const double slope = -1.5 + 3.0 * y / kDeluxeSide, turn = 2.1 * x;
    const dvec3 d = glm::normalize(dvec3(std::cos(turn), slope, std::sin(turn)));
    return static_cast<int>(std::lround(255 * (0.5 * d[c] + 0.5)));
}

dvec3 directionOf(int x, int y) {
    dvec3 d;
    for (int c = 0; c < 3; ++c) d[c] = 2 * directionAt(c, x, y) / 255.0 - 1;
    return d;
}

/// Returns the light that a white surface shows in ioquake3 (code/renderergl2/glsl/lightall_fp.glsl) at a light map of 1.
double shownByEngine(const dvec3& n, const dvec3& direction) {
    if (glm::length(direction) < 0.125) return 1;
    const dvec3 d = glm::normalize(direction);
    const double facing = std::clamp(glm::dot(kNormal, d), 0.0, 1.0), light = 0.75 / std::max(facing, 0.25),
                 ambient = std::max(1 - light * facing, 0.0);
    return light * std::clamp(glm::dot(n, d), 0.0, 1.0) + ambient;
}

double srgbToLinear(double value) {
    return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

LightMapDescription description(const TemporaryFolder& folder, const std::string& bake = std::string(kAutoBake)) {
    LightMapDescription description;
    description.bake = bake;
    description.encoding = LightEncoding::Srgb;
    description.mesh = folder / "square.glb";
    return description;
}

double shownBySh(const lighting::ShRgb& sh, int c, const dvec3& n) {
    return static_cast<double>(lighting::lambertExitRadiance(sh, n, glm::vec3(1)).value[c]);
}

TEST(Deluxe, TheSurfaceShowsItsLightMapAndOtherNormalsNearlyWhatTheShaderShows) {
    const TemporaryFolder folder;
    writePng(folder / "room.png", kDeluxeSide, kDeluxeSide, 3, lightAt);
    writePng(folder / "room_deluxe.png", kDeluxeSide, kDeluxeSide, 3, directionAt);
    writeSquare(folder / "square.glb", {});
    const LightMapStrip strip = readAll(folder / "room.png", description(folder));
    ASSERT_EQ(strip.sh.height(), kDeluxeSide);
    double largest = 0;
    for (int y = 0; y < kDeluxeSide; ++y)
        for (int x = 0; x < kDeluxeSide; ++x)
            for (int c = 0; c < 3; ++c) {
                ASSERT_EQ(strip.covered.at(x, y), 1);
                const double light = srgbToLinear(lightAt(c, x, y) / 255.0);
                ASSERT_NEAR(shownBySh(strip.sh.at(x, y), c, kNormal), light, 1e-5);
                const double strongest = 0.75 / std::max(glm::dot(kNormal, glm::normalize(directionOf(x, y))), 0.25);
                for (int k = 0; k < 24; ++k) {
                    const dvec3 local = lighting::fibonacciHemisphere(k, 24), n(local.x, local.z, local.y);
                    const double off = shownBySh(strip.sh.at(x, y), c, n) - light * shownByEngine(n, directionOf(x, y));
                    largest = std::max(largest, std::abs(off) / (light * strongest));
                }
                // Light is from where the map says.
                const lighting::ShRgb& sh = strip.sh.at(x, y);
                const dvec3 band1(sh[3][c], sh[1][c], sh[2][c]);
                if (y < kDeluxeSide - 1) {
                    EXPECT_GT(glm::dot(glm::normalize(band1), glm::normalize(directionOf(x, y))), 1 - 1e-6);
                } else {
                    EXPECT_EQ(band1, dvec3(0));
                }
            }
    RecordProperty("largest", fmt::format("{:.2g}", largest));
    EXPECT_LT(largest, 0.16) << "of the light's own strength: what order 2 leaves of a clamped cosine";
}

/// A light from straight above: the shader keeps a quarter as even light, so that a normal across the light is not black.
TEST(Deluxe, AQuarterOfTheLightIsEven) {
    const TemporaryFolder folder;
    writePng(folder / "room.png", kDeluxeSide, kDeluxeSide, 3, [](int, int, int) { return 255; });
    writePng(folder / "room_deluxe.png", kDeluxeSide, kDeluxeSide, 3, [](int c, int, int) { return c == 1 ? 255 : 128; });
    writeSquare(folder / "square.glb", {});
    const lighting::ShRgb sh = readAll(folder / "room.png", description(folder)).sh.at(3, 3);
    EXPECT_NEAR(shownBySh(sh, 0, kNormal), 1, 1e-5);
    // Nine coefficients of a light of strength 3/4 over 17/16 show 3/32 of it across, beside the quarter.
    EXPECT_NEAR(shownBySh(sh, 0, dvec3(1, 0, 0)), 0.25 + 0.75 * 16 / 17 * 3 / 32, 3e-3);
}

TEST(Deluxe, EitherFileOfAPairNamesBoth) {
    const TemporaryFolder folder;
    writePng(folder / "room.png", kDeluxeSide, kDeluxeSide, 3, lightAt);
    writePng(folder / "room_deluxe.png", kDeluxeSide, kDeluxeSide, 3, directionAt);
    writeSquare(folder / "square.glb", {});
    EXPECT_EQ(leadingFile(folder / "room_deluxe.png", kAutoBake), folder / "room.png");
    const auto named = LightMapReader::open(folder / "room_deluxe.png", description(folder));
    ASSERT_TRUE(named) << named.error().line();
    EXPECT_EQ(named->bake(), "deluxe") << "directions are no light";
    EXPECT_EQ(readAll(folder / "room_deluxe.png", description(folder)).sh.at(3, 3),
              readAll(folder / "room.png", description(folder)).sh.at(3, 3));
    std::filesystem::remove(folder / "room.png");
    const auto alone = LightMapReader::open(folder / "room_deluxe.png", description(folder));
    ASSERT_TRUE(alone) << alone.error().line();
    EXPECT_THAT(alone->recognition().incompleteSets, testing::ElementsAre(HasSubstr("room (.exr, .hdr, .tga or .png) is missing")));
}

TEST(Deluxe, NamesInCapitalsAreAPairToo) {
    const TemporaryFolder folder;
    writePng(folder / "ROOM.PNG", kDeluxeSide, kDeluxeSide, 3, lightAt);
    writePng(folder / "ROOM_DELUXE.PNG", kDeluxeSide, kDeluxeSide, 3, directionAt);
    writeSquare(folder / "square.glb", {});
    for (const char* file : {"ROOM.PNG", "ROOM_DELUXE.PNG"}) {
        const auto reader = LightMapReader::open(folder / file, description(folder));
        ASSERT_TRUE(reader) << reader.error().line();
        EXPECT_EQ(reader->bake(), "deluxe") << file;
        EXPECT_EQ(nameOfBake(leadingFile(folder / file, kAutoBake), "deluxe"), "ROOM");
    }
}

TEST(Deluxe, PagesAreReadOnlyWhereTheSceneNamesTheFormat) {
    const TemporaryFolder folder;
    writePng(folder / "lm_0002.png", kDeluxeSide, kDeluxeSide, 3, lightAt);
    writePng(folder / "lm_0003.png", kDeluxeSide, kDeluxeSide, 3, directionAt);
    writeSquare(folder / "square.glb", {});
    const auto plain = LightMapReader::open(folder / "lm_0002.png", description(folder));
    ASSERT_TRUE(plain) << plain.error().line();
    EXPECT_EQ(plain->bake(), "flat");
    const auto pages = LightMapReader::open(folder / "lm_0002.png", description(folder, "deluxe"));
    ASSERT_TRUE(pages) << pages.error().line();
    EXPECT_EQ(pages->bake(), "deluxe");
    EXPECT_EQ(pages->recognition().evidence, "the 2 files lm_0002.png to lm_0003.png, as named");
    const LightMapStrip byOther = readAll(folder / "lm_0003.png", description(folder, "deluxe"));
    EXPECT_EQ(byOther.sh.at(3, 3), readAll(folder / "lm_0002.png", description(folder, "deluxe")).sh.at(3, 3)) << "either page names both";
    EXPECT_EQ(leadingFile(folder / "lm_0003.png", kAutoBake), folder / "lm_0003.png") << "it may be a page of light";
    writePng(folder / "alone.png", kDeluxeSide, kDeluxeSide, 3, lightAt);
    EXPECT_THAT(refusal(folder / "alone.png", description(folder, "deluxe")).line(),
                HasSubstr("alone.png: found 1 of the 2 files of bake format deluxe, alone_deluxe (.exr, .hdr, .tga or .png) is missing"));
    std::filesystem::remove(folder / "lm_0003.png");
    EXPECT_THAT(refusal(folder / "lm_0002.png", description(folder, "deluxe")).line(),
                HasSubstr("found 1 of the 2 files of bake format deluxe, lm_0003.png is missing, expected it in the same folder"));
    EXPECT_EQ(LightMapReader::open(folder / "lm_0002.png", description(folder))->recognition().incompleteSets, std::vector<std::string>());
}

TEST(Deluxe, ThePairMayHaveTwoKindsOfFiles) {
    const TemporaryFolder folder;
    ExrRecipe light;
    light.width = light.height = kDeluxeSide;
    for (const char* colour : {"R", "G", "B"}) light.channels[colour] = [](int, int) { return 0.5f; };
    writeRecipe(folder / "room.exr", light);
    writePng(folder / "room_deluxe.png", kDeluxeSide, kDeluxeSide, 3, directionAt);
    writeSquare(folder / "square.glb", {});
    LightMapDescription named = description(folder);
    named.encoding = LightEncoding::None;
    for (const char* file : {"room.exr", "room_deluxe.png"}) {
        const auto reader = LightMapReader::open(folder / file, named);
        ASSERT_TRUE(reader) << reader.error().line();
        EXPECT_EQ(reader->bake(), "deluxe") << file;
        EXPECT_EQ(reader->recognition().evidence, "the 2 files room.exr to room_deluxe.png");
    }
}

TEST(Deluxe, DirectionsThatAreNoNumbersAreNamed) {
    const TemporaryFolder folder;
    const auto picture = [](const ByteValue& bytes) {
        ExrRecipe recipe;
        recipe.width = recipe.height = kDeluxeSide;
        for (int c = 0; c < 3; ++c)
            recipe.channels[std::string(1, "RGB"[c])] = [c, bytes](int x, int y) { return static_cast<float>(bytes(c, x, y)) / 255; };
        return recipe;
    };
    writeRecipe(folder / "room.exr", picture(lightAt));
    ExrRecipe directions = picture(directionAt);
    poke(directions, "B", 3, 4, std::numeric_limits<float>::quiet_NaN());
    writeRecipe(folder / "room_deluxe.exr", directions);
    writeSquare(folder / "square.glb", {});
    LightMapDescription named = description(folder);
    named.encoding = LightEncoding::None;
    const Error error = refusal(folder / "room.exr", named);
    EXPECT_EQ(error.code, ErrorCode::ValueNotFinite);
    EXPECT_THAT(error.line(), HasSubstr("room_deluxe.exr, channel B, texel (3, 4): found nan"));
}

}  // namespace
}  // namespace lightcook::formats

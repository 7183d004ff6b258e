#include "formats/bakes/flat.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <string>

#include "tests/formats/light_map_fixture.h"
#include "tests/formats/surface_fixture.h"

namespace lightcook::formats {
namespace {

using lighting::ShRgb;
using testing::AllOf;
using testing::HasSubstr;

/// A picture of seeded light between 1 and 3.
ExrRecipe picture(int width, int height) {
    ExrRecipe recipe;
    recipe.width = width;
    recipe.height = height;
    for (int c = 0; c < 3; ++c) recipe.channels[std::string(1, "RGB"[c])] = [c](int x, int y) { return seededSh(0, c, x, y); };
    return recipe;
}

/// Exit radiance of a white surface under radiance SH, written out: (1/pi) sum of A_l lambda_i Y_i(n) with A = pi, 2 pi/3, pi/4.
double exitRadiance(const ShRgb& sh, int c, const glm::dvec3& n) {
    const auto at = [&](std::size_t i) { return static_cast<double>(sh[i][c]); };
    const double a = std::sqrt(3 / (4 * std::numbers::pi)), b = std::sqrt(15 / std::numbers::pi) / 2;
    const double linear = a * (at(1) * n.y + at(2) * n.z + at(3) * n.x);
    const double quadratic = b * (at(4) * n.x * n.y + at(5) * n.y * n.z + at(7) * n.x * n.z) +
                             std::sqrt(5 / std::numbers::pi) / 4 * at(6) * (3 * n.z * n.z - 1) + b / 2 * at(8) * (n.x * n.x - n.y * n.y);
    return at(0) / std::sqrt(4 * std::numbers::pi) + 2.0 / 3 * linear + quadratic / 4;
}

/// The square covers 10.5 x 35 texels of 20 x 70: of the last column half of each texel.
TEST(Flat, CoverageAndNormalsAreThoseOfTheMeshIfAsked) {
    const MapFile map(picture(20, 70));
    const TemporaryFolder folder;
    writeSquare(folder / "square.glb", {.lightMap = {10.5f / 20, 0.5f}});
    LightMapDescription description;
    description.coverage = CoverageSource::Mesh;
    description.mesh = folder / "square.glb";
    const LightMapStrip strip = readAll(map.path, description);
    int covered = 0;
    for (int y = 0; y < 70; ++y)
        for (int x = 0; x < 20; ++x) {
            ASSERT_EQ(strip.covered.at(x, y), x <= 10 && y < 35 ? 1 : 0)
                << x << ' ' << y << ": a texel that is only touched is not covered";
            covered += strip.covered.at(x, y);
            if (strip.covered.at(x, y) != 0) {
                ASSERT_EQ(strip.normal.at(x, y), glm::vec3(0, 1, 0));
            }
        }
    EXPECT_EQ(covered, 11 * 35);
    const auto reader = LightMapReader::open(map.path, description);
    ASSERT_TRUE(reader);
    EXPECT_TRUE(reader->hasCoverage());
    EXPECT_TRUE(reader->hasNormals());
    // Strips are those of the whole.
    const auto part = reader->read(32, 5);
    ASSERT_TRUE(part);
    for (int y = 0; y < 5; ++y)
        for (int x = 0; x < 20; ++x) EXPECT_EQ(part->covered.at(x, y), strip.covered.at(x, 32 + y));
}

TEST(Flat, TheFilesOwnNormalsStayBesideCoverageOfTheMesh) {
    ExrRecipe recipe = picture(8, 8);
    for (const char* channel : {"normal.X", "normal.Y"}) recipe.channels[channel] = [](int, int) { return 0.0f; };
    recipe.channels["normal.Z"] = [](int, int) { return 1.0f; };
    recipe.channels["coverage.Y"] = [](int x, int) { return x < 2 ? 1.0f : 0.0f; };
    const MapFile map(recipe);
    const TemporaryFolder folder;
    writeSquare(folder / "square.glb", {.lightMap = {0.5f, 1}});
    LightMapDescription description;
    description.coverage = CoverageSource::Mesh;
    description.mesh = folder / "square.glb";
    const LightMapStrip strip = readAll(map.path, description);
    for (int x = 0; x < 8; ++x) EXPECT_EQ(strip.covered.at(x, 3), x < 4 ? 1 : 0) << "the mesh says so, not the file";
    EXPECT_EQ(strip.normal.at(1, 1), glm::vec3(0, 0, 1));
}

TEST(Flat, NormalsAreThoseOfTheMeshIfTheFileHasNone) {
    ExrRecipe recipe = picture(16, 8);
    recipe.channels["coverage.Y"] = [](int x, int) { return x < 14 ? 1.0f : 0.0f; };
    const MapFile map(recipe);
    const TemporaryFolder folder;
    writeSquare(folder / "square.glb", {.lightMap = {0.5f, 1}});
    LightMapDescription description;
    description.mesh = folder / "square.glb";
    const LightMapStrip strip = readAll(map.path, description);
    const glm::vec3 up(0, 1, 0), unknown(0, 0, 1);
    for (int x = 0; x < 16; ++x) {
        EXPECT_EQ(strip.covered.at(x, 3), x < 14 ? 1 : 0) << "the file says so";
        EXPECT_EQ(strip.normal.at(x, 3), x < 12 ? up : unknown) << x << ": the square ends at 8, and its light may grow by 4 texels";
    }
    const auto reader = LightMapReader::open(map.path, description);
    ASSERT_TRUE(reader);
    EXPECT_TRUE(reader->hasNormals());
    EXPECT_FALSE(LightMapReader::open(map.path, {})->hasNormals());
    // The normal of the triangle stands in for one of zero.
    writeSquare(folder / "bare.glb", {.lightMap = {0.5f, 1}, .hasNormals = false});
    description.mesh = folder / "bare.glb";
    const LightMapStrip bare = readAll(map.path, description);
    for (int x = 0; x < 12; ++x) EXPECT_EQ(bare.normal.at(x, 3), up) << x;
}

TEST(Flat, CoverageOfAMeshNeedsOne) {
    const MapFile map(picture(8, 8));
    LightMapDescription description;
    description.coverage = CoverageSource::Mesh;
    const auto refused = LightMapReader::open(map.path, description);
    ASSERT_FALSE(refused);
    EXPECT_THAT(refused.error().line(), HasSubstr("found coverage \"mesh\" without a mesh"));
}

TEST(Flat, ATexelShadesToItsValueAtEveryNormal) {
    for (const ShQuantity quantity : {ShQuantity::Radiance, ShQuantity::Irradiance}) {
        const MapFile map(picture(20, 70));
        LightMapDescription description;
        description.quantity = quantity;
        const LightMapStrip strip = readAll(map.path, description);
        ASSERT_EQ(strip.sh.height(), 70);
        for (int y = 0; y < 70; ++y)
            for (int x = 0; x < 20; ++x) {
                ASSERT_EQ(strip.covered.at(x, y), 1);
                for (std::size_t i = 1; i < 9; ++i) ASSERT_EQ(strip.sh.at(x, y)[i], glm::vec3(0));
                for (const glm::dvec3& normal : kShadedNormals)
                    for (int c = 0; c < 3; ++c) {
                        const double stored = static_cast<double>(seededSh(0, c, x, y));
                        const double shown = quantity == ShQuantity::Irradiance ? stored / std::numbers::pi : stored;
                        ASSERT_NEAR(exitRadiance(strip.sh.at(x, y), c, normal), shown, 1e-6 * shown);
                    }
            }
    }
}

TEST(Flat, APictureIsRecognisedWithoutAKey) {
    const MapFile map(picture(16, 16));
    const auto reader = LightMapReader::open(map.path, {});
    ASSERT_TRUE(reader) << reader.error().line();
    EXPECT_EQ(reader->bake(), "flat");
    EXPECT_EQ(reader->recognition().evidence, "a picture of 16 x 16 texels");
    EXPECT_THAT(std::string(reader->recognition().format->assumes), HasSubstr("E / pi"));
    EXPECT_FALSE(reader->hasCoverage());
}

TEST(Flat, CoverageIsThatOfTheFileElseAlpha) {
    ExrRecipe recipe = picture(8, 8);
    recipe.channels["A"] = [](int x, int) { return x < 3 ? 0.0f : 1.0f; };
    for (int round = 0; round < 2; ++round) {
        const MapFile map(recipe);
        const LightMapStrip strip = readAll(map.path);
        for (int y = 0; y < 8; ++y)
            for (int x = 0; x < 8; ++x) EXPECT_EQ(strip.covered.at(x, y), round == 0 ? x >= 3 : y >= 4);
        recipe.channels["coverage.Y"] = [](int, int y) { return y < 4 ? 0.0f : 1.0f; };
    }
}

TEST(Flat, NormalsOfTheFileAreKept) {
    ExrRecipe recipe = picture(4, 4);
    for (const char axis : {'X', 'Y', 'Z'}) recipe.channels[std::string("normal.") + axis] = [axis](int, int) { return axis == 'Y'; };
    EXPECT_EQ(readAll(MapFile(recipe).path).normal.at(1, 1), glm::vec3(0, 1, 0));
}

TEST(Flat, ARadiancePictureIsReadAsItsTexels) {
    const TemporaryFolder folder;
    // One texel (1, 0.5, 0.25) and one (2, 1, 0.5): mantissas 128, 64, 32 with exponents 129 and 130.
    std::string bytes = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n";
    for (const int value : {128, 64, 32, 129, 128, 64, 32, 130}) bytes += static_cast<char>(value);
    writeContent(folder / "room.hdr", bytes);
    const LightMapStrip strip = readAll(folder / "room.hdr");
    ASSERT_EQ(strip.sh.width(), 2);
    const double colours[3] = {1, 0.5, 0.25};
    for (int x = 0; x < 2; ++x)
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(exitRadiance(strip.sh.at(x, 0), c, kShadedNormals[0]), (x + 1) * colours[c], 1e-6);
}

TEST(Flat, AStripOfSixFacesIsReadOnlyIfNamed) {
    const MapFile map(picture(4, 24));
    const Error error = refusal(map.path);
    EXPECT_EQ(error.code, ErrorCode::UnknownBake);
    EXPECT_THAT(error.line(), AllOf(HasSubstr("it holds R, G, B"), HasSubstr("The six faces of a probe?"), HasSubstr("bake = \"flat\"")));
    LightMapDescription description;
    description.bake = "flat";
    EXPECT_EQ(readAll(map.path, description).sh.height(), 24);
}

TEST(Flat, ValuesThatAreNoLightAreNamed) {
    for (const auto& [value, code] :
         {std::pair(std::numeric_limits<float>::quiet_NaN(), ErrorCode::ValueNotFinite), std::pair(-1.0f, ErrorCode::ValueOutOfRange)}) {
        ExrRecipe recipe = picture(8, 8);
        poke(recipe, "G", 3, 4, value);
        const Error error = refusal(MapFile(recipe).path);
        EXPECT_EQ(error.code, code);
        EXPECT_THAT(error.line(), HasSubstr(fmt::format("channel G, texel (3, 4): found {}, expected", value))) << "as the file has it";
    }
}

TEST(Flat, CoverageThatIsNoNumberIsNamedByItsChannel) {
    for (const char* channel : {"A", "coverage.Y"}) {
        ExrRecipe recipe = picture(8, 8);
        recipe.channels[channel] = [](int, int) { return 1.0f; };
        poke(recipe, channel, 3, 4, std::numeric_limits<float>::quiet_NaN());
        EXPECT_THAT(refusal(MapFile(recipe).path).line(), HasSubstr(fmt::format("map.exr, channel {}, texel (3, 4): found nan", channel)));
    }
}

TEST(Flat, TheMapOfAnEngineIsReadWhole) {
    const std::filesystem::path file =
        std::filesystem::path(LIGHTCOOK_SHARED_DATA) / "engine_lightmaps" / "godot_ragdoll_physics_lightmap.exr";
    if (!std::filesystem::exists(file)) GTEST_SKIP() << "needs the shared test data at " << LIGHTCOOK_SHARED_DATA;
    const auto reader = LightMapReader::open(file, {});
    ASSERT_TRUE(reader) << reader.error().line();
    EXPECT_EQ(reader->bake(), "flat");
    const auto strip = reader->read(0, 64);
    ASSERT_TRUE(strip) << strip.error().line();
    EXPECT_EQ(strip->sh.width(), 2048);
}

}  // namespace
}  // namespace lightcook::formats

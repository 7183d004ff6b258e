#include "formats/bakes/godot.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/gtc/packing.hpp>
#include <limits>
#include <numbers>
#include <string>

#include "tests/formats/light_map_fixture.h"
#include "tests/formats/lmbake_fixture.h"

namespace lightcook::formats {
namespace {

using lighting::ShRgb;
using testing::AllOf;
using testing::HasSubstr;

/// One colour of a texel as the engine bakes it: L0 and the vector L1.
struct Baked {
    double first;
    glm::dvec3 linear;
};
using BakedTexel = std::function<Baked(int colour, int x, int y)>;

/// Light of changing strength and direction.
Baked seededLight(int c, int x, int y) {
    const auto seed = [&](int i) { return static_cast<double>(seededSh(i, c, x, y)); };
    const double first = 0.05 + 2 * (seed(0) - 1);
    return {first, glm::normalize(glm::dvec3(seed(1) + 1.5, seed(2), seed(3))) * first * (1.9 + 2 * seed(4))};
}

float asHalf(double value) {
    return glm::unpackHalf1x16(glm::packHalf1x16(static_cast<float>(value)));
}

/// The picture that the engine saves: slices L0, y, z, x of each page, one below the other. Packs as its shader does.
ExrRecipe stacked(int width, int sliceHeight, const BakedTexel& texel, int pages = 1) {
    ExrRecipe recipe;
    recipe.width = width;
    recipe.height = 4 * pages * sliceHeight;
    recipe.isHalf = true;
    for (int c = 0; c < 3; ++c)
        recipe.channels[std::string(1, "RGB"[c])] = [=](int x, int y) {
            const int page = y / (4 * sliceHeight), slice = y / sliceHeight % 4;
            const Baked baked = texel(c, x, page * sliceHeight + y % sliceHeight);
            if (slice == 0) return asHalf(baked.first);
            const double component = slice == 1 ? baked.linear.y : slice == 2 ? baked.linear.z : baked.linear.x;
            return asHalf(std::clamp(component / (8 * baked.first + 1e-6) + 0.5, 0.0, 1.0));
        };
    return recipe;
}

LightMapDescription named(const std::string& bake) {
    LightMapDescription description;
    description.bake = bake;
    return description;
}

void writeImport(const std::filesystem::path& file, int slices, int columns = 1) {
    writeContent(file.string() + ".import",
                 fmt::format("[remap]\n\nimporter=\"2d_array_texture\"\ntype=\"CompressedTexture2DArray\"\n\n[params]"
                             "\n\nslices/horizontal={}\nslices/vertical={}\n",
                             columns, slices));
}

TEST(Godot, ATexelShadesAsTheEngineShowsIt) {
    constexpr int kWidth = 20, kHeight = 70;
    const ExrRecipe recipe = stacked(kWidth, kHeight, seededLight);
    const MapFile map(recipe);
    const LightMapStrip strip = readAll(map.path, named("godot"));
    ASSERT_EQ(strip.sh.width(), kWidth);
    ASSERT_EQ(strip.sh.height(), kHeight);
    double largest = 0;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
            for (int c = 0; c < 3; ++c) {
                // The engine's own decode.
                const auto& stored = recipe.channels.at(std::string(1, "RGB"[c]));
                const auto slice = [&](int index) { return static_cast<double>(stored(x, y + index * kHeight)); };
                for (const glm::dvec3& n : kShadedNormals) {
                    const double shown =
                        slice(0) * (1 + 4 * ((2 * slice(1) - 1) * n.y + (2 * slice(2) - 1) * n.z + (2 * slice(3) - 1) * n.x));
                    largest = std::max(largest, std::abs(exitRadianceOfOrder1(strip.sh.at(x, y), c, n) - shown));
                }
                for (std::size_t i = 4; i < 9; ++i) ASSERT_EQ(strip.sh.at(x, y)[i][c], 0);
            }
    EXPECT_LT(largest, 1e-5) << "of light up to 4";
}

TEST(Godot, UniformLightOfTheHemisphereIsReadAsThatLight) {
    // The engine's sums for radiance 0.6 from the upper hemisphere of n: 1/4 and 2/3 n. Its projection has lambda_0 = sqrt(pi) 0.6 and
    // lambda_1 = (1/2) sqrt(3 pi) 0.6 n.
    const glm::dvec3 n = glm::normalize(glm::dvec3(1, -2, 2));
    const MapFile map(stacked(8, 8, [&](int, int, int) { return Baked{0.6 / 4, 0.6 * 2 / 3 * n}; }));
    const LightMapStrip strip = readAll(map.path, named("godot-radiance"));
    const ShRgb& sh = strip.sh.at(3, 5);
    const double linear = std::sqrt(3 * std::numbers::pi) / 2 * 0.6;
    EXPECT_NEAR(sh[0].g, std::sqrt(std::numbers::pi) * 0.6, 1e-3);
    EXPECT_NEAR(sh[1].g, linear * n.y, 2e-3);
    EXPECT_NEAR(sh[2].g, linear * n.z, 2e-3);
    EXPECT_NEAR(sh[3].g, linear * n.x, 2e-3);
    // Read as shown it is 0.917, as in the engine.
    const LightMapStrip shown = readAll(map.path, named("godot"));
    EXPECT_NEAR(exitRadianceOfOrder1(shown.sh.at(3, 5), 1, n), 0.6 * (0.25 + 2.0 / 3), 2e-3);
}

TEST(Godot, ImportSettingsNameTheSlicesAndPagesFollowEachOther) {
    constexpr int kWidth = 12, kHeight = 10, kPages = 3;
    const MapFile map(stacked(kWidth, kHeight, seededLight, kPages));
    writeImport(map.path, 4 * kPages);
    const auto reader = LightMapReader::open(map.path, {});
    ASSERT_TRUE(reader) << reader.error().line();
    EXPECT_EQ(reader->bake(), "godot");
    EXPECT_EQ(reader->recognition().evidence, "slices/vertical=12 in map.exr.import");
    EXPECT_THAT(reader->recognition().otherReadings, testing::Contains("godot-radiance"));
    EXPECT_THAT(bakeFilesBeside(map.path, kAutoBake), testing::ElementsAre(map.path.string() + ".import"));
    const LightMapStrip whole = readAll(map.path);
    ASSERT_EQ(whole.sh.height(), kHeight * kPages);
    for (int y = 0; y < kHeight * kPages; ++y)
        for (int x = 0; x < kWidth; ++x)
            ASSERT_NEAR(exitRadianceOfOrder1(whole.sh.at(x, y), 1, kShadedNormals[3]),
                        seededLight(1, x, y).first + glm::dot(seededLight(1, x, y).linear, kShadedNormals[3]), 4e-3 * 4);
    for (const auto& [first, count] : {std::pair(0, 1), {9, 2}, {5, 20}, {29, 1}}) {
        const auto strip = reader->read(first, count);
        ASSERT_TRUE(strip) << strip.error().line();
        for (int y = 0; y < count; ++y)
            for (int x = 0; x < kWidth; ++x) ASSERT_EQ(strip->sh.at(x, y), whole.sh.at(x, first + y));
    }
}

TEST(Godot, AStoredDigestIsThatOfEachSliceOfItsRows) {
    constexpr int kWidth = 8, kSlice = 40, kStrip = 16;
    const TemporaryFolder folder;
    const auto file = folder / "map.exr";
    ExrRecipe recipe = stacked(kWidth, kSlice, seededLight, 2);
    writeImport(file, 8);
    struct Strips {
        std::vector<std::vector<ShRgb>> texels;
        std::vector<std::string> digests;
    };
    const auto strips = [&] {
        Strips out;
        writeRecipe(file, recipe);
        const auto reader = LightMapReader::open(file, named("godot"));
        EXPECT_TRUE(reader) << reader.error().line();
        for (int row = 0; row < reader->height(); row += kStrip) {
            const int count = std::min(kStrip, reader->height() - row);
            out.texels.push_back(reader->read(row, count)->sh.texels());
            out.digests.push_back(reader->storedDigest(row, count).value_or(""));
            EXPECT_FALSE(out.digests.back().empty());
        }
        return out;
    };
    const Strips before = strips();
    ASSERT_EQ(before.digests.size(), 2 * kSlice / kStrip);
    for (int row = 3; row < recipe.height; row += 13) {  // of every slice of both pages
        const auto red = recipe.channels["R"];
        poke(recipe, "R", 2, row, asHalf(red(2, row) * 0.9));
        const Strips after = strips();
        int changed = 0;
        for (std::size_t i = 0; i < after.digests.size(); ++i) {
            if (after.texels[i] == before.texels[i]) continue;
            ++changed;
            EXPECT_NE(after.digests[i], before.digests[i]) << "row " << row << " of the file, strip " << i;
        }
        EXPECT_EQ(changed, 1);
        recipe.channels["R"] = red;
    }
}

TEST(Godot, AlphaIsCoverage) {
    ExrRecipe recipe = stacked(8, 8, seededLight);
    recipe.channels["A"] = [](int x, int y) { return y < 8 && x < 3 ? 0.0f : 1.0f; };
    const LightMapStrip strip = readAll(MapFile(recipe).path, named("godot"));
    for (int x = 0; x < 8; ++x) EXPECT_EQ(strip.covered.at(x, 4), x >= 3);
}

TEST(Godot, AStackOfSquaresThatNothingNamesIsAChoice) {
    const MapFile map(stacked(8, 8, seededLight));
    const Error error = refusal(map.path);
    EXPECT_EQ(error.code, ErrorCode::WrongShape);
    EXPECT_THAT(error.line(), AllOf(HasSubstr("could be flat (a picture of 8 x 32 texels) or godot (four slices of 8 x 8 texels)"),
                                    HasSubstr("bake = \"flat\" or bake = \"godot\" or bake = \"godot-radiance\"")));
    EXPECT_EQ(readAll(map.path, named("flat")).sh.height(), 32);
    EXPECT_EQ(readAll(map.path, named("godot")).sh.height(), 8);
}

TEST(Godot, AStackOfSquaresThatItsImportSettingsCallOneSliceIsFlat) {
    const MapFile map(stacked(8, 8, seededLight));
    writeImport(map.path, 1);
    const auto reader = LightMapReader::open(map.path, {});
    ASSERT_TRUE(reader) << reader.error().line();
    EXPECT_EQ(reader->bake(), "flat");
    EXPECT_THAT(reader->recognition().otherReadings, testing::IsEmpty()) << "godot would be refused";
    EXPECT_THAT(refusal(map.path, named("godot")).line(), HasSubstr("found slices/vertical=1, expected a multiple of 4"));
}

TEST(Godot, OtherShapesAndFlatPagesAreRefused) {
    ExrRecipe recipe = stacked(8, 8, seededLight);
    recipe.height = 30;
    EXPECT_THAT(refusal(MapFile(recipe).path, named("godot")).line(), HasSubstr("found a height of 30 texels, expected a multiple of 4"));
    const MapFile imported(stacked(8, 8, seededLight));
    writeImport(imported.path, 6);
    EXPECT_THAT(refusal(imported.path, named("godot")).line(), AllOf(HasSubstr("map.exr.import"), HasSubstr("slices/vertical=6")));
    writeImport(imported.path, 4, 2);
    EXPECT_THAT(refusal(imported.path).line(), HasSubstr("map.exr.import: found slices/horizontal=2, expected 1"));
    writeImport(imported.path, 12);
    EXPECT_THAT(refusal(imported.path).line(), HasSubstr("found a height of 32 texels, expected a multiple of 12"));
    // Four pages of dark flat light.
    ExrRecipe pages = stacked(8, 8, seededLight);
    for (auto& [name, value] : pages.channels) value = [](int x, int y) { return 0.01f * static_cast<float>(1 + (x + y) % 5); };
    const MapFile flat(pages);
    writeImport(flat.path, 4);
    const Error error = refusal(flat.path);
    EXPECT_EQ(error.code, ErrorCode::WrongShape);
    EXPECT_THAT(error.line(), AllOf(HasSubstr("slices 2 to 4 that differ from 0.5 by 0.47 on average"), HasSubstr("bake = \"flat\"")));
}

/// Import settings of four flat slices are those of one directional page.
TEST(Godot, FlatPagesOfMiddlingLightAreRefused) {
    ExrRecipe pages = stacked(8, 8, seededLight);
    for (auto& [name, value] : pages.channels)
        value = [](int x, int y) { return x == 0 ? 0.25f : 0.85f + 0.01f * static_cast<float>((x + y) % 5); };
    const MapFile bright(pages);
    writeImport(bright.path, 4);
    EXPECT_THAT(refusal(bright.path).line(), AllOf(HasSubstr("found slices 2 to 4"), HasSubstr("Flat pages?")));
    // Pages whose light is near 0.5, and dark in the first page alone.
    for (auto& [name, value] : pages.channels) value = [](int x, int y) { return y < 8 && x < 4 ? 0.0f : 0.3f; };
    const MapFile even(pages);
    writeImport(even.path, 4);
    EXPECT_THAT(refusal(even.path).line(),
                HasSubstr("found slices 2 to 4 that are not 0.5 in 100 % of the texels without light in slice 1"));
}

/// Godot 4.0 to 4.3 stores L1 itself.
TEST(Godot, ABakeOfAnOlderGodotIsToBeBakedAgain) {
    ExrRecipe old = stacked(8, 8, seededLight);
    for (int c = 0; c < 3; ++c)
        old.channels[std::string(1, "RGB"[c])] = [c](int x, int y) {
            const Baked baked = seededLight(c, x, y % 8);
            return asHalf(y < 8 ? baked.first : y < 16 ? baked.linear.y : y < 24 ? baked.linear.z : baked.linear.x);
        };
    const MapFile map(old);
    writeImport(map.path, 4);
    EXPECT_THAT(refusal(map.path).line(), AllOf(HasSubstr("found slices 2 to 4"), HasSubstr("Bake it again with Godot 4.4 or later")));
    GodotBake bake{.meshes = {{{"..", "Wall"}, 0, 0, 1, 1, 0}}, .isPacked = false, .minor = 3};
    bake.write(map.folder / "map.lmbake");
    const Error error = refusal(map.path);
    EXPECT_EQ(error.code, ErrorCode::FormatUnsupported);
    EXPECT_THAT(error.line(), AllOf(HasSubstr("map.lmbake: found a directional bake without _uses_packed_directional"),
                                    HasSubstr("bake map.exr again with it")));
    // Also where the values could be packed ones.
    writeRecipe(map.path, stacked(8, 8, seededLight));
    EXPECT_THAT(refusal(map.path).line(), HasSubstr("_uses_packed_directional"));
    bake.minor = 4;
    bake.write(map.folder / "map.lmbake");
    EXPECT_EQ(readAll(map.path).sh.height(), 8) << "the values tell";
}

TEST(Godot, PagesOfSquaresThatNothingNamesAreAChoice) {
    const MapFile map(stacked(8, 8, seededLight, 2));
    EXPECT_THAT(refusal(map.path).line(), HasSubstr("could be flat (a picture of 8 x 64 texels) or godot (8 slices of 8 x 8 texels)"));
    EXPECT_EQ(readAll(map.path, named("godot")).sh.height(), 16);
}

TEST(Godot, ValuesThatAreNoLightAndOtherQuantitiesAreRefused) {
    for (const int row : {4, 12}) {  // of L0, of y
        ExrRecipe recipe = stacked(8, 8, seededLight);
        poke(recipe, "B", 3, row, std::numeric_limits<float>::quiet_NaN());
        const Error error = refusal(MapFile(recipe).path, named("godot"));
        EXPECT_EQ(error.code, ErrorCode::ValueNotFinite) << error.line();
        EXPECT_THAT(error.line(), HasSubstr(fmt::format("channel B, texel (3, {})", row)));
    }
    LightMapDescription description = named("godot");
    description.quantity = ShQuantity::Irradiance;
    const Error error = refusal(MapFile(stacked(8, 8, seededLight)).path, description);
    EXPECT_EQ(error.code, ErrorCode::InvalidRequest);
    EXPECT_THAT(error.line(), HasSubstr("bake format godot implies"));
}

}  // namespace
}  // namespace lightcook::formats

// Bakes with an image for each coefficient, and bakes of bands 0 and 1 alone.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/bakes/sh9.h"
#include "tests/formats/light_map_fixture.h"
#include "tests/formats/picture_fixture.h"

namespace lightcook::formats {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr int kFilesWidth = 20, kFilesHeight = 9;

/// A folder with an image for each coefficient of a seeded map, and one for each colour of them.
class Images {
public:
    Images() {
        for (int index = 0; index < 9; ++index) {
            ExrRecipe whole = recipeOf({});
            for (int c = 0; c < 3; ++c) {
                const ChannelValue value = [index, c](int x, int y) { return seededSh(index, c, x, y); };
                whole.channels[std::string(1, "RGB"[c])] = value;
                writeRecipe(folder_ / fmt::format("{}_{}.exr", index, "rgb"[c]), recipeOf({{"Y", value}}));
            }
            writeRecipe(folder_ / fmt::format("{}.exr", index), whole);
        }
    }

    std::filesystem::path operator/(const std::string& name) const { return folder_ / name; }
    static ExrRecipe recipeOf(std::map<std::string, ChannelValue> channels) {
        ExrRecipe recipe;
        recipe.width = kFilesWidth;
        recipe.height = kFilesHeight;
        recipe.channels = std::move(channels);
        return recipe;
    }

    /// Describes the first coefficients.
    /// splitFrom  coefficients from this one on have an image for each colour
    LightMapDescription describe(int count, int splitFrom) const {
        LightMapDescription description;
        for (int index = 0; index < count; ++index) {
            if (index < splitFrom) description.partFiles[fmt::format("sh{:02}", index)] = folder_ / fmt::format("{}.exr", index);
            for (int c = 0; c < 3 && index >= splitFrom; ++c)
                description.partFiles[fmt::format("sh{:02}.{}", index, "RGB"[c])] = folder_ / fmt::format("{}_{}.exr", index, "rgb"[c]);
        }
        for (const auto& [name, file] : description.partFiles) description.parts.push_back(name);
        return description;
    }

private:
    TemporaryFolder folder_;
};

TEST(CoefficientFiles, HoldTheSameNumbersAsOneFile) {
    const Images images;
    for (const int count : {4, 9})
        for (const int splitFrom : {0, 2, count}) {
            const LightMapDescription description = images.describe(count, splitFrom);
            const auto reader = LightMapReader::open(images / "0.exr", description);
            ASSERT_TRUE(reader) << reader.error().line();
            EXPECT_EQ(reader->bake(), count == 4 ? "sh4" : "sh9");
            EXPECT_THAT(reader->recognition().evidence,
                        HasSubstr(fmt::format("the {} images that the scene lists", description.parts.size())));
            const LightMapStrip strip = readAll(images / "0.exr", description);
            for (int y = 0; y < kFilesHeight; ++y)
                for (int x = 0; x < kFilesWidth; ++x) {
                    lighting::ShRgb expected = seededTexel(x, y);
                    std::fill(expected.begin() + count, expected.end(), glm::vec3(0));
                    ASSERT_EQ(strip.sh.at(x, y), expected) << count << ' ' << splitFrom << ' ' << x << ' ' << y;
                }
        }
}

TEST(CoefficientFiles, TheFirstImageMayHaveCoverageAndNormals) {
    const Images images;
    ExrRecipe first = Images::recipeOf({});
    for (const char colour : {'R', 'G', 'B'}) first.channels[std::string(1, colour)] = [](int, int) { return 1.0f; };
    first.channels["coverage.Y"] = [](int x, int) { return x < 3 ? 1.0f : 0.0f; };
    for (const char axis : {'X', 'Y', 'Z'})
        first.channels[fmt::format("normal.{}", axis)] = [axis](int, int) { return axis == 'X' ? 1.0f : 0.0f; };
    writeRecipe(images / "0.exr", first);
    const LightMapStrip strip = readAll(images / "0.exr", images.describe(4, 4));
    EXPECT_EQ(strip.covered.at(2, 0), 1);
    EXPECT_EQ(strip.covered.at(3, 0), 0);
    EXPECT_EQ(strip.normal.at(0, 0), glm::vec3(1, 0, 0));
}

TEST(CoefficientFiles, TheFirstImageMayStateItsPrimaries) {
    const Images images;
    EXPECT_FALSE(LightMapReader::open(images / "0.exr", images.describe(4, 4))->primaries());
    ExrRecipe first = Images::recipeOf({});
    for (const char colour : {'R', 'G', 'B'}) first.channels[std::string(1, colour)] = [](int, int) { return 1.0f; };
    first.chromaticities = {0.708f, 0.292f, 0.170f, 0.797f, 0.131f, 0.046f, 0.3127f, 0.3290f};
    writeRecipe(images / "0.exr", first);
    const auto reader = LightMapReader::open(images / "0.exr", images.describe(4, 4));
    ASSERT_TRUE(reader) << reader.error().line();
    ASSERT_TRUE(reader->primaries());
    EXPECT_EQ(reader->primaries()->space, "lin_rec2020");
    EXPECT_GT(reader->primaries()->difference, 0.3) << "the description says lin_rec709";
}

TEST(CoefficientFiles, ListsThatNameNoBakeAreRefused) {
    const auto detailOf = [](std::vector<std::string> names) {
        const auto format = bakeFormatOfFiles(names, "scene.toml:5:9");
        EXPECT_FALSE(format);
        EXPECT_EQ(format.error().code, ErrorCode::InvalidRequest);
        return format.error().line();
    };
    EXPECT_THAT(detailOf({}), AllOf(testing::StartsWith("scene.toml:5:9: "), HasSubstr("found no sh00")));
    EXPECT_THAT(detailOf({"sh00", "sh01", "sh2"}), AllOf(HasSubstr("found 'sh2'"), HasSubstr("nearest is 'sh02'")));
    EXPECT_THAT(detailOf({"sh00", "sh01", "sh03"}), HasSubstr("found no sh02, expected sh00 to sh03"));
    EXPECT_THAT(detailOf({"sh00", "sh01", "sh02", "sh03", "sh04"}), HasSubstr("found no sh05"));
    EXPECT_THAT(detailOf({"sh00.R", "sh00.G", "sh01", "sh02", "sh03"}), HasSubstr("found 2 of the colours of sh00"));
    EXPECT_THAT(detailOf({"sh00", "sh00.G", "sh01", "sh02", "sh03"}), HasSubstr("found sh00 beside one of its colours"));
}

TEST(CoefficientFiles, ImagesOfAnotherShapeAreRefused) {
    const Images images;
    LightMapDescription description = images.describe(4, 4);
    description.partFiles["sh02"] = images / "2_r.exr";
    EXPECT_THAT(refusal(images / "0.exr", description).line(), AllOf(HasSubstr("2_r.exr"), HasSubstr("found no channel R")));
    description = images.describe(4, 0);
    description.partFiles["sh02.G"] = images / "2.exr";
    EXPECT_THAT(
        refusal(images / "0.exr", description).line(),
        AllOf(HasSubstr("2.exr"), HasSubstr("found the channels B, G, R, expected one channel"), HasSubstr("Name it as sh02 alone")));
    description = images.describe(4, 4);
    ExrRecipe small = Images::recipeOf({});
    small.width = 5;
    for (const char colour : {'R', 'G', 'B'}) small.channels[std::string(1, colour)] = [](int, int) { return 0.0f; };
    writeRecipe(images / "3.exr", small);
    EXPECT_THAT(refusal(images / "0.exr", description).line(), HasSubstr("3.exr: found 5 x 9 texels, expected 20 x 9 as 0.exr has"));
    std::filesystem::remove(images / "3.exr");
    EXPECT_EQ(refusal(images / "0.exr", description).code, ErrorCode::FileUnreadable);
    description.partFiles["sh03"] = images / "3.png";
    writePng(images / "3.png", kFilesWidth, kFilesHeight, 3, [](int, int, int) { return 128; });
    EXPECT_THAT(refusal(images / "0.exr", description).line(),
                HasSubstr("3.png: found a picture of integers, expected OpenEXR or Radiance HDR: coefficients have no encoding"));
}

TEST(Sh4, IsOneFileOfTwelveChannels) {
    ExrRecipe recipe = seededMap(kFilesWidth, kFilesHeight);
    std::erase_if(recipe.channels, [](const auto& channel) { return channel.first >= "sh04"; });
    const MapFile map(recipe);
    const auto reader = LightMapReader::open(map.path, {});
    ASSERT_TRUE(reader) << reader.error().line();
    EXPECT_EQ(reader->bake(), "sh4");
    EXPECT_EQ(reader->recognition().evidence, "channels sh00.R .. sh03.B");
    const LightMapStrip strip = readAll(map.path);
    EXPECT_EQ(strip.sh.at(7, 5)[3], seededTexel(7, 5)[3]);
    for (std::size_t i = 4; i < 9; ++i) EXPECT_EQ(strip.sh.at(7, 5)[i], glm::vec3(0));
}

TEST(Sh4, AMissingChannelIsNamedByTheNearerFormat) {
    ExrRecipe recipe = seededMap(kFilesWidth, kFilesHeight);
    recipe.channels.erase("sh02.G");
    EXPECT_THAT(refusal(MapFile(recipe).path).detail, HasSubstr("found 26 of the 27 channels of bake format sh9, sh02.G is missing"));
    std::erase_if(recipe.channels, [](const auto& channel) { return channel.first >= "sh04"; });
    EXPECT_THAT(refusal(MapFile(recipe).path).detail, HasSubstr("found 11 of the 12 channels of bake format sh4, sh02.G is missing"));
}

}  // namespace
}  // namespace lightcook::formats

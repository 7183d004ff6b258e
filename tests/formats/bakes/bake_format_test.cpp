#include "formats/bake_format.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/bakes/bake_reader.h"
#include "formats/vocabulary.h"
#include "tests/formats/light_map_fixture.h"

namespace lightcook::formats {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

ExrInfo fileOf(std::vector<std::string> channels) {
    ExrInfo info;
    info.width = info.height = 4;
    info.channels = std::move(channels);
    return info;
}

TEST(BakeFormat, EveryRowIsFoundByItsNameAndByItsChannels) {
    for (const BakeFormatInfo& format : allBakeFormats()) {
        for (const std::string& bake : {std::string(format.name), std::string(kAutoBake)}) {
            const auto found = findBakeFormat(bake, fileOf(format.channels()), "map.exr");
            ASSERT_TRUE(found) << found.error().line();
            EXPECT_EQ((*found)->name, format.name);
        }
        EXPECT_FALSE(format.caption.empty());
        EXPECT_FALSE(format.channelCaption.empty());
        EXPECT_NE(format.name, kAutoBake);
    }
    EXPECT_THAT(bakeNames(), ElementsAre("auto", "sh9"));
}

TEST(BakeFormat, ReaderSaysWhichFormatItChose) {
    const MapFile map(seededMap(4, 4));
    const auto reader = LightMapReader::open(map.path, {});
    ASSERT_TRUE(reader) << reader.error().line();
    EXPECT_EQ(reader->bake(), "sh9");
}

TEST(BakeFormat, UnknownFilesAreRefusedWithTheirChannelsAndTheKnownFormats) {
    for (const char* bake : {"auto", "sh9"}) {
        const auto found = findBakeFormat(bake, fileOf({"B", "G", "R"}), "lobby.exr");
        ASSERT_FALSE(found);
        EXPECT_EQ(found.error().code, ErrorCode::WrongShape);
        EXPECT_EQ(found.error().line(),
                  "lobby.exr: found no light map, expected the channels of a bake format: sh9 (sh00.R .. sh08.B); it holds R, G, B. A flat "
                  "light map "
                  "or a picture? It has no directions: compress it with `lightcook encode`, or bake SH coefficients");
    }
}

TEST(BakeFormat, UnknownNamesAreRefusedBeforeTheFileIsOpened) {
    LightMapDescription description;
    description.bake = "sh4";
    const Error error = refusal("absent.exr", description);
    EXPECT_EQ(error.code, ErrorCode::InvalidRequest);
    EXPECT_EQ(error.line(), "absent.exr, bake: found \"sh4\", expected auto or sh9");
}

TEST(BakeFormat, MissingChannelsAreNamed) {
    ExrRecipe recipe = seededMap(8, 8);
    recipe.channels.erase("sh05.G");
    const Error error = refusal(MapFile(recipe).path);
    EXPECT_EQ(error.code, ErrorCode::WrongShape);
    EXPECT_THAT(error.detail, HasSubstr("found 26 of the 27 channels of bake format sh9, sh05.G is missing, expected sh00.R .. sh08.B"));
    recipe.channels.erase("sh07.R");
    EXPECT_THAT(refusal(MapFile(recipe).path).detail,
                HasSubstr("found 25 of the 27 channels of bake format sh9, sh05.G and 1 more are missing"));
}

TEST(BakeFormat, ImpliedConventionsReplaceThoseOfTheDescription) {
    LightMapDescription description;
    description.phase = ShPhase::CondonShortley;
    description.lightUnits = LightUnits::Game;
    const LightMapDescription same = withImplied(description, {});
    EXPECT_EQ(same.phase, ShPhase::CondonShortley);
    EXPECT_EQ(same.frame, ShFrame::World);
    EXPECT_EQ(same.quantity, ShQuantity::Radiance);
    EXPECT_EQ(same.lightUnits, LightUnits::Game);
    const LightMapDescription implied =
        withImplied(description, {ShPhase::None, ShFrame::Tangent, ShQuantity::Irradiance, LightUnits::Radiometric});
    EXPECT_EQ(implied.phase, ShPhase::None);
    EXPECT_EQ(implied.frame, ShFrame::Tangent);
    EXPECT_EQ(implied.quantity, ShQuantity::Irradiance);
    EXPECT_EQ(implied.lightUnits, LightUnits::Radiometric);
}

}  // namespace
}  // namespace lightcook::formats

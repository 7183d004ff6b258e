#include "formats/bake_format.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "formats/bakes/bake_reader.h"
#include "formats/bakes/sh9.h"
#include "tests/formats/light_map_fixture.h"

namespace lightcook::formats {
namespace {

using testing::HasSubstr;

ExrInfo fileOf(std::vector<std::string> channels) {
    ExrInfo info;
    info.width = info.height = 4;
    info.channels = std::move(channels);
    return info;
}

TEST(BakeFormat, EveryRowHasWordsAndANameOfItsOwn) {
    std::set<std::string_view> names = {kAutoBake};
    for (const BakeFormatInfo& format : allBakeFormats()) {
        EXPECT_FALSE(format.caption.empty());
        EXPECT_FALSE(format.content.empty());
        EXPECT_TRUE(names.insert(format.name).second) << format.name;
        const int openers =
            (format.open != nullptr ? 1 : 0) + (format.openGltf != nullptr ? 1 : 0) + (format.openOnMesh != nullptr ? 1 : 0);
        EXPECT_EQ(openers, 1) << format.name;
    }
    EXPECT_THAT(bakeNames(), testing::IsSupersetOf({"auto", "sh9", "sh-baker"}));
}

TEST(BakeFormat, ABakeOfSeveralFilesHasTheNameWithoutTheirEndings) {
    std::size_t sets = 0;
    for (const BakeFormatInfo& format : allBakeFormats()) {
        sets += format.endings.empty() ? 0 : 1;
        for (const std::string_view ending : format.endings) {
            const std::filesystem::path file = "absent/hall.v2" + std::string(ending) + ".exr";
            EXPECT_EQ(nameOfBake(file, format.name), "hall.v2") << file;
            if (ending.empty()) continue;  // any picture may be one of a pair
            EXPECT_THAT(format.filesBeside(file), testing::Contains(file)) << format.name;
        }
    }
    EXPECT_EQ(sets, 8u);
    EXPECT_EQ(nameOfBake("hall_L0.exr", "flat"), "hall_L0");
    EXPECT_EQ(nameOfBake("_L0.exr", "bakery-sh"), "_L0") << "no name would be left";
}

TEST(BakeFormat, ChannelsIdentifyAFile) {
    for (const std::string& bake : {std::string("sh9"), std::string(kAutoBake)}) {
        const auto found = findBakeFormat(bake, "map.exr", fileOf(sh9Channels()));
        ASSERT_TRUE(found) << found.error().line();
        EXPECT_EQ(found->format->name, "sh9");
        EXPECT_THAT(found->evidence, testing::StartsWith("channels sh00.R .. sh08.B"));
        EXPECT_THAT(found->otherReadings, testing::IsEmpty());
    }
}

TEST(BakeFormat, WhatIsCompleteIsNoPartOfAnotherFormat) {
    std::vector<std::string> channels = sh9Channels();
    channels.resize(12);
    const auto found = findBakeFormat(std::string(kAutoBake), "map.exr", fileOf(channels));
    ASSERT_TRUE(found) << found.error().line();
    EXPECT_EQ(found->format->name, "sh4");
    EXPECT_THAT(found->incompleteSets, testing::IsEmpty()) << "12 of the 27 channels of sh9";
    const auto alone = findBakeFormat(std::string(kAutoBake), "absent/room_L0.exr", fileOf({"B", "G", "R"}));
    ASSERT_TRUE(alone) << alone.error().line();
    EXPECT_EQ(alone->format->name, "flat");
    EXPECT_THAT(alone->incompleteSets,
                testing::ElementsAre("found 1 of the 2 files of bake format bakery-mono-sh, room_L1 (.exr, .hdr, .tga or .png) "
                                     "is missing, expected it in the same folder; or it is one of sh-baker or bakery-sh"))
        << "the set that lacks fewest files";
}

TEST(BakeFormat, ReaderSaysWhichFormatItChose) {
    const MapFile map(seededMap(4, 4));
    const auto reader = LightMapReader::open(map.path, {});
    ASSERT_TRUE(reader) << reader.error().line();
    EXPECT_EQ(reader->bake(), "sh9");
}

TEST(BakeFormat, UnknownFilesAreRefusedWithTheirChannelsAndTheKnownFormats) {
    const auto found = findBakeFormat("auto", "lobby.exr", fileOf({"depth.Z", "sh.0"}));
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().code, ErrorCode::UnknownBake);
    EXPECT_THAT(found.error().line(),
                testing::AllOf(HasSubstr("lobby.exr: found no light map, expected that of a bake format: sh9 (sh00.R .. "
                                         "sh08.B), sh-baker ("),
                               HasSubstr("it holds depth.Z, sh.0. SH under other names? Rename the channels")));
    const auto named = findBakeFormat("sh9", "lobby.exr", fileOf({"B", "G", "R"}));
    ASSERT_FALSE(named);
    EXPECT_EQ(named.error().line(), "lobby.exr: found no light map of bake format sh9, expected sh00.R .. sh08.B; it holds R, G, B");
}

TEST(BakeFormat, UnknownNamesAreRefusedBeforeTheFileIsOpened) {
    LightMapDescription description;
    description.bake = "sh27";
    const Error error = refusal("absent.exr", description);
    EXPECT_EQ(error.code, ErrorCode::InvalidRequest);
    EXPECT_THAT(error.line(), testing::StartsWith("absent.exr, bake: found \"sh27\", expected auto or sh9 or sh-baker"));
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

TEST(BakeFormat, LayersOfAFileAreNamedInOneShortLine) {
    const auto found =
        findBakeFormat(std::string(kAutoBake), "render.exr", fileOf({"Combined.A", "Combined.B", "Combined.G", "Combined.R"}));
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().line(),
              "render.exr: found R, G, B under layer Combined, expected them without a layer: save one layer as R, G, B");
}

TEST(BakeFormat, ImpliedConventionsReplaceTheDefaultAndRefuseOthers) {
    BakeFormatInfo format = allBakeFormats().front();
    LightMapDescription description;
    description.phase = ShPhase::CondonShortley;
    const auto same = withImplied(description, format, "map.exr");
    ASSERT_TRUE(same);
    EXPECT_EQ(same->phase, ShPhase::CondonShortley);
    EXPECT_EQ(same->quantity, ShQuantity::Radiance);
    format.implied = {ShPhase::CondonShortley, ShFrame::Tangent, ShQuantity::Irradiance, LightUnits::Game};
    const auto implied = withImplied(description, format, "map.exr");
    ASSERT_TRUE(implied) << implied.error().line();
    EXPECT_EQ(implied->phase, ShPhase::CondonShortley);
    EXPECT_EQ(implied->frame, ShFrame::Tangent);
    EXPECT_EQ(implied->quantity, ShQuantity::Irradiance);
    EXPECT_EQ(implied->lightUnits, LightUnits::Game);
    format.implied = {ShPhase::None, {}, {}, {}};
    const auto refused = withImplied(description, format, "map.exr");
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::InvalidRequest);
    EXPECT_EQ(refused.error().line(), "map.exr, phase: found another value than \"none\", expected it: bake format sh9 implies that value");
}

TEST(BakeFormat, APictureWithoutDirectionsHasNoSignConventionAndNoFrame) {
    for (const BakeFormatInfo& format : allBakeFormats()) {
        if (format.hasDirections) continue;
        LightMapDescription description;
        description.phase = ShPhase::CondonShortley;
        EXPECT_FALSE(withImplied(description, format, "map.exr")) << format.name;
        description.phase = ShPhase::None;
        description.frame = ShFrame::Tangent;
        EXPECT_FALSE(withImplied(description, format, "map.exr")) << format.name;
        description.frame = ShFrame::World;
        description.lightUnits = LightUnits::Game;
        EXPECT_EQ(withImplied(description, format, "map.exr").has_value(), !format.implied.lightUnits) << format.name;
    }
}

}  // namespace
}  // namespace lightcook::formats

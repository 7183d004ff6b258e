#include "pipeline/draft/scene_text.h"

#include <gmock/gmock.h>

#include "formats/unity_axes.h"
#include "pipeline/scene/scene.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// Writes the text of a scene file and reads it back.
Scene roundTrip(const DraftInputs& inputs, const fs::path& folder) {
    const auto text = draftScene(inputs, folder);
    EXPECT_TRUE(text.has_value()) << text.error().line();
    formats::writeContent(folder / "scene.toml", text.value_or(""));
    auto scene = readScene(folder / "scene.toml");
    EXPECT_TRUE(scene.has_value()) << scene.error().line() << "\n" << *text;
    return scene ? std::move(*scene) : Scene();
}

DraftLightMap lightMap(const fs::path& file) {
    return {.file = file, .reading = {"", "sh9", "channels", {}, {}, {}}};
}

TEST(SceneDraft, IsReadWithItsSettings) {
    const formats::TemporaryFolder folder;
    DraftInputs inputs;
    inputs.lightMaps = {lightMap(folder / "maps" / "room.exr")};
    inputs.lightMaps[0].mesh = folder / "room.glb";
    inputs.probes = {{folder / "sky.hdr"}, {folder / "hall.exr", folder / "probes.json"}};
    inputs.gradients = {folder / "dusk.exr"};
    const Scene scene = roundTrip(inputs, folder / "");
    ASSERT_EQ(scene.lightMaps.size(), 1u);
    EXPECT_EQ(scene.lightMaps[0].name, "room");
    EXPECT_EQ(scene.lightMaps[0].file.lexically_normal(), (folder / "maps" / "room.exr").lexically_normal());
    EXPECT_EQ(scene.lightMaps[0].description.bake, "sh9");
    EXPECT_EQ(scene.lightMaps[0].mesh->filename(), "room.glb");
    ASSERT_EQ(scene.probes.size(), 2u);
    EXPECT_FALSE(scene.probes[0].sh);
    EXPECT_EQ(scene.probes[1].sh->filename(), "probes.json");
    EXPECT_EQ(scene.gradients.at(0).name, "dusk");
    EXPECT_EQ(scene.output.limits[Limit::WholeVisible], 5);
    ASSERT_EQ(scene.materials.size(), 1u);
    EXPECT_EQ(scene.materials[0].specular, true);
}

TEST(SceneDraft, MaterialsOfTheMeshesAreNotReplaced) {
    const formats::TemporaryFolder folder;
    DraftInputs inputs;
    inputs.lightMaps = {lightMap(folder / "hall.exr"), lightMap(folder / "room.exr")};
    inputs.lightMaps[0].hasMaterials = true;
    EXPECT_EQ(roundTrip(inputs, folder / "").materials.size(), 1u) << "nobody knows those of the room";
    inputs.lightMaps[1].hasMaterials = true;
    EXPECT_TRUE(roundTrip(inputs, folder / "").materials.empty());
    EXPECT_THAT(draftScene(inputs, folder / "").value_or(""), HasSubstr("# [[material]]\n# name = \"*\""));
}

TEST(SceneDraft, TheLimitIsThatOfTheLightMapWhereNoneHasDirections) {
    const formats::TemporaryFolder folder;
    DraftInputs inputs;
    inputs.lightMaps = {lightMap(folder / "hall.exr")};
    inputs.lightMaps[0].hasDirections = false;
    EXPECT_EQ(roundTrip(inputs, folder / "").output.limits[Limit::Visible], 5);
}

TEST(SceneDraft, GapsWithoutLightAreWrittenWithAWord) {
    const formats::TemporaryFolder folder;
    DraftInputs inputs;
    inputs.lightMaps = {lightMap(folder / "hall.exr")};
    inputs.lightMaps[0].hasCoverage = false;
    inputs.lightMaps[0].gaps = 0.694;
    inputs.lightMaps[0].reading.assumed = {kEveryTexelIsCovered};
    EXPECT_EQ(roundTrip(inputs, folder / "").lightMaps.at(0).description.coverage, formats::CoverageSource::Light);
    EXPECT_THAT(draftScene(inputs, folder / "").value_or(""),
                testing::AllOf(HasSubstr("coverage = \"light\""), HasSubstr("the 69 % that are black"), Not(HasSubstr("every texel"))));
}

TEST(SceneDraft, CommentsAreAtTheFirstOfSeveralProbes) {
    const formats::TemporaryFolder folder;
    DraftInputs inputs;
    for (const char* name : {"a.exr", "b.exr", "c.exr"}) inputs.probes.push_back({folder / name, folder / "probes.json"});
    const std::string text = draftScene(inputs, folder / "").value_or("");
    for (const char* comment : {"# size = 128", "panorama, cross, strip", "SH of the probe", "# max_converter_visible = 20"}) {
        const std::size_t at = text.find(comment);
        EXPECT_NE(at, std::string::npos) << comment;
        EXPECT_EQ(text.find(comment, at + 1), std::string::npos) << comment << " stands twice";
    }
    // 20 and "2 MiB" are examples, where other keys show their default.
    EXPECT_THAT(text, HasSubstr("probes and gradients; no limit by default\n"));
    EXPECT_THAT(text, HasSubstr("within it are chosen; no limit by default\n"));
    EXPECT_EQ(roundTrip(inputs, folder / "").probes.size(), 3u);
}

TEST(SceneDraft, NamesAreUniqueAndPathsAreQuoted) {
    const formats::TemporaryFolder folder;
    DraftInputs inputs;
    const char* const stems[] = {"a", "a b", "A", "a\"b", "a\\b", "été", "a_b", ".a", "a\nb", "a'b # c", "日本"};
    for (const char* stem : stems) inputs.lightMaps.push_back(lightMap(folder / (std::string(stem) + ".exr")));
    formats::writeContent(folder / "a\\b.exr", "");  // else the '\' would be taken for that of Windows
    inputs.probes = {{folder / "a.exr"}};
    inputs.gradients = {folder / (std::string(250, 'x') + ".exr")};
    const Scene scene = roundTrip(inputs, folder / "");
    std::set<std::string> names;
    for (std::size_t i = 0; i < scene.lightMaps.size(); ++i) {
        EXPECT_TRUE(names.insert(scene.lightMaps[i].name).second) << scene.lightMaps[i].name;
        EXPECT_EQ(scene.lightMaps[i].file.filename().string(), std::string(stems[i]) + ".exr");
    }
    EXPECT_EQ(scene.lightMaps.size(), std::size(stems));
    EXPECT_EQ(scene.lightMaps[1].name, "a_b");
    EXPECT_EQ(scene.lightMaps[2].name, "A_2") << "a file system may hold it for a";
    EXPECT_EQ(scene.lightMaps[5].name, "_t_");
    EXPECT_EQ(scene.lightMaps[10].name, "lightmap") << "no letter is left of it";
    EXPECT_EQ(scene.probes.at(0).name, "a_3");
}

TEST(SceneDraft, NamesInOtherScriptsAreThoseOfTheKind) {
    const formats::TemporaryFolder folder;
    const std::filesystem::path place = folder / "сцена_02";
    std::filesystem::create_directory(place);
    DraftInputs inputs;
    inputs.lightMaps = {lightMap(place / "場景.exr"), lightMap(place / "свет.exr")};
    inputs.probes = {{place / "空.exr"}};
    const Scene scene = roundTrip(inputs, place);
    EXPECT_EQ(scene.name, "scene_02");
    EXPECT_EQ(scene.lightMaps.at(0).name, "lightmap");
    EXPECT_EQ(scene.lightMaps.at(1).name, "lightmap_2");
    EXPECT_EQ(scene.probes.at(0).name, "probe");
}

TEST(SceneDraft, AMapOfSeveralFilesHasTheNameThatTheyShare) {
    const formats::TemporaryFolder folder;
    DraftInputs inputs;
    const std::pair<const char*, const char*> maps[] = {{"hall_L0", "bakery-sh"}, {"lift_light", "unity-directional"}, {"yard_L0", "flat"}};
    for (const auto& [stem, bake] : maps) {
        inputs.lightMaps.push_back(lightMap(folder / (std::string(stem) + ".exr")));
        inputs.lightMaps.back().reading.bake = bake;
    }
    inputs.probes = {{folder / "hall.exr"}};
    const Scene scene = roundTrip(inputs, folder / "");
    EXPECT_EQ(scene.lightMaps.at(0).name, "hall");
    EXPECT_EQ(scene.lightMaps[0].file.filename(), "hall_L0.exr");
    EXPECT_EQ(scene.lightMaps.at(1).name, "lift");
    EXPECT_EQ(scene.lightMaps.at(2).name, "yard_L0") << "a picture of one file";
    EXPECT_EQ(scene.probes.at(0).name, "hall_2");
}

/// cook refuses such names.
TEST(SceneDraft, NamesThatWindowsReservesAreChanged) {
    const formats::TemporaryFolder folder;
    DraftInputs inputs;
    for (const char* stem : {"nul", "con.v2", "room.", "COM1"}) inputs.lightMaps.push_back(lightMap(folder / (std::string(stem) + ".exr")));
    const Scene scene = roundTrip(inputs, folder / "");
    ASSERT_EQ(scene.lightMaps.size(), 4u);
    EXPECT_EQ(scene.lightMaps[0].name, "_nul");
    EXPECT_EQ(scene.lightMaps[1].name, "_con.v2");
    EXPECT_EQ(scene.lightMaps[2].name, "room_");
    EXPECT_EQ(scene.lightMaps[3].name, "_COM1");
}

TEST(SceneDraft, OffersALimitOnSeamsWhereThereIsAMesh) {
    DraftInputs inputs;
    inputs.lightMaps = {lightMap("/maps/hall.exr"), lightMap("/maps/room.exr")};
    EXPECT_THAT(draftScene(inputs, "/maps").value_or(""), Not(HasSubstr("max_seam")));
    inputs.lightMaps[1].mesh = "/maps/room.glb";
    inputs.lightMaps[1].reading.assumed = {"every surface faces +z", "the axes are those of the world"};
    EXPECT_THAT(draftScene(inputs, "/maps").value_or(""), HasSubstr("\n# max_seam = 5 "));
    EXPECT_THAT(draftScene(inputs, "/maps").value_or(""), Not(HasSubstr("faces +z"))) << "the mesh has normals";
    EXPECT_THAT(draftScene(inputs, "/maps").value_or(""), HasSubstr("# Assumed: the axes are those of the world\n"));
}

/// The coefficients of Bakery are in Unity's axes, the mesh in those of glTF.
TEST(SceneDraft, TurnsUnitysAxesIntoThoseOfTheMesh) {
    DraftInputs inputs;
    inputs.lightMaps = {lightMap("/maps/room_L0.exr")};
    inputs.lightMaps[0].reading = {"", "bakery-sh", "4 files", {std::string(formats::kUnityAxes)}, {}, {}};
    const std::string alone = draftScene(inputs, "/maps").value_or("");
    EXPECT_THAT(alone, AllOf(HasSubstr("# Assumed: the axes are those of the world that was baked"), Not(HasSubstr("\naxes"))));
    inputs.lightMaps[0].mesh = "/maps/room.glb";
    const std::string onMesh = draftScene(inputs, "/maps").value_or("");
    EXPECT_THAT(onMesh, AllOf(Not(HasSubstr("# Assumed: the axes")), HasSubstr("\naxes = \"-x,y,z\"")));
}

TEST(SceneDraft, SaysWhatWasAssumedAndWhatElseTheFileMayBe) {
    DraftInputs inputs;
    inputs.lightMaps = {lightMap("/maps/flat.exr")};
    inputs.lightMaps[0].reading = {"", "flat", "a picture\nof two lines", {"every texel is covered"}, {"godot", "godot-radiance"}, {}};
    inputs.lightMaps[0].isGuess = true;
    inputs.lightMaps[0].hasDirections = false;
    const auto text = draftScene(inputs, "/maps");
    ASSERT_TRUE(text.has_value());
    EXPECT_THAT(*text, HasSubstr("# a guess: a picture of two lines\n"));
    EXPECT_THAT(*text, HasSubstr("# Assumed: every texel is covered\n"));
    EXPECT_THAT(*text, HasSubstr("# The file would also fit bake = \"godot\" or \"godot-radiance\".\n"));
    EXPECT_THAT(*text, Not(HasSubstr("[[material]]"))) << "light without directions needs none";
}

TEST(SceneDraft, AFileOfAnIncompleteSetKeepsTheWarningOfLint) {
    DraftInputs inputs;
    inputs.lightMaps = {lightMap("/maps/room_L0.exr")};
    inputs.lightMaps[0].reading = {"", "flat", "a picture", {}, {}, {"found 1 of the 9 files of bake format sh-baker"}};
    inputs.lightMaps[0].isGuess = true;
    const auto text = draftScene(inputs, "/maps");
    ASSERT_TRUE(text.has_value());
    EXPECT_THAT(*text, HasSubstr("bake = \"auto\""));
    EXPECT_THAT(*text, HasSubstr("# read as flat, a guess: a picture\n"));
    EXPECT_THAT(*text, HasSubstr("# An incomplete set: found 1 of the 9 files of bake format sh-baker\n"));
}

TEST(SceneDraft, ANameThatIsNoUtf8IsRefused) {
    for (const char* name : {"bad\xff.exr", "cut\xc3", "surrogate\xed\xa0\x80", "overlong\xc0\xaf"}) {
        DraftInputs inputs;
        inputs.gradients = {fs::path("/maps") / name};
        const auto text = draftScene(inputs, "/maps");
        ASSERT_FALSE(text.has_value()) << name;
        EXPECT_THAT(text.error().line(), HasSubstr("no UTF-8"));
    }
}

}  // namespace
}  // namespace lightcook::pipeline

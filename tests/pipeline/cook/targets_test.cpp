// Scenes of several targets: a folder for each, which is that of a cook of the target alone.
#include <gmock/gmock.h>

#include "pipeline/manifest/cooked_folder.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/report/report.h"
#include "pipeline/scene/settings.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr const char* kBoth = "targets = [\"bc\", \"astc\"]\nlight_map_layout = \"ratio\"";

std::vector<Outcome> cookAll(const CookOptions& options, const RunState& state = {}) {
    auto scenes = readScenes(options.scene, options.given);
    if (!scenes) return {outcomeOf(scenes.error())};
    return cookScenes(std::move(*scenes), options, state);
}

/// Returns the files that an engine reads of a cooked folder, with their content.
std::map<std::string, std::string> filesToRead(const std::filesystem::path& folder) {
    std::map<std::string, std::string> files = {{kManifestName, formats::contentOf(folder / kManifestName)}};
    const auto manifest = loadManifest(folder);
    if (manifest)
        for (const FileRecord& file : filesOf(*manifest)) files[file.name] = formats::contentOf(folder / file.name);
    return files;
}

TEST(Targets, HaveTheBytesOfCooksOfOneTarget) {
    const SmallScene scene(SmallScene::Parts::LightMap);
    scene.writeSceneFile(std::string(kBoth) + "\n\n[target.astc]\neffort = 3\nzstd = true");
    CookOptions options = scene.optionsWithOwnCache();
    options.depfile = scene / "out.d";
    RunState state;
    std::vector<std::string> shared;
    state.event = [&](const Action& action, ActionEvent event, double) {
        if (event == ActionEvent::Reused) shared.push_back(action.id);
    };
    const std::vector<Outcome> outcomes = cookAll(options, state);
    EXPECT_THAT(shared, testing::Contains("content/map"));
    ASSERT_EQ(outcomes.size(), 2u);
    for (const Outcome& outcome : outcomes) ASSERT_TRUE(outcome.errors.empty()) << outcome.errors.front().line();
    EXPECT_THAT(targetFolders(scene / "out"), ElementsAre(scene / "out/bc", scene / "out/astc"));
    EXPECT_THAT(targetFolders(scene / "out/bc"), ElementsAre(scene / "out/bc"));
    for (const std::string target : {"bc", "astc"}) {
        SCOPED_TRACE(target);
        CookOptions alone = scene.options();
        alone.given.set("output.target", target);
        alone.cache = scene / "another";
        alone.output = scene / "alone" / target;
        ASSERT_TRUE(cook(alone).errors.empty());
        EXPECT_TRUE(filesToRead(scene / "out" / target) == filesToRead(alone.output));
        EXPECT_THAT(formats::contentOf(scene / "out.d"), HasSubstr((scene / "out" / target / kManifestName).string() + ": "));
    }
}

TEST(Targets, HaveBudgetsOfTheirOwn) {
    const SmallScene scene(SmallScene::Parts::LightMap);
    scene.writeSceneFile(std::string(kBoth) + "\nbudget = \"1 MiB\"\n\n[target.bc]\nbudget = \"100\"");
    const std::vector<Outcome> outcomes = cookAll(scene.options());
    ASSERT_EQ(outcomes.size(), 2u) << "a target over its budget does not keep the next from being cooked";
    ASSERT_EQ(outcomes[0].errors.size(), 1u);
    EXPECT_EQ(outcomes[0].errors[0].code, ErrorCode::OverBudget);
    EXPECT_EQ(outcomes[0].errors[0].lineNumber, 10) << "that of its table";
    EXPECT_TRUE(outcomes[1].errors.empty());
    EXPECT_EQ(outcomes[1].report["budget"]["limit_bytes"], 1 << 20);
}

TEST(Targets, AreNotCookedAfterAFaultOfAnInput) {
    const SmallScene scene(SmallScene::Parts::LightMap);
    scene.writeSceneFile(kBoth);
    formats::writeContent(scene / "map.exr", "no EXR");
    CookOptions options = scene.options();
    options.depfile = scene / "out.d";
    EXPECT_EQ(cookAll(options).size(), 1u);
    EXPECT_FALSE(std::filesystem::exists(scene / "out.d"));
    options.keepGoing = true;
    EXPECT_EQ(cookAll(options).size(), 2u);
}

TEST(Targets, AreThoseOfAnOptionOverTheFile) {
    const SmallScene scene(SmallScene::Parts::LightMap);
    const auto targetsOf = [&](const char* key, const char* value) {
        GivenKeys given;
        if (*key != 0) given.set(key, value);
        std::vector<std::string> targets;
        const auto scenes = readScenes(scene.sceneFile(), given);
        if (!scenes) return std::vector<std::string>{scenes.error().line()};
        for (const Scene& each : *scenes)
            targets.push_back(fmt::format("{} {} {}", cookedFolder(each, "out").string(), each.output.effort, each.output.zstd));
        return targets;
    };
    scene.writeSceneFile(std::string(kBoth) + "\neffort = 6\n\n[target.astc]\neffort = 3");
    EXPECT_THAT(targetsOf("", ""), ElementsAre("out/bc 6 false", "out/astc 3 false"));
    EXPECT_THAT(targetsOf("output.target", "astc"), ElementsAre("out 3 false"));
    EXPECT_THAT(targetsOf("output.effort", "1"), ElementsAre("out/bc 1 false", "out/astc 1 false"));
    EXPECT_THAT(targetsOf("output.targets", "astc,bc"), ElementsAre("out/astc 3 false", "out/bc 6 false"));
    scene.writeSceneFile("target = \"bc\"\n\n[target.astc]\nzstd = true");
    EXPECT_THAT(targetsOf("", ""), ElementsAre("out 5 false"));
    EXPECT_THAT(targetsOf("output.target", "astc"), ElementsAre("out 5 true"));
    EXPECT_THAT(targetsOf("output.targets", "astc"), ElementsAre("out/astc 5 true"));
}

}  // namespace
}  // namespace lightcook::pipeline

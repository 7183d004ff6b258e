// Ninja files of scenes: paths with characters that Ninja takes for its own.
#include "pipeline/cook/ninja.h"

#include <gmock/gmock.h>

namespace lightcook::pipeline {
namespace {

using testing::HasSubstr;
using testing::Not;

Scene sceneWithMap(const std::filesystem::path& map) {
    Scene scene;
    scene.name = "room";
    scene.file = "/work/room.toml";
    scene.lightMaps.emplace_back();
    scene.lightMaps.front().name = "walls";
    scene.lightMaps.front().file = map;
    return scene;
}

NinjaOptions optionsWithOutput(const std::filesystem::path& output) {
    NinjaOptions options;
    options.program = "/bin/lightcook";
    options.output = output;
    return options;
}

// A bar ends the outputs of a build statement, and Ninja has no escape for it.
TEST(NinjaFile, NamesBarsInPathsByAVariable) {
    const std::string text = ninjaFileOf(sceneWithMap("/work/map.exr"), optionsWithOutput("/work/a|b: c"));
    EXPECT_THAT(text, HasSubstr("\nbar = |\n"));
    EXPECT_THAT(text, HasSubstr("\nbuild /work/a${bar}b$:$ c/cooked.json: scene /work/room.toml | /work/a${bar}b$:$ c.assets/walls/"));
    EXPECT_THAT(text, Not(HasSubstr("build /work/a|")));
}

TEST(NinjaFile, HasOneCommandForSeveralTargets) {
    NinjaOptions options = optionsWithOutput("/work/out");
    options.targets = {"bc", "astc"};
    const std::string text = ninjaFileOf(sceneWithMap("/work/map.exr"), options);
    EXPECT_THAT(text, HasSubstr("\nbuild /work/out/bc/cooked.json /work/out/astc/cooked.json: scene /work/room.toml | "
                                "/work/out.assets/walls/bc/cooked.json /work/out.assets/walls/astc/cooked.json "));
    EXPECT_THAT(text, HasSubstr("\ndefault /work/out/bc/cooked.json /work/out/astc/cooked.json\n"));
}

TEST(NinjaFile, HasAWarningOfPathsThatNinjaDoesNotReadInDepfiles) {
    EXPECT_FALSE(warningOfDepfiles(sceneWithMap("/work/map 1#$(x).exr"), optionsWithOutput("/work/out")));
    const auto output = warningOfDepfiles(sceneWithMap("/work/map.exr"), optionsWithOutput("/work/day & night"));
    ASSERT_TRUE(output);
    EXPECT_EQ(output->subject, "/work/day & night");
    EXPECT_THAT(output->detail, HasSubstr("found '&', expected none of "));
    const auto input = warningOfDepfiles(sceneWithMap("/work/map;1.exr"), optionsWithOutput("/work/out"));
    ASSERT_TRUE(input);
    EXPECT_EQ(input->subject, "/work/map;1.exr");
}

}  // namespace
}  // namespace lightcook::pipeline

// Keys of the command line over those of a scene file, and rules between settings that either breaks.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "pipeline/scene/scene.h"
#include "pipeline/scene/settings.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::pipeline {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

/// A folder with a scene file.
class GivenKeysOverAFile : public testing::Test {
protected:
    formats::Result<Scene> read(const std::string& text, const GivenKeys& given = {}) const {
        formats::writeContent(folder_ / "scene.toml", "schema = 1\nname = \"s\"\n" + text);
        return readScene(folder_ / "scene.toml", given);
    }
    /// Returns the place of a mistake from its last folder on, and what is wrong.
    std::string mistake(const std::string& text, const GivenKeys& given = {}) const {
        const auto scene = read(text, given);
        if (scene) return "";
        const std::string line = scene.error().line();
        return line.starts_with('-') ? line : line.substr(line.find("scene.toml"));
    }
    static GivenKeys keys(std::initializer_list<std::pair<const char*, const char*>> values) {
        GivenKeys given;
        for (const auto& [key, value] : values) given.set(key, value);
        return given;
    }

    formats::TemporaryFolder folder_;
};

constexpr const char* kMap = "[[light_map]]\nname = \"map\"\nfile = \"map.exr\"\n";

TEST_F(GivenKeysOverAFile, GoBeforeItsKeysAndThoseOfEntries) {
    const std::string text = fmt::format(
        "[output]\ntarget = \"astc\"\nmax_visible = 3\nmips = false\n{}max_visible = 4\nmips = false\nlayouts = [\"flat\"]\n"
        "[tables]\nmax_visible = 5\n",
        kMap);
    const auto scene = read(text, keys({{"output.target", "float"},
                                        {"output.max_visible", "7"},
                                        {"output.mips", "true"},
                                        {"output.max_error", "2%"},
                                        {"output.budget", "2 KiB"},
                                        {"output.layouts", "godot,sh4"},
                                        {"output.max_converter_visible", "8"}}));
    ASSERT_TRUE(scene) << scene.error().line();
    const OutputSettings& output = scene->output;
    EXPECT_EQ(output.target, Target::Float);
    EXPECT_EQ(output.limits[Limit::Visible], 7);
    EXPECT_EQ(output.limits[Limit::Error], 0.02);
    EXPECT_EQ(output.budgetBytes, 2048u);
    EXPECT_THAT(output.layouts, testing::ElementsAre("godot", "sh4"));
    EXPECT_TRUE(hasMips(output, scene->lightMaps[0]));
    EXPECT_FALSE(scene->lightMaps[0].limits[Limit::Visible]);
    EXPECT_TRUE(scene->lightMaps[0].layouts.empty());
    EXPECT_FALSE(scene->tables.limits[Limit::Visible]);
    EXPECT_EQ(read(text)->lightMaps[0].limits[Limit::Visible], 4);
}

TEST_F(GivenKeysOverAFile, MakeTheTablesThatAreMissing) {
    const auto scene =
        read("", keys({{"output.effort", "007"}, {"material.name", "*"}, {"light_map.name", "a"}, {"light_map.file", "a.exr"}}));
    ASSERT_TRUE(scene) << scene.error().line();
    EXPECT_EQ(scene->output.effort, 7);
    EXPECT_EQ(scene->materials.at(0).name, "*");
    EXPECT_EQ(scene->lightMaps.at(0).name, "a");
    EXPECT_FALSE(scene->lines.find("output", "", "effort")) << "no line has it";
}

TEST_F(GivenKeysOverAFile, AreRefusedByTheNameOfTheirOption) {
    EXPECT_EQ(mistake("", keys({{"output.effort", "11"}})), "--effort: found '11', expected an integer from 0 to 9");
    EXPECT_EQ(mistake("", keys({{"output.target", "atsc"}})),
              "--target: found 'atsc', expected one of: bc, astc, float; nearest is 'astc'");
    EXPECT_THAT(mistake(kMap, keys({{"light_map.axes", "x,y,y"}})), StartsWith("--axes: found 'x,y,y', expected x, y and z once each"));
    EXPECT_THAT(mistake("[[gradient]]\nname = \"g\"\nfile = \"g.exr\"\n", keys({{"gradient.axis", "0,nan,0"}})),
                StartsWith("--axis: found 'nan', expected a direction"));
    EXPECT_EQ(faultOfKey("output.rdo", "150%"), "found '150%', expected a fraction from 0 to 1: 0.02, or \"2%\"");
    EXPECT_EQ(faultOfKey("output.budget", "2 MiB"), "");
    EXPECT_THAT(faultOfKey("output.budget", "2 parsecs"), StartsWith("found '2 parsecs'"));
}

TEST_F(GivenKeysOverAFile, NameTheOptionThatBreaksARule) {
    const std::string zstd = "[output]\nzstd = true\n", effort = "[output]\neffort = 9\n", cost = "[output]\ncost = \"taps\"\n";
    const char* const isDds = "found zstd = true with container = \"dds\"";
    EXPECT_THAT(mistake(zstd + "container = \"dds\"\n"), StartsWith(fmt::format("scene.toml:4:8: {}", isDds)));
    EXPECT_THAT(mistake(zstd, keys({{"output.container", "dds"}})), StartsWith(fmt::format("--container: {}", isDds)));
    EXPECT_THAT(mistake("[output]\ncontainer = \"dds\"\n", keys({{"output.zstd", "true"}})), StartsWith(fmt::format("--zstd: {}", isDds)));
    // Without effect there, which is the aim of the option.
    EXPECT_EQ(mistake(effort, keys({{"output.target", "float"}})), "");
    EXPECT_EQ(mistake(cost, keys({{"output.light_map_layout", "ratio"}})), "");
    EXPECT_EQ(mistake("[output]\ntarget = \"float\"\n", keys({{"output.effort", "3"}})), "") << "scripts give it to all scenes";
    EXPECT_THAT(mistake("", keys({{"output.target", "float"}, {"output.effort", "9"}})), StartsWith("--effort: found output.effort with"));
    EXPECT_EQ(mistake(zstd + "container = \"dds\"\n", keys({{"output.container", "ktx2"}})), "") << "an option may mend a file";
    EXPECT_THAT(mistake("[[gradient]]\nname = \"g\"\nfile = \"g.exr\"\nformat = \"bc7\"\n", keys({{"output.target", "astc"}})),
                StartsWith("--target: found format \"bc7\" with target \"astc\""));
}

TEST_F(GivenKeysOverAFile, PhongLobesAreThoseOfTablesAlone) {
    const std::string phong = "lobe = \"phong\"\n";
    EXPECT_EQ(mistake(phong), "");
    EXPECT_THAT(mistake(phong + kMap), StartsWith("scene.toml:3:8: found \"phong\" for lobe, expected beckmann or ggx"));
    EXPECT_EQ(mistake(phong, keys({{"tables.normalization", "halo3"}})),
              "--normalization: found \"halo3\" with the lobe \"phong\", expected \"energy\", the only one of Phong lobes");
}

TEST_F(GivenKeysOverAFile, ChartsHaveToFitTheScene) {
    const std::string output = "[output]\ncharts = \"pack\"\nmax_error = 0.05\n", mesh = "mesh = \"map.glb\"\n";
    EXPECT_EQ(mistake(output + kMap + mesh), "");
    EXPECT_EQ(mistake(output + "charts_max_visible = 1\n" + kMap + mesh), "");
    EXPECT_THAT(mistake(output + kMap), StartsWith("scene.toml:4:10: found charts of 'map' to pack without a mesh"));
    EXPECT_THAT(mistake(kMap, keys({{"output.charts", "pack"}})), StartsWith("--charts: found charts of 'map' to pack without a mesh"));
    EXPECT_THAT(mistake(output + "light_map_layout = \"rnm\"\n" + kMap + mesh), HasSubstr("to pack with a layout in tangent space"));
    const char* const unused = "found charts_max_visible where no charts are packed";
    EXPECT_THAT(mistake(std::string("[output]\ncharts_max_visible = 1\n") + kMap), StartsWith(fmt::format("scene.toml:4:22: {}", unused)));
    EXPECT_THAT(mistake(output + kMap + mesh + "charts = \"keep\"\ncharts_max_visible = 1\n"),
                StartsWith(fmt::format("scene.toml:11:22: {}", unused)));
    EXPECT_EQ(mistake(output + "charts_max_visible = 1\n" + kMap + mesh, keys({{"output.charts", "keep"}})), "");
    for (const char* mode : {"", "charts = \"keep\"\n"})
        EXPECT_THAT(mistake(std::string("[output]\n") + mode + kMap, keys({{"output.charts_max_visible", "1"}})),
                    StartsWith(fmt::format("--charts-max-visible: {}", unused)));
}

/// A scene that is read again from what it keeps is the same.
TEST_F(GivenKeysOverAFile, AreKeptInTheDocument) {
    const auto scene =
        read(fmt::format("allow = [\"stale-bake\"]\n[output]\nmax_error = 1\nlayouts = [\"godot\"]\n{}mips = true\nfirefly_limit = "
                         "0.5e3\n[[light_map.place]]\nnode = \"a\"\nscale = [1, 0.5]\n",
                         "[[light_map]]\nname = \"map\"\nfile = \"map.exr\"\nmesh = \"map.glb\"\n"),
             keys({{"output.budget", "4096"}, {"output.max_visible", "1e-7"}}));
    ASSERT_TRUE(scene) << scene.error().line();
    const auto again = readSceneDocument(parseJson(textOf(scene->document)), scene->directory);
    ASSERT_TRUE(again) << again.error().line();
    EXPECT_EQ(again->document, scene->document);
    EXPECT_EQ(again->output.limits, scene->output.limits);
    EXPECT_EQ(again->output.budgetBytes, 4096u);
    EXPECT_EQ(again->lightMaps.at(0).file, scene->lightMaps.at(0).file);
    EXPECT_EQ(again->lightMaps.at(0).mips, true);
    EXPECT_EQ(again->lightMaps.at(0).description.places.at(0).scale[1], 0.5);
    EXPECT_EQ(again->allowances.at(0).check, LintCheck::StaleBake);
}

TEST(ReadSceneDocument, PathsOfOptionsAreThoseOfTheCurrentFolder) {
    const Json document = {{"schema", 1}, {"name", "s"}, {"light_map", {{{"name", "map"}, {"file", "map.exr"}}}}};
    GivenKeys given;
    given.set("light_map.surfaces", "meshes/map.glb");
    given.set("light_map.lmbake", "none");
    for (const std::filesystem::path& directory :
         {std::filesystem::path("a/b"), std::filesystem::current_path() / "a", std::filesystem::path()}) {
        const auto scene = readSceneDocument(document, directory, given);
        ASSERT_TRUE(scene) << scene.error().line();
        const formats::LightMapDescription& map = scene->lightMaps.at(0).description;
        EXPECT_EQ(std::filesystem::absolute(map.mesh), std::filesystem::absolute("meshes/map.glb"));
        EXPECT_TRUE(map.hasNoLmbake);
        EXPECT_EQ(scene->lightMaps.at(0).file, directory / "map.exr");
        EXPECT_EQ(readSceneDocument(scene->document, directory)->lightMaps.at(0).description.mesh, map.mesh);
    }
}

}  // namespace
}  // namespace lightcook::pipeline

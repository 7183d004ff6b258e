// `output_axes` of a light map: the engine's shader reads light in axes of its own, while lint and mesh have those of the mesh.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "pipeline/cook/cook.h"
#include "pipeline/manifest/manifest.h"
#include "tests/formats/temporary_folder.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

using testing::HasSubstr;

class OutputAxes : public testing::Test {
protected:
    /// map  lines of [[light_map]]
    Outcome cook(const std::string& output, const std::string& map) const {
        scene_.writeSceneFile(output);
        const std::string file = "file = \"map.exr\"\n";
        std::string text = formats::contentOf(scene_.sceneFile());
        formats::writeContent(scene_.sceneFile(), text.insert(text.find(file) + file.size(), map));
        return cookScene(scene_.options(), RunState());
    }
    static std::string firstError(const Outcome& outcome) { return outcome.errors.empty() ? "" : outcome.errors.front().line(); }
    std::string texture(const std::string& role) const { return formats::contentOf(scene_ / ("out/map_" + role + ".ktx2")); }

    SmallScene scene_{SmallScene::Parts::LightMap};
};

/// A bake in the axes of Unity, whose normals are brought to a glTF's for the verification, is written as it is.
TEST_F(OutputAxes, TurnedBackTheTexelsAreThoseOfTheBake) {
    const std::string output = "light_map_layout = \"bakery\"\nmax_error = 0.9";
    ASSERT_EQ(firstError(cook(output, "")), "");
    const std::string l1x = texture("l1x"), l1y = texture("l1y");
    ASSERT_EQ(firstError(cook(output, "axes = \"-x,y,z\"\n")), "");
    EXPECT_NE(texture("l1x"), l1x) << "in the axes of the mesh";
    EXPECT_EQ(texture("l1y"), l1y);
    ASSERT_EQ(firstError(cook(output, "axes = \"-x,y,z\"\noutput_axes = \"-x,y,z\"\n")), "");
    EXPECT_EQ(texture("l1x"), l1x);
    EXPECT_EQ(texture("l1y"), l1y);
    EXPECT_EQ(readManifest(scene_.options().output)->at("assets").at(0).at("source").at("description").at("output_axes"), "-x,y,z");
}

TEST_F(OutputAxes, AreForShadersOfEnginesAlone) {
    const std::string axes = "output_axes = \"-x,y,z\"\n";
    EXPECT_THAT(firstError(cook("light_map_layout = \"ratio\"", axes)),
                HasSubstr("expected a layout with the directions of an engine's own"));
    EXPECT_THAT(firstError(cook("max_error = 0.1", axes)), HasSubstr("expected a layout with the directions of an engine's own"));
    EXPECT_THAT(firstError(cook("layouts = [\"godot\", \"sh4\"]\nmax_error = 0.9", axes)), HasSubstr("output_axes"));
    EXPECT_EQ(firstError(cook("layouts = [\"godot\"]\nmax_error = 0.9", axes)), "");
    EXPECT_THAT(firstError(cook("light_map_layout = \"godot\"\nmax_error = 0.9\ngltf = true", axes + "mesh = \"none.glb\"\n")),
                HasSubstr("with gltf = true"));
    EXPECT_THAT(firstError(cook("light_map_layout = \"godot\"\nmax_error = 0.9", "output_axes = \"x,y,y\"\n")),
                HasSubstr("x, y and z once each"));
}

}  // namespace
}  // namespace lightcook::pipeline

#include "pipeline/scene/named_files.h"

#include <gmock/gmock.h>

#include "tests/formats/temporary_folder.h"
#include "tests/pipeline/scene_with_one_map.h"

namespace lightcook::pipeline {
namespace {

TEST(FilesNamedBy, HasTheSceneFileAndEveryFileThatItNames) {
    Scene scene = sceneWithOneMap();
    scene.file = "scene.toml";
    scene.lightMaps[0].mesh = "map.glb";
    scene.lightMaps[0].groundTruth = "traced.csv";
    scene.probes[0].sh = "probes.json";
    scene.colors.config = "studio.ocio";
    EXPECT_THAT(filesNamedBy(scene), testing::UnorderedElementsAre("scene.toml", "map.exr", "map.glb", "traced.csv", "probe.exr",
                                                                   "probes.json", "sky.exr", "studio.ocio"));
}

TEST(NamedPlaces, AreThoseOfTheFilesHoweverTheyAreWritten) {
    const formats::TemporaryFolder folder;
    std::filesystem::create_directories(folder / "out");
    std::filesystem::create_directory_symlink("out", folder / "link");
    Scene scene = sceneWithOneMap();
    scene.lightMaps[0].file = folder / "out" / "map.exr";
    const NamedPlaces places(scene);
    EXPECT_TRUE(places.contains(folder / "out" / "map.exr"));
    EXPECT_TRUE(places.contains(folder / "out" / ".." / "link" / "map.exr"));
    EXPECT_FALSE(places.contains(folder / "map.exr"));
    EXPECT_FALSE(places.contains(folder / "out" / "map.ktx2"));
}

/// An output replaces a link of its name, and what the link names stays.
TEST(NamedPlaces, ALinkIsAnotherPlaceThanItsFile) {
    const formats::TemporaryFolder folder;
    formats::writeContent(folder / "map.exr", "light");
    std::filesystem::create_symlink("map.exr", folder / "link.exr");
    Scene scene = sceneWithOneMap();
    scene.lightMaps[0].file = folder / "map.exr";
    EXPECT_FALSE(NamedPlaces(scene).contains(folder / "link.exr"));
    scene.lightMaps[0].file = folder / "link.exr";
    EXPECT_TRUE(NamedPlaces(scene).contains(folder / "link.exr"));
    EXPECT_FALSE(NamedPlaces(scene).contains(folder / "map.exr"));
}

}  // namespace
}  // namespace lightcook::pipeline

#include "pipeline/scene/named_files.h"

#include <gmock/gmock.h>

#include "formats/bake_format.h"
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

TEST(FilesNamedBy, HasTheFilesThatAreReadBesideThem) {
    const formats::TemporaryFolder folder;
    for (const char* name : {"sky_px.exr", "sky_nx.exr", "sky_nz.exr", "room_L0.exr", "room_L1.exr", "other.exr"})
        formats::writeContent(folder / name, "light");
    Scene scene = sceneWithOneMap();
    scene.probes[0].file = folder / "sky_px.exr";
    scene.lightMaps[0].file = folder / "room_L0.exr";
    const auto beside = formats::bakeFilesBeside(scene.lightMaps[0].file, scene.lightMaps[0].description.bake);
    const std::vector<std::filesystem::path> files = filesNamedBy(scene);
    EXPECT_THAT(files, testing::IsSupersetOf(beside));
    EXPECT_THAT(files, testing::IsSupersetOf({folder / "sky_px.exr", folder / "sky_nx.exr", folder / "sky_nz.exr"}));
    EXPECT_THAT(files, testing::Not(testing::Contains(folder / "sky_py.exr"))) << "it does not exist";
    EXPECT_THAT(files, testing::Not(testing::Contains(folder / "other.exr")));
}

TEST(FilesNamedBy, HasTheBuffersAndImagesOfAMesh) {
    const formats::TemporaryFolder folder;
    for (const char* name : {"room.bin", "wood.png", "other.bin"}) formats::writeContent(folder / name, "data");
    formats::writeContent(folder / "room.gltf", R"({"asset": {"version": "2.0"}, "buffers": [{"uri": "room.bin", "byteLength": 4}],
                                                    "images": [{"uri": "wood.png"}]})");
    Scene scene = sceneWithOneMap();
    scene.lightMaps[0].mesh = folder / "room.gltf";
    EXPECT_THAT(filesNamedBy(scene), testing::IsSupersetOf({folder / "room.gltf", folder / "room.bin", folder / "wood.png"}));
    EXPECT_THAT(filesNamedBy(scene), testing::Not(testing::Contains(folder / "other.bin")));
    scene.lightMaps[0].mesh.reset();
    scene.lightMaps[0].description.mesh = folder / "room.gltf";
    EXPECT_THAT(filesNamedBy(scene), testing::Contains(folder / "room.bin"));
    EXPECT_TRUE(NamedPlaces(scene).contains(folder / "wood.png"));
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

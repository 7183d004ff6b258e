#include "pipeline/draft/inputs.h"

#include <gmock/gmock.h>

#include "formats/plain_image.h"
#include "pipeline/document/json.h"
#include "tests/formats/picture_fixture.h"
#include "tests/formats/unreal_fixture.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

namespace fs = std::filesystem;
using formats::ErrorCode;
using formats::Image;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

constexpr const char* kTriangleScene = R"({"asset": {"version": "2.0"}, "buffers": [{"byteLength": 66, "uri":
"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/AAABAAIA"}],
"bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 24}, {"buffer": 0, "byteOffset": 60, "byteLength": 6}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
{"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"}, {"bufferView": 2, "componentType": 5123, "count": 3, "type": "SCALAR"}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0UVS}, "indices": 2}]}], "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}], "scene": 0})";

class DraftInputsOfAFolder : public testing::Test {
protected:
    void picture(const std::string& name, int width, int height, int channels = 3) const {
        ASSERT_TRUE(formats::writeExr(folder_ / name, Image<glm::vec4>(width, height, glm::vec4(0.5f)).view(), channels)) << name;
    }
    void mesh(const std::string& name, bool hasUvs = true, const std::string& primitive = "") const {
        std::string text = kTriangleScene;
        constexpr std::string_view kPrimitive = R"("meshes": [{"primitives": [{)";
        if (!primitive.empty()) text.replace(text.find(kPrimitive), kPrimitive.size(), primitive);
        text.replace(text.find("UVS"), 3, hasUvs ? ", \"TEXCOORD_1\": 1" : "");
        formats::writeContent(folder_ / name, text);
    }
    void integers(const std::string& name, int width, int height, int channels = 3) const {
        formats::writePng(folder_ / name, width, height, channels, [](int, int, int) { return 128; });
    }
    void write(const std::string& name) const { formats::writeContent(folder_ / name, "words"); }
    DraftInputs find() const {
        auto inputs = findInputs({folder_ / ""});
        EXPECT_TRUE(inputs.has_value()) << inputs.error().line();
        return inputs ? std::move(*inputs) : DraftInputs();
    }
    static std::string whyLeftOut(const DraftInputs& inputs, const std::string& name) {
        for (const LeftOut& each : inputs.leftOut)
            if (each.file.filename() == name) return each.why;
        return "not left out";
    }

    formats::TemporaryFolder folder_;
};

TEST_F(DraftInputsOfAFolder, EachKindIsRecognised) {
    const SmallScene scene(SmallScene::Parts::All);
    const auto inputs = findInputs({scene / "map.exr", scene / "probe.exr", scene / "sky.exr"});
    ASSERT_TRUE(inputs.has_value()) << inputs.error().line();
    ASSERT_THAT(inputs->lightMaps, SizeIs(1));
    EXPECT_EQ(inputs->lightMaps[0].reading.bake, "sh9");
    EXPECT_FALSE(inputs->lightMaps[0].isGuess);
    EXPECT_TRUE(inputs->lightMaps[0].hasDirections);
    ASSERT_THAT(inputs->probes, SizeIs(1));
    EXPECT_EQ(inputs->probes[0].file.filename(), "probe.exr");
    ASSERT_THAT(inputs->gradients, SizeIs(1));
    EXPECT_EQ(inputs->gradients[0].filename(), "sky.exr");
    EXPECT_THAT(inputs->leftOut, IsEmpty());
}

TEST_F(DraftInputsOfAFolder, ThePartsOfABakeAreNoPicturesOfTheirOwn) {
    for (const char* name : {"room_L0.exr", "room_L1x.exr", "room_L1y.exr", "room_L1z.exr"}) picture(name, 16, 8);
    const DraftInputs inputs = find();
    ASSERT_THAT(inputs.lightMaps, SizeIs(1));
    EXPECT_EQ(inputs.lightMaps[0].file.filename(), "room_L0.exr");
    EXPECT_EQ(inputs.lightMaps[0].reading.bake, "bakery-sh");
    EXPECT_THAT(inputs.probes, IsEmpty()) << "though the parts have the shape of panoramas";
    EXPECT_THAT(inputs.leftOut, IsEmpty());
}

TEST_F(DraftInputsOfAFolder, TheFirstFileOfASetIsTheLightMap) {
    picture("Lightmap-0_comp_light.exr", 16, 8);
    integers("Lightmap-0_comp_dir.png", 16, 8, 4);
    const DraftInputs inputs = find();
    ASSERT_THAT(inputs.lightMaps, SizeIs(1));
    EXPECT_EQ(inputs.lightMaps[0].file.filename(), "Lightmap-0_comp_light.exr") << "not the directions, which sort before it";
    EXPECT_EQ(inputs.lightMaps[0].reading.bake, "unity-directional");
    EXPECT_THAT(inputs.leftOut, IsEmpty());
}

TEST_F(DraftInputsOfAFolder, NamesInCapitalsMakeOneLightMap) {
    for (const auto& [light, direction] : {std::pair("Lightmap-0_comp_light.exr", "Lightmap-0_comp_dir.PNG"),
                                           std::pair("LIGHTMAP-1_COMP_LIGHT.EXR", "LIGHTMAP-1_COMP_DIR.PNG")}) {
        picture(light, 16, 16);
        integers(direction, 16, 16, 4);
    }
    const DraftInputs inputs = find();
    ASSERT_THAT(inputs.lightMaps, SizeIs(2));
    for (const DraftLightMap& map : inputs.lightMaps) EXPECT_EQ(map.reading.bake, "unity-directional") << map.file;
    EXPECT_THAT(inputs.leftOut, IsEmpty());
}

TEST_F(DraftInputsOfAFolder, WhatASetLacksIsTheReasonWhyItsFilesAreLeftOut) {
    picture("square.exr", 16, 16);
    for (const char* name : {"room_L1x.png", "room_L1y.png", "room_L1z.png", "hall_light.png", "hall_dir.png"}) integers(name, 16, 8, 4);
    DraftInputs inputs = find();
    EXPECT_THAT(whyLeftOut(inputs, "room_L1y.png"),
                HasSubstr("found 3 of the 4 files of bake format bakery-sh, room_L0 (.exr, .hdr, .tga or .png) is missing"));
    for (const char* name : {"hall_light.png", "hall_dir.png"})
        EXPECT_THAT(whyLeftOut(inputs, name), HasSubstr("hall_light.png to hall_dir.png of bake format unity-directional with light in a "
                                                        "picture of integers, expected encoding = \"none\" (linear)"))
            << name;
    picture("room_L0.exr", 16, 9);
    inputs = find();
    EXPECT_THAT(whyLeftOut(inputs, "room_L0.exr"), testing::StartsWith("room_L1x.png: found 16 x 8 texels, expected 16 x 9"));
}

TEST_F(DraftInputsOfAFolder, AGltfOfUnrealSaysWhatToWrite) {
    picture("square.exr", 16, 16);
    picture("circle.exr", 16, 16);
    std::string text = kTriangleScene;
    text.replace(text.find("UVS"), 3, ", \"TEXCOORD_1\": 1");
    Json level = Json::parse(text);
    const formats::UnrealImage image(8, 8);
    const auto lightMap = [&](int texture) { return formats::unrealLightMap(image, {0, 0, 8, 8}, {}, texture); };
    level.update(formats::unrealGltf(Json::array({{{"name", "HQ_0"}, {"uri", "a.png"}}, {{"name", "HQ_1"}, {"uri", "b.png"}}}),
                                     Json::array({lightMap(0), lightMap(1)})));
    level["nodes"].push_back({{"mesh", 0}});
    level["scenes"][0]["nodes"] = {2};
    formats::writeContent(folder_ / "level.gltf", level.dump());
    EXPECT_THAT(whyLeftOut(find(), "level.gltf"), HasSubstr("it holds light maps of Unreal; write file = \"level.gltf\" and image = "
                                                            "\"HQ_0\" into a [[light_map]], and so for each: HQ_0, HQ_1"));
}

TEST_F(DraftInputsOfAFolder, APictureIsAnEnvironmentByItsShapeOrALightMapByItsName) {
    picture("panorama.exr", 32, 16);
    picture("strip.exr", 8, 48);
    picture("hall_lightmap.exr", 64, 32);
    picture("square.exr", 16, 16);
    for (const char* face : {"cube_px.exr", "cube_nx.exr", "cube_py.exr", "cube_ny.exr", "cube_pz.exr", "cube_nz.exr"}) picture(face, 8, 8);
    const DraftInputs inputs = find();
    ASSERT_THAT(inputs.lightMaps, SizeIs(2));
    for (const DraftLightMap& map : inputs.lightMaps) {
        EXPECT_EQ(map.reading.bake, "flat");
        EXPECT_TRUE(map.isGuess);
        EXPECT_FALSE(map.hasDirections);
    }
    ASSERT_THAT(inputs.probes, SizeIs(3));
    EXPECT_EQ(inputs.probes[0].file.filename(), "cube_px.exr") << "the other faces belong to it";
}

TEST_F(DraftInputsOfAFolder, BlackAroundTheChartsOfAFlatMapIsAGap) {
    Image<glm::vec4> texels(40, 30, glm::vec4(0));
    for (int y = 0; y < 30; ++y)
        for (int x = 0; x < 20; ++x) texels.at(x, y) = glm::vec4(0.5f);
    ASSERT_TRUE(formats::writeExr(folder_ / "hall_lightmap.exr", texels.view(), 3));
    ASSERT_TRUE(formats::writeExr(folder_ / "black_lightmap.exr", Image<glm::vec4>(40, 30, glm::vec4(0)).view(), 3));
    picture("full_lightmap.exr", 40, 30);
    const DraftInputs inputs = find();
    ASSERT_THAT(inputs.lightMaps, SizeIs(3));
    EXPECT_EQ(inputs.lightMaps[0].gaps, 0) << "all of it is black: no surface would be left";
    EXPECT_EQ(inputs.lightMaps[1].gaps, 0);
    EXPECT_DOUBLE_EQ(inputs.lightMaps[2].gaps, 0.5);
}

TEST_F(DraftInputsOfAFolder, AMeshGoesToTheLightMapWhoseNameBeginsWithIts) {
    for (const char* name : {"a_lightmap.exr", "a_b_lightmap.exr", "c_lightmap.exr"}) picture(name, 16, 16);
    for (const char* name : {"a_b.gltf", "unused.gltf"}) mesh(name);
    mesh("plain.gltf", false);
    mesh("a.gltf", true, R"("materials": [{}], "meshes": [{"primitives": [{"material": 0,)");
    const DraftInputs inputs = find();
    ASSERT_THAT(inputs.lightMaps, SizeIs(3));
    EXPECT_EQ(inputs.lightMaps[0].mesh->filename(), "a_b.gltf") << "the longest name that fits";
    EXPECT_EQ(inputs.lightMaps[1].mesh->filename(), "a.gltf");
    EXPECT_FALSE(inputs.lightMaps[0].hasMaterials);
    EXPECT_TRUE(inputs.lightMaps[1].hasMaterials);
    EXPECT_FALSE(inputs.lightMaps[2].mesh);
    EXPECT_THAT(whyLeftOut(inputs, "unused.gltf"), HasSubstr("mesh = \"FILE\""));
    EXPECT_THAT(whyLeftOut(inputs, "plain.gltf"), HasSubstr("TEXCOORD_1"));
}

TEST_F(DraftInputsOfAFolder, ABakeInTangentSpaceIsReadOnTheMeshOfItsName) {
    for (const char* name : {"room_RNM0.exr", "room_RNM1.exr", "room_RNM2.exr", "hall.exr", "hall_deluxe.exr"}) picture(name, 16, 16);
    mesh("room.gltf");
    const DraftInputs inputs = find();
    ASSERT_THAT(inputs.lightMaps, SizeIs(1));
    EXPECT_EQ(inputs.lightMaps[0].file.filename(), "room_RNM0.exr");
    EXPECT_EQ(inputs.lightMaps[0].reading.bake, "bakery-rnm");
    ASSERT_TRUE(inputs.lightMaps[0].mesh);
    EXPECT_EQ(inputs.lightMaps[0].mesh->filename(), "room.gltf");
    for (const char* name : {"hall.exr", "hall_deluxe.exr"})
        EXPECT_THAT(whyLeftOut(inputs, name), HasSubstr("found bake format deluxe without a mesh")) << name << ": directions are no light";
}

TEST_F(DraftInputsOfAFolder, TheOnlyMeshIsThatOfTheOnlyLightMap) {
    picture("lightmap.exr", 16, 16);
    mesh("level.gltf");
    const DraftInputs inputs = find();
    ASSERT_THAT(inputs.lightMaps, SizeIs(1));
    ASSERT_TRUE(inputs.lightMaps[0].mesh);
    EXPECT_EQ(inputs.lightMaps[0].mesh->filename(), "level.gltf");
    EXPECT_THAT(inputs.leftOut, IsEmpty());
}

TEST_F(DraftInputsOfAFolder, AProbeGetsItsShByName) {
    picture("p0.exr", 8, 48);
    picture("p1.exr", 8, 48);
    const Json rows = std::vector<std::vector<double>>(9, {1, 1, 1});
    formats::writeContent(folder_ / "probes.json", Json{{"probes", {{{"file", "p1.exr"}, {"sh", rows}}}}}.dump());
    write("other.json");
    const DraftInputs inputs = find();
    ASSERT_THAT(inputs.probes, SizeIs(2));
    EXPECT_FALSE(inputs.probes[0].sh);
    ASSERT_TRUE(inputs.probes[1].sh);
    EXPECT_EQ(inputs.probes[1].sh->filename(), "probes.json");
    EXPECT_THAT(inputs.leftOut, SizeIs(1));
}

TEST_F(DraftInputsOfAFolder, WhatCannotBeReadIsAnErrorWhereItIsNamed) {
    picture("lightmap.exr", 16, 16);
    write("broken.exr");
    write("broken.glb");
    write("notes.txt");
    write("reference.csv");
    write(".hidden.exr");
    const DraftInputs inputs = find();
    EXPECT_THAT(inputs.leftOut, SizeIs(4)) << "a hidden file is none of them";
    EXPECT_THAT(whyLeftOut(inputs, "notes.txt"), HasSubstr("kind of file"));
    EXPECT_THAT(whyLeftOut(inputs, "reference.csv"), HasSubstr("ground_truth"));
    for (const char* name : {"broken.exr", "broken.glb"}) {
        const auto refused = findInputs({folder_ / "lightmap.exr", folder_ / name});
        ASSERT_FALSE(refused.has_value()) << name;
        EXPECT_EQ(refused.error().code, ErrorCode::FileUnreadable) << refused.error().line();
        EXPECT_THAT(refused.error().line(), HasSubstr(name));
    }
    const auto missing = findInputs({folder_ / "nowhere"});
    ASSERT_FALSE(missing.has_value());
    EXPECT_THAT(missing.error().line(), HasSubstr("found no such file"));
    fs::remove(folder_ / "lightmap.exr");
    const auto nothing = findInputs({folder_ / ""});
    ASSERT_FALSE(nothing.has_value());
    EXPECT_EQ(nothing.error().code, ErrorCode::FormatUnsupported);
    EXPECT_THAT(nothing.error().line(), HasSubstr("found nothing that can be cooked"));
}

}  // namespace
}  // namespace lightcook::pipeline

// `info` lists a cooked folder from its manifest, and adds the figures of its report.
#include "pipeline/command/info.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "formats/image/exr_file.h"
#include "formats/plain_image.h"
#include "pipeline/cook/cook.h"
#include "tests/formats/picture_fixture.h"
#include "tests/formats/temporary_folder.h"
#include "tests/pipeline/example_folder.h"
#include "tests/pipeline/report_parts.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

using testing::HasSubstr;

TEST(InfoOfASceneFile, HasTheLimitThatChoosesLayouts) {
    const SmallScene scene(SmallScene::Parts::LightMap);
    scene.writeSceneFile("max_visible = 7", "");
    const auto facts = describeFile(scene / "scene.toml");
    ASSERT_TRUE(facts) << facts.error().line();
    EXPECT_EQ(facts->at("max_visible"), 7);
    scene.writeSceneFile("max_error = 0.1", "");
    EXPECT_FALSE(describeFile(scene / "scene.toml")->contains("max_visible"));
}

TEST(InfoOfACookedFolder, HasTheFiguresOfItsReport) {
    const SmallScene scene(SmallScene::Parts::LightMap);
    const Outcome cooked = cook(scene.options());
    ASSERT_TRUE(cooked.errors.empty());
    const auto facts = describeFile(scene / "out");
    ASSERT_TRUE(facts) << facts.error().line();
    EXPECT_EQ(facts->at("assets").size(), cooked.report.at("assets").size());
    const Json &asset = facts->at("assets").at(0), &row = cooked.report.at("assets").at(0);
    EXPECT_EQ(asset.at("name"), row.at("name"));
    EXPECT_EQ(asset.at("width"), SmallScene::kWidth);
    EXPECT_EQ(asset.at("bytes_gpu"), row.at("bytes_gpu"));
    EXPECT_EQ(asset.at("passed"), true);
    const Json& error = row.at("stages").back().at("error").at("specular");
    EXPECT_EQ(asset.at("specular").at("rel_rms"), error.at("rel_rms"));
    EXPECT_EQ(asset.at("specular").at("visible_p99"), error.at("visible").at("p99"));
    EXPECT_EQ(asset.at("specular").at("visible_bound"), error.at("visible").at("bound"));
}

TEST(InfoOfACookedFolder, HasNoErrorOfLightThatAnAssetDoesNotHave) {
    const SmallScene scene(SmallScene::Parts::LightMap);
    ASSERT_TRUE(cook(scene.options()).errors.empty());
    const auto facts = describeFile(scene / "out");
    ASSERT_TRUE(facts) << facts.error().line();
    const Json& light = assetOf(*facts, "map_dominant");
    EXPECT_TRUE(light.at("diffuse").at("rel_rms").is_null());
    EXPECT_GT(light.at("specular").at("rel_rms").get<double>(), 0);
}

TEST(InfoOfACookedFolder, DoesWithoutAReportAndRefusesABrokenOne) {
    const SmallScene scene(SmallScene::Parts::LightMap);
    ASSERT_TRUE(cook(scene.options()).errors.empty());
    std::filesystem::resize_file(scene / "out/report.json", 100);
    const auto broken = describeFile(scene / "out");
    ASSERT_FALSE(broken);
    EXPECT_THAT(broken.error().line(), HasSubstr("report.json"));
    std::filesystem::remove(scene / "out/report.json");
    const auto facts = describeFile(scene / "out");
    ASSERT_TRUE(facts) << facts.error().line();
    EXPECT_FALSE(facts->at("assets").at(0).contains("passed"));
    EXPECT_FALSE(facts->at("assets").at(0).contains("specular"));
}

TEST(InfoOfACookedFolder, NamesTheFolderOfAManifestAndAReport) {
    const formats::TemporaryFolder folder;
    for (const char* name : {"cooked.json", "report.json"}) {
        formats::writeContent(folder / name, "{}");
        const auto facts = describeFile(folder / name);
        ASSERT_FALSE(facts);
        EXPECT_THAT(facts.error().line(), HasSubstr("found a file of a cooked scene, expected its folder: "));
    }
    EXPECT_THAT(describeFile("cooked.json").error().line(),
                HasSubstr("cooked.json: found a file of a cooked scene, expected its folder: ."));
}

TEST(InfoOfACookedFolder, CountsTheTrianglesOfAMeshAndNoTexels) {
    const formats::TemporaryFolder folder;
    for (const char* file : {"cornell_lightmap.exr", "cornell.glb"}) std::filesystem::copy_file(exampleFolder() / file, folder / file);
    formats::writeContent(
        folder / "scene.toml",
        "schema = 1\nname = \"box\"\n[output]\nlight_map_layout = \"ratio\"\ndraco = true\n[[light_map]]\nname = \"map\"\n"
        "file = \"cornell_lightmap.exr\"\nmesh = \"cornell.glb\"\n");
    CookOptions options;
    options.scene = folder / "scene.toml";
    options.output = folder / "out";
    options.cache = LIGHTCOOK_TEST_CACHE;
    options.onlyKind = "mesh";
    const Outcome cooked = cook(options);
    for (const formats::Error& error : cooked.errors) ADD_FAILURE() << error.line();
    const auto facts = describeFile(folder / "out");
    ASSERT_TRUE(facts) << facts.error().line();
    const Json& mesh = facts->at("assets").at(0);
    EXPECT_EQ(mesh.at("kind"), "mesh");
    EXPECT_EQ(mesh.at("triangles"), 32);
    EXPECT_TRUE(std::filesystem::exists(folder / "out" / mesh.at("file").get<std::string>()));
    EXPECT_FALSE(mesh.contains("width"));
    EXPECT_FALSE(mesh.contains("textures"));
    EXPECT_GE(mesh.at("diffuse").at("visible_bound").get<double>(), mesh.at("diffuse").at("visible_p99").get<double>());
}

/// Writes a picture of one grey.
void writeGrey(const std::filesystem::path& file, int width, int height) {
    formats::Image<glm::vec4> picture(width, height);
    for (glm::vec4& texel : picture.texels()) texel = glm::vec4(0.5f, 0.5f, 0.5f, 1.0f);
    ASSERT_TRUE(formats::writeExr(file, picture.view(), 3));
}

TEST(InfoOfAnImage, SaysWhyItIsNotReadAsALightMap) {
    const formats::TemporaryFolder folder;
    writeGrey(folder / "stack.exr", 16, 64);
    for (const char* name : {"two_RNM0.exr", "two_RNM1.exr", "one_RNM0.exr"}) writeGrey(folder / name, 16, 16);
    const auto stack = describeFile(folder / "stack.exr"), two = describeFile(folder / "two_RNM0.exr");
    ASSERT_TRUE(stack && two);
    EXPECT_EQ(stack->at("height"), 64);
    EXPECT_THAT(stack->at("as_light_map").at("error").get<std::string>(), HasSubstr("stack.exr: found a file that could be "));
    EXPECT_EQ(two->at("maximum"), 0.5);
    EXPECT_THAT(two->at("as_light_map").at("error").get<std::string>(), HasSubstr("two_RNM2 (.exr, .hdr, .tga or .png) is missing"));
    const auto one = describeFile(folder / "one_RNM0.exr");
    ASSERT_TRUE(one);
    EXPECT_EQ(one->at("as_light_map").at("light_map"), "flat");
    EXPECT_THAT(one->at("as_light_map").at("incomplete_sets").at(0).get<std::string>(),
                HasSubstr("one_RNM1 (.exr, .hdr, .tga or .png) and 1 more are missing"));
}

TEST(InfoOfAnImage, AnyFileOfASetIsDescribedAsTheSet) {
    const formats::TemporaryFolder folder;
    writeGrey(folder / "room_L0.exr", 16, 8);
    const auto writePart = [&](const char* name) { formats::writePng(folder / name, 16, 8, 3, [](int, int, int) { return 128; }); };
    for (const char* name : {"room_L1x.png", "room_L1y.png"}) writePart(name);
    const auto incomplete = describeFile(folder / "room_L1x.png");
    ASSERT_TRUE(incomplete);
    EXPECT_THAT(incomplete->at("as_light_map").at("error").get<std::string>(),
                HasSubstr("found 3 of the 4 files of bake format bakery-sh"));
    writePart("room_L1z.png");
    const auto whole = describeFile(folder / "room_L1x.png");
    ASSERT_TRUE(whole);
    EXPECT_EQ(whole->at("light_map"), "bakery-sh");
    std::filesystem::remove(folder / "room_L0.exr");
    const auto part = describeFile(folder / "room_L1x.png");
    ASSERT_TRUE(part);
    EXPECT_EQ(part->at("width"), 16);
    EXPECT_THAT(part->at("as_light_map").at("error").get<std::string>(),
                HasSubstr("found 3 of the 4 files of bake format bakery-sh, room_L0 (.exr, .hdr, .tga or .png) is missing"));
}

TEST(InfoOfAnImage, NamesTheChannelsThatABakeFormatLacks) {
    const formats::TemporaryFolder folder;
    std::vector<std::string> channels;
    for (int i = 0; i < 9; ++i)
        for (const char colour : {'R', 'G', 'B'})
            if (i != 5 || colour != 'G') channels.push_back(fmt::format("sh{:02}.{}", i, colour));
    constexpr int kSide = 4;
    const std::vector<float> texels(kSide * kSide * channels.size(), 1.0f);
    auto writer = formats::ExrWriter::create(folder / "map.exr", kSide, kSide, channels, formats::ExrLayout::ScanLines);
    ASSERT_TRUE(writer && writer->append(texels.data(), static_cast<std::ptrdiff_t>(kSide * channels.size()), kSide) && writer->commit());
    const auto lacking = describeFile(folder / "map.exr");
    ASSERT_TRUE(lacking);
    EXPECT_THAT(lacking->at("as_light_map").at("error").get<std::string>(),
                HasSubstr("found 26 of the 27 channels of bake format sh9, sh05.G is missing"));
}

TEST(InfoOfAnImage, SaysNothingOfLightMapsWhereNoneIsMeant) {
    const formats::TemporaryFolder folder;
    writeGrey(folder / "faces.exr", 16, 96);
    const auto facts = describeFile(folder / "faces.exr");
    ASSERT_TRUE(facts);
    EXPECT_FALSE(facts->contains("as_light_map"));
}

}  // namespace
}  // namespace lightcook::pipeline

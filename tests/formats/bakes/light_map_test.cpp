#include "formats/light_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <tuple>

#include "tests/formats/light_map_fixture.h"
#include "tests/formats/opens.h"
#include "tests/formats/texture_fixture.h"

namespace lightcook::formats {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(LightMapReader, IncompleteNormalsAndATangentFrameWithoutThemAreRefused) {
    ExrRecipe recipe = seededMap(4, 4);
    LightMapDescription tangent;
    tangent.frame = ShFrame::Tangent;
    EXPECT_THAT(refusal(MapFile(recipe).path, tangent).line(), HasSubstr("frame is \"tangent\""));
    recipe.channels["normal.X"] = recipe.channels["normal.Y"] = [](int, int) { return 0.5f; };
    const Error error = refusal(MapFile(recipe).path);
    EXPECT_EQ(error.code, ErrorCode::WrongShape);
    EXPECT_THAT(error.line(), HasSubstr("found 2 of the channels normal.X"));
}

TEST(LightMapReader, FilesThatAreNoExrAreRefused) {
    const TemporaryFolder folder;
    EXPECT_THAT(refusal(folder / "absent.exr").line(), AllOf(HasSubstr("absent.exr"), HasSubstr("no such file")));
    EXPECT_EQ(refusal(folder.path()).code, ErrorCode::FileUnreadable) << "a folder";
    writeContent(folder / "text.exr", "this is not an image at all");
    EXPECT_THAT(refusal(folder / "text.exr").line(), HasSubstr("found the first bytes 74 68 69 73"));
    writeContent(folder / "short.exr", "v/1");
    EXPECT_THAT(refusal(folder / "short.exr").line(), HasSubstr("found 3 bytes"));
}

TEST(LightMapReader, TexturesAreRefusedByTheirContainer) {
    const TemporaryFolder folder;
    const TextureShape shape{PixelFormat::Rgba8Unorm, 4, 4};
    for (const auto& [file, container, name] :
         {std::tuple("map.ktx2", Container::Ktx2, "KTX2"), std::tuple("map.dds", Container::Dds, "DDS"),
          std::tuple("named.exr", Container::Ktx2, "KTX2")}) {
        TextureFileOptions options;
        options.container = container;
        ASSERT_TRUE(writePattern(folder / file, shape, options));
        const Error error = refusal(folder / file);
        EXPECT_EQ(error.code, ErrorCode::FormatUnsupported);
        EXPECT_THAT(error.line(), AllOf(HasSubstr(file), HasSubstr(std::string("found a GPU texture (") + name + ")"),
                                        HasSubstr("expected OpenEXR or Radiance HDR"), HasSubstr("`lightcook decode`")));
    }
}

/// Every action of a light map asks whether the bake has normals.
TEST(ReadsMesh, LooksIntoAFileOnceUntilItChanges) {
    const MapFile map(seededMap(4, 4));
    LightMapDescription description;
    description.mesh = map.folder / "mesh.glb";
    EXPECT_FALSE(readsMesh(map.path, description)) << "there is no mesh";
    writeContent(description.mesh, "mesh");
    const Opens opens(map.path);
    EXPECT_TRUE(readsMesh(map.path, description));
    EXPECT_GT(opens.count(), 0);
    EXPECT_TRUE(readsMesh(map.path, description));
    EXPECT_EQ(opens.count(), 0);
    ExrRecipe withNormals = seededMap(4, 4);
    for (const char* normal : {"normal.X", "normal.Y", "normal.Z"}) withNormals.channels[normal] = [](int, int) { return 1.0f; };
    writeRecipe(map.path, withNormals);
    EXPECT_FALSE(readsMesh(map.path, description));
}

TEST(LightMapReader, EncodedColoursAreRefused) {
    LightMapDescription encoded;
    encoded.colors.source = "srgb_texture";
    const MapFile map(seededMap(4, 4));
    EXPECT_EQ(refusal(map.path, encoded).code, ErrorCode::ColorSpace);
    EXPECT_THAT(refusal(map.path, encoded).line(), AllOf(HasSubstr("map.exr"), HasSubstr("'srgb_texture' is not linear")));
}

}  // namespace
}  // namespace lightcook::formats

// Light maps of Unreal in a glTF, cooked as a whole.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/command/info.h"
#include "pipeline/cook/cook.h"
#include "pipeline/manifest/manifest.h"
#include "tests/formats/unreal_fixture.h"

namespace lightcook::pipeline {
namespace {

using formats::UnrealConstants;
using formats::UnrealImage;
using formats::UnrealRectangle;
using testing::AllOf;
using testing::HasSubstr;

constexpr int kMapSide = 16;
constexpr UnrealRectangle kWhole = {0, 0, kMapSide, kMapSide}, kInner = {1, 1, kMapSide - 2, kMapSide - 2};

glm::dvec3 lightOf(int x, int y) {
    return glm::dvec3(0.2 + 0.05 * x, 0.3 + 0.03 * y, 0.5);
}

/// A scene with a light map for each image of a glTF: one of a whole image, one of a rectangle.
class UnrealScene {
public:
    UnrealScene() {
        nlohmann::json images = nlohmann::json::array(), maps = nlohmann::json::array();
        for (int i = 0; i < 2; ++i) {
            const std::string name = fmt::format("HQ_Lightmap{}", i);
            const UnrealRectangle part = i == 0 ? kWhole : kInner;
            UnrealImage image(kMapSide, kMapSide);
            const UnrealConstants constants = image.encode(part, lightOf);
            image.writeTo(*this / (name + ".png"));
            images.push_back({{"name", name}, {"uri", name + ".png"}});
            maps.push_back(formats::unrealLightMap(image, part, constants, i));
        }
        nlohmann::json gltf = formats::unrealGltf(std::move(images), std::move(maps));
        for (nlohmann::json& node : gltf["nodes"]) node["mesh"] = 0;
        addTriangle(gltf);
        formats::writeContent(*this / "level.gltf", gltf.dump());
        write("image = \"HQ_Lightmap0\"", "image = \"HQ_Lightmap1\"");
    }
    std::filesystem::path operator/(const std::string& name) const { return folder_ / name; }

    /// keys  of each light map
    void write(const std::string& first, const std::string& second) const {
        std::string text = "schema = 1\nname = \"level\"\n\n[output]\n";
        for (const auto& [name, keys] : {std::pair("hall", first), std::pair("yard", second)})
            text += fmt::format("\n[[light_map]]\nname = \"{}\"\nfile = \"level.gltf\"\n{}\n", name, keys);
        formats::writeContent(*this / "scene.toml", text);
    }
    Outcome cook() const {
        CookOptions options;
        options.scene = *this / "scene.toml";
        options.output = *this / "out";
        options.cache = *this / "cache";
        options.depfile = *this / "out.d";
        return cookScene(options, state_);
    }

private:
    /// Adds a mesh of one triangle with light-map UVs, in a file beside the glTF.
    void addTriangle(nlohmann::json& gltf) const {
        constexpr std::size_t kFloats = 9 + 6;
        formats::writeContent(*this / "level.bin", std::string(kFloats * sizeof(float), '\0'));
        gltf["buffers"] = nlohmann::json::array({{{"byteLength", kFloats * sizeof(float)}, {"uri", "level.bin"}}});
        gltf["bufferViews"] =
            nlohmann::json::array({{{"buffer", 0}, {"byteLength", 9 * sizeof(float)}},
                                   {{"buffer", 0}, {"byteOffset", 9 * sizeof(float)}, {"byteLength", 6 * sizeof(float)}}});
        gltf["accessors"] = nlohmann::json::array({{{"bufferView", 0}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}},
                                                   {{"bufferView", 1}, {"componentType", 5126}, {"count", 3}, {"type", "VEC2"}}});
        gltf["meshes"] =
            nlohmann::json::array({{{"primitives", nlohmann::json::array({{{"attributes", {{"POSITION", 0}, {"TEXCOORD_1", 1}}}}})}}});
    }

    formats::TemporaryFolder folder_;
    RunState state_;
};

TEST(UnrealFiles, ALightMapIsCookedForEachImageOfAGltf) {
    const UnrealScene scene;
    const Outcome outcome = scene.cook();
    ASSERT_TRUE(outcome.errors.empty()) << outcome.errors.front().line();
    const auto manifest = readManifest(scene / "out");
    ASSERT_TRUE(manifest) << manifest.error().line();
    int lightMaps = 0;
    for (const Json& asset : manifest->at("assets")) {
        EXPECT_NE(asset.at("kind"), "dominant") << "no light has a direction";
        if (asset.at("kind") != "light-map") continue;
        ++lightMaps;
        EXPECT_EQ(asset.at("layout"), "flat");
        EXPECT_EQ(asset.at("width"), kMapSide);
        EXPECT_EQ(asset.at("height"), kMapSide) << "half of the image's";
    }
    EXPECT_EQ(lightMaps, 2);
    EXPECT_EQ(manifest->at("assets")[1].at("source").at("description").at("image"), "HQ_Lightmap1");
    VerifyOptions verify;
    verify.folder = scene / "out";
    const Outcome verified = verifyCooked(verify, {});
    EXPECT_TRUE(verified.errors.empty()) << verified.errors.front().line();
    const std::string depfile = formats::contentOf(scene / "out.d");
    for (const char* name : {"level.gltf", "level.bin", "HQ_Lightmap0.png"}) EXPECT_THAT(depfile, HasSubstr((scene / name).string()));
    EXPECT_EQ(scene.cook().actionsRun, 0);
    UnrealImage other(kMapSide, kMapSide);
    other.encode(kWhole, [](int x, int y) { return 1.5 * lightOf(y, x); });
    other.writeTo(scene / "HQ_Lightmap0.png");
    EXPECT_GT(scene.cook().actionsRun, 0) << "an image changed";
}

TEST(UnrealFiles, AnImageHasToBeChosenAndNoMeshMayHaveUvsOfItsOwn) {
    const UnrealScene scene;
    scene.write("", "image = \"HQ_Lightmap1\"");
    Outcome outcome = scene.cook();
    ASSERT_FALSE(outcome.errors.empty());
    EXPECT_EQ(outcome.errors.front().code, formats::ErrorCode::InvalidRequest);
    EXPECT_THAT(outcome.errors.front().line(), HasSubstr("expected one of them: image = \"HQ_Lightmap0\" or image = \"HQ_Lightmap1\""));
    scene.write("image = \"HQ_Lightmap0\"", "image = \"HQ_Lightmap1\"\nmesh = \"level.gltf\"");
    outcome = scene.cook();
    ASSERT_FALSE(outcome.errors.empty());
    EXPECT_EQ(outcome.errors.front().code, formats::ErrorCode::FormatUnsupported);
    EXPECT_THAT(
        outcome.errors.front().line(),
        AllOf(HasSubstr("level.gltf, node 0 'Wall_0': found light map \"HQ_Lightmap0\" of a node of `mesh`, expected \"HQ_Lightmap1\""),
              HasSubstr("Remove `mesh`")));
    LintOptions lint;
    lint.scene = scene / "scene.toml";
    lint.cache = scene / "cache";
    const Outcome linted = lintScene(lint, {});
    ASSERT_FALSE(linted.errors.empty());
    EXPECT_THAT(linted.errors.front().line(), HasSubstr("Remove `mesh`"));
}

TEST(UnrealFiles, InfoListsTheLightMapsOfAGltf) {
    const UnrealScene scene;
    std::filesystem::resize_file(scene / "HQ_Lightmap1.png", 100);
    const auto facts = describeFile(scene / "level.gltf");
    ASSERT_TRUE(facts) << facts.error().line();
    EXPECT_EQ(facts->at("triangles"), 1);
    const Json& maps = facts->at("as_light_maps");
    ASSERT_EQ(maps.size(), 2u);
    EXPECT_EQ(maps[0].at("image"), "HQ_Lightmap0");
    EXPECT_EQ(maps[0].at("light_map"), "unreal-hq");
    EXPECT_EQ(maps[0].at("height"), kMapSide);
    EXPECT_THAT(maps[0].at("assumed").dump(), HasSubstr("0.6"));
    EXPECT_THAT(maps[1].at("error").get<std::string>(), HasSubstr("level.gltf, image 1: found"));
}

}  // namespace
}  // namespace lightcook::pipeline

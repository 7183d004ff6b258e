#include "formats/gltf/light_map_uvs.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <numbers>

#include "formats/gltf_scene.h"
#include "tests/formats/gltf/quad_scene.h"

namespace lightcook::formats {
namespace {

using nlohmann::json;
using testing::HasSubstr;

constexpr QuadScene::Encoding kUint16 = {5123, 1, true};

class LightMapUvSets : public testing::Test {
protected:
    Result<GltfScene> load(const QuadScene& quads) const {
        quads.write(folder_ / "scene.glb");
        return GltfScene::load(folder_ / "scene.glb");
    }
    /// Returns the lowest and the highest light-map UV of each mesh.
    static std::vector<std::string> boxesOf(const Result<GltfScene>& scene) {
        if (!scene) return {scene.error().line()};
        std::vector<std::string> boxes;
        for (const TriangleMesh* mesh : scene->triangleMeshes()) {
            const MeshAttribute* const uvs = mesh->find("TEXCOORD_1");
            if (uvs == nullptr) {
                boxes.emplace_back("none");
                continue;
            }
            glm::dvec2 low(1e9), high(-1e9);
            for (std::size_t i = 0; i < uvs->vertexCount(); ++i) {
                low = {std::min(low.x, uvs->at(i).x), std::min(low.y, uvs->at(i).y)};
                high = {std::max(high.x, uvs->at(i).x), std::max(high.y, uvs->at(i).y)};
            }
            boxes.push_back(fmt::format("{:.3f} {:.3f} to {:.3f} {:.3f}", low.x + 0.0, low.y, high.x, high.y));
        }
        return boxes;
    }
    /// Returns the JSON of the scene as it is written.
    json written(const GltfScene& scene) const {
        EXPECT_TRUE(scene.writePlain(folder_ / "written.glb", nullptr));
        const std::string bytes = contentOf(folder_ / "written.glb");
        std::uint32_t length = 0;
        std::memcpy(&length, bytes.data() + 12, 4);
        return json::parse(bytes.substr(20, length));
    }
    static json transform(std::array<double, 2> offset, std::array<double, 2> scale, double rotation = 0) {
        return {{"KHR_texture_transform", {{"offset", offset}, {"scale", scale}, {"rotation", rotation}}}};
    }
    static QuadScene quad(const glm::dvec2& low, const glm::dvec2& high, const QuadScene::Encoding& uvs = {}) {
        QuadScene scene;
        scene.uvs = uvs;
        scene.add({"floor", low, high});
        scene.json["textures"] = json::array({json::object()});
        return scene;
    }
    TemporaryFolder folder_;
};

TEST_F(LightMapUvSets, ATransformOfQuantizedUvsIsApplied) {
    QuadScene scene = quad({0.1, 0.2}, {0.2, 0.4}, kUint16);
    scene.json["materials"][0]["occlusionTexture"] = {{"index", 0}, {"texCoord", 1}, {"extensions", transform({0.05, 0.1}, {2, 1.5})}};
    scene.json["extensionsUsed"] = {"KHR_texture_transform"};
    const auto loaded = load(scene);
    EXPECT_THAT(boxesOf(loaded), testing::ElementsAre("0.250 0.400 to 0.450 0.700"));
    // The texture shows what it did: its transform is in the UVs.
    const json out = written(*loaded);
    EXPECT_EQ(out["materials"][0]["occlusionTexture"], json({{"index", 0}, {"texCoord", 1}}));
    EXPECT_FALSE(out["meshes"][0]["primitives"][0]["attributes"].contains("TEXCOORD_2"));
    EXPECT_EQ(out.value("extensionsUsed", json::array()), json::array({"KHR_mesh_quantization"}));
}

TEST_F(LightMapUvSets, IntegersThatAreNotNormalizedAreTransformedToo) {
    QuadScene scene = quad({0.1, 0.2}, {0.2, 0.4}, {5123, 1000, false});
    scene.json["materials"][0]["occlusionTexture"] = {{"index", 0}, {"texCoord", 1}, {"extensions", transform({0, 0.5}, {0.001, 0.001})}};
    EXPECT_THAT(boxesOf(load(scene)), testing::ElementsAre("0.100 0.700 to 0.200 0.900"));
}

TEST_F(LightMapUvSets, ATransformMirrorsAndTurns) {
    QuadScene scene = quad({0.1, 0.2}, {0.2, 0.4}, kUint16);
    json& texture = scene.json["materials"][0]["occlusionTexture"];
    texture = {{"index", 0}, {"texCoord", 1}, {"extensions", transform({0, 1}, {1, -1})}};
    EXPECT_THAT(boxesOf(load(scene)), testing::ElementsAre("0.100 0.600 to 0.200 0.800"));
    // The example of the extension: the lower left quadrant, turned.
    texture["extensions"] = transform({0, 1}, {0.5, 0.5}, std::numbers::pi / 2);
    EXPECT_THAT(boxesOf(load(scene)), testing::ElementsAre("0.100 0.900 to 0.200 0.950"));
}

TEST_F(LightMapUvSets, TheSetOfATransformGoesBeforeThatOfItsTexture) {
    QuadScene scene = quad({0.1, 0.2}, {0.2, 0.4}, kUint16);
    json& texture = scene.json["materials"][0]["occlusionTexture"];
    texture = {{"index", 0}, {"texCoord", 0}, {"extensions", transform({0, 0}, {2, 2})}};
    EXPECT_THAT(boxesOf(load(scene)), testing::ElementsAre("0.100 0.200 to 0.200 0.400")) << "it is of TEXCOORD_0";
    texture["extensions"]["KHR_texture_transform"]["texCoord"] = 1;
    EXPECT_THAT(boxesOf(load(scene)), testing::ElementsAre("0.200 0.400 to 0.400 0.800"));
}

TEST_F(LightMapUvSets, GltfpackTransformsAllSetsAlike) {
    QuadScene scene = quad({0.1, 0.2}, {0.2, 0.4}, kUint16);
    const auto base = scene.accessor({0, 0, 0.5, 0, 0.5, 0.5, 0, 0.5}, 2, kUint16);
    scene.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = base;
    scene.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}, {"extensions", transform({0, 0}, {2, 2})}};
    EXPECT_THAT(boxesOf(load(scene)), testing::ElementsAre("0.100 0.200 to 0.200 0.400")) << "it tiles a texture";
    scene.json["asset"]["generator"] = "gltfpack 1.0";
    EXPECT_THAT(boxesOf(load(scene)), testing::ElementsAre("0.200 0.400 to 0.400 0.800"));
}

TEST_F(LightMapUvSets, ATransformOverFloatsTilesATexture) {
    QuadScene scene = quad({0.1, 0.2}, {0.2, 0.4});
    scene.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {
        {"index", 0}, {"texCoord", 1}, {"extensions", transform({0, 0}, {8, 8})}};
    const auto loaded = load(scene);
    EXPECT_THAT(boxesOf(loaded), testing::ElementsAre("0.100 0.200 to 0.200 0.400"));
    EXPECT_EQ(written(*loaded)["materials"], scene.json["materials"]);
}

TEST_F(LightMapUvSets, TheLightMapOfTheMaterialNamesItsSet) {
    QuadScene scene = quad({0.1, 0.2}, {0.2, 0.4});
    json& attributes = scene.json["meshes"][0]["primitives"][0]["attributes"];
    const std::size_t old = attributes["TEXCOORD_1"].get<std::size_t>();
    attributes["TEXCOORD_2"] = scene.accessor({0.5, 0.5, 0.75, 0.5, 0.75, 1, 0.5, 1}, 2, {});
    scene.json["materials"][0]["extensions"]["MOZ_lightmap"] = {{"index", 0}, {"texCoord", 2}};
    scene.json["materials"][0]["occlusionTexture"] = {{"index", 0}, {"texCoord", 1}};
    const auto loaded = load(scene);
    EXPECT_THAT(boxesOf(loaded), testing::ElementsAre("0.500 0.500 to 0.750 1.000"));
    const json out = written(*loaded);
    EXPECT_EQ(out["materials"][0]["extensions"]["MOZ_lightmap"]["texCoord"], 1);
    EXPECT_EQ(out["materials"][0]["occlusionTexture"]["texCoord"], 3) << "it needs the old TEXCOORD_1";
    EXPECT_EQ(out["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_3"], old);

    // Its own transform counts, also over floats.
    scene.json["materials"][0]["extensions"]["MOZ_lightmap"]["extensions"] = transform({0, 0.1}, {0.5, 0.5});
    EXPECT_THAT(boxesOf(load(scene)), testing::ElementsAre("0.250 0.350 to 0.375 0.600"));
    scene.json["materials"][0]["extensions"]["MOZ_lightmap"]["texCoord"] = 5;
    EXPECT_THAT(boxesOf(load(scene)), testing::ElementsAre(HasSubstr("mesh 0, primitive 0: found no TEXCOORD_5, which MOZ_lightmap")));
}

TEST_F(LightMapUvSets, TheFirstSetMayBeThatOfTheLightMap) {
    QuadScene scene = quad({0.1, 0.2}, {0.2, 0.4});
    scene.json["meshes"][0]["primitives"][0]["attributes"].erase("TEXCOORD_1");
    scene.json["materials"][0]["extensions"]["MOZ_lightmap"] = {{"index", 0}};
    EXPECT_THAT(boxesOf(load(scene)), testing::ElementsAre("0.000 0.000 to 1.000 1.000"));
    EXPECT_TRUE(checkLightMapUvs(folder_ / "scene.glb"));
}

TEST_F(LightMapUvSets, AMaterialThatOthersNeedAsItIsBecomesACopy) {
    QuadScene scene = quad({0.1, 0.2}, {0.2, 0.4}, kUint16);
    scene.uvs = {};
    scene.add({"wall", {0.5, 0.5}, {1, 1}});
    scene.json["materials"][0]["occlusionTexture"] = {{"index", 0}, {"texCoord", 1}, {"extensions", transform({0, 0}, {2, 2})}};
    scene.uvs = kUint16;  // for the extension
    const auto loaded = load(scene);
    EXPECT_THAT(boxesOf(loaded), testing::ElementsAre("0.200 0.400 to 0.400 0.800", "0.500 0.500 to 1.000 1.000"));
    const json out = written(*loaded);
    EXPECT_EQ(out["materials"].size(), 2u);
    EXPECT_EQ(out["materials"][0], scene.json["materials"][0]);
    EXPECT_EQ(out["meshes"][0]["primitives"][0]["material"], 1);
    EXPECT_EQ(out["meshes"][1]["primitives"][0]["material"], 0);
}

TEST_F(LightMapUvSets, DracoStreamsAreTransformedToo) {
    quad({0.1, 0.2}, {0.2, 0.4}, kUint16).write(folder_ / "plain.glb");
    ASSERT_TRUE(GltfScene::load(folder_ / "plain.glb")->writeDraco(folder_ / "draco.glb", {}));
    const std::string bytes = contentOf(folder_ / "draco.glb");
    std::uint32_t length = 0;
    std::memcpy(&length, bytes.data() + 12, 4);
    json out = json::parse(bytes.substr(20, length));
    out["textures"] = json::array({json::object()});
    out["materials"][0]["occlusionTexture"] = {{"index", 0}, {"texCoord", 1}, {"extensions", transform({0, 0}, {2, 2})}};
    out["images"] = json::array({{{"uri", "beside.png"}}});
    writeContent(folder_ / "beside.png", "\x89PNG of sorts");
    writeContent(folder_ / "scene.glb", glbOf(out.dump(), bytes.substr(28 + length)));
    const auto scene = GltfScene::load(folder_ / "scene.glb");
    EXPECT_THAT(boxesOf(scene), testing::ElementsAre("0.200 0.400 to 0.400 0.800"));
    const TemporaryFolder elsewhere;
    ASSERT_TRUE(scene->writePlain(elsewhere / "scene.glb", nullptr));
    EXPECT_THAT(contentOf(elsewhere / "scene.glb"), HasSubstr("\x89PNG of sorts")) << "an image beside the source";

    out["meshes"][0]["primitives"][0]["targets"] = json::array({{{"POSITION", 0}}});
    writeContent(folder_ / "scene.glb", glbOf(out.dump(), bytes.substr(28 + length)));
    EXPECT_THAT(boxesOf(GltfScene::load(folder_ / "scene.glb")),
                testing::ElementsAre(HasSubstr("mesh 0, primitive 0: found a Draco stream that cannot be coded anew")));
}

}  // namespace
}  // namespace lightcook::formats

#include "formats/gltf/scene_rules.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "formats/gltf_scene.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::formats {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

/// Returns the error of loading a scene of one mesh without geometry; empty if it loads.
/// changes  members that replace those of the scene
std::string refusalOfScene(const nlohmann::json& changes) {
    nlohmann::json scene = {{"asset", {{"version", "2.0"}}},
                            {"meshes", {{{"primitives", nlohmann::json::array()}}}},
                            {"textures", nlohmann::json::array({nlohmann::json::object()})}};
    scene.update(changes);
    const TemporaryFolder folder;
    writeContent(folder / "scene.gltf", scene.dump());
    const auto loaded = GltfScene::load(folder / "scene.gltf");
    return loaded ? "" : loaded.error().line();
}

std::string refusalOfNodes(const nlohmann::json& nodes) {
    return refusalOfScene({{"nodes", nodes}});
}

std::string refusalOfMaterial(const nlohmann::json& material) {
    return refusalOfScene({{"materials", nlohmann::json::array({material})}});
}

TEST(SceneRules, NodesAreTrees) {
    EXPECT_THAT(refusalOfNodes({{{"children", {1, 2}}}, {{"children", {3}}}, {{"mesh", 0}}, {{"mesh", 0}}}), IsEmpty());
    EXPECT_THAT(refusalOfNodes({{{"children", {0}}}}), HasSubstr("node 0: found the node below itself, expected a tree"));
    EXPECT_THAT(refusalOfNodes({{{"mesh", 0}}, {{"children", {2}}}, {{"children", {3}}}, {{"children", {1}}}}),
                HasSubstr("found the node below itself, expected a tree"));
    EXPECT_THAT(refusalOfNodes({{{"children", {2}}}, {{"children", {2}}}, {{"mesh", 0}}}),
                HasSubstr("node 1: found child 2, which is one of node 0 too, expected a tree"));
    EXPECT_THAT(refusalOfNodes({{{"children", {7}}}}), HasSubstr("node 0: found child 7, expected a node below 1"));
    EXPECT_THAT(refusalOfNodes({{{"children", {-1}}}}), HasSubstr("node 0: found child -1"));
    EXPECT_THAT(refusalOfNodes({{{"mesh", 1}}}), HasSubstr("node 0: found mesh = 1, expected less than 1"));
}

TEST(SceneRules, TransformsAreWhole) {
    EXPECT_THAT(refusalOfNodes({{{"translation", {1, 2, 3}}, {"rotation", {0, 0.6, 0, 0.8}}, {"scale", {1, -1, 1}}}}), IsEmpty());
    EXPECT_THAT(refusalOfNodes({{{"scale", {1, 2}}}}), HasSubstr("node 0: found scale = [1,2], expected 3 numbers"));
    EXPECT_THAT(refusalOfNodes({{{"matrix", 1}}}), HasSubstr("node 0: found matrix = 1, expected 16 numbers"));
    EXPECT_THAT(refusalOfNodes({{{"rotation", {0, 0, 0, 2}}}}), HasSubstr("found a rotation of length 2, expected a unit quaternion"));
}

TEST(SceneRules, FactorsOfMaterialsLieInTheirRanges) {
    EXPECT_THAT(refusalOfMaterial({{"pbrMetallicRoughness", {{"roughnessFactor", 1}, {"metallicFactor", 0.0}}},
                                   {"normalTexture", {{"index", 0}}},
                                   {"extensions",
                                    {{"KHR_materials_ior", {{"ior", 0}}},
                                     {"KHR_materials_specular", {{"specularFactor", 1}, {"specularColorFactor", {1, 2, 30}}}}}}}),
                IsEmpty());
    EXPECT_THAT(refusalOfMaterial({{"pbrMetallicRoughness", {{"roughnessFactor", 5}}}}),
                HasSubstr("material 0: found roughnessFactor = 5, expected 0 to 1"));
    EXPECT_THAT(refusalOfMaterial({{"pbrMetallicRoughness", {{"roughnessFactor", "rough"}}}}),
                HasSubstr("material 0: found roughnessFactor = \"rough\", expected 0 to 1"));
    EXPECT_THAT(refusalOfMaterial({{"pbrMetallicRoughness", {{"metallicFactor", -3}}}}), HasSubstr("found metallicFactor = -3"));
    EXPECT_THAT(refusalOfMaterial({{"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1}}}}}), HasSubstr("expected 4 numbers"));
    EXPECT_THAT(refusalOfMaterial({{"extensions", {{"KHR_materials_ior", {{"ior", 0.2}}}}}}),
                HasSubstr("found ior = 0.2, expected at least 1"));
    EXPECT_THAT(refusalOfMaterial({{"extensions", {{"KHR_materials_specular", {{"specularFactor", -1}}}}}}),
                HasSubstr("found specularFactor = -1, expected 0 to 1"));
    const auto refusalOfExtension = [](const char* name, const nlohmann::json& extension) {
        return refusalOfMaterial({{"extensions", {{name, extension}}}});
    };
    constexpr const char *kClearcoat = "KHR_materials_clearcoat", *kGlossiness = "KHR_materials_pbrSpecularGlossiness";
    EXPECT_THAT(refusalOfExtension(kClearcoat, {{"clearcoatFactor", 1}, {"clearcoatRoughnessFactor", 0}}), IsEmpty());
    EXPECT_THAT(refusalOfExtension(kClearcoat, {{"clearcoatFactor", 2}}), HasSubstr("found clearcoatFactor = 2, expected 0 to 1"));
    EXPECT_THAT(refusalOfExtension(kClearcoat, {{"clearcoatRoughnessFactor", -1}}), HasSubstr("found clearcoatRoughnessFactor = -1"));
    EXPECT_THAT(refusalOfExtension(kClearcoat, {{"clearcoatNormalTexture", {{"index", 1}}}}),
                HasSubstr("material 0, clearcoatNormalTexture: found index = 1, expected less than 1"));
    EXPECT_THAT(refusalOfExtension(kGlossiness, {{"specularFactor", {1, 0.5, 0}}, {"glossinessFactor", 1}}), IsEmpty());
    EXPECT_THAT(refusalOfExtension(kGlossiness, {{"specularFactor", {1, 2, 0}}}), HasSubstr("found specularFactor = 2, expected 0 to 1"));
    EXPECT_THAT(refusalOfExtension(kGlossiness, {{"glossinessFactor", 2}}), HasSubstr("found glossinessFactor = 2, expected 0 to 1"));
    EXPECT_THAT(refusalOfMaterial({{"normalTexture", {{"index", 1}}}}),
                HasSubstr("material 0, normalTexture: found index = 1, expected less than 1"));
}

TEST(SceneRules, RequiredExtensionsAreKnown) {
    EXPECT_THAT(refusalOfScene({{"extensionsRequired", {"KHR_mesh_quantization", "KHR_texture_basisu", "KHR_materials_unlit"}}}),
                IsEmpty());
    EXPECT_THAT(refusalOfScene({{"extensionsRequired", {"EXT_mesh_gpu_instancing"}}}),
                HasSubstr("extensionsRequired: found EXT_mesh_gpu_instancing, expected a scene that can be read without it"));
}

}  // namespace
}  // namespace lightcook::formats

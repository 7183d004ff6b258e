#include "formats/gltf/lmbake_nodes.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "formats/gltf_scene.h"
#include "tests/formats/gltf/glb.h"
#include "tests/formats/lmbake_fixture.h"

namespace lightcook::formats {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

/// A node of a scene. Each mesh is a triangle with light-map UVs at (0, 0), (1, 0) and (0.5, 1); mesh 1 lies at x = 1.
struct NodeOfScene {
    std::string name;
    int parent = -1, mesh = -1;
};

void writeScene(const std::filesystem::path& file, const std::vector<NodeOfScene>& nodes) {
    using Json = nlohmann::json;
    Json list = Json::array(), roots = Json::array();
    for (const NodeOfScene& node : nodes) {
        list.push_back({{"name", node.name}});
        if (node.mesh >= 0) list.back()["mesh"] = node.mesh;
        const auto index = list.size() - 1;
        if (node.parent < 0)
            roots.push_back(index);
        else
            list[static_cast<std::size_t>(node.parent)]["children"].push_back(index);
    }
    const std::array<float, 24> values = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 0, 0, 2, 0, 0, 1, 1, 0, 0, 0, 1, 0, 0.5f, 1};
    const auto mesh = [](int position) { return Json{{"primitives", {{{"attributes", {{"POSITION", position}, {"TEXCOORD_1", 2}}}}}}}; };
    const Json gltf = {{"asset", {{"version", "2.0"}}},
                       {"scene", 0},
                       {"scenes", {{{"nodes", roots}}}},
                       {"nodes", list},
                       {"meshes", {mesh(0), mesh(1)}},
                       {"buffers", {{{"byteLength", sizeof values}}}},
                       {"bufferViews", {{{"buffer", 0}, {"byteLength", sizeof values}}}},
                       {"accessors",
                        {{{"bufferView", 0}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}},
                         {{"bufferView", 0}, {"byteOffset", 36}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}},
                         {{"bufferView", 0}, {"byteOffset", 72}, {"componentType", 5126}, {"count", 3}, {"type", "VEC2"}}}}};
    writeContent(file, glbOf(gltf.dump(), std::string(reinterpret_cast<const char*>(values.data()), sizeof values)));
}

class LmbakeNodes : public testing::Test {
protected:
    Result<GltfScene> load(const std::vector<NodeOfScene>& nodes, const std::vector<GodotMesh>& meshes) const {
        writeScene(folder_ / "level.glb", nodes);
        GodotBake{.meshes = meshes}.write(folder_ / "level.lmbake");
        return GltfScene::load(folder_ / "level.glb", folder_ / "level.lmbake");
    }
    /// Returns the lowest and the highest UV of each drawn triangle, as text; "none" without UVs.
    static std::vector<std::string> boxesOf(const GltfScene& scene) {
        std::vector<std::string> boxes;
        for (const GltfScene::Placed& placed : scene.placedMeshes()) {
            const MeshAttribute* const uv = placed.mesh->find("TEXCOORD_1");
            boxes.push_back(uv == nullptr ? "none" : fmt::format("{} {} to {} {}", uv->at(0).x, uv->at(0).y, uv->at(1).x, uv->at(2).y));
        }
        return boxes;
    }
    TemporaryFolder folder_;
};

TEST_F(LmbakeNodes, EachNodeLiesInItsRectangleOfItsSlice) {
    const auto scene =
        load({{"Root"}, {"Left", 0, 0}, {"Right", 0, 0}, {"Floor", 0, 1}},
             {{{"..", "Left"}, 0.25, 0.5, 0.5, 0.25, 0}, {{"..", "Right"}, 0, 0, 1, 0.5, 1}, {{"..", "Floor"}, 0.5, 0, 0.5, 1, 1}});
    ASSERT_TRUE(scene) << scene.error().line();
    EXPECT_THAT(boxesOf(*scene), UnorderedElementsAre("0.25 0.25 to 0.75 0.375", "0 0.5 to 1 0.75", "0.5 0.5 to 1 1"))
        << "slice 1 of 2 is the lower half";
    ASSERT_TRUE(scene->lmbakeMatch());
    EXPECT_EQ(scene->lmbakeMatch()->placed, 3u);
    EXPECT_THAT(scene->lmbakeMatch()->unplaced, IsEmpty());
    EXPECT_THAT(scene->lmbakeMatch()->unread, IsEmpty());
    EXPECT_FALSE(GltfScene::load(folder_ / "level.glb", {})->lmbakeMatch());

    // The written files have them, plain and as Draco.
    ASSERT_TRUE(scene->writePlain(folder_ / "plain.glb", nullptr));
    ASSERT_TRUE(scene->writeDraco(folder_ / "draco.glb", {}));
    const auto plain = GltfScene::load(folder_ / "plain.glb"), draco = GltfScene::load(folder_ / "draco.glb");
    ASSERT_TRUE(plain && draco);
    EXPECT_EQ(boxesOf(*plain), boxesOf(*scene));
    const auto error = scene->errorOf(*draco);
    ASSERT_TRUE(error) << error.error().line();
    EXPECT_LT(error->lightMapUv, 1e-4);
    EXPECT_GT(error->lightMapUv, 0) << "UVs of Draco are rounded";
}

TEST_F(LmbakeNodes, ADracoStreamIsPlacedToo) {
    writeScene(folder_ / "source.glb", {{"Left", -1, 0}, {"Right", -1, 0}});
    ASSERT_TRUE(GltfScene::load(folder_ / "source.glb")->writeDraco(folder_ / "level.glb", {}));
    GodotBake{.meshes = {{{"..", "Left"}, 0, 0, 0.5, 1}, {{"..", "Right"}, 0.5, 0, 0.5, 1}}}.write(folder_ / "level.lmbake");
    const auto scene = GltfScene::load(folder_ / "level.glb", folder_ / "level.lmbake");
    ASSERT_TRUE(scene) << scene.error().line();
    std::map<double, double> ranges;  // of u, by the lowest
    for (const GltfScene::Placed& placed : scene->placedMeshes()) {
        double low = 1, high = 0;
        const MeshAttribute& uv = *placed.mesh->find("TEXCOORD_1");
        for (std::size_t vertex = 0; vertex < uv.vertexCount(); ++vertex) {
            low = std::min(low, uv.at(vertex).x);
            high = std::max(high, uv.at(vertex).x);
        }
        ranges[low] = high;
    }
    ASSERT_EQ(ranges.size(), 2u);
    EXPECT_NEAR(ranges.begin()->second, 0.5, 1e-4);
    EXPECT_NEAR(ranges.rbegin()->first, 0.5, 1e-4);
}

TEST_F(LmbakeNodes, PathsBeginWhereMostOfThemFit) {
    const std::vector<NodeOfScene> house = {{"House"},    {"Hall", 0},    {"Wall", 1, 0}, {"Floor", 1, 1},
                                            {"Attic", 0}, {"Wall", 4, 0}, {"Wall", 0, 1}};
    // Below the root of an exported scene: the wall of the house is none of its rooms'.
    auto scene = load(house, {{{"..", "Hall", "Wall"}, 0, 0, 0.25, 1},
                              {{"..", "Hall", "Floor"}, 0.25, 0, 0.25, 1},
                              {{"..", "Attic", "Wall"}, 0.5, 0, 0.25, 1},
                              {{"..", "Wall"}, 0.75, 0, 0.25, 1}});
    ASSERT_TRUE(scene) << scene.error().line();
    EXPECT_EQ(scene->lmbakeMatch()->placed, 4u);
    EXPECT_THAT(boxesOf(*scene), UnorderedElementsAre("0 0 to 0.25 1", "0.25 0 to 0.5 1", "0.5 0 to 0.75 1", "0.75 0 to 1 1"));

    // A node LightmapGI inside the hall: more paths fit there than below the house.
    scene = load(house, {{{"..", "Wall"}, 0, 0, 0.5, 1}, {{"..", "Floor"}, 0.5, 0, 0.5, 1}});
    ASSERT_TRUE(scene) << scene.error().line();
    EXPECT_THAT(scene->lmbakeMatch()->unplaced, UnorderedElementsAre("House/Attic/Wall", "House/Wall"));
    EXPECT_THAT(boxesOf(*scene), UnorderedElementsAre("0 0 to 0.5 1", "0.5 0 to 1 1", "none", "none"));

    // The glTF is a part of the scene.
    scene = load({{"Wall", -1, 0}, {"Floor", -1, 1}}, {{{"..", "Rooms", "hall", "Wall"}, 0, 0, 0.5, 1},
                                                       {{"..", "Rooms", "hall", "Floor"}, 0.5, 0, 0.5, 1},
                                                       {{"..", "Rooms", "attic", "Wall"}, 0, 0, 0.5, 1, 1}});
    ASSERT_TRUE(scene) << scene.error().line();
    EXPECT_EQ(scene->lmbakeMatch()->placed, 2u);
    EXPECT_THAT(scene->lmbakeMatch()->unread, ElementsAre("../Rooms/attic/Wall"));
}

TEST_F(LmbakeNodes, WhatFitsSeveralIsNotGuessed) {
    // Two rooms fit alike.
    auto scene = load({{"A"}, {"Wall", 0, 0}, {"B"}, {"Wall", 2, 0}, {"Floor", -1, 1}},
                      {{{"..", "Wall"}, 0, 0, 0.5, 1}, {{"..", "..", "Floor"}, 0.5, 0, 0.5, 1}});
    ASSERT_TRUE(scene) << scene.error().line();
    EXPECT_THAT(scene->lmbakeMatch()->unplaced, UnorderedElementsAre("A/Wall", "B/Wall"));
    EXPECT_THAT(scene->lmbakeMatch()->unread, ElementsAre("../Wall"));
    // Nodes of one name beside each other, a mesh of several, and two rectangles for a node.
    scene = load({{"Wall", -1, 0}, {"Wall", -1, 0}, {"Floor", -1, 1}, {"Grid", -1, 1}, {"Door", -1, 1}},
                 {{{"..", "Wall"}}, {{"..", "Floor"}}, {{"..", "Grid"}, 0, 0, 1, 1, 0, 3}, {{"..", "Door"}}, {{"..", "Door"}}});
    ASSERT_TRUE(scene) << scene.error().line();
    EXPECT_THAT(scene->lmbakeMatch()->unplaced, UnorderedElementsAre("Wall", "Wall", "Grid", "Door"));
    EXPECT_THAT(scene->lmbakeMatch()->unread, ElementsAre("../Wall", "../Grid, mesh 3", "../Door", "../Door"));
}

TEST_F(LmbakeNodes, NamesAreThoseThatGodotGivesThem) {
    const auto scene = load({{"Cube.001", -1, 0}}, {{{"..", "Cube_001"}, 0, 0, 0.5, 1}});
    ASSERT_TRUE(scene) << scene.error().line();
    EXPECT_EQ(scene->lmbakeMatch()->placed, 1u);
}

TEST_F(LmbakeNodes, AMeshWithoutAnyNodeOfTheBakeIsRefused) {
    const auto scene = load({{"Wall", -1, 0}}, {{{"..", "Room", "Floor"}}});
    ASSERT_FALSE(scene);
    EXPECT_THAT(
        scene.error().line(),
        AllOf(HasSubstr("level.glb, nodes: found none of the 1 nodes of level.lmbake (the first is '../Room/Floor') among the 1 with "
                        "light-map UVs (the first is 'Wall'), expected the scene that Godot baked"),
              HasSubstr("lmbake = \"none\"")));
}

/// A small file whose nodes draw one mesh: each would need UVs of its own.
TEST_F(LmbakeNodes, ManyNodesOfOneNameDoNotTakeForever) {
    constexpr int kCount = 2100;
    const auto scene = load(std::vector<NodeOfScene>(kCount, {"Wall", -1, 0}), std::vector<GodotMesh>(kCount, {{"..", "Wall"}}));
    ASSERT_FALSE(scene);
    EXPECT_THAT(scene.error().line(), HasSubstr("pairs of a node and an entry of the lmbake with the same name"));
}

}  // namespace
}  // namespace lightcook::formats

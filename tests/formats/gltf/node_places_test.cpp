#include "formats/gltf/node_places.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "formats/gltf_scene.h"
#include "tests/formats/gltf/quad_scene.h"

namespace lightcook::formats {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

class NodePlaces : public testing::Test {
protected:
    NodePlaces() {
        quads_.add({"Floor"});
        quads_.add({"Wall"});
        quads_.add({"Lamp", {0, 0}, {1, 1}, false});
    }
    Result<GltfScene> load(const std::vector<NodePlace>& places) const {
        quads_.write(folder_ / "room.glb");
        return GltfScene::load(folder_ / "room.glb", {}, places);
    }
    /// Returns the light-map UVs of two opposite corners of each drawn quad; "none" without UVs.
    static std::vector<std::string> boxesOf(const Result<GltfScene>& scene) {
        if (!scene) return {scene.error().line()};
        std::vector<std::string> boxes;
        for (const GltfScene::Placed& placed : scene->placedMeshes()) {
            const MeshAttribute* const uv = placed.mesh->find("TEXCOORD_1");
            boxes.push_back(uv == nullptr ? "none" : fmt::format("{} {} to {} {}", uv->at(0).x, uv->at(0).y, uv->at(2).x, uv->at(2).y));
        }
        return boxes;
    }
    QuadScene quads_;
    TemporaryFolder folder_;
};

TEST_F(NodePlaces, AMapLiesOnTheNodesThatHaveAPlace) {
    const auto floor = load({{"Floor", {0.5, 0.25}, {0.25, 0.5}}});
    EXPECT_THAT(boxesOf(floor), ElementsAre("0.25 0.5 to 0.75 0.75"));
    EXPECT_THAT(floor->nodesWithoutPlace(), ElementsAre("Wall")) << "the lamp has no light-map UVs";
    EXPECT_TRUE(floor->hasLightMapUvs());
    // The others are gone from what is written, with their values.
    ASSERT_TRUE(floor->writeDraco(folder_ / "floor.glb", {}));
    const auto written = GltfScene::load(folder_ / "floor.glb");
    ASSERT_TRUE(written) << written.error().line();
    EXPECT_EQ(written->triangleCount(), 2);
    ASSERT_TRUE(load({})->writeDraco(folder_ / "all.glb", {}));
    EXPECT_LT(std::filesystem::file_size(folder_ / "floor.glb") + 200, std::filesystem::file_size(folder_ / "all.glb"));
    const auto error = floor->errorOf(*written);
    EXPECT_TRUE(error) << error.error().line();
}

TEST_F(NodePlaces, NodesBelowHaveThePlaceOfTheNearestAbove) {
    quads_.json["nodes"].push_back({{"name", "House"}, {"children", {0, 1}}});
    EXPECT_THAT(boxesOf(load({{"House", {0.5, 0.5}, {0, 0}}})), ElementsAre("0 0 to 0.5 0.5", "0 0 to 0.5 0.5"));
    EXPECT_THAT(boxesOf(load({{"House", {0.5, 0.5}, {0, 0}}, {"Wall", {0.5, 0.5}, {0.5, 0.5}}})),
                UnorderedElementsAre("0 0 to 0.5 0.5", "0.5 0.5 to 1 1"));
}

TEST_F(NodePlaces, AMeshThatSeveralNodesDrawHasAPlaceForEach) {
    quads_.json["nodes"][1]["mesh"] = 0;
    EXPECT_THAT(boxesOf(load({{"Floor", {0.5, 1}, {0, 0}}, {"Wall", {-0.5, 1}, {1, 0}}})),
                UnorderedElementsAre("0 0 to 0.5 1", "1 0 to 0.5 1"));
}

TEST_F(NodePlaces, APathTellsNodesOfOneNameApart) {
    quads_.json["nodes"][1]["name"] = "Floor";
    quads_.json["nodes"].push_back({{"name", "Upper/Left"}, {"children", {1}}});
    EXPECT_THAT(
        boxesOf(load({{"Floor", {0.5, 0.5}, {0, 0}}})),
        ElementsAre(HasSubstr("room.glb, nodes: found 2 nodes 'Floor' (the first are 'Floor' and 'Upper/Left/Floor'), expected one")));
    EXPECT_THAT(boxesOf(load({{"Left/Floor", {0.5, 0.5}, {0, 0}}})), ElementsAre(HasSubstr("found no node 'Left/Floor'")))
        << "names are whole";
    EXPECT_THAT(boxesOf(load({{"Upper/Left/Floor", {0.5, 0.5}, {0, 0}}})), ElementsAre("0 0 to 0.5 0.5"));
}

TEST_F(NodePlaces, WhatFitsNoNodeIsRefused) {
    EXPECT_THAT(boxesOf(load({{"Flor"}})), ElementsAre(HasSubstr("found no node 'Flor'")));
    EXPECT_THAT(boxesOf(load({{"Floor"}, {"Floor"}})), ElementsAre(HasSubstr("found two places of node 'Floor', expected one")));
    quads_.json["nodes"].push_back({{"name", "Empty"}});
    EXPECT_THAT(boxesOf(load({{"Empty"}})), ElementsAre(HasSubstr("found no mesh at node 'Empty' or below it")));
}

TEST_F(NodePlaces, TrianglesWithoutUvsAreNamedUnlessTheyHaveNoPlace) {
    quads_.write(folder_ / "room.glb");
    const auto fault = checkAllLightMapUvs(folder_ / "room.glb", {});
    ASSERT_FALSE(fault);
    EXPECT_THAT(fault.error().line(),
                HasSubstr("room.glb: found triangles without TEXCOORD_1 in mesh 2 'LampMesh' of node 2 'Lamp', expected "
                          "light-map UVs on all triangles"));
    EXPECT_TRUE(checkAllLightMapUvs(folder_ / "room.glb", {{"Floor"}, {"Wall"}}));
    EXPECT_FALSE(checkAllLightMapUvs(folder_ / "room.glb", {{"Floor"}, {"Lamp"}}));
}

}  // namespace
}  // namespace lightcook::formats

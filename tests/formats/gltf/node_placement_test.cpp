#include "formats/gltf/node_placement.h"

#include <gtest/gtest.h>

#include <glm/vec4.hpp>

namespace lightcook::formats {
namespace {

glm::dvec3 originOf(const glm::dmat4& place) {
    return glm::dvec3(place * glm::dvec4(0, 0, 0, 1));
}

TEST(PlacesOfMeshes, MultiplyTheTransformsOfAllAncestors) {
    const nlohmann::json gltf = nlohmann::json::parse(R"({"scene": 0, "scenes": [{"nodes": [0]}], "nodes": [
        {"translation": [1, 2, 3], "rotation": [0, 0.7071067811865476, 0, 0.7071067811865476], "children": [1]},
        {"translation": [0, 0, 2], "scale": [2, 2, 2], "mesh": 4}]})");
    const auto places = placesOfMeshes(gltf);
    ASSERT_EQ(places.at(4).size(), 1u);
    const glm::dmat4 place = places.at(4)[0].worldFromMesh;
    EXPECT_NEAR(originOf(place).x, 3, 1e-12) << "a quarter turn about y brings +z to +x";
    EXPECT_NEAR(originOf(place).z, 3, 1e-12);
    EXPECT_NEAR((place * glm::dvec4(1, 0, 0, 0)).z, -2, 1e-12) << "scaled, then turned";
}

TEST(PlacesOfMeshes, AMeshDrawnTwiceHasTwoPlacesAndAnUndrawnOneNone) {
    const nlohmann::json gltf = nlohmann::json::parse(R"({"scenes": [{"nodes": [0, 1]}], "nodes": [
        {"mesh": 0}, {"mesh": 0, "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 7,8,9,1]}, {"mesh": 1}]})");
    const auto places = placesOfMeshes(gltf);
    ASSERT_EQ(places.at(0).size(), 2u);
    EXPECT_EQ(places.at(0)[0].node + places.at(0)[1].node, 1u);
    EXPECT_FALSE(places.contains(1)) << "no scene has its node";
}

TEST(PlacesOfMeshes, WithoutScenesTheRootsAreTheNodesWithoutParents) {
    const nlohmann::json gltf = nlohmann::json::parse(R"({"nodes": [{"mesh": 0}, {"children": [0], "translation": [5, 0, 0]}]})");
    EXPECT_EQ(originOf(placesOfMeshes(gltf).at(0)[0].worldFromMesh).x, 5);
}

TEST(PlacesOfMeshes, ACycleEndsAndWrongShapesCountAsUntransformed) {
    const nlohmann::json gltf = nlohmann::json::parse(R"({"scenes": [{"nodes": [0, 99, -1]}], "nodes": [
        {"children": [1], "translation": "far"}, {"children": [0, 1], "mesh": 0}]})");
    const auto places = placesOfMeshes(gltf);
    ASSERT_EQ(places.at(0).size(), 1u);
    EXPECT_EQ(places.at(0)[0].worldFromMesh, glm::dmat4(1));
    EXPECT_TRUE(placesOfMeshes(nlohmann::json::object()).empty());
}

}  // namespace
}  // namespace lightcook::formats

#include "pipeline/assets/light_map/small_charts.h"

#include <gmock/gmock.h>

namespace lightcook::pipeline {
namespace {

using verify::SurfaceTriangle;

constexpr glm::dvec2 kSmallMap(64, 32);

/// Adds the two triangles of a rectangle of texels, which lies at its own place in the world or at `height`.
void addPatch(std::vector<SurfaceTriangle>& triangles, const glm::dvec2& low, const glm::dvec2& high, double height = 0) {
    const std::array<glm::dvec2, 4> corners = {low, glm::dvec2(high.x, low.y), high, glm::dvec2(low.x, high.y)};
    for (const std::array<std::size_t, 3>& corner : {std::array<std::size_t, 3>{0, 1, 2}, std::array<std::size_t, 3>{0, 2, 3}}) {
        SurfaceTriangle triangle{};
        for (std::size_t k = 0; k < 3; ++k) {
            triangle.position[k] = glm::dvec3(corners[corner[k]], height);
            triangle.uv[k] = corners[corner[k]] / kSmallMap;
        }
        triangles.push_back(triangle);
    }
}

TEST(SmallCharts, AreTheTrianglesThatShareVertices) {
    std::vector<SurfaceTriangle> triangles;
    addPatch(triangles, {2, 2}, {5, 4});    // 6 texels
    addPatch(triangles, {10, 2}, {13, 5});  // 9 and 9 texels with a common side
    addPatch(triangles, {13, 2}, {16, 5});
    addPatch(triangles, {20, 2}, {23, 5});  // the same, in two places of the world
    addPatch(triangles, {23, 2}, {26, 5}, 1);
    addPatch(triangles, {40, 10}, {44, 14});  // 16 texels
    EXPECT_NEAR(fewTexelsAt(triangles, kSmallMap, {2, 2}).value_or(-1), 6, 1e-9);
    EXPECT_NEAR(fewTexelsAt(triangles, kSmallMap, {5.4, 3}).value_or(-1), 6, 1e-9) << "beside the chart, nearest to it";
    EXPECT_EQ(fewTexelsAt(triangles, kSmallMap, {11, 3}), std::nullopt);
    EXPECT_NEAR(fewTexelsAt(triangles, kSmallMap, {21, 3}).value_or(-1), 9, 1e-9);
    EXPECT_EQ(fewTexelsAt(triangles, kSmallMap, {41, 11}), std::nullopt) << "16 are not few";
    EXPECT_EQ(fewTexelsAt({}, kSmallMap, {1, 1}), std::nullopt);
}

TEST(SmallCharts, ATriangleWithoutAreaHoldsNoPlace) {
    std::vector<SurfaceTriangle> triangles;
    addPatch(triangles, {2, 2}, {30, 2});
    addPatch(triangles, {2, 6}, {5, 8});
    EXPECT_NEAR(fewTexelsAt(triangles, kSmallMap, {2.5, 6}).value_or(-1), 6, 1e-9);
    EXPECT_NEAR(fewTexelsAt(triangles, kSmallMap, {10, 2}).value_or(-1), 0, 1e-9) << "nearest";
}

TEST(SmallCharts, AreFoundForEachKindOfLight) {
    std::vector<SurfaceTriangle> triangles;
    addPatch(triangles, {2, 2}, {5, 4});
    addPatch(triangles, {10, 10}, {20, 20});
    verify::StageError stage;
    const auto errorAt = [](double x, double y) {
        verify::VisibleFigures visible;
        visible.maxAt.x = x;
        visible.maxAt.y = y;
        return visible;
    };
    stage.diffuse.visible = errorAt(15, 15);
    stage.specular.visible = errorAt(3.25, 2.5);
    const auto few = fewTexelsOf(stage, triangles, kSmallMap);
    ASSERT_EQ(few.size(), 1u);
    EXPECT_EQ(few[0].shading, "specular");
    EXPECT_NEAR(few[0].texels, 6, 1e-9);
    EXPECT_THAT(few[0].advice, testing::StartsWith("The chart of the largest error has 6 texels, and filters read those beside it: no"));
    stage.specular.visible.reset();
    EXPECT_THAT(fewTexelsOf(stage, triangles, kSmallMap), testing::IsEmpty());
}

}  // namespace
}  // namespace lightcook::pipeline

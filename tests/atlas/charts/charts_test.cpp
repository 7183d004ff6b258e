// Charts found by their triangles, against a brute-force walk over places.
#include "atlas/charts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <set>
#include <string>

#include "tests/atlas/mesh_fixture.h"

namespace lightcook::atlas {
namespace {

using formats::TriangleMesh;
using testing::HasSubstr;

formats::Result<ChartSet> chartsOf(const std::vector<TriangleMesh>& meshes, int width, int height) {
    std::vector<const TriangleMesh*> pointers;
    std::vector<formats::Subject> names;
    for (const TriangleMesh& mesh : meshes) {
        pointers.push_back(&mesh);
        names.push_back("mesh " + std::to_string(names.size()));
    }
    return findCharts(pointers, names, width, height);
}

TEST(FindCharts, ARectangleReadsTheTexelsAroundIt) {
    const auto found = chartsOf({rectangle({4 / 32.0f, 2 / 16.0f}, {10 / 32.0f, 5 / 16.0f})}, 32, 16);
    ASSERT_TRUE(found) << found.error().line();
    ASSERT_EQ(found->charts.size(), 1u);
    // Places 4 to 10 lie between the centres 3.5 and 10.5 of texels 3 and 10.
    EXPECT_EQ(found->charts[0].first, glm::ivec2(3, 1));
    EXPECT_EQ(found->charts[0].quads, glm::ivec2(7, 4));
    EXPECT_EQ(found->charts[0].texels(), glm::ivec2(8, 5));
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 7; ++x) EXPECT_TRUE(found->charts[0].reaches(x, y)) << x << " " << y;
}

TEST(FindCharts, AtTheBorderOfTheMapTheQuadBeyondIsReached) {
    const auto found = chartsOf({rectangle({0, 0}, {1, 1})}, 8, 8);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->charts[0].first, glm::ivec2(-1));
    EXPECT_EQ(found->charts[0].quads, glm::ivec2(9));
}

TEST(FindCharts, TrianglesOfOneQuadMoveTogetherAndOthersDoNot) {
    const auto at = [](float x) { return x / 32; };
    const auto found = chartsOf({rectangle({at(2), at(2)}, {at(6), at(6)}), rectangle({at(6), at(2)}, {at(9), at(6)}),  // abut
                                 rectangle({at(12), at(2)}, {at(16), at(6)}),                                           // apart
                                 rectangle({at(13), at(3)}, {at(14), at(4)})},  // inside the one before
                                32, 32);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->charts.size(), 2u);
    const auto chartOf = [&](std::size_t mesh) {
        return std::set<std::uint32_t>(found->ofVertex[mesh].begin(), found->ofVertex[mesh].end());
    };
    EXPECT_EQ(chartOf(0), std::set<std::uint32_t>{0});
    EXPECT_EQ(chartOf(1), std::set<std::uint32_t>{0});
    EXPECT_EQ(chartOf(2), std::set<std::uint32_t>{1});
    EXPECT_EQ(chartOf(3), std::set<std::uint32_t>{1});
}

TEST(FindCharts, VerticesWithoutTriangleHaveNoChart) {
    const auto found = chartsOf({meshOf({{0.1f, 0.1f}, {0.2f, 0.1f}, {0.1f, 0.2f}, {7, 7}}, {0, 1, 2})}, 32, 32);
    ASSERT_TRUE(found) << found.error().line() << ": the UV of an unused vertex does not matter";
    EXPECT_EQ(found->ofVertex[0], (std::vector<std::uint32_t>{0, 0, 0, ChartSet::kNoChart}));
}

TEST(FindCharts, EveryPlaceInATriangleLiesInAReachedQuadOfItsChart) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> number(0, 1), extent(0.005f, 0.2f);
    constexpr int kWidth = 61, kHeight = 47;
    std::vector<TriangleMesh> meshes;
    for (int i = 0; i < 60; ++i) {
        const glm::vec2 corner(number(random) * 0.8f, number(random) * 0.8f);
        const auto other = [&] { return corner + glm::vec2(extent(random), extent(random)); };
        meshes.push_back(meshOf({corner, other(), other()}, {0, 1, 2}));
    }
    const auto found = chartsOf(meshes, kWidth, kHeight);
    ASSERT_TRUE(found);
    EXPECT_GT(found->charts.size(), 3u);
    for (std::size_t mesh = 0; mesh < meshes.size(); ++mesh) {
        const formats::MeshAttribute& uv = meshes[mesh].attributes[0];
        const Chart& chart = found->charts[found->ofVertex[mesh][0]];
        for (int i = 0; i < 2000; ++i) {
            double a = static_cast<double>(number(random)), b = static_cast<double>(number(random));
            if (a + b > 1) a = 1 - a, b = 1 - b;
            const glm::dvec3 place = uv.at(0) * (1 - a - b) + uv.at(1) * a + uv.at(2) * b;
            const int x = static_cast<int>(std::floor(place.x * kWidth - 0.5)) - chart.first.x,
                      y = static_cast<int>(std::floor(place.y * kHeight - 0.5)) - chart.first.y;
            ASSERT_TRUE(x >= 0 && y >= 0 && x < chart.quads.x && y < chart.quads.y) << mesh;
            EXPECT_TRUE(chart.reaches(x, y)) << mesh << ": " << x << " " << y;
        }
    }
}

TEST(FindCharts, BadUvsAreRefusedWithTheirTriangle) {
    const auto outside =
        chartsOf({rectangle({0.1f, 0.1f}, {0.5f, 0.5f}), meshOf({{0, 0}, {1, 0}, {0, 1}, {1, 1.5f}}, {0, 1, 2, 1, 3, 2})}, 8, 8);
    ASSERT_FALSE(outside);
    EXPECT_EQ(outside.error().line(), "mesh 1: found light-map UV (1, 1.5) at triangle 1, expected numbers in [0, 1]");
    TriangleMesh without = rectangle({0, 0}, {1, 1});
    without.attributes[0].semantic = "TEXCOORD_0";
    const auto missing = chartsOf({without}, 8, 8);
    ASSERT_FALSE(missing);
    EXPECT_THAT(missing.error().line(), HasSubstr("found no TEXCOORD_1, expected light-map UVs"));
}

}  // namespace
}  // namespace lightcook::atlas

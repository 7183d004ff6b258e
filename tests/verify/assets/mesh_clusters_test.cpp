#include "verify/mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

namespace lightcook::verify {
namespace {

using testing::HasSubstr;

constexpr int kSize = 32;

/// Returns a mesh of triangles over a map of kSize x kSize texels, with corners in texels.
struct Corner {
    float x, y;
    std::uint8_t cluster;
};
formats::TriangleMesh meshOf(const std::vector<Corner>& corners) {
    formats::TriangleMesh mesh;
    formats::MeshAttribute uv{"TEXCOORD_1", formats::ComponentType::Float32, 2, false, {}};
    formats::MeshAttribute cluster{formats::kBasisAttribute, formats::ComponentType::Uint8, 1, false, {}};
    uv.values.resize(corners.size() * 8);
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const float place[2] = {corners[i].x / kSize, corners[i].y / kSize};
        std::memcpy(uv.values.data() + 8 * i, place, 8);
        cluster.values.push_back(static_cast<std::byte>(corners[i].cluster));
        mesh.indices.push_back(static_cast<std::uint32_t>(i));
    }
    mesh.attributes = {uv, cluster};
    return mesh;
}

/// Returns a map whose left half has cluster 1, the right half cluster 2.
formats::ClusterMap halves() {
    formats::ClusterMap map{kSize, kSize, {}};
    for (int block = 0; block < kSize / 4 * (kSize / 4); ++block)
        map.ofBlock.push_back(block % (kSize / 4) < kSize / 8 ? std::uint8_t{1} : std::uint8_t{2});
    return map;
}
CoveredTexels covered() {
    formats::LightMapStrip band;
    band.covered = formats::Image<std::uint8_t>(kSize, kSize, 1);
    for (int y = 0; y < kSize; ++y)
        for (int x = 12; x < 20; ++x) band.covered.at(x, y) = 0;
    CoveredTexels texels(kSize, kSize);
    for (const int row : {8, 0}) texels.add(band, row, row == 0 ? 8 : kSize - 8);
    return texels;
}

std::string mistakeOf(const std::vector<Corner>& corners, double inset = 0.01) {
    return clusterMistake(meshOf(corners), halves(), covered(), inset).value_or("");
}

TEST(CoveredTexels, AreThoseOfTheStrip) {
    const CoveredTexels texels = covered();
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) EXPECT_EQ(texels.at(x, y), x < 12 || x >= 20);
}

TEST(ClusterMistake, NoneWhereEveryTexelIsOfTheCornersCluster) {
    EXPECT_EQ(mistakeOf({{1, 1, 1}, {11, 1, 1}, {1, 30, 1}, {21, 1, 2}, {31, 1, 2}, {21, 30, 2}}), "");
    EXPECT_EQ(mistakeOf({}), "");
}

TEST(ClusterMistake, AWrongClusterIsNamedByTriangleAndTexel) {
    const std::string mistake = mistakeOf({{1, 1, 1}, {11, 1, 1}, {1, 30, 1}, {21, 1, 1}, {31, 1, 1}, {21, 30, 1}});
    EXPECT_THAT(mistake, HasSubstr("found cluster 1 in triangle 1, expected 2"));
    EXPECT_THAT(mistake, HasSubstr("texel (20, 0)"));
    EXPECT_THAT(mistakeOf({{1, 1, 1}, {11, 1, 1}, {1, 30, 2}}), HasSubstr("found vertices of clusters 1 and 2 in triangle 0"));
    EXPECT_THAT(mistakeOf({{1, 1, 255}, {11, 1, 255}, {1, 30, 255}}), HasSubstr("found cluster 255"));
}

TEST(ClusterMistake, ACentreInsideCountsWithoutCoverageToo) {
    EXPECT_THAT(mistakeOf({{2, 2, 1}, {19, 2, 1}, {2, 14, 1}}), HasSubstr("texel (16, 2)"));
}

TEST(ClusterMistake, ACoveredTexelCountsAsFarAsAFilterReaches) {
    // A sliver between two rows of centres that ends before column 20, whose centres are at 20.5.
    const auto sliver = [](float end) { return std::vector<Corner>{{15, 8.6f, 1}, {end, 8.6f, 1}, {15, 8.7f, 1}}; };
    EXPECT_EQ(mistakeOf(sliver(19.45f)), "");
    EXPECT_THAT(mistakeOf(sliver(19.6f)), HasSubstr("texel (20, 8)"));
    EXPECT_EQ(mistakeOf(sliver(19.6f), 0.2), "") << "quantization may have moved it that far";
}

TEST(ClusterMistake, TrianglesWithoutAreaAreReadFromToo) {
    EXPECT_THAT(mistakeOf({{25, 5, 1}, {25, 5, 1}, {25, 5, 1}}), HasSubstr("expected 2"));
    EXPECT_EQ(mistakeOf({{25, 5, 2}, {25, 5, 2}, {25, 5, 2}}), "");
    EXPECT_EQ(mistakeOf({{1e30f, 1e30f, 2}, {-1e30f, 1e30f, 2}, {1e30f, 2e30f, 2}}), "") << "places that no int can hold";
}

TEST(ClusterMistake, AMeshWithoutTheAttributeIsAMistake) {
    formats::TriangleMesh mesh = meshOf({{1, 1, 1}, {11, 1, 1}, {1, 30, 1}});
    mesh.attributes.pop_back();
    EXPECT_THAT(clusterMistake(mesh, halves(), covered(), 0.01).value_or(""), HasSubstr("_LIGHTCOOK_BASIS"));
}

}  // namespace
}  // namespace lightcook::verify

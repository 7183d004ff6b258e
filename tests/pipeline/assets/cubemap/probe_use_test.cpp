#include "pipeline/assets/cubemap/probe_use.h"

#include <gtest/gtest.h>

#include <cstring>
#include <glm/ext/matrix_transform.hpp>

namespace lightcook::pipeline {
namespace {

using glm::dvec3;

/// A square of side 10 in the plane y = 0, as two triangles.
formats::TriangleMesh floorMesh() {
    const float corners[] = {0, 0, 0, 10, 0, 0, 10, 0, 10, 0, 0, 10};
    formats::MeshAttribute positions{.semantic = "POSITION", .values = {}};
    positions.values.resize(sizeof(corners));
    std::memcpy(positions.values.data(), corners, sizeof(corners));
    return {{positions}, {0, 1, 2, 0, 2, 3}};
}

/// Nine probes over the floor, and one far away.
std::vector<dvec3> probes() {
    std::vector<dvec3> positions;
    for (int i = 0; i < 9; ++i) positions.emplace_back(1 + 4 * (i % 3), 1, 1 + 4 * (i / 3));
    positions.emplace_back(200, 1, 200);
    return positions;
}

TEST(ProbeUse, TheFarProbeAloneIsUnused) {
    ProbeUse use(probes());
    use.add(floorMesh(), glm::dmat4(1));
    for (std::size_t i = 0; i < 9; ++i) EXPECT_TRUE(use.isUsed()[i]) << i;
    EXPECT_FALSE(use.isUsed()[9]);
}

TEST(ProbeUse, ASecondPlaceOfTheMeshUsesIt) {
    ProbeUse use(probes());
    use.add(floorMesh(), glm::translate(glm::dmat4(1), dvec3(195, 0, 195)));
    EXPECT_TRUE(use.isUsed()[9]);
    EXPECT_FALSE(use.isUsed()[0]) << "nine others, of which three are nearer";
}

TEST(ProbeUse, ALargeTriangleUsesProbesFarFromItsCorners) {
    ProbeUse use({dvec3(0, 0, 0), dvec3(1, 0, 0), dvec3(0, 0, 1), dvec3(1, 0, 1), dvec3(5, 0, 3), dvec3(9, 0, 9), dvec3(8, 0, 9),
                  dvec3(9, 0, 8), dvec3(10, 0, 0), dvec3(9, 0, 0), dvec3(9, 0, 1), dvec3(10, 0, 1)});
    use.add(floorMesh(), glm::dmat4(1));
    EXPECT_TRUE(use.isUsed()[4]) << "inside the triangle, among the four nearest of no corner";
}

TEST(ProbeUse, ProbesAtOnePlaceAreNoEndlessLoop) {
    ProbeUse use(std::vector<dvec3>(6, dvec3(1, 1, 1)));
    use.add(floorMesh(), glm::dmat4(1));
    EXPECT_TRUE(use.isUsed()[0]);
}

}  // namespace
}  // namespace lightcook::pipeline

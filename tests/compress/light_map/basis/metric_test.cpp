#include "compress/light_map/basis/metric.h"

#include <gtest/gtest.h>

#include "tests/compress/light_map/basis/random_basis.h"

namespace lightcook {
namespace {

using compress::Metric;
using synthetic::cost;
using ShadingMetricTest = synthetic::BasisTest;

TEST_F(ShadingMetricTest, TurnsWithTheNormal) {
    compress::ShadingMetric metric;
    const Metric up = metric.at(glm::vec3(0, 0, 1));
    for (int round = 0; round < 50; ++round) {
        const glm::vec3 normal = randomNormal();
        const Metric turned = metric.at(normal);
        const lighting::ShRotation rotation(lighting::worldFromTangentFrame(glm::dvec3(normal)));
        lighting::ShDouble local;
        for (double& value : local) value = static_cast<double>(uniform(-1, 1));
        const double expected = cost(up, local);
        EXPECT_GT(expected, 0);
        EXPECT_NEAR(cost(turned, rotation.apply(local)), expected, 1e-4 * expected);
    }
    // Constant light: Y0^2 from the normals, and Y0^2 from the materials, which are relative to it.
    EXPECT_NEAR(static_cast<double>(up[0][0]), 2 * lighting::kShConstant * lighting::kShConstant, 1e-6);
}

}  // namespace
}  // namespace lightcook

#include "verify/light_map/shading.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace lightcook::verify {
namespace {

struct Texel {
    shaders::LcSh reference, error;
    glm::vec3 normal;
};

shaders::LcSh randomLight(std::mt19937& random, float size) {
    std::uniform_real_distribution<float> coefficient(-size, size);
    shaders::LcSh light{};
    for (glm::vec3& each : light.c) each = {coefficient(random), coefficient(random), coefficient(random)};
    light.c[0] += 2 * size;
    return light;
}

/// Runs of equal texels: black ones without and with an error, lit ones that are exact or not, under two normals.
std::vector<Texel> makeRuns() {
    std::mt19937 random(1);
    std::vector<Texel> texels;
    const glm::vec3 up(0, 0, 1), down(0, 0, -1);
    for (int run = 0; run < 16; ++run) {
        Texel texel{{}, {}, run % 3 == 0 ? down : up};
        if (run % 2 == 1) texel.reference = randomLight(random, 1);
        if (run % 4 >= 2) texel.error = randomLight(random, 0.01f);
        texels.insert(texels.end(), 5, texel);
    }
    return texels;
}

void expectEqual(const ErrorFigures& found, const ErrorFigures& expected) {
    EXPECT_EQ(found.relRms, expected.relRms);
    EXPECT_EQ(found.p99, expected.p99);
    EXPECT_EQ(found.maxSampled, expected.maxSampled);
}
void expectEqual(const VisibleFigures& found, const VisibleFigures& expected) {
    EXPECT_EQ(found.rms, expected.rms);
    EXPECT_EQ(found.max, expected.max);
    EXPECT_EQ(found.histogram, expected.histogram);
}

/// Texels that are black, exact or like the one before take short cuts. A shader of its own for each texel takes none that depends on its
/// neighbours, and the error of a texel that is nearly exact takes none at all.
TEST(ErrorShader, RunsOfEqualTexelsCountLikeTexelsAlone) {
    const ShadingMatrices matrices = shadingMatrices({}, 1, Viewing{});
    ShadedErrors together, alone;
    ErrorShader one(matrices, 1);
    constexpr float kNearlyNothing = 1e-30f;
    for (const Texel& texel : makeRuns()) {
        one.setReference(texel.reference, texel.normal, {0.5, 0.5});
        one.add(texel.error, together);
        ErrorShader fresh(matrices, 1);
        fresh.setReference(texel.reference, texel.normal, {0.5, 0.5});
        shaders::LcSh error = texel.error;
        if (error.c[0].x == 0) error.c[0].x = kNearlyNothing;
        fresh.add(error, alone);
    }
    EXPECT_EQ(together.diffuse.sampleCount(), alone.diffuse.sampleCount());
    EXPECT_EQ(together.visibleSpecular.sampleCount(), alone.visibleSpecular.sampleCount());
    expectEqual(together.diffuse.figures(), alone.diffuse.figures());
    expectEqual(together.specular.figures(), alone.specular.figures());
    expectEqual(together.visibleDiffuse.figures(), alone.visibleDiffuse.figures());
    expectEqual(together.visibleSpecular.figures(), alone.visibleSpecular.figures());
    EXPECT_GT(together.visibleDiffuse.figures().max, 0);
}

}  // namespace
}  // namespace lightcook::verify

#include "verify/mesh_shift.h"

#include <gtest/gtest.h>

#include <random>

#include "lighting/radiometry.h"

namespace verify {
namespace {

using formats::LightMapBand;

LightMapBand bandOf(int width, int height, const lighting::ShRgb& sh) {
    LightMapBand band;
    band.sh = formats::Image<lighting::ShRgb>(width, height, sh);
    band.covered = formats::Image<std::uint8_t>(width, height, 1);
    band.normal = formats::Image<glm::vec3>(width, height, glm::vec3(0, 0, 1));
    return band;
}

LightMapBand noise(int width, int height) {
    LightMapBand band = bandOf(width, height, {});
    std::mt19937 random(7);
    std::uniform_real_distribution<float> value(-0.2f, 0.2f);
    for (lighting::ShRgb& sh : band.sh.texels())
        for (std::size_t i = 0; i < sh.size(); ++i)
            for (int c = 0; c < 3; ++c) sh[i][c] = i == 0 ? 1 + value(random) : value(random);
    return band;
}

ErrorFigures figuresOf(const LightMapBand& band, const MeshShift& shift) {
    ErrorAccumulator errors(0.3);
    addMeshShiftErrors(band, 0, band.sh.height(), shift, 0.3, errors);
    return errors.figures();
}

TEST(MeshShift, AMeshThatDidNotMoveHasNoError) {
    const ErrorFigures figures = figuresOf(noise(16, 16), {});
    EXPECT_LT(figures.maxSampled, 1e-6);
    EXPECT_EQ(figures.maxBound, 0);
}

TEST(MeshShift, ConstantLightDoesNotNoticeAnyShift) {
    lighting::ShRgb sh{};
    sh[0] = glm::vec3(1.7f);
    EXPECT_LT(figuresOf(bandOf(8, 8, sh), {0.4, 0.4, 0.1}).maxSampled, 1e-5);
}

TEST(MeshShift, ATurnedNormalErrsByTheSlopeOfTheLight) {
    const glm::vec3 slanted(0.6f, 0, 0.8f);
    const LightMapBand band = bandOf(8, 8, lighting::projectDirectional(slanted, glm::vec3(1)));
    const double angle = 1e-3;
    const auto shaded = [&](double turn) {
        const glm::vec3 normal(static_cast<float>(std::sin(turn)), 0, static_cast<float>(std::cos(turn)));
        return static_cast<double>(lighting::lambertExitRadiance(band.sh.at(0, 0), normal, glm::vec3(1)).value.x);
    };
    // The normal turns about diagonals: 1 / sqrt 2 of the angle lies in the plane of the light.
    const double expected = std::abs(shaded(angle / std::sqrt(2.0)) - shaded(0)) / (shaded(0) + 0.02 * 0.3);
    EXPECT_NEAR(figuresOf(band, {0, 0, angle}).maxSampled, expected, 0.02 * expected);
}

TEST(MeshShift, NoSampleExceedsTheBoundAndTheErrorGrowsWithTheShift) {
    const LightMapBand band = noise(32, 32);
    double before = 0;
    for (const double shift : {0.001, 0.01, 0.1, 0.4}) {
        const ErrorFigures figures = figuresOf(band, {shift, shift, 0.1 * shift});
        EXPECT_LE(figures.maxSampled, figures.maxBound);
        EXPECT_GT(figures.relRms, before);
        before = figures.relRms;
    }
}

TEST(MeshShift, QuadsThatLeaveTheirChartAreNotMeasured) {
    LightMapBand band = noise(4, 4);
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x) band.covered.at(x, y) = (x + y) % 2 == 0 ? 1 : 0;
    ErrorAccumulator errors(0.3);
    addMeshShiftErrors(band, 0, 4, {0.4, 0.4, 0.1}, 0.3, errors);
    EXPECT_EQ(errors.sampleCount(), 0);
}

}  // namespace
}  // namespace verify

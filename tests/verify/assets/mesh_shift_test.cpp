#include "verify/mesh.h"

#include <gtest/gtest.h>

#include <random>

#include "lighting/radiometry.h"

namespace lightcook::verify {
namespace {

using formats::LightMapStrip;

LightMapStrip bandOf(int width, int height, const lighting::ShRgb& sh) {
    LightMapStrip band;
    band.sh = formats::Image<lighting::ShRgb>(width, height, sh);
    band.covered = formats::Image<std::uint8_t>(width, height, 1);
    band.normal = formats::Image<glm::vec3>(width, height, glm::vec3(0, 0, 1));
    return band;
}

LightMapStrip noise(int width, int height) {
    LightMapStrip band = bandOf(width, height, {});
    std::mt19937 random(7);
    std::uniform_real_distribution<float> value(-0.2f, 0.2f);
    for (lighting::ShRgb& sh : band.sh.texels())
        for (std::size_t i = 0; i < sh.size(); ++i)
            for (int c = 0; c < 3; ++c) sh[i][c] = i == 0 ? 1 + value(random) : value(random);
    return band;
}

ErrorFigures figuresOf(const LightMapStrip& band, const MeshShift& shift) {
    ErrorAccumulator errors(0.3);
    addMeshShiftErrors(band, 0, band.sh.height(), shift, 0.3, errors);
    return errors.figures();
}

TEST(MeshShift, AMeshThatDidNotMoveHasNoError) {
    const ErrorFigures figures = figuresOf(noise(16, 16), {});
    EXPECT_LT(figures.maxSampled, 1e-6);
    EXPECT_EQ(figures.maxBound, 0);
}

TEST(MeshShift, ConstantLightHasNoErrorForAnyShift) {
    lighting::ShRgb sh{};
    sh[0] = glm::vec3(1.7f);
    EXPECT_LT(figuresOf(bandOf(8, 8, sh), {0.4, 0.4, 0.1}).maxSampled, 1e-5);
}

TEST(MeshShift, ARotatedNormalErrsByTheGradientOfTheLight) {
    const glm::vec3 slanted(0.6f, 0, 0.8f);
    const LightMapStrip band = bandOf(8, 8, lighting::projectDirectional(slanted, glm::vec3(1)));
    const double angle = 1e-3;
    const auto shaded = [&](double turn) {
        const glm::vec3 normal(static_cast<float>(std::sin(turn)), 0, static_cast<float>(std::cos(turn)));
        return static_cast<double>(lighting::lambertExitRadiance(band.sh.at(0, 0), normal, glm::vec3(1)).value.x);
    };
    // The normal is rotated about diagonals: 1 / sqrt 2 of the angle is in the plane of the light.
    const double expected = std::abs(shaded(angle / std::sqrt(2.0)) - shaded(0)) / (shaded(0) + lighting::kLocalErrorFloor * 0.3);
    EXPECT_NEAR(figuresOf(band, {0, 0, angle}).maxSampled, expected, 0.02 * expected);
}

TEST(MeshShift, NoSampleExceedsTheBoundAndTheErrorGrowsWithTheShift) {
    const LightMapStrip band = noise(32, 32);
    double before = 0;
    for (const double shift : {0.001, 0.01, 0.1, 0.4}) {
        const ErrorFigures figures = figuresOf(band, {shift, shift, 0.1 * shift});
        EXPECT_LE(figures.maxSampled, figures.maxBound);
        EXPECT_GT(figures.relRms, before);
        before = figures.relRms;
    }
}

TEST(MeshShift, QuadsThatLeaveTheirChartAreNotMeasured) {
    LightMapStrip band = noise(4, 4);
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x) band.covered.at(x, y) = (x + y) % 2 == 0 ? 1 : 0;
    ErrorAccumulator errors(0.3);
    addMeshShiftErrors(band, 0, 4, {0.4, 0.4, 0.1}, 0.3, errors);
    EXPECT_EQ(errors.sampleCount(), 0);
}

TEST(MeshShift, QuadsBetweenTwoChartsAreNotMeasured) {
    LightMapStrip band = noise(6, 4);
    band.chart = formats::Image<std::uint32_t>(6, 4, 1);
    for (int y = 0; y < 4; ++y)
        for (int x = 3; x < 6; ++x) band.chart.at(x, y) = 2;
    ErrorAccumulator errors(0.3);
    addMeshShiftErrors(band, 0, 4, {0.4, 0.4, 0.1}, 0.3, errors);
    EXPECT_EQ(errors.sampleCount(), 3 * 4 * (3 * 5 - 3)) << "colours, corners of the shift, and quads but for a column";
}

/// The map's bound for a shift holds for the errors of that shift and is tight; the six sums equal the quads' bounds.
TEST(MeshShiftBound, HoldsForEveryShift) {
    const LightMapStrip band = noise(24, 20);
    MeshShiftBound whole, upper, lower;
    whole.add(band, 0, 20);
    upper.add(band, 0, 7);
    lower.add(band, 7, 13);
    upper.merge(lower);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> texels(0, 0.5), angle(0, 0.05);
    for (int i = 0; i < 200; ++i) {
        const MeshShift shift{texels(random), texels(random), angle(random)};
        const double bound = whole.relRms(shift);
        EXPECT_GE(bound, figuresOf(band, shift).relRms);
        EXPECT_LE(bound, 12 * figuresOf(band, shift).relRms) << "norms of noise, against signs that happen";
        EXPECT_NEAR(upper.relRms(shift), bound, 1e-12 * bound);
        EXPECT_NEAR(whole.relRms({2 * shift.uTexels, 2 * shift.vTexels, 2 * shift.normalRadians}), 2 * bound, 1e-9 * bound);
    }
    EXPECT_EQ(whole.relRms({}), 0);
    EXPECT_EQ(MeshShiftBound().relRms({0.1, 0.1, 0.1}), 0) << "nothing to move";
}

/// One quad by hand: coefficient 0 of 1, 3 across, 2 down; a band's value factor is 1 * sqrt(1 / 4 pi).
TEST(MeshShiftBound, IsTheSlopesForOneQuad) {
    LightMapStrip band = bandOf(2, 2, {});
    band.sh.at(0, 0)[0] = glm::vec3(1);
    band.sh.at(1, 0)[0] = glm::vec3(4);
    band.sh.at(0, 1)[0] = glm::vec3(3);
    band.sh.at(1, 1)[0] = glm::vec3(6);
    MeshShiftBound bound;
    bound.add(band, 0, 2);
    EXPECT_NEAR(bound.relRms({0.1, 0, 0}), 0.3 / 3.5, 1e-6);
    EXPECT_NEAR(bound.relRms({0, 0.1, 0}), 0.2 / 3.5, 1e-6);
    EXPECT_NEAR(bound.relRms({0.1, 0.1, 0.2}), 0.5 / 3.5, 1e-6) << "light from everywhere does not turn";
}

}  // namespace
}  // namespace lightcook::verify

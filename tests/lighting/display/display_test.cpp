#include "lighting/display.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

namespace lightcook::lighting {
namespace {

TEST(Display, TheCurveHasItsKnownValues) {
    // SMPTE ST 2084: 0 is black, 10000 cd/m^2 is 1, and 100 cd/m^2 is close to half of the range.
    EXPECT_NEAR(perceptualQuantizer(0), 7.31e-7, 1e-8);
    EXPECT_DOUBLE_EQ(perceptualQuantizer(10000), 1);
    EXPECT_DOUBLE_EQ(perceptualQuantizer(20000), 1);
    EXPECT_NEAR(perceptualQuantizer(100), 0.508078, 1e-6);
    EXPECT_NEAR(perceptualQuantizer(203), 0.580689, 1e-6);
}

TEST(Display, TheColourSpaceHasItsPublishedExample) {
    const glm::dvec3 found = ictcpItp({0.45620519, 0.03081071, 0.04091952});
    EXPECT_NEAR(found.x, 0.07351364, 1e-7);
    EXPECT_NEAR(found.y, 0.00475253 / 2, 1e-7);
    EXPECT_NEAR(found.z, 0.09351596, 1e-7);
}

TEST(Display, GreyHasNoColour) {
    for (const double nits : {0.5, 20.0, 203.0, 4000.0}) {
        const glm::dvec3 found = ictcpItp(bt2020FromRec709() * glm::dvec3(nits));
        EXPECT_NEAR(found.x, perceptualQuantizer(nits), 1e-6);
        EXPECT_NEAR(found.y, 0, 1e-6);
        EXPECT_NEAR(found.z, 0, 1e-6);
    }
}

TEST(Display, ShowsAKeyAsAGreyCard) {
    EXPECT_DOUBLE_EQ(DisplaySettings{}.of(2).nitsPerUnit, 0.18 * 203 / 2);
    EXPECT_DOUBLE_EQ(DisplaySettings{}.of(0).nitsPerUnit, 0.18 * 203) << "of a black map";
    DisplaySettings settings;
    settings.white = 4;
    settings.stops = -1;
    settings.black = 0.1;
    EXPECT_DOUBLE_EQ(settings.of(2).nitsPerUnit, 203.0 / 8);
    EXPECT_DOUBLE_EQ(settings.of(2).black, 0.1);
}

TEST(Display, DifferencesAreThoseOfWhatIsShown) {
    const Display display = DisplaySettings{}.of(1);
    EXPECT_EQ(visibleDifference({1, 2, 3}, {1, 2, 3}, display), 0);
    EXPECT_EQ(visibleDifference({-1, 0, 0}, {0, -5, 0}, display), 0) << "negative light is none";
    // A grey step moves I alone, by the step of the curve.
    const double step = 720 * (perceptualQuantizer(36.54 * 1.02 + 0.5) - perceptualQuantizer(36.54 + 0.5));
    EXPECT_NEAR(visibleDifference(glm::dvec3(1), glm::dvec3(1.02), display), step, 1e-3);
    EXPECT_NEAR(step, 1.3, 0.05) << "2 % at the key is just noticeable";
    // The same relative step is less visible near black.
    EXPECT_LT(visibleDifference(glm::dvec3(1e-3), glm::dvec3(1.02e-3), display), 0.05);
}

}  // namespace
}  // namespace lightcook::lighting

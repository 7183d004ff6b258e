// The quick test of visible errors agrees with the coarse bound, and both hold for every light that they are about.
#include "verify/light_map/visible_metric.h"

#include <gtest/gtest.h>

#include <cmath>

#include "lighting/display.h"
#include "verify/assets/random.h"

namespace lightcook {
namespace {

using verify::Random;

verify::Viewing viewingOf(bool isPositive) {
    verify::Viewing viewing;
    viewing.display.nitsPerUnit = 40;
    // Primaries beyond those of the display: some channel lowers L, M or S.
    if (!isPositive) viewing.bt2020FromWorking = glm::dmat3(1.4, -0.5, 0, -0.4, 1.6, -0.1, 0, -0.1, 1.1);
    return viewing;
}

TEST(VisibleMetric, WhatIsCoarselyBelowALimitIsBelowIt) {
    for (const bool isPositive : {true, false}) {
        const verify::Viewing viewing = viewingOf(isPositive);
        const verify::VisibleMetric metric(viewing, 1);
        Random random(3);
        const auto light = [&](double lowest, double highest) { return lowest * std::pow(highest / lowest, random.next()); };
        int below = 0;
        for (int i = 0; i < 20000; ++i) {
            const double brightness = light(1e-3, 1e3), share = light(1e-4, 2), limit = light(0.5, 800);
            glm::dvec3 low, error;
            for (int c = 0; c < 3; ++c) {
                low[c] = random.next() < 0.1 ? -brightness * random.next() : brightness * random.next();
                error[c] = share * brightness * random.next();
            }
            if (!metric.isCoarselyBelow(low, error, limit)) continue;
            ++below;
            EXPECT_LT(metric.coarseBound(low, error), limit);
            for (int k = 0; isPositive && k < 4; ++k) {
                glm::dvec3 reference, found;
                for (int c = 0; c < 3; ++c) {
                    reference[c] = low[c] + (k % 2 == 0 ? 0 : brightness * random.next());
                    found[c] = reference[c] + (random.next() < 0.5 ? -1 : 1) * error[c];
                }
                EXPECT_LT(lighting::visibleDifference(reference, found, viewing.display, viewing.bt2020FromWorking), limit);
            }
        }
        EXPECT_GT(below, isPositive ? 3000 : -1);  // of 20,000
    }
}

TEST(VisibleMetric, NothingIsCoarselyBelowWithoutANumber) {
    const verify::VisibleMetric metric(viewingOf(true), 1);
    const double nan = std::nan("");
    EXPECT_TRUE(metric.isCoarselyBelow(glm::dvec3(1), glm::dvec3(1e-6), 5));
    EXPECT_FALSE(metric.isCoarselyBelow(glm::dvec3(1), glm::dvec3(nan), 5));
    EXPECT_FALSE(metric.isCoarselyBelow(glm::dvec3(1), glm::dvec3(HUGE_VAL), 5));
    EXPECT_FALSE(metric.isCoarselyBelow(glm::dvec3(1), glm::dvec3(1e-6), 0));
}

}  // namespace
}  // namespace lightcook

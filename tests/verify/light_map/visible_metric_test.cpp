// The quick test of visible errors agrees with the coarse bound, both hold for every light that they are about, and the numbers of the PQ
// curve that they are made of are those of its formula.
#include "verify/light_map/visible_metric.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/matrix.hpp>

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

TEST(VisibleMetric, WhatCheaplyCannotExceedALimitIsBelowIt) {
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
            if (!metric.cannotExceedCheaply(low, error, limit)) continue;
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

TEST(VisibleMetric, CoarseBoundHoldsForLightThatGoesOut) {
    verify::Viewing viewing = viewingOf(true);  // black is 0.5 cd/m^2
    // Each channel raises one of L, M and S almost alone, so that their codes differ apart from each other.
    viewing.bt2020FromWorking = glm::inverse(lighting::lmsFromBt2020()) * glm::dmat3(1, 0.02, 0.02, 0.02, 1, 0.02, 0.02, 0.02, 1);
    const verify::VisibleMetric metric(viewing, 1);
    for (int channel = 0; channel < 3; ++channel)
        for (const double brightness : {1.0, 3.0, 10.0, 20.0}) {
            glm::dvec3 reference(0);
            reference[channel] = brightness;
            // The error is larger than the darkest light that the reference may have.
            for (const double factor : {1.0, 0.3})
                EXPECT_GE(metric.coarseBound(0.1 * reference, reference),
                          lighting::visibleDifference(factor * reference, glm::dvec3(0), viewing.display, viewing.bt2020FromWorking))
                    << channel << " " << brightness;
        }
}

TEST(VisibleMetric, WithoutANumberNothingIsProvenCheaply) {
    const verify::VisibleMetric metric(viewingOf(true), 1);
    const double nan = std::nan("");
    EXPECT_TRUE(metric.cannotExceedCheaply(glm::dvec3(1), glm::dvec3(1e-6), 5));
    EXPECT_FALSE(metric.cannotExceedCheaply(glm::dvec3(1), glm::dvec3(nan), 5));
    EXPECT_FALSE(metric.cannotExceedCheaply(glm::dvec3(1), glm::dvec3(HUGE_VAL), 5));
    EXPECT_FALSE(metric.cannotExceedCheaply(glm::dvec3(1), glm::dvec3(1e-6), 0));
}

/// Returns the slope of the PQ curve over the natural logarithm of the luminance, by a central difference.
double slopeOverLogarithm(double nits) {
    constexpr double kStep = 1e-4;
    return (lighting::perceptualQuantizer(nits * std::exp(kStep)) - lighting::perceptualQuantizer(nits * std::exp(-kStep))) / (2 * kStep);
}
/// Calls visit(z) for luminances from 2^-8 to 9900 cd/m^2, rising. The differences above need some room below 10000 cd/m^2, where the curve
/// is clamped.
template <class Visit>
void forEachLuminance(Visit visit) {
    constexpr int kSteps = 20000;
    for (int i = 0; i <= kSteps; ++i) visit(std::exp2(-8 + (std::log2(9900) + 8) * i / kSteps));
}

TEST(VisibleMetric, SteepestSlopeIsTheMaximumOfThePqCurveAndTheSlopeRisesUpToIt) {
    double largest = 0, at = 0, last = 0;
    forEachLuminance([&](double nits) {
        const double slope = slopeOverLogarithm(nits);
        EXPECT_LE(slope, verify::kSteepestSlope) << nits;
        if (nits <= verify::kSteepestLuminance) {
            EXPECT_GT(slope, last) << nits;
        }
        if (slope > largest) {
            largest = slope;
            at = nits;
        }
        last = slope;
    });
    EXPECT_NEAR(largest, verify::kSteepestSlope, 1e-5);
    EXPECT_NEAR(at, verify::kSteepestLuminance, 20);  // a maximum is flat
}

TEST(VisibleMetric, SteepnessIsThatOfThePqCurveAndRisesWithTheLuminance) {
    constexpr double kStep = 1e-3;
    double last = 0;
    forEachLuminance([&](double nits) {
        const double steepness = verify::VisibleMetric::steepness(nits);
        EXPECT_GT(steepness, last) << nits;
        last = steepness;
        const double above = std::log(slopeOverLogarithm(nits * std::exp(kStep))),
                     below = std::log(slopeOverLogarithm(nits * std::exp(-kStep)));
        EXPECT_NEAR(1 - (above - below) / (2 * kStep), steepness, 1e-5) << nits;
    });
}

}  // namespace
}  // namespace lightcook

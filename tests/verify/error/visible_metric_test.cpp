// The quick test of visible errors agrees with the coarse bound, both hold for every light that they are about, and the numbers of the PQ
// curve that they are made of are those of its formula.
#include "verify/error/visible_metric.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <vector>

#include "lighting/display.h"
#include "tests/verify/itp_truth.h"
#include "verify/assets/random.h"
#include "verify/error/perceptual_quantizer.h"

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

/// Displays of several blacks, under primaries within those of BT.2020 and beyond them.
std::vector<verify::Viewing> displays() {
    std::vector<verify::Viewing> out;
    const glm::dmat3 wide = viewingOf(false).bt2020FromWorking;
    for (const glm::dmat3& primaries : {lighting::bt2020FromRec709(), glm::dmat3(1), wide})
        for (const double black : {0.005, 0.5, 100.0}) out.push_back({{40, black}, primaries});
    return out;
}

TEST(VisibleMetric, NoTwoLightsDifferByMoreThanTheLargestDifferenceOfTheDisplay) {
    for (const verify::Viewing& viewing : displays()) {
        const verify::VisibleMetric metric(viewing, 1);
        const bool isWithin = viewing.bt2020FromWorking[1][0] >= 0;
        // Every light of a grid: channels that are dark, of each brightness, or beyond the display.
        std::vector<glm::dvec3> shown;
        const std::vector<double> steps = {0, 1e-3, 0.03, 0.3, 1, 3, 10, 40, 120, 300, 2000, 1e5};
        for (const double red : steps)
            for (const double green : steps)
                for (const double blue : steps) {
                    const glm::dvec3 light = viewing.bt2020FromWorking * glm::dvec3(red, green, blue);
                    shown.push_back(lighting::kVisibleScale *
                                    lighting::ictcpItp(viewing.display.nitsPerUnit * light + viewing.display.black));
                }
        double farthest = 0;
        for (const glm::dvec3& a : shown)
            for (const glm::dvec3& b : shown) farthest = std::max(farthest, glm::length(a - b));
        EXPECT_LE(farthest, metric.mostVisible());
        if (isWithin) {
            EXPECT_GT(farthest, 0.65 * metric.mostVisible());
        }
    }
    EXPECT_NEAR(verify::VisibleMetric({}, 1).mostVisible(), 765.7, 0.5) << "as the documentation has it";
}

TEST(VisibleMetric, NoLightsInTwoBoxesDifferByMoreThanTheirBound) {
    Random random(5);
    for (const verify::Viewing& viewing : displays()) {
        const verify::VisibleMetric metric(viewing, 1);
        for (int i = 0; i < 400; ++i) {
            const double brightness = std::pow(10, -3 + 6 * random.next()), share = std::pow(10, -4 * random.next());
            verify::Intervals reference, found, error;
            for (std::size_t c = 0; c < 3; ++c) {
                const double low = brightness * (random.next() - 0.1), off = share * brightness * (random.next() - 0.5),
                             width = i % 3 == 0 ? 0 : share * brightness * random.next();
                reference[c] = {low, low + width};
                error[c] = verify::Interval::around(off, 0.5 * share * brightness * random.next());
                found[c] = reference[c] + error[c];
            }
            const double narrow = metric.bound(reference, found, error), wide = metric.bound(reference, found);
            EXPECT_LE(narrow, metric.mostVisible());
            EXPECT_LE(wide, metric.mostVisible());
            EXPECT_LE(narrow, wide + 1e-9);
            for (int k = 0; k < 24; ++k) {
                // Corners of the boxes, and places in them.
                const auto in = [&](const verify::Interval& range) {
                    const double at = k < 12 ? std::round(random.next()) : random.next();
                    return range.low + at * (range.high - range.low);
                };
                glm::dvec3 x, y, z;
                for (int c = 0; c < 3; ++c) {
                    const auto channel = static_cast<std::size_t>(c);
                    x[c] = in(reference[channel]);
                    y[c] = x[c] + in(error[channel]);
                    z[c] = in(found[channel]);
                }
                ASSERT_LE(lighting::visibleDifference(x, y, viewing.display, viewing.bt2020FromWorking), narrow);
                ASSERT_LE(lighting::visibleDifference(x, z, viewing.display, viewing.bt2020FromWorking), wide);
            }
        }
    }
}

TEST(VisibleMetric, TheBoundOfSingleLightsIsTheirDifferenceAndThatOfGreyOnesToo) {
    const verify::Viewing viewing = viewingOf(true);
    const verify::VisibleMetric metric(viewing, 1);
    Random random(7);
    for (int i = 0; i < 2000; ++i) {
        verify::Intervals a, b;
        glm::dvec3 x, y;
        const double share = std::pow(10, -4 * random.next());
        for (int c = 0; c < 3; ++c) {
            x[c] = std::pow(10, -2 + 4 * random.next());
            y[c] = x[c] * (1 + share * (random.next() - 0.5));
            a[static_cast<std::size_t>(c)] = {x[c], x[c]};
            b[static_cast<std::size_t>(c)] = {y[c], y[c]};
        }
        const double difference = lighting::visibleDifference(x, y, viewing.display, viewing.bt2020FromWorking);
        EXPECT_GE(metric.bound(a, b), difference);
        EXPECT_LE(metric.bound(a, b), 1.1 * difference + 0.05);
        const double grey = lighting::visibleDifference(glm::dvec3(x.x), glm::dvec3(y.x), viewing.display);
        const double bound = metric.greyBound({x.x, x.x}, {y.x, y.x}, {y.x - x.x, y.x - x.x});
        EXPECT_GE(bound, grey);
        EXPECT_LE(bound, 1.01 * grey + 0.03);
    }
}

TEST(VisibleMetric, GreyLightsInTwoRangesDifferByNoMoreThanTheirBound) {
    Random random(9);
    for (const double black : {0.005, 0.5, 100.0}) {
        const verify::Viewing viewing{{40, black}};
        const verify::VisibleMetric metric(viewing, 1);
        for (int i = 0; i < 1000; ++i) {
            const double brightness = std::pow(10, -4 + 8 * random.next()), low = brightness * (random.next() - 0.2);
            const verify::Interval reference{low, low + brightness * random.next()},
                error = verify::Interval::around(brightness * (random.next() - 0.5), brightness * random.next());
            const double bound = metric.greyBound(reference, reference + error, error);
            EXPECT_LE(bound, metric.mostVisible());
            for (int k = 0; k < 20; ++k) {
                const double x = reference.low + (k < 8 ? k % 2 : random.next()) * (reference.high - reference.low),
                             y = x + error.low + (k < 8 ? k / 2 % 2 : random.next()) * (error.high - error.low);
                ASSERT_LE(lighting::visibleDifference(glm::dvec3(x), glm::dvec3(y), viewing.display), bound);
            }
        }
    }
}

TEST(VisibleMetric, LightThatIsNotFiniteHasNoBound) {
    const verify::VisibleMetric metric(viewingOf(true), 1);
    const verify::Intervals one = {{{1, 1}, {1, 1}, {1, 1}}};
    for (const double value : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
        verify::Intervals other = one;
        other[1].high = value;
        EXPECT_EQ(metric.bound(one, other), HUGE_VAL);
        EXPECT_EQ(metric.bound(other, one), HUGE_VAL);
        EXPECT_EQ(metric.greyBound(one[1], other[1], {0, 1}), HUGE_VAL);
    }
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

/// Returns the luminance of a code in [0, 1]: the EOTF of SMPTE ST 2084.
long double nitsOfCode(long double code) {
    const long double power = std::pow(code, 32 / 2523.0L);
    return 10000 * std::pow(std::max(power - 3424 / 4096.0L, 0.0L) / (2413 / 128.0L - 2392 / 128.0L * power), 16384 / 2610.0L);
}

TEST(PerceptualQuantizer, EveryCodeOf16BitsHasTheStatedError) {
    for (int code = 0; code < 65536; ++code) {
        const double nits = static_cast<double>(nitsOfCode(code / 65535.0L));
        ASSERT_NEAR(lighting::perceptualQuantizer(nits) * 65535, code, 0.05) << "the whole range, in codes";
        const auto rounded = static_cast<float>(nits);
        const long double exact = verify::itp::pq(static_cast<long double>(rounded));
        ASSERT_NEAR(lighting::perceptualQuantizer(static_cast<double>(rounded)), static_cast<double>(exact), 1e-13) << code;
        // Below 2^-8 cd/m^2 the floats of the verifier have the code of 2^-8: a display's black is above it.
        const long double held = verify::itp::pq(std::max(static_cast<long double>(rounded), 0x1p-8L));
        ASSERT_NEAR(verify::perceptualQuantizerOf(rounded), static_cast<double>(held), 2e-7) << code;
    }
    static_assert(lighting::kLeastBlack > 0x1p-8);
    EXPECT_EQ(verify::perceptualQuantizerOf(3e38f), verify::perceptualQuantizerOf(10000));
}

}  // namespace
}  // namespace lightcook

// Stated errors of the metrics, and bounds of visible errors, over the whole range of floats, searched against long double.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <vector>

#include "lighting/display.h"
#include "tests/lighting/worst_search.h"
#include "tests/verify/itp_truth.h"
#include "verify/error/perceptual_quantizer.h"
#include "verify/error/visible_any_light.h"
#include "verify/error/visible_metric.h"
#include "verify/figures.h"
#include "verify/visible.h"

namespace lightcook {
namespace {

using Real = long double;
using test::SearchBudget;
using test::SearchRange;
using Kind = SearchRange::Kind;
using verify::Interval;
using verify::Intervals;
using Input = std::vector<double>;

constexpr double kMostFloat = 3.4028234663852886e38;

/// Appends the ranges of a display: luminance of a unit, black, and primaries.
void addDisplay(std::vector<SearchRange>& ranges, int primaryCount) {
    ranges.push_back({1e-9, 1e13});
    ranges.push_back({lighting::kLeastBlack, lighting::kMostBlack});
    ranges.push_back({0, primaryCount - 1.0, Kind::Linear});
}
verify::Viewing viewingAt(const Input& in, std::size_t at) {
    return {{in[at], in[at + 1]}, verify::testedPrimaries()[static_cast<std::size_t>(std::lround(in[at + 2]))]};
}

using verify::truthOf;

// ---- metrics

/// Visits floats from 2^-8 to 10000 cd/m^2, every step-th.
void expectCurveOfFloats(std::int32_t step) {
    const auto first = std::bit_cast<std::int32_t>(0x1p-8f), last = std::bit_cast<std::int32_t>(10000.0f);
    constexpr double kM1 = 2610.0 / 16384, kM2 = 2523.0 / 32, kC1 = 3424.0 / 4096, kC2 = 2413.0 / 128, kC3 = 2392.0 / 128;
    double code = 0, slope = 0, logarithm = 0;
    float codeAt = 0, slopeAt = 0, logarithmAt = 0;
    for (std::int64_t bits = first; bits <= last; bits += step) {
        const auto nits = std::bit_cast<float>(static_cast<std::int32_t>(bits));
        // In doubles, which are within 1e-13 of long double (LightingNumbers).
        const double z = static_cast<double>(nits), y = std::pow(z / 10000, kM1), top = kC1 + kC2 * y, bottom = 1 + kC3 * y;
        const double exact = std::pow(top / bottom, kM2), exactSlope = kM2 * exact * (kC2 / top - kC3 / bottom) * kM1 * y;
        const auto raise = [&](double error, double& most, float& at) {
            if (!(error > most)) return;
            most = error;
            at = nits;
        };
        raise(std::abs(static_cast<double>(verify::perceptualQuantizerOf(nits)) - exact), code, codeAt);
        raise(std::abs(static_cast<double>(verify::perceptualSlopeOf(nits)) / exactSlope - 1), slope, slopeAt);
        raise(std::abs(static_cast<double>(verify::log2Of(nits)) - std::log2(z)), logarithm, logarithmAt);
    }
    std::cout << "perceptualQuantizerOf " << code << " at " << codeAt << ", slope " << slope << " at " << slopeAt << ", log2Of "
              << logarithm << " at " << logarithmAt << '\n';
    EXPECT_LE(code, 2e-7);
    EXPECT_LE(slope, 1e-4);
    EXPECT_LE(logarithm, 6e-7);
}
void expectLogarithm(const SearchBudget& budget) {
    const std::array<SearchRange, 1> ranges = {{{1.17549435e-38, kMostFloat}}};
    test::expectHolds("log2Of, within 6e-7 of an exponent below 16 and 4.5e-6 of any", ranges, budget, [](const Input& in) {
        const auto x = static_cast<float>(in[0]);
        const Real truth = std::log2(static_cast<Real>(x));
        return std::abs(static_cast<Real>(verify::log2Of(x)) - truth) / (std::abs(truth) < 16 ? 6e-7L : 4.5e-6L);
    });
}
void expectTransform(const SearchBudget& budget, double brightest, int primaryCount) {
    std::vector<SearchRange> ranges(6, {1e-45, brightest, Kind::Signed});
    addDisplay(ranges, primaryCount);
    test::expectHolds("DisplayTransform, as stated", ranges, budget, [](const Input& in) {
        constexpr std::size_t kLanes = verify::DisplayTransform::kLanes;
        const verify::Viewing viewing = viewingAt(in, 6);
        const verify::DisplayTransform transform(viewing, 1);
        std::array<float, 3 * kLanes> a{}, b{}, shownA{}, shownB{};
        std::array<Real, 3> x, y;
        for (std::size_t c = 0; c < 3; ++c) {
            a[c * kLanes] = static_cast<float>(in[c]);
            b[c * kLanes] = static_cast<float>(in[3 + c]);
            x[c] = static_cast<Real>(a[c * kLanes]);
            y[c] = static_cast<Real>(b[c * kLanes]);
        }
        transform.apply(a.data(), kLanes, shownA.data());
        transform.apply(b.data(), kLanes, shownB.data());
        std::array<float, kLanes> differences{};
        verify::visibleDifferences(shownA.data(), shownB.data(), kLanes, differences.data());
        const Real truth = truthOf(x, y, viewing);
        return std::abs(static_cast<Real>(differences[0]) - truth) / (0.003L + 1e-4L * truth);
    });
}
void expectFigures(const SearchBudget& budget) {
    // Four samples of floats and the key.
    std::vector<SearchRange> ranges(8, {1e-45, kMostFloat, Kind::Signed});
    ranges.push_back({1e-36, kMostFloat});
    test::expectHolds("relRms and maxSampled of floats, within 1e-6, or the largest number", ranges, budget, [](const Input& in) {
        std::array<float, 4> reference, error;
        for (std::size_t i = 0; i < 4; ++i) {
            reference[i] = static_cast<float>(in[i]);
            error[i] = static_cast<float>(in[4 + i]);
        }
        verify::ErrorAccumulator errors(in[8]);
        errors.addErrors(reference, error);
        const verify::ErrorFigures figures = errors.figures();
        Real squares = 0, errorSquares = 0, largest = 0;
        for (std::size_t i = 0; i < 4; ++i) {
            const Real r = static_cast<Real>(std::abs(reference[i])), e = static_cast<Real>(std::abs(error[i]));
            squares += r * r;
            errorSquares += e * e;
            if (e > 0) largest = std::max(largest, e / std::min(r + 0.02L * static_cast<Real>(in[8]), static_cast<Real>(kMostFloat)));
        }
        const auto off = [](double found, Real truth) {
            if (found == std::numeric_limits<double>::max()) return Real(0);  // passes no limit
            return std::abs(static_cast<Real>(found) - truth) / (1e-6L * truth + 1e-38L);
        };
        return std::max(errorSquares == 0 ? Real(0) : off(figures.relRms, std::sqrt(errorSquares / squares)),
                        off(figures.maxSampled, largest));
    });
}

// ---- bounds

/// Boxes of light and of its change: low, width and change of each channel, the width of the change, and the places in them.
std::vector<SearchRange> boxRanges(int primaryCount) {
    std::vector<SearchRange> ranges(3, {1e-30, 1e30, Kind::Signed});  // low
    ranges.insert(ranges.end(), 3, {1e-30, 1e30, Kind::Signed});      // width
    ranges.insert(ranges.end(), 3, {1e-30, 1e30, Kind::Signed});      // change
    ranges.insert(ranges.end(), 3, {1e-30, 1e30, Kind::Signed});      // width of the change
    ranges.insert(ranges.end(), 6, {0, 1, Kind::Linear});             // places
    addDisplay(ranges, primaryCount);
    return ranges;
}
/// Returns the sums of numbers in two intervals, with the rounding of doubles.
Interval sumOf(const Interval& a, const Interval& b) {
    const double rounding = 4e-16 * (std::abs(a.low) + std::abs(a.high) + std::abs(b.low) + std::abs(b.high));
    return {a.low + b.low - rounding, a.high + b.high + rounding};
}
Real placeIn(const Interval& range, double share) {
    return static_cast<Real>(range.low) + static_cast<Real>(share) * (static_cast<Real>(range.high) - static_cast<Real>(range.low));
}
struct Box {
    Intervals reference, found, error;
    std::array<Real, 3> x, y;
};
Box boxOf(const Input& in) {
    Box box;
    for (std::size_t c = 0; c < 3; ++c) {
        box.reference[c] = {in[c], in[c] + std::abs(in[3 + c])};
        box.error[c] = {in[6 + c], in[6 + c] + std::abs(in[9 + c])};
        box.found[c] = sumOf(box.reference[c], box.error[c]);
        box.x[c] = placeIn(box.reference[c], in[12 + c]);
        box.y[c] = box.x[c] + placeIn(box.error[c], in[15 + c]);
    }
    return box;
}
void expectMetricBound(const SearchBudget& budget) {
    const auto ranges = boxRanges(3);
    test::expectHolds("VisibleMetric::bound", ranges, budget, [](const Input& in) {
        const verify::Viewing viewing = viewingAt(in, 18);
        const Box box = boxOf(in);
        const verify::VisibleMetric metric(viewing, 1);
        return truthOf(box.x, box.y, viewing) /
               static_cast<Real>(std::min(metric.bound(box.reference, box.found, box.error), metric.mostVisible()));
    });
}
void expectGreyBound(const SearchBudget& budget) {
    std::vector<SearchRange> ranges(4, {1e-30, 1e30, Kind::Signed});
    ranges.insert(ranges.end(), 2, {0, 1, Kind::Linear});
    addDisplay(ranges, 1);
    test::expectHolds("VisibleMetric::greyBound", ranges, budget, [](const Input& in) {
        const verify::Viewing viewing = viewingAt(in, 6);
        const Interval reference{in[0], in[0] + std::abs(in[1])}, error{in[2], in[2] + std::abs(in[3])};
        const Real x = placeIn(reference, in[4]), y = x + placeIn(error, in[5]);
        return truthOf({x, x, x}, {y, y, y}, viewing) /
               static_cast<Real>(verify::VisibleMetric(viewing, 1).greyBound(reference, sumOf(reference, error), error));
    });
}
/// Lights above `low` whose channels are off by at most `error`, both times a number in [0, 1].
void expectCoarseBound(const SearchBudget& budget, bool isCheap) {
    std::vector<SearchRange> ranges(3, {1e-30, 1e30, Kind::Signed});  // low
    ranges.insert(ranges.end(), 3, {1e-30, 1e30});                    // above low
    ranges.insert(ranges.end(), 3, {1e-30, 1e30});                    // error
    ranges.insert(ranges.end(), 3, {-1, 1, Kind::Linear});            // share of it
    ranges.push_back({0, 1, Kind::Linear});                           // factor of both
    ranges.push_back({0.02, 1000});                                   // limit of the cheap test
    addDisplay(ranges, 3);
    test::expectHolds(isCheap ? "VisibleMetric::cannotExceedCheaply" : "VisibleMetric::coarseBound", ranges, budget, [=](const Input& in) {
        const verify::Viewing viewing = viewingAt(in, 14);
        const verify::VisibleMetric metric(viewing, 1);
        const glm::dvec3 low(in[0], in[1], in[2]), error(in[6], in[7], in[8]);
        std::array<Real, 3> x, y;
        for (std::size_t c = 0; c < 3; ++c) {
            const Real light = static_cast<Real>(in[c]) + static_cast<Real>(in[3 + c]);
            x[c] = static_cast<Real>(in[12]) * light;
            y[c] = static_cast<Real>(in[12]) * (light + static_cast<Real>(in[9 + c]) * static_cast<Real>(in[6 + c]));
        }
        const Real truth = truthOf(x, y, viewing);
        if (!isCheap) return truth / static_cast<Real>(metric.coarseBound(low, error));
        // Negative: how far from a limit that the test would have to deny.
        return metric.cannotExceedCheaply(low, error, in[13]) ? truth / static_cast<Real>(in[13]) : Real(-1);
    });
}
void expectMostVisible(const SearchBudget& budget) {
    std::vector<SearchRange> ranges(6, {1e-45, 1e300, Kind::Signed});
    addDisplay(ranges, 3);
    test::expectHolds("VisibleMetric::mostVisible", ranges, budget, [](const Input& in) {
        const verify::Viewing viewing = viewingAt(in, 6);
        std::array<Real, 3> x, y;
        for (std::size_t c = 0; c < 3; ++c) {
            x[c] = static_cast<Real>(in[c]);
            y[c] = static_cast<Real>(in[3 + c]);
        }
        return truthOf(x, y, viewing) / static_cast<Real>(verify::VisibleMetric(viewing, 1).mostVisible());
    });
}
/// The secant of the curve between luminances in two intervals, and its ratio at luminances in a ratio.
void expectSecants(const SearchBudget& budget) {
    std::vector<SearchRange> ranges = {{0x1p-8, 10000}, {0x1p-8, 10000}, {1, 1e4}, {1, 1e4}};
    ranges.insert(ranges.end(), 2, {0, 1, Kind::Linear});
    test::expectHolds("VisibleMetric::slopes", ranges, budget, [](const Input& in) {
        const Interval x{in[0], std::min(in[0] * in[2], 10000.0)}, y{in[1], std::min(in[1] * in[3], 10000.0)};
        const auto at = [](const Interval& range, double share) {
            return static_cast<Real>(range.low) *
                   std::pow(static_cast<Real>(range.high) / static_cast<Real>(range.low), static_cast<Real>(share));
        };
        const Real from = at(x, in[4]), to = at(y, in[5]);
        if (std::abs(from - to) < 1e-2L * from) return Real(0);  // the difference of codes has too few digits left
        const Real secant = (verify::itp::pq(to) - verify::itp::pq(from)) / (to - from);
        const Interval stated = verify::VisibleMetric::slopes(x, y);
        return std::max(secant / static_cast<Real>(stated.high), static_cast<Real>(stated.low) / secant);
    });
    test::expectHolds("VisibleMetric::secantRatio", ranges, budget, [](const Input& in) {
        // Two luminances, and multiples of both by ratios in an interval.
        const Real x = static_cast<Real>(in[0]), y = static_cast<Real>(in[1]);
        const Interval ratio{1 / in[2], in[3]};
        const auto at = [&](double share) {
            return static_cast<Real>(ratio.low) *
                   std::pow(static_cast<Real>(ratio.high) / static_cast<Real>(ratio.low), static_cast<Real>(share));
        };
        const Real u = x * at(in[4]), v = y * at(in[5]);
        if (std::abs(x - y) < 1e-2L * x || std::abs(u - v) < 1e-2L * u || std::max(u, v) > 10000 || std::min(u, v) < 0x1p-8L)
            return Real(0);
        const auto secant = [](Real a, Real b) { return (verify::itp::pq(a) - verify::itp::pq(b)) / (a - b); };
        const Interval nits{static_cast<double>(std::min({x, y, u, v})) * (1 - 1e-15),
                            static_cast<double>(std::max({x, y, u, v})) * (1 + 1e-15)};
        const Interval stated = verify::VisibleMetric::secantRatio(ratio, nits);
        const Real truth = secant(u, v) / secant(x, y);
        return std::max(truth / static_cast<Real>(stated.high), static_cast<Real>(stated.low) / truth) * (1 - 1e-13L);
    });
}
void expectAnyLight(const SearchBudget& budget, const verify::Viewing& viewing) {
    const verify::VisibleMetric metric(viewing, 1);
    const verify::AnyLightBound any(metric);
    std::vector<SearchRange> ranges = {{1e-12, 1e12, Kind::Signed}};  // low
    ranges.insert(ranges.end(), 3, {1e-12, 1e12, Kind::Signed});      // change of each channel
    ranges.insert(ranges.end(), 3, {1e-12, 1e12});                    // light above low
    test::expectHolds("AnyLightBound", ranges, budget, [&](const Input& in) {
        Intervals error;
        std::array<Real, 3> x, y;
        for (std::size_t c = 0; c < 3; ++c) {
            error[c] = in[1 + c] < 0 ? Interval{in[1 + c], 0} : Interval{0, in[1 + c]};
            // Both lights are at least `low`, and at least 0.
            const Real least = std::max(static_cast<Real>(in[0]), Real(0)) + static_cast<Real>(in[4 + c]);
            x[c] = in[1 + c] < 0 ? least - static_cast<Real>(in[1 + c]) : least;
            y[c] = x[c] + static_cast<Real>(in[1 + c]);
        }
        return truthOf(x, y, viewing) / static_cast<Real>(any.bound(in[0], error));
    });
}

// Quick ones, with a seed each; the same for seconds in the soak.
TEST(MetricNumbers, CurveOfFloats) {
    expectCurveOfFloats(1009);
}
TEST(MetricNumbers, Logarithm) {
    expectLogarithm({100000});
}
TEST(MetricNumbers, Transform) {
    expectTransform({30000}, kMostFloat, 2);
}
TEST(MetricNumbers, Figures) {
    expectFigures({5000});
}
TEST(MetricBoundNumbers, Bound) {
    expectMetricBound({30000});
}
TEST(MetricBoundNumbers, GreyBound) {
    expectGreyBound({60000});
}
TEST(MetricBoundNumbers, CoarseBound) {
    expectCoarseBound({30000}, false);
}
TEST(MetricBoundNumbers, CheapTest) {
    expectCoarseBound({30000}, true);
}
TEST(MetricBoundNumbers, MostVisible) {
    expectMostVisible({30000});
}
TEST(MetricBoundNumbers, Secants) {
    expectSecants({60000});
}
TEST(MetricBoundNumbers, AnyLight) {
    expectAnyLight({60000}, {{36, 0.5}});
}
TEST(MetricNumbersSoak, CurveOfFloats) {
    expectCurveOfFloats(1);
}
TEST(MetricNumbersSoak, Transform) {
    expectTransform(test::soakBudget(2), kMostFloat, 2);
    expectTransform(test::soakBudget(2), 1e20, 3);  // no more than 1e33 cd/m^2
}
TEST(MetricNumbersSoak, Figures) {
    expectFigures(test::soakBudget());
}
TEST(MetricBoundNumbersSoak, Bound) {
    expectMetricBound(test::soakBudget());
}
TEST(MetricBoundNumbersSoak, GreyBound) {
    expectGreyBound(test::soakBudget());
}
TEST(MetricBoundNumbersSoak, CoarseBound) {
    expectCoarseBound(test::soakBudget(), false);
}
TEST(MetricBoundNumbersSoak, CheapTest) {
    expectCoarseBound(test::soakBudget(), true);
}
TEST(MetricBoundNumbersSoak, MostVisible) {
    expectMostVisible(test::soakBudget());
}
TEST(MetricBoundNumbersSoak, Secants) {
    expectSecants(test::soakBudget(2));
}
TEST(MetricBoundNumbersSoak, AnyLight) {
    for (const double black : {0.005, 0.5, 100.0})
        for (const glm::dmat3& each : verify::testedPrimaries()) expectAnyLight(test::soakBudget(9), {{36, black}, each});
}

}  // namespace
}  // namespace lightcook

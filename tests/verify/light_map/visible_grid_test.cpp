// The bound of visible errors on a grid of kernels, and that of errors in any light, hold for every light, and so does the theorem on means
// that the former rests on.
#include "verify/light_map/visible_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "lighting/display.h"
#include "tests/verify/visible_sampler.h"
#include "verify/assets/random.h"
#include "verify/error/visible_any_light.h"

namespace lightcook {
namespace {

using verify::Random;

using Precise = long double;

// The curve PQ of SMPTE ST 2084.
constexpr Precise kPqM1 = 2610.0L / 16384, kPqM2 = 2523.0L / 32, kPqC1 = 3424.0L / 4096, kPqC2 = 2413.0L / 128, kPqC3 = 2392.0L / 128;
Precise preciseCode(Precise nits) {
    const Precise y = std::pow(nits / 10000, kPqM1);
    return std::pow((kPqC1 + kPqC2 * y) / (1 + kPqC3 * y), kPqM2);
}
/// Returns 1 / PQ'.
Precise inverseSlope(Precise nits) {
    const Precise y = std::pow(nits / 10000, kPqM1), b = (kPqC1 + kPqC2 * y) / (1 + kPqC3 * y);
    return 1 / (kPqM2 * std::pow(b, kPqM2 - 1) * (kPqC2 - kPqC1 * kPqC3) / ((1 + kPqC3 * y) * (1 + kPqC3 * y)) * kPqM1 * y / nits);
}
/// The concave function under it: itself up to 440 cd/m^2, and a line beyond.
Precise concaveInverse(Precise nits) {
    return nits <= 440 ? inverseSlope(nits) : inverseSlope(440) + 9.0507L * (nits - 440);
}
/// Returns the secant of the curve whose slope is the inverse of that, by its integral.
Precise concaveSecant(Precise x, Precise y) {
    Precise sum = 0;
    constexpr int kSteps = 150;
    // Even steps of a power, which has most of them where the slope is steep.
    const Precise from = std::pow(std::min(x, y), 0.25L), to = std::pow(std::max(x, y), 0.25L);
    if (to - from < 1e-9L) return 1 / concaveInverse(x);
    for (int i = 0; i < kSteps; ++i) {
        const Precise at = from + (to - from) * (i + 0.5L) / kSteps, z = at * at * at * at;
        sum += 4 * at * at * at * (to - from) / kSteps / concaveInverse(z);
    }
    return sum / std::abs(y - x);
}
Precise logUniform(Random& random, double low, double high) {
    return static_cast<Precise>(low * std::pow(high / low, random.next()));
}

TEST(MeansOfLight, InverseSlopeOfTheCurveLiesAboveAConcaveFunction) {
    Precise last = concaveInverse(0x1p-8L), lastStep = 1e9L;
    for (Precise z = 0x1p-8L * 1.001L; z < 10000; z *= 1.001L) {
        const Precise q = concaveInverse(z), slope = (q - last) / (z - z / 1.001L);
        EXPECT_LE(slope, lastStep * (1 + 1e-9L)) << static_cast<double>(z);
        EXPECT_LE(q, inverseSlope(z) * (1 + 1e-12L)) << static_cast<double>(z);
        EXPECT_GE(q, inverseSlope(z) / 1.06L) << static_cast<double>(z);
        last = q;
        lastStep = slope;
    }
}

/// s(F, R) |sum of w_j e_j| <= max_j s(F_j, R_j) |e_j|, for luminances near black, around the bend of the curve, and up to its end.
TEST(MeansOfLight, DifferNoMoreThanTheirWorstControl) {
    Random random(3);
    constexpr std::array<std::array<double, 2>, 6> kRanges = {
        {{0.004, 0.02}, {0.4, 5}, {0.01, 1e4}, {300, 600}, {1000, 2000}, {1341, 1e4}}};
    for (int i = 0; i < 900; ++i) {
        const auto [low, high] = kRanges[static_cast<std::size_t>(i) % kRanges.size()];
        const int count = 2 + random.below(8);
        Precise reference = 0, found = 0, error = 0, sum = 0, worst = 0;
        for (int j = 0; j < count; ++j) {
            const Precise weight = random.next() < 0.2 ? 1e-4L : static_cast<Precise>(random.next());
            const Precise r = logUniform(random, low, high), f = random.next() < 0.3 ? r * 1.01L : logUniform(random, low, high);
            // Any linear function of light, not of this luminance alone.
            const Precise e = (random.next() < 0.5 ? f - r : 2 * static_cast<Precise>(random.next()) - 1);
            reference += weight * r;
            found += weight * f;
            error += weight * e;
            sum += weight;
            worst = std::max(worst, concaveSecant(f, r) * std::abs(e));
        }
        reference /= sum;
        found /= sum;
        const Precise secant = std::abs(found - reference) < 1e-6L * reference
                                   ? 1 / inverseSlope(reference)
                                   : std::abs(preciseCode(found) - preciseCode(reference)) / std::abs(found - reference);
        ASSERT_LE(secant * std::abs(error / sum), worst * (1 + 1e-4L)) << low << " to " << high << ", case " << i;
    }
}

/// Some light, and how bright it is at most.
struct RandomLight {
    verify::CellLight light;
    std::vector<std::array<lighting::Sh, 3>> references, errors;
};
RandomLight randomLight(Random& random, double brightness, double share) {
    RandomLight out;
    const int count = 1 + random.below(6);
    // Controls of a quad are like each other, or not at all.
    const double alike = random.next() < 0.5 ? 0.2 : 1;
    std::array<lighting::Sh, 3> common{};
    const auto number = [&] { return 2 * random.next() - 1; };
    const double direction = 1.6 * random.next();
    for (lighting::Sh& channel : common) {
        const double bright = brightness * (0.1 + random.next());
        for (std::size_t i = 0; i < channel.size(); ++i) channel[i] = static_cast<float>(bright * (i == 0 ? 3.0 : direction * number()));
    }
    for (int j = 0; j < count; ++j) {
        std::array<lighting::Sh, 3> reference = common, error, found;
        for (std::size_t c = 0; c < 3; ++c)
            for (std::size_t i = 0; i < error[c].size(); ++i) {
                reference[c][i] *= static_cast<float>(1 + alike * (random.next() - 0.5));
                error[c][i] = static_cast<float>(share * brightness * number());
                found[c][i] = reference[c][i] + error[c][i];
            }
        out.light.references.add(reference);
        out.light.errors.add(error);
        out.light.found.add(found);
        out.references.push_back(reference);
        out.errors.push_back(error);
    }
    // What a sampler may add.
    if (random.next() < 0.3)
        for (int d = 0; d < 3; ++d) {
            std::array<lighting::Sh, 3> moved;
            for (lighting::Sh& channel : moved)
                for (float& value : channel) value = static_cast<float>(0.3 * share * brightness * number());
            out.light.deviations.add(moved);
        }
    return out;
}

void expectWithinTheGrid(bool isSpecular) {
    const verify::LightMapShading shading = test::sampledShading();
    const verify::ScannedKernels scanned(shading);
    verify::KernelGrids grids;
    for (const int fineness : {1, 2})
        (fineness == 1 ? grids.coarse : grids.fine) = isSpecular ? verify::KernelGrid::specular(shading, scanned, fineness)
                                                                 : verify::KernelGrid::diffuse(test::kSampledTilt, fineness);
    const test::ShadingRows rows(2048, isSpecular, 5);
    Random random(isSpecular ? 11 : 12);
    for (const double black : {0.005, 0.5}) {
        verify::Viewing viewing;
        viewing.display = {36, black};
        const verify::VisibleMetric metric(viewing, 1);
        const verify::AnyLightBound anyLight(metric);
        verify::GridBound grid(metric, anyLight, grids);
        double nearest = 0;
        int bounded = 0;
        for (int i = 0; i < 600; ++i) {
            // From 0.02 cd/m^2 beyond the end of the curve.
            const double brightness = std::pow(10, -3.5 + 6 * random.next()), share = std::pow(10, -3 * random.next());
            const RandomLight each = randomLight(random, brightness, share);
            const double coarse = grid.bound(each.light, 0, false), fine = grid.bound(each.light, 0, true);
            bounded += fine < metric.mostVisible();
            double worst = 0;
            for (int k = 0; k < 400; ++k) {
                std::vector<double> weights(each.errors.size());
                double sum = 0;
                const std::size_t only = static_cast<std::size_t>(random.below(static_cast<int>(weights.size())));
                for (std::size_t j = 0; j < weights.size(); ++j) sum += weights[j] = k % 2 == 0 ? j == only : random.next();
                const test::ShadingRow& row = rows.rows[static_cast<std::size_t>(random.below(2048))];
                glm::dvec3 reference(0), found(0);
                std::vector<double> moves(each.light.deviations.count());
                for (double& move : moves) move = k % 3 == 0 ? 0 : std::round(2 * random.next()) - 1;
                for (std::size_t c = 0; c < 3; ++c)
                    for (std::size_t n = 0; n < row.size(); ++n) {
                        double r = 0, e = 0;
                        for (std::size_t j = 0; j < weights.size(); ++j) {
                            r += weights[j] / sum * static_cast<double>(each.references[j][c][n]);
                            e += weights[j] / sum * static_cast<double>(each.errors[j][c][n]);
                        }
                        for (std::size_t d = 0; d < moves.size(); ++d) e += moves[d] * each.light.deviations.value(d, c, n);
                        reference[static_cast<int>(c)] += row[n] * r;
                        found[static_cast<int>(c)] += row[n] * (r + e);
                    }
                worst = std::max(worst, lighting::visibleDifference(reference, found, viewing.display, viewing.bt2020FromWorking));
            }
            ASSERT_LE(worst, fine) << "case " << i << ", brightness " << brightness << ", share " << share;
            ASSERT_LE(worst, coarse) << "case " << i;
            // Nothing above a threshold: then no difference is.
            for (const double part : {0.7, 1.1, 1.5})
                if (grid.bound(each.light, part * worst, true) <= part * worst) {
                    ASSERT_GE(part * worst, worst) << "case " << i;
                }
            nearest = std::max(nearest, worst / fine);
        }
        EXPECT_GT(bounded, 450);
        EXPECT_GT(nearest, 0.7) << "a bound far above all errors would always hold";
    }
}

TEST(VisibleGrid, NoDiffuseLightDiffersByMoreThanItsBound) {
    expectWithinTheGrid(false);
}
TEST(VisibleGrid, NoSpecularLightDiffersByMoreThanItsBound) {
    expectWithinTheGrid(true);
}

TEST(VisibleGrid, BoundsNothingThatIsNotFinite) {
    const verify::VisibleMetric metric({}, 1);
    const verify::AnyLightBound anyLight(metric);
    const verify::KernelGrids grids = {verify::KernelGrid::diffuse(60, 1), verify::KernelGrid::diffuse(60, 2)};
    verify::GridBound grid(metric, anyLight, grids);
    Random random(1);
    RandomLight each = randomLight(random, 1, 0.1);
    EXPECT_LT(grid.bound(each.light, 0, true), metric.mostVisible());
    each.light.isFinite = false;
    EXPECT_EQ(grid.bound(each.light, 0, true), HUGE_VAL);
}

TEST(AnyLight, NoErrorIsMoreVisibleThanItsBound) {
    Random random(21);
    for (const bool isWide : {false, true})
        for (const double black : {0.005, 0.5, 100.0}) {
            verify::Viewing viewing;
            viewing.display = {1, black};
            if (isWide) viewing.bt2020FromWorking = glm::dmat3(1);
            const verify::VisibleMetric metric(viewing, 1);
            const verify::AnyLightBound anyLight(metric);
            for (int i = 0; i < 400; ++i) {
                const double size = black * std::pow(10, -1.5 + 5 * random.next()),
                             low = random.next() < 0.5 ? 0 : black * std::pow(10, 3 * random.next() - 1);
                verify::Intervals error;
                for (verify::Interval& each : error) {
                    each = {random.next() < 0.5 ? 0 : -size * random.next(), random.next() < 0.3 ? 0 : size * random.next()};
                    if (random.next() < 0.2) each = {0, size};
                }
                const double bound = anyLight.bound(low, error);
                EXPECT_LE(bound, metric.mostVisible());
                for (int k = 0; k < 300; ++k) {
                    glm::dvec3 x, y;
                    for (int c = 0; c < 3; ++c) {
                        const verify::Interval& range = error[static_cast<std::size_t>(c)];
                        const double part = k % 3 == 0   ? 1
                                            : k % 3 == 1 ? std::round(random.next())
                                                         : random.next(),
                                     step = part * (random.next() < 0.5 ? range.low : range.high),
                                     z = low + (random.next() < 0.4 ? 0 : size * std::pow(10, 5 * random.next() - 3));
                        x[c] = z + std::max(-step, 0.0);
                        y[c] = z + std::max(step, 0.0);
                    }
                    ASSERT_LE(lighting::visibleDifference(x, y, viewing.display, viewing.bt2020FromWorking), bound)
                        << "black " << black << ", low " << low << ", case " << i;
                }
            }
        }
}

TEST(AnyLight, BoundIsNotFarAboveWhatASearchFinds) {
    verify::Viewing viewing;
    viewing.display = {1, 0.5};
    const verify::VisibleMetric metric(viewing, 1);
    const verify::AnyLightBound anyLight(metric);
    // The largest differences that a search over lights finds are 106, 91, 98 and 209.
    EXPECT_LT(anyLight.bound(0, {{{0, 5}, {0, 5}, {0, 5}}}), 170);
    EXPECT_LT(anyLight.bound(0, {{{0, 5}, {0, 0}, {0, 0}}}), 97);
    EXPECT_LT(anyLight.bound(0, {{{0, 0}, {0, 5}, {0, 0}}}), 125);
    EXPECT_LT(anyLight.bound(0, {{{0, 30}, {0, 30}, {0, 30}}}), 350);
    EXPECT_EQ(anyLight.bound(0, {{{0, std::nan("")}, {0, 1}, {0, 1}}}), metric.mostVisible());
    EXPECT_EQ(anyLight.bound(0, {{{0, HUGE_VAL}, {0, 1}, {0, 1}}}), metric.mostVisible());
}

}  // namespace
}  // namespace lightcook

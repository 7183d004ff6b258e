#include "verify/lut.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <glm/common.hpp>
#include <random>
#include <set>

#include "lighting/display.h"
#include "lighting/radiometry.h"

namespace lightcook::verify {
namespace {

using lighting::CookTorranceNormalization;
using lighting::SpecularLobe;
using Factors = std::array<double, 4>;
constexpr Factors kPlain = {0, 1, 0, 1}, kSine = {1, -1, 1, 1}, kWarped = {1, -1, 1, -0.8}, kRoot = {0, 1, 1, 0};
const std::vector<double> kF0 = {0.0, 0.04, 1.0};

LutAxis axisOf(int count, double low, double high, const Factors& factors) {
    LutAxis axis{count, 0, 0, 0, 0.5f, factors};
    axis.minimum = std::min(axis.of(low), axis.of(high));
    axis.maximum = std::max(axis.of(low), axis.of(high));
    if (axis.minimum == axis.maximum) return axis;
    const double scale = (count - 1) / (count * (axis.maximum - axis.minimum));
    axis.scale = static_cast<float>(scale);
    axis.offset = static_cast<float>(0.5 / count - axis.minimum * scale);
    return axis;
}

struct TableKind {
    Factors view = kSine, roughness = kPlain;
    SpecularLobe lobe = SpecularLobe::Beckmann;
    CookTorranceNormalization normalization = CookTorranceNormalization::Energy;
};

/// Returns 16-bit tables of the kernel, integrated node by node.
CookedLut cook(int views, int rows, double minimumM, double maximumM, const TableKind& kind = {}) {
    CookedLut tables;
    tables.lobe = kind.lobe;
    tables.normalization = kind.normalization;
    tables.view = axisOf(views, 0, 1, kind.view);
    tables.roughness = axisOf(rows, minimumM, maximumM, kind.roughness);
    for (auto& texture : tables.textures) texture = formats::Image<glm::vec4>(views, rows);
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < views; ++x) {
            const double NoV = tables.view.inverse(tables.view.at(x)), m = tables.roughness.inverse(tables.roughness.at(y));
            const auto k = lighting::areaSpecular(std::max(1e-3, NoV), m, kind.lobe, kind.normalization);
            tables.textures[0].at(x, y) = glm::vec4(glm::dvec4(k.c[0], k.c[2], k.c[3], k.c[6]));
            tables.textures[1].at(x, y) = glm::vec4(glm::dvec4(k.d[0], k.d[2], k.d[3], k.d[6]));
            tables.textures[2].at(x, y) = glm::vec4(glm::dvec4(k.c[7], k.c[8], k.d[7], k.d[8]));
        }
    for (std::size_t i = 0; i < 3; ++i) {
        glm::vec4 low = tables.textures[i].at(0, 0), high = low;
        for (const glm::vec4& value : tables.textures[i].texels()) low = glm::min(low, value), high = glm::max(high, value);
        tables.bias[i] = low;
        for (int c = 0; c < 4; ++c) tables.scale[i][c] = high[c] > low[c] ? high[c] - low[c] : 1.0f;
        for (glm::vec4& value : tables.textures[i].texels()) value = glm::round((value - low) / tables.scale[i] * 65535.0f) / 65535.0f;
    }
    return tables;
}

struct Verified {
    std::vector<LutSample> samples;
    std::vector<LutResult> results;
    LutKeys keys;
};
Verified compareAll(const CookedLut& tables, int randomCount = 12) {
    Verified all;
    all.samples = lutSamples(tables, randomCount, 1);
    for (const LutSample& sample : all.samples) all.results.push_back(compareLut(tables, sample));
    all.keys = lutKeys(all.samples, all.results, kF0);
    return all;
}

std::vector<StageError> verifyAll(const CookedLut& tables, int randomCount = 12) {
    const Verified all = compareAll(tables, randomCount);
    return lutStages(tables, all.samples, all.results, kF0, boundLut(tables, all.keys, kF0));
}

TEST(LutSamples, CoverEveryNodeAndCellAndStayInTheRanges) {
    const CookedLut tables = cook(4, 3, 0.1, 0.7);
    const auto samples = lutSamples(tables, 50, 3);
    int nodes = 0, middles = 0;
    std::set<std::pair<double, double>> places;
    for (const LutSample& sample : samples) {
        nodes += sample.isNode ? 1 : 0;
        middles += sample.isMiddle ? 1 : 0;
        EXPECT_GE(sample.NoV, 0);
        EXPECT_LE(sample.NoV, 1);
        EXPECT_GE(sample.m, 0.1 - 1e-12);
        EXPECT_LE(sample.m, 0.7 + 1e-12);
        places.insert({sample.NoV, sample.m});
    }
    EXPECT_EQ(nodes, 12);
    EXPECT_EQ(middles, 6);
    EXPECT_EQ(places.size(), samples.size());
}

TEST(VerifyLut, GoodTablesQuantizeFinelyAndFilterWithinPercents) {
    const auto stages = verifyAll(cook(8, 6, 0.2, 0.6));
    ASSERT_EQ(stages.size(), 3u);
    EXPECT_EQ(stages[0].name, "quantize");
    EXPECT_EQ(stages[1].name, "filter");
    EXPECT_EQ(stages[2].name, "total");
    EXPECT_GT(stages[0].specular.relRms, 1e-7);
    EXPECT_LT(stages[0].specular.relRms, 1e-4);
    EXPECT_GT(stages[1].specular.relRms, stages[0].specular.relRms);
    EXPECT_LT(stages[1].specular.relRms, 0.2);
    EXPECT_LT(stages[2].specular.relRms, 0.15);
    for (const StageError& stage : stages) {
        EXPECT_GE(stage.specular.maxBound, stage.specular.maxSampled) << stage.name;
        EXPECT_EQ(stage.diffuse.relRms, 0);
    }
}

TEST(VerifyLut, CosinesFilterBetterThanSines) {
    // Near grazing views the kernel is smooth in NoV, but grows as a root in the sine.
    const double sines = verifyAll(cook(8, 4, 0.2, 0.5)).back().specular.relRms;
    const double cosines = verifyAll(cook(8, 4, 0.2, 0.5, {.view = kPlain})).back().specular.relRms;
    EXPECT_LT(cosines, 0.7 * sines);
    EXPECT_LT(verifyAll(cook(8, 4, 0.2, 0.5, {.view = kPlain})).front().specular.relRms, 1e-4);
}

TEST(VerifyLut, OneRowOfRoughnessIsEnoughForOneMaterial) {
    const CookedLut tables = cook(8, 1, 0.3, 0.3);
    for (const LutSample& sample : lutSamples(tables, 9, 1)) EXPECT_NEAR(sample.m, 0.3, 1e-12);
    EXPECT_LT(verifyAll(tables).back().specular.relRms, 0.15);
}

TEST(VerifyLut, FindsWrongContentAndWrongCoordinates) {
    const CookedLut good = cook(6, 3, 0.2, 0.6);
    const double filter = verifyAll(good)[1].specular.relRms;
    CookedLut bright = cook(6, 3, 0.2, 0.6);
    for (glm::vec4& scale : bright.scale) scale *= 4.0f;  // Halo 3's normalization in place of energy normalization
    for (glm::vec4& bias : bright.bias) bias *= 4.0f;
    EXPECT_NEAR(verifyAll(bright)[0].specular.relRms, 3, 0.01);
    CookedLut swapped = cook(6, 3, 0.2, 0.6);
    std::swap(swapped.textures[0], swapped.textures[1]);
    EXPECT_GT(verifyAll(swapped)[2].specular.relRms, 0.3);
    CookedLut shifted = cook(6, 3, 0.2, 0.6);
    shifted.view.offset += 0.5f / 6;  // half a texel: the usual mistake
    EXPECT_GT(verifyAll(shifted)[0].specular.relRms, 0.005);
    EXPECT_GT(verifyAll(shifted)[1].specular.relRms, filter);
    EXPECT_GT(verifyAll(shifted)[1].specular.maxBound, 1e30) << "no bound is known where the filter does not meet the texels";
}

LutStepError stepErrorOf(const CookedLut& tables) {
    const Verified all = compareAll(tables, 0);
    return lutStepError(tables, all.samples, all.results);
}

TEST(LutStepError, IsHalfAStepAtAnySizeAndAxis) {
    const auto expectHalfAStep = [](const CookedLut& tables) {
        const LutStepError worst = stepErrorOf(tables);
        EXPECT_LT(worst.steps, 0.52) << tables.view.count << " x " << tables.roughness.count << ", entry " << worst.entry << " NoV "
                                     << worst.NoV << " m " << worst.m;
    };
    // C 0 of these is nearly the same for all views: a step is less than the distance of floats.
    for (const Factors& view : {kPlain, kSine, kWarped, kRoot})
        for (const double m : {1e-4, 0.05, 0.1})
            for (const int views : {2, 3, 8}) expectHalfAStep(cook(views, 1, m, m, {.view = view}));
    expectHalfAStep(cook(2, 1, 0.05, 0.05, {.view = kSine, .lobe = SpecularLobe::Ggx}));
    expectHalfAStep(cook(2, 1, 0.05, 0.05, {.view = kWarped, .lobe = SpecularLobe::Phong}));
    expectHalfAStep(cook(3, 4, 0.1, 0.1));
    expectHalfAStep(cook(8, 16, 0.001, 0.002));
    // Beside NoV 1 a float is a part of a texel away from the view of these columns.
    expectHalfAStep(cook(512, 1, 0.1, 0.1, {.view = kWarped}));
    expectHalfAStep(cook(1024, 1, 0.05, 0.05, {.view = kSine, .lobe = SpecularLobe::Ggx}));
    expectHalfAStep(cook(2, 1024, 1e-4, 1e-3, {.view = kPlain, .roughness = {0.05, 1, 1, 0}}));
}

TEST(LutStepError, FindsAWrongTexel) {
    CookedLut tables = cook(6, 3, 0.2, 0.6);
    tables.textures[2].at(4, 1).y += 2.0f / 65535;
    const LutStepError worst = stepErrorOf(tables);
    EXPECT_NEAR(worst.steps, 2, 0.52);
    EXPECT_EQ(worst.entry, 9u);
    EXPECT_NEAR(worst.NoV, tables.view.inverse(tables.view.at(4)), 1e-12);
    EXPECT_NEAR(worst.m, 0.4, 1e-12);
    tables.textures[0].at(0, 2).x = NAN;
    EXPECT_EQ(stepErrorOf(tables).entry, 0u) << "no number is the largest error";
}

TEST(LutAxis, HasAnErrorIfItsCoordinatesMissTheTexels) {
    for (const int count : {2, 8, 24, 1024})
        for (const Factors& factors : {kPlain, kSine, kWarped, kRoot}) {
            LutAxis axis = axisOf(count, 0, 1, factors);
            EXPECT_LE(axis.coordinateError(), axis.coordinateRounding() + 1e-9);
            EXPECT_LT(axis.coordinateRounding(), 2e-4);
            axis.offset += 0.5f / static_cast<float>(count);
            EXPECT_NEAR(axis.coordinateError(), 0.5, 1e-3);
        }
    const LutAxis narrow = axisOf(16, 0.5, 0.5001, kPlain);
    EXPECT_LE(narrow.coordinateError(), narrow.coordinateRounding() + 1e-9);
}

TEST(VerifyLut, TotalIsTheAreaSpecularOfConstantLight) {
    // One sample, whose C0 is wrong by 10 %: for F0 = 1 and constant light the reflected radiance is wrong by as much.
    LutResult result;
    result.reference[0] = 0.25;
    result.cooked[0] = 0.275;
    const std::vector<LutSample> samples = {{0.5, 0.3, true, false}};
    const auto stages = lutStages({}, samples, {result}, {1.0}, {});
    EXPECT_NEAR(stages[2].specular.relRms, 0.1, 1e-6);
    EXPECT_NEAR(stages[2].specular.maxSampled, 0.1 / 1.02, 2e-3);
}

/// Returns the node before a place.
std::size_t cellOf(const LutAxis& axis, double t) {
    if (axis.count == 1) return 0;
    const double place = (axis.of(t) - axis.minimum) / (axis.maximum - axis.minimum);
    return static_cast<std::size_t>(std::clamp(static_cast<int>(place * (axis.count - 1)), 0, axis.count - 2));
}

/// Compares random views, each with a hundred roughnesses, with the bounds of their cells. No error may exceed its bound. Returns the
/// largest ratios of error to bound: of the entries, and of the local relative errors.
struct Filled {
    double entries = 0, filter = 0, total = 0;
};
Filled throwPlaces(const CookedLut& tables, long long count, unsigned seed) {
    const LutKeys keys = compareAll(tables).keys;
    std::vector<std::vector<LutCellBound>> cells;
    for (int cell = 0; cell + 1 < tables.view.count; ++cell) cells.push_back(boundLut(tables, cell, keys, kF0));
    const auto shadings = lutShadings(kF0);
    const double low = tables.roughness.inverse(tables.roughness.minimum), high = tables.roughness.inverse(tables.roughness.maximum);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> uniform(0, 1);
    Filled filled;
    LutBounds worst;
    for (long long i = 0; i < count / 100; ++i) {
        const double NoV = i % 3 == 0   ? std::pow(10, -4 * uniform(random))
                           : i % 3 == 1 ? 1 - std::pow(10, -4 * uniform(random))
                                        : uniform(random);
        const lighting::AreaSpecularColumn column(std::max(NoV, kSmallestTableNoV), low, high, tables.lobe, 12);
        for (int k = 0; k < 100; ++k) {
            const double m = low + (high - low) * uniform(random);
            const SpecularKernelEntries truth = entriesOf(column.kernel(m, tables.normalization)), seen = fetchLut(tables, NoV, m);
            const LutCellBound& bound = cells[cellOf(tables.view, NoV)][cellOf(tables.roughness, m)];
            for (std::size_t e = 0; e < truth.size(); ++e) {
                const double error = std::abs(seen[e] - truth[e]),
                             local = error / (std::abs(truth[e]) + lighting::kLocalErrorFloor * keys.kernel);
                EXPECT_LE(error, bound.entries[e]) << "entry " << e << " NoV " << NoV << " m " << m;
                EXPECT_LE(local, bound.filter) << "entry " << e << " NoV " << NoV << " m " << m;
                filled.entries = std::max(filled.entries, error / bound.entries[e]);
                worst.filter = std::max(worst.filter, local);
            }
            for (const SpecularKernelEntries& shading : shadings) {
                double reflected = 0, error = 0;
                for (std::size_t e = 0; e < truth.size(); ++e) {
                    reflected += shading[e] * truth[e];
                    error += shading[e] * (seen[e] - truth[e]);
                }
                const double local = std::abs(error) / (std::abs(reflected) + lighting::kLocalErrorFloor * keys.shaded);
                EXPECT_LE(local, bound.total) << "NoV " << NoV << " m " << m;
                worst.total = std::max(worst.total, local);
            }
            if (testing::Test::HasFailure()) return filled;
        }
    }
    const LutBounds all = boundLut(tables, keys, kF0);
    filled.filter = worst.filter / all.filter;
    filled.total = worst.total / all.total;
    std::printf("[ figures  ] filter %.4g of %.4g, total %.4g of %.4g, fullest entry %.2f\n", worst.filter, all.filter, worst.total,
                all.total, filled.entries);
    return filled;
}

/// Compares visible errors of random places with the bound. A sampler reads a place up to 1/256 texel away, and its values are off by the
/// tolerance of the format.
void throwVisible(const CookedLut& tables, int count, unsigned seed) {
    const Viewing viewing{lighting::DisplaySettings{}.of(1)};
    const LutBounds bounds = boundLut(tables, compareAll(tables).keys, kF0, viewing);
    const auto shadings = lutShadings(kF0);
    const auto exits = lutExitRadiances(kF0);
    const double low = tables.roughness.inverse(tables.roughness.minimum), high = tables.roughness.inverse(tables.roughness.maximum);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> uniform(0, 1);
    double largest = 0;
    for (int i = 0; i < count; ++i) {
        const double NoV = i % 2 == 0 ? std::pow(10, -4 * uniform(random)) : uniform(random), m = low + (high - low) * uniform(random);
        const SpecularKernelEntries truth = compareLut(tables, {NoV, m, false, false}).reference;
        const auto moved = [&](const LutAxis& axis, double t) {
            const double step = (axis.maximum - axis.minimum) / (axis.count - 1) / 256;
            return axis.inverse(std::clamp(axis.of(t) + (2 * uniform(random) - 1) * step, axis.minimum, axis.maximum));
        };
        SpecularKernelEntries seen = fetchLut(tables, moved(tables.view, NoV), moved(tables.roughness, m));
        for (std::size_t k = 0; k < seen.size(); ++k)
            seen[k] += (uniform(random) < 0.5 ? -1 : 1) * static_cast<double>(tables.tolerance[k / 4].absolute) *
                       std::abs(static_cast<double>(tables.scale[k / 4][static_cast<int>(k % 4)]));
        for (std::size_t s = 0; s < shadings.size(); ++s) {
            double reference = 0, found = 0;
            for (std::size_t k = 0; k < truth.size(); ++k) {
                reference += shadings[s][k] * truth[k] / exits[s];
                found += shadings[s][k] * seen[k] / exits[s];
            }
            largest = std::max(largest, lighting::visibleDifference(glm::dvec3(reference), glm::dvec3(found), viewing.display));
        }
    }
    EXPECT_LE(largest, bounds.visible.value());
    EXPECT_GT(largest, 0.2 * *bounds.visible) << "a bound that no place comes near says little";
    EXPECT_TRUE(bounds.visibleAt.isKnown());
    EXPECT_EQ(bounds.visibleAt.difference, *bounds.visible);
}

TEST(LutBound, OfVisibleErrorsHoldsForEverySampler) {
    CookedLut tables = cook(8, 8, 0.1, 0.6, {.view = kWarped});
    tables.tolerance.fill(toleranceOf(formats::PixelFormat::Rgba16Unorm));
    throwVisible(tables, 2000, 1);
    for (glm::vec4& texel : tables.textures[0].texels()) texel.x *= 0.8f;  // wrong tables are seen by the bound, too
    throwVisible(tables, 500, 2);
    throwVisible(cook(6, 4, 0.2, 0.7, {.lobe = SpecularLobe::Ggx}), 1000, 3);
}

TEST(LutBound, OfVisibleErrorsIsInTheLastStageAndGrowsWithTheError) {
    CookedLut tables = cook(8, 6, 0.2, 0.6), shifted = cook(8, 6, 0.2, 0.6);
    const Viewing viewing{lighting::DisplaySettings{}.of(1)};
    EXPECT_FALSE(boundLut(tables, compareAll(tables).keys, kF0).visible.has_value()) << "without a display";
    const auto boundOf = [&](const CookedLut& each) {
        const Verified all = compareAll(each);
        const auto stages = lutStages(each, all.samples, all.results, kF0, boundLut(each, all.keys, kF0, viewing), viewing);
        const VisibleFigures& visible = stages[2].specular.visible.value();
        EXPECT_GE(visible.bound.value(), visible.max);
        return *visible.bound;
    };
    const double good = boundOf(tables);
    tables.textures[0].at(4, 3).x += 40;
    EXPECT_GT(boundOf(tables), 1.5 * good);
    shifted.view.offset += 0.1f / 8;
    EXPECT_EQ(boundOf(shifted), HUGE_VAL) << "no bound is known where the filter does not meet the texels";
}

TEST(LutBound, HoldsAtAMillionPlaces) {
    const Filled usual = throwPlaces(cook(8, 16, 1.0 / 16, 1, {.view = kWarped}), 400'000, 1);
    EXPECT_GT(usual.filter, 0.5) << "a bound that no place comes near says little";
    EXPECT_GT(usual.total, 0.5);
    throwPlaces(cook(8, 8, 0.1, 0.5, {.view = kPlain}), 200'000, 2);
    throwPlaces(cook(8, 8, 0.1, 0.5, {.view = kSine, .roughness = kRoot}), 100'000, 3);
    throwPlaces(cook(8, 8, 0.1, 1, {.view = kWarped, .lobe = SpecularLobe::Ggx, .normalization = CookTorranceNormalization::Halo3}),
                100'000, 4);
    throwPlaces(cook(5, 3, 0.005, 0.02, {.view = {1, -1, 1, 0}}), 50'000, 5);
    const Filled wide = throwPlaces(cook(8, 4, 1e-4, 1, {.view = kWarped}), 50'000, 9);
    EXPECT_GT(wide.filter, 0.2) << "smallest lobes between coarse rows have a bound worth the name too";
    throwPlaces(cook(8, 8, 0.1, 1, {.view = kWarped, .lobe = SpecularLobe::Phong}), 50'000, 6);
    throwPlaces(cook(8, 8, 0.1, 1, {.view = {0.05, 1, 1, 0}, .roughness = {0, 1, 0.2, 1}, .lobe = SpecularLobe::PhongPower}), 50'000, 7);
    throwPlaces(cook(6, 1, 0.3, 0.3, {.view = kWarped}), 50'000, 8);
}

TEST(LutBoundSoak, HoldsAtAHundredMillionPlaces) {
    unsigned seed = 100;
    for (const SpecularLobe lobe : {SpecularLobe::Beckmann, SpecularLobe::Ggx, SpecularLobe::Phong, SpecularLobe::PhongPower})
        for (const auto& view : {kPlain, kSine, kWarped, kRoot})
            throwPlaces(cook(8, 16, 1.0 / 16, 1, {.view = view, .lobe = lobe}), 6'250'000, seed++);
}

}  // namespace
}  // namespace lightcook::verify

// Visible errors of light maps against sums in doubles, texel by texel.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "formats/specular_lobe.h"
#include "lighting/area_specular.h"
#include "lighting/sphere.h"
#include "tests/compress/synthetic_light_map.h"
#include "tests/verify/cooked_light_map.h"

namespace lightcook::verify {
namespace {

using formats::LightMapStrip;

constexpr int kVisibleWidth = 24, kVisibleHeight = 16;

/// Differences of all samples, sorted.
struct Sorted {
    std::vector<double> values;
    double quantile(double share) const { return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))]; }
    double rms() const {
        double squares = 0;
        for (const double value : values) squares += value * value;
        return std::sqrt(squares / static_cast<double>(values.size()));
    }
};

/// Returns the differences of the exit radiance of a white surface at the normals of the cap, by the definition.
Sorted diffuseDifferences(const LightMapStrip& reference, const formats::Image<lighting::ShRgb>& found, double tilt,
                          const lighting::Display& display) {
    Sorted sorted;
    for (int y = 0; y < kVisibleHeight; ++y)
        for (int x = 0; x < kVisibleWidth; ++x) {
            if (reference.covered.at(x, y) == 0) continue;
            const glm::dmat3 frame = lighting::worldFromTangentFrame(glm::dvec3(reference.normal.at(x, y)));
            for (int i = -1; i < (tilt > 0 ? 24 : 0); ++i) {
                const double z = i < 0 ? 1 : 1 - (1 - std::cos(tilt * std::numbers::pi / 180)) * (i + 0.5) / 24, r = std::sqrt(1 - z * z);
                const double azimuth = i * std::numbers::pi * (3 - std::sqrt(5.0));
                const glm::dvec3 normal = frame * glm::dvec3(r * std::cos(azimuth), r * std::sin(azimuth), z);
                const lighting::ShDouble basis = lighting::evaluateBasis(normal);
                glm::dvec3 a(0), b(0);
                for (std::size_t k = 0; k < basis.size(); ++k) {
                    const double weight = basis[k] * lighting::kExitRadianceBands[static_cast<std::size_t>(lighting::kShBand[k])];
                    a += weight * glm::dvec3(reference.sh.at(x, y)[k]);
                    b += weight * glm::dvec3(found.at(x, y)[k]);
                }
                sorted.values.push_back(lighting::visibleDifference(a, b, display));
            }
        }
    std::ranges::sort(sorted.values);
    return sorted;
}

/// Returns the bake with its coefficients rounded to steps of a share of coefficient 0.
formats::Image<lighting::ShRgb> rounded(const LightMapStrip& bake, float share) {
    formats::Image<lighting::ShRgb> out = bake.sh.copy();
    for (lighting::ShRgb& sh : out.texels())
        for (int c = 0; c < 3; ++c) {
            const float step = share * std::max(sh[0][c], 1e-6f);
            for (glm::vec3& coefficient : sh) coefficient[c] = step * std::round(coefficient[c] / step + 0.3f);
        }
    return out;
}

TEST(VisibleError, OfDiffuseLightIsThatOfTheDefinition) {
    for (const synthetic::Kind kind : {synthetic::Kind::Gradient, synthetic::Kind::Night})
        for (const double tilt : {0.0, 60.0}) {
            const LightMapStrip bake = synthetic::makeBand(kind, kVisibleWidth, 0, kVisibleHeight);
            const formats::Image<lighting::ShRgb> found = rounded(bake, 0.2f);
            LightMapKey key;
            key.add(bake, 0, kVisibleHeight);
            const Viewing viewing{lighting::DisplaySettings{}.of(key.displayKey())};
            LightMapShading shading;
            shading.normalMapTilt = tilt;
            shading.normalCount = tilt > 0 ? 32 : 1;
            const auto score = LightMapScore::create(shading, key.key(), viewing);
            ASSERT_TRUE(score.has_value());
            const ErrorFigures figures = score->score(bake, found.view(), 0).diffuseFigures();
            ASSERT_TRUE(figures.visible.has_value());
            const Sorted truth = diffuseDifferences(bake, found, tilt, viewing.display);
            EXPECT_GT(truth.values.back(), 2);
            EXPECT_NEAR(figures.visible->max, truth.values.back(), 0.003 + 5e-4 * truth.values.back());
            EXPECT_NEAR(figures.visible->rms, truth.rms(), 0.001 + 1e-3 * truth.rms());
            EXPECT_NEAR(figures.visible->p50, truth.quantile(0.5), 0.003 + 0.02 * truth.quantile(0.5));
            EXPECT_NEAR(figures.visible->p99, truth.quantile(0.99), 0.003 + 0.03 * truth.quantile(0.99));
            const VisiblePlace& worst = figures.visible->maxAt;
            EXPECT_TRUE(worst.isKnown());
            EXPECT_NEAR(lighting::visibleDifference(worst.reference, worst.found, viewing.display), figures.visible->max,
                        0.003 + 1e-3 * figures.visible->max)
                << "the place has the light of both";
        }
}

TEST(VisibleError, OfSpecularLightIsThatOfItsKernels) {
    const LightMapStrip bake = synthetic::makeBand(synthetic::Kind::Gradient, kVisibleWidth, 0, kVisibleHeight);
    const formats::Image<lighting::ShRgb> found = rounded(bake, 0.3f);
    LightMapKey key;
    key.add(bake, 0, kVisibleHeight);
    const Viewing viewing{lighting::DisplaySettings{}.of(key.displayKey())};
    LightMapShading shading;
    shading.m = {0.3};
    shading.f0 = {0.6};
    const auto score = LightMapScore::create(shading, key.key(), viewing);
    ASSERT_TRUE(score.has_value());
    const ErrorFigures figures = score->score(bake, found.view(), 0).specularFigures();
    ASSERT_TRUE(figures.visible.has_value());
    double largest = 0;
    for (int y = 0; y < kVisibleHeight; ++y)
        for (int x = 0; x < kVisibleWidth; ++x) {
            if (bake.covered.at(x, y) == 0) continue;
            const glm::dmat3 frame = lighting::worldFromTangentFrame(glm::dvec3(bake.normal.at(x, y)));
            for (int i = 0; i < shading.viewCount; ++i) {
                const glm::dvec3 view = lighting::fibonacciHemisphere(i, shading.viewCount);
                const auto kernel =
                    lighting::areaSpecular(view.z, 0.3, lighting::SpecularLobe::Beckmann, lighting::CookTorranceNormalization::Energy);
                const double azimuth = std::atan2(view.y, view.x), c = std::cos(azimuth), s = std::sin(azimuth);
                const lighting::ShRotation turn(frame * glm::dmat3(c, s, 0, -s, c, 0, 0, 0, 1));
                lighting::ShDouble row{};
                for (std::size_t k = 0; k < row.size(); ++k) row[k] = 0.6 * kernel.c[k] + 0.4 * kernel.d[k];
                row = turn.apply(row);
                glm::dvec3 a(0), b(0);
                for (std::size_t k = 0; k < row.size(); ++k) {
                    a += row[k] * glm::dvec3(bake.sh.at(x, y)[k]);
                    b += row[k] * glm::dvec3(found.at(x, y)[k]);
                }
                largest = std::max(largest, lighting::visibleDifference(a, b, viewing.display));
            }
        }
    EXPECT_GT(largest, 5);
    EXPECT_NEAR(figures.visible->max, largest, 0.005 * largest);
}

TEST(VisibleError, OfTheBakeItselfIsNoneAndWithoutAViewingThereIsNone) {
    const LightMapStrip bake = synthetic::makeBand(synthetic::Kind::Gradient, kVisibleWidth, 0, kVisibleHeight);
    const auto score = LightMapScore::create({}, 1, Viewing{});
    const ShadedErrors errors = score->score(bake, bake.sh.view(), 0);
    EXPECT_EQ(errors.diffuseFigures().visible->max, 0);
    EXPECT_EQ(errors.specularFigures().visible->p999, 0);
    EXPECT_FALSE(LightMapScore::create({}, 1)->score(bake, bake.sh.view(), 0).diffuseFigures().visible.has_value());
}

TEST(VisibleError, OfStripsMergedIsThatOfTheWhole) {
    const LightMapStrip bake = synthetic::makeBand(synthetic::Kind::Gradient, kVisibleWidth, 0, kVisibleHeight);
    const formats::Image<lighting::ShRgb> found = rounded(bake, 0.2f);
    const auto score = LightMapScore::create({}, 1, Viewing{});
    ShadedErrors merged;
    for (int row = 0; row < kVisibleHeight; row += 5)
        merged.merge(score->score(bake, found.view().rows(row, std::min(5, kVisibleHeight - row)), row));
    const VisibleFigures whole = *score->score(bake, found.view(), 0).diffuseFigures().visible, parts = *merged.diffuseFigures().visible;
    EXPECT_EQ(parts.p99, whole.p99);
    EXPECT_EQ(parts.max, whole.max);
    EXPECT_EQ(parts.maxAt.x, whole.maxAt.x);
    EXPECT_NEAR(parts.rms, whole.rms, 1e-12);
}

TEST(LightMapKey, OfTheDisplayIsTheDefinition) {
    for (const synthetic::Kind kind : {synthetic::Kind::Gradient, synthetic::Kind::Night, synthetic::Kind::Spikes}) {
        const LightMapStrip bake = synthetic::makeBand(kind, kVisibleWidth, 0, kVisibleHeight);
        std::vector<double> luminances;
        for (int y = 0; y < kVisibleHeight; ++y)
            for (int x = 0; x < kVisibleWidth; ++x)
                if (bake.covered.at(x, y) != 0)
                    luminances.push_back(static_cast<double>(
                        glm::dot(lighting::lambertExitRadiance(bake.sh.at(x, y), bake.normal.at(x, y), glm::vec3(1)).value,
                                 lighting::kRec709Luminance)));
        double mean = 0, logs = 0;
        for (const double y : luminances) mean += std::max(y, 0.0) / static_cast<double>(luminances.size());
        for (const double y : luminances) logs += std::log(std::max(y, mean / 1024)) / static_cast<double>(luminances.size());
        LightMapKey key, top, bottom;
        key.add(bake, 0, kVisibleHeight);
        EXPECT_NEAR(key.displayKey(), std::exp(logs), 1e-3 * std::exp(logs));
        EXPECT_GE(key.displayKey(), key.key() * (1 - 1e-3));
        top.add(bake, 0, 7);
        bottom.add(bake, 7, kVisibleHeight - 7);
        bottom.merge(top);
        EXPECT_EQ(bottom.displayKey(), key.displayKey());
        EXPECT_EQ(bottom.key(), key.key());
    }
}

/// Of a bake that does not say which texels lie inside charts, black gaps would brighten the picture of the rest.
TEST(LightMapKey, LeavesOutTexelsWithoutLightWhereNoCoverageIsKnown) {
    LightMapStrip bake = synthetic::makeBand(synthetic::Kind::Gradient, kVisibleWidth, 0, kVisibleHeight);
    LightMapKey charts;
    charts.add(bake, 0, kVisibleHeight);
    ASSERT_LT(charts.coveredTexels(), kVisibleWidth * kVisibleHeight);
    for (int y = 0; y < kVisibleHeight; ++y)
        for (int x = 0; x < kVisibleWidth; ++x) {
            if (bake.covered.at(x, y) == 0) bake.sh.at(x, y) = {};
            bake.covered.at(x, y) = 1;
        }
    LightMapKey known, unknown(lighting::kRec709Luminance, false);
    known.add(bake, 0, kVisibleHeight);
    unknown.add(bake, 0, kVisibleHeight);
    EXPECT_EQ(unknown.displayKey(), charts.displayKey());
    EXPECT_EQ(unknown.key(), charts.key());
    EXPECT_LT(known.displayKey(), charts.displayKey()) << "where a texel is said to be covered, its black is black light";
}

/// The verdict is that of the surface; figures of texel centres stand beside it, and the largest error is that of both.
TEST(VisibleError, OfTheWholeIsThatOfTheSurface) {
    test::Cooked cooked = test::cook(synthetic::makeBand(synthetic::Kind::Spikes, kVisibleWidth, 0, kVisibleHeight),
                                     formats::LightMapLayout::Hdr2, formats::Target::Bc, 1);
    const auto verifier = LightMapVerifier::create(cooked.map, {}, {}, cooked.key, Viewing{});
    ASSERT_TRUE(verifier.has_value());
    const LightMapErrors errors = verifier->verifyRows(cooked.texels, cooked.reference, 0, kVisibleHeight);
    const auto stages = errors.figures();
    const VisibleFigures total = *stages.back().diffuse.visible, surface = errors.surface.visibleDiffuse.figures(),
                         centres = *stages[stages.size() - 2].diffuse.visible;
    EXPECT_GT(centres.p99, 0);
    EXPECT_NE(centres.p99, surface.p99);
    EXPECT_EQ(total.p99, surface.p99);
    EXPECT_EQ(stages.back().atTexels->diffuse.visible->p99, centres.p99);
    EXPECT_EQ(total.max, std::max(centres.max, surface.max));
    EXPECT_EQ(total.maxAt.difference, total.max);
}

/// A trial measures every stage on the surface: the last one has the figures of the verdict.
TEST(LightMapTrial, MeasuresEveryStageOnTheSurface) {
    for (const auto layout : {formats::LightMapLayout::Ratio, formats::LightMapLayout::Basis8}) {
        const test::Cooked cooked =
            test::cook(synthetic::makeBand(synthetic::Kind::Gradient, kVisibleWidth, 0, kVisibleHeight), layout, formats::Target::Bc, 1);
        LightMapSampling trial;
        trial.figures = LightMapFigures::Trial;
        const auto tried = cooked.stages({}, trial), verified = cooked.stages();
        ASSERT_EQ(tried.size(), verified.size());
        EXPECT_EQ(tried[tried.size() - 2].diffuse.relRms, verified.back().diffuse.relRms);
        EXPECT_EQ(tried[tried.size() - 2].specular.relRms, verified.back().specular.relRms);
        EXPECT_GT(tried[0].diffuse.relRms, 0);
        EXPECT_NE(tried[0].diffuse.relRms, verified[0].diffuse.relRms);
    }
}

/// Squares of diffuse light on the surface are, but for the directions, those of its figures.
TEST(LightMapStages, HaveTheSquaresOfTheSurface) {
    test::Cooked cooked = test::cook(synthetic::makeBand(synthetic::Kind::Gradient, kVisibleWidth, 0, kVisibleHeight),
                                     formats::LightMapLayout::Basis8, formats::Target::Bc, 1);
    LightMapSampling sampling;
    sampling.figures = LightMapFigures::Sampled;
    const LightMapErrors errors = cooked.verifier({}, sampling).verifyRows(cooked.texels, cooked.reference, 0, kVisibleHeight);
    const double onSurface = errors.surface.diffuseFigures().relRms;
    EXPECT_NEAR(errors.stages[2].surface.relRms(), onSurface, 0.3 * onSurface) << "hemispheres of the normals beside the sphere";
    EXPECT_GT(errors.stages[1].surface.relRms(), errors.stages[2].surface.relRms()) << "the residual is of this map";
    cooked.texels.textures[2][0] = formats::Image<glm::vec4>(kVisibleWidth, kVisibleHeight, glm::vec4(1));
    const LightMapErrors wrong = cooked.verifier({}, sampling).verifyRows(cooked.texels, cooked.reference, 0, kVisibleHeight);
    EXPECT_EQ(wrong.stages[1].surface.relRms(), errors.stages[1].surface.relRms());
    EXPECT_GT(wrong.stages[2].surface.relRms(), 2 * wrong.stages[1].surface.relRms()) << "the residual is of no map";
}

/// Every covered texel has as many places as another, also at the rims of charts and at the edges of the map.
TEST(SurfacePlaces, LieEvenlyOnTheFootprintsOfCoveredTexels) {
    const test::Cooked cooked = test::cook(synthetic::makeBand(synthetic::Kind::Gradient, kVisibleWidth, 0, kVisibleHeight),
                                           formats::LightMapLayout::Raw, formats::Target::Float, 1);
    std::int64_t covered = 0;
    for (const std::uint8_t each : cooked.reference.covered.texels()) covered += each != 0;
    LightMapSampling sampling;
    sampling.placesPerTexel = 64;
    sampling.figures = LightMapFigures::Sampled;
    const LightMapErrors errors = cooked.verifier({}, sampling).verifyRows(cooked.texels, cooked.reference, 0, kVisibleHeight);
    const double texels = static_cast<double>(errors.surface.diffuse.sampleCount()) /
                          static_cast<double>(errors.stages[0].errors.diffuse.sampleCount()) * static_cast<double>(covered) / 64;
    EXPECT_NEAR(texels, static_cast<double>(covered), 0.01 * static_cast<double>(covered));
}

}  // namespace
}  // namespace lightcook::verify

#include "verify/dominant.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <numeric>
#include <random>

#include "fit/dominant_light.h"
#include "lighting/brdf.h"
#include "lighting/display.h"
#include "lighting/sphere.h"
#include "verify/error/visible_metric.h"

namespace lightcook::verify {
namespace {

constexpr int kDominantWidth = 24, kDominantHeight = 20;
constexpr double kKey = 0.5;

/// A light source that moves over the map, ambient light, and a hole in the charts.
formats::LightMapStrip bake(bool isUneven = true) {
    formats::LightMapStrip band;
    band.sh = formats::Image<lighting::ShRgb>(kDominantWidth, kDominantHeight);
    band.covered = formats::Image<std::uint8_t>(kDominantWidth, kDominantHeight, 1);
    band.normal = formats::Image<glm::vec3>(kDominantWidth, kDominantHeight);
    for (int y = 0; y < kDominantHeight; ++y)
        for (int x = 0; x < kDominantWidth; ++x) {
            const double s = isUneven ? 0.03 * x : 0.2, t = isUneven ? 0.04 * y : 0.1;
            band.sh.at(x, y) = lighting::projectDirectional(glm::vec3(glm::normalize(glm::dvec3(s, t, 1))), glm::vec3(3, 2, 1));
            band.sh.at(x, y)[0] += glm::vec3(0.4f, 0.5f, 0.9f);
            band.normal.at(x, y) = glm::vec3(glm::normalize(glm::dvec3(0.1 * t, 0.2 * s, 1)));
        }
    band.covered.at(5, 5) = 0;
    return band;
}

CookedDominant description() {
    return {2, -1, 4, kDominantWidth, kDominantHeight};
}

/// The closed form in floats, stored without loss.
DecodedDominantRows exact(const formats::LightMapStrip& band, int firstRow = 0, int rowCount = kDominantHeight) {
    DecodedDominantRows rows{firstRow, formats::Image<glm::vec4>(kDominantWidth, rowCount),
                             formats::Image<glm::vec4>(kDominantWidth, rowCount)};
    for (int y = 0; y < rowCount; ++y)
        for (int x = 0; x < kDominantWidth; ++x) {
            const auto light =
                dominantReference(band.sh.at(x, firstRow + y), glm::dvec3(band.normal.at(x, firstRow + y)), lighting::kRec709Luminance);
            rows.direction.at(x, y) = glm::vec4(glm::vec3(0.5 * light.direction + 0.5), 1);
            rows.intensity.at(x, y) = glm::vec4(glm::vec3(light.intensity / 4.0), 1);
        }
    return rows;
}

DominantVerifier verifier(int stride = 1, lighting::NormalDistribution lobe = lighting::NormalDistribution::Beckmann) {
    return {description(), {{0.1, 0.5}, {0.04, 0.6}, 8, stride, lobe}, lighting::kRec709Luminance, kKey};
}

TEST(DominantReference, IsTheClosedFormThatTheFitDocuments) {
    std::mt19937 random(5);
    std::normal_distribution<float> normal;
    for (int i = 0; i < 2000; ++i) {
        lighting::ShRgb sh;
        for (glm::vec3& c : sh) c = glm::vec3(normal(random), normal(random), normal(random));
        sh[0] = glm::abs(sh[0]) * static_cast<float>(i % 40);  // from no coefficient 0 to almost no directionality
        const glm::vec3 n(lighting::fibonacciSphere(i % 50, 50));
        const fit::DominantLight expected = fit::dominantLight(sh, n, {});
        const DominantLightSample found = dominantReference(sh, glm::dvec3(n), lighting::kRec709Luminance);
        EXPECT_LT(glm::length(found.direction - glm::dvec3(expected.direction)), 1e-6) << i;
        EXPECT_LT(glm::length(found.intensity - glm::dvec3(expected.intensity)), 1e-5) << i;
    }
}

TEST(DominantReference, FindsASingleLightSourceAndNoneInConstantLight) {
    const glm::dvec3 direction = glm::normalize(glm::dvec3(1, 2, -0.5));
    const auto lamp =
        dominantReference(lighting::projectDirectional(glm::vec3(direction), glm::vec3(5, 6, 7)), {0, 0, 1}, lighting::kRec709Luminance);
    EXPECT_LT(glm::length(lamp.direction - direction), 1e-6);
    EXPECT_LT(glm::length(lamp.intensity - glm::dvec3(5, 6, 7)), 1e-5);
    lighting::ShRgb constant{};
    constant[0] = glm::vec3(1);
    const auto nothing = dominantReference(constant, {0, 1, 0}, lighting::kRec709Luminance);
    EXPECT_LT(glm::length(nothing.direction - glm::dvec3(0, 0.08, 0)), 1e-7);
    EXPECT_EQ(nothing.intensity, glm::dvec3(0));
    EXPECT_EQ(dominantReference({}, {0, 0, 1}, lighting::kRec709Luminance).intensity, glm::dvec3(0));
}

lighting::ShRgb lampsOverAmbient(std::mt19937& random) {
    std::uniform_real_distribution<float> uniform;
    const auto color = [&] { return glm::vec3(uniform(random), uniform(random), uniform(random)); };
    lighting::ShRgb sh{};
    const int lamps = 1 + static_cast<int>(random() % 4);
    for (int lamp = 0; lamp < lamps; ++lamp) {
        const auto one =
            lighting::projectDirectional(glm::vec3(lighting::fibonacciSphere(static_cast<int>(random() % 1000), 1000)), color());
        for (std::size_t i = 0; i < sh.size(); ++i) sh[i] += one[i];
    }
    sh[0] += 2.0f * color();
    return sh;
}

double residualOf(const lighting::ShRgb& sh, const DominantLightSample& light, bool hasAmbient) {
    const Unexplained unexplained = unexplainedBy(sh, light, hasAmbient);
    return std::sqrt(unexplained.error / unexplained.energy);
}

TEST(RefinedReference, IsTheLightThatTheFitDocuments) {
    std::mt19937 random(6);
    int other = 0;
    for (int i = 0; i < 4000; ++i) {
        const lighting::ShRgb sh = lampsOverAmbient(random);
        const glm::dvec3 normal = lighting::fibonacciSphere(i % 50, 50);
        const bool hasAmbient = i % 2 == 0;
        fit::DominantLightOptions options;
        options.fit = hasAmbient ? fit::DominantFit::RefinedAmbient : fit::DominantFit::Refined;
        options.tolerance = 0;
        const fit::DominantLight fitted = fit::dominantLight(sh, glm::vec3(normal), options);
        const DominantLightSample promised{glm::dvec3(fitted.direction), glm::dvec3(fitted.intensity)};
        const auto found = refinedReference(sh, normal, lighting::kRec709Luminance, hasAmbient, promised.direction);
        const bool isFaded = fitted.directionality < 0.08f;  // the stored direction is between the light and the normal
        EXPECT_NEAR(residualOf(sh, found, hasAmbient), residualOf(sh, promised, hasAmbient), isFaded ? 2e-3 : 1e-5) << i;
        if (glm::distance(found.direction, promised.direction) > 1e-3 ||
            glm::distance(found.intensity, promised.intensity) > 1e-3 * glm::length(promised.intensity))
            ++other;
    }
    EXPECT_LE(other, 20);  // ridges: directions with equal error
}

TEST(RefinedReference, DoesNotAcceptAWorseStoredLight) {
    std::mt19937 random(7);
    int missed = 0;
    for (int i = 0; i < 2000; ++i) {
        const lighting::ShRgb sh = lampsOverAmbient(random);
        const bool hasAmbient = i % 2 == 0;
        const glm::dvec3 normal(0, 0, 1);
        if (fit::dominantLight(sh, glm::vec3(normal), {}).directionality < 0.08f) continue;  // blended with the normal
        double least = 2;
        for (int j = 0; j < 20; ++j)
            least = std::min(
                least,
                residualOf(sh, refinedReference(sh, normal, lighting::kRec709Luminance, hasAmbient, lighting::fibonacciSphere(j, 20)),
                           hasAmbient));
        const auto unseen = refinedReference(sh, normal, lighting::kRec709Luminance, hasAmbient, glm::dvec3(0));
        const auto seen = refinedReference(sh, normal, lighting::kRec709Luminance, hasAmbient, lighting::fibonacciSphere(i % 97, 97));
        const double most = std::max(residualOf(sh, unseen, hasAmbient), residualOf(sh, seen, hasAmbient));
        if (most > least + 2e-3) ++missed;
        EXPECT_LT(most, least + 1e-2) << i;
    }
    EXPECT_LE(missed, 2);  // a third local maximum as high as the others
}

TEST(RefinedReference, StaysFinite) {
    for (const float value : {0.0f, 1e-45f, 1e30f, -1e30f, 3e38f})
        for (const bool hasAmbient : {false, true}) {
            lighting::ShRgb sh;
            sh.fill(glm::vec3(value));
            sh[0] = glm::abs(sh[0]);
            const auto light = refinedReference(sh, {0, 0, 1}, lighting::kRec709Luminance, hasAmbient, {1, 0, 0});
            for (int channel = 0; channel < 3; ++channel) {
                EXPECT_TRUE(std::isfinite(light.intensity[channel]) && light.intensity[channel] >= 0) << value;
                EXPECT_TRUE(std::isfinite(light.direction[channel])) << value;
            }
        }
}

TEST(VerifyDominant, LosslessTexturesHaveNoErrorAtTexels) {
    const auto band = bake();
    const DominantErrors errors = verifier().verifyRows(exact(band), band, 0, kDominantHeight);
    const auto stages = errors.stages();
    ASSERT_EQ(stages.size(), 2u);
    EXPECT_EQ(stages[0].name, "magnified");
    EXPECT_EQ(stages[1].name, "total");
    EXPECT_LT(stages[1].specular.relRms, 1e-5);
    EXPECT_EQ(stages[1].diffuse.relRms, 0);
    EXPECT_GT(stages[0].specular.relRms, 0);
    EXPECT_LT(stages[0].specular.relRms, 0.02);
    EXPECT_LT(errors.meanDirectionError(), 1e-4);
    EXPECT_LT(errors.maxDirectionError(), 1e-3);
    for (const StageError& stage : stages) EXPECT_GE(stage.specular.maxBound, stage.specular.maxSampled);
}

TEST(VerifyDominant, AMapThatIsEvenIsAlsoExactBetweenTexels) {
    const auto band = bake(false);
    EXPECT_LT(verifier().verifyRows(exact(band), band, 0, kDominantHeight).stages()[0].specular.relRms, 1e-5);
}

TEST(VerifyDominant, ReportsARotatedDirectionInDegrees) {
    const auto band = bake();
    DecodedDominantRows rows = exact(band);
    const double angle = 3 * std::numbers::pi / 180;
    for (glm::vec4& texel : rows.direction.texels()) {
        const glm::dvec3 d = 2.0 * glm::dvec3(texel) - 1.0;
        const glm::dvec3 axis = glm::normalize(glm::cross(d, glm::dvec3(1, 0, 0)));
        texel = glm::vec4(glm::vec3(0.5 * (d * std::cos(angle) + glm::cross(axis, d) * std::sin(angle)) + 0.5), 1);
    }
    const DominantErrors errors = verifier().verifyRows(rows, band, 0, kDominantHeight);
    EXPECT_NEAR(errors.meanDirectionError(), 3, 1e-3);
    EXPECT_NEAR(errors.maxDirectionError(), 3, 1e-3);
    EXPECT_GT(errors.stages()[1].specular.relRms, 0.05);
}

TEST(VerifyDominant, IntensityErrorsAreRelativeAndHolesAreLeftOut) {
    const auto band = bake();
    DecodedDominantRows rows = exact(band);
    for (glm::vec4& texel : rows.intensity.texels()) texel *= 1.1f;
    EXPECT_NEAR(verifier().verifyRows(rows, band, 0, kDominantHeight).stages()[1].specular.relRms, 0.1, 1e-4);
    DecodedDominantRows holed = exact(band);
    holed.intensity.at(5, 5) = glm::vec4(1e6f);
    EXPECT_LT(verifier().verifyRows(holed, band, 0, kDominantHeight).stages()[1].specular.relRms, 1e-5);
    EXPECT_LT(verifier().verifyRows(holed, band, 0, kDominantHeight).stages()[0].specular.relRms, 0.02);
}

TEST(VerifyDominant, StripsMergeToTheWholeAndTheBoundCoversOtherViews) {
    const auto band = bake();
    DecodedDominantRows rows = exact(band);
    for (glm::vec4& texel : rows.direction.texels()) texel = glm::vec4(glm::round(glm::vec3(texel) * 31.0f) / 31.0f, 1);
    const auto whole = verifier().verifyRows(rows, band, 0, kDominantHeight).stages();
    DominantErrors merged(kKey);
    for (const auto& [first, count] : {std::pair{0, 7}, std::pair{7, 9}, std::pair{16, 4}})
        merged.merge(verifier().verifyRows(rows, band, first, count));
    EXPECT_NEAR(merged.stages()[1].specular.relRms, whole[1].specular.relRms, 1e-12);
    EXPECT_EQ(merged.stages()[0].specular.maxSampled, whole[0].specular.maxSampled);
    const DominantVerifier dense(description(), {{0.1, 0.2, 0.5}, {0, 0.3, 1}, 400, 4}, lighting::kRec709Luminance, kKey);
    const auto manyViews = dense.verifyRows(rows, band, 0, kDominantHeight).stages();
    EXPECT_GE(whole[1].specular.maxBound, manyViews[1].specular.maxSampled);
    EXPECT_GE(whole[0].specular.maxBound, manyViews[0].specular.maxSampled);
}

TEST(VerifyDominant, TheBoundOfVisibleErrorsIsTheLargestDifferenceOfTheDisplay) {
    const auto band = bake();
    DecodedDominantRows rows = exact(band);
    const Viewing viewing{lighting::DisplaySettings{}.of(kKey)};
    const DominantVerifier shown(description(), {}, lighting::kRec709Luminance, kKey, viewing);
    for (const float factor : {1.0f, 0.0f}) {  // also of a light that went out
        for (glm::vec4& texel : rows.intensity.texels()) texel *= factor;
        const VisibleFigures visible = shown.verifyRows(rows, band, 0, kDominantHeight).stages()[1].specular.visible.value();
        EXPECT_EQ(visible.bound, VisibleMetric(viewing, 1).mostVisible());
        EXPECT_GE(*visible.bound, visible.max);
        EXPECT_EQ(visible.boundAt.x, visible.maxAt.x);
    }
    rows.intensity.at(7, 3).y = NAN;
    EXPECT_EQ(shown.verifyRows(rows, band, 0, kDominantHeight).stages()[1].specular.visible->bound, HUGE_VAL);
    EXPECT_FALSE(verifier().verifyRows(rows, band, 0, kDominantHeight).stages()[1].specular.visible.has_value());
}

TEST(VerifyDominant, ShadesWithTheLobeOfTheSceneAndBoundsIt) {
    const auto band = bake(false);
    for (const auto lobe : {lighting::NormalDistribution::Beckmann, lighting::NormalDistribution::Ggx}) {
        const DominantErrors errors = verifier(1, lobe).verifyRows(exact(band), band, 0, kDominantHeight);
        // Every texel has the same light: the RMS is that of one.
        const glm::dvec3 normal(band.normal.at(0, 0));
        const DominantLightSample light = dominantReference(band.sh.at(0, 0), normal, lighting::kRec709Luminance);
        const glm::dvec3 towards = glm::normalize(light.direction);
        const glm::dmat3 frame = lighting::worldFromTangentFrame(normal);
        double squares = 0;
        int count = 0;
        for (int i = 0; i < 8; ++i)
            for (const double m : {0.1, 0.5})
                for (const double f0 : {0.04, 0.6}) {
                    const glm::dvec3 view = frame * lighting::fibonacciHemisphere(i, 8);
                    const double seen =
                        std::max(glm::dot(normal, towards), 0.0) *
                        lighting::cookTorrance(view, towards, normal, m, f0, lobe, lighting::CookTorranceNormalization::Energy);
                    squares += seen * seen * glm::dot(light.intensity, light.intensity) / 3;
                    ++count;
                }
        EXPECT_NEAR(errors.referenceRms(), std::sqrt(squares / count), 1e-3 * std::sqrt(squares / count));
        DecodedDominantRows rows = exact(band);
        for (glm::vec4& texel : rows.direction.texels()) texel = glm::vec4(glm::round(glm::vec3(texel) * 31.0f) / 31.0f, 1);
        const auto whole = verifier(1, lobe).verifyRows(rows, band, 0, kDominantHeight).stages();
        const DominantVerifier dense(description(), {{0.1, 0.2, 0.5}, {0, 0.3, 1}, 400, 4, lobe}, lighting::kRec709Luminance, kKey);
        EXPECT_GE(whole[1].specular.maxBound, dense.verifyRows(rows, band, 0, kDominantHeight).stages()[1].specular.maxSampled);
    }
}

TEST(VerifyDominant, ComparesARefinedFitWithTheBestLight) {
    auto band = bake();
    for (int y = 0; y < kDominantHeight; ++y)
        for (int x = 0; x < kDominantWidth; ++x) {
            const auto side = lighting::projectDirectional(glm::vec3(1, 0, 0), glm::vec3(1.5f, 1, 0.5f));
            for (std::size_t i = 0; i < side.size(); ++i) band.sh.at(x, y)[i] += side[i];
        }
    const DecodedDominantRows closed = exact(band);
    DecodedDominantRows refined = exact(band);
    for (int y = 0; y < kDominantHeight; ++y)
        for (int x = 0; x < kDominantWidth; ++x) {
            fit::DominantLightOptions options;
            options.fit = fit::DominantFit::Refined;
            const auto light = fit::dominantLight(band.sh.at(x, y), band.normal.at(x, y), options);
            refined.direction.at(x, y) = glm::vec4(0.5f * light.direction + 0.5f, 1);
            refined.intensity.at(x, y) = glm::vec4(light.intensity / 4.0f, 1);
        }
    CookedDominant map = description();
    map.fit = DominantFit::Refined;
    const DominantVerifier strict(map, {{0.1, 0.5}, {0.04, 0.6}, 8, 1}, lighting::kRec709Luminance, kKey);
    const DominantErrors good = strict.verifyRows(refined, band, 0, kDominantHeight),
                         bad = strict.verifyRows(closed, band, 0, kDominantHeight);
    EXPECT_LT(good.stages()[1].specular.relRms, 2e-3);
    EXPECT_GT(bad.stages()[1].specular.relRms, 0.2) << "the closed form is not what was promised";
    EXPECT_GT(verifier().verifyRows(refined, band, 0, kDominantHeight).stages()[1].specular.relRms, 0.2);
    EXPECT_LT(good.unexplainedStored(), bad.unexplainedStored());
    EXPECT_NEAR(good.unexplainedStored(), good.unexplainedReference(), 1e-6);
    EXPECT_NEAR(good.unexplainedReference(), bad.unexplainedReference(), 1e-6);
}

/// Every difference computed a second time in doubles, one by one.
TEST(VerifyDominant, VisibleErrorsAreThoseOfTheDefinition) {
    const auto band = bake();
    DecodedDominantRows rows = exact(band);
    for (glm::vec4& texel : rows.direction.texels()) texel = glm::vec4(glm::round(glm::vec3(texel) * 15.0f) / 15.0f, 1);
    for (glm::vec4& texel : rows.intensity.texels()) texel *= glm::vec4(1.1f, 0.9f, 1, 1);
    // 8 views of 3 materials: no whole number of lanes a place.
    const DominantShading shading{{0.1, 0.25, 0.5}, {0.04}, 8, 1};
    Viewing viewing;
    viewing.display.nitsPerUnit = 40;
    const DominantVerifier verifier(description(), shading, lighting::kRec709Luminance, kKey, viewing);
    double squares = 0, largest = 0;
    std::int64_t count = 0;
    for (int y = 0; y < kDominantHeight; ++y)
        for (int x = 0; x < kDominantWidth; ++x) {
            if (band.covered.at(x, y) == 0) continue;
            const glm::dvec3 normal(band.normal.at(x, y));
            const DominantLightSample seen = verifier.decode(rows, x, y), truth = verifier.reference(band.sh.at(x, y), normal, seen);
            const auto highlight = [&](const DominantLightSample& light, const glm::dvec3& view, double m) {
                const glm::dvec3 towards = glm::normalize(light.direction);
                return std::max(glm::dot(normal, towards), 0.0) *
                       lighting::cookTorrance(view, towards, normal, m, 0.04, lighting::NormalDistribution::Beckmann,
                                              lighting::CookTorranceNormalization::Energy) *
                       light.intensity;
            };
            for (int i = 0; i < 8; ++i)
                for (const double m : shading.m) {
                    const glm::dvec3 view = lighting::worldFromTangentFrame(normal) * lighting::fibonacciHemisphere(i, 8);
                    const double apart = lighting::visibleDifference(highlight(truth, view, m), highlight(seen, view, m), viewing.display);
                    squares += apart * apart;
                    largest = std::max(largest, apart);
                    ++count;
                }
        }
    // The last stage also has the maxima between texels.
    const std::vector<StageError> stages = verifier.verifyRows(rows, band, 0, kDominantHeight).stages();
    ASSERT_TRUE(stages[0].specular.visible && stages[1].specular.visible);
    const double rms = std::sqrt(squares / static_cast<double>(count));
    const VisibleFigures& total = *stages[1].specular.visible;
    EXPECT_NEAR(total.rms, std::max(rms, stages[0].specular.visible->rms), 1e-3 * rms);
    EXPECT_GE(total.max, largest * (1 - 1e-3));
    EXPECT_NEAR(lighting::visibleDifference(total.maxAt.reference, total.maxAt.found, viewing.display), total.max, 1e-2 * total.max);
    EXPECT_TRUE(total.maxAt.isKnown());
    EXPECT_FALSE(stages[1].diffuse.visible);
}

/// A sample of texels finds the few with all the light, or does not: a map of 512 x 512 is shaded whole.
TEST(VerifyDominant, DarkTexelsCountAsSamplesWithoutAnError) {
    formats::LightMapStrip dark = bake();
    DecodedDominantRows rows = exact(dark);
    for (int y = 0; y < kDominantHeight; ++y)
        for (int x = 0; x < kDominantWidth; ++x) {
            if (x == 11 && y == 6) continue;
            dark.sh.at(x, y) = {};
            rows.intensity.at(x, y) = glm::vec4(0);
        }
    rows.intensity.at(11, 6) *= 0.5f;
    const Viewing viewing{lighting::DisplaySettings{}.of(kKey)};
    const DominantVerifier shown(description(), {{0.5}, {0.04}, 8, 1}, lighting::kRec709Luminance, kKey, viewing);
    const ErrorFigures figures = shown.verifyRows(rows, dark, 0, kDominantHeight).stages()[1].specular;
    EXPECT_NEAR(figures.relRms, 0.5, 1e-3) << "of the only light";
    EXPECT_LT(figures.p99, 1e-9) << "of all texels";
    EXPECT_LT(figures.visible->p50, 1e-3);
    EXPECT_GT(figures.visible->max, 1);
    EXPECT_EQ(std::accumulate(figures.visible->histogram.begin(), figures.visible->histogram.end(), std::int64_t{0}),
              8 * (kDominantWidth * kDominantHeight - 1));
}

/// Packed charts touch: their lights differ as they like, and no surface shows what a filter blends of both.
TEST(VerifyDominant, MiddlesBetweenTwoChartsAreNoPlaces) {
    formats::LightMapStrip band = bake();
    DecodedDominantRows rows = exact(band);
    for (int y = 0; y < kDominantHeight; ++y)
        for (int x = 12; x < kDominantWidth; ++x) {
            band.sh.at(x, y) = {};
            rows.intensity.at(x, y) = glm::vec4(0);
        }
    const double mixed = verifier().verifyRows(rows, band, 0, kDominantHeight).stages()[0].specular.relRms;
    band.chart = formats::Image<std::uint32_t>(kDominantWidth, kDominantHeight, 1);
    for (int y = 0; y < kDominantHeight; ++y)
        for (int x = 12; x < kDominantWidth; ++x) band.chart.at(x, y) = 2;
    EXPECT_LT(verifier().verifyRows(rows, band, 0, kDominantHeight).stages()[0].specular.relRms, 0.1 * mixed);
}

TEST(VerifyDominant, WithoutADisplayThereAreNoVisibleErrors) {
    const auto band = bake();
    for (const StageError& stage : verifier().verifyRows(exact(band), band, 0, kDominantHeight).stages())
        EXPECT_FALSE(stage.specular.visible);
}

/// The stride is that of the middles between texels.
TEST(VerifyDominant, ShadesEveryTexelWhateverTheStride) {
    const auto band = bake();
    for (const glm::ivec2& at : {glm::ivec2(1, 1), glm::ivec2(7, 3), glm::ivec2(23, 19)}) {
        DecodedDominantRows rows = exact(band);
        rows.intensity.at(at.x, at.y) *= 5.0f;
        const ErrorFigures all = verifier(1).verifyRows(rows, band, 0, kDominantHeight).stages()[1].specular,
                           few = verifier(4).verifyRows(rows, band, 0, kDominantHeight).stages()[1].specular;
        EXPECT_GT(few.relRms, 0.04);
        EXPECT_EQ(few.relRms, all.relRms);
        EXPECT_EQ(few.p99, all.p99);
    }
}

TEST(DominantStride, KeepsTheMiddlesOfLargeMapsAffordable) {
    EXPECT_EQ(dominantStride(128, 128), 1);
    EXPECT_EQ(dominantStride(512, 512), 1);
    for (const int size : {513, 1024, 2048, 8192}) {
        const double shaded = std::pow(std::ceil(static_cast<double>(size) / dominantStride(size, size)), 2);
        EXPECT_LE(shaded, 1 << 18);
        EXPECT_GT(shaded, 1 << 16);
    }
}

}  // namespace
}  // namespace lightcook::verify

#include "verify/ground_truth.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

#include "lighting/brdf.h"
#include "lighting/display.h"
#include "lighting/sh.h"

namespace lightcook::verify {
namespace {

using Kind = formats::ShadingValue::Kind;

formats::ShadingValue valueOf(Kind kind, const glm::dvec3& direction, const glm::dvec3& light) {
    formats::ShadingValue value;
    value.kind = kind;
    value.m = 0.25;
    value.f0 = 0.04;
    value.direction = glm::normalize(direction);
    value.value = light;
    return value;
}

lighting::ShRgb constantLight(float radiance) {
    lighting::ShRgb sh{};
    sh[0] = glm::vec3(radiance * 2 * std::sqrt(std::numbers::pi_v<float>));
    return sh;
}

/// Constant radiance 1 has irradiance pi, without model error. Cooked light of 1.1 has an error of 0.1, all of it from cooking.
TEST(GroundTruth, ErrorsOfConstantLightAreKnown) {
    std::vector<LightMapTruthPlace> places;
    for (const glm::dvec3& normal : {glm::dvec3(0, 0, 1), glm::dvec3(1, 2, 3)})
        places.push_back({valueOf(Kind::Lambert, normal, glm::dvec3(std::numbers::pi)), {0, 0, 1}, constantLight(1), constantLight(1.1f)});
    const LightMapTruth truth = lightMapTruth(places);
    EXPECT_EQ(truth.lambert.count(), 2);
    EXPECT_NEAR(truth.lambert.errors().model, 0, 1e-6);
    EXPECT_NEAR(truth.lambert.errors().cooking, 0.1, 1e-6);
    EXPECT_NEAR(truth.lambert.errors().total, 0.1, 1e-6);
    EXPECT_TRUE(truth.areaSpecular.empty());
}

/// Area specular of constant light is the kernel's coefficient 0, with an entry for each m.
TEST(GroundTruth, AreaSpecularIsGroupedByRoughness) {
    const glm::dvec3 view = glm::normalize(glm::dvec3(0.5, 0.1, 0.8));
    std::vector<LightMapTruthPlace> places;
    for (const double m : {0.1, 0.5}) {
        formats::ShadingValue value = valueOf(Kind::Specular, view, {});
        value.m = m;
        const lighting::AreaSpecularKernel kernel = lighting::integrateAreaSpecular(view.z, m, lighting::NormalDistribution::Beckmann,
                                                                                    lighting::CookTorranceNormalization::Energy, 512);
        value.value = glm::dvec3((value.f0 * kernel.c[0] + (1 - value.f0) * kernel.d[0]) * 2 * std::sqrt(std::numbers::pi));
        places.push_back({value, {0, 0, 1}, constantLight(1), constantLight(0.5f)});
    }
    const LightMapTruth truth = lightMapTruth(places);
    ASSERT_EQ(truth.areaSpecular.size(), 2u);
    for (const auto& [m, sums] : truth.areaSpecular) {
        EXPECT_LT(sums.errors().model, 2e-3) << m << ": kernels are of NoV in steps of a thousandth";
        EXPECT_NEAR(sums.errors().cooking, 0.5, 2e-3);
    }
    EXPECT_EQ(sumOf(truth.areaSpecular).count(), 2);
}

/// Two light sources, of which the fit has one: the error is the other's reflection. Two lights have no error.
TEST(GroundTruth, OneLightMissesTheSecond) {
    const glm::dvec3 normal(0, 0, 1), view = glm::normalize(glm::dvec3(0.3, 0, 1));
    const std::array<DominantLightSample, 2> lamps = {DominantLightSample{glm::normalize(glm::dvec3(-0.3, 0, 1)), glm::dvec3(3)},
                                                      DominantLightSample{glm::normalize(glm::dvec3(0, 0.5, 1)), glm::dvec3(2)}};
    const auto reflected = [&](const DominantLightSample& lamp) {
        return glm::dot(normal, lamp.direction) *
               lighting::cookTorrance(view, lamp.direction, normal, 0.25, 0.04, lighting::NormalDistribution::Beckmann,
                                      lighting::CookTorranceNormalization::Energy) *
               lamp.intensity;
    };
    const glm::dvec3 first = reflected(lamps[0]), second = reflected(lamps[1]);
    const std::array<DominantTruthPlace, 1> place = {
        DominantTruthPlace{valueOf(Kind::Specular, view, first + second), normal, {}, lamps[0], lamps[0], lamps}};
    const DominantTruth truth = dominantTruth(place);
    EXPECT_NEAR(truth.oneLight.at(0.25).errors().model, second.x / (first.x + second.x), 1e-5);
    EXPECT_EQ(truth.oneLight.at(0.25).errors().cooking, 0);
    EXPECT_NEAR(truth.twoLights.at(0.25).errors().total, 0, 1e-5);
    EXPECT_NEAR(truth.areaSpecular.at(0.25).errors().model, 1, 1e-12) << "of no light";
}

/// One light source explains all coefficients, so that nothing remains for area specular, and no light counts twice.
TEST(GroundTruth, NothingRemainsOfASingleLightSource) {
    const glm::dvec3 normal(0, 0, 1), view = glm::normalize(glm::dvec3(0.3, 0, 1));
    const DominantLightSample lamp{glm::normalize(glm::dvec3(-0.3, 0.1, 1)), glm::dvec3(3)}, none{normal, glm::dvec3(0)};
    const lighting::ShRgb baked = lighting::projectDirectional(glm::vec3(lamp.direction), glm::vec3(lamp.intensity));
    const std::array<DominantTruthPlace, 1> place = {
        DominantTruthPlace{valueOf(Kind::Specular, view, glm::dvec3(1)), normal, baked, lamp, none, {lamp, none}}};
    const DominantTruth truth = dominantTruth(place);
    EXPECT_NEAR(truth.withRest.at(0.25).errors().model, truth.oneLight.at(0.25).errors().model, 1e-5);
    EXPECT_NEAR(truth.withRest.at(0.25).errors().total, truth.areaSpecular.at(0.25).errors().model, 1e-12) << "no light leaves all";
}

/// Irradiance is shown as the exit radiance of a white surface, specular light as it is.
TEST(GroundTruth, VisibleErrorsAreOfLightOnTheDisplay) {
    const Viewing viewing{{.nitsPerUnit = 30}};
    const std::array<LightMapTruthPlace, 1> lambert = {LightMapTruthPlace{
        valueOf(Kind::Lambert, {0, 0, 1}, glm::dvec3(1.3 * std::numbers::pi)), {0, 0, 1}, constantLight(1), constantLight(1.1f)}};
    const TruthVisible diffuse = lightMapTruth(lambert, lighting::NormalDistribution::Beckmann, viewing).visibleLambert;
    const auto apart = [&](double a, double b) { return lighting::visibleDifference(glm::dvec3(a), glm::dvec3(b), viewing.display); };
    EXPECT_NEAR(diffuse.cooking.largest(), apart(1, 1.1), 1e-3);
    EXPECT_NEAR(diffuse.total.largest(), apart(1.3, 1.1), 1e-3);
    EXPECT_EQ(lightMapTruth(lambert).visibleLambert.total.sampleCount(), 0);

    const glm::dvec3 normal(0, 0, 1);
    const DominantLightSample none{normal, glm::dvec3(0)};
    const std::array<DominantTruthPlace, 1> specular = {
        DominantTruthPlace{valueOf(Kind::Specular, {0.3, 0, 1}, glm::dvec3(0.7)), normal, {}, none, none, {none, none}}};
    const TruthVisible whole = dominantTruth(specular, lighting::NormalDistribution::Beckmann, viewing).visibleWithRest;
    EXPECT_EQ(whole.cooking.largest(), 0);
    EXPECT_NEAR(whole.total.largest(), apart(0.7, 0), 1e-3);
    EXPECT_EQ(dominantTruth(specular).visibleWithRest.total.sampleCount(), 0);
}

/// The three errors against sums by hand, and for a black truth.
TEST(GroundTruth, SumsAreOfSquares) {
    TruthSums sums, other;
    sums.add(glm::dvec3(3, 0, 0), glm::dvec3(4, 0, 0), glm::dvec3(4, 2, 0));
    other.add(glm::dvec3(0, 4, 0), glm::dvec3(0, 4, 0), glm::dvec3(0, 4, 0));
    sums.merge(other);
    EXPECT_DOUBLE_EQ(sums.errors().model, 1.0 / 5);
    EXPECT_DOUBLE_EQ(sums.errors().cooking, 2.0 / 5);
    EXPECT_DOUBLE_EQ(sums.errors().total, std::sqrt(5.0) / 5);
    EXPECT_EQ(TruthSums().errors().total, 0);
    TruthSums overBlack;
    overBlack.add(glm::dvec3(0), glm::dvec3(0), glm::dvec3(1));
    EXPECT_EQ(overBlack.errors().model, 0);
    EXPECT_EQ(overBlack.errors().total, std::numeric_limits<double>::max());
}

}  // namespace
}  // namespace lightcook::verify

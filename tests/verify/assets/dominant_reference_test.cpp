// The dominant light that is dimmed where it explains little: the fit's, and the verifier's independent one.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <random>

#include "fit/dominant_light.h"
#include "fit/light_search.h"
#include "verify/dominant.h"

namespace lightcook::verify {
namespace {

const glm::vec3 kNormal(0, 0, 1);

fit::DominantLight fitted(const lighting::ShRgb& sh, fit::DominantFit which) {
    fit::DominantLightOptions options;
    options.fit = which;
    return fit::dominantLight(sh, kNormal, options);
}

/// One light source and constant light: the more of the latter, the less one light explains.
lighting::ShRgb lampAndSky(float sky) {
    lighting::ShRgb sh = lighting::projectDirectional(glm::normalize(glm::vec3(0.3f, -0.4f, 0.8f)), glm::vec3(1, 0.8f, 0.5f));
    sh[0] += glm::vec3(sky);
    return sh;
}

TEST(ExplainedLight, IsTheRefinedOneWhereItExplainsAllAndNoneWhereItExplainsLittle) {
    const lighting::ShRgb lamp = lampAndSky(0), mist = lampAndSky(3);
    EXPECT_EQ(fitted(lamp, fit::DominantFit::Explained).intensity, fitted(lamp, fit::DominantFit::Refined).intensity);
    EXPECT_EQ(fitted(mist, fit::DominantFit::Explained).intensity, glm::vec3(0));
    EXPECT_GT(fitted(mist, fit::DominantFit::Refined).intensity.x, 0.5f) << "else the last line says nothing";
    EXPECT_EQ(fitted(mist, fit::DominantFit::Explained).direction, fitted(mist, fit::DominantFit::Refined).direction);
}

/// The intensity falls continuously as the residual grows.
TEST(ExplainedLight, DimsSmoothly) {
    double before = 1;
    bool isBetween = false;
    for (float sky = 0; sky < 2; sky += 0.002f) {
        const lighting::ShRgb sh = lampAndSky(sky);
        const fit::DominantLight light = fitted(sh, fit::DominantFit::Explained), whole = fitted(sh, fit::DominantFit::Refined);
        const double share = static_cast<double>(light.intensity.x / whole.intensity.x);
        const double residual = std::sqrt(fit::lightTowards(sh, glm::normalize(glm::dvec3(whole.direction)), false).unexplained);
        EXPECT_LE(share, before + 1e-6);
        EXPECT_LT(before - share, 0.05) << sky;
        EXPECT_EQ(share > 0.999, residual < 0.302) << residual;
        EXPECT_EQ(share<0.001, residual> 0.398) << residual;
        isBetween = isBetween || (share > 0.3 && share < 0.7);
        before = share;
    }
    EXPECT_TRUE(isBetween);
}

/// The verifier's independent search and dimming agree with the fit's for random light, given the fit's direction.
TEST(ExplainedLight, TheVerifierFindsTheSame) {
    std::mt19937 random(5);
    std::uniform_real_distribution<float> value(-1, 1);
    int dimmed = 0;
    for (int i = 0; i < 2000; ++i) {
        const glm::vec3 towards = glm::normalize(glm::vec3(value(random), value(random), value(random) + 0.2f));
        lighting::ShRgb sh = lighting::projectDirectional(towards, glm::vec3(1, 0.9f, 0.7f));
        const float noise = 0.12f * (value(random) + 1);
        for (std::size_t j = 0; j < sh.size(); ++j)
            for (int c = 0; c < 3; ++c) sh[j][c] += noise * value(random);
        sh[0] += glm::vec3(0.3f * (value(random) + 1));
        const fit::DominantLight cooked = fitted(sh, fit::DominantFit::Explained);
        const DominantLightSample own =
            explainedReference(sh, glm::dvec3(kNormal), lighting::kRec709Luminance, glm::dvec3(cooked.direction));
        EXPECT_GT(glm::dot(glm::normalize(own.direction), glm::normalize(glm::dvec3(cooked.direction))), 0.9995) << i;
        // Lights within 1e-3 of residual are equally good, which is up to 15e-3 of the dimming.
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(own.intensity[c], static_cast<double>(cooked.intensity[c]), 0.02) << i;
        const double whole = static_cast<double>(fitted(sh, fit::DominantFit::Refined).intensity.x);
        dimmed += own.intensity.x > 0.05 * whole && own.intensity.x < 0.95 * whole ? 1 : 0;
    }
    EXPECT_GT(dimmed, 100) << "else only bright and black lights were compared";
    EXPECT_EQ(explainedReference(lighting::ShRgb{}, glm::dvec3(kNormal), lighting::kRec709Luminance, glm::dvec3(0)).intensity,
              glm::dvec3(0));
}

}  // namespace
}  // namespace lightcook::verify

// The sum of light map and dominant light against the shader's own lcWholeSpecular.
#include "verify/whole_shading.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "lighting/brdf.h"
#include "lighting/sphere.h"
#include "shaders/lightcook_cpp.h"

namespace lightcook::verify {
namespace {

shaders::LcSpecularKernel kernelOf(double NoV, double m) {
    const lighting::AreaSpecularKernel kernel =
        lighting::integrateAreaSpecular(NoV, m, lighting::NormalDistribution::Beckmann, lighting::CookTorranceNormalization::Energy, 512);
    const auto four = [](const lighting::ShDouble& c) { return glm::vec4(glm::dvec4(c[0], c[2], c[3], c[6])); };
    shaders::LcSpecularKernel out;
    out.c0236 = four(kernel.c);
    out.d0236 = four(kernel.d);
    out.cd78 = glm::vec4(glm::dvec4(kernel.c[7], kernel.c[8], kernel.d[7], kernel.d[8]));
    return out;
}

lighting::ShRgb randomLight(std::mt19937& random) {
    std::uniform_real_distribution<float> any(-1, 1);
    lighting::ShRgb sh;
    for (auto& c : sh) c = glm::vec3(any(random), any(random), any(random));
    sh[0] = glm::vec3(3);
    return sh;
}

/// White diffuse light and lcWholeSpecular, view by view, with kernels of their own integral.
TEST(WholeShader, LightMapAndDominantLightAddUpToTheShadersLight) {
    LightMapShading shading;
    shading.viewCount = 4;
    const WholeShader shader = WholeShader::create(shading).value();
    const std::size_t stride = shader.stride();
    std::mt19937 random(9);
    std::uniform_real_distribution<double> any(-1, 1);
    for (int round = 0; round < 5; ++round) {
        const lighting::ShRgb sh = randomLight(random);
        const glm::vec3 normal(glm::normalize(glm::dvec3(any(random), any(random), any(random))));
        const DominantLightSample light{glm::dvec3(normal) + 0.4 * glm::dvec3(any(random), any(random), any(random)), {2, 1, 0.5}};
        std::vector<float> map(3 * stride), dominant(3 * stride);
        shader.shadeLightMap(sh, normal, map);
        shader.shadeDominant(light, normal, dominant);
        shaders::LcSh lit;
        for (std::size_t i = 0; i < sh.size(); ++i) lit.c[i] = sh[i];
        const glm::vec3 diffuse = shaders::lcExitRadiance(lit, normal);
        std::size_t k = 0;
        for (int i = 0; i < shading.viewCount; ++i) {
            const glm::dvec3 local = lighting::fibonacciHemisphere(i, shading.viewCount);
            const glm::vec3 view(lighting::worldFromTangentFrame(glm::dvec3(normal)) * local);
            for (const double m : shading.m)
                for (const double f0 : shading.f0) {
                    const glm::vec3 expected =
                        diffuse + shaders::lcWholeSpecular(view, lit, glm::vec3(light.direction), glm::vec3(light.intensity), normal,
                                                           static_cast<float>(m), glm::vec3(static_cast<float>(f0)), kernelOf(local.z, m));
                    for (std::size_t channel = 0; channel < 3; ++channel) {
                        const float truth = expected[static_cast<int>(channel)];
                        EXPECT_NEAR(map[channel * stride + k] + dominant[channel * stride + k], truth, 2e-4f * (1 + std::abs(truth)));
                    }
                    ++k;
                }
        }
        EXPECT_EQ(k, shader.sampleCount());
    }
}

TEST(WholeShader, AMatteSceneShowsDiffuseLightAlone) {
    LightMapShading shading;
    shading.specular = false;
    const WholeShader shader = WholeShader::create(shading).value();
    std::mt19937 random(4);
    const lighting::ShRgb sh = randomLight(random);
    std::vector<float> map(3 * shader.stride()), dominant(3 * shader.stride(), 1.0f);
    shader.shadeLightMap(sh, {0, 0, 1}, map);
    shader.shadeDominant({{0, 0, 1}, {5, 5, 5}}, {0, 0, 1}, dominant);
    shaders::LcSh lit;
    for (std::size_t i = 0; i < sh.size(); ++i) lit.c[i] = sh[i];
    EXPECT_EQ(shader.sampleCount(), 1u);
    EXPECT_FLOAT_EQ(map[0], shaders::lcExitRadiance(lit, {0, 0, 1}).x);
    for (const float each : dominant) EXPECT_EQ(each, 0.0f);
}

TEST(WholeShader, VisibleErrorsOfASumAreThoseOfEachSample) {
    constexpr std::size_t kStride = DisplayTransform::kLanes;
    std::mt19937 random(2);
    std::uniform_real_distribution<float> any(0, 2);
    std::vector<float> reference(6 * kStride), a(6 * kStride), b(6 * kStride);
    for (std::vector<float>* each : {&reference, &a, &b})
        for (float& value : *each) value = any(random);
    const Viewing viewing;
    double largest = 0;
    for (std::size_t place = 0; place < 2; ++place)
        for (std::size_t k = 0; k < kStride; ++k) {
            glm::dvec3 truth, found;
            for (std::size_t c = 0; c < 3; ++c) {
                const std::size_t at = (3 * place + c) * kStride + k;
                truth[static_cast<int>(c)] = static_cast<double>(reference[at]);
                found[static_cast<int>(c)] = static_cast<double>(a[at] + b[at]);
            }
            largest = std::max(largest, lighting::visibleDifference(truth, found, viewing.display, viewing.bt2020FromWorking));
        }
    EXPECT_NEAR(wholeErrors(reference, a, b, kStride, kStride, viewing).visibleFigures().max, largest, 1e-3 * largest);
    EXPECT_EQ(wholeErrors(reference, reference, {}, kStride, kStride, viewing).visibleFigures().max, 0);
    double squaredError = 0, squaredReference = 0;
    for (std::size_t i = 0; i < reference.size(); ++i) {
        const double error = static_cast<double>(a[i]) + static_cast<double>(b[i]) - static_cast<double>(reference[i]);
        squaredError += error * error;
        squaredReference += static_cast<double>(reference[i]) * static_cast<double>(reference[i]);
    }
    EXPECT_NEAR(wholeErrors(reference, a, b, kStride, kStride, viewing).relRms(), std::sqrt(squaredError / squaredReference), 1e-12);
    EXPECT_EQ(wholeErrors(reference, reference, {}, kStride, kStride, viewing).relRms(), 0);
}

/// A strong light with a weaker one, under a sky: what fit "explained" keeps.
lighting::ShRgb mostlyOneLight(std::mt19937& random) {
    std::normal_distribution<double> any;
    std::uniform_real_distribution<double> share(0, 1);
    lighting::ShRgb sh{};
    const auto add = [&](double strength) {
        const lighting::ShDouble basis = lighting::evaluateBasis(glm::normalize(glm::dvec3(any(random), any(random), any(random))));
        const glm::dvec3 colour(share(random), share(random), share(random));
        for (std::size_t i = 0; i < sh.size(); ++i) sh[i] += glm::vec3(strength * basis[i] * (0.2 + 0.8 * colour));
    };
    add(1);
    add(0.2 * share(random));
    sh[0] += glm::vec3(static_cast<float>(0.3 * share(random)));
    return sh;
}

/// The search of the verifier in doubles is the truth.
TEST(DerivedLight, IsTheLightThatExplainsTheCoefficientsBest) {
    std::mt19937 random(5);
    const glm::dvec3 normal(0, 0, 1);
    int lit = 0;
    for (int i = 0; i < 300; ++i) {
        const lighting::ShRgb sh = mostlyOneLight(random);
        const DominantLightSample found = derivedLight(sh, glm::vec3(normal));
        const DominantLightSample expected = explainedReference(sh, normal, lighting::kRec709Luminance, found.direction);
        const double brightest = std::max({expected.intensity.x, expected.intensity.y, expected.intensity.z});
        if (brightest < 0.05) continue;
        ++lit;
        EXPECT_GT(glm::dot(found.direction, glm::normalize(expected.direction)), std::cos(0.01)) << i;
        EXPECT_LT(glm::length(found.intensity - expected.intensity), 0.01 * brightest + 1e-4) << i;
    }
    EXPECT_GT(lit, 150);
}

TEST(DerivedLight, IsNoneWhereNoDirectionDominates) {
    const glm::vec3 normal = glm::normalize(glm::vec3(1, 2, 3));
    lighting::ShRgb sky{}, black{};
    sky[0] = glm::vec3(2);
    for (const lighting::ShRgb& sh : {sky, black}) {
        const DominantLightSample found = derivedLight(sh, normal);
        EXPECT_EQ(found.intensity, glm::dvec3(0));
        EXPECT_NEAR(glm::length(found.direction), 1, 1e-5);
    }
}

TEST(DerivedLight, HasAnyUnitOfLight) {
    std::mt19937 random(7);
    for (int i = 0; i < 20; ++i) {
        const lighting::ShRgb sh = mostlyOneLight(random);
        const DominantLightSample one = derivedLight(sh, glm::vec3(0, 0, 1));
        for (const float unit : {0x1p-60f, 0x1p60f}) {
            lighting::ShRgb scaled = sh;
            for (glm::vec3& coefficient : scaled) coefficient *= unit;
            const DominantLightSample found = derivedLight(scaled, glm::vec3(0, 0, 1));
            EXPECT_EQ(found.direction, one.direction);
            EXPECT_EQ(found.intensity, static_cast<double>(unit) * one.intensity);
        }
    }
}

}  // namespace
}  // namespace lightcook::verify

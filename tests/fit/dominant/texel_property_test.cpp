// Properties of random texels of every fit that fills textures: prefiltered cubemaps, irradiance, tables, two lights, wrapped
// diffuse and game lights. A case is one value of a texel; some are also compared with brute force.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "fit/cubemap.h"
#include "fit/dominant_light.h"
#include "fit/irradiance.h"
#include "fit/light_search.h"
#include "fit/specular_tables.h"
#include "lighting/radiometry.h"
#include "shaders/lightcook_cpp.h"
#include "tests/fit/brute_force.h"
#include "tests/soak/soak.h"

namespace lightcook {
namespace {

constexpr long long kCases = 500'000;

/// Up to 32 x 16 texels of noise in one of several magnitudes, some black, some with light sources; a panorama or a strip.
formats::Environment anyEnvironment(truth::Random& random) {
    const int height = 1 + random.below(16);
    formats::Environment environment = random.below(3) == 0 ? truth::constantStrip(1 + random.below(8), glm::vec3(0))
                                                            : truth::constantEquirectangular(2 * height, height, glm::vec3(0));
    const double magnitudes[] = {1e-44, 1e-20, 1, 1e4, 1e30};
    const double magnitude = random.below(3) == 0 ? magnitudes[random.below(5)] : 1;
    const bool hasLamps = random.below(2) == 0;
    for (glm::vec3& texel : environment.texels.texels())
        for (int channel = 0; channel < 3; ++channel) {
            const double lamp = hasLamps && random.below(40) == 0 ? 1e4 : 1;
            texel[channel] = random.below(6) == 0 ? 0 : static_cast<float>(magnitude * lamp * random.uniform());
        }
    return environment;
}

/// Returns texels in pieces of about 3 degrees or less.
std::vector<truth::Sample> piecesOf(const formats::Environment& environment) {
    const bool isPanorama = environment.projection == formats::Environment::Projection::Equirectangular;
    const int across = isPanorama ? environment.texels.height() : environment.texels.width();
    return truth::samplesOf(environment, ((isPanorama ? 72 : 40) + across - 1) / across);
}

float brightestOf(const formats::Environment& environment) {
    float brightest = 0;
    for (const glm::vec3& texel : environment.texels.texels()) brightest = std::max({brightest, texel.x, texel.y, texel.z});
    return brightest;
}

/// Errors of texels, summed over three channels. Largest: relative to reference + mean, for any contrast (light sources 10,000 times as
/// bright as their surroundings, a radian wide). Share above 0.5 %: relative to reference + 2 % of the mean, if no source texel exceeds
/// twenty means.
class Errors {
public:
    void add(const glm::vec3& found, const glm::dvec3& expected, const glm::dvec3& mean, double brightest) {
        const double off = sumOf(glm::abs(glm::dvec3(found) - expected));
        worst_ = std::max(worst_, off / (sumOf(expected) + sumOf(mean)));
        if (brightest > 20 * std::min({mean.x, mean.y, mean.z})) return;
        if (off > 0.005 * (sumOf(expected) + 0.02 * sumOf(mean))) ++large_;
        ++count_;
    }
    void expectSmall(const char* what) const {
        std::printf("[ figures  ] %s against brute force: at most %.2e off; of %lld in calm light %.2f %% by more than 0.5 %%\n", what,
                    worst_, count_, 100.0 * static_cast<double>(large_) / static_cast<double>(count_));
        EXPECT_LT(worst_, 0.02);
        EXPECT_LT(large_, count_ / 20);
    }

private:
    static double sumOf(const glm::dvec3& rgb) { return rgb.x + rgb.y + rgb.z; }
    double worst_ = 0;
    long long large_ = 0, count_ = 0;
};

/// Every value is finite and within the source's range, the level has the source's mean, and one texel in two thousand is near brute force.
void prefilterAnything(long long cases, fit::PrefilterKernel kernel, std::uint64_t seed) {
    truth::Random random(seed);
    Errors errors;
    for (long long done = 0; done < cases;) {
        const formats::Environment environment = anyEnvironment(random);
        fit::CubemapOptions options;
        options.size = 64;
        options.mipCount = 2;
        options.kernel = kernel;
        options.roughness = {0.3 + 0.7 * random.uniform(), random.below(4) == 0 ? 1.0 : 0.2 + 0.8 * random.uniform()};
        const auto filter = fit::CubemapPrefilter::create(environment, options);
        ASSERT_TRUE(filter);
        const float brightest = brightestOf(environment);
        const auto samples = piecesOf(environment);
        const glm::dvec3 mean = truth::meanRadiance(samples);
        for (int mip = 0; mip < filter->mipCount(); ++mip) {
            const fit::MipKernel& level = filter->mips()[static_cast<std::size_t>(mip)];
            formats::Image<glm::vec3> strip(level.size, 6 * level.size);
            for (int face = 0; face < 6; ++face) filter->filterRows(mip, face, 0, strip.view().rows(face * level.size, level.size));
            for (int texel = random.below(2000); texel < 6 * level.size * level.size; texel += 2000) {
                const int x = texel % level.size, row = texel / level.size;
                const glm::dvec3 expected = truth::prefilter(
                    samples, kernel, level.m, lighting::cubeTexelDirection(row / level.size, x, row % level.size, level.size));
                if (brightest > 1e-30f) errors.add(strip.at(x, row), expected, mean, brightest);
            }
            filter->keepMean(mip, strip.view());
            for (const glm::vec3& value : strip.texels())
                for (int channel = 0; channel < 3; ++channel, ++done)
                    ASSERT_TRUE(value[channel] >= 0 && value[channel] <= brightest) << done << ": " << value[channel];
            const glm::dvec3 kept = truth::meanOfStrip(strip);
            for (int channel = 0; channel < 3; ++channel)
                ASSERT_NEAR(kept[channel], mean[channel], 1e-4 * mean[channel] + 1e-40 * std::max(1.0f, brightest))
                    << done << " mip " << mip;
        }
    }
    errors.expectSmall("prefilter");
}

/// Every value is between 0 and the brightest of the source, and one texel in two thousand is near brute force.
void irradianceOfAnything(long long cases, std::uint64_t seed) {
    truth::Random random(seed);
    Errors errors;
    for (long long done = 0; done < cases;) {
        const formats::Environment environment = anyEnvironment(random);
        const double wrap = random.below(3) == 0 ? 0 : random.uniform();
        constexpr int kSize = 48;
        const auto strip = fit::irradianceCubemap(environment, {kSize, wrap});
        ASSERT_TRUE(strip);
        const float brightest = brightestOf(environment);
        for (const glm::vec3& value : strip->texels())
            for (int channel = 0; channel < 3; ++channel, ++done)
                ASSERT_TRUE(value[channel] >= 0 && value[channel] <= brightest) << done << ": " << value[channel];
        if (!(brightest > 1e-30f)) continue;
        const auto samples = piecesOf(environment);
        const glm::dvec3 mean = truth::meanRadiance(samples);
        for (int texel = random.below(2000); texel < 6 * kSize * kSize; texel += 2000) {
            const int x = texel % kSize, row = texel / kSize;
            const glm::dvec3 normal = lighting::cubeTexelDirection(row / kSize, x, row % kSize, kSize);
            glm::dvec3 sum(0);
            double weight = 0;
            for (const truth::Sample& sample : samples) {
                const double own = std::max(0.0, glm::dot(normal, sample.direction) + wrap) * sample.solidAngle;
                weight += own;
                sum += own * sample.radiance;
            }
            errors.add(strip->at(x, row), sum / weight, mean, brightest);
        }
    }
    errors.expectSmall("irradiance");
}

/// Random size, range, lobe, normalisation and axes: twelve values a node decode within half a step, and samples lie between neighbouring
/// nodes.
void tablesOfAnything(long long cases, std::uint64_t seed) {
    truth::Random random(seed);
    constexpr lighting::SpecularLobe kLobes[] = {lighting::SpecularLobe::Beckmann, lighting::SpecularLobe::Ggx,
                                                 lighting::SpecularLobe::Phong, lighting::SpecularLobe::PhongPower};
    const auto anyOf = [&random](const std::vector<fit::AxisMapping>& all) {
        return all[static_cast<std::size_t>(random.below(static_cast<int>(all.size())))];
    };
    for (long long done = 0; done < cases;) {
        fit::SpecularTableOptions options;
        options.lobe = kLobes[random.below(4)];
        if (random.below(3) == 0) options.normalization = lighting::CookTorranceNormalization::Halo3;
        options.viewCount = 2 + random.below(40);
        options.roughnessCount = 2 + random.below(40);
        options.view = anyOf(fit::viewMappings());
        options.roughness = anyOf(fit::roughnessMappings());
        options.minimumM = std::pow(10, -4 * random.uniform());
        options.maximumM = options.minimumM + (1 - options.minimumM) * random.uniform();
        options.pointCount = 8;
        ASSERT_TRUE(fit::checkSpecularTableOptions(options));
        const fit::SpecularTables tables = fit::makeSpecularTables(options);
        const double most = options.normalization == lighting::CookTorranceNormalization::Halo3 ? 2.8 : 0.7;
        for (const fit::SpecularTexture* texture : {&tables.c0236, &tables.d0236, &tables.cd78})
            for (int y = 0; y < options.roughnessCount; ++y)
                for (int x = 0; x < options.viewCount; ++x) {
                    const double along = random.uniform();
                    const glm::vec4 fetched =
                        fit::sampleSpecularTexture(*texture, (std::min(x + along, options.viewCount - 1.0) + 0.5) / options.viewCount,
                                                   (y + 0.5) / options.roughnessCount);
                    const int next = std::min(x + 1, options.viewCount - 1);
                    for (int channel = 0; channel < 4; ++channel, ++done) {
                        const double value = texture->values.at(x, y)[channel], other = texture->values.at(next, y)[channel];
                        const double step = static_cast<double>(texture->scale[channel]) / 65535;
                        const double decoded = texture->stored.at(x, y)[channel] * step + static_cast<double>(texture->bias[channel]);
                        ASSERT_LE(std::abs(value), most) << done;
                        ASSERT_NEAR(decoded, value, 0.501 * step + 1e-7 * std::abs(value)) << done;
                        const double slack = 0.501 * step + 1e-6 * most;
                        ASSERT_GE(fetched[channel], std::min(value, other) - slack) << done;
                        ASSERT_LE(fetched[channel], std::max(value, other) + slack) << done;
                    }
                }
    }
}

lighting::ShRgb anySh(truth::Random& random) {
    lighting::ShRgb sh{};
    if (random.below(4) == 0) {
        const double magnitudes[] = {1e-44, 1e-10, 1, 1e30, 1e37};
        const double magnitude = magnitudes[random.below(5)];
        for (glm::vec3& c : sh)
            for (int channel = 0; channel < 3; ++channel) c[channel] = static_cast<float>(magnitude * (2 * random.uniform() - 1));
        return sh;
    }
    for (int remaining = random.below(4); remaining >= 0; --remaining) {
        const lighting::ShRgb light =
            lighting::projectDirectional(glm::vec3(random.direction()), glm::vec3(random.uniform(), random.uniform(), random.uniform()));
        for (std::size_t i = 0; i < sh.size(); ++i) sh[i] += light[i];
    }
    sh[0] += static_cast<float>(random.uniform());
    return sh;
}

/// Two lights are finite and no worse than one. Explained light is at most the refined light in every channel.
void lightsOfAnything(long long cases, std::uint64_t seed) {
    truth::Random random(seed);
    fit::DominantLightOptions refined, explained;
    refined.fit = fit::DominantFit::Refined;
    explained.fit = fit::DominantFit::Explained;
    for (long long i = 0; i < cases; i += 3) {  // three channels, three cases
        const lighting::ShRgb sh = anySh(random);
        const glm::vec3 normal(random.direction());
        const fit::TwoLights two = fit::bestTwoLights(sh, glm::dvec3(0, 0, 1), i % 2 == 0);
        ASSERT_TRUE(two.unexplained >= 0 && two.unexplained <= 1) << i;
        ASSERT_LE(two.unexplained, fit::lightTowards(sh, {0, 0, 1}, i % 2 == 0).unexplained + 1e-12) << i;
        for (const fit::LightFit* light : {&two.first, &two.second}) {
            ASSERT_NEAR(glm::length(light->direction), 1, 1e-12) << i;
            for (int channel = 0; channel < 3; ++channel)
                ASSERT_TRUE(std::isfinite(light->intensity[channel]) && light->intensity[channel] >= 0) << i;
        }
        const fit::DominantLight whole = fit::dominantLight(sh, normal, refined), dimmed = fit::dominantLight(sh, normal, explained);
        for (int channel = 0; channel < 3; ++channel) {
            ASSERT_TRUE(std::isfinite(dimmed.intensity[channel]) && dimmed.intensity[channel] >= 0) << i;
            ASSERT_LE(dimmed.intensity[channel], whole.intensity[channel] * 1.000001f) << i;
        }
        ASSERT_LE(glm::length(glm::dvec3(dimmed.direction)), 1 + 1e-6) << i;
    }
}

/// The shader's wrapped diffuse light equals the SH times the wrapped bands; a game light gives 17/16, 1 and the wrapped value.
void wrapAnything(long long cases, std::uint64_t seed) {
    truth::Random random(seed);
    for (long long i = 0; i < cases; i += 3) {
        const lighting::ShRgb sh = anySh(random);
        const glm::dvec3 normal = random.direction();
        const double wrap = random.below(4) == 0 ? random.below(2) : random.uniform();
        const lighting::ShBands bands = lighting::wrappedLambertBands(wrap);
        const lighting::ShDouble basis = lighting::evaluateBasis(normal);
        shaders::LcSh shader;
        for (int k = 0; k < 9; ++k) shader.c[k] = sh[static_cast<std::size_t>(k)];
        const glm::vec3 found = shaders::lcExitRadianceWrapped(shader, glm::vec3(normal), static_cast<float>(wrap));
        for (int channel = 0; channel < 3; ++channel) {
            double expected = 0, size = 0;
            for (std::size_t k = 0; k < basis.size(); ++k) {
                const double part = bands[static_cast<std::size_t>(lighting::kShBand[k])] * basis[k] * static_cast<double>(sh[k][channel]);
                expected += part;
                size += std::abs(static_cast<double>(sh[k][channel]));
            }
            ASSERT_NEAR(found[channel], expected, 2e-6 * size + 1e-43) << i << " wrap " << wrap;
        }
        const glm::vec3 color(random.uniform(), random.uniform(), random.uniform());
        for (const auto normalization : {lighting::GameLightNormalization::None, lighting::GameLightNormalization::D3dx}) {
            const lighting::ShRgb light = lighting::projectGameLight({color}, glm::vec3(normal), normalization);
            const glm::vec3 white = lighting::lambertExitRadiance(light, glm::vec3(normal), glm::vec3(1)).value;
            const float factor = normalization == lighting::GameLightNormalization::None ? 17.0f / 16 : 1.0f;
            for (int channel = 0; channel < 3; ++channel) ASSERT_NEAR(white[channel], factor * color[channel], 2e-6) << i;
        }
    }
}

TEST(TexelProperties, BeckmannLevelsStayInRangeAndKeepTheMean) {
    prefilterAnything(kCases, fit::PrefilterKernel::Beckmann, 201);
}
TEST(TexelProperties, GgxLevelsStayInRangeAndKeepTheMean) {
    prefilterAnything(kCases, fit::PrefilterKernel::Ggx, 202);
}
TEST(TexelProperties, PhongLevelsStayInRangeAndKeepTheMean) {
    prefilterAnything(kCases, fit::PrefilterKernel::Phong, 203);
}
TEST(TexelProperties, IrradianceStaysInRangeAndMatchesBruteForce) {
    irradianceOfAnything(kCases, 204);
}
TEST(TexelProperties, TablesDecodeWithinHalfAStepAndBetweenTheirNodes) {
    tablesOfAnything(kCases, 205);
}
TEST(TexelPropertiesSoak, TwoLightsAreNoWorseThanOneAndExplainedLightIsNoBrighter) {
    lightsOfAnything(2 * kCases, 206);
}
TEST(TexelProperties, WrappedDiffuseAndGameLightsAreTheirFormulas) {
    wrapAnything(kCases, 207);
}

/// Calls check(seed), each for kCases, as long as the soak lets it.
template <class Check>
void soakCases(const Check& check) {
    test::repeatInSoak("random cases", kCases, check);
}

TEST(TexelSoak, BeckmannLevelsStayInRangeAndKeepTheMean) {
    soakCases([](std::uint64_t seed) { prefilterAnything(kCases, fit::PrefilterKernel::Beckmann, seed); });
}
TEST(TexelSoak, GgxLevelsStayInRangeAndKeepTheMean) {
    soakCases([](std::uint64_t seed) { prefilterAnything(kCases, fit::PrefilterKernel::Ggx, seed); });
}
TEST(TexelSoak, PhongLevelsStayInRangeAndKeepTheMean) {
    soakCases([](std::uint64_t seed) { prefilterAnything(kCases, fit::PrefilterKernel::Phong, seed); });
}
TEST(TexelSoak, IrradianceStaysInRangeAndMatchesBruteForce) {
    soakCases([](std::uint64_t seed) { irradianceOfAnything(kCases, seed); });
}
TEST(TexelSoak, TablesDecodeWithinHalfAStepAndBetweenTheirNodes) {
    soakCases([](std::uint64_t seed) { tablesOfAnything(kCases, seed); });
}
TEST(TexelSoak, TwoLightsAreNoWorseThanOneAndExplainedLightIsNoBrighter) {
    soakCases([](std::uint64_t seed) { lightsOfAnything(kCases, seed); });
}
TEST(TexelSoak, WrappedDiffuseAndGameLightsAreTheirFormulas) {
    soakCases([](std::uint64_t seed) { wrapAnything(kCases, seed); });
}

}  // namespace
}  // namespace lightcook

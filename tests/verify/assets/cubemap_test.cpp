#include "verify/cubemap.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <optional>

#include "lighting/cube.h"
#include "lighting/display.h"
#include "lighting/radiometry.h"
#include "lighting/sphere.h"
#include "verify/error/visible_metric.h"

namespace lightcook::verify {
namespace {

using formats::Environment;
using formats::Image;

/// Returns a panorama of a function of direction, evaluated at texel centres.
template <class Radiance>
Environment panorama(int height, const Radiance& radiance) {
    Environment environment;
    environment.texels = Image<glm::vec3>(2 * height, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < 2 * height; ++x)
            environment.texels.at(x, y) = radiance(lighting::directionFromEquirectangular({(x + 0.5) / (2 * height), (y + 0.5) / height}));
    return environment;
}

glm::vec3 smooth(const glm::dvec3& d) {
    return glm::vec3(glm::dvec3(1 + 0.5 * d.x, 2 + 0.7 * d.y * d.z, 1 + 0.9 * d.z * d.z));
}

glm::vec3 withSun(const glm::dvec3& d) {
    const glm::dvec3 sun = glm::normalize(glm::dvec3(0.3, 0.8, -0.4));
    return smooth(d) + glm::vec3(static_cast<float>(400 * std::exp(200 * (glm::dot(d, sun) - 1))));
}

double shape(double c, double m, bool isGgx) {
    if (isGgx) return c <= 0 ? 0 : c / std::pow(0.5 * (1 + c) * (m * m - 1) + 1, 2);
    const double tangentSquared = (1 - c) / (1 + c), cosineSquared = 0.5 * (1 + c);
    return c <= 0 ? 0 : std::exp(-tangentSquared / (m * m)) / (cosineSquared * cosineSquared) * c;
}

/// Returns the convolution on a polar lattice around the direction, from the source's function instead of its texels.
template <class Radiance>
glm::dvec3 convolve(const glm::dvec3& direction, double m, const Radiance& radiance, bool isGgx = false) {
    const glm::dmat3 frame = lighting::worldFromTangentFrame(direction);
    glm::dvec3 sum(0);
    double weightSum = 0;
    for (int i = 0; i < 600; ++i) {
        const double angle = 0.5 * std::numbers::pi * std::pow((i + 0.5) / 600, 2), width = (i + 0.5);  // d(angle) grows with i
        const double c = std::cos(angle), weight = shape(c, m, isGgx) * std::sin(angle) * width;
        for (int j = 0; j < 90; ++j) {
            const double phi = 2 * std::numbers::pi * (j + 0.5) / 90;
            const glm::dvec3 local(std::sin(angle) * std::cos(phi), std::sin(angle) * std::sin(phi), c);
            sum += weight * glm::dvec3(radiance(frame * local));
            weightSum += weight;
        }
    }
    return sum / weightSum;
}

/// Returns a map of the references themselves, divided by S.
CookedCubemap ideal(const Environment& environment, const lighting::ShRgb& sh) {
    const CubemapReference reference(environment);
    CookedCubemap map;
    map.range = 4;
    map.windowedSh = sh;
    const double roughness[] = {0.0, 0.3, 1.0};
    for (int level = 0; level < 3; ++level) {
        CookedCubemap::Mip mip;
        mip.m = roughness[level];
        mip.bands = {1, level == 2 ? 0.6 : 0.9, level == 2 ? 0.2 : 0.7};
        const int size = 8 >> level;
        std::optional<PrefilteredLight> light;
        if (mip.m > 0) light.emplace(environment, mip.m);
        for (int face = 0; face < 6; ++face) {
            Image<glm::vec4> image(size, size);
            for (int y = 0; y < size; ++y)
                for (int x = 0; x < size; ++x) {
                    const glm::dvec3 direction = lighting::cubeTexelDirection(face, x, y, size);
                    const lighting::ShRgb zonal = lighting::convolve(sh, mip.bands);
                    const glm::dvec3 s(lighting::evaluate(zonal, glm::vec3(direction)));
                    const glm::dvec3 radiance = light ? light->towards(direction) : reference.footprintMean(direction, size);
                    image.at(x, y) = glm::vec4(glm::vec3(radiance / s / 4.0), 1);
                }
            mip.faces.push_back(std::move(image));
        }
        map.mips.push_back(std::move(mip));
    }
    return map;
}

lighting::ShRgb positiveSh() {
    lighting::ShRgb sh{};
    sh[0] = glm::vec3(4, 6, 5);
    sh[1] = glm::vec3(0.5f, -0.4f, 0.3f);
    sh[6] = glm::vec3(0.2f, 0.3f, -0.3f);
    return sh;
}

std::vector<StageError> verifyAll(const CookedCubemap& map, const Environment& environment, int samplesBetween = 32,
                                  const std::optional<Viewing>& viewing = std::nullopt) {
    const CubemapReference reference(environment);
    const double key = glm::dot(reference.mean(), glm::dvec3(lighting::kRec709Luminance));
    const auto samples = cubemapSamples(map, samplesBetween);
    std::vector<CubemapErrors> levels;
    std::vector<CubemapResult> results;
    for (int mip = 0; mip < static_cast<int>(map.mips.size()); ++mip) {
        const CookedCubemap::Mip& level = map.mips[static_cast<std::size_t>(mip)];
        const int size = level.faces[0].width();
        std::optional<PrefilteredLight> light;
        if (level.m > 0) light.emplace(environment, level.m, map.lobe);
        levels.emplace_back(key, viewing);
        for (int face = 0; face < 6; ++face) {
            Image<glm::vec3> references = light ? Image<glm::vec3>(size, size) : reference.footprintMeans(face, size);
            for (int y = 0; light && y < size; ++y)
                for (int x = 0; x < size; ++x)
                    references.at(x, y) = glm::vec3(light->towards(lighting::cubeTexelDirection(face, x, y, size)));
            levels.back().merge(compareCubemapFace(map, mip, face, references.view(), key, viewing));
        }
        for (const CubemapSample& sample : samples)
            if (sample.mip == mip)
                results.push_back(compareCubemap(
                    map, sample, light ? light->towards(sample.direction) : reference.footprintMean(sample.direction, size)));
    }
    return cubemapStages(map, reference, levels, samples, results, lighting::kRec709Luminance, viewing);
}

TEST(PrefilteredLight, IsThatOfALatticeAroundTheDirection) {
    const Environment environment = panorama(256, withSun);
    for (const double m : {0.1, 0.3, 1.0}) {
        const PrefilteredLight light(environment, m);
        for (int i = 0; i < 6; ++i) {
            const glm::dvec3 direction = lighting::fibonacciSphere(i, 6);
            const glm::dvec3 expected = convolve(direction, m, withSun), found = light.towards(direction);
            for (int channel = 0; channel < 3; ++channel) EXPECT_NEAR(found[channel], expected[channel], 2e-3 * expected[channel]) << m;
        }
    }
}

TEST(PrefilteredLight, OfGgxIsThatOverTheWholeHemisphere) {
    const Environment environment = panorama(256, withSun);
    for (const double m : {0.02, 0.1, 0.3, 1.0}) {
        const PrefilteredLight light(environment, m, lighting::NormalDistribution::Ggx);
        for (int i = 0; i < 6; ++i) {
            const glm::dvec3 direction = lighting::fibonacciSphere(i, 6);
            const glm::dvec3 expected = convolve(direction, m, withSun, true), found = light.towards(direction);
            for (int channel = 0; channel < 3; ++channel) EXPECT_NEAR(found[channel], expected[channel], 2e-3 * expected[channel]) << m;
        }
    }
}

/// One pass over a face against a walk around each texel: noise with light sources of a thousand times its light.
TEST(CubemapReference, MeansOfAFaceAreThoseOfItsTexels) {
    std::uint32_t state = 1;
    const auto next = [&] { return (state = 1664525 * state + 1013904223) >> 8; };
    const auto noise = [&](const glm::dvec3&) {
        return glm::vec3(static_cast<float>(next() % 1000) / 1000, next() % 200 == 0 ? 1000.0f : 0.6f, 1.0f);
    };
    Environment strip;
    strip.projection = Environment::Projection::CubeStrip;
    strip.texels = Image<glm::vec3>(20, 120);
    for (glm::vec3& texel : strip.texels.texels()) texel = noise({});
    Environment wide = panorama(96, noise);
    for (const Environment* environment : {&wide, &strip}) {
        const CubemapReference reference(*environment);
        for (const int size : {1, 4, 6, 24})
            for (int face = 0; face < 6; ++face) {
                const Image<glm::vec3> means = reference.footprintMeans(face, size);
                for (int i = 0; i < size * size; i += 5) {
                    const int x = i % size, y = i / size;
                    const glm::dvec3 expected = reference.footprintMean(lighting::cubeTexelDirection(face, x, y, size), size);
                    for (int channel = 0; channel < 3; ++channel) {
                        const double brightest = channel == 1 ? 1000 : 1;
                        EXPECT_NEAR(means.at(x, y)[channel], expected[channel], 1e-3 * brightest) << size << ", " << face << ", " << i;
                    }
                }
            }
    }
}

TEST(CubemapReference, ProjectsEnvironmentsOfAnySizeExactly) {
    // One bright texel of a coarse environment: its SH is that of the whole texel, not of its centre.
    Environment coarse, fine;
    coarse.texels = Image<glm::vec3>(4, 2);
    fine.texels = Image<glm::vec3>(2048, 1024);
    coarse.texels.at(1, 0) = {3, 2, 1};
    for (int y = 0; y < 512; ++y)
        for (int x = 512; x < 1024; ++x) fine.texels.at(x, y) = {3, 2, 1};
    Environment strip, fineStrip;
    strip.projection = fineStrip.projection = Environment::Projection::CubeStrip;
    strip.texels = Image<glm::vec3>(1, 6);
    fineStrip.texels = Image<glm::vec3>(256, 6 * 256);
    strip.texels.at(0, 2) = {3, 2, 1};
    for (int y = 512; y < 768; ++y)
        for (int x = 0; x < 256; ++x) fineStrip.texels.at(x, y) = {3, 2, 1};
    for (const auto& [small, large] : {std::pair(&coarse, &fine), std::pair(&strip, &fineStrip)}) {
        const auto found = CubemapReference(*small).incidentSh(), expected = CubemapReference(*large).incidentSh();
        for (std::size_t i = 0; i < found.size(); ++i)
            for (int channel = 0; channel < 3; ++channel) EXPECT_NEAR(found[i][channel], expected[i][channel], 2e-4 * expected[0][channel]);
    }
}

TEST(KernelBands, OfBothLobesAreThoseOfLongDoubleQuadrature) {
    for (const bool isGgx : {false, true})
        for (const double m : {1.0 / 49, 4.0 / 49, 0.25, 0.5, 1.0}) {
            std::array<long double, 3> sums{};
            constexpr int kSteps = 400000;
            for (int i = 0; i < kSteps; ++i) {  // steps grow with the angle: half of them lie within 22 degrees
                const long double t = (i + 0.5L) / kSteps, angle = std::numbers::pi_v<long double> / 2 * t * t, c = std::cos(angle);
                const long double half = (1 + c) / 2, term = half * (static_cast<long double>(m) * m - 1) + 1;
                const long double d = isGgx ? 1 / (term * term) : std::exp(-(1 - c) / (1 + c) / (m * m)) / (half * half);
                const long double weight = d * c * std::sin(angle) * t;
                sums[0] += weight;
                sums[1] += weight * c;
                sums[2] += weight * (3 * c * c - 1) / 2;
            }
            const lighting::ShBands found =
                kernelBands(m, isGgx ? lighting::NormalDistribution::Ggx : lighting::NormalDistribution::Beckmann);
            EXPECT_EQ(found[0], 1);
            for (std::size_t l = 1; l < 3; ++l) EXPECT_NEAR(found[l], static_cast<double>(sums[l] / sums[0]), 1e-4) << m << ' ' << l;
        }
}

/// Returns six faces of a function of direction. With 40 texels a side, the last tile is partial.
template <class Radiance>
Environment strip(int size, const Radiance& radiance) {
    Environment environment;
    environment.projection = Environment::Projection::CubeStrip;
    environment.texels = Image<glm::vec3>(size, 6 * size);
    for (int y = 0; y < 6 * size; ++y)
        for (int x = 0; x < size; ++x) environment.texels.at(x, y) = radiance(lighting::cubeTexelDirection(y / size, x, y % size, size));
    return environment;
}

/// Returns the sum over all texels, each cut into pieces x pieces, with the standard library's exponential.
glm::dvec3 sumOverTexels(const Environment& environment, const glm::dvec3& direction, double m, bool isGgx, int pieces) {
    const int width = environment.texels.width() * pieces, height = environment.texels.height() * pieces;
    const bool isStrip = environment.projection == Environment::Projection::CubeStrip;
    glm::dvec3 sum(0);
    double weightSum = 0;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const glm::dvec3 towards = isStrip ? lighting::cubeTexelDirection(y / width, x, y % width, width)
                                               : lighting::directionFromEquirectangular({(x + 0.5) / width, (y + 0.5) / height});
            const double cosine = glm::dot(towards, direction);
            if (cosine <= 0) continue;
            const double solidAngle =
                isStrip ? lighting::cubeTexelSolidAngle(x, y % width, width) : lighting::equirectangularTexelSolidAngle(y, width, height);
            const double weight = solidAngle * shape(cosine, m, isGgx);
            sum += weight * glm::dvec3(environment.texels.at(x / pieces, y / pieces));
            weightSum += weight;
        }
    return sum / weightSum;
}

/// Noise with light sources of a hundred thousand times its light, each of one texel: one on the rim of its face or of the image, and of
/// sizes that no size of a tile divides.
TEST(PrefilteredLight, IsThePlainSumOverTexelsInBothProjections) {
    std::uint32_t state = 1;
    const auto noise = [&](const glm::dvec3&) {
        state = 1664525 * state + 1013904223;
        const float value = 0.2f + static_cast<float>(state >> 8) * 0x1p-24f;
        return glm::vec3(value, 1, value * value);
    };
    for (Environment& environment : std::array{strip(19, noise), panorama(27, noise)}) {
        environment.texels.at(7, 10) = glm::vec3(1e5f);
        environment.texels.at(0, 3) = glm::vec3(2e4f, 0, 1);
        const bool isStrip = environment.projection == Environment::Projection::CubeStrip;
        const glm::dvec3 sun =
            isStrip ? lighting::cubeTexelDirection(0, 7, 10, 19) : lighting::directionFromEquirectangular({7.5 / 54, 10.5 / 27});
        for (const bool isGgx : {false, true})
            for (const double m : {0.03, 0.1, 0.3, 0.6, 1.0}) {
                const auto lobe = isGgx ? lighting::NormalDistribution::Ggx : lighting::NormalDistribution::Beckmann;
                const PrefilteredLight light(environment, m, lobe);
                const int pieces = m < 0.05 ? 24 : 8;
                double brightest = 0;
                std::vector<glm::dvec3> expected, found;
                for (int i = 0; i < 12; ++i) {
                    glm::dvec3 direction = lighting::fibonacciSphere(i, 12);
                    if (i % 2 == 0) direction = glm::normalize(sun + (0.3 * m * i) * direction);
                    expected.push_back(sumOverTexels(environment, direction, m, isGgx, pieces));
                    found.push_back(light.towards(direction));
                    brightest = std::max(brightest, expected.back().x);
                }
                for (std::size_t i = 0; i < found.size(); ++i)
                    for (int channel = 0; channel < 3; ++channel)
                        EXPECT_NEAR(found[i][channel], expected[i][channel], 2e-3 * expected[i][channel] + 2e-3 * brightest)
                            << m << ' ' << isGgx << ' ' << isStrip << ' ' << i;
            }
    }
}

TEST(PrefilteredLight, NarrowLobesSeeTheTexelsTheyLieIn) {
    Environment environment = panorama(16, smooth);
    environment.texels.at(20, 7) = glm::vec3(90, 80, 70);
    const PrefilteredLight light(environment, 0.01);
    const glm::dvec3 centre = lighting::directionFromEquirectangular({20.5 / 32, 7.5 / 16});
    EXPECT_NEAR(light.towards(centre).x, 90, 1e-3);
    const glm::dvec3 edge = lighting::directionFromEquirectangular({20.0 / 32, 7.5 / 16});
    EXPECT_NEAR(light.towards(edge).x, 0.5 * (90 + static_cast<double>(environment.texels.at(19, 7).x)), 0.5);
}

/// What kernels share does not depend on which of them came first; tiles of another size are not taken.
TEST(PrefilteredLight, IsTheSameBesideAnotherOfItsEnvironment) {
    for (const bool isStrip : {false, true}) {
        Environment environment = panorama(16, smooth);
        if (isStrip) {
            environment.projection = Environment::Projection::CubeStrip;
            environment.texels = Image<glm::vec3>(8, 48, glm::vec3(1, 2, 3));
            environment.texels.at(3, 20) = glm::vec3(40, 30, 20);
        }
        const PrefilteredLight other(environment, 1.0);
        for (const double m : {0.02, 0.6, 0.8})
            for (const auto lobe : {lighting::NormalDistribution::Beckmann, lighting::NormalDistribution::Ggx}) {
                const PrefilteredLight alone(environment, m, lobe), beside(environment, m, lobe, &other);
                for (int i = 0; i < 20; ++i) {
                    const glm::dvec3 direction = lighting::fibonacciSphere(i, 20);
                    EXPECT_EQ(beside.towards(direction), alone.towards(direction)) << m;
                }
            }
    }
}

TEST(CubemapReference, ConstantsStayConstantInBothProjections) {
    for (const bool isStrip : {false, true}) {
        Environment environment;
        environment.projection = isStrip ? Environment::Projection::CubeStrip : Environment::Projection::Equirectangular;
        environment.texels = isStrip ? Image<glm::vec3>(8, 48, glm::vec3(1, 2, 3)) : Image<glm::vec3>(32, 16, glm::vec3(1, 2, 3));
        const CubemapReference reference(environment);
        EXPECT_NEAR(reference.mean().y, 2, 1e-12);
        for (int i = 0; i < 20; ++i) {
            const glm::dvec3 direction = lighting::fibonacciSphere(i, 20);
            EXPECT_NEAR(PrefilteredLight(environment, 0.02 + 0.04 * i).towards(direction).z, 3, 1e-5);
            EXPECT_NEAR(reference.footprintMean(direction, 4).x, 1, 1e-9);
        }
    }
}

TEST(CubemapReference, FootprintOfAStripsOwnTexelIsThatTexel) {
    Environment environment;
    environment.projection = Environment::Projection::CubeStrip;
    environment.texels = Image<glm::vec3>(4, 24);
    for (int y = 0; y < 24; ++y)
        for (int x = 0; x < 4; ++x) environment.texels.at(x, y) = glm::vec3(static_cast<float>(4 * y + x + 1));
    const CubemapReference reference(environment);
    for (int y = 0; y < 24; ++y)
        for (int x = 0; x < 4; ++x)
            EXPECT_NEAR(reference.footprintMean(lighting::cubeTexelDirection(y / 4, x, y % 4, 4), 4).x, 4 * y + x + 1, 1e-9);
}

/// Returns the mean of a whole map over the sphere by the footprints of its texels.
double meanOfFootprints(const CubemapReference& reference, int size) {
    double sum = 0;
    for (int face = 0; face < 6; ++face)
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x)
                sum += lighting::cubeTexelSolidAngle(x, y, size) *
                       reference.footprintMean(lighting::cubeTexelDirection(face, x, y, size), size).x;
    return sum / (4 * std::numbers::pi);
}

TEST(CubemapReference, FootprintsHoldAllLightOfASingleTexel) {
    // Texels far smaller than a footprint: on a side, beside a pole, at a pole, and on the rim of the image, which is inside a face.
    for (const glm::ivec2& lamp : {glm::ivec2(77, 40), glm::ivec2(20, 6), glm::ivec2(90, 0), glm::ivec2(0, 31), glm::ivec2(127, 63)}) {
        Environment environment;
        environment.texels = Image<glm::vec3>(128, 64, glm::vec3(0.5f));
        environment.texels.at(lamp.x, lamp.y) = glm::vec3(10000);
        const CubemapReference reference(environment);
        for (const int size : {3, 4})
            EXPECT_NEAR(meanOfFootprints(reference, size) / reference.mean().x, 1, 2e-3) << lamp.x << ", " << size;
    }
    Environment strip;
    strip.projection = Environment::Projection::CubeStrip;
    strip.texels = Image<glm::vec3>(16, 96, glm::vec3(0.5f));
    strip.texels.at(3, 21) = glm::vec3(10000);
    const CubemapReference reference(strip);
    EXPECT_NEAR(meanOfFootprints(reference, 3) / reference.mean().x, 1, 1e-9);
}

TEST(VerifyCubemap, AnIdealMapHasNoErrorAtItsTexels) {
    const Environment environment = panorama(32, withSun);
    const auto stages = verifyAll(ideal(environment, positiveSh()), environment);
    ASSERT_EQ(stages.size(), 3u);
    EXPECT_EQ(stages[0].name, "divide");
    EXPECT_EQ(stages[1].name, "filter");
    EXPECT_EQ(stages[2].name, "total");
    constexpr double kOfReference = 1e-4;  // that of PrefilteredLight under a sun
    EXPECT_LT(stages[0].specular.relRms, kOfReference);
    EXPECT_LT(stages[2].specular.relRms, kOfReference);
    EXPECT_GT(stages[1].specular.relRms, 1e-3);  // an 8 x 8 face under a sun cannot be filtered without error
    EXPECT_EQ(stages[2].diffuse.maxSampled, 0);
    for (const StageError& stage : stages) EXPECT_GE(stage.specular.maxBound, stage.specular.maxSampled) << stage.name;
}

TEST(VerifyCubemap, FindsChangesToAMap) {
    const Environment environment = panorama(32, smooth);
    const CubemapReference reference(environment);
    const CookedCubemap good = ideal(environment, positiveSh());
    CookedCubemap dimmed = ideal(environment, positiveSh());
    dimmed.range *= 0.9f;
    const ErrorFigures tenth = verifyAll(dimmed, environment)[2].specular;
    EXPECT_NEAR(tenth.relRms, 0.1, 1e-5);
    EXPECT_NEAR(tenth.p99, 0.1, 0.02) << "the largest of all levels";
    CookedCubemap turned = ideal(environment, positiveSh());
    std::swap(turned.mips[0].faces[0], turned.mips[0].faces[4]);
    EXPECT_GT(verifyAll(turned, environment)[2].specular.relRms, 0.03);
    CookedCubemap rough = ideal(environment, positiveSh());
    rough.mips[1].m = 0.8;  // the manifest names another kernel than the one used
    EXPECT_GT(verifyAll(rough, environment)[2].specular.relRms, 0.01);
}

TEST(VerifyCubemap, APlainMapIsShownAsItIs) {
    const Environment environment = panorama(32, withSun);
    const CubemapReference reference(environment);
    lighting::ShRgb one{};
    one[0] = glm::vec3(static_cast<float>(1 / lighting::evaluate(lighting::ShDouble{1}, glm::dvec3(0, 0, 1))));
    CookedCubemap map = ideal(environment, one);  // divided by 1
    const StageError divided = verifyAll(map, environment)[2];
    map.isDivided = false;
    map.windowedSh = {};  // has no effect
    const auto stages = verifyAll(map, environment);
    EXPECT_NEAR(stages[2].specular.relRms, divided.specular.relRms, 1e-5);
    EXPECT_LT(stages[0].specular.relRms, 1e-4);
    EXPECT_GE(stages[2].specular.maxBound, stages[2].specular.maxSampled);
    map.isDivided = true;
    EXPECT_GT(verifyAll(map, environment, 0)[2].specular.relRms, 1e100) << "divided by nothing";
    map.isDivided = false;
    map.range *= 1.1f;
    EXPECT_NEAR(verifyAll(map, environment)[0].specular.relRms, 0.1, 1e-4);
}

TEST(VerifyCubemap, TheBoundOfVisibleErrorsHoldsInEveryDirection) {
    double before = 0;
    for (const bool isSunny : {false, true}) {
        const Environment environment = isSunny ? panorama(32, withSun) : panorama(32, smooth);
        const CubemapReference reference(environment);
        const Viewing viewing{lighting::DisplaySettings{}.of(reference.displayKey(lighting::kRec709Luminance))};
        CookedCubemap map = ideal(environment, positiveSh());
        const VisibleFigures few = verifyAll(map, environment, 1, viewing)[2].specular.visible.value(),
                             many = verifyAll(map, environment, 600, viewing)[2].specular.visible.value();
        EXPECT_EQ(few.bound, many.bound) << "of all directions, whatever was sampled";
        EXPECT_GE(few.bound.value(), many.max);
        EXPECT_LE(*few.bound, VisibleMetric(viewing, 1).mostVisible());
        EXPECT_GT(*few.bound, before) << "a sun";
        before = *few.bound;
        // A texel as bright as the sun where there is none.
        map.mips.back().faces[4].at(0, 0) = glm::vec4(1e3f);
        const VisibleFigures seen = verifyAll(map, environment, 600, viewing)[2].specular.visible.value();
        EXPECT_GE(seen.bound.value(), seen.max);
        EXPECT_GT(*seen.bound, before);
    }
}

TEST(VerifyCubemap, RoughLevelsOfASmallSunHaveABoundOfTheirOwn) {
    // One bright texel: its light is spread by the kernel, so that a rough level is far from as bright as the texel.
    Environment environment = panorama(32, [](const glm::dvec3&) { return glm::vec3(1); });
    environment.texels.at(20, 9) = glm::vec3(200);
    const CubemapReference reference(environment);
    const Viewing viewing{lighting::DisplaySettings{}.of(1)};
    CookedCubemap map;
    map.isDivided = false;
    CookedCubemap::Mip mip;
    mip.m = 0.5;
    for (int face = 0; face < 6; ++face) mip.faces.emplace_back(2, 2, glm::vec4(1));
    map.mips.push_back(std::move(mip));
    const VisibleFigures rough = verifyAll(map, environment, 100, viewing)[2].specular.visible.value();
    const glm::dvec3 sun = lighting::directionFromEquirectangular({20.5 / 64, 9.5 / 32});
    const double part = cubemapReflectance(0.5, map.lobe);
    const double largest = lighting::visibleDifference(part * PrefilteredLight(environment, 0.5).towards(sun), glm::dvec3(part),
                                                       viewing.display, viewing.bt2020FromWorking);
    EXPECT_GT(largest, 10);
    EXPECT_GE(rough.bound.value(), largest);
    EXPECT_LT(*rough.bound, 1.6 * largest);
    map.mips[0].m = 0.02;
    EXPECT_GT(verifyAll(map, environment, 100, viewing)[2].specular.visible->bound.value(), 2 * largest);
}

TEST(VerifyCubemap, AnSThatIsNotPositivePassesNoLimit) {
    const Environment environment = panorama(32, smooth);
    const CubemapReference reference(environment);
    CookedCubemap map = ideal(environment, positiveSh());
    map.windowedSh[2] = glm::vec3(0, 9, 0);  // green S is negative below
    EXPECT_GT(verifyAll(map, environment, 0)[2].specular.relRms, 1e100);
    EXPECT_EQ(verifyAll(map, environment, 0, Viewing{})[2].specular.visible->bound, HUGE_VAL) << "nothing is known";
    map.windowedSh[2] = glm::vec3(0, NAN, 0);
    EXPECT_GT(verifyAll(map, environment, 0)[2].specular.relRms, 1e100);
}

TEST(VerifyCubemap, ATexelThatIsNotFinitePassesNoLimitEvenWhereNoSampleLies) {
    const Environment environment = panorama(32, smooth);
    const CubemapReference reference(environment);
    for (const float value : {NAN, HUGE_VALF}) {
        CookedCubemap map = ideal(environment, positiveSh());
        map.mips[1].faces[2].at(1, 3).y = value;
        const std::vector<StageError> stages = verifyAll(map, environment, 0);
        EXPECT_GT(stages[2].specular.relRms, 1e100);
        EXPECT_GT(stages[2].specular.maxBound.value_or(0), 1e100);
    }
}

TEST(VerifyCubemap, ABlackProbeIsExact) {
    const Environment environment = panorama(16, [](const glm::dvec3&) { return glm::vec3(0); });
    const CubemapReference reference(environment);
    lighting::ShRgb sh{};
    sh[0] = glm::vec3(1e-30f);
    CookedCubemap map = ideal(environment, positiveSh());
    map.windowedSh = sh;
    for (const StageError& stage : verifyAll(map, environment)) EXPECT_EQ(stage.specular.maxSampled, 0);
}

TEST(VerifyCubemap, BandFactorsAreTheKernelsEffectOnHarmonics) {
    const Environment environment =
        panorama(256, [](const glm::dvec3& d) { return glm::vec3(glm::dvec3(1, 1 + d.y, 1 + 0.5 * (3 * d.y * d.y - 1))); });
    const CubemapReference reference(environment);
    for (const double m : {0.05, 0.2, 0.5, 1.0}) {
        const lighting::ShBands bands = kernelBands(m);
        const glm::dvec3 seen = PrefilteredLight(environment, m).towards({0, 1, 0});
        EXPECT_EQ(bands[0], 1);
        EXPECT_NEAR(bands[1], seen.y - 1, 3e-4) << m;
        EXPECT_NEAR(bands[2], seen.z - 1, 6e-4) << m;
    }
    EXPECT_EQ(kernelBands(0), (lighting::ShBands{1, 1, 1}));
}

TEST(VerifyCubemap, OneWrongTexelOfAnyLevelIsInItsFigures) {
    const Environment environment = panorama(32, smooth);
    const CookedCubemap good = ideal(environment, positiveSh());
    for (std::size_t mip = 0; mip < 3; ++mip)
        for (const std::size_t face : {0u, 3u, 5u}) {
            CookedCubemap map = ideal(environment, positiveSh());
            const int size = map.mips[mip].faces[face].width(), x = size - 1, y = static_cast<int>(face) % size;
            map.mips[mip].faces[face].at(x, y) *= 3.0f;
            double errors = 0, references = 0;
            for (int at = 0; at < 6 * size * size; ++at) {
                const int eachFace = at / (size * size), eachX = at % size, eachY = at / size % size;
                const glm::dvec3 direction = lighting::cubeTexelDirection(eachFace, eachX, eachY, size);
                const auto lightOf = [&](const CookedCubemap& each) {
                    return shadeCubemap(each, static_cast<int>(mip),
                                        glm::vec3(each.mips[mip].faces[static_cast<std::size_t>(eachFace)].at(eachX, eachY)), direction);
                };
                const glm::dvec3 truth = lightOf(good), error = lightOf(map) - truth;
                const double solidAngle = lighting::cubeTexelSolidAngle(eachX, eachY, size);
                errors += solidAngle * glm::dot(error, error);
                references += solidAngle * glm::dot(truth, truth);
            }
            const ErrorFigures total = verifyAll(map, environment, 0)[2].specular;
            EXPECT_NEAR(total.relRms, std::sqrt(errors / references), 1e-5) << "of its level alone: " << mip;
            EXPECT_GT(total.maxSampled, 1.5);
            EXPECT_EQ(total.sampledAt.mip, static_cast<int>(mip));
            EXPECT_EQ(total.sampledAt.face, static_cast<int>(face));
            EXPECT_EQ(total.sampledAt.x, x);
            EXPECT_EQ(total.sampledAt.y, y);
        }
}

TEST(VerifyCubemap, SamplesBetweenTexelsAreTheSameEveryTime) {
    const CookedCubemap map = ideal(panorama(16, smooth), positiveSh());
    const auto first = cubemapSamples(map, 5, 7), second = cubemapSamples(map, 5, 7), other = cubemapSamples(map, 5, 8);
    ASSERT_EQ(first.size(), 15u);
    bool differs = false;
    for (std::size_t i = 0; i < first.size(); ++i) {
        EXPECT_EQ(first[i].mip, static_cast<int>(i / 5));
        EXPECT_EQ(first[i].direction, second[i].direction);
        EXPECT_NEAR(glm::length(first[i].direction), 1, 1e-12);
        differs = differs || first[i].direction != other[i].direction;
    }
    EXPECT_TRUE(differs);
}

}  // namespace
}  // namespace lightcook::verify

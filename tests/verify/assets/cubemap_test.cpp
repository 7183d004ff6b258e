#include "verify/cubemap.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <optional>
#include <set>
#include <tuple>

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

/// Returns a map of the brute-force prefilter, divided by S.
CookedCubemap ideal(const CubemapReference& reference, const lighting::ShRgb& sh) {
    CookedCubemap map;
    map.range = 4;
    map.windowedSh = sh;
    const double roughness[] = {0.0, 0.3, 1.0};
    for (int level = 0; level < 3; ++level) {
        CookedCubemap::Mip mip;
        mip.m = roughness[level];
        mip.bands = {1, level == 2 ? 0.6 : 0.9, level == 2 ? 0.2 : 0.7};
        const int size = 8 >> level;
        for (int face = 0; face < 6; ++face) {
            Image<glm::vec4> image(size, size);
            for (int y = 0; y < size; ++y)
                for (int x = 0; x < size; ++x) {
                    const glm::dvec3 direction = lighting::cubeTexelDirection(face, x, y, size);
                    const lighting::ShRgb zonal = lighting::convolve(sh, mip.bands);
                    const glm::dvec3 s(lighting::evaluate(zonal, glm::vec3(direction)));
                    const glm::dvec3 radiance =
                        mip.m > 0 ? reference.prefiltered(direction, mip.m) : reference.footprintMean(direction, size);
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

std::vector<StageError> verifyAll(const CookedCubemap& map, const CubemapReference& reference, const CubemapSampling& sampling = {},
                                  const std::optional<Viewing>& viewing = std::nullopt) {
    const auto samples = cubemapSamples(map, sampling);
    std::vector<CubemapResult> results;
    for (const CubemapSample& sample : samples) results.push_back(compareCubemap(map, reference, sample));
    return cubemapStages(map, reference, samples, results, lighting::kRec709Luminance, viewing);
}

TEST(CubemapReference, PrefiltersLikeALatticeAroundTheDirection) {
    const Environment environment = panorama(256, withSun);
    const CubemapReference reference(environment);
    for (const double m : {0.1, 0.3, 1.0})
        for (int i = 0; i < 6; ++i) {
            const glm::dvec3 direction = lighting::fibonacciSphere(i, 6);
            const glm::dvec3 expected = convolve(direction, m, withSun), found = reference.prefiltered(direction, m);
            for (int channel = 0; channel < 3; ++channel) EXPECT_NEAR(found[channel], expected[channel], 2e-3 * expected[channel]) << m;
        }
}

TEST(CubemapReference, PrefiltersGgxOverTheWholeHemisphere) {
    const Environment environment = panorama(256, withSun);
    const CubemapReference reference(environment);
    for (const double m : {0.02, 0.1, 0.3, 1.0})
        for (int i = 0; i < 6; ++i) {
            const glm::dvec3 direction = lighting::fibonacciSphere(i, 6);
            const glm::dvec3 expected = convolve(direction, m, withSun, true),
                             found = reference.prefiltered(direction, m, 8, lighting::NormalDistribution::Ggx);
            for (int channel = 0; channel < 3; ++channel) EXPECT_NEAR(found[channel], expected[channel], 2e-3 * expected[channel]) << m;
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

TEST(CubemapReference, PrefiltersAlikeFromLargerTexels) {
    constexpr double kPieces = 8;
    Environment wide = panorama(256, withSun);
    Environment strip;
    strip.projection = Environment::Projection::CubeStrip;
    strip.texels = Image<glm::vec3>(128, 768);
    for (int y = 0; y < 768; ++y)
        for (int x = 0; x < 128; ++x) strip.texels.at(x, y) = withSun(lighting::cubeTexelDirection(y / 128, x, y % 128, 128));
    for (const Environment* environment : {&wide, &strip}) {
        const CubemapReference reference(*environment);
        for (const double m : {0.1, 0.3, 1.0})
            for (const auto lobe : {lighting::NormalDistribution::Beckmann, lighting::NormalDistribution::Ggx}) {
                const std::optional<Environment> reduced = reducedEnvironment(*environment, m * std::numbers::sqrt2 / kPieces);
                ASSERT_TRUE(reduced);
                EXPECT_LT(reduced->texels.width(), environment->texels.width());
                const CubemapReference fast(*reduced);
                for (int channel = 0; channel < 3; ++channel)
                    EXPECT_NEAR(fast.mean()[channel], reference.mean()[channel], 1e-3 * reference.mean()[channel]);
                for (int i = 0; i < 12; ++i) {
                    const glm::dvec3 direction = lighting::fibonacciSphere(i, 12);
                    const glm::dvec3 expected = reference.prefiltered(direction, m, 8, lobe),
                                     found = fast.prefiltered(direction, m, kPieces, lobe);
                    for (int channel = 0; channel < 3; ++channel)
                        EXPECT_NEAR(found[channel], expected[channel], 0.05 * expected[channel]) << m;
                }
            }
        EXPECT_FALSE(reducedEnvironment(*environment, 0.001));
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

TEST(CubemapReferenceSoak, LargePiecesOfTheTailOfGgxCostNothing) {
    // Texels of 7 degrees and a lobe of 1 to 6: pieces grow from the peak outwards. The truth splits every texel alike.
    const Environment environment = panorama(24, withSun);
    const CubemapReference reference(environment);
    for (const double m : {0.02, 0.06, 0.1})
        for (int i = 0; i < 6; ++i) {
            const glm::dvec3 direction = lighting::fibonacciSphere(i, 6);
            glm::dvec3 sum(0);
            double weightSum = 0;
            constexpr int kPieces = 96;
            for (int y = 0; y < 24 * kPieces; ++y)
                for (int x = 0; x < 48 * kPieces; ++x) {
                    const glm::dvec2 uv((x + 0.5) / (48 * kPieces), (y + 0.5) / (24 * kPieces));
                    const double c = glm::dot(lighting::directionFromEquirectangular(uv), direction);
                    if (c <= 0) continue;
                    const double weight = shape(c, m, true) * std::sin(std::numbers::pi * uv.y);
                    sum += weight * glm::dvec3(environment.texels.at(x / kPieces, y / kPieces));
                    weightSum += weight;
                }
            const glm::dvec3 found = reference.prefiltered(direction, m, 8, lighting::NormalDistribution::Ggx);
            for (int channel = 0; channel < 3; ++channel)
                EXPECT_NEAR(found[channel], sum[channel] / weightSum, 2e-3 * sum[channel] / weightSum) << m;
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

/// Returns the sum over all texels, one by one, with the standard library's exponential.
glm::dvec3 sumOverTexels(const Environment& environment, const glm::dvec3& direction, double m) {
    const int width = environment.texels.width(), height = environment.texels.height();
    const bool isStrip = environment.projection == Environment::Projection::CubeStrip;
    glm::dvec3 sum(0);
    double weightSum = 0;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const glm::dvec3 towards = isStrip ? lighting::cubeTexelDirection(y / width, x, y % width, width)
                                               : lighting::directionFromEquirectangular({(x + 0.5) / width, (y + 0.5) / height});
            const double solidAngle =
                isStrip ? lighting::cubeTexelSolidAngle(x, y % width, width) : lighting::equirectangularTexelSolidAngle(y, width, height);
            const double weight = solidAngle * shape(glm::dot(towards, direction), m, false);
            sum += weight * glm::dvec3(environment.texels.at(x, y));
            weightSum += weight;
        }
    return sum / weightSum;
}

/// Returns the image with each texel repeated count x count times.
Environment enlarged(const Environment& environment, int count) {
    Environment large;
    large.projection = environment.projection;
    large.texels = Image<glm::vec3>(environment.texels.width() * count, environment.texels.height() * count);
    for (int y = 0; y < large.texels.height(); ++y)
        for (int x = 0; x < large.texels.width(); ++x) large.texels.at(x, y) = environment.texels.at(x / count, y / count);
    return large;
}

TEST(CubemapReference, IsThePlainSumOverTexelsInBothProjections) {
    for (const Environment& environment : {strip(40, withSun), panorama(40, withSun)}) {
        const CubemapReference reference(environment);
        for (const double m : {0.06, 0.3, 1.0})
            for (int i = 0; i < 12; ++i) {
                const glm::dvec3 direction = lighting::fibonacciSphere(i, 12), expected = sumOverTexels(environment, direction, m);
                const glm::dvec3 found = reference.prefiltered(direction, m, 0.1);  // texels are not split
                // Texels beyond the kernel's support, 1e-7 of its peak, are ignored; the sun is 400 times as bright as the rest.
                for (int channel = 0; channel < 3; ++channel) EXPECT_NEAR(found[channel], expected[channel], 2e-6 * expected[channel]) << m;
            }
    }
}

TEST(CubemapReference, PiecesOfTexelsAreTexelsOfALargerSource) {
    for (const Environment& environment : {strip(20, withSun), panorama(20, withSun)}) {
        const CubemapReference reference(environment);
        const double texelWidth = environment.projection == Environment::Projection::CubeStrip ? 2.0 / 20 : std::numbers::pi / 20;
        for (const int pieces : {2, 3}) {
            const Environment large = enlarged(environment, pieces);
            for (const double m : {0.1, 0.4})
                for (int i = 0; i < 12; ++i) {
                    const glm::dvec3 direction = lighting::fibonacciSphere(i, 12), expected = sumOverTexels(large, direction, m);
                    const glm::dvec3 found = reference.prefiltered(direction, m, (pieces - 0.5) * std::numbers::sqrt2 * m / texelWidth);
                    // Pieces of a cube strip use the density at their middle: with 1/40 a side the error is up to 3e-4.
                    for (int channel = 0; channel < 3; ++channel)
                        EXPECT_NEAR(found[channel], expected[channel], 4e-4 * expected[channel]) << m << ' ' << pieces;
                }
        }
    }
}

TEST(CubemapReference, NarrowLobesSeeTheTexelsTheyLieIn) {
    Environment environment = panorama(16, smooth);
    environment.texels.at(20, 7) = glm::vec3(90, 80, 70);
    const CubemapReference reference(environment);
    const glm::dvec3 centre = lighting::directionFromEquirectangular({20.5 / 32, 7.5 / 16});
    EXPECT_NEAR(reference.prefiltered(centre, 0.01).x, 90, 1e-3);
    const glm::dvec3 edge = lighting::directionFromEquirectangular({20.0 / 32, 7.5 / 16});
    EXPECT_NEAR(reference.prefiltered(edge, 0.01).x, 0.5 * (90 + static_cast<double>(environment.texels.at(19, 7).x)), 0.5);
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
            EXPECT_NEAR(reference.prefiltered(direction, 0.02 + 0.04 * i).z, 3, 1e-9);
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

TEST(VerifyCubemap, MomentsOfALevelAreThoseOfTheSourceThroughItsKernel) {
    const Environment environment = panorama(32, smooth);
    const CubemapReference reference(environment);
    const CookedCubemap map = ideal(reference, positiveSh());
    const LightMoments& source = reference.moments();
    for (int mip = 0; mip < 3; ++mip) {
        const LightMoments found = cubemapMoments(map, mip);
        const double band = kernelBands(map.mips[static_cast<std::size_t>(mip)].m)[1], tolerance = mip == 0 ? 1e-2 : 3e-2;
        EXPECT_NEAR(found.mean.y / source.mean.y, 1, tolerance) << mip;
        EXPECT_LT(glm::distance(found.first[0], band * source.first[0]), tolerance * source.mean.x) << mip;
    }
    EXPECT_GT(glm::length(source.first[0]), 0.1 * source.mean.x) << "the light has a direction";
}

TEST(VerifyCubemap, AnIdealMapHasNoErrorAtItsTexels) {
    const Environment environment = panorama(32, withSun);
    const CubemapReference reference(environment);
    const auto stages = verifyAll(ideal(reference, positiveSh()), reference);
    ASSERT_EQ(stages.size(), 3u);
    EXPECT_EQ(stages[0].name, "divide");
    EXPECT_EQ(stages[1].name, "filter");
    EXPECT_EQ(stages[2].name, "total");
    EXPECT_LT(stages[0].specular.relRms, 1e-6);
    EXPECT_LT(stages[2].specular.relRms, 1e-6);
    EXPECT_GT(stages[1].specular.relRms, 1e-3);  // an 8 x 8 face under a sun cannot be filtered without error
    EXPECT_EQ(stages[2].diffuse.maxSampled, 0);
    for (const StageError& stage : stages) EXPECT_GE(stage.specular.maxBound, stage.specular.maxSampled) << stage.name;
}

TEST(VerifyCubemap, FindsChangesToAMap) {
    const Environment environment = panorama(32, smooth);
    const CubemapReference reference(environment);
    const CookedCubemap good = ideal(reference, positiveSh());
    CookedCubemap dimmed = ideal(reference, positiveSh());
    dimmed.range *= 0.9f;
    EXPECT_NEAR(verifyAll(dimmed, reference)[2].specular.relRms, 0.1, 1e-5);
    CookedCubemap turned = ideal(reference, positiveSh());
    std::swap(turned.mips[0].faces[0], turned.mips[0].faces[4]);
    EXPECT_GT(verifyAll(turned, reference)[2].specular.relRms, 0.03);
    CookedCubemap rough = ideal(reference, positiveSh());
    rough.mips[1].m = 0.8;  // the manifest names another kernel than the one used
    EXPECT_GT(verifyAll(rough, reference)[2].specular.relRms, 0.01);
}

TEST(VerifyCubemap, APlainMapIsShownAsItIs) {
    const Environment environment = panorama(32, withSun);
    const CubemapReference reference(environment);
    lighting::ShRgb one{};
    one[0] = glm::vec3(static_cast<float>(1 / lighting::evaluate(lighting::ShDouble{1}, glm::dvec3(0, 0, 1))));
    CookedCubemap map = ideal(reference, one);  // divided by 1
    const StageError divided = verifyAll(map, reference)[2];
    map.isDivided = false;
    map.windowedSh = {};  // has no effect
    const auto stages = verifyAll(map, reference);
    EXPECT_NEAR(stages[2].specular.relRms, divided.specular.relRms, 1e-5);
    EXPECT_LT(stages[0].specular.relRms, 1e-5);
    EXPECT_GE(stages[2].specular.maxBound, stages[2].specular.maxSampled);
    map.isDivided = true;
    EXPECT_GT(verifyAll(map, reference, {1, 1, 0})[2].specular.relRms, 1e100) << "divided by nothing";
    map.isDivided = false;
    map.range *= 1.1f;
    EXPECT_NEAR(verifyAll(map, reference)[0].specular.relRms, 0.1, 1e-4);
}

TEST(VerifyCubemap, TheBoundOfVisibleErrorsHoldsInEveryDirection) {
    double before = 0;
    for (const bool isSunny : {false, true}) {
        const Environment environment = isSunny ? panorama(32, withSun) : panorama(32, smooth);
        const CubemapReference reference(environment);
        const Viewing viewing{lighting::DisplaySettings{}.of(reference.displayKey(lighting::kRec709Luminance))};
        CookedCubemap map = ideal(reference, positiveSh());
        const VisibleFigures few = verifyAll(map, reference, {1, 1, 1}, viewing)[2].specular.visible.value(),
                             many = verifyAll(map, reference, {2, 400, 600}, viewing)[2].specular.visible.value();
        EXPECT_EQ(few.bound, many.bound) << "of all directions, whatever was sampled";
        EXPECT_GE(few.bound.value(), many.max);
        EXPECT_LE(*few.bound, VisibleMetric(viewing, 1).mostVisible());
        EXPECT_GT(*few.bound, before) << "a sun";
        before = *few.bound;
        // A texel as bright as the sun where there is none.
        map.mips.back().faces[4].at(0, 0) = glm::vec4(1e3f);
        const VisibleFigures seen = verifyAll(map, reference, {2, 400, 600}, viewing)[2].specular.visible.value();
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
    const VisibleFigures rough = verifyAll(map, reference, {1, 24, 100}, viewing)[2].specular.visible.value();
    const glm::dvec3 sun = lighting::directionFromEquirectangular({20.5 / 64, 9.5 / 32});
    const double part = cubemapReflectance(0.5, map.lobe);
    const double largest =
        lighting::visibleDifference(part * reference.prefiltered(sun, 0.5), glm::dvec3(part), viewing.display, viewing.bt2020FromWorking);
    EXPECT_GT(largest, 10);
    EXPECT_GE(rough.bound.value(), largest);
    EXPECT_LT(*rough.bound, 1.6 * largest);
    map.mips[0].m = 0.02;
    EXPECT_GT(verifyAll(map, reference, {1, 24, 100}, viewing)[2].specular.visible->bound.value(), 2 * largest);
}

TEST(VerifyCubemap, AnSThatIsNotPositivePassesNoLimit) {
    const Environment environment = panorama(32, smooth);
    const CubemapReference reference(environment);
    CookedCubemap map = ideal(reference, positiveSh());
    map.windowedSh[2] = glm::vec3(0, 9, 0);  // green S is negative below
    EXPECT_GT(verifyAll(map, reference, {1, 1, 0})[2].specular.relRms, 1e100);
    EXPECT_EQ(verifyAll(map, reference, {1, 1, 0}, Viewing{})[2].specular.visible->bound, HUGE_VAL) << "nothing is known";
    map.windowedSh[2] = glm::vec3(0, NAN, 0);
    EXPECT_GT(verifyAll(map, reference, {1, 1, 0})[2].specular.relRms, 1e100);
}

TEST(VerifyCubemap, ATexelThatIsNotFinitePassesNoLimitEvenWhereNoSampleLies) {
    const Environment environment = panorama(32, smooth);
    const CubemapReference reference(environment);
    for (const float value : {NAN, HUGE_VALF}) {
        CookedCubemap map = ideal(reference, positiveSh());
        map.mips[1].faces[2].at(1, 3).y = value;
        const std::vector<StageError> stages = cubemapStages(map, reference, {}, {});
        EXPECT_GT(stages[2].specular.relRms, 1e100);
        EXPECT_GT(stages[2].specular.maxBound.value_or(0), 1e100);
    }
}

TEST(VerifyCubemap, ABlackProbeIsExact) {
    const Environment environment = panorama(16, [](const glm::dvec3&) { return glm::vec3(0); });
    const CubemapReference reference(environment);
    lighting::ShRgb sh{};
    sh[0] = glm::vec3(1e-30f);
    CookedCubemap map = ideal(reference, positiveSh());
    map.windowedSh = sh;
    for (const StageError& stage : verifyAll(map, reference)) EXPECT_EQ(stage.specular.maxSampled, 0);
}

TEST(VerifyCubemap, BandFactorsAreTheKernelsEffectOnHarmonics) {
    const Environment environment =
        panorama(256, [](const glm::dvec3& d) { return glm::vec3(glm::dvec3(1, 1 + d.y, 1 + 0.5 * (3 * d.y * d.y - 1))); });
    const CubemapReference reference(environment);
    for (const double m : {0.05, 0.2, 0.5, 1.0}) {
        const lighting::ShBands bands = kernelBands(m);
        const glm::dvec3 seen = reference.prefiltered({0, 1, 0}, m);
        EXPECT_EQ(bands[0], 1);
        EXPECT_NEAR(bands[1], seen.y - 1, 3e-4) << m;
        EXPECT_NEAR(bands[2], seen.z - 1, 6e-4) << m;
    }
    EXPECT_EQ(kernelBands(0), (lighting::ShBands{1, 1, 1}));
}

TEST(VerifyCubemap, SamplesCoverEveryBlockIfThereAreEnough) {
    const Environment environment = panorama(16, smooth);
    const CubemapReference reference(environment);
    CookedCubemap map = ideal(reference, positiveSh());
    std::set<std::tuple<int, int, int>> blocks;
    for (const int size : {16, 10}) {  // 10: three blocks a side, the last of two texels
        map.mips[0].faces.clear();
        for (int face = 0; face < 6; ++face) map.mips[0].faces.emplace_back(size, size);
        blocks.clear();
        for (const CubemapSample& sample : cubemapSamples(map, {}))
            if (sample.mip == 0 && sample.isTexel) {
                ASSERT_TRUE(sample.x >= 0 && sample.x < size && sample.y >= 0 && sample.y < size);
                blocks.insert({sample.face, sample.x / 4, sample.y / 4});
            }
        EXPECT_EQ(blocks.size(), size == 16 ? 96u : 54u);
    }
}

TEST(VerifyCubemap, SamplesAreTheSameEveryTimeAndInsideTheMap) {
    const Environment environment = panorama(16, smooth);
    const CubemapReference reference(environment);
    const CookedCubemap map = ideal(reference, positiveSh());
    const auto first = cubemapSamples(map, {7, 40, 5}), second = cubemapSamples(map, {7, 40, 5}), other = cubemapSamples(map, {8, 40, 5});
    ASSERT_EQ(first.size(), 40u + 40u + 24u + 15u);  // the last mip has 24 texels
    bool differs = false;
    for (std::size_t i = 0; i < first.size(); ++i) {
        EXPECT_EQ(first[i].direction, second[i].direction);
        EXPECT_NEAR(glm::length(first[i].direction), 1, 1e-12);
        differs = differs || first[i].direction != other[i].direction;
    }
    EXPECT_TRUE(differs);
}

}  // namespace
}  // namespace lightcook::verify

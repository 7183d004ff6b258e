// The shared sources, compiled as C++, against lighting/: the same mathematics written twice, by different hands.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <random>
#include <vector>

#include "lighting/area_specular.h"
#include "lighting/brdf.h"
#include "lighting/radiometry.h"
#include "lighting/sh.h"
#include "lighting/sphere.h"
#include "shaders/lightcook_ggx.h"

namespace lightcook {
namespace {

using glm::vec3;
using shaders::LcSh;

class Random {
public:
    vec3 direction() {
        const vec3 v(normal_(engine_), normal_(engine_), normal_(engine_));
        return glm::normalize(v);
    }
    float number(float low, float high) { return std::uniform_real_distribution<float>(low, high)(engine_); }
    glm::vec4 texel(float low, float high) {
        glm::vec4 values;
        for (int i = 0; i < 4; ++i) values[i] = number(low, high);
        return values;
    }
    LcSh light() {
        LcSh sh;
        for (vec3& c : sh.c) c = vec3(number(-1, 1), number(-1, 1), number(-1, 1));
        return sh;
    }

private:
    std::mt19937 engine_{7};
    std::normal_distribution<float> normal_;
};

lighting::ShRgb toRgb(const LcSh& sh) {
    lighting::ShRgb out;
    std::copy_n(sh.c, out.size(), out.begin());
    return out;
}

void expectNear(const vec3& a, const vec3& b, float tolerance) {
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], tolerance);
}

TEST(ShaderSh, EvaluatesAsLightingDoes) {
    Random random;
    for (int i = 0; i < 200; ++i) {
        const LcSh sh = random.light();
        const vec3 n = random.direction();
        expectNear(shaders::lcRadiance(sh, n), lighting::evaluate(toRgb(sh), n), 1e-5f);
        expectNear(shaders::lcIrradiance(sh, n), lighting::irradiance(toRgb(sh), n).value, 2e-5f);
        expectNear(shaders::lcExitRadiance(sh, n), lighting::lambertExitRadiance(toRgb(sh), n, vec3(1)).value, 1e-5f);
        const float wrap = random.number(0, 1);
        const lighting::ShRgb wrapped = lighting::convolve(toRgb(sh), lighting::wrappedLambertBands(static_cast<double>(wrap)));
        expectNear(shaders::lcExitRadianceWrapped(sh, n, wrap), lighting::evaluate(wrapped, n), 1e-5f);
    }
}

TEST(ShaderFilter, MixesTheCoveredTexelsAroundAPlace) {
    using shaders::vec2, shaders::vec4;
    const vec2 size(10, 6);
    shaders::LcQuad q = shaders::lcQuad(vec2(3.75f, 2.25f) / size, size);
    EXPECT_EQ(q.texel00, vec2(3, 1));
    EXPECT_EQ(q.texel10, vec2(4, 1));
    EXPECT_EQ(q.texel01, vec2(3, 2));
    EXPECT_EQ(q.texel11, vec2(4, 2));
    const vec4 expected(0.75f * 0.25f, 0.25f * 0.25f, 0.75f * 0.75f, 0.25f * 0.75f);
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(q.weights[i], expected[i], 1e-5f);
    const shaders::LcQuad corner = shaders::lcQuad(vec2(1, 0), size);
    EXPECT_EQ(corner.texel00, vec2(9, 0));
    EXPECT_EQ(corner.texel11, vec2(9, 0));
    const vec4 two = shaders::lcCoveredQuad(q, vec4(1, 0, 0, 1)).weights;
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(two[i], i == 0 || i == 3 ? 0.5f : 0.0f, 1e-5f);
    EXPECT_EQ(shaders::lcCoveredQuad(q, vec4(0)).weights, q.weights);
    LcSh lights[4];
    for (int i = 0; i < 4; ++i) std::fill_n(lights[i].c, 9, vec3(static_cast<float>(i)));
    expectNear(shaders::lcMix(lights[0], lights[1], lights[2], lights[3], vec4(0.5f, 0, 0, 0.5f)).c[8], vec3(1.5f), 1e-6f);
    // One texel, as often as it weighs.
    q.weights = vec4(0.25f, 0.5f, 0, 0.25f);
    EXPECT_EQ(shaders::lcQuadTexel(q, 0), q.texel00);
    EXPECT_EQ(shaders::lcQuadTexel(q, 0.3f), q.texel10);
    EXPECT_EQ(shaders::lcQuadTexel(q, 0.74f), q.texel10);
    EXPECT_EQ(shaders::lcQuadTexel(q, 0.75f), q.texel11);
}

TEST(ShaderFilter, ReadsEveryBitOfTheCoverage) {
    for (int bit = 0; bit < 32; ++bit) {
        shaders::vec4 texel(0);
        texel[bit / 8] = static_cast<float>(1 << bit % 8) / 255;
        for (int y = 0; y < 4; ++y)
            for (int x = 0; x < 8; ++x) {
                const shaders::vec2 at(16 + x, 8 + y);
                EXPECT_EQ(shaders::lcCoverageTexel(at), shaders::vec2(2, 2));
                EXPECT_EQ(shaders::lcCovered(texel, at), 8 * y + x == bit ? 1 : 0);
                EXPECT_EQ(shaders::lcCovered(shaders::vec4(1) - texel, at), 8 * y + x == bit ? 0 : 1);
            }
    }
}

TEST(ShaderLit, LightIsTheSumOfOneLightAndTheRest) {
    Random random;
    for (int i = 0; i < 50; ++i) {
        // Octahedral projection, both halves.
        const vec3 towards = random.direction();
        vec3 p = towards / (std::abs(towards.x) + std::abs(towards.y) + std::abs(towards.z));
        if (p.z < 0) p = vec3((1 - std::abs(p.y)) * (p.x < 0 ? -1.0f : 1.0f), (1 - std::abs(p.x)) * (p.y < 0 ? -1.0f : 1.0f), p.z);
        shaders::LcLitTexels t{};
        shaders::LcLitConstants k{2, {}, {}};
        t.direction = shaders::vec4(0.5f * p.x + 0.5f, 0.5f * p.y + 0.5f, 0, 0);
        expectNear(shaders::lcLitDirection(t.direction), towards, 1e-5f);
        t.light = shaders::vec4(0.1f, 0.2f, 0.3f, 0);
        t.l0 = shaders::vec4(0.5f, 0.6f, 0.7f, 0);
        for (int c = 0; c < 8; ++c) {
            k.scale[c] = 2;
            k.bias[c] = -1;
            t.rest[c] = shaders::vec4(random.number(0, 1), random.number(0, 1), random.number(0, 1), 0);
        }
        const lighting::Sh y = lighting::evaluateBasis(towards);
        for (const float dim : {0.0f, 0.25f, 1.0f}) {
            const LcSh sh = shaders::lcLightMapLitDimmed(t, k, vec3(dim));
            const vec3 light = 2.0f * vec3(t.light), rest = 2.0f * vec3(t.l0) - y[0] * light;
            expectNear(sh.c[0], rest + dim * y[0] * light, 1e-5f);
            for (int c = 0; c < 8; ++c) {
                const vec3 ratio = 2.0f * vec3(t.rest[c]) - 1.0f;
                expectNear(sh.c[c + 1], rest * ratio + dim * y[static_cast<std::size_t>(c) + 1] * light, 1e-5f);
            }
        }
        const LcSh whole = shaders::lcLightMapLit(t, k), undimmed = shaders::lcLightMapLitDimmed(t, k, vec3(1));
        for (int c = 0; c < 9; ++c) expectNear(whole.c[c], undimmed.c[c], 0);
    }
}

TEST(ShaderSh, ConstantGreyLeavesAWhiteSurfaceAsGrey) {
    LcSh sh{};
    sh.c[0] = vec3(0.5f * std::sqrt(4 * std::numbers::pi_v<float>));
    Random random;
    for (int i = 0; i < 50; ++i) {
        expectNear(shaders::lcExitRadiance(sh, random.direction()), vec3(0.5f), 5e-7f);
        expectNear(shaders::lcZonalSpecular(sh, random.direction(), vec3(1, 0.9f, 0.7f)), vec3(0.5f), 5e-7f);
    }
}

TEST(ShaderSh, LocalCoefficientsAreThoseOfTheTurnedLight) {
    Random random;
    for (int i = 0; i < 100; ++i) {
        const LcSh sh = random.light();
        const glm::dmat3 world = lighting::worldFromTangentFrame(glm::dvec3(random.direction()));
        const LcSh local = shaders::lcLocalSh(sh, vec3(world[0]), vec3(world[1]), vec3(world[2]));
        const lighting::ShRgb expected = lighting::ShRotation(glm::transpose(world)).apply(toRgb(sh));
        for (std::size_t k = 0; k < expected.size(); ++k) expectNear(local.c[k], expected[k], 3e-6f);
        const vec3 n = random.direction();
        expectNear(shaders::lcRadiance(local, n), shaders::lcRadiance(sh, glm::mat3(world) * n), 1e-5f);
    }
}

/// Random factors of learned layouts: rows of a texture, and the buffers of each row.
struct LearnedTables {
    static constexpr int kClusters = 3, kLayers = 5, kColumns = 120 + 36 * kLayers;
    std::vector<glm::vec4> texels;
    std::vector<shaders::LcBasisFirst3> first3{kClusters};
    std::vector<shaders::LcBasisFirst4> first4{kClusters};
    std::vector<std::vector<shaders::LcBasisResidual>> residual{kClusters, std::vector<shaders::LcBasisResidual>(kLayers)};

    explicit LearnedTables(Random& random) {
        for (int i = 0; i < kClusters * kColumns; ++i) texels.push_back(random.texel(-1, 1));
        for (std::size_t cluster = 0; cluster < kClusters; ++cluster) {
            const glm::vec4* const row = texels.data() + cluster * kColumns;
            std::copy_n(row, 80, first3[cluster].v);
            std::copy_n(row, 120, first4[cluster].v);
            for (std::size_t layer = 0; layer < kLayers; ++layer) std::copy_n(row + 120 + 36 * layer, 36, residual[cluster][layer].v);
        }
    }
    shaders::LcTables texture() const { return {texels.data(), kColumns}; }
};

/// The same sums in the same order: bit for bit what the tables in buffers give.
TEST(ShaderLightMaps, LearnedTablesFromTheTextureDecodeAsThoseOfBuffers) {
    Random random;
    const LearnedTables all(random);
    const shaders::LcTables tables = all.texture();
    const auto expectSame = [](const LcSh& a, const LcSh& b) {
        for (int i = 0; i < 9; ++i) EXPECT_EQ(a.c[i], b.c[i]) << i;
    };
    for (int i = 0; i < 100; ++i) {
        const int row = i % LearnedTables::kClusters;
        const auto cluster = static_cast<std::size_t>(row);
        const glm::vec4 l0 = random.texel(0, 1), a = random.texel(0, 1), b = random.texel(0, 1), c = random.texel(0, 1),
                        d = random.texel(0, 1);
        const shaders::LcBasisQuad quad = shaders::lcBasisQuad(l0, a, b, c, d, 3.0f);
        expectSame(shaders::lcLightMapBasis3From(l0, a, tables, row, 3.0f), shaders::lcLightMapBasis3(l0, a, all.first3[cluster], 3.0f));
        expectSame(shaders::lcMixBasis3From(quad, a, b, c, d, tables, row), shaders::lcMixBasis3(quad, a, b, c, d, all.first3[cluster]));
        LcSh fetched = shaders::lcLightMapBasis4From(l0, a, tables, row, 3.0f),
             buffered = shaders::lcLightMapBasis4(l0, a, all.first4[cluster], 3.0f),
             mixFetched = shaders::lcMixBasis4From(quad, a, b, c, d, tables, row),
             mixBuffered = shaders::lcMixBasis4(quad, a, b, c, d, all.first4[cluster]);
        expectSame(fetched, buffered);
        expectSame(mixFetched, mixBuffered);
        for (int layer = 0; layer < LearnedTables::kLayers; ++layer) {
            const shaders::LcBasisResidual& residual = all.residual[cluster][static_cast<std::size_t>(layer)];
            fetched = shaders::lcLightMapBasisAddFrom(fetched, l0, b, tables, row, layer, 3.0f, 0.5f);
            buffered = shaders::lcLightMapBasisAdd(buffered, l0, b, residual, 3.0f, 0.5f);
            expectSame(fetched, buffered);
            mixFetched = shaders::lcMixBasisAddFrom(mixFetched, quad, b, c, d, a, tables, row, layer, 0.5f);
            mixBuffered = shaders::lcMixBasisAdd(mixBuffered, quad, b, c, d, a, residual, 0.5f);
            expectSame(mixFetched, mixBuffered);
        }
    }
}

/// A term passes at most 80 roundings of 2^-24 on both ways together: 5e-6 of the sum of all terms without their signs.
TEST(ShaderLightMaps, MixingLearnedTexelsFirstIsMixingTheirLight) {
    constexpr float kRange = 3, kNeutral = 0.4f, kRounding = 5e-6f;
    Random random;
    const LearnedTables all(random);
    const auto absolute = [](auto basis) {
        for (vec3& factor : basis.v) factor = glm::abs(factor);
        return basis;
    };
    for (int i = 0; i < 300; ++i) {
        const auto cluster = static_cast<std::size_t>(i % LearnedTables::kClusters);
        glm::vec4 l0[4], code[4], weights = random.texel(0, 1);
        LcSh light3[4], light4[4], size3[4], size4[4];
        // A texel that is not covered weighs nothing; l0 differs by a factor of up to 1000.
        if (i % 3 == 0) weights[i / 3 % 4] = 0;
        weights /= glm::dot(weights, glm::vec4(1));
        for (int t = 0; t < 4; ++t) {
            l0[t] = random.texel(0, 1) * std::pow(10.0f, random.number(-3, 0));
            code[t] = random.texel(0, 1);
            light3[t] = shaders::lcLightMapBasis3(l0[t], code[t], all.first3[cluster], kRange);
            light4[t] = shaders::lcLightMapBasis4(l0[t], code[t], all.first4[cluster], kRange);
            size3[t] = shaders::lcLightMapBasis3(l0[t], code[t], absolute(all.first3[cluster]), kRange);
            size4[t] = shaders::lcLightMapBasis4(l0[t], code[t], absolute(all.first4[cluster]), kRange);
        }
        const shaders::LcBasisQuad quad = shaders::lcBasisQuad(l0[0], l0[1], l0[2], l0[3], weights, kRange);
        const auto expectMixed = [&](const LcSh& mixed, const LcSh* light, const LcSh* size) {
            const LcSh expected = shaders::lcMix(light[0], light[1], light[2], light[3], weights),
                       sum = shaders::lcMix(size[0], size[1], size[2], size[3], weights);
            for (int k = 0; k < 9; ++k)
                for (int c = 0; c < 3; ++c) EXPECT_NEAR(mixed.c[k][c], expected.c[k][c], kRounding * sum.c[k][c]) << i << ", " << k;
        };
        expectMixed(shaders::lcMixBasis3(quad, code[0], code[1], code[2], code[3], all.first3[cluster]), light3, size3);
        LcSh mixed = shaders::lcMixBasis4(quad, code[0], code[1], code[2], code[3], all.first4[cluster]);
        expectMixed(mixed, light4, size4);
        for (const shaders::LcBasisResidual& residual : all.residual[cluster]) {
            glm::vec4 stored[4];
            for (int t = 0; t < 4; ++t) {
                stored[t] = random.texel(0, 1);
                light4[t] = shaders::lcLightMapBasisAdd(light4[t], l0[t], stored[t], residual, kRange, kNeutral);
                size4[t] = shaders::lcLightMapBasisAdd(size4[t], l0[t], glm::abs(stored[t] - kNeutral), absolute(residual), kRange, 0);
            }
            mixed = shaders::lcMixBasisAdd(mixed, quad, stored[0], stored[1], stored[2], stored[3], residual, kNeutral);
            expectMixed(mixed, light4, size4);
        }
    }
}

/// The formula of the engine, and what the decoded coefficients of radiance show: L0 + n . L1 with L1 written out.
TEST(ShaderLightMaps, EnginesLayoutsShowWhatTheEngineShows) {
    Random random;
    const auto texel = [&](float high) { return glm::vec4(random.number(0, high), random.number(0, high), random.number(0, high), 1); };
    const auto expectShown = [&](const LcSh& sh, const vec3& shown, const vec3& n) {
        expectNear(lighting::lambertExitRadiance(toRgb(sh), n, vec3(1)).value, shown, 2e-5f);
        for (int i = 4; i < 9; ++i) EXPECT_EQ(sh.c[i], vec3(0));
    };
    for (int i = 0; i < 200; ++i) {
        const vec3 n = random.direction();
        const glm::vec4 first = texel(2), x = texel(1), y = texel(1), z = texel(1);
        const vec3 l0(first), alongColours = n.x * (vec3(x) - 0.5f) + n.y * (vec3(y) - 0.5f) + n.z * (vec3(z) - 0.5f);
        const shaders::LcGodotTexels godot{{first, y, z, x}};
        expectNear(shaders::lcGodotExitRadiance(godot, n), l0 + 8.0f * l0 * alongColours, 1e-5f);
        expectShown(shaders::lcLightMapGodot(godot), shaders::lcGodotExitRadiance(godot, n), n);
        const shaders::LcBakeryTexels bakery{first, x, y, z};
        expectNear(shaders::lcBakeryExitRadiance(bakery, n), l0 + 4.0f * l0 * alongColours, 1e-5f);
        expectShown(shaders::lcLightMapBakery(bakery), shaders::lcBakeryExitRadiance(bakery, n), n);
        const shaders::LcMonoShTexels mono{first, x};
        expectNear(shaders::lcMonoShExitRadiance(mono, n), l0 + 4.0f * l0 * glm::dot(vec3(x) - 0.5f, n), 1e-5f);
        expectShown(shaders::lcLightMapMonoSh(mono), shaders::lcMonoShExitRadiance(mono, n), n);
    }
}

/// The engine's formula written out in double; light is not negative where the engine clamps the directionality at 0.
TEST(ShaderLightMaps, UnrealShowsWhatTheEngineShows) {
    Random random;
    const auto four = [&](float low, float high) {
        return glm::vec4(random.number(low, high), random.number(low, high), random.number(low, high), random.number(low, high));
    };
    int clamped = 0;
    for (int i = 0; i < 400; ++i) {
        const vec3 n = random.direction();
        const shaders::LcUnrealHqTexels texels{four(0, 1), four(0, 1)};
        shaders::LcUnrealHqConstants k{four(0.5f, 2), four(0, 1), four(0.5f, 1), four(-0.5f, 0)};
        k.scale0.w = random.number(1, 12);
        k.add0.w = random.number(-5, -1);
        k.scale1.w = 0;
        k.add1.w = 0.282095f;
        const glm::dvec4 first(texels.lightmap0), second(texels.lightmap1);
        const double logL = (first.w + second.w / 255 - 0.5 / 255) * static_cast<double>(k.scale0.w) + static_cast<double>(k.add0.w);
        const double luminance = std::exp2(logL) - 0.01858136;
        const glm::dvec4 sh = second * glm::dvec4(k.scale1) + glm::dvec4(k.add1);
        const double along = sh.x * static_cast<double>(n.y) + sh.y * static_cast<double>(n.z) + sh.z * static_cast<double>(n.x) + sh.w;
        const glm::dvec3 uvw = glm::dvec3(first) * glm::dvec3(first) * glm::dvec3(k.scale0) + glm::dvec3(k.add0);
        const float rounding = 1e-5f * (1 + std::abs(static_cast<float>(luminance)));
        expectNear(shaders::lcUnrealHqExitRadiance(texels, k, n), vec3(luminance * std::max(along, 0.0) * uvw), 3 * rounding);
        const LcSh decoded = shaders::lcLightMapUnrealHq(texels, k);
        expectNear(lighting::lambertExitRadiance(toRgb(decoded), n, vec3(1)).value, vec3(luminance * along * uvw), 9 * rounding);
        for (int j = 4; j < 9; ++j) EXPECT_EQ(decoded.c[j], vec3(0));
        clamped += along < 0 ? 1 : 0;
    }
    EXPECT_GT(clamped, 20);
}

/// The engine's formula written out in double, and coefficients that show the same at the surface's own normal, in any frame.
TEST(ShaderLightMaps, RnmShowsWhatTheEngineShows) {
    Random random;
    const double a = std::sqrt(2.0 / 3), b = 1 / std::sqrt(6.0), c = 1 / std::sqrt(2.0), d = 1 / std::sqrt(3.0);
    int clamped = 0;
    for (int i = 0; i < 400; ++i) {
        const auto light = [&] { return glm::vec4(random.number(0, 4), random.number(0, 4), random.number(0, 4), 1); };
        const shaders::LcRnmTexels t{light(), light(), light()};
        const vec3 n = random.direction();
        const glm::dvec3 exact(n);
        const double along[3] = {a * exact.x + d * exact.z, -b * exact.x - c * exact.y + d * exact.z,
                                 -b * exact.x + c * exact.y + d * exact.z};
        const glm::dvec3 shown = std::max(along[0], 0.0) * glm::dvec3(vec3(t.rnm0)) + std::max(along[1], 0.0) * glm::dvec3(vec3(t.rnm1)) +
                                 std::max(along[2], 0.0) * glm::dvec3(vec3(t.rnm2));
        expectNear(shaders::lcRnmExitRadiance(t, n), vec3(shown), 1e-5f);
        clamped += along[0] < 0 ? 1 : 0;
        const vec3 normal = random.direction(), tangent = glm::normalize(glm::cross(normal, random.direction())),
                   bitangent = (i % 2 == 0 ? 1.0f : -1.0f) * glm::cross(normal, tangent);
        const LcSh decoded = shaders::lcLightMapRnm(t, tangent, bitangent, normal);
        expectNear(lighting::lambertExitRadiance(toRgb(decoded), normal, vec3(1)).value, shaders::lcRnmExitRadiance(t, vec3(0, 0, 1)),
                   3e-5f);
        // Within the hemisphere, no colour is farther off than an eighth of the light of the directions.
        const vec3 local = vec3(n.x, n.y, std::abs(n.z)), world = local.x * tangent + local.y * bitangent + local.z * normal;
        const vec3 off =
            glm::abs(lighting::lambertExitRadiance(toRgb(decoded), world, vec3(1)).value - shaders::lcRnmExitRadiance(t, local));
        for (int channel = 0; channel < 3; ++channel)
            EXPECT_LT(off[channel], 0.1254f * (t.rnm0[channel] + t.rnm1[channel] + t.rnm2[channel]));
    }
    EXPECT_GT(clamped, 100);
}

TEST(ShaderSpecular, CookTorranceIsLightings) {
    Random random;
    for (int i = 0; i < 500; ++i) {
        const vec3 normal = random.direction(), view = random.direction(), light = random.direction();
        const float m = random.number(0.1f, 0.6f), f0 = random.number(0, 1);
        const vec3 value = shaders::lcCookTorrance(view, light, normal, m, vec3(f0));
        const auto expected = [&](lighting::CookTorranceNormalization normalization) {
            return lighting::cookTorrance(glm::dvec3(view), glm::dvec3(light), glm::dvec3(normal), static_cast<double>(m),
                                          static_cast<double>(f0), lighting::NormalDistribution::Beckmann, normalization);
        };
        const double energy = expected(lighting::CookTorranceNormalization::Energy);
        EXPECT_NEAR(static_cast<double>(value.x), energy, 1e-3 * energy + 1e-6) << "m " << m;
        const double halo = expected(lighting::CookTorranceNormalization::Halo3);
        EXPECT_NEAR(static_cast<double>(shaders::lcCookTorranceHalo3(view, light, normal, m, vec3(f0)).x), halo, 1e-3 * halo + 4e-6);
    }
}

TEST(ShaderSpecular, AnIncludeWithGgxDefinedHasItsDistribution) {
    Random random;
    for (int i = 0; i < 500; ++i) {
        const vec3 normal = random.direction(), view = random.direction(), light = random.direction();
        const float m = random.number(0.1f, 1.0f), f0 = random.number(0, 1);
        const double value = static_cast<double>(shaders::ggx::lcCookTorrance(view, light, normal, m, vec3(f0)).x);
        const double expected =
            lighting::cookTorrance(glm::dvec3(view), glm::dvec3(light), glm::dvec3(normal), static_cast<double>(m), static_cast<double>(f0),
                                   lighting::NormalDistribution::Ggx, lighting::CookTorranceNormalization::Energy);
        EXPECT_NEAR(value, expected, 1e-3 * expected + 1e-6) << "m " << m;
        EXPECT_EQ(shaders::ggx::lcBeckmann(0.9f, m), shaders::lcBeckmann(0.9f, m));
        EXPECT_EQ(shaders::ggx::lcDistribution(0.9f, m), shaders::lcGgx(0.9f, m));
        EXPECT_EQ(shaders::lcDistribution(0.9f, m), shaders::lcBeckmann(0.9f, m));
    }
}

/// The furnace: light of 1 from everywhere on a surface that absorbs nothing. The sum over the shader's punctual lights, by long double
/// quadrature over the light's directions, is that of the tables' kernel, and never more than what arrives.
TEST(ShaderSpecular, TheFurnaceGivesTheTablesLightForBothLobes) {
    constexpr long double kPi = std::numbers::pi_v<long double>;
    for (const bool isGgx : {false, true})
        for (const float m : {0.25f, 0.5f, 1.0f})
            for (const float NoV : {0.2f, 0.6f, 1.0f}) {
                const vec3 normal(0, 0, 1), view(std::sqrt(1 - NoV * NoV), 0, NoV);
                constexpr int kRings = 1200, kSteps = 900;
                long double sum = 0;
                for (int i = 0; i < kRings; ++i) {
                    const long double z = (i + 0.5L) / kRings, ring = std::sqrt(1 - z * z);
                    for (int j = 0; j < kSteps; ++j) {
                        const long double phi = kPi * (j + 0.5L) / kSteps;  // the half in front of the plane of incidence mirrors the other
                        const vec3 light(static_cast<float>(ring * std::cos(phi)), static_cast<float>(ring * std::sin(phi)),
                                         static_cast<float>(z));
                        const vec3 value = isGgx ? shaders::ggx::lcCookTorrance(view, light, normal, m, vec3(1))
                                                 : shaders::lcCookTorrance(view, light, normal, m, vec3(1));
                        sum += static_cast<long double>(value.x) * z * (2 * kPi / kRings / kSteps);
                    }
                }
                const auto lobe = isGgx ? lighting::SpecularLobe::Ggx : lighting::SpecularLobe::Beckmann;
                const auto kernel = lighting::areaSpecular(static_cast<double>(NoV), static_cast<double>(m), lobe,
                                                           lighting::CookTorranceNormalization::Energy);
                const double expected = kernel.c[0] / lighting::kShConstant;
                EXPECT_NEAR(static_cast<double>(sum), expected, 1e-3 * expected) << (isGgx ? "GGX " : "Beckmann ") << m << ' ' << NoV;
                EXPECT_LT(expected, 1 + 1e-6);
            }
}

TEST(ShaderSpecular, FresnelStaysSaneAtItsEnds) {
    for (const float f0 : {0.0f, 0.04f, 0.6f, 1.0f}) {
        EXPECT_NEAR(shaders::lcFresnelExact(f0, 1.0f), f0, 1e-3f);
        // Without a step of the index there is nothing to reflect, at any angle.
        EXPECT_NEAR(shaders::lcFresnelExact(f0, 0.0f), f0 == 0 ? 0.0f : 1.0f, 1e-3f);
        for (const float LoH : {-0.1f, 0.0f, 0.3f, 1.0f, 1.0000001f}) {
            EXPECT_TRUE(std::isfinite(shaders::lcFresnelExact(f0, LoH)));
            const float schlick = shaders::lcSchlick(vec3(f0), LoH).x;
            EXPECT_GE(schlick, f0 - 1e-6f);
            EXPECT_LE(schlick, 1.0f + 1e-6f);
        }
    }
}

TEST(ShaderSpecular, ViewFrameIsOrthonormalAlsoAlongTheNormal) {
    Random random;
    for (int i = 0; i < 100; ++i) {
        const vec3 normal = random.direction();
        const vec3 view = i % 4 == 0 ? normal : random.direction();
        const shaders::LcFrame f = shaders::lcViewFrame(normal, view);
        EXPECT_NEAR(glm::dot(f.x, f.y), 0, 1e-5f);
        EXPECT_NEAR(glm::dot(f.x, f.z), 0, 2e-4f);
        EXPECT_NEAR(glm::length(f.x), 1, 1e-5f);
        EXPECT_NEAR(glm::dot(glm::cross(f.x, f.y), f.z), 1, 1e-4f);
        EXPECT_NEAR(glm::dot(f.y, view), 0, 2e-4f);
        EXPECT_GE(glm::dot(f.x, view), -1e-5f);
    }
}

TEST(ShaderSpecular, AreaSpecularIsTheSumOfTheKernel) {
    Random random;
    const lighting::AreaSpecularKernel kernel =
        lighting::integrateAreaSpecular(0.7, 0.3, lighting::NormalDistribution::Beckmann, lighting::CookTorranceNormalization::Energy, 128);
    shaders::LcSpecularKernel texels;
    const auto at = [](const lighting::ShDouble& k, std::size_t i) { return static_cast<float>(k[i]); };
    texels.c0236 = glm::vec4(at(kernel.c, 0), at(kernel.c, 2), at(kernel.c, 3), at(kernel.c, 6));
    texels.d0236 = glm::vec4(at(kernel.d, 0), at(kernel.d, 2), at(kernel.d, 3), at(kernel.d, 6));
    texels.cd78 = glm::vec4(at(kernel.c, 7), at(kernel.c, 8), at(kernel.d, 7), at(kernel.d, 8));
    // A table of scale 1/2 and bias 1/4, as unorm textures have one.
    shaders::LcSpecularConstants k;
    k.scale = {glm::vec4(2), glm::vec4(2), glm::vec4(2)};
    k.bias = {glm::vec4(-0.5f), glm::vec4(-0.5f), glm::vec4(-0.5f)};
    const auto packed = [](const glm::vec4& v) { return 0.5f * (v + 0.5f); };
    const shaders::LcSpecularKernel stored = {packed(texels.c0236), packed(texels.d0236), packed(texels.cd78)};
    for (int i = 0; i < 20; ++i) {
        const LcSh sh = random.light();
        const double f0 = 0.6;
        double expected = 0;
        for (std::size_t j = 0; j < kernel.c.size(); ++j)
            expected += static_cast<double>(sh.c[j].y) * (f0 * kernel.c[j] + (1 - f0) * kernel.d[j]);
        const vec3 value = shaders::lcAreaSpecular(sh, shaders::lcSpecularKernel(stored, k), vec3(static_cast<float>(f0)));
        EXPECT_NEAR(static_cast<double>(value.y), expected, 1e-5);
    }
}

/// One lamp's coefficients without that lamp are none; the whole specular light is then the lamp's own, and without the lamp that of the
/// coefficients.
TEST(ShaderSpecular, TheWholeCountsNoLightTwice) {
    Random random;
    shaders::LcSpecularKernel kernel;
    kernel.c0236 = glm::vec4(0.2f, 0.1f, 0.3f, 0.05f);
    kernel.d0236 = glm::vec4(0.02f, 0.01f, 0.03f, 0.005f);
    kernel.cd78 = glm::vec4(0.1f, 0.2f, 0.01f, 0.02f);
    const vec3 normal(0, 0, 1), f0(0.04f);
    for (int i = 0; i < 50; ++i) {
        const vec3 towards = random.direction(), view = glm::normalize(random.direction() + 1.2f * normal), intensity(2, 1, 0.5f);
        const lighting::ShRgb lamp = lighting::projectDirectional(towards, intensity);
        LcSh sh = random.light(), both = sh;
        for (std::size_t j = 0; j < lamp.size(); ++j) both.c[j] += lamp[j];
        const LcSh rest = shaders::lcWithoutLight(both, towards, intensity);
        for (std::size_t j = 0; j < lamp.size(); ++j) expectNear(rest.c[j], sh.c[j], 1e-5f);
        const shaders::LcFrame f = shaders::lcViewFrame(normal, view);
        const vec3 area = shaders::lcAreaSpecular(shaders::lcLocalSh(sh, f.x, f.y, f.z), kernel, f0);
        const vec3 sharp = shaders::lcDominantSpecular(view, 0.5f * towards, intensity, normal, 0.2f, f0);
        expectNear(shaders::lcWholeSpecular(view, both, 0.5f * towards, intensity, normal, 0.2f, f0, kernel), area + sharp,
                   1e-4f * (1 + sharp.x));
        expectNear(shaders::lcWholeSpecular(view, sh, towards, vec3(0), normal, 0.2f, f0, kernel), area, 1e-6f);
    }
}

TEST(ShaderSh, TheAxisOfBand1IsThatOfALightInAnyUnit) {
    Random random;
    const vec3 weights(0.2f, 0.7f, 0.1f);
    for (const float unit : {1e-38f, 1e-30f, 1e-6f, 1.0f, 1e30f, 3e37f})
        for (int i = 0; i < 50; ++i) {
            const vec3 n = random.direction(), color(random.number(0.1f, 1), random.number(0.1f, 1), random.number(0.1f, 1));
            const lighting::ShRgb light = lighting::projectDirectional(n, color);
            LcSh sh{};
            for (std::size_t c = 0; c < 4; ++c) sh.c[c] = unit * light[c];
            expectNear(shaders::lcLinearAxis(sh, weights), n, unit < 1e-37f ? 1e-5f : 1e-6f);
        }
    EXPECT_EQ(shaders::lcLinearAxis(LcSh{}, weights), vec3(0));
}

TEST(ShaderLightMap, Halo3IsTheFormulaOfItsTalk) {
    shaders::LcHalo3Texels texels{};
    shaders::LcHalo3Constants constants{};
    const glm::vec4 first(0.9f, 0.6f, 0.3f, 0.7f), second(0.5f, 0.8f, 0.4f, 0.6f);
    texels.first[3] = first;
    texels.second[3] = second;
    constants.range[3] = 3;
    const vec3 uvw = (vec3(first) + vec3(second)) * 2.0f - 2.0f;
    expectNear(shaders::lcLightMapHalo3(texels, constants).c[3], 3.0f * 0.7f * 0.6f * uvw, 1e-6f);
}

TEST(ShaderLightMap, RatioOfABlackL0IsBlack) {
    shaders::LcRatioTexels texels{};
    shaders::LcRatioConstants constants{};
    constants.range = 5;
    for (int i = 0; i < 8; ++i) {
        texels.ratio[i] = glm::vec4(1);
        constants.scale[i] = 4;
        constants.bias[i] = -2;
    }
    for (const vec3& c : shaders::lcLightMapRatio(texels, constants).c) EXPECT_EQ(c, vec3(0));
}

TEST(ShaderEnvironment, APlainCubemapIsItsTexelTimesTheRange) {
    EXPECT_EQ(shaders::lcPrefiltered(vec3(0.5f, 2, 0), 8), vec3(4, 16, 0));
    EXPECT_EQ(shaders::lcPrefiltered(vec3(0.5f, 2, 0), 8), shaders::lcEnvironment(vec3(4, 16, 0), vec3(1)));
}

TEST(ShaderRsrm, TexelCentresAndRowsAreWhereTheMapHasThem) {
    const vec3 axis(0, 1, 0);
    constexpr int width = 256;
    for (const int j : {0, 1, 100, 255}) {
        const float z = 1 - (2 * static_cast<float>(j) + 1) / width;
        const vec3 r(std::sqrt(1 - z * z), z, 0);
        EXPECT_NEAR(shaders::lcRsrmU(r, axis), (static_cast<float>(j) + 0.5f) / width, 1e-6f);
    }
    for (int row = 0; row < 8; ++row) EXPECT_NEAR(shaders::lcRsrmRow(std::pow(4.0f, static_cast<float>(row)), 1, 4), row, 1e-5f);
    EXPECT_EQ(shaders::lcRsrmUv(axis, axis, 100, 8), glm::vec2(0, 7.5f / 8));
    expectNear(shaders::lcRsrmBlend(vec3(1), vec3(3), 0.25f), vec3(1.5f), 1e-6f);
}

}  // namespace
}  // namespace lightcook

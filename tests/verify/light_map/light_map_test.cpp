#include "verify/light_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>
#include <random>
#include <tuple>

#include "compress/light_map.h"
#include "lighting/brdf.h"
#include "lighting/quadratic.h"
#include "lighting/radiometry.h"
#include "lighting/sphere.h"
#include "tests/compress/synthetic_light_map.h"
#include "tests/formats/light_map_layouts.h"
#include "tests/verify/cooked_light_map.h"
#include "verify/light_map/shading.h"

namespace lightcook {
namespace {

using formats::LightMapLayout;
using formats::Target;
using synthetic::Kind;

using test::kEveryLayout;
constexpr int kMapWidth = 46, kMapHeight = 38;

/// Returns true if the layout keeps band 2: sh4 and most of those of engines drop it.
bool keepsBand2(LightMapLayout layout) {
    return formats::info(layout).isFlat() || formats::info(layout).lacks.empty();
}

/// Returns true if the hardware filters the textures. decoded_filter_test.cpp has the other layouts.
bool isFiltered(const formats::LightMapLayoutInfo& layout) {
    return !layout.isAlwaysDecoded;
}

using test::Cooked;

Cooked cook(formats::LightMapStrip reference, LightMapLayout layout, Target target) {
    return test::cook(std::move(reference), layout, target, 3);
}
Cooked cook(Kind kind, LightMapLayout layout, Target target = Target::Bc) {
    return cook(synthetic::makeBand(kind, kMapWidth, 0, kMapHeight), layout, target);
}

lighting::ShDouble channelOf(const lighting::ShRgb& sh, int channel) {
    lighting::ShDouble out;
    for (std::size_t i = 0; i < sh.size(); ++i) out[i] = static_cast<double>(sh[i][channel]);
    return out;
}

double exitRadiance(const lighting::ShDouble& sh, const glm::dvec3& n) {
    const lighting::ShDouble basis = lighting::evaluateBasis(n);
    double sum = 0;
    for (std::size_t i = 0; i < sh.size(); ++i)
        sum += lighting::kExitRadianceBands[static_cast<std::size_t>(lighting::kShBand[i])] * sh[i] * basis[i];
    return sum;
}

/// Texels and reference at places between texels, filtered by the definition, arranged as a map of one row.
struct Filtered {
    Cooked row;
    std::vector<lighting::ShRgb> reference;
    formats::Image<lighting::ShRgb> decoded;
};
Filtered filterAt(const Cooked& cooked, int count, std::mt19937& random) {
    struct Place {
        int x, y;
        float u, v;
    };
    std::uniform_real_distribution<float> fraction(0, 1);
    std::vector<Place> places;
    while (places.size() < static_cast<std::size_t>(count)) {
        const int x = static_cast<int>(random() % static_cast<unsigned>(cooked.map.width - 1));
        const int y = static_cast<int>(random() % static_cast<unsigned>(cooked.map.height - 1));
        const auto covered = [&](int dx, int dy) { return cooked.reference.covered.at(x + dx, y + dy) != 0; };
        if (covered(0, 0) && covered(1, 0) && covered(0, 1) && covered(1, 1)) places.push_back({x, y, fraction(random), fraction(random)});
    }
    const auto blend = [](const auto& image, const Place& p, const auto& get) {
        return (1 - p.v) * ((1 - p.u) * get(image.at(p.x, p.y)) + p.u * get(image.at(p.x + 1, p.y))) +
               p.v * ((1 - p.u) * get(image.at(p.x, p.y + 1)) + p.u * get(image.at(p.x + 1, p.y + 1)));
    };
    Filtered out;
    out.row.map = cooked.map;
    out.row.map.width = count;
    out.row.map.height = 1;
    out.row.key = cooked.key;
    for (const auto& texture : cooked.texels.textures) {
        out.row.texels.textures.emplace_back();
        for (const auto& image : texture) {
            formats::Image<glm::vec4> row(count, 1);
            for (int i = 0; i < count; ++i)
                row.at(i, 0) = blend(image, places[static_cast<std::size_t>(i)], [](const glm::vec4& texel) { return texel; });
            out.row.texels.textures.back().push_back(std::move(row));
        }
    }
    for (const Place& place : places) {
        lighting::ShRgb sh;
        for (std::size_t i = 0; i < sh.size(); ++i)
            sh[i] = blend(cooked.reference.sh, place, [&](const lighting::ShRgb& texel) { return texel[i]; });
        out.reference.push_back(sh);
    }
    out.decoded = out.row.verifier().reconstruct(out.row.texels, 0, 1);
    return out;
}

TEST(LightMapVerifier, PlacesBetweenChartsAreNotJudged) {
    constexpr int kGap = 20;
    formats::LightMapStrip reference = synthetic::makeBand(Kind::Grey, kMapWidth, 0, kMapHeight);
    reference.chart = formats::Image<std::uint32_t>(kMapWidth, kMapHeight, 1);
    for (int y = 0; y < kMapHeight; ++y)
        for (int x = kGap; x < kMapWidth; ++x) reference.chart.at(x, y) = x == kGap ? formats::kNoChart : 2;
    for (int y = 0; y < kMapHeight; ++y) {
        reference.covered.at(kGap, y) = 0;
        reference.sh.at(kGap, y) = {};
    }
    Cooked cooked = cook(std::move(reference), LightMapLayout::Raw, Target::Float);
    for (auto& texture : cooked.texels.textures)
        for (auto& layer : texture)
            for (int y = 0; y < kMapHeight; ++y) layer.at(kGap, y) = glm::vec4(65504);
    const auto surface = [&] {
        return cooked.verifier().verifyRows(cooked.texels, cooked.reference, 0, kMapHeight).surface.diffuse.figures();
    };
    const verify::ErrorFigures apart = surface();
    EXPECT_LT(apart.relRms, 1e-3);
    EXPECT_LT(apart.maxBound, 0.1);
    for (int y = 0; y < kMapHeight; ++y) cooked.reference.chart.at(kGap, y) = 1;  // now the first chart ends at the texel's centre
    EXPECT_GT(surface().relRms, 0.1);
    for (int y = 0; y < kMapHeight; ++y) cooked.reference.chart.at(kGap, y) = formats::kAnyChart;
    EXPECT_GT(surface().relRms, 0.1);
    cooked.reference.chart = {};
    EXPECT_GT(surface().relRms, 0.1);
}

/// A map of layout "raw" under grey light, decoded without an error.
struct RawMap {
    formats::LightMapStrip reference;
    verify::CookedLightMap map{"raw", {{"range", {1.0f}}}};
    verify::DecodedLightMapRows texels;

    RawMap(int width, int height) {
        map.width = width;
        map.height = height;
        lighting::ShRgb grey{};
        grey[0] = glm::vec3(1);
        reference.sh = formats::Image<lighting::ShRgb>(width, height, grey);
        reference.covered = formats::Image<std::uint8_t>(width, height, 1);
        reference.normal = formats::Image<glm::vec3>(width, height, glm::vec3(0, 0, 1));
        auto& layers = texels.textures.emplace_back();
        for (std::size_t i = 0; i < lighting::kShCount; ++i) layers.emplace_back(width, height, glm::vec4(i == 0 ? 1 : 0));
    }
    /// Returns the figures of diffuse light on the surface.
    verify::ErrorFigures surface() const {
        verify::LightMapShading shading;
        shading.specular = false;
        verify::LightMapSampling sampling;
        sampling.placesPerTexel = 4;
        const auto verifier = verify::LightMapVerifier::create(map, shading, sampling, 1);
        return verifier->verifyRows(texels, reference, 0, map.height).surface.diffuse.figures();
    }
};

TEST(LightMapVerifier, ChartsOfOneRowOfTexelsAtTheEdgeOfTheMapAreBounded) {
    constexpr int kSide = 4;
    for (const int edge : {0, 1, 2, 3}) {
        RawMap raw(kSide, kSide);
        raw.reference.chart = formats::Image<std::uint32_t>(kSide, kSide, formats::kNoChart);
        for (int y = 0; y < kSide; ++y)
            for (int x = 0; x < kSide; ++x) {
                const bool isInside = (edge < 2 ? x : y) == (edge % 2 == 0 ? 0 : kSide - 1);
                raw.reference.covered.at(x, y) = isInside ? 1 : 0;
                if (isInside) raw.reference.chart.at(x, y) = 1;
                raw.texels.textures[0][0].at(x, y).x = (x + y) % 2 == 0 ? 1.0f : 1.2f;
            }
        const verify::ErrorFigures figures = raw.surface();
        EXPECT_GT(figures.maxSampled, 0.05) << edge;
        EXPECT_GE(figures.maxBound.value_or(0), figures.maxSampled) << edge;
    }
}

TEST(LightMapVerifier, TheBoundOfAMapOfOneRowIsReachedAtItsTexel) {
    for (const bool isColumn : {true, false}) {
        RawMap raw(isColumn ? 1 : 3, isColumn ? 3 : 1);
        raw.texels.textures[0][0].texels()[1].x = 1.2f;
        const verify::ErrorPlace place = raw.surface().boundAt;
        EXPECT_NEAR(place.x, isColumn ? 0 : 1, 1e-6);
        EXPECT_NEAR(place.y, isColumn ? 1 : 0, 1e-6);
        EXPECT_NEAR(place.found, 1.2 * place.reference, 1e-5);
    }
}

TEST(LightMapVerifierSoak, GreyStaysGreyThroughEveryLayoutFromItsBytes) {
    // Three directions do not show even light.
    for (const LightMapLayout layout : test::layoutsWhere([](const formats::LightMapLayoutInfo& row) { return !row.isInTangentSpace; }))
        for (const Target target : {Target::Bc, Target::Astc, Target::Float}) {
            Cooked cooked = cook(Kind::Grey, layout, target);
            // Texels of 8 bits have no 1/2: without constants, each component of L1 is off by 2 L0 / 255.
            const bool hasNoHalf = target == Target::Bc && (layout == LightMapLayout::MonoSh || layout == LightMapLayout::Bakery);
            // Halo 3's residual has no code for "nothing left", so that a root of L in 8 bits has to make up for it.
            const bool isHalo3 = layout == LightMapLayout::Halo3;
            const float most = 0.5e-3f + (hasNoHalf                            ? 0.5f * 2 * std::numbers::sqrt3_v<float> / 255
                                          : isHalo3 && target != Target::Float ? 0.5f / 255
                                                                               : 0.0f);
            const auto decoded = cooked.verifier().reconstruct(cooked.texels, 0, kMapHeight, 1, &cooked.reference);
            for (int y = 0; y < kMapHeight; ++y)
                for (int x = 0; x < kMapWidth; ++x)
                    for (int k = 0; k < 8; ++k) {
                        const glm::vec3 n(lighting::fibonacciSphere(k, 8));
                        const glm::vec3 exit = lighting::lambertExitRadiance(decoded.at(x, y), n, glm::vec3(1)).value;
                        for (int c = 0; c < 3; ++c)
                            ASSERT_NEAR(exit[c], 0.5f, most)
                                << cooked.map.layout << " target " << static_cast<int>(target) << " " << x << ", " << y;
                    }
            EXPECT_LT(cooked.idealTotal().diffuse.maxBound, 2 * most) << cooked.map.layout;
        }
}

TEST(LightMapVerifier, BlackStaysBlackWithoutError) {
    for (const LightMapLayout layout : kEveryLayout) {
        const Cooked cooked = cook(Kind::Black, layout);
        const auto decoded = cooked.verifier().reconstruct(cooked.texels, 0, kMapHeight, 1, &cooked.reference);
        for (const lighting::ShRgb& sh : decoded.texels())
            for (const glm::vec3& c : sh) ASSERT_EQ(c, glm::vec3(0));
        const verify::StageError total = cooked.total();
        EXPECT_EQ(total.diffuse.relRms, 0);
        constexpr double kRounding = 1e-15;
        EXPECT_LT(total.diffuse.maxBound, kRounding);
        EXPECT_LT(total.specular.maxBound, kRounding);
    }
}

TEST(LightMapVerifier, FiguresAreThoseOfABruteForceInDouble) {
    const Cooked cooked = cook(Kind::Gradient, LightMapLayout::Ratio);
    const auto decoded = cooked.verifier().reconstruct(cooked.texels, 0, kMapHeight, 1, &cooked.reference);
    const std::vector<verify::StageError> stages = cooked.stages();
    struct Sum {
        double error = 0, reference = 0, largest = 0;
        std::vector<double> local;
        void add(double r, double value, double key) {
            error += (value - r) * (value - r);
            reference += r * r;
            local.push_back(std::abs(value - r) / (std::abs(r) + lighting::kLocalErrorFloor * key));
        }
        double rms() const { return std::sqrt(error / reference); }
        double p99() {
            std::ranges::sort(local);
            return local[local.size() * 99 / 100];
        }
    } diffuse, specular;
    std::vector<std::pair<glm::dvec3, lighting::ShDouble>> kernels;  // view, nine factors in the view's frame
    for (int k = 0; k < 8; ++k)
        for (const double m : {0.1, 0.25, 0.5}) {
            const glm::dvec3 view = lighting::fibonacciHemisphere(k, 8);
            const auto kernel = lighting::integrateAreaSpecular(view.z, m, lighting::NormalDistribution::Beckmann,
                                                                lighting::CookTorranceNormalization::Energy, 256);
            for (const double f0 : {0.04, 0.6}) {
                lighting::ShDouble sum;
                for (std::size_t i = 0; i < sum.size(); ++i) sum[i] = f0 * kernel.c[i] + (1 - f0) * kernel.d[i];
                kernels.emplace_back(view, sum);
            }
        }
    for (int y = 0; y < kMapHeight; ++y)
        for (int x = 0; x < kMapWidth; ++x) {
            if (cooked.reference.covered.at(x, y) == 0) continue;
            const glm::dvec3 normal(cooked.reference.normal.at(x, y));
            const glm::dmat3 world = lighting::worldFromTangentFrame(normal);
            for (int c = 0; c < 3; ++c) {
                const lighting::ShDouble r = channelOf(cooked.reference.sh.at(x, y), c), d = channelOf(decoded.at(x, y), c);
                for (int k = 0; k < 32; ++k) {
                    const glm::dvec3 n = world * lighting::fibonacciHemisphere(k, 32);
                    diffuse.add(exitRadiance(r, n), exitRadiance(d, n), cooked.key);
                }
                for (const auto& [view, kernel] : kernels) {
                    // The frame whose x-z plane contains the view.
                    const glm::dvec3 worldView = world * view;
                    const glm::dvec3 tangent = glm::normalize(worldView - glm::dot(worldView, normal) * normal);
                    const glm::dmat3 frame(tangent, glm::cross(normal, tangent), normal);
                    const lighting::ShRotation toFrame(glm::transpose(frame));
                    const lighting::ShDouble localR = toFrame.apply(r), localD = toFrame.apply(d);
                    double sumR = 0, sumD = 0;
                    for (std::size_t i = 0; i < kernel.size(); ++i) {
                        sumR += kernel[i] * localR[i];
                        sumD += kernel[i] * localD[i];
                    }
                    specular.add(sumR, sumD, cooked.key);
                }
            }
        }
    const verify::StageError& final = stages[stages.size() - 2];
    ASSERT_EQ(final.name, "ratio");
    EXPECT_NEAR(final.diffuse.relRms, diffuse.rms(), 1e-3 * diffuse.rms());
    EXPECT_NEAR(final.diffuse.p99, diffuse.p99(), 0.01 * diffuse.p99());
    EXPECT_NEAR(final.diffuse.maxSampled, diffuse.local.back(), 1e-3 * diffuse.local.back());
    EXPECT_NEAR(final.specular.relRms, specular.rms(), 2e-3 * specular.rms());
    EXPECT_NEAR(final.specular.p99, specular.p99(), 0.01 * specular.p99());
    ASSERT_TRUE(stages.back().atTexels);
    EXPECT_EQ(stages.back().atTexels->diffuse.relRms, final.diffuse.relRms);
}

/// Returns light shaded for a place: with its normal, or with its material and view.
double shadedAs(const verify::ErrorPlace& place, const lighting::ShDouble& light) {
    if (place.view == glm::dvec3(0)) return exitRadiance(light, place.normal);
    const auto kernel = lighting::integrateAreaSpecular(glm::dot(place.view, place.normal), place.m, lighting::NormalDistribution::Beckmann,
                                                        lighting::CookTorranceNormalization::Energy, 256);
    const glm::dvec3 tangent = glm::normalize(place.view - glm::dot(place.view, place.normal) * place.normal);
    const lighting::ShDouble local =
        lighting::ShRotation(glm::transpose(glm::dmat3(tangent, glm::cross(place.normal, tangent), place.normal))).apply(light);
    double sum = 0;
    for (std::size_t i = 0; i < local.size(); ++i) sum += (place.f0 * kernel.c[i] + (1 - place.f0) * kernel.d[i]) * local[i];
    return sum;
}

TEST(LightMapVerifier, TheWorstSampleIsFoundAgainAtItsPlace) {
    for (const LightMapLayout layout : {LightMapLayout::Halo3, LightMapLayout::Basis4, LightMapLayout::Flat}) {
        const Cooked cooked = cook(Kind::Gradient, layout);
        const auto decoded = cooked.verifier().reconstruct(cooked.texels, 0, kMapHeight, 1, &cooked.reference);
        const std::vector<verify::StageError> stages = cooked.stages();
        const verify::StageError& last = stages[stages.size() - 2];
        for (const verify::ErrorFigures* figures : {&last.diffuse, &last.specular}) {
            const verify::ErrorPlace& place = figures->sampledAt;
            ASSERT_TRUE(place.isKnown()) << cooked.map.layout;
            EXPECT_EQ(place.local, figures->maxSampled);
            EXPECT_NEAR(glm::length(place.normal), 1, 1e-6);
            const int x = static_cast<int>(place.x), y = static_cast<int>(place.y);
            const lighting::ShDouble light = channelOf(cooked.reference.sh.at(x, y), *place.channel);
            const double reference = shadedAs(place, light), found = shadedAs(place, channelOf(decoded.at(x, y), *place.channel));
            EXPECT_NEAR(place.reference, reference, 1e-3 * std::abs(reference) + 1e-5 * cooked.key) << cooked.map.layout;
            EXPECT_NEAR(place.found, found, 1e-3 * std::abs(reference) + 1e-5 * cooked.key) << cooked.map.layout;
            EXPECT_NEAR(std::abs(place.found - place.reference), place.allowed(place.local, cooked.key), 1e-4 * cooked.key);
        }
        // Between texels: from the filtered texels of a quad.
        const verify::ErrorPlace between =
            cooked.verifier().verifyRows(cooked.texels, cooked.reference, 0, kMapHeight).surface.diffuse.figures().sampledAt;
        EXPECT_TRUE(between.x != std::floor(between.x) || between.y != std::floor(between.y));
        EXPECT_LE(between.local, stages.back().diffuse.maxSampled);
    }
}

TEST(LightMapVerifier, TheWorstBoundOfATexelIsReachedAtItsPlace) {
    Cooked cooked = cook(Kind::Gradient, LightMapLayout::Halo3);
    cooked.map.formats.clear();  // an ideal sampler: the bound is exact if the reference is not negative
    const auto decoded = cooked.verifier().reconstruct(cooked.texels, 0, kMapHeight, 1, &cooked.reference);
    const std::vector<verify::StageError> stages = cooked.stages();
    const verify::ErrorFigures& last = stages[stages.size() - 2].diffuse;
    const verify::ErrorPlace& place = last.boundAt;
    ASSERT_TRUE(place.isKnown());
    EXPECT_EQ(place.local, last.maxBound);
    const int x = static_cast<int>(place.x), y = static_cast<int>(place.y);
    const double reference = exitRadiance(channelOf(cooked.reference.sh.at(x, y), *place.channel), place.normal),
                 found = exitRadiance(channelOf(decoded.at(x, y), *place.channel), place.normal);
    EXPECT_NEAR(std::abs(found - reference) / (std::abs(reference) + lighting::kLocalErrorFloor * cooked.key), *last.maxBound,
                1e-3 * *last.maxBound);
    EXPECT_NEAR(place.reference, reference, 1e-4 * cooked.key);
    EXPECT_NEAR(place.found, found, 1e-4 * cooked.key);
    // A bound of a quad: inside the quad, or on its edge. It is that of boundQuad(), or above it where a budget of work was spent.
    const verify::ErrorPlace& between = stages.back().diffuse.boundAt;
    EXPECT_EQ(between.local, stages.back().diffuse.maxBound);
    EXPECT_NEAR(glm::length(between.normal), 1, 1e-9);
    const verify::LightMapVerifier verifier = cooked.verifier();
    bool isFound = false;
    for (int dy = 0; dy < 2; ++dy)
        for (int dx = 0; dx < 2; ++dx) {
            const int left = static_cast<int>(std::ceil(between.x)) - dx, top = static_cast<int>(std::ceil(between.y)) - dy;
            if (left < kMapWidth && top < kMapHeight)
                isFound = isFound || verifier.boundQuad(cooked.texels, cooked.reference, left, top).diffuse <= between.local;
        }
    EXPECT_TRUE(isFound);
}

/// The light that is reported beside a bound between texels is that of the filtered textures there.
TEST(LightMapVerifier, TheLightOfABoundIsWhatTheTexturesDecodeToThere) {
    for (const LightMapLayout layout : test::layoutsWhere(isFiltered)) {
        const Cooked cooked = cook(Kind::Gradient, layout);
        const auto stages = cooked.stages();
        const verify::ErrorPlace& place = stages.back().diffuse.boundAt;
        ASSERT_TRUE(place.isKnown()) << cooked.map.layout;
        const int x = std::min(static_cast<int>(place.x), kMapWidth - 2), y = std::min(static_cast<int>(place.y), kMapHeight - 2);
        const double u = place.x - x, v = place.y - y;
        // A map of one place: every texel holds the filtered texels, so that reconstruct decodes them.
        verify::DecodedLightMapRows filtered;
        for (const auto& texture : cooked.texels.textures) {
            filtered.textures.emplace_back();
            for (const formats::Image<glm::vec4>& image : texture) {
                const glm::vec4 above = glm::mix(image.at(x, y), image.at(x + 1, y), static_cast<float>(u));
                const glm::vec4 below = glm::mix(image.at(x, y + 1), image.at(x + 1, y + 1), static_cast<float>(u));
                filtered.textures.back().emplace_back(kMapWidth, kMapHeight, glm::mix(above, below, static_cast<float>(v)));
            }
        }
        const auto decoded = cooked.verifier().reconstruct(filtered, 0, kMapHeight, 1, &cooked.reference);
        const lighting::ShRgb& seen = decoded.at(x + (u > 0.5 ? 1 : 0), y + (v > 0.5 ? 1 : 0));
        const double found = exitRadiance(channelOf(seen, *place.channel), place.normal);
        EXPECT_NEAR(place.found, found, 1e-4 * std::abs(found) + 1e-5 * cooked.key) << cooked.map.layout;
        double reference = 0, weights = 0;
        for (int corner = 0; corner < 4; ++corner) {
            if (cooked.reference.covered.at(x + corner % 2, y + corner / 2) == 0) continue;
            const double weight = (corner % 2 == 0 ? 1 - u : u) * (corner / 2 == 0 ? 1 - v : v);
            weights += weight;
            reference +=
                weight * exitRadiance(channelOf(cooked.reference.sh.at(x + corner % 2, y + corner / 2), *place.channel), place.normal);
        }
        reference /= weights;
        EXPECT_NEAR(place.reference, reference, 1e-4 * std::abs(reference) + 1e-5 * cooked.key) << cooked.map.layout;
        EXPECT_LE(std::abs(place.found - place.reference), place.allowed(place.local, cooked.key) * (1 + 1e-6)) << cooked.map.layout;
    }
}

TEST(LightMapVerifier, NoSampledShadingExceedsTheBound) {
    std::mt19937 random(11);
    std::normal_distribution<double> normal;
    constexpr int places = 4000, normals = 25;
    for (const Kind kind : {Kind::Gradient, Kind::Spikes, Kind::NegativeBands, Kind::Night})
        for (const LightMapLayout layout : test::layoutsWhere([](const formats::LightMapLayoutInfo& row) {
                 return isFiltered(row) && !row.isFlat() && !row.isLearned() && !row.isInTangentSpace;
             })) {
            const Cooked cooked = cook(kind, layout);
            const verify::StageError total = cooked.total();
            const Filtered filtered = filterAt(cooked, places, random);
            double worst = 0;
            for (int i = 0; i < places; ++i)
                for (int k = 0; k < normals; ++k) {
                    const glm::dvec3 n = glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
                    for (int c = 0; c < 3; ++c) {
                        const double r = exitRadiance(channelOf(filtered.reference[static_cast<std::size_t>(i)], c), n);
                        const double d = exitRadiance(channelOf(filtered.decoded.at(i, 0), c), n);
                        worst = std::max(worst, std::abs(d - r) / (std::abs(r) + lighting::kLocalErrorFloor * cooked.key));
                    }
                }
            EXPECT_LE(worst, total.diffuse.maxBound) << cooked.map.layout << ", kind " << static_cast<int>(kind);
            EXPECT_LE(total.diffuse.maxSampled, total.diffuse.maxBound) << cooked.map.layout;
            EXPECT_LE(total.specular.maxSampled, total.specular.maxBound) << cooked.map.layout;
            EXPECT_TRUE(std::isfinite(*total.diffuse.maxBound));
        }
}

TEST(LightMapVerifier, NoMaterialInTheRangeExceedsTheSpecularBound) {
    std::mt19937 random(5);
    std::normal_distribution<double> gauss;
    std::uniform_real_distribution<double> uniform(0, 1);
    const Cooked cooked = cook(Kind::Gradient, LightMapLayout::Halo3);
    const double bound = *cooked.total().specular.maxBound;
    const Filtered filtered = filterAt(cooked, 200, random);
    for (int material = 0; material < 40; ++material) {
        const double m = 0.1 + 0.4 * uniform(random), f0 = 0.04 + 0.56 * uniform(random), NoV = std::max(1e-3, uniform(random));
        const auto kernel = lighting::integrateAreaSpecular(NoV, m, lighting::NormalDistribution::Beckmann,
                                                            lighting::CookTorranceNormalization::Energy, 96);
        for (int i = 0; i < 200; ++i) {
            const glm::dvec3 axis = glm::normalize(glm::dvec3(gauss(random), gauss(random), gauss(random)));
            const lighting::ShRotation turn(lighting::worldFromTangentFrame(axis));
            for (int c = 0; c < 3; ++c) {
                const lighting::ShDouble r = turn.apply(channelOf(filtered.reference[static_cast<std::size_t>(i)], c));
                const lighting::ShDouble d = turn.apply(channelOf(filtered.decoded.at(i, 0), c));
                double reference = 0, error = 0;
                for (std::size_t k = 0; k < r.size(); ++k) {
                    const double t = f0 * kernel.c[k] + (1 - f0) * kernel.d[k];
                    reference += t * r[k];
                    error += t * (d[k] - r[k]);
                }
                ASSERT_LE(std::abs(error) / (std::abs(reference) + lighting::kLocalErrorFloor * cooked.key), bound);
            }
        }
    }
}

TEST(SpecularResponses, HoldEveryKernelAndAreNotFarAboveIt) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(0, 1);
    std::normal_distribution<double> gauss;
    const std::vector<std::pair<double, double>> ranges = {{0.1, 0.5}, {0.25, 0.25}, {0.02, 1.0}};
    for (const auto& [low, high] : ranges)
        for (const double lowF0 : {0.04, 0.0}) {
            verify::LightMapShading shading;
            shading.m = {high, low};
            shading.f0 = {lowF0, 0.9};
            const std::vector<verify::Response> responses = verify::specularResponses(shading, verify::ScannedKernels(shading));
            std::vector<lighting::ShDouble> kernels;
            for (int i = 0; i < 150; ++i) {
                const double m = low * std::pow(high / low, uniform(random)),
                             f0 = lowF0 + (0.9 - lowF0) * std::max(0.0, uniform(random) * 1.4 - 0.2);
                const double NoV = i % 5 == 0 ? 1e-3 + 0.01 * uniform(random) : std::max(1e-3, std::pow(uniform(random), 2.0));
                const auto kernel = lighting::integrateAreaSpecular(NoV, m, lighting::NormalDistribution::Beckmann,
                                                                    lighting::CookTorranceNormalization::Energy, 128);
                kernels.emplace_back();
                for (std::size_t k = 0; k < kernel.c.size(); ++k)
                    kernels.back()[k] = std::min(f0, 0.9) * kernel.c[k] + (1 - std::min(f0, 0.9)) * kernel.d[k];
            }
            double nearest = 0;
            for (int i = 0; i < 60; ++i) {
                lighting::ShDouble light{};
                for (std::size_t k = 0; k < light.size(); ++k) light[k] = (k == 0 ? 3 : 1) * gauss(random);
                lighting::Sh single;
                std::ranges::copy(light, single.begin());
                double most = 0;
                for (const verify::Response& response : responses)
                    most = std::max(most, lighting::extremaOnSphere(lighting::sphereQuadratic(light, response.bands)).maximum +
                                              verify::bandSum(lighting::bandLengths(single), response.residual));
                double sampled = 0;
                for (int frame = 0; frame < 200; ++frame) {
                    const glm::dvec3 normal = glm::normalize(glm::dvec3(gauss(random), gauss(random), gauss(random)));
                    const glm::dvec3 tangent = glm::normalize(glm::cross(normal, glm::dvec3(gauss(random), gauss(random), gauss(random))));
                    const lighting::ShDouble local =
                        lighting::ShRotation(glm::transpose(glm::dmat3(tangent, glm::cross(normal, tangent), normal))).apply(light);
                    for (const lighting::ShDouble& kernel : kernels) {
                        double sum = 0;
                        for (std::size_t k = 0; k < kernel.size(); ++k) sum += kernel[k] * local[k];
                        sampled = std::max(sampled, sum);
                    }
                }
                ASSERT_LE(sampled, most * (1 + 1e-6)) << "m " << low << " to " << high;
                nearest = std::max(nearest, sampled / most);
            }
            EXPECT_GT(nearest, 0.85);
        }
}

/// Bounds are proven in any cut, but a strip whose budget of work is spent has a looser one.
TEST(LightMapVerifier, StripsInAnyCutGiveTheSameFigures) {
    for (const LightMapLayout layout : kEveryLayout) {
        const Cooked cooked = cook(Kind::Gradient, layout);
        const verify::LightMapVerifier verifier = cooked.verifier();
        const std::vector<verify::StageError> whole = cooked.stages();
        verify::LightMapErrors merged = verifier.noErrors();
        for (int row = 0; row < kMapHeight; row += 9) {
            const int count = std::min(9, kMapHeight - row);
            const formats::LightMapStrip band = synthetic::makeBandWithContext(Kind::Gradient, kMapWidth, kMapHeight, row, count, 1);
            merged.merge(verifier.verifyRows(cooked.texels, band, row, count));
        }
        const std::vector<verify::StageError> parts = merged.figures();
        ASSERT_EQ(parts.size(), whole.size());
        for (std::size_t i = 0; i < parts.size(); ++i) {
            EXPECT_EQ(parts[i].name, whole[i].name);
            EXPECT_NEAR(parts[i].diffuse.relRms, whole[i].diffuse.relRms, 1e-12 * whole[i].diffuse.relRms);  // sums in another order
            EXPECT_EQ(parts[i].diffuse.p99, whole[i].diffuse.p99);
            EXPECT_EQ(parts[i].diffuse.maxSampled, whole[i].diffuse.maxSampled);
            EXPECT_GE(parts[i].diffuse.maxBound, parts[i].diffuse.maxSampled);
            EXPECT_EQ(parts[i].specular.maxSampled, whole[i].specular.maxSampled);
            EXPECT_GE(parts[i].specular.maxBound, parts[i].specular.maxSampled);
            const auto isSame = [](const verify::ErrorPlace& a, const verify::ErrorPlace& place) {
                return std::tie(a.x, a.y, a.channel, a.normal, a.view, a.m, a.f0, a.reference, a.found, a.local) ==
                       std::tie(place.x, place.y, place.channel, place.normal, place.view, place.m, place.f0, place.reference, place.found,
                                place.local);
            };
            EXPECT_TRUE(isSame(parts[i].diffuse.sampledAt, whole[i].diffuse.sampledAt)) << whole[i].name;
            EXPECT_TRUE(isSame(parts[i].specular.sampledAt, whole[i].specular.sampledAt)) << whole[i].name;
        }
    }
}

TEST(LightMapVerifier, EachLayerOfTheResidualReducesTheError) {
    const std::vector<verify::StageError> stages = cook(Kind::Gradient, LightMapLayout::Basis16).stages();
    ASSERT_EQ(stages.size(), 6u);
    EXPECT_EQ(stages[0].name, "l0");
    EXPECT_EQ(stages[1].name, "code");
    EXPECT_EQ(stages[2].name, "residual 1");
    EXPECT_EQ(stages[3].name, "residual 2");
    EXPECT_EQ(stages[4].name, "residual 3");
    for (std::size_t stage = 2; stage < 5; ++stage) {
        EXPECT_LT(stages[stage].diffuse.relRms, 0.9 * stages[stage - 1].diffuse.relRms) << stages[stage].name;
        EXPECT_LT(stages[stage].specular.relRms, 0.9 * stages[stage - 1].specular.relRms) << stages[stage].name;
    }
}

TEST(LightMapVerifier, DroppingTheResidualGivesTheShorterLayout) {
    // Earlier stages do not depend on later ones: basis-12 without its residual equals basis-4, to the last bit.
    const std::vector<verify::StageError> whole = cook(Kind::Gradient, LightMapLayout::Basis12).stages();
    const std::vector<verify::StageError> code = cook(Kind::Gradient, LightMapLayout::Basis4).stages();
    EXPECT_EQ(whole[1].diffuse.relRms, code[1].diffuse.relRms);
    EXPECT_EQ(whole[1].specular.p99, code[1].specular.p99);
}

TEST(LightMapVerifier, RefusesBrokenTables) {
    const Cooked good = cook(Kind::Gradient, LightMapLayout::Basis8);
    const auto refused = [&](const char* name, std::vector<float> values) {
        verify::CookedLightMap map = good.map;
        map.constants[name] = std::move(values);
        const auto created = verify::LightMapVerifier::create(map, {}, {}, good.key);
        return !created && created.error().line().find(name) != std::string::npos;
    };
    EXPECT_TRUE(refused("clusters", {0}));
    EXPECT_TRUE(refused("clusters", {1.5f}));
    EXPECT_TRUE(refused("clusters", {1e9f}));
    EXPECT_TRUE(refused("code", {1, 2, 3}));
    EXPECT_TRUE(refused("residual", {}));
    EXPECT_TRUE(refused("index_runs", {}));
    EXPECT_TRUE(refused("index_runs", {0, 5}));
    EXPECT_TRUE(refused("index_runs", {0, 1e9f}));
    EXPECT_TRUE(refused("index_runs", {200, 120}));
    EXPECT_TRUE(refused("index_runs", {-1, 120}));
    EXPECT_TRUE(refused("index_runs", {0, std::numeric_limits<float>::quiet_NaN()}));
}

TEST(LightMapVerifier, TheSecondStageOfHdr2ReducesTheErrorOfTheFirst) {
    for (const Kind kind : {Kind::Gradient, Kind::Spikes, Kind::Night}) {
        const std::vector<verify::StageError> stages = cook(kind, LightMapLayout::Hdr2).stages();
        ASSERT_EQ(stages.size(), 3u);
        EXPECT_EQ(stages[0].name, "stage 1");
        EXPECT_EQ(stages[1].name, "stage 2");
        EXPECT_EQ(stages[2].name, "total");
        // A spike of 65504 spoils both stages in its block.
        const double factor = kind == Kind::Spikes ? 0.8 : 0.5;
        EXPECT_LT(stages[1].diffuse.relRms, factor * stages[0].diffuse.relRms) << static_cast<int>(kind);
        EXPECT_LT(stages[0].diffuse.relRms, 0.2);
    }
}

/// An engine has the constants of Halo 3 in its shader but for the ranges: the manifest need not say them.
TEST(LightMapVerifier, Halo3HasRangesAlone) {
    const Cooked cooked = cook(Kind::Gradient, LightMapLayout::Halo3);
    EXPECT_EQ(cooked.map.constants.size(), 1u);
    EXPECT_EQ(cooked.map.constants.at("range").size(), 9u);
    EXPECT_LT(cooked.total().diffuse.relRms, 0.03);
}

/// The decode of Halo 3 in the words of its talk, written again: L is the product of both alphas.
TEST(LightMapVerifier, Halo3IsDecodedByTheFormulaOfItsTalk) {
    const Cooked cooked = cook(Kind::Gradient, LightMapLayout::Halo3);
    const auto decoded = cooked.verifier().reconstruct(cooked.texels, 0, kMapHeight, 1, &cooked.reference);
    const auto& textures = cooked.texels.textures;
    const std::vector<float>& range = cooked.map.constants.at("range");
    for (int y = 0; y < kMapHeight; ++y)
        for (int x = 0; x < kMapWidth; ++x)
            for (std::size_t i = 0; i < 9; ++i) {
                const glm::dvec4 first(textures[0][i].at(x, y)), second(textures[1][i].at(x, y));
                for (int c = 0; c < 3; ++c) {
                    const double uvw = 2 * first[c] - 1 + 2 * second[c] - 1, length = static_cast<double>(range[i]) * first.w * second.w;
                    ASSERT_NEAR(static_cast<double>(decoded.at(x, y)[i][c]), length * uvw, 1e-5 * static_cast<double>(range[i]));
                }
            }
}

/// The decode of Unreal in the words of its shader, written again, and its constants: ranges of the map.
TEST(LightMapVerifier, UnrealHqIsDecodedByTheFormulaOfItsShader) {
    const Cooked cooked = cook(Kind::Gradient, LightMapLayout::UnrealHq);
    const auto decoded = cooked.verifier().reconstruct(cooked.texels, 0, kMapHeight, 1, &cooked.reference);
    const auto& textures = cooked.texels.textures;
    const auto constant = [&](const char* name) {
        const std::vector<float>& v = cooked.map.constants.at(name);
        EXPECT_EQ(v.size(), 4u) << name;
        return glm::dvec4(v[0], v[1], v[2], v[3]);
    };
    const glm::dvec4 scale0 = constant("scale0"), add0 = constant("add0"), scale1 = constant("scale1"), add1 = constant("add1");
    EXPECT_EQ(cooked.map.constants.size(), 4u);
    EXPECT_EQ(scale1.w, 0);
    EXPECT_NEAR(add1.w, 0.282095, 1e-6);
    for (int y = 0; y < kMapHeight; ++y)
        for (int x = 0; x < kMapWidth; ++x) {
            const glm::dvec4 first(textures[0][0].at(x, y)), second(textures[1][0].at(x, y));
            const double l = std::exp2((first.w + second.w / 255 - 0.5 / 255) * scale0.w + add0.w) - 0.01858136;
            const glm::dvec3 uvw = glm::dvec3(first) * glm::dvec3(first) * glm::dvec3(scale0) + glm::dvec3(add0);
            const glm::dvec4 sh = second * scale1 + add1;
            for (int k = 0; k < 6; ++k) {
                const glm::dvec3 n = lighting::fibonacciSphere(k, 6);
                const double along = sh.x * n.y + sh.y * n.z + sh.z * n.x + sh.w;
                for (int c = 0; c < 3; ++c)
                    ASSERT_NEAR(exitRadiance(channelOf(decoded.at(x, y), c), n), l * along * uvw[c], 1e-5 * std::abs(l) * uvw[c] + 1e-7);
            }
        }
}

TEST(LightMapVerifier, ConstantsOfUnrealHqAreFourFiniteNumbersEach) {
    const Cooked good = cook(Kind::Gradient, LightMapLayout::UnrealHq);
    const auto refused = [&](const char* name, std::vector<float> values) {
        verify::CookedLightMap map = good.map;
        if (values.empty())
            map.constants.erase(name);
        else
            map.constants[name] = std::move(values);
        const auto created = verify::LightMapVerifier::create(map, {}, {}, good.key);
        return !created && created.error().line().find(std::string("constant ") + name) != std::string::npos;
    };
    for (const char* name : {"scale0", "add0", "scale1", "add1"}) {
        EXPECT_FALSE(refused(name, good.map.constants.at(name)));
        EXPECT_TRUE(refused(name, {}));
        EXPECT_TRUE(refused(name, {1, 2, 3}));
        EXPECT_TRUE(refused(name, {1, 2, 3, std::numeric_limits<float>::infinity()}));
    }
}

/// The bound of a quad must not depend on how much of its curvature is left when it is no longer split: a quad of smooth light in which the
/// luminance rises by a hundred is bounded near what its places show.
TEST(LightMapVerifier, TheCurvatureOfUnrealHqIsSplitUntilItHardlyCounts) {
    formats::LightMapStrip band = synthetic::makeBand(Kind::Grey, kMapWidth, 0, kMapHeight);
    for (int y = 0; y < kMapHeight; ++y)
        for (int x = 0; x < kMapWidth; ++x) band.sh.at(x, y) = synthetic::constantLight(glm::vec3(x < kMapWidth / 2 ? 1.0f : 100.0f));
    Cooked cooked = cook(std::move(band), LightMapLayout::UnrealHq, Target::Float);
    std::fill(cooked.reference.covered.texels().begin(), cooked.reference.covered.texels().end(), std::uint8_t{1});
    cooked.map.formats.clear();
    const verify::LightMapVerifier verifier = cooked.verifier();
    const int x = kMapWidth / 2 - 1, y = kMapHeight / 2;
    const double bound = verifier.boundQuad(cooked.texels, cooked.reference, x, y).diffuse;
    const auto fine = verifier.reconstruct(cooked.texels, 0, kMapHeight, 16);
    double worst = 0;
    for (int i = 0; i < 16; ++i) {
        const double u = (i + 0.5) / 16, reference = (1 - u) + 100 * u;
        const double found = exitRadiance(channelOf(fine.at(16 * x + 8 + i, 16 * y + 8), 1), glm::dvec3(0, 0, 1));
        worst = std::max(worst, std::abs(found - reference) / (reference + lighting::kLocalErrorFloor * cooked.key));
    }
    EXPECT_GT(worst, 0.3) << "between the texels the light is nearer to their geometric mean";
    EXPECT_GE(bound, worst);
    EXPECT_LE(bound, 1.2 * worst);
}

TEST(LightMapVerifier, ColumnsOfAReconstructionAreThoseOfTheWhole) {
    const Cooked cooked = cook(Kind::Gradient, LightMapLayout::Ratio);
    const verify::LightMapVerifier verifier = cooked.verifier();
    const std::vector<int> columns = {17, 0, 2 * kMapWidth - 1, 5};
    const auto whole = verifier.reconstruct(cooked.texels, 4, 3, 2),
               some = verifier.reconstructColumns(cooked.texels, 4, 3, 2, nullptr, columns);
    ASSERT_EQ(some.width(), 4);
    ASSERT_EQ(some.height(), whole.height());
    for (int y = 0; y < some.height(); ++y)
        for (int x = 0; x < some.width(); ++x) EXPECT_EQ(some.at(x, y), whole.at(columns[static_cast<std::size_t>(x)], y));
}

/// The second alpha holds what rounding took from the first one: without it the luminance is coarser by far.
TEST(LightMapVerifier, TheSecondAlphaOfUnrealHqRefinesTheFirst) {
    Cooked cooked = cook(Kind::Gradient, LightMapLayout::UnrealHq);
    const double with = cooked.idealTotal().diffuse.relRms;
    for (glm::vec4& texel : cooked.texels.textures[1][0].texels()) texel.w = 0.5f;
    EXPECT_GT(cooked.idealTotal().diffuse.relRms, with);
}

TEST(LightMapVerifierSoak, FloatTargetsAreFarMoreExactThanBlocks) {
    for (const LightMapLayout layout : kEveryLayout) {
        // A flat map is exact for what it holds: the texel's own normal.
        verify::LightMapShading shading;
        if (formats::info(layout).isFlat()) {
            shading.specular = false;
            shading.normalCount = 1;
        }
        const auto errorOf = [&](Target target) { return cook(Kind::Gradient, layout, target).stages(shading).back().diffuse.relRms; };
        const double floats = errorOf(Target::Float);
        // For two light sources and a sky, band 2 is not zero: an error of the layout in any format, which blocks may
        // change a little either way. So is that of texels which share their ratios.
        const auto isOfOneTexel = [](const formats::LightMapTextureInfo& texture) { return texture.side == 1; };
        if (keepsBand2(layout) && std::ranges::all_of(formats::info(layout).textures, isOfOneTexel)) {
            EXPECT_LT(floats, 1e-3) << formats::info(layout).name;
        }
        EXPECT_LE(floats, (keepsBand2(layout) ? 1 : 1.001) * errorOf(Target::Bc)) << formats::info(layout).name;
    }
}

TEST(LightMapVerifierSoak, NightIsCookedAsWellAsDay) {
    // Ranges follow the map: only the unit differs, so the errors must be equal. Scaling by a power of two does not change rounding.
    for (const LightMapLayout layout : kEveryLayout) {
        const std::string_view name = formats::info(layout).name;
        // Engines have a unit of their own: at night their halves are subnormal.
        const double rounding = formats::info(layout).isForEngine ? 0.02 : 1e-6;
        const verify::StageError day = cook(Kind::Gradient, layout).total(), night = cook(Kind::Night, layout).total();
        for (const float scale : {0x1p-17f, 0x1p9f}) {
            formats::LightMapStrip band = synthetic::makeBand(Kind::Gradient, kMapWidth, 0, kMapHeight);
            for (lighting::ShRgb& sh : band.sh.texels())
                for (glm::vec3& coefficient : sh) coefficient *= scale;
            const verify::StageError scaled = cook(std::move(band), layout, Target::Bc).total();
            EXPECT_NEAR(scaled.diffuse.relRms, day.diffuse.relRms, rounding * day.diffuse.relRms) << name << ' ' << scale;
            EXPECT_NEAR(scaled.diffuse.p99, day.diffuse.p99, rounding * day.diffuse.p99) << name << ' ' << scale;
        }
        // For learned layouts, another rounding of coefficient 0 leads the fit of this small map to another optimum: 0.22 or 0.30 %.
        const double share = formats::info(layout).isLearned() ? 0.5 : 0.1;
        EXPECT_NEAR(night.diffuse.relRms, day.diffuse.relRms, share * day.diffuse.relRms) << name;
        EXPECT_NEAR(night.diffuse.p99, day.diffuse.p99, share * day.diffuse.p99) << name;
    }
}

TEST(LightMapVerifier, ALinearLayoutIsRightBetweenTexelsAtHardEdges) {
    const auto surfaceError = [](LightMapLayout layout) {
        formats::LightMapStrip band = synthetic::makeBand(Kind::Gradient, kMapWidth, 0, kMapHeight);
        for (int y = 0; y < kMapHeight; ++y)
            for (int x = 0; x < kMapWidth / 2; ++x) {
                lighting::ShRgb& sh = band.sh.at(x, y);
                for (glm::vec3& coefficient : sh) coefficient *= 100.0f;
                for (int i = 1; i < 4; ++i) std::swap(sh[static_cast<std::size_t>(i)], sh[static_cast<std::size_t>(i % 3 + 1)]);
            }
        return cook(std::move(band), layout, Target::Float).total().diffuse;
    };
    // Raw errs at the rims of charts alone, where the filter reads padded texels.
    const verify::ErrorFigures raw = surfaceError(LightMapLayout::Raw), hdr = surfaceError(LightMapLayout::Hdr),
                               ratio = surfaceError(LightMapLayout::Ratio);
    EXPECT_NEAR(hdr.relRms, raw.relRms, 1e-3 * raw.relRms + 1e-4);
    EXPECT_GT(ratio.relRms, 2 * hdr.relRms);
    EXPECT_GT(ratio.p99, 5 * hdr.p99);
}

/// A step of RGB9E5 is at most 1/256 of the brightest channel of the texel, which holds at most the range of ratios times coefficient 0.
TEST(LightMapVerifier, TexelsOfNineBitsErrByTheirSteps) {
    for (const Kind kind : {Kind::Gradient, Kind::Spikes, Kind::Night}) {
        const Cooked cooked = cook(kind, LightMapLayout::HdrRgb9e5);
        const std::vector<float>& bias = cooked.map.constants.at("bias");
        const auto decoded = cooked.verifier().reconstruct(cooked.texels, 0, kMapHeight, 1, &cooked.reference);
        for (int y = 0; y < kMapHeight; ++y)
            for (int x = 0; x < kMapWidth; ++x) {
                if (cooked.reference.covered.at(x, y) == 0) continue;
                const lighting::ShRgb &found = decoded.at(x, y), &expected = cooked.reference.sh.at(x, y);
                const float brightest = std::max({expected[0].r, expected[0].g, expected[0].b});
                for (std::size_t i = 0; i < 9; ++i) {
                    const float most = i == 0 ? 1 : std::sqrt(5.0f) - bias[i - 1];
                    for (int c = 0; c < 3; ++c)
                        ASSERT_LE(std::abs(found[i][c] - expected[i][c]), most * brightest / 512 * 1.01f) << x << ' ' << y << ' ' << i;
                }
            }
        EXPECT_LT(cooked.total().diffuse.relRms, 0.002);
        EXPECT_LT(cooked.total().diffuse.relRms, cook(kind, LightMapLayout::Hdr2).total().diffuse.relRms);
    }
}

/// The second texture removes at least half of the error of the first one. The materials ask for no directions.
TEST(LightMapVerifier, TheSecondTextureOfFlat2HoldsWhatTheFirstMisses) {
    for (const Kind kind : {Kind::Gradient, Kind::Night}) {
        verify::LightMapShading shading;
        shading.normalCount = 1;
        shading.specular = false;
        const auto flat = cook(kind, LightMapLayout::Flat).stages(shading), two = cook(kind, LightMapLayout::Flat2).stages(shading);
        ASSERT_EQ(two.size(), flat.size() + 1);
        EXPECT_EQ(two[0].diffuse.relRms, flat[0].diffuse.relRms);
        EXPECT_LT(two[1].diffuse.relRms, 0.5 * flat[0].diffuse.relRms);
        EXPECT_LT(two[1].diffuse.p99, 0.5 * flat[0].diffuse.p99);
    }
}

TEST(LightMapVerifier, FindsAKnownError) {
    // Every decoded texel is 1 % too bright: all figures are known.
    Cooked cooked = cook(Kind::Grey, LightMapLayout::Raw);
    for (float& range : cooked.map.constants.at("range")) range *= 1.01f;
    const verify::StageError total = cooked.idealTotal();
    EXPECT_NEAR(total.diffuse.relRms, 0.01, 3e-4);
    EXPECT_NEAR(total.diffuse.maxSampled, 0.01 / 1.02, 3e-4);
    EXPECT_NEAR(*total.diffuse.maxBound, 0.01 / 1.02, 3e-4);
    EXPECT_NEAR(total.specular.relRms, 0.01, 3e-4);
}

TEST(LightMapVerifier, ADefectBetweenTexelsIsSeenOnTheSurfaceAlone) {
    // Exact at every texel centre, wrong between them: L = a0 a1, with a0 and a1 exchanged from texel to texel.
    Cooked cooked = cook(Kind::Grey, LightMapLayout::Halo3, Target::Float);
    const auto at = [&](std::size_t texture, int x, int y) -> glm::vec4& { return cooked.texels.textures[texture][0].at(x, y); };
    for (int y = 0; y < kMapHeight; ++y)
        for (int x = 0; x < kMapWidth; ++x) {
            const float product = at(0, x, y).w * at(1, x, y).w, high = (x + y) % 2 == 0 ? 1.0f : 0.8f;
            at(0, x, y).w = high;
            at(1, x, y).w = product / high;
        }
    const std::vector<verify::StageError> stages = cooked.stages();
    EXPECT_LT(stages[1].diffuse.maxBound, 1e-3);
    EXPECT_GT(stages[2].diffuse.maxSampled, 5e-3);
    EXPECT_GE(stages[2].diffuse.maxBound, stages[2].diffuse.maxSampled);
    verify::LightMapSampling none;
    none.placesPerTexel = 0;
    const verify::StageError total = cooked.stages({}, none).back();
    EXPECT_FALSE(total.atTexels);
    EXPECT_EQ(total.diffuse.maxSampled, stages[1].diffuse.maxSampled);
    EXPECT_EQ(total.diffuse.maxBound, stages[2].diffuse.maxBound);
}

TEST(LightMapVerifier, WithoutSpecularMaterialsThereIsNoSpecularError) {
    verify::LightMapShading shading;
    shading.specular = false;
    const verify::StageError total = cook(Kind::Gradient, LightMapLayout::Ratio).stages(shading).back();
    EXPECT_GT(total.diffuse.relRms, 0);
    EXPECT_EQ(total.specular.relRms, 0);
    EXPECT_EQ(total.specular.maxBound, 0);
}

TEST(LightMapVerifier, RefusesInvalidMaps) {
    const Cooked cooked = cook(Kind::Grey, LightMapLayout::Ratio);
    const auto lineOf = [&](auto&& spoil) {
        verify::CookedLightMap map = cooked.map;
        verify::LightMapShading shading;
        spoil(map, shading);
        const auto created = verify::LightMapVerifier::create(map, shading, {}, cooked.key);
        return created ? std::string() : created.error().line();
    };
    EXPECT_EQ(lineOf([](auto&, auto&) {}), "");
    EXPECT_NE(lineOf([](auto& map, auto&) { map.layout = "ratios"; }).find("\"ratios\""), std::string::npos);
    EXPECT_NE(lineOf([](auto& map, auto&) { map.constants.erase("bias"); }).find("constant bias"), std::string::npos);
    EXPECT_NE(lineOf([](auto& map, auto&) { map.constants["scale"].pop_back(); }).find("found 7 values, expected 8"), std::string::npos);
    EXPECT_NE(lineOf([](auto& map, auto&) { map.constants["range"][0] = std::numeric_limits<float>::quiet_NaN(); }).find("NaN"),
              std::string::npos);
    EXPECT_NE(lineOf([](auto& map, auto&) { map.width = 0; }), "");
    EXPECT_NE(lineOf([](auto&, auto& shading) { shading.m.clear(); }), "");
    EXPECT_NE(lineOf([](auto&, auto& shading) { shading.f0 = {1.5}; }), "");
    EXPECT_NE(lineOf([](auto&, auto& shading) { shading.viewCount = 0; }), "");
}

TEST(LightMapScenesSoak, CornellCooksWithinOnePercent) {
    const std::filesystem::path file = std::filesystem::path(LIGHTCOOK_SHARED_DATA) / "scenes/cornell_lightmap.exr";
    if (!std::filesystem::exists(file)) GTEST_SKIP() << "the shared scenes are not here";
    const auto reader = formats::LightMapReader::open(file, {});
    ASSERT_TRUE(reader.has_value()) << reader.error().line();
    for (const LightMapLayout layout : {LightMapLayout::Hdr2, LightMapLayout::Ratio}) {
        auto band = reader->read(0, reader->height());
        ASSERT_TRUE(band.has_value()) << band.error().line();
        const verify::StageError total = cook(std::move(*band), layout, Target::Bc).total();
        EXPECT_LT(total.diffuse.relRms, 0.010) << formats::info(layout).name;
        EXPECT_LT(total.specular.relRms, 0.010) << formats::info(layout).name;
        EXPECT_GT(total.diffuse.relRms, 0.0005);
    }
}

}  // namespace
}  // namespace lightcook

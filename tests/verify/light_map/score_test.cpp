#include "verify/light_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "compress/light_map.h"
#include "formats/specular_lobe.h"
#include "lighting/sphere.h"
#include "tests/compress/light_map_plan.h"
#include "tests/compress/synthetic_light_map.h"
#include "verify/texture_unit.h"

namespace lightcook {
namespace {

using synthetic::Kind;

constexpr int kScoreWidth = 46, kScoreHeight = 38;

double keyOf(const formats::LightMapStrip& band) {
    verify::LightMapKey key;
    key.add(band, 0, band.sh.height());
    return key.key();
}

verify::LightMapScore scoreFor(const formats::LightMapStrip& band, const verify::LightMapShading& shading = {}) {
    auto score = verify::LightMapScore::create(shading, keyOf(band));
    EXPECT_TRUE(score.has_value());
    return std::move(*score);
}

/// The bake, encoded by a layout and decoded, with the verifier's errors at texel centres.
struct Coded {
    formats::Image<lighting::ShRgb> decoded;
    verify::CentreFigures figures;
};
Coded code(const formats::LightMapStrip& band, formats::LightMapLayout layout) {
    compress::EncodeOptions options;
    options.effort = 2;
    const auto plan = synthetic::planOf(layout, formats::Target::Bc, band, options);
    const auto rows = compress::encodeLightMapRows(plan, band, 0, kScoreHeight, options);
    verify::DecodedLightMapRows texels;
    for (std::size_t t = 0; t < rows.textures.size(); ++t) {
        texels.textures.emplace_back();
        for (const auto& bytes : rows.textures[t].layers) {
            texels.textures.back().emplace_back(kScoreWidth, kScoreHeight);
            verify::decodeRows(plan.textures[t].format, bytes, texels.textures.back().back().view());
        }
    }
    const verify::CookedLightMap map{std::string(formats::info(layout).name), plan.constants, kScoreWidth, kScoreHeight};
    const auto verifier = verify::LightMapVerifier::create(map, {}, {}, keyOf(band));
    return {verifier->reconstruct(texels, 0, kScoreHeight),
            verifier->verifyRows(texels, band, 0, kScoreHeight).figures().back().atTexels.value()};
}

TEST(LightMapScore, AgreesWithTheVerifierForOurOwnLayouts) {
    for (const Kind kind : {Kind::Gradient, Kind::Spikes, Kind::Night})
        for (const auto layout : {formats::LightMapLayout::Ratio, formats::LightMapLayout::Hdr2, formats::LightMapLayout::Basis8}) {
            const auto band = synthetic::makeBand(kind, kScoreWidth, 0, kScoreHeight);
            const Coded coded = code(band, layout);
            const auto errors = scoreFor(band).score(band, coded.decoded.view(), 0);
            const auto diffuse = errors.diffuse.figures(), specular = errors.specular.figures();
            EXPECT_GT(diffuse.relRms, 1e-6);
            EXPECT_DOUBLE_EQ(diffuse.relRms, coded.figures.diffuse.relRms);
            EXPECT_DOUBLE_EQ(specular.relRms, coded.figures.specular.relRms);
            EXPECT_DOUBLE_EQ(diffuse.p99, coded.figures.diffuse.p99);
            EXPECT_DOUBLE_EQ(specular.p99, coded.figures.specular.p99);
        }
}

/// Layouts that lack directions or bands are shaded like every other: the light that they lose is an error.
TEST(LightMapScore, AgreesWithTheVerifierForLayoutsThatLackLight) {
    const auto band = synthetic::makeBand(Kind::Gradient, kScoreWidth, 0, kScoreHeight);
    int lacking = 0;
    for (const formats::LightMapLayoutInfo& row : formats::allLightMapLayouts()) {
        // Diffuse light in tangent space is no function of coefficients (rnm_test.cpp).
        if (row.lacks.empty() || row.isInTangentSpace) continue;
        ++lacking;
        const Coded coded = code(band, row.id);
        const auto errors = scoreFor(band).score(band, coded.decoded.view(), 0);
        EXPECT_DOUBLE_EQ(errors.diffuse.figures().relRms, coded.figures.diffuse.relRms) << row.name;
        EXPECT_DOUBLE_EQ(errors.specular.figures().relRms, coded.figures.specular.relRms) << row.name;
        EXPECT_GT(coded.figures.diffuse.relRms, 0.003) << row.name;
        EXPECT_GT(coded.figures.specular.relRms, 0.01) << row.name;
    }
    EXPECT_EQ(lacking, 7) << "flat, flat-2, sh4, godot, mono-sh, bakery, unreal-hq";
}

/// The specular light of GGX: the RMS of the reference is that of exact kernels, for light from one direction and from everywhere.
TEST(LightMapScore, ShadesWithTheLobeOfTheScene) {
    formats::LightMapStrip band = synthetic::makeBand(Kind::Gradient, 1, 0, 1);
    band.normal.at(0, 0) = glm::vec3(0, 0, 1);
    for (const lighting::SpecularLobe lobe : {lighting::SpecularLobe::Beckmann, lighting::SpecularLobe::Ggx})
        for (const double m : {0.05, 0.3, 1.0})
            for (const double f0 : {0.04, 1.0}) {
                verify::LightMapShading shading;
                shading.m = {m};
                shading.f0 = {f0};
                shading.lobe = *formats::info(lobe).distribution;
                double squares = 0;
                for (int k = 0; k < shading.viewCount; ++k) {
                    const glm::dvec3 view = lighting::fibonacciHemisphere(k, shading.viewCount);
                    const auto kernel = lighting::areaSpecular(view.z, m, lobe, lighting::CookTorranceNormalization::Energy);
                    const double azimuth = std::atan2(view.y, view.x), c = std::cos(azimuth), s = std::sin(azimuth);
                    const lighting::ShRotation turn(glm::dmat3(c, s, 0, -s, c, 0, 0, 0, 1));
                    lighting::ShDouble row{};
                    for (std::size_t i = 0; i < row.size(); ++i) row[i] = f0 * kernel.c[i] + (1 - f0) * kernel.d[i];
                    row = turn.apply(row);
                    glm::dvec3 light(0);
                    for (std::size_t i = 0; i < row.size(); ++i) light += row[i] * glm::dvec3(band.sh.at(0, 0)[i]);
                    squares += glm::dot(light, light) / (3 * shading.viewCount);
                }
                auto score = verify::LightMapScore::create(shading, 1);
                ASSERT_TRUE(score.has_value());
                const double found = score->score(band, band.sh.view(), 0).specular.referenceRms();
                EXPECT_NEAR(found, std::sqrt(squares), 3e-4 * std::sqrt(squares)) << m << ' ' << f0;
            }
}

TEST(LightMapScore, IsZeroForTheBakeAndTheScaleOfAScaledOne) {
    const auto band = synthetic::makeBand(Kind::Gradient, kScoreWidth, 0, kScoreHeight);
    const auto score = scoreFor(band);
    formats::Image<lighting::ShRgb> result = band.sh.copy();
    EXPECT_EQ(score.score(band, result.view(), 0).diffuse.figures().maxSampled, 0);
    EXPECT_EQ(score.score(band, result.view(), 0).specular.figures().relRms, 0);
    for (lighting::ShRgb& sh : result.texels())
        for (glm::vec3& c : sh) c *= 1.25f;
    const auto errors = score.score(band, result.view(), 0);
    EXPECT_NEAR(errors.diffuse.figures().relRms, 0.25, 1e-6);
    EXPECT_NEAR(errors.specular.figures().relRms, 0.25, 1e-6);
}

TEST(LightMapScore, StripsMergeToTheWhole) {
    const auto band = synthetic::makeBand(Kind::Gradient, kScoreWidth, 0, kScoreHeight);
    const auto score = scoreFor(band);
    formats::Image<lighting::ShRgb> result = band.sh.copy();
    for (lighting::ShRgb& sh : result.texels()) sh[2] *= 0.9f;
    const auto whole = score.score(band, result.view(), 0);
    verify::ShadedErrors merged;
    for (int row = 0; row < kScoreHeight; row += 12)
        merged.merge(score.score(band, std::as_const(result).view().rows(row, std::min(12, kScoreHeight - row)), row));
    EXPECT_NEAR(merged.diffuse.figures().relRms, whole.diffuse.figures().relRms, 1e-14);
    EXPECT_EQ(merged.diffuse.figures().p99, whole.diffuse.figures().p99);
    EXPECT_EQ(merged.specular.figures().maxSampled, whole.specular.figures().maxSampled);
    EXPECT_EQ(merged.specular.sampleCount(), whole.specular.sampleCount());
}

TEST(LightMapScore, TexelsOutsideChartsDoNotCountAndNotANumberIsTheWorst) {
    const auto band = synthetic::makeBand(Kind::Gradient, kScoreWidth, 0, kScoreHeight);
    const auto score = scoreFor(band);
    formats::Image<lighting::ShRgb> result = band.sh.copy();
    for (int y = 0; y < kScoreHeight; ++y)
        for (int x = 0; x < kScoreWidth; ++x)
            if (band.covered.at(x, y) == 0) result.at(x, y).fill(glm::vec3(std::numeric_limits<float>::quiet_NaN()));
    EXPECT_EQ(score.score(band, result.view(), 0).diffuse.figures().maxSampled, 0);
    result.at(1, 1)[0].y = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(score.score(band, result.view(), 0).diffuse.figures().maxSampled, std::numeric_limits<double>::max());
}

TEST(LightMapScore, RefusesInvalidShading) {
    verify::LightMapShading shading;
    shading.normalCount = 0;
    EXPECT_FALSE(verify::LightMapScore::create(shading, 1).has_value());
    shading = {};
    shading.m = {};
    EXPECT_FALSE(verify::LightMapScore::create(shading, 1).has_value());
}

}  // namespace
}  // namespace lightcook

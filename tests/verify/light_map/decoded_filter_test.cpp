// Filter "decoded": texels are decoded, then the light of covered ones is mixed.
#include <gtest/gtest.h>

#include <random>

#include "lighting/radiometry.h"
#include "shaders/lightcook_cpp.h"
#include "tests/compress/synthetic_light_map.h"
#include "tests/verify/cooked_light_map.h"

namespace lightcook {
namespace {

using formats::LightMapLayout;
using formats::Target;
using synthetic::Kind;

constexpr int kDecodedWidth = 46, kDecodedHeight = 38;

test::Cooked cookDecoded(LightMapLayout layout, formats::LightMapStrip strip) {
    return test::cook(std::move(strip), layout, Target::Bc, 3, formats::LightMapFilter::Decoded);
}
test::Cooked cookDecoded(LightMapLayout layout) {
    return cookDecoded(layout, synthetic::makeBand(Kind::Gradient, kDecodedWidth, 0, kDecodedHeight));
}
std::vector<LightMapLayout> decodedLayouts() {
    return test::layoutsWhere([](const formats::LightMapLayoutInfo& row) { return row.mayHave(formats::LightMapFilter::Decoded); });
}

/// The shader's light at a place.
shaders::LcSh shaderLight(const test::Cooked& cooked, const glm::vec2& uv) {
    shaders::LcQuad quad = shaders::lcQuad(uv, glm::vec2(cooked.map.width, cooked.map.height));
    const auto covered = [&](const glm::vec2& texel) {
        const glm::ivec2 at(texel);
        return static_cast<float>(cooked.texels.covered.at(at.x, at.y));
    };
    quad =
        shaders::lcCoveredQuad(quad, glm::vec4(covered(quad.texel00), covered(quad.texel10), covered(quad.texel01), covered(quad.texel11)));
    return std::visit(
        [&](const auto& layout) {
            const auto decode = [&](const glm::vec2& texel) {
                const glm::ivec2 at(texel);
                return test::lightOfTexel(cooked, layout, at.x, at.y);
            };
            return shaders::lcMix(decode(quad.texel00), decode(quad.texel10), decode(quad.texel01), decode(quad.texel11), quad.weights);
        },
        test::layoutOn(cooked));
}

class DecodedFilter : public testing::TestWithParam<LightMapLayout> {};
INSTANTIATE_TEST_SUITE_P(Layouts, DecodedFilter, testing::ValuesIn(decodedLayouts()), test::nameOfLayout);

TEST_P(DecodedFilter, TheVerifierMixesAsTheShader) {
    const test::Cooked cooked = cookDecoded(GetParam());
    const auto verifier = cooked.verifier();
    std::vector<lighting::ShRgb> light(verifier.lightCount());
    std::mt19937 random(7);
    std::uniform_real_distribution<float> unit(0, 1);
    int compared = 0;
    for (int i = 0; i < 4000; ++i) {
        const glm::vec2 uv(unit(random), unit(random));
        const glm::dvec2 place = glm::dvec2(uv) * glm::dvec2(kDecodedWidth, kDecodedHeight) - 0.5;
        if (!verifier.lightAt(cooked.texels, cooked.reference, place, light)) continue;
        ++compared;
        const shaders::LcSh expected = shaderLight(cooked, uv);
        for (std::size_t k = 0; k < lighting::kShCount; ++k)
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(light.back()[k][c] * cooked.key, expected.c[k][c], 1e-4f * expected.c[0][c] + 1e-6f) << uv.x << ", " << uv.y;
    }
    EXPECT_GT(compared, 2000);
}

TEST_P(DecodedFilter, NoPlaceAndNoNormalExceedTheBound) {
    for (const Kind kind : {Kind::Gradient, Kind::Spikes, Kind::NegativeBands, Kind::Night}) {
        const test::Cooked cooked = cookDecoded(GetParam(), synthetic::makeBand(kind, kDecodedWidth, 0, kDecodedHeight));
        const verify::StageError total = cooked.total();
        const auto verifier = cooked.verifier();
        std::vector<lighting::ShRgb> light(verifier.lightCount());
        std::mt19937 random(11);
        std::uniform_real_distribution<float> unit(0, 1);
        std::normal_distribution<float> normal;
        double worst = 0;
        for (int i = 0; i < 3000; ++i) {
            const glm::dvec2 place = glm::dvec2(unit(random), unit(random)) * glm::dvec2(kDecodedWidth, kDecodedHeight) - 0.5;
            if (!verifier.lightAt(cooked.texels, cooked.reference, place, light)) continue;
            for (int k = 0; k < 25; ++k) {
                const glm::vec3 n = glm::normalize(glm::vec3(normal(random), normal(random), normal(random)));
                const auto exit = [&](const lighting::ShRgb& sh) {
                    return lighting::evaluate(lighting::convolve(sh, lighting::kExitRadianceBands), n);
                };
                const glm::vec3 reference = exit(light.front()), error = exit(light.back()) - reference;
                for (int c = 0; c < 3; ++c)
                    worst = std::max(worst, static_cast<double>(std::abs(error[c])) /
                                                (static_cast<double>(std::abs(reference[c])) + lighting::kLocalErrorFloor));
            }
        }
        EXPECT_LE(worst, *total.diffuse.maxBound) << static_cast<int>(kind);
        if (kind != Kind::Gradient) continue;
        EXPECT_GT(worst, 0.02 * *total.diffuse.maxBound);
    }
}

TEST_P(DecodedFilter, ReconstructionIsTheShadersLightAtEveryPlace) {
    const test::Cooked cooked = cookDecoded(GetParam());
    constexpr int kPlaces = 3;
    const auto seen = cooked.verifier().reconstruct(cooked.texels, 0, kDecodedHeight, kPlaces);
    for (int y = 0; y < seen.height(); ++y)
        for (int x = 0; x < seen.width(); ++x) {
            const glm::vec2 uv((static_cast<float>(x) + 0.5f) / static_cast<float>(seen.width()),
                               (static_cast<float>(y) + 0.5f) / static_cast<float>(seen.height()));
            const shaders::LcSh expected = shaderLight(cooked, uv);
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(seen.at(x, y)[2][c], expected.c[2][c], 1e-4f * std::abs(expected.c[0][c]) + 1e-6f) << x << ", " << y;
        }
}

TEST(DecodedFilterTexels, TexelsOutsideChartsChangeNothing) {
    test::Cooked cooked = cookDecoded(LightMapLayout::Lit);
    const auto before = cooked.stages();
    std::mt19937 random(3);
    std::uniform_real_distribution<float> unit(0, 1);
    for (auto& texture : cooked.texels.textures)
        for (auto& layer : texture)
            for (int y = 0; y < kDecodedHeight; ++y)
                for (int x = 0; x < kDecodedWidth; ++x)
                    if (cooked.reference.covered.at(x, y) == 0)
                        layer.at(x, y) = glm::vec4(unit(random), unit(random), unit(random), unit(random));
    const auto after = cooked.stages();
    ASSERT_EQ(before.size(), after.size());
    for (std::size_t i = 0; i < before.size(); ++i) {
        EXPECT_EQ(before[i].diffuse.relRms, after[i].diffuse.relRms) << before[i].name;
        EXPECT_EQ(before[i].specular.maxBound, after[i].specular.maxBound) << before[i].name;
        EXPECT_EQ(before[i].diffuse.maxBound, after[i].diffuse.maxBound) << before[i].name;
    }
}

/// Charts of 6 x 6 texels that are one texel apart: a third of their texels are at rims.
formats::LightMapStrip closeCharts() {
    formats::LightMapStrip strip = synthetic::makeBand(Kind::Grey, kDecodedWidth, 0, kDecodedHeight);
    for (int y = 0; y < kDecodedHeight; ++y)
        for (int x = 0; x < kDecodedWidth; ++x) {
            const bool isCovered = x % 7 < 6 && y % 7 < 6;
            strip.covered.at(x, y) = isCovered ? 1 : 0;
            const float share = (x / 7 + y / 7) % 2 == 0 ? 1.0f : 0.05f;  // bright beside dark
            strip.sh.at(x, y) = synthetic::gradientLight(x, y);
            for (glm::vec3& coefficient : strip.sh.at(x, y)) coefficient *= isCovered ? share : 0;
        }
    return strip;
}

TEST(DecodedFilterRims, TheSurfaceErrsNoMoreThanTheTexels) {
    for (const LightMapLayout layout : decodedLayouts()) {
        if (formats::info(layout).isFlat() || layout == LightMapLayout::Sh4)
            continue;  // these lack directions or band 2: most of their error
        const verify::StageError total = cookDecoded(layout, closeCharts()).total();
        EXPECT_LE(total.diffuse.relRms, total.atTexels->diffuse.relRms) << formats::info(layout).name;
        EXPECT_LE(total.specular.relRms, total.atTexels->specular.relRms) << formats::info(layout).name;
    }
    const verify::StageError filtered = test::cook(closeCharts(), LightMapLayout::Ratio, Target::Bc, 3).total();
    EXPECT_GT(filtered.diffuse.relRms, 2 * filtered.atTexels->diffuse.relRms) << "the hardware's filter mixes charts";
}

TEST(DecodedFilterDim, ALightThatIsOffLeavesTheRest) {
    const shaders::LcLitConstants k{2, {1, 1, 1, 1, 1, 1, 1, 1}, {}};
    shaders::LcLitTexels t{glm::vec4(3, 2, 1, 0), glm::vec4(1, 0.5f, 0.25f, 0), glm::vec4(0.6f, 0.7f, 0, 0), {}};
    for (std::size_t i = 0; i < 8; ++i) t.rest[i] = glm::vec4(0.1f * static_cast<float>(i), 0.2f, -0.3f, 0);
    const shaders::LcSh lit = shaders::lcLightMapLit(t, k), off = shaders::lcLightMapLitDimmed(t, k, glm::vec3(0)),
                        half = shaders::lcLightMapLitDimmed(t, k, glm::vec3(0.5f));
    const shaders::LcBasis basis = shaders::lcBasis(shaders::lcLitDirection(t.direction));
    const glm::vec3 intensity = shaders::lcLitIntensity(t.light, k);
    EXPECT_EQ(intensity, glm::vec3(2, 1, 0.5f));
    for (std::size_t i = 0; i < lighting::kShCount; ++i)
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(lit.c[i][c] - off.c[i][c], basis.y[i] * intensity[c], 1e-5f);
            EXPECT_NEAR(half.c[i][c], 0.5f * (lit.c[i][c] + off.c[i][c]), 1e-5f);
        }
}

}  // namespace
}  // namespace lightcook

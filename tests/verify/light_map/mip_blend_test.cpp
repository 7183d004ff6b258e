// Errors between two mip levels against closed forms: maps of one light and one ratio each.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "lighting/radiometry.h"
#include "tests/compress/synthetic_light_map.h"
#include "tests/verify/cooked_light_map.h"

namespace lightcook {
namespace {

using formats::LightMapLayout;
using verify::LightMapRows;
using verify::LightMapVerifier;

constexpr int kLargeSide = 16, kSmallSide = 8;

/// Light with a slope along z: coefficient 0 and its ratio to coefficient 2.
lighting::ShRgb slopedLight(float light, float ratio) {
    lighting::ShRgb sh{};
    sh[0] = glm::vec3(light);
    sh[2] = glm::vec3(ratio * light);
    return sh;
}

formats::LightMapStrip evenMap(int side, const lighting::ShRgb& light) {
    formats::LightMapStrip strip;
    strip.sh = formats::Image<lighting::ShRgb>(side, side, light);
    strip.covered = formats::Image<std::uint8_t>(side, side, 1);
    strip.normal = formats::Image<glm::vec3>(side, side, glm::vec3(0, 0, 1));
    return strip;
}

/// A level, cooked alone. Both levels need the same constants: those of the larger one's plan.
struct TwoLevels {
    test::Cooked large, small;

    TwoLevels(const lighting::ShRgb& first, const lighting::ShRgb& second, LightMapLayout layout) {
        // Both lights are in the plan, so that its ranges hold them.
        formats::LightMapStrip both = evenMap(kLargeSide, first);
        for (int x = 0; x < kLargeSide; ++x) both.sh.at(x, kLargeSide - 1) = second;
        large = test::cook(std::move(both), layout, formats::Target::Float, 3);
        small = test::cook(evenMap(kSmallSide, second), layout, formats::Target::Float, 3);
        small.map.constants = large.map.constants;
        // The texels of `second` under the constants of the plan: those of the larger map's last row.
        for (std::size_t t = 0; t < small.texels.textures.size(); ++t)
            for (std::size_t l = 0; l < small.texels.textures[t].size(); ++l)
                for (glm::vec4& texel : small.texels.textures[t][l].texels()) texel = large.texels.textures[t][l].at(0, kLargeSide - 1);
        // Above that row the larger map is even.
        for (std::size_t t = 0; t < large.texels.textures.size(); ++t)
            for (auto& layer : large.texels.textures[t])
                for (int x = 0; x < kLargeSide; ++x) layer.at(x, kLargeSide - 1) = layer.at(x, 0);
        for (int x = 0; x < kLargeSide; ++x) large.reference.sh.at(x, kLargeSide - 1) = first;
    }
    verify::ErrorFigures diffuse(int placesPerTexel, int firstRow = 0, int rowCount = kSmallSide) const {
        verify::LightMapShading shading;
        verify::LightMapSampling sampling;
        sampling.placesPerTexel = placesPerTexel;
        sampling.figures = verify::LightMapFigures::Sampled;
        const auto verifierOf = [&](const test::Cooked& cooked) {
            auto created = LightMapVerifier::create(cooked.map, shading, sampling, 1);
            EXPECT_TRUE(created);
            return std::move(*created);
        };
        const LightMapVerifier larger = verifierOf(large), smaller = verifierOf(small);
        return larger
            .verifyBetween(LightMapRows{large.texels, large.reference}, smaller, LightMapRows{small.texels, small.reference}, firstRow,
                           rowCount)
            .diffuseFigures();
    }
};

TEST(LightMapBetweenLevels, ALinearDecodeOfTheMixIsTheMixOfTheDecodes) {
    const TwoLevels levels(slopedLight(1, 0.6f), slopedLight(4, -0.4f), LightMapLayout::Raw);
    EXPECT_LT(levels.diffuse(4).relRms, 1e-3);
}

/// Coefficient 2 of the mix is (a + w (b - a)) (r + w (s - r)), and its reference a r + w (b s - a r): the difference is
/// -w (1 - w) (b - a) (s - r), at most a quarter of (b - a) (s - r).
TEST(LightMapBetweenLevels, AProductOfTexelsErrsByItsSecondDifference) {
    const float a = 1, b = 4, r = 0.6f, s = -0.4f;
    const TwoLevels levels(slopedLight(a, r), slopedLight(b, s), LightMapLayout::Ratio);
    const verify::ErrorFigures found = levels.diffuse(16);
    double squares = 0, references = 0, largest = 0;
    constexpr int kSteps = 1000, kNormals = 32;
    const double band1 = 2.0 / 3 * lighting::kShLinear;  // of exit radiance
    for (int step = 0; step < kSteps; ++step) {
        const double w = (step + 0.5) / kSteps, off = -w * (1 - w) * static_cast<double>((b - a) * (s - r));
        const double light = static_cast<double>(a) + w * static_cast<double>(b - a);
        const double slope = static_cast<double>(a * r) + w * static_cast<double>(b * s - a * r);
        for (int i = 0; i < kNormals; ++i) {
            const double z = (i + 0.5) / kNormals, reference = lighting::kShConstant * light + band1 * slope * z;
            squares += off * off * band1 * band1 * z * z;
            references += reference * reference;
            largest = std::max(largest, std::abs(off * band1 * z) / (std::abs(reference) + lighting::kLocalErrorFloor));
        }
    }
    const double expected = std::sqrt(squares / references);
    EXPECT_GT(expected, 0.05);
    EXPECT_NEAR(found.relRms, expected, 0.03 * expected);
    EXPECT_NEAR(found.maxSampled, largest, 0.02 * largest);
}

/// Each place belongs to one row of quads, so that strips add up to the map.
TEST(LightMapBetweenLevels, StripsHaveThePlacesOfTheMap) {
    const TwoLevels levels(slopedLight(1, 0.6f), slopedLight(4, -0.4f), LightMapLayout::Ratio);
    const double whole = levels.diffuse(2).maxSampled;
    EXPECT_EQ(std::max(levels.diffuse(2, 0, 4).maxSampled, levels.diffuse(2, 4, 4).maxSampled), whole);
}

}  // namespace
}  // namespace lightcook

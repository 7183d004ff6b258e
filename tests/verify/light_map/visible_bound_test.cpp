// No shading anywhere on a map, rims of charts included, is further from its reference than the bound of visible errors says.
#include <gtest/gtest.h>

#include <fmt/format.h>
#include <chrono>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/compress/synthetic_light_map.h"
#include "tests/verify/visible_sampler.h"
#include "verify/error/visible_metric.h"

namespace lightcook {
namespace {

using formats::LightMapLayout;
using synthetic::Kind;
using test::Cooked;
using test::SampledPlace;
using test::ShadingRows;
using verify::Random;

constexpr int kBoundWidth = 46, kBoundHeight = 38, kBoundBlock = 12;

/// Light of strong colours with hard edges, dark charts and rims.
formats::LightMapStrip harsh() {
    formats::LightMapStrip strip = synthetic::makeBand(Kind::Gradient, kBoundWidth, 0, kBoundHeight);
    Random random(5);
    for (int y = 0; y < kBoundHeight; ++y)
        for (int x = 0; x < kBoundWidth; ++x) {
            const bool isDark = (x / 5 + y / 7) % 3 == 0;
            const glm::vec3 tint = (x / 9) % 2 == 0 ? glm::vec3(1, 0.1f, 0.02f) : glm::vec3(0.1f, 0.3f, 1);
            for (glm::vec3& c : strip.sh.at(x, y)) c *= (isDark ? 0.002f : 1.0f) * tint;
            if (random.next() < 0.05) strip.covered.at(x, y) = 0;
        }
    return strip;
}

/// every  of the kinds of light, or the two that are furthest apart
std::vector<formats::LightMapStrip> strips(bool every) {
    std::vector<formats::LightMapStrip> out;
    out.push_back(synthetic::makeBand(Kind::Gradient, kBoundWidth, 0, kBoundHeight));
    if (every) out.push_back(synthetic::makeBand(Kind::NegativeBands, kBoundWidth, 0, kBoundHeight));
    if (every) out.push_back(synthetic::makeBand(Kind::Spikes, kBoundWidth, 0, kBoundHeight));
    out.push_back(harsh());
    return out;
}

void expectNeverExceeded(LightMapLayout layout, std::vector<formats::LightMapStrip> maps) {
    static const ShadingRows kDiffuse(2048, false, 1), kSpecular(2048, true, 2);
    constexpr int kPlaces = 4000;  // of each map, with 32 shadings of each kind
    std::int64_t shadings = 0, above = 0;
    std::uint64_t seed = 7;
    for (formats::LightMapStrip& strip : maps) {
        const Cooked cooked = test::cook(std::move(strip), layout, formats::Target::Bc, 1);
        const verify::Viewing viewing = test::viewingOf(cooked);
        const test::VisibleSampler sampler(cooked, viewing);
        const auto verifier = verify::LightMapVerifier::create(cooked.map, test::sampledShading(), {}, cooked.key, viewing);
        ASSERT_TRUE(verifier.has_value());
        const auto start = std::chrono::steady_clock::now();
        constexpr int kAcross = (kBoundWidth + kBoundBlock - 1) / kBoundBlock, kDown = (kBoundHeight + kBoundBlock - 1) / kBoundBlock;
        std::array<std::array<verify::LightMapVerifier::AreaVisibleBound, kAcross>, kDown> bounds;
        for (int y = 0; y < kDown; ++y)
            for (int x = 0; x < kAcross; ++x)
                bounds[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)] =
                    verifier->visibleBound(cooked.texels, cooked.reference, {kBoundBlock * x, kBoundBlock * y, kBoundBlock, kBoundBlock});
        const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        Random random(++seed);
        double nearestDiffuse = 0, nearestSpecular = 0;
        for (int i = 0; i < kPlaces; ++i) {
            const auto [x, y] = sampler.covered[static_cast<std::size_t>(random.next() * static_cast<double>(sampler.covered.size()))];
            const SampledPlace place = sampler.placeAt(x, y, random);
            const auto light = sampler.lightAt(place);
            const auto& bound = bounds[static_cast<std::size_t>(std::max(place.quadY(), 0) / kBoundBlock)]
                                      [static_cast<std::size_t>(std::max(place.quadX(), 0) / kBoundBlock)];
            for (int group = 0; group < 2; ++group) {
                const auto first = static_cast<std::size_t>(random.below(128)) * ShadingRows::kLanes;
                std::array<float, ShadingRows::kLanes> diffuse, specular;
                sampler.differences(light, kDiffuse, first, diffuse.data());
                sampler.differences(light, kSpecular, first, specular.data());
                for (std::size_t lane = 0; lane < ShadingRows::kLanes; ++lane) {
                    above += !(static_cast<double>(diffuse[lane]) <= bound.diffuse);
                    above += !(static_cast<double>(specular[lane]) <= bound.specular);
                    nearestDiffuse = std::max(nearestDiffuse, static_cast<double>(diffuse[lane]) / bound.diffuse);
                    nearestSpecular = std::max(nearestSpecular, static_cast<double>(specular[lane]) / bound.specular);
                }
                shadings += 2 * static_cast<std::int64_t>(ShadingRows::kLanes);
            }
        }
        fmt::print("{:11} {:.2f} s, nearest {:.2f} and {:.2f} of the bound; {:.1f} {:.1f}\n", formats::info(layout).name, seconds,
                   nearestDiffuse, nearestSpecular, bounds[1][1].diffuse, bounds[1][1].specular);
        // A bound far above all errors would always hold.
        EXPECT_GT(nearestDiffuse, 0.02);
        EXPECT_GT(nearestSpecular, 0.005);
    }
    EXPECT_EQ(above, 0);
    EXPECT_GE(shadings, 250'000 * static_cast<std::int64_t>(maps.size()));
}

class VisibleBoundOfLayout : public testing::TestWithParam<LightMapLayout> {};
using VisibleBoundOfLayoutSoak = VisibleBoundOfLayout;
TEST_P(VisibleBoundOfLayout, IsNeverExceeded) {
    expectNeverExceeded(GetParam(), strips(false));
}
TEST_P(VisibleBoundOfLayoutSoak, IsNeverExceeded) {
    expectNeverExceeded(GetParam(), strips(true));
}

/// Without normal maps, visible errors of diffuse light are of the texels' own normals, beside specular light too.
TEST(VisibleBound, WithoutATiltIsOfTheOwnNormalAlone) {
    const Cooked cooked = test::cook(harsh(), LightMapLayout::Ratio, formats::Target::Bc, 1);
    const verify::Viewing viewing = test::viewingOf(cooked);
    const auto figuresOf = [&](double tilt) {
        verify::LightMapShading shading;
        shading.normalMapTilt = tilt;
        const auto verifier = verify::LightMapVerifier::create(cooked.map, shading, {}, cooked.key, viewing);
        return verifier->verifyRows(cooked.texels, cooked.reference, 0, kBoundHeight).figures().back();
    };
    const verify::StageError own = figuresOf(0), cap = figuresOf(60);
    ASSERT_TRUE(own.diffuse.visible && own.diffuse.visible->bound && cap.diffuse.visible && cap.diffuse.visible->bound);
    EXPECT_LE(own.diffuse.visible->max, *own.diffuse.visible->bound);
    EXPECT_LT(own.diffuse.visible->max, cap.diffuse.visible->max);
    EXPECT_LT(*own.diffuse.visible->bound, *cap.diffuse.visible->bound);
    EXPECT_EQ(own.diffuse.relRms, cap.diffuse.relRms) << "of 32 normals of the hemisphere";
    EXPECT_EQ(own.specular.visible->p99, cap.specular.visible->p99);
}

/// Quads that repeat their left neighbour are left out.
TEST(VisibleBound, FindsTheTexelThatDiffersFromARun) {
    formats::LightMapStrip strip = synthetic::makeBand(Kind::Gradient, kBoundWidth, 0, kBoundHeight);
    std::ranges::fill(strip.sh.texels(), strip.sh.at(0, 0));
    std::ranges::fill(strip.normal.texels(), glm::vec3(0, 0, 1));
    std::ranges::fill(strip.covered.texels(), std::uint8_t{1});
    Cooked cooked = test::cook(std::move(strip), LightMapLayout::Hdr, formats::Target::Float, 1);
    const verify::Viewing viewing = test::viewingOf(cooked);
    const auto verifier = verify::LightMapVerifier::create(cooked.map, test::sampledShading(), {}, cooked.key, viewing);
    ASSERT_TRUE(verifier.has_value());
    const auto figuresOf = [&] { return verifier->verifyRows(cooked.texels, cooked.reference, 0, kBoundHeight).figures().back(); };
    const verify::StageError before = figuresOf();
    constexpr int kX = 20, kY = 10;
    cooked.texels.textures[0][0].at(kX, kY) *= 2.0f;
    const auto whole = verifier->visibleBound(cooked.texels, cooked.reference, {0, 0, kBoundWidth, kBoundHeight});
    const auto around = verifier->visibleBound(cooked.texels, cooked.reference, {kX - 1, kY - 1, 2, 2});
    EXPECT_EQ(whole.diffuse, around.diffuse);
    EXPECT_EQ(whole.specular, around.specular);
    const verify::StageError after = figuresOf();
    double local = 0;
    for (const int y : {kY - 1, kY})
        for (const int x : {kX - 1, kX}) local = std::max(local, verifier->boundQuad(cooked.texels, cooked.reference, x, y).diffuse);
    EXPECT_EQ(after.diffuse.maxBound, local);
    EXPECT_GT(*after.diffuse.maxBound, *before.diffuse.maxBound + 0.5);
    EXPECT_GT(*after.diffuse.visible->bound, *before.diffuse.visible->bound + 10);
}

INSTANTIATE_TEST_SUITE_P(EveryFamily, VisibleBoundOfLayout, testing::ValuesIn(test::layoutsOfEveryFamily()), test::nameOfLayout);
INSTANTIATE_TEST_SUITE_P(Every, VisibleBoundOfLayoutSoak, testing::ValuesIn(test::kEveryLayout), test::nameOfLayout);

}  // namespace
}  // namespace lightcook

// The bench's copies of other engines' layouts, held against light whose result is known without them.
#include "bench/peer_layouts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "lighting/radiometry.h"
#include "tests/compress/synthetic_light_map.h"
#include "verify/light_map.h"

namespace lightcook {
namespace {

using bench::PeerMaps;
using lighting::ShRgb;

constexpr int kSize = 32;

/// One white light a texel, its direction and intensity running over the map, on normals that face it.
formats::LightMapStrip oneLight() {
    formats::LightMapStrip strip;
    strip.sh = formats::Image<ShRgb>(kSize, kSize);
    strip.covered = formats::Image<std::uint8_t>(kSize, kSize, 1);
    strip.normal = formats::Image<glm::vec3>(kSize, kSize);
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
            const glm::vec3 direction = glm::normalize(glm::vec3(static_cast<float>(x) / kSize - 0.5f, 1, static_cast<float>(y) / kSize));
            strip.normal.at(x, y) = direction;
            strip.sh.at(x, y) = lighting::projectDirectional(direction, glm::vec3(1 + static_cast<float>(y) / kSize));
        }
    return strip;
}

PeerMaps make(const std::string& name, const bench::Bake& bake) {
    for (const bench::PeerLayout& layout : bench::peerLayouts())
        if (layout.name == name) return layout.make(bake, 3);
    throw std::runtime_error("no layout " + name);
}

verify::ErrorFigures diffuse(const bench::Bake& bake, const formats::Image<ShRgb>& result) {
    const auto score = verify::LightMapScore::create({}, bake.measure.key());
    return score->score(bake.strip, result.view(), 0).diffuse.figures();
}

TEST(PeerLayouts, BitsAreThoseOfTheirBlocks) {
    const bench::Bake bake(oneLight());
    const std::pair<const char*, double> expected[] = {
        {"unreal", 16},    {"l0-bc6h+l1-bc1", 20},    {"l0-bc6h+l1-bc7", 32},        {"godot-4.4", 32},
        {"nine-bc6h", 72}, {"halo3-linear-talk", 80}, {"halo3-quadratic-talk", 144}, {"nine-rgba16f", 576}};
    for (const auto& [name, bits] : expected) EXPECT_EQ(make(name, bake).bitsPerTexel, bits) << name;
}

TEST(PeerLayouts, OneLightIsExactlyWhatHalo3Keeps) {
    const bench::Bake bake(oneLight());
    EXPECT_LT(diffuse(bake, make("halo3-linear-talk", bake).ideal).relRms, 1e-6);
    const glm::vec3 direction = bake.strip.normal.at(5, 9), intensity(1 + 9.0f / kSize);
    EXPECT_NEAR(bench::dominantIntensity(bake.strip.sh.at(5, 9)).x, intensity.x, 1e-6);
    const ShRgb light = bench::withDominantLight(lighting::projectDirectional(direction, glm::vec3(2)), glm::vec3(2));
    for (std::size_t i = 0; i < light.size(); ++i) EXPECT_NEAR(light[i].y, 2 * lighting::evaluateBasis(direction)[i], 1e-6) << i;
}

TEST(PeerLayouts, LightWithoutDirectionHasNoDominantOne) {
    const ShRgb grey = synthetic::constantLight(glm::vec3(0.5f));
    EXPECT_EQ(bench::dominantIntensity(grey), glm::vec3(0));
    EXPECT_EQ(bench::withDominantLight(grey, glm::vec3(7)), grey);
}

// White light from one direction d through bands 0 and 1: the error is its band 2, whose share of the 32 x 3 shaded values is summed
// here from Legendre polynomials of the angle between normal and light.
TEST(PeerLayouts, LinearFormsLoseExactlyBandTwo) {
    const bench::Bake bake(oneLight());
    double lost = 0, all = 0;
    for (int y = 0; y < kSize; ++y)
        for (int k = 0; k < 32; ++k) {
            // The normal faces the light: the angle to it is that to the sample.
            const double c = (k + 0.5) / 32, intensity = 1 + static_cast<double>(y) / kSize;
            const double band2 = 0.25 * 5 * (3 * c * c - 1) / 2, whole = 1 + 2.0 / 3 * 3 * c + band2;
            lost += intensity * intensity * band2 * band2;
            all += intensity * intensity * whole * whole;
        }
    const double expected = std::sqrt(lost / all);
    for (const char* name : {"l1-truncation", "godot-4.4", "l0-bc6h+l1-bc7", "l0-bc6h+l1-bc1", "unreal"})
        EXPECT_NEAR(diffuse(bake, make(name, bake).ideal).relRms, expected, 1e-5) << name;
}

TEST(PeerLayouts, CodingCostsLittleOnSmoothLight) {
    const bench::Bake bake(oneLight());
    const std::pair<const char*, double> most[] = {
        {"nine-rgba16f", 5e-4}, {"nine-bc6h", 0.01}, {"halo3-quadratic-talk", 0.03}, {"halo3-linear-talk", 0.03}};
    for (const auto& [name, bound] : most) {
        const double error = diffuse(bake, make(name, bake).seen).relRms;
        EXPECT_GT(error, 0) << name;
        EXPECT_LT(error, bound) << name;
    }
}

TEST(PeerLayouts, BlackAndSpikesStayFinite) {
    for (const synthetic::Kind kind : {synthetic::Kind::Black, synthetic::Kind::Spikes, synthetic::Kind::Night}) {
        const bench::Bake bake(synthetic::makeBand(kind, 44, 0, 30));
        for (const bench::PeerLayout& layout : bench::peerLayouts()) {
            const PeerMaps maps = layout.make(bake, 1);
            for (int y = 0; y < bake.height(); ++y)
                for (int x = 0; x < bake.width(); ++x)
                    for (std::size_t i = 0; i < lighting::kShCount && bake.strip.covered.at(x, y) != 0; ++i)
                        for (int c = 0; c < 3; ++c) {
                            ASSERT_TRUE(std::isfinite(maps.ideal.at(x, y)[i][c])) << layout.name << ' ' << x << ' ' << y << ' ' << i;
                            ASSERT_TRUE(std::isfinite(maps.seen.at(x, y)[i][c])) << layout.name << ' ' << x << ' ' << y << ' ' << i;
                        }
        }
    }
}

}  // namespace
}  // namespace lightcook

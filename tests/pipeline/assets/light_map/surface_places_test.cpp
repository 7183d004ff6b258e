#include "pipeline/assets/light_map/surface_places.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <glm/common.hpp>

namespace lightcook::pipeline {
namespace {

constexpr int kMapWidth = 300, kMapHeight = 256;

/// Coefficient 0 is x + 1000 y of the texel.
formats::LightMapStrip ramp() {
    formats::LightMapStrip texels;
    texels.sh = formats::Image<lighting::ShRgb>(kMapWidth, kMapHeight);
    texels.covered = formats::Image<std::uint8_t>(kMapWidth, kMapHeight, 1);
    texels.normal = formats::Image<glm::vec3>(kMapWidth, kMapHeight, glm::vec3(0, 0, 1));
    for (int y = 0; y < kMapHeight; ++y)
        for (int x = 0; x < kMapWidth; ++x) texels.sh.at(x, y)[0] = glm::vec3(static_cast<float>(x + 1000 * y));
    return texels;
}
double rampAt(const glm::dvec2& at) {
    const glm::dvec2 inside = glm::clamp(at, glm::dvec2(0), glm::dvec2(kMapWidth - 1, kMapHeight - 1));
    return inside.x + 1000 * inside.y;
}

TEST(SurfacePlaces, LieEvenlyInTheFootprintsOfTexels) {
    const std::vector<SurfacePlace> places = SurfacePlaces(kMapWidth, kMapHeight).of(ramp(), 0, kMapHeight);
    EXPECT_GT(places.size(), 5000u);
    EXPECT_LE(places.size(), 10000u);
    std::array<int, 16> quarters{};  // of a footprint, along both axes
    for (const SurfacePlace& place : places) {
        const glm::dvec2 inTexel = place.at + 0.5 - glm::floor(place.at + 0.5);
        ++quarters[static_cast<std::size_t>(inTexel.x * 4) + 4 * static_cast<std::size_t>(inTexel.y * 4)];
        EXPECT_NEAR(static_cast<double>(place.bake[0].r), rampAt(place.at), 0.05) << place.at.x << ' ' << place.at.y;
    }
    for (const int count : quarters)
        EXPECT_NEAR(count, static_cast<double>(places.size()) / 16, 0.1 * static_cast<double>(places.size()) / 16 + 2);
}

TEST(SurfacePlaces, TheBakeIsFilteredBetweenCoveredTexelsAlone) {
    formats::LightMapStrip texels = ramp();
    for (int y = 0; y < kMapHeight; ++y)
        for (int x = 0; x < kMapWidth; ++x) {
            texels.sh.at(x, y)[0] = glm::vec3(x < kMapWidth / 2 ? 1.0f : 1e6f);
            texels.covered.at(x, y) = x < kMapWidth / 2 ? 1 : 0;
        }
    for (const SurfacePlace& place : SurfacePlaces(kMapWidth, kMapHeight).of(texels, 0, kMapHeight)) {
        EXPECT_LT(place.at.x, kMapWidth / 2) << "places lie on covered texels";
        EXPECT_EQ(place.bake[0].r, 1.0f);
    }
}

TEST(SurfacePlaces, NoneLiesBetweenCharts) {
    formats::LightMapStrip texels = ramp();
    texels.chart = formats::Image<std::uint32_t>(kMapWidth, kMapHeight, 1);
    for (int y = 0; y < kMapHeight; ++y)
        for (int x = 0; x < kMapWidth; ++x) texels.chart.at(x, y) = x % 2 == 0 ? 1 : 2;
    for (const SurfacePlace& place : SurfacePlaces(kMapWidth, kMapHeight).of(texels, 0, kMapHeight))
        EXPECT_TRUE(place.at.x <= 0 || place.at.x >= kMapWidth - 1) << "the filter reads one column at the ends of the map alone";
}

TEST(SurfacePlaces, OfStripsAreThoseOfTheMapLessTheRowsAtTheirEnds) {
    const formats::LightMapStrip texels = ramp();
    const SurfacePlaces all(kMapWidth, kMapHeight);
    const std::vector<SurfacePlace> whole = all.of(texels, 0, kMapHeight);
    for (int first = 0; first < kMapHeight; first += 64) {
        for (const SurfacePlace& place : all.of(texels, first, 64)) {
            const auto isSame = [&](const SurfacePlace& other) { return other.at == place.at && other.bake == place.bake; };
            EXPECT_TRUE(std::ranges::any_of(whole, isSame));
            EXPECT_TRUE(first == 0 || place.at.y >= first + 0.5);
            EXPECT_TRUE(first + 64 == kMapHeight || place.at.y <= first + 62.5);
        }
    }
}

}  // namespace
}  // namespace lightcook::pipeline

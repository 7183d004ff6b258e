// Charts at fewer texels, against light whose best resolution is known and an interpolation of the test's own.
#include "atlas/reduction.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <string>

#include "lighting/radiometry.h"
#include "tests/atlas/mesh_fixture.h"

namespace lightcook::atlas {
namespace {

using formats::Image;
using lighting::ShRgb;

constexpr int kSize = 64;

/// A map of kSize x kSize texels with one chart, whose sh00 and sh02 are functions of the texel.
struct ReducedMap {
    Image<ShRgb> sh{kSize, kSize};
    Image<std::uint8_t> covered{kSize, kSize, 1};
    Image<glm::vec3> normal{kSize, kSize, glm::vec3(0, 0, 1)};
    Chart chart;

    /// rim  texels between the mesh and the border of the map
    explicit ReducedMap(const std::function<double(int x, int y)>& light, float rim = 0.6f) {
        for (int y = 0; y < kSize; ++y)
            for (int x = 0; x < kSize; ++x) {
                sh.at(x, y)[0] = glm::vec3(static_cast<float>(light(x, y)));
                sh.at(x, y)[2] = 0.5f * sh.at(x, y)[0];
            }
        const formats::TriangleMesh mesh = rectangle(glm::vec2(rim / kSize), glm::vec2((kSize - rim) / kSize));
        const formats::TriangleMesh* pointer = &mesh;
        const formats::Subject name = "mesh";
        chart = findCharts({&pointer, 1}, {&name, 1}, kSize, kSize)->charts.front();
    }
    ReducedChart reduced(double maxVisible) const {
        ReductionLimit limit;
        limit.maxVisible = maxVisible;
        limit.display = lighting::DisplaySettings{}.of(1);
        return reduceChart(chart, {sh.view(), covered.view(), normal.view()}, limit, std::atomic<bool>(false));
    }
};

/// Returns the light of a reduced chart at a texel of the bake, in double.
std::array<glm::dvec3, 9> lightAt(const ReducedChart& chart, int x, int y) {
    const double fx = static_cast<double>(x) / chart.step.x, fy = static_cast<double>(y) / chart.step.y;
    const int left = static_cast<int>(fx), top = static_cast<int>(fy);
    std::array<glm::dvec3, 9> sum{};
    for (int dy = 0; dy < 2; ++dy)
        for (int dx = 0; dx < 2; ++dx) {
            const double weight = (dx != 0 ? fx - left : 1 - fx + left) * (dy != 0 ? fy - top : 1 - fy + top);
            if (weight <= 0) continue;
            EXPECT_EQ(chart.isRead.at(left + dx, top + dy), 1) << x << " " << y;
            for (std::size_t i = 0; i < 9; ++i) sum[i] += weight * glm::dvec3(chart.sh.at(left + dx, top + dy)[i]);
        }
    return sum;
}

/// Returns the share of covered texels whose light at their normal is off by more than a limit.
double shareBeyond(const ReducedMap& map, const ReducedChart& chart, double maxVisible) {
    int beyond = 0, all = 0;
    const glm::dvec3 normal(0, 0, 1);
    const lighting::ShDouble basis = lighting::evaluateBasis(normal);
    const auto exit = [&](const auto& sh) {
        glm::dvec3 sum(0);
        for (std::size_t i = 0; i < 9; ++i) sum += lighting::kExitRadianceBands[i == 0 ? 0 : i < 4 ? 1 : 2] * basis[i] * glm::dvec3(sh[i]);
        return sum;
    };
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
            if (map.covered.at(x, y) == 0) continue;
            const glm::ivec2 place = glm::ivec2(x, y) - map.chart.first;
            const double visible = lighting::visibleDifference(exit(map.sh.at(x, y)), exit(lightAt(chart, place.x, place.y)),
                                                               lighting::DisplaySettings{}.of(1));
            ++all;
            beyond += visible > maxVisible ? 1 : 0;
        }
    return static_cast<double>(beyond) / all;
}

TEST(ReduceChart, ConstantAndLinearLightTakeTwoTexelsASide) {
    for (const auto& light :
         {std::function<double(int, int)>([](int, int) { return 2.0; }), {[](int x, int y) { return 1 + 0.01 * x + 0.02 * y; }}}) {
        const ReducedMap map(light);
        const ReducedChart chart = map.reduced(0.1);
        EXPECT_EQ(chart.sh.width(), 2);
        EXPECT_EQ(chart.sh.height(), 2);
        EXPECT_EQ(shareBeyond(map, chart, 0.1), 0);
        EXPECT_EQ(chart.visible.size(), static_cast<std::size_t>(kSize * kSize * ReducedChart::kNormals));
        EXPECT_LT(*std::max_element(chart.visible.begin(), chart.visible.end()), 0.1f);
        EXPECT_EQ(chart.readBefore, kSize * kSize);
    }
}

TEST(ReduceChart, AChartUpToTheBorderReadsNoMoreTexelsThanTheMapHas) {
    const ReducedMap map([](int, int) { return 1.0; }, 0);
    EXPECT_EQ(map.chart.texels(), glm::ivec2(kSize + 2)) << "filters at the border read beyond it, where the map is clamped";
    EXPECT_EQ(map.reduced(0).readBefore, kSize * kSize);
}

TEST(ReduceChart, HardEdgesAndALimitOfZeroKeepEveryBit) {
    const ReducedMap edges([](int x, int y) { return (x / 3 + y / 5) % 2 == 0 ? 1.0 : 3.0; }), flat([](int, int) { return 1.0; });
    for (const auto& [map, limit] : {std::pair{&edges, 2.0}, {&flat, 0.0}}) {
        const ReducedChart chart = map->reduced(limit);
        EXPECT_EQ(chart.step, glm::ivec2(1));
        for (int y = 0; y < kSize; ++y)
            for (int x = 0; x < kSize; ++x)
                EXPECT_EQ(chart.sh.at(x - map->chart.first.x, y - map->chart.first.y), map->sh.at(x, y)) << x << " " << y;
        EXPECT_EQ(chart.squaredError, 0);
        EXPECT_GT(chart.squaredLight, 0);
    }
}

TEST(ReduceChart, StripesShrinkAlongTheirLength) {
    const ReducedMap map([](int x, int) { return x % 4 < 2 ? 1.0 : 3.0; });
    const ReducedChart chart = map.reduced(1);
    EXPECT_EQ(chart.step.x, 1);
    EXPECT_EQ(chart.sh.height(), 2);
    EXPECT_EQ(shareBeyond(map, chart, 1), 0);
}

TEST(ReduceChart, SmoothLightKeepsTheLimitAtFewerTexels) {
    const ReducedMap map([](int x, int y) { return 1.5 + std::sin(x * 0.1) + 0.4 * std::cos(y * 0.15); });
    int texels = kSize * kSize + 1;
    for (const double limit : {0.25, 1.0, 4.0}) {
        const ReducedChart chart = map.reduced(limit);
        EXPECT_LT(chart.sh.width() * chart.sh.height(), texels) << "a wider limit takes fewer texels";
        texels = chart.sh.width() * chart.sh.height();
        EXPECT_LE(shareBeyond(map, chart, limit), 0.01) << limit;
    }
}

TEST(ReduceChart, BrightLightThatADisplayClampsStillCounts) {
    // Both are white on any display, far beyond its brightest.
    const ReducedMap map([](int x, int y) { return (x + y) % 2 == 0 ? 2e5 : 1e6; });
    EXPECT_EQ(map.reduced(1).step, glm::ivec2(1));
}

TEST(ReduceChart, UncoveredTexelsDoNotCountAndAChartOfThemStays) {
    ReducedMap map([](int, int) { return 1.0; });
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x)
            if (x < 9 || (x - 40) * (x - 40) + (y - 30) * (y - 30) < 50) {
                map.covered.at(x, y) = 0;
                map.sh.at(x, y) = ShRgb{};
            }
    const ReducedChart chart = map.reduced(0.5);
    EXPECT_EQ(chart.sh.width(), 2);
    EXPECT_EQ(shareBeyond(map, chart, 0.5), 0) << "zeros outside the charts do not darken them";
    std::fill(map.covered.texels().begin(), map.covered.texels().end(), std::uint8_t{0});
    EXPECT_EQ(map.reduced(0.5).step, glm::ivec2(1));
}

TEST(ReduceChart, TexelsAreLight) {
    // Least squares overshoot beside a spike: below zero, if nothing held them.
    const ReducedMap map([](int x, int y) { return x % 32 == 16 && y % 32 == 16 ? 1e4 : 1e-3; });
    const ReducedChart chart = map.reduced(100);
    EXPECT_NE(chart.step, glm::ivec2(1)) << "the test is about reduced charts";
    for (const ShRgb& sh : chart.sh.texels()) {
        EXPECT_GE(sh[0].x, 0);
        EXPECT_LE(glm::abs(sh[2].x), 2 * std::sqrt(3.0f) * sh[0].x * 1.0001f);
    }
}

TEST(ReduceChart, AnInterruptEndsTheSearch) {
    const ReducedMap map([](int, int) { return 1.0; });
    ReductionLimit limit;
    EXPECT_EQ(reduceChart(map.chart, {map.sh.view(), map.covered.view(), map.normal.view()}, limit, std::atomic<bool>(true)).step,
              glm::ivec2(1));
}

}  // namespace
}  // namespace lightcook::atlas

// Errors by chart against a brute-force walk over texel centres.
#include "pipeline/assets/light_map/chart_errors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/atlas/mesh_fixture.h"

namespace lightcook::pipeline {
namespace {

using formats::TriangleMesh;

constexpr int kChartMapSide = 128, kCell = 12, kCells = 10;  // a rectangle in each cell, texels apart from the others

/// A rectangle of texels [low, high), whose charts hold these centres and no others.
struct Rectangle {
    glm::ivec2 low, high;
    bool holds(int x, int y) const { return low.x <= x && x < high.x && low.y <= y && y < high.y; }
    int texels() const { return (high.x - low.x) * (high.y - low.y); }
};

std::vector<Rectangle> randomRectangles() {
    std::mt19937 random(11);
    std::vector<Rectangle> rectangles;
    for (int cell = 0; cell < kCells * kCells; ++cell) {
        const glm::ivec2 low(cell % kCells * kCell, cell / kCells * kCell);
        rectangles.push_back({low, low + glm::ivec2(1 + random() % 9, 1 + random() % 9)});
    }
    return rectangles;
}

struct Atlas {
    std::vector<TriangleMesh> meshes;
    std::vector<const TriangleMesh*> pointers;
    explicit Atlas(const std::vector<Rectangle>& rectangles) {
        for (const Rectangle& each : rectangles)
            meshes.push_back(atlas::rectangle(glm::vec2(each.low) / float(kChartMapSide), glm::vec2(each.high) / float(kChartMapSide)));
        for (const TriangleMesh& mesh : meshes) pointers.push_back(&mesh);
    }
};

formats::Image<float> randomErrors() {
    std::mt19937 random(12);
    std::lognormal_distribution<float> error(0, 1);
    formats::Image<float> visible(kChartMapSide, kChartMapSide);
    for (float& value : visible.texels()) value = error(random);
    return visible;
}

ChartSummary summaryOf(const MapCharts& charts, const formats::Image<float>& visible, int stripHeight, std::uint64_t bytes) {
    ChartErrors whole;
    for (int first = 0; first < kChartMapSide; first += stripHeight) {
        ChartErrors strip;
        const auto groups = charts.groupsOf(first, stripHeight);
        for (int y = 0; y < stripHeight; ++y)
            for (int x = 0; x < kChartMapSide; ++x) strip.add(groups.at(x, y), x, first + y, visible.at(x, first + y));
        whole.merge(strip);
    }
    return whole.summary(charts, bytes, std::int64_t{kChartMapSide} * kChartMapSide);
}

TEST(ChartErrors, TexelsBelongToTheChartThatHoldsTheirCentres) {
    const auto rectangles = randomRectangles();
    const Atlas atlas(rectangles);
    const auto charts = MapCharts::of(atlas.pointers, kChartMapSide, kChartMapSide);
    ASSERT_TRUE(charts);
    ASSERT_EQ(charts->groupCount(), MapCharts::kMostOwn + 1) << "a hundred charts, most of which are measured";
    const auto groups = charts->groupsOf(0, kChartMapSide);
    for (int y = 0; y < kChartMapSide; ++y)
        for (int x = 0; x < kChartMapSide; ++x) {
            const auto holder = std::ranges::find_if(rectangles, [&](const Rectangle& each) { return each.holds(x, y); });
            if (holder == rectangles.end()) continue;
            const std::size_t group = groups.at(x, y);
            ASSERT_LT(group, charts->groupCount()) << x << " " << y;
            if (group < MapCharts::kMostOwn) {
                EXPECT_EQ(charts->chartOf(group), std::size_t(holder - rectangles.begin())) << x << " " << y;
            }
        }
    EXPECT_EQ(groups.at(kChartMapSide - 1, kChartMapSide - 1), MapCharts::kNoGroup) << "beside all charts";
}

TEST(ChartErrors, FiguresAreThoseOfTheTexelsInAnyCut) {
    const auto rectangles = randomRectangles();
    const Atlas atlas(rectangles);
    const auto charts = MapCharts::of(atlas.pointers, kChartMapSide, kChartMapSide);
    ASSERT_TRUE(charts);
    // Texels beside all rectangles are not covered: their errors are no chart's.
    formats::Image<float> visible = randomErrors();
    constexpr std::uint64_t kBytes = 1 << 20;
    ChartErrors errors;
    const auto groups = charts->groupsOf(0, kChartMapSide);
    for (const Rectangle& each : rectangles)
        for (int y = each.low.y; y < each.high.y; ++y)
            for (int x = each.low.x; x < each.high.x; ++x) errors.add(groups.at(x, y), x, y, visible.at(x, y));
    const ChartSummary summary = errors.summary(*charts, kBytes, std::int64_t{kChartMapSide} * kChartMapSide);
    EXPECT_EQ(summary.count, 100);
    ASSERT_EQ(summary.largest.size(), MapCharts::kMostOwn);
    ASSERT_TRUE(summary.rest);
    std::int64_t texels = summary.rest->texels;
    for (const ChartFigures& chart : summary.largest) {
        const Rectangle& rectangle = rectangles.at(static_cast<std::size_t>(chart.number - 1));
        std::vector<float> truth;
        glm::ivec2 worst(0);
        double squares = 0;
        for (int y = rectangle.low.y; y < rectangle.high.y; ++y)
            for (int x = rectangle.low.x; x < rectangle.high.x; ++x) {
                const float value = visible.at(x, y);
                if (truth.empty() || value > *std::ranges::max_element(truth)) worst = {x, y};
                truth.push_back(value);
                squares += double(value) * double(value);
            }
        std::ranges::sort(truth);
        EXPECT_EQ(chart.texels, rectangle.texels());
        EXPECT_EQ(chart.bytes, std::uint64_t(std::llround(double(kBytes) * rectangle.texels() / (kChartMapSide * kChartMapSide))));
        EXPECT_NEAR(chart.visibleRms, std::sqrt(squares / double(truth.size())), 1e-9 * chart.visibleRms);
        EXPECT_EQ(chart.visibleMax, double(truth.back()));
        // The percentile lies between the samples around it, and bins are 0.4 % wide.
        const double rank = 0.99 * double(truth.size());
        const auto below = std::size_t(std::max(0.0, std::floor(rank) - 1)),
                   above = std::min(truth.size() - 1, std::size_t(std::ceil(rank)));
        EXPECT_GE(chart.visibleP99, 0.995 * double(truth[below]));
        EXPECT_LE(chart.visibleP99, 1.005 * double(truth[above]));
        EXPECT_EQ(chart.worst, (std::array{worst.x, worst.y}));
        // A filter inside the rectangle reads one texel more on each side, as far as the map has one.
        EXPECT_EQ(chart.first, (std::array{std::max(rectangle.low.x - 1, 0), std::max(rectangle.low.y - 1, 0)}));
        texels += chart.texels;
    }
    int covered = 0;
    for (const Rectangle& each : rectangles) covered += each.texels();
    EXPECT_EQ(texels, covered);
    EXPECT_TRUE(std::ranges::is_sorted(summary.largest, std::ranges::greater{}, &ChartFigures::texels));
    EXPECT_LE(std::ranges::max(summary.largest, {}, &ChartFigures::texels).texels, 81);
    const Json inStrips = toJson(summaryOf(*charts, visible, 16, kBytes));
    EXPECT_EQ(inStrips, toJson(summaryOf(*charts, visible, 16, kBytes)));
    for (const int height : {32, 128}) {
        // Sums of squares depend on the cut, as all figures that are merged; the rest does not.
        const Json other = toJson(summaryOf(*charts, visible, height, kBytes));
        for (std::size_t i = 0; i < summary.largest.size(); ++i)
            for (const char* key : {"number", "texels", "bytes", "visible_p99", "visible_max", "worst"})
                EXPECT_EQ(inStrips["largest"][i][key], other["largest"][i][key]) << key;
    }
}

TEST(ChartErrors, MapsWithoutChartsHaveNone) {
    EXPECT_FALSE(MapCharts::of({}, kChartMapSide, kChartMapSide));
    const TriangleMesh outside = atlas::rectangle({0.5f, 0.5f}, {1.5f, 0.7f}), inside = atlas::rectangle({0.1f, 0.1f}, {0.2f, 0.2f});
    const TriangleMesh *wrong = &outside, *right = &inside;
    EXPECT_FALSE(MapCharts::of({&wrong, 1}, kChartMapSide, kChartMapSide));
    EXPECT_TRUE(MapCharts::of({&right, 1}, kChartMapSide, kChartMapSide));
    EXPECT_FALSE(MapCharts::of({&right, 1}, 1 << 14, 1 << 14)) << "too large to be told apart in little memory";
}

}  // namespace
}  // namespace lightcook::pipeline

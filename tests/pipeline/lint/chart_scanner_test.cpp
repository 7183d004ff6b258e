// Charts that are found row by row, in parts of any height, beside those that a flood fill finds.
#include "pipeline/lint/chart_scanner.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "formats/archive.h"

namespace lightcook::pipeline {
namespace {

using Rows = std::vector<std::vector<float>>;

/// A map of random charts: gaps, black texels, usual light, and few bright texels.
Rows randomMap(int width, int height, std::mt19937& random) {
    std::uniform_real_distribution<float> share(0, 1);
    const float gaps = share(random);
    Rows rows(static_cast<std::size_t>(height), std::vector<float>(static_cast<std::size_t>(width)));
    for (auto& row : rows)
        for (float& light : row) {
            const float kind = share(random);
            light = share(random) < gaps ? -1 : kind < 0.4f ? 0 : kind < 0.99f ? 0.5f + share(random) : 5000 * share(random);
        }
    return rows;
}

/// Returns the charts without their fireflies.
ChartFacts floodFilled(Rows rows) {
    ChartFacts facts;
    const int height = static_cast<int>(rows.size()), width = static_cast<int>(rows.front().size());
    const auto at = [&](int x, int y) -> float& { return rows[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)]; };
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            if (at(x, y) < 0) continue;
            std::vector<std::pair<int, int>> open = {{x, y}};
            std::int64_t texels = 0;
            bool isLit = false;
            while (!open.empty()) {
                const auto [u, v] = open.back();
                open.pop_back();
                if (u < 0 || v < 0 || u >= width || v >= height || at(u, v) < 0) continue;
                isLit = isLit || at(u, v) > 0;
                ++texels;
                at(u, v) = -1;
                for (int i = -1; i <= 1; ++i)
                    for (int j = -1; j <= 1; ++j) open.emplace_back(u + i, v + j);
            }
            ++facts.charts;
            if (isLit) continue;
            ++facts.blackCharts;
            facts.blackTexels += texels;
        }
    return facts;
}

/// partOf  height of the part that begins at a row
template <class PartOf>
ChartFacts scanned(const Rows& rows, PartOf partOf) {
    ChartScanner scanner(static_cast<int>(rows.front().size()), 100);
    for (std::size_t y = 0; y < rows.size();) {
        ChartRows part;
        for (const std::size_t end = std::min(rows.size(), y + partOf()); y < end; ++y) part.addRow(rows[y]);
        const auto kept = formats::unarchived<ChartRows>(formats::archived(part));
        EXPECT_TRUE(kept);
        scanner.add(kept.value_or(ChartRows()));
    }
    return scanner.finish();
}

TEST(ChartScanner, FindsTheChartsOfAFloodFillInPartsOfAnyHeight) {
    std::mt19937 random(3);
    std::int64_t black = 0, fireflies = 0;
    for (int i = 0; i < 1000; ++i) {
        const Rows rows = randomMap(1 + static_cast<int>(random() % 24), 1 + static_cast<int>(random() % 24), random);
        const ChartFacts expected = floodFilled(rows), whole = scanned(rows, [&] { return rows.size(); });
        EXPECT_EQ(whole.charts, expected.charts);
        EXPECT_EQ(whole.blackCharts, expected.blackCharts);
        EXPECT_EQ(whole.blackTexels, expected.blackTexels);
        for (const ChartFacts& cut :
             {scanned(rows, [] { return 1; }), scanned(rows, [] { return 2; }), scanned(rows, [&] { return 1 + random() % 6; })}) {
            EXPECT_EQ(cut.charts, whole.charts);
            EXPECT_EQ(cut.blackCharts, whole.blackCharts);
            EXPECT_EQ(cut.blackTexels, whole.blackTexels);
            EXPECT_EQ(cut.rimFireflies, whole.rimFireflies);
            EXPECT_EQ(cut.worstRimRatio, whole.worstRimRatio);
            EXPECT_EQ(std::tuple(cut.worst.x, cut.worst.y, cut.worst.light, cut.worst.brightest),
                      std::tuple(whole.worst.x, whole.worst.y, whole.worst.light, whole.worst.brightest));
        }
        black += whole.blackCharts;
        fireflies += whole.rimFireflies;
    }
    EXPECT_GT(black, 100);
    EXPECT_GT(fireflies, 100);
}

}  // namespace
}  // namespace lightcook::pipeline

#include "compress/light_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <queue>
#include <random>
#include <set>

#include "tests/compress/synthetic_light_map.h"

namespace lightcook {
namespace {

using compress::kChartBlock;

formats::LightMapStrip emptyBand(int width, int height) {
    formats::LightMapStrip band;
    band.sh = formats::Image<lighting::ShRgb>(width, height, lighting::ShRgb{});
    band.covered = formats::Image<std::uint8_t>(width, height, 0);
    band.normal = formats::Image<glm::vec3>(width, height, glm::vec3(0, 0, 1));
    return band;
}

/// Returns the charts by a flood fill over texels: from each to its eight neighbours and to all covered texels of its block.
std::vector<int> floodedCharts(const formats::LightMapStrip& band) {
    const int width = band.sh.width(), height = band.sh.height(), across = (width + kChartBlock - 1) / kChartBlock;
    const int blocks = across * ((height + kChartBlock - 1) / kChartBlock);
    std::vector<int> charts(static_cast<std::size_t>(blocks), -1);
    const auto blockOf = [&](int x, int y) { return static_cast<std::size_t>(y / kChartBlock * across + x / kChartBlock); };
    int next = 0;
    for (int block = 0; block < blocks; ++block) {
        std::queue<std::pair<int, int>> open;
        const auto visitBlock = [&](std::size_t which) {
            if (charts[which] >= 0) return;
            const int left = static_cast<int>(which) % across * kChartBlock, top = static_cast<int>(which) / across * kChartBlock;
            for (int y = top; y < std::min(top + kChartBlock, height); ++y)
                for (int x = left; x < std::min(left + kChartBlock, width); ++x)
                    if (band.covered.at(x, y) != 0) {
                        charts[which] = next;
                        open.push({x, y});
                    }
        };
        visitBlock(static_cast<std::size_t>(block));
        if (open.empty()) continue;
        while (!open.empty()) {
            const auto [x, y] = open.front();
            open.pop();
            for (int ny = std::max(y - 1, 0); ny <= std::min(y + 1, height - 1); ++ny)
                for (int nx = std::max(x - 1, 0); nx <= std::min(x + 1, width - 1); ++nx)
                    if (band.covered.at(nx, ny) != 0) visitBlock(blockOf(nx, ny));
        }
        ++next;
    }
    return charts;
}

TEST(LightMapBlocks, ChartsAreThoseOfAFloodTexelByTexel) {
    std::mt19937 random(7);
    for (int round = 0; round < 60; ++round) {
        const int width = 5 + static_cast<int>(random() % 60), height = 5 + static_cast<int>(random() % 60);
        const unsigned share = 3 + random() % 40;  // of a hundred texels
        formats::LightMapStrip band = emptyBand(width, height);
        for (std::uint8_t& covered : band.covered.texels()) covered = random() % 100 < share;
        compress::LightMapBlocks blocks(width, height);
        blocks.add(band, 0, height);
        EXPECT_EQ(blocks.chartOfBlock(), floodedCharts(band)) << round;
    }
}

/// Returns labels of blocks, propagated to neighbours and along islands until nothing changes; -1 for a block without texels and island.
std::vector<int> spreadLabels(const formats::LightMapStrip& band, const std::vector<formats::IslandRun>& islands) {
    const int width = band.sh.width(), height = band.sh.height(), across = (width + kChartBlock - 1) / kChartBlock;
    std::vector<int> labels(static_cast<std::size_t>(across) * static_cast<std::size_t>((height + kChartBlock - 1) / kChartBlock), -1);
    const auto at = [&](int x, int y) -> int& { return labels[static_cast<std::size_t>(y / kChartBlock * across + x / kChartBlock)]; };
    const auto isRead = [&](const formats::IslandRun& run, int x) { return run.isInside || band.covered.at(x, run.row) != 0; };
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            if (band.covered.at(x, y) != 0) at(x, y) = y / kChartBlock * across + x / kChartBlock;
    for (const formats::IslandRun& run : islands)
        for (int x = run.begin; x < run.end; ++x)
            if (isRead(run, x)) at(x, run.row) = run.row / kChartBlock * across + x / kChartBlock;
    for (bool changed = true; changed;) {
        changed = false;
        const auto lower = [&](int& label, int to) {
            changed = changed || to < label;
            label = std::min(label, to);
        };
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                for (int ny = std::max(y - 1, 0); ny <= std::min(y + 1, height - 1); ++ny)
                    for (int nx = std::max(x - 1, 0); nx <= std::min(x + 1, width - 1); ++nx)
                        if (band.covered.at(x, y) != 0 && band.covered.at(nx, ny) != 0) lower(at(x, y), at(nx, ny));
        std::map<int, int> lowest;
        for (const bool writes : {false, true})
            for (const formats::IslandRun& run : islands)
                for (int x = run.begin; x < run.end; ++x) {
                    if (!isRead(run, x)) continue;
                    int& least = lowest.try_emplace(run.island, at(x, run.row)).first->second;
                    if (writes)
                        lower(at(x, run.row), least);
                    else
                        least = std::min(least, at(x, run.row));
                }
    }
    return labels;
}

TEST(LightMapBlocks, AnIslandOfAMeshIsOneChart) {
    std::mt19937 random(8);
    for (int round = 0; round < 200; ++round) {
        const int width = 5 + static_cast<int>(random() % 50), height = 5 + static_cast<int>(random() % 50);
        const unsigned share = random() % 12;  // of a hundred texels; none in some maps
        formats::LightMapStrip band = emptyBand(width, height);
        for (std::uint8_t& covered : band.covered.texels()) covered = random() % 100 < share;
        std::vector<formats::IslandRun> islands;
        for (unsigned i = 0; i < random() % 20; ++i) {
            const int begin = static_cast<int>(random() % static_cast<unsigned>(width));
            islands.push_back({static_cast<int>(random() % 6), static_cast<int>(random() % static_cast<unsigned>(height)), begin,
                               begin + 1 + static_cast<int>(random() % static_cast<unsigned>(width - begin)), random() % 3 == 0});
        }
        compress::LightMapBlocks blocks(width, height);
        blocks.add(band, 0, height);
        const std::vector<int> charts = blocks.chartOfBlock(islands), truth = spreadLabels(band, islands), covered = blocks.chartOfBlock();
        const bool anyLight = std::ranges::any_of(covered, [](int chart) { return chart >= 0; });
        std::map<int, int> chartOf, labelOf;  // labelOf: of sets with light
        int next = 0;
        for (std::size_t i = 0; i < charts.size(); ++i) {
            ASSERT_EQ(charts[i] >= 0, truth[i] >= 0 && anyLight) << round;
            if (charts[i] < 0) continue;
            EXPECT_EQ(chartOf.try_emplace(truth[i], charts[i]).first->second, charts[i]) << round << ": one set, one chart";
            if (covered[i] < 0) continue;
            EXPECT_EQ(labelOf.try_emplace(charts[i], truth[i]).first->second, truth[i]) << round << ": one chart, one set with light";
            EXPECT_LE(charts[i], next);
            next = std::max(next, charts[i] + 1);
        }
        for (const int chart : charts) EXPECT_LT(chart, std::max(next, 1)) << "no chart without light";
    }
}

TEST(LightMapBlocks, ChosenBlocksStandForTheWholeMap) {
    constexpr int kSize = 512;
    const formats::LightMapStrip band = synthetic::makeBand(synthetic::Kind::Gradient, kSize, 0, kSize);
    compress::LightMapBlocks blocks(kSize, kSize);
    for (int row = 0; row < kSize; row += 64) blocks.add(band, row, 64);
    const std::vector<int> charts = blocks.chartOfBlock();
    const auto choices = blocks.choose(charts, 3000);
    EXPECT_NEAR(static_cast<double>(choices.size()), 3000, 600);
    std::set<int> seen;
    double count = 0, coveredBlocks = 0;
    int last = -1;
    for (const auto& choice : choices) {
        EXPECT_GT(choice.block, last);
        last = choice.block;
        EXPECT_GE(choice.weight, 1);
        seen.insert(charts[static_cast<std::size_t>(choice.block)]);
        count += static_cast<double>(choice.weight);
    }
    std::set<int> all(charts.begin(), charts.end());
    all.erase(-1);
    for (const int chart : charts) coveredBlocks += chart >= 0;
    EXPECT_EQ(seen, all) << "every chart has a block";
    EXPECT_NEAR(count, coveredBlocks, 0.1 * coveredBlocks);
}

TEST(LightMapBlocks, TheOneBrightBlockOfADarkChartIsChosen) {
    constexpr int kSize = 256;
    formats::LightMapStrip band = emptyBand(kSize, kSize);
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
            band.covered.at(x, y) = x != 128 && x != 129;
            band.sh.at(x, y)[0] = glm::vec3(x < 128 ? 100.0f : 0.001f);
        }
    band.sh.at(201, 77)[0] = glm::vec3(50);
    compress::LightMapBlocks blocks(kSize, kSize);
    blocks.add(band, 0, kSize);
    bool found = false;
    for (const auto& choice : blocks.choose(blocks.chartOfBlock(), 20)) found = found || choice.block == 77 / 4 * (kSize / 4) + 201 / 4;
    EXPECT_TRUE(found);
}

TEST(LightMapSamples, HoldTheirBlocksAndMarginsForAnyCut) {
    using compress::LightMapSamples;
    constexpr int kWidth = 61, kHeight = 50;
    const formats::LightMapStrip band = synthetic::makeBand(synthetic::Kind::Gradient, kWidth, 0, kHeight);
    compress::LightMapBlocks blocks(kWidth, kHeight);
    blocks.add(band, 0, kHeight);
    LightMapSamples samples(blocks.choose(blocks.chartOfBlock(), 40), blocks.across());
    for (const int row : {32, 0, 16, 48}) {
        const int first = std::max(row - LightMapSamples::kMargin, 0), end = std::min(row + 16 + LightMapSamples::kMargin, kHeight);
        samples.add(synthetic::makeBand(synthetic::Kind::Gradient, kWidth, first, end - first), row, std::min(16, kHeight - row));
    }
    ASSERT_EQ(samples.texels().sh.width(), static_cast<int>(samples.choices().size()) * LightMapSamples::kSide);
    for (std::size_t i = 0; i < samples.choices().size(); ++i)
        for (int y = 0; y < LightMapSamples::kSide; ++y)
            for (int x = 0; x < LightMapSamples::kSide; ++x) {
                const int mapX = samples.choices()[i].block % blocks.across() * kChartBlock + x - LightMapSamples::kMargin;
                const int mapY = samples.choices()[i].block / blocks.across() * kChartBlock + y - LightMapSamples::kMargin;
                const int place = static_cast<int>(i) * LightMapSamples::kSide + x;
                const bool inside = 0 <= mapX && mapX < kWidth && 0 <= mapY && mapY < kHeight;
                ASSERT_EQ(samples.texels().covered.at(place, y), inside ? band.covered.at(mapX, mapY) : 0);
                if (!inside || band.covered.at(mapX, mapY) == 0) continue;
                EXPECT_EQ(samples.texels().sh.at(place, y), band.sh.at(mapX, mapY));
                EXPECT_EQ(samples.texels().normal.at(place, y), band.normal.at(mapX, mapY));
            }
}

}  // namespace
}  // namespace lightcook

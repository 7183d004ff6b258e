// The 4 x 4 blocks of a map (LightMapBlocks), and copies of those that a learned layout is fitted to (LightMapSamples).
//
// 1. add() records the covered texels and the light of each block, strip by strip.
// 2. chartOfBlock() joins blocks whose covered texels touch (compared as 16-bit masks), and blocks of one island of a mesh, by union-find.
//    Charts are numbered in the order of their first blocks.
// 3. choose() is systematic sampling with unequal probabilities: it visits the blocks in order and adds up the probability of each, chart
//    by chart; a block is chosen each time the sum reaches 1. The choice is spread evenly, and needs no random numbers.
#include "compress/light_map.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>

#include "formats/disjoint_sets.h"

namespace lightcook::compress {

namespace {

using formats::LightMapStrip;

bool holds(std::uint16_t mask, int x, int y) {
    return 0 <= y && y < kChartBlock && ((mask >> (kChartBlock * y + x)) & 1) != 0;
}

/// Returns true if a covered texel of a block's right column touches one in the left column of the next block, `down` block rows below
/// (-1, 0, 1).
bool touchesRight(std::uint16_t left, std::uint16_t right, int down) {
    for (int y = 0; y < kChartBlock; ++y)
        for (int dy = -1; dy <= 1; ++dy)
            if (holds(left, kChartBlock - 1, y) && holds(right, 0, y + dy - down * kChartBlock)) return true;
    return false;
}
bool touchesBelow(std::uint16_t above, std::uint16_t below) {
    for (int x = 0; x < kChartBlock; ++x)
        for (int dx = std::max(x - 1, 0); dx <= std::min(x + 1, kChartBlock - 1); ++dx)
            if (holds(above, x, kChartBlock - 1) && holds(below, dx, 0)) return true;
    return false;
}

/// Returns the number of each block's set, or -1 for a block that neither has covered texels nor is held by an island. Sets with covered
/// texels are numbered in the order of their first blocks. A set without them takes the number of the block before it, which shortens the
/// run-length encoded index.
std::vector<int> numbered(formats::DisjointSets& sets, const std::vector<std::uint16_t>& covered, const std::vector<bool>& isHeld) {
    const auto count = static_cast<std::uint32_t>(covered.size());
    std::vector<int> ofSet(covered.size(), -1), charts(covered.size(), -1);
    int next = 0;
    for (std::uint32_t block = 0; block < count; ++block) {
        int& chart = ofSet[sets.find(block)];
        if (covered[block] != 0 && chart < 0) chart = next++;
    }
    int last = 0;
    for (std::uint32_t block = 0; block < count && next > 0; ++block) {
        if (covered[block] == 0 && !isHeld[block]) continue;
        int& chart = ofSet[sets.find(block)];
        if (chart < 0) chart = last;
        last = charts[block] = chart;
    }
    return charts;
}

}  // namespace

LightMapBlocks::LightMapBlocks(int width, int height)
    : across_((width + kChartBlock - 1) / kChartBlock),
      width_(width),
      height_(height),
      covered_(static_cast<std::size_t>(across_) * static_cast<std::size_t>((height + kChartBlock - 1) / kChartBlock)),
      light_(covered_.size()) {}

void LightMapBlocks::add(const LightMapStrip& strip, int firstRow, int rowCount) {
    assert(firstRow % kChartBlock == 0 && (rowCount % kChartBlock == 0 || firstRow + rowCount == height_));
    for (int y = firstRow; y < firstRow + rowCount; ++y) {
        const std::size_t row = static_cast<std::size_t>(y / kChartBlock) * static_cast<std::size_t>(across_);
        for (int x = 0; x < width_; ++x) {
            if (strip.covered.at(x, y - strip.firstRow) == 0) continue;
            const std::size_t block = row + static_cast<std::size_t>(x / kChartBlock);
            covered_[block] |= static_cast<std::uint16_t>(1u << (kChartBlock * (y % kChartBlock) + x % kChartBlock));
            const glm::dvec3 dc(strip.sh.at(x, y - strip.firstRow)[0]);
            light_[block] += glm::dot(dc, dc);
        }
    }
}

template <class Visit>
void LightMapBlocks::forEachBlock(const formats::IslandRun& run, Visit visit) const {
    if (run.row < 0 || run.row >= height_) return;
    const int begin = std::max(run.begin, 0), end = std::min(run.end, width_);
    for (int x = begin; x < end; x = (x / kChartBlock + 1) * kChartBlock) {
        const int block = run.row / kChartBlock * across_ + x / kChartBlock;
        bool isTouched = run.isInside;
        for (int column = x; column < std::min(end, (x / kChartBlock + 1) * kChartBlock); ++column)
            isTouched = isTouched || holds(covered_[static_cast<std::size_t>(block)], column % kChartBlock, run.row % kChartBlock);
        if (isTouched) visit(block);
    }
}

std::vector<int> LightMapBlocks::chartOfBlock(std::span<const formats::IslandRun> islands) const {
    formats::DisjointSets sets(covered_.size());
    const auto join = [&](int a, int b) { sets.join(static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b)); };
    const auto mask = [&](int block) { return covered_[static_cast<std::size_t>(block)]; };
    for (int block = 0; block < count(); ++block) {
        if (mask(block) == 0) continue;
        const bool hasRight = block % across_ + 1 < across_, hasBelow = block + across_ < count();
        if (hasRight && touchesRight(mask(block), mask(block + 1), 0)) join(block, block + 1);
        if (hasBelow && touchesBelow(mask(block), mask(block + across_))) join(block, block + across_);
        if (hasRight && hasBelow && touchesRight(mask(block), mask(block + across_ + 1), 1)) join(block, block + across_ + 1);
        if (hasRight && block >= across_ && touchesRight(mask(block), mask(block - across_ + 1), -1)) join(block, block - across_ + 1);
    }
    std::vector<bool> isHeld(covered_.size(), false);
    std::vector<int> firstOf;  // [island] first block
    for (const formats::IslandRun& run : islands)
        forEachBlock(run, [&](int block) {
            if (static_cast<std::size_t>(run.island) >= firstOf.size()) firstOf.resize(static_cast<std::size_t>(run.island) + 1, -1);
            int& first = firstOf[static_cast<std::size_t>(run.island)];
            if (first < 0) first = block;
            join(first, block);
            isHeld[static_cast<std::size_t>(block)] = true;
        });
    return numbered(sets, covered_, isHeld);
}

namespace {

/// Sums of one chart, and the progress of its choice.
struct ChartLight {
    int brightest = -1, blockCount = 0;
    double brightestLight = -1;
    double light = 0;
    double due = 0.5;  ///< sum of probabilities; a block is chosen each time it reaches 1, which is then subtracted
    double brightestChosen = -1;
};

std::vector<ChartLight> lightOfCharts(const std::vector<int>& chartOfBlock, const std::vector<std::uint16_t>& covered,
                                      const std::vector<double>& light) {
    std::vector<ChartLight> out;
    for (std::size_t i = 0; i < covered.size(); ++i) {
        if (covered[i] == 0) continue;
        const auto index = static_cast<std::size_t>(chartOfBlock[i]);
        if (index >= out.size()) out.resize(index + 1);
        ChartLight& chart = out[index];
        ++chart.blockCount;
        chart.light += light[i];
        if (light[i] > chart.brightestLight) {
            chart.brightestLight = light[i];
            chart.brightest = static_cast<int>(i);
        }
    }
    return out;
}

}  // namespace

std::vector<LightMapBlocks::Choice> LightMapBlocks::choose(const std::vector<int>& chartOfBlock, int budget) const {
    assert(chartOfBlock.size() == covered_.size());
    std::vector<ChartLight> lights = lightOfCharts(chartOfBlock, covered_, light_);
    double coveredBlocks = 0, light = 0, roots = 0;
    for (std::size_t i = 0; i < covered_.size(); ++i) {
        if (covered_[i] == 0) continue;
        coveredBlocks += 1;
        light += light_[i];
    }
    for (const ChartLight& chart : lights) roots += std::sqrt(chart.light);
    std::vector<Choice> choices;
    for (std::size_t i = 0; i < covered_.size(); ++i) {
        if (covered_[i] == 0) continue;
        ChartLight& chart = lights[static_cast<std::size_t>(chartOfBlock[i])];
        const double byArea = 1 / coveredBlocks, byLight = light > 0 ? light_[i] / light : byArea;
        const double byChart = roots > 0 ? std::sqrt(chart.light) / roots / chart.blockCount : byArea;
        const double probability = std::min(1.0, budget * (0.25 * byArea + 0.25 * byLight + 0.5 * byChart));
        chart.due += probability;
        if (chart.due < 1) continue;
        chart.due -= 1;
        chart.brightestChosen = std::max(chart.brightestChosen, light_[i]);
        choices.push_back({static_cast<int>(i), static_cast<float>(1 / probability)});
    }
    // The sample of each chart must hold a block at least half as bright as its brightest.
    for (const ChartLight& chart : lights)
        if (chart.brightest >= 0 && !(chart.brightestChosen >= 0.5 * chart.brightestLight))
            choices.push_back({chart.brightest, chart.brightestChosen < 0 ? static_cast<float>(chart.blockCount) : 1.0f});
    std::ranges::sort(choices, {}, &Choice::block);
    return choices;
}

LightMapSamples::LightMapSamples(std::vector<LightMapBlocks::Choice> choices, int blocksAcross)
    : across_(blocksAcross), choices_(std::move(choices)) {
    const int width = kSide * static_cast<int>(choices_.size());
    texels_.sh = formats::Image<lighting::ShRgb>(width, kSide, lighting::ShRgb{});
    texels_.covered = formats::Image<std::uint8_t>(width, kSide, 0);
    texels_.normal = formats::Image<glm::vec3>(width, kSide, glm::vec3(0, 0, 1));
}

void LightMapSamples::add(const LightMapStrip& strip, int firstRow, int rowCount) {
    const int firstBlock = firstRow / kChartBlock * across_;
    auto chosen = std::ranges::lower_bound(choices_, firstBlock, {}, &LightMapBlocks::Choice::block);
    for (; chosen != choices_.end(); ++chosen) {
        const int top = chosen->block / across_ * kChartBlock - kMargin, left = chosen->block % across_ * kChartBlock - kMargin;
        if (top + kMargin >= firstRow + rowCount) break;
        const int place = kSide * static_cast<int>(chosen - choices_.begin());
        const int bottom = std::min(top + kSide, strip.firstRow + strip.sh.height()), right = std::min(left + kSide, strip.sh.width());
        for (int y = std::max(top, strip.firstRow); y < bottom; ++y)
            for (int x = std::max(left, 0); x < right; ++x) {
                texels_.sh.at(place + x - left, y - top) = strip.sh.at(x, y - strip.firstRow);
                texels_.covered.at(place + x - left, y - top) = strip.covered.at(x, y - strip.firstRow);
                texels_.normal.at(place + x - left, y - top) = strip.normal.at(x, y - strip.firstRow);
            }
    }
}

}  // namespace lightcook::compress

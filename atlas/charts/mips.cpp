// A level is checked row by row, in memory for one row of the level. First each texel of the row gets the number of the chart that it
// holds. Then every run whose filter reaches the row is compared with the texels that it reads.
#include "atlas/mips.h"

#include <algorithm>
#include <cstddef>
#include <optional>

#include "formats/disjoint_sets.h"

namespace lightcook::atlas {
namespace {

constexpr std::int64_t kEmpty = -1, kMixed = -2;  ///< beside the number of a chart

/// Texels of a level along one axis, both ends included.
struct Reach {
    int first, last;
};

/// Returns floor(a / b) for b > 0.
int floorDiv(int a, int b) {
    return a >= 0 ? a / b : -((b - 1 - a) / b);
}

/// Returns the texels with a weight in a bilinear filter at the places of [begin, end), borders between texels of level 0.
/// side   of a texel of the level [texels of level 0]
/// count  texels of the level along the axis
Reach reachOf(int begin, int end, int side, int count) {
    // A place p has the coordinate u = p / side - 1/2, where whole numbers are texel centres; it reads floor(u) and ceil(u).
    const int first = floorDiv(2 * begin - side, 2 * side), last = -floorDiv(side - 2 * end, 2 * side);
    return {std::clamp(first, 0, count - 1), std::clamp(last, 0, count - 1)};
}

/// The runs of a map by rows.
class RunRows {
public:
    RunRows(std::span<const CoveredRun> runs, int height) : runs_(runs), first_(static_cast<std::size_t>(height) + 1) {
        std::size_t next = 0;
        for (int row = 0; row <= height; ++row) {
            while (next < runs.size() && runs[next].row < row) ++next;
            first_[static_cast<std::size_t>(row)] = next;
        }
    }
    std::span<const CoveredRun> row(int y) const {
        const std::size_t begin = first_[static_cast<std::size_t>(y)];
        return runs_.subspan(begin, first_[static_cast<std::size_t>(y) + 1] - begin);
    }

private:
    std::span<const CoveredRun> runs_;
    std::vector<std::size_t> first_;  ///< [row]
};

/// Returns the first texel of a level that is read from within a chart and holds another one. Empty for a safe level.
std::optional<glm::ivec2> firstUnsafe(const RunRows& rows, int width, int height, int level) {
    const int side = 1 << level, levelWidth = width / side, levelHeight = height / side;
    std::vector<std::int64_t> holds(static_cast<std::size_t>(levelWidth));
    for (int y = 0; y < levelHeight; ++y) {
        std::ranges::fill(holds, kEmpty);
        for (int row = y * side; row < (y + 1) * side; ++row)
            for (const CoveredRun& run : rows.row(row))
                for (int x = run.begin / side; x <= (run.end - 1) / side; ++x) {
                    std::int64_t& chart = holds[static_cast<std::size_t>(x)];
                    chart = chart == kEmpty || chart == run.chart ? std::int64_t{run.chart} : kMixed;
                }
        for (int row = std::max(0, y * side - side); row < std::min(height, (y + 2) * side); ++row) {
            const Reach down = reachOf(row, row + 1, side, levelHeight);
            if (y < down.first || y > down.last) continue;
            for (const CoveredRun& run : rows.row(row)) {
                const Reach across = reachOf(run.begin, run.end, side, levelWidth);
                for (int x = across.first; x <= across.last; ++x)
                    if (const std::int64_t chart = holds[static_cast<std::size_t>(x)]; chart != kEmpty && chart != run.chart)
                        return glm::ivec2(x, y);
            }
        }
    }
    return std::nullopt;
}

}  // namespace

std::vector<CoveredRun> coveredRuns(const formats::LightMapStrip& strip) {
    const int width = strip.covered.width();
    const auto chartAt = [&](int x, int y) { return strip.chart.width() > 0 ? strip.chart.at(x, y) : formats::kAnyChart; };
    std::vector<CoveredRun> runs;
    for (int y = 0; y < strip.covered.height(); ++y)
        for (int x = 0; x < width;) {
            if (strip.covered.at(x, y) == 0) {
                ++x;
                continue;
            }
            const int begin = x;
            const std::uint32_t chart = chartAt(begin, y);
            while (x < width && strip.covered.at(x, y) != 0 && chartAt(x, y) == chart) ++x;
            runs.push_back({strip.firstRow + y, begin, x, chart});
        }
    return runs;
}

void findMipCharts(std::span<CoveredRun> runs) {
    formats::DisjointSets charts(runs.size());
    std::size_t above = 0;  // first run of the row above that may still touch
    for (std::size_t i = 0; i < runs.size(); ++i) {
        const CoveredRun& run = runs[i];
        while (above < i && (runs[above].row < run.row - 1 || (runs[above].row == run.row - 1 && runs[above].end < run.begin))) ++above;
        for (std::size_t j = above; j < i && runs[j].row == run.row - 1 && runs[j].begin <= run.end; ++j)
            charts.join(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j));
    }
    for (std::size_t i = 0; i < runs.size(); ++i) runs[i].chart = charts.find(static_cast<std::uint32_t>(i)) + 1;
}

MipLevels safeMipLevels(std::span<const CoveredRun> runs, int width, int height) {
    const RunRows rows(runs, height);
    MipLevels levels;
    for (; width % (kLevelStep << levels.count) == 0 && height % (kLevelStep << levels.count) == 0; ++levels.count)
        if (const auto unsafe = firstUnsafe(rows, width, height, levels.count)) {
            levels.end = MipLevels::End::Charts;
            levels.texel = *unsafe;
            break;
        }
    return levels;
}

}  // namespace lightcook::atlas

#include "pipeline/report/chart_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "pipeline/report/page_parts.h"
#include "pipeline/report/treemap.h"

namespace lightcook::pipeline {
namespace {

constexpr std::size_t kShownWorst = 6;

/// A range of visible errors that has one colour, up to its end [Delta E ITP].
struct ErrorClass {
    double end;
    const char *color, *words;
};
constexpr std::array<ErrorClass, 5> kClasses = {{{1, "var(--error-0)", "below 1"},
                                                 {2, "var(--error-1)", "1 to 2"},
                                                 {5, "var(--error-2)", "2 to 5"},
                                                 {10, "var(--error-3)", "5 to 10"},
                                                 {HUGE_VAL, "var(--error-4)", "10 or more"}}};

const char* colorOf(double visible) {
    const auto range = std::ranges::find_if(kClasses, [&](const ErrorClass& each) { return visible < each.end; });
    return range != kClasses.end() ? range->color : "var(--track)";
}

std::string chartName(const Json& chart) {
    return fmt::format("chart {}", count(member(chart, "number")));
}

/// Returns "12, 34"; a dash where there are no two numbers.
std::string pairWords(const Json& pair) {
    if (!pair.is_array() || pair.size() != 2) return kDash;
    return fmt::format("{}, {}", count(pair[0]), count(pair[1]));
}

TreemapTile tileOf(const Json& chart, const std::string& name) {
    const std::string detail = fmt::format("{} texels, visible error {} for 99 %, at most {} at texel {}",
                                           groupedCount(count(member(chart, "texels"))), humanNumber(number(member(chart, "visible_p99"))),
                                           humanNumber(number(member(chart, "visible_max"))), pairWords(member(chart, "worst")));
    return {name, detail, colorOf(number(member(chart, "visible_p99"))), "", count(member(chart, "bytes"))};
}

Html legend() {
    Html ranges;
    for (const ErrorClass& each : kClasses)
        ranges += element("span",
                          element("i", {{"class", "swatch"}, {"style", fmt::format("background:{}", each.color)}}, {}) + word(each.words));
    return element("p", {{"class", "soft error-classes"}}, ranges);
}

Html chartTable(const Json& largest) {
    std::vector<const Json*> worst;
    for (const Json& chart : largest)
        if (number(member(chart, "visible_p99")) >= 1) worst.push_back(&chart);
    std::ranges::stable_sort(worst, std::ranges::greater{}, [](const Json* chart) { return number(member(*chart, "visible_p99")); });
    worst.resize(std::min(worst.size(), kShownWorst));
    Html rows;
    for (const Json* chart : worst)
        rows += element("tr", element("th", {{"scope", "row"}}, text(chartName(*chart))) +
                                  numberCell(bytesMarkup(count(member(*chart, "bytes")))) +
                                  numberCell(text(pairWords(member(*chart, "first")))) +
                                  numberCell(text(pairWords(member(*chart, "size")))) + numberCell(visibleNumber(*chart, "visible_p99")) +
                                  numberCell(visibleNumber(*chart, "visible_max")) + numberCell(text(pairWords(member(*chart, "worst")))));
    if (rows.isEmpty()) return {};
    return table("charts",
                 element("tr", headCell("Most visible") + headCell("GPU", "num") + headCell("From texel", "num") + headCell("Size", "num") +
                                   headCell("p99", "num") + headCell("max", "num") + headCell("at texel", "num")),
                 rows);
}

}  // namespace

Html chartSection(const Json& asset) {
    const Json &charts = member(asset, "charts"), &largest = list(charts, "largest"), &rest = member(charts, "rest");
    std::vector<TreemapTile> tiles;
    std::uint64_t bytes = 0;
    for (const Json& chart : largest) tiles.push_back(tileOf(chart, chartName(chart)));
    const std::uint64_t total = count(member(charts, "count"));
    if (rest.is_object())
        tiles.push_back(tileOf(rest, fmt::format("{} smaller charts", total > largest.size() ? total - largest.size() : 0)));
    for (const TreemapTile& tile : tiles) bytes += tile.bytes;
    if (bytes == 0) return {};
    if (const std::uint64_t whole = count(member(asset, "bytes_gpu")); whole > bytes)
        tiles.push_back({"between charts", "texels that no chart holds", "var(--track)", "", whole - bytes});
    const std::string caption = fmt::format(
        "{} {}. Areas are GPU memory, colours the visible error that 99 % of a chart's texels stay under, at their own normals:",
        groupedCount(total), total == 1 ? "chart" : "charts");
    return element("div", {{"class", "notes"}},
                   element("h3", word("Charts: memory and visible errors")) + element("p", {{"class", "soft"}}, text(caption)) + legend() +
                       treemap(std::move(tiles), "GPU memory of each chart, coloured by its visible error") + chartTable(largest));
}

}  // namespace lightcook::pipeline

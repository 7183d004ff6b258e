#include "pipeline/report/frontier_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "pipeline/report/frontier.h"
#include "pipeline/report/page_parts.h"
#include "pipeline/report/plot.h"

namespace lightcook::pipeline {

namespace {

/// Returns the points that can be read; a damaged report may hold others.
std::vector<FrontierPoint> pointsOf(const Json& budget) {
    std::vector<FrontierPoint> points;
    for (const Json& each : list(budget, "frontier"))
        if (auto point = fromJson<FrontierPoint>(each, "frontier"); point && point->bytesGpu > 0) points.push_back(std::move(*point));
    return points;
}

/// Returns a position for an error. Errors that no display shows share the bottom of the plot.
double shownError(double visible) {
    constexpr double kLeastShown = 0.05;
    return std::max(visible, kLeastShown);
}

Html plot(const std::vector<FrontierPoint>& points, double limitBytes) {
    constexpr double kPlotWidth = 640, kPlotHeight = 280, kPlotLeft = 58, kPlotRight = 14, kPlotTop = 14, kPlotBottom = 38;
    double mostBytes = limitBytes > 0 ? limitBytes : 0, leastBytes = mostBytes > 0 ? mostBytes : HUGE_VAL, mostError = 0,
           leastError = HUGE_VAL;
    for (const FrontierPoint& point : points) {
        const auto bytes = static_cast<double>(point.bytesGpu);
        leastBytes = std::min(leastBytes, bytes);
        mostBytes = std::max(mostBytes, bytes);
        leastError = std::min(leastError, shownError(point.visible));
        mostError = std::max(mostError, shownError(point.visible));
    }
    constexpr double kKib = 1024;
    const Axis bytes(kPlotLeft, kPlotWidth - kPlotRight, leastBytes / kKib, mostBytes / kKib, 0.15),
        error(kPlotHeight - kPlotBottom, kPlotTop, leastError, mostError);
    Html drawing;
    for (const double tick : error.ticks()) {
        drawing += line("grid", kPlotLeft, error.at(tick), kPlotWidth - kPlotRight, error.at(tick));
        drawing += label("tick end", kPlotLeft - 7, error.at(tick) + 4, fmt::format("{:g}", tick));
    }
    // Powers of two, of which memory has round figures.
    for (int exponent = 0; exponent < 40; ++exponent) {
        const double tick = std::exp2(exponent), x = bytes.at(tick);
        if (x < kPlotLeft || x > kPlotWidth - kPlotRight) continue;
        drawing += line("grid", x, kPlotTop, x, kPlotHeight - kPlotBottom);
        drawing += label("tick middle", x, kPlotHeight - kPlotBottom + 15, humanBytes(static_cast<std::uint64_t>(tick * kKib)));
    }
    drawing += label("tick middle", (kPlotLeft + kPlotWidth - kPlotRight) / 2, kPlotHeight - 4, "GPU memory of the scene");
    if (limitBytes > 0) {
        const double x = bytes.at(limitBytes / kKib);
        drawing += line("limit", x, kPlotTop, x, kPlotHeight - kPlotBottom) + label("tick end limit", x - 5, kPlotTop + 8, "budget");
    }
    // A budget between two points buys the one on the left.
    std::string path;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const std::string x = place(bytes.at(static_cast<double>(points[i].bytesGpu) / kKib));
        if (i > 0) path += fmt::format(" {},{}", x, place(error.at(shownError(points[i - 1].visible))));
        path += fmt::format("{}{},{}", path.empty() ? "" : " ", x, place(error.at(shownError(points[i].visible))));
    }
    drawing += element("polyline", {{"class", "trendline"}, {"points", path}}, {});
    for (const FrontierPoint& point : points) {
        const Html tip =
            element("title", text(fmt::format("{}, {}: {}", humanBytes(point.bytesGpu), humanNumber(point.visible), layoutWords(point))));
        drawing += element("g", {{"class", point.isChosen ? "chosen" : "other"}},
                           element("circle",
                                   {{"class", "dot"},
                                    {"cx", place(bytes.at(static_cast<double>(point.bytesGpu) / kKib))},
                                    {"cy", place(error.at(shownError(point.visible)))},
                                    {"r", point.isChosen ? "6" : "4"}},
                                   tip));
    }
    return element("svg",
                   {{"class", "curve"},
                    {"viewBox", fmt::format("0 0 {} {}", kPlotWidth, kPlotHeight)},
                    {"role", "img"},
                    {"aria-label", "Visible error of the whole shading against GPU memory: the best allocations, this cook's marked"}},
                   drawing);
}

/// Returns what the next step costs or saves, in words.
std::string stepWords(const FrontierPoint& from, const FrontierPoint& to) {
    const bool isUp = to.bytesGpu > from.bytesGpu;
    return fmt::format("{} {} take the visible error from {} to {} ({}).",
                       humanBytes(isUp ? to.bytesGpu - from.bytesGpu : from.bytesGpu - to.bytesGpu), isUp ? "more" : "less",
                       humanNumber(from.visible), humanNumber(to.visible), layoutWords(to));
}

}  // namespace

Html frontierSection(const Json& budget) {
    const std::vector<FrontierPoint> points = pointsOf(budget);
    const auto chosen = std::ranges::find(points, true, &FrontierPoint::isChosen);
    if (points.size() < 2 || chosen == points.end()) return {};
    Html steps, rows;
    if (chosen + 1 != points.end()) steps += element("li", text(stepWords(*chosen, *(chosen + 1))));
    if (chosen != points.begin()) steps += element("li", text(stepWords(*chosen, *(chosen - 1))));
    for (const FrontierPoint& point : points)
        rows += element("tr", {{"class", point.isChosen ? "total" : ""}},
                        element("th", {{"scope", "row"}}, text(layoutWords(point) + (point.isChosen ? " (chosen)" : ""))) +
                            numberCell(bytesMarkup(point.bytesGpu)) +
                            numberCell(withTitle(humanNumber(point.visible), exactNumber(point.visible))));
    const Html all = element(
        "details",
        element("summary", text(fmt::format("All {} allocations", points.size()))) +
            table("frontier", element("tr", headCell("Layouts") + headCell("GPU memory", "num") + headCell("Visible p99", "num")), rows));
    const Json& limit = member(budget, "limit_bytes");
    return card(
        "What another budget buys",
        element("p", {{"class", "soft"}},
                word("Light maps and dominant lights share the memory. No other choice of their layouts has fewer bytes and no larger "
                     "visible error of the whole shading (p99 of the worst light map, as the trials measured it).")) +
            plot(points, limit.is_null() ? 0 : static_cast<double>(count(limit))) + element("ul", {{"class", "advice"}}, steps) + all);
}

}  // namespace lightcook::pipeline

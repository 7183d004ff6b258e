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

constexpr PlotArea kFrontierArea{640, 280, 58, 626, 14, 242};
constexpr double kKib = 1024;

double kibOf(const FrontierPoint& point) {
    return static_cast<double>(point.bytesGpu) / kKib;
}

/// The axes of the plot.
struct FrontierAxes {
    Axis kib, error;
    double x(const FrontierPoint& point) const { return kib.at(kibOf(point)); }
    double y(const FrontierPoint& point) const { return error.at(shownError(point.visible)); }
};

/// limitBytes  0: none
FrontierAxes axesOf(const std::vector<FrontierPoint>& points, double limitBytes) {
    double mostKib = limitBytes / kKib, leastKib = limitBytes > 0 ? mostKib : HUGE_VAL, mostError = 0, leastError = HUGE_VAL;
    for (const FrontierPoint& point : points) {
        leastKib = std::min(leastKib, kibOf(point));
        mostKib = std::max(mostKib, kibOf(point));
        leastError = std::min(leastError, shownError(point.visible));
        mostError = std::max(mostError, shownError(point.visible));
    }
    return {Axis(kFrontierArea.left, kFrontierArea.right, leastKib, mostKib, 0.15),
            Axis(kFrontierArea.bottom, kFrontierArea.top, leastError, mostError)};
}

/// Returns the lines and numbers of both axes.
Html frontierGrid(const FrontierAxes& axes) {
    Html drawing;
    for (const double tick : axes.error.ticks()) {
        drawing += line("grid", kFrontierArea.left, axes.error.at(tick), kFrontierArea.right, axes.error.at(tick));
        drawing += label("tick end", kFrontierArea.left - 7, axes.error.at(tick) + 4, fmt::format("{:g}", tick));
    }
    // Powers of two, of which memory has round figures.
    for (int exponent = 0; exponent < 40; ++exponent) {
        const double tick = std::exp2(exponent), x = axes.kib.at(tick);
        if (x < kFrontierArea.left || x > kFrontierArea.right) continue;
        drawing += line("grid", x, kFrontierArea.top, x, kFrontierArea.bottom);
        drawing += label("tick middle", x, kFrontierArea.bottom + 15, humanBytes(static_cast<std::uint64_t>(tick * kKib)));
    }
    return drawing +
           label("tick middle", (kFrontierArea.left + kFrontierArea.right) / 2, kFrontierArea.height - 4, "GPU memory of the scene");
}

/// Returns the steps between the points: a budget between two points buys the one on the left.
Html frontierSteps(const std::vector<FrontierPoint>& points, const FrontierAxes& axes) {
    std::string path;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const std::string x = place(axes.x(points[i]));
        if (i > 0) path += fmt::format(" {},{}", x, place(axes.y(points[i - 1])));
        path += fmt::format("{}{},{}", path.empty() ? "" : " ", x, place(axes.y(points[i])));
    }
    return element("polyline", {{"class", "trendline"}, {"points", path}}, {});
}

/// Returns the dot of a point, whose title names the layouts.
Html frontierDot(const FrontierPoint& point, const FrontierAxes& axes) {
    const Html tip =
        element("title", text(fmt::format("{}, {}: {}", humanBytes(point.bytesGpu), humanNumber(point.visible), layoutWords(point))));
    return element(
        "g", {{"class", point.isChosen ? "chosen" : "other"}},
        element("circle", {{"class", "dot"}, {"cx", place(axes.x(point))}, {"cy", place(axes.y(point))}, {"r", point.isChosen ? "6" : "4"}},
                tip));
}

Html plot(const std::vector<FrontierPoint>& points, double limitBytes) {
    const FrontierAxes axes = axesOf(points, limitBytes);
    Html drawing = frontierGrid(axes);
    if (limitBytes > 0) {
        const double x = axes.kib.at(limitBytes / kKib);
        drawing +=
            line("limit", x, kFrontierArea.top, x, kFrontierArea.bottom) + label("tick end limit", x - 5, kFrontierArea.top + 8, "budget");
    }
    drawing += frontierSteps(points, axes);
    for (const FrontierPoint& point : points) drawing += frontierDot(point, axes);
    return element("svg",
                   {{"class", "curve"},
                    {"viewBox", fmt::format("0 0 {} {}", kFrontierArea.width, kFrontierArea.height)},
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

#include "pipeline/report/trend_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "pipeline/report/page_parts.h"
#include "pipeline/report/plot.h"

namespace lightcook::pipeline {
namespace {

constexpr PlotArea kTrendArea{.width = 720, .height = 130, .left = 74, .right = 708, .top = 12, .bottom = 108};

/// The state of the scenes after a step of the history.
struct TrendPoint {
    std::string at;
    std::uint64_t bytes = 0;
    double error = 0;    ///< rel_rms, the larger of diffuse and specular
    double visible = 0;  ///< p99; 0 without any
    int failed = 0;
};

using SceneKey = std::pair<std::string, std::string>;  ///< name and target
using LatestLines = std::map<SceneKey, const HistoryLine*>;

TrendPoint pointOf(const LatestLines& latest, const std::string& at) {
    TrendPoint point{at};
    for (const auto& [key, line] : latest) {
        point.bytes += line->bytesGpu;
        point.error = std::max({point.error, line->diffuse.value_or(0.0), line->specular.value_or(0.0)});
        point.visible = std::max(point.visible, line->visible.value_or(0.0));
        point.failed += line->passed ? 0 : 1;
    }
    return point;
}

/// Returns the steps of a history. A step ends before the line of a scene that it has already: one report of many scenes is one step.
std::vector<TrendPoint> pointsOf(const std::vector<HistoryLine>& history) {
    LatestLines latest;
    std::set<SceneKey> step;
    std::string at;
    std::vector<TrendPoint> points;
    for (const HistoryLine& line : history) {
        const SceneKey key(line.scene, line.target);
        if (!step.insert(key).second) {
            points.push_back(pointOf(latest, at));
            step = {key};
        }
        latest[key] = &line;
        at = line.at;
    }
    if (!latest.empty()) points.push_back(pointOf(latest, at));
    return points;
}

/// Draws one figure over the points, from zero to its largest value.
template <class Value, class Words>
Html trend(const std::vector<TrendPoint>& points, const char* title, Value valueOf, Words wordsOf) {
    double most = 0;
    for (const TrendPoint& point : points)
        if (std::isfinite(valueOf(point))) most = std::max(most, valueOf(point));
    if (most <= 0) return {};
    const auto x = [&](std::size_t index) {
        return kTrendArea.left + (kTrendArea.right - kTrendArea.left) * static_cast<double>(index) / static_cast<double>(points.size() - 1);
    };
    const auto y = [&](double value) {
        return kTrendArea.bottom - (kTrendArea.bottom - kTrendArea.top) * std::clamp(value / most, 0.0, 1.0);
    };
    std::string path;
    Html dots;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double value = valueOf(points[i]);
        if (!std::isfinite(value)) continue;
        path += fmt::format("{}{},{}", path.empty() ? "" : " ", place(x(i)), place(y(value)));
        constexpr std::size_t kMostDots = 200;
        if (points.size() > kMostDots) continue;
        const Html tip = element("title", text(fmt::format("{}: {}{}", points[i].at, wordsOf(value),
                                                           points[i].failed > 0 ? fmt::format(", {} failed", points[i].failed) : "")));
        dots += element("circle",
                        {{"class", points[i].failed > 0 ? "bad" : "dot"}, {"cx", place(x(i))}, {"cy", place(y(value))}, {"r", "3"}}, tip);
    }
    const Html frame =
        line("grid", kTrendArea.left, y(0), kTrendArea.right, y(0)) + line("grid", kTrendArea.left, y(most), kTrendArea.right, y(most)) +
        label("tick end", kTrendArea.left - 8, y(0) + 4, wordsOf(0)) + label("tick end", kTrendArea.left - 8, y(most) + 4, wordsOf(most)) +
        label("tick", kTrendArea.left, kTrendArea.height - 5, points.front().at.substr(0, 10)) +
        label("tick end", kTrendArea.right, kTrendArea.height - 5, points.back().at.substr(0, 10));
    const Html svg = element(
        "svg",
        {{"class", "curve trend"},
         {"viewBox", fmt::format("0 0 {} {}", kTrendArea.width, kTrendArea.height)},
         {"role", "img"},
         {"aria-label", fmt::format("{}: {} at first, {} now", title, wordsOf(valueOf(points.front())), wordsOf(valueOf(points.back())))}},
        frame + element("polyline", {{"class", "trendline"}, {"points", path}}, {}) + dots);
    return element(
        "div", element("p", {{"class", "soft"}},
                       text(fmt::format("{}: {}, at first {}", title, wordsOf(valueOf(points.back())), wordsOf(valueOf(points.front()))))) +
                   element("div", {{"class", "scroll"}}, svg));
}

}  // namespace

Html trendSection(const std::vector<HistoryLine>& history, bool isOneScene) {
    const std::vector<TrendPoint> points = pointsOf(history);
    if (points.size() < 2) return {};
    const Html charts = trend(
                            points, isOneScene ? "GPU memory" : "GPU memory of all scenes",
                            [](const TrendPoint& point) { return static_cast<double>(point.bytes); },
                            [](double bytes) { return humanBytes(static_cast<std::uint64_t>(bytes)); }) +
                        trend(
                            points, isOneScene ? "Largest rel_rms of an asset" : "Largest rel_rms of an asset of any scene",
                            [](const TrendPoint& point) { return point.error; }, humanPercent) +
                        trend(
                            points, "Largest visible error (p99)", [](const TrendPoint& point) { return point.visible; }, humanNumber);
    return card(
        "Over time",
        element("div", {{"class", "pair trends"}}, charts) +
            element("p", {{"class", "soft"}},
                    text(fmt::format("{} steps. Red dots: {}.", points.size(), isOneScene ? "the scene failed" : "a scene failed"))));
}

}  // namespace lightcook::pipeline

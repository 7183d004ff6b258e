#include "bench/scatter.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "bench/html_page.h"

namespace lightcook::bench {
namespace {

constexpr std::size_t kColourCount = 6;  ///< classes c0 .. c5 of kStyle
constexpr double kWidth = 620, kHeight = 400, kLeft = 66, kRight = 16, kTop = 12, kBottom = 44;

/// Maps values to places in a panel: log10 of seconds to the right, decibels upwards.
struct Axes {
    double left = std::numeric_limits<double>::infinity(), right = -left, low = left, high = -left;

    explicit Axes(const ScatterPanel& panel) {
        for (const ScatterSeries& series : panel.series)
            for (const ScatterPoint& point : series.points) {
                left = std::min(left, std::log10(point.secondsPerMpix));
                right = std::max(right, std::log10(point.secondsPerMpix));
                low = std::min(low, point.db);
                high = std::max(high, point.db);
            }
        const double sideways = std::max(0.15, 0.06 * (right - left)), upwards = std::max(0.2, 0.07 * (high - low));
        left -= sideways, right += sideways, low -= upwards, high += upwards;
    }
    double x(double logSeconds) const { return kLeft + (logSeconds - left) / (right - left) * (kWidth - kLeft - kRight); }
    double y(double db) const { return kHeight - kBottom - (db - low) / (high - low) * (kHeight - kTop - kBottom); }
};

/// Returns the 1, 2 or 5 times a power of ten that divides a range into about six parts.
double tickStep(double range) {
    const double rough = range / 6, power = std::pow(10, std::floor(std::log10(rough))), lead = rough / power;
    return power * (lead < 1.5 ? 1 : lead < 3.5 ? 2 : lead < 7.5 ? 5 : 10);
}

std::string timeName(double log) {
    const double seconds = std::pow(10, log);
    if (seconds < 0.99e-3) return fmt::format("{:.3g} µs", 1e6 * seconds);
    if (seconds < 0.99) return fmt::format("{:.3g} ms", 1e3 * seconds);
    return fmt::format("{:.4g} s", seconds);
}

/// Returns the logarithms of the powers of ten inside a range of logarithms, with 2 and 5 times each if the range is short.
std::vector<double> logTicks(double low, double high) {
    std::vector<double> ticks;
    const int step = std::max(1, static_cast<int>(std::round((high - low) / 8)));
    for (int decade = static_cast<int>(std::floor(low)); decade <= std::floor(high); ++decade)
        for (const int lead : {1, 2, 5})
            if ((lead == 1 && decade % step == 0) || high - low < 2.5)
                if (const double log = decade + std::log10(lead); log >= low && log <= high) ticks.push_back(log);
    return ticks;
}

std::vector<double> evenTicks(double low, double high) {
    std::vector<double> ticks;
    const double step = tickStep(high - low);
    const double first = std::ceil(low / step);
    for (int i = 0; (first + i) * step <= high; ++i) ticks.push_back((first + i) * step);
    return ticks;
}

std::string errorName(double log) {
    const double error = std::pow(10, log);
    return error >= 0.9999e-4 ? fmt::format("{:.3g} %", 100 * error) : fmt::format("{:.0e}", error);
}

std::string axesSvg(const Axes& axes, const ScatterPanel& panel) {
    std::string svg;
    const double bottom = kHeight - kBottom;
    for (const double decade : logTicks(axes.left, axes.right))
        svg +=
            fmt::format("<line class=grid x1={0:.1f} x2={0:.1f} y1={1:.1f} y2={2:.1f} /><text x={0:.1f} y={3:.1f} class=mid>{4}</text>\n",
                        axes.x(decade), kTop, bottom, bottom + 16, timeName(decade));
    for (const double db : panel.isError ? logTicks(axes.low, axes.high) : evenTicks(axes.low, axes.high))
        svg +=
            fmt::format("<line class=grid x1={0:.1f} x2={1:.1f} y1={2:.1f} y2={2:.1f} /><text x={3:.1f} y={4:.1f} class=end>{5}</text>\n",
                        kLeft, kWidth - kRight, axes.y(db), kLeft - 6, axes.y(db) + 4,
                        panel.isError ? errorName(db) : fmt::format("{:g}", std::round(db * 100) / 100));
    svg += fmt::format("<text x={:.1f} y={:.1f} class=mid>{}</text>\n", (kLeft + kWidth - kRight) / 2, kHeight - 8, escaped(panel.xLabel));
    svg += fmt::format("<text class=mid transform=\"translate(13 {:.1f}) rotate(-90)\">{}</text>\n", (kTop + bottom) / 2,
                       escaped(panel.yLabel));
    return svg;
}

std::string markOf(ScatterSeries::Style style, double x, double y) {
    switch (style) {
        case ScatterSeries::Style::Main:
            return fmt::format("<circle cx={:.1f} cy={:.1f} r=4.5 />", x, y);
        case ScatterSeries::Style::Part:
            return fmt::format("<circle cx={:.1f} cy={:.1f} r=2.5 />", x, y);
        case ScatterSeries::Style::Front:
            return fmt::format("<circle cx={:.1f} cy={:.1f} r=7.5 />", x, y);
        case ScatterSeries::Style::Peer:
        case ScatterSeries::Style::Quoted:
            return fmt::format("<path d=\"M{:.1f} {:.1f}l6 6l-6 6l-6 -6z\" />", x, y - 6);
        case ScatterSeries::Style::QuotedElsewhere:
            break;
    }
    return fmt::format("<rect x={:.1f} y={:.1f} width=9 height=9 />", x - 4.5, y - 4.5);
}

bool isQuoted(ScatterSeries::Style style) {
    return style == ScatterSeries::Style::Quoted || style == ScatterSeries::Style::QuotedElsewhere;
}

/// Places names beside their marks so that they overlap no other name or mark.
class LabelPlaces {
public:
    /// Returns an SVG text beside (x, y): right of it, left, above or below, whichever is free first; above if none is.
    std::string put(const std::string& text, double x, double y) {
        const double width = 6.8 * static_cast<double>(text.size());
        const Place places[] = {
            {x + 9, y + 4, width}, {x - 9 - width, y + 4, width}, {x - width / 2, y - 10, width}, {x - width / 2, y + 19, width}};
        const Place* best = &places[2];
        for (const Place& place : places)
            if (isFree(place)) {
                best = &place;
                break;
            }
        taken_.push_back(*best);
        return fmt::format("<text x={:.1f} y={:.1f} class=label>{}</text>", best->left, best->baseline, escaped(text));
    }
    void takeMark(double x, double y) { taken_.push_back({x - 6, y + 5, 12}); }

private:
    struct Place {
        double left, baseline, width;
    };
    bool isFree(const Place& place) const {
        if (place.left < kLeft || place.left + place.width > kWidth - kRight) return false;
        return std::none_of(taken_.begin(), taken_.end(), [&](const Place& other) {
            return place.left < other.left + other.width && other.left < place.left + place.width &&
                   std::abs(place.baseline - other.baseline) < 13;
        });
    }
    std::vector<Place> taken_;
};

const char* classOf(ScatterSeries::Style style) {
    switch (style) {
        case ScatterSeries::Style::Main:
            return "main";
        case ScatterSeries::Style::Part:
            return "part";
        case ScatterSeries::Style::Peer:
            return "peer";
        case ScatterSeries::Style::Front:
            return "front";
        case ScatterSeries::Style::Quoted:
        case ScatterSeries::Style::QuotedElsewhere:
            break;
    }
    return "quoted";
}

std::string seriesSvg(const Axes& axes, const ScatterSeries& series, std::size_t colour, bool isCrowded, LabelPlaces& labels) {
    std::string line, marks;
    for (const ScatterPoint& point : series.points) {
        const double x = axes.x(std::log10(point.secondsPerMpix)), y = axes.y(point.db);
        // A front is stepped: until the next point, nothing is better than the one before.
        if (series.style == ScatterSeries::Style::Front && !line.empty()) line += fmt::format("H{:.1f}", x);
        line += fmt::format("{}{:.1f} {:.1f}", line.empty() ? "M" : "L", x, y);
        marks += fmt::format("<g>{}{}", point.hint.empty() ? "" : "<title>" + escaped(point.hint) + "</title>", markOf(series.style, x, y));
        if (isQuoted(series.style) || ((isCrowded || series.style == ScatterSeries::Style::Peer) && !point.label.empty()))
            marks += labels.put(point.label, x, y);
        else if (!point.label.empty())
            marks += fmt::format("<text x={:.1f} y={:.1f} class=\"label mid\">{}</text>", x, y - 9, escaped(point.label));
        marks += "</g>\n";
    }
    return fmt::format("<g class=\"{} c{}\">{}\n{}</g>\n", classOf(series.style), colour,
                       isQuoted(series.style) ? "" : fmt::format("<path d=\"{}\" />", line), marks);
}

std::string legendItem(const ScatterSeries& series, std::size_t colour) {
    return fmt::format("<span><svg width=14 height=14 class=\"{} c{}\">{}</svg> {}</span>\n", classOf(series.style), colour,
                       markOf(series.style, 7, 7), escaped(series.name));
}

std::string panelHtml(const ScatterPanel& panel) {
    const Axes axes(panel);
    std::string drawing = axesSvg(axes, panel), legend;
    LabelPlaces labels;
    for (const ScatterSeries& series : panel.series)
        for (const ScatterPoint& point : series.points) labels.takeMark(axes.x(std::log10(point.secondsPerMpix)), axes.y(point.db));
    // Quoted figures first, so that our own measurements are drawn on top.
    for (const bool quoted : {true, false})
        for (std::size_t i = 0; i < panel.series.size(); ++i)
            if (isQuoted(panel.series[i].style) == quoted)
                drawing += seriesSvg(axes, panel.series[i], i % kColourCount, panel.isError, labels);
    for (std::size_t i = 0; i < panel.series.size(); ++i) legend += legendItem(panel.series[i], i % kColourCount);
    return fmt::format(
        "<section><h2>{}</h2>\n<svg viewBox=\"0 0 {} {}\" role=img aria-label=\"{}\">\n{}</svg>\n<p class=legend>{}</p></section>\n",
        escaped(panel.title), kWidth, kHeight, escaped(panel.title + ": " + panel.yLabel + " against time"), drawing, legend);
}

constexpr const char* kStyle = R"(
:root { color-scheme: light dark; --ink: #1c1f24; --soft: #5c6470; --line: #dfe3e8; --back: #f5f6f8; --card: #fff;
  --k0: #1f5fbf; --k1: #c2571a; --k2: #2c8a57; --k3: #8a4fb0; --k4: #6b7280; --k5: #9a6b00; }
@media (prefers-color-scheme: dark) { :root { --ink: #e8eaee; --soft: #a3abb8; --line: #343a44; --back: #14171b; --card: #1d2127;
  --k0: #6fa8ff; --k1: #ff9a5c; --k2: #62c98f; --k3: #c99af0; --k4: #a3abb8; --k5: #e0b04a; } }
body { margin: 0 auto; max-width: 1360px; padding: 24px; font: 15px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--back); }
h1 { font-size: 24px; margin: 0 0 8px; } h2 { font-size: 16px; margin: 0 0 8px; font-family: ui-monospace, monospace; }
p.note { margin: 0 0 8px; max-width: 84ch; color: var(--soft); }
main { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 560px), 1fr)); gap: 20px; margin-top: 20px; }
section { background: var(--card); border: 1px solid var(--line); border-radius: 10px; padding: 16px; }
section > svg { width: 100%; height: auto; display: block; }
svg text { font: 12px system-ui, sans-serif; fill: var(--soft); } svg .mid { text-anchor: middle; } svg .end { text-anchor: end; }
.grid { stroke: var(--line); stroke-width: 1; } .label { fill: currentColor !important; font-weight: 600; }
.main > path, .part > path, .peer > path, .front > path { fill: none; stroke: currentColor; }
.peer > path { stroke-width: 1.5; } .peer g path { fill: currentColor; stroke: var(--card); } svg.peer > path { fill: currentColor; }
.front > path { stroke-width: 1; stroke-dasharray: 3 4; opacity: .8; } .front circle { fill: none; stroke: currentColor; stroke-width: 1.3; } .main > path { stroke-width: 2; } .part > path { stroke-width: 1.2; opacity: .7; }
circle { fill: currentColor; stroke: var(--card); stroke-width: 1; }
.quoted rect, .quoted path { fill: none; stroke: currentColor; stroke-width: 1.5; } .quoted .label { font-weight: 400; }
.c0 { color: var(--k0); } .c1 { color: var(--k1); } .c2 { color: var(--k2); } .c3 { color: var(--k3); } .c4 { color: var(--k4); } .c5 { color: var(--k5); }
.legend { margin: 8px 0 0; display: flex; flex-wrap: wrap; gap: 4px 16px; font-size: 13px; color: var(--soft); }
.legend svg { overflow: visible; } .legend span { display: inline-flex; align-items: center; gap: 5px; }
)";

}  // namespace

std::string scatterPage(const std::string& title, const std::vector<std::string>& notes, const std::vector<ScatterPanel>& panels) {
    std::string page = pageStart(title, kStyle, notes);
    page += "<main>\n";
    for (const ScatterPanel& panel : panels) page += panelHtml(panel);
    return page + "</main></body></html>\n";
}

}  // namespace lightcook::bench

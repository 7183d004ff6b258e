#include "bench/curve.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "bench/html_page.h"

namespace lightcook::bench {
namespace {

constexpr double kWidth = 640, kHeight = 460, kLeft = 54, kRight = 18, kTop = 12, kBottom = 44;
constexpr double kLineHeight = 12.5, kLetterWidth = 6.6;

/// A logarithmic axis: its range in powers of ten, and the places of its ends in the panel.
struct Axis {
    double low = std::numeric_limits<double>::infinity(), high = -low, start = 0, end = 0;

    /// Widens the range so that it holds a value. Ignores values that a logarithmic axis cannot show.
    void include(double value) {
        if (!(value > 0)) return;
        low = std::min(low, std::log10(value)), high = std::max(high, std::log10(value));
    }
    void widen(double below, double above) { low -= below, high += above; }
    double at(double value) const { return start + (std::log10(value) - low) / (high - low) * (end - start); }
    bool holds(double value) const { return std::log10(value) >= low && std::log10(value) <= high; }
};

struct Axes {
    Axis x, y;
    explicit Axes(const CurvePanel& panel) {
        for (const CurvePoint& point : panel.points) x.include(point.bits), y.include(point.first), y.include(point.second);
        x.widen(0.06, 0.06), y.widen(0.1, 0.1);
        x.start = kLeft, x.end = kWidth - kRight, y.start = kHeight - kBottom, y.end = kTop;
    }
};

std::string gridSvg(const Axes& axes) {
    std::string svg;
    for (const int bits : {4, 8, 12, 16, 24, 32, 48, 72, 96, 144, 288, 576})
        if (axes.x.holds(bits))
            svg += fmt::format("<line class=grid x1={0:.1f} x2={0:.1f} y1={1} y2={2} /><text x={0:.1f} y={3} class=mid>{4}</text>\n",
                               axes.x.at(bits), kTop, kHeight - kBottom, kHeight - kBottom + 16, bits);
    for (int decade = -6; decade <= 6; ++decade)
        for (const int lead : {1, 2, 5}) {
            const double percent = lead * std::pow(10, decade);
            if (axes.y.holds(percent))
                svg +=
                    fmt::format("<line class=grid x1={0} x2={1} y1={2:.1f} y2={2:.1f} /><text x={3} y={4:.1f} class=end>{5:g} %</text>\n",
                                kLeft, kWidth - kRight, axes.y.at(percent), kLeft - 6, axes.y.at(percent) + 4, percent);
        }
    return svg + fmt::format("<text x={:.1f} y={:.1f} class=mid>bits a texel, tables included</text>\n", (kLeft + kWidth - kRight) / 2,
                             kHeight - 8);
}

/// Places names beside their marks so that they overlap no other name or mark.
class Labels {
public:
    void takeMark(double x, double y) { taken_.push_back({x - 6, y + 5, 12}); }
    /// Returns an SVG text beside (x, y), at the nearest free place; to the right if none is free.
    std::string put(const std::string& text, double x, double y) {
        const double width = kLetterWidth * static_cast<double>(text.size());
        Place best{x + 9, y + 4, width};
        double least = std::numeric_limits<double>::infinity();
        for (int row = -6; row <= 6; ++row)
            for (const double left : {x + 9, x - 9 - width, x - width / 2}) {
                if (left == x - width / 2 && row == 0) continue;
                const Place place{left, y + 4 + kLineHeight * row, width};
                const double cost = std::abs(row) + (left == x + 9 ? 0 : 0.5);
                if (cost < least && isFree(place)) best = place, least = cost;
            }
        taken_.push_back(best);
        return fmt::format("<text x={:.1f} y={:.1f} class=label>{}</text>", best.left, best.baseline, escaped(text));
    }

private:
    struct Place {
        double left, baseline, width;
    };
    bool isFree(const Place& place) const {
        if (place.left < kLeft || place.left + place.width > kWidth - kRight) return false;
        if (place.baseline < kTop + 10 || place.baseline > kHeight - kBottom - 2) return false;
        return std::none_of(taken_.begin(), taken_.end(), [&](const Place& other) {
            return place.left < other.left + other.width && other.left < place.left + place.width &&
                   std::abs(place.baseline - other.baseline) < kLineHeight;
        });
    }
    std::vector<Place> taken_;
};

std::string pointSvg(const Axes& axes, const CurvePoint& point, Labels& labels) {
    const double x = axes.x.at(point.bits);
    std::string svg = fmt::format("<g class={}><title>{}</title>", point.ours ? "ours" : "peer", escaped(point.hint));
    if (point.first > 0 && point.second > 0)
        svg += fmt::format("<line x1={0:.1f} x2={0:.1f} y1={1:.1f} y2={2:.1f} />", x, axes.y.at(point.first), axes.y.at(point.second));
    if (point.second > 0) svg += fmt::format("<circle class=hollow cx={:.1f} cy={:.1f} r=4 />", x, axes.y.at(point.second));
    if (point.first > 0)
        svg += fmt::format("<circle cx={:.1f} cy={:.1f} r=4.5 />{}", x, axes.y.at(point.first),
                           labels.put(point.name, x, axes.y.at(point.first)));
    return svg + "</g>\n";
}

/// Draws a line through our Pareto front: the layouts whose first error is less than that of every smaller layout of ours.
std::string frontSvg(const Axes& axes, const CurvePanel& panel) {
    std::vector<const CurvePoint*> ours;
    for (const CurvePoint& point : panel.points)
        if (point.ours && point.first > 0) ours.push_back(&point);
    std::sort(ours.begin(), ours.end(), [](const CurvePoint* a, const CurvePoint* b) { return a->bits < b->bits; });
    std::string path;
    double least = std::numeric_limits<double>::infinity();
    for (const CurvePoint* point : ours) {
        if (point->first >= least) continue;
        least = point->first;
        path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", axes.x.at(point->bits), axes.y.at(point->first));
    }
    return fmt::format("<path class=\"ours front\" d=\"{}\" />\n", path);
}

std::string panelHtml(const CurvePanel& panel) {
    const Axes axes(panel);
    std::string drawing = gridSvg(axes) + frontSvg(axes, panel);
    Labels labels;
    for (const CurvePoint& point : panel.points)
        for (const double value : {point.first, point.second})
            if (value > 0) labels.takeMark(axes.x.at(point.bits), axes.y.at(value));
    for (const bool ours : {false, true})  // ours last, so that they are drawn on top
        for (const CurvePoint& point : panel.points)
            if (point.ours == ours) drawing += pointSvg(axes, point, labels);
    return fmt::format(
        "<section><h2>{}</h2>\n<svg viewBox=\"0 0 {} {}\" role=img aria-label=\"{}: error against bits a texel\">\n{}</svg></section>\n",
        escaped(panel.title), kWidth, kHeight, escaped(panel.title), drawing);
}

constexpr const char* kStyle = R"(
:root { color-scheme: light dark; --ink: #1c1f24; --soft: #5c6470; --line: #dfe3e8; --back: #f5f6f8; --card: #fff; --ours: #1f5fbf; --peer: #b4511a; }
@media (prefers-color-scheme: dark) { :root { --ink: #e8eaee; --soft: #a3abb8; --line: #343a44; --back: #14171b; --card: #1d2127;
  --ours: #6fa8ff; --peer: #ff9a5c; } }
body { margin: 0 auto; max-width: 1400px; padding: 24px; font: 15px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--back); }
h1 { font-size: 24px; margin: 0 0 8px; } h2 { font-size: 16px; margin: 0 0 8px; }
p { margin: 0 0 8px; max-width: 90ch; color: var(--soft); }
main { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 600px), 1fr)); gap: 20px; margin-top: 16px; }
section { background: var(--card); border: 1px solid var(--line); border-radius: 10px; padding: 16px; }
section > svg { width: 100%; height: auto; display: block; }
svg text { font: 12px system-ui, sans-serif; fill: var(--soft); } svg .mid { text-anchor: middle; } svg .end { text-anchor: end; }
.grid { stroke: var(--line); stroke-width: 1; } .label { fill: currentColor !important; paint-order: stroke; stroke: var(--card); stroke-width: 3px; }
.ours { color: var(--ours); } .ours .label { font-weight: 600; } .peer { color: var(--peer); }
circle { fill: currentColor; stroke: var(--card); stroke-width: 1; } .hollow { fill: var(--card); stroke: currentColor; stroke-width: 1.6; }
g > line { stroke: currentColor; stroke-width: 1; opacity: .5; } .front { fill: none; stroke: currentColor; stroke-width: 2; }
.key { display: inline-block; width: .8em; height: .8em; border-radius: 50%; border: 2px solid currentColor; box-sizing: border-box; }
.full { background: currentColor; }
)";

}  // namespace

std::string curvePage(const std::string& title, const std::vector<std::string>& notes, const std::string& first, const std::string& second,
                      const std::vector<CurvePanel>& panels) {
    std::string page = pageStart(title, kStyle, notes);
    page += fmt::format(
        "<p><span class=\"ours key full\"></span> lightcook &nbsp; <span class=\"peer key full\"></span> others &nbsp; "
        "<span class=\"key full\"></span> {} &nbsp; <span class=key></span> {}</p>\n<main>\n",
        escaped(first), escaped(second));
    for (const CurvePanel& panel : panels) page += panelHtml(panel);
    return page + "</main></body></html>\n";
}

}  // namespace lightcook::bench

#include "pipeline/report/layout_curve.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/report/plot.h"

namespace lightcook::pipeline {

namespace {

constexpr PlotArea kCurveArea{.width = 640, .height = 300, .left = 58, .right = 626, .top = 12, .bottom = 262};
constexpr double kLabelHeight = 13, kLetterWidth = 6.4;

const char* captionOf(CurveCost cost) {
    switch (cost) {
        case CurveCost::Operations:
            return "operations of a sample's decode";
        case CurveCost::Fetches:
            return "texture fetches of a sample";
        case CurveCost::BitsPerTexel:
            break;
    }
    return "bits per texel, tables included";
}

Html grid(const Axis& cost, const Axis& error, bool isVisible, const char* caption) {
    Html out;
    for (const double tick : error.ticks()) {
        out += line("grid", kCurveArea.left, error.at(tick), kCurveArea.right, error.at(tick));
        out += label("tick end", kCurveArea.left - 7, error.at(tick) + 4,
                     isVisible ? fmt::format("{:g}", tick) : fmt::format("{:g} %", 100 * tick));
    }
    for (const double tick : cost.ticks()) {
        out += line("grid", cost.at(tick), kCurveArea.top, cost.at(tick), kCurveArea.bottom);
        out += label("tick middle", cost.at(tick), kCurveArea.bottom + 15, fmt::format("{:g}", tick));
    }
    return out + label("tick middle", (kCurveArea.left + kCurveArea.right) / 2, kCurveArea.height - 4, caption);
}

/// Places names beside their dots and moves them up or down until none covers another.
class Labels {
public:
    /// Marks a position as taken by a dot or a ring.
    void takeMark(double x, double y) { taken_.push_back({x - 6, y + 4, 12}); }
    Html put(const std::string& name, double x, double y) {
        const double width = kLetterWidth * static_cast<double>(name.size());
        const double left = x + 8 + width > kCurveArea.right ? x - 8 - width : x + 8;
        double baseline = y + 4;
        for (const double offset : {0.0, -13.0, 13.0, -26.0, 26.0, -39.0, 39.0}) {
            baseline = y + 4 + offset;
            if (isFree(left, baseline, width)) break;
        }
        taken_.push_back({left, baseline, width});
        return label("name", left, baseline, name);
    }

private:
    struct Box {
        double left, baseline, width;
    };
    bool isFree(double left, double baseline, double width) const {
        return baseline > kCurveArea.top + 8 && baseline < kCurveArea.bottom && std::ranges::none_of(taken_, [&](const Box& box) {
                   return left < box.left + box.width && box.left < left + width && std::abs(baseline - box.baseline) < kLabelHeight;
               });
    }
    std::vector<Box> taken_;
};

bool canBeDrawn(const CurvePoint& point) {
    return std::ranges::all_of(std::array{point.cost, point.diffuse, point.specular},
                               [](double value) { return std::isfinite(value) && value > 1e-8 && value < 1e8; });
}

}  // namespace

Html errorCurve(const std::vector<CurvePoint>& points, double limit, CurveUnit unit, CurveCost cost) {
    std::vector<CurvePoint> drawn;
    std::ranges::copy_if(points, std::back_inserter(drawn), canBeDrawn);
    if (drawn.size() < 2) return {};
    double leastCost = 1e9, mostCost = 0, leastError = 1e9, mostError = 0;
    for (const CurvePoint& point : drawn) {
        leastCost = std::min(leastCost, point.cost);
        mostCost = std::max(mostCost, point.cost);
        leastError = std::min({leastError, point.diffuse, point.specular});
        mostError = std::max({mostError, point.diffuse, point.specular});
    }
    const bool hasLimit = limit > 0.5 * leastError && limit < 2 * mostError;
    if (hasLimit) {
        leastError = std::min(leastError, limit);
        mostError = std::max(mostError, limit);
    }
    const Axis costs(kCurveArea.left, kCurveArea.right, leastCost, mostCost),
        error(kCurveArea.bottom, kCurveArea.top, leastError, mostError);
    const bool isVisible = unit == CurveUnit::Visible;
    Html drawing = grid(costs, error, isVisible, captionOf(cost));
    if (hasLimit) {
        drawing += line("limit", kCurveArea.left, error.at(limit), kCurveArea.right, error.at(limit));
        drawing += label("tick end limit", kCurveArea.right, error.at(limit) - 4, "limit");
    }
    Labels labels;
    for (const CurvePoint& point : drawn)
        for (const double value : {point.diffuse, point.specular}) labels.takeMark(costs.at(point.cost), error.at(value));
    for (const CurvePoint& point : drawn) {
        const double x = costs.at(point.cost), diffuse = error.at(point.diffuse), specular = error.at(point.specular);
        drawing += element("g", {{"class", point.isChosen ? "chosen" : "other"}},
                           line("stem", x, diffuse, x, specular) +
                               element("circle", {{"class", "ring"}, {"cx", place(x)}, {"cy", place(specular)}, {"r", "4"}}, {}) +
                               element("circle", {{"class", "dot"}, {"cx", place(x)}, {"cy", place(diffuse)}, {"r", "4.5"}}, {}) +
                               labels.put(point.name, x, diffuse));
    }
    return element("svg",
                   {{"class", "curve"},
                    {"viewBox", fmt::format("0 0 {} {}", kCurveArea.width, kCurveArea.height)},
                    {"role", "img"},
                    {"aria-label", fmt::format("{} of each layout against {}: dots diffuse, rings specular",
                                               isVisible ? "Visible error" : "Error", captionOf(cost))}},
                   drawing);
}

}  // namespace lightcook::pipeline

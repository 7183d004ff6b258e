#include "pipeline/report/plot.h"

#include <fmt/format.h>

#include <cmath>

namespace lightcook::pipeline {

Axis::Axis(double from, double to, double low, double high, double margin)
    : from_(from), to_(to), low_(std::log2(low) - margin), high_(std::log2(high) + margin) {}

double Axis::at(double value) const {
    return from_ + (to_ - from_) * (std::log2(value) - low_) / (high_ - low_);
}

std::vector<double> Axis::ticks() const {
    std::vector<double> ticks;
    for (int decade = -8; decade <= 8; ++decade)
        for (const double step : {1.0, 2.0, 5.0})
            if (const double value = step * std::pow(10.0, decade); std::log2(value) >= low_ && std::log2(value) <= high_)
                ticks.push_back(value);
    return ticks;
}

std::string place(double value) {
    return fmt::format("{:.1f}", value);
}

Html line(const char* kind, double x1, double y1, double x2, double y2) {
    return element("line", {{"class", kind}, {"x1", place(x1)}, {"y1", place(y1)}, {"x2", place(x2)}, {"y2", place(y2)}}, {});
}

Html label(const char* kind, double x, double y, const std::string& words) {
    return element("text", {{"class", kind}, {"x", place(x)}, {"y", place(y)}}, text(words));
}

}  // namespace lightcook::pipeline

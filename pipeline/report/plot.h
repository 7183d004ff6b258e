// Parts of the plots of report.html.
#pragma once

#include <string>
#include <vector>

#include "pipeline/report/html.h"

namespace lightcook::pipeline {

/// Size of a plot, and the sides of the area inside its axes [units of the SVG].
struct PlotArea {
    double width, height;
    double left, right, top, bottom;
};

/// A logarithmic axis between two positions on the page, with a margin around its values.
class Axis {
public:
    /// from, to   positions [units of the SVG]
    /// low, high  least and largest value, above 0
    /// margin     beyond both [octaves]
    Axis(double from, double to, double low, double high, double margin = 0.35);
    double at(double value) const;
    /// Returns the ticks: 1, 2 and 5 of each decade inside.
    std::vector<double> ticks() const;

private:
    double from_, to_, low_, high_;
};

/// Returns a coordinate as text.
std::string place(double value);
Html line(const char* kind, double x1, double y1, double x2, double y2);
Html label(const char* kind, double x, double y, const std::string& words);

}  // namespace lightcook::pipeline

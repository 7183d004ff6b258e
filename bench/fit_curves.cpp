#include "bench/fit_curves.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <stdexcept>

#include "bench/scatter.h"

namespace lightcook::bench {
namespace {

void writeText(const std::filesystem::path& file, const std::string& text) {
    std::ofstream out(file);
    out << text;
    if (!out.flush())
        throw std::runtime_error(file.string() + ": the file could not be written; give --curves a folder that you may write to");
}

ScatterPoint scatterPointOf(const FitPoint& point) {
    return {point.cpuSeconds, std::log10(point.error), point.way + (point.isDefault ? " (default)" : ""),
            fmt::format("{}, {}: {:.3g} CPU s, error {:.2e}", point.series, point.way, point.cpuSeconds, point.error)};
}

/// Returns the points of a panel by series, in the order in which the series were added.
std::vector<ScatterSeries> seriesOf(const std::vector<FitPoint>& points) {
    std::vector<ScatterSeries> all;
    for (const FitPoint& point : points) {
        if (!(point.error > 0) || !(point.cpuSeconds > 0)) continue;
        auto place = std::find_if(all.begin(), all.end(), [&](const ScatterSeries& each) { return each.name == point.series; });
        if (place == all.end())
            place = all.insert(all.end(),
                               {point.series, point.isQuoted ? ScatterSeries::Style::QuotedElsewhere : ScatterSeries::Style::Main, {}});
        place->points.push_back(scatterPointOf(point));
    }
    for (ScatterSeries& series : all)
        std::sort(series.points.begin(), series.points.end(),
                  [](const ScatterPoint& a, const ScatterPoint& b) { return a.secondsPerMpix < b.secondsPerMpix; });
    return all;
}

}  // namespace

FitCurves::Panel& FitCurves::panelOf(const std::string& converter) {
    const auto place = std::find_if(panels_.begin(), panels_.end(), [&](const Panel& panel) { return panel.converter == converter; });
    return place != panels_.end() ? *place : panels_.emplace_back(Panel{converter, "error", {}});
}

void FitCurves::describe(const std::string& converter, const std::string& measure) {
    panelOf(converter).measure = measure;
}

void FitCurves::add(FitPoint point) {
    panelOf(point.converter).points.push_back(std::move(point));
}

void FitCurves::write(const std::filesystem::path& folder) const {
    std::filesystem::create_directories(folder);
    std::string csv = "converter,measure,series,way,cpu_seconds,error,is_default,is_quoted\n";
    std::vector<ScatterPanel> panels;
    for (const Panel& panel : panels_) {
        for (const FitPoint& p : panel.points)
            csv += fmt::format("\"{}\",\"{}\",\"{}\",\"{}\",{},{},{},{}\n", p.converter, panel.measure, p.series, p.way, p.cpuSeconds,
                               p.error, p.isDefault ? 1 : 0, p.isQuoted ? 1 : 0);
        ScatterPanel each{panel.converter, panel.measure, seriesOf(panel.points), "CPU seconds, one thread (left is faster)", true};
        if (!each.series.empty()) panels.push_back(std::move(each));
    }
    writeText(folder / "fits.csv", csv);
    writeText(
        folder / "fits.html",
        scatterPage("Fits: run time against error",
                    {"Lower is better, left is faster. Which point is the default and why: docs/lab/fit.md. Hollow squares are quoted: "
                     "whole processes of other programs, measured elsewhere."},
                    panels));
}

}  // namespace lightcook::bench

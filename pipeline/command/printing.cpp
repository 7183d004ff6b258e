#include "pipeline/command/printing.h"

#include <fmt/format.h>

#include <cmath>

namespace lightcook::pipeline {
namespace {

std::string percent(double value) {
    return std::isfinite(value) ? fmt::format("{:8.3f} %", 100 * value) : "     not finite";
}

}  // namespace

void printReport(Terminal& terminal, const Report& report) {
    terminal.say(fmt::format("{:24} {:10} {:12} {:>12} {:>9} {:>10} {:>10} {:>10} {:>12}  {}", "asset", "kind", "layout", "GPU bytes",
                             "bits/tx", "diffuse", "specular", "p99", "bound", "verdict"));
    for (const ReportRow& row : report.assets) {
        const verify::StageError& error = row.verdict.stages.back();
        const bool diffuseIsWorse =
            std::isfinite(error.specular.p99) && std::isfinite(error.diffuse.p99) && error.diffuse.p99 >= error.specular.p99;
        const verify::ErrorFigures& worse = diffuseIsWorse ? error.diffuse : error.specular;
        terminal.say(fmt::format("{:24} {:10} {:12} {:12} {:9.2f} {} {} {} {}  {}", row.name, info(row.kind).name, row.layout, row.bytesGpu,
                                 row.bitsPerTexel, percent(error.diffuse.relRms), percent(error.specular.relRms), percent(worse.p99),
                                 percent(worse.maxBound), row.verdict.passed ? "passed" : "FAILED"));
    }
    const std::string limit = report.budget.limitBytes ? fmt::format(" of {}", *report.budget.limitBytes) : "";
    terminal.say(fmt::format("{} bytes of GPU memory{}, {:.2f} s, {:.0f} MiB resident at most", report.budget.usedBytes, limit,
                             report.seconds, static_cast<double>(report.peakRssBytes) / 0x1p20));
    if (report.whole) terminal.say(lineOf(*report.whole));
}

void printReport(Terminal& terminal, const Json& json) {
    if (const auto report = fromJson<Report>(json, kReportName)) printReport(terminal, *report);
}

void printJson(Terminal& terminal, const Json& json, const std::string& indent) {
    for (const auto& [key, value] : json.items()) {
        if (value.is_structured()) {
            terminal.say(fmt::format("{}{}:", indent, key));
            printJson(terminal, value, indent + "  ");
        } else {
            terminal.say(fmt::format("{}{}: {}", indent, key, value.is_string() ? value.get<std::string>() : textOf(value)));
        }
    }
}

}  // namespace lightcook::pipeline

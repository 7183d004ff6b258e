// lightcook report: memory budgets and errors of a cooked scene.
#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <memory>

#include "pipeline/command/command.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/printing.h"
#include "pipeline/command/session.h"
#include "pipeline/graph/files.h"
#include "pipeline/report/report.h"

namespace lightcook::pipeline {
namespace {

using formats::Error;
using formats::ErrorCode;

/// Returns an error if the GPU memory grew by more than `allowedPercent` over the baseline.
std::vector<Error> compareWithBaseline(const Report& report, const std::filesystem::path& baseline, double allowedPercent) {
    const auto old = loadReport(baseline);
    if (!old) return {old.error()};
    const double before = static_cast<double>(old->budget.usedBytes), now = static_cast<double>(report.budget.usedBytes);
    const double growth = before > 0 ? 100 * (now / before - 1) : (now > 0 ? 100.0 : 0.0);
    if (growth <= allowedPercent) return {};
    return {{ErrorCode::OverBudget, baseline.string(),
             fmt::format("found {} bytes of GPU memory, {:.2f} % more than the baseline's {}, expected at most {} % more", now, growth,
                         before, allowedPercent)}};
}

}  // namespace

CommandFunction defineReport(CLI::App& app) {
    struct Options {
        std::filesystem::path folder, json, html, baseline;
        double failOver = 0;
    };
    const auto options = std::make_shared<Options>();
    addFolderOption(app, "folder", options->folder, "Output folder of cook")->required();
    addFileOption(app, "--json", options->json, "Write the report as JSON");
    addFileOption(app, "--html", options->html, "Write the report as one self-contained HTML page");
    CLI::Option* baseline = addFileOption(app, "--baseline", options->baseline, "An older report.json to compare with");
    app.add_option("--fail-over", options->failOver, "Growth of GPU memory over the baseline that is allowed [percent]")
        ->needs(baseline)
        ->type_name("PERCENT")
        ->capture_default_str();
    app.footer("More GPU memory than the scene's budget, or more growth than --fail-over allows, ends with exit code 5.");
    return [options](Session& session) {
        const auto json = readReport(options->folder / kReportName);
        if (!json) return session.finish(json);
        const auto report = loadReport(options->folder / kReportName);
        if (!report) return session.finish(report);
        std::vector<Error> errors;
        const auto write = [&](const std::filesystem::path& file, const std::string& text) {
            if (auto written = writeFile(file, text); !written) errors.push_back(written.error());
        };
        if (!options->json.empty()) write(options->json, textOf(*json) + "\n");
        if (!options->html.empty()) write(options->html, renderReportHtml(*json, options->folder));
        if (!options->baseline.empty())
            for (Error& error : compareWithBaseline(*report, options->baseline, options->failOver)) errors.push_back(std::move(error));
        if (!report->budget.isKept())
            errors.push_back({ErrorCode::OverBudget, options->folder.string(),
                              "found more GPU memory used than the scene's budget, expected at most the budget"});
        printReport(session.terminal, *report);
        return session.finish(errors);
    };
}

}  // namespace lightcook::pipeline

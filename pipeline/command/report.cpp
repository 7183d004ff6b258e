// lightcook report: memory budgets and errors of a cooked scene.
#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <memory>

#include "pipeline/command/command.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/outputs.h"
#include "pipeline/command/printing.h"
#include "pipeline/command/session.h"
#include "pipeline/cook/integrity.h"
#include "pipeline/cook/verdicts.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/report/report.h"

namespace lightcook::pipeline {
namespace {

using formats::Error;
using formats::ErrorCode;

struct ReportOptions {
    std::filesystem::path folder, html, baseline;
    std::optional<double> failOver;  ///< [percent]; none: no growth fails
    JsonOutput json;
};

/// Returns an error if the GPU memory grew by more than is allowed.
std::vector<Error> errorsOf(const BaselineComparison& comparison) {
    if (comparison.passed) return {};
    return {{ErrorCode::OverBudget, comparison.file,
             fmt::format("found {} bytes of GPU memory, {:.2f} % more than the baseline's {}, expected at most {} % more",
                         comparison.bytesNow, comparison.growthPercent, comparison.bytesBefore, *comparison.allowedPercent)}};
}

/// Returns the errors of a cooked folder as its cook or verification found them, and files that were changed since.
std::vector<Error> verdictOf(const std::filesystem::path& folder, const Report& report) {
    std::vector<Error> errors;
    if (const auto manifest = loadManifest(folder)) errors = checkDigests(folder, *manifest);
    appendVerdicts(report, errors);
    if (errors.empty() && !report.passed)
        errors.push_back({ErrorCode::Verification, (folder / kReportName).string(), "found passed: false, expected a folder that passed"});
    return errors;
}

int runReport(const ReportOptions& options, Session& session) {
    options.json.prepare(session);
    if (options.html == kStandardOutput) session.terminal.keepOutputForData();
    std::error_code code;
    if (!std::filesystem::exists(options.folder / kReportName, code))
        return options.json.finish(session, {},
                                   {{ErrorCode::FileUnreadable, (options.folder / kReportName).string(),
                                     "found no report, expected the output folder of `lightcook cook`"}});
    auto json = readReport(options.folder / kReportName);
    if (!json) return options.json.finish(session, json);
    auto report = loadReport(options.folder / kReportName);
    if (!report) return options.json.finish(session, {}, {report.error()});
    std::vector<Error> errors = verdictOf(options.folder, *report);
    if (!options.baseline.empty()) {
        const bool isFolder = std::filesystem::is_directory(options.baseline, code);
        const std::filesystem::path file = isFolder ? options.baseline / kReportName : options.baseline;
        if (const auto before = loadReport(file)) {
            report->baseline = compareWithBaseline(*report, *before, file.string(), options.failOver);
            (*json)["baseline"] = jsonOf(*report->baseline);
            for (Error& error : errorsOf(*report->baseline)) errors.push_back(std::move(error));
        } else {
            errors.push_back(before.error());
        }
    }
    if (!options.html.empty())
        if (auto written = session.write(options.html, renderReportHtml(*json, options.folder)); !written)
            errors.push_back(written.error());
    if (auto written = options.json.write(session, *json, errors); !written) errors.push_back(written.error());
    if (session.terminal.verbosity() != Verbosity::Quiet) {
        printReport(session.terminal, *report);
        if (report->baseline) printComparison(session.terminal, *report->baseline);
    }
    return session.finish(errors);
}

}  // namespace

CommandFunction defineReport(CLI::App& app) {
    const auto options = std::make_shared<ReportOptions>();
    addFolderOption(app, "folder", options->folder, "Output folder of cook")->required();
    options->json.add(app, "the report, and with --baseline the comparison,");
    addFileOption(app, "--html", options->html, "Write the report as one self-contained HTML page; - is standard output");
    CLI::Option* baseline =
        addFileOption(app, "--baseline", options->baseline, "An older report.json, or its folder: compare asset by asset, bytes and error");
    addPercentOption(app, "--fail-over", options->failOver,
                     "Growth of the scene's GPU memory over the baseline that is allowed; more ends with code 5. Default: any")
        ->needs(baseline);
    app.footer(R"(The exit code is that of the folder: 4 if its verification failed or a file was changed since the cook,
5 if it needs more GPU memory than the scene's budget or grew by more than --fail-over. Without
--fail-over a comparison is information and fails nothing.)");
    return [options](Session& session) { return runReport(*options, session); };
}

}  // namespace lightcook::pipeline

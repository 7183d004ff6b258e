#include "pipeline/command/outputs.h"

#include <fmt/format.h>

#include <CLI/App.hpp>

#include "pipeline/command/option_groups.h"
#include "pipeline/command/printing.h"
#include "pipeline/command/session.h"
#include "pipeline/report/ci_report.h"
#include "pipeline/report/exit_codes.h"
#include "pipeline/report/report.h"

namespace lightcook::pipeline {
namespace {

using formats::Error;
using formats::Result;

Json jsonOf(const Error& error) {
    return {{"code", exitCode(error.code)}, {"subject", error.subject}, {"detail", error.detail}};
}

}  // namespace

void JsonOutput::add(CLI::App& app, const std::string& what) {
    addFileOption(app, "--json", file_, fmt::format("Write {} as JSON; - is standard output", what));
}

bool JsonOutput::isStandardOutput() const {
    return file_ == kStandardOutput;
}

void JsonOutput::prepare(Session& session) const {
    if (isStandardOutput()) session.terminal.keepOutputForData();
}

Result<void> JsonOutput::write(Session& session, Json facts, const std::vector<Error>& errors) const {
    if (!isGiven()) return {};
    if (!errors.empty()) {
        if (facts.is_null()) facts = {{"passed", false}};
        Json list = Json::array();
        for (const Error& error : errors) list.push_back(jsonOf(error));
        if (!facts.is_object()) facts = {{"results", std::move(facts)}};
        facts["exit_code"] = exitCode(errors.front().code);
        facts["errors"] = std::move(list);
    }
    return session.write(file_, textOf(facts) + "\n");
}

int JsonOutput::finish(Session& session, Json facts, std::vector<Error> errors) const {
    if (auto written = write(session, std::move(facts), errors); !written) errors.push_back(written.error());
    return session.finish(errors);
}

int JsonOutput::finish(Session& session, const Result<Json>& facts) const {
    return facts ? finish(session, *facts, {}) : finish(session, {}, {facts.error()});
}

void CiOutputs::add(CLI::App& app) {
    json_.add(app, "the report");
    addFileOption(app, "--junit", junit_, "Write every check as JUnit XML; - is standard output");
    addFileOption(app, "--sarif", sarif_, "Write the failures as SARIF 2.1.0; - is standard output");
}

Result<void> CiOutputs::prepare(Session& session) const {
    const int count = (json_.isStandardOutput() ? 1 : 0) + (junit_ == kStandardOutput ? 1 : 0) + (sarif_ == kStandardOutput ? 1 : 0);
    if (count > 1)
        return formats::failure(formats::ErrorCode::InvalidRequest, "--json, --junit, --sarif",
                                fmt::format("found - for {} of them, expected one document on standard output", count));
    if (count == 1) session.terminal.keepOutputForData();
    return {};
}

std::vector<Error> CiOutputs::write(Session& session, const std::string& command, const Outcome& outcome,
                                    const std::filesystem::path& sceneFile, const std::filesystem::path& sources) const {
    std::vector<Error> errors = outcome.errors;
    const auto keep = [&](const Result<void>& written) {
        if (!written) errors.push_back(written.error());
    };
    keep(json_.write(session, outcome.report, outcome.errors));
    if (junit_.empty() && sarif_.empty()) return errors;
    const CiRun run = ciRun(
        {command, outcome.output, sceneFile, sources, outcome.report, outcome.errors, outcome.isLinted ? &outcome.findings : nullptr});
    if (!junit_.empty()) keep(session.write(junit_, junitReport(run)));
    if (!sarif_.empty()) keep(session.write(sarif_, sarifReport(run)));
    return errors;
}

void printCook(Session& session, const Outcome& outcome) {
    printFindings(session.terminal, outcome.findings);
    if (!outcome.report.is_object() || session.terminal.verbosity() == Verbosity::Quiet) return;
    const auto report = fromJson<Report>(outcome.report, kReportName);
    if (!report) return;
    if (session.terminal.isInteractive()) printReport(session.terminal, *report);
    printSummary(session.terminal, *report, outcome);
}

}  // namespace lightcook::pipeline

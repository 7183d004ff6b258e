// lightcook lint: what looks wrong in the inputs of a scene.
#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <memory>

#include "pipeline/command/command.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/printing.h"
#include "pipeline/command/session.h"
#include "pipeline/graph/files.h"
#include "pipeline/report/ci_report.h"

namespace lightcook::pipeline {
namespace {

/// The file of --json.
struct LintReport {
    std::string scene;
    bool passed = false;
    std::vector<Finding> findings;
    std::vector<std::string> errors;
};
template <class Fields, Is<LintReport> Self>
void describe(Fields& fields, Self& report) {
    fields.required("scene", report.scene, "scene file");
    fields.required("passed", report.passed, "true without errors");
    fields.required("findings", report.findings, "findings, also those that the scene file allows");
    fields.required("errors", report.errors, "errors, those of --strict and of inputs that cannot be read among them");
}

std::string jsonOf(const Outcome& outcome, const std::filesystem::path& scene) {
    LintReport report{scene.string(), outcome.errors.empty(), outcome.findings, {}};
    for (const formats::Error& error : outcome.errors) report.errors.push_back(error.line());
    return textOf(toJson(report)) + "\n";
}

/// Returns "2 warnings, 1 error, 1 allowed".
std::string countsOf(const Outcome& outcome) {
    const auto allowed = std::ranges::count_if(outcome.findings, [](const Finding& finding) { return finding.allowed.has_value(); });
    const auto warnings =
        std::ranges::count_if(outcome.findings, [](const Finding& finding) { return !finding.allowed && !finding.isFailure(); });
    const auto words = [](auto count, const char* what) { return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s"); };
    return fmt::format("{}, {}, {} allowed", words(warnings, "warning"), words(outcome.errors.size(), "error"), allowed);
}

}  // namespace

CommandFunction defineLint(CLI::App& app) {
    struct Options {
        LintOptions lint;
        std::filesystem::path json, junit, sarif;
    };
    const auto options = std::make_shared<Options>();
    addFileOption(app, "scene", options->lint.scene, "The scene file (scene.toml)")->required();
    addStrictOption(app, options->lint.strict);
    addRepairOption(app, options->lint.repair);
    addFolderOption(app, "--cache", options->lint.cache, "Cache folder; default: $LIGHTCOOK_CACHE, else the user's cache folder");
    addFileOption(app, "--json", options->json, "Write the findings as JSON");
    addFileOption(app, "--junit", options->junit, "Write the findings as JUnit XML");
    addFileOption(app, "--sarif", options->sarif, "Write the findings as SARIF");
    app.footer(R"(lint looks at light maps, meshes, probes and settings before a cook: sign convention, axes, units, gamma
curves, coverage, normals, fireflies, light-map UVs, limits. Each finding has a code, the evidence in
figures, and what to write in the scene file. cook and verify do the same checks.

An error, such as a map without coverage, ends with exit code 3; a warning ends with exit code 0, with
--strict 3. `allow = [{ code = "...", reason = "..." }]` in the scene file silences a warning.)");
    return [options](Session& session) {
        Outcome outcome = lintScene(options->lint, session.state);
        const std::vector<formats::Error> failures = outcome.errors;
        const auto write = [&](const std::filesystem::path& file, const std::string& text) {
            if (file.empty()) return;
            if (auto written = writeFile(file, text); !written) outcome.errors.push_back(written.error());
        };
        write(options->json, jsonOf(outcome, options->lint.scene));
        write(options->junit, junitReport(outcome.report, failures, options->lint.scene.string()));
        write(options->sarif, sarifReport(outcome.report, failures));
        printFindings(session.terminal, outcome.findings);
        session.terminal.say(fmt::format("{}: {}", options->lint.scene.string(), countsOf(outcome)));
        return session.finish(outcome.errors);
    };
}

}  // namespace lightcook::pipeline

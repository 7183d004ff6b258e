// lightcook lint: what looks wrong in the inputs of a scene.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <memory>

#include "pipeline/command/command.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/outputs.h"
#include "pipeline/command/session.h"
#include "pipeline/command/terminal/printing.h"
#include "pipeline/lint/lint.h"

namespace lightcook::pipeline {
namespace {

/// Returns "2 warnings, 1 error, 1 allowed"; with notes "2 warnings, 1 error, 3 notes, 1 allowed".
std::string countsOf(const Outcome& outcome) {
    const auto allowed = std::ranges::count_if(outcome.findings, [](const Finding& finding) { return finding.allowed.has_value(); });
    const auto warnings = std::ranges::count_if(
        outcome.findings, [](const Finding& finding) { return !finding.allowed && !finding.isFailure() && !finding.isNote(); });
    const auto notes = std::ranges::count_if(outcome.findings, [](const Finding& finding) { return !finding.allowed && finding.isNote(); });
    const auto words = [](auto count, const char* what) { return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s"); };
    return fmt::format("{}, {}, {}{} allowed", words(warnings, "warning"), words(outcome.errors.size(), "error"),
                       notes > 0 ? words(notes, "note") + ", " : "", allowed);
}

/// Prints how each light map was recognised.
void printReadings(Terminal& terminal, const Json& json) {
    const auto report = fromJson<LintReport>(json, "lint");
    if (!report) return;
    for (const BakeReading& reading : report->lightMaps) {
        std::string line = fmt::format("{}: read as {} ({})", reading.lightMap, reading.bake, reading.evidence);
        if (!reading.assumed.empty()) line += fmt::format("; assumed: {}", fmt::join(reading.assumed, "; "));
        if (!reading.otherReadings.empty()) line += fmt::format("; would also fit: {}", fmt::join(reading.otherReadings, ", "));
        terminal.say(line);
    }
}

}  // namespace

CommandFunction defineLint(CLI::App& app) {
    struct Options {
        LintOptions lint;
        CiOutputs files;
    };
    const auto options = std::make_shared<Options>();
    addFileOption(app, "scene", options->lint.scene, "The scene file (scene.toml)")->required();
    addStrictOption(app, options->lint.strict);
    addRepairOption(app, options->lint.repair);
    addCacheOption(app, options->lint.cache);
    options->files.add(app);
    app.footer(R"(lint looks at light maps, meshes, probes and settings before a cook: sign convention, axes, units, gamma
curves, coverage, normals, fireflies, light-map UVs, limits. Each finding has a code, the evidence in
figures, and what to write in the scene file. cook and verify do the same checks. The bake format of
each light map is printed first, with its evidence and with what the file does not say.

An error, such as a map without coverage, ends with exit code 3; a warning, which no right bake gets,
ends with exit code 0, with --strict 3; a note says what may be right as it is, and fails nothing.
`allow = [{ code = "...", reason = "..." }]` in the scene file silences a
warning or a note.)");
    return [options](Session& session) {
        if (auto ready = options->files.prepare(session); !ready) return session.finish(ready);
        const auto scene = readScene(options->lint.scene);
        if (scene)
            if (auto checked = session.paths.checkAgainstScene(*scene, {}); !checked) return session.finish(checked);
        const Outcome outcome = scene ? lintScene(*scene, options->lint, session.state) : outcomeOf(scene.error());
        const std::vector<formats::Error> errors = options->files.write(session, "lint", {outcome}, options->lint.scene, {});
        if (session.terminal.verbosity() != Verbosity::Quiet) printReadings(session.terminal, outcome.report);
        printFindings(session.terminal, outcome.findings);
        if (outcome.isLinted && session.terminal.verbosity() != Verbosity::Quiet)
            session.terminal.say(fmt::format("{}: {}", options->lint.scene.string(), countsOf(outcome)));
        return session.finish(errors);
    };
}

}  // namespace lightcook::pipeline

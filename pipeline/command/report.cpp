// lightcook report: memory budgets and errors of cooked scenes, one or several.
#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <memory>

#include "pipeline/command/command.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/outputs.h"
#include "pipeline/command/session.h"
#include "pipeline/command/terminal/printing.h"
#include "pipeline/cook/verdicts.h"
#include "pipeline/manifest/cooked_folder.h"
#include "pipeline/report/collection.h"
#include "pipeline/report/page.h"
#include "pipeline/report/words.h"

namespace lightcook::pipeline {
namespace {

using formats::Error;
using formats::ErrorCode;
using formats::failure;
using formats::Result;

struct ReportOptions {
    std::vector<std::filesystem::path> folders;
    std::filesystem::path html, baseline, budgets, history;
    AllowedGrowth allowed;
    JsonOutput json;
};

/// Adds an error if the GPU memory grew by more than is allowed.
template <class Comparison>
void appendGrowth(const Comparison& comparison, std::vector<Error>& errors) {
    if (comparison.allowed.memory && comparison.growthPercent > *comparison.allowed.memory)
        errors.push_back({ErrorCode::OverBudget, comparison.file,
                          fmt::format("found {} of GPU memory, {:.2f} % more than the baseline's {}, expected at most {} % more",
                                      sizeWords(comparison.bytesNow), comparison.growthPercent, sizeWords(comparison.bytesBefore),
                                      *comparison.allowed.memory)});
}

/// Adds an error for each error of an asset that grew by more than is allowed.
/// place  file of the baseline, and the scene of several
void appendGrownErrors(const std::vector<AssetChange>& assets, const AllowedGrowth& allowed, const std::string& place,
                       std::vector<Error>& errors) {
    if (!allowed.error) return;
    for (const AssetChange& asset : assets)
        for (const std::string& grown : grownErrors(asset, *allowed.error))
            errors.push_back({ErrorCode::OverLimit, place + ", " + asset.name,
                              fmt::format("found {}, expected at most {} % more", grown, *allowed.error)});
}

/// Reads every folder, and refuses two of one scene and target.
Result<std::vector<CookedFolder>> readFolders(const std::vector<std::filesystem::path>& folders) {
    std::vector<CookedFolder> read;
    std::map<std::pair<std::string, std::string>, std::filesystem::path> seen;
    std::vector<std::filesystem::path> cookedFolders;
    for (const std::filesystem::path& folder : folders) std::ranges::copy(targetFolders(folder), std::back_inserter(cookedFolders));
    for (const std::filesystem::path& folder : cookedFolders) {
        LC_TRY(cooked, readCookedFolder(folder));
        const auto [place, isNew] = seen.try_emplace({cooked->report.scene, cooked->target}, folder);
        if (!isNew)
            return failure(ErrorCode::InvalidRequest, folder,
                           fmt::format("found the scene '{}' for target '{}', which {} has too, expected each scene once for a target",
                                       cooked->report.scene, cooked->target, place->second.string()));
        read.push_back(std::move(*cooked));
    }
    return read;
}

/// Holds the scenes against the budgets of platforms. Warns of limits for scenes and targets that are not there.
Result<std::vector<PlatformUse>> platformsOf(const std::filesystem::path& file, const std::vector<CookedFolder>& folders,
                                             Terminal& terminal) {
    LC_TRY(budgets, readBudgets(file));
    std::vector<SceneMemory> memory;
    for (const CookedFolder& folder : folders) memory.push_back(memoryOf(folder));
    if (const auto unknown = warningOfUnknownScenes(*budgets, memory)) terminal.warning(file.string() + ", scenes", *unknown);
    if (const auto unused = warningOfUnusedPlatforms(*budgets, memory)) terminal.warning(file.string() + ", platforms", *unused);
    return usesOf(*budgets, memory);
}

Result<std::vector<HistoryLine>> historyOf(const std::filesystem::path& file, const std::vector<CookedFolder>& folders) {
    if (file.empty()) return std::vector<HistoryLine>();
    std::vector<HistoryLine> lines;
    for (const CookedFolder& folder : folders) {
        HistoryLine line = historyLine(folder.report, folder.target);
        line.passed = folder.errors.empty();
        lines.push_back(std::move(line));
    }
    return appendHistory(file, lines);
}

/// Returns "3 scenes", or of a single one "the scene 'hall' for target 'bc'".
std::string scenesIn(const std::vector<SceneSummary>& scenes) {
    if (scenes.size() != 1) return fmt::format("{} scenes", scenes.size());
    const std::string target = scenes.front().target.empty() ? "" : fmt::format(" for target '{}'", scenes.front().target);
    return fmt::format("the scene '{}'{}", scenes.front().name, target);
}

Result<BaselineComparison> comparisonOf(const ReportOptions& options, const CookedFolder& folder) {
    LC_TRY(before, readBaselineScenes(options.baseline));
    std::error_code code;
    const bool isFolder = std::filesystem::is_directory(options.baseline, code);
    const std::filesystem::path file = isFolder ? options.baseline / kReportName : options.baseline;
    // A single report.json without its manifest does not say its target.
    const auto isSame = [&](const SceneSummary& scene) {
        return scene.name == folder.report.scene && (scene.target.empty() || scene.target == folder.target);
    };
    const auto scene = std::ranges::find_if(*before, isSame);
    if (scene == before->end())
        return failure(
            ErrorCode::FileUnreadable, file,
            fmt::format("found {}, expected one named '{}' for target '{}'", scenesIn(*before), folder.report.scene, folder.target));
    BaselineComparison comparison = compareWithScene(folder.report, *scene, file.string(), options.allowed);
    addPictures(comparison.assets, scene->folder.empty() ? file.parent_path().string() : scene->folder, folder.folder.string());
    return comparison;
}

int reportOne(const ReportOptions& options, CookedFolder folder, const std::vector<HistoryLine>& history, Session& session) {
    Report& report = folder.report;
    std::vector<Error> errors = folder.errors;
    if (report.platforms) {
        folder.json["platforms"] = jsonOf(*report.platforms);
        for (Error& error : errorsOf(*report.platforms, options.budgets.string())) errors.push_back(std::move(error));
    }
    if (report.baseline) {
        folder.json["baseline"] = jsonOf(*report.baseline);
        appendGrowth(*report.baseline, errors);
        appendGrownErrors(report.baseline->assets, report.baseline->allowed, report.baseline->file, errors);
    }
    // A scene that passed its cook may be over the budget of a platform, or have grown by too much.
    report.passed = errors.empty();
    folder.json["passed"] = report.passed;
    if (!options.html.empty()) {
        std::vector<HistoryLine> own;
        for (const HistoryLine& line : history)
            if (line.scene == report.scene && line.target == folder.target) own.push_back(line);
        if (auto written = session.write(options.html, renderReportHtml(report, folder.folder, own)); !written)
            errors.push_back(written.error());
    }
    if (auto written = options.json.write(session, folder.json, errors); !written) errors.push_back(written.error());
    if (session.terminal.verbosity() != Verbosity::Quiet) {
        printReport(session.terminal, report);
        if (report.platforms) printPlatforms(session.terminal, *report.platforms);
        if (report.baseline) printComparison(session.terminal, *report.baseline);
    }
    return session.finish(errors);
}

int reportMany(const ReportOptions& options, const std::vector<CookedFolder>& folders, CollectionReport report,
               const std::vector<HistoryLine>& history, Session& session) {
    std::vector<Error> errors;
    for (const CookedFolder& folder : folders)
        for (const Error& error : folder.errors) errors.push_back({error.code, folder.report.scene + ", " + error.subject, error.detail});
    if (report.platforms)
        for (Error& error : errorsOf(*report.platforms, options.budgets.string())) errors.push_back(std::move(error));
    if (report.baseline) {
        appendGrowth(*report.baseline, errors);
        for (const SceneChange& scene : report.baseline->scenes)
            appendGrownErrors(scene.assets, report.baseline->allowed, report.baseline->file + ", " + scene.name, errors);
    }
    report.passed = errors.empty();
    if (!options.html.empty()) {
        const std::filesystem::path page = options.html == kStandardOutput ? std::filesystem::path() : options.html;
        if (auto written = session.write(options.html, renderCollectionHtml(report, page, history)); !written)
            errors.push_back(written.error());
    }
    if (auto written = options.json.write(session, toJson(report), errors); !written) errors.push_back(written.error());
    if (session.terminal.verbosity() != Verbosity::Quiet) printCollection(session.terminal, report);
    return session.finish(errors);
}

int runReport(const ReportOptions& options, Session& session) {
    options.json.prepare(session);
    const bool isHtmlOnOutput = options.html == kStandardOutput;
    if (isHtmlOnOutput && options.json.isStandardOutput())
        return session.finish(
            {{ErrorCode::InvalidRequest, "--json, --html", "found - for both, expected one document on standard output"}});
    if (isHtmlOnOutput) session.terminal.keepOutputForData();
    if (auto checked = checkIsFile("--history", options.history); !checked) return options.json.finish(session, {}, {checked.error()});
    // Every input is read before anything is written.
    auto folders = readFolders(options.folders);
    if (!folders) return options.json.finish(session, {}, {folders.error()});
    std::optional<std::vector<PlatformUse>> platforms;
    if (!options.budgets.empty()) {
        auto read = platformsOf(options.budgets, *folders, session.terminal);
        if (!read) return options.json.finish(session, {}, {read.error()});
        platforms = std::move(*read);
    }
    const bool isOne = folders->size() == 1;
    CollectionReport collection;
    if (!isOne) {
        collection = makeCollection(*folders);
        collection.platforms = platforms;
    }
    folders->front().report.platforms = std::move(platforms);
    if (!options.baseline.empty() && isOne) {
        auto comparison = comparisonOf(options, folders->front());
        if (!comparison) return options.json.finish(session, {}, {comparison.error()});
        folders->front().report.baseline = std::move(*comparison);
    } else if (!options.baseline.empty()) {
        const auto before = readBaselineScenes(options.baseline);
        if (!before) return options.json.finish(session, {}, {before.error()});
        collection.baseline = compareCollections(collection, *before, options.baseline, options.allowed);
    }
    const auto history = historyOf(options.history, *folders);
    if (!history) return options.json.finish(session, {}, {history.error()});
    if (isOne) return reportOne(options, std::move(folders->front()), *history, session);
    return reportMany(options, *folders, std::move(collection), *history, session);
}

}  // namespace

CommandFunction defineReport(CLI::App& app) {
    const auto options = std::make_shared<ReportOptions>();
    addFoldersOption(app, "folder", options->folders, "Output folders of cook; several are reported together")->required();
    options->json.add(app, "the report, and with --baseline the comparison,");
    declareWritten(addFileOption(app, "--html", options->html, "Write the report as one self-contained HTML page; - is standard output"),
                   Written::File);
    CLI::Option* baseline =
        addFileOption(app, "--baseline", options->baseline,
                      "An older report (report.json, its folder, or what --json wrote of several scenes): compare asset "
                      "by asset, bytes and error");
    addPercentOption(app, "--fail-over", options->allowed.memory,
                     "Growth of the GPU memory of all scenes over the baseline that is allowed; more ends with code 5. Default: any")
        ->needs(baseline);
    addPercentOption(app, "--fail-over-error", options->allowed.error,
                     "Growth of each error of an asset (rel_rms, visible p99, seam) over the baseline that is allowed; more ends with "
                     "code 4. Default: any")
        ->needs(baseline);
    addFileOption(app, "--budgets", options->budgets, "Memory budgets of platforms (TOML); more ends with code 5");
    declareWritten(addFileOption(app, "--history", options->history, "Append a line for each scene (JSON lines); the page draws the trend"),
                   Written::File);
    app.footer(R"(The exit code is that of the folder: 3 if its manifest or report cannot be read, that of the first error
if `cook --keep-going` left assets out, 4 if its verification failed, a file was changed since the cook or an error grew by more
than --fail-over-error, 5 if it needs more GPU memory than the scene's budget or a platform's, or grew by
more than --fail-over. Without these two a comparison is information and fails nothing.

Of several folders, or of one with several targets, there is one page and one JSON: totals by kind, format
and target, and a row for each scene. The exit code is that of the first failure, in the order of the folders. Each scene may
be there once for a target.)");
    return [options](Session& session) { return runReport(*options, session); };
}

}  // namespace lightcook::pipeline

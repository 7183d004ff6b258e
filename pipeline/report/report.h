// report.json: memory against the budget, errors and their bounds against the limits, time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/graph/action.h"
#include "pipeline/graph/files.h"
#include "pipeline/graph/run_record.h"
#include "pipeline/lint/finding.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/report/baseline.h"
#include "pipeline/report/budgets.h"
#include "pipeline/report/frontier.h"
#include "pipeline/report/history.h"
#include "pipeline/report/report_row.h"
#include "pipeline/report/scene_error.h"
#include "pipeline/report/skip.h"

namespace lightcook::pipeline {

inline constexpr const char* kReportName = "report.json";
inline constexpr const char* kReportHtmlName = "report.html";

/// Name in `by_format` of GPU memory that is no texture: vertices of meshes.
inline constexpr const char* kVertexMemory = "mesh";

/// Largest and used GPU memory of a scene.
struct MemoryBudget {
    std::optional<std::uint64_t> limitBytes;  ///< none: no limit
    std::uint64_t usedBytes = 0;
    std::map<std::string, std::uint64_t> byKind, byFormat;
    std::vector<FrontierPoint> frontier;  ///< of a scene whose layouts a budget chose, the smallest first
    std::string advice = {};              ///< of a budget that is not kept
    bool isKept() const { return !limitBytes || usedBytes <= *limitBytes; }
};
template <class Fields, Is<MemoryBudget> Self>
void describe(Fields& fields, Self& budget) {
    constexpr FieldRule kBytes = between(0, kLargestBytes);
    fields.nullable("limit_bytes", budget.limitBytes, kBytes, "budget [bytes], null without one");
    fields.required("used_bytes", budget.usedBytes, kBytes, "GPU memory of all assets");
    fields.required("by_kind", budget.byKind, kBytes, "GPU memory by kind of asset");
    fields.required("by_format", budget.byFormat, kBytes, "GPU memory by pixel format; `mesh`: vertices");
    fields.presentIf(
        !budget.frontier.empty(), "frontier", budget.frontier,
        "where a budget chose the layouts: the allocations that no other beats in bytes and visible error, the smallest first");
    fields.presentIf(!budget.advice.empty(), "advice", budget.advice, "what to do about a budget that is not kept");
}

struct ReportFile {
    std::string file, digest;
};
template <class Fields, Is<ReportFile> Self>
void describe(Fields& fields, Self& file) {
    fields.required("file", file.file, kFileInFolder, "manifest, page or picture");
    fields.required("digest", file.digest, "XXH3-128 of the file");
}

/// A formats::Error in the JSON of a command that failed.
struct DocumentError {
    int exitCode = 1;
    std::string subject, detail, asset = {}, file = {};
    std::optional<int> line = {};
    bool operator==(const DocumentError&) const = default;

    static DocumentError of(const formats::Error& error);
    formats::Error error() const;
};
template <class Fields, class Self>
void describeError(Fields& fields, Self& error, std::string_view keyOfCode) {
    fields.required(keyOfCode, error.exitCode, between(1, 6), "exit code of this error");
    fields.required("subject", error.subject, "file and place");
    fields.required("detail", error.detail, "what was found, and what was expected");
    fields.presentIf(!error.asset.empty(), "asset", error.asset, "asset that it stopped");
    fields.presentIf(!error.file.empty(), "file", error.file, "file that it is about");
    fields.optional("line", error.line, "line of that file");
}
template <class Fields, Is<DocumentError> Self>
void describe(Fields& fields, Self& error) {
    describeError(fields, error, "code");
}

/// The error of an action that failed in a cook that went on with the others.
struct FailedAction : DocumentError {};
template <class Fields, Is<FailedAction> Self>
void describe(Fields& fields, Self& failed) {
    describeError(fields, failed, "exit_code");
}

/// Assets that a cook with --keep-going left out, and the errors that stopped them.
struct IncompleteCook {
    std::vector<std::string> assets;
    std::vector<FailedAction> errors;
    bool operator==(const IncompleteCook&) const = default;
};
template <class Fields, Is<IncompleteCook> Self>
void describe(Fields& fields, Self& incomplete) {
    fields.required("assets", incomplete.assets, "assets of the scene that are not in the folder");
    fields.required("errors", incomplete.errors, "errors of that cook, the first one first");
}

/// report.json.
struct Report {
    std::string scene;
    std::optional<Tool> tool;
    bool passed = false;
    double seconds = 0;
    std::uint64_t peakRssBytes = 0;
    std::vector<RunRecord> runs;  ///< that made the results, the first one first
    std::vector<ReportRow> assets;
    std::vector<Skip> skipped;
    std::optional<IncompleteCook> incomplete;
    std::vector<std::string> partial;  ///< assets of the scene that `cook --only` left out
    MemoryBudget budget;
    std::vector<Finding> findings;
    std::optional<SceneError> whole;
    std::optional<BaselineComparison> baseline;         ///< of `report --baseline`
    std::optional<std::vector<PlatformUse>> platforms;  ///< of `report --budgets`
    std::optional<std::vector<ReportFile>> files;
    std::optional<std::string> digest;  ///< of a report that was read
    // Only the document of --json has these: see JsonOutput.
    std::optional<int> exitCode;
    std::optional<std::vector<DocumentError>> errors;
};
template <class Fields, Is<Report> Self>
void describe(Fields& fields, Self& report) {
    fields.required("scene", report.scene, "name of the scene");
    fields.optional("tool", report.tool, "program that wrote the report");
    fields.required("passed", report.passed,
                    "true if every asset was cooked and passed, and the scene keeps its budget and its limits on the whole");
    fields.required("seconds", report.seconds, between(0, HUGE_VAL),
                    "wall time of the runs that made the results, of each its part in them; of a verification its own");
    fields.required("peak_rss_bytes", report.peakRssBytes, between(0, kLargestBytes), "most memory that was resident in one of them");
    fields.presentIf(!report.runs.empty(), "runs", report.runs, "runs that made the results: what came from the cache keeps its own");
    fields.required("assets", report.assets, "a row for each asset");
    fields.required("skipped", report.skipped, "assets that were not cooked, and actions whose results were reused");
    fields.optional("incomplete", report.incomplete, "what `cook --keep-going` could not cook; absent if the folder is complete");
    fields.presentIf(!report.partial.empty(), "partial", report.partial, kPartialCaption);
    fields.required("budget", report.budget, "GPU memory");
    fields.presentIf(true, "findings", report.findings, "what lint found in the inputs");
    fields.optional("whole", report.whole, "error of the whole shading of the scene");
    fields.optional("baseline", report.baseline, "comparison with an older report: of `lightcook report --baseline`");
    fields.optional("platforms", report.platforms, "budgets of platforms: of `lightcook report --budgets`");
    fields.optional("files", report.files, "files that belong to this report");
    fields.optional("digest", report.digest, "XXH3-128 of this file, taken with zeros for the digits of the digest itself");
    fields.optional("exit_code", report.exitCode, between(1, 6), "in the document of `--json` of a command that failed: its exit code");
    fields.optional("errors", report.errors, "in the document of `--json` of a command that failed: its errors, the first one first");
}

/// Results of the actions of an asset; null where there was no such action.
struct AssetRecords {
    const ActionRecord *cooked, *verified;
    const ActionRecord* whole = nullptr;  ///< verification of a light map and its dominant light together
};

/// Returns the row of an asset: its manifest entry, the results of its cook and its verification, and the time of each. addFailures() gives
/// it its failures.
formats::Result<ReportRow> reportRow(const CookedAsset& asset, const AssetRecords& records);

/// Members of a report that do not depend on the rows.
struct ReportFrame {
    std::string scene;
    double seconds = 0;
    std::uint64_t peakRssBytes = 0;
    std::optional<std::uint64_t> budgetBytes;
    std::vector<RunRecord> runs = {};  ///< that made the results; empty: the time and memory above
    std::vector<Finding> findings = {};
    std::vector<FrontierPoint> frontier = {};  ///< of the budget
    std::optional<IncompleteCook> incomplete = {};
    std::vector<std::string> partial = {};
};
/// Returns a report. `passed` is true if every asset that was asked for was cooked and passed, and the memory is within the budget.
Report makeReport(const ReportFrame& frame, std::vector<ReportRow> rows, std::vector<Skip> skipped);

/// Returns the pictures that rows name, relative to the folder of the report. A report may have been edited: names outside its folder of
/// pictures are left out.
std::vector<std::string> picturesOf(const std::vector<ReportRow>& rows);

/// Reads a report, and refuses one of another shape.
formats::Result<Report> loadReport(const std::filesystem::path& file);
/// Returns the same as JSON.
formats::Result<Json> readReport(const std::filesystem::path& file);

}  // namespace lightcook::pipeline

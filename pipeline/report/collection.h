// The report of several cooked folders: memory and errors of each scene, totals, budgets of platforms, growth over an older one.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "formats/error.h"
#include "pipeline/document/json_fields.h"
#include "pipeline/report/baseline.h"
#include "pipeline/report/budgets.h"
#include "pipeline/report/history.h"
#include "pipeline/report/limit_use.h"
#include "pipeline/report/report.h"

namespace lightcook::pipeline {

/// An asset of a scene, with the figures of its last stage.
struct AssetSummary {
    std::string name;
    AssetKind kind = AssetKind::LightMap;
    double limit = 0;  ///< on rel_rms
    AssetFigures figures;
    std::optional<LimitUse> limitUse = {};  ///< mostUsedLimit; not in JSON
};
template <class Fields, Is<AssetSummary> Self>
void describe(Fields& fields, Self& asset) {
    fields.required("name", asset.name, "name of the asset");
    fields.required("kind", asset.kind, "kind of asset");
    fields.required("limit", asset.limit, kFigure, "limit on rel_rms");
    describe(fields, asset.figures);
}

struct SceneSummary {
    std::string name, target;
    std::string folder;  ///< as it was named on the command line
    bool passed = false;
    double seconds = 0;
    std::uint64_t bytesDisk = 0, bytesSaved = 0;
    MemoryBudget budget;
    std::optional<double> sceneError;  ///< SceneError::relRms
    int findingCount = 0;
    std::vector<AssetSummary> assets;
    std::vector<std::string> errors;   ///< lines of why it did not pass
    std::vector<std::string> partial;  ///< Report::partial
};
template <class Fields, Is<SceneSummary> Self>
void describe(Fields& fields, Self& scene) {
    fields.required("name", scene.name, "name of the scene");
    fields.required("target", scene.target, "target of the cook");
    fields.required("folder", scene.folder, "cooked folder, as it was named on the command line");
    fields.required("passed", scene.passed, "true if the scene passed and no file was changed since");
    fields.required("seconds", scene.seconds, kFigure, "wall time of the runs that made it");
    fields.required("bytes_disk", scene.bytesDisk, "size of the files [bytes]");
    fields.required("bytes_saved", scene.bytesSaved, "GPU memory that skipped work saved [bytes]");
    fields.required("budget", scene.budget, "GPU memory");
    fields.optional("whole_rel_rms", scene.sceneError, kFigure, "error of the whole shading of the scene");
    fields.required("findings", scene.findingCount, "number of warnings and errors of lint that are not allowed");
    fields.required("assets", scene.assets, "assets with the figures of their last stages");
    fields.required("errors", scene.errors, "why the scene did not pass");
    fields.presentIf(!scene.partial.empty(), "partial", scene.partial, kPartialCaption);
}

/// Change of a scene since a baseline.
struct SceneChange {
    std::string name, target;
    std::string change;  ///< same, changed, added or removed
    std::uint64_t bytesBefore = 0, bytesNow = 0;
    double growthPercent = 0;
    std::vector<AssetChange> assets;  ///< that changed
};
template <class Fields, Is<SceneChange> Self>
void describe(Fields& fields, Self& scene) {
    fields.required("name", scene.name, "name of the scene");
    fields.required("target", scene.target, "target of the cook");
    fields.required("change", scene.change, "same, changed, added or removed");
    fields.required("bytes_before", scene.bytesBefore, "GPU memory in the baseline [bytes]");
    fields.required("bytes_now", scene.bytesNow, "GPU memory now [bytes]");
    fields.required("growth_percent", scene.growthPercent, "growth of the GPU memory");
    fields.required("assets", scene.assets, "assets that are not the same");
}

struct CollectionComparison {
    std::string file;
    std::uint64_t bytesBefore = 0, bytesNow = 0;
    double growthPercent = 0;
    AllowedGrowth allowed;
    bool passed = true;
    std::vector<SceneChange> scenes;
};
template <class Fields, Is<CollectionComparison> Self>
void describe(Fields& fields, Self& baseline) {
    fields.required("file", baseline.file, "the older report");
    fields.required("bytes_before", baseline.bytesBefore, "GPU memory of all scenes in the baseline [bytes]");
    fields.required("bytes_now", baseline.bytesNow, "GPU memory of all scenes in this report [bytes]");
    fields.required("growth_percent", baseline.growthPercent, "growth of the GPU memory");
    describe(fields, baseline.allowed);
    fields.required("passed", baseline.passed, "false if a growth is over the allowed one");
    fields.required("scenes", baseline.scenes, "scenes of both reports, by name and target");
}

/// Totals of all scenes.
struct CollectionTotals {
    std::uint64_t bytesGpu = 0, bytesDisk = 0, bytesSaved = 0;
    std::map<std::string, std::uint64_t> byKind, byFormat, byTarget;
};
template <class Fields, Is<CollectionTotals> Self>
void describe(Fields& fields, Self& totals) {
    fields.required("bytes_gpu", totals.bytesGpu, "GPU memory [bytes]");
    fields.required("bytes_disk", totals.bytesDisk, "size of the files [bytes]");
    fields.required("bytes_saved", totals.bytesSaved, "GPU memory that skipped work saved [bytes]");
    fields.required("by_kind", totals.byKind, "GPU memory by kind of asset");
    fields.required("by_format", totals.byFormat, "GPU memory by pixel format, as in report.json");
    fields.required("by_target", totals.byTarget, "GPU memory by target of the cook");
}

struct CollectionReport {
    Tool tool;
    bool passed = false;
    CollectionTotals totals;
    std::vector<SceneSummary> scenes;  ///< the largest first
    std::optional<std::vector<PlatformUse>> platforms;
    std::optional<CollectionComparison> baseline;
};
template <class Fields, Is<CollectionReport> Self>
void describe(Fields& fields, Self& report) {
    fields.required("tool", report.tool, "program that wrote the report");
    fields.required("passed", report.passed, "true if every scene passed and every budget is kept");
    fields.required("totals", report.totals, "memory of all scenes");
    fields.required("scenes", report.scenes, "a row for each scene, the one with the most GPU memory first");
    fields.optional("platforms", report.platforms, "budgets of platforms: of --budgets");
    fields.optional("baseline", report.baseline, "comparison with an older report: of --baseline");
}

/// A cooked folder that was read.
struct CookedFolder {
    std::filesystem::path folder;
    Json json;  ///< report.json
    Report report;
    std::string target;
    std::vector<formats::Error> errors;  ///< of its verification, budget and files
};

/// Returns the memory of a folder, as budgets count it.
SceneMemory memoryOf(const CookedFolder& folder);
SceneSummary summaryOf(const CookedFolder& folder);

/// Returns the report of several folders. `passed` does not count a baseline.
CollectionReport makeCollection(const std::vector<CookedFolder>& folders);

/// Reads an older report of one or several scenes, and returns its scenes. A folder stands for the report.json in it.
formats::Result<std::vector<SceneSummary>> readBaselineScenes(const std::filesystem::path& file);

/// Compares a report with one scene of an older one.
BaselineComparison compareWithScene(const Report& now, const SceneSummary& before, std::string file, const AllowedGrowth& allowed);

/// Compares scenes with older ones by name and target.
CollectionComparison compareCollections(const CollectionReport& now, const std::vector<SceneSummary>& before,
                                        const std::filesystem::path& file, const AllowedGrowth& allowed);

}  // namespace lightcook::pipeline

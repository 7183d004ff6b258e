#include "pipeline/report/collection.h"

#include <fmt/format.h>

#include <algorithm>

#include "pipeline/graph/files.h"
#include "pipeline/graph/version.h"
#include "pipeline/manifest/manifest.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

SceneSummary summaryOf(const Report& report) {
    SceneSummary scene;
    scene.name = report.scene;
    scene.passed = report.passed;
    scene.partial = report.partial;
    scene.seconds = report.seconds;
    scene.budget = report.budget;
    if (report.whole) scene.sceneError = report.whole->shading.relRms;
    for (const ReportRow& row : report.assets) {
        scene.bytesDisk += row.bytesDisk;
        scene.assets.push_back(
            {row.name, row.kind, row.verdict.limits[Limit::Error].value_or(kNoErrorLimit), pipeline::figuresOf(row), mostUsedLimit(row)});
    }
    for (const Skip& skip : report.skipped) scene.bytesSaved += skip.bytesSaved;
    scene.findingCount = static_cast<int>(
        std::ranges::count_if(report.findings, [](const Finding& finding) { return !finding.allowed.has_value() && !finding.isNote(); }));
    return scene;
}

SceneFigures figuresOf(const SceneSummary& scene) {
    SceneFigures figures;
    figures.bytes = scene.budget.usedBytes;
    for (const AssetSummary& asset : scene.assets) figures.assets[asset.name] = asset.figures;
    return figures;
}

using SceneKey = std::pair<std::string, std::string>;  ///< name and target

SceneChange changeOf(const SceneSummary* before, const SceneSummary* now, const std::filesystem::path& baselineFolder) {
    SceneChange change;
    change.name = now != nullptr ? now->name : before->name;
    change.target = now != nullptr ? now->target : before->target;
    change.bytesBefore = before != nullptr ? before->budget.usedBytes : 0;
    change.bytesNow = now != nullptr ? now->budget.usedBytes : 0;
    change.growthPercent = growthPercent(change.bytesBefore, change.bytesNow);
    change.assets = compareAssets(before != nullptr ? figuresOf(*before).assets : std::map<std::string, AssetFigures>(),
                                  now != nullptr ? figuresOf(*now).assets : std::map<std::string, AssetFigures>());
    std::erase_if(change.assets, [](const AssetChange& asset) { return asset.change == "same"; });
    if (before != nullptr && now != nullptr)
        addPictures(change.assets, before->folder.empty() ? baselineFolder.string() : before->folder, now->folder);
    change.change = before == nullptr ? "added" : now == nullptr ? "removed" : change.assets.empty() ? "same" : "changed";
    return change;
}

}  // namespace

SceneMemory memoryOf(const CookedFolder& folder) {
    const MemoryBudget& budget = folder.report.budget;
    return {folder.report.scene, folder.target, budget.usedBytes, budget.byKind, budget.byFormat};
}

SceneSummary summaryOf(const CookedFolder& folder) {
    SceneSummary scene = summaryOf(folder.report);
    scene.target = folder.target;
    scene.folder = folder.folder.string();
    scene.passed = folder.errors.empty();
    for (const formats::Error& error : folder.errors) scene.errors.push_back(error.line());
    return scene;
}

CollectionReport makeCollection(const std::vector<CookedFolder>& folders) {
    CollectionReport report;
    report.tool = {kToolName, kToolVersion};
    report.passed = true;
    for (const CookedFolder& folder : folders) {
        SceneSummary scene = summaryOf(folder);
        report.passed = report.passed && scene.passed;
        report.totals.bytesGpu += scene.budget.usedBytes;
        report.totals.bytesDisk += scene.bytesDisk;
        report.totals.bytesSaved += scene.bytesSaved;
        report.totals.byTarget[scene.target] += scene.budget.usedBytes;
        for (const auto& [kind, bytes] : scene.budget.byKind) report.totals.byKind[kind] += bytes;
        for (const auto& [format, bytes] : scene.budget.byFormat) report.totals.byFormat[format] += bytes;
        report.scenes.push_back(std::move(scene));
    }
    std::ranges::sort(report.scenes, [](const SceneSummary& a, const SceneSummary& b) {
        if (a.budget.usedBytes != b.budget.usedBytes) return a.budget.usedBytes > b.budget.usedBytes;
        return SceneKey(a.name, a.target) < SceneKey(b.name, b.target);
    });
    return report;
}

Result<std::vector<SceneSummary>> readBaselineScenes(const std::filesystem::path& file) {
    std::error_code code;
    const std::filesystem::path named = std::filesystem::is_directory(file, code) ? file / kReportName : file;
    LC_TRY(text, readFile(named));
    const Json json = parseJson(*text);
    if (!json.is_object() || !json.contains("scenes") || !json.contains("totals")) {
        LC_TRY(report, loadReport(named));
        SceneSummary scene = summaryOf(*report);
        if (const auto manifest = loadManifest(named.parent_path())) scene.target = manifest->target;
        return std::vector{std::move(scene)};
    }
    LC_TRY(collection, fromJson<CollectionReport>(json, named));
    return std::move(collection->scenes);
}

BaselineComparison compareWithScene(const Report& now, const SceneSummary& before, std::string file, const AllowedGrowth& allowed) {
    return compareFigures(pipeline::figuresOf(now), figuresOf(before), std::move(file), allowed);
}

CollectionComparison compareCollections(const CollectionReport& now, const std::vector<SceneSummary>& before,
                                        const std::filesystem::path& file, const AllowedGrowth& allowed) {
    std::error_code code;
    const std::filesystem::path folder = std::filesystem::is_directory(file, code) ? file : file.parent_path();
    std::map<SceneKey, std::pair<const SceneSummary*, const SceneSummary*>> pairs;
    CollectionComparison comparison;
    comparison.file = file.string();
    for (const SceneSummary& scene : now.scenes) pairs[{scene.name, scene.target}].second = &scene;
    for (const SceneSummary& scene : before) {
        // A single report.json without its manifest does not say its target.
        auto same = pairs.find({scene.name, scene.target});
        if (same == pairs.end() && scene.target.empty())
            same = std::ranges::find_if(pairs, [&](const auto& pair) { return pair.first.first == scene.name; });
        (same == pairs.end() ? pairs[{scene.name, scene.target}] : same->second).first = &scene;
    }
    for (const auto& [key, scenes] : pairs) {
        SceneChange change = changeOf(scenes.first, scenes.second, folder);
        comparison.bytesBefore += change.bytesBefore;
        comparison.bytesNow += change.bytesNow;
        comparison.scenes.push_back(std::move(change));
    }
    // The largest growth stands first.
    std::ranges::stable_sort(comparison.scenes, [](const SceneChange& a, const SceneChange& b) {
        const auto growth = [](const SceneChange& scene) {
            return static_cast<std::int64_t>(scene.bytesNow) - static_cast<std::int64_t>(scene.bytesBefore);
        };
        if ((a.change == "same") != (b.change == "same")) return b.change == "same";
        return growth(a) > growth(b);
    });
    comparison.growthPercent = growthPercent(comparison.bytesBefore, comparison.bytesNow);
    comparison.allowed = allowed;
    comparison.passed =
        isKept({allowed.memory, {}}, comparison.growthPercent, {}) && std::ranges::all_of(comparison.scenes, [&](const SceneChange& scene) {
            return isKept({{}, allowed.error}, scene.growthPercent, scene.assets);
        });
    return comparison;
}

}  // namespace lightcook::pipeline

#include "pipeline/report/baseline.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>

#include "pipeline/report/report.h"
#include "pipeline/report/words.h"

namespace lightcook::pipeline {
namespace {

/// Returns the file of an asset's difference picture, or nothing if there is none.
std::optional<std::string> differencePicture(const std::filesystem::path& folder, const std::string& asset) {
    const std::filesystem::path file = folder / "preview" / (asset + "_difference.png");
    std::error_code code;
    return std::filesystem::is_regular_file(file, code) ? std::optional(file.string()) : std::nullopt;
}

}  // namespace

bool isKept(const AllowedGrowth& allowed, double growthPercent, const std::vector<AssetChange>& assets) {
    const auto isGrown = [&](const AssetChange& asset) { return allowed.error && !grownErrors(asset, *allowed.error).empty(); };
    return (!allowed.memory || growthPercent <= *allowed.memory) && std::ranges::none_of(assets, isGrown);
}

double growthPercent(std::uint64_t before, std::uint64_t now) {
    if (before == 0) return now > 0 ? 100.0 : 0.0;
    return 100 * (static_cast<double>(now) - static_cast<double>(before)) / static_cast<double>(before);
}

std::string growthWords(std::uint64_t before, std::uint64_t now) {
    return isNew(before, now) ? "new" : fmt::format("{:+.2f} %", growthPercent(before, now));
}

std::vector<std::string> grownErrors(const AssetChange& asset, double percent) {
    struct Row {
        std::optional<double> AssetFigures::*figure;
        const char* name;
        bool isRatio;
    };
    constexpr std::array kRows = {Row{&AssetFigures::diffuse, "rel_rms of diffuse light", true},
                                  Row{&AssetFigures::specular, "rel_rms of specular light", true},
                                  Row{&AssetFigures::visible, "visible p99", false}, Row{&AssetFigures::seam, "seam", false}};
    std::vector<std::string> grown;
    if (!asset.before || !asset.now) return grown;
    for (const Row& row : kRows) {
        const std::optional<double>&before = (*asset.before).*row.figure, &now = (*asset.now).*row.figure;
        if (!before || !now || *now <= (1 + percent / 100) * *before) continue;
        const auto words = [&](double value) { return row.isRatio ? humanPercent(value) : fmt::format("{:.3g}", value); };
        grown.push_back(
            fmt::format("{} {}, {:.3g} % more than the baseline's {}", row.name, words(*now), 100 * (*now / *before - 1), words(*before)));
    }
    return grown;
}

bool errorGrew(const AssetChange& asset) {
    constexpr double kNoticed = 0.1;
    return !grownErrors(asset, kNoticed).empty();
}

AssetFigures figuresOf(const ReportRow& row) {
    AssetFigures figures;
    figures.bytesGpu = row.bytesGpu;
    figures.layout = row.layout;
    figures.passed = row.verdict.passed;
    if (row.verdict.stages.empty()) return figures;
    const std::vector<verify::StageError>& stages = row.verdict.stages;
    if (hasShading(stages, &verify::StageError::diffuse)) figures.diffuse = stages.back().diffuse.relRms;
    if (hasShading(stages, &verify::StageError::specular)) figures.specular = stages.back().specular.relRms;
    figures.visible = visibleP99(row.verdict.stages.back());
    if (row.seams && !row.seams->stages.empty()) figures.seam = row.seams->largestAdded();
    return figures;
}

std::vector<AssetChange> compareAssets(const std::map<std::string, AssetFigures>& before, const std::map<std::string, AssetFigures>& now) {
    std::map<std::string, AssetChange> changes;
    for (const auto& [name, figures] : before) changes[name].before = figures;
    for (const auto& [name, figures] : now) changes[name].now = figures;
    std::vector<AssetChange> sorted;
    for (auto& [name, change] : changes) {
        change.name = name;
        if (!change.before) change.change = "added";
        if (!change.now) change.change = "removed";
        if (change.before && change.now) {
            // A report of an older version has no visible errors and no seams: that is no change of the asset.
            if (!change.before->visible) change.now->visible.reset();
            if (!change.before->seam) change.now->seam.reset();
            // It has an error of 0 in place of none.
            for (const auto figure : {&AssetFigures::diffuse, &AssetFigures::specular})
                if (!((*change.now).*figure) && (*change.before).*figure == 0.0) ((*change.before).*figure).reset();
            change.change = jsonOf(*change.before) == jsonOf(*change.now) ? "same" : "changed";
            change.growthPercent = growthPercent(change.before->bytesGpu, change.now->bytesGpu);
        }
        sorted.push_back(std::move(change));
    }
    return sorted;
}

void addPictures(std::vector<AssetChange>& assets, const std::string& folderBefore, const std::string& folderNow) {
    std::error_code code;
    const bool hasBefore = !folderBefore.empty() && !std::filesystem::equivalent(folderBefore, folderNow, code) && !code;
    for (AssetChange& asset : assets) {
        if (!errorGrew(asset)) continue;
        asset.pictureNow = differencePicture(folderNow, asset.name);
        if (hasBefore) asset.pictureBefore = differencePicture(folderBefore, asset.name);
    }
}

SceneFigures figuresOf(const Report& report) {
    SceneFigures figures;
    figures.bytes = report.budget.usedBytes;
    for (const ReportRow& row : report.assets) figures.assets[row.name] = figuresOf(row);
    return figures;
}

BaselineComparison compareFigures(const SceneFigures& now, const SceneFigures& before, std::string file, const AllowedGrowth& allowed) {
    BaselineComparison comparison;
    comparison.file = std::move(file);
    comparison.bytesBefore = before.bytes;
    comparison.bytesNow = now.bytes;
    comparison.growthPercent = growthPercent(comparison.bytesBefore, comparison.bytesNow);
    comparison.allowed = allowed;
    comparison.assets = compareAssets(before.assets, now.assets);
    comparison.passed = isKept(allowed, comparison.growthPercent, comparison.assets);
    return comparison;
}

BaselineComparison compareWithBaseline(const Report& now, const Report& before, std::string file, const AllowedGrowth& allowed) {
    return compareFigures(figuresOf(now), figuresOf(before), std::move(file), allowed);
}

}  // namespace lightcook::pipeline

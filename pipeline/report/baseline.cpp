#include "pipeline/report/baseline.h"

#include <map>

#include "pipeline/report/report.h"

namespace lightcook::pipeline {
namespace {

/// Returns the growth in percent: of nothing to something 100.
double growth(std::uint64_t before, std::uint64_t now) {
    if (before == 0) return now > 0 ? 100.0 : 0.0;
    return 100 * (static_cast<double>(now) - static_cast<double>(before)) / static_cast<double>(before);
}

}  // namespace

AssetFigures figuresOf(const ReportRow& row) {
    AssetFigures figures;
    figures.bytesGpu = row.bytesGpu;
    figures.layout = row.layout;
    figures.passed = row.verdict.passed;
    if (row.verdict.stages.empty()) return figures;
    figures.diffuse = row.verdict.stages.back().diffuse.relRms;
    figures.specular = row.verdict.stages.back().specular.relRms;
    figures.visible = visibleP99(row.verdict.stages.back());
    return figures;
}

BaselineComparison compareWithBaseline(const Report& now, const Report& before, std::string file, std::optional<double> allowedPercent) {
    std::map<std::string, AssetChange> changes;
    for (const ReportRow& row : before.assets) changes[row.name].before = figuresOf(row);
    for (const ReportRow& row : now.assets) changes[row.name].now = figuresOf(row);
    BaselineComparison comparison;
    comparison.file = std::move(file);
    comparison.bytesBefore = before.budget.usedBytes;
    comparison.bytesNow = now.budget.usedBytes;
    comparison.growthPercent = growth(comparison.bytesBefore, comparison.bytesNow);
    comparison.allowedPercent = allowedPercent;
    comparison.passed = !allowedPercent || comparison.growthPercent <= *allowedPercent;
    for (auto& [name, change] : changes) {
        change.name = name;
        if (!change.before) change.change = "added";
        if (!change.now) change.change = "removed";
        if (change.before && change.now) {
            // A report of an older version has no visible errors: that is no change of the asset.
            if (!change.before->visible) change.now->visible.reset();
            change.change = jsonOf(*change.before) == jsonOf(*change.now) ? "same" : "changed";
            change.growthPercent = growth(change.before->bytesGpu, change.now->bytesGpu);
        }
        comparison.assets.push_back(std::move(change));
    }
    return comparison;
}

}  // namespace lightcook::pipeline

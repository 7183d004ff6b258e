// Comparison of a report with an older one, asset by asset: GPU memory and error.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/document/json_fields.h"

namespace lightcook::pipeline {

struct Report;
struct ReportRow;

/// Figures of an asset in one report.
struct AssetFigures {
    std::uint64_t bytesGpu = 0;
    std::string layout;
    std::optional<double> diffuse, specular;  ///< rel_rms of the last stage; none of light that the asset does not have
    std::optional<double> visible;            ///< visibleP99 of the last stage
    std::optional<double> seam;               ///< largest step that cooking adds to an edge
    bool passed = false;
};
template <class Fields, Is<AssetFigures> Self>
void describe(Fields& fields, Self& figures) {
    fields.required("bytes_gpu", figures.bytesGpu, "GPU memory [bytes]");
    fields.required("layout", figures.layout, "layout of the textures");
    fields.nullable("diffuse_rel_rms", figures.diffuse, between(0, HUGE_VAL), "rel_rms of diffuse light; null where the asset has none");
    fields.nullable("specular_rel_rms", figures.specular, between(0, HUGE_VAL), "rel_rms of specular light; null where the asset has none");
    fields.optional("visible_p99", figures.visible, kFigure, "99th percentile of the visible errors, the larger of diffuse and specular");
    fields.optional("seam_max", figures.seam, kFigure, "largest step that cooking adds to an edge that charts share");
    fields.required("passed", figures.passed, "true if the asset passed");
}
AssetFigures figuresOf(const ReportRow& row);

struct AssetChange {
    std::string name;
    std::string change;  ///< same, changed, added or removed
    std::optional<AssetFigures> before, now;
    std::optional<double> growthPercent;  ///< of the GPU memory, if both have some
    /// Files of the difference pictures, as the program opens them, if the error grew.
    std::optional<std::string> pictureBefore = {}, pictureNow = {};
};
template <class Fields, Is<AssetChange> Self>
void describe(Fields& fields, Self& asset) {
    fields.required("name", asset.name, "name of the asset");
    fields.required("change", asset.change, "same, changed, added or removed");
    fields.optional("before", asset.before, "figures in the baseline");
    fields.optional("now", asset.now, "figures in this report");
    fields.optional("growth_percent", asset.growthPercent, "growth of the GPU memory");
    fields.optional("picture_before", asset.pictureBefore, "picture of the errors in the baseline, where they grew and its folder has it");
    fields.optional("picture_now", asset.pictureNow, "picture of the errors now, where they grew");
}
/// Growth over a baseline that passes [percent]; none: any does.
struct AllowedGrowth {
    std::optional<double> memory;  ///< of all scenes
    std::optional<double> error;   ///< of each figure of an asset
};

/// Returns the errors of an asset that grew by more than a part of themselves: "visible p99 4.4, 12.8 % more than the baseline's 3.9".
std::vector<std::string> grownErrors(const AssetChange& asset, double percent);
/// Returns true if an error of the asset grew by more than a thousandth of itself.
bool errorGrew(const AssetChange& asset);
/// Returns true if the growth of the memory and of every error is allowed.
bool isKept(const AllowedGrowth& allowed, double growthPercent, const std::vector<AssetChange>& assets);
/// Returns the growth in percent: of nothing to something 100.
double growthPercent(std::uint64_t before, std::uint64_t now);
/// Returns true for a growth of nothing to something, which no percentage says.
inline bool isNew(std::uint64_t before, std::uint64_t now) {
    return before == 0 && now > 0;
}
/// Returns "+2.50 %"; of what is new "new".
std::string growthWords(std::uint64_t before, std::uint64_t now);

template <class Fields, Is<AllowedGrowth> Self>
void describe(Fields& fields, Self& allowed) {
    fields.optional("allowed_percent", allowed.memory, "largest growth of the GPU memory that passes: --fail-over");
    fields.optional("allowed_error_percent", allowed.error, "largest growth of an error of an asset that passes: --fail-over-error");
}

struct BaselineComparison {
    std::string file;
    std::uint64_t bytesBefore = 0, bytesNow = 0;
    double growthPercent = 0;
    AllowedGrowth allowed;
    bool passed = true;
    std::vector<AssetChange> assets;
};
template <class Fields, Is<BaselineComparison> Self>
void describe(Fields& fields, Self& baseline) {
    fields.required("file", baseline.file, "the older report");
    fields.required("bytes_before", baseline.bytesBefore, "GPU memory of all assets in the baseline [bytes]");
    fields.required("bytes_now", baseline.bytesNow, "GPU memory of all assets in this report [bytes]");
    fields.required("growth_percent", baseline.growthPercent, "growth of the GPU memory");
    describe(fields, baseline.allowed);
    fields.required("passed", baseline.passed, "false if a growth is over the allowed one");
    fields.required("assets", baseline.assets, "assets of both reports, by name");
}

/// Compares assets by name.
std::vector<AssetChange> compareAssets(const std::map<std::string, AssetFigures>& before, const std::map<std::string, AssetFigures>& now);
/// Memory and assets of a scene in one report.
struct SceneFigures {
    std::uint64_t bytes = 0;
    std::map<std::string, AssetFigures> assets;
};
SceneFigures figuresOf(const Report& report);
BaselineComparison compareFigures(const SceneFigures& now, const SceneFigures& before, std::string file, const AllowedGrowth& allowed);
/// Sets the difference pictures of the assets whose error grew, as far as there are such files: those of the folders' own previews.
/// folderBefore, folderNow  cooked folders; empty or the same: no picture of before
void addPictures(std::vector<AssetChange>& assets, const std::string& folderBefore, const std::string& folderNow);

/// Compares a report with an older one.
/// file  of the older one, for readers
BaselineComparison compareWithBaseline(const Report& now, const Report& before, std::string file, const AllowedGrowth& allowed);

}  // namespace lightcook::pipeline

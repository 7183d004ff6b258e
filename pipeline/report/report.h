// report.json and report.html: memory against the budget, errors and their bounds against the limits, time.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/graph/action.h"
#include "pipeline/scene/needs.h"

namespace lightcook::pipeline {

inline constexpr const char* kReportName = "report.json";
inline constexpr const char* kReportHtmlName = "report.html";

/// Returns the row of an asset: its manifest entry, the results of its cook and its verification, and the time of each.
Json reportAsset(const Json& manifestAsset, const ActionRecord& cooked, const ActionRecord& verified);

/// Returns the GPU memory of an asset [bytes]: its textures and the data beside them.
std::uint64_t gpuBytesOf(const Json& manifestAsset);

struct ReportFrame {
    std::string scene;
    double seconds = 0;
    std::uint64_t peakRssBytes = 0;
    std::optional<std::uint64_t> budgetBytes;
};
/// Returns report.json (docs/reference/report.md). "passed" is true if every asset passed and the memory is within the budget.
Json makeReport(const ReportFrame& frame, const std::vector<Json>& assets, const std::vector<Skip>& skipped);

bool isWithinBudget(const Json& report);

/// Returns a self-contained page; pictures are read from `folder` and embedded.
std::string renderReportHtml(const Json& report, const std::filesystem::path& folder);

formats::Result<Json> readReport(const std::filesystem::path& file);

/// Returns the peak resident memory of this process [bytes].
std::uint64_t peakResidentBytes();

}  // namespace lightcook::pipeline

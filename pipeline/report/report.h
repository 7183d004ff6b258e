// report.json and report.html: bytes against the budget, error against the bound, time against both.
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

/// One asset's row: its manifest entry, what cooking and verifying it said, and how long each took.
Json reportAsset(const Json& manifestAsset, const ActionRecord& cooked, const ActionRecord& verified);

/// GPU memory of an asset [bytes]: its textures, and what it needs beside them.
std::uint64_t gpuBytesOf(const Json& manifestAsset);

struct ReportFrame {
    std::string scene;
    double seconds = 0;
    std::uint64_t peakRssBytes = 0;
    std::optional<std::uint64_t> budgetBytes;
};
/// Product.md's report. passed: every asset passed, and the bytes are within the budget if there is one.
Json makeReport(const ReportFrame& frame, const std::vector<Json>& assets, const std::vector<Skip>& skipped);

bool isWithinBudget(const Json& report);

/// A page that stands alone: pictures are read from `folder` and put inside.
std::string renderReportHtml(const Json& report, const std::filesystem::path& folder);

formats::Result<Json> readReport(const std::filesystem::path& file);

/// Most memory that this process has had resident [bytes].
std::uint64_t peakResidentBytes();

}  // namespace lightcook::pipeline

#include "pipeline/report/report.h"

#include <sys/resource.h>

#include "pipeline/graph/files.h"
#include "pipeline/graph/version.h"
#include "pipeline/manifest/json_shape.h"
#include "pipeline/report/failures.h"
#include "pipeline/report/whole_error.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Result;

/// Returns the sum over an asset's textures; the entry of a mesh has its own number of bytes.
std::uint64_t sumOf(const Json& asset, const char* key) {
    std::uint64_t sum = asset.value(key, std::uint64_t{0});
    for (const Json& texture : asset.at("textures")) sum += texture.at(key).get<std::uint64_t>();
    return sum;
}

}  // namespace

std::uint64_t gpuBytesOf(const Json& manifestAsset) {
    return sumOf(manifestAsset, "bytes_gpu");
}

Json reportAsset(const Json& manifestAsset, const ActionRecord& cooked, const ActionRecord& verified) {
    const std::uint64_t bytesGpu = gpuBytesOf(manifestAsset);
    const double texels = manifestAsset.at("width").get<double>() * manifestAsset.at("height").get<double>() *
                          (manifestAsset.at("kind") == "cubemap" ? 6 : 1);
    Json row = {{"name", manifestAsset.at("name")},
                {"kind", manifestAsset.at("kind")},
                {"width", manifestAsset.at("width")},
                {"height", manifestAsset.at("height")},
                {"bytes_in", cooked.result.at("bytes_in")},
                {"bytes_gpu", bytesGpu},
                {"bytes_disk", sumOf(manifestAsset, "bytes_disk")},
                {"bits_per_texel", texels > 0 ? 8 * static_cast<double>(bytesGpu) / texels : 0.0},
                {"layout", manifestAsset.at("layout")},
                {"seconds", cooked.seconds},
                {"verify_seconds", verified.seconds}};
    const Json& verdict = verified.result.at("verdict");
    for (const char* key : {"stages", "limit", "passed"}) row[key] = verdict.at(key);
    if (verdict.contains("violations")) row["violations"] = verdict.at("violations");
    row["textures"] = Json::array();
    for (const Json& texture : manifestAsset.at("textures"))
        row["textures"].push_back({{"role", texture.at("role")},
                                   {"file", texture.at("file")},
                                   {"format", texture.at("format")},
                                   {"bytes_gpu", texture.at("bytes_gpu")}});
    for (const char* key : {"notes"})
        if (cooked.result.contains(key)) row[key] = cooked.result.at(key);
    for (const char* key : {"key", "light", "mesh_error", "preview", "measures", "ground_truth"})
        if (verified.result.contains(key)) row[key] = verified.result.at(key);
    if (!row.at("passed").get<bool>()) row["failures"] = failuresOf(row);
    // Lights and meshes are matched to their light map by these.
    const std::string kind = manifestAsset.at("kind").get<std::string>();
    if (row.contains("light") && (kind == "light-map" || kind == "dominant" || kind == "mesh"))
        row["light"]["bake"] = manifestAsset.at("source").at("files").at("source").at("file");
    return row;
}

Json makeReport(const ReportFrame& frame, const std::vector<Json>& assets, const std::vector<Skip>& skipped) {
    bool passed = true;
    std::uint64_t used = 0;
    std::map<std::string, std::uint64_t> byKind, byFormat;
    for (const Json& asset : assets) {
        passed = passed && asset.at("passed").get<bool>();
        used += asset.at("bytes_gpu").get<std::uint64_t>();
        byKind[asset.at("kind").get<std::string>()] += asset.at("bytes_gpu").get<std::uint64_t>();
        for (const Json& texture : asset.at("textures"))
            byFormat[texture.at("format").get<std::string>()] += texture.at("bytes_gpu").get<std::uint64_t>();
        if (asset.at("textures").empty()) byFormat["mesh"] += asset.at("bytes_gpu").get<std::uint64_t>();
    }
    Json report = {{"scene", frame.scene},
                   {"tool", {{"name", kToolName}, {"version", kToolVersion}}},
                   {"passed", passed},
                   {"seconds", frame.seconds},
                   {"peak_rss_bytes", frame.peakRssBytes},
                   {"assets", assets},
                   {"skipped", Json::array()},
                   {"budget", {{"limit_bytes", nullptr}, {"used_bytes", used}, {"by_kind", byKind}, {"by_format", byFormat}}}};
    if (const Json whole = wholeError(assets); !whole.is_null()) report["whole"] = whole;
    if (frame.budgetBytes) report["budget"]["limit_bytes"] = *frame.budgetBytes;
    for (const Skip& skip : skipped) report["skipped"].push_back(skip.toJson());
    if (!isWithinBudget(report)) report["passed"] = false;
    return report;
}

bool isWithinBudget(const Json& report) {
    const Json& budget = report.at("budget");
    return budget.at("limit_bytes").is_null() ||
           budget.at("used_bytes").get<std::uint64_t>() <= budget.at("limit_bytes").get<std::uint64_t>();
}

Result<Json> readReport(const std::filesystem::path& file) {
    const auto text = readFile(file);
    if (!text) return tl::make_unexpected(text.error());
    Json report = parseJson(*text);
    if (report.is_discarded() || !report.is_object() || !report.contains("assets") || !report.contains("budget"))
        return failure(ErrorCode::FileUnreadable, file.string(), "found no report in it, expected what `lightcook cook` writes");
    if (auto shaped = checkReport(report, file.string()); !shaped) return tl::make_unexpected(shaped.error());
    return report;
}

std::uint64_t peakResidentBytes() {
    struct rusage usage {};
    ::getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

}  // namespace lightcook::pipeline

#include "pipeline/report/report.h"

#include <algorithm>

#include "pipeline/assets/light_map/detailed_layout.h"
#include "pipeline/graph/files.h"
#include "pipeline/graph/version.h"
#include "pipeline/report/advice.h"
#include "pipeline/report/exit_codes.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Result;

/// Returns a report as JSON and as a struct.
Result<std::pair<Json, Report>> readBoth(const std::filesystem::path& file) {
    LC_TRY(text, readFile(file));
    Json json = parseJson(*text);
    if (json.is_discarded() || !json.is_object() || !json.contains("assets") || !json.contains("budget"))
        return failure(ErrorCode::FileUnreadable, file, "found no report in it, expected what `lightcook cook` writes");
    LC_TRY(report, fromJson<Report>(json, file));
    return std::pair(std::move(json), std::move(*report));
}

/// Returns the figures of a row that stand in the manifest, and in the results of cook and verification.
ReportRow rowOf(const CookedAsset& asset, CookResult cook, VerifyResult verification) {
    ReportRow row;
    static_cast<VerifyResult&>(row) = std::move(verification);
    row.name = asset.name;
    row.kind = asset.kind;
    row.width = asset.width;
    row.height = asset.height;
    row.bytesIn = cook.bytesIn;
    row.bytesGpu = asset.totalBytesGpu();
    row.bytesDisk = asset.totalBytesDisk();
    const double texels = static_cast<double>(asset.width) * asset.height * (asset.kind == AssetKind::Cubemap ? 6 : 1);
    row.bitsPerTexel = texels > 0 ? 8 * static_cast<double>(row.bytesGpu + asset.vertexBytes.value_or(0)) / texels : 0.0;
    row.layout = asset.layout;
    if (asset.detail) row.choice = DetailedLayout{asset.layout, asset.detail->limit}.name();
    for (const CookedTexture& texture : asset.textures)
        row.textures.push_back({texture.role, texture.file, texture.format, texture.bytesGpu});
    row.notes = std::move(cook.notes);
    row.mipsEnd = asset.mipsEnd;
    return row;
}

/// Adds a further verification to a row, which passes only if that keeps its limits. Does nothing without a record.
/// figures  member of the row
template <class Figures>
Result<void> addVerification(const ActionRecord* record, std::optional<Figures>& figures, ReportRow& row) {
    if (record == nullptr) return {};
    LC_TRY(result, fromJson<Figures>(record->result, row.name));
    figures = std::move(*result);
    row.verifySeconds += record->seconds;
    row.verdict.passed = row.verdict.passed && areKept(figures->checks());
    return {};
}

}  // namespace

DocumentError DocumentError::of(const formats::Error& error) {
    return {pipeline::exitCode(error.code), error.subject, error.detail, error.asset, error.file.string(), error.lineNumber};
}

formats::Error DocumentError::error() const {
    formats::Error error(errorCodeFor(exitCode), subject, detail);
    error.asset = asset;
    error.file = file;
    error.lineNumber = line;
    return error;
}

Result<ReportRow> reportRow(const CookedAsset& asset, const AssetRecords& records) {
    const ActionRecord &cooked = *records.cooked, &verified = *records.verified;
    LC_TRY(cook, fromJson<CookResult>(cooked.result, asset.name));
    LC_TRY(verification, fromJson<VerifyResult>(verified.result, asset.name));
    ReportRow row = rowOf(asset, std::move(*cook), std::move(*verification));
    row.filter = asset.filter;
    row.seconds = cooked.seconds;
    row.verifySeconds = verified.seconds;
    if (!cooked.run.empty()) row.cookedAt = cooked.run;
    if (!verified.run.empty()) row.verifiedAt = verified.run;
    LC_CHECK(addVerification(records.whole, row.whole, row));
    // Lights and meshes are matched to their light map by these.
    const bool hasBake = row.kind == AssetKind::LightMap || row.kind == AssetKind::Dominant || row.kind == AssetKind::Mesh;
    if (row.light && hasBake && asset.source.files)
        if (const auto source = asset.source.files->find("source"); source != asset.source.files->end())
            row.light->bake = source->second.file;
    return row;
}

Report makeReport(const ReportFrame& frame, std::vector<ReportRow> rows, std::vector<Skip> skipped) {
    Report report;
    report.scene = frame.scene;
    report.tool = Tool{kToolName, kToolVersion};
    report.seconds = frame.seconds;
    report.peakRssBytes = frame.peakRssBytes;
    report.runs = frame.runs;
    if (!report.runs.empty()) {
        report.seconds = 0;
        report.peakRssBytes = 0;
    }
    for (const RunRecord& run : report.runs) {
        report.seconds += run.seconds;
        report.peakRssBytes = std::max(report.peakRssBytes, run.peakRssBytes);
    }
    report.budget.limitBytes = frame.budgetBytes;
    report.budget.frontier = asCooked(frame.frontier, rows);
    report.passed = true;
    for (const ReportRow& row : rows) {
        report.passed = report.passed && row.verdict.passed;
        report.budget.usedBytes += row.bytesGpu;
        report.budget.byKind[std::string(info(row.kind).name)] += row.bytesGpu;
        std::uint64_t beside = row.bytesGpu;  // of the textures
        for (const ReportTexture& texture : row.textures) {
            report.budget.byFormat[texture.format] += texture.bytesGpu;
            beside -= std::min(texture.bytesGpu, beside);
        }
        if (beside > 0) report.budget.byFormat[kVertexMemory] += beside;
    }
    report.findings = frame.findings;
    const bool isPlausible = std::ranges::none_of(frame.findings, [](const Finding& finding) { return finding.isFailure(); });
    report.incomplete = frame.incomplete;
    report.partial = frame.partial;
    report.passed = report.passed && report.budget.isKept() && isPlausible && !report.incomplete;
    if (!report.budget.isKept()) report.budget.advice = budgetAdvice(rows, report.budget.usedBytes, !report.budget.frontier.empty());
    report.whole = sceneError(rows);
    report.assets = std::move(rows);
    report.skipped = std::move(skipped);
    return report;
}

std::vector<std::string> picturesOf(const std::vector<ReportRow>& rows) {
    std::vector<std::string> pictures;
    for (const ReportRow& row : rows)
        for (const std::string& file : row.pictures())
            if (std::filesystem::path(file).parent_path() == "preview") pictures.push_back(file);
    return pictures;
}

Result<Report> loadReport(const std::filesystem::path& file) {
    LC_TRY(both, readBoth(file));
    return std::move(both->second);
}

Result<Json> readReport(const std::filesystem::path& file) {
    LC_TRY(both, readBoth(file));
    return std::move(both->first);
}

}  // namespace lightcook::pipeline

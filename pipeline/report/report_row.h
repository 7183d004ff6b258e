// A row of report.json: size, errors, verdict and time of one asset. docs/reference/report.md lists the fields.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/assets/asset_kind.h"
#include "pipeline/assets/cooked_asset.h"
#include "pipeline/assets/light_map/trial.h"
#include "pipeline/assets/results.h"
#include "pipeline/assets/verdict.h"
#include "pipeline/document/json_fields.h"

namespace lightcook::pipeline {

struct ReportTexture {
    std::string role, file, format;
    std::uint64_t bytesGpu = 0;
};
template <class Fields, Is<ReportTexture> Self>
void describe(Fields& fields, Self& texture) {
    fields.required("role", texture.role, "name of the texture in the layout");
    fields.required("file", texture.file, "KTX2 or DDS file");
    fields.required("format", texture.format, "pixel format");
    fields.required("bytes_gpu", texture.bytesGpu, between(0, kLargestBytes), "GPU memory [bytes]");
}

/// Source of the limits of an asset: keys of a scene file, or options of the command that converts one asset.
enum class LimitsFrom { SceneFile, Converter };

/// A reason why an asset did not pass: a stage with figures over the limit or not finite, or a violation.
struct Failure {
    std::string asset;
    AssetKind kind = AssetKind::LightMap;
    std::string stage;
    std::optional<std::string> shading;    ///< of a stage: diffuse or specular
    std::optional<double> relRms, limit;   ///< of a stage
    std::optional<double> visible;         ///< of a stage over its limit on visible errors: the 99th percentile or the proven bound
    std::optional<double> seam;            ///< of a map over its limit on seams: the largest added step
    std::optional<SeamPlace> seamAt;       ///< its place
    std::optional<std::string> place;      ///< of a violation
    ErrorPlaceFields at;                   ///< worst sample: `found` is its light, `reference` that of the source
    std::optional<double> allowed;         ///< largest difference there that is within the limit
    std::string advice;                    ///< what to do; empty: nothing is known
    std::string subject, detail, message;  ///< the error line, in parts and whole
};
template <class Fields, Is<Failure> Self>
void describe(Fields& fields, Self& failure) {
    fields.required("asset", failure.asset, "name of the asset");
    fields.required("kind", failure.kind, "kind of asset");
    fields.required("stage", failure.stage, "stage that failed");
    fields.optional("shading", failure.shading, "diffuse or specular");
    fields.optional("rel_rms", failure.relRms, kNumberOrNull, "rel_rms of the stage");
    fields.optional("visible", failure.visible, kNumberOrNull, "99th percentile of the stage's visible errors, or their proven bound");
    fields.optional("seam", failure.seam, kNumberOrNull, "largest step that cooking adds to an edge");
    fields.optional("seam_at", failure.seamAt, "place of that step");
    fields.optional("limit", failure.limit, kNumberOrNull, "limit on rel_rms or, with `visible` or `seam`, on that");
    fields.optional("place", failure.place, "place of a violation");
    describe(fields, failure.at);
    fields.optional("allowed", failure.allowed, kNumberOrNull, "largest difference of light there that is within the limit");
    fields.required("subject", failure.subject, "asset and place");
    fields.required("detail", failure.detail, "what was found and what was expected");
    fields.presentIf(!failure.advice.empty(), "advice", failure.advice,
                     "what to do: the cause if it is known, the key that lowers the error with its cost, the limit that allows it");
    fields.required("message", failure.message, "the whole line, with the advice");
}

/// A layout that the scene's list lacks, and the gain if the list had it.
struct ExcludedLayout {
    std::string layout;
    std::int64_t bytesSaved = 0;          ///< negative if it takes more
    double relRms = 0, relRmsThen = 0;    ///< of the chosen layout, and of this one: the larger of diffuse and specular
    double visible = 0, visibleThen = 0;  ///< 99th percentiles, likewise
};
template <class Fields, Is<ExcludedLayout> Self>
void describe(Fields& fields, Self& excluded) {
    fields.required("layout", excluded.layout, "layout");
    fields.required("bytes_saved", excluded.bytesSaved, "GPU memory that it saves; negative if it takes more [bytes]");
    fields.required("rel_rms", excluded.relRms, kFigure, "rel_rms of the chosen layout in its trial");
    fields.required("rel_rms_then", excluded.relRmsThen, kFigure, "rel_rms of this layout");
    fields.required("visible", excluded.visible, kFigure, "99th percentile of visible errors of the chosen layout in its trial");
    fields.required("visible_then", excluded.visibleThen, kFigure, "99th percentile of visible errors of this layout");
}

struct ReportRow : VerifyResult {
    std::string name;
    AssetKind kind = AssetKind::LightMap;
    int width = 0, height = 0;
    std::uint64_t bytesIn = 0, bytesGpu = 0, bytesDisk = 0;
    double bitsPerTexel = 0;
    std::string layout;
    std::optional<std::string> choice;              ///< of a light map with detail: DetailedLayout::name
    std::optional<formats::LightMapFilter> filter;  ///< of a light map
    double seconds = 0, verifySeconds = 0;
    std::vector<ReportTexture> textures;
    std::optional<std::string> mipsEnd;  ///< CookedAsset::mipsEnd
    std::optional<Json> notes;           ///< see CookResult
    std::optional<WholeFigures> whole;
    std::vector<Failure> failures;  ///< of an asset that did not pass
    std::optional<std::vector<TrialCandidate>> trialCandidates;
    std::optional<double> trialShare;
    std::optional<ExcludedLayout> betterExcluded;     ///< see bestExcluded()
    std::optional<std::string> cookedAt, verifiedAt;  ///< RunRecord::at

    /// Returns the layout as a trial names it.
    const std::string& triedLayout() const { return choice ? *choice : layout; }
    /// Returns the files of all pictures.
    std::vector<std::string> pictures() const { return preview ? preview->all() : std::vector<std::string>(); }
};
template <class Fields, Is<ReportRow> Self>
void describe(Fields& fields, Self& row) {
    constexpr FieldRule kSide = between(0, kLargestSide), kBytes = between(0, kLargestBytes), kNotNegative = between(0, HUGE_VAL);
    fields.required("name", row.name, "name of the asset");
    fields.required("kind", row.kind, "kind of asset");
    fields.required("width", row.width, kSide, "width [texels]");
    fields.required("height", row.height, kSide, "height [texels]");
    fields.required("bytes_in", row.bytesIn, kBytes, "size of the source [bytes]");
    fields.required("bytes_gpu", row.bytesGpu, kBytes, "GPU memory [bytes]");
    fields.required("bytes_disk", row.bytesDisk, kBytes, "size of the files [bytes]");
    fields.required("bits_per_texel", row.bitsPerTexel, kNotNegative,
                    "GPU memory of a texel, with tables, and with the index or vertex attribute that names bases [bits]");
    fields.required("layout", row.layout, "layout of the textures");
    fields.optional("choice", row.choice, "of a light map with detail: `basis-4+lit@5`, the layout, that of the detail, and the limit");
    fields.optional("filter", row.filter, "of a light map: `hardware` or `decoded`, as in cooked.json");
    fields.required("seconds", row.seconds, kNotNegative, "wall time of the cook");
    fields.presentIf(true, "verify_seconds", row.verifySeconds, "wall time of the verification");
    fields.presentIf(true, "textures", row.textures, "textures of the layout");
    fields.optional("mips_end", row.mipsEnd, "why a light map with `mips = true` has no further mip level");
    fields.optional("notes", row.notes, "counts and facts of the cook");
    std::conditional_t<std::is_const_v<Self>, const VerifyResult, VerifyResult>& verified = row;
    describe(fields, verified);
    fields.optional("whole", row.whole,
                    "of a light map that a budget or a limit on the whole chose: what a pixel shows of it and its dominant light together");
    fields.presentIf(!row.verdict.passed, "failures", row.failures, "reasons of an asset that did not pass");
    fields.optional("trial_candidates", row.trialCandidates, "layouts that were tried, the smallest first");
    fields.optional("trial_share", row.trialShare, kFigure, "part of the map that was tried");
    fields.optional("better_excluded", row.betterExcluded, "layout that the scene's `layouts` lacks and the map would be better off with");
    fields.optional("cooked_at", row.cookedAt, "run that cooked it, whose time is `seconds`; see `runs`");
    fields.optional("verified_at", row.verifiedAt, "run that verified it, whose time is `verify_seconds`");
}

}  // namespace lightcook::pipeline

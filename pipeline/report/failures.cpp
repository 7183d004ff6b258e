#include "pipeline/report/failures.h"

#include <fmt/format.h>

#include <cmath>
#include <string_view>

#include "pipeline/assets/verdict.h"

namespace lightcook::pipeline {
namespace {

/// Keys of a scene file, or options of a command, that set the limits of an asset.
struct LimitNames {
    const char *error = "max_error", *visible = "max_visible", *visibleBound = "max_visible_bound", *seam = "max_seam";
};

LimitNames limitNamesOf(AssetKind kind, LimitsFrom limitsFrom) {
    if (limitsFrom == LimitsFrom::Converter) return {"--max-error", "--max-visible", "--max-visible-bound", "--max-seam"};
    switch (kind) {
        case AssetKind::LightMap:
        case AssetKind::Mesh:
            break;
        case AssetKind::Dominant:
            return {.error = "max_converter_error", .visible = "max_converter_visible", .visibleBound = "max_converter_visible_bound"};
        case AssetKind::Cubemap:
        case AssetKind::Lut:
        case AssetKind::Rsrm:
            return {.error = "max_converter_error",
                    .visible = "max_visible of the asset, or max_converter_visible",
                    .visibleBound = "max_visible_bound of the asset, or max_converter_visible_bound"};
    }
    return {};
}

/// Returns "1.2, expected at most 1 (max_error)" of a figure over its limit, with as many digits as it takes to tell them apart.
/// between  after the figure
std::string overLimit(double found, double limit, int digits, const char* name, std::string_view between = "") {
    constexpr int kAllDigits = 17;
    const auto words = [&](double value) { return fmt::format("{:.{}g}", value, digits); };
    while (words(found) == words(limit) && digits < kAllDigits) ++digits;
    return fmt::format("{}{}, expected at most {} ({})", words(found), between, words(limit), name);
}

double finiteOrNan(double value) {
    return std::isfinite(value) ? value : std::nan("");
}

/// Returns ": found 1.2, expected 0.9, off by 0.3, allowed 0.02".
std::string lightWords(const ErrorPlaceFields& at, double allowed) {
    const double found = at.found.value_or(std::nan("")), reference = at.reference.value_or(std::nan(""));
    if (!std::isfinite(found) || !std::isfinite(reference)) return "";
    const std::string words = fmt::format(": found {:.4g}, expected {:.4g}, off by {:.4g}", found, reference, std::abs(found - reference));
    return std::isfinite(allowed) ? words + fmt::format(", allowed {:.4g}", allowed) : words;
}

/// Returns the difference of light at a place that is a local relative error of `limit`; NaN if the place has no figures.
double allowedAt(const ErrorPlaceFields& at, double limit) {
    const double local = at.local.value_or(std::nan(""));
    const double off = std::abs(at.found.value_or(std::nan("")) - at.reference.value_or(std::nan("")));
    return local > 0 && std::isfinite(local) ? limit * off / local : std::nan("");
}

/// Adds the texts of a failure, and its place.
/// subject  without the asset's name
void complete(Failure& failure, const ReportRow& row, const std::string& subject, const verify::ErrorPlace& at) {
    failure.asset = row.name;
    failure.kind = row.kind;
    if (at.isKnown()) {
        failure.at = FieldMirror<verify::ErrorPlace>::of(at);
        const double allowed = allowedAt(failure.at, row.verdict.limit);
        if (std::isfinite(allowed)) failure.allowed = allowed;
        failure.at.local.reset();
        failure.detail += "; worst at " + placeWords(toJson(failure.at)) + lightWords(failure.at, allowed);
    }
    failure.subject = row.name + ", " + subject;
    failure.message = failure.subject + ": " + failure.detail;
}

/// Appends a failure if one kind of shading of a stage is over the limit or has figures that are not finite.
void addStage(const ReportRow& row, const verify::StageError& stage, const std::string& shading, const verify::ErrorFigures& figures,
              const LimitNames& names, std::vector<Failure>& failures) {
    const double limit = row.verdict.limit, relRms = finiteOrNan(figures.relRms);
    const bool isLast = &stage == &row.verdict.stages.back();
    const bool areFinite = isFinite(figures);
    if (areFinite && !(isLast && relRms > limit)) return;
    Failure failure;
    failure.stage = stage.name;
    failure.shading = shading;
    failure.relRms = relRms;
    failure.limit = limit;
    failure.detail =
        fmt::format("found rel_rms {}{}", overLimit(relRms, limit, 4, names.error), areFinite ? "" : " and every figure finite");
    complete(failure, row, fmt::format("{}, {}", stageWords(stage.name), shading), figures.sampledAt);
    failures.push_back(std::move(failure));
}

/// A figure of visible errors that has a limit, and the place to name if it is over.
struct VisibleFigure {
    std::optional<double> limit, value;
    const char* upTo;  ///< before the value
    const char* name;  ///< of the figure
    const char* limitName;
    const char* place;  ///< before the place
    const verify::VisiblePlace& at;
    std::optional<double> difference;  ///< at the place, if it was sampled
};

/// Appends a failure if a figure of visible errors of one kind of shading of the last stage is over its limit.
void addVisible(const ReportRow& row, const std::string& shading, const VisibleFigure& figure, std::vector<Failure>& failures) {
    if (!figure.limit || !figure.value || *figure.value <= *figure.limit) return;
    Failure failure;
    failure.stage = row.verdict.stages.back().name;
    failure.shading = shading;
    failure.visible = finiteOrNan(*figure.value);
    failure.limit = *figure.limit;
    failure.detail = fmt::format("found a visible error of {}{}", figure.upTo,
                                 overLimit(*failure.visible, *figure.limit, 3, figure.limitName, fmt::format(" ({})", figure.name)));
    if (figure.at.isKnown()) {
        const Json place = toJson(FieldMirror<verify::VisiblePlace>::of(figure.at));
        failure.detail += fmt::format("; {} at {}: found {}, expected {}", figure.place, placeWords(place), vectorWords(place["found"]),
                                      vectorWords(place["reference"]));
        if (figure.difference) failure.detail += fmt::format(", a difference of {:.3g}", *figure.difference);
    }
    complete(failure, row, fmt::format("{}, {}", stageWords(failure.stage), shading), {});
    failures.push_back(std::move(failure));
}

/// Appends a failure for each limit on visible errors that one kind of shading of the last stage is over.
void addVisible(const ReportRow& row, const std::string& shading, const verify::ErrorFigures& figures, const LimitNames& names,
                std::vector<Failure>& failures) {
    if (!figures.visible) return;
    const verify::VisibleFigures& visible = *figures.visible;
    addVisible(row, shading, {row.verdict.maxVisible, visible.p99, "", "p99", names.visible, "worst", visible.maxAt, visible.max},
               failures);
    addVisible(row, shading,
               {row.verdict.maxVisibleBound, visible.bound, "up to ", "proven bound", names.visibleBound, "largest", visible.boundAt, {}},
               failures);
}

/// Appends a failure for each limit that a light map and its dominant light together exceed.
void addWhole(const ReportRow& row, std::vector<Failure>& failures) {
    if (!row.whole) return;
    const auto add = [&](Failure failure) {
        failure.stage = "whole";
        complete(failure, row, "together with its dominant light", {});
        failures.push_back(std::move(failure));
    };
    if (!row.whole->isVisibleKept()) {
        Failure failure;
        failure.visible = finiteOrNan(row.whole->visible.p99);
        failure.limit = *row.whole->maxVisible;
        failure.detail = "found a visible error of " + overLimit(*failure.visible, *failure.limit, 3, "max_whole_visible", " (p99)");
        add(std::move(failure));
    }
    if (!row.whole->isErrorKept()) {
        Failure failure;
        failure.relRms = finiteOrNan(row.whole->relRms);
        failure.limit = *row.whole->maxError;
        failure.detail = "found rel_rms " + overLimit(*failure.relRms, *failure.limit, 4, "max_whole_error");
        add(std::move(failure));
    }
}

/// Appends a failure if the largest step that cooking adds to an edge is over its limit.
/// subject  without the asset's name
void addSeam(const ReportRow& row, const SeamFigures& seams, const std::optional<double>& maxSeam, const char* limitName,
             std::string subject, std::vector<Failure>& failures) {
    if (!maxSeam || seams.largestAdded() <= *maxSeam) return;
    Failure failure;
    failure.stage = seams.stages.back().name;
    failure.seam = finiteOrNan(seams.largestAdded());
    failure.limit = *maxSeam;
    failure.detail = "found a seam of " + overLimit(*failure.seam, *failure.limit, 3, limitName);
    if (!seams.worst.empty()) {
        const SeamPlace& worst = seams.worst.front();
        failure.shading = worst.shading;
        failure.seamAt = worst;
        subject += ", " + worst.shading;
        failure.detail += "; worst at " + seamWords(worst);
    }
    complete(failure, row, subject, {});
    failures.push_back(std::move(failure));
}

}  // namespace

std::string vectorWords(const Json& v) {
    if (!v.is_array()) return "";
    std::string words;
    for (const Json& each : v)
        words += fmt::format("{}{:.4g}", words.empty() ? "" : ", ", each.is_number() ? each.get<double>() : std::nan(""));
    return "(" + words + ")";
}

std::string seamWords(const SeamPlace& seam) {
    const Json place = toJson(seam);
    const auto sides = [&](const char* key) { return vectorWords(place[key][0]) + " and " + vectorWords(place[key][1]); };
    std::string words = fmt::format("the edge from {} to {}, {}: a step of {:.3g} where the bake has {:.3g}", vectorWords(place["edge"][0]),
                                    vectorWords(place["edge"][1]), placeWords(place), seam.cookedStep, seam.bakeStep);
    const std::string maps = seam.maps ? fmt::format(" of '{}' and '{}'", (*seam.maps)[0], (*seam.maps)[1]) : "";
    return words + fmt::format("; at texels {}{}: found {}, expected {}", sides("texels"), maps, sides("found"), sides("reference"));
}

std::string placeWords(const Json& at) {
    std::string words;
    if (!at.is_object()) return words;
    const auto add = [&](const std::string& more) { words += (words.empty() ? "" : ", ") + more; };
    for (const char* key : {"mip", "face", "primitive", "triangle", "position", "texel", "channel", "normal", "view", "m", "f0"}) {
        const auto found = at.find(key);
        if (found == at.end()) continue;
        const std::string name = std::string(key) == "f0" ? "F0" : key;
        if (found->is_array()) add(name + " " + vectorWords(*found));
        if (found->is_number()) add(fmt::format("{} {:.4g}", name, found->get<double>()));
        if (found->is_string()) add((name == "channel" ? "" : name + " ") + found->get<std::string>());
    }
    return words;
}

std::vector<Failure> failuresOf(const ReportRow& row, LimitsFrom limitsFrom) {
    const LimitNames names = limitNamesOf(row.kind, limitsFrom);
    std::vector<Failure> failures;
    for (const verify::Violation& each : row.verdict.violations) {
        Failure failure;
        failure.stage = row.verdict.stages.back().name;
        failure.place = each.place;
        failure.detail = fmt::format("found {}, expected {}", each.found, each.expected);
        complete(failure, row, each.place, each.at);
        failures.push_back(std::move(failure));
    }
    for (const verify::StageError& stage : row.verdict.stages) {
        addStage(row, stage, "diffuse", stage.diffuse, names, failures);
        addStage(row, stage, "specular", stage.specular, names, failures);
    }
    addVisible(row, "diffuse", row.verdict.stages.back().diffuse, names, failures);
    addVisible(row, "specular", row.verdict.stages.back().specular, names, failures);
    if (row.seams) addSeam(row, *row.seams, row.verdict.maxSeam, names.seam, "seams", failures);
    if (row.splitSeams) addSeam(row, row.splitSeams->seams, row.splitSeams->maxSeam, names.seam, "seams between its maps", failures);
    addWhole(row, failures);
    return failures;
}

std::vector<formats::Error> errorsOf(const std::vector<Failure>& failures) {
    std::vector<formats::Error> errors;
    for (const Failure& each : failures) errors.push_back({formats::ErrorCode::Verification, each.subject, each.detail});
    return errors;
}

}  // namespace lightcook::pipeline

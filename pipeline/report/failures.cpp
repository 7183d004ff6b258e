#include "pipeline/report/failures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "pipeline/assets/verdict.h"
#include "pipeline/report/advice.h"

namespace lightcook::pipeline {
namespace {

/// Returns the key of a scene file, or the option of a command, that sets a limit of an asset.
std::string limitName(Limit limit, AssetKind kind, LimitsFrom limitsFrom) {
    std::string name(info(limit).name);
    if (limitsFrom == LimitsFrom::Converter) return optionOf(info(limit));
    if (kind == AssetKind::LightMap || kind == AssetKind::Mesh) return name;
    const std::string ofConverters(converterLimit(limit).name);
    const bool mayBeOfAsset = limit != Limit::Error && kind != AssetKind::Dominant;
    return mayBeOfAsset ? fmt::format("{} of the asset, or {}", name, ofConverters) : ofConverters;
}

/// Returns "rel_rms 1.2, expected at most 1 (max_error)" of a figure over its limit, with as many digits as it takes to tell them apart.
std::string overLimit(const Check& check, const std::string& name) {
    constexpr int kAllDigits = 17;
    const LimitInfo& limit = info(check.figure.limit);
    int digits = limit.digits;
    const auto words = [&](double value) { return fmt::format("{:.{}g}", value, digits); };
    while (words(check.figure.value) == words(check.allowed) && digits < kAllDigits) ++digits;
    return fmt::format("{}, expected at most {} ({})", fmt::format(fmt::runtime(limit.words), words(check.figure.value)),
                       words(check.allowed), name);
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

/// Returns the advice as it follows the detail.
std::string adviceAfter(const Failure& failure) {
    return failure.advice.empty() ? "" : ". " + failure.advice;
}

/// Adds the texts of a failure, and its place.
/// subject  without the asset's name
void complete(Failure& failure, const ReportRow& row, const std::string& subject, const verify::ErrorPlace& at) {
    failure.asset = row.name;
    failure.kind = row.kind;
    if (at.isKnown()) {
        failure.at = FieldMirror<verify::ErrorPlace>::of(at);
        const double allowed = allowedAt(failure.at, row.verdict.limits[Limit::Error].value_or(std::nan("")));
        if (std::isfinite(allowed)) failure.allowed = allowed;
        failure.at.local.reset();
        failure.detail += "; worst at " + placeWords(toJson(failure.at)) + lightWords(failure.at, allowed);
    }
    failure.subject = row.name + ", " + subject;
    failure.message = failure.subject + ": " + failure.detail + adviceAfter(failure);
}

/// A stage, or a mip level of a light map or a mix of two, and whether it is one of these.
struct Level {
    const verify::StageError* stage = nullptr;
    bool isMip = false;

    [[nodiscard]] std::string words() const { return isMip ? stage->name : stageWords(stage->name); }
    [[nodiscard]] const verify::ErrorFigures& figures(const std::string& shading) const {
        return shading == "diffuse" ? stage->diffuse : stage->specular;
    }
};

/// Returns the stages of an asset, its mip levels and their mixes.
std::vector<Level> levelsOf(const ReportRow& row) {
    std::vector<Level> levels;
    for (const verify::StageError& stage : row.verdict.stages) levels.push_back({&stage, false});
    for (const auto* mips : {&row.mips, &row.mipBlends})
        for (const verify::StageError& mip : *mips) levels.push_back({&mip, true});
    return levels;
}

/// Returns the member of a failure that holds the figure of a limit.
std::optional<double>& valueOf(Failure& failure, Limit limit) {
    if (limit == Limit::Seam) return failure.seam;
    return info(limit).isFraction ? failure.relRms : failure.visible;
}

/// The names in the texts of an asset's failures come from these and from its row.
struct Names {
    LimitsFrom limitsFrom;
    const ReportRow* lightMap;
};

/// Returns a failure of a figure over its limit, with "found ..., expected ..." and no place.
Failure failureOf(const ReportRow& row, const Check& check, const Names& names) {
    Failure failure;
    failure.stage = check.figure.stage;
    if (!check.figure.shading.empty()) failure.shading = check.figure.shading;
    failure.limit = check.allowed;
    valueOf(failure, check.figure.limit) = finiteOrNan(check.figure.value);
    failure.detail = "found " + overLimit(check, limitName(check.figure.limit, row.kind, names.limitsFrom));
    failure.advice = adviceOn(row, check, names.lightMap);
    return failure;
}

/// Returns the place of the worst visible error, or of the bound, as text.
std::string visibleWords(Limit limit, const verify::VisibleFigures& figures) {
    const bool isBound = limit == Limit::VisibleBound;
    const verify::VisiblePlace& at = isBound ? figures.boundAt : figures.maxAt;
    if (!at.isKnown()) return "";
    const Json place = toJson(FieldMirror<verify::VisiblePlace>::of(at));
    std::string words = fmt::format("; {} at {}: found {}, expected {}", isBound ? "largest" : "worst", placeWords(place),
                                    vectorWords(place["found"]), vectorWords(place["reference"]));
    return isBound ? words : words + fmt::format(", a difference of {:.3g}", figures.max);
}

/// Appends a failure of a figure of a stage or mip level that is over its limit.
void addOver(const ReportRow& row, const Level& level, const Check& check, const Names& names, std::vector<Failure>& failures) {
    const verify::ErrorFigures& figures = level.figures(check.figure.shading);
    Failure failure = failureOf(row, check, names);
    if (check.figure.limit != Limit::Error) failure.detail += visibleWords(check.figure.limit, *figures.visible);
    if (level.isMip) {
        failure.detail += ", as at level 0";
        failure.advice += " A lower limit chooses a layout with less error there; mips = false cooks level 0 alone.";
    }
    complete(failure, row, fmt::format("{}, {}", level.words(), check.figure.shading),
             check.figure.limit == Limit::Error ? figures.sampledAt : verify::ErrorPlace());
    failures.push_back(std::move(failure));
}

/// Appends a failure of each kind of shading of a level with figures that are not finite.
void addNotFinite(const ReportRow& row, const Level& level, std::vector<Failure>& failures) {
    for (const char* shading : {"diffuse", "specular"}) {
        const verify::ErrorFigures& figures = level.figures(shading);
        if (isFinite(figures)) continue;
        Failure failure;
        failure.stage = level.stage->name;
        failure.shading = shading;
        failure.relRms = finiteOrNan(figures.relRms);
        failure.limit = row.verdict.limits[Limit::Error];
        failure.detail = fmt::format("found rel_rms {:.4g}, expected every figure finite", *failure.relRms);
        complete(failure, row, fmt::format("{}, {}", level.words(), shading), figures.sampledAt);
        failures.push_back(std::move(failure));
    }
}

/// Appends a failure of each limit on seams that is exceeded.
/// checks  of all limits
void addSeam(const ReportRow& row, const SeamFigures& seams, const std::vector<Check>& checks, const Names& names,
             std::vector<Failure>& failures) {
    for (const Check& check : checks) {
        if (check.figure.limit != Limit::Seam || check.isKept()) continue;
        Failure failure = failureOf(row, check, names);
        if (!seams.worst.empty()) {
            failure.seamAt = seams.worst.front();
            failure.detail += "; worst at " + seamWords(seams.worst.front());
        }
        complete(failure, row, check.figure.shading.empty() ? "seams" : "seams, " + check.figure.shading, {});
        failures.push_back(std::move(failure));
    }
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
    return words + fmt::format("; at texels {}: found {}, expected {}", sides("texels"), sides("found"), sides("reference"));
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

std::vector<Failure> failuresOf(const ReportRow& row, LimitsFrom limitsFrom, const ReportRow* lightMap,
                                const std::vector<FrontierPoint>& frontier) {
    const Names names{limitsFrom, lightMap};
    std::vector<Failure> failures;
    for (const verify::Violation& each : row.verdict.violations) {
        Failure failure;
        failure.stage = row.verdict.stages.back().name;
        failure.place = each.place;
        failure.detail = fmt::format("found {}, expected {}", each.found, each.expected);
        complete(failure, row, each.place, each.at);
        failures.push_back(std::move(failure));
    }
    const std::vector<Level> levels = levelsOf(row);
    for (const Level& level : levels) addNotFinite(row, level, failures);
    const std::vector<Check> checks = row.checks(row.verdict.limits);
    for (const Check& check : checks) {
        const auto level = std::ranges::find_if(levels, [&](const Level& each) { return each.stage->name == check.figure.stage; });
        if (check.figure.limit == Limit::Seam || check.isKept() || level == levels.end()) continue;
        // A level that is not finite has its failure. A bound alone may be infinite too.
        if (isFinite(level->figures(check.figure.shading))) addOver(row, *level, check, names, failures);
    }
    if (row.seams) addSeam(row, *row.seams, checks, names, failures);
    for (const Check& check : row.whole ? row.whole->checks() : std::vector<Check>()) {
        if (check.isKept()) continue;
        Failure failure = failureOf(row, check, names);
        if (check.figure.limit == Limit::WholeVisible) failure.advice = budgetRemedy(frontier, check.allowed) + failure.advice;
        complete(failure, row, "together with its dominant light", {});
        failures.push_back(std::move(failure));
    }
    return failures;
}

void addFailures(std::vector<ReportRow>& rows, LimitsFrom limitsFrom, const std::vector<FrontierPoint>& frontier) {
    const std::vector<const ReportRow*> lightMaps = lightMapsOf(rows);
    for (ReportRow& row : rows)
        if (!row.verdict.passed && row.failures.empty()) row.failures = failuresOf(row, limitsFrom, lightMapOf(row, lightMaps), frontier);
}

std::vector<formats::Error> errorsOf(const std::vector<Failure>& failures) {
    std::vector<formats::Error> errors;
    for (const Failure& each : failures)
        errors.emplace_back(formats::ErrorCode::OverLimit, each.subject, each.detail + adviceAfter(each)).asset = each.asset;
    return errors;
}

}  // namespace lightcook::pipeline

#include "pipeline/report/advice.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <iterator>

#include "formats/light_map_layout.h"
#include "pipeline/assets/light_map/detailed_layout.h"
#include "pipeline/assets/note_keys.h"
#include "pipeline/report/words.h"
#include "pipeline/scene/dominant_layout.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {
namespace {

using Candidates = std::vector<TrialCandidate>;

/// Returns true for a limit whose figures are known of the layouts that were tried or, of seams, verified for the choice.
bool isTried(Limit limit) {
    return limit == Limit::Error || limit == Limit::Visible || limit == Limit::Seam;
}

/// Returns the figure of a layout that such a limit holds; NaN: it was not measured.
double triedFigure(const TrialCandidate& candidate, Limit limit) {
    if (limit == Limit::Error) return std::max(candidate.diffuse, candidate.specular);
    if (limit == Limit::Visible) return std::max(candidate.visibleDiffuse, candidate.visibleSpecular);
    return candidate.seam.value_or(std::nan(""));
}

/// Returns "visible error 4.32 when it was tried".
std::string figureWords(Limit limit, double value) {
    if (limit == Limit::Seam) return fmt::format("a seam of {:.3g} when it was verified", value);
    return (limit == Limit::Error ? "rel_rms " + humanPercent(value) : fmt::format("visible error {:.3g}", value)) + " when it was tried";
}

/// Returns "12.00 KiB more than now".
std::string costWords(std::uint64_t bytes, std::uint64_t bytesNow) {
    return bytes == bytesNow ? "the same memory"
                             : fmt::format("{} {}", sizeWords(bytes > bytesNow ? bytes - bytesNow : bytesNow - bytes),
                                           bytes > bytesNow ? "more" : "less");
}

/// Returns true for a layout that an engine decodes with its own shader, which reads no other, and for a name of none.
bool isFixed(const std::string& name) {
    const auto layout = formats::lightMapLayoutFromName(name);
    return !layout || formats::info(*layout).isForEngine;
}

/// Returns the remedy where the scene allows the row's layout alone.
std::string remedyOfNamed(const ReportRow& row) {
    return isFixed(row.layout) ? "" : "No other layout is allowed: light_map_layout = \"auto\" takes the smallest that keeps the limit.";
}

/// Returns true if a scene allows one layout alone, which was tried for the choice of its dominant light.
bool isAlone(const Candidates& candidates) {
    return std::ranges::count(candidates, false, &TrialCandidate::isExcluded) == 1;
}

/// Returns true if a layout of another figure gains more than it costs: bytes times visible error are below those of the chosen one, as for
/// the opportunities of the page. Visible errors below 1 count as 1, since nobody sees them.
bool isWorthItsBytes(const TrialCandidate& each, double figure, const TrialCandidate& chosen, double chosenFigure) {
    const auto cost = [](const TrialCandidate& candidate, double visible) {
        return static_cast<double>(candidate.bytesGpu) * std::max(visible, 1.0);
    };
    return cost(each, figure) < cost(chosen, chosenFigure);
}

/// Returns the layout that a trial of the map found to help, or that none does.
std::string triedRemedy(const ReportRow& row, const Candidates& candidates, const std::optional<Check>& over) {
    const Limit limit = over ? over->figure.limit : Limit::Visible;
    const auto chosen = std::ranges::find(candidates, row.triedLayout(), &TrialCandidate::layout);
    if (chosen == candidates.end()) return "";
    const auto figureOf = [&](const TrialCandidate& each) { return triedFigure(each, limit); };
    const double least = figureOf(*chosen);
    if (std::isnan(least)) return isAlone(candidates) ? remedyOfNamed(row) : "";
    const TrialCandidate *smallest = nullptr, *excluded = nullptr, *best = nullptr;
    for (const TrialCandidate& each : candidates) {  // the smallest first
        const double figure = figureOf(each);
        if (!(figure < least)) continue;
        const bool helps = over ? figure <= over->allowed : isWorthItsBytes(each, figure, *chosen, least);
        const TrialCandidate*& first = each.isExcluded ? excluded : smallest;
        if (helps && first == nullptr) first = &each;
        if (!each.isExcluded && (best == nullptr || figure < figureOf(*best))) best = &each;
    }
    const auto words = [&](const TrialCandidate& each) {
        return fmt::format("({}, {})", figureWords(limit, figureOf(each)), costWords(each.bytesGpu, chosen->bytesGpu));
    };
    const char* const does = over ? "keeps the limit" : "has less";
    if (smallest != nullptr) {
        const DetailedLayout named = DetailedLayout::ofName(smallest->layout);
        return fmt::format("light_map_layout = \"{}\"{} {} {}.", named.layout, named.limit ? " with detail = true" : "", does,
                           words(*smallest));
    }
    const auto name = [](const TrialCandidate& each) { return DetailedLayout::ofName(each.layout).words(); };
    if (excluded != nullptr) return fmt::format("{}, which layouts leaves out, {} {}.", name(*excluded), does, words(*excluded));
    if (!over) return "";
    if (best != nullptr) return fmt::format("No layout keeps the limit: the least is that of {} {}.", name(*best), words(*best));
    if (least <= over->allowed)
        return fmt::format("{} kept the limit ({}): a lower limit takes a larger layout.", name(*chosen), figureWords(limit, least));
    return isAlone(candidates)    ? remedyOfNamed(row)
           : limit == Limit::Seam ? "No layout that was verified has less."
                                  : "No layout has less.";
}

std::string lightMapRemedy(const ReportRow& row, const std::optional<Check>& over) {
    if (!over && row.whole) return "";  // chosen with its dominant light: the next scenes of that choice stand elsewhere
    if (row.trialCandidates) {
        if (!over || isTried(over->figure.limit)) return triedRemedy(row, *row.trialCandidates, over);
        const bool isOfWhole = over->figure.limit == Limit::WholeVisible || over->figure.limit == Limit::WholeError;
        return isOfWhole && isAlone(*row.trialCandidates) ? remedyOfNamed(row) : "";
    }
    if (isFixed(row.layout)) return "";
    if (over && over->figure.limit == Limit::Seam)
        return "light_map_layout = \"auto\" takes the smallest layout that keeps the limit, or that of the smallest seam.";
    return over ? "light_map_layout = \"auto\" takes the smallest layout that keeps the limit."
                : "light_map_layout = \"auto\" with max_visible measures what the other layouts give.";
}

/// Returns which side of the worst edge makes the step, and how much its light errs; of a filter that reads past charts, the other filter.
std::string seamCause(const ReportRow& row) {
    if (!row.seams || row.seams->worst.empty() || !(row.key.value_or(0) > 0)) return "";
    const SeamPlace& at = row.seams->worst.front();
    const auto offAt = [&](std::size_t side) {
        const glm::dvec3 off = glm::abs(at.found[side] - at.reference[side]);
        return std::max({off.x, off.y, off.z});
    };
    const std::size_t side = offAt(1) > offAt(0) ? 1 : 0;
    const glm::dvec3& light = at.reference[side];
    std::string words = fmt::format("The worst step is made at texel ({:.1f}, {:.1f}), whose light is off by {:.3g}, {} of the map's key",
                                    at.texels[side][0], at.texels[side][1], offAt(side), humanPercent(offAt(side) / *row.key));
    constexpr double kDark = 0.25;
    words += std::max({light.x, light.y, light.z}) < kDark * *row.key ? "; it is dark there, where little light shows." : ".";
    const auto layout = formats::lightMapLayoutFromName(row.layout);
    if (row.filter == formats::LightMapFilter::Hardware && layout && formats::info(*layout).mayHave(formats::LightMapFilter::Decoded))
        words += fmt::format(
            " The sampler reads texels beside charts: filter = \"decoded\" leaves them out ({} more, and four decodes a pixel).",
            sizeWords(static_cast<std::uint64_t>(row.width) * static_cast<std::uint64_t>(row.height) / 8));
    return words;
}

/// Returns the layout that stores the texels of the bake as half floats, with what it costs: the way out where no block format keeps a seam
/// small enough.
std::string unquantizedRemedy(const ReportRow& row) {
    const formats::LightMapLayoutInfo& raw = formats::info(formats::LightMapLayout::Raw);
    if (isFixed(row.layout) || formats::info(*formats::lightMapLayoutFromName(row.layout)).isFlat()) return "";
    const auto texels = static_cast<std::uint64_t>(row.width) * static_cast<std::uint64_t>(row.height);
    const std::uint64_t bytes = texels * static_cast<std::uint64_t>(formats::textureBits(raw, formats::info(formats::Target::Bc)) + 1) / 8;
    if (bytes <= row.bytesGpu) return "";
    return fmt::format("light_map_layout = \"{}\" with filter = \"decoded\" has the half floats of the bake, and next to no step ({}).",
                       raw.name, costWords(bytes, row.bytesGpu));
}

/// Returns true if filtering between the texels of a dominant light makes a larger error than there is at texel centres. The texels are
/// fitted for the places between them, so that finer codes change little then.
bool isMadeByFilter(const ReportRow& row) {
    constexpr const char* kMagnifiedStage = "magnified";
    const auto& stages = row.verdict.stages;
    const auto magnified = std::ranges::find(stages, kMagnifiedStage, &verify::StageError::name);
    return magnified != stages.end() && magnified->specular.relRms >= stages.back().specular.relRms;
}

std::string dominantRemedy(const ReportRow& row, const ReportRow* lightMap) {
    const std::string fit = row.notes ? row.notes->value(note_keys::kFit, "") : "";
    if (lightMap != nullptr && usualDominantLayout(lightMap->layout, fit) == kDerivedDominant)
        return fmt::format("dominant_layout = \"{}\" has no textures to err ({} less).", kDerivedDominant, sizeWords(row.bytesGpu));
    return isMadeByFilter(row) ? "Filtering between its texels makes the error: only more texels in the bake lower it." : "";
}

std::string tablesRemedy(const ReportRow& row) {
    if (row.width <= 0 || row.width >= kFineViewCount) return "";
    const auto more = row.bytesGpu * static_cast<std::uint64_t>(kFineViewCount - row.width) / static_cast<std::uint64_t>(row.width);
    return fmt::format("views = {} in [tables] in place of {} takes {} more.", kFineViewCount, row.width, sizeWords(more));
}

/// Returns the least whole KiB that hold as many bytes.
std::uint64_t kibibytesFor(std::uint64_t bytes) {
    constexpr std::uint64_t kStep = 1024;
    return (bytes + kStep - 1) / kStep;
}

/// Returns the least limit that allows every figure of an asset that it holds, rounded up to three digits; nothing if one is not finite.
std::optional<double> allowingLimit(const ReportRow& row, Limit limit) {
    std::vector<Check> checks = row.checks(row.verdict.limits);
    if (row.whole) std::ranges::copy(row.whole->checks(), std::back_inserter(checks));
    double largest = 0;
    for (const Check& check : checks)
        if (check.figure.limit == limit && !(check.figure.value <= largest)) largest = check.figure.value;
    if (!(largest > 0) || !std::isfinite(largest)) return std::nullopt;
    const double step = std::pow(10.0, std::floor(std::log10(largest)) - 2);
    return step * std::ceil(largest / step);
}

}  // namespace

std::vector<const ReportRow*> lightMapsOf(const std::vector<ReportRow>& rows) {
    std::vector<const ReportRow*> lightMaps;
    for (const ReportRow& row : rows)
        if (row.kind == AssetKind::LightMap) lightMaps.push_back(&row);
    return lightMaps;
}

const ReportRow* lightMapOf(const ReportRow& row, const std::vector<const ReportRow*>& lightMaps) {
    const auto bakeOf = [](const ReportRow& each) { return each.light ? each.light->bake.value_or("") : std::string(); };
    const ReportRow* found = nullptr;
    bool isNamed = false;
    for (const ReportRow* map : lightMaps) {
        if (bakeOf(*map) != bakeOf(row)) continue;
        const bool begins = row.name.starts_with(map->name + "_");
        const bool isLonger = found != nullptr && map->name.size() > found->name.size();
        if (found != nullptr && (!begins || (isNamed && !isLonger))) continue;
        found = map;
        isNamed = begins;
    }
    return found;
}

std::string remedyOf(const ReportRow& row, const std::optional<Check>& over, const ReportRow* lightMap) {
    switch (row.kind) {
        case AssetKind::LightMap:
            return lightMapRemedy(row, over);
        case AssetKind::Dominant:
            return dominantRemedy(row, lightMap);
        case AssetKind::Lut:
            return tablesRemedy(row);
        case AssetKind::Cubemap:
        case AssetKind::Rsrm:
        case AssetKind::Mesh:
            break;
    }
    return "";
}

std::string adviceOn(const ReportRow& row, const Check& over, const ReportRow* lightMap) {
    std::vector<std::string> sentences;
    const bool isVisible = over.figure.limit == Limit::Visible || over.figure.limit == Limit::VisibleBound;
    if (row.charts && isVisible)
        if (const auto few = std::ranges::find(row.charts->few, over.figure.shading, &FewTexels::shading); few != row.charts->few.end())
            sentences.push_back(few->advice);
    if (over.figure.limit == Limit::Seam)
        if (std::string cause = seamCause(row); !cause.empty()) sentences.push_back(std::move(cause));
    if (std::string remedy = remedyOf(row, over, lightMap); !remedy.empty()) sentences.push_back(std::move(remedy));
    if (over.figure.limit == Limit::Seam && row.trialCandidates)
        if (std::string remedy = unquantizedRemedy(row); !remedy.empty()) sentences.push_back(std::move(remedy));
    if (const auto limit = allowingLimit(row, over.figure.limit)) sentences.push_back(fmt::format("A limit of {:.3g} allows it.", *limit));
    return fmt::format("{}", fmt::join(sentences, " "));
}

std::string budgetRemedy(const std::vector<FrontierPoint>& frontier, double maxWholeVisible) {
    const auto kept =
        std::ranges::find_if(frontier, [&](const FrontierPoint& point) { return !point.isChosen && point.visible <= maxWholeVisible; });
    if (kept == frontier.end()) return "";
    return fmt::format("A budget of {} KiB keeps it ({}). ", kibibytesFor(kept->bytesGpu), layoutWords(*kept));
}

std::string budgetAdvice(const std::vector<ReportRow>& rows, std::uint64_t usedBytes, bool isChosen) {
    std::vector<std::string> sentences;
    if (const auto largest = std::ranges::max_element(rows, {}, &ReportRow::bytesGpu); largest != rows.end())
        sentences.push_back(fmt::format("The largest asset is the {} '{}' ({}).", info(largest->kind).shortCaption, largest->name,
                                        sizeWords(largest->bytesGpu)));
    const std::vector<const ReportRow*> lightMaps = lightMapsOf(rows);
    for (const ReportRow& row : rows) {
        const std::string fit = row.notes ? row.notes->value(note_keys::kFit, "") : "";
        const ReportRow* lightMap = row.kind == AssetKind::Dominant ? lightMapOf(row, lightMaps) : nullptr;
        if (lightMap == nullptr || usualDominantLayout(lightMap->layout, fit) != kDerivedDominant) continue;
        sentences.push_back(
            fmt::format("dominant_layout = \"{}\" for {} takes {} less.", kDerivedDominant, lightMap->name, sizeWords(row.bytesGpu)));
    }
    const auto isNamed = [](const ReportRow& row) { return row.kind == AssetKind::LightMap && !row.trialCandidates; };
    if (isChosen)
        sentences.emplace_back("No other layouts that the limits allow are smaller.");
    else if (std::ranges::any_of(rows, isNamed))
        sentences.emplace_back("Without light_map_layout the budget chooses the layouts.");
    sentences.push_back(fmt::format("A budget of {} KiB allows it.", kibibytesFor(usedBytes)));
    return fmt::format("{}", fmt::join(sentences, " "));
}

}  // namespace lightcook::pipeline

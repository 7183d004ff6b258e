#include "pipeline/report/advice.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
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

/// Returns the figure of a layout in its trial that a limit holds; nothing of a limit that trials have no figure of.
std::optional<double> triedFigure(const TrialCandidate& candidate, Limit limit) {
    if (limit == Limit::Error) return std::max(candidate.diffuse, candidate.specular);
    if (limit == Limit::Visible) return std::max(candidate.visibleDiffuse, candidate.visibleSpecular);
    return std::nullopt;
}

std::string figureWords(Limit limit, double value) {
    return limit == Limit::Error ? "rel_rms " + humanPercent(value) : fmt::format("visible error {:.3g}", value);
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
    const auto figureOf = [&](const TrialCandidate& each) { return triedFigure(each, limit).value_or(std::nan("")); };
    const double least = figureOf(*chosen);
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
        return fmt::format("({} when it was tried, {})", figureWords(limit, figureOf(each)), costWords(each.bytesGpu, chosen->bytesGpu));
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
        return fmt::format("{} kept the limit when it was tried ({}): a lower limit takes a larger layout.", name(*chosen),
                           figureWords(limit, least));
    return isAlone(candidates) ? remedyOfNamed(row) : "No layout has less.";
}

std::string lightMapRemedy(const ReportRow& row, const std::optional<Check>& over) {
    if (!over && row.whole) return "";  // chosen with its dominant light: the next scenes of that choice stand elsewhere
    if (row.trialCandidates) {
        if (!over || triedFigure({}, over->figure.limit)) return triedRemedy(row, *row.trialCandidates, over);
        const bool isOfWhole = over->figure.limit == Limit::WholeVisible || over->figure.limit == Limit::WholeError;
        return isOfWhole && isAlone(*row.trialCandidates) ? remedyOfNamed(row) : "";
    }
    if (isFixed(row.layout)) return "";
    return over ? "light_map_layout = \"auto\" takes the smallest layout that keeps the limit."
                : "light_map_layout = \"auto\" with max_visible measures what the other layouts give.";
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
    if (std::string remedy = remedyOf(row, over, lightMap); !remedy.empty()) sentences.push_back(std::move(remedy));
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
    const auto isNamed = [](const ReportRow& row) { return row.kind == AssetKind::LightMap && !row.trialCandidates; };
    if (isChosen)
        sentences.emplace_back("No other layouts are smaller.");
    else if (std::ranges::any_of(rows, isNamed))
        sentences.emplace_back("Without light_map_layout the budget chooses the layouts.");
    sentences.push_back(fmt::format("A budget of {} KiB allows it.", kibibytesFor(usedBytes)));
    return fmt::format("{}", fmt::join(sentences, " "));
}

}  // namespace lightcook::pipeline

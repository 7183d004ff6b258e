#include "pipeline/assets/light_map/layout_choice.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "pipeline/assets/verdict.h"

namespace lightcook::pipeline {
namespace {

using formats::LayoutCost;

/// Returns the cheapest candidate that uses at most `mostUsed` of the limits; else see cheapestWithin().
const LightMapCandidate& cheapestOf(const std::vector<LightMapCandidate>& candidates, double mostUsed, LayoutCost cost) {
    const auto costOf = [&](const LightMapCandidate& each) {
        return std::pair(cost == LayoutCost::Fetches ? each.fetches : 0, each.bytes);
    };
    const auto isBetter = [&](const LightMapCandidate& each, const LightMapCandidate& other) {
        const bool fits = each.usedOfLimits <= mostUsed, otherFits = other.usedOfLimits <= mostUsed;
        if (fits != otherFits) return fits;
        if (fits) return costOf(each) < costOf(other);
        const bool fitted = each.usedInTrial <= mostUsed, otherFitted = other.usedInTrial <= mostUsed;
        if (fitted != otherFitted) return fitted;
        return fitted ? each.usedOfLimits < other.usedOfLimits : each.usedInTrial < other.usedInTrial;
    };
    return *std::ranges::min_element(candidates, isBetter);
}

}  // namespace

double triedUse(const TrialCandidate& candidate, const Limits& limits) {
    return mostUsedShare(judge({{Limit::Error, std::max(candidate.diffuse, candidate.specular), "", ""},
                                {Limit::Visible, std::max(candidate.visibleDiffuse, candidate.visibleSpecular), "", ""}},
                               limits));
}

double verifiedUse(const VerifyResult& verified, const Limits& limits) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    if (!verified.verdict.violations.empty()) return kInfinity;
    if (limits[Limit::VisibleBound] && !hasVisibleBound(verified.verdict.stages.back())) return kInfinity;
    return mostUsedShare(verified.checks(limits));
}

std::vector<LightMapCandidate> candidatesOf(const TrialResult& trial, const Limits& limits) {
    std::vector<LightMapCandidate> candidates;
    for (const TrialCandidate& each : trial.candidates)
        if (const double used = triedUse(each, limits); !each.isExcluded)
            candidates.push_back(
                {each.layout, each.bytesGpu, used, each.fetches, used, std::max(each.visibleDiffuse, each.visibleSpecular)});
    return candidates;
}

void expectBounds(const LightMapCandidate& verified, std::vector<LightMapCandidate>& candidates) {
    for (LightMapCandidate& each : candidates)
        if (each.visible < verified.visible)
            each.usedOfLimits = std::max(each.usedOfLimits, verified.usedOfLimits * each.visible / verified.visible);
}

std::vector<std::string> layoutsOfCurve(std::vector<LightMapCandidate> candidates) {
    std::ranges::sort(candidates, {}, [](const LightMapCandidate& each) { return std::pair(each.bytes, each.usedOfLimits); });
    std::vector<std::string> layouts;
    double least = std::numeric_limits<double>::infinity();
    for (const LightMapCandidate& each : candidates) {
        if (!(each.usedOfLimits < least)) continue;
        least = each.usedOfLimits;
        layouts.push_back(each.layout);
    }
    return layouts;
}

const TrialCandidate* bestExcluded(const std::vector<TrialCandidate>& candidates, const std::string& chosen, const Limits& limits) {
    const auto taken = std::ranges::find(candidates, chosen, &TrialCandidate::layout);
    if (taken == candidates.end()) return nullptr;
    const double takenUse = triedUse(*taken, limits);
    const TrialCandidate *smallest = nullptr, *best = nullptr;
    for (const TrialCandidate& each : candidates) {
        if (!each.isExcluded) continue;
        const double use = triedUse(each, limits);
        if (use <= 1 && (takenUse > 1 || each.bytesGpu < taken->bytesGpu) && (smallest == nullptr || each.bytesGpu < smallest->bytesGpu))
            smallest = &each;
        if (use < takenUse && each.bytesGpu <= taken->bytesGpu && (best == nullptr || use < triedUse(*best, limits))) best = &each;
    }
    return smallest != nullptr ? smallest : best;
}

std::map<std::string, std::string> cheapestWithin(const LightMapCandidates& candidates, double mostUsed, LayoutCost cost) {
    std::map<std::string, std::string> layouts;
    for (const auto& [map, each] : candidates) layouts[map] = cheapestOf(each, mostUsed, cost).layout;
    return layouts;
}

}  // namespace lightcook::pipeline

#include "pipeline/assets/light_map/layout_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "pipeline/assets/verdict.h"

namespace lightcook::pipeline {
namespace {

using formats::LayoutCost;

/// Returns the larger error of a candidate as a part of its limit.
double partOf(const TrialCandidate& candidate, const LayoutLimits& limits) {
    return limits.partOf(std::max(candidate.diffuse, candidate.specular), std::max(candidate.visibleDiffuse, candidate.visibleSpecular));
}

/// Returns the cheapest candidate within maxError, or the one of least error.
const LightMapCandidate& cheapestOf(const std::vector<LightMapCandidate>& candidates, double maxError, LayoutCost cost) {
    const auto costOf = [&](const LightMapCandidate& each) { return std::pair(cost == LayoutCost::Taps ? each.fetches : 0, each.bytes); };
    const LightMapCandidate* best = &candidates.front();
    for (const LightMapCandidate& each : candidates) {
        const bool fits = each.error <= maxError, bestFits = best->error <= maxError;
        const bool isBetter = fits && bestFits ? costOf(each) < costOf(*best) : fits != bestFits ? fits : each.error < best->error;
        if (isBetter) best = &each;
    }
    return *best;
}

}  // namespace

double LayoutLimits::partOf(double error, double visible, double bound, double seam) const {
    const double largest = std::max({error / maxError, maxVisible ? visible / *maxVisible : 0,
                                     maxVisibleBound ? bound / *maxVisibleBound : 0, maxSeam ? seam / *maxSeam : 0});
    const bool areFinite = std::isfinite(error) && std::isfinite(visible) && std::isfinite(bound) && std::isfinite(seam);
    return areFinite ? largest : std::numeric_limits<double>::infinity();
}

double verifiedPart(const verify::StageError& stage, double seam, const LayoutLimits& limits) {
    const bool isBoundMissing = limits.maxVisibleBound && !hasVisibleBound(stage);
    const double bound = isBoundMissing ? std::numeric_limits<double>::infinity() : visibleBound(stage).value_or(0);
    return limits.partOf(std::max(stage.diffuse.relRms, stage.specular.relRms), visibleP99(stage).value_or(0), bound, seam);
}

std::vector<LightMapCandidate> candidatesOf(const TrialResult& trial, const LayoutLimits& limits) {
    std::vector<LightMapCandidate> candidates;
    for (const TrialCandidate& each : trial.candidates)
        if (!each.isExcluded) candidates.push_back({each.layout, each.bytesGpu, partOf(each, limits), each.fetches});
    return candidates;
}

std::vector<std::string> layoutsOfCurve(std::vector<LightMapCandidate> candidates) {
    std::ranges::sort(candidates, {}, [](const LightMapCandidate& each) { return std::pair(each.bytes, each.error); });
    std::vector<std::string> layouts;
    double least = std::numeric_limits<double>::infinity();
    for (const LightMapCandidate& each : candidates) {
        if (!(each.error < least)) continue;
        least = each.error;
        layouts.push_back(each.layout);
    }
    return layouts;
}

const TrialCandidate* bestExcluded(const std::vector<TrialCandidate>& candidates, const std::string& chosen, const LayoutLimits& limits) {
    const auto taken = std::ranges::find(candidates, chosen, &TrialCandidate::layout);
    if (taken == candidates.end()) return nullptr;
    const double error = partOf(*taken, limits);
    const TrialCandidate *smallest = nullptr, *best = nullptr;
    for (const TrialCandidate& each : candidates) {
        if (!each.isExcluded) continue;
        const double part = partOf(each, limits);
        if (part <= 1 && (error > 1 || each.bytesGpu < taken->bytesGpu) && (smallest == nullptr || each.bytesGpu < smallest->bytesGpu))
            smallest = &each;
        if (part < error && each.bytesGpu <= taken->bytesGpu && (best == nullptr || part < partOf(*best, limits))) best = &each;
    }
    return smallest != nullptr ? smallest : best;
}

std::map<std::string, std::string> cheapestWithin(const LightMapCandidates& candidates, double maxError, LayoutCost cost) {
    std::map<std::string, std::string> layouts;
    for (const auto& [map, each] : candidates) layouts[map] = cheapestOf(each, maxError, cost).layout;
    return layouts;
}

}  // namespace lightcook::pipeline

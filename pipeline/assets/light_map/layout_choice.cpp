#include "pipeline/assets/light_map/layout_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

namespace lightcook::pipeline {
namespace {

using formats::LayoutCost;

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

double LayoutLimits::partOf(double error, double visible, double bound) const {
    const double largest =
        std::max({error / maxError, maxVisible ? visible / *maxVisible : 0, maxVisibleBound ? bound / *maxVisibleBound : 0});
    const bool areFinite = std::isfinite(error) && std::isfinite(visible) && std::isfinite(bound);
    return areFinite ? largest : std::numeric_limits<double>::infinity();
}

std::vector<LightMapCandidate> candidatesOf(const TrialResult& trial, const LayoutLimits& limits) {
    std::vector<LightMapCandidate> candidates;
    for (const TrialCandidate& each : trial.candidates)
        candidates.push_back({each.layout, each.bytesGpu,
                              limits.partOf(std::max(each.diffuse, each.specular), std::max(each.visibleDiffuse, each.visibleSpecular)),
                              each.fetches});
    return candidates;
}

std::map<std::string, std::string> cheapestWithin(const LightMapCandidates& candidates, double maxError, LayoutCost cost) {
    std::map<std::string, std::string> layouts;
    for (const auto& [map, each] : candidates) layouts[map] = cheapestOf(each, maxError, cost).layout;
    return layouts;
}

std::map<std::string, std::string> bestWithin(const LightMapCandidates& candidates, std::uint64_t bytes) {
    std::set<double> bounds;
    for (const auto& [map, each] : candidates)
        for (const LightMapCandidate& candidate : each) bounds.insert(candidate.error);
    for (const double bound : bounds) {
        std::uint64_t used = 0;
        bool isHeld = true;
        for (const auto& [map, each] : candidates) {
            const LightMapCandidate& smallest = cheapestOf(each, bound, LayoutCost::Bytes);
            used += smallest.bytes;
            isHeld = isHeld && smallest.error <= bound;
        }
        if (isHeld && used <= bytes) return cheapestWithin(candidates, bound);
    }
    std::map<std::string, std::string> layouts;
    for (const auto& [map, each] : candidates) layouts[map] = std::ranges::min_element(each, {}, &LightMapCandidate::bytes)->layout;
    return layouts;
}

}  // namespace lightcook::pipeline

// Choice of layouts for the light maps of a scene, from the candidates of their trials.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "formats/layout_cost.h"
#include "pipeline/assets/light_map/trial.h"
#include "pipeline/assets/results.h"
#include "pipeline/limits/limits.h"
#include "verify/figures.h"

namespace lightcook::pipeline {

/// Returns the largest part of its limits that a layout uses in its trial, which knows neither bounds nor seams.
double triedUse(const TrialCandidate& candidate, const Limits& limits);

/// Returns the largest part of its limits that a verified map uses: of its last stage, its mip levels, the mixes of two levels, and its
/// seams. Infinite where a limit on the bound of visible errors is given and the bound is not known, and for a map with a violation:
/// verification fails them, too.
double verifiedUse(const VerifyResult& verified, const Limits& limits);

/// A layout's bytes, fetches and errors for one map.
struct LightMapCandidate {
    std::string layout;
    std::uint64_t bytes = 0;
    double usedOfLimits = 0;  ///< largest part of its limits, of the verification where there was one: 1 is just within them
    int fetches = 0;
    double usedInTrial = 0;  ///< the same in the trial, which knows neither bounds nor seams
    double visible = 0;      ///< 99th percentile of visible errors in the trial
};
/// Candidates by the name of the map.
using LightMapCandidates = std::map<std::string, std::vector<LightMapCandidate>>;
/// Returns the candidates that the scene's list of layouts has.
std::vector<LightMapCandidate> candidatesOf(const TrialResult& trial, const Limits& limits);

/// Notes that a verified candidate misses its limit on the bound. Bounds of others are expected to shrink as their visible errors do, at
/// best, so that the search for one within the limit is short.
void expectBounds(const LightMapCandidate& verified, std::vector<LightMapCandidate>& candidates);

/// Returns the layouts that no other candidate beats in both bytes and usedOfLimits, the smallest first.
std::vector<std::string> layoutsOfCurve(std::vector<LightMapCandidate> candidates);

/// Returns the layout that would serve a map better if the scene's list of layouts had it. That is the smallest one that keeps the limits,
/// if the chosen one misses them or takes more memory; else the one of least error among those that are no larger than the chosen one and
/// have less error.
/// Null if none is, as far as the trial measured them.
const TrialCandidate* bestExcluded(const std::vector<TrialCandidate>& candidates, const std::string& chosen, const Limits& limits);

/// Returns for each map the layout of least cost whose usedOfLimits is at most mostUsed. If there is none, returns the one that uses least
/// of the limits among those that the trial found within them: only these were verified, and only verification knows bounds and seams. If
/// the trial found none within them, returns the one that uses least in the trial.
std::map<std::string, std::string> cheapestWithin(const LightMapCandidates& candidates, double mostUsed = 1,
                                                  formats::LayoutCost cost = formats::LayoutCost::Bytes);

}  // namespace lightcook::pipeline

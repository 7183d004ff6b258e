// Choice of layouts for the light maps of a scene, from the candidates of their trials.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "pipeline/assets/light_map/trial.h"

namespace lightcook::pipeline {

/// A layout's bytes and error for one map.
struct LightMapCandidate {
    std::string layout;
    std::uint64_t bytes = 0;
    double error = 0;  ///< the larger rel_rms of diffuse and specular; infinite where it is not finite, so that it is never chosen
};
/// Candidates by the name of the map.
using LightMapCandidates = std::map<std::string, std::vector<LightMapCandidate>>;
std::vector<LightMapCandidate> candidatesOf(const TrialResult& trial);

/// Returns for each map the smallest layout whose error is within maxError; where none is, the one of least error.
std::map<std::string, std::string> smallestWithin(const LightMapCandidates& candidates, double maxError);
/// Returns the layouts that fit into `bytes` together under the least common bound on the error; where nothing fits, the smallest layouts.
std::map<std::string, std::string> bestWithin(const LightMapCandidates& candidates, std::uint64_t bytes);

}  // namespace lightcook::pipeline

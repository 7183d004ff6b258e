// How a light map's layout is prepared: what is measured of the map, what a layout learns from it, and which layout serves a bound or a
// budget best.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "compress/light_map.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

struct MeasuredLightMap {
    compress::LightMapMeasure measure;
    formats::LightMapRepairs repairs;
    std::int64_t negativeAfterGamut = 0;
};
formats::Result<MeasuredLightMap> measureLightMap(LightMapSource& source, const ActionContext& context);

/// Plans layouts for one map. What they learn from is gathered once, when the first of them asks.
class LightMapPlanner {
public:
    /// parameters  of the action: target, textures (effort)
    LightMapPlanner(LightMapSource& source, const Json& parameters, const compress::LightMapMeasure& measure, const ActionContext& context);
    formats::Result<compress::LightMapPlan> plan(const std::string& layout);

private:
    formats::Result<void> gather();

    LightMapSource& source_;
    const compress::LightMapMeasure& measure_;
    const ActionContext& context_;
    formats::Target target_;
    compress::EncodeOptions options_;
    compress::LightMapBlocks blocks_;
    std::vector<int> charts_;
    bool hasIslands_ = false;  ///< of a mesh that will bear the clusters
    std::optional<compress::LightMapSamples> samples_;
};

/// "light-map-trial". Inputs "source" and, of a map that has one, "mesh"; parameters: description, target, textures, shading. Cooks the
/// map, or evenly spread bands of a large one, under every layout that knows directions, and shades the texels: result "candidates" has
/// layout, bytes_gpu, bits_per_texel, diffuse, specular (rel_rms) of each, in the order of bytes; "share" is how much of the map was tried.
formats::Result<ActionOutcome> tryLightMap(const ActionContext& context);

/// A layout's price and worth for one map.
struct LightMapCandidate {
    std::string layout;
    std::uint64_t bytes = 0;
    double error = 0;  ///< the larger rel_rms of diffuse and specular
};
/// By the map's name.
using LightMapCandidates = std::map<std::string, std::vector<LightMapCandidate>>;
std::vector<LightMapCandidate> candidatesOf(const ActionRecord& trial);

/// For each map the smallest layout whose error stays within maxError; where none does, the one of least error.
std::map<std::string, std::string> smallestWithin(const LightMapCandidates& candidates, double maxError);
/// The least bound on every map's error whose smallest layouts fit into `bytes` together, and these layouts; where nothing fits, the
/// smallest of all.
std::map<std::string, std::string> bestWithin(const LightMapCandidates& candidates, std::uint64_t bytes);

}  // namespace lightcook::pipeline

// Light maps whose charts a cook may split between maps (pipeline/assets/light_map/chart_split.h): the actions that choose a split and try
// it, and the maps as the rest of the cook takes them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/assets/light_map/chart_split.h"
#include "pipeline/assets/needs.h"
#include "pipeline/cook/plan.h"
#include "pipeline/graph/action.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

/// Returns the light maps to split, as far as the options want one of their maps, with the settings of the scene and no other assets.
Scene onlyMapsToSplit(const Scene& scene, const PlanOptions& options);

/// Returns the action that chooses the split of a light map, "split/" and its name. Empty where its layout is not chosen: it needs no
/// directions, or all its texels hold the same light.
/// entry   with its charts packed into one map
/// needs   with the contents of that map
std::optional<Action> splitAction(const Scene& scene, const Needs& needs, const LightMapEntry& entry, const PackedLightMap& packed,
                                  bool repair);

/// Returns the maps of a split. The light map is one of the scene.
std::vector<LightMapEntry> partsOf(const LightMapEntry& lightMap, const TriedSplit& split, double displayKey);

/// Returns the trial of one of the maps. Empty where its layout is not chosen.
std::optional<Action> partTrial(const Scene& scene, const Needs& needs, const LightMapEntry& entry, bool repair);

/// Returns the GPU memory of the smallest layout of a trial within the limits of its map, with that of the dominant light [bytes]. Empty:
/// none is.
/// packing  of the map
std::optional<std::uint64_t> leastBytes(const TrialResult& trial, const ChartPacking& packing, const Scene& scene, const Needs& needs,
                                        const LightMapEntry& entry);

}  // namespace lightcook::pipeline

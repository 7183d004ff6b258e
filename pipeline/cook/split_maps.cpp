#include "pipeline/cook/split_maps.h"

#include <algorithm>

#include "pipeline/assets/light_map/layout_choice.h"
#include "pipeline/cook/trial_actions.h"

namespace lightcook::pipeline {
namespace {

/// Returns the parameters of the trial of a packed map. Empty where its layout is not chosen.
std::optional<TrialParameters> trialOf(const Scene& scene, const Needs& needs, const LightMapEntry& entry, bool repair) {
    const LightMapReduction reduction = reductionOf(scene, needs, entry, lightMapLayoutFor(scene, needs, entry));
    if (reduction.layout != kAutoLayout || reduction.constantOf) return std::nullopt;
    return trialParametersOf(scene, needs, entry, reduction, repair);
}

}  // namespace

std::string fineNameOf(const std::string& lightMap) {
    return lightMap + "_fine";
}

Scene onlyMapsToSplit(const Scene& scene, const PlanOptions& options) {
    Scene maps = scene;
    maps.probes.clear();
    maps.gradients.clear();
    std::erase_if(maps.lightMaps, [&](const LightMapEntry& entry) {
        LightMapEntry fine = entry;
        fine.name = fineNameOf(entry.name);
        return !isSplit(scene.output, entry) || !(isAnyWanted(scene, options, entry) || isAnyWanted(scene, options, fine));
    });
    return maps;
}

std::optional<Action> splitAction(const Scene& scene, const Needs& needs, const LightMapEntry& entry, const PackedLightMap& packed,
                                  bool repair) {
    auto trial = trialOf(scene, needs, entry, repair);
    if (!trial) return std::nullopt;
    const SplitParameters parameters{std::move(*trial), scene.output.maxError, visibleLimit(scene.output, entry.maxVisible),
                                     packed.bake.places};
    return Action{"split/" + entry.name, "split-charts", entry.name, toJson(parameters), learnedInputsOf(entry), {}};
}

std::vector<LightMapEntry> partsOf(const LightMapEntry& lightMap, const TriedSplit& split, double displayKey) {
    std::vector<LightMapEntry> parts(2, lightMap);
    parts[1].name = fineNameOf(lightMap.name);
    parts[0].part = ChartPart{lightMap.name, split.charts};
    parts[1].part = ChartPart{lightMap.name, split.fineCharts};
    for (LightMapEntry& part : parts) {
        part.charts.mode = ChartMode::Pack;
        if (displayKey > 0) part.white = displayKey / lighting::kKeyOfDiffuseWhite;
    }
    return parts;
}

std::optional<Action> partTrial(const Scene& scene, const Needs& needs, const LightMapEntry& entry, bool repair) {
    const auto trial = trialOf(scene, needs, entry, repair);
    return trial ? std::optional(trialAction(entry, *trial)) : std::nullopt;
}

std::optional<std::uint64_t> leastBytes(const TrialResult& trial, const ChartPacking& packing, const Scene& scene, const Needs& needs,
                                        const LightMapEntry& entry) {
    std::optional<std::uint64_t> least;
    for (const LightMapCandidate& each : candidatesOf(trial, {scene.output.maxError, visibleLimit(scene.output, entry.maxVisible)}))
        if (each.error <= 1 && each.bytes < least.value_or(UINT64_MAX)) least = each.bytes;
    if (least && needs.specular) *least += bytesOf(dominantImages(scene.output.target), {packing.width, packing.height});
    return least;
}

}  // namespace lightcook::pipeline

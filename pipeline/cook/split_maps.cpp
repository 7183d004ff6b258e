#include "pipeline/cook/split_maps.h"

#include <algorithm>
#include <set>

#include "pipeline/assets/action_kind.h"
#include "pipeline/assets/light_map/layout_choice.h"
#include "pipeline/cook/plan.h"
#include "pipeline/cook/trial_actions.h"
#include "pipeline/scene/dominant_layout.h"
#include "pipeline/scene/settings.h"

namespace lightcook::pipeline {
namespace {

/// Returns the parameters of the trial of a packed map. Empty where its layout is not chosen.
std::optional<TrialParameters> trialOf(const Scene& scene, const Needs& needs, const LightMapEntry& entry, bool repair) {
    const LightMapReduction reduction = reductionOf(scene, needs, entry, lightMapLayoutFor(scene, needs, entry));
    if (reduction.layout != kAutoLayout || reduction.constantOf) return std::nullopt;
    return trialParametersOf(scene, needs, entry, reduction, repair);
}

/// Returns the GPU memory of the dominant light of a map of some size, in the layout of the scene file [bytes].
std::uint64_t dominantBytes(const LightMapEntry& entry, formats::Target target, const glm::ivec2& size) {
    const DominantLayoutInfo& layout = entry.dominantLayout ? *dominantLayoutFromName(*entry.dominantLayout) : allDominantLayouts().front();
    if (layout.divisor == 0) return 0;
    return bytesOf(dominantImages(target, layout.hasResidual), (size + layout.divisor - 1) / layout.divisor);
}

}  // namespace

std::string fineNameOf(const std::string& lightMap) {
    return lightMap + "_fine";
}

Scene onlyMapsToSplit(const Scene& scene, const PlanOptions& options) {
    Scene split = scene;
    split.lightMaps.clear();
    for (const LightMapEntry& entry : scene.lightMaps) {
        const std::vector<LightMapEntry> parts = isSplit(scene.output, entry) ? partsOf(entry, {}, 0) : std::vector{entry};
        split.lightMaps.insert(split.lightMaps.end(), parts.begin(), parts.end());
    }
    std::set<std::string> wanted;
    for (const LightMapEntry& part : split.lightMaps)
        if (part.part && isAnyWanted(split, options, part)) wanted.insert(part.nameInScene());
    Scene maps = scene;
    maps.probes.clear();
    maps.gradients.clear();
    std::erase_if(maps.lightMaps, [&](const LightMapEntry& entry) { return !wanted.contains(entry.name); });
    return maps;
}

std::optional<Action> splitAction(const Scene& scene, const Needs& needs, const LightMapEntry& entry, const PackedLightMap& packed,
                                  bool repair) {
    auto trial = trialOf(scene, needs, entry, repair);
    if (!trial) return std::nullopt;
    const SplitParameters parameters{std::move(*trial), layoutErrorLimit(scene.output), visibleLimit(scene.output, entry.maxVisible),
                                     packed.bake.places, packed.boxes};
    return Action{actionId(ActionStep::Split, entry.name), kSplitChartsKind, entry.name, toJson(parameters), learnedInputsOf(entry), {}};
}

std::vector<LightMapEntry> partsOf(const LightMapEntry& lightMap, const TriedSplit& split, double displayKey) {
    std::vector<LightMapEntry> parts(2, lightMap);
    parts[1].name = fineNameOf(lightMap.name);
    parts[0].part = ChartPart{lightMap.name, split.tileSide, split.tiles};
    parts[1].part = ChartPart{lightMap.name, split.tileSide, split.fineTiles};
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
    for (const LightMapCandidate& each :
         candidatesOf(trial, {layoutErrorLimit(scene.output), visibleLimit(scene.output, entry.maxVisible)}))
        if (each.usedOfLimits <= 1 && each.bytes < least.value_or(UINT64_MAX)) least = each.bytes;
    if (least && needs.specular) *least += dominantBytes(entry, scene.output.target, {packing.width, packing.height});
    return least;
}

}  // namespace lightcook::pipeline

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

Scene onlyMapsToSplit(const Scene& scene, const PlanOptions& options) {
    const TriedSplit any{0, std::vector<SplitMap>(kMostMaps), 0, 0};
    Scene split = scene;
    split.lightMaps.clear();
    for (const LightMapEntry& entry : scene.lightMaps) {
        const std::vector<LightMapEntry> parts = isSplit(scene.output, entry) ? partsOf(entry, any, 0) : std::vector{entry};
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
    const SplitParameters parameters{std::move(*trial), layoutLimits(scene.output, entry), packed.bake.places, packed.boxes};
    return Action{actionId(ActionStep::Split, entry.name), kSplitChartsKind, entry.name, toJson(parameters), learnedInputsOf(entry), {}};
}

std::vector<LightMapEntry> partsOf(const LightMapEntry& lightMap, const TriedSplit& split, double displayKey) {
    const auto names = splitNamesOf(lightMap.name);
    std::vector<LightMapEntry> parts(split.maps.size(), lightMap);
    for (std::size_t i = 0; i < parts.size(); ++i) {
        LightMapEntry& part = parts[i];
        part.name = names[i];
        part.part = ChartPart{lightMap.name, split.tileSide, split.maps[i].tiles};
        if (split.tileSide > 0 && parts.size() == 3) part.part->otherTiles = split.maps[i == 2 ? 1 : 2].tiles;
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
    for (const LightMapCandidate& each : candidatesOf(trial, layoutLimits(scene.output, entry)))
        if (each.usedOfLimits <= 1 && each.bytes < least.value_or(UINT64_MAX)) least = each.bytes;
    if (least && needs.specular) *least += dominantBytes(entry, scene.output.target, {packing.width, packing.height});
    return least;
}

}  // namespace lightcook::pipeline

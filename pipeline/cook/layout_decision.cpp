#include "pipeline/cook/layout_decision.h"

#include <algorithm>

#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/assets/results.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

/// Returns an upper bound of the GPU memory of the meshes of some light maps: these meshes wait for the layouts.
Result<std::uint64_t> mostMeshBytes(const Scene& scene, const std::vector<std::string>& lightMaps, const ExecutionResult& materials) {
    std::uint64_t bytes = 0;
    for (const LightMapEntry& entry : scene.lightMaps) {
        if (!entry.mesh || std::ranges::find(lightMaps, entry.name) == lightMaps.end()) continue;
        const auto record = materials.records.find("materials/" + entry.mesh->string());
        if (record == materials.records.end()) continue;
        const auto result = fromJson<MaterialsResult>(record->second.result, record->second.id);
        if (!result) return tl::make_unexpected(result.error());
        bytes += result->mostBytesGpu;
    }
    return bytes;
}

}  // namespace

Result<LayoutDecision> LayoutDecision::create(const Scene& scene, const Plan& open, const ExecutionResult& trials,
                                              const ExecutionResult& materials) {
    LayoutDecision decision(scene);
    for (const std::string& map : open.undecided) {
        const auto record = trials.records.find("trial/" + map);
        if (record == trials.records.end()) continue;
        const auto trial = fromJson<TrialResult>(record->second.result, record->second.id);
        if (!trial) return tl::make_unexpected(trial.error());
        decision.candidates_[map] = candidatesOf(*trial, decision.limitsOf(map));
    }
    const auto meshBytes = mostMeshBytes(scene, open.undecided, materials);
    if (!meshBytes) return tl::make_unexpected(meshBytes.error());
    decision.otherBytes_ = *meshBytes;
    for (const std::string& name : open.assets) {
        const auto record = trials.records.find("cook/" + name);
        if (record == trials.records.end()) continue;
        const auto cooked = fromJson<CookResult>(record->second.result, record->second.id);
        if (!cooked) return tl::make_unexpected(cooked.error());
        decision.otherBytes_ += cooked->asset.totalBytesGpu();
    }
    return decision;
}

LayoutLimits LayoutDecision::limitsOf(const std::string& map) const {
    const auto entry = std::ranges::find(scene_.lightMaps, map, &LightMapEntry::name);
    const bool isKnown = entry != scene_.lightMaps.end();
    return {scene_.output.maxError, visibleLimit(scene_.output, isKnown ? entry->maxVisible : std::nullopt),
            isKnown && entry->maxVisibleBound ? entry->maxVisibleBound : scene_.output.maxVisibleBound};
}

std::map<std::string, std::string> LayoutDecision::choose() const {
    const OutputSettings& output = scene_.output;
    if (!output.budgetBytes || output.isErrorAsked || output.maxVisible || output.maxVisibleBound)
        return cheapestWithin(candidates_, 1, output.cost);
    return bestWithin(candidates_, *output.budgetBytes - std::min(otherBytes_, *output.budgetBytes));
}

Result<bool> LayoutDecision::isRefuted(const ExecutionResult& chosen, const std::map<std::string, std::string>& layouts) {
    bool isRefuted = false;
    for (const auto& [map, layout] : layouts) {
        const auto record = chosen.records.find("verify/" + map);
        if (record == chosen.records.end()) continue;
        const auto verified = fromJson<VerifyResult>(record->second.result, record->second.id);
        if (!verified) return tl::make_unexpected(verified.error());
        const verify::StageError& last = verified->verdict.stages.back();
        const double found = limitsOf(map).partOf(std::max(last.diffuse.relRms, last.specular.relRms), visibleP99(last).value_or(0),
                                                  visibleBound(last).value_or(0));
        LightMapCandidate& candidate = *std::ranges::find(candidates_.at(map), layout, &LightMapCandidate::layout);
        if (found > 1 && candidate.error <= 1) isRefuted = true;
        candidate.error = found;
    }
    return isRefuted;
}

const std::string& lightMapOf(const Plan& plan, const std::string& asset) {
    const auto mesh = plan.meshes.find(asset);
    return mesh == plan.meshes.end() ? asset : mesh->second;
}

}  // namespace lightcook::pipeline

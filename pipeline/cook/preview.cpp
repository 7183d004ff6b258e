#include "pipeline/cook/preview.h"

#include <algorithm>

#include "formats/light_map_layout.h"
#include "pipeline/assets/action_kind.h"
#include "pipeline/assets/asset_kind.h"
#include "pipeline/assets/light_map/detailed_layout.h"
#include "pipeline/assets/results.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/scene/settings.h"

namespace lightcook::pipeline {

namespace {

/// Returns true if "auto" may take a layout.
bool isAllowed(const Scene& scene, const LightMapEntry& entry, const std::string& layout) {
    const formats::LayoutList& allowed = layoutsFor(scene.output, entry);
    return allowed.empty() || std::ranges::find(allowed, layout) != allowed.end();
}

}  // namespace

Scene previewOf(Scene scene) {
    scene.output.effort = 0;
    scene.output.limits = {};
    scene.output.budgetBytes.reset();
    scene.output.gltf = false;  // it holds the proof of its light map
    for (LightMapEntry& entry : scene.lightMaps) entry.limits = {};
    return scene;
}

Decisions decisionsIn(const std::filesystem::path& folder, const Scene& scene) {
    const auto manifest = loadManifest(folder);
    if (!manifest || manifest->scene != scene.name) return {};
    Decisions decisions = manifest->cooks.back().decisions;
    for (const LightMapEntry& entry : scene.lightMaps)
        if (const auto layout = decisions.layouts.find(entry.name);
            layout != decisions.layouts.end() && !isAllowed(scene, entry, DetailedLayout::ofName(layout->second).layout))
            decisions.layouts.erase(layout);
    return decisions;
}

std::string previewLayoutOf(const Scene& scene, const LightMapEntry& entry) {
    const std::string fastest(formats::info(formats::LightMapLayout::Hdr).name);
    return isAllowed(scene, entry, fastest) ? fastest : layoutsFor(scene.output, entry).front();
}

std::vector<Action> previewActionsOf(const Plan& plan) {
    const std::string verification = std::string(kVerifyKindPrefix) + std::string(info(AssetKind::LightMap).name);
    std::vector<Action> actions;
    for (const Action& action : plan.actions) {
        if (!isOfStep(action.id, ActionStep::Cook) && action.kind != verification) continue;
        actions.push_back(action);
        if (action.kind == verification) actions.back().kind = kSampledKind;
    }
    return actions;
}

formats::Result<PreviewSummary> previewSummary(const Scene& scene, const Plan& plan, const ExecutionResult& result, double seconds) {
    PreviewSummary summary{.scene = scene.name, .seconds = seconds};
    for (const std::string& name : plan.assets) {
        const auto cooked = result.records.find(actionId(ActionStep::Cook, name));
        if (cooked == result.records.end()) continue;
        LC_TRY(asset, fromJson<CookResult>(cooked->second.result, name));
        summary.bytesGpu += asset->asset.totalBytesGpu();
        const auto compared = result.records.find(actionId(ActionStep::Verify, name));
        if (compared == result.records.end()) continue;
        LC_TRY(figures, fromJson<SampledErrors>(compared->second.result, name));
        summary.lightMaps.push_back({name, asset->asset.layout, std::move(*figures)});
    }
    return summary;
}

}  // namespace lightcook::pipeline

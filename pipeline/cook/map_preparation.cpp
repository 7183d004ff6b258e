#include "pipeline/cook/map_preparation.h"

#include <algorithm>

#include "pipeline/graph/files.h"
#include "pipeline/scene/settings.h"

namespace lightcook::pipeline {

formats::Result<PreparedMaps> prepareMaps(const Scene& scene, PlanOptions& options, const std::filesystem::path& folder,
                                          const RunInto& run) {
    PreparedMaps prepared{scene, {}, {}};
    for (const LightMapEntry& entry : scene.lightMaps)
        if (isPacked(scene.output, entry) && isAnyWanted(scene, options, entry))
            prepared.graph.push_back(packAction(entry, chartsMaxVisible(scene.output, entry), options.repair));
    if (prepared.graph.empty()) return prepared;
    LC_CHECK(makeFolder(folder));
    prepared.result = run(prepared.graph, folder);
    for (const Action& action : prepared.graph) {
        const auto record = prepared.result.records.find(action.id);
        const auto entry = std::ranges::find(prepared.scene.lightMaps, action.asset, &LightMapEntry::name);
        if (record == prepared.result.records.end()) {
            prepared.scene.lightMaps.erase(entry);
            continue;
        }
        LC_TRY(packed, packedLightMap(action, record->second, folder));
        *entry = packedEntry(std::move(*entry), *packed);
        options.packed[action.asset] = std::move(*packed);
    }
    return prepared;
}

}  // namespace lightcook::pipeline

#include <array>
#include <utility>

#include "pipeline/assets/cubemap/cubemap.h"
#include "pipeline/assets/dominant/dominant.h"
#include "pipeline/assets/light_map/light_map.h"
#include "pipeline/assets/light_map/planner.h"
#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/assets/rsrm/rsrm.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

ActionFunction actionFunction(const std::string& kind) {
    static constexpr std::array<std::pair<std::string_view, ActionFunction>, 14> kFunctions = {{
        {"materials", readMaterials},
        {"light-map", cookLightMap},
        {"light-map-trial", tryLightMap},
        {"dominant", cookDominant},
        {"cubemap", cookCubemap},
        {"lut", cookTables},
        {"rsrm", cookRsrm},
        {"mesh", cookMesh},
        {"verify-light-map", verifyLightMap},
        {"verify-dominant", verifyDominant},
        {"verify-cubemap", verifyCubemap},
        {"verify-lut", verifyTables},
        {"verify-rsrm", verifyRsrm},
        {"verify-mesh", verifyMesh},
    }};
    for (const auto& [name, function] : kFunctions)
        if (name == kind) return function;
    return [](const ActionContext& context) -> formats::Result<ActionOutcome> {
        return formats::failure(formats::ErrorCode::FileUnreadable, context.action.asset,
                                "found the kind '" + context.action.kind + "', expected one that this version knows");
    };
}

}  // namespace lightcook::pipeline

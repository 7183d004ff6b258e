#include "pipeline/assets/light_map/decoded_rows.h"

#include <algorithm>
#include <cstddef>
#include <string>

#include "compress/light_map_context.h"
#include "verify/texture_unit.h"

namespace lightcook::pipeline {

verify::CookedLightMap cookedMapOf(const compress::LightMapPlan& plan, const formats::LightMapLayoutInfo& layout) {
    verify::CookedLightMap map{std::string(layout.name), plan.constants, plan.width, plan.height};
    map.filter = plan.filter;
    const int planned = formats::info(plan.layout).residualCount();
    const auto residual = map.constants.find("residual");
    if (residual == map.constants.end() || layout.id == plan.layout || planned == 0) return map;
    residual->second.resize(residual->second.size() / static_cast<std::size_t>(planned) * static_cast<std::size_t>(layout.residualCount()));
    return map;
}

formats::Result<PlannedRows> planRows(LightMapSource& source, const compress::LightMapPlan& plan, const compress::EncodeOptions& options,
                                      int firstRow, int endRow) {
    const int above = std::max(0, firstRow - compress::kLightMapContextRows),
              below = std::min(plan.height, endRow + compress::kLightMapContextRows), rowCount = endRow - firstRow;
    LC_TRY(texels, source.rows(above, below - above));
    const auto rows = compress::encodeLightMapRows(plan, *texels, firstRow, rowCount, options);
    verify::DecodedLightMapRows decoded;
    decoded.firstRow = firstRow;
    for (std::size_t texture = 0; texture < plan.textures.size(); ++texture) {
        decoded.textures.emplace_back();
        for (const auto& bytes : rows.textures[texture].layers) {
            const glm::ivec2 size = plan.textures[texture].sizeFor(plan.width, rowCount);
            decoded.textures.back().emplace_back(size.x, size.y);
            verify::decodeRows(plan.textures[texture].format, bytes, decoded.textures.back().back().view());
        }
    }
    return PlannedRows{std::move(*texels), std::move(decoded)};
}

}  // namespace lightcook::pipeline

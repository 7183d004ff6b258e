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

namespace {

verify::DecodedLightMapRows decoded(const compress::LightMapPlan& plan, const compress::EncodedLightMapRows& rows, int firstRow,
                                    int rowCount) {
    verify::DecodedLightMapRows out;
    out.firstRow = firstRow;
    for (std::size_t texture = 0; texture < plan.textures.size(); ++texture) {
        out.textures.emplace_back();
        for (const auto& bytes : rows.textures[texture].layers) {
            const glm::ivec2 size = plan.textures[texture].sizeFor(plan.width, rowCount);
            out.textures.back().emplace_back(size.x, size.y);
            verify::decodeRows(plan.textures[texture].format, bytes, out.textures.back().back().view());
        }
    }
    return out;
}

/// Returns rows [firstRow, endRow) with what the encoder needs beside them.
formats::Result<formats::LightMapStrip> rowsWithContext(LightMapSource& source, int firstRow, int endRow) {
    const int above = std::max(0, firstRow - compress::kLightMapContextRows),
              below = std::min(source.height(), endRow + compress::kLightMapContextRows);
    return source.rows(above, below - above);
}

}  // namespace

formats::Result<PlannedRows> planRows(LightMapSource& source, const compress::LightMapPlan& plan, const compress::EncodeOptions& options,
                                      int firstRow, int endRow) {
    const int rowCount = endRow - firstRow;
    LC_TRY(texels, rowsWithContext(source, firstRow, endRow));
    const auto rows = compress::encodeLightMapRows(plan, *texels, firstRow, rowCount, options);
    return PlannedRows{std::move(*texels), decoded(plan, rows, firstRow, rowCount)};
}

formats::Result<PlannedRows> planStrip(LightMapSource& source, const StripEncoder& encoder, int index) {
    const compress::LightMapPlan& plan = encoder.plan();
    const int firstRow = source.stripFirstRow(index), endRow = firstRow + source.stripRows(index),
              below = std::min(plan.height, endRow + plan.blockHeight());
    LC_TRY(texels, rowsWithContext(source, firstRow, endRow));
    LC_TRY(strip, encoder.encode(source, index));
    compress::EncodedLightMapRows& rows = strip->rows;
    if (endRow < below) {
        LC_TRY(next, rowsWithContext(source, endRow, below));
        const auto more = compress::encodeLightMapRows(plan, *next, endRow, below - endRow, encoder.options());
        for (std::size_t texture = 0; texture < rows.textures.size(); ++texture)
            for (std::size_t layer = 0; layer < rows.textures[texture].layers.size(); ++layer) {
                std::vector<std::byte>& blocks = rows.textures[texture].layers[layer];
                const std::vector<std::byte>& following = more.textures[texture].layers[layer];
                blocks.insert(blocks.end(), following.begin(), following.end());
            }
    }
    return PlannedRows{std::move(*texels), decoded(plan, rows, firstRow, below - firstRow)};
}

}  // namespace lightcook::pipeline

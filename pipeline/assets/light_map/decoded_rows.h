// Encoded rows of a light map, decoded without files.
#pragma once

#include <cstddef>

#include "compress/light_map.h"
#include "verify/light_map.h"
#include "verify/texture_unit.h"

namespace lightcook::pipeline {

/// Decodes rows [firstRow, firstRow + rowCount), as encodeLightMapRows returns them, with the verifier's own decoders.
inline verify::DecodedLightMapRows decodedRows(const compress::LightMapPlan& plan, const compress::EncodedLightMapRows& rows, int firstRow,
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

}  // namespace lightcook::pipeline

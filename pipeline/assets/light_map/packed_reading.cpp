#include "pipeline/assets/light_map/packed_reading.h"

#include <algorithm>
#include <cmath>

#include "pipeline/graph/parallel_for.h"

namespace lightcook::pipeline {

using formats::Result;

namespace {

/// Returns rows of a bake whose texels are all covered.
formats::LightMapStrip coveredRows(int firstRow, int width, int rowCount) {
    formats::LightMapStrip strip;
    strip.firstRow = firstRow;
    strip.sh = formats::Image<lighting::ShRgb>(width, rowCount);
    strip.covered = formats::Image<std::uint8_t>(width, rowCount, 1);
    strip.normal = formats::Image<glm::vec3>(width, rowCount, glm::vec3(0, 0, 1));
    return strip;
}

}  // namespace

Result<std::vector<lighting::ShRgb>> decodedAt(std::span<const glm::dvec2> places, const PackedReading& reading,
                                               const ActionContext& context) {
    const CookedLightMapReader& cooked = reading.cooked;
    struct Place {
        std::size_t index;
        glm::dvec2 texel;
    };
    std::vector<std::vector<Place>> strips(static_cast<std::size_t>((cooked.height() + kChunkRows - 1) / kChunkRows));
    for (std::size_t i = 0; i < places.size(); ++i)
        if (const auto texel = reading.charts.packed(places[i])) {
            const int row = std::clamp(static_cast<int>(std::floor(texel->y)), 0, cooked.height() - 1);
            strips[static_cast<std::size_t>(row / kChunkRows)].push_back({i, *texel});
        }
    std::vector<lighting::ShRgb> decoded(places.size());
    const auto decodeStrip = [&](int index) -> Result<int> {
        const std::vector<Place>& strip = strips[static_cast<std::size_t>(index)];
        if (strip.empty()) return index;
        const int firstRow = index * kChunkRows, rowCount = std::min(kChunkRows + 1, cooked.height() - firstRow);
        LC_TRY(texels, cooked.read(firstRow, kChunkRows + 1));
        LC_TRY(covered, reading.repacked != nullptr ? reading.repacked->rows(firstRow, rowCount)
                                                    : Result<formats::LightMapStrip>(coveredRows(firstRow, cooked.width(), rowCount)));
        const float unit = reading.key > 0 ? static_cast<float>(reading.key) : 1.0f;
        std::vector<lighting::ShRgb> light(cooked.verifier().lightCount());
        for (const Place& place : strip) {
            if (!cooked.verifier().lightAt(*texels, *covered, place.texel, light)) continue;
            for (std::size_t i = 0; i < lighting::kShCount; ++i) decoded[place.index][i] = unit * light.back()[i];
        }
        return index;
    };
    LC_TRY(done, foldInOrder<int>(static_cast<int>(strips.size()), context, "decode " + context.action.asset, decodeStrip, [](int) {}));
    return decoded;
}

}  // namespace lightcook::pipeline

#include "pipeline/assets/light_map/mesh_part.h"

#include <fmt/format.h>

#include <utility>

#include "atlas/mesh_cut.h"

namespace lightcook::pipeline {

using formats::Result;

Result<atlas::ChartSet> chartsOf(const formats::GltfScene& scene, const formats::Subject& file, const glm::ivec2& size) {
    const auto meshes = scene.triangleMeshes();
    return atlas::findCharts(meshes, std::vector<formats::Subject>(meshes.size(), file), size.x, size.y);
}

Result<MeshPart> partOf(const formats::GltfScene& scene, const formats::Subject& file, const ChartPart& part, const glm::ivec2& size,
                        bool hasLines) {
    LC_TRY(charts, chartsOf(scene, file, size));
    atlas::Tiles tiles(atlas::boxesOf(charts->charts), part.tileSide);
    constexpr std::uint8_t kRest = 0, kOwn = 1, kOther = 2;
    std::vector<std::uint8_t> mapOf(static_cast<std::size_t>(tiles.count()), kRest);
    for (const auto& [map, numbers] : {std::pair(kOwn, &part.tiles), std::pair(kOther, &part.otherTiles)})
        for (const int tile : *numbers) {
            if (tile < 0 || tile >= tiles.count())
                return formats::failure(
                    formats::ErrorCode::Verification, file,
                    fmt::format("found {} tiles of charts, expected one of number {}: cook the scene again", tiles.count(), tile));
            mapOf[static_cast<std::size_t>(tile)] = map;
        }
    auto cut = scene.part({atlas::cutMeshes(scene.triangleMeshes(), {*charts, tiles, size, mapOf}, kOwn), hasLines});
    if (!cut) return tl::make_unexpected(cut.error());
    std::vector<std::uint8_t> isChosen;
    for (const std::uint8_t map : mapOf) isChosen.push_back(map == kOwn ? 1 : 0);
    return MeshPart{std::move(*cut), std::move(*charts), std::move(tiles), std::move(isChosen)};
}

}  // namespace lightcook::pipeline

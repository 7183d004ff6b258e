#include "pipeline/repack/mesh_part.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "atlas/mesh_cut.h"

namespace lightcook::pipeline {

using formats::Result;

Result<atlas::ChartSet> chartsOf(const formats::GltfScene& scene, const std::string& file, const glm::ivec2& size) {
    const auto meshes = scene.triangleMeshes();
    return atlas::findCharts(meshes, std::vector<std::string>(meshes.size(), file), size.x, size.y);
}

Result<MeshPart> partOf(const formats::GltfScene& scene, const std::string& file, const ChartPart& part, const glm::ivec2& size,
                        bool hasLines) {
    auto charts = chartsOf(scene, file, size);
    if (!charts) return tl::make_unexpected(charts.error());
    atlas::Tiles tiles(atlas::boxesOf(charts->charts), part.tileSide);
    std::vector<std::uint8_t> isChosen(static_cast<std::size_t>(tiles.count()), 0);
    for (const int tile : part.tiles) {
        if (tile < 0 || tile >= tiles.count())
            return formats::failure(
                formats::ErrorCode::Verification, file,
                fmt::format("found {} tiles of charts, expected one of number {}: cook the scene again", tiles.count(), tile));
        isChosen[static_cast<std::size_t>(tile)] = 1;
    }
    auto cut = scene.part({atlas::cutMeshes(scene.triangleMeshes(), *charts, tiles, size, isChosen), hasLines});
    if (!cut) return tl::make_unexpected(cut.error());
    return MeshPart{std::move(*cut), std::move(*charts), std::move(tiles), std::move(isChosen)};
}

}  // namespace lightcook::pipeline

// Places of a light map before and after its charts were packed.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "atlas/charts.h"
#include "formats/gltf_scene.h"
#include "formats/image.h"
#include "pipeline/repack/repack.h"
#include "pipeline/repack/unpacked_bake.h"

namespace lightcook::pipeline {

/// Maps places of a bake to those of the repacked bake, chart by chart.
class ChartPlaces {
public:
    /// Finds the charts of the mesh as it was. Fails with ErrorCode::Verification where it has other charts than the record says.
    /// mesh  its file, for errors
    static formats::Result<ChartPlaces> create(const formats::GltfScene& scene, const std::string& mesh, const UnpackedBake& bake);

    /// Returns the place in the repacked map. Empty where no triangle comes near, and in charts of another part.
    /// texel  place in the bake; integers are texel centres
    std::optional<glm::dvec2> packed(const glm::dvec2& texel) const;
    /// Returns true where a chart of the mesh lies, be it of this part or of another.
    bool isRead(const glm::dvec2& texel) const { return chartAt(texel) != atlas::ChartSet::kNoChart; }

    /// Fails with ErrorCode::Verification, naming mesh and vertex, unless the UVs of the repacked mesh lie where its charts do.
    /// mesh  file of `after`, for errors
    /// size  of the repacked map [texels]
    formats::Result<void> check(const formats::GltfScene& before, const formats::GltfScene& after, const std::string& mesh,
                                const glm::ivec2& size) const;

private:
    ChartPlaces(atlas::ChartSet charts, std::vector<std::optional<ChartPlace>> places, const glm::ivec2& before);
    glm::dvec2 moved(std::size_t chart, const glm::dvec2& texel) const;
    std::uint32_t ownerOf(const glm::ivec2& quad) const;
    std::uint32_t chartAt(const glm::dvec2& texel) const;

    atlas::ChartSet charts_;
    std::vector<std::optional<ChartPlace>> places_;  ///< [chart]; empty: of another part
    glm::ivec2 before_;
    formats::Image<std::uint32_t> owners_;  ///< chart of each quad, from quad (-1, -1) on
};

/// Returns the triangles of each of some meshes whose charts are chosen, as GltfScene::writePart() takes them.
/// meshes    as they were given to atlas::findCharts
/// isChosen  of each chart
std::vector<std::vector<std::uint8_t>> trianglesOfCharts(std::span<const formats::TriangleMesh* const> meshes,
                                                         const atlas::ChartSet& charts, const std::vector<std::uint8_t>& isChosen);

/// Return places as parameters of an action have them, four numbers a chart, and back.
std::vector<int> numbersOf(std::span<const ChartPlace> places);
std::vector<ChartPlace> placesOf(std::span<const int> numbers);

}  // namespace lightcook::pipeline

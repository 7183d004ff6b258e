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

namespace lightcook::pipeline {

/// Maps places of a bake to those of the repacked bake, chart by chart.
class ChartPlaces {
public:
    /// Finds the charts of the mesh as it was. Fails with ErrorCode::Verification where it has another number of charts than places.
    /// mesh    its file, for errors
    /// before  size of the bake [texels]
    static formats::Result<ChartPlaces> create(const formats::GltfScene& scene, const std::string& mesh, const glm::ivec2& before,
                                               std::span<const ChartPlace> places);

    /// Returns the place in the repacked map. Empty where no triangle comes near.
    /// texel  place in the bake; integers are texel centres
    std::optional<glm::dvec2> packed(const glm::dvec2& texel) const;

    /// Fails with ErrorCode::Verification, naming mesh and vertex, unless the UVs of the repacked mesh lie where its charts do.
    /// mesh  file of `after`, for errors
    /// size  of the repacked map [texels]
    formats::Result<void> check(const formats::GltfScene& before, const formats::GltfScene& after, const std::string& mesh,
                                const glm::ivec2& size) const;

private:
    ChartPlaces(atlas::ChartSet charts, std::span<const ChartPlace> places, const glm::ivec2& before);
    glm::dvec2 moved(std::size_t chart, const glm::dvec2& texel) const;
    std::uint32_t ownerOf(const glm::ivec2& quad) const;

    atlas::ChartSet charts_;
    std::vector<ChartPlace> places_;
    glm::ivec2 before_;
    formats::Image<std::uint32_t> owners_;  ///< chart of each quad, from quad (-1, -1) on
};

/// Return places as parameters of an action have them, four numbers a chart, and back.
std::vector<int> numbersOf(std::span<const ChartPlace> places);
std::vector<ChartPlace> placesOf(std::span<const int> numbers);

}  // namespace lightcook::pipeline

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
#include "pipeline/assets/light_map/unpacked_bake.h"

namespace lightcook::pipeline {

/// Place of a chart in the repacked map.
struct ChartPlace {
    glm::ivec2 step{1};   ///< texels of the bake for each texel, on each axis
    glm::ivec2 texel{0};  ///< its first texel
    bool operator==(const ChartPlace&) const = default;
};

/// Maps places of a bake to those of the repacked bake, chart by chart.
class ChartPlaces {
public:
    /// Finds the charts of the mesh as it was. Fails with ErrorCode::Verification where it has other charts than the record says.
    /// mesh  its file, for errors
    static formats::Result<ChartPlaces> create(const formats::GltfScene& scene, const formats::Subject& mesh, const UnpackedBake& bake);

    /// Returns the place in the repacked map. Empty where no triangle comes near.
    /// texel  place in the bake; integers are texel centres
    std::optional<glm::dvec2> packed(const glm::dvec2& texel) const;

    /// Fails with ErrorCode::Verification, naming mesh and vertex, unless the UVs of the repacked mesh lie where its charts do.
    /// before  as create() had it
    /// mesh    file of `after`, for errors
    /// size    of the repacked map [texels]
    formats::Result<void> check(const formats::GltfScene& before, const formats::GltfScene& after, const formats::Subject& mesh,
                                const glm::ivec2& size) const;

private:
    ChartPlaces(atlas::ChartSet charts, std::vector<ChartPlace> places, const glm::ivec2& before);
    glm::dvec2 moved(std::size_t chart, const glm::dvec2& texel) const;
    std::uint32_t chartAt(const glm::dvec2& texel) const;

    atlas::ChartSet charts_;
    std::vector<ChartPlace> places_;  ///< [chart]
    glm::ivec2 before_;
    formats::Image<std::uint32_t> owners_;  ///< chart of each quad, from quad (-1, -1) on
};

/// Return places as parameters of an action have them, four numbers a chart, and back.
std::vector<int> numbersOf(std::span<const ChartPlace> places);
std::vector<ChartPlace> placesOf(std::span<const int> numbers);

}  // namespace lightcook::pipeline

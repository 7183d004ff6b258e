// The charts of a light map: the parts of the map that triangles use, which can be moved and resized apart from each other.
//
// "Chart" means here a connected piece of the meshes in UV space. Two other modules find charts without meshes: atlas::findMipCharts()
// (mips.h) as covered texels that touch, compress::LightMapBlocks::chartOfBlock() as covered texels that touch or share a 4 x 4 block.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "formats/chart_clusters.h"
#include "formats/error.h"

namespace lightcook::atlas {

/// A quad is the square between the centres of 2 x 2 neighbouring texels, in which a bilinear filter reads these four. It is named by its
/// upper left texel; beside the map's border that is texel -1, which a sampler clamps to 0.
struct Chart {
    glm::ivec2 first{0};                     ///< lowest quad
    glm::ivec2 quads{0};                     ///< size of the box around the quads that triangles reach
    std::vector<std::uint8_t> reached = {};  ///< 1 for quads that a triangle reaches, row by row
    std::size_t mesh = 0, triangle = 0;      ///< the first triangle, for messages

    bool reaches(int x, int y) const {
        return reached[static_cast<std::size_t>(y) * static_cast<std::size_t>(quads.x) + static_cast<std::size_t>(x)] != 0;
    }
    glm::ivec2 texels() const { return quads + 1; }  ///< size of the box around the texels that a filter reads
};

struct ChartSet {
    std::vector<Chart> charts;  ///< in the order of their first triangles
    /// Index of the chart of each vertex of each mesh; kNoChart for vertices that no triangle uses.
    std::vector<std::vector<std::uint32_t>> ofVertex;
    static constexpr std::uint32_t kNoChart = UINT32_MAX;
};

/// Largest error of a light-map UV as a place [texels]: samplers round places to 1/256 of a texel, and UVs are floats.
inline constexpr double kPlaceRounding = 1.0 / 128;

/// Finds the charts of a map of width x height texels from the light-map UVs (TEXCOORD_1) of its meshes. Triangles that share a vertex or
/// reach the same quad are of one chart: where bakers overlap or abut charts, these move together.
/// Fails with ErrorCode::WrongShape, naming mesh and triangle, for a mesh without light-map UVs and for UVs outside [0, 1].
/// names  of the meshes, for errors
formats::Result<ChartSet> findCharts(std::span<const formats::TriangleMesh* const> meshes, std::span<const formats::Subject> names,
                                     int width, int height);

}  // namespace lightcook::atlas

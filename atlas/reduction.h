// Charts at fewer texels: the lowest resolution at which the filtered light stays within a limit of visible error.
//
// Texels of a reduced chart lie on every step-th texel of the bake, on each axis. Each quad of the bake then lies inside one quad of the
// reduced chart. Both lights are bilinear in it, so their difference is largest at its corners: texel centres are enough as samples.
#pragma once

#include <atomic>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "atlas/charts.h"
#include "formats/image.h"
#include "lighting/display.h"
#include "lighting/sh.h"

namespace lightcook::atlas {

/// A light map in memory: incident radiance in canonical form (formats/light_map.h).
struct MapView {
    formats::ImageView<const lighting::ShRgb> sh;
    formats::ImageView<const std::uint8_t> covered;  ///< 1 inside charts
    formats::ImageView<const glm::vec3> normal;      ///< unit
};

struct ReductionLimit {
    /// Largest visible error of 99 % of a chart's samples [Delta E ITP]; 0 keeps every texel. The rel_rms of a chart's exit radiance is
    /// limited too, to kRelRmsPerVisible times as much: light above the display's white has no visible error.
    double maxVisible = 1;
    static constexpr double kRelRmsPerVisible = 0.01;
    lighting::Display display;
    glm::dmat3 bt2020FromWorking = lighting::bt2020FromRec709();
    glm::vec3 luminanceWeights = lighting::kRec709Luminance;
};

/// A chart at its lowest resolution.
struct ReducedChart {
    glm::ivec2 step{1};  ///< texels of the bake for each texel, on each axis: powers of two
    formats::Image<lighting::ShRgb> sh = {};
    formats::Image<std::uint8_t> covered = {};
    formats::Image<glm::vec3> normal = {};
    formats::Image<std::uint8_t> isRead = {};  ///< 1 for texels that a filter inside a triangle reads
    /// Visible error of exit radiance of a white surface, kNormals for each sample. Samples are covered texels of the bake and, at rims,
    /// the middles of quads with covered and uncovered corners, where the reference is the mean of the covered ones.
    std::vector<float> visible = {};
    std::int64_t readBefore = 0;                ///< texels of the bake that filters read
    double squaredError = 0, squaredLight = 0;  ///< of exit radiance, summed over the same samples
    static constexpr int kNormals = 5;          ///< the texel's own, and four that lie 45 degrees from it
};

/// Returns a chart at its lowest resolution. While the limit holds, halves the resolution of one axis at a time: of the one with the
/// smaller error. A chart without covered texels keeps its resolution. The texels of a reduced chart minimise the squared error of the
/// samples, weighted by the inverse square of their luminance on the display (conjugate gradients). Coefficients that no light can have
/// are clamped: a negative sh00, and bands much longer than those of a single direction.
/// interrupted  ends the search when it becomes true; the result is then incomplete
ReducedChart reduceChart(const Chart& chart, const MapView& map, const ReductionLimit& limit, const std::atomic<bool>& interrupted);

}  // namespace lightcook::atlas

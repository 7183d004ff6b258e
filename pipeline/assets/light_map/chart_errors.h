// Visible errors of a light map by chart: which part of the atlas takes how much memory, and how far off it is.
//
// Charts are those of atlas::findCharts, from the light-map UVs of the map's mesh. A covered texel belongs to the chart that reaches the
// quad below and to the right of it, as every triangle does that holds the texel's centre; a texel at a rim, whose centre lies beside all
// triangles, belongs to a chart that reaches another quad around it. Its error is that at the texel's own normal.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "atlas/charts.h"
#include "formats/gltf_scene.h"
#include "formats/image.h"
#include "pipeline/assets/chart_figures.h"
#include "verify/visible.h"

namespace lightcook::pipeline {

/// Returns the meshes of a scene that nodes draw and that have light-map UVs, each once.
std::vector<const formats::TriangleMesh*> lightMapMeshes(const formats::GltfScene& scene);

/// The charts of a light map. The largest have errors of their own, the others one together.
class MapCharts {
public:
    static constexpr std::size_t kMostOwn = 60;
    /// Largest map whose charts are told apart [texels]: finding them takes four bytes a texel for a while.
    static constexpr std::int64_t kMostTexels = std::int64_t{4096} * 4096;
    static constexpr std::uint8_t kNoGroup = 255;

    /// Returns nothing without meshes, for a map that is too large, and for light-map UVs outside [0, 1], which lint reports.
    /// meshes  with TEXCOORD_1
    static std::optional<MapCharts> of(std::span<const formats::TriangleMesh* const> meshes, int width, int height);

    /// Returns the group of each texel of rows [firstRow, firstRow + rowCount); kNoGroup for texels of no chart.
    formats::Image<std::uint8_t> groupsOf(int firstRow, int rowCount) const;
    std::size_t groupCount() const { return own_.size() + 1; }  ///< the last is that of the charts without one of their own
    const std::vector<atlas::Chart>& charts() const { return charts_; }
    /// Returns the index of the chart that has a group of its own.
    std::size_t chartOf(std::size_t group) const { return own_[group]; }

private:
    int width_ = 0;
    std::vector<atlas::Chart> charts_;
    std::vector<std::size_t> own_;     ///< [group], largest chart first
    std::vector<std::uint8_t> group_;  ///< [chart]
};

/// Visible errors of some rows of a map, by group of charts.
class ChartErrors {
public:
    /// Adds a covered texel, and does nothing for one of no chart.
    void add(std::uint8_t group, int x, int y, float visible);
    /// Merge strips in a fixed order for reproducible bits.
    void merge(const ChartErrors& other);
    /// bytes      GPU memory of the whole map
    /// mapTexels  its width times height
    ChartSummary summary(const MapCharts& charts, std::uint64_t bytes, std::int64_t mapTexels) const;

    template <class Archive, class Self>
    static void members(Archive& archive, Self& self) {
        archive(self.errors_);
    }

private:
    std::map<std::size_t, verify::VisibleAccumulator> errors_;  ///< [group], those that occur
};

}  // namespace lightcook::pipeline

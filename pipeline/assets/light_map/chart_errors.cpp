#include "pipeline/assets/light_map/chart_errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "pipeline/assets/light_map/checked_light_map.h"

namespace lightcook::pipeline {
namespace {

/// Returns the number of quads that a chart reaches.
std::ptrdiff_t quadCount(const atlas::Chart& chart) {
    return std::ranges::count(chart.reached, std::uint8_t{1});
}

}  // namespace

std::vector<const formats::TriangleMesh*> lightMapMeshes(const formats::GltfScene& scene) {
    std::vector<const formats::TriangleMesh*> meshes;
    for (const formats::GltfScene::Placed& placed : scene.placedMeshes())
        if (placed.mesh->find("TEXCOORD_1") != nullptr && std::ranges::find(meshes, placed.mesh) == meshes.end())
            meshes.push_back(placed.mesh);
    return meshes;
}

std::optional<MapCharts> MapCharts::of(std::span<const formats::TriangleMesh* const> meshes, int width, int height) {
    if (meshes.empty() || std::int64_t{width} * height > kMostTexels) return std::nullopt;
    const std::vector<formats::Subject> names(meshes.size(), "");  // of errors, which nobody reads
    auto found = atlas::findCharts(meshes, names, width, height);
    if (!found || found->charts.empty()) return std::nullopt;
    MapCharts charts;
    charts.width_ = width;
    charts.charts_ = std::move(found->charts);
    const std::size_t count = charts.charts_.size();
    std::vector<std::ptrdiff_t> quads;
    for (const atlas::Chart& chart : charts.charts_) quads.push_back(quadCount(chart));
    charts.own_.resize(count);
    std::iota(charts.own_.begin(), charts.own_.end(), std::size_t{0});
    std::ranges::stable_sort(charts.own_, [&](std::size_t a, std::size_t b) { return quads[a] > quads[b]; });
    charts.own_.resize(std::min(count, kMostOwn));
    charts.group_.assign(count, static_cast<std::uint8_t>(charts.own_.size()));
    for (std::size_t group = 0; group < charts.own_.size(); ++group) charts.group_[charts.own_[group]] = static_cast<std::uint8_t>(group);
    return charts;
}

formats::Image<std::uint8_t> MapCharts::groupsOf(int firstRow, int rowCount) const {
    formats::Image<std::uint8_t> groups(width_, rowCount, kNoGroup);
    // The quad that begins at a texel first: all others only where no chart reaches that one.
    constexpr std::array<std::array<int, 2>, 4> kQuads = {{{0, 0}, {-1, 0}, {0, -1}, {-1, -1}}};
    for (const auto& [left, up] : kQuads)
        for (std::size_t index = 0; index < charts_.size(); ++index) {
            const atlas::Chart& chart = charts_[index];
            const int begin = std::max(chart.first.y - up, firstRow),
                      end = std::min(chart.first.y + chart.quads.y - up, firstRow + rowCount);
            for (int y = begin; y < end; ++y)
                for (int quad = 0; quad < chart.quads.x; ++quad) {
                    const int x = chart.first.x + quad - left;
                    if (x < 0 || x >= width_ || !chart.reaches(quad, y + up - chart.first.y)) continue;
                    if (std::uint8_t& group = groups.at(x, y - firstRow); group == kNoGroup) group = group_[index];
                }
        }
    return groups;
}

void ChartErrors::add(std::uint8_t group, int x, int y, float visible) {
    if (group == MapCharts::kNoGroup) return;
    verify::VisibleAccumulator& errors = errors_[group];
    const bool isFirst = errors.sampleCount() == 0;
    if (const double before = errors.largest(); errors.add({&visible, 1}), isFirst || errors.largest() > before) {
        verify::VisiblePlace at;
        at.x = x;
        at.y = y;
        errors.setMaxAt(at);
    }
}

void ChartErrors::merge(const ChartErrors& other) {
    for (const auto& [group, errors] : other.errors_) {
        const auto [mine, isNew] = errors_.try_emplace(group, errors);
        if (!isNew) mine->second.merge(errors);
    }
}

ChartSummary ChartErrors::summary(const MapCharts& charts, std::uint64_t bytes, std::int64_t mapTexels) const {
    ChartSummary summary;
    summary.count = static_cast<std::int64_t>(charts.charts().size());
    for (const auto& [group, errors] : errors_) {
        const verify::VisibleFigures figures = errors.figures();
        ChartFigures made;
        made.texels = errors.sampleCount();
        made.bytes = static_cast<std::uint64_t>(
            std::llround(static_cast<double>(bytes) * static_cast<double>(made.texels) / static_cast<double>(mapTexels)));
        made.visibleRms = figures.rms;
        made.visibleP99 = figures.p99;
        made.visibleMax = figures.max;
        made.worst = {static_cast<int>(figures.maxAt.x), static_cast<int>(figures.maxAt.y)};
        if (group + 1 == charts.groupCount()) {
            summary.rest = made;
            continue;
        }
        const std::size_t index = charts.chartOf(group);
        const atlas::Chart& chart = charts.charts()[index];
        made.number = static_cast<std::int64_t>(index) + 1;
        const glm::ivec2 first = glm::max(chart.first, glm::ivec2(0)), size = chart.first + chart.texels() - first;
        made.first = {first.x, first.y};
        made.size = {size.x, size.y};
        summary.largest.push_back(made);
    }
    std::ranges::stable_sort(summary.largest, std::ranges::greater{}, &ChartFigures::texels);
    return summary;
}

formats::Result<void> checkCharts(CheckedLightMap& map) {
    const std::int64_t mapTexels = std::int64_t{map.bake.width()} * map.bake.height();
    map.result.charts = map.texels.shown.charts.summary(*map.charts, map.asset.totalBytesGpu(), mapTexels);
    return {};
}

}  // namespace lightcook::pipeline

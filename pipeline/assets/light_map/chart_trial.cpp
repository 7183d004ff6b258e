#include "pipeline/assets/light_map/chart_trial.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace lightcook::pipeline {
namespace {

using atlas::Chart;
using atlas::ChartSet;

/// Calls visit(x, y, quad) for each texel of the map that a filter inside a quad of the chart reads, with the quad's place in the chart.
/// Texels come up to four times.
template <class Visit>
void forEachRead(const Chart& chart, const glm::ivec2& size, Visit visit) {
    for (int y = 0; y < chart.quads.y; ++y)
        for (int x = 0; x < chart.quads.x; ++x)
            for (int corner = 0; chart.reaches(x, y) && corner < 4; ++corner) {
                const glm::ivec2 at = chart.first + glm::ivec2(x + corner % 2, y + corner / 2);
                if (at.x >= 0 && at.y >= 0 && at.x < size.x && at.y < size.y) visit(at.x, at.y, glm::ivec2(x, y));
            }
}

/// The texels of a tile.
struct TileTexels {
    std::int64_t count = 0;
    int firstRow = std::numeric_limits<int>::max(), rowsEnd = 0;
};

/// Sets the tile of each texel that triangles read, and returns what each tile reads.
std::vector<TileTexels> readTiles(const std::vector<Chart>& charts, const PackedTiles& packed, formats::Image<std::uint32_t>& tileOf) {
    const glm::ivec2 size(tileOf.width(), tileOf.height());
    for (std::size_t i = 0; i < charts.size(); ++i)
        forEachRead(charts[i], size, [&](int x, int y, const glm::ivec2& quad) {
            tileOf.at(x, y) = static_cast<std::uint32_t>(packed.tiles.ofQuad(i, packed.firsts[i] + quad * packed.steps[i]));
        });
    std::vector<TileTexels> tiles(static_cast<std::size_t>(packed.tiles.count()));
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            if (tileOf.at(x, y) == ChartSet::kNoChart) continue;
            TileTexels& texels = tiles[tileOf.at(x, y)];
            ++texels.count;
            texels.firstRow = std::min(texels.firstRow, y);
            texels.rowsEnd = y + 1;
        }
    return tiles;
}

ChartSamples::Light samplesOf(const verify::ErrorAccumulator& errors, const verify::VisibleAccumulator& visible, double maxVisible) {
    const double light = errors.referenceRms(), relRms = errors.figures().relRms, squares = light * light;
    const auto count = static_cast<double>(errors.sampleCount());
    return {visible.sampleCount(), visible.countAbove(maxVisible), relRms * relRms * squares * count, squares * count};
}

/// Returns a strip like another, with texels of its own.
formats::LightMapStrip copyOf(const formats::LightMapStrip& strip) {
    formats::LightMapStrip copy;
    copy.firstRow = strip.firstRow;
    copy.sh = strip.sh.copy();
    copy.covered = strip.covered.copy();
    copy.normal = strip.normal.copy();
    copy.chart = strip.chart.copy();
    return copy;
}

}  // namespace

void ChartSamples::Light::add(const Light& other) {
    count += other.count;
    above += other.above;
    squaredError += other.squaredError;
    squaredLight += other.squaredLight;
}

void ChartSamples::add(const ChartSamples& other) {
    diffuse.add(other.diffuse);
    specular.add(other.specular);
}

ChartTrial::ChartTrial(const std::vector<Chart>& charts, const PackedTiles& packed, int width, int height, double maxVisible)
    : groupOf_(width, height, ChartSet::kNoChart), maxVisible_(maxVisible) {
    const std::vector<TileTexels> tiles = readTiles(charts, packed, groupOf_);
    std::vector<std::uint32_t> groupOfTile(tiles.size(), ChartSet::kNoChart);
    const auto addTo = [&](TileGroup& group, int tile) {
        const TileTexels& texels = tiles[static_cast<std::size_t>(tile)];
        if (texels.count == 0) return;
        group.firstRow = group.tiles.empty() ? texels.firstRow : std::min(group.firstRow, texels.firstRow);
        group.rowsEnd = std::max(group.rowsEnd, texels.rowsEnd);
        group.texels += texels.count;
        group.tiles.push_back(tile);
    };
    const auto finish = [&](TileGroup& group) {
        if (group.tiles.empty()) return;
        std::ranges::sort(group.tiles);
        for (const int tile : group.tiles) groupOfTile[static_cast<std::size_t>(tile)] = static_cast<std::uint32_t>(groups_.size());
        groups_.push_back(std::exchange(group, {}));
    };
    std::vector<TileGroup> small;  // whole charts
    for (std::size_t i = 0; i < charts.size(); ++i) {
        const glm::ivec2 grid = packed.tiles.gridOf(i);
        const int first = packed.tiles.at(i, {0, 0}), end = first + grid.x * grid.y;
        TileGroup whole;
        for (int tile = first; tile < end; ++tile) addTo(whole, tile);
        if (whole.texels < kLeastTexels) {
            small.push_back(std::move(whole));
            continue;
        }
        TileGroup littleTiles;
        for (int tile = first; tile < end; ++tile) {
            TileGroup alone;
            addTo(alone, tile);
            if (alone.texels >= kLeastTexelsOfTiles)
                finish(alone);
            else
                addTo(littleTiles, tile);
            if (littleTiles.texels >= kLeastTexelsOfTiles) finish(littleTiles);
        }
        finish(littleTiles);
    }
    std::ranges::stable_sort(small, {}, &TileGroup::firstRow);
    TileGroup together;
    for (const TileGroup& chart : small) {
        for (const int tile : chart.tiles) addTo(together, tile);
        if (together.texels >= kLeastTexels) finish(together);
    }
    finish(together);
    for (std::uint32_t& texel : groupOf_.texels())
        if (texel != ChartSet::kNoChart) texel = groupOfTile[texel];
}

std::vector<std::vector<ChartSamples>> ChartTrial::measure(const verify::LightMapVerifier& verifier,
                                                           const verify::DecodedLightMapRows& texels,
                                                           const formats::LightMapStrip& reference, int firstRow, int rowCount) const {
    std::vector<std::vector<ChartSamples>> samples(verifier.noErrors().stages.size(), std::vector<ChartSamples>(groups_.size()));
    formats::LightMapStrip ofGroup = copyOf(reference);
    for (std::size_t i = 0; i < groups_.size(); ++i) {
        const TileGroup& group = groups_[i];
        const int first = std::max(group.firstRow, firstRow), end = std::min(group.rowsEnd, firstRow + rowCount);
        if (first >= end) continue;
        for (int y = 0; y < ofGroup.covered.height(); ++y)
            for (int x = 0; x < ofGroup.covered.width(); ++x)
                ofGroup.covered.at(x, y) = groupOf_.at(x, reference.firstRow + y) == i ? reference.covered.at(x, y) : 0;
        const verify::LightMapErrors errors = verifier.verifyRows(texels, ofGroup, first, end - first);
        for (std::size_t stage = 0; stage < samples.size(); ++stage) {
            const verify::ShadedErrors& shaded = errors.stages[stage].errors;
            samples[stage][i] = {samplesOf(shaded.diffuse, shaded.visibleDiffuse, maxVisible_),
                                 samplesOf(shaded.specular, shaded.visibleSpecular, maxVisible_)};
        }
    }
    return samples;
}

}  // namespace lightcook::pipeline

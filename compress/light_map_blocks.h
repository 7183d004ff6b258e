// A light map by its 4 x 4 blocks: which texels are covered and how much light they hold, which chart a block belongs to, and a sample of
// blocks to learn from. Ten bytes a block: a 16384 x 16384 map takes 160 MiB, whatever it holds.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "compress/light_map.h"
#include "formats/chart_clusters.h"
#include "formats/light_map.h"

namespace lightcook::compress {

/// Texels of a side of the blocks that charts are told apart by.
inline constexpr int kChartBlock = formats::kClusterBlock;

class LightMapBlocks {
public:
    LightMapBlocks() = default;
    /// [texels]
    LightMapBlocks(int width, int height);
    /// Rows [firstRow, firstRow + rowCount) of the map, whole blocks but at its end, which the band must hold. Different rows may be added
    /// from several threads.
    void add(const formats::LightMapStrip& band, int firstRow, int rowCount);

    int across() const { return across_; }
    int count() const { return static_cast<int>(covered_.size()); }
    /// A chart for each block, numbered in the order of their first blocks; -1 without covered texels. Covered texels that touch, by a
    /// corner too, and texels of one block are one chart: no filter reaches from one into another.
    /// islands  of meshes that read the map: all blocks that one holds texel centres of, and all covered texels that it is filtered from,
    ///          are one chart, however narrow what joins them. Blocks of texel centres have a chart although nothing in them is covered.
    std::vector<int> charts(std::span<const formats::IslandRun> islands = {}) const;
    /// About `budget` blocks, ascending: a quarter of them by covered area, a quarter by light, half by charts, each after the root of its
    /// light; at least one of every chart, spread evenly over it. charts: of this map
    struct Choice {
        int block;
        float weight;  ///< how many blocks this one stands for
    };
    std::vector<Choice> choose(const std::vector<int>& charts, int budget) const;

private:
    /// Calls visit(block) for blocks of a run: with a covered texel in it, or all where their centres lie inside the island.
    template <class Visit>
    void forEachBlock(const formats::IslandRun& run, Visit visit) const;

    int across_ = 0, width_ = 0, height_ = 0;
    std::vector<std::uint16_t> covered_;  ///< bit 4 y + x
    std::vector<double> light_;           ///< sum of squared coefficient 0
};

/// Chosen blocks with their surroundings, side by side in a band of their own: what lies beside a block's texels decides how it is padded.
class LightMapSamples {
public:
    LightMapSamples() = default;
    LightMapSamples(std::vector<LightMapBlocks::Choice> choices, int across);
    /// Takes the chosen blocks of rows [firstRow, firstRow + rowCount) of the map, whole blocks but at its end. The band must hold those
    /// rows and kLightMapPaddingRows more on either side where the map has them. Different rows may be added from several threads.
    void add(const formats::LightMapStrip& band, int firstRow, int rowCount);

    const std::vector<LightMapBlocks::Choice>& choices() const { return choices_; }
    /// kSide rows; the texels of choice i are rows and columns [kMargin, kMargin + kChartBlock) of its columns, kSide i and on.
    const formats::LightMapStrip& texels() const { return texels_; }
    static constexpr int kMargin = kLightMapPaddingRows, kSide = kChartBlock + 2 * kMargin;

private:
    int across_ = 0;
    std::vector<LightMapBlocks::Choice> choices_;
    formats::LightMapStrip texels_;
};

}  // namespace lightcook::compress

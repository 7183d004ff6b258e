// Charts of a light map split between two or three maps, so that the places which need a fine layout do not make all others take it.
//
// Along the edge of a shadow a learned layout may be far off where its error is invisible elsewhere. One layout for the map is the one that
// its worst places need.
//   1. The trial measures every layout on every tile of the charts (atlas/tiles.h). Small tiles are measured in groups (tile_groups.h).
//   2. For each coarse layout, tiles are sorted by what they exceed their share of the limits by, per texel; the largest excess first.
//   3. Tiles are moved to the fine map in that order, until the rest keeps the limits with the coarse layout and the moved tiles keep them
//      with a finer one: the fewest tiles for each pair of a coarse and a fine layout. With more, the fine layout only takes more bits.
//   4. The pair with the fewest bits is the split, if it saves at least kLeastSplitSaving.
//   5. For three maps, the tiles moved from the coarsest layout are divided between two layouts in the same way, for several numbers of
//      them: with more tiles than the first layout has to lose, the second one has fewer errors in the mean. A third map has to save as
//      much as the second.
// This is repeated for each of kSplitShares, and with whole charts in place of tiles: they need no texels beside a cut. The cook tries and
// cooks each of the maps as any other.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pipeline/assets/light_map/trial.h"
#include "pipeline/graph/action.h"
#include "pipeline/limits/limits.h"
#include "pipeline/scene/chart_settings.h"

namespace lightcook::pipeline {

/// Limits that each of the maps keeps.
struct SplitLimits {
    double maxError = 0;               ///< on rel_rms
    std::optional<double> maxVisible;  ///< on the 99th percentile of visible errors
    double share = 1;                  ///< part of each limit that the choice uses
};

/// The groups of tiles of one map.
struct SplitPart {
    std::string layout;  ///< that the choice expects
    std::vector<std::size_t> groups;
};

struct ChartSplit {
    std::vector<SplitPart> parts;    ///< the one with the coarsest layout first; one part: no split takes fewer bits
    double bits = 0, bitsOfOne = 0;  ///< of a texel in the mean, and with one layout for all charts
};

/// Least part of the bits that a further map has to save: it has borders of blocks and tables of its own.
inline constexpr double kLeastSplitSaving = 0.03;
/// Shares of the limits that are tried, one after the other: learned layouts are fitted anew to the charts of each map, and blocks at rims
/// differ.
inline constexpr std::array kSplitShares = {1.0, 0.9, 0.75, 0.5};

/// Side of the tiles that charts are cut into [texels].
inline constexpr int kTileSide = 32;
/// Texels of a finer map for each texel of its tiles: filters read a texel beyond a cut, and charts begin at corners of blocks.
inline constexpr double kTilePadding = 1.2;

/// Chooses the split of least bits.
/// candidates  layouts that may be chosen
/// texels      of each group
/// padding     texels of a finer map for each texel of its groups
/// mostMaps    2 or 3
ChartSplit chooseSplit(std::span<const CandidateByGroup> candidates, std::span<const std::int64_t> texels, const SplitLimits& limits,
                       double padding, std::size_t mostMaps);

/// Parameters of action "split-charts". Its inputs are "source" and "mesh": a map and its mesh whose charts were packed.
struct SplitParameters {
    TrialParameters trial;
    Limits limits;
    std::vector<int> places = {}, boxes = {};  ///< of the charts, as PackResult has them
};
template <class Fields, Is<SplitParameters> Self>
void describe(Fields& fields, Self& parameters) {
    fields.required("trial", parameters.trial, "trial of the light map");
    describe(fields, parameters.limits, {Limit::Error, Limit::Visible});
    fields.required("places", parameters.places, "places of the charts");
    fields.required("boxes", parameters.boxes, "boxes of the charts in the bake");
}

/// One of the maps of a split.
struct SplitMap {
    std::string layout;      ///< that the choice expects
    std::vector<int> tiles;  ///< see ChartPart
    double share = 0;        ///< part of the texels that it has
};
template <class Fields, Is<SplitMap> Self>
void describe(Fields& fields, Self& map) {
    fields.required("layout", map.layout, "expected layout");
    fields.required("tiles", map.tiles, "tiles of the map");
    fields.required("share", map.share, "part of the texels that it has");
}

/// A split with the tiles of its maps.
struct TriedSplit {
    int tileSide = 0;                ///< see ChartPart
    std::vector<SplitMap> maps;      ///< the coarsest first
    double bits = 0, bitsOfOne = 0;  ///< see ChartSplit
};
template <class Fields, Is<TriedSplit> Self>
void describe(Fields& fields, Self& split) {
    fields.required("tile_side", split.tileSide, "side of the tiles [texels]; 0: whole charts");
    fields.required("maps", split.maps, "maps, the coarsest first");
    fields.required("bits", split.bits, "expected memory of a texel [bits]");
    fields.required("bits_of_one", split.bitsOfOne, "that of one map [bits]");
}

struct SplitResult {
    std::vector<TriedSplit> splits;  ///< those that are expected to take fewer bits than one map, the smallest first
    double displayKey = 0;           ///< of all charts (verify::LightMapKey): its maps are shown on the display of the whole
    TrialResult one;                 ///< the trial of one map with all charts
};
template <class Fields, Is<SplitResult> Self>
void describe(Fields& fields, Self& result) {
    fields.required("splits", result.splits, "splits to try");
    fields.required("display_key", result.displayKey, "key of the whole map, for the display");
    fields.required("one", result.one, "layouts of one map with all charts");
}

/// Tries every layout on every tile and chooses splits.
formats::Result<ActionOutcome> splitCharts(const ActionContext& context);

}  // namespace lightcook::pipeline

// Errors of a trial by tile: how far off each part of a light map is under each layout, so that parts can be given layouts of their own.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "atlas/charts.h"
#include "atlas/tiles.h"
#include "formats/image.h"
#include "formats/light_map.h"
#include "verify/light_map.h"

namespace lightcook::pipeline {

/// Samples of shaded light on some tiles, under one layout.
struct ChartSamples {
    struct Light {
        std::int64_t count = 0;  ///< samples
        std::int64_t above = 0;  ///< samples whose visible error is above the limit of the trial
        double squaredError = 0, squaredLight = 0;

        void add(const Light& other);
    };
    Light diffuse, specular;

    void add(const ChartSamples& other);
};

/// Maps quads of a packed map to tiles of the bake that it was packed from.
struct PackedTiles {
    const atlas::Tiles& tiles;
    std::vector<glm::ivec2> firsts = {};  ///< quad of the bake at which the first packed quad of each chart begins
    std::vector<glm::ivec2> steps = {};   ///< texels of the bake for each texel of the packed chart, on each axis
};

/// Tiles that get one layout: a large one, or small ones that lie near each other.
struct TileGroup {
    std::vector<int> tiles;         ///< ascending
    std::int64_t texels = 0;        ///< that filters read
    int firstRow = 0, rowsEnd = 0;  ///< rows of these texels
};

class ChartTrial {
public:
    /// Charts with fewer texels form groups of at least this many.
    static constexpr std::int64_t kLeastTexels = 1024;
    /// Small tiles of a larger chart form groups of at least this many texels. The last group of a chart may have fewer.
    static constexpr std::int64_t kLeastTexelsOfTiles = 256;

    /// charts      of the light map's mesh
    /// maxVisible  limit that samples are counted above
    ChartTrial(const std::vector<atlas::Chart>& charts, const PackedTiles& tiles, int width, int height, double maxVisible);
    const std::vector<TileGroup>& groups() const { return groups_; }
    /// Returns the samples of rows [firstRow, firstRow + rowCount), by stage of the layout and group. Texels and reference as
    /// verify::LightMapVerifier::verifyRows takes them. Pure; safe to call from several threads.
    std::vector<std::vector<ChartSamples>> measure(const verify::LightMapVerifier& verifier, const verify::DecodedLightMapRows& texels,
                                                   const formats::LightMapStrip& reference, int firstRow, int rowCount) const;

private:
    std::vector<TileGroup> groups_;
    formats::Image<std::uint32_t> groupOf_;  ///< of each texel; kNoChart of atlas::ChartSet: of none
    double maxVisible_;
};

}  // namespace lightcook::pipeline

// Law on the texels beside the charts of a dominant light, which a filter on a surface reads too. They are compared with nothing else.
//
// A light counts as three vectors, one a channel: intensity times direction. At the edge of a covered texel, towards one that is not
// covered, the filtered light is compared with the lights of all covered texels next to the one outside, as they were cooked: the nearest
// of them gives the error, by the weight of the texel outside, the brightest of them the scale. So black padding errs, and so do padding
// that is too bright and padding of another direction.
//
// The encoder is free outside charts, and correct cooks have single texels, and even tiles, that miss all light there. So the law is on the
// median of the tiles that have light: padding that is wrong all over the map. docs/lab/experiments.md has the figures.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "pipeline/assets/dominant/cooked_dominant.h"
#include "pipeline/assets/light_map/source.h"
#include "verify/violation.h"

namespace lightcook::pipeline {

/// Errors at the rims of some rows of a dominant light.
class DominantRimErrors {
public:
    static constexpr int kTile = 8;                ///< side of a tile [texels of the textures]
    static constexpr std::size_t kLeastTiles = 8;  ///< fewer say nothing of a map

    /// Adds the rims of rows [firstRow, firstRow + rowCount) of the light map.
    /// key  of the map
    formats::Result<void> add(LightMapSource& bake, const CookedDominantReader& cooked, const verify::DominantVerifier& verifier,
                              double key, int firstRow, int rowCount);
    void merge(const DominantRimErrors& other);
    /// Returns the error over the light beside it, from 0 to 1, at the median of the tiles whose light is not dark; none: there are few
    /// such tiles.
    std::optional<double> median() const;
    /// Adds a violation if that is over its limit.
    void check(std::vector<verify::Violation>& violations) const;

private:
    /// Sums over the places of a tile.
    struct Mismatch {
        double error = 0;  ///< by the weight of the texel outside in the filter, at most the light
        double light = 0;  ///< of the brightest covered texel next to it
        double dark = 0;   ///< light that counts as dark
    };
    std::map<std::pair<int, int>, Mismatch> tiles_;  ///< by (y, x) of the tile's first texel
};

}  // namespace lightcook::pipeline

// Law on the texels beside charts, which a filter on a surface reads too. Random places of the surface often miss a single wrong texel
// there. The law has two parts:
//   1. No block may err by more than a limit, relative to the brightest texel of the chart beside it. It finds texels that are too bright.
//   2. No tile of rims may lose more than a share of its light. It finds texels that are too dark, such as black padding. A filter shows
//      half of what such a texel lacks. Correct cooks err by as much at single texels, so the share is a mean over the tile.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/assets/light_map/cooked_light_map.h"
#include "verify/block_errors.h"
#include "verify/violation.h"

namespace lightcook::pipeline {

/// Errors at the rims of some rows of a map.
class RimErrors {
public:
    static constexpr int kTile = 8;  ///< side of a tile [texels]

    /// Takes the errors of rows [firstRow, firstRow + rowCount) of a map of this width [texels]; 0 rows for a sum of parts.
    explicit RimErrors(int width, int rowCount = 0, int firstRow = 0) : blocks_(width, rowCount, firstRow) {}
    /// Adds the rims of a strip.
    /// key  of the map
    formats::Result<void> add(LightMapSource& bake, const CookedLightMapReader& cooked, const CookedStrip& strip, bool isFlat, double key);
    void merge(const RimErrors& other);
    /// Adds a violation for the worst block and one for the darkest tile, where they are over their limits.
    /// image  prefix of the place: "mip 1, "
    void check(const std::string& image, double maxError, std::vector<verify::Violation>& violations) const;

private:
    /// Shares of the light beside them that texels outside charts lack, from 0 to 1.
    struct Losses {
        double sum = 0;
        int places = 0;
    };
    void addErrors(const std::vector<verify::RimPlace>& places, const formats::LightMapStrip& around, const CookedStrip& strip, bool isFlat,
                   double key);
    void addLosses(const std::vector<verify::RimPlace>& places, const formats::LightMapStrip& around, double key);

    verify::BlockErrors blocks_;                       ///< of each block the place that errs most
    std::map<std::pair<int, int>, Losses> darkTiles_;  ///< by (y, x) of the tile's first texel
};

}  // namespace lightcook::pipeline

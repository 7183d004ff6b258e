// Law on the texels beside charts, which a filter on a surface reads too. Random places of the surface often miss a single wrong texel
// there. At the rim of a chart
//   - light may be off by no more than the texels of the chart beside it explain: a texel outside that is far too bright;
//   - light may not be lost: texels outside that are far too dark, such as black padding. Half of what they lack is seen, which is less
//   than
//     a correct cook may miss at a single texel, so that this is a mean over the rims of a tile.
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

    /// As verify::BlockErrors.
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

// Visible errors of a light map by 4 x 4 block. A block that lost its light is seen at once, but hardly changes a percentile over a whole
// map: 16 texels of 65536.
//
// The error of a texel is the largest at its own normal: at its centre and, beside a texel outside every chart, at the outermost places of
// its chart, where a filter weighs that texel most. The error of a block is the sum over its covered texels, divided by 16: a single texel
// that an encoder traded for the surface around it counts little, and so does light far below what the display shows.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "formats/image.h"
#include "pipeline/assets/light_map/cooked_light_map.h"
#include "pipeline/assets/results.h"
#include "pipeline/limits/limits.h"
#include "verify/violation.h"
#include "verify/visible.h"

namespace lightcook::pipeline {

/// Returns the largest error of a block that passes, in just noticeable differences: 100, or ten times max_visible, or 1000 times
/// max_error, or three times the 99th percentile of the map's visible errors, whichever is largest (docs/theory/error.md).
double allowedOfBlock(const Limits& limits, const verify::StageError& total);

/// Light at an outermost place of a chart that no texel beside it has: a texel outside charts outshines them.
struct RimGlare {
    double excess = 0;           ///< light above the reference, over the brightest covered texel beside the one outside
    std::array<int, 2> texel{};  ///< the covered texel: x and y

    void merge(const RimGlare& other) {
        if (other.excess > excess) *this = other;
    }
};

/// Errors of some rows of a map.
class VisibleBlocks {
public:
    static constexpr int kSize = 4;
    /// Rows of the bake above and below the rows of a strip that addRims() reads.
    static constexpr int kRowsAbove = 2, kRowsBelow = 3;

    /// Takes the texels of rows [firstRow, firstRow + rowCount) of a map of this width [texels], which begin with a row of blocks.
    VisibleBlocks(int width, int rowCount, int firstRow) : texels_(width, rowCount, -1), firstRow_(firstRow) {}
    /// Adds an error of a covered texel.
    void add(int x, int y, float visible);
    /// Adds the rims of charts, where texels outside them may be seen.
    /// key  of the map
    formats::Result<void> addRims(LightMapSource& bake, const CookedLightMapReader& cooked, const CookedStrip& strip,
                                  const verify::Viewing& viewing, double key);
    formats::ImageView<const float> texels() const { return texels_.view(); }  ///< negative: not covered
    int firstRow() const { return firstRow_; }
    const RimGlare& glare() const { return glare_; }

private:
    formats::Image<float> texels_;
    RimGlare glare_;
    int firstRow_;
};

/// The worst of all blocks of a map.
class WorstBlock {
public:
    void merge(const VisibleBlocks& rows);
    void merge(const WorstBlock& other);
    /// Adds a violation if the block errs by more than is allowed, and one for a texel outside charts that outshines them.
    /// image  prefix of the place: "mip 1, "
    /// total  errors of the map, or of the mip level
    void check(const std::string& image, const Limits& limits, const verify::StageError& total,
               std::vector<verify::Violation>& violations) const;
    BlockFigures figures() const { return figures_; }

private:
    BlockFigures figures_;
    RimGlare glare_;
};

}  // namespace lightcook::pipeline

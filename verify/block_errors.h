// The worst block of an image: figures over a whole map forgive one block that is all wrong, a player does not.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace lightcook::verify {

/// Sums of squared error and squared reference by 4 x 4 blocks, of an image or of some rows of it.
class BlockErrors {
public:
    static constexpr int kSize = 4;

    /// Rows [firstRow, firstRow + rowCount) of the image, whole blocks but at its end; none for one that only takes others in.
    BlockErrors(int width, int rowCount, int firstRow = 0);
    /// One texel of the image: squares of whatever is compared, summed over channels and coefficients.
    void add(int x, int y, double squaredError, double squaredReference);
    /// Takes in other rows of the same image. Of their blocks only those are kept that could still be the worst.
    void merge(const BlockErrors& rows);

    struct Block {
        int x = 0, y = 0;  ///< its first texel
        /// RMS error over RMS reference, both over as many texels as the fullest block has, the reference with a tenth of the map's mean
        /// square added: a block in the dark, or one that holds a corner of a chart, counts for little. Largest double if it is not finite.
        double error = 0;
    };
    /// None where there is no light at all. leastMean: what the mean square counts as at the least, for an image that is one of several.
    std::optional<Block> worst(double leastMean = 0) const;
    double meanSquare() const;  ///< of the reference, over all texels
    /// What `error` may be in a map with this limit on rel_rms. Honest cooks of the public scenes stay below 0.6, in layouts that suit them
    /// below 0.4 (docs/experiments.md); a block that lost its light, and was at least 0.31 times as bright as the map, is above 0.7.
    static double allowed(double maxError);

private:
    struct Sums {
        double error = 0, reference = 0;
        int x = 0, y = 0, texelCount = 0;
    };
    void count(const Sums& block);

    int across_, firstRow_;
    std::vector<Sums> blocks_;           ///< of the rows, one after the other
    std::vector<Sums> candidates_;       ///< of rows taken in: less error and less reference from one to the next
    double reference_ = 0, texels_ = 0;  ///< of rows taken in
    int fullest_ = 0;
};

}  // namespace lightcook::verify

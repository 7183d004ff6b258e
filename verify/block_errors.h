// The worst 4 x 4 block of an image. A single wrong block is visible, but hardly changes error figures over a whole map.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace lightcook::verify {

/// Sums of squared error and squared reference for each 4 x 4 block of an image, or of some of its rows.
class BlockErrors {
public:
    static constexpr int kSize = 4;

    /// Constructs sums for rows [firstRow, firstRow + rowCount) of the image: whole rows of blocks, except at the image's end. rowCount is
    /// 0 for an object that only merges others.
    BlockErrors(int width, int rowCount, int firstRow = 0);
    /// Adds one texel: squares summed over channels and coefficients.
    void add(int x, int y, double squaredError, double squaredReference);
    /// Merges other rows of the same image. Keeps only those of their blocks that may still be the worst.
    void merge(const BlockErrors& rows);

    struct Block {
        int x = 0, y = 0;  ///< its first texel
        /// RMS error over RMS reference. Both are taken over the texel count of the fullest block, and a tenth of the map's mean square is
        /// added to the reference, so that dark blocks and blocks with few covered texels count less. The largest double if not finite.
        double error = 0;
    };
    /// Returns the block with the largest error, or nothing for a black image.
    /// leastMean  lower bound of the mean square, for an image that is one of several
    std::optional<Block> worst(double leastMean = 0) const;
    double meanSquare() const;  ///< of the reference, over all texels
    /// Returns the limit of Block::error for a map whose limit of rel_rms is maxError. Correct cooks of the public scenes stay below 0.6,
    /// and below 0.4 in suitable layouts (docs/lab/experiments.md). A block that lost its light, and was at least 0.31 times as bright as
    /// the map, is above 0.7.
    static double allowed(double maxError);

private:
    struct Sums {
        double error = 0, reference = 0;
        int x = 0, y = 0, texelCount = 0;
    };
    void count(const Sums& block);

    int across_, firstRow_;
    std::vector<Sums> blocks_;           ///< row after row
    std::vector<Sums> candidates_;       ///< of merged rows: error and reference both decrease from one to the next
    double reference_ = 0, texels_ = 0;  ///< of merged rows
    int fullest_ = 0;
};

}  // namespace lightcook::verify

// The worst block of an image: figures over a whole map forgive one block that is all wrong, a player does not.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace verify {

/// Sums of squared error and squared reference by 4 x 4 blocks. Blocks of different rows may be filled from different threads.
class BlockErrors {
public:
    static constexpr int kSize = 4;

    BlockErrors(int width, int height);
    /// One texel: squares of whatever is compared, summed over channels and coefficients.
    void add(int x, int y, double squaredError, double squaredReference);

    struct Block {
        int x = 0, y = 0;  ///< its first texel
        /// RMS error over RMS reference, both over as many texels as the fullest block has, the reference with a tenth of the map's mean
        /// square added: a block in the dark, or one that holds a corner of a chart, counts for little. Largest double if it is not finite.
        double error = 0;
    };
    /// None where there is no light at all.
    std::optional<Block> worst() const;
    /// What `error` may be in a map with this limit on rel_rms. Honest cooks of the public scenes stay below 0.6, in layouts that suit them
    /// below 0.4 (docs/experiments.md); a block that lost its light, and was at least 0.31 times as bright as the map, is above 0.7.
    static double allowed(double maxError);

private:
    struct Sums {
        double error = 0, reference = 0;
        int texelCount = 0;
    };
    int across_;
    std::vector<Sums> blocks_;
};

}  // namespace verify

// BC7 blocks of two colours, encoded with the least possible error.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "compress/bc7/search.h"
#include "compress/block/two_colours.h"

namespace lightcook::compress {

/// Branch and bound over every mode, partition and rotation, every pair of indices for the colours of each region, all low bits and every
/// pair of ends. A branch is pruned where the lower bound of its error is not below the best error so far.
class Bc7TwoColours {
public:
    explicit Bc7TwoColours(const EncodeOptions& options);
    /// Returns the encoded block with the least error.
    Bc7Result fit(const Block& block, const TwoColours& two);

private:
    /// Storage of the ends of a region.
    struct Coding {
        int bits;            ///< without the low bit
        int lowBitsPerPair;  ///< 0; 1: shared by both ends; 2: one for each end
        int indexBits;
    };
    /// An encoded region.
    struct Coded {
        double error = 0;
        std::array<Ends, 4> ends{};
        std::array<std::uint8_t, 2> low{}, index{};  ///< low bit of each end; index of each colour
    };
    using Weights = std::array<double, 2>;  ///< total significance of each colour in a region
    /// A partition of the block into two or three regions.
    struct Partition {
        double both;  ///< sum over the regions of the smaller weight of the two colours; 0: the colours are separated
        int regionCount, number;
    };

    void tryOneRegion(int mode);
    void tryRotation(int mode, int rotation, bool indexSelection);
    void tryPartition(int mode, int partition);
    /// Finds the best encoding of a region with an error below the bound; the error is infinite if there is none.
    Coded code(std::span<const ChannelError> channels, const Weights& weight, const Coding& coding, double bound) const;
    double leastOf(int mode, const Weights& weight);
    std::vector<Partition> partitions();
    Weights weightOf(int regionCount, int partition, int region) const;
    void setRegion(int regionCount, int partition, int region, std::size_t firstChannel, std::size_t channelCount, const Coded& coded);
    bool foundAll() const;

    std::array<ChannelError, 4> channels_;
    double least_ = 0;                                 ///< lower bound of the error of any block
    double opaqueError_ = 0;                           ///< error of replacing alpha by 1
    Weights total_{};                                  ///< in the whole block
    Weights floor_{};                                  ///< lower bounds of the weights in any region that has the colour
    std::array<std::vector<RegionBounds>, 8> bounds_;  ///< for each mode with several regions, for each choice of low bits
    double bestError_ = 0;
    Bc7Result best_;
    const Block* block_ = nullptr;
    const TwoColours* two_ = nullptr;
};

}  // namespace lightcook::compress

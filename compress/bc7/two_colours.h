// BC7 blocks of two colours, coded with the least error that the format has.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "compress/bc7/search.h"
#include "compress/block/two_colours.h"

namespace lightcook::compress {

/// Every mode, every partition and rotation, every pair of places for the colours of each region, all low bits, every pair of ends: cut
/// wherever what is left cannot beat the best so far.
class Bc7TwoColours {
public:
    explicit Bc7TwoColours(const EncodeOptions& options);
    Bc7Result fit(const Block& block, const TwoColours& two);

private:
    /// How the ends of a region are stored.
    struct Coding {
        int bits;            ///< without the low bit
        int lowBitsPerPair;  ///< 0, 1 for both ends, 2
        int indexBits;
    };
    /// A region, coded.
    struct Coded {
        double error = 0;
        std::array<Ends, 4> ends{};
        std::array<std::uint8_t, 2> low{}, index{};  ///< of each end; of each colour
    };
    using Weights = std::array<double, 2>;  ///< of the colours in a region

    void tryOneRegion(int mode);
    void tryRotation(int mode, int rotation, bool indexSelection);
    void tryPartition(int mode, int partition);
    /// The best of a region below the bound; an infinite error if there is none.
    Coded code(std::span<const ChannelError> channels, const Weights& weight, const Coding& coding, double bound) const;
    double bound(int mode, const Weights& weight);
    std::vector<std::array<int, 3>> partitions();
    Weights weightOf(int regionCount, int partition, int region) const;
    void setRegion(int regionCount, int partition, int region, std::size_t firstChannel, std::size_t channelCount, const Coded& coded);
    bool foundAll() const;

    std::array<ChannelError, 4> channels_;
    double least_ = 0;        ///< no block has a smaller error
    double opaqueError_ = 0;  ///< of taking alpha for 1
    Weights total_{}, floor_{};
    std::array<std::vector<RegionBounds>, 8> bounds_;  ///< of each mode with several regions, for each choice of low bits
    double bestError_ = 0;
    Bc7Result best_;
    const Block* block_ = nullptr;
    const TwoColours* two_ = nullptr;
};

}  // namespace lightcook::compress

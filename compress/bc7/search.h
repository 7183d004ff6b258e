// Search parameters of the BC7 encoder at each effort, and its result.
#pragma once

#include <array>
#include <cstdint>

#include "compress/block/block.h"

namespace lightcook::compress {

struct Bc7Search {
    int shapes;        ///< number of two-region partitions that are ranked, of 64
    int twoRegions;    ///< number of these that are fitted
    int threeRegions;  ///< number of three-region partitions that are fitted, in opaque blocks
    int rotations;     ///< channels that modes 4 and 5 try as the separate one: 0 none, 1 alpha, 4 all
    bool mode4;        ///< tries mode 4 besides mode 5
    int freeRefits;    ///< refits with unrounded ends
    int codedRefits;   ///< refits after rounding the ends to codes
    bool everyLowBit;  ///< tries all combinations of low bits, not only the nearest
    int descents;      ///< number of coordinate-descent passes over the codes
    bool twoColours;   ///< blocks of two colours are encoded with the least possible error
};

/// A block before its bits are packed.
struct Bc7Result {
    int mode = 6;
    int partition = 0, rotation = 0, indexSelection = 0;
    std::array<std::array<std::uint8_t, 4>, 6> code{};        ///< ends 2r and 2r + 1 of region r, without their low bits
    std::array<std::uint8_t, 6> low{};                        ///< low bits of the ends
    std::array<std::uint8_t, kTexelCount> index{}, second{};  ///< second: indices of the separate channel, in modes 4 and 5
};

/// Returns the parameters of an effort, 0 .. 9.
const Bc7Search& bc7SearchOf(int effort);

}  // namespace lightcook::compress

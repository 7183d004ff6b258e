// What the BC7 encoder searches at each effort, and what it finds.
#pragma once

#include <array>
#include <cstdint>

#include "compress/block/block.h"

namespace lightcook::compress {

/// Parameters of the search: what each point on the curve of time against error buys.
struct Bc7Search {
    int shapes;        ///< two-region partitions that are judged, of 64
    int twoRegions;    ///< of these, tried in full
    int threeRegions;  ///< three-region partitions tried in full; opaque blocks only
    int rotations;     ///< of the modes with a second index: 0 none, 1 alpha alone, 4 every channel
    bool mode4;        ///< with them, also the mode of three-bit second indices
    int freeRefits;    ///< least-squares steps before anything is rounded
    int codedRefits;   ///< the same, against rounded ends
    bool everyLowBit;  ///< all combinations of shared low bits, in place of the nearest
    int descents;      ///< passes of single steps of each code
    bool twoColours;   ///< blocks of two colours get the least error there is
};

/// A block before its bits are packed.
struct Bc7Result {
    int mode = 6;
    int partition = 0, rotation = 0, indexSelection = 0;
    std::array<std::array<std::uint8_t, 4>, 6> code{};        ///< ends 2r and 2r + 1 of region r; without low bits
    std::array<std::uint8_t, 6> low{};                        ///< their low bits
    std::array<std::uint8_t, kTexelCount> index{}, second{};  ///< second: of the channel on its own, in modes 4 and 5
};

const Bc7Search& bc7SearchOf(int effort);

}  // namespace lightcook::compress

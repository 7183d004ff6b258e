// Search parameters of the BC7 encoder at each effort, and its result.
#pragma once

#include <array>
#include <cstdint>

#include "compress/block/block.h"

namespace lightcook::compress {

/// Search parameters of the full search (fit-inl.h).
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

/// Search parameters of the fast kernel (fast-inl.h).
struct Bc7FastSearch {
    int refits;             ///< to the indices of the rounded ends
    float exactBelow;       ///< in blocks below this RMS error [8-bit codes], mode 6 chooses its low bits by the error as decoded
    bool mode5;             ///< tries mode 5, with alpha as the separate channel
    float twoRegionsAbove;  ///< blocks with a greater RMS error [8-bit codes] with one region are fitted with two
    int shapes;             ///< number of two-region partitions that are ranked, of 64
    int partitions;         ///< number of these that are fitted, up to 4
    bool mode3;             ///< tries mode 3 besides mode 1
    bool fullSearch;        ///< blocks are encoded by the full search too, and the better result is kept; then mode5 must be false
};

/// A block before its bits are packed.
struct Bc7Result {
    float error = -1;  ///< weighted squared error [8-bit codes^2]; below 0 for blocks that have the least possible or none
    int mode = 6;
    int partition = 0, rotation = 0, indexSelection = 0;
    std::array<std::array<std::uint8_t, 4>, 6> code{};        ///< ends 2r and 2r + 1 of region r, without their low bits
    std::array<std::uint8_t, 6> low{};                        ///< low bits of the ends
    std::array<std::uint8_t, kTexelCount> index{}, second{};  ///< second: indices of the separate channel, in modes 4 and 5
};

/// Returns the parameters of the full search at an effort, 0 .. 9. It is used from effort 3 up; efforts 0 to 2 have the fast kernel alone.
const Bc7Search& bc7SearchOf(int effort);
/// Returns the parameters of the fast kernel at an effort.
const Bc7FastSearch& bc7FastSearchOf(int effort);

}  // namespace lightcook::compress

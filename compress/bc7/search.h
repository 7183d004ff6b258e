// Search parameters of the BC7 encoder at each effort, and its result.
#pragma once

#include <array>
#include <cstdint>

#include "compress/block/block.h"

namespace lightcook::compress {

/// Search parameters of the full search (full/search-inl.h).
struct Bc7Search {
    static constexpr int kMostPolished = 64;
    // Candidates, which are fitted in closed form (full/candidates-inl.h):
    int twoRegions;    ///< number of two-region partitions
    int threeRegions;  ///< number of three-region partitions, in opaque blocks
    bool twoIndices;   ///< tries modes 4 and 5, with each channel as the separate one
    int refits;        ///< to the indices of the rounded ends
    // The polish of the best candidates (full/polish-inl.h):
    int polished;     ///< number of candidates with the least predicted error that are polished, at most kMostPolished
    float promising;  ///< limit of their predicted error, as a multiple of the least one
    int starts;       ///< ranges of indices on which the texels are placed at first
    int startRefits;  ///< refits of each start to the indices of its rounded ends
    int descents;     ///< number of coordinate-descent passes over the codes
    bool pairs;       ///< descents also move both ends of a channel, against each other
    bool twoColours;  ///< blocks of two colours are encoded with the least possible error
};

/// The fields of an encoded block that stand before its ends.
struct Bc7Candidate {
    static constexpr std::int32_t kNone = -1;
    static constexpr int kPartitionShift = 6;
    int mode;
    int partition = 0, rotation = 0, indexSelection = 0;

    [[nodiscard]] std::int32_t number() const { return partition << kPartitionShift | indexSelection << 5 | rotation << 3 | mode; }
    static Bc7Candidate of(std::int32_t number) { return {number & 7, number >> kPartitionShift, (number >> 3) & 3, (number >> 5) & 1}; }
};

/// Search parameters of the fast kernel (fast/kernel-inl.h).
struct Bc7FastSearch {
    int refits;             ///< to the indices of the rounded ends
    float exactBelow;       ///< in blocks below this RMS error [8-bit codes], mode 6 chooses its low bits by the error as decoded
    bool mode5;             ///< tries mode 5, with alpha as the separate channel
    float twoRegionsAbove;  ///< blocks with a greater RMS error [8-bit codes] with one region are fitted with two
    int shapes;             ///< number of two-region partitions that are ranked, of 64
    int partitions;         ///< number of these that are fitted, up to 4
    bool mode3;             ///< tries mode 3 besides mode 1
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

inline constexpr int kBc7FastEfforts = 2;  ///< the highest effort of the fast kernel; above it is the full search

/// Returns the parameters of the full search at an effort. Those of low efforts are for blocks without significance.
const Bc7Search& bc7SearchOf(int effort);
/// Returns the parameters of the fast kernel at an effort.
const Bc7FastSearch& bc7FastSearchOf(int effort);

}  // namespace lightcook::compress

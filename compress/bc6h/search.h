// Search parameters of the BC6H encoder at each effort, and its result.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "compress/block/block.h"

namespace lightcook::compress {

struct Bc6hSearch {
    float fastKernelMaxError;  ///< blocks above this RMS error [octaves] are re-encoded by the full search; 0 disables the fast kernel
    int partitions;            ///< number of two-region partitions that are fitted, of 32; 0: one region only
    int freeRefits;            ///< refits with unrounded ends
    int subranges[2];          ///< number of starts on sub-ranges of the indices (Bc6hSubranges) with one region and with two; 0: none
    bool bothStarts;           ///< refits the usual start as well as the best one on a sub-range
    int codedRefits;           ///< refits after rounding the ends to codes
    int descents;              ///< maximum number of descent passes from the best candidate
    bool pairs;                ///< descent also moves both ends of a channel at once
    int moves;                 ///< number of moves of a channel that descent tries, most promising first; 0: all, in fixed order
    int polished;              ///< number of partitions whose candidates are descended before they are compared
    int everyMode;             ///< number of partitions that are also tried in other modes than the finest; above 0: one region, too
    int otherModes;            ///< number of those modes, of 9
    float escalateAbove;       ///< blocks above this RMS error [octaves] also get the search of the next effort; 0 disables it
    float slopeReach;          ///< share of the block's range over which the slope of the metric is taken
    int triedPartitions;       ///< number of the best partitions that a search before this one tried: skipped beyond everyMode
    bool twoColours;           ///< blocks of two colours are encoded with the least possible error
};

/// A start of the fit of a region: distances of the outermost texels from the first and the last index [index steps]. Negative: the texel
/// lies beyond that index.
struct Bc6hSubrange {
    float freeLow, freeHigh;
};
/// Returns the starts for modes with this number of regions, the most useful ones first.
std::span<const Bc6hSubrange> bc6hSubranges(int regionCount);

/// A block before its bits are packed. Codes are signed in the signed format; region 1 is used only by modes that have it.
struct Bc6hResult {
    int mode = 0;  ///< of kBc6hModes
    int partition = 0;
    std::array<std::array<std::int32_t, 3>, 4> code{};  ///< ends 2r and 2r + 1 of region r
    std::array<std::uint8_t, kTexelCount> index{};
    float error = 0;  ///< weighted squared error in the metric, summed over texels and channels
};

/// Returns the parameters of an effort, 0 .. 9.
const Bc6hSearch& bc6hSearchOf(int effort);

/// Encodes whole rows of blocks by the fast kernels (narrow-inl.h, fast-inl.h). Returns true if a value was clamped into the range of the
/// format. errors  receives the mean squared error of each block [octaves^2], approximately; infinity where it is not reliable: such blocks
///         may be left unencoded
bool encodeBc6hRows(const TexelRows& rows, bool isSigned, const EncodeOptions& options, std::byte* out, float* errors);

/// Coefficients of p, from m^0 up, such that m p(m) is log2(1 + m) on [0, 1] to 2e-5, exact at both ends (minimax by Lawson's iteration).
inline constexpr std::array<float, 5> kBc6hLog2 = {1.4419170f, -0.7090964f, 0.4156059f, -0.1935755f, 0.0451490f};

}  // namespace lightcook::compress

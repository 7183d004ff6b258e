// What the BC6H encoder searches at each effort, and what it finds.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "compress/block/block.h"

namespace lightcook::compress {

/// Parameters of the search: what each point on the curve of time against error buys.
struct Bc6hSearch {
    float careAbove;  ///< root mean square error, about in octaves, that the fast kernel may leave a block with; 0: it is not asked at all
    int partitions;   ///< two-region shapes tried in full, of 32; 0: one region only
    int freeRefits;   ///< least-squares steps before anything is rounded
    int codedRefits;  ///< the same, against rounded ends
    int descents;     ///< passes of single steps of each code of the best
    bool pairs;       ///< of both ends of a channel as well
    int polished;     ///< two-region shapes that are each stepped on their own
    int everyMode;    ///< two-region shapes, and one region, for which not only the finest mode is tried whose deltas hold
    float deeperAbove;  ///< error, measured likewise, above which a block gets the next effort's search as well; 0: none does
    float slopeReach;   ///< share of the block's range across which the metric's slope is taken
    bool twoColours;    ///< blocks of two colours get the least error there is
};

/// A block before its bits are packed. Codes are signed in signed formats; region 1 only where the mode has it.
struct Bc6hResult {
    int mode = 0;  ///< of kBc6hModes
    int partition = 0;
    std::array<std::array<std::int32_t, 3>, 4> code{};
    std::array<std::uint8_t, kTexelCount> index{};
    float error = 0;  ///< sum over texels and channels, weighed, in the metric
};

const Bc6hSearch& bc6hSearchOf(int effort);

/// Whole rows of blocks by the fast kernel; returns whether a value was clamped into the format's range.
/// errors  receives the mean square error that each block is left with, about in octaves, or is null
bool encodeBc6hRows(const TexelRows& rows, bool isSigned, const EncodeOptions& options, std::byte* out, float* errors);

/// m p(m), p of these coefficients from m^0 up, is log2(1 + m) on [0, 1] to 2e-5, exact at both ends (minimax by Lawson's iteration).
inline constexpr std::array<float, 5> kBc6hLog2 = {1.4419170f, -0.7090964f, 0.4156059f, -0.1935755f, 0.0451490f};

}  // namespace lightcook::compress

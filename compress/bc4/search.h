// Search parameters of the single-channel encoder (BC4, BC5, BC3's alpha) at each effort, and its result.
#pragma once

#include <array>
#include <cstdint>

namespace lightcook::compress {

struct Bc4Search {
    int starts;            ///< number of kBc4Starts tried in the eight-value mode
    int plainStarts;       ///< the same in the six-value mode, over all texels
    int thresholds;        ///< number of kBc4Thresholds tried in the six-value mode
    int thresholdStarts;   ///< number of kBc4Starts tried for each threshold
    int startsPerDescent;  ///< starts are divided into groups of this size, and the best of each group is polished
    int refits;            ///< least-squares steps in polishing
    int passes;            ///< maximum number of descent passes in polishing
    int reach;             ///< maximum distance of a neighbour in descent [codes]
    bool polishEach;       ///< six-value mode: polishes the best of each group of starts, not only the best of all
    bool sixValues;        ///< also tries the six-value mode
    bool exhaustive;       ///< searches all pairs of endpoints at the end (exact-inl.h)

    /// Returns true at effort 0, where rows of blocks whose texels all weigh 1 go through the fast kernel (fast-inl.h). It has the same
    /// starts and nothing else.
    bool usesFastKernel() const { return !sixValues; }
};

/// Maps a value to codes: value * scale + offset, from 0 to the largest. The bytes -127 .. 127 of the signed formats count from 0 too;
/// interpolation is linear, so the shift does not change it.
struct Bc4Codes {
    float scale, offset, largest;
};
inline constexpr Bc4Codes kBc4Unorm = {255, 0, 255}, kBc4Snorm = {127, 127, 254};

/// A block before its bits are packed.
struct Bc4Result {
    int low = 0, high = 0;      ///< endpoints in codes, low <= high
    bool sixValues = false;     ///< six values from low to high, and the smallest and the largest code
    float error = 0;            ///< weighted squared error [codes^2]
    std::uint64_t indices = 0;  ///< of the sixteen texels, three bits each, for these ends
    bool isConstant = false;    ///< all significant texels are equal
};

/// Start endpoints: the shares of the range by which the low and the high end are moved inwards (negative: outwards). The first sixteen
/// were selected greedily from a hundred candidates: each reduces the error most after those before it, over blocks of noise, narrow noise,
/// slopes, and slopes of whole codes. The last eight fill gaps between these.
inline constexpr std::array<std::array<float, 2>, 24> kBc4Starts = {
    {{0, 0},           {0.04f, 0.04f}, {-0.15f, 0.04f}, {0.08f, 0},       {0, 0.08f},    {0.04f, -0.15f}, {0.22f, 0.08f}, {-0.05f, 0},
     {0.08f, 0.22f},   {0, -0.05f},    {0.12f, 0.3f},   {0.08f, 0.08f},   {0.3f, 0.08f}, {0.04f, 0},      {0.3f, 0.22f},  {-0.1f, -0.05f},
     {-0.05f, -0.05f}, {-0.12f, 0},    {0, -0.12f},     {-0.15f, -0.15f}, {0.2f, 0.2f},  {0.2f, 0},       {0, 0.2f},      {0.12f, 0.12f}}};

/// Six-value mode: texels closer than the threshold to the smallest or the largest code take it and are left out of the fit [codes].
inline constexpr std::array<float, 4> kBc4Thresholds = {0.5f, 12, 4, 24};

/// Returns the parameters of an effort, 0 .. 9.
const Bc4Search& bc4SearchOf(int effort);
/// Returns the parameters for the alpha of BC3 at an effort, 0 .. 8. Colour has most of the error, so at low effort alpha gets less of the
/// time.
const Bc4Search& bc3AlphaSearchOf(int effort);

}  // namespace lightcook::compress

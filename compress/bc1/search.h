// Search parameters of the BC1 encoder (BC1, and the colour of BC3) at each effort, and its result.
#pragma once

#include <array>
#include <cstdint>

namespace lightcook::compress {

struct Bc1Search {
    int axisSteps;         ///< steps of the power iteration for the principal axis
    int starts;            ///< number of kBc1Starts tried
    int startsPerDescent;  ///< starts are divided into groups of this size, and the best of each group is refined
    int refits;            ///< least-squares steps in refinement
    int passes;            ///< maximum number of coordinate-descent passes
    bool threeColours;     ///< also tries the three-colour mode, in BC1
    bool diagonals;        ///< descent also moves both endpoints of a channel at once
    bool twoColours;       ///< blocks of two colours are encoded with the least possible error
};

/// A block before its indices are chosen.
struct Bc1Result {
    std::array<std::uint8_t, 3> first{}, second{};  ///< endpoints in 5, 6 and 5 bits
    bool threeColours = false;
};

/// Starts: the shares of the range on the principal axis by which the low and the high end are moved inwards (negative: outwards).
inline constexpr std::array<std::array<float, 2>, 8> kBc1Starts = {
    {{0.04f, 0.04f}, {0.15f, 0}, {0, 0.15f}, {-0.2f, -0.2f}, {0.3f, 0}, {0, 0.3f}, {0.15f, 0.15f}, {0, 0}}};

/// Returns the parameters of an effort, 0 .. 9.
const Bc1Search& bc1SearchOf(int effort);

}  // namespace lightcook::compress

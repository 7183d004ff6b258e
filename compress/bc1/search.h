// What the encoder of BC1's and BC3's colours searches at each effort, and what it finds.
#pragma once

#include <array>
#include <cstdint>

namespace lightcook::compress {

struct Bc1Search {
    int refits;         ///< least-squares steps
    int starts;         ///< of kBc1Starts
    int passes;         ///< of neighbours, at most
    bool threeColours;  ///< also the layout with the value half-way, where the format has it
    bool diagonals;     ///< neighbours that move both ends of a channel
    bool twoColours;    ///< blocks of two colours get the best ends there are
};

struct Bc1Result {
    std::array<std::uint8_t, 3> first{}, second{};  ///< codes of 5, 6 and 5 bits
    bool threeColours = false;
};

/// Shares of the range by which the ends are drawn in at the start.
inline constexpr std::array<std::array<float, 2>, 6> kBc1Starts = {{{0, 0}, {0.1f, 0.1f}, {0.15f, 0}, {0, 0.15f}, {0.3f, 0}, {0, 0.3f}}};

const Bc1Search& bc1SearchOf(int effort);

}  // namespace lightcook::compress

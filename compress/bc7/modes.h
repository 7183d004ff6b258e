// The eight modes of BC7. Source: Khronos' Data Format Specification 1.3, table "Mode-dependent BPTC parameters".
#pragma once

#include <array>
#include <cstddef>

namespace lightcook::compress {

struct Bc7Mode {
    int regionCount;
    int partitionBits;
    int rotationBits;
    int indexSelectionBits;
    int colourBits;       ///< of each endpoint and channel, without the low bit
    int alphaBits;        ///< 0: alpha is 1
    int endpointLowBits;  ///< 1: each endpoint has a low bit, shared by its channels
    int sharedLowBits;    ///< 1: each region has a low bit, shared by its endpoints
    int indexBits;
    int secondIndexBits;  ///< 0: one index for colour and alpha
};

// clang-format off
constexpr std::array<Bc7Mode, 8> kBc7Modes = {{
  // regionCount partitionBits rotationBits indexSelectionBits colourBits alphaBits endpointLowBits sharedLowBits indexBits secondIndexBits
  {          3,            4,           0,                 0,         4,        0,              1,            0,        3,              0},
  {          2,            6,           0,                 0,         6,        0,              0,            1,        3,              0},
  {          3,            6,           0,                 0,         5,        0,              0,            0,        2,              0},
  {          2,            6,           0,                 0,         7,        0,              1,            0,        2,              0},
  {          1,            0,           2,                 1,         5,        6,              0,            0,        2,              3},
  {          1,            0,           2,                 0,         7,        8,              0,            0,        2,              2},
  {          1,            0,           0,                 0,         7,        7,              1,            0,        4,              0},
  {          2,            6,           0,                 0,         5,        5,              1,            0,        2,              0},
}};
// clang-format on

/// Expands an endpoint to eight bits: the high bits are repeated below.
constexpr int expandTo8(int value, int bits) {
    const int high = value << (8 - bits);
    return high | (high >> bits);
}

/// Returns the channel of the texels that stands at a place, 3 being the separate one: alpha swapped for channel rotation - 1; 0: none.
constexpr std::size_t rotatedChannel(int rotation, std::size_t place) {
    const auto swapped = static_cast<std::size_t>(rotation == 0 ? 3 : rotation - 1);
    return place == 3 ? swapped : place == swapped ? 3 : place;
}

}  // namespace lightcook::compress

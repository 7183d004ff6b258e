// The fourteen modes of BC6H: precision, deltas, and the place of each endpoint bit in the block.
// Source: Khronos' Data Format Specification 1.3, BC6H; field names as in Microsoft's "BC6H Format".
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "compress/block/block.h"

namespace lightcook::compress {

struct Bc6hMode {
    std::uint8_t header;      ///< value of the mode bits
    std::uint8_t headerBits;  ///< 2 or 5
    std::uint8_t regionCount;
    bool transformed;                       ///< all endpoints but the first are stored as differences from it
    std::uint8_t endpointBits;              ///< precision
    std::array<std::uint8_t, 3> deltaBits;  ///< bits of the other endpoints, for red, green and blue
};

// clang-format off
/// The modes with two regions, then those with one. An index of this table is not the mode number of the specification.
constexpr std::array<Bc6hMode, 14> kBc6hModes = {{
    // header headerBits regionCount transformed endpointBits   deltaBits
    {   0x00,         2,          2,       true,          10, {5,  5,  5}},
    {   0x01,         2,          2,       true,           7, {6,  6,  6}},
    {   0x02,         5,          2,       true,          11, {5,  4,  4}},
    {   0x06,         5,          2,       true,          11, {4,  5,  4}},
    {   0x0A,         5,          2,       true,          11, {4,  4,  5}},
    {   0x0E,         5,          2,       true,           9, {5,  5,  5}},
    {   0x12,         5,          2,       true,           8, {6,  5,  5}},
    {   0x16,         5,          2,       true,           8, {5,  6,  5}},
    {   0x1A,         5,          2,       true,           8, {5,  5,  6}},
    {   0x1E,         5,          2,      false,           6, {6,  6,  6}},
    {   0x03,         5,          1,      false,          10, {10, 10, 10}},
    {   0x07,         5,          1,       true,          11, {9,  9,  9}},
    {   0x0B,         5,          1,       true,          12, {8,  8,  8}},
    {   0x0F,         5,          1,       true,          16, {4,  4,  4}},
}};
// clang-format on

/// Indices of kBc6hModes by precision, coarse to fine. The first of each has no deltas, so that it holds any endpoints.
inline constexpr std::array<int, 4> kBc6hOneRegionModes = {10, 11, 12, 13};
inline constexpr std::array<int, 10> kBc6hTwoRegionModes = {9, 1, 6, 7, 8, 5, 0, 2, 3, 4};
/// The mode with endpoints of 16 bits, which are finer than halves.
inline constexpr int kBc6h16BitMode = 13;

/// Reads the mode bits of a block. Returns an index of kBc6hModes, or -1 for the four reserved modes.
int bc6hModeOf(BitReader& bits);

/// One stored bit: bit `bit` of channel `channel` of endpoint `end` (0 and 1 in region 0, 2 and 3 in region 1).
struct Bc6hBit {
    std::uint8_t end, channel, bit;
};

/// Returns the endpoint bits of a mode in stored order, after the mode bits (72 for two regions, 60 for one).
std::span<const Bc6hBit> bc6hLayout(int modeIndex);

/// Consecutive rising bits of one endpoint.
struct Bc6hRun {
    std::uint8_t end, channel, firstBit, bitCount;
};

/// Returns the endpoint bits of a mode as runs.
std::span<const Bc6hRun> bc6hRuns(int modeIndex);

/// Returns the value of an endpoint on the scale that is interpolated: 0 .. 65535, or -32767 .. 32767 if signed.
constexpr int bc6hUnquantize(int value, int bits, bool isSigned) {
    if (!isSigned) {
        if (bits >= 15 || value == 0) return value;
        if (value == (1 << bits) - 1) return 0xFFFF;
        return ((value << 16) + 0x8000) >> bits;
    }
    if (bits >= 16) return value;
    const int magnitude = value < 0 ? -value : value;
    int result = 0;
    if (magnitude >= (1 << (bits - 1)) - 1)
        result = 0x7FFF;
    else if (magnitude > 0)
        result = ((magnitude << 15) + 0x4000) >> (bits - 1);
    return value < 0 ? -result : result;
}

/// Returns the bits of the half that an interpolated value decodes to.
constexpr int bc6hFinish(int value, bool isSigned) {
    if (!isSigned) return (value * 31) >> 6;
    return value < 0 ? ((-value * 31) >> 5) | 0x8000 : (value * 31) >> 5;
}

}  // namespace lightcook::compress

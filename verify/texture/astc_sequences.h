// ASTC's bounded integer sequences: values of 2 to 256 levels, packed as bits, or as bits with five trits or three quints in common; and
// the unquantization of the stored levels. Source: Khronos Data Format 1.3, chapter 23, integer sequence encoding and its unquantizations.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "verify/texture/decode.h"

namespace lightcook::verify {

/// A block of 128 bits, the lowest in words[0].
struct AstcBits {
    std::array<std::uint64_t, 2> words{};
    AstcBits() = default;
    explicit AstcBits(Block16 block) {
        const BlockBits bits(block);
        words = {bits.low(), bits.high()};
    }
};
/// Returns bits [first, first + count), count 0 to 32, all below 128.
std::uint32_t astcBits(const AstcBits& bits, int first, int count);
/// Returns the same block in reverse bit order.
AstcBits astcReversed(const AstcBits& bits);

/// Returns the number of bits of a sequence of `count` values with the given levels.
int astcSequenceBits(int count, int levels);
void astcReadSequence(const AstcBits& bits, int first, int levels, std::span<std::uint8_t> values);

/// Returns the largest number of levels, 6 to 256, whose sequence of `count` endpoint values fits; 0 if 6 levels do not fit.
int astcColourLevels(int count, int bitsAvailable);
/// Return the unquantized value of a level: 0..255 for colours, 0..64 for weights.
std::uint8_t astcUnquantizeColour(std::uint8_t stored, int levels);
std::uint8_t astcUnquantizeWeight(std::uint8_t stored, int levels);

}  // namespace lightcook::verify

// ASTC's bounded integer sequences: values of 2 to 256 levels packed as bits, or as bits with a trit or a quint shared among five or three
// of them, and what the stored levels mean. Source: Khronos Data Format 1.3, chapter 23, integer sequence encoding and its unquantizations.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "verify/texture/decode.h"

namespace lightcook::verify {

/// 128 bits, the lowest in words[0].
struct AstcBits {
    std::array<std::uint64_t, 2> words{};
    AstcBits() = default;
    explicit AstcBits(Block16 block) {
        const BlockBits bits(block);
        words = {bits.low(), bits.high()};
    }
};
/// Bits [first, first + count), count 0 to 32, all below 128.
std::uint32_t astcBits(const AstcBits& bits, int first, int count);
/// The same bits in reverse order.
AstcBits astcReversed(const AstcBits& bits);

/// Bits that `count` values of so many levels take.
int astcSequenceBits(int count, int levels);
void astcReadSequence(const AstcBits& bits, int first, int levels, std::span<std::uint8_t> values);

/// The most levels whose sequence of `count` endpoint values fits: 6 to 256, or 0 where not even 6 do.
int astcColourLevels(int count, int bitsAvailable);
/// 0..255 and 0..64.
std::uint8_t astcUnquantizeColour(std::uint8_t stored, int levels);
std::uint8_t astcUnquantizeWeight(std::uint8_t stored, int levels);

}  // namespace lightcook::verify

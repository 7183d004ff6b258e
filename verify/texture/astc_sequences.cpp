#include "verify/texture/astc_sequences.h"

#include <algorithm>
#include <cassert>

namespace lightcook::verify {
namespace {

/// Encoding of values with base * 2^bits levels.
struct Packing {
    int bits;
    int base;  ///< 1, 3 or 5
};

Packing packingOf(int levels) {
    int base = 1;
    if (levels % 3 == 0) base = 3;
    if (levels % 5 == 0) base = 5;
    return {std::countr_zero(static_cast<unsigned>(levels / base)), base};
}

/// Unpacks five trits from 8 bits.
std::array<std::uint8_t, 5> trits(std::uint32_t t) {
    const auto bit = [&](int i) { return t >> i & 1; };
    std::uint32_t c, t0, t1, t2, t3, t4;
    if ((t >> 2 & 7) == 7) {
        c = (t >> 5 & 7) << 2 | (t & 3);
        t4 = t3 = 2;
    } else {
        c = t & 31;
        if ((t >> 5 & 3) == 3) {
            t4 = 2;
            t3 = bit(7);
        } else {
            t4 = bit(7);
            t3 = t >> 5 & 3;
        }
    }
    if ((c & 3) == 3) {
        t2 = 2;
        t1 = c >> 4 & 1;
        t0 = (c >> 3 & 1) << 1 | ((c >> 2 & 1) & ~(c >> 3 & 1));
    } else if ((c >> 2 & 3) == 3) {
        t2 = t1 = 2;
        t0 = c & 3;
    } else {
        t2 = c >> 4 & 1;
        t1 = c >> 2 & 3;
        t0 = (c >> 1 & 1) << 1 | ((c & 1) & ~(c >> 1 & 1));
    }
    const auto byte = [](std::uint32_t v) { return static_cast<std::uint8_t>(v); };
    return {byte(t0), byte(t1), byte(t2), byte(t3), byte(t4)};
}

/// Unpacks three quints from 7 bits.
std::array<std::uint8_t, 3> quints(std::uint32_t q) {
    std::uint32_t q0, q1, q2;
    if ((q >> 1 & 3) == 3 && (q >> 5 & 3) == 0) {
        const std::uint32_t notLowest = ~q & 1;
        q2 = (q & 1) << 2 | ((q >> 4 & 1) & notLowest) << 1 | ((q >> 3 & 1) & notLowest);
        q1 = q0 = 4;
    } else {
        std::uint32_t c;
        if ((q >> 1 & 3) == 3) {
            q2 = 4;
            c = (q >> 3 & 3) << 3 | (~(q >> 5) & 3) << 1 | (q & 1);
        } else {
            q2 = q >> 5 & 3;
            c = q & 31;
        }
        if ((c & 7) == 5) {
            q1 = 4;
            q0 = c >> 3 & 3;
        } else {
            q1 = c >> 3 & 3;
            q0 = c & 7;
        }
    }
    const auto byte = [](std::uint32_t v) { return static_cast<std::uint8_t>(v); };
    return {byte(q0), byte(q1), byte(q2)};
}

/// Returns a value of `bits` bits, repeated to fill `wanted` bits.
std::uint32_t replicate(std::uint32_t value, int bits, int wanted) {
    std::uint32_t result = 0;
    for (int left = wanted; left > 0; left -= bits) result |= left >= bits ? value << (left - bits) : value >> (bits - left);
    return result;
}

/// The bits of a value below its trit or quint: a is the lowest, then b, c, d, e, f. B is written as in the specification.
std::uint32_t spread(std::uint32_t bits, const char* pattern) {
    std::uint32_t result = 0;
    for (; *pattern != 0; ++pattern) result = result << 1 | (*pattern == '0' ? 0 : bits >> (*pattern - 'a') & 1);
    return result;
}

struct Unquantization {
    int levels;
    std::uint32_t c;
    const char* b;
};
constexpr std::array<Unquantization, 11> kColour = {{{6, 204, "000000000"},
                                                     {12, 93, "b000b0bb0"},
                                                     {24, 44, "cb000cbcb"},
                                                     {48, 22, "dcb000dcb"},
                                                     {96, 11, "edcb000ed"},
                                                     {192, 5, "fedcb000f"},
                                                     {10, 113, "000000000"},
                                                     {20, 54, "b0000bb00"},
                                                     {40, 26, "cb0000cbc"},
                                                     {80, 13, "dcb0000dc"},
                                                     {160, 6, "edcb0000e"}}};
constexpr std::array<Unquantization, 5> kWeight = {
    {{6, 50, "0000000"}, {12, 23, "b000b0b"}, {24, 11, "cb000cb"}, {10, 28, "0000000"}, {20, 13, "b0000b0"}}};

/// Unquantizes a colour (9 bits, top bit of the result 0x80) or a weight (7 bits, 0x20).
std::uint32_t unquantizeMixed(std::uint32_t stored, int bits, const Unquantization& table, std::uint32_t allOnes, std::uint32_t topBit) {
    const std::uint32_t low = stored & ((1u << bits) - 1), digit = stored >> bits;
    const std::uint32_t a = (low & 1) != 0 ? allOnes : 0;
    const std::uint32_t t = (digit * table.c + spread(low, table.b)) ^ a;
    return (a & topBit) | t >> 2;
}

std::uint8_t computeColour(std::uint32_t stored, int levels) {
    const Packing packing = packingOf(levels);
    if (packing.base == 1) return static_cast<std::uint8_t>(replicate(stored, packing.bits, 8));
    for (const Unquantization& table : kColour)
        if (table.levels == levels) return static_cast<std::uint8_t>(unquantizeMixed(stored, packing.bits, table, 0x1ff, 0x80));
    assert(false);
    return 0;
}

std::uint8_t computeWeight(std::uint32_t stored, int levels) {
    const Packing packing = packingOf(levels);
    std::uint32_t value = 0;
    if (packing.base == 1)
        value = replicate(stored, packing.bits, 6);
    else if (levels == 3)
        value = std::array<std::uint32_t, 3>{0, 32, 63}[stored];
    else if (levels == 5)
        value = std::array<std::uint32_t, 5>{0, 16, 32, 47, 63}[stored];
    else
        for (const Unquantization& table : kWeight)
            if (table.levels == levels) value = unquantizeMixed(stored, packing.bits, table, 0x7f, 0x20);
    return static_cast<std::uint8_t>(value > 32 ? value + 1 : value);
}

constexpr std::array<int, 17> kColourLevels = {256, 192, 160, 128, 96, 80, 64, 48, 40, 32, 24, 20, 16, 12, 10, 8, 6};

}  // namespace

std::uint32_t astcBits(const AstcBits& bits, int first, int count) {
    assert(first >= 0 && count >= 0 && count <= 32 && first + count <= 128);
    if (count == 0) return 0;
    const std::size_t word = static_cast<std::size_t>(first / 64);
    const int shift = first % 64;
    std::uint64_t value = bits.words[word] >> shift;
    if (shift + count > 64) value |= bits.words[1] << (64 - shift);
    return static_cast<std::uint32_t>(value & ((std::uint64_t{1} << count) - 1));
}

AstcBits astcReversed(const AstcBits& bits) {
    const auto reversed = [](std::uint64_t word) {
        word = (word >> 1 & 0x5555555555555555) | (word & 0x5555555555555555) << 1;
        word = (word >> 2 & 0x3333333333333333) | (word & 0x3333333333333333) << 2;
        word = (word >> 4 & 0x0f0f0f0f0f0f0f0f) | (word & 0x0f0f0f0f0f0f0f0f) << 4;
        return __builtin_bswap64(word);
    };
    AstcBits result;
    result.words = {reversed(bits.words[1]), reversed(bits.words[0])};
    return result;
}

int astcSequenceBits(int count, int levels) {
    const Packing packing = packingOf(levels);
    int bits = count * packing.bits;
    if (packing.base == 3) bits += (8 * count + 4) / 5;
    if (packing.base == 5) bits += (7 * count + 2) / 3;
    return bits;
}

void astcReadSequence(const AstcBits& bits, int first, int levels, std::span<std::uint8_t> values) {
    const Packing packing = packingOf(levels);
    // Each value of a group carries a few bits of the packed digits. Bits of missing values are 0.
    static constexpr std::array<int, 5> kTritBits = {2, 2, 1, 2, 1};
    static constexpr std::array<int, 3> kQuintBits = {3, 2, 2};
    const std::span<const int> digitBits = packing.base == 3 ? std::span<const int>(kTritBits) : std::span<const int>(kQuintBits);
    const std::size_t groupSize = packing.base == 1 ? 1 : digitBits.size();
    for (std::size_t start = 0; start < values.size(); start += groupSize) {
        std::array<std::uint32_t, 5> low{};
        std::uint32_t packed = 0;
        int packedBits = 0;
        const std::size_t count = std::min(groupSize, values.size() - start);
        for (std::size_t i = 0; i < count; ++i) {
            low[i] = astcBits(bits, first, packing.bits);
            first += packing.bits;
            if (packing.base == 1) continue;
            packed |= astcBits(bits, first, digitBits[i]) << packedBits;
            first += digitBits[i];
            packedBits += digitBits[i];
        }
        std::array<std::uint8_t, 5> digits{};
        if (packing.base == 3) digits = trits(packed);
        if (packing.base == 5) {
            const std::array<std::uint8_t, 3> three = quints(packed);
            std::copy(three.begin(), three.end(), digits.begin());
        }
        for (std::size_t i = 0; i < count; ++i)
            values[start + i] = static_cast<std::uint8_t>(static_cast<std::uint32_t>(digits[i]) << packing.bits | low[i]);
    }
}

int astcColourLevels(int count, int bitsAvailable) {
    for (const int levels : kColourLevels)
        if (astcSequenceBits(count, levels) <= bitsAvailable) return levels;
    return 0;
}

std::uint8_t astcUnquantizeColour(std::uint8_t stored, int levels) {
    return computeColour(stored, levels);
}
std::uint8_t astcUnquantizeWeight(std::uint8_t stored, int levels) {
    return computeWeight(stored, levels);
}

}  // namespace lightcook::verify

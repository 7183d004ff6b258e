// BC6H. Source: Khronos Data Format 1.3, section 20.2; Direct3D 11.3 functional specification, BC6H.
#include <array>

#include "verify/texture/decode.h"

namespace lightcook::verify {
namespace {

// Fields of the header: endpoints 0 to 3 of each channel. Endpoints 2 and 3 belong to the second subset.
enum Field : std::uint8_t { kR0, kG0, kB0, kR1, kG1, kB1, kR2, kG2, kB2, kR3, kG3, kB3 };

/// The next `count` bits of the header in file order, which are bits [lowest, lowest + count) of a field.
struct Run {
    Field field;
    std::uint8_t lowest, count;
};
struct Mode {
    int subsetCount = 0;  ///< 0: reserved
    bool isTransformed = false;
    int endpointBits = 0;
    std::array<int, 3> deltaBits{};  ///< [R, G, B]
    std::array<Run, 24> runs{};      ///< after the mode's own 2 or 5 bits; a count of 0 ends them
};

constexpr Mode kTwo10_5_5_5 = {2,
                               true,
                               10,
                               {5, 5, 5},
                               {{{kG2, 4, 1},
                                 {kB2, 4, 1},
                                 {kB3, 4, 1},
                                 {kR0, 0, 10},
                                 {kG0, 0, 10},
                                 {kB0, 0, 10},
                                 {kR1, 0, 5},
                                 {kG3, 4, 1},
                                 {kG2, 0, 4},
                                 {kG1, 0, 5},
                                 {kB3, 0, 1},
                                 {kG3, 0, 4},
                                 {kB1, 0, 5},
                                 {kB3, 1, 1},
                                 {kB2, 0, 4},
                                 {kR2, 0, 5},
                                 {kB3, 2, 1},
                                 {kR3, 0, 5},
                                 {kB3, 3, 1}}}};
constexpr Mode kTwo7_6_6_6 = {
    2, true, 7, {6, 6, 6}, {{{kG2, 5, 1}, {kG3, 4, 1}, {kG3, 5, 1}, {kR0, 0, 7}, {kB3, 0, 1}, {kB3, 1, 1}, {kB2, 4, 1}, {kG0, 0, 7},
                             {kB2, 5, 1}, {kB3, 2, 1}, {kG2, 4, 1}, {kB0, 0, 7}, {kB3, 3, 1}, {kB3, 5, 1}, {kB3, 4, 1}, {kR1, 0, 6},
                             {kG2, 0, 4}, {kG1, 0, 6}, {kG3, 0, 4}, {kB1, 0, 6}, {kB2, 0, 4}, {kR2, 0, 6}, {kR3, 0, 6}}}};
constexpr Mode kTwo11_5_4_4 = {2,
                               true,
                               11,
                               {5, 4, 4},
                               {{{kR0, 0, 10},
                                 {kG0, 0, 10},
                                 {kB0, 0, 10},
                                 {kR1, 0, 5},
                                 {kR0, 10, 1},
                                 {kG2, 0, 4},
                                 {kG1, 0, 4},
                                 {kG0, 10, 1},
                                 {kB3, 0, 1},
                                 {kG3, 0, 4},
                                 {kB1, 0, 4},
                                 {kB0, 10, 1},
                                 {kB3, 1, 1},
                                 {kB2, 0, 4},
                                 {kR2, 0, 5},
                                 {kB3, 2, 1},
                                 {kR3, 0, 5},
                                 {kB3, 3, 1}}}};
constexpr Mode kTwo11_4_5_4 = {
    2, true, 11, {4, 5, 4}, {{{kR0, 0, 10}, {kG0, 0, 10}, {kB0, 0, 10}, {kR1, 0, 4}, {kR0, 10, 1}, {kG3, 4, 1}, {kG2, 0, 4},
                              {kG1, 0, 5},  {kG0, 10, 1}, {kG3, 0, 4},  {kB1, 0, 4}, {kB0, 10, 1}, {kB3, 1, 1}, {kB2, 0, 4},
                              {kR2, 0, 4},  {kB3, 0, 1},  {kB3, 2, 1},  {kR3, 0, 4}, {kG2, 4, 1},  {kB3, 3, 1}}}};
constexpr Mode kTwo11_4_4_5 = {
    2, true, 11, {4, 4, 5}, {{{kR0, 0, 10}, {kG0, 0, 10}, {kB0, 0, 10}, {kR1, 0, 4}, {kR0, 10, 1}, {kB2, 4, 1},  {kG2, 0, 4},
                              {kG1, 0, 4},  {kG0, 10, 1}, {kB3, 0, 1},  {kG3, 0, 4}, {kB1, 0, 5},  {kB0, 10, 1}, {kB2, 0, 4},
                              {kR2, 0, 4},  {kB3, 1, 1},  {kB3, 2, 1},  {kR3, 0, 4}, {kB3, 4, 1},  {kB3, 3, 1}}}};
constexpr Mode kTwo9_5_5_5 = {2,
                              true,
                              9,
                              {5, 5, 5},
                              {{{kR0, 0, 9},
                                {kB2, 4, 1},
                                {kG0, 0, 9},
                                {kG2, 4, 1},
                                {kB0, 0, 9},
                                {kB3, 4, 1},
                                {kR1, 0, 5},
                                {kG3, 4, 1},
                                {kG2, 0, 4},
                                {kG1, 0, 5},
                                {kB3, 0, 1},
                                {kG3, 0, 4},
                                {kB1, 0, 5},
                                {kB3, 1, 1},
                                {kB2, 0, 4},
                                {kR2, 0, 5},
                                {kB3, 2, 1},
                                {kR3, 0, 5},
                                {kB3, 3, 1}}}};
constexpr Mode kTwo8_6_5_5 = {2,
                              true,
                              8,
                              {6, 5, 5},
                              {{{kR0, 0, 8},
                                {kG3, 4, 1},
                                {kB2, 4, 1},
                                {kG0, 0, 8},
                                {kB3, 2, 1},
                                {kG2, 4, 1},
                                {kB0, 0, 8},
                                {kB3, 3, 1},
                                {kB3, 4, 1},
                                {kR1, 0, 6},
                                {kG2, 0, 4},
                                {kG1, 0, 5},
                                {kB3, 0, 1},
                                {kG3, 0, 4},
                                {kB1, 0, 5},
                                {kB3, 1, 1},
                                {kB2, 0, 4},
                                {kR2, 0, 6},
                                {kR3, 0, 6}}}};
constexpr Mode kTwo8_5_6_5 = {
    2, true, 8, {5, 6, 5}, {{{kR0, 0, 8}, {kB3, 0, 1}, {kB2, 4, 1}, {kG0, 0, 8}, {kG2, 5, 1}, {kG2, 4, 1}, {kB0, 0, 8},
                             {kG3, 5, 1}, {kB3, 4, 1}, {kR1, 0, 5}, {kG3, 4, 1}, {kG2, 0, 4}, {kG1, 0, 6}, {kG3, 0, 4},
                             {kB1, 0, 5}, {kB3, 1, 1}, {kB2, 0, 4}, {kR2, 0, 5}, {kB3, 2, 1}, {kR3, 0, 5}, {kB3, 3, 1}}}};
constexpr Mode kTwo8_5_5_6 = {
    2, true, 8, {5, 5, 6}, {{{kR0, 0, 8}, {kB3, 1, 1}, {kB2, 4, 1}, {kG0, 0, 8}, {kB2, 5, 1}, {kG2, 4, 1}, {kB0, 0, 8},
                             {kB3, 5, 1}, {kB3, 4, 1}, {kR1, 0, 5}, {kG3, 4, 1}, {kG2, 0, 4}, {kG1, 0, 5}, {kB3, 0, 1},
                             {kG3, 0, 4}, {kB1, 0, 6}, {kB2, 0, 4}, {kR2, 0, 5}, {kB3, 2, 1}, {kR3, 0, 5}, {kB3, 3, 1}}}};
constexpr Mode kTwo6_6_6_6 = {
    2, false, 6, {6, 6, 6}, {{{kR0, 0, 6}, {kG3, 4, 1}, {kB3, 0, 1}, {kB3, 1, 1}, {kB2, 4, 1}, {kG0, 0, 6}, {kG2, 5, 1}, {kB2, 5, 1},
                              {kB3, 2, 1}, {kG2, 4, 1}, {kB0, 0, 6}, {kG3, 5, 1}, {kB3, 3, 1}, {kB3, 5, 1}, {kB3, 4, 1}, {kR1, 0, 6},
                              {kG2, 0, 4}, {kG1, 0, 6}, {kG3, 0, 4}, {kB1, 0, 6}, {kB2, 0, 4}, {kR2, 0, 6}, {kR3, 0, 6}}}};
constexpr Mode kOne10_10 = {
    1, false, 10, {10, 10, 10}, {{{kR0, 0, 10}, {kG0, 0, 10}, {kB0, 0, 10}, {kR1, 0, 10}, {kG1, 0, 10}, {kB1, 0, 10}}}};
// In the one-subset modes with deltas, the bits above the tenth are stored highest first.
constexpr Mode kOne11_9 = {
    1,
    true,
    11,
    {9, 9, 9},
    {{{kR0, 0, 10}, {kG0, 0, 10}, {kB0, 0, 10}, {kR1, 0, 9}, {kR0, 10, 1}, {kG1, 0, 9}, {kG0, 10, 1}, {kB1, 0, 9}, {kB0, 10, 1}}}};
constexpr Mode kOne12_8 = {1,
                           true,
                           12,
                           {8, 8, 8},
                           {{{kR0, 0, 10},
                             {kG0, 0, 10},
                             {kB0, 0, 10},
                             {kR1, 0, 8},
                             {kR0, 11, 1},
                             {kR0, 10, 1},
                             {kG1, 0, 8},
                             {kG0, 11, 1},
                             {kG0, 10, 1},
                             {kB1, 0, 8},
                             {kB0, 11, 1},
                             {kB0, 10, 1}}}};
constexpr Mode kOne16_4 = {1, true, 16, {4, 4, 4}, {{{kR0, 0, 10}, {kG0, 0, 10}, {kB0, 0, 10}, {kR1, 0, 4},  {kR0, 15, 1}, {kR0, 14, 1},
                                                     {kR0, 13, 1}, {kR0, 12, 1}, {kR0, 11, 1}, {kR0, 10, 1}, {kG1, 0, 4},  {kG0, 15, 1},
                                                     {kG0, 14, 1}, {kG0, 13, 1}, {kG0, 12, 1}, {kG0, 11, 1}, {kG0, 10, 1}, {kB1, 0, 4},
                                                     {kB0, 15, 1}, {kB0, 14, 1}, {kB0, 13, 1}, {kB0, 12, 1}, {kB0, 11, 1}, {kB0, 10, 1}}}};
constexpr Mode kReserved = {};

/// Returns the mode for the lowest five bits of a block. Modes of two bits are determined by the lowest two.
const Mode& modeOf(std::uint32_t lowestFive) {
    if ((lowestFive & 3) == 0) return kTwo10_5_5_5;
    if ((lowestFive & 3) == 1) return kTwo7_6_6_6;
    switch (lowestFive) {
        case 0b00010:
            return kTwo11_5_4_4;
        case 0b00110:
            return kTwo11_4_5_4;
        case 0b01010:
            return kTwo11_4_4_5;
        case 0b01110:
            return kTwo9_5_5_5;
        case 0b10010:
            return kTwo8_6_5_5;
        case 0b10110:
            return kTwo8_5_6_5;
        case 0b11010:
            return kTwo8_5_5_6;
        case 0b11110:
            return kTwo6_6_6_6;
        case 0b00011:
            return kOne10_10;
        case 0b00111:
            return kOne11_9;
        case 0b01011:
            return kOne12_8;
        case 0b01111:
            return kOne16_4;
        default:
            return kReserved;
    }
}

std::int32_t signExtend(std::uint32_t value, int bits) {
    return static_cast<std::int32_t>(value << (32 - bits)) >> (32 - bits);
}

std::int32_t unquantizeUnsigned(std::int32_t value, int bits) {
    if (bits >= 15 || value == 0) return value;
    if (value == (1 << bits) - 1) return 0xffff;
    return ((value << 16) + 0x8000) >> bits;
}

std::int32_t unquantizeSigned(std::int32_t value, int bits) {
    if (bits >= 16 || value == 0) return value;
    const std::int32_t magnitude = value < 0 ? -value : value;
    const std::int32_t wide = magnitude >= (1 << (bits - 1)) - 1 ? 0x7fff : ((magnitude << 15) + 0x4000) >> (bits - 1);
    return value < 0 ? -wide : wide;
}

/// Converts a value of the interpolated 16-bit scale to the bits of a half: 31/64 of it, or for signed blocks 31/32 of the magnitude.
std::uint16_t halfFromUnsigned(std::int32_t value) {
    return static_cast<std::uint16_t>((value * 31) >> 6);
}
std::uint16_t halfFromSigned(std::int32_t value) {
    if (value >= 0) return static_cast<std::uint16_t>((value * 31) >> 5);
    const std::int32_t magnitude = (-value * 31) >> 5;
    return static_cast<std::uint16_t>(magnitude == 0 ? 0 : 0x8000 | magnitude);
}

using Fields = std::array<std::uint32_t, 12>;

/// Returns the endpoints on the 16-bit scale, indexed like Field.
std::array<std::int32_t, 12> unquantizedEndpoints(const Fields& fields, const Mode& mode, bool isSigned) {
    std::array<std::int32_t, 12> endpoints{};
    for (std::size_t f = 0; f < static_cast<std::size_t>(6 * mode.subsetCount); ++f) {
        const std::size_t channel = f % 3;
        std::uint32_t value = fields[f];
        if (mode.isTransformed && f >= 3) {
            const std::uint32_t mask = (1u << mode.endpointBits) - 1;
            value = (fields[channel] + static_cast<std::uint32_t>(signExtend(value, mode.deltaBits[channel]))) & mask;
        }
        endpoints[f] = isSigned ? unquantizeSigned(signExtend(value, mode.endpointBits), mode.endpointBits)
                                : unquantizeUnsigned(static_cast<std::int32_t>(value), mode.endpointBits);
    }
    return endpoints;
}

}  // namespace

void decodeBc6h(Block16 block, bool isSigned, Texels4x4 out) {
    BlockBits bits(block);
    const std::uint32_t lowestFive = static_cast<std::uint32_t>(bits.low() & 31);
    const Mode& mode = modeOf(lowestFive);
    if (mode.subsetCount == 0) {
        for (glm::vec4& texel : out) texel = {0.0f, 0.0f, 0.0f, 1.0f};
        return;
    }
    bits.take((lowestFive & 2) == 0 ? 2 : 5);
    Fields fields{};
    for (const Run& run : mode.runs) {
        if (run.count == 0) break;
        fields[run.field] |= bits.take(run.count) << run.lowest;
    }
    const bool hasTwo = mode.subsetCount == 2;
    const Partition& partition = bptcPartition(mode.subsetCount, hasTwo ? static_cast<int>(bits.take(5)) : 0);
    const std::array<std::int32_t, 12> endpoints = unquantizedEndpoints(fields, mode, isSigned);
    const int indexBits = hasTwo ? 3 : 4;
    const std::span<const std::uint8_t> weights = bptcWeights(indexBits);
    for (int texel = 0; texel < 16; ++texel) {
        const bool isAnchor = texel == 0 || (hasTwo && texel == partition.anchors[1]);
        const std::int32_t weight = weights[bits.take(indexBits - (isAnchor ? 1 : 0))];
        const std::size_t first = 6 * static_cast<std::size_t>(partition.subset(texel));
        glm::vec4& value = out[static_cast<std::size_t>(texel)];
        value.a = 1.0f;
        for (std::size_t channel = 0; channel < 3; ++channel) {
            const std::int32_t a = endpoints[first + channel], b = endpoints[first + 3 + channel];
            const std::int32_t mixed = (a * (64 - weight) + b * weight + 32) >> 6;
            value[static_cast<int>(channel)] = floatFromHalf(isSigned ? halfFromSigned(mixed) : halfFromUnsigned(mixed));
        }
    }
}

}  // namespace lightcook::verify

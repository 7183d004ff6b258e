// BC7: runs the kernels (fast/rows-inl.h, full/search-inl.h) on the best instruction set, and packs the results of the full search. Blocks
// of one colour, and at effort 9 blocks of two colours, are encoded without a kernel.
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "compress/block/highway_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "compress/bc7/encode.cpp"
#include <hwy/foreach_target.h>
// Must follow foreach_target: each target compiles its own copy.
#include "compress/bc7/fast/rows-inl.h"
#include "compress/bc7/full/search-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {

void searchBc7(std::span<const Block* const> blocks, const Bc7Search& search, const EncodeOptions& options, Bc7Result* found) {
    Bc7FullSearch<hn::ScalableTag<float>>(search, options).run(blocks, found);
}

bool fitBc7Rows(const TexelRows& rows, const Bc7FastSearch& search, const EncodeOptions& options, Bc7OneColour* oneColour, std::byte* out) {
    return Bc7FastRows<hn::ScalableTag<float>>(search, options, oneColour).run(rows, out);
}

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "compress/bc7/two_colours.h"
namespace lightcook::compress {
namespace {

HWY_EXPORT(searchBc7);
HWY_EXPORT(fitBc7Rows);

/// Codes of the two ends of a channel.
struct SingleCode {
    std::uint8_t first, second;
};
/// Returns, for each 8-bit value, two 7-bit ends whose palette entry 1 of 4 is exactly that value. With them mode 5 encodes any single
/// 8-bit colour without error.
const std::array<SingleCode, 256>& singleCodes() {
    static const std::array<SingleCode, 256> table = [] {
        std::array<SingleCode, 256> codes{};
        std::array<int, 256> spread;
        spread.fill(std::numeric_limits<int>::max());
        for (int a = 0; a < 128; ++a)
            for (int b = 0; b < 128; ++b) {
                const auto value = static_cast<std::size_t>((expandTo8(a, 7) * 43 + expandTo8(b, 7) * 21 + 32) >> 6);
                if (std::abs(a - b) >= spread[value]) continue;
                spread[value] = std::abs(a - b);
                codes[value] = {static_cast<std::uint8_t>(a), static_cast<std::uint8_t>(b)};
            }
        return codes;
    }();
    return table;
}

/// Encodes one colour, in 0 .. 255.
Bc7Result singleColour(const std::array<float, 4>& colour) {
    Bc7Result result;
    result.mode = 5;
    for (std::size_t c = 0; c < 4; ++c) {
        const auto value = static_cast<std::size_t>(colour[c] + 0.5f);
        const SingleCode code =
            c < 3 ? singleCodes()[value] : SingleCode{static_cast<std::uint8_t>(value), static_cast<std::uint8_t>(value)};
        result.code[0][c] = code.first;
        result.code[1][c] = code.second;
    }
    result.index.fill(1);
    return result;
}
Bc7Result singleColour(const Block& block, std::size_t texel) {
    std::array<float, 4> colour;
    for (std::size_t c = 0; c < 4; ++c) colour[c] = block.channel[c][texel] * 255;
    return singleColour(colour);
}

/// Swaps the ends of regions whose anchor index has its highest bit set, which is not stored, and mirrors their indices.
void swapHighAnchors(int regionCount, int partition, int indexBits, std::size_t firstChannel, std::size_t endChannel, Bc7Result& result,
                     std::array<std::uint8_t, kTexelCount>& index) {
    const int half = 1 << (indexBits - 1), last = 2 * half - 1;
    for (int r = 0; r < regionCount; ++r) {
        if (index[static_cast<std::size_t>(anchorOf(regionCount, partition, r))] < half) continue;
        const auto first = static_cast<std::size_t>(2 * r);
        for (std::size_t c = firstChannel; c < endChannel; ++c) std::swap(result.code[first][c], result.code[first + 1][c]);
        std::swap(result.low[first], result.low[first + 1]);
        for (int t = 0; t < kTexelCount; ++t)
            if (regionOf(regionCount, partition, t) == r) {
                auto& i = index[static_cast<std::size_t>(t)];
                i = static_cast<std::uint8_t>(last - i);
            }
    }
}

void putIndices(int regionCount, int partition, int indexBits, const std::array<std::uint8_t, kTexelCount>& index, BitWriter& bits) {
    std::uint32_t anchors = 0;
    for (int r = 0; r < regionCount; ++r) anchors |= 1u << anchorOf(regionCount, partition, r);
    for (std::size_t t = 0; t < kTexelCount; ++t) bits.put(index[t], indexBits - static_cast<int>((anchors >> t) & 1));
}

void pack(Bc7Result result, std::byte* out) {
    const Bc7Mode& mode = kBc7Modes[static_cast<std::size_t>(result.mode)];
    const auto ends = static_cast<std::size_t>(2 * mode.regionCount);
    const bool swapped = mode.secondIndexBits && result.indexSelection;
    const int colourIndexBits = swapped ? mode.secondIndexBits : mode.indexBits;
    swapHighAnchors(mode.regionCount, result.partition, colourIndexBits, 0, mode.secondIndexBits ? 3 : 4, result, result.index);
    if (mode.secondIndexBits) swapHighAnchors(1, 0, mode.indexBits + mode.secondIndexBits - colourIndexBits, 3, 4, result, result.second);

    BitWriter bits;
    bits.put(1u << result.mode, result.mode + 1);
    bits.put(static_cast<std::uint32_t>(result.partition), mode.partitionBits);
    bits.put(static_cast<std::uint32_t>(result.rotation), mode.rotationBits);
    bits.put(static_cast<std::uint32_t>(result.indexSelection), mode.indexSelectionBits);
    for (std::size_t c = 0; c < 4; ++c)
        for (std::size_t e = 0; e < ends; ++e) bits.put(result.code[e][c], c < 3 ? mode.colourBits : mode.alphaBits);
    for (std::size_t e = 0; e < ends; e += mode.sharedLowBits ? 2 : 1)
        if (mode.endpointLowBits || mode.sharedLowBits) bits.put(result.low[e], 1);
    putIndices(mode.regionCount, result.partition, mode.indexBits, swapped ? result.second : result.index, bits);
    if (mode.secondIndexBits) putIndices(1, 0, mode.secondIndexBits, swapped ? result.index : result.second, bits);
    bits.store(out, 16);
}

void packOneColour(const std::array<float, 4>& colour, std::byte* out) {
    pack(singleColour(colour), out);
}

}  // namespace

const Bc7FastSearch& bc7FastSearchOf(int effort) {
    // clang-format off
    static constexpr Bc7FastSearch kSearches[3] = {
        // refits exactBelow mode5 twoRegionsAbove shapes partitions mode3
        {       0,         0,false,           1.5f,    32,         1,false},  // effort 0
        {       1,         0,false,           1.0f,    64,         1, true},
        {       1,      2.0f, true,           0.5f,    64,         2, true},  // effort 2 and above
    };
    // clang-format on
    return kSearches[static_cast<std::size_t>(std::clamp(effort, 0, 2))];
}

bool encodeBc7Rows(const TexelRows& rows, const EncodeOptions& options, std::byte* out) {
    return HWY_DYNAMIC_DISPATCH(fitBc7Rows)(rows, bc7FastSearchOf(options.effort), options, packOneColour, out);
}

const Bc7Search& bc7SearchOf(int effort) {
    // clang-format off
    static constexpr std::array<Bc7Search, 8> kSearches = {{
        // twoRegions threeRegions twoIndices refits polished promising starts startRefits descents pairs twoColours
        {           0,           0,     false,     0,       1,     1.0f,     1,          0,       0,false,     false},  // effort 2 and below
        {           3,           2,      true,     0,       2,     1.1f,     3,          0,       1,false,     false},  // effort 3
        {           4,           3,      true,     0,       3,     1.2f,     6,          0,       1,false,     false},
        {           6,           4,      true,     0,       6,     1.2f,    10,          0,       1,false,     false},  // effort 5
        {           8,           8,      true,     1,       8,     1.3f,    10,          1,       1, true,     false},
        {          12,          12,      true,     1,      16,     2.0f,    15,          1,       1, true,     false},
        {          24,          24,      true,     1,      32,     3.0f,    28,          1,       2, true,     false},
        {          64,          64,      true,     2,      64,     4.0f,   105,          3,       3, true,      true},  // effort 9
    }};
    // clang-format on
    return kSearches[static_cast<std::size_t>(std::clamp(effort, 2, 9) - 2)];
}

void encodeBc7(std::span<const Block> blocks, const EncodeOptions& options, std::byte* out) {
    BlockSorter sorted(blocks, 4);
    std::vector<Bc7Result> found(blocks.size());
    const auto run = [&](const std::vector<const Block*>& list, int effort) {
        std::vector<Bc7Result> results(list.size());
        HWY_DYNAMIC_DISPATCH(searchBc7)(list, bc7SearchOf(effort), options, results.data());
        for (std::size_t i = 0; i < list.size(); ++i) found[static_cast<std::size_t>(list[i] - blocks.data())] = results[i];
    };
    for (const auto& [block, texel] : sorted.constant) found[static_cast<std::size_t>(block - blocks.data())] = singleColour(*block, texel);
    if (bc7SearchOf(options.effort).twoColours) {
        Bc7TwoColours exact(options);
        std::erase_if(sorted.varied, [&](const Block* block) {
            TwoColours two;
            if (!hasTwoColours(*block, 4, two)) return false;
            found[static_cast<std::size_t>(block - blocks.data())] = exact.fit(*block, two);
            return true;
        });
    }
    run(sorted.varied, options.effort);
    run(sorted.insignificant, 0);
    for (const Bc7Result& result : found) {
        pack(result, out);
        out += 16;
    }
}

}  // namespace lightcook::compress
#endif

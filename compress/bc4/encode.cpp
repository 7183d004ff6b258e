// BC4, BC5 (unsigned and signed), and the alpha of BC3: one channel, with a palette of eight values between two bytes, or of six values
// between them and the two extremes of the format. At effort 9 an exhaustive search follows the kernel.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "compress/block/highway_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "compress/bc4/encode.cpp"
#include <hwy/foreach_target.h>
// Must follow foreach_target: each target compiles its own copy.
#include "compress/bc4/exact-inl.h"
#include "compress/bc4/fit-inl.h"
#include "compress/bc4/rows-inl.h"
#include "compress/block/fit_blocks-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {

void fitBc4(std::span<const Block* const> blocks, std::size_t channel, const Bc4Search& search, const Bc4Codes& codes, Bc4Result* found) {
    using D = hn::ScalableTag<float>;
    Bc4Fit<D> fit(search, codes);
    fitBlocks<D>(blocks, found, [&](const Block* const* lanes, Bc4Result* results) { fit.run(lanes, channel, results); });
}

template <int kChannels>
bool fitRows(const TexelRows& rows, const Bc4Search& search, const Bc4Codes& codes, std::byte* out) {
    using D = hn::ScalableTag<float>;
    constexpr std::size_t kBytes = 8 * kChannels;
    Bc4Rows<D, kChannels> fit(search, codes);
    bool clamped = false;
    forEachVector<D>(rows, [&](const auto& texels, const auto* weights, std::size_t count) {
        clamped |= fit.run(texels, weights, count, out);
        out += kBytes * count;
    });
    fit.finish();
    return clamped;
}
bool fitBc4Rows(const TexelRows& rows, const Bc4Search& search, const Bc4Codes& codes, std::byte* out) {
    return fitRows<1>(rows, search, codes, out);
}
bool fitBc5Rows(const TexelRows& rows, const Bc4Search& search, const Bc4Codes& codes, std::byte* out) {
    return fitRows<2>(rows, search, codes, out);
}

void searchBc4(const Block& block, std::size_t channel, const Bc4Codes& codes, Bc4Result& found) {
    Bc4Exact<hn::ScalableTag<float>>(codes).run(block, channel, found);
}

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lightcook::compress {
namespace {

HWY_EXPORT(fitBc4);
HWY_EXPORT(fitBc4Rows);
HWY_EXPORT(fitBc5Rows);
HWY_EXPORT(searchBc4);

/// One channel of a block, in codes.
struct Channel {
    float largest;  ///< the largest code; the smallest is 0
    alignas(64) std::array<float, kTexelCount> value;
};

using Candidate = Bc4Result;

/// Returns the byte of a code, two's complement in signed formats. Byte -128, a second -1, is never written.
std::uint32_t byteOf(int code, const Bc4Codes& codes) {
    return static_cast<std::uint32_t>(code - static_cast<int>(codes.offset)) & 0xff;
}

/// Packs a block whose indices are known.
void packKnown(const Candidate& fitted, const Bc4Codes& codes, std::byte* out) {
    const auto first = byteOf(fitted.sixValues ? fitted.low : fitted.high, codes);
    const auto second = static_cast<std::uint64_t>(byteOf(fitted.sixValues ? fitted.high : fitted.low, codes));
    const std::uint64_t bits = first | second << 8 | fitted.indices << 16;
    for (int i = 0; i < 8; ++i) out[i] = static_cast<std::byte>(bits >> (8 * i));
}

/// Packs a block after choosing the index of each texel.
void pack(const Channel& channel, const Candidate& fitted, const Bc4Codes& codes, std::byte* out) {
    BitWriter bits;
    // first > second selects eight values, else six.
    const int first = fitted.sixValues ? fitted.low : fitted.high, second = fitted.sixValues ? fitted.high : fitted.low;
    bits.put(byteOf(first, codes), 8);
    bits.put(byteOf(second, codes), 8);
    const int steps = fitted.sixValues ? 5 : 7;
    for (std::size_t t = 0; t < kTexelCount; ++t) {
        const float value = channel.value[t];
        const float range = static_cast<float>(second - first);
        const float position = second != first ? (value - static_cast<float>(first)) * static_cast<float>(steps) / range : 0.0f;
        const int nearest = static_cast<int>(std::clamp(position, 0.0f, static_cast<float>(steps)) + 0.5f);
        int index = nearest == 0 ? 0 : nearest == steps ? 1 : nearest + 1;
        if (fitted.sixValues) {
            const float miss = std::abs(static_cast<float>(first) + static_cast<float>(nearest) * range / 5 - value);
            if (value < miss) index = 6;
            if (channel.largest - value < miss && channel.largest - value < value) index = 7;
        }
        bits.put(static_cast<std::uint32_t>(index), 3);
    }
    bits.store(out, 8);
}

Channel channelOf(const Block& block, std::size_t channelIndex, const Bc4Codes& codes) {
    Channel channel;
    channel.largest = codes.largest;
    for (std::size_t t = 0; t < kTexelCount; ++t) channel.value[t] = block.channel[channelIndex][t] * codes.scale + codes.offset;
    return channel;
}

}  // namespace

const Bc4Search& bc4SearchOf(int effort) {
    // clang-format off
    static constexpr std::array<Bc4Search, 10> kSearches = {{
        // starts plainStarts thresholds thresholdStarts startsPerDescent refits passes reach polishEach sixValues exhaustive
        {       3,          0,         0,              0,               3,     0,     0,    0,     false,    false,     false},  // effort 0
        {       8,          4,         3,              4,               8,     0,     0,    0,     false,     true,     false},
        {      12,          8,         3,              6,              12,     0,     1,    1,     false,     true,     false},
        {      16,         16,         4,              8,              16,     0,     2,    1,     false,     true,     false},
        {      16,         16,         4,              8,               8,     1,     3,    1,      true,     true,     false},
        {      16,         12,         4,              6,               4,     1,     4,    1,      true,     true,     false},  // effort 5
        {      16,         16,         4,              8,               4,     2,     4,    2,      true,     true,     false},
        {      24,         24,         4,             12,               4,     2,     6,    2,      true,     true,     false},
        {      24,         24,         4,             16,               2,     2,     6,    2,      true,     true,     false},
        {      16,          6,         4,              4,               4,     2,     3,    2,      true,     true,      true},  // effort 9
    }};
    // clang-format on
    return kSearches[static_cast<std::size_t>(std::clamp(effort, 0, 9))];
}

const Bc4Search& bc3AlphaSearchOf(int effort) {
    // clang-format off
    static constexpr std::array<Bc4Search, 3> kSearches = {{
        // starts plainStarts thresholds thresholdStarts startsPerDescent refits passes reach polishEach sixValues exhaustive
        {       3,          0,         0,              0,               3,     0,     0,    0,     false,    false,     false},  // effort 0
        {       4,          1,         1,              1,               4,     0,     0,    0,     false,     true,     false},
        {       8,          3,         2,              2,               8,     0,     0,    0,     false,     true,     false},
    }};
    // clang-format on
    const auto row = static_cast<std::size_t>(std::max(effort, 0));
    return row < kSearches.size() ? kSearches[row] : bc4SearchOf(effort);
}

namespace {

void encodeChannel(std::span<const Block> blocks, std::size_t channelIndex, int effort, const Bc4Codes& codes, std::byte* out,
                   std::size_t stride) {
    std::vector<Bc4Result> results(blocks.size());
    std::vector<const Block*> varied, insignificant;
    for (const Block& block : blocks) (block.insignificant ? insignificant : varied).push_back(&block);
    const auto run = [&](const std::vector<const Block*>& list, int listEffort) {
        std::vector<Bc4Result> found(list.size());
        HWY_DYNAMIC_DISPATCH(fitBc4)(list, channelIndex, bc4SearchOf(listEffort), codes, found.data());
        for (std::size_t i = 0; i < list.size(); ++i) results[static_cast<std::size_t>(list[i] - blocks.data())] = found[i];
    };
    run(varied, effort);
    run(insignificant, 0);
    for (std::size_t i = 0; i < blocks.size(); ++i) {
        const bool search = bc4SearchOf(effort).exhaustive && !blocks[i].insignificant && !results[i].isConstant && results[i].error > 0;
        if (!search) {
            packKnown(results[i], codes, out + i * stride);
            continue;
        }
        HWY_DYNAMIC_DISPATCH(searchBc4)(blocks[i], channelIndex, codes, results[i]);
        pack(channelOf(blocks[i], channelIndex, codes), results[i], codes, out + i * stride);
    }
}

}  // namespace

void encodeBc4Channel(std::span<const Block> blocks, std::size_t channelIndex, int effort, std::byte* out, std::size_t stride) {
    encodeChannel(blocks, channelIndex, effort, kBc4Unorm, out, stride);
}

void encodeBc4(std::span<const Block> blocks, bool isSigned, const EncodeOptions& options, std::byte* out) {
    encodeChannel(blocks, 0, options.effort, isSigned ? kBc4Snorm : kBc4Unorm, out, 8);
}

void encodeBc5(std::span<const Block> blocks, bool isSigned, const EncodeOptions& options, std::byte* out) {
    for (const std::size_t channel : {0u, 1u})
        encodeChannel(blocks, channel, options.effort, isSigned ? kBc4Snorm : kBc4Unorm, out + 8 * channel, 16);
}

bool encodeBc4Rows(const TexelRows& rows, int channelCount, bool isSigned, int effort, std::byte* out) {
    const Bc4Search& search = bc4SearchOf(effort);
    const Bc4Codes& codes = isSigned ? kBc4Snorm : kBc4Unorm;
    if (channelCount == 1) return HWY_DYNAMIC_DISPATCH(fitBc4Rows)(rows, search, codes, out);
    return HWY_DYNAMIC_DISPATCH(fitBc5Rows)(rows, search, codes, out);
}

}  // namespace lightcook::compress
#endif

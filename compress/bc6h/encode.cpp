// BC6H: runs the kernels (narrow-inl.h, fast-inl.h, fit-inl.h) on the best instruction set, and packs their results. Blocks of one colour,
// and at effort 9 blocks of two colours, are encoded without a kernel.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <vector>

#include "compress/block/highway_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "compress/bc6h/encode.cpp"
#include <hwy/foreach_target.h>
// Must follow foreach_target: each target compiles its own copy.
#include "compress/bc6h/fast-inl.h"
#include "compress/bc6h/fit-inl.h"
#include "compress/bc6h/narrow-inl.h"
#include "compress/block/fit_blocks-inl.h"
#include "compress/block/texel_rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {

template <bool kSigned>
void fitBc6h(std::span<const Block* const> blocks, const Bc6hSearch& search, const EncodeOptions& options, Bc6hResult* found) {
    using D = hn::ScalableTag<float>;
    Bc6hFit<D, kSigned> fit(search, options);
    fitBlocks<D>(blocks, found, [&](const Block* const* lanes, Bc6hResult* results) { fit.run(lanes, results); });
}

void fitUnsigned(std::span<const Block* const> blocks, const Bc6hSearch& search, const EncodeOptions& options, Bc6hResult* found) {
    fitBc6h<false>(blocks, search, options, found);
}
void fitSigned(std::span<const Block* const> blocks, const Bc6hSearch& search, const EncodeOptions& options, Bc6hResult* found) {
    fitBc6h<true>(blocks, search, options, found);
}

/// Encodes the listed blocks by the fast kernel, a vector of them at a time.
bool fitListed(const TexelRows& rows, Bc6hFast<hn::ScalableTag<float>, false>& fit, std::span<const std::size_t> blocks, std::byte* out,
               float* errors) {
    using D = hn::ScalableTag<float>;
    constexpr std::size_t kLanes = hn::MaxLanes(D());
    const std::size_t across = static_cast<std::size_t>(rows.width + 3) / 4;
    HWY_ALIGN std::uint32_t words[4 * kLanes];
    HWY_ALIGN float errorLeft[kLanes];
    bool clamped = false;
    for (; !blocks.empty(); blocks = blocks.subspan(std::min(kLanes, blocks.size()))) {
        BlockTexels<kLanes> gathered;
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
            const std::size_t block = blocks[std::min(lane, blocks.size() - 1)];
            gathered.load(rows, static_cast<int>(4 * (block % across)), static_cast<int>(4 * (block / across)), lane);
        }
        std::array<const float*, 4> texels, weights;
        for (std::size_t y = 0; y < 4; ++y) {
            texels[y] = gathered.texels[y];
            weights[y] = gathered.weights[y];
        }
        clamped |= fit.run(texels, gathered.areWeighted ? &weights : nullptr, words, errorLeft);
        for (std::size_t lane = 0; lane < std::min(kLanes, blocks.size()); ++lane) {
            std::memcpy(out + 16 * blocks[lane], words + 4 * lane, 16);
            errors[blocks[lane]] = errorLeft[lane];
        }
    }
    return clamped;
}

/// Encodes narrow blocks in integers, and the others in floats.
bool fitRowsUnsigned(const TexelRows& rows, const EncodeOptions& options, std::byte* out, float* errors) {
    using D = hn::ScalableTag<float>;
    constexpr std::size_t kLanes = hn::MaxLanes(D());
    Bc6hNarrow<D> narrow(options);
    HWY_ALIGN std::uint32_t words[4 * kLanes];
    HWY_ALIGN float errorLeft[kLanes];
    std::vector<std::size_t> left;
    std::size_t done = 0, underWay = 0;  // blocks
    bool clamped = false;
    const auto finish = [&] {
        narrow.finish(words, errorLeft);
        std::memcpy(out + 16 * done, words, 16 * underWay);
        for (std::size_t lane = 0; lane < underWay; ++lane) {
            errors[done + lane] = errorLeft[lane];
            if (errorLeft[lane] < 0) left.push_back(done + lane);
        }
        done += underWay;
    };
    forEachVector<D>(rows, [&](const auto& texels, const auto* weights, std::size_t count) {
        clamped |= narrow.begin(texels, weights);
        if (underWay > 0) finish();
        narrow.fitLine();
        underWay = count;
    });
    narrow.endInput();
    finish();
    Bc6hFast<D, false> fit(options);
    return fitListed(rows, fit, left, out, errors) || clamped;
}

bool fitRowsSigned(const TexelRows& rows, const EncodeOptions& options, std::byte* out, float* errors) {
    using D = hn::ScalableTag<float>;
    constexpr std::size_t kLanes = hn::MaxLanes(D());
    Bc6hFast<D, true> fit(options);
    HWY_ALIGN std::uint32_t words[4 * kLanes];
    HWY_ALIGN float errorLeft[kLanes];
    bool clamped = false;
    forEachVector<D>(rows, [&](const auto& texels, const auto* weights, std::size_t count) {
        clamped |= fit.run(texels, weights, words, errorLeft);
        std::memcpy(out, words, 16 * count);
        out += 16 * count;
        errors = std::copy_n(errorLeft, count, errors);
    });
    return clamped;
}

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "compress/bc6h/two_colours.h"
#include "compress/texel/half.h"
namespace lightcook::compress {
namespace {

HWY_EXPORT(fitUnsigned);
HWY_EXPORT(fitSigned);
HWY_EXPORT(fitRowsUnsigned);
HWY_EXPORT(fitRowsSigned);

void pack(const Bc6hResult& found, std::byte* out) {
    const Bc6hMode& mode = kBc6hModes[static_cast<std::size_t>(found.mode)];
    auto stored = found.code;
    if (mode.transformed)
        for (std::size_t e = 1; e < 4; ++e)
            for (std::size_t c = 0; c < 3; ++c) stored[e][c] -= stored[0][c];
    BitWriter bits;
    bits.put(mode.header, mode.headerBits);
    for (const Bc6hRun& run : bc6hRuns(found.mode))
        bits.put(static_cast<std::uint32_t>(stored[run.end][run.channel] >> run.firstBit), run.bitCount);
    if (mode.regionCount == 2) bits.put(static_cast<std::uint32_t>(found.partition), 5);
    const int indexBits = mode.regionCount == 2 ? 3 : 4;
    const int secondAnchor = mode.regionCount == 2 ? anchorOf(2, found.partition, 1) : 0;
    for (int t = 0; t < kTexelCount; ++t) {
        const bool anchor = t == 0 || t == secondAnchor;
        bits.put(found.index[static_cast<std::size_t>(t)], indexBits - anchor);
    }
    bits.store(out, 16);
}

/// Encodes a block of one colour, exactly if its channels are halves: the 16-bit mode is finer than a half.
Bc6hResult singleColour(const Block& block, std::size_t texel, bool isSigned) {
    Bc6hResult result;
    result.mode = kBc6h16BitMode;
    for (std::size_t c = 0; c < 3; ++c) {
        const std::uint16_t half = halfFromFloat(block.channel[c][texel]);
        const int bits = half & 0x7FFF;
        // The smallest code of which 31/64 (31/32 if signed) is at least the bits of the half.
        const int code = isSigned ? (bits * 32 + 30) / 31 : (bits * 64 + 30) / 31;
        result.code[0][c] = result.code[1][c] = half & 0x8000 ? -code : code;
    }
    return result;
}

/// Returns the error of a block whose values all differ by the given number of octaves; infinity if the metric is not logarithmic.
float errorOf(const Block& block, const EncodeOptions& options, float octaves) {
    if (options.hdrMetric != HdrMetric::Log) return INFINITY;
    float sum = 0;
    for (const float weight : block.significance) sum += weight;
    return sum * (options.channelWeights[0] + options.channelWeights[1] + options.channelWeights[2]) * octaves * octaves;
}

}  // namespace

const Bc6hSearch& bc6hSearchOf(int effort) {
    // clang-format off
    // One row for each effort, 0 .. 9.
    static constexpr std::array<Bc6hSearch, 10> kSearches = {{
        // fastKernelMaxError partitions freeRefits subranges bothStarts codedRefits descents pairs moves polished everyMode otherModes escalateAbove slopeReach tried twoColours
        {                1e9f,         0,         0,   {0, 0},     false,          1,       0, false,    0,       0,        0,         0,            0,  1.0f / 16,    0,     false},
        {              0.024f,         1,         0,   {0, 0},     false,          1,       0, false,    0,       0,        0,         0,            0,  1.0f / 16,    0,     false},
        {             0.0078f,         3,         0,   {0, 0},     false,          2,       0, false,    0,       0,        1,         4,            0,  1.0f / 16,    0,     false},
        {                   0,         2,         0,   {4, 5},     false,          1,       0, false,    0,       0,        0,         0,       0.008f,  1.0f / 16,    0,     false},
        {                   0,         3,         0,   {4, 5},     false,          1,       0, false,    0,       0,        1,         2,            0,  1.0f / 16,    0,     false},
        {                   0,         3,         0,  {6, 13},     false,          1,       1,  true,    1,       0,        1,         4,            0,  1.0f / 16,    0,     false},
        {                   0,         3,         0,  {6, 15},     false,          1,       1,  true,    1,       2,        2,         4,            0,  1.0f / 16,    0,     false},
        {                   0,         7,         0, {13, 24},     false,          1,       1,  true,    3,       5,        4,         4,            0,  1.0f / 16,    0,     false},
        {                   0,        10,         0, {23, 44},      true,          1,       2,  true,    4,      10,       10,         9,            0,  1.0f / 16,    0,     false},
        {                   0,        32,         0, {23, 44},      true,          2,      16,  true,    0,      32,       32,         9,            0,  1.0f / 16,    0,      true},
    }};
    // clang-format on
    return kSearches[static_cast<std::size_t>(std::clamp(effort, 0, 9))];
}

std::span<const Bc6hSubrange> bc6hSubranges(int regionCount) {
    // clang-format off
    static constexpr Bc6hSubrange kOfOne[] = {
        {0, 0}, {-0.25f, 1}, {1, -0.25f}, {-0.25f, -0.25f}, {-0.25f, 0}, {0, -0.25f}, {-0.25f, 0.5f}, {0.5f, -0.25f}, {-0.25f, 3}, {3, -0.25f},
        {-0.5f, -0.25f}, {-0.25f, -0.5f}, {1, 1}, {-0.25f, 4}, {4, -0.25f}, {2, 2}, {0, 8}, {8, 0}, {2, 6}, {6, 2}, {4, 4}, {1, 3}, {3, 1}};
    static constexpr Bc6hSubrange kOfTwo[] = {
        {0, 0}, {2, 2}, {-0.25f, 1}, {1, -0.25f}, {-0.25f, -0.25f}, {1.5f, 1.5f}, {1, 3}, {3, 1}, {1, 4}, {4, 1}, {1, 1}, {0.5f, 2}, {2, 0.5f},
        {2.5f, 3}, {3, 2.5f}, {0.5f, 0.5f}, {1, 1.5f}, {1.5f, 1}, {-0.25f, 2}, {2, -0.25f}, {-0.5f, 0}, {0, -0.5f}, {0, 2}, {2, 0}, {1.5f, 4},
        {4, 1.5f}, {0, 3}, {3, 0}, {2, 3}, {3, 2}, {0, 4}, {4, 0}, {0.5f, 3}, {3, 0.5f}, {-0.25f, 3}, {3, -0.25f}, {1, 2}, {2, 1}, {0, 1},
        {1, 0}, {0, 5}, {5, 0}, {0, 0.5f}, {0.5f, 0}};
    // clang-format on
    if (regionCount == 1) return kOfOne;
    return kOfTwo;
}

bool encodeBc6hRows(const TexelRows& rows, bool isSigned, const EncodeOptions& options, std::byte* out, float* errors) {
    if (isSigned) return HWY_DYNAMIC_DISPATCH(fitRowsSigned)(rows, options, out, errors);
    return HWY_DYNAMIC_DISPATCH(fitRowsUnsigned)(rows, options, out, errors);
}

void encodeBc6h(std::span<const Block> blocks, bool isSigned, const EncodeOptions& options, std::byte* out) {
    BlockSorter sorted(blocks, 3);
    std::vector<Bc6hResult> found(blocks.size());
    const auto fit = [&](const std::vector<const Block*>& list, const Bc6hSearch& search) {
        std::vector<Bc6hResult> results(list.size());
        if (isSigned)
            HWY_DYNAMIC_DISPATCH(fitSigned)(list, search, options, results.data());
        else
            HWY_DYNAMIC_DISPATCH(fitUnsigned)(list, search, options, results.data());
        return results;
    };
    const auto run = [&](const std::vector<const Block*>& list, int effort) {
        const Bc6hSearch& search = bc6hSearchOf(effort);
        const auto at = [&](const Block* block) -> Bc6hResult& { return found[static_cast<std::size_t>(block - blocks.data())]; };
        std::vector<const Block*> inaccurate;
        const std::vector<Bc6hResult> results = fit(list, search);
        for (std::size_t i = 0; i < list.size(); ++i) {
            at(list[i]) = results[i];
            if (search.escalateAbove > 0 && results[i].error > errorOf(*list[i], options, search.escalateAbove))
                inaccurate.push_back(list[i]);
        }
        if (inaccurate.empty()) return;
        // The search of the next effort skips the partitions that this one has tried.
        Bc6hSearch deeperSearch = bc6hSearchOf(effort + 1);
        deeperSearch.triedPartitions = search.partitions;
        const std::vector<Bc6hResult> deeper = fit(inaccurate, deeperSearch);
        for (std::size_t i = 0; i < inaccurate.size(); ++i)
            if (deeper[i].error < at(inaccurate[i]).error) at(inaccurate[i]) = deeper[i];
    };
    for (const auto& [block, texel] : sorted.constant)
        found[static_cast<std::size_t>(block - blocks.data())] = singleColour(*block, texel, isSigned);
    if (bc6hSearchOf(options.effort).twoColours) {
        std::optional<Bc6hTwoColours> exact;
        std::erase_if(sorted.varied, [&](const Block* block) {
            TwoColours two;
            if (!hasTwoColours(*block, 3, two)) return false;
            if (!exact) exact.emplace(isSigned, options);
            found[static_cast<std::size_t>(block - blocks.data())] = exact->fit(*block, two);
            return true;
        });
    }
    run(sorted.varied, options.effort);
    run(sorted.insignificant, 0);
    for (const Bc6hResult& result : found) {
        pack(result, out);
        out += 16;
    }
}

}  // namespace lightcook::compress
#endif

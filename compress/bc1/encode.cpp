// BC1, and the colour of BC3: two endpoint colours of 5, 6 and 5 bits, and a palette of four colours on the line between them, or (BC1
// only) three. The fourth index of the three-colour mode is never used: some readers decode it to black, others to transparent.
//
// Efforts below 9 go from rows of texels to packed blocks (rows-inl.h). At effort 9 the kernel (fit-inl.h) gets gathered blocks, and blocks
// of two colours get an exhaustive search (fitTwoColours).
#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "compress/block/highway_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "compress/bc1/encode.cpp"
#include <hwy/foreach_target.h>
// Must follow foreach_target: each target compiles its own copy.
#include "compress/bc1/fit-inl.h"
#include "compress/bc1/rows-inl.h"
#include "compress/block/fit_blocks-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {

void fitBc1(std::span<const Block* const> blocks, const Bc1Search& search, const EncodeOptions& options, bool mayUseThree,
            Bc1Result* found) {
    using D = hn::ScalableTag<float>;
    Bc1Fit<D> fit(search, options, mayUseThree);
    fitBlocks<D>(blocks, found, [&](const Block* const* lanes, Bc1Result* results) { fit.run(lanes, results); });
}

template <bool kHasAlpha>
bool fitColourRows(const TexelRows& rows, const EncodeOptions& options, std::byte* out) {
    using D = hn::ScalableTag<float>;
    constexpr std::size_t kWords = kHasAlpha ? 4 : 2, kBytes = 4 * kWords;
    Bc1Rows<D, kHasAlpha> fit(options);
    HWY_ALIGN std::uint32_t words[kWords * hn::MaxLanes(D())];
    bool clamped = false;
    forEachVector<D>(rows, [&](const auto& texels, const auto* weights, std::size_t count) {
        clamped |= fit.run(texels, weights, words);
        std::memcpy(out, words, kBytes * count);
        out += kBytes * count;
    });
    return clamped;
}
bool fitBc1Rows(const TexelRows& rows, const EncodeOptions& options, std::byte* out) {
    return fitColourRows<false>(rows, options, out);
}
bool fitBc3Rows(const TexelRows& rows, const EncodeOptions& options, std::byte* out) {
    return fitColourRows<true>(rows, options, out);
}

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "compress/block/two_colours.h"
namespace lightcook::compress {
namespace {

HWY_EXPORT(fitBc1);
HWY_EXPORT(fitBc1Rows);
HWY_EXPORT(fitBc3Rows);

constexpr std::array<int, 3> kLargestCode = {31, 63, 31};

/// Assigns each texel to the nearest of the steps + 1 palette colours, counted in steps from the first endpoint.
void assignSteps(const Block& block, const EncodeOptions& options, const Bc1Result& found, int steps, std::array<int, kTexelCount>& step) {
    std::array<float, 3> a, along;
    float length = 0;
    for (std::size_t c = 0; c < 3; ++c) {
        const float unit = 1 / static_cast<float>(kLargestCode[c]);
        a[c] = static_cast<float>(found.first[c]) * unit;
        const float d = static_cast<float>(found.second[c]) * unit - a[c];
        along[c] = std::max(options.channelWeights[c], 1e-12f) * d;
        length += along[c] * d;
    }
    const float scale = length > 0 ? static_cast<float>(steps) / length : 0.0f;
    const float last = static_cast<float>(steps);
    for (std::size_t t = 0; t < kTexelCount; ++t) {
        float position = 0;
        for (std::size_t c = 0; c < 3; ++c) position += (block.channel[c][t] - a[c]) * along[c];
        position *= scale;
        position = position < 0 ? 0 : position;
        position = position > last ? last : position;
        step[t] = static_cast<int>(position + 0.5f);
    }
}

/// Finds the two integer endpoints, 0 .. largest, with the least weighted squared error for two targets at the given shares of the way
/// from first to second. Returns the error.
double bestEnds(const std::array<double, 2>& target, const std::array<double, 2>& weight, const std::array<double, 2>& share, int largest,
                std::uint8_t& first, std::uint8_t& second) {
    double best = INFINITY;
    for (int a = 0; a <= largest; ++a) {
        double along = 0, squares = 0;
        for (std::size_t i = 0; i < 2; ++i) {
            along += weight[i] * share[i] * (target[i] - (1 - share[i]) * a);
            squares += weight[i] * share[i] * share[i];
        }
        const int below = static_cast<int>(std::clamp(squares > 0 ? along / squares : 0.0, 0.0, static_cast<double>(largest)));
        for (const int b : {below, std::min(below + 1, largest)}) {
            double error = 0;
            for (std::size_t i = 0; i < 2; ++i) {
                const double miss = (1 - share[i]) * a + share[i] * b - target[i];
                error += weight[i] * miss * miss;
            }
            if (error >= best) continue;
            best = error;
            first = static_cast<std::uint8_t>(a);
            second = static_cast<std::uint8_t>(b);
        }
    }
    return best;
}

/// Encodes a block of two colours with the least possible error. Tries every pair of palette positions for the two colours. Given the
/// positions, channels are independent, and for each first endpoint the error is a parabola in the second one, so only the two integers
/// beside its minimum need a test.
Bc1Result fitTwoColours(const Block& block, const TwoColours& two, const EncodeOptions& options, bool mayUseThree) {
    std::array<double, 2> colourWeight{};
    for (std::size_t t = 0; t < kTexelCount; ++t)
        for (std::size_t i = 0; i < 2; ++i)
            if (two.texels[i] >> t & 1) colourWeight[i] += static_cast<double>(block.significance[t]);
    Bc1Result best;
    double bestError = INFINITY;
    for (const int steps : {3, 2}) {
        if (steps == 2 && !mayUseThree) continue;
        // i <= j suffices: swapping the endpoints mirrors the positions.
        for (int i = 0; i <= steps; ++i)
            for (int j = i; j <= steps; ++j) {
                Bc1Result trial;
                trial.threeColours = steps == 2;
                double error = 0;
                for (std::size_t c = 0; c < 3 && error < bestError; ++c) {
                    const double unit = kLargestCode[c], weight = static_cast<double>(options.channelWeights[c]) / (unit * unit);
                    const std::array<double, 2> target = {static_cast<double>(two.colour[0][c]) * unit,
                                                          static_cast<double>(two.colour[1][c]) * unit};
                    error += weight * bestEnds(target, colourWeight, {double(i) / steps, double(j) / steps}, kLargestCode[c],
                                               trial.first[c], trial.second[c]);
                }
                if (error >= bestError) continue;
                bestError = error;
                best = trial;
            }
    }
    return best;
}

std::uint32_t packed565(const std::array<std::uint8_t, 3>& code) {
    return static_cast<std::uint32_t>(code[0] << 11 | code[1] << 5 | code[2]);
}

/// Packs a block.
/// orderSelectsMode  BC1: first > second selects four colours, else three. BC3 has four colours whatever the order
void pack(const Block& block, const EncodeOptions& options, const Bc1Result& found, bool orderSelectsMode, std::byte* out) {
    const int steps = found.threeColours ? 2 : 3;
    std::array<int, kTexelCount> step;
    assignSteps(block, options, found, steps, step);
    std::uint32_t first = packed565(found.first), second = packed565(found.second);
    // Equal endpoints select three colours as well, but then all indices below 3 are the same colour.
    const bool swap = orderSelectsMode && (found.threeColours ? first > second : first < second);
    const bool equal = first == second;
    if (swap) std::swap(first, second);
    BitWriter bits;
    bits.put(first, 16);
    bits.put(second, 16);
    for (const int s : step) {
        const int fromFirst = equal ? 0 : swap ? steps - s : s;
        bits.put(static_cast<std::uint32_t>(fromFirst == 0 ? 0 : fromFirst == steps ? 1 : fromFirst + 1), 2);
    }
    bits.store(out, 8);
}

/// Encodes the colours of blocks, 8 bytes every `stride` bytes.
/// isBc1  false: the colour of BC3
void encodeColours(std::span<const Block> blocks, const EncodeOptions& options, bool isBc1, std::byte* out, std::size_t stride) {
    const auto run = [&](bool insignificant, int effort) {
        std::vector<const Block*> list;
        for (const Block& block : blocks)
            if (block.insignificant == insignificant) list.push_back(&block);
        std::vector<Bc1Result> found(list.size());
        HWY_DYNAMIC_DISPATCH(fitBc1)(list, bc1SearchOf(effort), options, isBc1, found.data());
        for (std::size_t i = 0; i < list.size(); ++i) {
            TwoColours two;
            if (bc1SearchOf(effort).twoColours && hasTwoColours(*list[i], 3, two)) found[i] = fitTwoColours(*list[i], two, options, isBc1);
            pack(*list[i], options, found[i], isBc1, out + static_cast<std::size_t>(list[i] - blocks.data()) * stride);
        }
    };
    run(false, options.effort);
    run(true, 0);
}

}  // namespace

const Bc1Search& bc1SearchOf(int effort) {
    // clang-format off
    static constexpr std::array<Bc1Search, 10> kSearches = {{
        // axisSteps starts startsPerDescent refits passes threeColours diagonals twoColours
        {          2,     1,               1,     0,     0,       false,    false,     false},  // effort 0
        {          3,     3,               3,     1,     0,       false,    false,     false},
        {          4,     4,               4,     1,     1,       false,    false,     false},
        {          4,     6,               6,     2,     1,        true,    false,     false},
        {          4,     6,               6,     2,     2,        true,    false,     false},
        {          4,     6,               3,     2,     2,        true,     true,     false},  // effort 5
        {          4,     6,               2,     2,     4,        true,     true,     false},
        {          4,     8,               2,     2,     6,        true,     true,     false},
        {          4,     8,               1,     2,     8,        true,     true,     false},
        {          4,     8,               1,     2,    24,        true,     true,      true},  // effort 9
    }};
    // clang-format on
    return kSearches[static_cast<std::size_t>(std::clamp(effort, 0, 9))];
}

bool encodeBc1Rows(const TexelRows& rows, bool hasAlpha, const EncodeOptions& options, std::byte* out) {
    if (hasAlpha) return HWY_DYNAMIC_DISPATCH(fitBc3Rows)(rows, options, out);
    return HWY_DYNAMIC_DISPATCH(fitBc1Rows)(rows, options, out);
}

void encodeBc1(std::span<const Block> blocks, const EncodeOptions& options, std::byte* out) {
    encodeColours(blocks, options, true, out, 8);
}

void encodeBc3(std::span<const Block> blocks, const EncodeOptions& options, std::byte* out) {
    encodeBc4Channel(blocks, 3, options.effort, out, 16);
    encodeColours(blocks, options, false, out + 8, 16);
}

}  // namespace lightcook::compress
#endif

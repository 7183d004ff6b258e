// BC1, and the colour of BC3: two colours of 5, 6 and 5 bits, four values on the line between them, or (BC1 only) three.
// The fourth index of the three-colour layout, black to some readers and transparent to others, is never used.
#include <algorithm>
#include <cmath>
#include <vector>

#include "compress/block/highway_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "compress/bc1/encode.cpp"
#include <hwy/foreach_target.h>
// After foreach_target, so that each target gets its own.
#include "compress/bc1/fit-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {

void fitBc1(std::span<const Block* const> blocks, const Bc1Search& search, const EncodeOptions& options, bool mayUseThree,
            Bc1Result* found) {
    using D = hn::ScalableTag<float>;
    constexpr std::size_t kLanes = hn::MaxLanes(D());
    Bc1Fit<D> fit(search, options, mayUseThree);
    std::array<const Block*, kLanes> lanes;
    std::array<Bc1Result, kLanes> results;
    for (std::size_t first = 0; first < blocks.size(); first += kLanes) {
        // The last few fill a vector up with repeats of the very last.
        for (std::size_t lane = 0; lane < kLanes; ++lane) lanes[lane] = blocks[std::min(first + lane, blocks.size() - 1)];
        fit.run(lanes.data(), results.data());
        std::copy_n(results.begin(), std::min(kLanes, blocks.size() - first), found + first);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "compress/block/two_colours.h"
namespace lightcook::compress {
namespace {

HWY_EXPORT(fitBc1);

constexpr std::array<int, 3> kLargestCode = {31, 63, 31};

/// Place of every texel on the line between the ends, in steps: the nearest of steps + 1 values.
void place(const Block& block, const EncodeOptions& options, const Bc1Result& found, int steps, std::array<int, kTexelCount>& step) {
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

/// One colour: the pair of codes whose value a third (or half) of the way is nearest, channel by channel.
Bc1Result fitConstant(const std::array<float, 3>& colour, const EncodeOptions& options, bool mayUseThree) {
    Bc1Result best;
    double bestError = INFINITY;
    for (const bool threeColours : {false, true}) {
        if (threeColours && !mayUseThree) continue;
        const double share = threeColours ? 0.5 : 1.0 / 3.0;
        Bc1Result trial;
        trial.threeColours = threeColours;
        double error = 0;
        for (std::size_t c = 0; c < 3; ++c) {
            const int largest = kLargestCode[c];
            const double target = static_cast<double>(colour[c]) * largest;
            double bestMiss = INFINITY;
            int spread = 0;
            for (int a = 0; a <= largest; ++a) {
                const int b = static_cast<int>(std::clamp((target - (1 - share) * a) / share, 0.0, static_cast<double>(largest)) + 0.5);
                const double miss = std::abs((1 - share) * a + share * b - target);
                // Of equal ones the pair closest together: hardware rounds the interpolation in its own way.
                if (miss < bestMiss - 1e-9 || (miss < bestMiss + 1e-9 && std::abs(a - b) < spread)) {
                    bestMiss = std::min(miss, bestMiss);
                    spread = std::abs(a - b);
                    trial.first[c] = static_cast<std::uint8_t>(a);
                    trial.second[c] = static_cast<std::uint8_t>(b);
                }
            }
            error += static_cast<double>(options.channelWeights[c]) * bestMiss * bestMiss / (largest * largest);
        }
        if (error < bestError) {
            bestError = error;
            best = trial;
        }
    }
    return best;
}

/// The two whole ends, 0 .. largest, that come nearest to the targets at these shares of the way; returns the error.
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

/// A block of two colours: ends for every pair of places that they may take on the line. Channels have nothing to do with one another once
/// the places are chosen, and for a first end the best second one lies beside the minimum of a parabola.
Bc1Result fitTwoColours(const Block& block, const TwoColours& two, const EncodeOptions& options, bool mayUseThree) {
    std::array<double, 2> colourWeight{};
    for (std::size_t t = 0; t < kTexelCount; ++t)
        for (std::size_t i = 0; i < 2; ++i)
            if (two.texels[i] >> t & 1) colourWeight[i] += static_cast<double>(block.significance[t]);
    Bc1Result best;
    double bestError = INFINITY;
    for (const int steps : {3, 2}) {
        if (steps == 2 && !mayUseThree) continue;
        // A pair that falls is one that rises, seen from the other end.
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

/// constant: all texels one step from the first end.
void pack(const Block& block, const EncodeOptions& options, const Bc1Result& found, bool constant, bool orderTellsLayout, std::byte* out) {
    const int steps = found.threeColours ? 2 : 3;
    std::array<int, kTexelCount> step;
    if (constant)
        step.fill(1);
    else
        place(block, options, found, steps, step);
    std::uint32_t first = packed565(found.first), second = packed565(found.second);
    // A rising pair means three colours; equal ones do too, but then every index below 3 is the same colour.
    const bool swap = orderTellsLayout && (found.threeColours ? first > second : first < second);
    const bool equal = first == second;
    if (swap) std::swap(first, second);
    BitWriter bits;
    bits.put(first, 16);
    bits.put(second, 16);
    for (const int s : step) {
        const int turned = equal ? 0 : swap ? steps - s : s;
        bits.put(static_cast<std::uint32_t>(turned == 0 ? 0 : turned == steps ? 1 : turned + 1), 2);
    }
    bits.store(out, 8);
}

void encodeColours(std::span<const Block> blocks, const EncodeOptions& options, bool isBc1, std::byte* out, std::size_t stride) {
    const BlockSorter sorted(blocks, 3);
    const auto at = [&](const Block* block) { return out + static_cast<std::size_t>(block - blocks.data()) * stride; };
    const auto run = [&](const std::vector<const Block*>& list, int effort) {
        std::vector<Bc1Result> found(list.size());
        HWY_DYNAMIC_DISPATCH(fitBc1)(list, bc1SearchOf(effort), options, isBc1, found.data());
        for (std::size_t i = 0; i < list.size(); ++i) {
            TwoColours two;
            if (bc1SearchOf(effort).twoColours && hasTwoColours(*list[i], 3, two)) found[i] = fitTwoColours(*list[i], two, options, isBc1);
            pack(*list[i], options, found[i], false, isBc1, at(list[i]));
        }
    };
    run(sorted.varied, options.effort);
    run(sorted.insignificant, 0);
    // Constant blocks come in runs (outside charts): what was found for the last colour serves the next.
    std::array<float, 3> colour = {-1, -1, -1};
    Bc1Result found;
    for (const auto& [block, texel] : sorted.constant) {
        const std::array<float, 3> next = {block->channel[0][texel], block->channel[1][texel], block->channel[2][texel]};
        if (next != colour) found = fitConstant(next, options, isBc1);
        colour = next;
        pack(*block, options, found, true, isBc1, at(block));
    }
}

}  // namespace

const Bc1Search& bc1SearchOf(int effort) {
    static constexpr std::array<Bc1Search, 10> kSearches = {{{0, 1, 0, false, false, false},
                                                             {1, 1, 0, false, false, false},
                                                             {2, 1, 0, false, false, false},
                                                             {2, 1, 1, false, false, false},
                                                             {2, 1, 1, true, false, false},
                                                             {2, 1, 3, true, true, false},
                                                             {2, 2, 4, true, true, false},
                                                             {2, 4, 6, true, true, false},
                                                             {2, 6, 8, true, true, false},
                                                             {4, 6, 24, true, true, true}}};
    return kSearches[static_cast<std::size_t>(std::clamp(effort, 0, 9))];
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

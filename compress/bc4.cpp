// BC4, BC5, and the alpha of BC3: one channel on a line between two bytes, in 8 steps, or in 6 with 0 and 1 exact.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "compress/block.h"

namespace compress {
namespace {

/// One channel of a block, in units of a code (0 .. 255).
struct Channel {
    alignas(64) std::array<float, kTexelCount> value;
    alignas(64) std::array<float, kTexelCount> weight;
};

struct Candidate {
    int low = 0, high = 0;  ///< low <= high
    bool sixSteps = false;  ///< 6 values between low and high, and 0 and 255
    float error = 0;
};

/// Sum of the sixteen in one order, whatever the machine.
float sum16(const float* terms) {
    float partial[8];
    for (int i = 0; i < 8; ++i) partial[i] = terms[i] + terms[i + 8];
    return ((partial[0] + partial[4]) + (partial[2] + partial[6])) + ((partial[1] + partial[5]) + (partial[3] + partial[7]));
}

/// Error of the channel with these ends, every texel at its nearest value.
float errorOf(const Channel& channel, int low, int high, bool sixSteps) {
    alignas(64) float terms[kTexelCount];
    const float base = static_cast<float>(low), range = static_cast<float>(high - low);
    const float steps = sixSteps ? 5.0f : 7.0f;
    const float scale = high > low ? steps / range : 0.0f, unit = range / steps;
    for (std::size_t t = 0; t < kTexelCount; ++t) {
        const float value = channel.value[t];
        float position = (value - base) * scale;
        position = position < 0 ? 0 : position;
        position = position > steps ? steps : position;
        const float nearest = static_cast<float>(static_cast<int>(position + 0.5f));
        const float difference = base + nearest * unit - value;
        float error = difference * difference;
        if (sixSteps) {
            const float fromZero = value * value, fromOne = (255 - value) * (255 - value);
            error = fromZero < error ? fromZero : error;
            error = fromOne < error ? fromOne : error;
        }
        terms[t] = channel.weight[t] * error;
    }
    return sum16(terms);
}

bool improve(const Channel& channel, int low, int high, bool sixSteps, Candidate& best) {
    if (low < 0 || high > 255 || low > high || (!sixSteps && low == high)) return false;
    const float error = errorOf(channel, low, high, sixSteps);
    if (!(error < best.error)) return false;
    best = {low, high, sixSteps, error};
    return true;
}

/// Moves to the least-squares ends of the present choice of values, until that no longer helps.
void refit(const Channel& channel, bool sixSteps, int iterations, Candidate& best) {
    const float steps = sixSteps ? 5.0f : 7.0f;
    float low = static_cast<float>(best.low), high = static_cast<float>(best.high);
    for (int iteration = 0; iteration < iterations && high > low; ++iteration) {
        float ll = 0, lh = 0, hh = 0, l = 0, h = 0;
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            const float value = channel.value[t];
            const float nearest = std::floor(std::clamp((value - low) / (high - low), 0.0f, 1.0f) * steps + 0.5f) / steps;
            float weight = channel.weight[t];
            const float miss = std::abs(low + nearest * (high - low) - value);
            if (sixSteps && (value < miss || 255 - value < miss)) weight = 0;
            const float rest = 1 - nearest;
            ll += weight * rest * rest;
            lh += weight * rest * nearest;
            hh += weight * nearest * nearest;
            l += weight * rest * value;
            h += weight * nearest * value;
        }
        const float determinant = ll * hh - lh * lh;
        if (!(determinant > 1e-6f * (ll + hh) * (ll + hh))) return;
        const int newLow = static_cast<int>(std::clamp((hh * l - lh * h) / determinant, 0.0f, 255.0f) + 0.5f);
        const int newHigh = static_cast<int>(std::clamp((ll * h - lh * l) / determinant, 0.0f, 255.0f) + 0.5f);
        if (!improve(channel, std::min(newLow, newHigh), std::max(newLow, newHigh), sixSteps, best)) return;
        low = static_cast<float>(best.low);
        high = static_cast<float>(best.high);
    }
}

/// Steps of `reach` codes at either end as long as one helps.
void descend(const Channel& channel, int reach, int passes, Candidate& best) {
    for (int pass = 0; pass < passes; ++pass) {
        bool improved = false;
        const Candidate from = best;
        for (int dLow = -reach; dLow <= reach; ++dLow)
            for (int dHigh = -reach; dHigh <= reach; ++dHigh)
                if (dLow != 0 || dHigh != 0) improved |= improve(channel, from.low + dLow, from.high + dHigh, from.sixSteps, best);
        if (!improved) return;
    }
}

/// Every pair of ends that could still win. A pair whose ends leave the extremes of the texels outside loses at least that much there.
void searchAll(const Channel& channel, Candidate& best) {
    float lowest = 255, highest = 0, lowestWeight = 0, highestWeight = 0;
    for (std::size_t t = 0; t < kTexelCount; ++t) {
        if (!(channel.weight[t] > 0)) continue;
        if (channel.value[t] < lowest) lowest = channel.value[t], lowestWeight = channel.weight[t];
        if (channel.value[t] > highest) highest = channel.value[t], highestWeight = channel.weight[t];
    }
    for (int low = 0; low <= 255 && best.error > 0; ++low) {
        const float under = std::max(0.0f, static_cast<float>(low) - lowest);
        const bool lowHopeless = under * under * lowestWeight > best.error;
        for (int high = 255; high >= low; --high) {
            const float over = std::max(0.0f, highest - static_cast<float>(high));
            if (!lowHopeless && !(over * over * highestWeight > best.error)) improve(channel, low, high, false, best);
            improve(channel, low, high, true, best);
        }
    }
}

/// A single value: ends side by side reach every seventh of a code, and every fifth.
Candidate fitConstant(const Channel& channel, float value) {
    Candidate best;
    best.error = INFINITY;
    for (const bool sixSteps : {false, true}) {
        const int steps = sixSteps ? 5 : 7;
        const int low = std::min(static_cast<int>(std::nearbyint(value * static_cast<float>(steps))) / steps, 254);
        improve(channel, low, low + 1, sixSteps, best);
    }
    return best;
}

Candidate fit(const Channel& channel, int effort) {
    float lowest = 255, highest = 0, innerLowest = 255, innerHighest = 0;
    for (std::size_t t = 0; t < kTexelCount; ++t) {
        if (!(channel.weight[t] > 0)) continue;
        const float value = channel.value[t];
        lowest = std::min(lowest, value);
        highest = std::max(highest, value);
        if (value >= 0.5f) innerLowest = std::min(innerLowest, value);
        if (value <= 254.5f) innerHighest = std::max(innerHighest, value);
    }
    if (lowest == highest) return fitConstant(channel, lowest);
    Candidate best;
    best.error = INFINITY;
    const auto floorOf = [](float v) { return static_cast<int>(v); };
    const auto ceilOf = [](float v) { return std::min(255, static_cast<int>(std::ceil(v))); };
    improve(channel, std::min(floorOf(lowest + 0.5f), 254), std::max(static_cast<int>(highest + 0.5f), floorOf(lowest + 0.5f) + 1), false,
            best);
    improve(channel, std::min(floorOf(lowest), 254), std::max(ceilOf(highest), 1), false, best);
    if (effort >= 1) refit(channel, false, effort >= 3 ? 4 : 2, best);
    if (effort >= 4) descend(channel, effort >= 7 ? 3 : effort >= 6 ? 2 : 1, effort >= 5 ? 6 : 1, best);
    // The other layout pays off where texels touch 0 or 1, or where six steps happen to fall better.
    const bool touches = lowest < 0.5f || highest > 254.5f;
    if ((effort >= 1 && touches) || effort >= 5) {
        Candidate six;
        six.error = INFINITY;
        const float from = innerLowest <= innerHighest ? innerLowest : lowest, to = innerLowest <= innerHighest ? innerHighest : highest;
        improve(channel, floorOf(from + 0.5f), std::max(floorOf(from + 0.5f), static_cast<int>(to + 0.5f)), true, six);
        refit(channel, true, effort >= 3 ? 4 : 2, six);
        if (effort >= 6 || (effort >= 4 && touches)) descend(channel, effort >= 7 ? 3 : effort >= 6 ? 2 : 1, effort >= 5 ? 6 : 1, six);
        if (six.error < best.error) best = six;
    }
    if (effort >= 9 && best.error > 0) searchAll(channel, best);
    return best;
}

void pack(const Channel& channel, const Candidate& fitted, std::byte* out) {
    BitWriter bits;
    // The order of the ends tells the layout: falling for 8 values, rising (or equal) for 6.
    const int first = fitted.sixSteps ? fitted.low : fitted.high, second = fitted.sixSteps ? fitted.high : fitted.low;
    bits.put(static_cast<std::uint32_t>(first), 8);
    bits.put(static_cast<std::uint32_t>(second), 8);
    const int steps = fitted.sixSteps ? 5 : 7;
    for (std::size_t t = 0; t < kTexelCount; ++t) {
        const float value = channel.value[t];
        const float range = static_cast<float>(second - first);
        const float position = second != first ? (value - static_cast<float>(first)) * static_cast<float>(steps) / range : 0.0f;
        const int nearest = static_cast<int>(std::clamp(position, 0.0f, static_cast<float>(steps)) + 0.5f);
        int index = nearest == 0 ? 0 : nearest == steps ? 1 : nearest + 1;
        if (fitted.sixSteps) {
            const float miss = std::abs(static_cast<float>(first) + static_cast<float>(nearest) * range / 5 - value);
            if (value < miss) index = 6;
            if (255 - value < miss && 255 - value < value) index = 7;
        }
        bits.put(static_cast<std::uint32_t>(index), 3);
    }
    bits.store(out, 8);
}

}  // namespace

void encodeBc4Channel(const Block& block, std::size_t channelIndex, int effort, std::byte* out) {
    Channel channel;
    for (std::size_t t = 0; t < kTexelCount; ++t) channel.value[t] = block.channel[channelIndex][t] * 255;
    channel.weight = block.significance;
    pack(channel, fit(channel, block.insignificant ? 0 : effort), out);
}

void encodeBc4(std::span<const Block> blocks, const EncodeOptions& options, std::byte* out) {
    for (const Block& block : blocks) {
        encodeBc4Channel(block, 0, options.effort, out);
        out += 8;
    }
}

void encodeBc5(std::span<const Block> blocks, const EncodeOptions& options, std::byte* out) {
    for (const Block& block : blocks) {
        encodeBc4Channel(block, 0, options.effort, out);
        encodeBc4Channel(block, 1, options.effort, out + 8);
        out += 16;
    }
}

}  // namespace compress

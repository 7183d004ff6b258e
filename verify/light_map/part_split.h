// Splits of a part of a quad into quarters, where slack that shrinks with the part makes its bound loose. Private to verify/.
#pragma once

#include <algorithm>
#include <array>

#include "verify/light_map/bound_evaluator.h"
#include "verify/light_map/controls.h"

namespace lightcook::verify::lightmap {

/// A part is split this often at most: an 8th of a quad along each axis.
inline constexpr int kPartDepth = 3;
/// A part is split if the shrinking slack causes more than this share of its error.
inline constexpr double kSplitShare = 0.05;

/// Returns true if slack that shrinks with the part is a large share of the error of a channel, and the part may exceed the maximum there;
/// false if the budget of exact bounds is spent.
/// pairs      control vectors by channel
/// slack      all of it
/// shrinking  what the part's size causes of it, as exit radiance
inline bool isWorthSplitting(const BoundEvaluator& evaluator, const QuadControls::Pairs& pairs, const ChannelSlack& slack,
                             const std::array<double, kChannels>& shrinking, const LargestBounds& largest) {
    if (largest.isSpent()) return false;
    for (std::size_t c = 0; c < kChannels; ++c) {
        double error = 0;
        for (const ErrorPair& pair : pairs[c]) error = std::max(error, bandSum(lighting::bandLengths(pair.error), kExitNorm));
        if (shrinking[c] <= kSplitShare * error) continue;
        if (!verify::cannotExceed(pairs[c], {&kExitResponse, 1}, kFloor, slack[c], largest.diffuse.bound)) return true;
        if (!verify::cannotExceed(pairs[c], evaluator.setup().responses, kFloor, slack[c], largest.specular.bound)) return true;
    }
    return false;
}

/// Calls work(quarter) for the quarters of a part, by rows.
template <class Work>
void forEachQuarter(const Part& part, Work work) {
    const float half = 0.5f * part.size;
    for (const float v : {0.0f, half})
        for (const float u : {0.0f, half}) work(Part{part.u + u, part.v + v, half});
}

}  // namespace lightcook::verify::lightmap

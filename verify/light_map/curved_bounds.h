// Bounds of quads for curved layouts, whose decode is no polynomial of the texels. Private to verify/.
//
// Over a part of a quad the decode is the bilinear blend of its values at the corners of the part, and at most its curvature beside it
// (curvature.h), which is slack. With filter fractions off by f, the decode is that of a place at most f away: the part is widened by f, so
// that both places are in it, and the blend differs between them by at most f times its slopes. If the curvature is much of the error and
// the part may exceed the maximum, the part is split into quarters, in which the curvature is a quarter, up to three times.
#pragma once

#include <algorithm>
#include <array>

#include "verify/light_map/bound_evaluator.h"
#include "verify/light_map/controls.h"
#include "verify/light_map/tolerance.h"

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

class CurvedBounds {
public:
    CurvedBounds(const MapRows& rows, const SamplerTolerance& tolerance, const BoundEvaluator& evaluator)
        : decoder_(rows.decoder()), tolerance_(tolerance), evaluator_(evaluator) {}

    /// Raises the maximum to the bound of quad (x, y).
    void bound(const QuadTexels& texels, const QuadReferences& references, int x, int y, LargestBounds& largest) const {
        boundPart({texels, references, x, y}, {}, 0, largest);
    }

private:
    struct Place {
        const QuadTexels& texels;
        const QuadReferences& references;
        int x, y;
    };

    /// Returns the part with the places that a filter may take for those in it, as far as the quad reaches.
    Part widened(const Part& part) const {
        if (tolerance_.isNone()) return part;
        const float size = std::min(part.size + 2 * kFractionTolerance, 1.0f);
        return {std::clamp(part.u - kFractionTolerance, 0.0f, 1 - size), std::clamp(part.v - kFractionTolerance, 0.0f, 1 - size), size};
    }
    std::array<FilteredTexels, 4> cornersOf(const QuadTexels& t, const Part& part) const {
        std::array<FilteredTexels, 4> out;
        for (std::size_t i = 0; i < 4; ++i) {
            const std::size_t column = i % 2, row = i / 2;
            const float u = part.u + part.size * static_cast<float>(column), v = part.v + part.size * static_cast<float>(row);
            out[i] = blend(t, {u, v}, decoder_.layers());
        }
        return out;
    }

    void boundPart(const Place& place, const Part& part, int depth, LargestBounds& largest) const {
        const Part reach = widened(part);
        const std::array<FilteredTexels, 4> corners = cornersOf(place.texels, reach);
        const QuadTexels ends = {corners[0].data(), corners[1].data(), corners[2].data(), corners[3].data()};
        const QuadControls quad = QuadControls::ofErrors(decoder_, 0, place.texels, place.references, reach);
        ChannelSlack curvature{};
        addLengths(curvature, decoder_.curvature(ends), static_cast<double>(decoder_.perKey()));
        ChannelSlack slack = curvature;
        const Squares squares = largestSquares(quad.values());
        addRounding(slack, squares, referenceSquares(place.references));
        if (!tolerance_.isNone()) addTolerance(place, reach, quad, ends, slack);
        if (evaluator_.cannotExceed(largest, squares, slack)) return;
        const auto pairs = quad.pairs();
        if (depth < kPartDepth && isWorthSplitting(evaluator_, pairs, slack, exitOf(curvature), largest)) {
            forEachQuarter(part, [&](const Part& quarter) { boundPart(place, quarter, depth + 1, largest); });
            return;
        }
        for (std::size_t c = 0; c < kChannels; ++c)
            evaluator_.raise(largest, pairs[c], slack[c],
                             {place.x + static_cast<double>(reach.u), place.y + static_cast<double>(reach.v),
                              static_cast<double>(reach.size), quad.nodes(), static_cast<int>(c)});
    }
    static std::array<double, kChannels> exitOf(const ChannelSlack& slack) {
        std::array<double, kChannels> exit{};
        for (std::size_t c = 0; c < kChannels; ++c) exit[c] = bandSum(slack[c], kExitNorm);
        return exit;
    }
    /// Adds the sampler tolerance over a widened part.
    void addTolerance(const Place& place, const Part& reach, const QuadControls& quad, const QuadTexels& ends, ChannelSlack& slack) const {
        const auto off = tolerance_.partDeviation(place.texels, ends, place.x, place.y, 0);
        addLengths(slack, off.absolute, static_cast<double>(decoder_.perKey()));
        const auto addSteps = [&](const auto& at, double factor) {
            for (const auto& [a, b, c, d] : {std::array<std::size_t, 4>{1, 0, 3, 2}, std::array<std::size_t, 4>{2, 0, 3, 1}}) {
                const std::array<LcSh, 2> edges = {difference(at(a), at(b)), difference(at(c), at(d))};
                addLargestLengths(slack, edges, factor);
            }
        };
        constexpr double kSteepest = kOutward * kFractionTolerance;
        addSteps([&](std::size_t i) -> const LcSh& { return quad.values()[i]; }, kSteepest / static_cast<double>(reach.size));
        addSteps([&](std::size_t i) -> const LcSh& { return *place.references[i]; }, kSteepest);
    }

    const MapDecoder& decoder_;
    const SamplerTolerance& tolerance_;
    const BoundEvaluator& evaluator_;
};

}  // namespace lightcook::verify::lightmap

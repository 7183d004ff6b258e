// Coarse bound of the error in a quad, from lengths that are computed once a texel. Most quads need no other. Private to verify/.
//
// At the control vectors b of the decode and r of the filtered reference, by the triangle inequality,
//   |b - r| <= max |error at the corners| + curvature + tolerance,
// where curvature is the distance of b from the bilinear blend of the corners' decodes and tolerance the sampler's deviation
// (coarse_bound.h). To this come the effect of inexact filter fractions, 1/256 texel along each axis, and the rounding of floats. The
// local error is then at most (sum_l response_l |band l|) / floor, for the largest response of each band over all normals, views and
// materials. Quads whose coarse bound cannot exceed the map's current maximum are done; all others are refined by QuadBounds.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "verify/light_map/bound_evaluator.h"
#include "verify/light_map/covered_quad.h"
#include "verify/light_map/rows.h"
#include "verify/light_map/tolerance.h"

namespace lightcook::verify::lightmap {

/// Band lengths of one texel, in units of the key.
struct TexelLengths {
    BandLengths error;  ///< under the texel's own decode
    BandLengths reference;
};

/// Lengths of light at the covered corners of a quad, and of its differences.
struct CornerLengths {
    std::array<const TexelLengths*, 4> texels{};  ///< of covered corners only
    BandLengths step{};                           ///< largest differences of their references
};

class QuadCoarseBound {
public:
    using Row = MapRows::Row;
    using Corners = MapRows::Corners;

    QuadCoarseBound(const MapRows& rows, const SamplerTolerance& tolerance, const BoundEvaluator& evaluator)
        : rows_(rows),
          decoder_(rows.decoder()),
          isIdeal_(tolerance.isNone()),
          evaluator_(evaluator),
          coarseBounds_(rows.decoder().coarseBounds(tolerance.formats())),
          tolerance_(tolerance) {}

    /// Computes the lengths of row y.
    void measure(const Row& row, int y, std::vector<TexelLengths>& out) const {
        if (!isKnown()) return;
        const int width = rows_.width();
        out.resize(index(width));
        for (int x = 0; x < width; ++x) {
            const std::size_t i = index(x);
            if (row.covered[i] == 0) continue;
            out[i] = lengthsOf(row.texelsAt(i), row.reference[i], x, y);
        }
    }
    /// Returns the lengths of texel (x, y).
    TexelLengths lengthsOf(LayerTexels texels, const LcSh& reference, int x, int y) const {
        return {bandLengths(errorUnder(decoder_.clusterAt(x, y), texels, reference)), bandLengths(reference)};
    }
    /// Raises lengths to those of others.
    static void raise(BandLengths& largest, const BandLengths& lengths) {
        // Written so that NaN stays: every comparison with it is false.
        for (std::size_t lane = 0; lane < kBandLanes; ++lane)
            largest[lane] = lengths[lane] <= largest[lane] ? largest[lane] : lengths[lane];
    }
    bool isKnown() const { return coarseBounds_->isKnown(); }

    struct Estimate {
        ErrorBound bound;     ///< upper bound of the error, under every decode of the corners
        ErrorBound priority;  ///< the bound relative to the light there: quads that may raise the maximum most have the highest
    };
    /// Returns an upper bound for quad (x, y), refined only until it is below the current maximum.
    /// rows  lengths of two texels each of the row above and of the row below
    Estimate bound(const LargestBounds& largest, const Corners& corners, const std::array<const TexelLengths*, 2>& rows, int x,
                   int y) const {
        const std::array<const TexelLengths*, 4> texels = {rows[0], rows[0] + 1, rows[1], rows[1] + 1};
        const BandLengths light = largestOf(texels, &TexelLengths::reference);
        // |a - b| <= |a| + |b|: bound neighbour differences by their magnitudes.
        BandLengths slack{};
        for (std::size_t lane = 0; lane < kBandLanes; ++lane)
            slack[lane] = (kFloatRounding + (!isIdeal_ ? 4 * kFractionTolerance : 0)) * light[lane];
        Estimate estimate;
        for (int corner = 0; corner < 4; ++corner) {
            if (!rows_.isNewDecode(x, y, corner)) continue;
            const std::size_t cluster = rows_.clusterOf(x, y, corner);
            const BandLengths error = largestError(cluster, corners, texels, x, y, corner);
            Estimate each;
            const auto cannotExceed = [&](const CoarseBound& coarseBound, const BandLengths& errorSlack) {
                each = estimateOf(error, coarseBound, errorSlack, light);
                return evaluator_.cannotExceed(largest, each.bound);
            };
            const auto quickBound = coarseBounds_->quickBound(corners.texels, cluster);
            if (!quickBound || !cannotExceed(*quickBound, slack)) {
                const CoarseBound coarseBound = coarseBounds_->bound(corners.texels, cluster, {tolerance_, x, y});
                if (!cannotExceed(coarseBound, slack) && !isIdeal_) cannotExceed(coarseBound, slackOf(corners.references, light));
            }
            estimate.bound.raise(each.bound);
            estimate.priority.raise(each.priority);
        }
        return estimate;
    }

    /// Returns upper bounds of the band lengths of the error under one decode in a quad of which some texels may not be covered, by
    /// channel. The reference is filtered between the covered ones: it is a mean of them, so that the error is one of differences from
    /// them.
    /// corner   the texel whose decode it is
    /// isQuick  faster and looser, where the layout has such a bound
    BandLengths errorLengths(const CoveredQuad& quad, const CornerLengths& lengths, int corner, bool isQuick) const {
        const std::size_t cluster = rows_.clusterOf(quad.x, quad.y, corner);
        const Corners& corners = quad.corners;
        BandLengths error{}, light{};
        for (std::size_t i = 0; i < 4; ++i) {
            if (quad.covered[i]) {
                raise(light, lengths.texels[i]->reference);
                raise(error, rows_.hasSameDecode(quad.x, quad.y, corner, static_cast<int>(i))
                                 ? lengths.texels[i]->error
                                 : bandLengths(errorUnder(cluster, corners.texels[i], *corners.references[i])));
                continue;
            }
            if (decoder_.isMixed()) continue;
            for (std::size_t j = 0; j < 4; ++j)
                if (quad.covered[j]) raise(error, bandLengths(errorUnder(cluster, corners.texels[i], *corners.references[j])));
        }
        BandLengths slack{};
        for (std::size_t lane = 0; lane < kBandLanes; ++lane)
            slack[lane] = kFloatRounding * light[lane] + (!isIdeal_ ? 2 * kFractionTolerance * lengths.step[lane] : 0);
        if (isQuick)
            if (const auto quickBound = coarseBounds_->quickBound(corners.texels, cluster)) return sumOf(error, *quickBound, slack);
        return sumOf(error, coarseBounds_->bound(corners.texels, cluster, {tolerance_, quad.x, quad.y}), slack);
    }

private:
    /// Rounding of this bound's floats, and of those of the refined bound.
    static constexpr auto kFloatRounding = static_cast<float>(2.5 * kControlRounding);

    /// Returns the error under the decode of a cluster.
    LcSh errorUnder(std::size_t cluster, LayerTexels texels, const LcSh& reference) const {
        return difference(decoder_.decode(texels, cluster), reference);
    }
    /// Returns the slack of rounding, and of filter fractions by the exact differences of neighbouring references.
    static BandLengths slackOf(const QuadReferences& references, const BandLengths& light) {
        const auto steps = [&](std::size_t a, std::size_t b, std::size_t c, std::size_t d) {
            const std::array<LcSh, 2> edges = {difference(*references[a], *references[b]), difference(*references[c], *references[d])};
            return largestLengths(edges);
        };
        const BandLengths across = steps(1, 0, 3, 2), down = steps(2, 0, 3, 1);
        BandLengths slack;
        for (std::size_t lane = 0; lane < kBandLanes; ++lane)
            slack[lane] = kFloatRounding * light[lane] + kFractionTolerance * (across[lane] + down[lane]);
        return slack;
    }
    static BandLengths largestOf(const std::array<const TexelLengths*, 4>& texels, BandLengths TexelLengths::*which) {
        BandLengths largest{};
        for (const TexelLengths* texel : texels) raise(largest, texel->*which);
        return largest;
    }
    /// Returns the largest error of the corners under the decode of one of them.
    BandLengths largestError(std::size_t cluster, const Corners& corners, const std::array<const TexelLengths*, 4>& texels, int x, int y,
                             int corner) const {
        BandLengths error{};
        for (int i = 0; i < 4; ++i) {
            const auto at = static_cast<std::size_t>(i);
            raise(error, rows_.hasSameDecode(x, y, corner, i)
                             ? texels[at]->error
                             : bandLengths(errorUnder(cluster, corners.texels[at], *corners.references[at])));
        }
        return error;
    }
    /// Returns the sum of all parts of the error.
    BandLengths sumOf(const BandLengths& error, const CoarseBound& coarseBound, const BandLengths& slack) const {
        const float perKey = rows_.perKey();
        const float fractions = isIdeal_ ? 0 : kFractionTolerance * 4 * static_cast<float>(decoder_.degree());
        BandLengths all;
        for (std::size_t lane = 0; lane < kBandLanes; ++lane) {
            const float own = error[lane] + perKey * coarseBound.curvature[lane];
            // Fractions move the decode itself, not only its error.
            all[lane] = kOutwardFloat * ((1 + kFloatRounding) * own + fractions * own + slack[lane] + perKey * coarseBound.tolerance[lane]);
        }
        return all;
    }
    Estimate estimateOf(const BandLengths& error, const CoarseBound& coarseBound, const BandLengths& slack,
                        const BandLengths& light) const {
        const BandLengths all = sumOf(error, coarseBound, slack);
        Estimate estimate;
        for (std::size_t c = 0; c < kChannels; ++c) {
            const ErrorBound bound = evaluator_.errorBound(all, c);
            estimate.bound.raise(bound);
            estimate.priority.raise(evaluator_.relativeToLight(bound, light[c]));
        }
        return estimate;
    }

    const MapRows& rows_;
    const MapDecoder& decoder_;
    bool isIdeal_;
    const BoundEvaluator& evaluator_;
    std::unique_ptr<const CoarseBounds> coarseBounds_;
    const SamplerTolerance& tolerance_;
};

}  // namespace lightcook::verify::lightmap

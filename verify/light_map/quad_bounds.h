// Bounds of the error everywhere between four texels. Private to verify/.
//
// Method. Over a quad, decode and reference are polynomials in Bernstein form (controls.h): every value is a weighted mean of control
// vectors, with the same weights for error e and reference r. The local error is bounded for all means at once: t is a bound if
//   s e_j(n) <= t (share r_j(n) + floor)   for every control vector j, direction n, response and sign s,
// because this condition is linear in (e, r), hence holds for means too (bound.h). Slack is added for rounding, filter fractions and the
// sampler tolerance of the formats.
//
// The bound of a map is the maximum over its quads, and quads are refined only as far as they may raise it:
//   1. coarse bound of every quad, from lengths (quad_coarse_bound.h); quads that may exceed the current maximum are deferred
//   2. exact bounds of the 16 most promising deferred quads of each kind of shading, which raise the maximum
//   3. control vectors of the deferred quads that still may exceed it; what remains is deferred again
//   4. exact bounds of those, the most promising first
// Stopping early never changes the result, because a skipped quad provably has a smaller bound. When the budget of exact bounds is spent,
// the control vectors alone bound what is left (bound_evaluator.h).
#pragma once

#include <algorithm>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "verify/light_map/controls.h"
#include "verify/light_map/curved_bounds.h"
#include "verify/light_map/grouped_errors.h"
#include "verify/light_map/quad_coarse_bound.h"
#include "verify/light_map/tolerance.h"

namespace lightcook::verify::lightmap {

/// The largest bounds over the quads of some rows.
class QuadBounds {
public:
    using Corners = MapRows::Corners;

    QuadBounds(const MapRows& rows, const SamplerTolerance& tolerance, const BoundEvaluator& evaluator)
        : rows_(rows), tolerance_(tolerance), evaluator_(evaluator), curved_(rows, tolerance, evaluator) {}
    const LargestBounds& largest() const { return largest_; }
    /// Limits the work of exact bounds (LargestBounds).
    void setMostWork(double work) { largest_.mostWork = work; }

    /// Raises the maximum to the exact bound of quad (x, y).
    void boundQuad(int x, int y) {
        rows_.withQuad(x, y, [&](const Corners& corners) { bound(corners.texels, corners.references, x, y, false); });
    }
    /// Computes the coarse bound of every quad that begins in these rows, and defers those that may exceed the maximum.
    void boundRows(int firstRow, int rowCount) {
        const QuadCoarseBound coarseBound(rows_, tolerance_, evaluator_);
        std::vector<TexelLengths> upper, lower;
        rows_.forEachPairOfRows(firstRow, rowCount, [&](const auto& above, const auto& below, int y) {
            if (y == firstRow) coarseBound.measure(above, y, upper);
            coarseBound.measure(below, y + 1, lower);
            for (int x = 0; x + 1 < rows_.width(); ++x) {
                if (!rows_.isQuad(above, below, x)) continue;
                if (!tolerance_.isOfBlocks() && rows_.repeatsLeft(above, below, x)) continue;
                const Corners corners = rows_.cornersOf(above, below, x);
                if (!coarseBound.isKnown()) {
                    bound(corners.texels, corners.references, x, y, true);
                    continue;
                }
                const auto estimate = coarseBound.bound(largest_, corners, {&upper[index(x)], &lower[index(x)]}, x, y);
                if (!evaluator_.cannotExceed(largest_, estimate.bound))
                    coarselyBounded_.push_back({x, y, estimate.bound, estimate.priority});
            }
            std::swap(upper, lower);
        });
    }
    /// Refines the deferred quads, those first that may raise the maximum most, so that fewer of the others need refinement.
    void refineDeferred() {
        refineCoarselyBounded();
        constexpr std::size_t kFirst = 4;
        std::vector<DeferredQuad> deferred = std::move(deferred_);
        std::ranges::stable_sort(deferred, std::greater{}, &DeferredQuad::diffuse);
        for (std::size_t i = 0; i < std::min(kFirst, deferred.size()); ++i) boundQuad(deferred[i].x, deferred[i].y);
        std::ranges::stable_sort(deferred, std::greater{}, &DeferredQuad::specular);
        for (const DeferredQuad& each : deferred) boundQuad(each.x, each.y);
    }

private:
    void bound(const QuadTexels& texels, const QuadReferences& references, int x, int y, bool mayDefer) {
        if (rows_.decoder().isCurved()) return curved_.bound(texels, references, x, y, largest_);
        for (int corner = 0; corner < 4; ++corner)
            if (rows_.isNewDecode(x, y, corner) && !boundDecode(texels, references, x, y, corner, mayDefer)) return;
    }
    /// Bounds the quad under the decode of one corner. Returns false if the quad was deferred, with its remaining decodes.
    bool boundDecode(const QuadTexels& texels, const QuadReferences& references, int x, int y, int corner, bool mayDefer) {
        const QuadControls quad = QuadControls::ofErrors(rows_.decoder(), rows_.clusterOf(x, y, corner), texels, references, {});
        const Squares squares = largestSquares(quad.values());
        ChannelSlack slack{};
        addRounding(slack, squares, referenceSquares(references));
        addBesideSh(slack, rows_.decoder(), texels);
        if (tolerance_.isNone()) {
            if (evaluator_.cannotExceed(largest_, squares, slack)) return true;
            if (mayDefer) return defer(x, y, squares, slack, references);
            const auto pairs = quad.pairs();
            for (std::size_t c = 0; c < kChannels; ++c) evaluator_.raise(largest_, pairs[c], slack[c], placesOf(x, y, c));
            return true;
        }
        tolerance_.addFilterFractions(slack, references, squares);
        const auto off = tolerance_.quadDeviation(texels, x, y, corner);
        if (evaluator_.cannotExceed(largest_, squares, sumOf(slack, tolerance_.lengthsOf(off, false)))) return true;
        const ChannelSlack all = sumOf(slack, tolerance_.lengthsOf(off, true));
        if (evaluator_.cannotExceed(largest_, squares, all)) return true;
        if (mayDefer) return defer(x, y, squares, all, references);
        addLengths(slack, off.absolute, static_cast<double>(rows_.perKey()));
        raiseWithTolerance(quad.pairs(), references, all, slack, off, x, y);
        return true;
    }
    PairPlaces placesOf(int x, int y, std::size_t channel) const {
        return {static_cast<double>(x), static_cast<double>(y), 1, rows_.decoder().nodes(), static_cast<int>(channel)};
    }
    /// Raises the maximum to the bound of the pairs under the sampler tolerance.
    /// all    slack, the lengths of the deviation's groups included
    /// slack  the same without the groups
    void raiseWithTolerance(const QuadControls::Pairs& pairs, const QuadReferences& references, const ChannelSlack& all,
                            const ChannelSlack& slack, const Deviation& off, int x, int y) {
        if (largest_.isSpent()) {
            for (std::size_t c = 0; c < kChannels; ++c) evaluator_.raiseByLengths(largest_, pairs[c], all[c], placesOf(x, y, c));
            return;
        }
        const SignedGroups groups(off, references, rows_.perKey());
        for (std::size_t c = 0; c < kChannels; ++c) {
            largest_.work += evaluator_.workOf(pairs[c].size()) * static_cast<double>(1 + groups.sums.size());
            GroupedErrors errors(pairs[c], all[c], slack[c], groups, c);
            const auto raiseTo = [&](std::span<const Response> responses, LargestBound& current) {
                if (responses.empty() || errors.cannotExceed(responses, kTieFactor * current.bound)) return;
                BoundPlace found;
                const double bound = errors.bound(responses, current.bound, found);
                current.raise(bound, evaluator_.placeOf(found, bound, placesOf(x, y, c)), found.bands);
            };
            raiseTo({&kExitResponse, 1}, largest_.diffuse);
            raiseTo(evaluator_.setup().responses, largest_.specular);
        }
    }

    /// A quad whose coarse bound may exceed the maximum.
    struct CoarselyBoundedQuad {
        int x, y;
        ErrorBound bound, priority;
    };
    void refineCoarselyBounded() {
        constexpr std::ptrdiff_t kFirst = 16;
        const auto drop = [&] {
            std::erase_if(coarselyBounded_, [&](const CoarselyBoundedQuad& each) { return evaluator_.cannotExceed(largest_, each.bound); });
        };
        const auto boundFirst = [&](auto&& before) {
            const auto end = coarselyBounded_.begin() + std::min(kFirst, std::ssize(coarselyBounded_));
            std::partial_sort(coarselyBounded_.begin(), end, coarselyBounded_.end(), before);
            for (auto each = coarselyBounded_.begin(); each != end; ++each) boundQuad(each->x, each->y);
            drop();
        };
        // NaN comes first.
        const auto above = [](float a, float b) { return !std::isnan(b) && !(a <= b); };
        const auto byDiffuse = [&](const CoarselyBoundedQuad& a, const CoarselyBoundedQuad& b) {
            return above(a.priority.diffuse, b.priority.diffuse);
        };
        const auto bySpecular = [&](const CoarselyBoundedQuad& a, const CoarselyBoundedQuad& b) {
            return above(a.priority.specular, b.priority.specular);
        };
        drop();
        boundFirst(byDiffuse);
        boundFirst(bySpecular);
        std::ranges::stable_sort(coarselyBounded_, bySpecular);
        for (const CoarselyBoundedQuad& each : coarselyBounded_)
            if (!evaluator_.cannotExceed(largest_, each.bound))
                rows_.withQuad(each.x, each.y,
                               [&](const Corners& corners) { bound(corners.texels, corners.references, each.x, each.y, true); });
        coarselyBounded_.clear();
    }

    /// A quad whose control vectors may exceed the maximum, with estimates of its local error as its priority.
    struct DeferredQuad {
        int x, y;
        double diffuse, specular;
    };
    /// Defers quad (x, y). Returns false.
    bool defer(int x, int y, const Squares& error, const ChannelSlack& slack, const QuadReferences& references) {
        constexpr double kInfinite = std::numeric_limits<double>::max();
        DeferredQuad out{x, y, 0, 0};
        const auto raise = [](double& largest, double value) {
            largest = value <= largest ? largest : std::isfinite(value) ? value : kInfinite;
        };
        for (std::size_t c = 0; c < kChannels; ++c) {
            lighting::ShBands lengths = slack[c];
            for (std::size_t l = 0; l < 3; ++l) lengths[l] += outwardLength(error[l][static_cast<int>(c)]);
            double light = 0;
            for (const LcSh* reference : references) light += 0.25 * static_cast<double>(reference->c[0][static_cast<int>(c)]);
            light = std::max(light, 0.0);
            const lighting::ShBands& glossy = evaluator_.setup().largestResponse;
            raise(out.diffuse, bandSum(lengths, kExitNorm) / (kFloor + kExitNorm[0] * light));
            raise(out.specular, bandSum(lengths, glossy) / (kFloor + glossy[0] * light));
        }
        deferred_.push_back(out);
        return false;
    }

    const MapRows& rows_;
    const SamplerTolerance& tolerance_;
    const BoundEvaluator& evaluator_;
    const CurvedBounds curved_;
    LargestBounds largest_;
    std::vector<CoarselyBoundedQuad> coarselyBounded_;
    std::vector<DeferredQuad> deferred_;
};

}  // namespace lightcook::verify::lightmap

// Bounds of the local relative error at the rims of charts, where a filter reaches texels that are not covered. Private to verify/.
//
// The places nearest to a covered texel are a quarter of each quad around it. There error and reference are means, with the same weights,
// of the control vectors of place_light.h, which is what localErrorBound needs. Those of a quarter take up to 25 decodes, and maps of
// small charts have many rims, so coarse bounds come first:
//   1. coarse bound of every quad, from lengths (quad_coarse_bound.h); quads that may exceed the current maximum are kept
//   2. control vectors of the quarters of those, the largest coarse bound first, while they may exceed the maximum
// The bound of a quarter is the smaller of both, so that the maximum does not depend on the order of the quads. When the budget of exact
// bounds is spent (bound_evaluator.h), the coarse bounds of the other quads are theirs.
#pragma once

#include <algorithm>
#include <functional>
#include <limits>
#include <vector>

#include "verify/light_map/bound_evaluator.h"
#include "verify/light_map/place_light.h"
#include "verify/light_map/quad_coarse_bound.h"

namespace lightcook::verify::lightmap {

class RimBounds {
public:
    RimBounds(const MapRows& rows, const SamplerTolerance& tolerance, const BoundEvaluator& evaluator)
        : rows_(rows), tolerance_(tolerance), evaluator_(evaluator), coarse_(rows, tolerance, evaluator) {}

    /// Raises the largest bounds to those of the quads of these rows of which some texels are not covered.
    void raiseRows(int firstRow, int rowCount, LargestBounds& largest) {
        std::vector<CoarselyBoundedQuad> kept;
        forEachCoveredQuad(rows_, firstRow, rowCount, [&](const CoveredQuad& quad) {
            if (quad.isInside() || isOfAnotherQuad(quad)) return;
            const ErrorBound bound = coarseBound(quad, largest);
            if (!evaluator_.cannotExceed(largest, bound)) kept.push_back({quad.x, quad.y, bound});
        });
        // NaN comes first.
        const auto sizeOf = [](const ErrorBound& bound) {
            const float size = std::max(bound.diffuse, bound.specular);
            return size <= std::numeric_limits<float>::max() ? size : std::numeric_limits<float>::infinity();
        };
        std::ranges::stable_sort(kept, std::greater{}, [&](const CoarselyBoundedQuad& each) { return sizeOf(each.bound); });
        for (const CoarselyBoundedQuad& each : kept) {
            if (evaluator_.cannotExceed(largest, each.bound)) continue;
            if (largest.isSpent())
                raiseCoarsely(each, largest);
            else
                withCoveredQuad(rows_, each.x, each.y, [&](const CoveredQuad& quad) { raise(quad, largest); });
        }
    }
    /// Raises the largest bounds to those of a quad of which some texels are not covered.
    void raise(const CoveredQuad& quad, LargestBounds& largest) {
        measure(quad);
        for (int decode = 0; decode < 4; ++decode) {
            if (!quad.isNewDecode(rows_, decode)) continue;
            const ErrorBound coarse = coarseBound(quad, decode, largest);
            if (evaluator_.cannotExceed(largest, coarse)) continue;
            for (int corner = 0; corner < 4; ++corner)
                if (quad.hasQuarter(corner)) raiseQuarter(quad, corner, decode, coarse, largest);
        }
    }

private:
    struct CoarselyBoundedQuad {
        int x, y;
        ErrorBound bound;  ///< of all decodes
    };

    /// Raises the largest bounds to the coarse one of a quad, in its middle.
    static void raiseCoarsely(const CoarselyBoundedQuad& quad, LargestBounds& largest) {
        const auto raiseTo = [&](float error, LargestBound& kind, const Response& response) {
            const double bound = static_cast<double>(error) / kFloor;
            ErrorPlace place;
            place.x = std::max(quad.x + 0.5, 0.0);
            place.y = std::max(quad.y + 0.5, 0.0);
            place.normal = {0, 0, 1};
            place.local = bound >= 0 ? bound : std::numeric_limits<double>::infinity();
            kind.raise(place.local, place, response.bands);
        };
        raiseTo(quad.bound.diffuse, largest.diffuse, kExitResponse);
        raiseTo(quad.bound.specular, largest.specular, kExitResponse);
    }
    /// Returns true for a quad beyond the edge of the map whose light is known to be that at the rim of a quad inside: beyond the edge the
    /// light is that at the edge. The quad inside holds no surface if a chart ends at the texel beside the edge.
    bool isOfAnotherQuad(const CoveredQuad& quad) const {
        const bool isBesideX = rows_.width() > 1 && quad.texelX(0) == quad.texelX(1),
                   isBesideY = rows_.height() > 1 && quad.texelY(0) == quad.texelY(2);
        if (!isBesideX && !isBesideY) return false;
        if (!rows_.hasCharts()) return true;
        if (isBesideY && quad.y > 0) return false;  // a strip may begin at the last row: then it has no quad inside
        const int x = isBesideX ? std::clamp(quad.x, 0, rows_.width() - 2) : quad.x, y = isBesideY ? 0 : quad.y;
        bool holdsSurface = false;
        withCoveredQuad(rows_, x, y, [&](const CoveredQuad& inside) { holdsSurface = inside.coveredCount() > 0; });
        return holdsSurface;
    }
    /// Computes the lengths of the covered corners, and those of the differences of their references.
    void measure(const CoveredQuad& quad) {
        if (!coarse_.isKnown()) return;
        step_ = {};
        for (std::size_t i = 0; i < 4; ++i) {
            if (!quad.covered[i]) continue;
            const LcSh& reference = *quad.corners.references[i];
            const int corner = static_cast<int>(i);
            lengths_[i] = coarse_.lengthsOf(quad.corners.texels[i], reference, quad.texelX(corner), quad.texelY(corner));
            for (std::size_t j = 0; j < i; ++j)
                if (quad.covered[j]) QuadCoarseBound::raise(step_, bandLengths(difference(reference, *quad.corners.references[j])));
        }
    }
    /// Returns an upper bound of the error of a quad under every decode of its covered corners, refined only until it is below the largest.
    ErrorBound coarseBound(const CoveredQuad& quad, const LargestBounds& largest) {
        measure(quad);
        ErrorBound bound;
        for (int decode = 0; decode < 4; ++decode)
            if (quad.isNewDecode(rows_, decode)) bound.raise(coarseBound(quad, decode, largest));
        return bound;
    }
    /// Returns the same under the decode of one corner, for the quad that was measured last.
    ErrorBound coarseBound(const CoveredQuad& quad, int decode, const LargestBounds& largest) const {
        if (!coarse_.isKnown()) return {std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity()};
        const CornerLengths lengths = {{&lengths_[0], &lengths_[1], &lengths_[2], &lengths_[3]}, step_};
        ErrorBound least;
        for (const bool isQuick : {true, false}) {
            const ErrorBound bound = evaluator_.errorBound(coarse_.errorLengths(quad, lengths, decode, isQuick));
            least = isQuick ? bound : ErrorBound{std::min(least.diffuse, bound.diffuse), std::min(least.specular, bound.specular)};
            if (evaluator_.cannotExceed(largest, least)) break;
        }
        return least;
    }
    /// Raises the largest bounds to those of a quarter.
    /// coarse  upper bound of its error
    void raiseQuarter(const CoveredQuad& quad, int corner, int decode, const ErrorBound& coarse, LargestBounds& largest) {
        // Bounds hold for every direction, so light stays in the frame of the world.
        const QuarterLight quarter(rows_, tolerance_, quad, corner, decode, {glm::vec3(1, 0, 0), {0, 1, 0}, {0, 0, 1}});
        const CellLight light = quarter.over(quarter.whole());
        ChannelSlack slack = light.errorSlack;
        addBesideSh(slack, rows_.decoder(), quad.corners.texels);
        ChannelSlack all = slack;
        for (std::size_t c = 0; c < kChannels; ++c)
            for (std::size_t l = 0; l < 3; ++l) {
                slack[c][l] += static_cast<double>(light.deviations.count()) * light.deviations.largest(c)[l];
                if (!light.isFinite) slack[c][l] = std::numeric_limits<double>::infinity();
                all[c][l] = slack[c][l] + light.errors.largest(c)[l];
            }
        if (evaluator_.cannotExceed(largest, Squares{}, all)) return;
        const glm::dvec2 at = glm::dvec2(quad.x, quad.y) + glm::dvec2(quarter.whole().low);
        LargestBounds found = largest;
        pairs_.resize(light.errors.count());
        for (std::size_t c = 0; c < kChannels; ++c) {
            for (std::size_t k = 0; k < pairs_.size(); ++k)
                for (std::size_t i = 0; i < kCoefficients; ++i) {
                    pairs_[k].error[i] = static_cast<float>(light.errors.value(k, c, i));
                    pairs_[k].reference[i] = static_cast<float>(light.references.value(k, c, i));
                }
            evaluator_.raise(found, pairs_, slack[c], {at.x, at.y, 0.5, quarter.nodes(), static_cast<int>(c)});
        }
        const auto take = [&](LargestBound& kind, const LargestBound& raised, float coarseError) {
            ErrorPlace place = raised.place;
            const bool isSamePlace = place.x == kind.place.x && place.y == kind.place.y && place.channel == kind.place.channel;
            if (raised.bound == kind.bound && isSamePlace) return;
            const glm::dvec2 inMap = quad.inMap({place.x - quad.x, place.y - quad.y});
            place.x = inMap.x;
            place.y = inMap.y;
            // Also for NaN, of which nothing is known.
            const double coarseBound = static_cast<double>(coarseError) / kFloor;
            place.local = coarseBound < raised.bound ? coarseBound : raised.bound;
            kind.raise(place.local, place, raised.bands);
        };
        take(largest.diffuse, found.diffuse, coarse.diffuse);
        take(largest.specular, found.specular, coarse.specular);
    }

    const MapRows& rows_;
    const SamplerTolerance& tolerance_;
    const BoundEvaluator& evaluator_;
    QuadCoarseBound coarse_;
    std::array<TexelLengths, 4> lengths_;  ///< of the covered corners of the quad that was measured last
    BandLengths step_{};                   ///< largest differences of their references
    std::vector<ErrorPair> pairs_;         ///< reused
};

}  // namespace lightcook::verify::lightmap

// Bounds of the local relative error at the rims of charts, where a filter reaches texels that are not covered. Private to verify/.
//
// The places nearest to a covered texel are a quarter of each quad around it. There error and reference are means, with the same weights,
// of the control vectors of place_light.h, which is what localErrorBound needs. Uncovered texels make the error of a quarter large where
// their texels are wrong, so these bounds are no closer than those of quads.h, and cost little: few quads are at rims.
#pragma once

#include <vector>

#include "verify/light_map/bound_evaluator.h"
#include "verify/light_map/place_light.h"

namespace lightcook::verify::lightmap {

template <class Layout>
class RimBounds {
public:
    RimBounds(const MapRows<Layout>& rows, const SamplerTolerance<Layout>& tolerance, const BoundEvaluator& evaluator)
        : rows_(rows), tolerance_(tolerance), evaluator_(evaluator) {}

    /// Raises the largest bounds to those of a quad of which some texels are not covered.
    void raise(const CoveredQuad<Layout>& quad, LargestBounds& largest) {
        for (int decode = 0; decode < 4; ++decode) {
            if (!quad.isNewDecode(rows_, decode)) continue;
            for (int corner = 0; corner < 4; ++corner)
                if (quad.hasQuarter(corner)) raiseQuarter(quad, corner, decode, largest);
        }
    }

private:
    void raiseQuarter(const CoveredQuad<Layout>& quad, int corner, int decode, LargestBounds& largest) {
        // Bounds hold for every direction, so light stays in the frame of the world.
        const QuarterLight<Layout> quarter(rows_, tolerance_, quad, corner, decode, {glm::vec3(1, 0, 0), {0, 1, 0}, {0, 0, 1}});
        const CellLight light = quarter.over(quarter.whole());
        ChannelSlack slack = light.errorSlack, all = slack;
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
                for (std::size_t i = 0; i < kCount; ++i) {
                    pairs_[k].error[i] = static_cast<float>(light.errors.value(k, c, i));
                    pairs_[k].reference[i] = static_cast<float>(light.references.value(k, c, i));
                }
            evaluator_.raise(found, pairs_, slack[c], {at.x, at.y, 0.5, QuarterLight<Layout>::kRimNodes, static_cast<int>(c)});
        }
        for (const auto kind : {&LargestBounds::diffuse, &LargestBounds::specular}) {
            ErrorPlace& place = (found.*kind).place;
            const glm::dvec2 inMap = quad.inMap({place.x - quad.x, place.y - quad.y});
            place.x = inMap.x;
            place.y = inMap.y;
            (largest.*kind).raise((found.*kind).bound, place, (found.*kind).bands);
        }
    }

    const MapRows<Layout>& rows_;
    const SamplerTolerance<Layout>& tolerance_;
    const BoundEvaluator& evaluator_;
    std::vector<ErrorPair> pairs_;  ///< reused
};

}  // namespace lightcook::verify::lightmap

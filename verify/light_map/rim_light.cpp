// Light at the outermost places of charts: the edges of the footprints of covered texels, where a filter weighs texels outside charts most.
//
// Random places of the surface reach such an edge by chance only. In a quad with a covered corner C beside one P that is not, it is the
// middle of both (P weighs 1/2); where only a diagonal joins them, the middle of the quad (1/4).
#include <algorithm>
#include <array>

#include "verify/light_map/covered_quad.h"
#include "verify/light_map/light_map_state.h"

namespace lightcook::verify {

using lightmap::CoveredQuad;
using lightmap::MapRows;

std::vector<RimPlace> LightMapVerifier::rimPlaces(const LightMapRows& strip, int firstRow, int rowCount) const {
    const auto decoder = state_->decoderOn(strip.reference);
    const MapRows rows(*decoder, state_->map, strip.texels, strip.reference);
    const float unit = 1 / state_->perKey;
    std::vector<RimPlace> places;
    const auto add = [&](const CoveredQuad& quad, int covered, int outside, const glm::vec2& at) {
        RimPlace place;
        place.covered = {quad.texelX(covered), quad.texelY(covered)};
        place.outside = {quad.texelX(outside), quad.texelY(outside)};
        const auto light = [&](const lightmap::LcSh& sh, lighting::ShRgb& out) {
            for (std::size_t i = 0; i < out.size(); ++i) out[i] = unit * sh.c[i];
        };
        light(quad.referenceAt(at).first, place.reference);
        light(rows.decoded(quad.texelsAt(at).data(), place.covered.x, place.covered.y), place.found);
        places.push_back(place);
    };
    lightmap::forEachCoveredQuad(rows, firstRow, rowCount, [&](const CoveredQuad& quad) {
        if (quad.isCovered()) return;
        const auto isCovered = [&](int corner) { return quad.hasQuarter(corner); };
        for (int outside = 0; outside < 4; ++outside) {
            if (quad.covered[lightmap::index(outside)] || !quad.isOwn(outside)) continue;
            const int beside = outside ^ 1, above = outside ^ 2, diagonal = outside ^ 3;
            const int row = outside / 2, column = outside % 2;
            if (isCovered(beside)) add(quad, beside, outside, {0.5f, static_cast<float>(row)});
            if (isCovered(above)) add(quad, above, outside, {static_cast<float>(column), 0.5f});
            if (!isCovered(beside) && !isCovered(above) && isCovered(diagonal)) add(quad, diagonal, outside, {0.5f, 0.5f});
        }
    });
    return places;
}

}  // namespace lightcook::verify

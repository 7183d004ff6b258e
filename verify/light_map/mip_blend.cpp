// Places between two mip levels: a trilinear sampler filters both levels, mixes the two results, and the shader decodes the mix.
//
// The reference is the same mix of the filtered bakes of both levels. Places lie evenly on the surface and between the levels: random ones
// of each quad of the smaller level, at a random share of both. Those on no texel of the larger level that is covered are on no surface.
#include <glm/common.hpp>

#include "verify/light_map/covered_quad.h"
#include "verify/light_map/light_map_state.h"
#include "verify/light_map/places.h"

namespace lightcook::verify {

using lightmap::CoveredQuad;
using lightmap::FilteredTexels;
using lightmap::MapRows;

ShadedErrors LightMapVerifier::verifyBetween(const LightMapRows& rows, const LightMapVerifier& smaller, const LightMapRows& smallerRows,
                                             int firstRow, int rowCount) const {
    const auto decoder = state_->decoderOn(rows.reference), smallerDecoder = smaller.state_->decoderOn(smallerRows.reference);
    const MapRows larger(*decoder, state_->map, rows.texels, rows.reference);
    const MapRows next(*smallerDecoder, smaller.state_->map, smallerRows.texels, smallerRows.reference);
    const int placesPerTexel = smaller.state_->sampling.placesPerTexel;
    ErrorShader shader(state_->setup.matrices, 1 / static_cast<double>(state_->perKey));
    ShadedErrors errors;
    lightmap::forEachCoveredQuad(next, firstRow, rowCount, [&](const CoveredQuad& quad) {
        for (int sample = 0; sample < placesPerTexel; ++sample) {
            const lightmap::RandomPlace random(smaller.state_->sampling.seed, quad, placesPerTexel, sample);
            const glm::vec2 at = random.inQuad();
            const float share = random.third();
            // Texel x of the smaller level spans texels 2 x and 2 x + 1 of the larger one.
            const glm::dvec2 place = 2.0 * (glm::dvec2(quad.x, quad.y) + glm::dvec2(at)) + 0.5;
            const glm::ivec2 corner(glm::floor(place));
            if (corner.x < -1 || corner.y < -1 || corner.x >= larger.width() || corner.y >= larger.height()) continue;
            lightmap::withCoveredQuad(larger, corner.x, corner.y, [&](const CoveredQuad& fine) {
                const glm::vec2 inFine(place - glm::dvec2(corner));
                const int nearest = lightmap::nearestCorner(inFine);
                if (!fine.hasQuarter(nearest)) return;
                const auto [ofSmaller, weight] = quad.referenceAt(at);
                if (!(weight > 0)) return;
                const lightmap::LcSh reference = lightmap::blend(fine.referenceAt(inFine).first, ofSmaller, share);
                const FilteredTexels a = fine.texelsAt(inFine), b = quad.texelsAt(at);
                const FilteredTexels mixed = lightmap::blend(a.data(), b.data(), share, fine.layers);
                const int x = fine.texelX(nearest), y = fine.texelY(nearest);
                shader.setReference(reference, larger.normalAt(x, y), fine.inMap(glm::dvec2(inFine)));
                shader.add(lightmap::difference(larger.decoded(mixed.data(), x, y), reference), errors);
            });
        }
    });
    return errors;
}

}  // namespace lightcook::verify

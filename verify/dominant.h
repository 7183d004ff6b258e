// What a cooked dominant light is worth: the specular light that the shipped shader makes of direction and intensity as a sampler fetches
// them, against the fit computed here from the float coefficients.
#pragma once

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <vector>

#include "formats/image.h"
#include "formats/light_map.h"
#include "verify/assets/dominant_reference.h"
#include "verify/figures.h"

namespace lightcook::verify {

/// Textures as the manifest describes them: direction = scale * texel + bias, intensity = range * texel.
struct CookedDominant {
    float directionScale = 1, directionBias = 0, intensityRange = 1;
    int width = 0, height = 0;  ///< [texels]
    DominantFit fit = DominantFit::Closed;
};

struct DominantShading {
    std::vector<double> m = {0.1, 0.25, 0.5};
    std::vector<double> f0 = {0.04, 0.6};
    int viewCount = 8;  ///< spherical Fibonacci points of the hemisphere around the normal
    int stride = 1;     ///< every stride-th texel of every stride-th row is shaded
};
/// The stride that keeps a map at about fifty thousand shaded texels.
int dominantStride(int width, int height);

/// Rows of both textures as decodeRows gives them.
struct DecodedDominantRows {
    int firstRow = 0;
    formats::Image<glm::vec4> direction, intensity;
};

/// Partial errors of some rows.
class DominantErrors {
public:
    explicit DominantErrors(double key = 0) : centres_(key), between_(key) {}
    void merge(const DominantErrors& other);
    /// "magnified" (middles of quads of covered texels, against the fit of the four texels' mean) and "total" (texel centres).
    /// All of it is specular. maxBound of each covers every view, every f0 and every m of the shading's range at the places that were
    /// sampled; it is sound and far off, because a microfacet lobe seen at grazing incidence has no bound but 1 / NoL.
    std::vector<StageError> stages() const;
    /// Angle between the stored and the true direction, weighted by the luminance of the true intensity [degrees].
    double meanDirectionError() const;
    double maxDirectionError() const;  ///< [degrees], of texels that are not black
    /// RMS of the highlight that the float coefficients ask for: what relRms of "total" is a part of.
    double referenceRms() const { return centres_.referenceRms(); }
    /// Squared error of the light over the squares of all coefficients: what one light cannot say, and quantization. Of the stored lights,
    /// and of those that the float coefficients ask for.
    double unexplainedStored() const { return energy_ > 0 ? storedError_ / energy_ : 0; }
    double unexplainedReference() const { return energy_ > 0 ? referenceError_ / energy_ : 0; }

private:
    friend class DominantVerifier;
    ErrorAccumulator centres_, between_;
    double angleSum_ = 0, weightSum_ = 0, largestAngle_ = 0;
    double storedError_ = 0, referenceError_ = 0, energy_ = 0;
};

class DominantVerifier {
public:
    DominantVerifier(const CookedDominant& map, const DominantShading& shading, const glm::vec3& luminanceWeights, double key)
        : map_(map), shading_(shading), luminanceWeights_(luminanceWeights), key_(key) {}
    /// The light that a texel holds, as the shader fetches it.
    DominantLightSample decode(const DecodedDominantRows& texels, int x, int y) const;
    /// Rows [firstRow, firstRow + rowCount) and the quads that begin in them: texels and band must also hold the row below, where the
    /// map has one. Pure; safe on several threads.
    DominantErrors verifyRows(const DecodedDominantRows& texels, const formats::LightMapStrip& band, int firstRow, int rowCount) const;

    /// What the texel should hold; seen: what it holds, which settles ties.
    DominantLightSample reference(const lighting::ShRgb& incident, const glm::dvec3& normal, const DominantLightSample& seen) const;

private:
    struct Place;
    void addTexel(const Place& place, const lighting::ShRgb& incident, DominantErrors& errors) const;
    void shade(const Place& place, ErrorAccumulator& errors) const;

    CookedDominant map_;
    DominantShading shading_;
    glm::vec3 luminanceWeights_;
    double key_;
};

}  // namespace lightcook::verify

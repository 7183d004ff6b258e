// Verification of a cooked dominant light: the specular light that the shipped shader computes from sampled direction and intensity,
// against that of the reference fit, which is computed here from the float coefficients and shares nothing with fit/.
// docs/theory/lighting.md, "Dominant light", describes the fit.
#pragma once

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <optional>
#include <vector>

#include "formats/image.h"
#include "formats/light_map.h"
#include "lighting/brdf.h"
#include "lighting/sh.h"
#include "verify/figures.h"
#include "verify/visible.h"

namespace lightcook::verify {

/// A directional light as shaders use it: direction in the unit ball, radiometric delta intensity.
struct DominantLightSample {
    glm::dvec3 direction{0}, intensity{0};
};

/// The fit that a cook declares in its manifest.
enum class DominantFit {
    Closed,         ///< closed form, dominantReference()
    Refined,        ///< best direction of all, refinedReference() without ambient light
    Explained,      ///< the refined light, dimmed where it explains little of the coefficients, explainedReference()
    RefinedAmbient  ///< refinedReference() with ambient light
};

/// Returns the closed form of Chen and Liu, section 1.4.1: v = band 1 / (sqrt(3) lambda_0) of the luminance, inside the unit ball;
/// t = smoothstep(0.02, 0.08, |v|); direction = t v + (1 - t) 0.08 n; intensity = t (4 pi / 9) sum lambda_i Y_i(direction), at least 0.
DominantLightSample dominantReference(const lighting::ShRgb& incident, const glm::dvec3& normal, const glm::vec3& luminanceWeights);

/// Returns the light whose direction minimizes the squared error of all coefficients; its length is that of the closed form's v. At each
/// direction intensity and, if hasAmbient, ambient light are the least-squares solution with neither below 0.
/// The direction comes from a dense search, refined by quadratic fits to stencils. Lights whose relative error (root of the squared error
/// over the norm of the coefficients) is within 1e-3 of the best are equally good; the one nearest to `seen` is returned.
/// seen  the light in the textures; only its direction counts
DominantLightSample refinedReference(const lighting::ShRgb& incident, const glm::dvec3& normal, const glm::vec3& luminanceWeights,
                                     bool hasAmbient, const glm::dvec3& seen);

/// Returns the refined light without ambient light, times 1 - smoothstep(0.3, 0.4, r), where r is the relative error of the best light from
/// its direction.
DominantLightSample explainedReference(const lighting::ShRgb& incident, const glm::dvec3& normal, const glm::vec3& luminanceWeights,
                                       const glm::dvec3& seen);

/// Squared error of a light, and squared norm of the coefficients that it stands for.
struct Unexplained {
    double error = 0, energy = 0;
};
/// Returns the part of the coefficients that `light` does not explain. With ambient light, what the light leaves of coefficient 0 counts as
/// explained, unless it is negative.
Unexplained unexplainedBy(const lighting::ShRgb& incident, const DominantLightSample& light, bool hasAmbient);

/// The cooked textures as their manifest describes them: direction = scale * texel + bias, intensity = range * texel.
struct CookedDominant {
    float directionScale = 1, directionBias = 0, intensityRange = 1;
    int width = 0, height = 0;  ///< of the light map and of the textures [texels]
    DominantFit fit = DominantFit::Closed;
};

struct DominantShading {
    std::vector<double> m = {0.1, 0.25, 0.5};
    std::vector<double> f0 = {0.04, 0.6};
    int viewCount = 8;  ///< spherical Fibonacci points of the hemisphere around the normal
    int stride = 1;     ///< of the middles between texels that are shaded; texel centres are shaded all
    lighting::NormalDistribution lobe = lighting::NormalDistribution::Beckmann;
};
/// Returns the stride at which at most 2^18 middles of a map are shaded: all of a map of 512 x 512. Texel centres are shaded all, whatever
/// the size of the map: a few of them may hold most of its light.
int dominantStride(int width, int height);

/// Rows of both textures, decoded by decodeRows.
struct DecodedDominantRows {
    int firstRow = 0;  ///< of the textures
    formats::Image<glm::vec4> direction, intensity;
};
/// Some rows of a texture.
struct DominantRowRange {
    int first = 0, count = 0;
};
/// Returns the rows of the textures that linear filters read at places from row `first` to row `last` of the light map.
DominantRowRange dominantRowsFor(const CookedDominant& map, double first, double last);

/// Errors of highlights at some places.
struct HighlightErrors {
    ErrorAccumulator energy;
    VisibleAccumulator visible;  ///< without samples where no viewing was given

    void merge(const HighlightErrors& other);
    ErrorFigures figures() const;
};

/// Partial errors of some rows.
class DominantErrors {
public:
    explicit DominantErrors(double key = 0) : centres_{ErrorAccumulator(key), {}}, between_{ErrorAccumulator(key), {}} {}
    void merge(const DominantErrors& other);
    /// Returns stages "magnified" (middles of quads of covered texels of one chart, against the fit of the four texels' mean) and "total"
    /// (texel centres). Both are specular. maxBound covers every view, every f0 and every m of the shading's range, at the sampled places.
    /// It is sound and loose: seen at grazing incidence, a microfacet lobe has no bound but 1 / NoL. Visible errors are of the highlights
    /// alone. Their bound, of "total", is the difference of any two lights that the display shows: between texels, and towards the horizon,
    /// a highlight may be as bright as the display.
    std::vector<StageError> stages() const;
    /// Returns the mean angle between stored and reference direction, weighted by the luminance of the reference intensity [degrees].
    double meanDirectionError() const;
    double maxDirectionError() const;  ///< [degrees], over texels that are not black
    /// Returns the RMS of the reference highlight, the denominator of relRms of "total".
    double referenceRms() const { return centres_.energy.referenceRms(); }
    /// Squared error of the lights over the squared norm of all coefficients: of the stored lights (model error and quantization), and of
    /// the reference lights (model error alone).
    double unexplainedStored() const { return energy_ > 0 ? storedError_ / energy_ : 0; }
    double unexplainedReference() const { return energy_ > 0 ? referenceError_ / energy_ : 0; }

private:
    friend class DominantVerifier;
    HighlightErrors centres_, between_;
    double angleSum_ = 0, weightSum_ = 0, largestAngle_ = 0;
    double storedError_ = 0, referenceError_ = 0, energy_ = 0;
    std::optional<double> visibleBound_;
};

class DominantVerifier {
public:
    /// viewing  empty: no visible errors
    DominantVerifier(const CookedDominant& map, const DominantShading& shading, const glm::vec3& luminanceWeights, double key,
                     const std::optional<Viewing>& viewing = std::nullopt);
    /// Returns the light at a place of the light map, as the shader fetches it with a linear filter.
    /// x, y  [texels of the light map] integers are texel centres
    DominantLightSample decode(const DecodedDominantRows& texels, double x, double y) const;
    /// Returns errors of rows [firstRow, firstRow + rowCount) of the light map and of the quads that begin in them: the strip must also
    /// hold the row below, if the map has one, and the textures every row that its filter reads. Pure; safe on several threads.
    DominantErrors verifyRows(const DecodedDominantRows& texels, const formats::LightMapStrip& strip, int firstRow, int rowCount) const;

    /// Returns the reference light of a texel.
    /// seen  the stored light, which decides between equally good references
    DominantLightSample reference(const lighting::ShRgb& incident, const glm::dvec3& normal, const DominantLightSample& seen) const;

private:
    struct Place;
    DominantLightSample decodeTexel(const DecodedDominantRows& texels, int x, int y) const;
    /// Highlights of a place under every view and material, padded to whole lanes of a DisplayTransform.
    struct Highlights;
    void addTexel(const Place& place, const lighting::ShRgb& incident, Highlights& highlights, DominantErrors& errors) const;
    void shade(const Place& place, Highlights& highlights, HighlightErrors& errors) const;
    void addVisible(const Place& place, Highlights& highlights, VisibleAccumulator& errors) const;

    CookedDominant map_;
    DominantShading shading_;
    glm::vec3 luminanceWeights_;
    double key_;
    std::optional<DisplayTransform> display_;
    std::optional<double> mostVisible_;  ///< difference of any two lights on the display
};

}  // namespace lightcook::verify

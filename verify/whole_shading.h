// The light that a pixel of a light map shows, of all assets together: exit radiance of a white surface at its own normal, area specular,
// and the highlight of the dominant light, which area specular does not have again (shaders/specular.glsl, lcWholeSpecular).
//
// It is a sum of what the light map adds and what the dominant light adds: lcWholeSpecular shades the coefficients less those of the light,
// and area specular is linear. So every pair of cooked assets is shaded by one addition a sample.
#pragma once

#include <cstddef>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <vector>

#include "lighting/sh.h"
#include "verify/dominant.h"
#include "verify/light_map.h"

namespace lightcook::verify {

/// Returns the dominant light that the shipped shader derives from the light map's coefficients at a place.
DominantLightSample derivedLight(const lighting::ShRgb& incident, const glm::vec3& normal);

/// Shades places under every view, m and F0 of a shading. Samples of a place are three planes of stride() values, one a channel:
/// sampleCount() samples, then zeros.
class WholeShader {
public:
    /// Fails as LightMapScore::create does.
    static formats::Result<WholeShader> create(const LightMapShading& shading);
    WholeShader(WholeShader&&) noexcept;
    WholeShader& operator=(WholeShader&&) noexcept;
    ~WholeShader();

    std::size_t sampleCount() const;
    std::size_t stride() const;  ///< a multiple of DisplayTransform::kLanes
    /// Writes the light of a light map alone.
    /// out  3 stride() values
    void shadeLightMap(const lighting::ShRgb& incident, const glm::vec3& normal, std::span<float> out) const;
    /// Writes what a dominant light adds: its highlight, less its area specular. Nothing without specular shading.
    void shadeDominant(const DominantLightSample& light, const glm::vec3& normal, std::span<float> out) const;

private:
    struct State;
    explicit WholeShader(std::unique_ptr<const State> state);
    std::unique_ptr<const State> state_;
};

/// Errors of the whole shading at places, one by one, so that places of several layouts can be put together.
struct WholeErrors {
    std::vector<float> visible;                        ///< [place][sample]
    std::vector<double> squaredErrors, squaredLights;  ///< [place] of all samples and channels

    void append(const WholeErrors& other);
    VisibleFigures visibleFigures() const;
    /// Returns the RMS of the errors over that of the reference; 0 without light.
    double relRms() const;

    template <class Archive, class Self>
    static void members(Archive& archive, Self& self) {
        archive(self.visible, self.squaredErrors, self.squaredLights);
    }
};
/// Returns the errors of samples: of `a` and `b` together against those of the reference.
/// a, b, reference  places of 3 stride values each; b may be empty, for nothing
WholeErrors wholeErrors(std::span<const float> reference, std::span<const float> a, std::span<const float> b, std::size_t sampleCount,
                        std::size_t stride, const Viewing& viewing);

}  // namespace lightcook::verify

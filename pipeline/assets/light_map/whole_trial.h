// The visible error of the whole shading for every pair of a light map's layout and a dominant light's layout, from a few thousand places
// of the surface: what each byte buys, wherever it is spent.
//
// Method: the places lie anywhere in the footprints of covered texels, and light is filtered there as a GPU does. They are shaded once by
// the reference, once by each light-map layout and once by each dominant layout. The light of a pair is the sum of its two parts
// (verify/whole_shading.h), so a pair costs one addition and one comparison a sample, and no encoding. Dominant layouts of one size share a
// fit. If a scene without its dominant light differs by less than kUnseenDominant, no other layout is tried.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/assets/dominant/dominant.h"
#include "pipeline/assets/dominant/encoder.h"
#include "pipeline/assets/light_map/joint_trial.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/light_map/surface_places.h"
#include "pipeline/graph/action.h"
#include "verify/whole_shading.h"

namespace lightcook::pipeline {

/// Visible error (p99, in just noticeable differences) below which a missing dominant light is not seen.
inline constexpr double kUnseenDominant = 0.1;

/// The places of a map, and the light that candidates show there.
class WholeTrial {
public:
    /// strips  of the source, the same that light-map layouts are tried on
    static formats::Result<WholeTrial> create(LightMapSource& source, const std::vector<int>& strips,
                                              const verify::LightMapShading& shading, const verify::Viewing& viewing);

    /// Shades the reference and the dominant layouts. Without `dominant` the reference has no dominant light.
    formats::Result<void> tryDominants(const std::optional<DominantTrial>& dominant, const DominantParameters& parameters,
                                       const ActionContext& context);
    /// Returns the places of a strip as a decoded light map lights them. Pure; safe on several threads.
    /// key  of the verifier
    std::vector<float> shadeLightMap(const verify::LightMapVerifier& verifier, double key, const verify::DecodedLightMapRows& rows,
                                     const formats::LightMapStrip& texels, int strip) const;
    /// Notes the light of all places under a light-map layout.
    void add(std::string layout, std::vector<float> samples) { lightMaps_.push_back({std::move(layout), std::move(samples)}); }

    const std::vector<DominantCandidate>& dominants() const { return dominants_; }
    /// Returns the errors of all pairs, light maps in the order of add().
    std::vector<WholeCandidate> pairs(const ActionContext& context) const;

private:
    struct Lit {
        std::string layout;
        std::vector<float> samples;  ///< [place][channel][sample]; empty: no light
    };
    WholeTrial(LightMapSource& source, std::vector<int> strips, verify::WholeShader shader, const verify::Viewing& viewing);

    /// The places of one strip under the reference, and under the dominant layouts of one size.
    struct LitStrip {
        std::vector<float> bake, light;             ///< of the reference
        std::vector<std::vector<float>> dominants;  ///< [layout]
    };
    formats::Result<LitStrip> shadeBake(int strip, const std::optional<verify::DominantFit>& fit) const;
    formats::Result<LitStrip> shadeStrip(int strip, const DominantEncoder& encoder, const std::vector<const DominantLayoutInfo*>& layouts,
                                         verify::DominantFit fit) const;
    formats::Result<void> shadeReference(const std::optional<verify::DominantFit>& fit, const ActionContext& context);
    formats::Result<void> tryDivisor(const DominantEncoder& encoder, const std::vector<const DominantLayoutInfo*>& layouts,
                                     verify::DominantFit fit, const ActionContext& context);
    void addDominant(std::string_view layout, std::uint64_t bytes, std::vector<float> samples);
    double visibleOf(const std::vector<float>& a, const std::vector<float>& b) const;

    LightMapSource* source_;
    std::vector<int> strips_;
    verify::WholeShader shader_;
    verify::Viewing viewing_;
    SurfacePlaces places_;
    std::vector<float> bake_;              ///< the places lit by the bake's coefficients
    std::vector<float> light_;             ///< what the reference's dominant light adds; empty without one
    std::vector<float> reference_;         ///< their sum
    std::vector<Lit> lightMaps_, lights_;  ///< lights_ in the order of dominants_
    std::vector<DominantCandidate> dominants_;
};

}  // namespace lightcook::pipeline

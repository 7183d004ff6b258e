// The visible error of the whole shading for every pair of a light map's layout and a dominant light's layout, from a few thousand places
// of the surface: what each byte buys, wherever it is spent.
//
// Method: the places lie anywhere in the footprints of covered texels, and light is filtered there as a GPU does. They are shaded once by
// the reference, once by each light-map layout and once by each dominant layout. The light of a pair is the sum of its two parts
// (verify/whole_shading.h), so a pair costs one addition and one comparison a sample, and no encoding. Dominant layouts of one size share a
// fit. If a scene without its dominant light differs by less than kUnseenDominant, no other layout is tried.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pipeline/assets/dominant/dominant.h"
#include "pipeline/assets/dominant/encoder.h"
#include "pipeline/assets/light_map/joint_trial.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/light_map/surface_places.h"
#include "pipeline/assets/light_map/trial_rows.h"
#include "pipeline/graph/action.h"
#include "verify/whole_shading.h"

namespace lightcook::pipeline {

/// Visible error (p99, in just noticeable differences) below which a missing dominant light is not seen.
inline constexpr double kUnseenDominant = 0.1;

/// The places of a map, and the light that candidates show there.
class WholeTrial {
public:
    /// first, rest  rows of the source: those that every light-map layout is tried on, and those that some are tried on then
    static formats::Result<WholeTrial> create(LightMapSource& source, std::vector<TrialRows> first, std::vector<TrialRows> rest,
                                              const verify::LightMapShading& shading, const verify::Viewing& viewing);

    /// Shades the reference and the dominant layouts. Without `dominant` the reference has no dominant light.
    formats::Result<void> tryDominants(const std::optional<DominantTrial>& dominant, const DominantParameters& parameters,
                                       const ActionContext& context);
    /// Returns the places of some rows as a decoded light map lights them: of each place the samples of the map, and those of the light
    /// that the shader derives from it, if that is tried. Pure; safe on several threads. key  of the verifier
    std::vector<float> shadeLightMap(const verify::LightMapVerifier& verifier, double key, const verify::DecodedLightMapRows& decoded,
                                     const formats::LightMapStrip& texels, const TrialRows& rows) const;
    /// Adds the light of the places of the first rows under a light-map layout, or then that of the rest.
    /// samples  of shadeLightMap()
    void add(const std::string& layout, const std::vector<float>& samples);

    /// Adds a layout with detail: the light of the first rows is that of `detail` in the tiles that have it, else that of `layout`.
    /// tiles  ascending
    void addDetailed(const std::string& name, const std::string& layout, const std::string& detail,
                     const std::vector<std::uint32_t>& tiles);

    const std::vector<DominantCandidate>& dominants() const { return dominants_; }
    /// Returns the errors of a light-map layout with each layout of the dominant light, at the places that were added.
    std::vector<WholeCandidate> pairsOf(const std::string& layout, const ActionContext& context) const;

private:
    struct Lit {
        std::string layout = {};
        std::vector<float> samples = {};  ///< [place][channel][sample], places of the first rows before those of the rest; empty: no light
        std::vector<float> derived = {};  ///< of a light map: what the light derived from it adds
    };
    WholeTrial(LightMapSource& source, std::vector<TrialRows> first, std::vector<TrialRows> rest, verify::WholeShader shader,
               const verify::Viewing& viewing);

    /// The places of some rows of one strip under the reference, and under the dominant layouts of one size.
    struct LitRows {
        std::vector<float> bake, light;             ///< of the reference
        std::vector<float> derived;                 ///< of the light derived from the bake
        std::vector<std::uint32_t> tiles;           ///< of the places: texels of texture "coverage"
        std::vector<std::vector<float>> dominants;  ///< [layout]
    };
    /// The places of one strip.
    struct LitStrip {
        LitRows first, rest;
    };
    using ShadeRows = std::function<LitRows(const std::vector<SurfacePlace>& places)>;
    /// Shades the places of the first rows and of the rest of a strip.
    formats::Result<LitStrip> shadeStrip(int strip, const ShadeRows& shade) const;
    /// Shades all strips, and appends the samples of the first rows of all, and then those of the rest.
    template <class Shade, class Append>
    formats::Result<void> shadeStrips(const ActionContext& context, const std::string& what, Shade shade, Append append) const;
    LitRows shadeBake(const std::vector<SurfacePlace>& places, const std::optional<verify::DominantFit>& fit) const;
    formats::Result<LitStrip> shadeDominants(int strip, const DominantEncoder& encoder,
                                             const std::vector<const DominantLayoutInfo*>& layouts, verify::DominantFit fit) const;
    formats::Result<void> shadeReference(const std::optional<verify::DominantFit>& fit, const ActionContext& context);
    formats::Result<void> tryDivisor(const DominantEncoder& encoder, const std::vector<const DominantLayoutInfo*>& layouts,
                                     verify::DominantFit fit, const ActionContext& context);
    void addDominant(std::string_view layout, std::uint64_t bytes, std::vector<float> samples);
    double visibleOf(std::span<const float> a, std::span<const float> b) const;

    LightMapSource* source_;
    std::vector<TrialRows> first_, rest_;
    std::vector<int> strips_;  ///< that have some of these rows
    verify::WholeShader shader_;
    verify::Viewing viewing_;
    SurfacePlaces places_;
    std::vector<float> bake_;           ///< the places lit by the bake's coefficients
    std::vector<float> light_;          ///< what the reference's dominant light adds; empty without one
    std::vector<float> reference_;      ///< their sum
    std::vector<std::uint32_t> tiles_;  ///< of the places
    std::vector<float> derived_;        ///< what the light derived from the bake adds
    bool isDerivedTried_ = false;
    std::vector<Lit> lightMaps_, lights_;  ///< lights_ in the order of dominants_
    std::vector<DominantCandidate> dominants_;
};

}  // namespace lightcook::pipeline

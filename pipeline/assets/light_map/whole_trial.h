// The visible error of the whole shading under every layout of a light map, from a few thousand places of the surface: what each byte buys,
// wherever it is spent.
//
// Method: the places lie anywhere in the footprints of covered texels, and light is filtered there as a GPU does. They are shaded once by
// the reference, and once by each layout of the light map. What a dominant light adds (verify/whole_shading.h) is derived from each
// layout's own coefficients, or is that of the stored light, which is encoded and shaded once.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
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

/// The places of a map, and the light that candidates show there.
class WholeTrial {
public:
    /// first, rest  rows of the source: those that every light-map layout is tried on, and those that some are tried on then
    static formats::Result<WholeTrial> create(LightMapSource& source, std::vector<TrialRows> first, std::vector<TrialRows> rest,
                                              const verify::LightMapShading& shading, const verify::Viewing& viewing);

    /// Shades the reference and, if it is stored, the dominant light.
    /// dominant    empty: pixels show none
    /// parameters  of a stored light
    formats::Result<void> start(const std::optional<DominantTrial>& dominant, const DominantParameters& parameters,
                                const ActionContext& context);
    /// Returns the samples of the places of some rows as a decoded light map lights them, with the light that is derived from it. Pure;
    /// safe on several threads. key  of the verifier
    std::vector<float> shadeLightMap(const verify::LightMapVerifier& verifier, double key, const verify::DecodedLightMapRows& decoded,
                                     const formats::LightMapStrip& texels, const TrialRows& rows) const;
    /// Adds the light of the places of the first rows under a light-map layout, or then that of the rest.
    /// samples  of shadeLightMap()
    void add(const std::string& layout, const std::vector<float>& samples);

    /// Returns the errors of a light-map layout at the places that were added.
    WholeCandidate candidateOf(const std::string& layout) const;
    /// Returns those of a layout with detail: the errors of the first rows are those of `detail` in the tiles that have it, else those of
    /// `layout`.
    /// tiles  ascending
    WholeCandidate candidateWith(const std::string& name, const std::string& layout, const std::string& detail,
                                 const std::vector<std::uint32_t>& tiles) const;

private:
    WholeTrial(LightMapSource& source, std::vector<TrialRows> first, std::vector<TrialRows> rest, verify::WholeShader shader,
               const verify::Viewing& viewing);

    /// The places of some rows of one strip.
    struct LitRows {
        std::vector<float> samples;        ///< of the reference, or of the stored light
        std::vector<std::uint32_t> tiles;  ///< of the places: texels of texture "coverage"
    };
    /// The places of one strip.
    struct LitStrip {
        LitRows first, rest;
    };
    using ShadeRows = std::function<LitRows(const std::vector<SurfacePlace>& places)>;
    /// Shades the places of the first rows and of the rest of a strip.
    formats::Result<LitStrip> shadeStrip(int strip, const ShadeRows& shade) const;
    /// Shades all strips. Returns the samples of the first rows of all, and then those of the rest.
    template <class Shade>
    formats::Result<LitRows> shadeStrips(const ActionContext& context, const std::string& what, Shade shade) const;
    LitRows shadeBake(const std::vector<SurfacePlace>& places, const std::optional<verify::DominantFit>& fit) const;
    formats::Result<LitStrip> shadeStored(int strip, const DominantEncoder& encoder, verify::DominantFit fit) const;

    LightMapSource* source_;
    std::vector<TrialRows> first_, rest_;
    std::vector<int> strips_;  ///< that have some of these rows
    verify::WholeShader shader_;
    verify::Viewing viewing_;
    SurfacePlaces places_;
    bool isDerived_ = false;                             ///< the dominant light
    std::vector<float> reference_;                       ///< [place][channel][sample], places of the first rows before those of the rest
    std::vector<std::uint32_t> tiles_;                   ///< of the places
    std::vector<float> stored_;                          ///< what the stored light adds; empty without one
    std::map<std::string, verify::WholeErrors> errors_;  ///< by layout
};

}  // namespace lightcook::pipeline

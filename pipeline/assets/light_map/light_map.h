// Light maps: cook one in bands, open it again, verify it, give it back as a bake.
#pragma once

#include "formats/gpu_texture.h"
#include "formats/light_map.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/graph/action.h"
#include "verify/light_map.h"

namespace lightcook::pipeline {

/// "light-map". Input "source", and "mesh" where the layout learns and the map has one; parameters: asset, description, layout, target,
/// textures.
formats::Result<ActionOutcome> cookLightMap(const ActionContext& context);
/// "verify-light-map". Input "source"; upstream: the cooked light map; parameters: max_error, shading, samples.
formats::Result<ActionOutcome> verifyLightMap(const ActionContext& context);

/// Log-average luminance of a bake's exit radiance: the key of every error figure.
formats::Result<double> surveyKey(LightMapSource& bake, const ActionContext& context);

/// A cooked light map, opened from its manifest entry and the files beside it.
class CookedLightMapReader {
public:
    static formats::Result<CookedLightMapReader> open(const std::filesystem::path& folder, const Json& asset,
                                                      const verify::LightMapShading& shading, const verify::LightMapSampling& sampling,
                                                      double key);
    const verify::LightMapVerifier& verifier() const { return verifier_; }
    int width() const { return width_; }
    int height() const { return height_; }
    /// Decoded texels from firstRow (a multiple of 16) on: at least rowCount rows, as far as the map has them.
    formats::Result<verify::DecodedLightMapRows> read(int firstRow, int rowCount) const;

private:
    CookedLightMapReader(verify::LightMapVerifier verifier, int width, int height)
        : verifier_(std::move(verifier)), width_(width), height_(height) {}
    verify::LightMapVerifier verifier_;
    std::vector<formats::TextureReader> textures_;
    int width_, height_;
};

/// What the materials shade with, as parameters.
Json toJson(const verify::LightMapShading& shading);
verify::LightMapShading shadingFromJson(const Json& json);

}  // namespace lightcook::pipeline

// Fits and encodes the dominant light of a light map, strip by strip: what the cook writes and what a trial decodes at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "compress/encode.h"
#include "fit/filtered_light.h"
#include "pipeline/assets/dominant/dominant.h"
#include "pipeline/scene/dominant_fit.h"

namespace lightcook::pipeline {

/// Formats of the textures under a target.
struct DominantFormats {
    formats::PixelFormat direction, intensity;
    bool hasResidual;  ///< directions are stored as (v + 1) / 2, and a second texture may hold the residual of the first one
};
DominantFormats dominantFormatsOf(formats::Target target);

struct DominantFitCounts {
    fit::DominantCounts texels;
    std::int64_t solved = 0;  ///< covered texels whose light was solved with that of their neighbours
    void add(const DominantFitCounts& other);
};

/// Blocks of some rows of each texture.
struct EncodedDominantRows {
    int firstRow = 0, rowCount = 0;                         ///< of the textures
    std::vector<std::byte> direction, residual, intensity;  ///< residual: empty without that texture
    compress::EncodeReport report;
    DominantFitCounts fitted;
};

/// The lights of one map.
class DominantEncoder {
public:
    /// Measures the map.
    static formats::Result<DominantEncoder> create(LightMapSource& source, const DominantParameters& parameters,
                                                   const ActionContext& context);

    const DominantFormats& formats() const { return formats_; }
    const DominantConstants& constants() const { return constants_; }
    bool hasResidual() const { return constants_.residualScale != 0; }
    glm::ivec2 size() const { return {source_->width(), source_->height()}; }  ///< of the textures
    fit::DominantFit fit() const { return options_.light.fit; }
    /// Encodes the rows of a strip of the source. Pure; safe on several threads.
    formats::Result<EncodedDominantRows> encode(int strip) const;

private:
    explicit DominantEncoder(LightMapSource& source) : source_(&source) {}

    LightMapSource* source_;
    fit::FilteredLightOptions options_;
    DominantFormats formats_{};
    DominantConstants constants_;
    compress::EncodeOptions encodeOptions_;
};

}  // namespace lightcook::pipeline

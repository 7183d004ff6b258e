// A cooked dominant light, opened again.
#pragma once

#include <filesystem>
#include <glm/vec2.hpp>
#include <optional>

#include "formats/gpu_texture.h"
#include "pipeline/assets/cooked_asset.h"
#include "pipeline/assets/dominant/dominant.h"
#include "verify/dominant.h"

namespace lightcook::pipeline {

/// Reads and decodes a cooked dominant light from its manifest entry and the files beside it.
class CookedDominantReader {
public:
    /// Refuses textures that are not as large as the light map.
    /// lightMap  its width and height [texels]
    static formats::Result<CookedDominantReader> open(const std::filesystem::path& folder, const CookedAsset& asset,
                                                      const glm::ivec2& lightMap);
    /// Size, decode and fit.
    const verify::CookedDominant& map() const { return map_; }
    bool hasResidual() const { return residual_.has_value(); }

    struct Rows {
        verify::DecodedDominantRows whole;   ///< as the shader reads them, with the residual
        verify::DecodedDominantRows coarse;  ///< without the residual
    };
    /// Decodes every row that filters read at the rows [firstRow, firstRow + rowCount] of the light map. Refuses texels that are not
    /// finite.
    formats::Result<Rows> read(int firstRow, int rowCount) const;

private:
    CookedDominantReader(std::string name, formats::TextureReader direction, formats::TextureReader intensity,
                         const DominantConstants& constants)
        : name_(std::move(name)), direction_(std::move(direction)), intensity_(std::move(intensity)), constants_(constants) {}
    std::string name_;  ///< of the asset
    formats::TextureReader direction_, intensity_;
    std::optional<formats::TextureReader> residual_;
    DominantConstants constants_;
    verify::CookedDominant map_;
};

}  // namespace lightcook::pipeline

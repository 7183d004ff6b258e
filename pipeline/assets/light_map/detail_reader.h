// Detail of a cooked light map (formats/light_map_detail.h), opened again.
#pragma once

#include <filesystem>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>
#include <map>
#include <string>
#include <vector>

#include "formats/gpu_texture.h"
#include "formats/image.h"
#include "pipeline/assets/cooked_asset.h"
#include "verify/light_map.h"

namespace lightcook::pipeline {

/// Constants of a light map's decode, as compress::LightMapPlan::constants.
using LightMapConstants = std::map<std::string, std::vector<float>>;

class DetailReader {
public:
    static formats::Result<DetailReader> open(const std::filesystem::path& folder, const CookedAsset& asset);
    /// Returns what the verifier needs to know of it.
    const verify::CookedDetail& cooked() const { return cooked_; }
    /// Returns the texels of rows [firstRow, firstRow + rowCount).
    formats::Result<verify::DetailTexels> read(int firstRow, int rowCount) const;

private:
    DetailReader(const CookedAsset& asset, formats::TextureReader coverage);
    /// Reads texels of the second layer of texture "coverage".
    formats::Result<formats::Image<glm::vec4>> readPlaces(int firstTileRow, int tileRows) const;
    /// Decodes row `row` of the tiles of a texture's layer.
    formats::Result<formats::Image<glm::vec4>> readTiles(const formats::TextureReader& texture, int layer, int row) const;

    std::string asset_;
    verify::CookedDetail cooked_;
    formats::TextureReader coverage_;
    std::vector<formats::TextureReader> textures_;
    int width_;         ///< of the map [texels]
    glm::ivec2 tiles_;  ///< of the detail's textures, along each axis
};

}  // namespace lightcook::pipeline

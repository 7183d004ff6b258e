// Detail of a light map (formats/light_map_detail.h): which tiles have it, and their textures.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "compress/light_map.h"
#include "formats/light_map_detail.h"
#include "pipeline/assets/light_map/light_map.h"
#include "pipeline/assets/light_map/survey.h"
#include "pipeline/assets/textures.h"
#include "verify/light_map.h"

namespace lightcook::pipeline {

/// Share of the samples of a map that may err by more than its limit, less what tiles beside each other mix.
inline constexpr double kOverLimit = 0.0095;

/// Errors of a map that may have detail, and those of its detail.
struct DetailErrors {
    const verify::LightMapErrors::Stage &map, &detail;  ///< with tiles, of the same places
    std::size_t limit;                                  ///< index in TileErrors::limits()
};
/// Returns the fewest tiles whose detail brings a map to its limit: at most kOverLimit of its samples err by more. Nothing where no detail
/// does. Tiles are in ascending order.
/// tiles  of the map
std::optional<std::vector<std::uint32_t>> tilesWithin(const DetailErrors& errors, std::size_t tiles);

/// A map's detail.
struct DetailPlan {
    compress::LightMapPlan plan;       ///< of layout formats::kDetailLayout, for the whole map
    std::vector<std::uint32_t> tiles;  ///< that have detail, ascending; at least one

    formats::DetailAtlas atlas() const { return {static_cast<int>(tiles.size())}; }
    std::vector<std::byte> places() const;  ///< texels of that layer
    std::uint64_t gpuBytes() const;         ///< with the second layer of texture "coverage"
    /// Returns the bytes of a plan's detail with so many tiles.
    static std::uint64_t gpuBytes(const compress::LightMapPlan& plan, std::size_t tiles);

    template <class Archive, class Self>
    static void members(Archive& archive, Self& self) {
        archive(self.plan, self.tiles);
    }
};
/// Finds the tiles that need detail, from the errors of both plans on the whole map. Nothing where none does, or where detail is no help.
/// map     plan of the map
/// detail  plan of formats::kDetailLayout
formats::Result<std::optional<DetailPlan>> planDetail(LightMapSource& source, const compress::LightMapPlan& map,
                                                      compress::LightMapPlan detail, const DetailParameters& parameters,
                                                      const MapSurvey& survey, const compress::EncodeOptions& options,
                                                      const ActionContext& context);
/// Encodes the detail, and writes its textures.
/// metadata  constants of the detail's decode
formats::Result<compress::EncodeReport> writeDetail(LightMapSource& source, const DetailPlan& detail, const TextureSettings& settings,
                                                    const Json& metadata, AssetTextures& textures, const ActionContext& context);

}  // namespace lightcook::pipeline

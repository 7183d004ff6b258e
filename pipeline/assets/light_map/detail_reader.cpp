#include "pipeline/assets/light_map/detail_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "formats/light_map_detail.h"
#include "pipeline/assets/textures.h"
#include "shaders/lightcook_cpp.h"
#include "verify/texture_unit.h"

namespace lightcook::pipeline {

using formats::ErrorCode;
using formats::failure;
using formats::kCoverageColumns;
using formats::kCoverageRows;
using formats::Result;

DetailReader::DetailReader(const CookedAsset& asset, formats::TextureReader coverage)
    : asset_(asset.name), coverage_(std::move(coverage)), width_(asset.width) {
    const formats::DetailAtlas atlas{static_cast<int>(asset.detail->tiles)};
    tiles_ = {atlas.columns(), atlas.rows()};
}

Result<DetailReader> DetailReader::open(const std::filesystem::path& folder, const CookedAsset& asset) {
    const CookedTiles& detail = *asset.detail;
    const std::string_view layout = formats::info(formats::kDetailLayout).name;
    if (detail.layout != layout)
        return failure(ErrorCode::Verification, asset.name, fmt::format("found detail in layout '{}', expected {}", detail.layout, layout));
    auto constants = checkedJson(detail.constants, asset.name + ", detail, constants", [](const JsonPlace& root) {
        LightMapConstants values;
        readValue(root, values, {});
        return values;
    });
    if (!constants) return tl::make_unexpected(constants.error());
    LC_TRY(coverage, openTexture(folder, asset, std::string(formats::kCoverageRole)));
    if (coverage->shape().layerCount != formats::kDetailedCoverageLayers)
        return failure(ErrorCode::Verification, fmt::format("{}, texture {}", asset.name, formats::kCoverageRole),
                       fmt::format("found {} layers, expected {}, as a map with detail has", coverage->shape().layerCount,
                                   formats::kDetailedCoverageLayers));
    DetailReader reader(asset, std::move(*coverage));
    reader.cooked_.constants = std::move(*constants);
    const glm::ivec2 size = reader.tiles_ * glm::ivec2(kCoverageColumns, kCoverageRows);
    for (const formats::DetailTextureInfo& each : formats::kDetailTextures) {
        LC_TRY(texture, openTexture(folder, asset, std::string(each.name)));
        const formats::TextureShape& shape = texture->shape();
        if (shape.width != size.x || shape.height != size.y || shape.layerCount != formats::layersOf(each))
            return failure(ErrorCode::Verification, fmt::format("{}, texture {}", asset.name, each.name),
                           fmt::format("found {} x {} with {} layers, expected {} x {} with {}, as {} tiles of detail have", shape.width,
                                       shape.height, shape.layerCount, size.x, size.y, formats::layersOf(each), detail.tiles));
        for (const formats::LightMapTextureInfo& part : formats::info(formats::kDetailLayout).textures)
            if (part.role == each.role) reader.cooked_.formats.push_back(shape.format);
        reader.textures_.push_back(std::move(*texture));
    }
    return reader;
}

Result<formats::Image<glm::vec4>> DetailReader::readPlaces(int firstTileRow, int tileRows) const {
    const int across = formats::coverageSize(width_, 1).x;
    std::vector<std::byte> bytes(formats::bytesPerBlockRow(formats::PixelFormat::Rgba8Unorm, across) * static_cast<std::size_t>(tileRows));
    LC_CHECK(coverage_.readBlockRows({0, 1, 0}, firstTileRow, bytes));
    formats::Image<glm::vec4> texels(across, tileRows);
    verify::decodeRows(formats::PixelFormat::Rgba8Unorm, bytes, texels.view());
    return texels;
}

Result<formats::Image<glm::vec4>> DetailReader::readTiles(const formats::TextureReader& texture, int layer, int row) const {
    const formats::PixelFormat format = texture.shape().format;
    const int blockRows = kCoverageRows / formats::info(format).blockHeight, width = texture.shape().width;
    std::vector<std::byte> bytes(formats::bytesPerBlockRow(format, width) * static_cast<std::size_t>(blockRows));
    LC_CHECK(texture.readBlockRows({0, layer, 0}, row * blockRows, bytes));
    formats::Image<glm::vec4> texels(width, kCoverageRows);
    verify::decodeRows(format, bytes, texels.view());
    return texels;
}

Result<verify::DetailTexels> DetailReader::read(int firstRow, int rowCount) const {
    const int firstTileRow = firstRow / kCoverageRows, tileRows = (firstRow + rowCount + kCoverageRows - 1) / kCoverageRows - firstTileRow;
    LC_TRY(places, readPlaces(firstTileRow, tileRows));
    verify::DetailTexels out;
    out.has = formats::Image<std::uint8_t>(width_, rowCount);
    std::map<int, std::vector<glm::ivec2>> tilesOfRow;  // [row of tiles in the detail's textures] tiles of the map
    for (int y = 0; y < tileRows; ++y)
        for (int x = 0; x < places->width(); ++x) {
            if (!shaders::lcHasDetail(places->at(x, y))) continue;
            const glm::ivec2 tile(x, firstTileRow + y), size(kCoverageColumns, kCoverageRows);
            const glm::ivec2 place = glm::ivec2(shaders::lcDetailTexel(places->at(x, y), glm::vec2(tile * size))) / size;
            if (place.x >= tiles_.x || place.y >= tiles_.y)
                return failure(ErrorCode::Verification, fmt::format("{}, texture {}", asset_, formats::kCoverageRole),
                               fmt::format("found detail of tile ({}, {}) in column {} and row {}, expected less than {} and {}", tile.x,
                                           tile.y, place.x, place.y, tiles_.x, tiles_.y));
            tilesOfRow[place.y].push_back(tile);
        }
    // Calls work(x, row, texel of the detail) for the texels of a tile that are in these rows.
    const auto forEachTexel = [&](const glm::ivec2& tile, const auto& work) {
        const glm::vec4& place = places->at(tile.x, tile.y - firstTileRow);
        for (int y = std::max(firstRow, kCoverageRows * tile.y); y < std::min(firstRow + rowCount, kCoverageRows * (tile.y + 1)); ++y)
            for (int x = kCoverageColumns * tile.x; x < std::min(width_, kCoverageColumns * (tile.x + 1)); ++x)
                work(x, y - firstRow, glm::ivec2(shaders::lcDetailTexel(place, glm::vec2(x, y))));
    };
    std::array<int, formats::kDetailTextures.size()> layer{};
    for (const formats::LightMapTextureInfo& part : formats::info(formats::kDetailLayout).textures) {
        const std::size_t which = part.role == formats::kDetailTextures[0].role ? 0 : 1;
        std::vector<formats::Image<glm::vec4>>& layers = out.textures.emplace_back();
        for (int i = 0; i < part.layerCount; ++i, ++layer[which]) {
            formats::Image<glm::vec4>& image = layers.emplace_back(width_, rowCount);
            for (const auto& each : tilesOfRow) {
                const int row = each.first;
                LC_TRY(texels, readTiles(textures_[which], layer[which], row));
                for (const glm::ivec2& tile : each.second)
                    forEachTexel(tile, [&](int x, int y, const glm::ivec2& at) {
                        image.at(x, y) = texels->at(at.x, at.y - kCoverageRows * row);
                        out.has.at(x, y) = 1;
                    });
            }
        }
    }
    return out;
}

}  // namespace lightcook::pipeline

#include "pipeline/assets/light_map/detail.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "compress/light_map_context.h"
#include "pipeline/assets/light_map/decoded_rows.h"
#include "pipeline/assets/light_map/kept_plan.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/graph/parallel_for.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::kCoverageColumns;
using formats::kCoverageRows;
using formats::Result;
using Kind = verify::TileErrors::Kind;

constexpr std::array kKinds = {Kind::Diffuse, Kind::Specular};

/// Returns the errors of the last stage of a plan on the whole map, with those of its tiles.
Result<verify::LightMapErrors::Stage> errorsOf(LightMapSource& source, const compress::LightMapPlan& plan,
                                               const DetailParameters& parameters, const MapSurvey& survey,
                                               const compress::EncodeOptions& options, const ActionContext& context) {
    const verify::Viewing viewing{parameters.view.display.of(survey.key.displayKey()), source.bt2020FromWorking()};
    verify::LightMapSampling sampling;
    sampling.figures = verify::LightMapFigures::Trial;
    sampling.isLastStageAlone = true;
    sampling.tileLimits = {static_cast<float>(parameters.limit)};
    LC_TRY(verifier, verify::LightMapVerifier::create(cookedMapOf(plan), parameters.view.shading, sampling, plan.key, viewing));
    const StripEncoder encoder(plan, options, context);
    verify::LightMapErrors errors = verifier->noErrors();
    const auto verified = foldInOrder<verify::LightMapErrors>(
        source.stripCount(), context, fmt::format("look for detail of {}", context.action.asset),
        [&](int index) -> Result<verify::LightMapErrors> {
            // Places below the last row are filtered from the next one too.
            LC_TRY(rows, planStrip(source, encoder, index));
            return verifier->verifyRows(rows->decoded, rows->texels, source.stripFirstRow(index), source.stripRows(index));
        },
        [&](const verify::LightMapErrors& part) { errors.merge(part); });
    if (!verified) return tl::make_unexpected(verified.error());
    return std::move(errors.stages.back());
}

/// Blocks of some tiles, of each layer of the textures of formats::kDetailTextures.
using TileBlocks = std::vector<std::vector<std::vector<std::byte>>>;  // [texture][layer]

formats::PixelFormat formatOf(const compress::LightMapPlan& plan, const formats::DetailTextureInfo& texture) {
    return formats::formatFor(texture.role, formats::info(plan.target));
}

/// Number and size of the blocks of a tile.
struct TileShape {
    std::size_t across, down, blockBytes;
    explicit TileShape(formats::PixelFormat format)
        : across(static_cast<std::size_t>(kCoverageColumns / formats::info(format).blockWidth)),
          down(static_cast<std::size_t>(kCoverageRows / formats::info(format).blockHeight)),
          blockBytes(static_cast<std::size_t>(formats::info(format).bytesPerBlock)) {}
    std::size_t rowBytes() const { return across * blockBytes; }
    std::size_t bytes() const { return down * rowBytes(); }
};
/// Returns room for some tiles.
TileBlocks roomFor(const compress::LightMapPlan& plan, std::size_t tiles) {
    TileBlocks blocks;
    for (const formats::DetailTextureInfo& texture : formats::kDetailTextures)
        blocks.emplace_back(static_cast<std::size_t>(formats::layersOf(texture)),
                            std::vector<std::byte>(tiles * TileShape(formatOf(plan, texture)).bytes()));
    return blocks;
}

/// Returns the tiles of some rows of the map.
std::span<const std::uint32_t> tilesOfRows(const std::vector<std::uint32_t>& tiles, int tilesAcross, int firstRow, int rowCount) {
    const auto before = [&](int row) {
        return std::ranges::lower_bound(tiles, static_cast<std::uint32_t>(row / kCoverageRows * tilesAcross));
    };
    return {before(firstRow), before(firstRow + rowCount + kCoverageRows - 1)};
}

/// A tile of the map: its first texel.
glm::ivec2 placeOf(std::uint32_t tile, int tilesAcross) {
    const int number = static_cast<int>(tile);
    return {number % tilesAcross * kCoverageColumns, number / tilesAcross * kCoverageRows};
}

/// Copies the blocks of a tile. The map may end within it.
/// rows   whole rows of blocks of a map of this width, from firstRow on
/// place  of the tile
void copyTile(formats::PixelFormat format, const std::vector<std::byte>& rows, int mapWidth, int firstRow, const glm::ivec2& place,
              std::byte* to) {
    const formats::PixelFormatInfo& info = formats::info(format);
    const TileShape shape(format);
    const std::size_t rowBytes = formats::bytesPerBlockRow(format, mapWidth);
    const std::size_t column = static_cast<std::size_t>(place.x / info.blockWidth) * shape.blockBytes;
    std::size_t from = static_cast<std::size_t>((place.y - firstRow) / info.blockHeight) * rowBytes + column;
    for (std::size_t y = 0; y < shape.down && from < rows.size(); ++y, from += rowBytes, to += shape.rowBytes())
        std::copy_n(rows.data() + from, std::min(shape.rowBytes(), rowBytes - column), to);
}

using EncodedTiles = std::pair<TileBlocks, compress::EncodeReport>;

/// Encodes some tiles of the map.
/// strip     rows [firstRow, firstRow + rowCount), which hold the tiles, and those around them that the encoder reads
EncodedTiles encodeTiles(const compress::LightMapPlan& plan, const compress::EncodeOptions& options, std::span<const std::uint32_t> tiles,
                         formats::LightMapStrip strip, int firstRow, int rowCount) {
    const int across = formats::coverageSize(plan.width, plan.height).x;
    TileBlocks blocks = roomFor(plan, tiles.size());
    // Other texels are not stored. Each texel is encoded alone, so that they are no matter.
    formats::Image<std::uint8_t> covered(strip.covered.width(), strip.covered.height());
    for (const std::uint32_t tile : tiles) {
        const glm::ivec2 place = placeOf(tile, across);
        for (int y = place.y; y < std::min(place.y + kCoverageRows, firstRow + rowCount); ++y)
            for (int x = place.x; x < std::min(place.x + kCoverageColumns, plan.width); ++x)
                covered.at(x, y - strip.firstRow) = strip.covered.at(x, y - strip.firstRow);
    }
    strip.covered = std::move(covered);
    const auto rows = compress::encodeLightMapRows(plan, strip, firstRow, rowCount, options);
    for (std::size_t detailTexture = 0; detailTexture < blocks.size(); ++detailTexture) {
        const formats::DetailTextureInfo& info = formats::kDetailTextures[detailTexture];
        std::size_t to = 0;
        for (std::size_t texture = 0; texture < plan.textures.size(); ++texture) {
            if (formats::info(plan.layout).textures[texture].role != info.role) continue;
            for (const std::vector<std::byte>& layer : rows.textures[texture].layers) {
                std::vector<std::byte>& out = blocks[detailTexture][to++];
                for (std::size_t i = 0; i < tiles.size(); ++i)
                    copyTile(formatOf(plan, info), layer, plan.width, firstRow, placeOf(tiles[i], across),
                             out.data() + i * TileShape(formatOf(plan, info)).bytes());
            }
        }
    }
    return std::pair(std::move(blocks), rows.report);
}

/// Writes tiles side by side, row after row of them, as they come.
class TileWriter {
public:
    TileWriter(const DetailPlan& detail, std::size_t firstTexture, AssetTextures& textures)
        : plan_(detail.plan),
          columns_(static_cast<std::size_t>(detail.atlas().columns())),
          firstTexture_(firstTexture),
          textures_(textures),
          rows_(roomFor(plan_, columns_)) {}
    Result<void> add(const TileBlocks& blocks) {
        const std::size_t count = blocks.front().front().size() / shapeOf(0).bytes();
        for (std::size_t i = 0; i < count; ++i) {
            for (std::size_t texture = 0; texture < rows_.size(); ++texture) {
                const TileShape shape = shapeOf(texture);
                for (std::size_t layer = 0; layer < rows_[texture].size(); ++layer)
                    for (std::size_t y = 0; y < shape.down; ++y)
                        std::copy_n(blocks[texture][layer].data() + i * shape.bytes() + y * shape.rowBytes(), shape.rowBytes(),
                                    rows_[texture][layer].data() + (y * columns_ + column_) * shape.rowBytes());
            }
            if (++column_ == columns_) LC_CHECK(finishRow());
        }
        return {};
    }
    /// Writes the last row, if it is not whole.
    Result<void> finish() { return column_ == 0 ? Result<void>() : finishRow(); }

private:
    TileShape shapeOf(std::size_t texture) const { return TileShape(formatOf(plan_, formats::kDetailTextures[texture])); }
    Result<void> finishRow() {
        for (std::size_t texture = 0; texture < rows_.size(); ++texture)
            for (std::size_t layer = 0; layer < rows_[texture].size(); ++layer) {
                std::vector<std::byte>& row = rows_[texture][layer];
                const int firstBlockRow = row_ * static_cast<int>(shapeOf(texture).down);
                LC_CHECK(textures_.writer(firstTexture_ + texture).writeBlockRows({0, static_cast<int>(layer), 0}, firstBlockRow, row));
                std::ranges::fill(row, std::byte{0});
            }
        column_ = 0;
        ++row_;
        return {};
    }

    const compress::LightMapPlan& plan_;
    std::size_t columns_, firstTexture_, column_ = 0;
    int row_ = 0;
    AssetTextures& textures_;
    TileBlocks rows_;
};

}  // namespace

std::optional<std::vector<std::uint32_t>> tilesWithin(const DetailErrors& errors, std::size_t tiles) {
    // Samples over the limit as shares of those that may be.
    struct Gain {
        std::uint32_t tile;
        std::array<double, 2> saved;
    };
    std::array<double, 2> over{}, perSample{};
    const verify::ShadedErrors& all = errors.map.errors;
    for (const Kind kind : kKinds) {
        const auto samples = static_cast<double>((kind == Kind::Diffuse ? all.visibleDiffuse : all.visibleSpecular).sampleCount());
        perSample[static_cast<std::size_t>(kind)] = samples > 0 ? 1 / (kOverLimit * samples) : 0;
    }
    std::vector<Gain> gains;
    for (std::size_t tile = 0; tile < tiles; ++tile) {
        Gain gain{static_cast<std::uint32_t>(tile), {}};
        for (const Kind kind : kKinds) {
            const auto k = static_cast<std::size_t>(kind);
            const std::int64_t before = errors.map.tiles.over(tile, kind, errors.limit),
                               after = errors.detail.tiles.over(tile, kind, errors.limit);
            over[k] += perSample[k] * static_cast<double>(before);
            gain.saved[k] = perSample[k] * static_cast<double>(before - after);
        }
        if (gain.saved[0] > 0 || gain.saved[1] > 0) gains.push_back(gain);
    }
    // Light that is within the limit already gains nothing.
    const auto worthOf = [over](const Gain& gain) { return (over[0] > 1 ? gain.saved[0] : 0) + (over[1] > 1 ? gain.saved[1] : 0); };
    std::ranges::stable_sort(gains, [&](const Gain& a, const Gain& b) { return worthOf(a) > worthOf(b); });
    std::vector<std::uint32_t> chosen;
    for (const Gain& gain : gains) {
        if (over[0] <= 1 && over[1] <= 1) break;
        for (std::size_t k = 0; k < over.size(); ++k) over[k] -= gain.saved[k];
        chosen.push_back(gain.tile);
    }
    if (over[0] > 1 || over[1] > 1) return std::nullopt;
    std::ranges::sort(chosen);
    return chosen;
}

std::uint64_t DetailPlan::gpuBytes(const compress::LightMapPlan& plan, std::size_t tiles) {
    if (tiles == 0) return 0;
    const formats::DetailAtlas atlas{static_cast<int>(tiles)};
    const glm::ivec2 map = formats::coverageSize(plan.width, plan.height);
    std::uint64_t bytes = formats::bytesPerImage(formats::PixelFormat::Rgba8Unorm, map.x, map.y);
    for (const formats::DetailTextureInfo& texture : formats::kDetailTextures)
        bytes += static_cast<std::uint64_t>(formats::layersOf(texture)) *
                 formats::bytesPerImage(formatOf(plan, texture), atlas.width(), atlas.height());
    return bytes;
}

std::uint64_t DetailPlan::gpuBytes() const {
    return gpuBytes(plan, tiles.size());
}

std::vector<std::byte> DetailPlan::places() const {
    const glm::ivec2 map = formats::coverageSize(plan.width, plan.height);
    std::vector<std::byte> texels(formats::bytesPerImage(formats::PixelFormat::Rgba8Unorm, map.x, map.y));
    const auto columns = static_cast<std::size_t>(atlas().columns());
    for (std::size_t i = 0; i < tiles.size(); ++i) {
        std::byte* const texel = texels.data() + 4 * static_cast<std::size_t>(tiles[i]);
        texel[0] = static_cast<std::byte>(i % columns);
        texel[1] = static_cast<std::byte>(i / columns % 256);
        texel[2] = static_cast<std::byte>(i / columns / 256);
        texel[3] = std::byte{255};
    }
    return texels;
}

Result<std::optional<DetailPlan>> planDetail(LightMapSource& source, const compress::LightMapPlan& map, compress::LightMapPlan detail,
                                             const DetailParameters& parameters, const MapSurvey& survey,
                                             const compress::EncodeOptions& options, const ActionContext& context) {
    LC_TRY(ofMap, errorsOf(source, map, parameters, survey, options, context));
    LC_TRY(ofDetail, errorsOf(source, detail, parameters, survey, options, context));
    const glm::ivec2 tiles = formats::coverageSize(map.width, map.height);
    auto chosen = tilesWithin({*ofMap, *ofDetail, 0}, static_cast<std::size_t>(tiles.x) * static_cast<std::size_t>(tiles.y));
    if (!chosen || chosen->size() > formats::kMostDetailTiles)
        return failure(
            ErrorCode::Verification, context.action.asset,
            fmt::format("found more than 1 % of the samples above a visible error of {:.3g} even with detail in every tile, expected a "
                        "larger max_visible, or a finer layout, such as {}",
                        parameters.limit, formats::info(formats::LightMapLayout::Hdr2).name));
    if (chosen->empty()) return std::optional<DetailPlan>();
    return std::optional(DetailPlan{std::move(detail), std::move(*chosen)});
}

Result<compress::EncodeReport> writeDetail(LightMapSource& source, const DetailPlan& detail, const TextureSettings& settings,
                                           const Json& metadata, AssetTextures& textures, const ActionContext& context) {
    std::optional<std::size_t> firstTexture;
    for (const formats::DetailTextureInfo& texture : formats::kDetailTextures) {
        formats::TextureShape shape;
        shape.format = formatOf(detail.plan, texture);
        shape.width = detail.atlas().width();
        shape.height = detail.atlas().height();
        shape.layerCount = formats::layersOf(texture);
        shape.isArray = true;
        const std::string role(texture.name);
        LC_TRY(created, textures.create({role, fmt::format("{}_{}", context.action.asset, role), shape, metadata, "nearest"}));
        if (!firstTexture) firstTexture = *created;
    }
    TileWriter writer(detail, *firstTexture, textures);
    const StripEncoder encoder(detail.plan, settings.encodeOptions(), context);
    compress::EncodeReport report;
    Result<void> written;
    const auto encodeStrip = [&](int index) -> Result<EncodedTiles> {
        const int firstRow = source.stripFirstRow(index), rowCount = source.stripRows(index);
        const auto tiles = tilesOfRows(detail.tiles, formats::coverageSize(detail.plan.width, 1).x, firstRow, rowCount);
        if (tiles.empty()) return EncodedTiles(roomFor(detail.plan, 0), {});
        return encoder.partOf(source, index, digestOf(std::vector(tiles.begin(), tiles.end())),
                              [&](formats::LightMapStrip strip) -> Result<EncodedTiles> {
                                  return encodeTiles(detail.plan, encoder.options(), tiles, std::move(strip), firstRow, rowCount);
                              });
    };
    LC_CHECK(foldInOrder<EncodedTiles>(source.stripCount(), context, "encode detail of " + context.action.asset, encodeStrip,
                                       [&](const EncodedTiles& strip) {
                                           if (written) written = writer.add(strip.first);
                                           report.add(strip.second);
                                       }));
    if (!written) return tl::make_unexpected(written.error());
    LC_CHECK(writer.finish());
    return report;
}

}  // namespace lightcook::pipeline

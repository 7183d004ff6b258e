#include "pipeline/assets/light_map/cooked_light_map.h"

#include <fmt/format.h>

#include <algorithm>

#include "formats/chart_clusters.h"
#include "formats/digest.h"
#include "formats/light_map_layout.h"
#include "pipeline/assets/light_map/light_map.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/light_map/strip_digest.h"
#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/assets/textures.h"
#include "shaders/lightcook_cpp.h"
#include "verify/sampler_tolerance.h"
#include "verify/texture_unit.h"

namespace lightcook::pipeline {

using formats::ErrorCode;
using formats::failure;
using formats::Result;

Result<std::vector<std::uint8_t>> clustersOfBlocks(const std::filesystem::path& folder, const CookedAsset& asset) {
    std::vector<std::uint8_t> clusters;
    const auto layout = formats::lightMapLayoutFromName(asset.layout);
    if (!layout || !formats::info(*layout).isLearned() || hasClustersInMesh(asset)) return clusters;
    LC_TRY(texture, openTexture(folder, asset, kIndexRole));
    const formats::TextureShape& shape = texture->shape();
    const int across = indexWidth(asset.width), down = indexHeight(asset.height);
    if (shape.width != across || shape.height != down || shape.format != formats::PixelFormat::Rgba8Unorm)
        return failure(ErrorCode::Verification, fmt::format("{}, texture {}", asset.name, kIndexRole),
                       fmt::format("found {} x {} texels of {}, expected {} x {} of rgba8-unorm: a byte for each block of 4 x 4",
                                   shape.width, shape.height, formats::info(shape.format).name, across, down));
    LC_TRY(image, verify::decodeImage(*texture, {}));
    const glm::vec2 size(asset.width, asset.height);
    for (int y = 0; y < asset.height; y += formats::kClusterBlock)
        for (int x = 0; x < asset.width; x += formats::kClusterBlock) {
            const glm::vec2 uv = (glm::vec2(x, y) + 0.5f) / size;
            const glm::ivec2 texel(shaders::lcBasisIndexUv(uv, size) * glm::vec2(across, down));
            clusters.push_back(static_cast<std::uint8_t>(shaders::lcBasisCluster(image->at(texel.x, texel.y), uv, size)));
        }
    return clusters;
}

Result<LightMapConstants> constantsOf(const std::filesystem::path& folder, const CookedAsset& asset) {
    Json inManifest = asset.constants.value_or(Json());
    if (inManifest.is_object()) inManifest.erase(kTablesRole);
    auto constants = checkedJson(inManifest, asset.name + ", constants", [](const JsonPlace& root) {
        LightMapConstants values;
        readValue(root, values, {});
        return values;
    });
    const auto layout = formats::lightMapLayoutFromName(asset.layout);
    if (!constants || !layout || !formats::info(*layout).isLearned()) return constants;
    LC_TRY(texture, openTexture(folder, asset, kTablesRole));
    const formats::TextureShape& shape = texture->shape();
    const formats::LightMapLayoutInfo& row = formats::info(*layout);
    if (shape.width != row.tableFactors() || shape.format != formats::PixelFormat::Rgba16f)
        return failure(ErrorCode::Verification, fmt::format("{}, texture {}", asset.name, kTablesRole),
                       fmt::format("found {} columns of {}, expected {} of rgba16f: the factors of a cluster of {}", shape.width,
                                   formats::info(shape.format).name, row.tableFactors(), asset.layout));
    LC_TRY(image, verify::decodeImage(*texture, {}));
    const auto append = [&](std::vector<float>& values, int firstColumn, int columns) {
        for (int y = 0; y < image->height(); ++y)
            for (int x = firstColumn; x < firstColumn + columns; ++x)
                for (int c = 0; c < 3; ++c) values.push_back(image->at(x, y)[c]);
    };
    std::vector<float>&code = (*constants)["code"], &residual = (*constants)["residual"];
    code.clear();
    residual.clear();
    append(code, 0, row.codeFactors());
    for (int layer = 0; layer < row.residualCount(); ++layer)
        append(residual, row.codeFactors() + layer * row.kResidualFactors, row.kResidualFactors);
    return constants;
}

Result<CookedLightMapReader> CookedLightMapReader::open(const std::filesystem::path& folder, const CookedAsset& asset,
                                                        const VerifierSettings& settings) {
    LC_TRY(clusters, clustersOfBlocks(folder, asset));
    verify::CookedLightMap map;
    map.clusterOfBlock = std::move(*clusters);
    return openMap(folder, asset, 0, std::move(map), settings);
}

Result<CookedLightMapReader> CookedLightMapReader::openMip(const std::filesystem::path& folder, const CookedAsset& asset, int mip,
                                                           std::vector<std::uint8_t> clusterOfTexel, const VerifierSettings& settings) {
    verify::CookedLightMap map;
    map.clusterOfBlock = std::move(clusterOfTexel);
    map.clusterBlock = 1;
    return openMap(folder, asset, mip, std::move(map), settings);
}

Result<CookedLightMapReader> CookedLightMapReader::openMap(const std::filesystem::path& folder, const CookedAsset& asset, int mip,
                                                           verify::CookedLightMap map, const VerifierSettings& settings) {
    LC_TRY(constants, constantsOf(folder, asset));
    map.layout = asset.layout;
    map.filter = asset.filter.value_or(map.filter);
    map.constants = std::move(*constants);
    map.width = asset.width >> mip;
    map.height = asset.height >> mip;
    LC_TRY(needs, verify::LightMapVerifier::texturesOf(map));
    std::vector<formats::TextureReader> textures;
    for (const auto& need : *needs) {
        LC_TRY(texture, openTexture(folder, asset, need.name));
        const formats::TextureShape& shape = texture->shape();
        const glm::ivec2 size = formats::textureSize(asset.width, asset.height, need.side);
        if (shape.layerCount != need.layerCount || shape.width != size.x || shape.height != size.y)
            return failure(ErrorCode::Verification, fmt::format("{}, texture {}", asset.name, need.name),
                           fmt::format("found {} x {} with {} layers, expected {} x {} with {}", shape.width, shape.height,
                                       shape.layerCount, size.x, size.y, need.layerCount));
        if (shape.mipCount <= mip)
            return failure(ErrorCode::Verification, fmt::format("{}, texture {}", asset.name, need.name),
                           fmt::format("found {} mip levels, expected at least {}, as its other textures have", shape.mipCount, mip + 1));
        map.formats.push_back(shape.format);
        textures.push_back(std::move(*texture));
    }
    std::optional<formats::TextureReader> coverage;
    if (formats::info(*formats::lightMapLayoutFromName(asset.layout)).filterFor(map.filter) == formats::LightMapFilter::Decoded) {
        LC_TRY(texture, openTexture(folder, asset, std::string(formats::kCoverageRole)));
        const formats::TextureShape& shape = texture->shape();
        const glm::ivec2 size = formats::coverageSize(asset.width, asset.height);
        if (shape.width != size.x || shape.height != size.y || shape.format != formats::PixelFormat::Rgba8Unorm || shape.mipCount <= mip)
            return failure(
                ErrorCode::Verification, fmt::format("{}, texture {}", asset.name, formats::kCoverageRole),
                fmt::format("found {} x {} texels of {} with {} mip levels, expected {} x {} of rgba8-unorm with {} or more", shape.width,
                            shape.height, formats::info(shape.format).name, shape.mipCount, size.x, size.y, mip + 1));
        coverage = std::move(*texture);
    }
    std::optional<DetailReader> detail;
    if (asset.detail && mip == 0) {
        LC_TRY(opened, DetailReader::open(folder, asset));
        map.detail = opened->cooked();
        detail = std::move(*opened);
    }
    LC_TRY(verifier, verify::LightMapVerifier::create(map, settings.shading, settings.sampling, settings.key, settings.viewing));
    return CookedLightMapReader(std::move(*verifier), digestOf(map, settings), std::move(textures), std::move(coverage), std::move(detail),
                                map.width, map.height, mip);
}

Result<CookedLightMapReader::BlockRows> CookedLightMapReader::readCoverageBlocks(int firstRow, int rowCount) const {
    const int first = firstRow / formats::kCoverageRows, end = (firstRow + rowCount + formats::kCoverageRows - 1) / formats::kCoverageRows;
    BlockRows rows{{formats::coverageSize(width_, height_).x, end - first}, {}};
    auto& texels = rows.layers.emplace_back(formats::bytesPerImage(formats::PixelFormat::Rgba8Unorm, rows.size.x, rows.size.y));
    LC_CHECK(coverage_->readBlockRows({mip_, 0, 0}, first, texels));
    return rows;
}

/// Reads the bits of texture "coverage", as the shader does.
Result<formats::Image<std::uint8_t>> CookedLightMapReader::readCoverage(int firstRow, int rowCount) const {
    LC_TRY(stored, readCoverageBlocks(firstRow, rowCount));
    const int firstTexelRow = firstRow / formats::kCoverageRows;
    formats::Image<glm::vec4> texels(stored->size.x, stored->size.y);
    verify::decodeRows(formats::PixelFormat::Rgba8Unorm, stored->layers.front(), texels.view());
    formats::Image<std::uint8_t> covered(width_, rowCount);
    for (int y = 0; y < rowCount; ++y)
        for (int x = 0; x < width_; ++x) {
            const glm::vec2 texel(x, firstRow + y);
            const glm::ivec2 at(shaders::lcCoverageTexel(texel));
            covered.at(x, y) = static_cast<std::uint8_t>(shaders::lcCovered(texels.at(at.x, at.y - firstTexelRow), texel));
        }
    return covered;
}

Result<CookedLightMapReader::BlockRows> CookedLightMapReader::readBlocks(std::size_t index, int firstRow, int rowCount) const {
    const formats::TextureReader& texture = textures_[index];
    const int side = verifier_.textures()[index].side, firstTexelRow = firstRow / side;
    const glm::ivec2 size = formats::textureSize(width_, height_, side);
    const formats::PixelFormat format = texture.shape().format;
    const int blockHeight = formats::info(format).blockHeight;
    const int blockRows = formats::blocksDown(format, (firstRow + rowCount + side - 1) / side - firstTexelRow);
    BlockRows rows{{size.x, std::min(blockRows * blockHeight, size.y - firstTexelRow)}, {}};
    for (int layer = 0; layer < texture.shape().layerCount; ++layer) {
        auto& blocks = rows.layers.emplace_back(formats::bytesPerBlockRow(format, size.x) * static_cast<std::size_t>(blockRows));
        LC_CHECK(texture.readBlockRows({mip_, layer, 0}, firstTexelRow / blockHeight, blocks));
    }
    return rows;
}

Result<verify::DecodedLightMapRows> CookedLightMapReader::read(int firstRow, int rowCount) const {
    verify::DecodedLightMapRows rows;
    rows.firstRow = firstRow;
    rowCount = std::min(rowCount, height_ - firstRow);
    for (std::size_t i = 0; i < textures_.size(); ++i) {
        const formats::PixelFormat format = textures_[i].shape().format;
        LC_TRY(stored, readBlocks(i, firstRow, rowCount));
        std::vector<formats::Image<glm::vec4>> layers, spans;
        for (const std::vector<std::byte>& blocks : stored->layers) {
            layers.emplace_back(stored->size.x, stored->size.y);
            verify::decodeRows(format, blocks, layers.back().view());
            spans.push_back(verify::blockSpans(format, blocks, stored->size.x));
        }
        rows.textures.push_back(std::move(layers));
        rows.spans.push_back(std::move(spans));
    }
    if (coverage_) {
        LC_TRY(covered, readCoverage(firstRow, rowCount));
        rows.covered = std::move(*covered);
    }
    if (detail_) {
        LC_TRY(detail, detail_->read(firstRow, rowCount));
        rows.detail = std::move(*detail);
    }
    return rows;
}

Result<std::string> CookedLightMapReader::digestOfRows(int firstRow, int rowCount) const {
    formats::Digest digest;
    rowCount = std::min(rowCount, height_ - firstRow);
    const auto add = [&](const BlockRows& stored) {
        for (const std::vector<std::byte>& blocks : stored.layers) digest.add(std::span(blocks));
    };
    for (std::size_t i = 0; i < textures_.size(); ++i) {
        LC_TRY(stored, readBlocks(i, firstRow, rowCount));
        add(*stored);
    }
    if (coverage_) {
        LC_TRY(stored, readCoverageBlocks(firstRow, rowCount));
        add(*stored);
    }
    if (detail_) {
        LC_TRY(detail, detail_->read(firstRow, rowCount));
        digest.add(std::span(detail->has.texels()));
        for (const auto& layers : detail->textures)
            for (const auto& layer : layers) digest.add(std::span(layer.texels()));
    }
    return digestOf(firstRow, rowCount, digest.text());
}

Result<CookedStrip> readStrip(LightMapSource& bake, const CookedLightMapReader& cooked, int index) {
    const int firstRow = bake.stripFirstRow(index), rowCount = bake.stripRows(index);
    LC_TRY(reference, bake.stripWithMargin(index, 0, 1));
    LC_TRY(texels, cooked.read(firstRow, rowCount + 1));
    auto seen = cooked.verifier().reconstruct(*texels, firstRow, rowCount, 1, &*reference);
    return CookedStrip{firstRow, rowCount, std::move(*reference), std::move(*texels), std::move(seen)};
}

}  // namespace lightcook::pipeline

#include "pipeline/assets/dominant/cooked_dominant.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "pipeline/scene/dominant_fit.h"
#include "shaders/lightcook_cpp.h"
#include "verify/texture_unit.h"

namespace lightcook::pipeline {
namespace {

using formats::Image;
using formats::Result;

/// Decodes rows of a texture, from firstRow (a multiple of the block height) on: at least rowCount, as far as the map has them. Refuses
/// texels that are not finite: a filter spreads them, and errors are not measured at every texel.
Result<Image<glm::vec4>> readRows(const formats::TextureReader& texture, const std::string& name, int firstRow, int rowCount) {
    const formats::TextureShape& shape = texture.shape();
    const int blockHeight = formats::info(shape.format).blockHeight;
    const int blockRows = formats::blocksDown(shape.format, std::min(rowCount, shape.height - firstRow));
    Image<glm::vec4> rows(shape.width, std::min(blockRows * blockHeight, shape.height - firstRow));
    std::vector<std::byte> blocks(formats::bytesPerBlockRow(shape.format, shape.width) * static_cast<std::size_t>(blockRows));
    LC_CHECK(texture.readBlockRows({}, firstRow / blockHeight, blocks));
    verify::decodeRows(shape.format, blocks, rows.view());
    for (int y = 0; y < rows.height(); ++y)
        for (int x = 0; x < rows.width(); ++x) {
            const glm::vec4& texel = rows.at(x, y);
            if (std::isfinite(texel.x) && std::isfinite(texel.y) && std::isfinite(texel.z)) continue;
            return formats::failure(
                formats::ErrorCode::Verification, fmt::format("{}, texel ({}, {})", name, x, firstRow + y),
                fmt::format("found ({}, {}, {}), expected finite numbers: cook the scene again", texel.x, texel.y, texel.z));
        }
    return rows;
}

Image<glm::vec4> copyOf(const Image<glm::vec4>& image) {
    Image<glm::vec4> copy(image.width(), image.height());
    std::ranges::copy(image.texels(), copy.texels().begin());
    return copy;
}

}  // namespace

void addResidual(Image<glm::vec4>& directions, const Image<glm::vec4>& residual, const DominantConstants& constants) {
    for (std::size_t i = 0; i < residual.texels().size(); ++i)
        directions.texels()[i] = glm::vec4(shaders::lcDominantStored(glm::vec3(directions.texels()[i]), glm::vec3(residual.texels()[i]),
                                                                     constants.residualScale, constants.residualCentre),
                                           1.0f);
}

Result<CookedDominantReader> CookedDominantReader::open(const std::filesystem::path& folder, const CookedAsset& asset,
                                                        const glm::ivec2& lightMap) {
    LC_TRY(constants, fromJson<DominantConstants>(asset.constants.value_or(Json()), asset.name + ", constants"));
    LC_TRY(fit, dominantFitOf(asset.name, asset.fit.value_or("halo3")));
    LC_TRY(direction, openTexture(folder, asset, "direction"));
    LC_TRY(intensity, openTexture(folder, asset, "intensity"));
    CookedDominantReader reader(asset.name, std::move(*direction), std::move(*intensity), *constants);
    if (constants->residualScale != 0) {
        LC_TRY(residual, openTexture(folder, asset, "residual"));
        reader.residual_ = std::move(*residual);
    }
    const auto check = [&](const formats::TextureReader& texture) -> Result<void> {
        const glm::ivec2 found(texture.shape().width, texture.shape().height);
        if (found == lightMap) return {};
        return formats::failure(
            formats::ErrorCode::Verification, asset.name,
            fmt::format("found a texture of {} x {} texels, expected {} x {} as the source", found.x, found.y, lightMap.x, lightMap.y));
    };
    LC_CHECK(check(reader.direction_));
    LC_CHECK(check(reader.intensity_));
    if (reader.residual_) LC_CHECK(check(*reader.residual_));
    reader.map_ = {constants->directionScale, constants->directionBias, constants->intensityRange, lightMap.x, lightMap.y,
                   (*fit)->verified};
    return reader;
}

Result<CookedDominantReader::Rows> CookedDominantReader::read(int firstRow, int rowCount) const {
    const verify::DominantRowRange needed = verify::dominantRowsFor(map_, firstRow, firstRow + rowCount);
    const int blockHeight = formats::info(direction_.shape().format).blockHeight;
    const int first = needed.first / blockHeight * blockHeight, count = needed.first + needed.count - first;
    LC_TRY(directions, readRows(direction_, name_ + ", texture direction", first, count));
    LC_TRY(intensities, readRows(intensity_, name_ + ", texture intensity", first, count));
    verify::DecodedDominantRows coarse{first, copyOf(*directions), copyOf(*intensities)};
    if (residual_) {
        LC_TRY(residual, readRows(*residual_, name_ + ", texture residual", first, count));
        addResidual(*directions, *residual, constants_);
    }
    return Rows{{first, std::move(*directions), std::move(*intensities)}, std::move(coarse)};
}

}  // namespace lightcook::pipeline

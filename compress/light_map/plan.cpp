// Plans: the textures of a layout from the table, its constants from the measure.
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "compress/light_map/basis/model.h"
#include "compress/light_map/families.h"

namespace lightcook::compress {

using formats::LightMapFamily;

namespace rows {

LightMapPlan emptyPlan(formats::LightMapLayout layout, const MeasuredLightMap& map) {
    LightMapPlan plan;
    plan.layout = layout;
    plan.target = map.target;
    plan.width = map.width;
    plan.height = map.height;
    plan.objective = map.objective;
    plan.filter = formats::info(layout).filterFor(map.filter);
    plan.key = map.measure.key();
    for (const formats::LightMapTextureInfo& texture : formats::info(layout).textures)
        plan.textures.push_back(
            {std::string(texture.name), formats::formatFor(texture.role, formats::info(map.target)), texture.layerCount, texture.side});
    return plan;
}

float halfRange(float largest) {
    if (!(largest > 0)) return 1;
    int exponent = 0;
    // Light whose coefficient 0 is close to the largest float is infinite itself. largest = mantissa 2^exponent, mantissa in [0.5, 1).
    const float mantissa = std::frexp(std::min(largest, std::numeric_limits<float>::max()), &exponent);
    if (mantissa == 0.5f) --exponent;
    return std::ldexp(1.0f, exponent - 14);
}

}  // namespace rows

namespace {

/// Returns the GPU memory of the vertex attribute or the texture "index" that names the clusters [bytes].
std::size_t clusterBytes(const LightMapPlan& plan) {
    return plan.vertexBytes > 0 ? plan.vertexBytes : plan.indexBytes();
}

}  // namespace

int LightMapPlan::blockHeight() const {
    int largest = 1;
    for (const LightMapTexture& texture : textures)
        largest = std::max(largest, texture.side == 1 ? formats::info(texture.format).blockHeight : texture.side * formats::kExtentStep);
    return hasCoverage() ? std::max(largest, formats::kCoverageRows) : largest;
}

glm::ivec2 LightMapTexture::sizeFor(int mapWidth, int mapHeight) const {
    return formats::textureSize(mapWidth, mapHeight, side);
}

std::size_t LightMapPlan::layerBytes(const LightMapTexture& texture) const {
    const glm::ivec2 size = texture.sizeFor(width, height);
    std::size_t bytes = 0;
    for (int mip = 0; mip < mipCount; ++mip)
        bytes += formats::bytesPerImage(texture.format, std::max(1, size.x >> mip), std::max(1, size.y >> mip));
    return bytes;
}

std::size_t LightMapPlan::coverageBytes() const {
    if (!hasCoverage()) return 0;
    const glm::ivec2 size = formats::coverageSize(width, height);
    std::size_t bytes = 0;
    for (int mip = 0; mip < mipCount; ++mip)
        bytes += formats::bytesPerImage(formats::PixelFormat::Rgba8Unorm, std::max(1, size.x >> mip), std::max(1, size.y >> mip));
    return bytes;
}

std::size_t LightMapPlan::gpuBytes() const {
    std::size_t bytes = tableBytes() + clusterBytes(*this) + coverageBytes();
    for (const LightMapTexture& texture : textures) bytes += static_cast<std::size_t>(texture.layerCount) * layerBytes(texture);
    return bytes;
}

double LightMapPlan::bitsPerTexel() const {
    double bits = 8.0 * static_cast<double>(tableBytes() + clusterBytes(*this) + coverageBytes()) / (static_cast<double>(width) * height);
    for (const LightMapTexture& texture : textures) {
        const formats::PixelFormatInfo& format = formats::info(texture.format);
        const glm::ivec2 size = texture.sizeFor(width, height);
        const double mips =
            static_cast<double>(layerBytes(texture)) / static_cast<double>(formats::bytesPerImage(texture.format, size.x, size.y));
        bits +=
            mips * 8.0 * texture.layerCount * format.bytesPerBlock / (format.blockWidth * format.blockHeight * texture.side * texture.side);
    }
    return bits;
}

LightMapPlan LightMapPlan::ofMip(int level, std::vector<std::uint8_t> clusterOfTexel) const {
    LightMapPlan plan = *this;
    plan.width = width >> level;
    plan.height = height >> level;
    plan.mipCount = 1;
    if (!basis) return plan;
    assert(clusterOfTexel.size() == static_cast<std::size_t>(plan.width) * static_cast<std::size_t>(plan.height));
    auto model = std::make_shared<BasisModel>(*basis);
    model->blockSide = 1;
    model->blocksAcross = plan.width;
    model->clusterOfBlock = std::move(clusterOfTexel);
    plan.basis = std::move(model);
    return plan;
}

std::span<const std::uint8_t> LightMapPlan::clusterOfBlock() const {
    return basis ? std::span<const std::uint8_t>(basis->clusterOfBlock) : std::span<const std::uint8_t>();
}

std::size_t LightMapPlan::indexBytes() const {
    if (!basis) return 0;
    const std::size_t across = static_cast<std::size_t>(basis->blocksAcross);
    return (across + 3) / 4 * 4 * (basis->clusterOfBlock.size() / across);
}

std::vector<std::byte> LightMapPlan::indexTexels() const {
    std::vector<std::byte> texels;
    for (std::size_t block = 0; block < clusterOfBlock().size(); ++block) {
        texels.push_back(static_cast<std::byte>(clusterOfBlock()[block]));
        const bool isLast = (block + 1) % static_cast<std::size_t>(basis->blocksAcross) == 0;
        while (isLast && texels.size() % 4 != 0) texels.push_back(texels.back());
    }
    return texels;
}

LightMapPlan planLightMap(formats::LightMapLayout layout, const MeasuredLightMap& map) {
    LightMapPlan plan = rows::emptyPlan(layout, map);
    const LightMapMeasure& measure = map.measure;
    switch (formats::info(layout).family) {
        case LightMapFamily::Raw: {
            float largest = 0;
            for (int i = 0; i < lighting::kShCount; ++i) largest = std::max(largest, measure.maximumAbsolute(i));
            plan.constants["range"] = {rows::halfRange(largest)};
            break;
        }
        case LightMapFamily::Flat:
            plan.constants["range"] = {rows::halfRange(measure.maximumExit())};
            if (plan.textures.size() > 1) plan.constants["share"] = {rows::kSecondShare};
            break;
        case LightMapFamily::Ratio:
        case LightMapFamily::Sh4:
            rows::planRatio(plan, measure);
            break;
        case LightMapFamily::Godot:
        case LightMapFamily::Bakery:
        case LightMapFamily::Rnm:
            break;  // engines have no constants
        case LightMapFamily::Hdr:
            rows::planHdrCoefficients(plan, measure);
            break;
        case LightMapFamily::Halo3:
            rows::planHalo3(plan, measure);
            break;
        case LightMapFamily::Unreal:
            rows::planUnreal(plan, measure);
            break;
        case LightMapFamily::Lit:
            rows::planLit(plan, measure);
            break;
        case LightMapFamily::Basis:
            assert(false && "a learned layout needs planLearnedLightMap");
            break;
    }
    return plan;
}

}  // namespace lightcook::compress

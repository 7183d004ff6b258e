#include "pipeline/assets/cooked_asset.h"

namespace lightcook::pipeline {

std::uint64_t CookedAsset::totalBytesGpu() const {
    std::uint64_t sum = bytesGpu.value_or(0);
    for (const CookedTexture& texture : textures) sum += texture.bytesGpu;
    return sum;
}

std::uint64_t CookedAsset::totalBytesDisk() const {
    std::uint64_t sum = bytesDisk.value_or(0);
    for (const CookedTexture& texture : textures) sum += texture.bytesDisk;
    return sum;
}

CookedAsset makeCookedAsset(const std::string& name, AssetKind kind, const std::string& layout, int width, int height) {
    const AssetKindInfo& row = info(kind);
    const auto stated = [](std::string_view text) { return text.empty() ? std::nullopt : std::optional(std::string(text)); };
    CookedAsset asset;
    asset.name = name;
    asset.kind = kind;
    asset.layout = layout;
    asset.width = width;
    asset.height = height;
    asset.quantity = stated(row.quantity);
    asset.units = stated(row.conventions.units);
    asset.phase = stated(row.conventions.phase);
    asset.frame = stated(row.conventions.frame);
    return asset;
}

}  // namespace lightcook::pipeline

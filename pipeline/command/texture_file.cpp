#include "pipeline/command/texture_file.h"

#include <fmt/format.h>

#include <algorithm>

#include "formats/lower_extension.h"
#include "formats/memory.h"
#include "formats/srgb_curve.h"
#include "verify/texture_unit.h"

namespace lightcook::pipeline {

using formats::ErrorCode;
using formats::failure;
using formats::Image;
using formats::Result;

using formats::lowerExtension;

bool isTextureFile(const std::filesystem::path& file) {
    return lowerExtension(file) == ".ktx2" || lowerExtension(file) == ".dds";
}

formats::Container containerOf(const std::filesystem::path& file) {
    return lowerExtension(file) == ".dds" ? formats::Container::Dds : formats::Container::Ktx2;
}

Result<void> requireTextureFile(const std::filesystem::path& file) {
    if (isTextureFile(file)) return {};
    return failure(ErrorCode::InvalidRequest, file,
                   fmt::format("found the extension '{}', expected .ktx2 or .dds", file.extension().string()));
}

Result<void> requireExrFile(const std::filesystem::path& file) {
    if (lowerExtension(file) == ".exr") return {};
    return failure(ErrorCode::InvalidRequest, file,
                   fmt::format("found the extension '{}', expected .exr: the values are float", file.extension().string()));
}

Result<formats::PlainImage> readPicture(const std::filesystem::path& file) {
    auto image = formats::readImage(file);
    if (image && image->channelCount > 4)
        return failure(
            ErrorCode::WrongShape, file,
            fmt::format("found {} channels, expected 1 to 4. A light map? Compress it with `lightcook lightmap`", image->channelCount));
    return image;
}

void decodeSrgb(formats::PlainImage& image) {
    for (glm::vec4& texel : image.texels.texels())
        for (int c = 0; c < 3; ++c) texel[c] = static_cast<float>(formats::linearFromSrgb(static_cast<double>(texel[c])));
}

Result<formats::PlainImage> readAnyImage(const std::filesystem::path& file, int mip, int layer) {
    if (!isTextureFile(file)) return readPicture(file);
    LC_TRY(texture, formats::TextureReader::open(file));
    const formats::TextureShape& shape = texture->shape();
    if (mip < 0 || mip >= shape.mipCount || layer < 0 || layer >= shape.layerCount)
        return failure(ErrorCode::InvalidRequest, file,
                       fmt::format("found a request for mip {} and layer {}, expected mip 0 to {} and layer 0 to {}", mip, layer,
                                   shape.mipCount - 1, shape.layerCount - 1));
    const int width = shape.mipWidth(mip), height = shape.mipHeight(mip);
    const std::uint64_t texels = static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
    // Blocks are decoded face by face into floats, beside the whole image.
    const std::uint64_t faces = static_cast<std::uint64_t>(shape.faceCount);
    LC_CHECK(formats::checkMemory((faces + 1) * texels * sizeof(glm::vec4), file));
    formats::PlainImage image;
    image.channelCount = formats::info(shape.format).channelCount;
    image.hasAlpha = image.channelCount == 4;
    for (int face = 0; face < shape.faceCount; ++face) {
        LC_TRY(decoded, verify::decodeImage(*texture, {mip, layer, face}));
        if (shape.faceCount == 1) {
            image.texels = std::move(*decoded);
            break;
        }
        if (face == 0) image.texels = Image<glm::vec4>(width, height * shape.faceCount);  // once the file's content is known to be whole
        for (int y = 0; y < height; ++y) std::copy_n(decoded->view().row(y), width, image.texels.view().row(face * height + y));
    }
    if (texture->hasBc1Alpha() && hasTransparency(image)) {
        image.channelCount = 4;
        image.hasAlpha = true;
    }
    return image;
}

bool hasTransparency(const formats::PlainImage& image) {
    return std::ranges::any_of(image.texels.texels(), [](const glm::vec4& texel) { return texel.a != 1; });
}

}  // namespace lightcook::pipeline

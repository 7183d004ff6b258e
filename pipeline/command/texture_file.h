// Texture files by their names, and any readable file as an image.
#pragma once

#include <filesystem>

#include "formats/error.h"
#include "formats/gpu_texture.h"
#include "formats/plain_image.h"

namespace lightcook::pipeline {

/// Returns true for .ktx2 and .dds.
bool isTextureFile(const std::filesystem::path& file);

/// Returns the container that the name of a texture file asks for.
formats::Container containerOf(const std::filesystem::path& file);

/// Returns an error unless the file's extension is .ktx2 or .dds.
formats::Result<void> requireTextureFile(const std::filesystem::path& file);

/// Returns an error unless the file's extension is .exr.
formats::Result<void> requireExrFile(const std::filesystem::path& file);

/// Reads an image of 1 to 4 channels. Refuses files with more, such as light maps, of which an image would be the first four.
formats::Result<formats::PlainImage> readPicture(const std::filesystem::path& file);

/// Replaces the colours of an image, codes under the sRGB curve, by linear light. Alpha is linear already.
void decodeSrgb(formats::PlainImage& image);

/// Returns true if the alpha of a texel is not 1.
bool hasTransparency(const formats::PlainImage& image);

/// Reads an image, or one mip and layer of a texture. The faces of a cubemap lie one under the other. BC1 has alpha if one of its texels is
/// transparent.
formats::Result<formats::PlainImage> readAnyImage(const std::filesystem::path& file, int mip = 0, int layer = 0);

}  // namespace lightcook::pipeline

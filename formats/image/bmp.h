// BMP pictures whose texels are integers of 16 or 32 bits with a mask for each channel. OpenImageIO takes the unused byte of 32 bits for
// alpha, which makes the picture transparent. Source: Microsoft, "Bitmap Header Types" (BITMAPINFOHEADER to BITMAPV5HEADER).
#pragma once

#include <filesystem>
#include <optional>

#include "formats/error.h"
#include "formats/plain_image.h"

namespace lightcook::formats {

/// Reads such a picture, as stored. The header's alpha mask alone names alpha: a picture without compression (BI_RGB) has none. Returns
/// nothing for any other file: also 1 to 8 and 24 bits, and compressed ones.
std::optional<Result<PlainImage>> readMaskedBmp(const std::filesystem::path& file);

}  // namespace lightcook::formats

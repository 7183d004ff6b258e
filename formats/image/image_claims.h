// These functions check what the header of an image file claims, before memory is allocated for its texels.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>

#include "formats/error.h"
#include "formats/image/exr_file.h"
#include "formats/memory.h"

namespace lightcook::formats {

/// Floats that a texel takes while a library reads an image as RGBA: four of the library and four of the caller.
inline constexpr int kFloatsThroughLibrary = 8;
/// Most texels of an image that is read as a whole: 4 GiB as RGBA float. The largest panoramas in use, 16k x 8k, have half as many.
inline constexpr std::int64_t kMostTexels = std::int64_t{1} << 28;

/// Refuses a path without a regular file, a KTX2 texture, and an OpenEXR file that ExrReader does not open. OpenImageIO would take the
/// first part of several, and channels by their order. It reads textures in DDS.
Result<void> checkClaims(const std::filesystem::path& file, const Result<ExrReader>& reader);

/// Refuses an image of no or too many texels, or one for which the memory does not suffice.
/// Inline, because the image module calls it and is not linked with formats.
/// floatsPerTexel  of the memory that reading takes
/// subject         names the image in errors
inline Result<void> checkExtent(int width, int height, int channelCount, int floatsPerTexel, const Subject& subject) {
    if (width < 1 || height < 1 || channelCount < 1 || std::max(width, height) > kLargestExtent ||
        std::int64_t{width} * height > kMostTexels) {
        return failure(ErrorCode::WrongShape, subject,
                       fmt::format("found {} x {} texels of {} channels, expected 1 to {} a side and at most {} in all", width, height,
                                   channelCount, kLargestExtent, kMostTexels));
    }
    const std::uint64_t floats =
        static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height) * static_cast<std::uint64_t>(floatsPerTexel);
    return checkMemory(floats * sizeof(float), subject);
}

/// Refuses an image of more bytes than those of its file can stand for.
/// mostPerByte  bytes of texels, as the format stores them, for each byte of the file
inline Result<void> checkFileHolds(std::uint64_t texelBytes, std::uint64_t fileBytes, std::uint64_t mostPerByte, const Subject& subject) {
    if (texelBytes / mostPerByte <= fileBytes) return {};
    return failure(
        ErrorCode::FileUnreadable, subject,
        fmt::format("found {} bytes, expected more for {} bytes of texels: truncated, or a broken header", fileBytes, texelBytes));
}

}  // namespace lightcook::formats

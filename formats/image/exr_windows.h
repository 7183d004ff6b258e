// The rule that the data window of an EXR file equals its display window.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <string>

#include "formats/error.h"

namespace lightcook::formats {

/// A window of an EXR file: its corner and its size [texels].
struct ExrWindow {
    std::int64_t x = 0, y = 0, width = 0, height = 0;

    bool contains(const ExrWindow& other) const {
        return x <= other.x && y <= other.y && other.x + other.width <= x + width && other.y + other.height <= y + height;
    }
    std::string text() const { return fmt::format("{} x {} texels at ({}, {})", width, height, x, y); }
};

/// Fails if a file does not store exactly the texels of its display window, which UVs and directions are relative to: the picture was
/// cropped, or has overscan.
inline Result<void> checkWindows(const std::filesystem::path& file, const ExrWindow& data, const ExrWindow& display) {
    const bool isInside = display.contains(data), isAround = data.contains(display);
    if (isInside && isAround) return {};
    const char* const relation = isInside ? "smaller than" : isAround ? "larger than" : "partly outside";
    const char* const remedy = isInside ? "Pad with black" : isAround ? "Crop" : "Crop and pad with black";
    return failure(ErrorCode::WrongShape, file,
                   fmt::format("found a data window of {}, {} the display window of {}, expected equal windows. {}: oiiotool in.exr "
                               "--croptofull -o out.exr",
                               data.text(), relation, display.text(), remedy));
}

}  // namespace lightcook::formats

// Bake format sh9, which lightcook writes: an OpenEXR file with a channel for each of the 27 numbers of a texel.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "formats/bakes/bake_reader.h"

namespace lightcook::formats {

inline constexpr std::string_view kSh9Content = "sh00.R .. sh08.B";

/// Returns the channel of float `index` of a ShRgb: 0 "sh00.R", 1 "sh00.G", ... 26 "sh08.B".
std::string sh9Channel(int index);
std::vector<std::string> sh9Channels();

BakeMatch matchSh9(const std::filesystem::path& file, const ExrInfo& info);
/// Opens a file that has all of sh9Channels().
Result<std::unique_ptr<BakeReader>> openSh9(BakeImage image);

}  // namespace lightcook::formats

// Bake format sh4: an OpenEXR file with a channel for each of the 12 numbers of bands 0 and 1, named as in sh9. Band 2 is zero.
#pragma once

#include <memory>
#include <string_view>

#include "formats/bakes/bake_reader.h"

namespace lightcook::formats {

inline constexpr std::string_view kSh4Content = "sh00.R .. sh03.B";

/// Matches files that have no channel of band 2: one that has some belongs to sh9.
BakeMatch matchSh4(const std::filesystem::path& file, const ExrInfo& info);
/// Opens a file that has all twelve channels.
Result<std::unique_ptr<BakeReader>> openSh4(BakeImage image);

}  // namespace lightcook::formats

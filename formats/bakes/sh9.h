// Bake format sh9: an OpenEXR file with a channel for each of the 27 numbers of a texel. Optional channels: coverage.Y (above 0.5 inside
// a chart) and normal.X, normal.Y, normal.Z (world space).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "formats/bakes/bake_reader.h"

namespace lightcook::formats {

/// Returns the channel of float `index` of a ShRgb: 0 "sh00.R", 1 "sh00.G", ... 26 "sh08.B".
std::string sh9Channel(int index);
std::vector<std::string> sh9Channels();

/// Opens a file that has all of sh9Channels(). Fails if it has only one or two of the channels of the normal.
Result<std::unique_ptr<BakeReader>> openSh9(ExrReader file, const std::string& subject);

}  // namespace lightcook::formats

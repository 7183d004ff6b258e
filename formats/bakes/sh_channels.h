// Bakes that store each of the 27 numbers of a texel as a channel of one image or of several.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "formats/bakes/bake_reader.h"

namespace lightcook::formats {

/// Place of a number of a texel: the image, and its channel there.
struct ShChannel {
    std::size_t image = 0;
    std::string channel;
};

/// Returns how well the channels of a file fit a format that has all of `wanted`.
/// content  names them in short: "sh00.R .. sh08.B"
BakeMatch matchChannels(const ExrInfo& info, const std::vector<std::string>& wanted, std::string_view format, std::string_view content);

/// Returns a reader of images of one size that have these channels, in the order of ShRgb: coefficient by coefficient, R, G and B, up
/// to 27. Coefficients without a channel are 0. Coverage and normals are those of the first image. Fails if it has only one or two of the
/// channels of the normal. coverage  see SurfaceChannels::of
Result<std::unique_ptr<BakeReader>> openShChannels(std::vector<BakeImage> images, std::vector<ShChannel> channels,
                                                   const std::string& coverage = "");
/// Returns a reader of one image that has all channels.
Result<std::unique_ptr<BakeReader>> openShChannels(BakeImage image, std::vector<std::string> names);

}  // namespace lightcook::formats

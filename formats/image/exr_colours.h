// The channels of an OpenEXR file that are an image's colours, found by name.
// R, G, B and A, or r, g, b and a. Without any of the colours, Y is grey (but for CIE XYZ, and for chroma RY and BY). Without these too,
// the same of the only layer ("beauty.R") that has them; and the only channel of a file is grey whatever its name. A is alpha and nothing
// else is. Source: "Technical Introduction to OpenEXR", sections Channel Names and Layers.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "formats/error.h"
#include "formats/image/exr_file.h"

namespace lightcook::formats {

struct ExrColours {
    std::array<std::string, 4> channels;  ///< names of R, G, B and A; empty: there is none
    bool isGrey = false;                  ///< the channel of R is that of G and B too
    std::vector<std::string> ignored;     ///< all other channels

    bool hasRgb() const { return isGrey || !(channels[0].empty() || channels[1].empty() || channels[2].empty()); }
    int channelCount() const;
};

/// Fails for a file whose channels are those of no image, or of several layers.
/// subject  names the file in errors
Result<ExrColours> exrColours(const ExrInfo& info, const Subject& subject);

}  // namespace lightcook::formats

// Radiance pictures (.hdr, .pic) of the usual kind, without OpenImageIO, whose 250 libraries take longer to load than a picture to read.
// Source: Ward 1991, Real Pixels (Graphics Gems II); the Radiance file format's reference page.
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <optional>

#include "formats/image.h"

namespace lightcook::formats {

/// R, G and B of a picture whose rows run from top to bottom and left to right ("-Y height +X width"), in RGBE, flat or with each component
/// run-length encoded; a texel is mantissa * 2^(exponent - 136). Nothing at all if the file is missing, not such a picture, damaged, or of
/// another kind (XYZE, other orientations, the run lengths of before 1991): then it is for OpenImageIO to read or to refuse.
std::optional<Image<glm::vec3>> readRadiancePicture(const std::filesystem::path& file);

}  // namespace lightcook::formats

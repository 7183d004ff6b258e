// Reads common Radiance pictures (.hdr, .pic) without OpenImageIO, whose 250 libraries take longer to load than a picture takes to read.
// Source: Ward 1991, Real Pixels (Graphics Gems II); the Radiance file format's reference page.
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <optional>

#include "formats/image.h"

namespace lightcook::formats {

/// Reads an RGBE picture stored from top to bottom and left to right ("-Y height +X width"), flat or run-length encoded by component.
/// A texel is mantissa * 2^(exponent - 136). Returns nothing if the file is missing, damaged or of another kind (XYZE, other orientations,
/// run lengths of before 1991); the caller passes it to OpenImageIO then.
std::optional<Image<glm::vec3>> readRadiancePicture(const std::filesystem::path& file);

}  // namespace lightcook::formats

// Reads common Radiance pictures (.hdr, .pic) without OpenImageIO, whose 250 libraries take longer to load than a picture takes to read.
// Source: Ward 1991, Real Pixels (Graphics Gems II); the Radiance file format's reference page.
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <optional>

#include "formats/error.h"
#include "formats/image.h"

namespace lightcook::formats {

/// Reads an RGBE picture stored from top to bottom and left to right ("-Y height +X width"), flat or run-length encoded by component.
/// A texel is mantissa * 2^(exponent - 136) / radianceFactors(). Returns nothing if the file is missing, damaged or of another kind (XYZE,
/// other orientations, run lengths of before 1991); the caller passes it to OpenImageIO then.
std::optional<Image<glm::vec3>> readRadiancePicture(const std::filesystem::path& file);

/// Returns the factors that the stored R, G and B are the light times: the product of the header's EXPOSURE and COLORCORR lines.
/// OpenImageIO does not divide by them. (1, 1, 1) for files that are not Radiance pictures. Fails for a FORMAT other than RGBE, and for
/// factors that are not positive finite numbers.
Result<glm::vec3> radianceFactors(const std::filesystem::path& file);

}  // namespace lightcook::formats

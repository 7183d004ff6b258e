// Reads Radiance pictures (.hdr, .pic) without OpenImageIO, whose 250 libraries take longer to load than a picture takes to read, and which
// reads neither the run lengths of before 1991 nor other orientations.
// Source: Ward 1991, Real Pixels (Graphics Gems II); the Radiance file format's reference page ("filefmts"), color.c for both run lengths.
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <optional>

#include "formats/error.h"
#include "formats/image.h"
#include "formats/plain_image.h"

namespace lightcook::formats {

/// The light of a picture: mantissa * 2^(exponent - 136) / radianceFactors() of each texel.
struct RadiancePicture {
    Image<glm::vec3> texels;
    std::optional<StatedChromaticities> chromaticities = {};  ///< the last line PRIMARIES of the header
};

/// Reads an RGBE picture of any orientation: flat, run-length encoded by component, or by texel as before 1991. Returns nothing if the file
/// is missing, damaged or of another kind; the caller passes it to OpenImageIO then.
std::optional<RadiancePicture> readRadiancePicture(const std::filesystem::path& file);

/// Returns the factors that the stored R, G and B are the light times: the product of the header's EXPOSURE and COLORCORR lines.
/// OpenImageIO does not divide by them. (1, 1, 1) for files that are not Radiance pictures. Fails for a FORMAT other than RGBE, for
/// factors that are not positive finite numbers, and for PRIMARIES that are not eight finite numbers.
Result<glm::vec3> radianceFactors(const std::filesystem::path& file);

/// Returns the chromaticities that the header of a Radiance picture states, without reading texels. Empty: none, or another file.
std::optional<StatedChromaticities> radianceChromaticities(const std::filesystem::path& file);

}  // namespace lightcook::formats

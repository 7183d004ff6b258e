// Bake format flat: one picture R, G, B without directions, as Blender, The_Lightmapper and three.js write light maps. A texel is the exit
// radiance E / pi of a white surface (quantity = "radiance") or the irradiance E (quantity = "irradiance").
//
// A texel X becomes the light of a uniform environment: coefficient 0 is 2 sqrt(pi) X, bands 1 and 2 are zero. It shades to X at the
// texel's own normal and, because nothing is known of its directions, at every other one.
#pragma once

#include <filesystem>
#include <memory>

#include "formats/bakes/bake_reader.h"

namespace lightcook::formats {

BakeMatch matchFlat(const std::filesystem::path& file, const ExrInfo& info);
/// Opens a picture. Coverage is coverage.Y or, without it, alpha.
Result<std::unique_ptr<BakeReader>> openFlat(BakeImage image);

}  // namespace lightcook::formats

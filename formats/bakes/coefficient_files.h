// Bakes that the scene file lists image by image, with the key `files`: one for each coefficient, or for each colour of a coefficient.
//
//   files = { sh00 = "a.exr", sh01 = "b.exr", sh02 = "c.exr", sh03 = "d.exr" }           R, G and B of each image
//   files = { sh00 = { R = "r.exr", G = "g.exr", B = "b.exr" }, sh01 = ... }             the one channel of each image
//
// The coefficients are those of sh4 (sh00 to sh03) or of sh9 (sh00 to sh08). The image of sh00, or of its red, may have coverage and
// normals as channels.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "formats/bakes/bake_reader.h"
#include "formats/error.h"

namespace lightcook::formats {

/// Opens the images of such a list. Fails if one is missing, has another size than the first, or other channels than its place needs.
/// files  by name; bakeFormatOfFiles() of bake_format.h accepts the names
Result<std::unique_ptr<BakeReader>> openCoefficientFiles(const std::map<std::string, std::filesystem::path>& files);

}  // namespace lightcook::formats

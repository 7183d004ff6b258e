// Bake format deluxe: light map and direction map of q3map2 (Quake 3 and its kin), in two images:
//
//   lm_0000, lm_0001       pages as q3map2 numbers them: the even one is light, the odd one its directions
//   <stem>, <stem>_deluxe  the same as a pair of names
//   light: R, G, B of what the surface shows at its own normal N; directions: d = 2 t - 1 towards the light, in the map's axes
//
// With x = max(0, N . d), the shader (ioquake3, renderergl2) shows
//   E(n) / pi = C max(0, n . d) / max(x, 1/4) + C (1 - x / max(x, 1/4))
// a light from d, and where it would be more than four times the map, light from everywhere. Here the light is its nine coefficients. They
// show it up to 9 % too bright or too dark, so its strength, or below x = 1/4 the light from everywhere, is chosen so that the surface's
// own normal shows C exactly. A direction shorter than 1/8 is none. Source: ioquake/ioq3, code/renderergl2/glsl/lightall_fp.glsl.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <string_view>
#include <vector>

#include "formats/bakes/bake_reader.h"

namespace lightcook::formats {

/// Endings of the names of a light map and of its directions. Pages have numbers instead.
inline constexpr std::array<std::string_view, 2> kDeluxeEndings = {"", "_deluxe"};

/// Certain for a pair of names. Numbered pages may be plain light maps as well: the scene has to name the format.
BakeMatch matchDeluxe(const std::filesystem::path& file, const ExrInfo& info);
/// Returns light and directions. Empty for a name without a number that has no file _deluxe beside it.
std::vector<std::filesystem::path> filesBesideDeluxe(const std::filesystem::path& file);
/// mesh  has the normals of the surfaces
Result<std::unique_ptr<BakeReader>> openDeluxe(BakeImage image, const BakeSurface& surface);

}  // namespace lightcook::formats

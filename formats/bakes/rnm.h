// Bake formats bakery-rnm and source-rnm: light of three directions in tangent space, in three HDR images of one name:
//
//   <stem>_RNM0, <stem>_RNM1, <stem>_RNM2    R_i: R, G, B for direction b_i of the basis of Half-Life 2
//   b_0 = (sqrt(2/3), 0, 1/sqrt(3)),  b_1, b_2 = (-1/sqrt(6), +-1/sqrt(2), 1/sqrt(3))
//
// x is the tangent, z the normal of the surface; y points to where v grows, down a picture: both engines' normal maps are green downwards.
// For a normal n of the normal map, d_i = max(0, b_i . n), the engines show
//   bakery-rnm  E(n) / pi = sum_i d_i R_i              Bakery for Unity
//   source-rnm  E(n) / pi = sum_i d_i^2 R_i / sum d_i^2    Source (Half-Life 2), where the three are pages of a bumped face
// These functions are no SH of order 2: each direction's is replaced by the nine coefficients that show it with the least squared error
// over the hemisphere and exactly at the surface's own normal. The RMS of what is left is 3.5 % (Bakery) and 4.7 % (Source) of R_i.
// Sources: z3y/ShaderGraph-BuiltIn-Importer, CustomLighting/Bakery.cginc; Valve, Source SDK, lightmappedgeneric_ps2_3_x.h.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <string_view>
#include <vector>

#include "formats/bakes/bake_reader.h"

namespace lightcook::formats {

/// Endings of the names of the files.
inline constexpr std::array<std::string_view, 3> kRnmEndings = {"_RNM0", "_RNM1", "_RNM2"};

BakeMatch matchBakeryRnm(const std::filesystem::path& file, const ExrInfo& info);
/// Matches the same files, which nothing tells from those of Bakery: the scene has to name the format.
BakeMatch matchSourceRnm(const std::filesystem::path& file, const ExrInfo& info);
/// Returns the three files. The extension of each is that of `file`, or the first of .exr, .hdr, .tga and .png that exists.
std::vector<std::filesystem::path> filesBesideRnm(const std::filesystem::path& file);
/// surface  whose tangents the bake has: see SurfaceFrames. Texels without a surface are not covered.
Result<std::unique_ptr<BakeReader>> openBakeryRnm(BakeImage image, const BakeSurface& surface);
Result<std::unique_ptr<BakeReader>> openSourceRnm(BakeImage image, const BakeSurface& surface);

}  // namespace lightcook::formats

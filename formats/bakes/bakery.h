// Bake formats bakery-sh and bakery-mono-sh: the SH light maps of Bakery, a baker for Unity, in files of one name:
//
//   <stem>_L0    R, G, B of L0, HDR
//   bakery-sh        <stem>_L1x, <stem>_L1y, <stem>_L1z    t = L1 / (4 L0) + 0.5 along a world axis, by colour, in 8 bits or more
//   bakery-mono-sh   <stem>_L1    t along x, y and z as R, G, B, which the colours share
//
// Unity's shader shows  E(n) / pi = L0 + n . L1  with  L1 = 2 L0 (2 t - 1), which order 1 of SH holds exactly.
// Source: z3y/ShaderGraph, ShaderLibrary/Bakery.hlsl; z3y/ShaderGraph-BuiltIn-Importer, CustomLighting/Bakery.cginc (MonoSH).
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <string_view>
#include <vector>

#include "formats/bakes/bake_reader.h"

namespace lightcook::formats {

/// Endings of the names of the files.
inline constexpr std::array<std::string_view, 4> kBakeryEndings = {"_L0", "_L1x", "_L1y", "_L1z"};
inline constexpr std::array<std::string_view, 2> kMonoEndings = {"_L0", "_L1"};

/// Matches the names of the files. Beside the complete files of the other format, a match is no more than Possible.
BakeMatch matchBakerySh(const std::filesystem::path& file, const ExrInfo& info);
BakeMatch matchBakeryMonoSh(const std::filesystem::path& file, const ExrInfo& info);
/// Returns all files of the bake. The extension of each is that of `file`, or the first of .exr, .hdr, .tga and .png that exists.
std::vector<std::filesystem::path> filesBesideBakerySh(const std::filesystem::path& file);
std::vector<std::filesystem::path> filesBesideBakeryMonoSh(const std::filesystem::path& file);
Result<std::unique_ptr<BakeReader>> openBakerySh(BakeImage image);
Result<std::unique_ptr<BakeReader>> openBakeryMonoSh(BakeImage image);

}  // namespace lightcook::formats

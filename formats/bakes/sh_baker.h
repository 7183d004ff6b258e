// Bake format sh-baker: the files of DaviesX/sh-baker, which have the coefficients of sh9 in the same basis under other names.
//
//   one file     27 channels L0.R .. L22.B, and EnvVisibility, which is no light
//   split        <stem>_L0.exr .. <stem>_L22.exr, each R, G, B of a coefficient
//   packed       <stem>_packed_0.exr .. _2.exr, each RGBA: L0 in colour and the visibility of the environment; then the luminance of the
//                other eight coefficients. Their colour is that of L0.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <string_view>
#include <vector>

#include "formats/bakes/bake_reader.h"

namespace lightcook::formats {

/// Endings of the names of the files: of nine with a coefficient each, and of three packed ones.
inline constexpr std::array<std::string_view, 12> kShBakerEndings = {"_L0",  "_L1m1", "_L10", "_L11",      "_L2m2",     "_L2m1",
                                                                     "_L20", "_L21",  "_L22", "_packed_0", "_packed_1", "_packed_2"};

BakeMatch matchShBaker(const std::filesystem::path& file, const ExrInfo& info);
/// Returns the other split or packed files of a bake, if the name of `file` is one of theirs.
std::vector<std::filesystem::path> filesBesideShBaker(const std::filesystem::path& file);
/// Opens the one file, or all files beside it.
Result<std::unique_ptr<BakeReader>> openShBaker(BakeImage image);

}  // namespace lightcook::formats

// Bake formats godot and godot-radiance: the directional light maps of Godot 4.4 and later (LightmapGI). An EXR picture has four slices a
// page from top to bottom: L0, and the y, z and x component of L1, packed by colour as p = L1 / (8 L0) + 0.5. Alpha is coverage.
// Godot's import settings beside it (<file>.import) say how many slices there are; their pages become one map, page below page.
//
// The engine shows  E(n) / pi = L0 + n . L1  with  L1 = 8 L0 (p - 0.5), which order 1 of SH holds exactly:
//   godot            lambda_0 = L0 / 0.282095, lambda_1 = L1 / 0.325735 (Y of bands 0 and 1, times the 1 and 2/3 of the cosine)
// Light of one direction has |L1| = 4 L0, the most of any: both add up over the light. In lambda that is twice sqrt(3) lambda_0, which
// radiance cannot exceed; an even sky has 4/3.
// Godot's coefficients are no projection of radiance: indirect rays, whose density follows the cosine to the normal, count as 1/4 in L0
// and by their direction in L1. Uniform light X of the upper hemisphere has L0 = X / 4 and L1 = 2/3 X n there, and shows as 0.917 X.
//   godot-radiance   lambda_0 = 4 sqrt(pi) L0, lambda_1 = (3/4) sqrt(3 pi) L1: exact for that light, approximate for other
// Source: godotengine/godot, modules/lightmapper_rd/lm_compute.glsl and scene/3d/lightmap_gi.cpp.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "formats/bakes/bake_reader.h"

namespace lightcook::formats {

/// Longest band 1 of a bake as shown, over sqrt(3) lambda_0: |L1| = 4 L0.
inline constexpr double kLongestOfGodot = 2;

BakeMatch matchGodot(const std::filesystem::path& file, const ExrInfo& info);
/// Returns the number of slices that Godot's import settings give a picture; nothing without them.
std::optional<int> importedSlices(const std::filesystem::path& file);
/// Returns the file of Godot's import settings.
std::vector<std::filesystem::path> filesBesideGodot(const std::filesystem::path& file);
/// Opens a picture as the engine shows it. Fails if its height is no multiple of its slices, or if the slices of L1 are no packed ones.
Result<std::unique_ptr<BakeReader>> openGodot(BakeImage image);
/// Opens it as radiance.
Result<std::unique_ptr<BakeReader>> openGodotRadiance(BakeImage image);

}  // namespace lightcook::formats

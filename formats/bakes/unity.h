// Bake formats unity-directional and bakery-dominant: the directional light maps of Unity, and those that Bakery writes for it in its mode
// "Dominant Direction". Two files of one name:
//
//   unity-directional   <stem>_light   R, G, B: the colour D, HDR or under an encoding (Unity: Lightmap-0_comp_light.exr)
//                       <stem>_dir     R, G, B: d + 0.5 in world axes, |d| at most 0.5; A: w, the rebalancing coefficient
//   bakery-dominant     <stem>_final   the colour (Bakery: level_LMA1_final.hdr)
//                       <stem>_dir     the same; without alpha, w is 1 as a sampler has it
//
// Unity's shader shows  E(n) / pi = D (n . d + 0.5) / max(w, 1e-4),  half Lambert of the dominant direction, which order 1 of SH holds
// exactly: L0 = 0.5 D / w, L1 = D d / w. w is the half Lambert of the surface's own normal, which shows D therefore.
// Both write the first file alone where directions are off.
// Source: Unity, Packages/com.unity.render-pipelines.core/ShaderLibrary/EntityLighting.hlsl (SampleDirectionalLightmap); Bakery's manual,
// "Directional mode".
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <string_view>
#include <vector>

#include "formats/bakes/bake_reader.h"

namespace lightcook::formats {

/// Endings of the names of the files.
inline constexpr std::array<std::string_view, 2> kUnityEndings = {"_light", "_dir"};
inline constexpr std::array<std::string_view, 2> kDominantEndings = {"_final", "_dir"};

BakeMatch matchUnityDirectional(const std::filesystem::path& file, const ExrInfo& info);
BakeMatch matchBakeryDominant(const std::filesystem::path& file, const ExrInfo& info);
/// Returns both files. The extension of each is that of `file`, or the first of .exr, .hdr, .tga and .png that exists.
std::vector<std::filesystem::path> filesBesideUnityDirectional(const std::filesystem::path& file);
std::vector<std::filesystem::path> filesBesideBakeryDominant(const std::filesystem::path& file);
/// Fails if the direction map of Unity has no alpha. A covered texel with light fails when it is read if its w is 0, or its |d| above 0.75,
/// which no rounding of Unity reaches.
Result<std::unique_ptr<BakeReader>> openUnityDirectional(BakeImage image);
Result<std::unique_ptr<BakeReader>> openBakeryDominant(BakeImage image);

}  // namespace lightcook::formats

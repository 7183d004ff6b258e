// Bake format unity-directional: the directional light maps of Unity, in two files of one name:
//
//   <stem>_light   R, G, B: the colour D, HDR or under an encoding (Unity: Lightmap-0_comp_light.exr)
//   <stem>_dir     R, G, B: d + 0.5 in world axes, |d| at most 0.5; A: w, the rebalancing coefficient (Lightmap-0_comp_dir.png)
//
// Unity's shader shows  E(n) / pi = D (n . d + 0.5) / max(w, 1e-4),  half Lambert of the dominant direction, which order 1 of SH holds
// exactly: L0 = 0.5 D / w, L1 = D d / w. w is the half Lambert of the surface's own normal, which shows D therefore.
// Source: Unity, Packages/com.unity.render-pipelines.core/ShaderLibrary/EntityLighting.hlsl (SampleDirectionalLightmap).
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

BakeMatch matchUnityDirectional(const std::filesystem::path& file, const ExrInfo& info);
/// Returns both files. The extension of each is that of `file`, or the first of .exr, .hdr, .tga and .png that exists.
std::vector<std::filesystem::path> filesBesideUnityDirectional(const std::filesystem::path& file);
/// Fails if the direction map has no alpha. A covered texel with light fails when it is read if its w is 0, or its |d| above 0.75, which no
/// rounding of Unity reaches.
Result<std::unique_ptr<BakeReader>> openUnityDirectional(BakeImage image);

}  // namespace lightcook::formats

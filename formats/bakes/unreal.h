// Bake format unreal-hq: the high-quality light maps of Unreal (Lightmass, GPU Lightmass), as Unreal's own exporter writes them to glTF
// (extension EPIC_lightmap_textures, gltf/epic_extension.h). A light map is an image of W x 2H texels of 8 bits, without any curve:
//
//   a0, rgb0   rows 0 to H - 1: the logarithm of the luminance, and the square roots of the colour over the luminance
//   a1         rows H to 2H - 1: what rounding took from a0, a fraction of its step; their R, G and B are directions
//
// A mesh has a rectangle of the image, with constants of its own:
//
//   LogL = (a0 + (a1 - 0.5) / 255) scale.w + add.w      L = max(2^LogL - 0.01858136, 0)
//   UVW  = max(rgb0^2 scale.rgb + add.rgb, 0)           E / pi = 0.6 L UVW, at every normal
//
// The directions are not read: Unreal's shader brings them to their range by a second pair of scale and add, which the exporter leaves out.
// 0.6 is the shader's own value without them, and that of Epic's glTF viewer. Unreal pads each rectangle by a texel, which is not read: no
// file says whether it is there. The cook pads the rectangle again.
// Source: Unreal, Engine/Shaders/Private/LightmapCommon.ush (GetLightMapColorHQ) and Plugins/Experimental/GPULightmass,
// LightmapEncoding.cpp (QuantizeLightSamples); Epic's GLTFWebViewer, LightMapUE4; glTFast, EPIC_lightmap_textures.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "formats/bakes/bake_reader.h"

namespace lightcook::formats {

/// Returns the description of a glTF file for the recognition: the extension, in place of channels. Fails without light maps.
Result<ExrInfo> unrealContent(const std::filesystem::path& file);
BakeMatch matchUnrealHq(const std::filesystem::path& file, const ExrInfo& info);
/// Opens an image of light maps. Texels outside all rectangles are not covered. Fails if an image has an odd height or no alpha, or if two
/// rectangles with other constants share a texel.
/// image  name of the image; may be empty if there is only one
Result<std::unique_ptr<BakeReader>> openUnrealHq(const std::filesystem::path& file, const std::string& image);

}  // namespace lightcook::formats

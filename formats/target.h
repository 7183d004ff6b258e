// Targets: the families of pixel formats that a scene can be cooked for.
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "formats/pixel_format.h"

namespace lightcook::formats {

enum class Target { Bc, Astc, Float };

struct TargetInfo {
    Target id;
    std::string_view name;        ///< as in `[output] target` and `--target`
    std::string_view caption;     ///< for help texts and documents
    PixelFormat hdr;              ///< non-negative HDR colour: coefficient 0, intensity, cubemaps
    PixelFormat hdrFine;          ///< the same with an exponent of its own in each texel
    PixelFormat ldr;              ///< four channels in [0, 1]
    PixelFormat ldrRgb;           ///< three channels in [0, 1] at the fewest bits
    PixelFormat ldrAlpha;         ///< a coarse colour in [0, 1] with a fine alpha: the textures of halo3 and unreal-hq
    PixelFormat table;            ///< four channels in [0, 1] of 16 bits: specular tables
    std::string_view deviceNeed;  ///< features that a device must support to sample the formats
};

/// Returns every target, in the order of the enumeration.
std::span<const TargetInfo> allTargets();
const TargetInfo& info(Target target);
std::optional<Target> targetFromName(std::string_view name);

}  // namespace lightcook::formats

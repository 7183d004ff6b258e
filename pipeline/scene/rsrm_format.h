// Formats of radially symmetric reflection maps: one table, from which the scene file, the command line, the cook and its verification
// derive.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/pixel_format.h"
#include "formats/target.h"
#include "verify/rsrm.h"

namespace lightcook::pipeline {

enum class RsrmFormat { Rgba8, Bc7, Bc4, Bc6h, Rgb9e5, Rgba16f };

struct RsrmFormatInfo {
    RsrmFormat id;
    std::string_view name;     ///< value of `format` and `rsrm --format`
    std::string_view caption;  ///< for help and documents
    formats::PixelFormat pixels;
    verify::RsrmCodes codes;  ///< how texels may be rounded
    /// Texels are floats over one power of two, so that a sun and its sky keep their colours; others are shares of each channel's largest
    /// value.
    bool isFloat;

    bool hasBlocks() const { return formats::info(pixels).blockWidth > 1; }
    /// Blocks are those of target bc; every device samples the other formats.
    bool isFor(formats::Target target) const { return !hasBlocks() || target == formats::Target::Bc; }
};

/// Returns every format, in the order of the enumeration.
std::span<const RsrmFormatInfo> allRsrmFormats();
const RsrmFormatInfo& info(RsrmFormat format);
/// Return the format of a name or of a texture; nullptr for others.
const RsrmFormatInfo* rsrmFormatFromName(std::string_view name);
const RsrmFormatInfo* rsrmFormatOf(formats::PixelFormat pixels);

/// Selects the smallest format that keeps the error limit.
inline constexpr std::string_view kAutoRsrmFormat = "auto";
/// Returns "auto" and the names of the formats.
std::vector<std::string> rsrmFormatChoices();

/// Returns the names of the formats to try, in order: the first that keeps the limit is taken, the last if none does.
/// asked  a name (only this one); "auto" (those of the target, the smallest first); or empty (rgba8, then as "auto")
std::vector<std::string> rsrmFormatsToTry(std::string_view asked, formats::Target target, int width, int rowCount);

}  // namespace lightcook::pipeline

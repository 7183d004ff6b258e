// Bake formats: how a baker writes the SH coefficients of a light map into a file. The table in bakes/bake_format.cpp has a row for each.
// To add a format: a reader like bakes/sh9.cpp, a row, a test. All formats share bakes/canonical.cpp: coverage, normals, checks, conversion
// to canonical form.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/error.h"
#include "formats/light_map_conventions.h"

namespace lightcook::formats {

class BakeReader;  // bakes/bake_reader.h
class ExrReader;   // image/exr_file.h

/// Conventions that every file of a format follows. An empty member is left to the scene file.
struct BakeConventions {
    std::optional<ShPhase> phase;
    std::optional<ShFrame> frame;
    std::optional<ShQuantity> quantity;
    std::optional<LightUnits> lightUnits;
};

struct BakeFormatInfo {
    std::string_view name;                   ///< value of the scene key `bake`
    std::string_view caption;                ///< one line for help texts and documents
    std::string_view channelCaption;         ///< the channels in short, for error messages: "sh00.R .. sh08.B"
    std::vector<std::string> (*channels)();  ///< the channels that a file of this format must have; they identify it
    BakeConventions implied;
    Result<std::unique_ptr<BakeReader>> (*open)(ExrReader file, const std::string& subject);  ///< subject: the file's name for errors
};

/// Value of the scene key `bake` that chooses the format by the channels of the file.
inline constexpr std::string_view kAutoBake = "auto";

std::span<const BakeFormatInfo> allBakeFormats();
/// Returns "auto" and the names of all bake formats: the values of the scene key `bake`.
std::vector<std::string> bakeNames();

}  // namespace lightcook::formats

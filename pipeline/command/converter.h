// The common part of the single converters (lightmap, dominant, cubemap, lut, rsrm): a scene of one asset, made in memory, then cooked
// and verified like any other.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "pipeline/cook/cook.h"

namespace lightcook::pipeline {

/// Options of every converter.
struct ConverterOptions {
    std::filesystem::path input;             ///< not of lut
    std::filesystem::path output;            ///< a folder; or a .ktx2 file if the asset is one texture, or .dds if that has no constants
    CookOptions cook;                        ///< overrides of [output], repair, cache
    std::optional<std::string> source = {};  ///< colour space of the input; empty: what the file states
};

/// Returns the colour spaces of a command without a scene file.
/// source  of --source; empty: what the file states
formats::ColorSpaces colorsOf(const std::optional<std::string>& source);
/// Fails for a --source that is no linear colour space.
formats::Result<void> checkSource(const std::optional<std::string>& source);

/// Returns a scene without assets for the converter's input. What the file states about its colours is no finding if --source was given.
Scene sceneFor(const ConverterOptions& options);

/// Refuses a --container that is not that of the output file.
formats::Result<void> checkContainer(const CookOptions& cook, const std::filesystem::path& output);

/// Returns the error of a DDS file for a texture with constants of the decode: DDS has no place for them, and no manifest lies beside it.
/// otherwise   outputs that keep the constants
formats::Error constantsAreLost(const std::filesystem::path& output, const std::string& otherwise);

/// Cooks the assets of one kind of a scene to options.output.
Outcome convertScene(Scene scene, const std::string& kind, const ConverterOptions& options, const RunState& state);

/// An outcome that is nothing but an error.
Outcome failedOutcome(formats::Error error);

}  // namespace lightcook::pipeline

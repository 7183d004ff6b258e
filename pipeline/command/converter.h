// The commands that convert one asset: lightmap, dominant, cubemap, lut, rsrm. Each is a scene of that asset, read from the keys that its
// options give, and then cooked and verified like any other.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/command/key_options.h"
#include "pipeline/cook/cook.h"

namespace lightcook::pipeline {

struct Conversion {
    std::string command;           ///< "lightmap"
    std::filesystem::path input;   ///< not of lut
    std::filesystem::path output;  ///< a folder; or a .ktx2 file if the asset is one texture, or .dds if that has no constants
    CookOptions cook = {};         ///< given keys, repair, cache
};

/// Returns the scene of a conversion. What files state about their colours is no finding if the colour space is given.
formats::Result<Scene> sceneOf(const Conversion& conversion);

/// Cooks the asset of a conversion.
Outcome convert(const Conversion& conversion, const RunState& state);

/// Returns the settings of a command that has no scene: those of a scene without assets, where files state their colour space.
formats::Result<Scene> settingsOf(const GivenKeys& given);
/// Returns the colour spaces of such a command.
/// source  colour space of the input; empty: what the file states
formats::ColorSpaces colorsOf(const std::optional<std::string>& source);

/// Returns the options of the conventions of a baked light map.
std::vector<KeyOption> conventionOptions();
/// Returns the conventions that such options give for a bake. Fails for a --mesh that is none with light-map UVs.
/// meshes  that the command has beside --mesh; a single one stands in its place
formats::Result<formats::LightMapDescription> describeBake(const std::filesystem::path& bake, const GivenKeys& given,
                                                           const std::vector<std::filesystem::path>& meshes = {});

/// Returns the error of a DDS file for a texture with constants of the decode: DDS has no place for them, and no manifest lies beside it.
/// otherwise   outputs that keep the constants
formats::Error constantsAreLost(const std::filesystem::path& output, const std::string& otherwise);

}  // namespace lightcook::pipeline

// Options that give keys of the scene file (GivenKeys). Name, value, choices, default and help of an option come from the row of its key.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/document/given_keys.h"

namespace CLI {  // NOLINT(readability-identifier-naming): name of the library
class App;
class Option;
}  // namespace CLI

namespace lightcook::pipeline {

/// An option of a key. A flag whose name begins with "no-" gives false.
struct KeyOption {
    std::string_view key;                 ///< "output.max_error"
    std::string_view name = {};           ///< without dashes; empty: that of the key
    std::vector<std::string> names = {};  ///< values that the command takes; empty: those of the key
    std::string text = {};                ///< help, with the default; empty: caption and default of the key
};

/// Adds an option that sets its key in `given`, and refuses what the reader of a scene would refuse.
/// hasDefault  its help shows the default; else it is that of the scene file
CLI::Option* addKeyOption(CLI::App& app, GivenKeys& given, const KeyOption& option, bool hasDefault = true);
void addKeyOptions(CLI::App& app, GivenKeys& given, std::span<const KeyOption> options);

/// Adds an option for each key of [output].
void addOutputOptions(CLI::App& app, GivenKeys& given);

/// Returns the option --source of a command without a scene file.
KeyOption sourceOption();
/// Return the options of all converters, of those that encode textures, and of those of one asset that is no light map.
std::vector<KeyOption> fileOptions();
std::vector<KeyOption> textureOptions();
std::vector<KeyOption> converterLimitOptions();

}  // namespace lightcook::pipeline

// Settings of a user for all scenes. Each is an option of the command line, else a variable of the environment, else a key of the
// configuration file, $XDG_CONFIG_HOME/lightcook/config.toml or else ~/.config/lightcook/config.toml: --remote-cache,
// LIGHTCOOK_REMOTE_CACHE, remote_cache of [cache].
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "formats/error.h"
#include "pipeline/document/given_keys.h"
#include "pipeline/document/keys.h"

namespace lightcook::pipeline {

struct CacheSettings {
    std::optional<std::filesystem::path> folder;
    std::optional<std::string> remoteCache;  ///< address
    bool remoteUpload = false;
    std::optional<std::filesystem::path> remoteCredentials;  ///< file
    std::string credentials;                                 ///< of the variable, which goes before the file; empty: none
};
struct UserSettings {
    CacheSettings cache;
};

/// Returns what options, environment and configuration file say. Without such a file, none of it comes from there. What the file says of
/// its remote cache is for no other one: credentials least of all.
/// options   keys that the command line gives: "cache.remote_cache"
formats::Result<UserSettings> readUserSettings(const GivenKeys& options = {});

/// Returns the table [cache] of the configuration file, for options and the reference.
const KeyTable& cacheKeyTable();
/// Return the option and the variable of a key: "--remote-cache", "LIGHTCOOK_REMOTE_CACHE".
std::string optionOf(const KeyRow& row);
std::string variableOf(const KeyRow& row);
/// Returns where a value comes from if the option of a key is not given: "$LIGHTCOOK_CACHE, else the configuration file, else ...".
std::string defaultOf(const KeyRow& row);

}  // namespace lightcook::pipeline

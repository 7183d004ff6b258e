// A scene as a Ninja file: each asset is cooked by a command of its own, beside the others, and a last command puts the scene together. The
// commands meet in the cache: the last one finds what the others cooked and verified.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/error.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

struct NinjaOptions {
    std::filesystem::path program;          ///< absolute
    std::filesystem::path output;           ///< folder of the scene, absolute. Each asset has a folder of its own in <output>.assets
    std::filesystem::path cache;            ///< that all commands share, absolute; empty: that of their environment
    std::string launcher;                   ///< of every command; may be empty
    std::vector<std::string> words = {};    ///< options of every command that name a remote cache
    std::vector<std::string> targets = {};  ///< of a scene with several, each of which has a folder in that of a command
};

/// Returns the parts of a scene that have a command each, by the names that `cook --only` takes: light maps with what derives from them,
/// probes, gradients, tables.
std::vector<std::string> ninjaPartsOf(const Scene& scene);

/// Returns a warning if Ninja cannot read the depfiles of the commands, because of a character in the path of the output folder or of a
/// file that the scene names. Each command with that path then runs every time; it finds its results in the cache.
std::optional<formats::Error> warningOfDepfiles(const Scene& scene, const NinjaOptions& options);

/// Refuses paths with control characters, such as a line break, which a Ninja file cannot hold.
formats::Result<void> checkNinjaPaths(const Scene& scene, const NinjaOptions& options);

/// Returns the text of the file, for paths that checkNinjaPaths() allows. Its default target is <output>/cooked.json, or that
/// of each target.
std::string ninjaFileOf(const Scene& scene, const NinjaOptions& options);

}  // namespace lightcook::pipeline

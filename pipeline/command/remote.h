// Options of a command that uses a remote cache, and what it says of it.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "formats/error.h"
#include "pipeline/document/given_keys.h"
#include "pipeline/graph/remote_cache.h"

namespace CLI {  // NOLINT(readability-identifier-naming): name of the library
class App;
}

namespace lightcook::pipeline {

class Terminal;

/// The remote cache of the user's settings (user_settings.h), which the command line gives first.
class RemoteOptions {
public:
    /// mayUpload  with the option that allows it; else who opens the cache decides
    void add(CLI::App& app, bool mayUpload = true);
    /// Opens the cache. Null: none is named.
    /// local     see cacheFolder()
    /// isNeeded  see RemoteCacheOptions; also allows uploads
    formats::Result<std::unique_ptr<RemoteCache>> open(const std::filesystem::path& local, Trace* trace, bool isNeeded = false);
    /// Returns the options that name the cache to another command: its address, after open() in any case, and credentials of the command
    /// line.
    std::vector<std::string> words() const;
    /// Warns of what the cache did not do.
    void warn(Terminal& terminal, const RemoteCounts& counts) const;

private:
    GivenKeys given_;  ///< by the command line
    std::string url_;  ///< after open()
};

/// Return the figures as one line, and as JSON.
std::string lineOf(const RemoteCounts& counts);
Json jsonOf(const RemoteCounts& counts);

}  // namespace lightcook::pipeline

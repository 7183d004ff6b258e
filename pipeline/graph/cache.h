// A local cache of actions: records under ac/, file contents under cas/, both named by digest; runs under runs/. Parts of results lie
// beside them (part_cache.h).
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "formats/error.h"
#include "pipeline/graph/action.h"
#include "pipeline/graph/run_record.h"

namespace lightcook::pipeline {

/// Contents and parts that the cache of a cook keeps [bytes].
inline constexpr std::uint64_t kCacheLimitBytes = std::uint64_t{4} << 30;

class Cache {
public:
    /// root        is created as needed
    /// limitBytes  of contents and parts: prune() removes the least recently used ones beyond it
    Cache(std::filesystem::path root, std::uint64_t limitBytes);

    /// Returns the record of a key, or nothing if it is absent, damaged, or the record of another key. Its contents may have been pruned:
    /// see restore().
    std::optional<ActionRecord> find(const std::string& key) const;
    /// Stores a record and copies of its files, which lie in `folder`.
    formats::Result<void> store(const std::string& key, const ActionRecord& record, const std::filesystem::path& folder) const;
    /// Copies a content to a file. Returns false if the cache does not have it, or has it damaged.
    bool restore(const std::string& digest, const std::filesystem::path& destination) const;
    /// Returns the record in the text of one, or nothing if that is damaged or is the record of another key.
    static std::optional<ActionRecord> parse(const std::string& key, const std::string& text);
    /// Return the places of a record and of a content, where a shared cache reads and writes them.
    std::filesystem::path recordPath(const std::string& key) const;
    std::filesystem::path contentPath(const std::string& digest) const;
    /// Removes the least recently used contents and parts until the rest is within the limit.
    void prune() const;

    /// Stores the time and memory of a run. A cached result names the run that made it.
    void storeRun(const RunRecord& run) const;
    /// Returns a run by its RunRecord::at; nothing if it is not there.
    std::optional<RunRecord> findRun(const std::string& at) const;

    const std::filesystem::path& root() const { return root_; }

private:
    std::filesystem::path root_;
    std::uint64_t limitBytes_;
};

/// Returns a folder if it is not empty, else that of the user's settings (user_settings.h), else $XDG_CACHE_HOME/lightcook, else
/// ~/.cache/lightcook, else a folder in the system's temporary folder. A relative $XDG_CACHE_HOME does not count: the XDG Base Directory
/// Specification calls it invalid.
formats::Result<std::filesystem::path> cacheFolder(const std::filesystem::path& asked);

}  // namespace lightcook::pipeline

// A local cache of actions: records under ac/, contents under cas/, both by digest. Other machines may share it later by the same names.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "formats/error.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

class Cache {
public:
    /// root   made as needed
    /// limitBytes  of contents; the least recently used go when prune() finds more
    Cache(std::filesystem::path root, std::uint64_t limitBytes);

    /// The record of a key, if it is there, whole and readable. Contents may have been pruned: restore() tells.
    std::optional<ActionRecord> find(const std::string& key) const;
    /// Keeps a record and a copy of its files, which lie in `folder`.
    formats::Result<void> store(const std::string& key, const ActionRecord& record, const std::filesystem::path& folder) const;
    /// Puts a content back under a name; false if the cache has it no more, or has it damaged.
    bool restore(const std::string& digest, const std::filesystem::path& destination) const;
    void prune() const;

    const std::filesystem::path& root() const { return root_; }

private:
    std::filesystem::path recordPath(const std::string& key) const;
    std::filesystem::path contentPath(const std::string& digest) const;

    std::filesystem::path root_;
    std::uint64_t limitBytes_;
};

/// $LIGHTCOOK_CACHE, else $XDG_CACHE_HOME/lightcook, else ~/.cache/lightcook, else a folder in the system's temporary one.
std::filesystem::path defaultCacheFolder();

}  // namespace lightcook::pipeline

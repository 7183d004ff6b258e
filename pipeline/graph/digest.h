// Content digests: what an action's inputs and outputs are known by.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <string>
#include <string_view>

#include "formats/error.h"

namespace lightcook::pipeline {

/// XXH3-128 as 32 hexadecimal digits: for change and corruption, not against an adversary.
std::string digestOfText(std::string_view text);
formats::Result<std::string> digestOfFile(const std::filesystem::path& file);

/// Digests of files, remembered by size, times and inode between runs, so that an unchanged file is not read again.
/// Safe from several threads.
class DigestMemo {
public:
    /// memoFile  where to remember; a missing or broken one starts empty
    explicit DigestMemo(std::filesystem::path memoFile);
    formats::Result<std::string> of(const std::filesystem::path& file);
    /// Writes the memo if something was learnt; a memo that cannot be written costs time, not correctness.
    void save() const;

private:
    struct Stamp {
        std::uint64_t size = 0, inode = 0;
        std::int64_t modifiedNs = 0, changedNs = 0;
        bool operator==(const Stamp&) const = default;
    };
    struct Entry {
        Stamp stamp;
        std::string digest;
        std::int64_t learntNs = 0;
    };
    static bool stampOf(const std::filesystem::path& file, Stamp& stamp);

    std::filesystem::path memoFile_;
    mutable std::mutex mutex_;
    std::map<std::string, Entry> entries_;
    bool changed_ = false;
};

}  // namespace lightcook::pipeline

// Content digests, by which the inputs and outputs of actions are identified.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <string>
#include <string_view>

#include "formats/digest.h"
#include "formats/error.h"

namespace lightcook::pipeline {

using formats::digestOfText;
formats::Result<std::string> digestOfFile(const std::filesystem::path& file);

/// Digests of files. They are kept between runs by size, times and inode, so that an unchanged file is not read again. May be used from
/// several threads.
class DigestMemo {
public:
    /// memoFile  holds the digests of earlier runs; a missing or damaged one counts as empty
    explicit DigestMemo(std::filesystem::path memoFile);
    /// Returns the digest of a file as it is now.
    formats::Result<std::string> of(const std::filesystem::path& file);
    /// Returns the digest of an input of a job. Fails if it is not that of the first call: the results of one job are those of one content.
    formats::Result<std::string> ofInput(const std::filesystem::path& file);
    /// Returns the digest that the first ofInput() of a file found, also if the file has changed since; else that of now, empty if the file
    /// cannot be read.
    std::string ofInputAsRead(const std::filesystem::path& file);
    /// Writes the memo if it changed. A memo that cannot be written costs time, not correctness.
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
    static std::string keyOf(const std::filesystem::path& file);

    std::filesystem::path memoFile_;
    mutable std::mutex mutex_;
    std::map<std::string, Entry> entries_;
    std::map<std::string, std::string> inputs_;  ///< digests by ofInput()
    bool changed_ = false;
};

}  // namespace lightcook::pipeline

// Parts of the results of actions, such as the strips of a light map, in the cache folder. A part is named by the digest of all that it
// depends on, so an action is the same function with and without it. The program that made it counts, too: it alone reads it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace lightcook::pipeline {

class PartCache {
public:
    /// root      of the cache
    /// isForced  nothing is found: all parts are made again
    PartCache(const std::filesystem::path& root, bool isForced) : folder_(root / kFolder), isForced_(isForced) {}

    /// Returns a part; nothing if it is not there, or damaged.
    std::optional<std::string> find(const std::string& key) const;
    /// Stores a part. One that cannot be written costs time later.
    void store(const std::string& key, std::string_view content) const;

    static constexpr const char* kFolder = "parts";  ///< of a cache

private:
    std::filesystem::path placeOf(const std::string& key) const;

    std::filesystem::path folder_;
    bool isForced_;
};

}  // namespace lightcook::pipeline

// Parts of the results of actions, such as the strips of a light map, in the cache folder. A part is named by the digest of all that it
// depends on, so an action is the same function with and without it. The program that made it counts, too: it alone reads it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "formats/archive.h"
#include "formats/error.h"

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

/// Returns a part from the cache or, where the cache does not have it, the one that make() returns, which is stored.
/// parts    null: nothing is kept
/// keyOf()  returns a formats::Result: the digest of all that the part depends on. It is called only if there is a cache
/// make()   returns a formats::Result: the part
template <class KeyOf, class Make>
auto cachedPart(const PartCache* parts, KeyOf&& keyOf, Make&& make) -> decltype(make()) {
    using Part = typename decltype(make())::value_type;
    if (parts == nullptr) return make();
    LC_TRY(key, keyOf());
    if (const auto bytes = parts->find(*key))
        if (auto part = formats::unarchived<Part>(*bytes)) return std::move(*part);
    LC_TRY(made, make());
    parts->store(*key, formats::archived(*made));
    return made;
}

}  // namespace lightcook::pipeline

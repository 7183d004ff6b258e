#include "pipeline/graph/part_cache.h"

#include <fmt/format.h>

#include <chrono>
#include <fstream>

#include "formats/temporaries.h"
#include "pipeline/graph/digest.h"
#include "pipeline/graph/files.h"
#include "pipeline/source_digest.h"

namespace lightcook::pipeline {

namespace {

/// Returns the first line of a part: a part that a disk has changed, or that lies under another key, does not have it.
std::string firstLineOf(const std::string& key, std::string_view content) {
    return digestOfText(fmt::format("{}\n{}", key, digestOfText(content))) + "\n";
}

}  // namespace

std::filesystem::path PartCache::placeOf(const std::string& key) const {
    return folder_ / digestOfText(key + kSourceDigest);
}

std::optional<std::string> PartCache::find(const std::string& key) const {
    if (isForced_) return std::nullopt;
    const std::filesystem::path file = placeOf(key);
    auto text = readFile(file);
    if (!text) return std::nullopt;
    const std::size_t begin = text->find('\n') + 1;
    if (begin == 0 || text->substr(0, begin) != firstLineOf(key, std::string_view(*text).substr(begin))) return std::nullopt;
    std::error_code ignored;
    std::filesystem::last_write_time(file, std::filesystem::file_time_type::clock::now(), ignored);  // used
    text->erase(0, begin);
    return std::move(*text);
}

void PartCache::store(const std::string& key, std::string_view content) const {
    if (!makeFolder(folder_)) return;
    auto temporary = formats::Temporary::makeFile(folder_, "");
    if (!temporary) return;
    // Not synced: a part that a crash leaves incomplete counts as damaged.
    std::ofstream stream(temporary->path(), std::ios::binary);
    stream << firstLineOf(key, content) << content;
    stream.close();
    if (stream) (void)temporary->renameTo(placeOf(key));
}

}  // namespace lightcook::pipeline

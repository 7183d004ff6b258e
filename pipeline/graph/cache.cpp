#include "pipeline/graph/cache.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <ctime>

#include "formats/temporaries.h"
#include "pipeline/graph/digest.h"
#include "pipeline/graph/files.h"
#include "pipeline/graph/part_cache.h"
#include "pipeline/graph/record_fields.h"
#include "pipeline/graph/user_settings.h"

namespace lightcook::pipeline {

using formats::Result;

namespace {

/// Returns the first line of a record: a digest of its key and text. A record that a disk has changed, or that lies under the key of
/// another action, does not have it.
std::string recordDigest(const std::string& key, std::string_view text) {
    return digestOfText(fmt::format("{}\n{}", key, text));
}

}  // namespace

Cache::Cache(std::filesystem::path root, std::uint64_t limitBytes) : root_(std::move(root)), limitBytes_(limitBytes) {}

std::filesystem::path Cache::recordPath(const std::string& key) const {
    return root_ / "ac" / key;
}
std::filesystem::path Cache::contentPath(const std::string& digest) const {
    return root_ / "cas" / digest;
}

std::optional<ActionRecord> Cache::find(const std::string& key) const {
    const auto text = readFile(recordPath(key));
    return text ? parse(key, *text) : std::nullopt;
}

std::optional<ActionRecord> Cache::parse(const std::string& key, const std::string& text) {
    const std::size_t end = text.find('\n');
    if (end == std::string::npos || recordDigest(key, std::string_view(text).substr(end + 1)) != text.substr(0, end)) return std::nullopt;
    auto record = fromJson<ActionRecord>(parseJson(text.substr(end + 1)), key);
    if (!record) return std::nullopt;
    for (const FileRecord& file : record->files)  // it becomes the name of a file
        if (file.digest.find_first_not_of("0123456789abcdef") != std::string::npos) return std::nullopt;
    return std::move(*record);
}

Result<void> Cache::store(const std::string& key, const ActionRecord& record, const std::filesystem::path& folder) const {
    for (const FileRecord& file : record.files) {
        // A damaged content is replaced now: else each later run would find another one.
        if (const auto held = digestOfFile(contentPath(file.digest)); held && *held == file.digest) continue;
        LC_CHECK(copyFile(folder / file.name, contentPath(file.digest)));
    }
    const std::string text = toJson(record).dump(-1, ' ', false, Json::error_handler_t::replace);
    return writeFile(recordPath(key), recordDigest(key, text) + "\n" + text);
}

void Cache::storeRun(const RunRecord& run) const {
    (void)writeFile(root_ / "runs" / run.at, toJson(run).dump());  // without it a report names fewer runs
}

std::optional<RunRecord> Cache::findRun(const std::string& at) const {
    const auto text = readFile(root_ / "runs" / at);
    if (!text) return std::nullopt;
    auto run = fromJson<RunRecord>(parseJson(*text), at);
    return run && run->at == at ? std::optional(std::move(*run)) : std::nullopt;
}

std::string timeNow() {
    const auto now = std::chrono::floor<std::chrono::milliseconds>(std::chrono::system_clock::now());
    const std::time_t seconds = std::chrono::system_clock::to_time_t(now);
    std::tm utc{};
    ::gmtime_r(&seconds, &utc);
    return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:03}Z", utc.tm_year + 1900, utc.tm_mon + 1, utc.tm_mday, utc.tm_hour,
                       utc.tm_min, utc.tm_sec, now.time_since_epoch().count() % 1000);
}

bool Cache::restore(const std::string& digest, const std::filesystem::path& destination) const {
    const std::filesystem::path content = contentPath(digest);
    const auto found = digestOfFile(content);
    if (!found) return false;
    std::error_code ignored;
    if (*found != digest) {
        std::filesystem::remove(content, ignored);
        return false;
    }
    std::filesystem::last_write_time(content, std::filesystem::file_time_type::clock::now(), ignored);
    return copyFile(content, destination).has_value();
}

void Cache::prune() const {
    for (const char* part : {"ac", "cas", PartCache::kFolder, "runs"}) formats::removeOldTemporaries(root_ / part);
    struct Content {
        std::filesystem::file_time_type used;
        std::filesystem::path path;
        std::uint64_t bytes;
    };
    std::vector<Content> contents;
    std::uint64_t total = 0;
    std::error_code code;
    for (const char* part : {"cas", PartCache::kFolder})
        for (const auto& entry : std::filesystem::directory_iterator(root_ / part, code)) {
            if (entry.path().filename().string().starts_with(formats::kTemporaryPrefix)) continue;  // another process writes it
            std::error_code each;
            const Content content{entry.last_write_time(each), entry.path(), entry.file_size(each)};
            if (each) continue;
            total += content.bytes;
            contents.push_back(content);
        }
    if (total <= limitBytes_) return;
    std::sort(contents.begin(), contents.end(), [](const Content& a, const Content& b) { return a.used < b.used; });
    for (const Content& content : contents) {
        if (total <= limitBytes_) break;
        if (std::filesystem::remove(content.path, code)) total -= content.bytes;
    }
}

Result<std::filesystem::path> cacheFolder(const std::filesystem::path& asked) {
    if (!asked.empty()) return asked;
    LC_TRY(settings, readUserSettings());
    if (settings->cache.folder) return *settings->cache.folder;
    if (const char* xdg = std::getenv("XDG_CACHE_HOME"); xdg != nullptr && *xdg == '/') return std::filesystem::path(xdg) / "lightcook";
    if (const char* home = std::getenv("HOME"); home != nullptr && *home != 0) return std::filesystem::path(home) / ".cache" / "lightcook";
    std::error_code code;
    return std::filesystem::temp_directory_path(code) / fmt::format("lightcook-cache-{}", ::getuid());
}

}  // namespace lightcook::pipeline

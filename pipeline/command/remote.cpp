#include "pipeline/command/remote.h"

#include <fmt/format.h>

#include <CLI/App.hpp>
#include <algorithm>

#include "pipeline/command/option_groups.h"
#include "pipeline/command/terminal/terminal.h"
#include "pipeline/graph/files.h"
#include "pipeline/graph/user_settings.h"
#include "pipeline/report/words.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Result;

/// Returns the credentials; empty: none.
/// asked   file of the option, as it was typed; nullptr: none
Result<std::string> readCredentials(const CacheSettings& settings, const GivenKey* asked) {
    const std::filesystem::path file = asked != nullptr ? std::filesystem::path(asked->value) : settings.remoteCredentials.value_or("");
    const bool isOfFile = settings.credentials.empty() && !file.empty();
    std::string text = settings.credentials;
    if (isOfFile) {
        LC_TRY(content, readFile(file));
        text = content->substr(0, content->find_first_of("\r\n"));
        if (text.empty())
            return failure(ErrorCode::InvalidRequest, file, "found an empty first line, expected 'user:password' or a token in it");
    }
    const auto isOfHeader = [](char c) { return c >= ' ' && c < 0x7f; };
    if (std::all_of(text.begin(), text.end(), isOfHeader)) return text;
    return failure(ErrorCode::InvalidRequest, isOfFile ? formats::Subject(file) : formats::Subject("LIGHTCOOK_REMOTE_CREDENTIALS"),
                   "found a letter that no header may have, expected 'user:password' or a token in ASCII");
}

}  // namespace

void RemoteOptions::add(CLI::App& app, bool mayUpload) {
    for (const KeyRow& row : cacheKeyTable().keys) {
        const bool isFlag = row.shape == KeyShape::Flag;
        if (!row.name.starts_with("remote_") || (isFlag && !mayUpload)) continue;
        const auto give = [this, key = "cache." + row.name](const std::string& value) { given_.set(key, value); };
        if (isFlag)
            app.add_flag_function(
                optionOf(row), [give](std::int64_t) { give("true"); }, helpOf(row));
        else
            app.add_option_function<std::string>(optionOf(row), give, helpOf(row))
                ->type_name(row.shape == KeyShape::Path ? kFilePlaceholder : "URL");
    }
}

Result<std::unique_ptr<RemoteCache>> RemoteOptions::open(const std::filesystem::path& local, Trace* trace, bool isNeeded) {
    LC_TRY(settings, readUserSettings(given_));
    const CacheSettings& cache = settings->cache;
    if (!cache.remoteCache) {
        if (given_.all().empty()) return nullptr;
        return failure(ErrorCode::InvalidRequest, given_.all().back().option,
                       "found no remote cache, expected --remote-cache URL or $LIGHTCOOK_REMOTE_CACHE");
    }
    url_ = *cache.remoteCache;
    LC_TRY(credentials, readCredentials(cache, given_.find("cache.remote_credentials")));
    LC_TRY(folder, cacheFolder(local));
    return RemoteCache::open(
        {.url = url_, .upload = isNeeded || cache.remoteUpload, .credentials = std::move(*credentials), .isNeeded = isNeeded},
        Cache(*folder, kCacheLimitBytes), trace);
}

std::vector<std::string> RemoteOptions::words() const {
    std::vector<std::string> words;
    const auto add = [&](const char* key, const std::string& value) { words.insert(words.end(), {optionNamed(key), value}); };
    if (const GivenKey* address = given_.find("cache.remote_cache"); address != nullptr || !url_.empty())
        add("remote_cache", url_.empty() ? address->value : url_);
    if (const GivenKey* file = given_.find("cache.remote_credentials"))
        add("remote_credentials", std::filesystem::absolute(file->value).string());
    return words;
}

void RemoteOptions::warn(Terminal& terminal, const RemoteCounts& counts) const {
    const auto results = [](int count) { return counted(static_cast<std::uint64_t>(count), "result"); };
    if (counts.failed > 0)
        terminal.warning(url_, fmt::format("found no answer about {} ({}), expected a cache there: the cook went on without it",
                                           results(counts.failed), counts.firstFailure));
    if (counts.damaged > 0)
        terminal.warning(url_, fmt::format("found {} damaged there ({}), which were made here: a cook with --remote-upload replaces them",
                                           results(counts.damaged), counts.firstDamage));
    if (counts.refused > 0)
        terminal.warning(url_, fmt::format("found {} refused there ({}), expected a cache that takes them: it holds less than it could",
                                           results(counts.refused), counts.firstRefusal));
    if (counts.notUploaded > 0) {
        const std::string why = counts.firstFailure.empty() ? "" : fmt::format(" ({})", counts.firstFailure);
        terminal.warning(url_, fmt::format("found {} not uploaded when the cook had ended{}, expected a faster cache: a later cook with "
                                           "--remote-upload and the same cache folder writes them",
                                           results(counts.notUploaded), why));
    }
}

std::string lineOf(const RemoteCounts& counts) {
    std::string line = fmt::format("remote cache: {} read ({}), {} not there", counted(static_cast<std::uint64_t>(counts.hits), "result"),
                                   sizeWords(counts.bytesRead), counts.misses);
    for (const auto& [count, what] :
         {std::pair(counts.late, "too late"), std::pair(counts.damaged, "damaged"), std::pair(counts.failed, "without an answer"),
          std::pair(counts.refused, "refused"), std::pair(counts.notUploaded, "not uploaded")})
        if (count > 0) line += fmt::format(", {} {}", count, what);
    if (counts.uploaded > 0) line += fmt::format(", {} written ({})", counts.uploaded, sizeWords(counts.bytesWritten));
    return line;
}

Json jsonOf(const RemoteCounts& counts) {
    return {{"read", counts.hits},
            {"bytes_read", counts.bytesRead},
            {"not_there", counts.misses},
            {"late", counts.late},
            {"damaged", counts.damaged},
            {"failed", counts.failed},
            {"written", counts.uploaded},
            {"bytes_written", counts.bytesWritten},
            {"refused", counts.refused},
            {"not_written", counts.notUploaded},
            {"lost_seconds", counts.lostSeconds}};
}

}  // namespace lightcook::pipeline

#include "pipeline/command/remote.h"

#include <fmt/format.h>

#include <CLI/App.hpp>
#include <algorithm>
#include <cstdlib>

#include "pipeline/command/option_groups.h"
#include "pipeline/command/terminal/terminal.h"
#include "pipeline/graph/files.h"
#include "pipeline/report/words.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Result;

std::string variable(const char* name) {
    const char* const value = std::getenv(name);
    return value == nullptr ? "" : value;
}

/// Returns the credentials of a file, or those of the environment; empty: none.
Result<std::string> readCredentials(const std::filesystem::path& file) {
    constexpr const char* kVariable = "LIGHTCOOK_REMOTE_CREDENTIALS";
    std::string text = variable(kVariable);
    if (!file.empty()) {
        LC_TRY(content, readFile(file));
        text = content->substr(0, content->find_first_of("\r\n"));
        if (text.empty())
            return failure(ErrorCode::InvalidRequest, file, "found an empty first line, expected 'user:password' or a token in it");
    }
    const auto isOfHeader = [](char c) { return c >= ' ' && c < 0x7f; };
    if (std::all_of(text.begin(), text.end(), isOfHeader)) return text;
    return failure(ErrorCode::InvalidRequest, file.empty() ? formats::Subject(kVariable) : formats::Subject(file),
                   "found a letter that no header may have, expected 'user:password' or a token in ASCII");
}

}  // namespace

void RemoteOptions::add(CLI::App& app, bool mayUpload) {
    app.add_option("--remote-cache", url_,
                   "Address of a cache that a team shares over HTTP: results that the cache folder does not have come from there; default: "
                   "$LIGHTCOOK_REMOTE_CACHE, else none")
        ->type_name("URL");
    if (mayUpload)
        app.add_flag("--remote-upload", upload_,
                     "Also write results into the remote cache; default: only if $LIGHTCOOK_REMOTE_UPLOAD is 1");
    addFileOption(app, "--remote-credentials", credentials_,
                  "File whose first line is 'user:password' or a token for the remote cache; default: $LIGHTCOOK_REMOTE_CREDENTIALS, which "
                  "has that line itself");
}

Result<std::unique_ptr<RemoteCache>> RemoteOptions::open(const std::filesystem::path& local, Trace* trace, bool isNeeded) {
    if (url_.empty()) url_ = variable("LIGHTCOOK_REMOTE_CACHE");
    if (url_.empty()) {
        if (!upload_ && credentials_.empty()) return nullptr;
        return failure(ErrorCode::InvalidRequest, upload_ ? "--remote-upload" : "--remote-credentials",
                       "found no remote cache, expected --remote-cache URL or $LIGHTCOOK_REMOTE_CACHE");
    }
    LC_TRY(credentials, readCredentials(credentials_));
    const bool upload = isNeeded || upload_ || variable("LIGHTCOOK_REMOTE_UPLOAD") == "1";
    return RemoteCache::open({.url = url_, .upload = upload, .credentials = std::move(*credentials), .isNeeded = isNeeded},
                             Cache(local.empty() ? defaultCacheFolder() : local, kCacheLimitBytes), trace);
}

std::vector<std::string> RemoteOptions::words() const {
    std::vector<std::string> words;
    if (!url_.empty()) words = {"--remote-cache", url_};
    if (!credentials_.empty()) words.insert(words.end(), {"--remote-credentials", std::filesystem::absolute(credentials_).string()});
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

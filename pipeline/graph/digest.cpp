#include "pipeline/graph/digest.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <memory>
#include <new>
#include <nlohmann/json.hpp>

#include "pipeline/graph/files.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Result;

std::int64_t nowNs() {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
}

/// A file changed within this time before it was read may change again without its times moving.
constexpr std::int64_t kRacyNs = 20'000'000;

}  // namespace

Result<std::string> digestOfFile(const std::filesystem::path& file) {
    std::error_code code;
    const std::filesystem::file_status status = std::filesystem::status(file, code);
    if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))  // a pipe or a device may never end
        return failure(ErrorCode::FileUnreadable, file, "found something that is no file, expected a readable file");
    std::ifstream stream(file, std::ios::binary);
    if (!stream) return failure(ErrorCode::FileUnreadable, file, fmt::format("found {}, expected a readable file", std::strerror(errno)));
    formats::Digest digest;
    std::vector<char> buffer(1 << 20);
    while (stream.read(buffer.data(), static_cast<std::streamsize>(buffer.size())) || stream.gcount() > 0)
        digest.add(std::span<const char>(buffer).first(static_cast<std::size_t>(stream.gcount())));
    if (stream.bad()) return failure(ErrorCode::FileUnreadable, file, "found a read error, expected a readable file");
    return digest.text();
}

bool DigestMemo::stampOf(const std::filesystem::path& file, Stamp& stamp) {
    struct stat status {};
    if (::stat(file.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return false;
    stamp.size = static_cast<std::uint64_t>(status.st_size);
    stamp.inode = status.st_ino;
    stamp.modifiedNs = status.st_mtim.tv_sec * 1'000'000'000LL + status.st_mtim.tv_nsec;
    stamp.changedNs = status.st_ctim.tv_sec * 1'000'000'000LL + status.st_ctim.tv_nsec;
    return true;
}

DigestMemo::DigestMemo(std::filesystem::path memoFile) : memoFile_(std::move(memoFile)) {
    std::ifstream stream(memoFile_);
    const nlohmann::json json = nlohmann::json::parse(stream, nullptr, false);
    if (!json.is_object()) return;
    for (const auto& [path, row] : json.items()) {
        if (!row.is_array() || row.size() != 6) continue;
        try {
            Entry entry;
            entry.stamp = {row[0].get<std::uint64_t>(), row[1].get<std::uint64_t>(), row[2].get<std::int64_t>(),
                           row[3].get<std::int64_t>()};
            entry.digest = row[4].get<std::string>();
            entry.learntNs = row[5].get<std::int64_t>();
            entries_[path] = entry;
        } catch (const nlohmann::json::exception&) {
            continue;  // a row that is not ours is not believed
        }
    }
}

std::string DigestMemo::keyOf(const std::filesystem::path& file) {
    return std::filesystem::absolute(file).lexically_normal().string();
}

Result<std::string> DigestMemo::of(const std::filesystem::path& file) {
    Stamp stamp;
    if (!stampOf(file, stamp)) {
        std::error_code code;
        const auto kind = std::filesystem::status(file, code).type();
        const char* found = kind == std::filesystem::file_type::directory   ? "a folder"
                            : kind == std::filesystem::file_type::not_found ? "no such file"
                            : kind == std::filesystem::file_type::none      ? "a file that may not be looked at"
                                                                            : "something that is no file";
        return failure(ErrorCode::FileUnreadable, file, fmt::format("found {}, expected a readable file", found));
    }
    const std::string path = keyOf(file);
    {
        const std::lock_guard lock(mutex_);
        const auto known = entries_.find(path);
        if (known != entries_.end() && known->second.stamp == stamp && known->second.learntNs - stamp.changedNs > kRacyNs)
            return known->second.digest;
    }
    const std::int64_t learntNs = nowNs();
    Result<std::string> digest = digestOfFile(file);
    Stamp after;
    if (digest && stampOf(file, after) && after == stamp) {
        const std::lock_guard lock(mutex_);
        entries_[path] = {stamp, *digest, learntNs};
        changed_ = true;
    }
    return digest;
}

Result<std::string> DigestMemo::ofInput(const std::filesystem::path& file) {
    Result<std::string> digest = of(file);
    if (!digest) return digest;
    const std::lock_guard lock(mutex_);
    if (inputs_.try_emplace(keyOf(file), *digest).first->second == *digest) return digest;
    return failure(ErrorCode::FileUnreadable, file,
                   "found a file that changed while it was in use, expected the same content to the end: run the command again");
}

std::string DigestMemo::ofInputAsRead(const std::filesystem::path& file) {
    {
        const std::lock_guard lock(mutex_);
        if (const auto known = inputs_.find(keyOf(file)); known != inputs_.end()) return known->second;
    }
    return of(file).value_or("");
}

void DigestMemo::save() const {
    const std::lock_guard lock(mutex_);
    if (!changed_) return;
    nlohmann::json json = nlohmann::json::object();
    for (const auto& [path, entry] : entries_) {
        Stamp now;
        if (!stampOf(path, now) || now != entry.stamp) continue;  // gone or changed: forget it
        json[path] = {entry.stamp.size, entry.stamp.inode, entry.stamp.modifiedNs, entry.stamp.changedNs, entry.digest, entry.learntNs};
    }
    (void)writeFile(memoFile_, json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
}

}  // namespace lightcook::pipeline

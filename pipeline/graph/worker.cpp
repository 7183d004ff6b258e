#include "pipeline/graph/worker.h"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <filesystem>
#include <mutex>
#include <thread>
#include <vector>

#include "pipeline/graph/executor.h"
#include "pipeline/graph/files.h"
#include "pipeline/graph/job.h"
#include "pipeline/graph/sha256.h"

namespace lightcook::pipeline {
namespace {

using formats::Error;
using formats::ErrorCode;
using formats::failure;
using formats::Result;

constexpr std::size_t kWrittenBytes = 1 << 20;  ///< that show that a folder takes files

std::string machineName() {
    std::array<char, 256> name{};
    return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "node";
}

Result<std::string> readJobText(const std::string& job, const Cache& cache, RemoteCache* remote, const RunState& state) {
    if (remote != nullptr) return remote->readText(job, state.interrupted);
    const std::filesystem::path place = cache.contentPath(job);
    auto text = readFile(place);
    if (text && sha256OfText(*text) == job) return text;
    return failure(ErrorCode::Internal, place, "found no such job, expected it in the cache folder: all machines have to share it");
}

/// Reads contents into the cache. Damaged ones that it has are replaced.
Result<void> readContents(const std::vector<SharedContent>& contents, const Cache& cache, RemoteCache& remote, const RunState& state) {
    for (const SharedContent& content : contents) {
        std::error_code code;
        const std::filesystem::path held = cache.contentPath(content.digest);
        if (const auto found = digestOfFile(held); found && *found != content.digest) std::filesystem::remove(held, code);
        std::filesystem::last_write_time(held, std::filesystem::file_time_type::clock::now(), code);
    }
    return remote.readContents(contents, state.interrupted);
}

/// Puts a content of the cache into a place of a folder. A link, so that prune() of another process does not take it away.
Result<void> place(const SharedContent& content, const std::filesystem::path& at, const Cache& cache) {
    LC_CHECK(makeFolder(at.parent_path()));
    const std::filesystem::path held = cache.contentPath(content.digest);
    if (const auto found = digestOfFile(held); !found || *found != content.digest)
        return failure(ErrorCode::Internal, held, fmt::format("found no content of {}, expected it in the cache folder", content.name));
    std::error_code code;
    std::filesystem::create_hard_link(held, at, code);
    if (!code || std::filesystem::exists(at, code)) return {};  // two roles may name one file
    return copyFile(held, at);
}

/// Names a file as the machine does that wrote the job.
void rename(Error& error, const std::filesystem::path& here, const std::string& there) {
    const std::string name = here.string();
    if (error.subject.starts_with(name)) error.subject = there + error.subject.substr(name.size());
    if (error.file == here) error.file = there;
}

Result<std::string> tryJob(const std::string& name, const std::string& machine, ActionTable functions, const Cache& cache,
                           RemoteCache* remote, const RunState& state) {
    LC_TRY(text, readJobText(name, cache, remote, state));
    LC_TRY(job, readJob(*text, machine));
    LC_TRY(folder, TemporaryFolder::create(cache.root()));
    const std::filesystem::path inputs = folder->path() / "in", files = folder->path() / "out";
    LC_CHECK(makeFolder(files));
    if (remote != nullptr) {
        std::vector<SharedContent> contents = job->files;
        for (const JobInput& input : job->inputs) contents.push_back(input.content);
        LC_CHECK(readContents(contents, cache, *remote, state));
    }
    Action action = job->action;
    for (const JobInput& input : job->inputs) {
        std::filesystem::path& file = action.inputs[input.role] = input.absolute;
        if (remote == nullptr) continue;
        file = inputs / std::filesystem::path(input.absolute).relative_path();
        LC_CHECK(place(input.content, file, cache));
    }
    for (const SharedContent& content : job->files) LC_CHECK(place(content, files / content.name, cache));

    RunState running;
    std::mutex mutex;
    std::string fault;  // of the cache, without which there is no result
    running.warning = [&](const std::string& subject, const std::string& detail) {
        const std::lock_guard lock(mutex);
        fault = subject + ": " + detail;
    };
    running.progress = [&](const Action&, const std::string&, double) {
        if (state.interrupted) running.interrupted = true;
    };
    DigestMemo digests(folder->path() / "digests");
    const ExecutionContext context{functions, cache, digests, running, timeNow()};
    auto record = executeJob(*job, action, {files, job->force}, context);
    if (!record) {
        Error error = record.error();
        for (const JobInput& input : job->inputs) rename(error, action.inputs[input.role], input.content.name);
        rename(error, files, "");
        return tl::make_unexpected(std::move(error));
    }
    if (!fault.empty()) return failure(ErrorCode::Internal, action.id, fault);
    if (remote == nullptr) return action.id;
    remote->upload(job->key, action.id, RemoteCache::Upload::Replace);
    const RemoteCounts counts = remote->finish();
    if (counts.uploaded == 1) return action.id;
    return failure(counts.refused > 0 ? ErrorCode::InvalidRequest : ErrorCode::Internal, action.id,
                   fmt::format("found that its result cannot be written into the remote cache ({}{}), expected a cache that takes it",
                               counts.firstRefusal, counts.firstFailure));
}

}  // namespace

Result<std::string> runJob(const std::string& job, ActionTable functions, const Cache& cache, RemoteCache* remote, const RunState& state) {
    const std::string machine = machineName();
    auto done = tryJob(job, machine, functions, cache, remote, state);
    if (done || done.error().code != ErrorCode::Internal) return done;
    done.error().subject = machine + ", " + done.error().subject;
    return done;
}

void holdIfFull(const Cache& cache, const RunState& state) {
    {
        const auto folder = TemporaryFolder::create(cache.root());
        if (folder && writeFile(folder->path() / "written", std::string(kWrittenBytes, ' '))) return;
    }
    constexpr std::chrono::milliseconds kHold{20'000}, kStep{20};
    for (auto left = kHold; left > kStep && !state.interrupted; left -= kStep) std::this_thread::sleep_for(kStep);
}

}  // namespace lightcook::pipeline

#include "pipeline/graph/launcher.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <string_view>
#include <thread>

#include "pipeline/graph/files.h"
#include "pipeline/graph/launched_command.h"
#include "pipeline/graph/sha256.h"
#include "pipeline/graph/shell_word.h"

namespace lightcook::pipeline {
namespace {

using formats::Error;
using formats::ErrorCode;
using formats::failure;
using formats::Result;

/// Memory of a process that has read nothing, and how much more a limit allows than is expected.
constexpr double kBaseBytes = 128 << 20, kMemoryMargin = 1.5, kTimeMargin = 4;
constexpr double kMostScale = 4;  ///< of later launches
constexpr int kLeastMinutes = 5, kMemoryStep = 64;
/// Bytes of memory for a byte of a file, before the first action of a kind.
constexpr double kMemoryPerByte = 8;
/// Seconds for a byte of a file, before the first action of a kind: two cores, cornell, interior and outdoor of the test scenes.
struct KnownRate {
    std::string_view kind;
    double secondsPerByte;
};
constexpr std::array kKnownRates = {KnownRate{"light-map-trial", 2e-6}, KnownRate{"joint-trial", 2e-6}, KnownRate{"pack-charts", 1e-6},
                                    KnownRate{"verify-light-map", 4e-7}, KnownRate{"light-map", 1e-7}};
constexpr double kOtherRate = 5e-8;

/// Returns the size of everything that an action reads.
double bytesReadBy(const Action& action, const std::vector<const ActionRecord*>& upstream) {
    std::uint64_t bytes = 0;
    for (const auto& [role, file] : action.inputs) bytes += sizeOf(file);
    for (const ActionRecord* record : upstream)
        for (const FileRecord& file : record->files) bytes += file.bytes;
    return static_cast<double>(bytes);
}

void replaceAll(std::string& text, std::string_view what, const std::string& with) {
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + with.size()))
        text.replace(at, what.size(), with);
}

/// Waits for a moment, or until an interrupt.
void pause(std::chrono::milliseconds time, const std::atomic<bool>& interrupted) {
    constexpr std::chrono::milliseconds kStep{20};
    for (; time > kStep && !interrupted; time -= kStep) std::this_thread::sleep_for(kStep);
}

}  // namespace

std::string filledLauncher(const std::string& command, const Prediction& prediction) {
    const auto mebibytes = static_cast<std::int64_t>(std::ceil(kMemoryMargin * prediction.bytes / (1 << 20) / kMemoryStep)) * kMemoryStep;
    const auto minutes = std::max<std::int64_t>(kLeastMinutes, std::llround(std::ceil(kTimeMargin * prediction.seconds / 60)));
    std::string filled = command;
    replaceAll(filled, "{memory}", std::to_string(mebibytes));
    replaceAll(filled, "{time}", std::to_string(minutes));
    return filled;
}

Launcher::Launcher(LaunchOptions options, const Cache& cache, RemoteCache* remote, Trace* trace)
    : options_(std::move(options)),
      cache_(cache),
      remote_(remote),
      trace_(trace),
      seconds_(cache.root() / "launch_seconds.json"),
      memory_(cache.root() / "launch_memory.json") {}

Prediction Launcher::predict(const Action& action, const std::vector<const ActionRecord*>& upstream) const {
    const double bytes = bytesReadBy(action, upstream);
    const std::lock_guard lock(mutex_);
    const auto learnt = [&](const WorkRates& rates) {
        const auto ofAsset = rates.secondsOf(action.kind + "/" + action.asset, bytes);
        return ofAsset ? ofAsset : rates.secondsOf(action.kind, bytes);
    };
    const auto* const known =
        std::find_if(kKnownRates.begin(), kKnownRates.end(), [&](const auto& each) { return each.kind == action.kind; });
    return {learnt(seconds_).value_or(bytes * (known != kKnownRates.end() ? known->secondsPerByte : kOtherRate)),
            kBaseBytes + learnt(memory_).value_or(bytes * kMemoryPerByte)};
}

bool Launcher::takes(const Action& action, const std::vector<const ActionRecord*>& upstream) const {
    // A job is JSON, which holds no other names.
    const bool hasPlainNames = std::all_of(action.inputs.begin(), action.inputs.end(),
                                           [](const auto& input) { return isUtf8(std::filesystem::absolute(input.second).string()); });
    return hasPlainNames && predict(action, upstream).seconds >= kLeastSeconds;
}

void Launcher::learn(const Action& action, const std::vector<const ActionRecord*>& upstream, const ActionRecord& record) {
    const double bytes = bytesReadBy(action, upstream);
    const std::lock_guard lock(mutex_);
    for (const std::string& of : {action.kind, action.kind + "/" + action.asset}) {
        seconds_.add(of, bytes, record.seconds);
        if (record.peakRssBytes > 0) memory_.add(of, bytes, std::max(0.0, static_cast<double>(record.peakRssBytes) - kBaseBytes));
    }
}

void Launcher::save() const {
    const std::lock_guard lock(mutex_);
    seconds_.save();
    memory_.save();
}

Result<std::string> Launcher::sha256Of(const std::string& digest, const std::filesystem::path& file) {
    {
        const std::lock_guard lock(mutex_);
        if (const auto known = sha256_.find(digest); known != sha256_.end()) return known->second;
    }
    LC_TRY(sha256, sha256OfFile(file));
    const std::lock_guard lock(mutex_);
    return sha256_[digest] = *sha256;
}

Result<std::string> Launcher::writeJob(const Launch& launch, bool replace) {
    Job job{.program = thisProgram(), .key = launch.key, .force = launch.force};
    job.action = launch.action;
    job.action.inputs.clear();
    std::vector<SharedContent> contents;
    std::vector<std::filesystem::path> files;
    const auto share = [&](SharedContent& content, const std::filesystem::path& file) -> Result<void> {
        if (remote_ != nullptr) {
            LC_TRY(sha256, sha256Of(content.digest, file));
            content.sha256 = std::move(*sha256);
        }
        contents.push_back(content);
        files.push_back(file);
        return {};
    };
    for (const auto& [role, file] : launch.action.inputs) {
        const std::filesystem::path absolute = std::filesystem::absolute(file).lexically_normal();
        const bool isMade =
            std::mismatch(launch.folder.begin(), launch.folder.end(), file.begin(), file.end()).first == launch.folder.end();
        LC_TRY(digest, isMade ? launch.digests.of(file) : launch.digests.ofInput(file));
        JobInput input{role, absolute.string(), {file.string(), {}, *digest, sizeOf(file)}};
        // Nodes that share the folder of the cache see the files of the user too.
        if (remote_ != nullptr) LC_CHECK(share(input.content, file));
        job.inputs.push_back(std::move(input));
    }
    for (const ActionRecord* record : launch.upstream) {
        job.upstream.push_back(*record);
        for (const FileRecord& file : record->files) {
            SharedContent content{file.name, {}, file.digest, file.bytes};
            LC_CHECK(share(content, launch.folder / file.name));
            job.files.push_back(std::move(content));
        }
    }
    const std::string text = textOfJob(job);
    std::string name = sha256OfText(text);
    const std::filesystem::path place = cache_.contentPath(name);
    LC_CHECK(writeFile(place, text));
    if (remote_ == nullptr) {
        for (std::size_t i = 0; i < contents.size(); ++i)
            if (const auto held = cache_.contentPath(contents[i].digest); replace || sizeOf(held) != contents[i].bytes)
                LC_CHECK(copyFile(files[i], held));
        return name;
    }
    contents.push_back({"job", name, {}, text.size()});
    files.push_back(place);
    LC_CHECK(remote_->writeContents(contents, files, replace, launch.state.interrupted));
    return name;
}

Result<void> Launcher::launch(const Launch& launch) {
    const Prediction predicted = predict(launch.action, launch.upstream);
    Error fault;
    double scale = 1;
    for (int number = 0; number < kMostLaunches; ++number) {
        if (number > 0) pause(std::chrono::milliseconds(250) * (1 << number), launch.state.interrupted);
        const auto interrupted = [&] { return failure(ErrorCode::Interrupted, launch.action.asset, "interrupted"); };
        if (launch.state.interrupted) return interrupted();
        const auto job = writeJob(launch, number > 0);
        if (!job) {
            fault = job.error();
            if (fault.code != ErrorCode::Internal) break;
            continue;
        }
        const std::string launcher = filledLauncher(options_.command, {scale * predicted.seconds, scale * predicted.bytes});
        std::string command = fmt::format("{} {} work {}", launcher, shellWord(options_.program.string()), *job);
        for (const std::string& word : options_.words) command += " " + shellWord(word);
        const Trace::Clock::time_point start = Trace::Clock::now();
        LC_TRY(end, runCommand(command, launch.state.interrupted,
                               [&](const std::string& output) { return options_.statedError(output).has_value(); }));
        if (trace_ != nullptr)
            trace_->add("launch " + launch.action.id, "launch", start,
                        {{"launcher", launcher}, {"status", end->status}, {"number", number + 1}});
        if (launch.state.interrupted) return interrupted();
        // The cache has the result of an earlier run under the same key: then the status says whether this one has ended.
        if ((!launch.force || end->status == 0) && launch.isDone()) return {};
        if (auto stated = options_.statedError(end->output)) {
            fault = std::move(*stated);
            if (fault.code != ErrorCode::Internal && fault.code != ErrorCode::Interrupted) break;
        } else {
            scale = std::min(2 * scale, kMostScale);
            const std::string said = end->lastLine();
            fault = Error(ErrorCode::Internal, launch.action.id,
                          fmt::format("found no result after '{}' had ended with status {}{}, expected its record and outputs in the cache",
                                      launcher, end->status, said.empty() ? "" : fmt::format(" ({})", said)));
        }
        if (number + 1 < kMostLaunches && launch.state.warning)
            launch.state.warning(fmt::format("{}, launch {}", launch.action.id, number + 1),
                                 (fault.subject == launch.action.id ? fault.detail : fault.line()) + "; it is launched again");
    }
    return tl::make_unexpected(std::move(fault));
}

}  // namespace lightcook::pipeline

#include "pipeline/graph/executor.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <mutex>
#include <optional>

#include "formats/lower_extension.h"
#include "formats/process.h"
#include "pipeline/graph/files.h"
#include "pipeline/graph/part_cache.h"
#include "pipeline/source_digest.h"

namespace lightcook::pipeline {
namespace {

using formats::Error;
using formats::ErrorCode;
using formats::failure;
using formats::Result;

std::string digestOfJson(const Json& json) {
    return digestOfText(json.dump(-1, ' ', false, Json::error_handler_t::replace));
}

/// Returns the digest of an input. A file of the user that has changed since an action first read it is an error; a file of the staging
/// folder, such as a packed bake, may be made anew.
Result<std::string> digestOfInput(const std::filesystem::path& file, const std::filesystem::path& staging, DigestMemo& digests) {
    const bool isStaged = std::mismatch(staging.begin(), staging.end(), file.begin(), file.end()).first == staging.end();
    return isStaged ? digests.of(file) : digests.ofInput(file);
}

/// Returns the key of an action, whose digest names its result in a cache: everything that the result depends on. That is its function,
/// parameters and inputs, the files and results of its dependencies, the sources of this program, and the asset's name, which files and
/// manifest entry have. An input counts with its extension: a gradient in a .png has sRGB values, and a .hdr is not looked at as OpenEXR.
Result<Json> keyOf(const Action& action, const std::vector<const ActionRecord*>& upstream, const std::filesystem::path& staging,
                   DigestMemo& digests) {
    Json key = {{"tool", kSourceDigest},           {"kind", action.kind},      {"asset", action.asset},
                {"parameters", action.parameters}, {"inputs", Json::object()}, {"upstream", Json::array()}};
    for (const auto& [role, path] : action.inputs) {
        LC_TRY(digest, digestOfInput(path, staging, digests));
        key["inputs"][role] = {*digest, formats::lowerExtension(path)};
    }
    for (const ActionRecord* record : upstream) {
        Json files = Json::array();
        for (const FileRecord& file : record->files) files.push_back({file.name, file.digest});
        key["upstream"].push_back(digestOfJson({{"result", record->result}, {"files", files}}));
    }
    return key;
}

class Execution {
public:
    Execution(const ExecuteOptions& options, const std::filesystem::path& staging, const ExecutionContext& with)
        : options_(options),
          staging_(staging),
          functions_(with.functions),
          cache_(with.cache),
          digests_(with.digests),
          state_(with.state),
          run_(with.run),
          keys_(with.keys),
          remote_(with.remote),
          trace_(with.trace),
          launcher_(with.launcher),
          shared_(with.shared != nullptr ? *with.shared : own_) {}

    struct Done {
        ActionRecord record;
        ResultSource source = ResultSource::Run;
    };

    Result<Done> perform(const Action& action, const std::vector<const ActionRecord*>& upstream) {
        const Trace::Clock::time_point start = Trace::Clock::now();
        LC_TRY(key, keyOf(action, upstream, staging_, digests_));
        Result<Done> done = resultOf(action, upstream, digestOfJson(*key));
        const ResultSource source = done ? done->source : options_.force ? ResultSource::ForcedRun : ResultSource::Run;
        if (trace_ != nullptr) {
            constexpr std::array kNames = {"run", "forced run", "local cache", "remote cache"};
            trace_->add(
                action.id, "action", start,
                {{"result", done ? kNames.at(static_cast<std::size_t>(source)) : "none"}, {"seconds", done ? done->record.seconds : 0}});
        }
        if (keys_ != nullptr) keys_->add(action, std::move(*key), source, done.has_value());
        return done;
    }

    /// Runs the action of a job.
    Result<ActionRecord> perform(const Job& job, const Action& action) {
        isAlone_ = true;
        std::vector<const ActionRecord*> upstream;
        for (const ActionRecord& record : job.upstream) upstream.push_back(&record);
        LC_TRY(key, keyOf(action, upstream, staging_, digests_));
        if (digestOfJson(*key) != job.key)
            return failure(ErrorCode::Internal, action.id, "found files that are not those of the job, expected the same on every machine");
        LC_TRY(done, resultOf(action, upstream, job.key));
        return std::move(done->record);
    }

private:
    Result<Done> resultOf(const Action& action, const std::vector<const ActionRecord*>& upstream, const std::string& key) {
        if (!options_.force) {
            if (auto record = reuse(key)) {
                if (remote_ != nullptr) remote_->upload(key, action.id, RemoteCache::Upload::IfMissing);
                return Done{std::move(*record), ResultSource::LocalCache};
            }
        }
        if (options_.unwritable) return tl::make_unexpected(*options_.unwritable);
        if (launcher_ != nullptr) return launchOrRun(action, upstream, key);
        if (remote_ != nullptr && !options_.force) return race(action, upstream, key);
        auto done = run(action, upstream, key, state_);
        if (done && options_.force) done->source = ResultSource::ForcedRun;
        if (done && remote_ != nullptr) remote_->upload(key, action.id, RemoteCache::Upload::Replace);
        return done;
    }

    /// Asks the remote cache. If it does not answer in time, runs the action beside the request: the first result wins.
    Result<Done> race(const Action& action, const std::vector<const ActionRecord*>& upstream, const std::string& key) {
        using Answer = RemoteCache::Answer;
        RunState racing;  // outlives the request, which interrupts it
        RemoteCache::Fetch fetch(*remote_, key, action.id);
        const auto fetched = [&]() -> std::optional<Done> {
            auto record = reuse(key);
            return record ? std::optional(Done{std::move(*record), ResultSource::RemoteCache}) : std::nullopt;
        };
        if (fetch.wait() == Answer::Hit)
            if (auto done = fetched()) return std::move(*done);
        racing.progress = [&](const Action& of, const std::string& what, double fraction) {
            if (state_.interrupted) racing.interrupted = true;
            if (state_.progress) state_.progress(of, what, fraction);
        };
        racing.event = state_.event;
        racing.warning = state_.warning;
        racing.checkOutputs = state_.checkOutputs;
        fetch.watch([&] { racing.interrupted = true; });
        auto done = run(action, upstream, key, racing);
        const Answer answer = fetch.close();
        if (!done && racing.interrupted && !state_.interrupted) {
            if (auto other = fetched()) return std::move(*other);
            done = run(action, upstream, key, state_);
        }
        if (done && answer != Answer::Hit) upload(key, action, answer);
        return done;
    }

    /// Uploads a result that was made here after an answer.
    void upload(const std::string& key, const Action& action, RemoteCache::Answer answer) {
        using Answer = RemoteCache::Answer;
        using Upload = RemoteCache::Upload;
        remote_->upload(key, action.id,
                        answer == Answer::Miss      ? Upload::New
                        : answer == Answer::Damaged ? Upload::Replace
                                                    : Upload::IfMissing);
    }

    /// Asks the remote cache, if there is one. Without a result there the action is launched, or runs here if it is short.
    Result<Done> launchOrRun(const Action& action, const std::vector<const ActionRecord*>& upstream, const std::string& key) {
        using Answer = RemoteCache::Answer;
        std::optional<ActionRecord> record;
        const auto fetch = [&] {
            const Answer answer = remote_ == nullptr ? Answer::Hit : RemoteCache::Fetch(*remote_, key, action.id).wait();
            if (answer == Answer::Hit) record = reuse(key);
            return answer;
        };
        const Answer before = remote_ == nullptr ? Answer::Miss : options_.force ? Answer::Damaged : fetch();
        if (record) return Done{std::move(*record), ResultSource::RemoteCache};
        const ResultSource source = options_.force ? ResultSource::ForcedRun : ResultSource::Run;
        if (!launcher_->takes(action, upstream)) {
            auto done = run(action, upstream, key, state_);
            if (!done) return done;
            done->source = source;
            launcher_->learn(action, upstream, done->record);
            if (remote_ != nullptr) upload(key, action, before);
            return done;
        }
        for (const ActionRecord* each : upstream) LC_CHECK(gather(*each));
        const auto isDone = [&] { return fetch() == Answer::Hit && record.has_value(); };
        LC_CHECK(launcher_->launch({action, upstream, key, options_.force, staging_, digests_, state_, isDone}));
        launcher_->learn(action, upstream, *record);
        return Done{std::move(*record), source};
    }

    /// Returns the record of a key, with its files in place; nothing if the local cache has not all of them.
    std::optional<ActionRecord> reuse(const std::string& key) {
        auto record = cache_.find(key);
        return record && bringBack(*record) ? std::move(record) : std::nullopt;
    }

    /// Returns true if every file of the record is in the output folder, or could be copied from the cache into the staging folder.
    bool bringBack(const ActionRecord& record) {
        for (const FileRecord& file : record.files) {
            std::error_code code;
            const std::filesystem::path present = options_.outputFolder / file.name;
            if (std::filesystem::is_regular_file(present, code) && digests_.of(present) == file.digest) {
                // An earlier graph may have staged another file of this name, such as the texture of a layout that was refuted.
                if (staging_ != options_.outputFolder) std::filesystem::remove(staging_ / file.name, code);
                continue;
            }
            if (options_.unwritable || !cache_.restore(file.digest, staging_ / file.name)) return false;
        }
        return true;
    }

    Result<Done> run(const Action& action, const std::vector<const ActionRecord*>& upstream, const std::string& key,
                     const RunState& state) {
        const auto start = std::chrono::steady_clock::now();
        for (const ActionRecord* record : upstream) LC_CHECK(gather(*record));
        ActionContext context{action, staging_, staging_, upstream, shared_, state};
        const PartCache parts(cache_.root(), options_.force);
        context.parts = &parts;
        LC_TRY(outcome, functions_(action.kind)(context));
        // The file may not be the one that was digested any more: then the result is not that of the key.
        for (const auto& [role, path] : action.inputs) LC_CHECK(digestOfInput(path, staging_, digests_));
        Done done;
        done.record.id = action.id;
        done.record.run = run_;
        done.record.result = std::move(outcome->result);
        for (const std::string& name : outcome->files) {
            LC_TRY(digest, digestOfFile(staging_ / name));
            done.record.files.push_back({name, *digest, std::filesystem::file_size(staging_ / name)});
        }
        if (isAlone_) done.record.peakRssBytes = formats::peakResidentBytes();
        done.record.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        // A cache that is full or read-only costs time later.
        if (const auto stored = cache_.store(key, done.record, staging_);
            !stored && stored.error().code != ErrorCode::Interrupted && state_.warning)
            state_.warning(cache_.root().string(),
                           fmt::format("found a cache that cannot be written ({}), so nothing is kept and the next run makes it again; "
                                       "expected one that can be (--cache, $LIGHTCOOK_CACHE)",
                                       stored.error().line()));
        return done;
    }

    /// Links the files of a dependency that are only in the output folder into the staging folder, so that an action finds all in one
    /// place.
    Result<void> gather(const ActionRecord& record) {
        const std::lock_guard lock(gatherMutex_);
        for (const FileRecord& file : record.files) {
            std::error_code code;
            const std::filesystem::path place = staging_ / file.name;
            if (std::filesystem::exists(place, code)) continue;
            LC_CHECK(makeFolder(place.parent_path()));
            std::filesystem::create_symlink(std::filesystem::absolute(options_.outputFolder / file.name), place, code);
            if (code) return failure(ErrorCode::Internal, place, "found '" + code.message() + "', expected to link a cooked file here");
        }
        return {};
    }

    const ExecuteOptions& options_;
    const std::filesystem::path& staging_;
    ActionTable functions_;
    const Cache& cache_;
    DigestMemo& digests_;
    const RunState& state_;
    std::string run_;
    KeyLog* keys_;
    RemoteCache* remote_;
    Trace* trace_;
    Launcher* launcher_;
    bool isAlone_ = false;  ///< in this process
    SharedObjects own_;
    SharedObjects& shared_;
    std::mutex gatherMutex_;
};

/// Removes the links that an earlier graph gathered in the staging folder: an action that writes a file of such a name, as another layout
/// does, would write through it into the output folder.
void removeLinks(const std::filesystem::path& staging) {
    std::error_code code;
    std::vector<std::filesystem::path> links;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(staging, code))
        if (std::error_code each; entry.is_symlink(each)) links.push_back(entry.path());
    for (const std::filesystem::path& link : links) std::filesystem::remove(link, code);
}

/// Returns the indices of the actions in waves: the dependencies of an action are in earlier waves, as far as they are of this graph.
std::vector<std::vector<std::size_t>> waves(const std::vector<Action>& graph) {
    std::map<std::string, std::size_t> waveOf;
    std::vector<std::vector<std::size_t>> result;
    for (std::size_t index = 0; index < graph.size(); ++index) {
        std::size_t wave = 0;
        for (const std::string& id : graph[index].dependencies)
            if (const auto of = waveOf.find(id); of != waveOf.end()) wave = std::max(wave, of->second + 1);
        waveOf[graph[index].id] = wave;
        if (result.size() <= wave) result.resize(wave + 1);
        result[wave].push_back(index);
    }
    return result;
}

/// Collects the results of actions, in the order of the graph.
ExecutionResult collect(const std::vector<Action>& graph, std::vector<std::optional<Result<Execution::Done>>>& done, bool keepGoing) {
    ExecutionResult result;
    for (std::size_t index = 0; index < graph.size(); ++index) {
        if (!done[index]) continue;
        if (!*done[index]) {
            if (keepGoing || result.errors.empty()) formats::addOnce(result.errors, done[index]->error());
            continue;
        }
        Execution::Done& each = **done[index];
        const bool reused = isReused(each.source);
        (reused ? result.actionsReused : result.actionsRun) += 1;
        if (reused) result.reused[graph[index].id] = each.record.seconds;
        result.files.insert(result.files.end(), each.record.files.begin(), each.record.files.end());
        result.records.emplace(graph[index].id, std::move(each.record));
    }
    return result;
}

}  // namespace

void ExecutionResult::add(ExecutionResult later) {
    records.merge(later.records);
    reused.merge(later.reused);
    errors.insert(errors.end(), later.errors.begin(), later.errors.end());
    files.insert(files.end(), later.files.begin(), later.files.end());
    actionsRun += later.actionsRun;
    actionsReused += later.actionsReused;
}

ExecutionResult execute(const std::vector<Action>& graph, const ExecuteOptions& options, const std::filesystem::path& staging,
                        const ExecutionContext& context) {
    removeLinks(staging);
    Execution execution(options, staging, context);
    std::vector<std::optional<Result<Execution::Done>>> done(graph.size());
    std::map<std::string, std::size_t> indexOf;
    for (std::size_t index = 0; index < graph.size(); ++index) indexOf[graph[index].id] = index;
    const auto recordOf = [&](const std::string& id) -> const ActionRecord* {
        if (const auto index = indexOf.find(id); index != indexOf.end()) {
            const auto& here = done[index->second];
            return here && *here ? &(*here)->record : nullptr;
        }
        for (const ExecutionResult* earlier : context.earlier)
            if (const auto record = earlier->records.find(id); record != earlier->records.end()) return &record->second;
        return nullptr;
    };
    const auto announce = [&](const Action& action, ActionEvent event, double seconds) {
        if (context.state.event) context.state.event(action, event, seconds);
    };
    for (const Action& action : graph) announce(action, ActionEvent::Planned, 0);
    std::atomic<std::size_t> lowestFailure{graph.size()};
    for (const auto& wave : waves(graph)) {
        // The first failure of the graph is reported, whichever thread was first: actions that stand before it are still run.
        if (lowestFailure < graph.size() && !options.keepGoing) break;
        tbb::parallel_for(std::size_t{0}, wave.size(), [&](std::size_t i) {
            const Action& action = graph[wave[i]];
            if (context.state.interrupted || (wave[i] > lowestFailure && !options.keepGoing)) return;
            std::vector<const ActionRecord*> upstream;
            for (const std::string& id : action.dependencies) {
                upstream.push_back(recordOf(id));
                if (upstream.back() == nullptr) return;
            }
            announce(action, ActionEvent::Started, 0);
            done[wave[i]] = formats::ofAsset(action.asset, execution.perform(action, upstream));
            const auto& outcome = *done[wave[i]];
            if (!outcome)
                announce(action, ActionEvent::Failed, 0);
            else
                announce(action, isReused(outcome->source) ? ActionEvent::Reused : ActionEvent::Finished, outcome->record.seconds);
            std::size_t lowest = lowestFailure;
            while (!*done[wave[i]] && wave[i] < lowest && !lowestFailure.compare_exchange_weak(lowest, wave[i])) {
            }
        });
    }
    ExecutionResult result = collect(graph, done, options.keepGoing);
    // The errors of interrupted actions say nothing else.
    if (context.state.interrupted) result.errors.assign(1, Error{ErrorCode::Interrupted, "cook", "interrupted"});
    return result;
}

Result<ActionRecord> executeJob(const Job& job, const Action& action, const ExecuteOptions& options, const ExecutionContext& context) {
    return formats::ofAsset(action.asset, Execution(options, options.outputFolder, context).perform(job, action));
}

Result<void> publish(const ExecutionResult& result, const std::filesystem::path& staging, const std::filesystem::path& outputFolder) {
    for (const FileRecord& file : result.files) {
        std::error_code code;
        const std::filesystem::path staged = staging / file.name;
        if (!std::filesystem::is_regular_file(std::filesystem::symlink_status(staged, code))) continue;
        LC_CHECK(makeFoldersOf(outputFolder, file.name));
        LC_CHECK(moveFile(staged, outputFolder / file.name));
    }
    return {};
}

}  // namespace lightcook::pipeline

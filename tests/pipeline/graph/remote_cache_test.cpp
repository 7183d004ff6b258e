#include "pipeline/graph/remote_cache.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "pipeline/graph/action_result.h"
#include "pipeline/graph/executor.h"
#include "pipeline/graph/files.h"
#include "pipeline/graph/sha256.h"
#include "tests/formats/temporary_folder.h"
#include "tests/pipeline/graph/cache_server.h"

namespace lightcook::pipeline {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;
using namespace std::chrono_literals;

/// Writes a file with the parameters and the files of the dependencies. Takes as long as the parameters say, unless it is interrupted.
formats::Result<ActionOutcome> writeSlowly(const ActionContext& context) {
    std::string text = context.action.parameters.value("text", "");
    for (const ActionRecord* record : context.upstream)
        for (const FileRecord& file : record->files) text += *readFile(context.upstreamFolder / file.name);
    const std::string name = context.action.asset + "/file.txt";
    (void)makeFolder((context.folder / name).parent_path());
    (void)formats::writeContent(context.folder / name, "not whole");
    const int milliseconds = context.action.parameters.value("milliseconds", 0);
    for (int i = 0; i < milliseconds; ++i) {
        std::this_thread::sleep_for(1ms);
        context.report("write", static_cast<double>(i) / milliseconds);
        if (context.state.interrupted) return formats::failure(formats::ErrorCode::Interrupted, context.action.asset, "interrupted");
    }
    (void)formats::writeContent(context.folder / name, text);
    return ActionOutcome{{{"length", text.size()}}, {name}};
}
ActionFunction slowFunction(const std::string&) {
    return writeSlowly;
}

/// Runs of one graph on several machines that share a server.
class SharedCache : public testing::Test {
protected:
    struct Run {
        ExecutionResult result;
        RemoteCounts counts;
        std::string content;  ///< of the last file
        double seconds = 0;
    };
    /// machine       folder of its cache and output
    /// milliseconds  that each action takes
    Run run(const std::string& machine, bool upload, int milliseconds = 0, bool force = false) {
        const auto start = std::chrono::steady_clock::now();
        const std::filesystem::path folder = folder_ / machine;
        const auto staging = TemporaryFolder::create(folder / "");
        const Cache cache(folder / "cache", 1 << 20);
        DigestMemo digests(folder / "memo");
        const RunState state;
        const auto remote = RemoteCache::open({server_.url(), upload, {}, leastWait_}, cache, &trace_);
        ExecutionContext context{slowFunction, cache, digests, state};
        context.remote = remote->get();
        context.trace = &trace_;
        Run done;
        done.result = execute(graph(milliseconds), {folder / "out", force}, staging->path(), context);
        done.counts = (*remote)->finish();
        EXPECT_TRUE(done.result.errors.empty());
        EXPECT_TRUE(publish(done.result, staging->path(), folder / "out").has_value());
        done.content = formats::contentOf(folder / "out/c/file.txt");
        done.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        return done;
    }
    static std::vector<Action> graph(int milliseconds) {
        const auto action = [&](const std::string& name, std::vector<std::string> dependencies) {
            return Action{name, "text", name, {{"text", name + " "}, {"milliseconds", milliseconds}}, {}, std::move(dependencies)};
        };
        return {action("a", {}), action("b", {"a"}), action("c", {"a", "b"})};
    }
    static constexpr const char* kContent = "c a b a ";

    formats::TemporaryFolder folder_;
    Trace trace_;
    CacheServer server_;
    double leastWait_ = 20;  ///< seconds
};

TEST_F(SharedCache, AnotherMachineHasTheResultsWithoutARun) {
    const Run first = run("one", true);
    EXPECT_EQ(first.result.actionsRun, 3);
    EXPECT_EQ(first.counts.misses, 3);
    EXPECT_EQ(first.counts.uploaded, 3);
    EXPECT_EQ(server_.storedCount(), 9u) << "three ActionResults, three records, three files";
    const Run second = run("two", false);
    EXPECT_EQ(second.result.actionsRun, 0);
    EXPECT_EQ(second.counts.hits, 3);
    EXPECT_EQ(second.content, kContent);
    EXPECT_EQ(second.result.records.at("c").result, first.result.records.at("c").result);
    const std::size_t requests = server_.requests().size();
    const Run again = run("two", false);
    EXPECT_EQ(again.result.actionsReused, 3);
    EXPECT_EQ(server_.requests().size(), requests) << "what the machine has itself is not asked for";
}

TEST_F(SharedCache, ContentsAreWrittenBeforeTheirRecordAndOnlyWhereThatIsAllowed) {
    run("one", false);
    EXPECT_EQ(server_.storedCount(), 0u);
    run("one", true);  // from its own cache
    EXPECT_EQ(server_.storedCount(), 9u);
    std::map<std::string, std::size_t> firstPut;
    const std::vector<std::string> requests = server_.requests();
    for (std::size_t i = 0; i < requests.size(); ++i) firstPut.try_emplace(requests[i], i);
    std::size_t results = 0;
    server_.change([&](const std::map<std::string, std::string>& stored) {
        for (const auto& [path, content] : stored) {
            if (!path.starts_with("/cache/ac/")) continue;
            ++results;
            const auto files = readActionResult(content);
            ASSERT_TRUE(files.has_value());
            for (const OutputFile& file : *files) {
                EXPECT_LT(firstPut.at("PUT /cache/cas/" + file.sha256), firstPut.at("PUT " + path));
                EXPECT_EQ(sha256OfText(stored.at("/cache/cas/" + file.sha256)), file.sha256);
            }
        }
    });
    EXPECT_EQ(results, 3u);
    const std::size_t written = server_.requests().size();
    run("one", true);
    EXPECT_EQ(server_.requests().size(), written + 3) << "HEAD alone";
}

struct ReadFault {
    ServerFault fault;
    const char* folder;
    int RemoteCounts::*count;
};
void PrintTo(const ReadFault& fault, std::ostream* stream) {
    *stream << static_cast<int>(fault.fault) << " of " << fault.folder;
}
class ReadFaults : public SharedCache, public testing::WithParamInterface<ReadFault> {};

TEST_P(ReadFaults, TheActionRunsAndTheResultIsRight) {
    run("one", true);
    const std::uint64_t sent = server_.sentBytes();
    if (GetParam().count == &RemoteCounts::late) leastWait_ = 0;
    server_.delay = 200ms;
    server_.setFault(GetParam().fault, "GET", GetParam().folder);
    const Run faulty = run("two", false, 0);
    EXPECT_EQ(faulty.content, kContent);
    EXPECT_EQ(faulty.result.actionsRun, 3);
    EXPECT_EQ(faulty.counts.hits, 0);
    EXPECT_GT(faulty.counts.*GetParam().count, 0);
    EXPECT_EQ(faulty.counts.misses + faulty.counts.late + faulty.counts.damaged + faulty.counts.failed, 3);
    EXPECT_LT(faulty.seconds, 5);
    if (leastWait_ == 0) {
        EXPECT_LT(faulty.counts.lostSeconds, 0.5) << "of 0.02 s and a share of the run, on a busy machine";
    }
    EXPECT_LT(server_.sentBytes() - sent, 128u << 20);
    for (const std::string& request : server_.requests()) EXPECT_THAT(request, testing::Not(HasSubstr("moved")));
    // What the server did wrong is not in the cache of the machine either.
    server_.setFault(nullptr);
    EXPECT_EQ(run("two", false).content, kContent);
}
INSTANTIATE_TEST_SUITE_P(
    All, ReadFaults,
    testing::Values(
        ReadFault{ServerFault::Silent, "ac", &RemoteCounts::late}, ReadFault{ServerFault::Silent, "cas", &RemoteCounts::late},
        ReadFault{ServerFault::Slow, "ac", &RemoteCounts::late}, ReadFault{ServerFault::HangsInBody, "ac", &RemoteCounts::late},
        ReadFault{ServerFault::HangsInBody, "cas", &RemoteCounts::late}, ReadFault{ServerFault::TornBody, "ac", &RemoteCounts::failed},
        ReadFault{ServerFault::TornBody, "cas", &RemoteCounts::damaged}, ReadFault{ServerFault::OtherBody, "ac", &RemoteCounts::damaged},
        ReadFault{ServerFault::OtherBody, "cas", &RemoteCounts::damaged}, ReadFault{ServerFault::ShortBody, "cas", &RemoteCounts::damaged},
        ReadFault{ServerFault::LongBody, "cas", &RemoteCounts::damaged}, ReadFault{ServerFault::HugeBody, "ac", &RemoteCounts::failed},
        ReadFault{ServerFault::HugeBody, "cas", &RemoteCounts::damaged}, ReadFault{ServerFault::HugeChunks, "ac", &RemoteCounts::failed},
        ReadFault{ServerFault::HugeChunks, "cas", &RemoteCounts::damaged}, ReadFault{ServerFault::Empty, "ac", &RemoteCounts::damaged},
        ReadFault{ServerFault::Empty, "cas", &RemoteCounts::damaged}, ReadFault{ServerFault::Redirects, "ac", &RemoteCounts::failed},
        ReadFault{ServerFault::NotHttp, "ac", &RemoteCounts::failed}, ReadFault{ServerFault::LongHead, "ac", &RemoteCounts::failed},
        ReadFault{ServerFault::Missing, "ac", &RemoteCounts::misses}, ReadFault{ServerFault::Missing, "cas", &RemoteCounts::damaged},
        ReadFault{ServerFault::Refuses, "ac", &RemoteCounts::failed}, ReadFault{ServerFault::Closes, "ac", &RemoteCounts::failed}));

TEST_F(SharedCache, AServerThatFailsIsNotAskedAgainAndAgain) {
    server_.setFault(ServerFault::Refuses, "GET", "ac");
    const std::filesystem::path folder = folder_ / "one";
    const Cache cache(folder / "cache", 1 << 20);
    const auto remote = RemoteCache::open({server_.url()}, cache, nullptr);
    for (int i = 0; i < 10; ++i) {
        RemoteCache::Fetch fetch(**remote, fmt::format("{}", i), "a");
        while (fetch.wait() == RemoteCache::Answer::None) std::this_thread::sleep_for(1ms);
    }
    const RemoteCounts counts = (*remote)->finish();
    EXPECT_EQ(counts.failed, 10);
    EXPECT_THAT(counts.firstFailure, AllOf(StartsWith("ac/"), HasSubstr("status 403")));
    EXPECT_EQ(server_.requests().size(), 3u);
}

TEST_F(SharedCache, ARecordOfAnotherActionIsNoHit) {
    run("one", true);
    server_.change([](std::map<std::string, std::string>& stored) {
        std::vector<std::string*> results;
        for (auto& [path, content] : stored)
            if (path.starts_with("/cache/ac/")) results.push_back(&content);
        std::swap(*results[0], *results[1]);
        *results[2] = "";
    });
    const Run swapped = run("two", true);
    EXPECT_EQ(swapped.counts.damaged, 3);
    EXPECT_EQ(swapped.content, kContent);
    EXPECT_EQ(run("three", false).counts.hits, 3) << "an upload replaces what is damaged";
}

TEST_F(SharedCache, ADamagedContentIsReplacedByTheNextUpload) {
    run("one", true);
    server_.change([](std::map<std::string, std::string>& stored) {
        for (auto& [path, content] : stored)
            if (path.starts_with("/cache/cas/")) content.back() = static_cast<char>(content.back() ^ 1);
    });
    const Run reader = run("two", false);
    EXPECT_EQ(reader.counts.damaged, 3);
    EXPECT_THAT(reader.counts.firstDamage, HasSubstr("its record is another content"));
    EXPECT_EQ(run("three", true).counts.uploaded, 3);
    EXPECT_EQ(run("four", false).counts.hits, 3);
    server_.change([](std::map<std::string, std::string>& stored) {
        for (auto& [path, content] : stored) content.clear();
    });
    run("four", true, 0, true);
    EXPECT_EQ(run("five", false).counts.hits, 3) << "--force writes all of it again";
}

TEST_F(SharedCache, RefusedUploadsAreCounted) {
    server_.setFault(ServerFault::Refuses, "PUT", "cas");
    const Run refused = run("one", true);
    EXPECT_EQ(refused.counts.refused, 3);
    EXPECT_THAT(refused.counts.firstRefusal, AllOf(StartsWith("PUT cas/"), HasSubstr("status 403")));
    for (const std::string& request : server_.requests())
        EXPECT_THAT(request, testing::Not(StartsWith("PUT /cache/ac"))) << "no contents, no record";
    server_.setFault(ServerFault::Silent, "PUT", "cas");
    const Run silent = run("two", true);
    EXPECT_EQ(silent.counts.notUploaded, 3);
    EXPECT_LT(silent.seconds, 3) << "an end that does not wait for it";
}

TEST_F(SharedCache, TheFirstResultWins) {
    leastWait_ = 0;
    run("one", true, 2000);
    server_.delay = 150ms;
    server_.setFault(ServerFault::Slow, "GET", "ac");
    const Run late = run("two", false, 2000);
    EXPECT_EQ(late.counts.hits, 3) << "the actions began, and were interrupted";
    EXPECT_EQ(late.result.actionsReused, 3);
    EXPECT_EQ(late.content, kContent);
    EXPECT_LT(late.seconds, 5) << "of at least 6 s without the cache";
    server_.setFault(ServerFault::Silent, "GET", "ac");
    const Run alone = run("three", false, 50);
    EXPECT_EQ(alone.counts.late, 3);
    EXPECT_LT(alone.seconds, 3);
    EXPECT_EQ(alone.content, kContent);
}

TEST_F(SharedCache, AnInterruptEndsARace) {
    server_.setFault(ServerFault::Silent, "GET", "ac");
    const Cache cache(folder_ / "cache", 1 << 20);
    DigestMemo digests(folder_ / "memo");
    RunState state;
    std::atomic<int> passes{0};
    state.progress = [&](const Action&, const std::string&, double) { state.interrupted = ++passes > 10; };
    const auto remote = RemoteCache::open({server_.url()}, cache, nullptr);
    ExecutionContext context{slowFunction, cache, digests, state};
    context.remote = remote->get();
    const auto staging = TemporaryFolder::create(folder_ / "");
    const ExecutionResult result = execute(graph(10000), {folder_ / "out"}, staging->path(), context);
    ASSERT_EQ(result.errors.size(), 1u);
    EXPECT_EQ(result.errors[0].code, formats::ErrorCode::Interrupted);
    EXPECT_LT(passes, 20);
}

TEST_F(SharedCache, AFileOutsideTheFolderIsRefused) {
    const Cache cache(folder_ / "cache", 1 << 20);
    formats::writeContent(folder_ / "file.txt", "content");
    const std::string digest = *digestOfFile(folder_ / "file.txt");
    const std::string outside = "../escaped.txt";
    for (const FileRecord& file :
         {FileRecord{outside, digest, 7}, FileRecord{"/tmp/escaped.txt", digest, 7}, FileRecord{"a", "../../escaped", 7}}) {
        const std::string key = digestOfText(file.name);
        const ActionRecord record{"a", Json::object(), {file}};
        ASSERT_TRUE(makeFolder(folder_ / "deep/er").has_value());
        formats::writeContent(folder_ / "deep/escaped.txt", "content");
        (void)cache.store(key, record, folder_ / "deep/er");
        EXPECT_FALSE(cache.find(key).has_value()) << file.name << " " << file.digest;
    }
}

TEST_F(SharedCache, ATraceHasTheActionsAndTheExchanges) {
    run("one", true);
    run("two", false);
    std::map<std::string, int> counts;
    const Json document = trace_.document();
    for (const Json& event : document["traceEvents"]) {
        ++counts[event["cat"].get<std::string>()];
        EXPECT_EQ(event["ph"], "X");
        EXPECT_GE(event["ts"].get<double>(), 0);
        EXPECT_GE(event["dur"].get<double>(), 0);
        EXPECT_TRUE(event["pid"].is_number_integer() && event["tid"].is_number_integer());
    }
    EXPECT_EQ(counts["action"], 6);
    EXPECT_EQ(counts["wait"], 6);
    EXPECT_EQ(counts["remote write"], 9);
    EXPECT_EQ(counts["remote read"], 3 + 9) << "misses of the first machine, results and contents of the second";
}

TEST(KeyLog, NamesWhatDiffersFromTheLastRun) {
    const formats::TemporaryFolder folder;
    formats::writeContent(folder / "map.exr", "one");
    Action first{"a", "text", "a", {{"text", "one "}, {"nested", {{"effort", 5}}}}, {{"source", folder / "map.exr"}}, {}};
    const Action second{"b", "text", "b", {{"text", "two "}}, {}, {"a"}};
    const auto reasons = [&](bool force = false) {
        std::map<std::string, std::string> found;
        std::mutex mutex;
        const auto staging = TemporaryFolder::create(folder / "");
        const Cache cache(folder / "cache", 1 << 20);
        DigestMemo digests(folder / "memo");
        const RunState state;
        KeyLog keys(folder / "keys", [&](const Action& action, bool hasRun, const std::string& why) {
            const std::lock_guard lock(mutex);
            found[action.id] = (hasRun ? "runs: " : "does not run: ") + why;
        });
        ExecutionContext context{slowFunction, cache, digests, state};
        context.keys = &keys;
        const ExecutionResult result = execute({first, second}, {folder / "out", force}, staging->path(), context);
        EXPECT_TRUE(publish(result, staging->path(), folder / "out").has_value());
        keys.save();
        return found;
    };
    EXPECT_EQ(reasons()["a"], "runs: this folder had no result of it");
    auto found = reasons();
    EXPECT_EQ(found["a"], "does not run: nothing has changed");
    EXPECT_EQ(found["b"], "does not run: nothing has changed");
    first.parameters["nested"]["effort"] = 7;
    found = reasons();
    EXPECT_EQ(found["a"], "runs: parameter nested/effort: 5 -> 7");
    EXPECT_EQ(found["b"], "does not run: nothing has changed") << "the result is the same";
    first.parameters["text"] = "uno ";
    first.parameters["nested"]["effort"] = 5;
    found = reasons();
    EXPECT_EQ(found["a"], "runs: parameter text: \"one \" -> \"uno \"; parameter nested/effort: 7 -> 5");
    EXPECT_EQ(found["b"], "runs: the result of a has changed");
    first.parameters["text"] = "one ";
    found = reasons();
    EXPECT_EQ(found["a"], "does not run: the cache has the result for its inputs; parameter text: \"uno \" -> \"one \"");
    formats::writeContent(folder / "map.exr", "another");
    EXPECT_EQ(reasons()["a"], fmt::format("runs: input source ({}) has changed", (folder / "map.exr").string()));
    EXPECT_EQ(reasons(true)["a"], "runs: --force; nothing has changed");
    std::filesystem::remove_all(folder / "cache");
    EXPECT_EQ(reasons()["b"], "runs: nothing has changed, but no cache has its result");
}

}  // namespace
}  // namespace lightcook::pipeline

#include "pipeline/graph/executor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <map>
#include <mutex>

#include "pipeline/graph/files.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::pipeline {
namespace {

/// Writes a file with the parameters, and appends the contents of the dependencies' files.
formats::Result<ActionOutcome> writeText(const ActionContext& context) {
    if (context.action.parameters.value("fails", false))
        return formats::failure(formats::ErrorCode::ValueOutOfRange, context.action.asset, "found a failure, expected none");
    std::string text = context.action.parameters.value("text", "");
    for (const ActionRecord* record : context.upstream)
        for (const FileRecord& file : record->files) text += *readFile(context.upstreamFolder / file.name);
    const std::string name = context.action.asset + ".txt";
    // A link is followed, as those who write textures do.
    if (auto written = writeFile(context.folder / name, text, OutputLink::Follow); !written) return tl::make_unexpected(written.error());
    return ActionOutcome{{{"length", text.size()}}, {name}};
}
/// Replaces the file that the parameters name, as a baker does that runs beside a cook.
formats::Result<ActionOutcome> replaceFile(const ActionContext& context) {
    EXPECT_TRUE(writeFile(context.action.parameters.at("file").get<std::string>(), "another content").has_value());
    return writeText(context);
}
/// Counts its runs in an object that actions share.
formats::Result<ActionOutcome> countRuns(const ActionContext& context) {
    ++context.shared.get<std::atomic<int>>();
    return writeText(context);
}
ActionFunction functionOf(const std::string& kind) {
    return kind == "replace" ? replaceFile : kind == "count" ? countRuns : writeText;
}

class Executor : public testing::Test {
protected:
    ExecutionResult run(const std::vector<Action>& graph, bool keepGoing = false) {
        auto staging = TemporaryFolder::create(folder_ / "");
        const Cache cache(folder_ / "cache", 1 << 20);
        DigestMemo digests(folder_ / "memo");
        RunState state;
        state.warning = [this](const std::string& subject, const std::string& detail) {
            const std::lock_guard lock(mutex_);
            warnings_[subject] = detail;
        };
        ExecutionResult result = execute(graph, {folder_ / "out", false, keepGoing}, staging->path(), {functionOf, cache, digests, state});
        EXPECT_TRUE(publish(result, staging->path(), folder_ / "out").has_value());
        return result;
    }
    static Action action(const std::string& name, const std::string& text, std::vector<std::string> dependencies = {}) {
        return {name, "text", name, {{"text", text}}, {}, std::move(dependencies)};
    }
    formats::TemporaryFolder folder_;
    std::mutex mutex_;
    std::map<std::string, std::string> warnings_;  ///< by subject
};

TEST_F(Executor, DependenciesRunFirstAndTheirFilesAreRead) {
    const ExecutionResult result = run({action("a", "one "), action("b", "two "), action("c", "three ", {"a", "b"})});
    EXPECT_TRUE(result.errors.empty());
    EXPECT_EQ(result.actionsRun, 3);
    EXPECT_EQ(*readFile(folder_ / "out" / "c.txt"), "three one two ");
}

TEST_F(Executor, OnlyChangedActionsAndTheirDependantsRunAgain) {
    run({action("a", "one "), action("b", "two "), action("c", "three ", {"a"})});
    const ExecutionResult result = run({action("a", "uno "), action("b", "two "), action("c", "three ", {"a"})});
    EXPECT_EQ(result.actionsRun, 2);
    EXPECT_EQ(result.actionsReused, 1);
    EXPECT_EQ(*readFile(folder_ / "out" / "c.txt"), "three uno ");
}

/// The extension says how the values of a picture are read.
TEST_F(Executor, AnInputOfAnotherExtensionIsAnotherInput) {
    const auto reuses = [&](const char* name) {
        EXPECT_TRUE(writeFile(folder_ / name, "the same content").has_value());
        Action each = action("a", "one ");
        each.inputs["source"] = folder_ / name;
        return run({each}).actionsReused == 1;
    };
    EXPECT_FALSE(reuses("sky.png"));
    EXPECT_FALSE(reuses("sky.tif"));
    EXPECT_FALSE(reuses("sky.\xff"));
    EXPECT_TRUE(reuses("moved/SKY.PNG"));
}

TEST_F(Executor, AnInputThatChangesWhileAnActionReadsItIsRefused) {
    const std::filesystem::path file = folder_ / "map.exr";
    const Action reader{"a", "replace", "a", {{"text", "one "}, {"file", file.string()}}, {{"source", file}}, {}};
    for (const char* again : {"", " again"}) {
        EXPECT_TRUE(writeFile(file, "the first content").has_value());
        const ExecutionResult result = run({reader});
        ASSERT_EQ(result.errors.size(), 1u) << "not from the cache" << again;
        EXPECT_EQ(result.errors[0].code, formats::ErrorCode::FileUnreadable);
        EXPECT_EQ(result.errors[0].subject, file.string());
        EXPECT_THAT(result.errors[0].detail, testing::HasSubstr("changed while it was in use"));
        EXPECT_FALSE(std::filesystem::exists(folder_ / "out" / "a.txt"));
    }
}

TEST_F(Executor, ActionsDoNotReadOneInputWithTwoContents) {
    const std::filesystem::path file = folder_ / "map.exr";
    EXPECT_TRUE(writeFile(file, "the first content").has_value());
    Action cook = action("cook", "one "), verify = action("verify", "two ", {"between"});
    cook.inputs["source"] = verify.inputs["source"] = file;
    const Action between{"between", "replace", "between", {{"text", ""}, {"file", file.string()}}, {}, {"cook"}};
    const ExecutionResult result = run({cook, between, verify});
    ASSERT_EQ(result.errors.size(), 1u);
    EXPECT_EQ(result.errors[0].subject, file.string());
    EXPECT_FALSE(result.records.contains("verify"));
    verify.dependencies = {"cook"};
    EXPECT_TRUE(run({cook, verify}).errors.empty()) << "the next run reads the new content alone";
}

TEST_F(Executor, AFileThatAnEarlierGraphStagedDoesNotReplaceTheOneOfTheResult) {
    const std::vector<Action> kept = {action("a", "one "), action("c", "three ", {"a"})};
    run(kept);
    const auto staging = TemporaryFolder::create(folder_ / "");
    const Cache cache(folder_ / "cache", 1 << 20);
    DigestMemo digests(folder_ / "memo");
    const RunState state;
    const ExecutionContext context{functionOf, cache, digests, state};
    execute({action("a", "refuted ")}, {folder_ / "out"}, staging->path(), context);
    EXPECT_TRUE(std::filesystem::exists(staging->path() / "a.txt"));
    execute({action("a", "one "), action("d", "four ", {"a"})}, {folder_ / "out"}, staging->path(), context);
    EXPECT_EQ(*readFile(staging->path() / "d.txt"), "four one ") << "an action reads the file of its dependency";
    const ExecutionResult result = execute(kept, {folder_ / "out"}, staging->path(), context);
    EXPECT_EQ(result.actionsReused, 2);
    EXPECT_TRUE(publish(result, staging->path(), folder_ / "out").has_value());
    EXPECT_EQ(*readFile(folder_ / "out" / "a.txt"), "one ");
}

TEST_F(Executor, NothingIsWrittenIntoTheOutputFolderBeforeItIsPublished) {
    run({action("a", "one ")});
    const auto staging = TemporaryFolder::create(folder_ / "");
    const Cache cache(folder_ / "cache", 1 << 20);
    DigestMemo digests(folder_ / "memo");
    const RunState state;
    const ExecutionContext context{functionOf, cache, digests, state};
    execute({action("a", "one "), action("b", "two ", {"a"})}, {folder_ / "out"}, staging->path(), context);
    execute({action("a", "another layout ")}, {folder_ / "out"}, staging->path(), context);
    EXPECT_EQ(*readFile(staging->path() / "a.txt"), "another layout ");
    EXPECT_EQ(*readFile(folder_ / "out" / "a.txt"), "one ");
}

TEST_F(Executor, AnActionWhoseOutputFolderIsTheStagingFolderKeepsItsFiles) {
    const Cache cache(folder_ / "cache", 1 << 20);
    DigestMemo digests(folder_ / "memo");
    const RunState state;
    const ExecutionContext context{functionOf, cache, digests, state};
    for (const int reused : {0, 1}) {
        EXPECT_EQ(execute({action("a", "one ")}, {folder_ / "out"}, folder_ / "out", context).actionsReused, reused);
        EXPECT_EQ(*readFile(folder_ / "out" / "a.txt"), "one ");
    }
}

TEST_F(Executor, GraphsShareObjectsIfTheCallerHasThem) {
    const auto staging = TemporaryFolder::create(folder_ / "");
    const Cache cache(folder_ / "cache", 1 << 20);
    DigestMemo digests(folder_ / "memo");
    const RunState state;
    SharedObjects shared;
    const auto runAction = [&](const std::string& name, SharedObjects* objects) {
        const Action counted{name, "count", name, {{"text", name}}, {}, {}};
        const ExecutionContext context{functionOf, cache, digests, state, {}, objects};
        EXPECT_EQ(execute({counted}, {folder_ / "out"}, staging->path(), context).actionsRun, 1);
        return shared.get<std::atomic<int>>().load();
    };
    EXPECT_EQ(runAction("a", &shared), 1);
    EXPECT_EQ(runAction("b", nullptr), 1) << "a graph has its own";
    EXPECT_EQ(runAction("c", &shared), 2);
}

TEST_F(Executor, LinksInTheOutputFolderAreReplacedAndTheirTargetsStay) {
    namespace fs = std::filesystem;
    ASSERT_TRUE(writeFile(folder_ / "mine.txt", "mine").has_value());
    fs::create_directories(folder_ / "out");
    fs::create_directories(folder_ / "elsewhere");
    ASSERT_TRUE(writeFile(folder_ / "elsewhere/b.txt", "also mine").has_value());
    fs::create_symlink("../mine.txt", folder_ / "out/a.txt");
    fs::create_directory_symlink("../elsewhere", folder_ / "out/sub");
    run({action("a", "one "), action("sub/b", "two ")});
    EXPECT_TRUE(fs::is_regular_file(fs::symlink_status(folder_ / "out/a.txt")));
    EXPECT_TRUE(fs::is_directory(fs::symlink_status(folder_ / "out/sub")));
    EXPECT_EQ(*readFile(folder_ / "out/a.txt"), "one ");
    EXPECT_EQ(*readFile(folder_ / "out/sub/b.txt"), "two ");
    EXPECT_EQ(*readFile(folder_ / "mine.txt"), "mine");
    EXPECT_EQ(*readFile(folder_ / "elsewhere/b.txt"), "also mine");
}

TEST_F(Executor, NothingBehindALinkInTheOutputFolderIsRemoved) {
    namespace fs = std::filesystem;
    for (const char* name : {"mine.txt", "elsewhere/b.txt", "out/c.txt", "out/own/d.txt"})
        ASSERT_TRUE(writeFile(folder_ / name, "mine").has_value());
    fs::create_symlink("../mine.txt", folder_ / "out/a.txt");
    fs::create_directory_symlink("../elsewhere", folder_ / "out/sub");
    for (const char* name : {"a.txt", "sub/b.txt", "c.txt", "own/d.txt", "missing/e.txt"}) removeFileOf(folder_ / "out", name);
    EXPECT_FALSE(fs::exists(fs::symlink_status(folder_ / "out/a.txt"))) << "the link itself goes";
    EXPECT_TRUE(fs::exists(folder_ / "mine.txt"));
    EXPECT_TRUE(fs::exists(folder_ / "elsewhere/b.txt"));
    EXPECT_FALSE(fs::exists(folder_ / "out/c.txt"));
    EXPECT_FALSE(fs::exists(folder_ / "out/own/d.txt"));
}

TEST_F(Executor, ACacheThatCannotBeWrittenIsAWarning) {
    ASSERT_TRUE(writeFile(folder_ / "cache", "a file in place of the folder").has_value());
    const ExecutionResult result = run({action("a", "one "), action("b", "two ")});
    EXPECT_TRUE(result.errors.empty());
    EXPECT_EQ(result.actionsRun, 2);
    EXPECT_EQ(*readFile(folder_ / "out" / "b.txt"), "two ");
    ASSERT_EQ(warnings_.size(), 1u) << "of one subject";
    EXPECT_EQ(warnings_.begin()->first, (folder_ / "cache").string());
    EXPECT_THAT(warnings_.begin()->second, testing::AllOf(testing::HasSubstr("Not a directory"), testing::HasSubstr("nothing is kept")));
    std::filesystem::remove(folder_ / "cache");
    warnings_.clear();
    run({action("a", "one ")});
    EXPECT_TRUE(warnings_.empty());
}

TEST_F(Executor, AFailureStopsItsDependantsAndWithKeepGoingNothingElse) {
    Action failing = action("a", "");
    failing.parameters["fails"] = true;
    const std::vector<Action> graph = {failing, action("b", "two "), action("c", "three ", {"a"}), action("d", "four ", {"b"})};
    const ExecutionResult result = run(graph, true);
    ASSERT_EQ(result.errors.size(), 1u);
    EXPECT_EQ(result.errors[0].subject, "a");
    EXPECT_FALSE(result.records.contains("c"));
    EXPECT_EQ(*readFile(folder_ / "out" / "d.txt"), "four two ");
}

}  // namespace
}  // namespace lightcook::pipeline

// Actions on other machines: a script stands for the scheduler, and a node is a process with a cache folder of its own that sees no file of
// the scene. tests/end_to_end/cluster_test.py does the same with Slurm and ssh.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <set>

#include "pipeline/graph/sha256.h"
#include "tests/end_to_end/command_fixture.h"
#include "tests/pipeline/graph/cache_server.h"

namespace lightcook::pipeline {
namespace {

namespace fs = std::filesystem;
using formats::contentOf;
using formats::writeContent;
using testing::HasSubstr;
using testing::Not;

/// Kinds of the small scene that read files.
const std::vector<std::string> kSlow = {"light-map",       "dominant",       "cubemap",     "rsrm",      "verify-light-map",
                                        "verify-dominant", "verify-cubemap", "verify-rsrm", "verify-lut"};
constexpr std::ptrdiff_t kLaunched = 9, kOfSky = 2;

class Cluster : public Command {
protected:
    Cluster() {
        startWithoutCache();
        // The scene is away while a node works: it has nothing but the remote cache.
        writeContent(scene_ / "node.sh", fmt::format(R"(#!/bin/sh
echo "$@" >>'{0}/launched'
shift 2
[ -f '{0}/fault' ] && . '{0}/fault'
cd / && [ -f '{0}/isShared' ] && exec "$@"
mkdir -p '{0}/away' && mv '{0}/map.exr' '{0}/probe.exr' '{0}/sky.exr' '{0}/away/' 2>/dev/null
LIGHTCOOK_CACHE='{0}/node' "$@"
status=$?
mv '{0}'/away/* '{0}/'
exit $status
)",
                                                     (scene_ / "").string()));
        fs::permissions(scene_ / "node.sh", fs::perms::owner_all);
    }

    /// Cooks with every long action on a node, one after the other.
    Ended cook(const std::string& options = "", bool isShared = false, const std::vector<std::string>& slow = kSlow) {
        writeSlowRates(cache_, slow);
        fs::remove(scene_ / "launched");
        const std::string remote = isShared ? "" : " --remote-cache " + server_.url();
        return run(fmt::format("-j 1 cook scene.toml -o out --launcher \"'{}' {{memory}} {{time}}\"{} {}", (scene_ / "node.sh").string(),
                               remote, options));
    }
    std::ptrdiff_t launches() const {
        if (!fs::exists(scene_ / "launched")) return 0;
        const std::string text = contentOf(scene_ / "launched");
        return std::count(text.begin(), text.end(), '\n');
    }
    /// Runs before the command of a node.
    void setFault(const std::string& script) const { writeContent(scene_ / "fault", script); }
    /// The same before the first one alone.
    void setFaultOnce(const std::string& script) const { setFault(fmt::format("rm '{}'\n{}", (scene_ / "fault").string(), script)); }

    void expectSameBytes(const std::string& options = "") {
        const fs::path own = cache_;
        cache_ = LIGHTCOOK_TEST_CACHE;
        ASSERT_EQ(run("cook scene.toml -o direct " + options).code, 0);
        cache_ = own;
        std::set<std::string> names;
        for (const auto& entry : fs::directory_iterator(scene_ / "direct")) {
            const std::string name = entry.path().filename().string();
            if (!entry.is_regular_file() || name.starts_with("report")) continue;
            EXPECT_EQ(contentOf(scene_ / "out" / name), contentOf(entry.path())) << name;
            names.insert(name);
        }
        EXPECT_GT(names.size(), 2U);
        for (const auto& entry : fs::directory_iterator(scene_ / "out"))
            EXPECT_TRUE(fs::exists(scene_ / "direct" / entry.path().filename()));
        EXPECT_FALSE(fs::exists(scene_ / "node/.lightcook-")) << "nothing is left";
    }

    CacheServer server_;
};

TEST_F(Cluster, NodesNeedNothingButTheRemoteCache) {
    const Ended first = cook();
    ASSERT_EQ(first.code, 0) << first.err;
    EXPECT_THAT(first.out, HasSubstr(" 0 of 10 actions from the cache"));
    EXPECT_EQ(launches(), kLaunched);
    EXPECT_THAT(contentOf(scene_ / "launched"),
                testing::MatchesRegex("([0-9]+ [0-9]+ [^ ]*lightcook work [0-9a-f]+ --json - --remote-cache [^ ]+\n)+"));
    expectSameBytes();
    // A machine that has nothing finds all there.
    fs::remove_all(cache_);
    fs::remove_all(scene_ / "out");
    const Ended second = cook();
    EXPECT_THAT(second.out, HasSubstr(" 10 of 10 actions from the cache"));
    EXPECT_EQ(launches(), 0);
    expectSameBytes();
    EXPECT_EQ(cook("--force").code, 0);
    EXPECT_EQ(launches(), kLaunched);
    expectSameBytes();
}

TEST_F(Cluster, MachinesMayShareTheFoldersInstead) {
    writeContent(scene_ / "isShared", "");
    const Ended cooked = cook("", true);
    ASSERT_EQ(cooked.code, 0) << cooked.err;
    EXPECT_EQ(launches(), kLaunched);
    EXPECT_THAT(contentOf(scene_ / "launched"), HasSubstr(" --cache " + cache_.string()));
    EXPECT_EQ(server_.requests().size(), 0U);
    expectSameBytes();
}

/// An action whose next launch succeeds costs that launch and a warning.
TEST_F(Cluster, AFaultOfANodeCostsAnotherLaunch) {
    const std::string node = (scene_ / "node").string();
    for (const auto& [fault, words] : std::vector<std::pair<std::string, std::string>>{
             {"exit 0", "had ended with status 0"},  // as srun has done
             {"echo 'srun: error: Node failure' >&2; exit 143", "status 143 (srun: error: Node failure)"},
             {"(sleep 0.15; kill -9 $(cat /proc/$$/task/$$/children)) & ", ""},
             {"\"$@\" >/dev/null; rm -r '" + node + "' ; mkdir -p '" + node + "'; exit 9", ""}}) {
        SCOPED_TRACE(fault);
        fs::remove_all(cache_);
        fs::remove_all(scene_ / "out");
        fs::remove_all(node);
        server_.change([](auto& stored) { stored.clear(); });
        setFaultOnce(fault);
        const Ended cooked = cook("--only sky");
        ASSERT_EQ(cooked.code, 0) << cooked.err;
        if (!words.empty()) {
            EXPECT_EQ(launches(), kOfSky + 1);
            EXPECT_THAT(cooked.err, testing::AllOf(HasSubstr("launch 1: "), HasSubstr(words), HasSubstr("; it is launched again")));
        }
        expectSameBytes("--only sky");
    }
}

TEST_F(Cluster, AnActionThatIsNeverDoneFailsByItsName) {
    setFault("exit 0");
    const Ended cooked = cook();
    EXPECT_EQ(cooked.code, 1);
    EXPECT_THAT(cooked.err, HasSubstr("error: cook/map: found no result after "));
    EXPECT_EQ(launches(), 5);
    EXPECT_FALSE(fs::exists(scene_ / "out"));
    // Twice the memory and the time of the launch before.
    std::ifstream lines(scene_ / "launched");
    int memory = 0, minutes = 0;
    std::vector<std::pair<int, int>> asked;
    for (std::string line; lines >> memory >> minutes && std::getline(lines, line);) asked.emplace_back(memory, minutes);
    EXPECT_GT(asked[1].first, asked[0].first);
    EXPECT_NEAR(asked[4].second, 4 * asked[0].second, 4);
}

TEST_F(Cluster, AnotherVersionIsRefusedByName) {
    // A job of another program is refused by a line with the sources of this one, whose digest the file of the program has.
    const std::string job = R"({"program":{"version":"0","sources":"0","compiler":""}})";
    fs::create_directories(cache_ / "cas");
    writeContent(cache_ / "cas" / sha256OfText(job), job);
    const std::string refusal = run("work " + sha256OfText(job)).err;
    const std::string begin = refusal.substr(refusal.find("sources ") + 8, 12);
    std::string program = contentOf(LIGHTCOOK_PROGRAM);
    ASSERT_NE(program.find(begin), std::string::npos) << refusal;
    const std::string sources = program.substr(program.find(begin), 64), other(sources.rbegin(), sources.rend());
    for (std::size_t at = program.find(sources); at != std::string::npos; at = program.find(sources))
        program.replace(at, other.size(), other);
    writeContent(scene_ / "other", program);
    fs::permissions(scene_ / "other", fs::perms::owner_all);
    setFault(fmt::format("shift; set -- '{}' \"$@\"", (scene_ / "other").string()));
    const Ended cooked = cook();
    EXPECT_EQ(cooked.code, 2);
    EXPECT_THAT(cooked.err, HasSubstr(fmt::format("found lightcook 0.1.0 (sources {}, ", other.substr(0, 12))));
    EXPECT_THAT(cooked.err, HasSubstr(fmt::format("expected lightcook 0.1.0 (sources {}, ", begin)));
    EXPECT_FALSE(fs::exists(scene_ / "out"));
}

/// The cache loses an input before the node reads it, and a result before the cook does.
TEST_F(Cluster, WhatTheCacheLosesIsWrittenAgain) {
    for (const char* lost : {"/cache/cas/", "/cache/ac/"}) {
        SCOPED_TRACE(lost);
        fs::remove_all(cache_);
        fs::remove_all(scene_ / "out");
        fs::remove_all(scene_ / "node");
        server_.change([](auto& stored) { stored.clear(); });
        std::atomic<int> count = 0;
        server_.setFault([&](const std::string& method, const std::string& path) {
            return method == "GET" && path.starts_with(lost) && ++count % 5 == 3 ? ServerFault::Missing : ServerFault::None;
        });
        const Ended cooked = cook("--only sky");
        ASSERT_EQ(cooked.code, 0) << cooked.err;
        EXPECT_GT(launches(), kOfSky);
        server_.setFault({});
        expectSameBytes("--only sky");
    }
}

TEST_F(Cluster, WithoutARemoteCacheThatTakesThingsNothingIsLaunched) {
    server_.setFault(ServerFault::Refuses, "PUT", "");
    const Ended cooked = cook();
    EXPECT_EQ(cooked.code, 2);
    EXPECT_THAT(cooked.err, testing::AllOf(HasSubstr("map.exr cannot be written there"), HasSubstr("status 403")));
    EXPECT_EQ(launches(), 0);
    EXPECT_FALSE(fs::exists(scene_ / "out"));
}

/// A mistake in an input is that of a cook without a cluster.
TEST_F(Cluster, AMistakeHasTheNameThatTheSceneGivesTheFile) {
    std::string gradient = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 64\n";
    for (int i = 0; i < 100; ++i) gradient += "\x80\x80\x80\x81";
    writeContent(scene_ / "sky.exr", gradient);
    const Ended direct = run("cook scene.toml -o direct --only sky"), cooked = cook("--only sky", false, {"lint-gradient"});
    EXPECT_EQ(launches(), 1);
    EXPECT_EQ(cooked.code, direct.code);
    EXPECT_EQ(cooked.code, 3);
    EXPECT_EQ(cooked.err, direct.err);
}

}  // namespace
}  // namespace lightcook::pipeline

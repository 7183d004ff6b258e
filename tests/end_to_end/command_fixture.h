// The program as a command in a folder with a small scene.
#pragma once

#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/pipeline/shell.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {

class Command : public testing::Test {
protected:
    struct Ended {
        int code = -1;
        std::string out, err;
    };

    Ended run(const std::string& arguments, const std::filesystem::path& program = LIGHTCOOK_PROGRAM) const {
        const std::string command = fmt::format(
            "cd '{0}' && XDG_CONFIG_HOME='{0}/configuration' LIGHTCOOK_CACHE='{1}' '{2}' {3} >'{0}/stdout' 2>'{0}/stderr' </dev/null",
            (scene_ / "").string(), cache_.string(), program.string(), arguments);
        return {runShell(command), formats::contentOf(scene_ / "stdout"), formats::contentOf(scene_ / "stderr")};
    }

    /// Notes in the cache that each byte which actions of these kinds read took a second: --launcher takes them.
    static void writeSlowRates(const std::filesystem::path& cache, const std::vector<std::string>& kinds) {
        std::filesystem::create_directories(cache);
        Json rates = Json::object();
        for (const std::string& kind : kinds) rates[kind] = {{"texels", 1e12}, {"seconds", 1e12}};
        formats::writeContent(cache / "launch_seconds.json", rates.dump());
    }

    /// Expects the exit code, one error line with the words, and no output folder.
    void expectRefused(const std::string& arguments, int code, const std::vector<std::string>& words) const {
        SCOPED_TRACE(arguments);
        const Ended ended = run(arguments);
        EXPECT_EQ(ended.code, code) << ended.err;
        const std::string errors = withoutDone(ended.err);
        EXPECT_EQ(std::count(errors.begin(), errors.end(), '\n'), 1) << ended.err;
        for (const std::string& word : words) EXPECT_THAT(ended.err, testing::HasSubstr(word));
        EXPECT_FALSE(std::filesystem::exists(scene_ / "out"));
        for (const auto& entry : std::filesystem::directory_iterator(scene_ / ""))
            EXPECT_THAT(entry.path().filename().string(), testing::Not(testing::StartsWith(".")));
    }

    /// Gives the test an empty cache of its own. Tests that count cached actions need one.
    void startWithoutCache() { cache_ = scene_ / "cache"; }

    SmallScene scene_{SmallScene::Parts::All};
    std::filesystem::path cache_ = LIGHTCOOK_TEST_CACHE;  ///< the same scene is cooked by many tests
};

}  // namespace lightcook::pipeline

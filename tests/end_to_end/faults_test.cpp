// Every fault once: the n-th allocation, read, write, sync, rename, open, ... of a small cook, a verify and a report fails, for n from 1
// until a run has none left. Each run ends with exit code 0, or with one line and the exit code of what failed; no file is torn and no
// temporary one left; and the next cook is whole, with the same bytes.
//
// Allocations at one place fail alike, so one of each call stack fails. ./dev test takes some of each row, ./dev soak all.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <map>
#include <random>
#include <sstream>

#include "tests/end_to_end/faults.h"
#include "tests/pipeline/small_scene.h"
#include "tests/soak/soak.h"

namespace lightcook::pipeline {
namespace {

namespace fs = std::filesystem;
using formats::contentOf;
using testing::HasSubstr;

const std::vector<std::string> kCook = {"lightmap", "map.exr", "out", "-j", "1", "--layout", "ratio", "--effort", "0", "--quiet"};
const std::vector<std::string> kCookOnTwo = {"lightmap", "map.exr", "out", "-j", "2", "--layout", "ratio", "--effort", "0", "--quiet"};
const std::vector<std::string> kVerify = {"verify", "whole", "-j", "1", "--json", "out.json", "--quiet"};
const std::vector<std::string> kReport = {"report", "whole", "-j", "1", "--json", "out.json", "--quiet"};

/// Calls that fail one after the other, each in a run of its own.
struct Row {
    const std::vector<std::string>* command;
    faults::Kind kind;
    std::string how;
    std::vector<int> codes;  ///< exit codes that may follow
    int inTest;              ///< calls that fail in ./dev test
};
const std::string kNoMemory = std::to_string(ENOMEM), kDiskFull = std::to_string(ENOSPC), kDamage = std::to_string(EIO),
                  kForbidden = std::to_string(EACCES), kTooMany = std::to_string(EMFILE), kInterrupted = std::to_string(EINTR),
                  kTryAgain = std::to_string(EAGAIN);
const Row kRows[] = {
    {&kCook, faults::Alloc, kNoMemory, {0, 1}, 14},     {&kVerify, faults::Alloc, kNoMemory, {0, 1}, 5},
    {&kReport, faults::Alloc, kNoMemory, {0, 1}, 3},    {&kCook, faults::Alloc, kNoMemory + "+", {1}, 5},
    {&kCookOnTwo, faults::Alloc, kNoMemory, {0, 1}, 4}, {&kCookOnTwo, faults::Thread, kTryAgain, {0, 1}, 2},
    {&kCook, faults::Open, kTooMany, {0, 1, 3}, 4},     {&kCook, faults::Read, kDamage, {0, 1, 3}, 4},
    {&kVerify, faults::Read, kDamage, {0, 1, 3, 4}, 2}, {&kReport, faults::Read, kDamage, {0, 1, 3, 4}, 1},
    {&kCook, faults::Write, kDiskFull, {0, 1}, 4},      {&kCook, faults::Write, kDiskFull + "+", {1}, 1},
    {&kVerify, faults::Write, kDiskFull, {0, 1}, 1},    {&kCook, faults::Sync, kDamage, {0, 1}, 2},
    {&kCook, faults::Rename, kForbidden, {0, 1}, 4},    {&kCook, faults::Map, kNoMemory, {0, 1}, 1},
    {&kCook, faults::Read, kInterrupted, {0}, 2},       {&kCook, faults::Write, kInterrupted, {0}, 2},
    {&kCook, faults::Sync, kInterrupted, {0}, 1},       {&kCook, faults::Read, "short", {0}, 1},
    {&kCook, faults::Write, "short", {0}, 1},
};

class Faults : public testing::Test {
protected:
    static constexpr std::uint64_t kStackDepth = 8;

    static void SetUpTestSuite() {
        scene_ = new SmallScene(SmallScene::Parts::LightMap, sunAndSky, 8);
        const fs::path file = *scene_ / "calls";
        formats::writeContent(file, "");
        fs::resize_file(file, sizeof(faults::FaultFile));
        const int descriptor = ::open(file.c_str(), O_RDWR | O_CLOEXEC);
        void* const place = ::mmap(nullptr, sizeof(faults::FaultFile), PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
        ::close(descriptor);
        ASSERT_NE(place, MAP_FAILED);
        calls_ = static_cast<faults::FaultFile*>(place);
        ASSERT_EQ(run(kCook, ""), 0) << contentOf(*scene_ / "log");
        fs::rename(*scene_ / "out", *scene_ / "whole");
    }
    static void TearDownTestSuite() {
        ::munmap(calls_, sizeof(faults::FaultFile));
        delete scene_;
    }

    /// Runs the program. Returns its exit code; the negative number of a signal that ended it. What it printed lies in the file "log".
    static int run(const std::vector<std::string>& arguments, const std::string& fault, std::uint64_t stackDepth = 0) {
        for (std::atomic<std::uint64_t>& count : calls_->calls) count = 0;
        calls_->failed = calls_->stackCount = 0;
        std::vector<std::string> words = {LIGHTCOOK_PROGRAM};
        words.insert(words.end(), arguments.begin(), arguments.end());
        std::vector<std::string> environment = {"LD_PRELOAD=" LIGHTCOOK_FAULTS, "LIGHTCOOK_FAULT=" + fault,
                                                "LIGHTCOOK_FAULT_FILE=" + (*scene_ / "calls").string(),
                                                "LIGHTCOOK_CACHE=" + (*scene_ / "cache").string()};
        if (stackDepth > 0) environment.push_back("LIGHTCOOK_FAULT_STACKS=" + std::to_string(stackDepth));
        const auto pointers = [](std::vector<std::string>& texts) {
            std::vector<char*> all;
            for (std::string& text : texts) all.push_back(text.data());
            all.push_back(nullptr);
            return all;
        };
        const std::vector<char*> argv = pointers(words), envp = pointers(environment);
        const std::string log = *scene_ / "log", folder = *scene_ / "";
        const pid_t child = ::fork();
        if (child == 0) {
            const int descriptor = ::open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
            if (::chdir(folder.c_str()) != 0 || ::dup2(descriptor, STDERR_FILENO) < 0) ::_exit(98);
            ::dup2(::open("/dev/null", O_WRONLY), STDOUT_FILENO);
            ::alarm(120);  // a run that hangs fails
            ::execve(LIGHTCOOK_PROGRAM, argv.data(), envp.data());
            ::_exit(99);
        }
        int status = 0;
        ::waitpid(child, &status, 0);
        return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    }

    static void removeOutputs() {
        for (const char* output : {"out", "out.json", "cache"}) fs::remove_all(*scene_ / output);
    }

    /// Expects each file of a cook to be whole; and all of them to be there, if it succeeded.
    static void expectWholeFiles(bool isComplete) {
        std::map<std::string, std::string> expected, found;
        const auto read = [](const fs::path& folder, std::map<std::string, std::string>& files) {
            std::error_code none;
            for (const auto& entry : fs::recursive_directory_iterator(folder, none))
                if (entry.is_regular_file()) files[entry.path().lexically_relative(folder)] = contentOf(entry.path());
        };
        read(*scene_ / "whole", expected);
        read(*scene_ / "out", found);
        for (const auto& [name, content] : found) {
            ASSERT_TRUE(expected.contains(name)) << name;
            if (name == "report.json")  // has times
                EXPECT_TRUE(Json::accept(content)) << name;
            else if (name == "report.html")
                EXPECT_TRUE(content.ends_with("</html>\n")) << name;
            else
                EXPECT_EQ(content == expected.at(name), true) << name << " differs";
        }
        if (isComplete) {
            EXPECT_EQ(found.size(), expected.size());
        }
    }

    /// Expects what every run that ended leaves: one line of an error or none, whole files, no temporaries.
    static void expectCleanEnd(const Row& row, int code) {
        const std::string log = contentOf(*scene_ / "log");
        EXPECT_THAT(row.codes, testing::Contains(code)) << log;
        int errors = 0;
        std::istringstream lines(log);
        for (std::string line; std::getline(lines, line);) {
            const bool isError = line.starts_with("lightcook: error: ");
            EXPECT_TRUE(isError || line.starts_with("lightcook: warning: ")) << line;
            EXPECT_THAT(line, testing::Not(HasSubstr("bad_alloc")));
            errors += isError ? 1 : 0;
            if (isError && row.kind == faults::Alloc) {
                EXPECT_THAT(line, HasSubstr("memory"));
            }
        }
        EXPECT_EQ(errors, code == 0 ? 0 : code == 4 ? errors : 1) << log;
        for (const auto& entry : fs::recursive_directory_iterator(*scene_ / ""))
            EXPECT_FALSE(entry.path().filename().string().starts_with(".lightcook-")) << entry.path();
        if (row.command == &kCook || row.command == &kCookOnTwo) expectWholeFiles(code == 0);
        EXPECT_TRUE(!fs::exists(*scene_ / "out.json") || Json::accept(contentOf(*scene_ / "out.json")));
    }

    /// Returns the calls of a row that fail, each in a run of its own. Counts them in a run without a fault.
    static std::vector<std::uint64_t> callsOf(const Row& row) {
        removeOutputs();
        const bool isByStack = row.kind == faults::Alloc;
        EXPECT_EQ(run(*row.command, "", isByStack ? kStackDepth : 0), 0);
        if (isByStack) return {calls_->firstOfStack, calls_->firstOfStack + calls_->stackCount};
        std::vector<std::uint64_t> all(calls_->calls[row.kind]);
        for (std::size_t i = 0; i < all.size(); ++i) all[i] = i + 1;
        return all;
    }

    /// Lets calls of each row fail.
    /// all  every call, in random order, as many as the soak has time for; false: those of ./dev test
    static void failEach(bool all) {
        const test::SoakTime time;
        std::vector<std::pair<const Row*, std::uint64_t>> chosen;
        for (const Row& row : kRows) {
            const std::vector<std::uint64_t> calls = callsOf(row);
            ASSERT_GT(calls.size(), 0u);
            const std::size_t step = all ? 1 : std::max<std::size_t>(1, calls.size() / static_cast<std::size_t>(row.inTest));
            // From the end, where a run has done most; begins elsewhere in each row.
            for (std::size_t index = calls.size() - 1 - chosen.size() % step; index < calls.size(); index -= step)
                chosen.emplace_back(&row, calls[index]);
        }
        if (all) std::ranges::shuffle(chosen, std::mt19937_64(test::soakSeed()));
        int runs = 0, failed = 0, refused = 0;
        for (const auto& [row, call] : chosen) {
            if (all && runs > 0 && time.isOver()) break;
            const std::string fault = fmt::format("{}:{}:{}", faults::kKindNames[row->kind], call, row->how);
            SCOPED_TRACE(row->command->front() + " " + fault);
            removeOutputs();
            const int code = run(*row->command, fault);
            failed += calls_->failed > 0 ? 1 : 0;
            refused += code != 0 ? 1 : 0;
            expectCleanEnd(*row, code);
            if (row->command == &kCook && (all || runs % 5 == 0)) {
                ASSERT_EQ(run(kCook, ""), 0) << "the next cook: " << contentOf(*scene_ / "log");
                expectWholeFiles(true);
            }
            ++runs;
        }
        fmt::print("{} of {} calls, {} runs with one that failed, of which {} ended with an error\n", runs, chosen.size(), failed, refused);
        test::countInSoak(failed, "calls that failed");
        EXPECT_GE(10 * failed, 9 * runs) << "the runs make the calls that were counted";
    }

    static SmallScene* scene_;
    static faults::FaultFile* calls_;
};
SmallScene* Faults::scene_ = nullptr;
faults::FaultFile* Faults::calls_ = nullptr;
using FaultsSoak = Faults;

TEST_F(Faults, EndInOneLineAndTheNextCookIsWhole) {
    failEach(false);
}

TEST_F(FaultsSoak, EachEndsInOneLineAndTheNextCookIsWhole) {
    failEach(true);
}

/// Where standard error cannot be written either, the exit code is all that is left.
TEST_F(Faults, AFullStandardErrorIsNoCrash) {
    removeOutputs();
    const std::string command =
        fmt::format("cd '{}' && '{}' lightmap nowhere.exr out 2>/dev/full", (*scene_ / "").string(), LIGHTCOOK_PROGRAM);
    const int status = std::system(command.c_str());
    ASSERT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 3);
}

}  // namespace
}  // namespace lightcook::pipeline

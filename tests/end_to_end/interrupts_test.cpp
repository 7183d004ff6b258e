// Signals at many moments of every command: the program ends within a second, with the exit code of an interrupt, and leaves nothing
// behind. Also the files that a killed run leaves, and outputs that are no plain files.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <set>
#include <thread>

#include "formats/plain_image.h"
#include "pipeline/command/command.h"
#include "tests/pipeline/small_scene.h"
#include "tests/soak/soak.h"

namespace lightcook::pipeline {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using formats::contentOf;
using formats::writeContent;
using namespace std::chrono_literals;

/// Arguments that keep a command busy for a while, in a folder with a scene and, in `cooked`, the result of its cook.
struct BusyCommand {
    const char* name;
    std::vector<std::string> arguments;
};
const BusyCommand kBusyCommands[] = {
    {"cook", {"scene.toml", "-o", "out", "--force"}},
    {"init", {"map.exr", "probe.exr", "-o", "out"}},
    {"lint", {"scene.toml", "--json", "out"}},
    {"estimate", {LIGHTCOOK_SOURCE_DIR "/examples/cornell/cornell.glb", "--texel-density", "200"}},
    {"verify", {"cooked", "--json", "out"}},
    {"report", {"cooked", "--json", "out"}},
    {"plan", {"scene.toml", "--ninja", "out"}},
    {"work", {"--help"}},  // what it runs is an action of a cook
    {"repack",
     {LIGHTCOOK_SOURCE_DIR "/examples/cornell/cornell_lightmap.exr", LIGHTCOOK_SOURCE_DIR "/examples/cornell/cornell.glb", "-o", "out"}},
    {"lightmap", {"map.exr", "out"}},
    {"dominant", {"map.exr", "out", "--fit", "refined"}},
    {"cubemap", {"probe.exr", "out"}},
    {"lut", {"out", "--views", "1024"}},
    {"rsrm", {"sky.exr", "out"}},
    {"encode", {"large.exr", "out.ktx2", "--format", "bc6h-uf16", "--effort", "9"}},
    {"decode", {"large.ktx2", "out.exr"}},
    {"reconstruct", {"cooked", "map", "out.exr"}},
    {"compare", {"large.ktx2", "large.ktx2"}},
    {"diff", {"cooked", "cooked"}},
    {"info", {"large.exr"}},
    {"demo", {"-o", "out"}},
    {"view", {"cooked", "--port", "0"}},
    {"help", {"cook"}},
};

/// The program as a child process.
class Running {
public:
    Running(const fs::path& folder, const std::vector<std::string>& arguments) {
        std::vector<std::string> words = {LIGHTCOOK_PROGRAM};
        words.insert(words.end(), arguments.begin(), arguments.end());
        std::vector<char*> argv;
        for (std::string& word : words) argv.push_back(word.data());
        argv.push_back(nullptr);
        const std::string temporary = fmt::format("TMPDIR={}", (folder / "tmp").string()),
                          cache = fmt::format("LIGHTCOOK_CACHE={}", (folder / "cache").string());
        pid_ = ::fork();
        if (pid_ != 0) return;
        ::putenv(const_cast<char*>(temporary.c_str()));
        ::putenv(const_cast<char*>(cache.c_str()));
        if (::chdir(folder.c_str()) != 0) ::_exit(98);
        const int log = ::open((folder / "log").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
        ::dup2(log, STDOUT_FILENO);
        ::dup2(log, STDERR_FILENO);
        ::execv(argv[0], argv.data());
        ::_exit(99);
    }
    ~Running() {
        if (pid_ > 0 && !status_) {
            ::kill(pid_, SIGKILL);
            ::waitpid(pid_, nullptr, 0);
        }
    }
    Running(const Running&) = delete;
    Running& operator=(const Running&) = delete;

    /// Waits until the program watches for all signals, which it blocks, or ignores them. Returns false if it has ended before.
    bool waitUntilReady() {
        for (; !hasEnded(); std::this_thread::sleep_for(1ms)) {
            std::istringstream status(contentOf(fmt::format("/proc/{}/status", pid_)));
            unsigned long long taken = 0;
            for (std::string line; std::getline(status, line);)
                if (line.starts_with("SigBlk:") || line.starts_with("SigIgn:")) taken |= std::stoull(line.substr(7), nullptr, 16);
            const auto isTaken = [&](int number) { return (taken & 1ull << (number - 1)) != 0; };
            if (isTaken(SIGINT) && isTaken(SIGTERM) && isTaken(SIGHUP)) return true;
        }
        return false;
    }
    void signal(int number) const { ::kill(pid_, number); }
    bool hasEnded() {
        int status = 0;
        if (!status_ && ::waitpid(pid_, &status, WNOHANG) == pid_) status_ = status;
        return status_.has_value();
    }
    bool endsWithin(std::chrono::milliseconds time) {
        for (const auto end = Clock::now() + time; Clock::now() < end && !hasEnded();) std::this_thread::sleep_for(2ms);
        return hasEnded();
    }
    /// The exit code; -1 if a signal ended it.
    int code() const { return status_ && WIFEXITED(*status_) ? WEXITSTATUS(*status_) : -1; }

private:
    pid_t pid_ = -1;
    std::optional<int> status_;
};

class Interrupt : public testing::Test {
protected:
    static void SetUpTestSuite() {
        scene_ = new SmallScene(SmallScene::Parts::All);
        fs::create_directory(*scene_ / "tmp");
        formats::Image<glm::vec4> large(1024, 1024);
        for (int y = 0; y < 1024; ++y)
            for (int x = 0; x < 1024; ++x) large.at(x, y) = glm::vec4(0.1f + static_cast<float>(x * y % 251), x, y, 1);
        ASSERT_TRUE(formats::writeExr(*scene_ / "large.exr", large.view(), 3));
        ASSERT_EQ(end({"encode", "large.exr", "large.ktx2", "--format", "bc6h-uf16", "--effort", "0"}), 0);
        ASSERT_EQ(end({"cook", "scene.toml", "-o", "cooked"}), 0);
    }
    static void TearDownTestSuite() { delete scene_; }

    static int end(const std::vector<std::string>& arguments) {
        Running running(*scene_ / "", arguments);
        return running.endsWithin(std::chrono::minutes(10)) ? running.code() : -2;
    }
    /// Returns the files and folders of the scene's folder, without those that every run has.
    static std::set<std::string> entries() {
        std::set<std::string> names;
        for (const fs::path& folder : {*scene_ / "", *scene_ / "tmp"})
            for (const auto& entry : fs::directory_iterator(folder))
                if (entry.path().filename() != "log" && entry.path().filename() != "cache") names.insert(entry.path().string());
        return names;
    }
    static std::vector<std::string> temporariesIn(const fs::path& folder) {
        std::vector<std::string> names;
        for (const auto& entry : fs::recursive_directory_iterator(folder))
            if (entry.path().filename().string().starts_with(".lightcook-")) names.push_back(entry.path().string());
        return names;
    }

    /// Interrupts every command after each of the delays, or after one of them in turn.
    static void interruptEveryCommand(bool inTurn);

    static SmallScene* scene_;
};
SmallScene* Interrupt::scene_ = nullptr;
using InterruptSoak = Interrupt;

TEST_F(Interrupt, EveryCommandHasARow) {
    std::vector<std::string> rows, commands;
    for (const BusyCommand& row : kBusyCommands) rows.emplace_back(row.name);
    for (const CommandInfo& command : allCommands()) commands.emplace_back(command.name);
    EXPECT_THAT(rows, testing::IsSupersetOf(commands)) << "a new command needs a row in kBusyCommands";
}

void Interrupt::interruptEveryCommand(bool inTurn) {
    constexpr std::array kDelays = {0ms, 15ms, 60ms, 300ms};
    const std::set<std::string> before = entries();
    int runs = 0, interrupted = 0;
    for (std::size_t row = 0; row < std::size(kBusyCommands); ++row)
        for (std::size_t i = inTurn ? row % kDelays.size() : 0; i < kDelays.size(); i += inTurn ? kDelays.size() : 1) {
            const BusyCommand& command = kBusyCommands[row];
            const std::chrono::milliseconds delay = kDelays[i];
            const int number = std::array{SIGINT, SIGTERM, SIGHUP}[static_cast<std::size_t>(runs++ % 3)];
            SCOPED_TRACE(fmt::format("{}, signal {} after {} ms", command.name, number, delay.count()));
            std::vector<std::string> arguments = {command.name};
            arguments.insert(arguments.end(), command.arguments.begin(), command.arguments.end());
            Running running(*scene_ / "", arguments);
            const bool isReady = running.waitUntilReady();
            if (isReady) std::this_thread::sleep_for(delay);
            if (isReady && !running.hasEnded()) {
                running.signal(number);
                ASSERT_TRUE(running.endsWithin(1000ms)) << "still runs a second later";
                // Between the look and the signal it may have come to its end.
                EXPECT_THAT(running.code(), testing::AnyOf(6, 0)) << contentOf(*scene_ / "log");
            }
            const bool isInterrupted = running.code() == 6;
            interrupted += isInterrupted ? 1 : 0;
            EXPECT_EQ(temporariesIn(*scene_ / ""), std::vector<std::string>());
            for (const char* output : {"out", "out.ktx2", "out.exr"}) fs::remove_all(*scene_ / output);
            EXPECT_EQ(entries(), before);
        }
    test::countInSoak(runs, "interrupts");
    EXPECT_GE(4 * interrupted, runs) << "most commands run longer than the delays";
}

TEST_F(Interrupt, EndsEveryCommandWithinASecondAtAnyMomentAndLeavesNothing) {
    interruptEveryCommand(true);
}

TEST_F(InterruptSoak, EndsEveryCommandWithinASecondAfterEachDelayAndLeavesNothing) {
    interruptEveryCommand(false);
}

TEST_F(Interrupt, AnInterruptedRunWritesNoOutput) {
    for (const char* name : {"encode", "lut", "cook"}) {
        SCOPED_TRACE(name);
        const auto row = std::find_if(std::begin(kBusyCommands), std::end(kBusyCommands),
                                      [&](const auto& each) { return std::string(name) == each.name; });
        std::vector<std::string> arguments = {name};
        arguments.insert(arguments.end(), row->arguments.begin(), row->arguments.end());
        Running running(*scene_ / "", arguments);
        ASSERT_TRUE(running.waitUntilReady());
        running.signal(SIGINT);
        ASSERT_TRUE(running.endsWithin(1000ms));
        EXPECT_EQ(running.code(), 6);
        EXPECT_FALSE(fs::exists(*scene_ / "out"));
        EXPECT_FALSE(fs::exists(*scene_ / "out.ktx2"));
        EXPECT_THAT(contentOf(*scene_ / "log"), testing::HasSubstr("interrupted"));
    }
}

TEST_F(Interrupt, IsTheOrdinaryEndOfAServer) {
    Running running(*scene_ / "", {"view", "cooked", "--port", "0"});
    for (int i = 0; i < 10000 && contentOf(*scene_ / "log").find("Ctrl-C ends it") == std::string::npos; ++i)
        std::this_thread::sleep_for(1ms);
    running.signal(SIGINT);
    ASSERT_TRUE(running.endsWithin(1000ms));
    EXPECT_EQ(running.code(), 0);
    EXPECT_THAT(contentOf(*scene_ / "log"), testing::Not(testing::HasSubstr("interrupted")));
}

TEST_F(Interrupt, ASignalThatWasIgnoredStaysIgnored) {
    ::signal(SIGHUP, SIG_IGN);
    Running running(*scene_ / "", {"lut", "out", "--views", "1024"});
    ::signal(SIGHUP, SIG_DFL);
    ASSERT_TRUE(running.waitUntilReady());
    running.signal(SIGHUP);
    EXPECT_FALSE(running.endsWithin(300ms)) << "as under nohup";
    running.signal(SIGTERM);
    ASSERT_TRUE(running.endsWithin(1000ms));
    EXPECT_EQ(running.code(), 6);
}

TEST_F(Interrupt, AKilledCookLeavesNoHalfFileAndANewOneIsRight) {
    Running running(*scene_ / "", {"lut", "out", "--views", "512"});
    for (int i = 0; i < 5000 && temporariesIn(*scene_ / "").empty() && !running.hasEnded(); ++i) std::this_thread::sleep_for(1ms);
    running.signal(SIGKILL);
    ASSERT_TRUE(running.endsWithin(1000ms));
    EXPECT_FALSE(temporariesIn(*scene_ / "").empty());
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(*scene_ / "out", none))
        EXPECT_TRUE(entry.path().filename().string().starts_with(".lightcook-")) << entry.path();
    // A later cook removes after a day what a killed one left: until then it may belong to another process.
    for (const std::string& left : temporariesIn(*scene_ / "")) fs::last_write_time(left, fs::file_time_type::clock::now() - 25h);
    EXPECT_EQ(end({"rsrm", "sky.exr", "out", "--exponents", "3"}), 0);
    EXPECT_EQ(temporariesIn(*scene_ / ""), std::vector<std::string>());
    EXPECT_EQ(end({"verify", "out"}), 0);
    fs::remove_all(*scene_ / "out");
}

/// Nobody keeps two cooks apart: each file is that of one of them, and the next cook puts the folder right.
TEST_F(Interrupt, TwoCooksIntoOneFolderLeaveWholeFiles) {
    for (int round = 0; round < 3; ++round) {
        Running first(*scene_ / "", {"rsrm", "sky.exr", "out", "--exponents", "1,2"});
        Running second(*scene_ / "", {"rsrm", "sky.exr", "out", "--exponents", "1,2,4,8"});
        ASSERT_TRUE(first.endsWithin(60s) && second.endsWithin(60s));
        EXPECT_EQ(first.code(), 0);
        EXPECT_EQ(second.code(), 0);
        EXPECT_EQ(temporariesIn(*scene_ / "out"), std::vector<std::string>());
        EXPECT_EQ(end({"info", "out/sky.ktx2"}), 0) << contentOf(*scene_ / "log");
        EXPECT_EQ(end({"rsrm", "sky.exr", "out", "--exponents", "3"}), 0);
        EXPECT_EQ(end({"verify", "out"}), 0) << contentOf(*scene_ / "log");
        fs::remove_all(*scene_ / "out");
    }
}

TEST_F(Interrupt, OutputsThatAreNoPlainFilesAreWrittenInto) {
    const fs::path folder = *scene_ / "";
    ASSERT_EQ(end({"report", "cooked", "--json", "plain.json"}), 0);
    const std::string expected = contentOf(folder / "plain.json");
    // A device. As root, a rename would replace it.
    EXPECT_EQ(end({"report", "cooked", "--json", "/dev/null"}), 0);
    struct stat status {};
    ASSERT_EQ(::stat("/dev/null", &status), 0);
    EXPECT_TRUE(S_ISCHR(status.st_mode));
    EXPECT_EQ(end({"report", "cooked", "--json", "/dev/full"}), 1);
    // A symbolic link: its target is replaced, also one that is not there yet.
    fs::create_directory(folder / "elsewhere");
    for (const char* target : {"elsewhere/old.json", "elsewhere/new.json"}) {
        if (std::string(target).find("old") != std::string::npos) writeContent(folder / target, "old");
        fs::create_symlink(target, folder / "link.json");
        EXPECT_EQ(end({"report", "cooked", "--json", "link.json"}), 0);
        EXPECT_TRUE(fs::is_symlink(folder / "link.json"));
        EXPECT_EQ(contentOf(folder / target), expected);
        fs::remove(folder / "link.json");
    }
    // A pipe with a name.
    ASSERT_EQ(::mkfifo((folder / "fifo").c_str(), 0600), 0);
    std::string fromFifo;
    std::thread reader([&] { fromFifo = contentOf(folder / "fifo"); });
    EXPECT_EQ(end({"report", "cooked", "--json", "fifo"}), 0);
    reader.join();
    EXPECT_EQ(fromFifo, expected);
    EXPECT_TRUE(fs::is_fifo(folder / "fifo"));
    // Standard output, as a path.
    EXPECT_EQ(end({"report", "cooked", "--json", "/dev/stdout"}), 0);
    EXPECT_THAT(contentOf(folder / "log"), testing::HasSubstr(expected));
    EXPECT_EQ(temporariesIn(folder), std::vector<std::string>());
}

}  // namespace
}  // namespace lightcook::pipeline

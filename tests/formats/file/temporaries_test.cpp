#include "formats/temporaries.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>

#include "formats/pending_file.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::formats {
namespace {

namespace fs = std::filesystem;

TEST(RemoveOldTemporaries, TakesWhatHasNotChangedForADayAndNothingElse) {
    const TemporaryFolder folder;
    const auto ago = [](int hours) { return fs::file_time_type::clock::now() - std::chrono::hours(hours); };
    writeContent(folder / "kept", "text");
    writeContent(folder / ".lightcook-old.exr", "half");
    fs::create_directory(folder / ".lightcook-older");
    writeContent(folder / ".lightcook-older/content", "half");
    writeContent(folder / ".lightcook-new", "half");
    for (const char* name : {"kept", ".lightcook-old.exr", ".lightcook-older"}) fs::last_write_time(folder / name, ago(25));
    const auto made = TemporaryFolder::create(folder.path());
    ASSERT_TRUE(made);
    EXPECT_TRUE(fs::exists(folder / "kept"));
    EXPECT_TRUE(fs::exists(folder / ".lightcook-new")) << "a running process may own it";
    EXPECT_FALSE(fs::exists(folder / ".lightcook-old.exr"));
    EXPECT_FALSE(fs::exists(folder / ".lightcook-older"));
}

/// A folder of the kernel, in which nobody may make a file, not even root.
TEST(Temporary, WhereNobodyMayWriteTheErrorNamesTheFolder) {
    const fs::path folder = "/sys";
    if (!fs::is_directory(folder)) GTEST_SKIP() << "no " << folder;
    const auto made = TemporaryFolder::create(folder);
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().subject, "/sys");
    EXPECT_THAT(made.error().detail,
                testing::HasSubstr(" while making a temporary folder in it, expected a folder that this user may write"));
    const auto pending = PendingFile::create(folder / "a.exr");
    ASSERT_FALSE(pending);
    EXPECT_EQ(pending.error().subject, "/sys/a.exr");
    EXPECT_THAT(pending.error().detail, testing::HasSubstr(" while creating it, expected a folder that this user may write"));
}

TEST(OutputFailure, SaysWhatToDo) {
    EXPECT_EQ(outputFailure("a", "writing it", ENOSPC).value().line(),
              "a: found \"No space left on device\" while writing it, expected more free space, or another folder");
    EXPECT_EQ(outputFailure("a", "renaming it into place", EROFS).value().detail,
              "found \"Read-only file system\" while renaming it into place, expected a folder that this user may write to: change its "
              "permissions, or name another");
}

/// Runs in a child process, because both functions hold until its end.
TEST(StopOutputs, LetsNoOutputAppearAndAbandonRemovesEverything) {
    // No TemporaryFolder, which the child would inherit and remove.
    const fs::path folder = fs::temp_directory_path() / fmt::format("lightcook-stop-outputs-{}", ::getpid());
    fs::create_directory(folder);
    const pid_t child = ::fork();
    if (child == 0) {
        auto pending = PendingFile::create(folder / "a.bin");
        const auto inner = TemporaryFolder::create(folder / "new" / "deep");
        if (!pending || !inner) ::_exit(1);
        writeContent(*inner / "content", "half");
        stopOutputs();
        const auto committed = pending->commit();
        if (committed || committed.error().code != ErrorCode::Interrupted || OutputTransaction::begin()) ::_exit(2);
        abandonTemporaries();
        ::_exit(0);
    }
    int status = -1;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_EQ(WEXITSTATUS(status), 0);
    EXPECT_TRUE(fs::is_empty(folder));
    fs::remove_all(folder);
}

}  // namespace
}  // namespace lightcook::formats

#include "formats/file/owned_temporary.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>

#include "formats/pending_file.h"
#include "formats/temporaries.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::formats {
namespace {

namespace fs = std::filesystem;

/// Makes a file and a folder in a child process that ends without removing them, as a killed one does.
void leaveBehind(const fs::path& folder) {
    const pid_t child = ::fork();
    if (child == 0) {
        const auto file = OwnedTemporary::makeFile(folder, ".exr"), inner = OwnedTemporary::makeFolder(folder);
        if (inner) writeContent(inner->path() / "content", "half");
        ::_exit(file && inner ? 0 : 1);
    }
    int status = -1;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_EQ(status, 0);
}

std::ptrdiff_t entriesOf(const fs::path& folder) {
    return std::distance(fs::directory_iterator(folder), fs::directory_iterator());
}

TEST(RemoveLeftovers, TakesWhatNoProcessOwnsAndNothingElse) {
    const TemporaryFolder folder;
    writeContent(folder / "kept", "text");
    fs::create_symlink("kept", folder / ".lightcook-link");
    const std::ptrdiff_t before = entriesOf(folder.path());
    leaveBehind(folder.path());
    EXPECT_EQ(entriesOf(folder.path()), before + 3) << "a file, a folder and the lock of the folder";
    const auto file = OwnedTemporary::makeFile(folder.path(), ".exr"), inner = OwnedTemporary::makeFolder(folder.path());
    ASSERT_TRUE(file && inner);
    removeLeftovers(folder.path());
    EXPECT_EQ(entriesOf(folder.path()), before + 3);
    EXPECT_TRUE(fs::exists(file->path()));
    EXPECT_TRUE(fs::exists(inner->path()));
}

TEST(RemoveLeftovers, LeavesAFolderWithoutALockForAnHour) {
    const TemporaryFolder folder;
    fs::create_directory(folder / ".lightcook-old");
    removeLeftovers(folder.path());
    EXPECT_TRUE(fs::exists(folder / ".lightcook-old"));
    fs::last_write_time(folder / ".lightcook-old", fs::file_time_type::clock::now() - std::chrono::hours(2));
    removeLeftovers(folder.path());
    EXPECT_FALSE(fs::exists(folder / ".lightcook-old"));
}

TEST(RemoveLeftovers, HappensWhereATemporaryFolderIsMade) {
    const TemporaryFolder folder;
    const std::ptrdiff_t before = entriesOf(folder.path());
    leaveBehind(folder.path());
    const auto made = TemporaryFolder::create(folder.path());
    ASSERT_TRUE(made);
    EXPECT_EQ(entriesOf(folder.path()), before + 2) << "the new one and its lock";
}

/// A folder of the kernel, in which nobody may make a file, not even root.
TEST(OwnedTemporary, WhereNobodyMayWriteTheErrorNamesTheFolder) {
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

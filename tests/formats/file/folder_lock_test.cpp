#include "formats/folder_lock.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <iterator>

#include "tests/formats/temporary_folder.h"

namespace lightcook::formats {
namespace {

namespace fs = std::filesystem;

/// Returns true if another process can lock the folder. It ends without releasing the lock, as a killed one does.
bool isFreeForOthers(const fs::path& folder) {
    const pid_t child = ::fork();
    if (child == 0) {
        const auto lock = FolderLock::take(folder);
        ::_exit(lock ? 0 : 1);
    }
    int status = -1;
    return ::waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

TEST(FolderLock, KeepsOthersOutUntilItsEnd) {
    const TemporaryFolder folder;
    EXPECT_TRUE(isFreeForOthers(folder.path()));
    {
        const auto lock = FolderLock::take(folder.path());
        ASSERT_TRUE(lock);
        EXPECT_TRUE(lock->isOf(folder.path()));
        EXPECT_FALSE(isFreeForOthers(folder.path()));
        EXPECT_FALSE(FolderLock::take(folder.path())) << "a second owner in this process";
        EXPECT_TRUE(fs::is_empty(folder.path())) << "the lock is no file";
    }
    EXPECT_TRUE(isFreeForOthers(folder.path()));
    EXPECT_TRUE(FolderLock::take(folder.path())) << "the process that had it is gone";
}

TEST(FolderLock, IsEmptyWithoutAFolder) {
    const TemporaryFolder folder;
    const auto first = FolderLock::take(folder / "none"), second = FolderLock::take(folder / "none");
    ASSERT_TRUE(first && second);
    EXPECT_FALSE(first->isOf(folder / "none"));
}

TEST(FolderLock, IsNotOfAFolderThatWasMadeAnew) {
    const TemporaryFolder folder;
    fs::create_directory(folder / "inner");
    const auto lock = FolderLock::take(folder / "inner");
    ASSERT_TRUE(lock && lock->isOf(folder / "inner"));
    fs::rename(folder / "inner", folder / "moved");
    fs::create_directory(folder / "inner");
    EXPECT_FALSE(lock->isOf(folder / "inner"));
    EXPECT_TRUE(lock->isOf(folder / "moved"));
}

}  // namespace
}  // namespace lightcook::formats

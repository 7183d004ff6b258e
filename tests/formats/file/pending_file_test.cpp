#include "formats/pending_file.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/formats/temporary_folder.h"

namespace lightcook::formats {
namespace {

std::ptrdiff_t filesIn(const std::filesystem::path& folder) {
    return std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator());
}

TEST(PendingFile, AppearsWholeAtCommitAndReplacesWhatWasThere) {
    const TemporaryFolder folder;
    const auto file = folder / "map.exr";
    std::ofstream(file) << "old";
    auto pending = PendingFile::create(file);
    ASSERT_TRUE(pending) << pending.error().line();
    EXPECT_EQ(pending->temporary().extension(), ".exr");
    EXPECT_EQ(pending->temporary().parent_path(), file.parent_path());
    std::ofstream(pending->temporary()) << "new";
    EXPECT_EQ(contentOf(file), "old");
    ASSERT_TRUE(pending->commit());
    EXPECT_EQ(contentOf(file), "new");
    EXPECT_EQ(filesIn(folder.path()), 1);
}

TEST(PendingFile, LeavesNothingWithoutCommit) {
    const TemporaryFolder folder;
    {
        auto pending = PendingFile::create(folder / "a.bin");
        ASSERT_TRUE(pending);
        std::ofstream(pending->temporary()) << "half";
        PendingFile moved = std::move(*pending);
        EXPECT_EQ(filesIn(folder.path()), 1);
    }
    EXPECT_EQ(filesIn(folder.path()), 0);
}

TEST(PendingFile, AMissingFolderIsAnErrorWithThePath) {
    const TemporaryFolder folder;
    const auto pending = PendingFile::create(folder / "absent" / "a.bin");
    ASSERT_FALSE(pending);
    EXPECT_EQ(pending.error().code, ErrorCode::Internal);
    EXPECT_NE(pending.error().line().find("absent"), std::string::npos) << pending.error().line();
}

TEST(PendingFile, ReplacesWhatASymbolicLinkNames) {
    const TemporaryFolder folder;
    std::filesystem::create_directory(folder / "real");
    std::ofstream(folder / "real/a.bin") << "old";
    std::filesystem::create_symlink("real/a.bin", folder / "first");
    std::filesystem::create_symlink("first", folder / "second");
    const std::string text = "new";
    ASSERT_TRUE(writeWholeFile(folder / "second", std::as_bytes(std::span(text))));
    EXPECT_TRUE(std::filesystem::is_symlink(folder / "second"));
    EXPECT_TRUE(std::filesystem::is_symlink(folder / "first"));
    EXPECT_EQ(contentOf(folder / "real/a.bin"), "new");
    EXPECT_EQ(filesIn(folder / "real"), 1);
}

TEST(PendingFile, ReplacesALinkWhereItMayNotBeFollowed) {
    const TemporaryFolder folder;
    std::ofstream(folder / "mine.txt") << "mine";
    std::filesystem::create_directory(folder / "out");
    const std::string text = "new";
    for (const char* target : {"../mine.txt", "../absent.txt", "a.bin"}) {
        std::filesystem::create_symlink(target, folder / "out/a.bin");
        ASSERT_TRUE(writeWholeFile(folder / "out/a.bin", std::as_bytes(std::span(text)), OutputLink::Replace)) << target;
        EXPECT_TRUE(std::filesystem::is_regular_file(std::filesystem::symlink_status(folder / "out/a.bin"))) << target;
        EXPECT_EQ(contentOf(folder / "out/a.bin"), "new");
        std::filesystem::remove(folder / "out/a.bin");
    }
    EXPECT_EQ(contentOf(folder / "mine.txt"), "mine");
    EXPECT_FALSE(std::filesystem::exists(folder / "absent.txt"));
    const auto device = findOutputPlace("/dev/null", OutputLink::Replace);
    ASSERT_TRUE(device);
    EXPECT_TRUE(device->isStream);
}

TEST(PendingFile, RefusesFoldersLoopsAndNamesThatAreTooLong) {
    const TemporaryFolder folder;
    std::filesystem::create_symlink("b", folder / "a");
    std::filesystem::create_symlink("a", folder / "b");
    for (const std::filesystem::path& file : {folder.path(), folder / "a", folder / std::string(300, 'n')}) {
        const auto refused = PendingFile::create(file);
        ASSERT_FALSE(refused) << file;
        EXPECT_EQ(refused.error().code, ErrorCode::InvalidRequest) << refused.error().line();
        EXPECT_EQ(refused.error().subject, file.string());
    }
    const std::string longest(255, 'n');
    EXPECT_TRUE(writeWholeFile(folder / longest, {}));
    EXPECT_TRUE(std::filesystem::exists(folder / longest));
}

TEST(PendingFile, WritesIntoADeviceAndLeavesIt) {
    const std::string text = "gone";
    EXPECT_TRUE(writeWholeFile("/dev/null", std::as_bytes(std::span(text))));
    EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
    const auto full = writeWholeFile("/dev/full", std::as_bytes(std::span(text)));
    ASSERT_FALSE(full);
    EXPECT_EQ(full.error().code, ErrorCode::Internal);
}

TEST(WriteWholeFile, WritesTheBytes) {
    const TemporaryFolder folder;
    const std::string text(300000, 'x');
    ASSERT_TRUE(writeWholeFile(folder / "a.bin", std::as_bytes(std::span(text))));
    EXPECT_EQ(contentOf(folder / "a.bin"), text);
    ASSERT_TRUE(writeWholeFile(folder / "a.bin", {}));
    EXPECT_EQ(contentOf(folder / "a.bin"), "");
}

}  // namespace
}  // namespace lightcook::formats

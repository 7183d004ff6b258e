#include "formats/temporary_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/formats/temporary_folder.h"

namespace lightcook::formats {
namespace {

TEST(TemporaryFolder, IsRemovedWithItsContentAndTheParentsMadeForIt) {
    const TemporaryFolder outer;
    {
        const auto inner = TemporaryFolder::create(outer / "a" / "b");
        ASSERT_TRUE(inner) << inner.error().line();
        EXPECT_EQ(inner->path().parent_path(), outer / "a" / "b");
        writeContent(*inner / "file", "text");
    }
    EXPECT_TRUE(std::filesystem::is_empty(outer.path()));
}

TEST(TemporaryFolder, KeepsParentsThatHoldSomethingElse) {
    const TemporaryFolder outer;
    {
        const auto inner = TemporaryFolder::create(outer / "a" / "b");
        ASSERT_TRUE(inner) << inner.error().line();
        writeContent(outer / "a" / "kept", "text");
    }
    EXPECT_TRUE(std::filesystem::exists(outer / "a" / "kept"));
    EXPECT_FALSE(std::filesystem::exists(outer / "a" / "b"));
}

TEST(TemporaryFolder, MovedFromOwnsNothing) {
    std::filesystem::path path;
    {
        TemporaryFolder first;
        path = first.path();
        const TemporaryFolder second(std::move(first));
        EXPECT_EQ(second.path(), path);
        EXPECT_TRUE(std::filesystem::is_directory(path));
    }
    EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(TemporaryFolder, FileInTheWayIsAnError) {
    const TemporaryFolder outer;
    writeContent(outer / "file", "text");
    const auto refused = TemporaryFolder::create(outer / "file" / "inner");
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::Internal);
    EXPECT_THAT(refused.error().line(), testing::HasSubstr("making a temporary folder in it"));
}

}  // namespace
}  // namespace lightcook::formats

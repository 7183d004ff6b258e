#include "formats/read_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>

#include "formats/json_structure.h"
#include "formats/memory.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::formats {
namespace {

using testing::HasSubstr;

TEST(ReadFile, ReadsTextAndBytes) {
    const TemporaryFolder folder;
    writeContent(folder / "a", "text");
    EXPECT_EQ(readWholeText(folder / "a").value(), "text");
    EXPECT_EQ(readWholeFile(folder / "a").value().size(), 4u);
    const auto refused = readWholeText(folder / "a", 3);
    ASSERT_FALSE(refused);
    EXPECT_THAT(refused.error().line(), HasSubstr("found 4 bytes, expected at most 3"));
}

TEST(ReadFile, RefusesWhatIsNoFileAtOnce) {
    const TemporaryFolder folder;
    ASSERT_EQ(::mkfifo((folder / "fifo").c_str(), 0600), 0);
    for (const auto& [file, found] : {std::pair(folder / "fifo", "a FIFO"), {folder.path(), "a folder"}, {"/dev/zero", "a device"}}) {
        const auto refused = readWholeText(file);
        ASSERT_FALSE(refused) << file;
        EXPECT_EQ(refused.error().code, ErrorCode::FileUnreadable);
        EXPECT_THAT(refused.error().line(), HasSubstr(found));
    }
}

TEST(FaultOfStructure, CountsBracketsAndMembersOutsideStrings) {
    EXPECT_FALSE(faultOfStructure(R"({"a": [1, {"b": "[[[[\"[["}]})", 3));
    EXPECT_TRUE(faultOfStructure(R"({"a": [1, {"b": []}]})", 3));
    EXPECT_FALSE(faultOfStructure("[[],[],[],[]]", 2));
    EXPECT_FALSE(faultOfStructure("\"\\", 0));
    std::string members, elements;
    for (int i = 0; i < kMostJsonMembers; ++i) {
        members += "\"a,b\": 1,";
        elements += "1,";
    }
    EXPECT_FALSE(faultOfStructure("[" + elements + "1]", 4));
    EXPECT_FALSE(faultOfStructure("{" + members.substr(0, members.size() - 1) + "}", 4));
    EXPECT_EQ(faultOfStructure("{" + members + "\"c\": 1}", 4), "a JSON object of more than 2000 members");
}

TEST(CheckMemory, KnowsTheLimitOfAddressSpace) {
    EXPECT_TRUE(checkMemory(1 << 20, "a"));
    const pid_t child = ::fork();
    if (child == 0) {
        // One GiB beyond what is mapped already: a sanitizer maps terabytes before the test begins, and needs more while it runs.
        std::uint64_t pages = 0;
        std::ifstream("/proc/self/statm") >> pages;
        const std::uint64_t bytes = pages * 4096 + (std::uint64_t{1} << 30);
        const rlimit limit{bytes, bytes};
        ::setrlimit(RLIMIT_AS, &limit);
        const auto refused = checkMemory(std::uint64_t{2} << 30, "map.exr");
        ::_exit(!refused && refused.error().code == ErrorCode::WrongShape && refused.error().subject == "map.exr" ? 0 : 1);
    }
    int status = -1;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_EQ(status, 0);
    EXPECT_FALSE(checkMemory(std::uint64_t{1} << 60, "a")) << "more than any machine has";
}

}  // namespace
}  // namespace lightcook::formats

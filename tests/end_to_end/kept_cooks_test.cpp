// Cooked folders of earlier versions, with their sources: this version verifies, reports and shows each of them. A release adds its own to
// tests/end_to_end/kept (cook a small scene, then tar -czf VERSION.tar.gz of its folder); one that is out is never made anew.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>

#include "tests/formats/temporary_folder.h"
#include "tests/pipeline/shell.h"

namespace lightcook::pipeline {
namespace {

namespace fs = std::filesystem;
using formats::contentOf;

class KeptCooks : public testing::Test {
protected:
    /// Unpacks a cook as the folder "small".
    void unpack(const fs::path& archive) const {
        fs::remove_all(folder_ / "small");
        ASSERT_EQ(runShell(fmt::format("tar -C '{}' -xzf '{}'", folder_.path().string(), archive.string())), 0);
    }
    /// Runs the program in the folder of the scene. Returns its exit code; what it printed lies in the file "log".
    int run(const std::string& arguments) const {
        return runShell(fmt::format("cd '{}' && '{}' {} >../log 2>&1", (folder_ / "small").string(), LIGHTCOOK_PROGRAM, arguments));
    }
    std::string log() const { return contentOf(folder_ / "log"); }
    static std::vector<fs::path> archives() {
        std::vector<fs::path> all;
        for (const auto& entry : fs::directory_iterator(LIGHTCOOK_SOURCE_DIR "/tests/end_to_end/kept")) all.push_back(entry.path());
        return all;
    }

    const formats::TemporaryFolder folder_;
};

TEST_F(KeptCooks, AreVerifiedReportedAndShown) {
    ASSERT_FALSE(archives().empty());
    for (const fs::path& archive : archives()) {
        SCOPED_TRACE(archive.filename());
        unpack(archive);
        EXPECT_EQ(run("verify out"), 0) << log();
        EXPECT_EQ(run("report out"), 0) << log();
        EXPECT_EQ(run("info out"), 0) << log();
        EXPECT_EQ(run("view out --export page"), 0) << log();
        EXPECT_TRUE(fs::exists(folder_ / "small/page/index.html"));
    }
}

/// The number of the schema decides, before anything else is read.
TEST_F(KeptCooks, OfALaterSchemaAreRefusedInOneLine) {
    for (const fs::path& archive : archives()) {
        SCOPED_TRACE(archive.filename());
        unpack(archive);
        const fs::path manifest = folder_ / "small/out/cooked.json";
        std::string text = contentOf(manifest);
        const std::string now = "\"schema\": 1,";
        ASSERT_NE(text.find(now), std::string::npos);
        formats::writeContent(manifest, text.replace(text.find(now), now.size(), "\"schema\": 99,"));
        for (const char* command : {"verify out", "report out", "view out --export page"}) {
            SCOPED_TRACE(command);
            EXPECT_EQ(run(command), 3);
            EXPECT_EQ(std::ranges::count(log(), '\n'), 1) << log();
            EXPECT_THAT(log(), testing::HasSubstr("found schema 99, expected 1: another version of lightcook wrote it"));
        }
    }
}

}  // namespace
}  // namespace lightcook::pipeline

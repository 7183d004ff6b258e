// Corruption: `verify` names the file of a cooked folder in which a byte is changed, or that comes from another cook.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <map>
#include <random>

#include "pipeline/cook/cook.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/report/report.h"
#include "tests/formats/temporary_folder.h"
#include "tests/soak/soak.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;

/// The scene that ships: every kind of asset, a mesh too.
class CookedFolder : public testing::Test {
protected:
    static void SetUpTestSuite() {
        folder_ = std::make_unique<formats::TemporaryFolder>();
        cook("cooked", 0.02, 3);
        cook("other", 1, 0);
    }
    static void TearDownTestSuite() { folder_.reset(); }
    static std::filesystem::path cooked() { return *folder_ / "cooked"; }
    static std::filesystem::path other() { return *folder_ / "other"; }

    static std::map<std::string, std::string> filesOf(const std::filesystem::path& folder) {
        std::map<std::string, std::string> files;
        for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
            if (entry.is_regular_file()) files[entry.path().lexically_relative(folder).generic_string()] = formats::contentOf(entry.path());
        return files;
    }
    static Outcome verify() {
        const RunState state;
        return verifyCooked({cooked(), {}, 0}, state);
    }
    /// Expects exit code 3 or 4 and an error line that names the file.
    static void expectNamed(const std::string& file, const std::string& what) {
        const Outcome outcome = verify();
        ASSERT_FALSE(outcome.errors.empty()) << file << ", " << what << ": nothing found";
        EXPECT_TRUE(
            std::ranges::any_of(outcome.errors, [&](const formats::Error& error) { return error.subject.find(file) != std::string::npos; }))
            << file << ", " << what << ": " << outcome.errors[0].line();
        const std::vector<ErrorCode> codes = {ErrorCode::Verification, ErrorCode::FileUnreadable, ErrorCode::FormatUnsupported};
        EXPECT_THAT(codes, testing::Contains(outcome.errors[0].code)) << outcome.errors[0].line();
    }
    static void expectFlipNamed(const std::string& file, const std::string& content, std::size_t place, int bit) {
        formats::setByte(cooked() / file, place, static_cast<char>(content[place] ^ static_cast<char>(1 << bit)));
        expectNamed(file, fmt::format("bit {} of byte {}", bit, place));
        formats::setByte(cooked() / file, place, content[place]);
    }
    /// Flips a bit of the first, the middle and the last byte of each file, and of some at random.
    /// inText, inOthers  how many of these, in JSON and in other files
    static void expectFlipsNamed(int inText, int inOthers) {
        std::mt19937 random(3);
        int flips = 0;
        const auto files = filesOf(cooked());
        for (const char* file : {kManifestName, kReportName, kReportHtmlName, kShaderName}) EXPECT_TRUE(files.contains(file)) << file;
        EXPECT_GT(files.size(), 25u) << "textures, a mesh, pictures";
        for (const auto& [file, content] : files) {
            std::vector<std::size_t> places = {0, content.size() / 2, content.size() - 1};
            for (int i = 0; i < (file.ends_with(".json") ? inText : inOthers); ++i) places.push_back(random() % content.size());
            for (const std::size_t place : places) {
                expectFlipNamed(file, content, place, static_cast<int>(random() % 8));
                ++flips;
            }
        }
        std::printf("figures %d flipped bytes in %zu files\n", flips, files.size());
        EXPECT_EQ(filesOf(cooked()), files) << "as it was before";
    }

private:
    /// These are the cooks of mutation_test and of engines_test: the shared cache has them.
    static void cook(const char* name, double maxError, int effort) {
        CookOptions options;
        options.scene = std::filesystem::path(LIGHTCOOK_SOURCE_DIR) / "examples/cornell/scene.toml";
        options.output = *folder_ / name;
        options.cache = LIGHTCOOK_TEST_CACHE;
        options.given.set("output.light_map_layout", "basis-8");
        options.given.set("output.max_error", maxError);
        options.given.set("output.effort", effort);
        const RunState state;
        for (const formats::Error& error : cookScene(options, state).errors) ADD_FAILURE() << error.line();
    }
    static inline std::unique_ptr<formats::TemporaryFolder> folder_;
};

TEST_F(CookedFolder, IsFoundWholeAsItWasCooked) {
    EXPECT_THAT(verify().errors, testing::IsEmpty());
}

TEST_F(CookedFolder, AFlippedByteOfAnyFileIsFoundAndNamed) {
    expectFlipsNamed(8, 1);
}

using CookedFolderSoak = CookedFolder;
TEST_F(CookedFolderSoak, AFlippedBitOfAnyFileIsFoundAndNamed) {
    const auto files = filesOf(cooked());
    test::repeatInSoak("flipped bits", 1, [&](std::uint64_t seed) {
        std::mt19937_64 random(seed);
        const auto& [file, content] = *std::next(files.begin(), static_cast<std::ptrdiff_t>(random() % files.size()));
        expectFlipNamed(file, content, random() % content.size(), static_cast<int>(random() % 8));
    });
    EXPECT_EQ(filesOf(cooked()), files) << "as it was before";
}

TEST_F(CookedFolder, AFileOfAnotherCookIsFoundAndNamed) {
    const auto files = filesOf(cooked()), others = filesOf(other());
    int stale = 0;
    for (const auto& [file, content] : files) {
        const auto found = others.find(file);
        if (found == others.end() || found->second == content) continue;
        formats::writeContent(cooked() / file, found->second);
        // A manifest beside the files of another cook: every file that is not the manifest's is named.
        expectNamed(file == kManifestName ? kReportName : file, "of another cook");
        formats::writeContent(cooked() / file, content);
        ++stale;
    }
    std::printf("figures %d files of another cook\n", stale);
    EXPECT_GE(stale, 6);
    EXPECT_EQ(filesOf(cooked()), files) << "as it was before";
}

TEST_F(CookedFolder, AMissingFileIsFoundAndNamedAndAMissingReportIsNoFault) {
    for (const auto& [file, content] : filesOf(cooked())) {
        std::filesystem::remove(cooked() / file);
        if (file == kReportName)
            EXPECT_THAT(verify().errors, testing::IsEmpty());
        else
            expectNamed(file, "missing");
        formats::writeContent(cooked() / file, content);
    }
}

}  // namespace
}  // namespace lightcook::pipeline

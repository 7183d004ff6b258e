#include "pipeline/cook/kept_candidates.h"

#include <gmock/gmock.h>

#include "pipeline/document/json.h"
#include "pipeline/graph/digest.h"
#include "pipeline/report/report.h"
#include "tests/pipeline/small_scene.h"
#include "tests/pipeline/view/cooked_site.h"

namespace lightcook::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

/// A scene whose layout is chosen of three.
class KeptCandidates : public testing::Test {
protected:
    Outcome cook(bool keep, const std::string& output = kOutput) {
        scene_.writeSceneFile(output);
        CookOptions options = scene_.options();
        options.keepCandidates = keep;
        Outcome outcome = cookScene(options, state_);
        for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
        return outcome;
    }
    fs::path folder() const { return scene_ / "out"; }
    formats::Result<Site> open() { return Site::open({folder(), {}, kPage}, state_); }

    static constexpr const char* kOutput = "layouts = [\"hdr\", \"hdr-2\", \"raw\"]\nmax_error = 0.05";
    SmallScene scene_{SmallScene::Parts::LightMap};
    RunState state_;
};

TEST_F(KeptCandidates, AreCookedFoldersOfTheirOwn) {
    const Outcome outcome = cook(true);
    EXPECT_THAT(outcome.candidates, ElementsAre("hdr-2", "raw"));
    EXPECT_THAT(candidatesIn(folder()), ElementsAre("raw", "hdr-2")) << "in the order of the table";
    EXPECT_EQ(loadReport(folder() / kReportName)->assets.front().layout, "hdr");
    for (const std::string& layout : outcome.candidates) {
        const fs::path candidate = candidateFolder(folder(), layout);
        const Outcome verified = verifyCooked({candidate, {}, {}}, state_);
        EXPECT_TRUE(verified.errors.empty()) << verified.errors.front().line();
        EXPECT_EQ(verified.report.at("assets").at(0).at("layout"), layout);
        EXPECT_TRUE(isCandidateOf(*loadManifest(candidate), *loadManifest(folder())));
    }
    EXPECT_EQ(cook(true).actionsRun, 0) << "nothing has changed";
}

TEST_F(KeptCandidates, TheSceneItselfHasTheSameBytes) {
    cook(false);
    const std::string without = *digestOfFile(folder() / kManifestName);
    EXPECT_THAT(candidatesIn(folder()), IsEmpty());
    cook(true);
    EXPECT_EQ(*digestOfFile(folder() / kManifestName), without);
    cook(false);
    EXPECT_THAT(candidatesIn(folder()), IsEmpty()) << "removed";
    EXPECT_FALSE(fs::exists(folder() / "candidates"));
}

using KeptCandidatesSoak = KeptCandidates;
TEST_F(KeptCandidatesSoak, MayMissTheLimitsOfTheScene) {
    const Outcome outcome = cook(true, "layouts = [\"sh4\", \"raw\"]\nmax_error = 0.001");
    ASSERT_THAT(outcome.candidates, ElementsAre("sh4"));
    EXPECT_TRUE(loadReport(folder() / kReportName)->passed);
    EXPECT_FALSE(loadReport(candidateFolder(folder(), "sh4") / kReportName)->passed);
}

TEST_F(KeptCandidatesSoak, AreThoseOfABudgetToo) {
    const Outcome outcome = cook(true, "layouts = [\"hdr\", \"hdr-2\", \"raw\"]\nbudget = \"16 KiB\"");
    EXPECT_EQ(outcome.candidates.size(), 2u);
    for (const std::string& layout : outcome.candidates)
        EXPECT_FALSE(loadReport(candidateFolder(folder(), layout) / kReportName)->budget.limitBytes) << "a budget is that of the scene";
}

TEST_F(KeptCandidatesSoak, HaveTheirLayoutsAlsoWhereABudgetAloneChooses) {
    for (const char* limits : {"budget = \"1 MiB\"", "max_whole_visible = 10"}) {
        const Outcome outcome = cook(true, limits);
        EXPECT_GE(outcome.candidates.size(), 2u);
        for (const std::string& layout : outcome.candidates)
            EXPECT_EQ(loadReport(candidateFolder(folder(), layout) / kReportName)->assets.front().layout, layout);
    }
}

TEST_F(KeptCandidates, NothingIsCookedWhereNoLayoutIsTried) {
    scene_.writeSceneFile("light_map_layout = \"ratio\"");
    CookOptions options = scene_.options();
    options.keepCandidates = true;
    const Outcome outcome = cookScene(options, state_);
    ASSERT_EQ(outcome.errors.size(), 1u);
    EXPECT_EQ(outcome.errors.front().code, formats::ErrorCode::InvalidRequest);
    EXPECT_THAT(outcome.errors.front().line(), HasSubstr("--layout auto"));
    EXPECT_FALSE(fs::exists(folder()));
}

TEST_F(KeptCandidates, ThePageHasThoseOfThisCook) {
    cook(true);
    const auto site = open();
    ASSERT_TRUE(site.has_value()) << site.error().line();
    EXPECT_THAT(site->notes(), IsEmpty());
    const Json data = Json::parse(std::get<std::string>(site->files().at("viewer/scene.json").content));
    ASSERT_EQ(data.at("candidates").size(), 2u);
    std::uint64_t smaller = 0;
    for (const Json& candidate : data.at("candidates")) {
        const std::string at = candidate.at("folder");
        EXPECT_TRUE(site->files().contains(at + "cooked.json")) << at;
        EXPECT_TRUE(site->files().contains(at + "map_sh.ktx2")) << at;
        EXPECT_FALSE(site->files().contains(at + "map_dominant_direction.ktx2")) << "that of the scene is shown";
        EXPECT_GT(candidate.at("bytes_gpu").get<std::uint64_t>(), smaller) << "the smallest first";
        smaller = candidate.at("bytes_gpu");
        EXPECT_GT(candidate.at("visible"), 0);
    }
}

TEST_F(KeptCandidates, ThePageLeavesOutThoseOfAnotherCook) {
    cook(true);
    const fs::path stale = candidateFolder(folder(), "hdr-2");
    Manifest manifest = *loadManifest(stale);
    manifest.scene = "other";
    EXPECT_FALSE(isCandidateOf(manifest, *loadManifest(folder())));
    manifest = *loadManifest(stale);
    manifest.assets.front().source.files->at("source").digest = "0";
    EXPECT_FALSE(isCandidateOf(manifest, *loadManifest(folder()))) << "another bake";
    // A candidate of another scene in its place.
    SmallScene other(SmallScene::Parts::LightMap, grey);
    other.writeSceneFile("light_map_layout = \"hdr-2\"\nmax_error = 1");
    CookOptions options = other.options();
    options.output = stale;
    ASSERT_TRUE(cookScene(options, state_).errors.empty());
    const auto site = open();
    ASSERT_TRUE(site.has_value()) << site.error().line();
    EXPECT_THAT(site->notes(), ElementsAre(HasSubstr("of another cook")));
    EXPECT_FALSE(site->files().contains("cooked/candidates/hdr-2/cooked.json"));
    EXPECT_TRUE(site->files().contains("cooked/candidates/raw/cooked.json"));
}

TEST_F(KeptCandidates, BehindALinkStayAndAreNotWritten) {
    cook(true);
    const fs::path elsewhere = scene_ / "elsewhere";
    fs::rename(folder() / "candidates", elsewhere);
    fs::create_directory_symlink("../elsewhere", folder() / "candidates");
    cook(false);
    EXPECT_TRUE(fs::exists(elsewhere / "raw" / kManifestName));
    EXPECT_TRUE(fs::is_symlink(folder() / "candidates"));
    fs::remove(elsewhere / "raw" / kManifestName);
    cook(true);
    EXPECT_TRUE(fs::is_directory(fs::symlink_status(folder() / "candidates"))) << "in place of the link";
    EXPECT_THAT(candidatesIn(folder()), ElementsAre("raw", "hdr-2"));
    EXPECT_FALSE(fs::exists(elsewhere / "raw" / kManifestName));
}

TEST_F(KeptCandidates, AreRemovedWithoutTheFilesOfOthers) {
    cook(true);
    const fs::path raw = candidateFolder(folder(), "raw");
    ASSERT_TRUE(fs::is_directory(raw / "preview"));
    formats::writeContent(raw / "notes.txt", "mine");
    formats::writeContent(raw / "preview" / "mine.png", "mine");
    cook(false);
    EXPECT_THAT(candidatesIn(folder()), IsEmpty());
    EXPECT_FALSE(fs::exists(candidateFolder(folder(), "hdr-2"))) << "all of it was written by the cook";
    std::vector<std::string> left;
    for (const auto& entry : fs::recursive_directory_iterator(folder() / "candidates"))
        if (!entry.is_directory()) left.push_back(fs::relative(entry, raw).generic_string());
    EXPECT_THAT(left, UnorderedElementsAre("notes.txt", "preview/mine.png"));
}

TEST_F(KeptCandidates, AreRemovedWithoutAnInputOfTheScene) {
    cook(true);
    Scene scene;
    scene.file = candidateFolder(folder(), "raw") / "map_sh.ktx2";
    removeCandidates(folder(), {}, NamedPlaces(scene));
    EXPECT_THAT(candidatesIn(folder()), IsEmpty());
    EXPECT_TRUE(fs::exists(scene.file));
}

TEST_F(KeptCandidates, AFileOfThatNameStays) {
    fs::create_directories(folder());
    formats::writeContent(folder() / "candidates", "notes");
    cook(false);
    EXPECT_EQ(formats::contentOf(folder() / "candidates"), "notes");
}

TEST_F(KeptCandidates, ADamagedOneIsRefusedByName) {
    cook(true);
    formats::writeContent(candidateFolder(folder(), "raw") / "map_sh.ktx2", "no texture");
    const auto site = open();
    ASSERT_FALSE(site.has_value());
    EXPECT_EQ(site.error().code, formats::ErrorCode::Verification);
    EXPECT_THAT(site.error().line(), HasSubstr("candidates/raw/map_sh.ktx2"));
}

}  // namespace
}  // namespace lightcook::pipeline

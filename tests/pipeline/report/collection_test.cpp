// Reports of several scenes: totals, budgets of platforms, comparison, history, and the page.
#include "pipeline/report/collection.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/resource.h>

#include <csignal>

#include "pipeline/command/terminal/printing.h"
#include "pipeline/graph/files.h"
#include "pipeline/report/page.h"
#include "pipeline/report/words.h"

namespace lightcook::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

ReportRow rowOf(const std::string& name, AssetKind kind, std::uint64_t bytes, double error) {
    ReportRow row;
    row.name = name;
    row.kind = kind;
    row.layout = "ratio";
    row.bytesGpu = bytes;
    row.bytesDisk = bytes / 2;
    row.verdict.limits[Limit::Error] = 0.02;
    verify::StageError stage;
    stage.name = "total";
    stage.diffuse.relRms = stage.specular.relRms = error;
    row.verdict.stages = {stage};
    row.verdict.passed = error <= 0.02;
    return row;
}

CookedFolder folderOf(const std::string& scene, const std::string& target, std::vector<ReportRow> rows) {
    CookedFolder folder;
    folder.folder = "cooked/" + scene;
    folder.target = target;
    folder.report = makeReport({scene, 1.5, 0, std::nullopt, {{"2026-11-01T10:00:00.000Z", 1.5, 1, 1, 1.5}}}, std::move(rows), {});
    if (!folder.report.passed) folder.errors.push_back({formats::ErrorCode::Verification, scene, "failed"});
    return folder;
}

std::vector<CookedFolder> twoScenes() {
    std::vector<CookedFolder> folders;
    folders.push_back(folderOf("hall", "bc", {rowOf("map", AssetKind::LightMap, 1000, 0.01)}));
    folders.push_back(
        folderOf("roof", "astc", {rowOf("map", AssetKind::LightMap, 3000, 0.01), rowOf("probe", AssetKind::Cubemap, 500, 0.015)}));
    return folders;
}

class InFolder : public testing::Test {
protected:
    fs::path write(const std::string& name, const std::string& text) const {
        EXPECT_TRUE(writeFile(folder_ / name, text));
        return folder_ / name;
    }
    const formats::TemporaryFolder folder_;
};
using Budgets = InFolder;
using History = InFolder;
using CollectionBaseline = InFolder;

TEST(Collection, AddsUpScenesTheLargestFirst) {
    const CollectionReport report = makeCollection(twoScenes());
    ASSERT_EQ(report.scenes.size(), 2u);
    EXPECT_EQ(report.scenes[0].name, "roof");
    EXPECT_EQ(report.totals.bytesGpu, 4500u);
    EXPECT_EQ(report.totals.bytesDisk, 2250u);
    EXPECT_EQ(report.totals.byKind.at("light-map"), 4000u);
    EXPECT_EQ(report.totals.byTarget.at("bc"), 1000u);
    EXPECT_TRUE(report.passed);
    EXPECT_EQ(report.scenes[0].assets[1].figures.diffuse, 0.015);
    const auto read = fromJson<CollectionReport>(toJson(report), "report.json");
    ASSERT_TRUE(read) << read.error().line();
    EXPECT_EQ(toJson(*read), toJson(report));
}

TEST(Collection, FailsWithAScene) {
    std::vector<CookedFolder> folders = twoScenes();
    folders.push_back(folderOf("cellar", "bc", {rowOf("map", AssetKind::LightMap, 10, 0.5)}));
    const CollectionReport report = makeCollection(folders);
    EXPECT_FALSE(report.passed);
    EXPECT_FALSE(report.scenes.back().passed);
    EXPECT_THAT(report.scenes.back().errors, ElementsAre("cellar: failed"));
    EXPECT_THAT(renderCollectionHtml(report, "", {}), HasSubstr("<li>cellar: cellar: failed</li>"));
}

TEST(Collection, ComparesByNameAndTarget) {
    const CollectionReport before = makeCollection(twoScenes());
    std::vector<CookedFolder> folders = twoScenes();
    folders[0] = folderOf("hall", "bc", {rowOf("map", AssetKind::LightMap, 1500, 0.012)});
    folders[1] = folderOf("roof", "bc", {rowOf("map", AssetKind::LightMap, 3000, 0.01)});
    const CollectionComparison comparison = compareCollections(makeCollection(folders), before.scenes, "old.json", {5.0, {}});
    EXPECT_EQ(comparison.bytesBefore, 4500u);
    EXPECT_EQ(comparison.bytesNow, 4500u);
    EXPECT_TRUE(comparison.passed);
    ASSERT_EQ(comparison.scenes.size(), 3u) << "another target is another scene";
    EXPECT_EQ(comparison.scenes[0].change, "added");
    EXPECT_EQ(comparison.scenes[1].name, "hall");
    EXPECT_NEAR(comparison.scenes[1].growthPercent, 50, 1e-9);
    ASSERT_EQ(comparison.scenes[1].assets.size(), 1u);
    EXPECT_TRUE(errorGrew(comparison.scenes[1].assets[0]));
    EXPECT_EQ(comparison.scenes[2].change, "removed");
    EXPECT_FALSE(compareCollections(makeCollection(folders), {before.scenes[1]}, "old.json", {5.0, {}}).passed);
}

/// Growth from nothing has no percentage.
TEST(Collection, CallsASceneThatTheBaselineLacksNew) {
    EXPECT_EQ(growthWords(0, 50), "new");
    EXPECT_EQ(growthWords(0, 0), "+0.00 %");
    EXPECT_EQ(growthWords(50, 0), "-100.00 %");
    CollectionReport report = makeCollection(twoScenes());
    const auto printed = [&](const std::vector<SceneSummary>& before, std::optional<double> allowedPercent = std::nullopt) {
        report.baseline = compareCollections(report, before, "old.json", {allowedPercent, {}});
        Terminal terminal(TerminalOptions{LogFormat::Text, Verbosity::Normal, ColorChoice::Never});
        testing::internal::CaptureStdout();
        printCollection(terminal, report);
        return testing::internal::GetCapturedStdout();
    };
    EXPECT_THAT(printed({report.scenes[1]}),
                AllOf(HasSubstr(" added    0 bytes -> 3.42 KiB (new), 2 assets"), Not(HasSubstr("+100.00 %"))));
    EXPECT_THAT(printed({}), AllOf(HasSubstr("0 bytes -> 4.39 KiB since old.json (new); "), Not(HasSubstr("+100.00 %"))));
    EXPECT_THAT(printed({report.scenes[0], report.scenes[1]}, 0),
                HasSubstr("4.39 KiB -> 4.39 KiB since old.json (+0.00 %, at most 0 % allowed); 2 of 2"));
}

TEST(Collection, CountsOneAssetAndOneByteInTheSingular) {
    EXPECT_EQ(counted(1, "asset"), "1 asset");
    EXPECT_EQ(counted(0, "asset"), "0 assets");
    EXPECT_EQ(sizeWords(1), "1 byte");
    EXPECT_EQ(sizeWords(5652), "5.52 KiB");
    EXPECT_EQ(sizeWords(5652, 1), "5652 bytes");
    EXPECT_EQ(sizeWords(std::uint64_t{2} << 20, 5652), "2048.00 KiB");
    CollectionReport report = makeCollection({twoScenes()[0]});
    report.baseline = compareCollections(report, {}, "old.json", {});
    Terminal terminal(TerminalOptions{LogFormat::Text, Verbosity::Normal, ColorChoice::Never});
    testing::internal::CaptureStdout();
    printCollection(terminal, report);
    EXPECT_THAT(testing::internal::GetCapturedStdout(),
                AllOf(HasSubstr("(new), 1 asset\n"), HasSubstr("0 of 1 scene unchanged\n"), HasSubstr("in 1 scene, 0 failed")));
}

/// The sizes of a budget stand in one unit.
TEST(Collection, SummaryHasUseAndLimitInOneUnit) {
    const auto printed = [](std::uint64_t limit) {
        const Report report = makeReport({"hall", 1.5, 0, limit, {{"2026-11-01T10:00:00.000Z", 1.5, 1, 1, 1.5}}},
                                         {rowOf("map", AssetKind::LightMap, 5652, 0.01)}, {});
        Terminal terminal(TerminalOptions{LogFormat::Text, Verbosity::Normal, ColorChoice::Never});
        testing::internal::CaptureStdout();
        printSummary(terminal, report, Outcome());
        return testing::internal::GetCapturedStdout();
    };
    EXPECT_THAT(printed(1), HasSubstr("FAILED: over the budget, 1 asset passed, 5652 bytes of 1 byte of GPU memory"));
    EXPECT_THAT(printed(std::uint64_t{1} << 20), HasSubstr("passed: 1 asset, 5.52 KiB of 1024.00 KiB of GPU memory"));
}

TEST(Collection, PrintsADashForLightThatASceneDoesNotHave) {
    CollectionReport report = makeCollection(twoScenes());
    for (AssetSummary& asset : report.scenes[0].assets) asset.figures.specular.reset();
    for (AssetSummary& asset : report.scenes[1].assets) asset.figures.specular = 0.25;
    Terminal terminal(TerminalOptions{LogFormat::Text, Verbosity::Normal, ColorChoice::Never});
    testing::internal::CaptureStdout();
    printCollection(terminal, report);
    const std::string printed = testing::internal::GetCapturedStdout();
    EXPECT_THAT(printed, AllOf(HasSubstr(" 1.500 %          -  "), HasSubstr(" 25.000 %  "), Not(HasSubstr(" 0.000 %"))));
}

TEST_F(CollectionBaseline, IsReadBackFromJson) {
    const CollectionReport report = makeCollection(twoScenes());
    const auto scenes = readBaselineScenes(write("old.json", textOf(toJson(report))));
    ASSERT_TRUE(scenes) << scenes.error().line();
    EXPECT_EQ(compareCollections(report, *scenes, "old.json", {}).scenes[0].change, "same");
    const auto other = readBaselineScenes(write("other.json", "{\"scenes\": 3, \"totals\": 4}"));
    ASSERT_FALSE(other);
    EXPECT_THAT(other.error().line(), HasSubstr("other.json"));
}

TEST(Collection, PageOfManyScenesStaysSmall) {
    std::vector<CookedFolder> folders;
    for (int i = 0; i < 500; ++i)
        folders.push_back(folderOf(fmt::format("scene{}", i), "bc", {rowOf("map", AssetKind::LightMap, 1000, 0.01)}));
    EXPECT_LT(renderCollectionHtml(makeCollection(folders), "all.html", {}).size(), std::size_t{2} << 20);
}

constexpr const char* kBudgetsText = R"(schema = 1
[[platform]]
name = "desktop"
target = "bc"
scene = "2 KiB"
[[platform]]
name = "handheld"
total = "4 KiB"
scene = "1 KiB"
scenes = { roof = "8 KiB" }
kinds = { light-map = "2000", cubemap = "500" }
)";

TEST_F(Budgets, HoldScenesOfTheirTarget) {
    const auto budgets = readBudgets(write("budgets.toml", kBudgetsText));
    ASSERT_TRUE(budgets) << budgets.error().line();
    std::vector<SceneMemory> memory;
    for (const CookedFolder& folder : twoScenes()) memory.push_back(memoryOf(folder));
    const std::vector<PlatformUse> uses = usesOf(*budgets, memory);
    ASSERT_EQ(uses.size(), 2u);
    EXPECT_TRUE(uses[0].passed);
    EXPECT_EQ(uses[0].usedBytes, 1000u);
    EXPECT_EQ(uses[0].scenes, 1);
    EXPECT_FALSE(uses[1].passed);
    ASSERT_EQ(uses[1].checks.size(), 6u);
    EXPECT_EQ(uses[1].checks[0].limit, "total");
    EXPECT_FALSE(uses[1].checks[0].passed) << "4500 of 4096";
    EXPECT_EQ(uses[1].checks[3].limitBytes, 8192u) << "the scene's own limit";
    const auto errors = errorsOf(uses, "budgets.toml");
    ASSERT_EQ(errors.size(), 2u);
    EXPECT_EQ(errors[0].code, formats::ErrorCode::OverBudget);
    EXPECT_EQ(errors[0].line(),
              "budgets.toml, platform handheld, all scenes: found 4.39 KiB of GPU memory, expected at most 4.00 KiB: 404 bytes too much");
    EXPECT_EQ(errors[1].line(),
              "budgets.toml, platform handheld, scene roof, light-map: found 2.93 KiB of GPU memory, expected at most 1.95 KiB: 1000 bytes "
              "too much");
}

TEST_F(Budgets, NamesOfScenesThatAreNotThereAreAWarning) {
    const auto warningOf = [&](const std::string& scenes) {
        const auto budgets = readBudgets(write("budgets.toml", "schema = 1\n[[platform]]\nname = \"a\"\nscenes = { " + scenes + " }\n"));
        EXPECT_TRUE(budgets);
        std::vector<SceneMemory> memory;
        for (const CookedFolder& folder : twoScenes()) memory.push_back(memoryOf(folder));
        return warningOfUnknownScenes(*budgets, memory).value_or("");
    };
    EXPECT_EQ(warningOf("hall = \"1\", roof = \"1\""), "");
    EXPECT_EQ(warningOf("hal = \"1\", roof = \"1\""),
              "found limits for 'hal' (nearest is 'hall'), expected names of cooked scenes: other limits are not checked");
    EXPECT_THAT(warningOf("attic = \"1\", barn = \"1\", cellar = \"1\", rooof = \"1\", zoo = \"1\""),
                AllOf(HasSubstr("found limits for 'rooof' (nearest is 'roof'), "), HasSubstr(" and 2 more, expected")))
        << "the nearest one first";
}

TEST_F(Budgets, PlatformsOfOtherTargetsAreAWarning) {
    const auto warningOf = [&](const std::vector<std::string>& targets) {
        std::string text = "schema = 1\n";
        for (std::size_t i = 0; i < targets.size(); ++i)
            text += fmt::format("[[platform]]\nname = \"p{}\"\ntotal = \"1\"\n{}", i,
                                targets[i].empty() ? "" : fmt::format("target = \"{}\"\n", targets[i]));
        const auto budgets = readBudgets(write("budgets.toml", text));
        EXPECT_TRUE(budgets);
        std::vector<SceneMemory> memory;
        for (const CookedFolder& folder : twoScenes()) memory.push_back(memoryOf(folder));
        return warningOfUnusedPlatforms(*budgets, memory).value_or("");
    };
    EXPECT_EQ(warningOf({"bc", "astc", ""}), "");
    EXPECT_EQ(warningOf({"bc", "float"}),
              "found limits for 'p1' (target float), expected scenes that were cooked for that target: other limits are not checked");
    EXPECT_THAT(warningOf({"float", "float", "float", "float", "float"}), HasSubstr("'p2' (target float) and 2 more, expected"));
}

TEST_F(Budgets, AFolderIsNoFileOfBudgets) {
    const auto folder = readBudgets(folder_.path());
    ASSERT_FALSE(folder);
    EXPECT_EQ(folder.error().detail, "found a folder, expected the budgets of platforms (TOML)");
    EXPECT_THAT(readBudgets(folder_ / "none.toml").error().detail, HasSubstr("found no such file"));
}

TEST_F(Budgets, MistakesNamePlaceAndNearestName) {
    const auto lineOf = [&](const std::string& text) {
        const auto budgets = readBudgets(write("budgets.toml", text));
        return budgets ? std::string("read") : budgets.error().detail;
    };
    EXPECT_THAT(lineOf("schema = 1\n[[platfrom]]\n"),
                HasSubstr("unknown key 'platfrom' in the file, expected one of its keys; nearest is 'platform'"));
    EXPECT_THAT(lineOf("schema = 1\n[[platform]]\nname = \"a\"\ntotl = \"1\"\n"), HasSubstr("nearest is 'total'"));
    EXPECT_THAT(lineOf("schema = 1\n[[platform]]\nname = \"a\"\nkinds = { lightmap = \"1\" }\n"), HasSubstr("nearest is 'light-map'"));
    EXPECT_THAT(lineOf("schema = 1\n[[platform]]\nname = \"a\"\nformats = { bc6 = \"1\" }\n"), HasSubstr("unknown key 'bc6'"));
    EXPECT_THAT(lineOf("schema = 1\n[[platform]]\nname = \"a\"\ntarget = \"bcc\"\ntotal = \"1\"\n"),
                HasSubstr("found 'bcc' for platform.target, expected one of: bc, astc, float"));
    EXPECT_THAT(lineOf("schema = 1\n[[platform]]\nname = \"a\"\n"), HasSubstr("found no limit for platform 'a'"));
    EXPECT_THAT(lineOf("schema = 1\n[[platform]]\nname = \"a\"\ntotal = 3\n"),
                HasSubstr("found the integer 3 for platform.total, expected a size such as \"2 MiB\""));
    EXPECT_THAT(lineOf("schema = 1\n[[platform]]\nname = \"a\"\ntotal = \"3 MB\"\n[[platform]]\nname = \"a\"\ntotal = \"1\"\n"),
                HasSubstr("found a second platform 'a'"));
    EXPECT_THAT(lineOf("schema = 2\n"), HasSubstr("expected schema = 1"));
    EXPECT_THAT(lineOf("schema = true\n"), HasSubstr("found true (a boolean) for schema, expected schema = 1"));
    EXPECT_THAT(lineOf("schema = 1\n"), HasSubstr("expected tables [[platform]]"));
    EXPECT_THAT(lineOf("schema = [\n"), HasSubstr("syntax error"));
}

TEST_F(History, AppendsALineOnceForAReport) {
    const fs::path file = folder_ / "history.jsonl";
    std::vector<CookedFolder> folders = twoScenes();
    const std::vector<HistoryLine> lines = {historyLine(folders[0].report, "bc"), historyLine(folders[1].report, "astc")};
    ASSERT_TRUE(appendHistory(file, lines));
    auto history = appendHistory(file, lines);
    ASSERT_TRUE(history) << history.error().line();
    EXPECT_EQ(history->size(), 2u) << "the same report counts once";
    folders[0] = folderOf("hall", "bc", {rowOf("map", AssetKind::LightMap, 1500, 0.012)});
    history = appendHistory(file, {historyLine(folders[0].report, "bc")});
    ASSERT_TRUE(history);
    ASSERT_EQ(history->size(), 3u);
    EXPECT_EQ(history->back().bytesGpu, 1500u);
    EXPECT_EQ(history->back().diffuse, 0.012);
    const auto read = readHistory(file);
    ASSERT_TRUE(read);
    EXPECT_EQ(read->size(), 3u);
}

TEST_F(History, HasNoErrorOfLightThatNoAssetHas) {
    ReportRow row = rowOf("map", AssetKind::LightMap, 1000, 0.01);
    row.verdict.stages.back().specular.relRms = 0;
    const HistoryLine line = historyLine(folderOf("hall", "bc", {row}).report, "bc");
    EXPECT_EQ(line.diffuse, 0.01);
    EXPECT_EQ(line.specular, std::nullopt);
    EXPECT_TRUE(toJson(line).at("specular_rel_rms").is_null());
    const fs::path file = folder_ / "history.jsonl";
    ASSERT_TRUE(appendHistory(file, {line}));
    const auto read = readHistory(file);
    ASSERT_TRUE(read) << read.error().line();
    EXPECT_EQ(toJson(read->back()), toJson(line));
}

TEST_F(History, AnotherFileIsRefusedAndLeftAlone) {
    const std::vector<HistoryLine> lines = {historyLine(twoScenes()[0].report, "bc")};
    for (const std::string text : {"{\"scene\": 1}\n", "notes of mine\n", "\n", "{\"lightcook\": \"0.1\"}\n"}) {
        const fs::path file = write("history.jsonl", text);
        const auto appended = appendHistory(file, lines);
        ASSERT_FALSE(appended) << text;
        EXPECT_EQ(appended.error().code, formats::ErrorCode::FileUnreadable);
        EXPECT_THAT(appended.error().line(), HasSubstr("history.jsonl:1"));
        EXPECT_EQ(*readFile(file), text);
    }
    const fs::path good = folder_ / "good.jsonl";
    ASSERT_TRUE(appendHistory(good, lines));
    const std::string text = *readFile(good);
    write("good.jsonl", text.substr(0, text.size() - 1));
    EXPECT_FALSE(appendHistory(good, lines)) << "a line without its end was cut off";
}

/// Lets no file of this process grow beyond a size, as a full disk does.
class FullDisk {
public:
    explicit FullDisk(rlim_t bytes) : signal_(std::signal(SIGXFSZ, SIG_IGN)) {
        ::getrlimit(RLIMIT_FSIZE, &before_);
        const rlimit limited = {bytes, before_.rlim_max};
        ::setrlimit(RLIMIT_FSIZE, &limited);
    }
    FullDisk(const FullDisk&) = delete;
    FullDisk& operator=(const FullDisk&) = delete;
    ~FullDisk() {
        ::setrlimit(RLIMIT_FSIZE, &before_);
        std::signal(SIGXFSZ, signal_);
    }

private:
    rlimit before_{};
    void (*signal_)(int);
};

TEST_F(History, IsWrittenWholeOrNotAtAll) {
    const std::vector<HistoryLine> first = {historyLine(twoScenes()[0].report, "bc")}, second = {historyLine(twoScenes()[1].report, "bc")};
    const fs::path fresh = folder_ / "fresh.jsonl", file = folder_ / "history.jsonl";
    ASSERT_TRUE(appendHistory(file, first));
    const std::string text = *readFile(file);
    for (const fs::path& each : {fresh, file}) {
        formats::Result<std::vector<HistoryLine>> appended;
        {
            const FullDisk full(text.size() + 20);  // for a part of the line
            appended = appendHistory(each, each == fresh ? std::vector{first[0], second[0]} : second);
        }
        ASSERT_FALSE(appended) << each;
        EXPECT_EQ(appended.error().code, formats::ErrorCode::Internal);
        EXPECT_THAT(appended.error().line(), HasSubstr("expected to append to this file"));
    }
    EXPECT_FALSE(fs::exists(fresh)) << "no empty file stays behind";
    EXPECT_EQ(*readFile(file), text);
    ASSERT_TRUE(appendHistory(file, second));
    EXPECT_EQ(readHistory(file)->size(), 2u);
}

TEST_F(History, ADeviceIsNone) {
    for (const char* device : {"/dev/full", "/dev/null"}) {
        const auto read = readHistory(device);
        ASSERT_FALSE(read) << device;
        EXPECT_EQ(read.error().code, formats::ErrorCode::InvalidRequest);
        EXPECT_THAT(read.error().line(), HasSubstr("found a device or a pipe"));
        EXPECT_FALSE(appendHistory(device, {}));
    }
}

}  // namespace
}  // namespace lightcook::pipeline

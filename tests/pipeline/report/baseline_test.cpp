// The comparison of a report with an older one: in figures and in JSON.
#include "pipeline/report/baseline.h"

#include <gmock/gmock.h>

#include "pipeline/command/terminal/printing.h"
#include "pipeline/report/report.h"

namespace lightcook::pipeline {
namespace {

using testing::AllOf;
using testing::HasSubstr;

ReportRow rowOf(const std::string& name, std::uint64_t bytes, double error) {
    ReportRow row;
    row.name = name;
    row.layout = "ratio";
    row.bytesGpu = bytes;
    verify::StageError stage;
    stage.name = "total";
    stage.diffuse.relRms = stage.specular.relRms = error;
    row.verdict.stages = {stage};
    row.verdict.passed = true;
    return row;
}

Report reportOf(std::vector<ReportRow> rows) {
    return makeReport({"scene", 0, 0, std::nullopt}, std::move(rows), {});
}

const AssetChange& changeOf(const BaselineComparison& comparison, const std::string& name) {
    return *std::ranges::find(comparison.assets, name, &AssetChange::name);
}

TEST(Baseline, ComparesAssetByAssetBytesAndError) {
    const Report before = reportOf({rowOf("hall", 1000, 0.01), rowOf("roof", 500, 0.02), rowOf("gone", 100, 0.01)});
    const Report now = reportOf({rowOf("hall", 1200, 0.01), rowOf("roof", 500, 0.03), rowOf("new", 50, 0.01), rowOf("same", 0, 0)});
    const BaselineComparison comparison = compareWithBaseline(now, before, "old/report.json", {});
    ASSERT_EQ(comparison.assets.size(), 5u);
    EXPECT_EQ(changeOf(comparison, "hall").change, "changed");
    EXPECT_NEAR(*changeOf(comparison, "hall").growthPercent, 20, 1e-9);
    EXPECT_EQ(changeOf(comparison, "roof").change, "changed") << "the error grew";
    EXPECT_EQ(changeOf(comparison, "roof").before->diffuse, 0.02);
    EXPECT_EQ(changeOf(comparison, "roof").now->diffuse, 0.03);
    EXPECT_EQ(changeOf(comparison, "gone").change, "removed");
    EXPECT_FALSE(changeOf(comparison, "gone").now.has_value());
    EXPECT_EQ(changeOf(comparison, "new").change, "added");
    EXPECT_FALSE(changeOf(comparison, "new").growthPercent.has_value());
    EXPECT_EQ(comparison.bytesBefore, 1600u);
    EXPECT_EQ(comparison.bytesNow, 1750u);
    EXPECT_NEAR(comparison.growthPercent, 9.375, 1e-9);
    EXPECT_TRUE(comparison.passed) << "nothing was forbidden";
}

TEST(Baseline, FailsAtMoreGrowthThanAllowed) {
    const Report before = reportOf({rowOf("hall", 1000, 0.01)}), now = reportOf({rowOf("hall", 1020, 0.01)});
    EXPECT_TRUE(compareWithBaseline(now, before, "", {2.0, {}}).passed);
    EXPECT_FALSE(compareWithBaseline(now, before, "", {1.9, {}}).passed);
    EXPECT_FALSE(compareWithBaseline(now, before, "", {0.0, {}}).passed);
    EXPECT_TRUE(compareWithBaseline(before, now, "", {0.0, {}}).passed);
    EXPECT_FALSE(compareWithBaseline(now, reportOf({}), "", {99.0, {}}).passed) << "something where nothing was grew by 100 %";
}

TEST(Baseline, FailsAtMoreGrowthOfAnErrorThanAllowed) {
    const Report before = reportOf({rowOf("hall", 1000, 0.01)}), now = reportOf({rowOf("hall", 900, 0.0105)});
    EXPECT_TRUE(compareWithBaseline(now, before, "", {0.0, {}}).passed);
    EXPECT_TRUE(compareWithBaseline(now, before, "", {0.0, 6.0}).passed);
    const BaselineComparison grown = compareWithBaseline(now, before, "", {{}, 4.0});
    EXPECT_FALSE(grown.passed);
    EXPECT_EQ(jsonOf(grown).at("allowed_error_percent"), 4.0);
    EXPECT_THAT(grownErrors(grown.assets[0], 4),
                testing::ElementsAre("rel_rms of diffuse light 1.05 %, 5 % more than the baseline's 1.00 %",
                                     "rel_rms of specular light 1.05 %, 5 % more than the baseline's 1.00 %"));
    EXPECT_TRUE(compareWithBaseline(before, now, "", {{}, 0.0}).passed);
}

/// An asset without specular light has no error of it: a dash on the page, nothing in the line.
TEST(Baseline, ShowsNoErrorOfLightThatAnAssetDoesNotHave) {
    const auto diffuseOnly = [](double error) {
        ReportRow row = rowOf("flat", 1000, error);
        row.verdict.stages.back().specular.relRms = 0;
        row.verdict.stages.back().diffuse.visible.emplace();
        row.verdict.stages.back().diffuse.visible->p99 = 100 * error;
        return reportOf({row});
    };
    Report now = diffuseOnly(0.02);
    now.baseline = compareWithBaseline(now, diffuseOnly(0.01), "old/report.json", {});
    const AssetChange& change = changeOf(*now.baseline, "flat");
    EXPECT_EQ(change.now->diffuse, 0.02);
    EXPECT_EQ(change.now->specular, std::nullopt);
    EXPECT_TRUE(errorGrew(change));
    EXPECT_TRUE(jsonOf(change).at("now").at("specular_rel_rms").is_null());
    const auto read = fromJson<Report>(toJson(now), "report.json");
    ASSERT_TRUE(read && read->baseline);
    EXPECT_EQ(jsonOf(*read->baseline), jsonOf(*now.baseline));
    Terminal terminal(TerminalOptions{LogFormat::Text, Verbosity::Normal, ColorChoice::Never});
    testing::internal::CaptureStdout();
    printComparison(terminal, *now.baseline);
    EXPECT_THAT(testing::internal::GetCapturedStdout(), HasSubstr("(+0.00 %), diffuse 1.000 % -> 2.000 %, visible 1.000 -> 2.000\n"));
}

/// Reports of several scenes that older versions wrote have an error of 0 there.
TEST(Baseline, TakesAnOlderErrorOfZeroForNone) {
    ReportRow row = rowOf("flat", 1000, 0.01);
    row.verdict.stages.back().specular.relRms = 0;
    AssetFigures now = figuresOf(row), before = now;
    before.specular = 0;
    EXPECT_EQ(compareAssets({{"flat", before}}, {{"flat", now}}).at(0).change, "same");
}

TEST(Baseline, IsInTheReport) {
    Report now = reportOf({rowOf("hall", 1200, 0.012)});
    now.baseline = compareWithBaseline(now, reportOf({rowOf("hall", 1000, 0.01)}), "old/report.json", {5.0, {}});
    const Json json = toJson(now);
    EXPECT_EQ(json.at("baseline").at("assets")[0].at("before").at("bytes_gpu"), 1000);
    const auto read = fromJson<Report>(json, "report.json");
    ASSERT_TRUE(read && read->baseline);
    EXPECT_EQ(jsonOf(*read->baseline), json.at("baseline"));
}

}  // namespace
}  // namespace lightcook::pipeline

// Previews: what they leave in the folder, and that nothing takes them for a release.
#include "pipeline/cook/preview.h"

#include <gmock/gmock.h>

#include "pipeline/cook/cook.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/report/report.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class PreviewOfAScene : public testing::Test {
protected:
    CookOptions options(bool preview) const {
        CookOptions options = scene_.options();
        options.preview = preview;
        return options;
    }
    PreviewSummary preview() const {
        const Outcome outcome = cook(options(true));
        for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
        auto summary = fromJson<PreviewSummary>(outcome.report, "preview");
        EXPECT_TRUE(summary);
        return summary.value_or(PreviewSummary{});
    }
    Manifest manifest() const {
        auto manifest = loadManifest(scene_ / "out");
        EXPECT_TRUE(manifest) << manifest.error().line();
        return manifest.value_or(Manifest{});
    }
    Outcome verified() const {
        const RunState state;
        return verifyCooked({scene_ / "out", {}, {}, false}, state);
    }

    const SmallScene scene_{SmallScene::Parts::LightMap};
};

TEST_F(PreviewOfAScene, IsMarkedAndRefusedByVerifyUntilTheSceneIsCooked) {
    const PreviewSummary summary = preview();
    ASSERT_EQ(summary.lightMaps.size(), 1u);
    EXPECT_EQ(summary.lightMaps[0].layout, "ratio");
    EXPECT_TRUE(manifest().isPreview);
    EXPECT_FALSE(fs::exists(scene_ / "out" / kReportName));
    const Outcome refused = verified();
    ASSERT_EQ(refused.errors.size(), 1u);
    EXPECT_EQ(refused.errors[0].code, formats::ErrorCode::Verification);
    EXPECT_THAT(refused.errors[0].line(), HasSubstr("found a preview, which has no certificate"));

    ASSERT_TRUE(cook(options(false)).errors.empty());
    EXPECT_FALSE(manifest().isPreview);
    EXPECT_TRUE(verified().errors.empty());
}

TEST_F(PreviewOfAScene, TakesTheLayoutsOfTheLastCookAndRemovesItsReport) {
    scene_.writeSceneFile("max_visible = 30");
    const Outcome cooked = cook(options(false));
    ASSERT_TRUE(cooked.errors.empty());
    const std::string layout = manifest().assets.at(0).layout;
    ASSERT_NE(layout, "hdr") << "that of a preview without a cook before";
    const auto report = loadReport(scene_ / "out" / kReportName);
    ASSERT_TRUE(report);
    const std::vector<std::string> pictures = picturesOf(report->assets);
    ASSERT_FALSE(pictures.empty());

    for (int i = 0; i < 2; ++i) EXPECT_EQ(preview().lightMaps.at(0).layout, layout) << "also of a preview after a preview";
    for (const char* name : {kReportName, kReportHtmlName}) EXPECT_FALSE(fs::exists(scene_ / "out" / name)) << name;
    for (const std::string& picture : pictures) EXPECT_FALSE(fs::exists(scene_ / "out" / picture)) << picture;
}

TEST_F(PreviewOfAScene, HasAFastLayoutThatTheEngineReads) {
    scene_.writeSceneFile("");
    EXPECT_EQ(preview().lightMaps.at(0).layout, "hdr");
    // The layout of the last preview is not one of the list.
    scene_.writeSceneFile("layouts = [\"sh4\", \"godot\"]");
    EXPECT_EQ(preview().lightMaps.at(0).layout, "sh4");
}

TEST_F(PreviewOfAScene, IsHeldToNoLimit) {
    scene_.writeSceneFile("light_map_layout = \"sh4\"\nmax_error = 0.000001\nbudget = \"16\"");
    EXPECT_GT(preview().lightMaps.at(0).errors.total.diffuse.relRms, 0.000001);
}

TEST_F(PreviewOfAScene, MeasuresAsVerificationDoesWhereItComparesAllRows) {
    const PreviewSummary summary = preview();
    const SampledErrors& sampled = summary.lightMaps.at(0).errors;
    ASSERT_EQ(sampled.rows, sampled.rowsOfMap) << "a small map";
    CookOptions full = options(false);
    full.given.set("output.effort", "0", "--effort");
    const Outcome cooked = cook(full);
    ASSERT_TRUE(cooked.errors.empty());
    const auto report = fromJson<Report>(cooked.report, kReportName);
    ASSERT_TRUE(report);
    const verify::StageError& total = report->assets.at(0).verdict.stages.back();
    EXPECT_EQ(sampled.total.diffuse.relRms, total.diffuse.relRms);
    EXPECT_EQ(sampled.total.specular.relRms, total.specular.relRms);
    EXPECT_EQ(visibleP99(sampled.total), visibleP99(total));
    EXPECT_FALSE(sampled.total.diffuse.maxBound) << "nothing is bounded";
}

TEST_F(PreviewOfAScene, NoAssetOfAReleaseComesBesideIt) {
    preview();
    CookOptions one = options(false);
    one.only = "map";
    const Outcome outcome = cook(one);
    ASSERT_EQ(outcome.errors.size(), 1u);
    EXPECT_EQ(outcome.errors[0].code, formats::ErrorCode::InvalidRequest);
    EXPECT_THAT(outcome.errors[0].line(), HasSubstr("found a preview"));
}

}  // namespace
}  // namespace lightcook::pipeline

#include "pipeline/cook/chart_settings.h"

#include <gmock/gmock.h>

#include "pipeline/cook/cook.h"
#include "tests/formats/temporary_folder.h"
#include "tests/pipeline/scene_with_one_map.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using testing::HasSubstr;

std::string mistakeIn(const Scene& scene) {
    const auto checked = checkCharts(scene);
    if (checked) return "";
    EXPECT_EQ(checked.error().code, ErrorCode::InvalidRequest);
    return checked.error().line();
}

/// A scene that splits its charts within a limit.
Scene splitScene() {
    Scene scene = sceneWithOneMap();
    scene.output.lightMapLayout.clear();
    scene.lightMaps[0].mesh = "map.glb";
    scene.output.charts.mode = ChartMode::Split;
    scene.output.limits[Limit::Error] = 0.05;
    return scene;
}

TEST(CheckCharts, TakesChartsThatFitTheScene) {
    EXPECT_EQ(mistakeIn(sceneWithOneMap()), "");
    Scene scene = splitScene();
    EXPECT_EQ(mistakeIn(scene), "");
    scene.output.charts.maxVisible = 1;
    EXPECT_EQ(mistakeIn(scene), "");
}

TEST(CheckCharts, NamesTheLightMapWhoseChartsDoNotFit) {
    Scene scene = splitScene();
    scene.output.lightMapLayout = "ratio";
    EXPECT_THAT(mistakeIn(scene), HasSubstr("light map 'map': found charts to split without a limit"));
    scene = splitScene();
    scene.lightMaps[0].mesh.reset();
    EXPECT_THAT(mistakeIn(scene), HasSubstr("light map 'map': found charts to pack without a mesh"));
    scene = splitScene();
    scene.output.lightMapLayout = "rnm";
    EXPECT_THAT(mistakeIn(scene), HasSubstr("light map 'map': found charts to pack with a layout in tangent space"));
}

TEST(CheckCharts, RefusesALimitWhereNoChartsArePacked) {
    Scene scene = sceneWithOneMap();
    scene.output.charts.maxVisible = 1;
    EXPECT_THAT(mistakeIn(scene), HasSubstr("found charts_max_visible where no charts are packed"));
    scene = splitScene();
    scene.lightMaps[0].charts = {.mode = ChartMode::Keep, .maxVisible = 1};
    EXPECT_THAT(mistakeIn(scene), HasSubstr("found charts_max_visible where no charts are packed"));
}

/// A scene that lint lets pass is not refused by the cook for its settings.
TEST(CheckCharts, LintRefusesWhatACookRefuses) {
    const formats::TemporaryFolder folder;
    Scene scene = sceneWithOneMap();
    scene.output.charts.maxVisible = 1;
    LintOptions options;
    options.cache = folder / "cache";
    const Outcome outcome = lintScene(scene, options, RunState());
    ASSERT_EQ(outcome.errors.size(), 1u);
    EXPECT_EQ(outcome.errors[0].code, ErrorCode::InvalidRequest);
    EXPECT_THAT(outcome.errors[0].line(), HasSubstr("found charts_max_visible where no charts are packed"));
}

}  // namespace
}  // namespace lightcook::pipeline

// Lists of the layouts that an engine reads, and the choice of a layout among them.
#include <gmock/gmock.h>

#include <algorithm>
#include <set>

#include "formats/light_map_layout.h"
#include "pipeline/cook/cook.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class LayoutLists : public testing::Test {
protected:
    Outcome cook(const std::string& output, const std::string& materials = "") const {
        scene_.writeSceneFile(output, materials);
        return cookScene(scene_.options(), RunState());
    }
    /// Cooks with lines for the light map.
    Outcome cookMap(const std::string& output, const std::string& lightMap) const {
        scene_.writeSceneFile(output);
        std::string text = formats::contentOf(scene_.sceneFile());
        const std::string file = "file = \"map.exr\"\n";
        formats::writeContent(scene_.sceneFile(), text.replace(text.find(file), file.size(), file + lightMap + "\n"));
        return cookScene(scene_.options(), RunState());
    }
    static const Json& mapOf(const Outcome& outcome) {
        EXPECT_FALSE(outcome.report.is_null()) << (outcome.errors.empty() ? "" : outcome.errors.front().line());
        return outcome.report.at("assets").at(0);
    }
    static std::set<std::string> candidatesOf(const Outcome& outcome, bool isExcluded) {
        std::set<std::string> layouts;
        for (const Json& each : mapOf(outcome).at("trial_candidates"))
            if (each.contains("excluded") == isExcluded) layouts.insert(each.at("layout").get<std::string>());
        return layouts;
    }
    static void expectRefused(const Outcome& outcome, const testing::Matcher<std::string>& words) {
        ASSERT_EQ(outcome.errors.size(), 1u);
        EXPECT_EQ(outcome.errors.front().code, formats::ErrorCode::InvalidRequest);
        EXPECT_THAT(outcome.errors.front().line(), words);
    }

    SmallScene scene_{SmallScene::Parts::LightMap};
};

TEST_F(LayoutLists, AutoTakesTheBestOfTheListAndTheReportSaysWhatTheListCosts) {
    const Outcome outcome = cook("layouts = [\"godot\", \"sh4\", \"ratio\"]\nmax_error = 0.9");
    const Json& map = mapOf(outcome);
    EXPECT_EQ(candidatesOf(outcome, false), (std::set<std::string>{"godot", "sh4", "ratio"}));
    EXPECT_TRUE(candidatesOf(outcome, true).contains("basis-3"));
    EXPECT_FALSE(candidatesOf(outcome, true).contains("bakery")) << "auto never takes it without a list";
    EXPECT_THAT(map.at("layout").get<std::string>(), testing::AnyOf("godot", "sh4")) << "the smallest within the limit";
    const Json& lifted = map.at("better_excluded");
    const Json& candidates = map.at("trial_candidates");
    const auto bytesOf = [&](const std::string& layout) {
        return std::ranges::find_if(candidates, [&](const Json& each) { return each.at("layout") == layout; })->at("bytes_gpu").get<int>();
    };
    EXPECT_EQ(lifted.at("bytes_saved").get<int>(), bytesOf(map.at("layout")) - bytesOf(lifted.at("layout")));
    EXPECT_GT(lifted.at("bytes_saved").get<int>(), 0);
    for (const Json& each : candidates)
        if (each.contains("excluded") && std::max(each.at("diffuse").get<double>(), each.at("specular").get<double>()) <= 0.9) {
            EXPECT_GE(each.at("bytes_gpu").get<int>(), bytesOf(lifted.at("layout"))) << each.dump();
        }
}

TEST_F(LayoutLists, AListAloneAsksForAutoUnderTheDefaultLimit) {
    const Outcome outcome = cook("layouts = [\"ratio\", \"hdr-2\"]");
    EXPECT_EQ(candidatesOf(outcome, false), (std::set<std::string>{"ratio", "hdr-2"}));
    EXPECT_EQ(mapOf(outcome).at("limit").at("max_visible"), 5);
}

TEST_F(LayoutLists, NoLayoutOutsideTheListStandsInForOthers) {
    const std::string noDirections = "[[material]]\nname = \"*\"\nnormal_map = false\nspecular = false\n";
    EXPECT_EQ(mapOf(cook("layouts = [\"godot\"]\nmax_error = 0.9", noDirections)).at("layout"), "godot");
    EXPECT_EQ(mapOf(cook("layouts = [\"godot\", \"flat\"]\nmax_error = 0.9", noDirections)).at("layout"), "flat");
    const SmallScene constant(SmallScene::Parts::LightMap, grey);
    constant.writeSceneFile("layouts = [\"godot\"]\nmax_error = 0.9");
    const Outcome outcome = cookScene(constant.options(), RunState());
    EXPECT_EQ(mapOf(outcome).at("layout"), "godot") << "without the list it is one block of raw";
    EXPECT_EQ(mapOf(outcome).at("bytes_gpu").get<int>(), 4 * 16) << "four slices of one block";
}

TEST_F(LayoutLists, ALightMapHasAListOfItsOwn) {
    const Outcome outcome = cookMap("layouts = [\"ratio\"]\nmax_error = 0.9", "layouts = [\"sh4\"]");
    EXPECT_EQ(candidatesOf(outcome, false), (std::set<std::string>{"sh4"}));
    EXPECT_EQ(mapOf(outcome).at("layout"), "sh4");
}

TEST_F(LayoutLists, MistakesAreRefused) {
    expectRefused(cook("layouts = [\"godod\"]"), AllOf(HasSubstr("'godod'"), HasSubstr("nearest is 'godot'")));
    expectRefused(cook("layouts = []"), HasSubstr("found an empty list of layouts"));
    expectRefused(cook("layouts = [\"sh4\", \"sh4\"]"), HasSubstr("'sh4' twice"));
    expectRefused(cook("layouts = \"sh4\""), HasSubstr("expected a list of light-map layouts"));
    expectRefused(cook("layouts = [4]"), HasSubstr("no string"));
    expectRefused(cook("layouts = [\"auto\"]"), HasSubstr("'auto'"));
    expectRefused(cook("layouts = [\"sh4\"]\nlight_map_layout = \"ratio\""),
                  HasSubstr("found layout ratio that the list of layouts (sh4) lacks"));
    expectRefused(cook("layouts = [\"ratio\"]\nmax_fetches = 4"), HasSubstr("expected those of one of ratio (9 fetches"));
    expectRefused(cookMap("light_map_layout = \"ratio\"", "layouts = [\"sh4\"]"),
                  HasSubstr("without layout ratio, which the scene asks for"));
    expectRefused(cookMap("max_error = 0.9\nmax_fetches = 2", "layouts = [\"sh4\"]"), HasSubstr("expected those of one of sh4"));
    scene_.writeSceneFile("layouts = [\"sh4\"]");
    CookOptions options = scene_.options();
    options.given.set("output.light_map_layout", "ratio", "--layout");
    expectRefused(cookScene(options, RunState()), HasSubstr("--layout: found layout ratio that the list"));
}

}  // namespace
}  // namespace lightcook::pipeline

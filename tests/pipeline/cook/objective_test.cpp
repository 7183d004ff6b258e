// Learned layouts of light maps and ratio minimize visible errors by default, and energy if the scene or the command line asks for it.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "pipeline/cook/cook.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

using testing::HasSubstr;

class Objective : public testing::Test {
protected:
    Outcome cook(const std::string& output) const {
        scene_.writeSceneFile(output);
        return cookScene(scene_.optionsWithSharedCache(), RunState());
    }
    static const Json& mapOf(const Outcome& outcome) { return outcome.report.at("assets").at(0); }
    static Json diffuseOf(const Outcome& outcome) { return mapOf(outcome).at("stages").back().at("error").at("diffuse"); }

    SmallScene scene_{SmallScene::Parts::LightMap};
};

TEST_F(Objective, VisibleErrorsAreSmallerWhereTheyAreMinimized) {
    const std::string layout = "light_map_layout = \"basis-3\"\nmax_error = 0.9\n";
    const Json visible = diffuseOf(cook(layout)), energy = diffuseOf(cook(layout + "objective = \"energy\""));
    EXPECT_LT(visible.at("visible").at("rms").get<double>(), energy.at("visible").at("rms").get<double>());
    EXPECT_LT(visible.at("visible").at("p99").get<double>(), energy.at("visible").at("p99").get<double>());
}

TEST_F(Objective, OfTheCommandLineOverridesThatOfTheScene) {
    scene_.writeSceneFile("light_map_layout = \"basis-3\"\nmax_error = 0.9\nobjective = \"energy\"");
    CookOptions options = scene_.optionsWithSharedCache();
    const Json asked = diffuseOf(cookScene(options, RunState()));
    options.objective = formats::Objective::Visible;
    const Json overridden = diffuseOf(cookScene(options, RunState()));
    EXPECT_NE(asked.at("rel_rms"), overridden.at("rel_rms"));
}

/// Half of the map is in the shadow of the sun.
glm::vec3 halfInShadow(const glm::dvec3& direction, const glm::dvec2& place) {
    return place.x < 0.5 ? glm::vec3(0.01f) * static_cast<float>(1 + direction.x) : sunAndSky(direction, place);
}

TEST(ObjectiveOfRatio, IsThePlacesBetweenTexelsAtEdgesOfLight) {
    const SmallScene scene(SmallScene::Parts::LightMap, halfInShadow);
    const auto visibleOf = [&](const std::string& objective) {
        scene.writeSceneFile("light_map_layout = \"ratio\"\nmax_error = 0.9\nobjective = \"" + objective + "\"");
        const Outcome outcome = cookScene(scene.optionsWithSharedCache(), RunState());
        return outcome.report.at("assets").at(0).at("stages").back().at("error").at("diffuse").at("visible").at("rms").get<double>();
    };
    EXPECT_LT(visibleOf("visible"), 0.9 * visibleOf("energy"));
}

TEST_F(Objective, IsRefusedBesideLayoutsThatMinimizeNothing) {
    const auto mistakeOf = [](const Outcome& outcome) {
        EXPECT_EQ(outcome.errors.size(), 1u);
        return outcome.errors.empty() ? "" : outcome.errors.front().line();
    };
    for (const char* layout : {"raw", "hdr"}) {
        const std::string named = fmt::format("light_map_layout = \"{}\"\n", layout);
        EXPECT_THAT(mistakeOf(cook(named + "objective = \"energy\"")),
                    HasSubstr(fmt::format("found an objective beside layout {}, which minimizes nothing, expected layout ratio", layout)));
        scene_.writeSceneFile(named);
        CookOptions options = scene_.optionsWithSharedCache();
        options.objective = formats::Objective::Energy;
        EXPECT_THAT(mistakeOf(cookScene(options, RunState())), HasSubstr("--objective: found an objective beside layout"));
    }
    EXPECT_THAT(mistakeOf(cook("layouts = [\"sh4\", \"hdr\"]\nobjective = \"energy\"")),
                HasSubstr("found an objective beside a list of layouts that minimize nothing"));
}

TEST_F(Objective, OfTheSceneFileMayBeOfAnotherLayoutThanTheCommandLine) {
    scene_.writeSceneFile("light_map_layout = \"ratio\"\nmax_error = 0.9\nobjective = \"energy\"");
    CookOptions options = scene_.optionsWithSharedCache();
    options.lightMapLayout = "hdr";
    EXPECT_TRUE(cookScene(options, RunState()).errors.empty());
}

TEST_F(Objective, AnUnknownOneIsRefusedByName) {
    const Outcome outcome = cook("objective = \"seen\"");
    ASSERT_EQ(outcome.errors.size(), 1u);
    EXPECT_NE(outcome.errors.front().line().find("'seen'"), std::string::npos) << outcome.errors.front().line();
    EXPECT_NE(outcome.errors.front().line().find("visible, energy"), std::string::npos) << outcome.errors.front().line();
}

}  // namespace
}  // namespace lightcook::pipeline

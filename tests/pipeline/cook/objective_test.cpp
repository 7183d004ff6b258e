// Learned layouts of light maps and ratio minimize visible errors by default, and energy if the scene or the command line asks for it.
#include <gtest/gtest.h>

#include "pipeline/cook/cook.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

class Objective : public testing::Test {
protected:
    Outcome cook(const std::string& output) const {
        scene_.writeSceneFile(output);
        return cookScene(scene_.options(), RunState());
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
    CookOptions options = scene_.options();
    const Json asked = diffuseOf(cookScene(options, RunState()));
    options.given.set("output.objective", "visible");
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
        scene.writeSceneFile("light_map_layout = \"ratio\"\nfilter = \"hardware\"\nmax_error = 0.9\nobjective = \"" + objective + "\"");
        const Outcome outcome = cookScene(scene.options(), RunState());
        return outcome.report.at("assets").at(0).at("stages").back().at("error").at("diffuse").at("visible").at("rms").get<double>();
    };
    EXPECT_LT(visibleOf("visible"), 0.9 * visibleOf("energy"));
}

TEST_F(Objective, DoesNotChangeOtherLayouts) {
    const Outcome first = cook("light_map_layout = \"hdr\"");
    const Outcome second = cook("light_map_layout = \"hdr\"\nobjective = \"energy\"");
    EXPECT_EQ(diffuseOf(first), diffuseOf(second));
}

TEST_F(Objective, AnUnknownOneIsRefusedByName) {
    const Outcome outcome = cook("objective = \"seen\"");
    ASSERT_EQ(outcome.errors.size(), 1u);
    EXPECT_NE(outcome.errors.front().line().find("'seen'"), std::string::npos) << outcome.errors.front().line();
    EXPECT_NE(outcome.errors.front().line().find("visible, energy"), std::string::npos) << outcome.errors.front().line();
}

}  // namespace
}  // namespace lightcook::pipeline

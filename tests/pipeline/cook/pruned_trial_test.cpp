// Trials that measure no more layouts, and no more of a map, than their choice needs.
#include <gmock/gmock.h>

#include <algorithm>
#include <set>

#include "formats/light_map_layout.h"
#include "pipeline/cook/cook.h"
#include "pipeline/manifest/manifest.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

using testing::Contains;
using testing::Not;

/// A light map of enough rows for two levels of a trial.
class PrunedTrial : public testing::Test {
protected:
    static constexpr int kRows = 288;

    static Outcome cook(const SmallScene& scene, const std::string& output, bool keepCandidates = false) {
        scene.writeSceneFile(output);
        CookOptions options = scene.options();
        options.keepCandidates = keepCandidates;
        Outcome outcome = cookScene(options, RunState());
        for (const formats::Error& error : outcome.errors) ADD_FAILURE() << output << ": " << error.line();
        return outcome;
    }
    Outcome cook(const std::string& output, bool keepCandidates = false) const { return cook(scene_, output, keepCandidates); }
    static const Json& mapOf(const Outcome& outcome) { return outcome.report.at("assets").at(0); }
    static std::string layoutOf(const Outcome& outcome) { return mapOf(outcome).at("layout").get<std::string>(); }
    static double visibleOf(const Json& candidate) {
        return std::max(candidate.at("visible_diffuse").get<double>(), candidate.at("visible_specular").get<double>());
    }
    static std::set<std::string> triedIn(const Outcome& outcome) {
        std::set<std::string> layouts;
        for (const Json& each : mapOf(outcome).at("trial_candidates")) layouts.insert(each.at("layout").get<std::string>());
        return layouts;
    }

    SmallScene scene_{SmallScene::Parts::LightMap, sunAndSky, kRows};
};

TEST_F(PrunedTrial, ChoosesTheSmallestThatAllOfTheMapShowsWithinTheLimit) {
    const Outcome complete = cook("max_visible = 1\ndetail = false", true);
    EXPECT_EQ(mapOf(complete).at("trial_share"), 1.0);
    const Json all = mapOf(complete).at("trial_candidates");
    bool isAnySampled = false;
    for (const double limit : {0.2, 0.5, 1.0, 2.0, 5.0, 20.0}) {
        const Outcome outcome = cook(fmt::format("max_visible = {}\ndetail = false", limit));
        const auto expected = std::ranges::find_if(all, [&](const Json& each) { return visibleOf(each) <= limit; });  // by bytes
        ASSERT_NE(expected, all.end());
        EXPECT_EQ(layoutOf(outcome), expected->at("layout")) << limit;
        isAnySampled = isAnySampled || mapOf(outcome).at("trial_share") < 1.0;
    }
    EXPECT_TRUE(isAnySampled);
}

TEST_F(PrunedTrial, LeavesOutWhatCostsMoreAndWhatIsCoarserThanALayoutOverTheLimit) {
    const std::set<std::string> loose = triedIn(cook("max_visible = 100")), strict = triedIn(cook("max_visible = 0.2"));
    EXPECT_THAT(loose, Contains("basis-3"));
    EXPECT_THAT(loose, Contains("basis-8")) << "the report says what less error costs";
    EXPECT_THAT(loose, Not(Contains("raw")));
    EXPECT_THAT(strict, Contains("basis-4"));
    EXPECT_THAT(strict, Not(Contains("basis-3"))) << "basis-4 misses the limit";
}

using PrunedTrialSoak = PrunedTrial;
/// Its trial ends at basis-3. Only verification knows bounds, and refutes what it chose.
TEST_F(PrunedTrialSoak, IsCompletedWhereVerificationRefutesAllThatItMeasured) {
    const double bound = [&] {
        const Outcome fine = cook("light_map_layout = \"raw\"\nfilter = \"decoded\"");  // as under the limit
        double largest = 0;
        for (const char* shading : {"diffuse", "specular"})
            largest = std::max(largest, mapOf(fine).at("stages").back().at("error").at(shading).at("visible").at("bound").get<double>());
        return largest;
    }();
    const Outcome outcome = cook(fmt::format("max_visible = 100\nmax_visible_bound = {}", 1.01 * bound));
    EXPECT_EQ(layoutOf(outcome), "raw");
    EXPECT_THAT(triedIn(outcome), Contains("raw"));
}

TEST_F(PrunedTrial, LearnsWhatACookWithoutATrialLearns) {
    const SmallScene named{SmallScene::Parts::LightMap, sunAndSky, kRows};
    scene_.writeSceneFile("layouts = [\"basis-8\", \"basis-24\"]\nmax_visible = 100");
    named.writeSceneFile("light_map_layout = \"basis-8\"");
    ASSERT_TRUE(cookScene(scene_.optionsWithOwnCache(), RunState()).errors.empty());
    ASSERT_TRUE(cookScene(named.optionsWithOwnCache(), RunState()).errors.empty());
    const auto manifest = loadManifest(scene_ / "out");
    ASSERT_TRUE(manifest.has_value());
    ASSERT_EQ(manifest->assets.at(0).layout, "basis-8");
    for (const CookedTexture& texture : manifest->assets.at(0).textures)
        EXPECT_EQ(formats::contentOf(scene_ / "out" / texture.file), formats::contentOf(named / "out" / texture.file)) << texture.file;
}

/// A picture has no directions: what stores them costs more and shows no less error.
TEST_F(PrunedTrial, OfALightWithoutDirectionsEndsAtFlat) {
    const SmallScene flat(
        SmallScene::Parts::LightMap, [](const glm::dvec3&, const glm::dvec2& place) { return glm::vec3(1 + place.x); }, kRows);
    const std::string noDirections = "[[material]]\nname = \"*\"\nnormal_map = false\nspecular = false\n";
    flat.writeSceneFile("", noDirections);
    const Outcome outcome = cookScene(flat.options(), RunState());
    EXPECT_EQ(layoutOf(outcome), "flat");
    EXPECT_EQ(triedIn(outcome), (std::set<std::string>{"flat", "flat-2"}));
}

}  // namespace
}  // namespace lightcook::pipeline

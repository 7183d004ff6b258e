// Layouts chosen by an error. allocation_test.cpp has those that a budget chooses.
#include <gtest/gtest.h>

#include <algorithm>

#include "pipeline/cook/cook.h"
#include "tests/pipeline/report_parts.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

using Parts = SmallScene::Parts;

double errorOf(const Json& candidate) {
    return std::max(candidate.at("diffuse").get<double>(), candidate.at("specular").get<double>());
}

TEST(CookScene, ANamedErrorGetsTheSmallestLayoutThatKeepsIt) {
    const SmallScene scene(Parts::LightMap);
    for (const double maxError : {0.05, 0.01, 0.002}) {
        scene.writeSceneFile(fmt::format("max_error = {}", maxError));
        const Outcome outcome = cook(scene.options());
        ASSERT_TRUE(outcome.errors.empty()) << outcome.errors.front().line();
        const Json& row = assetOf(outcome.report, "map");
        EXPECT_TRUE(row.at("passed").get<bool>());
        std::uint64_t smallest = ~std::uint64_t{0};
        for (const Json& candidate : row.at("trial_candidates")) {
            if (errorOf(candidate) <= maxError) smallest = std::min(smallest, candidate.at("bytes_gpu").get<std::uint64_t>());
            if (candidate.at("layout") != row.at("layout")) continue;
            // The trial shaded what the verifier shades, so their figures are the same.
            EXPECT_EQ(candidate.at("diffuse"), row.at("stages").back().at("error").at("diffuse").at("rel_rms"));
            EXPECT_EQ(candidate.at("specular"), row.at("stages").back().at("error").at("specular").at("rel_rms"));
        }
        EXPECT_EQ(row.at("bytes_gpu").get<std::uint64_t>(), smallest);
        EXPECT_EQ(row.at("trial_share"), 1.0);
        EXPECT_EQ(cook(scene.options()).actionsRun, 0) << "the trial is kept too";
    }
}

TEST(CookScene, AnErrorThatNoLayoutKeepsFailsWithTheBestOne) {
    const SmallScene scene(Parts::LightMap);
    scene.writeSceneFile("max_error = 1e-9");
    const Outcome outcome = cook(scene.options());
    ASSERT_FALSE(outcome.errors.empty());
    EXPECT_EQ(outcome.errors.front().code, formats::ErrorCode::Verification);
    EXPECT_EQ(assetOf(outcome.report, "map").at("layout"), "raw");
}

TEST(CookScene, ANamedLayoutIsNotTried) {
    const SmallScene scene(Parts::LightMap);
    scene.writeSceneFile("max_error = 0.05\nlight_map_layout = \"luvw\"");
    const Outcome named = cook(scene.options());
    EXPECT_EQ(assetOf(named.report, "map").at("layout"), "luvw");
    EXPECT_FALSE(assetOf(named.report, "map").contains("trial_candidates"));
    scene.writeSceneFile("");
    EXPECT_EQ(assetOf(cook(scene.options()).report, "map").at("layout"), "ratio") << "without an error or a budget named";
}

}  // namespace
}  // namespace lightcook::pipeline

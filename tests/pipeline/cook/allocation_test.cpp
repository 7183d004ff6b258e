// Naming the error or the bytes instead of the layout.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "pipeline/assets/light_map/planner.h"
#include "pipeline/cook/cook.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

using Parts = SmallScene::Parts;

Outcome cook(const CookOptions& options) {
    const RunState state;
    return cookScene(options, state);
}

LightMapCandidates randomCandidates(std::mt19937& random, int maps) {
    LightMapCandidates candidates;
    for (int map = 0; map < maps; ++map)
        for (int i = 0; i < 5; ++i)
            candidates["map" + std::to_string(map)].push_back(
                {"layout" + std::to_string(i), 100 + random() % 1000, static_cast<double>(1 + random() % 50) / 1000});
    return candidates;
}

struct Worth {
    double error = 0;
    std::uint64_t bytes = 0;
};
Worth worthOf(const LightMapCandidates& candidates, const std::map<std::string, std::string>& layouts) {
    Worth worth;
    for (const auto& [map, layout] : layouts) {
        const LightMapCandidate& chosen = *std::ranges::find(candidates.at(map), layout, &LightMapCandidate::layout);
        worth.error = std::max(worth.error, chosen.error);
        worth.bytes += chosen.bytes;
    }
    return worth;
}
/// Every combination of layouts.
std::vector<Worth> allWorths(const LightMapCandidates& candidates) {
    std::vector<Worth> worths = {{}};
    for (const auto& [map, each] : candidates) {
        std::vector<Worth> longer;
        for (const Worth& worth : worths)
            for (const LightMapCandidate& candidate : each)
                longer.push_back({std::max(worth.error, candidate.error), worth.bytes + candidate.bytes});
        worths = std::move(longer);
    }
    return worths;
}

TEST(Allocation, FindsWhatTryingEveryCombinationFinds) {
    std::mt19937 random(3);
    for (int round = 0; round < 200; ++round) {
        const LightMapCandidates candidates = randomCandidates(random, 1 + static_cast<int>(random() % 4));
        const std::vector<Worth> all = allWorths(candidates);
        const double maxError = static_cast<double>(random() % 60) / 1000;
        const std::uint64_t budget = 200 + random() % 4000;
        std::uint64_t fewestBytes = ~std::uint64_t{0};
        double leastError = 1e30;
        for (const Worth& worth : all) {
            if (worth.error <= maxError) fewestBytes = std::min(fewestBytes, worth.bytes);
            if (worth.bytes <= budget) leastError = std::min(leastError, worth.error);
        }
        const Worth small = worthOf(candidates, smallestWithin(candidates, maxError));
        if (fewestBytes != ~std::uint64_t{0}) {
            EXPECT_LE(small.error, maxError);
            EXPECT_EQ(small.bytes, fewestBytes);
        }
        const Worth good = worthOf(candidates, bestWithin(candidates, budget));
        if (leastError < 1e30) {
            EXPECT_LE(good.bytes, budget);
            EXPECT_EQ(good.error, leastError);
        } else {
            EXPECT_EQ(good.bytes, std::ranges::min_element(all, {}, &Worth::bytes)->bytes);
        }
    }
}

const Json& rowOf(const Outcome& outcome, const std::string& name) {
    for (const Json& row : outcome.report.at("assets"))
        if (row.at("name") == name) return row;
    throw std::runtime_error("no row " + name);
}
double errorOf(const Json& candidate) {
    return std::max(candidate.at("diffuse").get<double>(), candidate.at("specular").get<double>());
}

TEST(CookScene, ANamedErrorGetsTheSmallestLayoutThatKeepsIt) {
    const SmallScene scene(Parts::LightMap);
    for (const double maxError : {0.05, 0.01, 0.002}) {
        scene.writeSceneFile(fmt::format("max_error = {}", maxError));
        const Outcome outcome = cook(scene.options());
        ASSERT_TRUE(outcome.errors.empty()) << outcome.errors.front().line();
        const Json& row = rowOf(outcome, "map");
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
    EXPECT_EQ(rowOf(outcome, "map").at("layout"), "raw");
}

TEST(CookScene, ANamedBudgetGetsTheLeastErrorThatFitsIt) {
    const SmallScene scene(Parts::LightMap);
    scene.writeSceneFile("light_map_layout = \"raw\"");
    const Outcome raw = cook(scene.options());
    const std::uint64_t others =
        raw.report.at("budget").at("used_bytes").get<std::uint64_t>() - rowOf(raw, "map").at("bytes_gpu").get<std::uint64_t>();
    for (const std::uint64_t forMap : {8000u, 14000u, 30000u, 60000u}) {
        scene.writeSceneFile(fmt::format("budget = \"{}\"", others + forMap));
        const Outcome outcome = cook(scene.options());
        ASSERT_TRUE(outcome.errors.empty()) << outcome.errors.front().line();
        const Json& row = rowOf(outcome, "map");
        EXPECT_LE(row.at("bytes_gpu").get<std::uint64_t>(), forMap);
        double least = 1e30, chosen = 1e30;
        for (const Json& candidate : row.at("trial_candidates")) {
            if (candidate.at("bytes_gpu").get<std::uint64_t>() <= forMap) least = std::min(least, errorOf(candidate));
            if (candidate.at("layout") == row.at("layout")) chosen = errorOf(candidate);
        }
        EXPECT_EQ(chosen, least) << forMap;
    }
    scene.writeSceneFile(fmt::format("budget = \"{}\"", others + 100));
    const Outcome tight = cook(scene.options());
    ASSERT_FALSE(tight.errors.empty());
    EXPECT_EQ(tight.errors.back().code, formats::ErrorCode::OverBudget);
}

TEST(CookScene, ANamedLayoutIsNotTried) {
    const SmallScene scene(Parts::LightMap);
    scene.writeSceneFile("max_error = 0.05\nlight_map_layout = \"luvw\"");
    const Outcome named = cook(scene.options());
    EXPECT_EQ(rowOf(named, "map").at("layout"), "luvw");
    EXPECT_FALSE(rowOf(named, "map").contains("trial_candidates"));
    scene.writeSceneFile("");
    EXPECT_EQ(rowOf(cook(scene.options()), "map").at("layout"), "ratio") << "without an error or a budget named";
}

}  // namespace
}  // namespace lightcook::pipeline

// Limits on the decode of light maps, and the choice of the layout with the fewest fetches.
#include <gmock/gmock.h>

#include <algorithm>

#include "formats/light_map_layout.h"
#include "pipeline/cook/cook.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class DecodeCost : public testing::Test {
protected:
    Outcome cook(const std::string& output) const {
        scene_.writeSceneFile(output);
        return cookScene(scene_.options(), RunState());
    }
    static const Json& mapOf(const Outcome& outcome) { return outcome.report.at("assets").at(0); }
    /// Expects one error whose line holds the words.
    void expectRefused(const std::string& output, const testing::Matcher<std::string>& words) const {
        const Outcome outcome = cook(output);
        ASSERT_EQ(outcome.errors.size(), 1u) << output;
        EXPECT_EQ(outcome.errors.front().code, formats::ErrorCode::InvalidRequest) << output;
        EXPECT_THAT(outcome.errors.front().line(), words);
    }

    SmallScene scene_{SmallScene::Parts::LightMap};
};

TEST_F(DecodeCost, TapsTakesTheLayoutOfFewestFetchesWithinTheLimit) {
    const Outcome outcome = cook("max_visible = 1\ncost = \"taps\"");
    ASSERT_TRUE(outcome.errors.empty()) << outcome.errors.front().line();
    const Json& candidates = mapOf(outcome).at("trial_candidates");
    int fewest = 1 << 20, chosen = 0, smallest = 0;
    std::uint64_t leastBytes = ~std::uint64_t{0};
    for (const Json& each : candidates) {
        const int fetches = each.at("fetches").get<int>();
        const auto layout = formats::lightMapLayoutFromName(each.at("layout").get<std::string>());
        EXPECT_EQ(fetches, formats::info(*layout).fetchCount());
        EXPECT_EQ(each.at("decode_ops").get<int>(), formats::info(*layout).operations());
        EXPECT_EQ(each.at("table_bytes").get<std::uint64_t>() > 0, formats::info(*layout).isLearned()) << each.dump();
        if (each.at("layout") == mapOf(outcome).at("layout")) chosen = fetches;
        const double visible = std::max(each.at("visible_diffuse").get<double>(), each.at("visible_specular").get<double>());
        if (visible > 1 || std::max(each.at("diffuse").get<double>(), each.at("specular").get<double>()) > 0.1) continue;
        fewest = std::min(fewest, fetches);
        if (each.at("bytes_gpu").get<std::uint64_t>() < leastBytes) {
            leastBytes = each.at("bytes_gpu").get<std::uint64_t>();
            smallest = fetches;
        }
    }
    EXPECT_EQ(chosen, fewest);
    EXPECT_LE(fewest, smallest);
}

using DecodeCostSoak = DecodeCost;
/// A budget measures all layouts that it may take.
TEST_F(DecodeCostSoak, LayoutsOverALimitAreNotTried) {
    const auto layoutsOf = [](const Outcome& outcome) {
        std::vector<std::string> layouts;
        for (const Json& each : mapOf(outcome).at("trial_candidates")) layouts.push_back(each.at("layout"));
        return layouts;
    };
    const std::vector<std::string> byFetches = layoutsOf(cook("budget = \"1 MiB\"\nmax_fetches = 3"));
    EXPECT_THAT(byFetches, testing::UnorderedElementsAre("basis-3", "basis-4", "basis-8"));
    const std::vector<std::string> byOps = layoutsOf(cook("budget = \"1 MiB\"\nmax_decode_ops = 60"));
    EXPECT_FALSE(byOps.empty());
    for (const std::string& layout : byOps) EXPECT_LE(formats::info(*formats::lightMapLayoutFromName(layout)).decodeOps, 60) << layout;
}

TEST_F(DecodeCost, WhatNoLayoutKeepsOrNothingUsesIsRefused) {
    expectRefused("max_error = 0.9\nmax_fetches = 1", AllOf(HasSubstr("that no layout keeps"), HasSubstr("basis-4 (2 fetches")));
    expectRefused("light_map_layout = \"ratio\"\nmax_fetches = 4", HasSubstr("found layout ratio (9 fetches, "));
    scene_.writeSceneFile("max_error = 0.9\nmax_fetches = 4");
    CookOptions options = scene_.options();
    options.given.set("output.light_map_layout", "ratio", "--layout");
    const Outcome overridden = cookScene(options, RunState());
    ASSERT_EQ(overridden.errors.size(), 1u);
    EXPECT_THAT(overridden.errors.front().line(), HasSubstr("--layout: found layout ratio (9 fetches, "));
    expectRefused("light_map_layout = \"ratio\"\ncost = \"taps\"", HasSubstr("the layout is named"));
    expectRefused("budget = \"1 MiB\"\ncost = \"taps\"",
                  HasSubstr("a budget chooses the layouts, expected max_error or max_visible as well"));
    expectRefused("max_error = 0.9\nmax_fetches = 0", HasSubstr("found 0 for output.max_fetches"));
    expectRefused("max_error = 0.9\ncost = \"time\"", HasSubstr("bytes, taps"));
}

}  // namespace
}  // namespace lightcook::pipeline

#include "pipeline/assets/light_map/layout_choice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace lightcook::pipeline {
namespace {

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
        worth.error = std::max(worth.error, chosen.usedOfLimits);
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
                longer.push_back({std::max(worth.error, candidate.usedOfLimits), worth.bytes + candidate.bytes});
        worths = std::move(longer);
    }
    return worths;
}

TEST(LayoutChoice, FindsWhatTryingEveryCombinationFinds) {
    std::mt19937 random(3);
    for (int round = 0; round < 200; ++round) {
        const LightMapCandidates candidates = randomCandidates(random, 1 + static_cast<int>(random() % 4));
        const std::vector<Worth> all = allWorths(candidates);
        const double maxError = static_cast<double>(random() % 60) / 1000;
        std::uint64_t fewestBytes = ~std::uint64_t{0};
        for (const Worth& worth : all)
            if (worth.error <= maxError) fewestBytes = std::min(fewestBytes, worth.bytes);
        const Worth small = worthOf(candidates, cheapestWithin(candidates, maxError));
        if (fewestBytes != ~std::uint64_t{0}) {
            EXPECT_LE(small.error, maxError);
            EXPECT_EQ(small.bytes, fewestBytes);
        }
    }
}

/// Verification knows bounds, which no trial has: a layout that was never verified looks better than those that were.
TEST(LayoutChoice, WhereNoneFitsALayoutThatMissedTheLimitsOfTheTrialIsNotTaken) {
    const std::vector<LightMapCandidate> candidates = {
        {"coarse", 10, 1.6, 1, 1.6}, {"fine", 100, 150, 9, 0.8}, {"finest", 1000, 120, 9, 0.1}, {"coarsest", 5, 3, 1, 3}};
    EXPECT_EQ(cheapestWithin({{"map", candidates}}).at("map"), "finest");
    EXPECT_EQ(cheapestWithin({{"map", {candidates[0], candidates[3]}}}).at("map"), "coarse");
}

TEST(LayoutChoice, ALayoutWithoutAFiniteErrorIsNeverChosen) {
    const TrialResult trial{{{"small", 10, 1, HUGE_VAL, 0, 0, 0}, {"large", 1000, 64, 0.5, 0.1, 1, 1}}, 1};
    const std::vector<LightMapCandidate> candidates = candidatesOf(trial, {{Limit::Error, 1}});
    EXPECT_EQ(candidates[0].usedOfLimits, HUGE_VAL);
    EXPECT_EQ(candidates[1].usedOfLimits, 0.5);
    EXPECT_EQ(cheapestWithin({{"map", candidates}}, 0.01).at("map"), "large");
}

/// A layout keeps the limits only if both errors do; without a limit on visible errors they do not count.
TEST(LayoutChoice, TheLargerPartOfTheTwoLimitsCounts) {
    const TrialResult trial{
        {{"small", 10, 8, 0.01, 0.005, 9, 2}, {"middle", 20, 16, 0.008, 0.008, 1, 4}, {"large", 40, 32, 0.001, 0.03, 1, 1}}, 1};
    const auto chosen = [&](const Limits& limits) { return cheapestWithin({{"map", candidatesOf(trial, limits)}}).at("map"); };
    EXPECT_EQ(chosen({{Limit::Error, 0.02}}), "small");
    EXPECT_EQ(chosen({{Limit::Error, 0.02}, {Limit::Visible, 5}}), "middle");
    EXPECT_EQ(chosen({{Limit::Error, 0.05}, {Limit::Visible, 2}}), "large");
    EXPECT_EQ(chosen({{Limit::Error, 0.02}, {Limit::Visible, 2}}), "large") << "none keeps both: the one that is least over";
    EXPECT_DOUBLE_EQ(candidatesOf(trial, {{Limit::Error, 0.02}, {Limit::Visible, 5}})[0].usedOfLimits, 9.0 / 5);
    EXPECT_DOUBLE_EQ(candidatesOf(trial, {{Limit::Error, 0.02}, {Limit::Visible, 5}})[0].usedInTrial, 9.0 / 5);
    EXPECT_DOUBLE_EQ(candidatesOf(trial, {{Limit::Error, 0.02}, {Limit::Visible, 5}})[2].usedOfLimits, 1.5);
}

/// A limit on the bound of visible errors is not kept by a stage that has none, or has one for a part of its light alone.
TEST(LayoutChoice, AnUnknownBoundKeepsNoLimitOnIt) {
    VerifyResult verified;
    verify::StageError& stage = verified.verdict.stages.emplace_back();
    stage.diffuse.relRms = 0.01;
    stage.diffuse.visible = verify::VisibleFigures{};
    stage.specular.visible = verify::VisibleFigures{};
    const Limits limited{{Limit::Error, 0.1}, {Limit::VisibleBound, 4}};
    EXPECT_EQ(verifiedUse(verified, limited), HUGE_VAL);
    stage.diffuse.visible->bound = 1;
    EXPECT_EQ(verifiedUse(verified, limited), HUGE_VAL) << "specular light has none";
    EXPECT_DOUBLE_EQ(verifiedUse(verified, {{Limit::Error, 0.1}}), 0.1) << "without a limit it does not count";
    stage.specular.visible->bound = 2;
    EXPECT_DOUBLE_EQ(verifiedUse(verified, limited), 0.5);
}

/// What fails a verification keeps no limit: a mip level, the mix of two, a block that lost its light.
TEST(LayoutChoice, MipLevelsAndViolationsCount) {
    VerifyResult verified;
    verified.verdict.stages.emplace_back().diffuse.relRms = 0.01;
    verified.mips.emplace_back().specular.relRms = 0.02;
    EXPECT_DOUBLE_EQ(verifiedUse(verified, {{Limit::Error, 0.1}}), 0.2);
    verified.mipBlends.emplace_back().diffuse.relRms = 0.2;
    EXPECT_DOUBLE_EQ(verifiedUse(verified, {{Limit::Error, 0.1}}), 2);
    verified.verdict.violations.push_back({"block", "", ""});
    EXPECT_EQ(verifiedUse(verified, {{Limit::Error, 0.1}}), HUGE_VAL);
}

/// A layout is on the curve unless another has no more bytes and no more error.
TEST(LayoutChoice, TheCurveHasWhatNoOtherBeats) {
    std::mt19937 random(5);
    for (int round = 0; round < 200; ++round) {
        const std::vector<LightMapCandidate> candidates = randomCandidates(random, 1).at("map0");
        std::vector<std::string> expected;
        for (const LightMapCandidate& each : candidates)
            if (std::ranges::none_of(candidates, [&](const LightMapCandidate& other) {
                    return other.bytes <= each.bytes && other.usedOfLimits <= each.usedOfLimits &&
                           (other.bytes < each.bytes || other.usedOfLimits < each.usedOfLimits);
                }))
                expected.push_back(each.layout);
        std::vector<std::string> found = layoutsOfCurve(candidates);
        EXPECT_TRUE(std::ranges::is_sorted(found, {}, [&](const std::string& layout) {
            return std::ranges::find(candidates, layout, &LightMapCandidate::layout)->bytes;
        }));
        std::ranges::sort(found);
        EXPECT_EQ(found, expected);
    }
    EXPECT_TRUE(layoutsOfCurve({{"broken", 10, HUGE_VAL}}).empty());
}

}  // namespace
}  // namespace lightcook::pipeline

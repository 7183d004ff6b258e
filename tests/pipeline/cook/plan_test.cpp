#include "pipeline/cook/plan.h"
#include "pipeline/cook/action_functions.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "pipeline/assets/asset_kind.h"
#include "tests/pipeline/scene_with_one_map.h"

namespace lightcook::pipeline {
namespace {

bool hasAsset(const Plan& plan, const std::string& name) {
    return std::find(plan.assets.begin(), plan.assets.end(), name) != plan.assets.end();
}

TEST(PlanScene, WithoutSpecularThereIsNoDominantLightNoTableNoCubemap) {
    Scene scene = sceneWithOneMap();
    scene.materials = {{"*", true, false, std::nullopt, std::nullopt}};
    const auto plan = planScene(scene, resolveNeeds(scene, {}), {});
    ASSERT_TRUE(plan.has_value());
    EXPECT_EQ(plan->assets, (std::vector<std::string>{"map", "sky"}));
    EXPECT_EQ(plan->actions[0].parameters.at("layout"), "ratio") << "normal maps still need directions";
    EXPECT_EQ(plan->skipped.size(), 4u) << "dominant light, cubemap, specular rows of the gradient, tables";
    for (const Skip& skip : plan->skipped) EXPECT_FALSE(skip.why.empty());
}

TEST(PlanScene, WithoutNormalMapsAndSpecularTheLightMapIsFlat) {
    Scene scene = sceneWithOneMap();
    scene.materials = {{"*", false, false, std::nullopt, std::nullopt}};
    const auto plan = planScene(scene, resolveNeeds(scene, {}), {});
    ASSERT_TRUE(plan.has_value());
    EXPECT_EQ(plan->actions[0].parameters.at("layout"), "flat");
    scene.output.lightMapLayout = kAutoLayout;
    const auto open = planScene(scene, resolveNeeds(scene, {}), {});
    ASSERT_TRUE(open.has_value());
    EXPECT_EQ(open->actions[0].parameters.at("is_flat_tried"), true);
    scene.output.lightMapLayout = "flat-2";
    const auto named = planScene(scene, resolveNeeds(scene, {}), {});
    ASSERT_TRUE(named.has_value());
    EXPECT_EQ(named->actions[0].parameters.at("layout"), "flat-2");
}

TEST(PlanScene, EverythingIsPlannedWhereEverythingIsNeeded) {
    const Scene scene = sceneWithOneMap();
    const auto plan = planScene(scene, resolveNeeds(scene, {}), {});
    ASSERT_TRUE(plan.has_value());
    for (const char* name : {"map", "map_dominant", "probe", "sky", "specular"}) EXPECT_TRUE(hasAsset(*plan, name)) << name;
    for (const Action& action : plan->actions) EXPECT_NE(actionFunction(action.kind), nullptr) << action.kind;
}

TEST(PlanScene, OnlyTakesAnAssetAndWhatDerivesFromIt) {
    const Scene scene = sceneWithOneMap();
    PlanOptions options;
    options.only = "map";
    const auto plan = planScene(scene, {}, options);
    ASSERT_TRUE(plan.has_value());
    EXPECT_EQ(plan->assets, (std::vector<std::string>{"map", "map_dominant"}));
    options.only = "mop";
    const auto refused = planScene(scene, {}, options);
    ASSERT_FALSE(refused.has_value());
    EXPECT_NE(refused.error().detail.find("nearest is 'map'"), std::string::npos);
}

TEST(PlanScene, RowsOfReflectionMapsThatNoMaterialReadsAreLeftOut) {
    Scene scene = sceneWithOneMap();
    scene.gradients[0].exponents = {1, 4, 16, 64, 256, 1024};
    const auto exponentsOf = [&](const Needs& needs) {
        const auto plan = planScene(scene, needs, {});
        for (const Action& action : plan->actions)
            if (action.id == "cook/sky") return action.parameters.at("exponents").get<std::vector<double>>();
        return std::vector<double>();
    };
    EXPECT_EQ(exponentsOf(resolveNeeds(scene, {})).size(), 6u) << "no material says how rough it is";
    scene.materials = {{"*", true, true, Range{0.1, 0.5}, std::nullopt}};
    EXPECT_EQ(exponentsOf(resolveNeeds(scene, {})), (std::vector<double>{1, 4, 16, 64})) << "m = 0.1 is exponent 50.5, between two rows";
    scene.output.keepUnused = true;
    EXPECT_EQ(exponentsOf(resolveNeeds(scene, {})).size(), 6u);
    scene.output.keepUnused = false;
    scene.materials = {{"*", true, true, Range{0, 0.5}, std::nullopt}};
    EXPECT_EQ(exponentsOf(resolveNeeds(scene, {})).size(), 6u) << "a mirror reads the sharpest row";
}

TEST(PlanScene, LevelsOfCubemapsThatNoMaterialReadsAreLeftOutUnlessASizeIsGiven) {
    Scene scene = sceneWithOneMap();
    const auto planned = [&] { return planScene(scene, resolveNeeds(scene, {}), {}).value(); };
    const auto firstLevel = [&] {
        for (const Action& action : planned().actions)
            if (action.id == "cook/probe") return action.parameters.value("first_level", 0);
        return -1;
    };
    EXPECT_EQ(firstLevel(), 0) << "no material states its roughness";
    scene.materials = {{"*", true, true, Range{0.1, 0.5}, std::nullopt}};
    EXPECT_EQ(firstLevel(), 2);
    EXPECT_TRUE(planned().notes.empty());
    const std::vector<Skip> skipped = planned().skipped;
    ASSERT_EQ(std::ranges::count(skipped, "2 of 8 levels of cubemap 'probe'", &Skip::what), 1);
    EXPECT_EQ(std::ranges::find(skipped, "2 of 8 levels of cubemap 'probe'", &Skip::what)->bytesSaved, 6u * (128 * 128 + 64 * 64));
    scene.output.keepUnused = true;
    EXPECT_EQ(firstLevel(), 0);
    EXPECT_TRUE(planned().notes.empty()) << "size = \"auto\" is no advice where it holds";
    scene.output.keepUnused = false;
    scene.probes[0].readLevelsOnly = false;
    EXPECT_EQ(firstLevel(), 0) << "a size by number is obeyed";
    EXPECT_EQ(planned().notes.at("probe"), Json({{"unread_levels", 2}, {"unread_bytes", 6 * (128 * 128 + 64 * 64)}}));
    scene.output.budgetBytes = 1 << 20;
    EXPECT_EQ(firstLevel(), 0) << "under a budget too";
}

TEST(PlanScene, TablesHave24ViewsUnlessANumberIsGiven) {
    Scene scene = sceneWithOneMap();
    const auto views = [&] {
        const Plan plan = planScene(scene, resolveNeeds(scene, {}), {}).value();
        for (const Action& action : plan.actions)
            if (action.id == "cook/specular") return action.parameters.at("view_count").get<int>();
        return 0;
    };
    EXPECT_EQ(views(), 24);
    scene.output.limits[Limit::WholeVisible] = 5;
    EXPECT_EQ(views(), 24);
    scene.tables.viewCount = 12;
    EXPECT_EQ(views(), 12) << "a number of their own is obeyed";
    scene.output.budgetBytes = 1 << 20;
    EXPECT_EQ(views(), 12);
}

TEST(PlanScene, TablesUnderABudgetWaitForTheirViews) {
    Scene scene = sceneWithOneMap();
    scene.output.budgetBytes = 1 << 20;
    scene.tables.roughnessCount = 5;
    const auto planned = [&](const PlanOptions& options) { return planScene(scene, resolveNeeds(scene, {}), options).value(); };
    const Plan open = planned({});
    ASSERT_TRUE(open.openTables);
    EXPECT_EQ(open.openTables->least, 8u * 5 * 3 * 8);
    EXPECT_EQ(open.openTables->fine, 24u * 5 * 3 * 8);
    EXPECT_TRUE(hasAsset(open, "specular"));
    EXPECT_EQ(std::ranges::count(open.actions, "specular", &Action::asset), 0);
    PlanOptions options;
    options.decisions.tableViews = kFineViewCount;
    const Plan chosen = planned(options);
    EXPECT_FALSE(chosen.openTables);
    const auto action = std::ranges::find(chosen.actions, "cook/specular", &Action::id);
    ASSERT_NE(action, chosen.actions.end());
    EXPECT_EQ(action->parameters.at("view_count"), 24);
}

/// The manifest says so, and nothing stores it.
TEST(PlanScene, ADominantLightThatIsTheSameEverywhereIsDerivedToo) {
    Scene scene = sceneWithOneMap();
    Needs needs = resolveNeeds(scene, {});
    LightMapContent& content = needs.contents["map"];
    content.width = content.height = 64;
    content.covered = 4096;
    content.isConstant = content.hasOneNormal = true;
    for (const char* layout : {"derived", "full", "none"}) {
        scene.lightMaps[0].dominantLayout = layout;
        const auto plan = planScene(scene, needs, {});
        ASSERT_TRUE(plan.has_value());
        const auto map = std::ranges::find(plan->actions, "cook/map", &Action::id);
        EXPECT_EQ(map->parameters.value("derived_dominant", false), std::string(layout) == "derived") << layout;
        EXPECT_EQ(hasAsset(*plan, "map_dominant"), std::string(layout) == "full") << layout;
    }
}

TEST(PlanScene, AConstantDominantLightThatIsSmallerThanABlockSavesNothing) {
    Scene scene = sceneWithOneMap();
    scene.output.target = formats::Target::Float;
    Needs needs = resolveNeeds(scene, {});
    LightMapContent& content = needs.contents["map"];
    content.width = content.height = 2;
    content.covered = 4;
    content.isConstant = content.hasOneNormal = true;
    const auto plan = planScene(scene, needs, {});
    ASSERT_TRUE(plan.has_value());
    const auto skip = std::ranges::find(plan->skipped, std::string("texels of the dominant light of 'map'"), &Skip::what);
    ASSERT_NE(skip, plan->skipped.end());
    EXPECT_EQ(skip->bytesSaved, 0u);
}

TEST(PlanScene, AProbeThatNoSurfaceUsesIsSkipped) {
    const Scene scene = sceneWithOneMap();
    Needs needs = resolveNeeds(scene, {});
    needs.unusedProbes = {"probe"};
    const auto plan = planScene(scene, needs, {});
    ASSERT_TRUE(plan.has_value());
    EXPECT_FALSE(hasAsset(*plan, "probe"));
    const auto skip = std::ranges::find(plan->skipped, std::string("cubemap 'probe'"), &Skip::what);
    ASSERT_NE(skip, plan->skipped.end());
    EXPECT_EQ(skip->bytesSaved, 6u * (128 * 128 + 64 * 64 + 32 * 32 + 16 * 16 + 8 * 8 + 4 * 4 + 4 * 4 + 4 * 4));
}

}  // namespace
}  // namespace lightcook::pipeline

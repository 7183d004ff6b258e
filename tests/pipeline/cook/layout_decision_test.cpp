// Layouts chosen by an error, and the memory of meshes that depends on the layout. allocation_test.cpp has more of those that a budget
// chooses.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/assets/action_kind.h"
#include "pipeline/assets/cooked_asset.h"
#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/assets/results.h"
#include "pipeline/cook/cook.h"
#include "pipeline/cook/layout_decision.h"
#include "pipeline/scene/settings.h"
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
    EXPECT_EQ(outcome.errors.front().code, formats::ErrorCode::OverLimit);
    EXPECT_EQ(assetOf(outcome.report, "map").at("layout"), "raw");
}

TEST(CookScene, ANamedLayoutIsNotTried) {
    const SmallScene scene(Parts::LightMap);
    scene.writeSceneFile("max_error = 0.05\nlight_map_layout = \"hdr-2\"");
    const Outcome named = cook(scene.options());
    EXPECT_EQ(assetOf(named.report, "map").at("layout"), "hdr-2");
    EXPECT_FALSE(assetOf(named.report, "map").contains("trial_candidates"));
    scene.writeSceneFile("");
    const Json open = assetOf(cook(scene.options()).report, "map");
    EXPECT_TRUE(open.contains("trial_candidates")) << "without a layout";
    EXPECT_EQ(open.at("limit").at("max_visible"), kDefaultMaxVisible);
}

/// The default limit is a wish: where no layout that may be taken keeps it, the best one passes, held to no limit.
TEST(CookScene, ADefaultLimitThatNoLayoutKeepsRefusesNothing) {
    const SmallScene scene(Parts::LightMap);
    scene.writeSceneFile("layouts = [\"godot\", \"mono-sh\"]");
    const Outcome outcome = cook(scene.options());
    ASSERT_TRUE(outcome.errors.empty()) << outcome.errors.front().line();
    const Json map = assetOf(outcome.report, "map");
    EXPECT_FALSE(map.at("limit").contains("max_visible"));
    EXPECT_GT(map.at("stages").back().at("error").at("specular").at("visible").at("p99").get<double>(), kDefaultMaxVisible);
    scene.writeSceneFile("layouts = [\"godot\", \"mono-sh\"]\nmax_visible = 5");
    EXPECT_FALSE(cook(scene.options()).errors.empty()) << "a limit that was asked for";
}

/// A light map with a mesh, whose layouts have known bytes and errors. Trials and cooks are records that nothing has to run for.
class MapWithMesh {
public:
    struct Layout {
        const char* name;
        std::uint64_t bytes;
        double visible;
    };
    static constexpr std::array<Layout, 5> kLayouts = {
        {{"sh4", 400, 9}, {"basis-4", 700, 4}, {"basis-8", 900, 3}, {"ratio", 1000, 6}, {"raw", 3000, 1}}};
    static constexpr std::uint64_t kMostVertices = 100;

    /// vertices  of the cooked mesh, at most kMostVertices
    MapWithMesh(bool isDraco, std::uint64_t vertices) : isDraco_(isDraco), vertices_(vertices) {
        scene_.output.draco = isDraco;
        LightMapEntry& entry = scene_.lightMaps.emplace_back();
        entry.name = "map";
        entry.mesh = "mesh.glb";
    }
    std::uint64_t bytesOf(const Layout& layout) const {
        const bool hasBases = hasLearnedBases(layout.name);
        return layout.bytes + (isDraco_ || hasBases ? vertices_ * bytesOfVertex(isDraco_, hasBases) : 0);
    }
    /// Returns the layout that a cook within a budget ends with.
    Layout cookWithin(std::uint64_t budget) {
        scene_.output.budgetBytes = budget;
        auto decision = tried();
        for (int round = 0; round < 10; ++round) {
            const std::string chosen = decision->choose().at("map");
            const Layout& layout = *std::ranges::find_if(kLayouts, [&](const Layout& each) { return each.name == chosen; });
            Plan plan;
            ExecutionResult cooked;
            addCooked("map", AssetKind::LightMap, layout.bytes, false, plan, cooked);
            if (const std::uint64_t mesh = bytesOf(layout) - layout.bytes; mesh > 0) {
                addCooked("mesh", AssetKind::Mesh, mesh, hasLearnedBases(layout.name), plan, cooked);
                plan.meshes["mesh"] = "map";
            }
            const auto isRefuted = decision->learnFrom(plan, {}, cooked);
            EXPECT_TRUE(isRefuted) << isRefuted.error().line();
            if (!*isRefuted) return layout;
        }
        ADD_FAILURE() << "no choice stays";
        return kLayouts[0];
    }

    /// Returns the frontier of a cook under a limit on the whole, after the verification of its layout found an error.
    std::vector<FrontierPoint> frontierOfWhole(double limit, double found) {
        scene_.output.limits[Limit::WholeVisible] = limit;
        auto decision = tried();
        decision->choose();
        ExecutionResult cooked;
        WholeFigures whole;
        whole.visible.p99 = found;
        whole.limits[Limit::WholeVisible] = limit;
        record(cooked, actionId(ActionStep::Whole, "map"), whole);
        EXPECT_TRUE(decision->learnFrom({}, {}, cooked));
        return frontierOf(*decision);
    }

private:
    formats::Result<LayoutDecision> tried() const {
        JointTrialResult trial;
        for (const Layout& each : kLayouts) {
            trial.trial.candidates.push_back({.layout = each.name, .bytesGpu = each.bytes});
            trial.whole.push_back({each.name, each.visible, 0});
        }
        ExecutionResult trials, materials;
        record(trials, actionId(ActionStep::Trial, "map"), trial);
        record(materials, actionId(ActionStep::Materials, "mesh.glb"), MaterialsResult{kMostVertices, {}});
        Plan open;
        open.undecided = {"map"};
        auto decision = LayoutDecision::create(scene_, open, trials, materials);
        EXPECT_TRUE(decision) << decision.error().line();
        return decision;
    }
    template <class Result>
    static void record(ExecutionResult& results, const std::string& id, const Result& result) {
        ActionRecord& made = results.records[id];
        made.id = id;
        made.result = toJson(result);
    }
    static void addCooked(const char* name, AssetKind kind, std::uint64_t bytes, bool hasBases, Plan& plan, ExecutionResult& cooked) {
        CookResult result{makeCookedAsset(name, kind, "layout", 0, 0), 0, {}};
        result.asset.bytesGpu = bytes;
        if (hasBases) result.asset.basis = {"_BASIS", "map"};
        plan.assets.emplace_back(name);
        record(cooked, actionId(ActionStep::Cook, name), result);
    }

    Scene scene_;
    bool isDraco_;
    std::uint64_t vertices_;
};

/// Other layouts are expected to exceed their trials as the chosen one did: a trial of a part of a map errs alike for all of them.
TEST(LayoutDecision, OtherLayoutsAreExpectedToExceedTheirTrialsAsTheVerifiedOneDoes) {
    const auto visible = [](const std::vector<FrontierPoint>& frontier) {
        std::vector<double> out;
        for (const FrontierPoint& each : frontier) out.push_back(each.visible);
        return out;
    };
    EXPECT_EQ(visible(MapWithMesh(false, 0).frontierOfWhole(5, 4.5)), (std::vector{10.125, 6.75, 4.5, 3.375, 1.125}));
    EXPECT_EQ(visible(MapWithMesh(false, 0).frontierOfWhole(5, 3.5)), (std::vector<double>{9, 6, 3.5, 3, 1}))
        << "no less than its trial found";
    EXPECT_EQ(visible(MapWithMesh(false, 0).frontierOfWhole(5, 8)), (std::vector<double>{18, 12, 6, 2})) << "8 is over the limit";
}

TEST(LayoutDecision, TheErrorNeverGrowsWithTheBudgetWhereTheMeshDependsOnTheLayout) {
    for (const bool isDraco : {false, true})
        for (const std::uint64_t vertices : {MapWithMesh::kMostVertices, MapWithMesh::kMostVertices * 4 / 5}) {
            MapWithMesh map(isDraco, vertices);
            double before = HUGE_VAL;
            for (std::uint64_t budget = 900; budget <= 4000; budget += 50) {
                const MapWithMesh::Layout chosen = map.cookWithin(budget);
                EXPECT_LE(map.bytesOf(chosen), budget) << chosen.name;
                EXPECT_LE(chosen.visible, before) << budget << ": " << chosen.name << (isDraco ? ", draco" : "");
                before = chosen.visible;
                if (vertices < MapWithMesh::kMostVertices) continue;  // bytes of a mesh that was not cooked are an upper bound
                for (const MapWithMesh::Layout& each : MapWithMesh::kLayouts)
                    EXPECT_TRUE(map.bytesOf(each) > budget || each.visible >= chosen.visible) << budget << ": " << each.name << " fits";
            }
            EXPECT_EQ(before, 1) << "in the end all fits";
        }
}

}  // namespace
}  // namespace lightcook::pipeline

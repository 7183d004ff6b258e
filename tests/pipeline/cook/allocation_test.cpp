// Memory shared out among light maps.
#include "pipeline/cook/allocation.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <limits>
#include <map>
#include <random>
#include <set>

#include "pipeline/cook/cook.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/report/ci_checks.h"
#include "pipeline/report/words.h"
#include "tests/pipeline/example_folder.h"
#include "tests/pipeline/report_parts.h"
#include "tests/pipeline/rewritten_manifest.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

using Parts = SmallScene::Parts;
using testing::HasSubstr;

AllocationChoices randomChoices(std::mt19937& random, int maps) {
    AllocationChoices choices;
    for (int map = 0; map < maps; ++map)
        for (int i = 0; i < 6; ++i)
            choices["map" + std::to_string(map)].push_back(
                {"layout" + std::to_string(i), 100 + random() % 1000, static_cast<double>(1 + random() % 40)});
    return choices;
}

struct Worth {
    std::uint64_t bytes = 0;
    double visible = 0;
};
/// Every combination of choices.
std::vector<Worth> allWorths(const AllocationChoices& choices, std::uint64_t otherBytes) {
    std::vector<Worth> worths = {{otherBytes, 0}};
    for (const auto& [map, each] : choices) {
        std::vector<Worth> longer;
        for (const Worth& worth : worths)
            for (const AllocationChoice& choice : each)
                longer.push_back({worth.bytes + choice.bytes, std::max(worth.visible, choice.visible)});
        worths = std::move(longer);
    }
    return worths;
}

TEST(Allocation, FindsWhatTryingEveryCombinationFinds) {
    std::mt19937 random(5);
    for (int round = 0; round < 200; ++round) {
        const AllocationChoices choices = randomChoices(random, 1 + static_cast<int>(random() % 4));
        const std::vector<Worth> all = allWorths(choices, 50);
        const std::vector<AllocationPoint> frontier = allocationFrontier(choices, 50);
        const std::uint64_t budget = 300 + random() % 4000;
        double least = HUGE_VAL;
        for (const Worth& worth : all)
            if (worth.bytes <= budget) least = std::min(least, worth.visible);
        const AllocationPoint& found = frontier[pointWithin(frontier, budget)];
        if (std::isfinite(least)) {
            EXPECT_LE(found.bytes, budget);
            EXPECT_EQ(found.visible, least);
        } else {
            EXPECT_EQ(found.bytes, std::ranges::min_element(all, {}, &Worth::bytes)->bytes);
        }
    }
}

TEST(Allocation, BytesGrowAndErrorsFallAlongTheFrontier) {
    std::mt19937 random(6);
    for (int round = 0; round < 100; ++round) {
        const std::vector<AllocationPoint> frontier = allocationFrontier(randomChoices(random, 3), 0);
        ASSERT_FALSE(frontier.empty());
        for (std::size_t i = 1; i < frontier.size(); ++i) {
            EXPECT_GT(frontier[i].bytes, frontier[i - 1].bytes);
            EXPECT_LT(frontier[i].visible, frontier[i - 1].visible);
        }
    }
}

TEST(Allocation, AChoiceWithoutAFiniteErrorIsTheLastResort) {
    const AllocationChoices choices = {{"map", {{"small", 10, HUGE_VAL}, {"large", 100, 3}}}};
    const std::vector<AllocationPoint> frontier = allocationFrontier(choices, 0);
    EXPECT_EQ(frontier[pointWithin(frontier, 100)].choices.at("map").layout, "large");
    EXPECT_EQ(frontier[pointWithin(frontier, 50)].choices.at("map").layout, "small");
}

TEST(Allocation, ALimitTakesTheFirstPointWithinIt) {
    const std::vector<AllocationPoint> frontier = {{10, 9, {}}, {20, 4, {}}, {30, 1, {}}};
    EXPECT_EQ(pointOfError(frontier, 9), 0u);
    EXPECT_EQ(pointOfError(frontier, 8.9), 1u);
    EXPECT_EQ(pointOfError(frontier, 1), 2u);
    EXPECT_EQ(pointOfError(frontier, 0.5), 2u) << "none is within it: the one of least error";
}

/// The best errors of all combinations beside tables of either size decide, byte by byte of the budget.
TEST(Allocation, FineTablesNeverTakeTheBytesOfASmallerError) {
    std::mt19937 random(7);
    const TableBytes tables{30, 400};
    for (int round = 0; round < 20; ++round) {
        const AllocationChoices choices = randomChoices(random, 1 + static_cast<int>(random() % 3));
        const std::vector<Worth> all = allWorths(choices, 50);
        const auto leastBeside = [&](std::uint64_t bytes, std::uint64_t budget) {
            double least = HUGE_VAL;
            for (const Worth& worth : all)
                if (worth.bytes + bytes <= budget) least = std::min(least, worth.visible);
            return least;
        };
        const std::vector<AllocationPoint> frontier = allocationFrontier(choices, 50);
        double before = HUGE_VAL;
        bool wereFine = false;
        for (std::uint64_t budget = 1; budget < frontier.back().bytes + tables.fine + 10; budget += 7) {
            const BudgetChoice choice = choiceWithin(frontier, tables, budget, frontier.size() - 1);
            const double usual = leastBeside(tables.least, budget), fine = leastBeside(tables.fine, budget);
            EXPECT_EQ(choice.areTablesFine, std::isfinite(usual) && fine == usual) << budget;
            if (!std::isfinite(usual)) {
                EXPECT_EQ(choice.point, 0u) << "the least that is possible";
                continue;
            }
            const double visible = frontier[choice.point].visible;
            EXPECT_EQ(visible, usual) << budget;
            EXPECT_LE(visible, before) << "the error never grows with the budget";
            before = visible;
            wereFine = choice.areTablesFine;
        }
        EXPECT_TRUE(wereFine) << "in the end all fits";
    }
}

TEST(Allocation, FineTablesThatALimitAsksForTakeAnyPointBesideThem) {
    const std::vector<AllocationPoint> frontier = {{10, 9, {}}, {20, 4, {}}, {30, 1, {}}};
    const TableBytes tables{1, 8};
    const auto choose = [&](std::uint64_t budget, std::size_t lastPoint, bool isFineOnly) {
        const BudgetChoice choice = choiceWithin(frontier, tables, budget, lastPoint, isFineOnly);
        return std::pair(choice.point, choice.areTablesFine);
    };
    EXPECT_EQ(choose(21, 2, false), std::pair(std::size_t{1}, false));
    EXPECT_EQ(choose(21, 2, true), std::pair(std::size_t{0}, true));
    EXPECT_EQ(choose(17, 2, true), std::pair(std::size_t{0}, false)) << "nothing fits beside them";
    EXPECT_EQ(choose(21, 0, false), std::pair(std::size_t{0}, true)) << "a limit on the whole wants no larger point";
    EXPECT_EQ(choose(5, 2, false), std::pair(std::size_t{0}, false)) << "a budget below the tables alone";
    EXPECT_EQ(choose(38, 2, false), std::pair(std::size_t{2}, true));
}

class BudgetedScene {
public:
    explicit BudgetedScene(std::filesystem::path sceneFile, std::filesystem::path folder)
        : sceneFile_(std::move(sceneFile)), folder_(std::move(folder)) {}
    Outcome cook(std::uint64_t budget, const std::string& output = "out") const {
        CookOptions options;
        options.scene = sceneFile_;
        options.output = folder_ / output;
        options.cache = LIGHTCOOK_TEST_CACHE;
        options.given.set("output.budget", budget);
        const RunState state;
        return cookScene(options, state);
    }

private:
    std::filesystem::path sceneFile_, folder_;
};

std::uint64_t usedBytes(const Outcome& outcome) {
    return outcome.report.at("budget").at("used_bytes").get<std::uint64_t>();
}
const Json& notesOf(const Outcome& outcome, const std::string& map) {
    return assetOf(outcome.report, map).at("notes");
}
std::uint64_t bytesOf(const Json& point) {
    return point.at("bytes_gpu").get<std::uint64_t>();
}
const Json& frontierOf(const Outcome& outcome) {
    return outcome.report.at("budget").at("frontier");
}
std::size_t chosenOn(const Json& frontier) {
    const auto chosen = std::ranges::find_if(frontier, [](const Json& point) { return point.at("chosen").get<bool>(); });
    return static_cast<std::size_t>(chosen - frontier.begin());
}

/// Returns the visible error of a cook, after checks that hold for every cook within its budget.
double expectWithin(const Outcome& outcome, const std::string& map, std::uint64_t budget) {
    EXPECT_TRUE(outcome.errors.empty()) << (outcome.errors.empty() ? "" : outcome.errors.front().line());
    EXPECT_LE(usedBytes(outcome), budget);
    const Json& frontier = frontierOf(outcome);
    const std::size_t chosen = chosenOn(frontier);
    if (chosen == frontier.size()) throw std::runtime_error("no allocation is marked as chosen");
    EXPECT_EQ(bytesOf(frontier[chosen]), usedBytes(outcome));
    if (chosen + 1 < frontier.size()) {
        EXPECT_GT(bytesOf(frontier[chosen + 1]), budget) << "the next step would fit";
    }
    const double visible = frontier[chosen].at("visible").get<double>();
    EXPECT_EQ(notesOf(outcome, map).at("whole_visible").get<double>(), visible) << "the only light map";
    return visible;
}

/// Halves hold every texel of both layouts, so all errors lie between texels: at the edge of the light, where a sampler filters the
/// factors of `ratio`.
TEST(CookScene, ABudgetCountsErrorsBetweenTexels) {
    const SmallScene scene(SmallScene::Parts::LightMap, [](const glm::dvec3& direction, const glm::dvec2& place) {
        const bool isLit = place.x < 0.5;
        return glm::vec3(isLit ? 50 * std::max(0.0, direction.z) : 0.5 + 0.5 * direction.x);
    });
    const auto visibleUnder = [&](const char* layout) {
        scene.writeSceneFile(fmt::format("target = \"float\"\nfilter = \"hardware\"\nlayouts = [\"{}\"]\nbudget = \"1 MiB\"", layout),
                             "[[material]]\nname = \"*\"\nspecular = false\nnormal_map = true\n");
        const Outcome outcome = pipeline::cook(scene.options());
        for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
        return notesOf(outcome, "map").at("whole_visible").get<double>();
    };
    EXPECT_LT(visibleUnder("hdr"), 1);
    EXPECT_GT(visibleUnder("ratio"), 10);
}

/// A scene with a sun, glossy materials and a limit on what a pixel shows.
class WholeLimit : public testing::Test {
protected:
    static Outcome cookWithin(const SmallScene& scene, const std::string& output, const std::string& folder = "out") {
        scene.writeSceneFile(output,
                             "dominant_layout = \"derived\"\n"
                             "[[material]]\nname = \"*\"\nnormal_map = true\nspecular = true\nm = [0.2, 0.5]\n");
        CookOptions options = scene.options();
        options.output = scene / folder;
        return pipeline::cook(options);
    }
    /// Expects JUnit and SARIF to have the refusal of a cook as a finding of this check, and no other.
    void expectFindingOf(CiRule rule, const Outcome& outcome) const {
        const CiRun run = ciRun({"cook", scene_ / "out", scene_.sceneFile(), {}, outcome.report, outcome.errors});
        bool isFound = false;
        for (const CiSuite& suite : run.suites)
            for (const CiCheck& check : suite.checks) {
                const bool isExpected = suite.name == "map" && check.rule == rule;
                EXPECT_EQ(check.findings.size(), isExpected ? 1u : 0u) << suite.name;
                isFound = isFound || isExpected;
            }
        EXPECT_TRUE(isFound) << "the check is among those of the map";
    }
    static double wholeOf(const Outcome& outcome) {
        return assetOf(outcome.report, "map").at("whole").at("visible").at("p99").get<double>();
    }

    SmallScene scene_{SmallScene::Parts::LightMap};
};

TEST_F(WholeLimit, TakesTheSmallestSceneWithinItAndVerifiesIt) {
    std::uint64_t bytes = std::numeric_limits<std::uint64_t>::max();
    for (const double limit : {4.0, 20.0, 200.0}) {
        const Outcome outcome = cookWithin(scene_, fmt::format("max_whole_visible = {}", limit));
        for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
        const Json& frontier = frontierOf(outcome);
        const std::size_t chosen = chosenOn(frontier);
        ASSERT_LT(chosen, frontier.size());
        EXPECT_LE(frontier[chosen].at("visible").get<double>(), limit);
        if (chosen > 0) {
            EXPECT_GT(frontier[chosen - 1].at("visible").get<double>(), limit) << "the next smaller scene is over the limit";
        }
        EXPECT_NEAR(wholeOf(outcome), frontier[chosen].at("visible").get<double>(), 1e-6) << "the trial and the files show the same";
        EXPECT_EQ(assetOf(outcome.report, "map").at("whole").at("max_visible"), limit);
        EXPECT_LE(usedBytes(outcome), bytes) << "less memory for a looser limit";
        bytes = usedBytes(outcome);
    }
}

using WholeLimitSoak = WholeLimit;
TEST_F(WholeLimit, OnRelRmsTakesTheSmallestSceneWithinIt) {
    std::uint64_t bytes = std::numeric_limits<std::uint64_t>::max();
    for (const double limit : {0.02, 0.1, 0.9}) {
        const Outcome outcome = cookWithin(scene_, fmt::format("max_whole_error = {}", limit));
        for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
        const Json& whole = assetOf(outcome.report, "map").at("whole");
        EXPECT_EQ(whole.at("max_error"), limit);
        EXPECT_GT(whole.at("rel_rms").get<double>(), 0);
        EXPECT_LE(whole.at("rel_rms").get<double>(), limit);
        EXPECT_EQ(chosenOn(frontierOf(outcome)), 0u) << "the smallest of those within the limit";
        EXPECT_LE(usedBytes(outcome), bytes) << "less memory for a looser limit";
        bytes = usedBytes(outcome);
    }
    const double visible = 0.7 * wholeOf(cookWithin(scene_, "max_whole_error = 0.9"));
    const Outcome both = cookWithin(scene_, fmt::format("max_whole_error = 0.9\nmax_whole_visible = {}", visible));
    EXPECT_LE(wholeOf(both), visible);
    EXPECT_GT(usedBytes(both), bytes);
}

/// max_error alone takes the cheapest layout that keeps it, whose whole shading may be over the other limit.
TEST_F(WholeLimitSoak, BesideALimitOfTheMapTakesAFinerLayoutWhereItMust) {
    const auto cookedWith = [&](double limit) {
        const Outcome outcome = cookWithin(scene_, fmt::format("max_error = 0.5\nmax_whole_error = {}", limit));
        for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
        return assetOf(outcome.report, "map");
    };
    const Json cheapest = cookedWith(0.9);
    double limit = cheapest.at("whole").at("rel_rms");
    Json finer = cheapest;
    for (int i = 0; i < 12 && finer.at("layout") == cheapest.at("layout"); ++i) {
        limit *= 0.7;
        finer = cookedWith(limit);
    }
    EXPECT_NE(finer.at("layout"), cheapest.at("layout"));
    EXPECT_LE(finer.at("whole").at("rel_rms").get<double>(), limit);
}

TEST_F(WholeLimitSoak, OnRelRmsThatNothingKeepsIsRefusedByWhatWasFound) {
    const Outcome outcome = cookWithin(scene_, "max_whole_error = 0.000001");
    ASSERT_EQ(outcome.errors.size(), 1u);
    EXPECT_EQ(outcome.errors[0].code, formats::ErrorCode::OverLimit);
    EXPECT_THAT(outcome.errors[0].line(),
                testing::AllOf(HasSubstr("map, together with its dominant light: found rel_rms "), HasSubstr("expected at most 1e-06")));
    expectFindingOf(CiRule::SpecularError, outcome);
}

TEST_F(WholeLimit, IsHeldByVerifyToo) {
    const Outcome cooked = cookWithin(scene_, "max_whole_visible = 20");
    const RunState state;
    const Outcome verified = verifyCooked({scene_ / "out", {}, {}}, state);
    EXPECT_TRUE(verified.errors.empty());
    EXPECT_EQ(wholeOf(verified), wholeOf(cooked));
    Json manifest = parseJson(formats::contentOf(scene_ / "out" / kManifestName));
    manifest["cooks"][0]["scene"]["output"]["max_whole_visible"] = 0.5 * wholeOf(cooked);
    writeManifestAndDigests(scene_ / "out", manifest);
    const Outcome failed = verifyCooked({scene_ / "out", {}, {}}, state);
    ASSERT_EQ(failed.errors.size(), 1u);
    EXPECT_THAT(failed.errors[0].line(),
                HasSubstr(fmt::format("map, together with its dominant light: found a visible error of {:.3g} (p99), "
                                      "expected at most {:.3g}",
                                      wholeOf(cooked), 0.5 * wholeOf(cooked))));
}

TEST_F(WholeLimit, ThatNothingKeepsIsRefusedByWhatWasFound) {
    const Outcome outcome = cookWithin(scene_, "max_whole_visible = 0.0001");
    ASSERT_EQ(outcome.errors.size(), 1u);
    EXPECT_EQ(outcome.errors[0].code, formats::ErrorCode::OverLimit);
    EXPECT_THAT(outcome.errors[0].line(), HasSubstr("expected at most 0.0001"));
    expectFindingOf(CiRule::VisibleError, outcome);
    EXPECT_EQ(chosenOn(frontierOf(outcome)), frontierOf(outcome).size() - 1) << "the least error that there is";
}

TEST_F(WholeLimit, BesideABudgetTakesTheSmallerOfBoth) {
    const std::uint64_t loose = usedBytes(cookWithin(scene_, "max_whole_visible = 20"));
    EXPECT_EQ(usedBytes(cookWithin(scene_, "max_whole_visible = 20\nbudget = \"1 MiB\"")), loose);
    const Outcome tight = cookWithin(scene_, fmt::format("max_whole_visible = 0.0001\nbudget = \"{}\"", loose));
    EXPECT_LE(usedBytes(tight), loose);
    ASSERT_EQ(tight.errors.size(), 1u);
    EXPECT_EQ(tight.errors[0].code, formats::ErrorCode::OverLimit);
}

TEST_F(WholeLimit, DoesNotCountChartsWithFewerTexels) {
    scene_.writeSceneFile("max_whole_visible = 5\ncharts = \"pack\"\ncharts_max_visible = 1");
    std::string text = formats::contentOf(scene_.sceneFile());
    formats::writeContent(scene_.sceneFile(), text.insert(text.find("file = \"map.exr\""), "mesh = \"map.glb\"\n"));
    const Outcome outcome = pipeline::cook(scene_.options());
    ASSERT_FALSE(outcome.errors.empty());
    EXPECT_THAT(outcome.errors[0].line(), HasSubstr("found max_whole_visible beside charts with fewer texels"));
}

/// The example scene: the error never grows with the budget, and one that nothing meets is refused with the least bytes.
TEST(CookSceneSoak, ABudgetIsSharedOutOverTheExampleScene) {
    const formats::TemporaryFolder folder;
    std::filesystem::copy(exampleFolder(), folder / "scene", std::filesystem::copy_options::recursive);
    std::string text = formats::contentOf(folder / "scene" / "scene.toml");
    text.replace(text.find("max_error = 0.02"), 16, "");
    formats::writeContent(folder / "scene" / "scene.toml", text);
    const BudgetedScene scene(folder / "scene" / "scene.toml", folder / "cooked");

    const Outcome refused = scene.cook(1000);
    ASSERT_EQ(refused.errors.size(), 1u);
    EXPECT_EQ(refused.errors.front().code, formats::ErrorCode::OverBudget);
    EXPECT_EQ(chosenOn(frontierOf(refused)), 0u) << "the least that is possible";
    EXPECT_THAT(refused.errors.front().line(),
                testing::AllOf(testing::HasSubstr(fmt::format("found {} of GPU memory", sizeWords(usedBytes(refused)))),
                               testing::HasSubstr("No other layouts that the limits allow are smaller. A budget of ")));

    std::vector<std::uint64_t> budgets;
    for (const Json& point : frontierOf(refused)) budgets.push_back(bytesOf(point));
    EXPECT_EQ(budgets.front(), usedBytes(refused));
    double before = HUGE_VAL;
    for (const std::size_t index : {std::size_t{1}, budgets.size() / 2, budgets.size() - 1}) {
        const double visible = expectWithin(scene.cook(budgets[index]), "lightmap", budgets[index]);
        EXPECT_LT(visible, before);
        before = visible;
    }
    EXPECT_EQ(scene.cook(budgets.back()).actionsRun, 0) << "trials and cooks are kept";
}

TEST(CookScene, ALightMapLayoutThatTheSceneNamesIsKept) {
    const SmallScene scene(Parts::LightMap);
    scene.writeSceneFile("light_map_layout = \"hdr-2\"");
    const Outcome outcome = BudgetedScene(scene.sceneFile(), scene / "cooked").cook(1 << 20);
    ASSERT_TRUE(outcome.errors.empty()) << outcome.errors.front().line();
    EXPECT_EQ(assetOf(outcome.report, "map").at("layout"), "hdr-2");
    EXPECT_FALSE(outcome.report.at("budget").contains("frontier")) << "nothing is left to choose";
}

/// Light that bands 0 and 1 do not have at all: every layout without band 2 is far over the default of max_error.
LightField bandTwo() {
    return [](const glm::dvec3& direction, const glm::dvec2& place) {
        return glm::vec3(static_cast<float>(direction.z * direction.z * (1 + place.x)));
    };
}

TEST(CookSceneSoak, ABudgetWithoutAnErrorLimitsNoError) {
    const SmallScene scene(Parts::LightMap, bandTwo());
    scene.writeSceneFile("light_map_layout = \"sh4\"\nbudget = \"1 MiB\"");
    const Outcome budget = cookScene(scene.options(), RunState());
    for (const formats::Error& error : budget.errors) ADD_FAILURE() << error.line();
    const Json& diffuse = assetOf(budget.report, "map").at("stages").back().at("error").at("diffuse");
    EXPECT_GT(diffuse.at("rel_rms").get<double>(), 0.1);
    const Outcome again = verifyCooked({scene / "out", {}, {}, true}, RunState());
    for (const formats::Error& error : again.errors) ADD_FAILURE() << error.line();
    EXPECT_TRUE(again.findings.empty()) << "nobody wrote the limit that a budget stands for";

    scene.writeSceneFile("light_map_layout = \"sh4\"\nbudget = \"1 MiB\"\nmax_error = 0.1");
    const Outcome limited = cookScene(scene.options(), RunState());
    ASSERT_FALSE(limited.errors.empty());
    EXPECT_EQ(limited.errors.front().code, formats::ErrorCode::OverLimit);

    scene.writeSceneFile("light_map_layout = \"sh4\"\nbudget = \"1 MiB\"\nmax_error = 2");
    const Outcome loose = cookScene(scene.options(), RunState()), verified = verifyCooked({scene / "out", {}, {}}, RunState());
    for (const Outcome* outcome : {&loose, &verified}) {
        ASSERT_EQ(outcome->findings.size(), 1u) << "as any limit that somebody wrote";
        EXPECT_EQ(outcome->findings[0].check, LintCheck::LimitAboveOne);
    }
}

/// The limit of one light map leaves the others to the budget.
TEST(CookScene, ALimitOfOneLightMapIsNoneOfAnother) {
    const SmallScene scene(Parts::LightMap);
    scene.writeSceneFile("budget = \"1 MiB\"", "[[light_map]]\nname = \"other\"\nfile = \"map.exr\"\nmax_visible = 1\n");
    const Outcome outcome = cookScene(scene.options(), RunState());
    for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
    std::map<std::string, std::set<std::string>> layouts;
    for (const Json& point : frontierOf(outcome))
        for (const Json& each : point.at("layouts"))
            layouts[each.at("light_map").get<std::string>()].insert(each.at("layout").get<std::string>());
    EXPECT_EQ(layouts.at("other").size(), 1u);
    EXPECT_GT(layouts.at("map").size(), 1u);
}

/// A map of constant light is not traded, and gets its layout where the list has neither raw nor ratio.
TEST(CookSceneSoak, AConstantMapUnderABudgetGetsALayoutOfTheList) {
    const SmallScene scene(Parts::LightMap), constant(Parts::LightMap, grey);
    std::filesystem::copy_file(constant / "map.exr", scene / "even.exr");
    scene.writeSceneFile("budget = \"1 MiB\"\nlayouts = [\"hdr\"]", "[[light_map]]\nname = \"even\"\nfile = \"even.exr\"\n");
    const Outcome outcome = cookScene(scene.options(), RunState());
    for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
    EXPECT_EQ(assetOf(outcome.report, "map").at("layout"), "hdr");
    EXPECT_EQ(assetOf(outcome.report, "even").at("layout"), "hdr");
    EXPECT_EQ(assetOf(outcome.report, "even").at("width"), 4);
}

/// A limit on the error decides the light map as without a budget.
TEST(CookScene, ALimitOnTheErrorKeepsTheLightMapsLayout) {
    const SmallScene scene(Parts::LightMap);
    const BudgetedScene budgeted(scene.sceneFile(), scene / "cooked");
    scene.writeSceneFile("max_error = 0.01");
    const Outcome outcome = budgeted.cook(1 << 20);
    ASSERT_TRUE(outcome.errors.empty()) << outcome.errors.front().line();
    const Json& frontier = frontierOf(outcome);
    ASSERT_EQ(frontier.size(), 1u);
    EXPECT_EQ(frontier[0].at("layouts").at(0).at("layout"), assetOf(outcome.report, "map").at("layout"));
}

/// A stored dominant light is one of the other assets of a budget, and layouts of the map are judged beside it.
TEST(CookScene, ANamedDominantLayoutIsKeptUnderABudget) {
    const SmallScene scene(Parts::LightMap);
    scene.writeSceneFile("", "dominant_layout = \"full\"\n");
    const std::uint64_t budget = std::uint64_t{1} << 20;
    const Outcome stored = BudgetedScene(scene.sceneFile(), scene / "cooked").cook(budget);
    expectWithin(stored, "map", budget);
    EXPECT_GT(frontierOf(stored).size(), 1u);
    ASSERT_TRUE(hasAsset(stored.report, "map_dominant"));
    EXPECT_EQ(assetOf(stored.report, "map_dominant").at("textures").size(), 3u) << "direction, residual and intensity";
    const double whole = assetOf(stored.report, "map").at("whole").at("visible").at("p99");
    EXPECT_NEAR(frontierOf(stored)[chosenOn(frontierOf(stored))].at("visible").get<double>(), whole, 1e-6);
    scene.writeSceneFile("", "dominant_layout = \"none\"\n");
    const Outcome none = cookScene(scene.options(), RunState());
    ASSERT_TRUE(none.errors.empty()) << none.errors.front().line();
    EXPECT_FALSE(hasAsset(none.report, "map_dominant"));
    EXPECT_THAT(none.report.at("skipped").dump(), HasSubstr("the scene file leaves it out"));
}

}  // namespace
}  // namespace lightcook::pipeline

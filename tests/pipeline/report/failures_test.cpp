// The failures of an asset: in an error line, in report.json, on the page.
#include <gmock/gmock.h>

#include <cmath>
#include <string_view>

#include "pipeline/document/json.h"
#include "pipeline/report/failures.h"
#include "pipeline/report/report.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

using testing::_;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

class Failures : public testing::Test {
protected:
    /// The small scene under limits that nothing keeps.
    static void SetUpTestSuite() {
        scene_ = std::make_unique<SmallScene>(SmallScene::Parts::All);
        scene_->writeSceneFile("max_error = 1e-6\nmax_converter_error = 1e-6\nlight_map_layout = \"basis-3\"",
                               "[[material]]\nname = \"*\"\nnormal_map = true\nspecular = true\nm = [0.1, 0.5]\nf0 = [0.04, 0.6]\n");
        const RunState state;
        outcome_ = std::make_unique<Outcome>(cookScene(scene_->options(), state));
    }
    static void TearDownTestSuite() {
        outcome_.reset();
        scene_.reset();
    }
    static const Json& asset(const std::string& kind) {
        for (const Json& each : outcome_->report.at("assets"))
            if (each.at("kind") == kind) return each;
        throw std::runtime_error("no " + kind);
    }
    static inline std::unique_ptr<SmallScene> scene_;
    static inline std::unique_ptr<Outcome> outcome_;
};

TEST_F(Failures, NameStageTexelNormalFoundAndAllowedOfEveryKindOfAsset) {
    for (const char* kind : {"light-map", "dominant", "cubemap", "lut", "rsrm"}) {
        SCOPED_TRACE(kind);
        const Json& row = asset(kind);
        ASSERT_TRUE(row.contains("failures"));
        const Json& failure = row.at("failures")[0];
        for (const char* key : {"asset", "kind", "stage", "texel", "normal", "found", "reference", "allowed", "message"})
            EXPECT_TRUE(failure.contains(key)) << key << " in " << failure.dump(2);
        const double off = std::abs(failure.value("found", 0.0) - failure.value("reference", 0.0));
        EXPECT_GT(off, failure.value("allowed", 0.0)) << failure.dump(2);
        const std::string message = failure.at("message").get<std::string>();
        const char* const limit =
            std::string_view(kind) == "light-map" ? "at most 1e-06 (max_error)" : "at most 1e-06 (max_converter_error)";
        for (const char* word : {"texel (", "normal (", ": found ", "allowed ", limit}) EXPECT_THAT(message, HasSubstr(word));
        EXPECT_TRUE(std::ranges::any_of(outcome_->errors, [&](const auto& error) { return error.line() == message; })) << message;
    }
    EXPECT_TRUE(asset("cubemap").at("failures")[0].contains("mip"));
    EXPECT_TRUE(asset("lut").at("failures")[0].contains("m"));
    EXPECT_TRUE(asset("dominant").at("failures")[0].contains("view"));
}

/// The place's own error is the figure that it explains.
TEST_F(Failures, PlacesOfTheWorstSampleHaveItsError) {
    int places = 0;
    for (const Json& row : outcome_->report.at("assets"))
        for (const Json& stage : row.at("stages"))
            for (const char* shading : {"diffuse", "specular"}) {
                const Json& error = stage.at("error").at(shading);
                for (const auto& [key, figure] : {std::pair("sampled_at", "max_sampled"), std::pair("bound_at", "max_bound")}) {
                    if (!error.contains(key)) continue;
                    ++places;
                    EXPECT_DOUBLE_EQ(error.at(key).value("local", 0.0), error.at(figure).get<double>())
                        << row.at("name") << ' ' << stage.at("name") << ' ' << shading << ' ' << key;
                }
            }
    EXPECT_GT(places, 20);
}

TEST_F(Failures, AreOnThePage) {
    const std::string page = formats::contentOf(*scene_ / "out/report.html");
    for (const Json& row : outcome_->report.at("assets"))
        for (const Json& failure : row.value("failures", Json::array()))
            EXPECT_THAT(page, HasSubstr("<li>" + failure.at("message").get<std::string>()));
}

/// A row over all of its limits by so little that three digits do not show it.
ReportRow rowOverLimits(AssetKind kind) {
    ReportRow row;
    row.name = "a";
    row.kind = kind;
    verify::StageError stage;
    stage.name = "total";
    stage.diffuse.relRms = 0.10000001;
    stage.diffuse.visible.emplace();
    stage.diffuse.visible->p99 = 5.0001;
    stage.diffuse.visible->bound = 70.00002;
    row.verdict = makeVerdict({stage}, {{Limit::Error, 0.1}, {Limit::Visible, 5}, {Limit::VisibleBound, 70}});
    return row;
}

TEST(LimitNames, AreThoseOfTheSceneFileOrOfTheCommand) {
    const auto lines = [](AssetKind kind, LimitsFrom from) {
        std::vector<std::string> details;
        for (const Failure& failure : failuresOf(rowOverLimits(kind), from)) details.push_back(failure.detail);
        return details;
    };
    EXPECT_THAT(lines(AssetKind::Mesh, LimitsFrom::SceneFile),
                ElementsAre("found rel_rms 0.10000001, expected at most 0.1 (max_error)",
                            "found a visible error of 5.0001 (p99), expected at most 5 (max_visible)",
                            "found a visible error of up to 70.00002 (proven bound), expected at most 70 (max_visible_bound)"));
    EXPECT_THAT(lines(AssetKind::Cubemap, LimitsFrom::SceneFile),
                ElementsAre(HasSubstr("(max_converter_error)"), HasSubstr("(max_visible of the asset, or max_converter_visible)"), _));
    EXPECT_THAT(lines(AssetKind::Cubemap, LimitsFrom::Converter),
                ElementsAre(HasSubstr("(--max-error)"), HasSubstr("(--max-visible)"), HasSubstr("(--max-visible-bound)")));
}

/// A light map over a limit of 5 on visible errors, of which 12.34 is the largest.
ReportRow mapOverLimit() {
    ReportRow row = rowOverLimits(AssetKind::LightMap);
    row.layout = "basis-4";
    row.bytesGpu = 4096;
    verify::StageError& stage = row.verdict.stages[0];
    stage.specular.visible.emplace().p99 = 12.34;
    row.verdict = makeVerdict({stage}, {{Limit::Visible, 5}});
    return row;
}
std::string adviceOf(const ReportRow& row) {
    const std::vector<Failure> failures = failuresOf(row, LimitsFrom::SceneFile);
    for (const Failure& failure : failures) {
        EXPECT_EQ(failure.message, fmt::format("{}: {}. {}", failure.subject, failure.detail, failure.advice));
        EXPECT_EQ(errorsOf({failure})[0].line(), failure.message);
    }
    return failures.back().advice;
}

TEST(FailureAdvice, NamesTheSmallestLayoutThatKeptTheLimitAndWhatItCosts) {
    ReportRow row = mapOverLimit();
    EXPECT_EQ(adviceOf(row), "light_map_layout = \"auto\" takes the smallest layout that keeps the limit. A limit of 12.4 allows it.");
    const auto tried = [](const char* layout, std::uint64_t bytes, double visible, bool isExcluded = false) {
        return TrialCandidate{layout, bytes, 1, 0, 0, 1, visible, 1, 1, 0, isExcluded};
    };
    row.trialCandidates = {tried("basis-4", 4096, 12), tried("godot", 5000, 1, true), tried("basis-8", 6144, 4.5), tried("raw", 9000, 1)};
    EXPECT_EQ(adviceOf(row),
              "light_map_layout = \"basis-8\" keeps the limit (visible error 4.5 when it was tried, 2.00 KiB more). A limit of 12.4 "
              "allows it.");
    row.trialCandidates = {tried("basis-4", 4096, 12), tried("basis-8", 6144, 7.5)};
    EXPECT_THAT(adviceOf(row), StartsWith("No layout keeps the limit: the least is that of basis-8 (visible error 7.5 when"));
    row.trialCandidates = {tried("basis-3", 3072, 23), tried("basis-4", 4096, 12)};
    EXPECT_EQ(adviceOf(row), "No layout has less. A limit of 12.4 allows it.");
    row.trialCandidates = {tried("basis-4", 4096, 12)};
    EXPECT_EQ(
        adviceOf(row),
        "No other layout is allowed: light_map_layout = \"auto\" takes the smallest that keeps the limit. A limit of 12.4 allows it.");
    row.trialCandidates = {tried("basis-4", 4096, 4.9)};
    EXPECT_EQ(
        adviceOf(row),
        "basis-4 kept the limit (visible error 4.9 when it was tried): a lower limit takes a larger layout. A limit of 12.4 allows it.");
    row.trialCandidates = {tried("basis-3", 3072, 23), tried("basis-4", 4096, 12)};
    row.trialCandidates->push_back(tried("hdr-2", 8192, 4.5, true));
    EXPECT_THAT(adviceOf(row), StartsWith("hdr-2, which layouts leaves out, keeps the limit (visible error 4.5 when"));
    row.layout = "godot";
    row.trialCandidates.reset();
    EXPECT_EQ(adviceOf(row), "A limit of 12.4 allows it.") << "the engine reads no other layout";
}

/// A seam is made by one side of the edge. Its cause, the layouts that were verified, and the way out stand under it.
TEST(FailureAdvice, NamesTheSideThatMakesASeamAndTheLayoutsThatWereVerified) {
    ReportRow row;
    row.name = "a";
    row.layout = "basis-4";
    row.width = row.height = 64;
    row.bytesGpu = 4096;
    row.key = 0.5;
    row.filter = formats::LightMapFilter::Decoded;
    SeamFigures& seams = row.seams.emplace();
    seams.stages.push_back({"total", {{1, 12}, {2, 20}}, {}});
    SeamPlace& worst = seams.worst.emplace_back();
    worst.shading = "diffuse";
    worst.texels = {{{1.5, 2}, {30, 40.25}}};
    worst.reference = {glm::dvec3(0.1), glm::dvec3(0.11)};
    worst.found = {glm::dvec3(0.1), glm::dvec3(0.11, 0.05, 0.11)};
    row.verdict = makeVerdict({verify::StageError()}, {{Limit::Seam, 5}});
    row.verdict.passed = false;
    const std::string cause =
        "The worst step is made at texel (30.0, 40.2), whose light is off by 0.06, 12.0 % of the map's key; it is dark there, where little "
        "light shows. ";
    EXPECT_EQ(adviceOf(row),
              cause +
                  "light_map_layout = \"auto\" takes the smallest layout that keeps the limit, or that of the smallest seam. A "
                  "limit of 12 allows it.");
    row.trialCandidates = {TrialCandidate{"basis-4", 4096}, TrialCandidate{"basis-8", 5120}};
    (*row.trialCandidates)[0].seam = 12;
    const std::string raw =
        "light_map_layout = \"raw\" with filter = \"decoded\" has the half floats of the bake, and next to no step (284.50 KiB more). ";
    EXPECT_EQ(adviceOf(row), cause + "No layout that was verified has less. " + raw + "A limit of 12 allows it.");
    (*row.trialCandidates)[1].seam = 7.5;
    EXPECT_THAT(adviceOf(row), HasSubstr("the least is that of basis-8 (a seam of 7.5 when it was verified, 1.00 KiB more). "));
    row.filter = formats::LightMapFilter::Hardware;
    worst.reference = {glm::dvec3(0.1), glm::dvec3(1)};
    worst.found = {glm::dvec3(0.1), glm::dvec3(0.9)};
    EXPECT_THAT(adviceOf(row),
                StartsWith("The worst step is made at texel (30.0, 40.2), whose light is off by 0.1, 20.0 % of the map's key. The "
                           "sampler reads texels beside charts: filter = \"decoded\" leaves them out (512 bytes more"));
}

TEST(FailureAdvice, NamesTheBudgetThatKeepsALimitOnTheWhole) {
    ReportRow row = mapOverLimit();
    row.verdict.limits = {};
    row.trialCandidates = {TrialCandidate{"basis-3", 1500}, TrialCandidate{"basis-4", 2500}};
    row.whole.emplace().visible.p99 = 6.1;
    row.whole->limits[Limit::WholeVisible] = 5;
    const std::vector<FrontierPoint> frontier = {
        {2000, 6.1, true, {{"a", "basis-3"}}}, {5000, 4.9, false, {{"a", "basis-4+lit@5.65685"}}}, {9000, 3, false, {{"a", "raw"}}}};
    EXPECT_EQ(failuresOf(row, LimitsFrom::SceneFile, nullptr, frontier).back().advice,
              "A budget of 5 KiB keeps it (a: basis-4, detail above 5.7). A limit of 6.1 allows it.");
}

TEST(FailureAdvice, NamesAChartOfFewTexelsAsTheCause) {
    ReportRow row = mapOverLimit();
    row.charts.emplace().few = {{"specular", 3, "Give the chart more texels."}};
    EXPECT_THAT(adviceOf(row), StartsWith("Give the chart more texels. light_map_layout"));
}

TEST(FailureAdvice, NamesWhatADominantLightAndTablesLack) {
    ReportRow map = mapOverLimit(), light = mapOverLimit();
    light.kind = AssetKind::Dominant;
    light.name = "a_dominant";
    light.bytesGpu = 1024;
    light.notes = Json::object({{"fit", "explained"}});
    const auto adviceBeside = [&](const ReportRow& row) { return failuresOf(row, LimitsFrom::SceneFile, &map).back().advice; };
    EXPECT_EQ(adviceBeside(light), "dominant_layout = \"derived\" has no textures to err (1.00 KiB less). A limit of 12.4 allows it.");
    light.notes = Json::object({{"fit", "halo3"}});
    EXPECT_EQ(adviceBeside(light), "A limit of 12.4 allows it.") << "the shader derives no other fit";
    ReportRow tables = mapOverLimit();
    tables.kind = AssetKind::Lut;
    tables.width = 8;
    tables.bytesGpu = 1536;
    EXPECT_EQ(adviceOf(tables), "views = 24 in [tables] in place of 8 takes 3.00 KiB more. A limit of 12.4 allows it.");
}

/// Nothing that fails a verdict may be without a failure: the error lines and the exit code come from these.
TEST(LimitNames, AnInfiniteBoundIsOverItsLimit) {
    ReportRow row;
    row.name = "a";
    verify::StageError stage;
    stage.name = "total";
    stage.diffuse.visible.emplace().bound = HUGE_VAL;
    row.verdict = makeVerdict({stage}, {{Limit::Error, 0.1}, {Limit::VisibleBound, 70}});
    ASSERT_FALSE(row.verdict.passed);
    const std::vector<Failure> failures = failuresOf(row, LimitsFrom::SceneFile);
    ASSERT_EQ(failures.size(), 1u);
    EXPECT_EQ(failures[0].message,
              "a, stage total, diffuse: found a visible error of up to inf (proven bound), expected at most 70 (max_visible_bound)");
}

TEST(PlaceWords, TolerateWhatTheyDoNotKnow) {
    EXPECT_EQ(placeWords(Json()), "");
    EXPECT_EQ(placeWords(parseJson(R"({"texel": [3, 4.5], "channel": "red", "f0": 0.04})")), "texel (3, 4.5), red, F0 0.04");
    EXPECT_EQ(placeWords(parseJson(R"({"texel": {"x": 3}, "channel": 7, "normal": ["up"]})")), "channel 7, normal (nan)");
}

}  // namespace
}  // namespace lightcook::pipeline

#include "pipeline/assets/verdict.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace lightcook::pipeline {
namespace {

verify::StageError stageWith(double diffuse, double specular) {
    verify::StageError stage;
    stage.name = "total";
    stage.diffuse.relRms = diffuse;
    stage.specular.relRms = specular;
    return stage;
}

TEST(Verdict, HoldsTheLastStageToTheLimit) {
    EXPECT_TRUE(makeVerdict({stageWith(0.5, 0.5), stageWith(0.01, 0.02)}, {{Limit::Error, 0.02}}).passed);
    EXPECT_FALSE(makeVerdict({stageWith(0.01, 0.03)}, {{Limit::Error, 0.02}}).passed);
    EXPECT_FALSE(makeVerdict({}, {{Limit::Error, 0.02}}).passed);
    EXPECT_FALSE(makeVerdict({stageWith(0, 0)}, {{Limit::Error, 0.02}}, {{"here", "one", "two"}}).passed);
}

TEST(Verdict, AFigureThatIsNotFiniteFailsInAnyStage) {
    verify::StageError first = stageWith(0, 0);
    first.diffuse.maxBound = HUGE_VAL;
    EXPECT_FALSE(makeVerdict({first, stageWith(0, 0)}, {{Limit::Error, 0.02}}).passed);
}

TEST(Verdict, IsReadAsItWasWritten) {
    verify::StageError stage = stageWith(0.25, 0.125);
    stage.specular.maxBound = HUGE_VAL;
    stage.diffuse.sampledAt.x = 12;
    stage.diffuse.sampledAt.y = 30.5;
    stage.diffuse.sampledAt.channel = 1;
    stage.diffuse.sampledAt.normal = {0, 0, 1};
    stage.diffuse.sampledAt.reference = 2;
    stage.diffuse.sampledAt.local = 0.5;
    verify::Violation violation{"block", "an error", "none"};
    violation.at.mip = 3;
    violation.at.face = 5;
    const Json json = toJson(makeVerdict({stage}, {{Limit::Error, 0.02}}, {violation}));
    const auto read = fromJson<Verdict>(Json::parse(json.dump()), "record");
    ASSERT_TRUE(read.has_value()) << read.error().line();
    EXPECT_EQ(toJson(*read), json);
    EXPECT_EQ(read->stages[0].specular.maxBound, HUGE_VAL);
    EXPECT_EQ(read->stages[0].diffuse.sampledAt.y, 30.5);
    EXPECT_EQ(read->violations[0].at.face, 5);
    EXPECT_EQ(json["violations"][0]["at"]["face"], "-Z");
    EXPECT_EQ(json["stages"][0]["error"]["diffuse"]["sampled_at"]["channel"], "green");
}

TEST(Verdict, ABoundThatIsNotKnownIsAbsent) {
    verify::StageError stage = stageWith(0.25, 0.125);
    stage.diffuse.maxBound.reset();
    const Verdict verdict = makeVerdict({stage}, {{Limit::Error, 0.5}});
    EXPECT_TRUE(verdict.passed) << "it is no figure that is not finite";
    const Json json = toJson(verdict);
    EXPECT_FALSE(json["stages"][0]["error"]["diffuse"].contains("max_bound"));
    EXPECT_EQ(json["stages"][0]["error"]["specular"]["max_bound"], 0);
    const auto read = fromJson<Verdict>(Json::parse(json.dump()), "record");
    ASSERT_TRUE(read.has_value()) << read.error().line();
    EXPECT_FALSE(read->stages[0].diffuse.maxBound.has_value());
    EXPECT_TRUE(read->stages[0].specular.maxBound.has_value());
    EXPECT_EQ(toJson(*read), json);
}

/// Returns a stage with visible errors of diffuse and of specular light, without bounds.
verify::StageError stageWithVisible() {
    verify::StageError stage = stageWith(0, 0);
    for (verify::ErrorFigures* figures : {&stage.diffuse, &stage.specular}) figures->visible.emplace().p99 = 0.5;
    return stage;
}

TEST(Verdict, ALimitOnTheVisibleBoundHoldsTheLarger) {
    verify::StageError stage = stageWithVisible();
    stage.diffuse.visible->bound = 2;
    stage.specular.visible->bound = 3;
    EXPECT_TRUE(makeVerdict({stage}, {{Limit::Error, 0.02}, {Limit::VisibleBound, 3.0}}).passed);
    EXPECT_FALSE(makeVerdict({stage}, {{Limit::Error, 0.02}, {Limit::VisibleBound, 2.5}}).passed);
    stage.specular.visible.reset();
    EXPECT_TRUE(makeVerdict({stage}, {{Limit::Error, 0.02}, {Limit::VisibleBound, 2.5}}).passed) << "a scene without specular light";
}

TEST(Verdict, ALimitOnAVisibleBoundThatIsNotKnownFails) {
    verify::StageError both = stageWithVisible(), one = stageWithVisible();
    one.diffuse.visible->bound = 2;
    for (const verify::StageError& stage : {both, one, stageWith(0, 0)}) {
        EXPECT_TRUE(makeVerdict({stage}, {{Limit::Error, 0.02}, {Limit::Visible, 1.0}}).passed) << "nothing is asked of the bound";
        const Verdict verdict = makeVerdict({stage}, {{Limit::Error, 0.02}, {Limit::VisibleBound, 9.0}});
        EXPECT_FALSE(verdict.passed);
        ASSERT_EQ(verdict.violations.size(), 1u);
        EXPECT_EQ(verdict.violations[0].place, "stage total");
        EXPECT_EQ(verdict.violations[0].found, "no proven bound of visible errors");
        EXPECT_THAT(verdict.violations[0].expected, testing::HasSubstr("at most 9, as max_visible_bound asks"));
    }
}

TEST(StageWords, SaysTheWordOnce) {
    EXPECT_EQ(stageWords("total"), "stage total");
    EXPECT_EQ(stageWords("residual 1"), "stage residual 1");
    EXPECT_EQ(stageWords("stage 2"), "stage 2");
}

TEST(CheckStage, AResidualThatAddsToTheErrorIsAViolation) {
    verify::StageError code = stageWith(0.1, 0.1), residual = stageWith(0.2, 0.1);
    code.name = "code";
    residual.name = "residual 1";
    std::vector<verify::Violation> violations;
    checkStage({code, residual}, "code", "residual 1", 0, violations);
    ASSERT_EQ(violations.size(), 1u);
    EXPECT_EQ(violations[0].place, "stage residual 1");
    checkStage({code, residual}, "residual 1", "residual 2", 0, violations);
    EXPECT_EQ(violations.size(), 1u);
}

TEST(CheckStage, RoundingOfCodesBesideAnExactStageIsNone) {
    verify::StageError code = stageWith(0, 0), residual = stageWith(1.0 / 255, 1.0 / 255);
    code.name = "code";
    residual.name = "residual 1";
    std::vector<verify::Violation> violations;
    checkStage({code, residual}, "code", "residual 1", 1.0 / 255, violations);
    EXPECT_TRUE(violations.empty());
    residual.specular.relRms *= 1.01;
    checkStage({code, residual}, "code", "residual 1", 1.0 / 255, violations);
    EXPECT_EQ(violations.size(), 1u);
}

}  // namespace
}  // namespace lightcook::pipeline

#include "pipeline/lint/judge.h"

#include <gmock/gmock.h>

#include <string>

namespace lightcook::pipeline {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr int kSwappedChoice = 8;  ///< (x, z, y): Z up

/// Facts of a map of which most texels are lit from behind under every choice of axes.
LightMapFacts litFromBehind(const std::string& bake) {
    LightMapFacts facts;
    facts.reading.bake = bake;
    facts.hasNormals = true;
    facts.coverage.inside = facts.covered = facts.directional = 100;
    facts.behind.fill(60);
    facts.behindInOtherFrame = 60;
    return facts;
}

Finding onlyFinding(const LightMapFacts& facts) {
    const Findings findings = judgeLightMap(Scene{}, LightMapEntry{}, facts);
    EXPECT_EQ(findings.size(), 1u);
    return findings.empty() ? Finding{} : findings.front();
}

TEST(LintJudge, NamesTheFrameBesideAxesThatExplainAsMuch) {
    LightMapFacts facts = litFromBehind("sh9");
    facts.behindInOtherFrame = 0;
    EXPECT_THAT(onlyFinding(facts).found, AllOf(HasSubstr("with frame = \"tangent\" it is 0.0 %"), Not(HasSubstr("x, y, z"))));
    facts.behind[kSwappedChoice] = 0;
    const Finding both = onlyFinding(facts);
    EXPECT_EQ(both.check, LintCheck::WrongFrame);
    EXPECT_THAT(both.found, HasSubstr("with frame = \"tangent\", or with (x,z,y) of the coefficients as x, y, z, it is 0.0 %"));
}

TEST(LintJudge, NamesAxesWhereTheBakeFormatImpliesTheConvention) {
    EXPECT_EQ(formats::BakeAxes::choice(kSwappedChoice).name(), "x,z,y");
    for (const char* bake : {"unity-directional", "bakery-sh", "godot", "deluxe"}) {
        LightMapFacts upward = litFromBehind(bake);  // surfaces that all face up
        upward.hasMeshNormals = true;
        upward.behind[kSwappedChoice] = upward.behindInOtherFrame = 0;
        EXPECT_EQ(onlyFinding(upward).check, LintCheck::WrongAxes) << bake << ": frame = \"tangent\" would be refused";
        LightMapFacts turned = litFromBehind(bake);
        turned.hasMeshNormals = true;
        turned.behind[formats::BakeAxes::kPhaseChoice] = 0;
        const Finding finding = onlyFinding(turned);
        EXPECT_EQ(finding.check, LintCheck::WrongAxes) << bake << ": phase = \"condon-shortley\" would be refused";
        EXPECT_THAT(finding.found, HasSubstr("with axes = \"-x,-y,z\" it is 0.0 %"));
        turned.reading.bake = "sh9";
        EXPECT_EQ(onlyFinding(turned).check, LintCheck::WrongPhase);
    }
}

TEST(LintJudge, OfEqualAxesARotationIsNamed) {
    LightMapFacts floors = litFromBehind("bakery-sh");
    floors.hasMeshNormals = true;
    for (const char* name : {"x,z,y", "-x,z,y", "x,z,-y", "y,z,-x"})
        floors.behind[static_cast<std::size_t>(formats::BakeAxes::fromName(name)->index())] = 0;
    EXPECT_THAT(onlyFinding(floors).found, HasSubstr("with axes = \"x,z,-y\" it is 0.0 %"));
}

TEST(LintJudge, NoteIsWhatMayBeRight) {
    LightMapFacts facts;
    facts.reading.bake = "flat";
    facts.hasCoverage = true;
    facts.coverage.inside = facts.covered = 1000;
    facts.coverage.largest = 1;
    for (const double key : {1e-9, 1e9}) {
        facts.key = key;
        const Finding finding = onlyFinding(facts);
        EXPECT_EQ(finding.check, LintCheck::Exposure);
        EXPECT_TRUE(finding.isNote()) << "a unit of its own";
    }
}

TEST(LintJudge, CoverageThatAFilterRingsInIsNoFault) {
    LightMapFacts facts;
    facts.reading.bake = "flat";
    facts.hasCoverage = true;
    facts.coverage.inside = facts.covered = 1000;
    facts.key = 1;
    facts.coverage.smallest = -0.2;
    facts.coverage.largest = 1.2;
    EXPECT_TRUE(judgeLightMap(Scene{}, LightMapEntry{}, facts).empty());
    facts.coverage.largest = 2;
    EXPECT_EQ(onlyFinding(facts).check, LintCheck::CoverageRange);
}

TEST(LintJudge, BandsThatNothingExplainsAreNamedBeyondTheNoiseOfFilters) {
    LightMapFacts facts;
    facts.reading.bake = "sh9";
    facts.hasCoverage = facts.hasNormals = true;
    facts.coverage.inside = facts.covered = facts.bands.texels = 1000;
    facts.coverage.largest = 1;
    facts.key = 1;
    facts.bands.otherQuantity = facts.bands.decoded = 900;
    facts.bands.asDescribed = 50;
    EXPECT_TRUE(judgeLightMap(Scene{}, LightMapEntry{}, facts).empty());
    facts.bands.asDescribed = 51;
    EXPECT_EQ(onlyFinding(facts).check, LintCheck::ImpossibleBands);
    facts.bands.asDescribed = 6;
    facts.bands.otherQuantity = 5;
    EXPECT_EQ(onlyFinding(facts).check, LintCheck::WrongQuantity) << "few that another reading explains";
}

TEST(LintJudge, NamesDirectionsThatNoLightHasWhereMostTexelsHaveThem) {
    LightMapFacts facts;
    facts.reading.bake = "bakery-mono-sh";
    facts.hasCoverage = true;
    facts.coverage.inside = facts.covered = facts.directional = 120;
    facts.coverage.largest = 1;
    facts.black = 20;
    facts.key = 1;
    facts.tooDirected = 51;
    const Finding finding = onlyFinding(facts);
    EXPECT_EQ(finding.check, LintCheck::ImpossibleDirections);
    EXPECT_THAT(finding.found, HasSubstr("in 51.0 % of 100 lit texels"));
    facts.tooDirected = 50;
    EXPECT_TRUE(judgeLightMap(Scene{}, LightMapEntry{}, facts).empty());
}

}  // namespace
}  // namespace lightcook::pipeline

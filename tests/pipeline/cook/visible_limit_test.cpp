// Limits on the visible error of light maps, and the display that they are judged on.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>

#include "pipeline/cook/cook.h"
#include "pipeline/cook/integrity.h"
#include "pipeline/manifest/manifest.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using testing::AllOf;
using testing::HasSubstr;

class VisibleLimit : public testing::Test {
protected:
    Outcome cook(const std::string& output, const std::string& root = "") const {
        scene_.writeSceneFile(output, "", root);
        return cookScene(scene_.options(), RunState());
    }
    static const Json& mapOf(const Outcome& outcome) { return outcome.report.at("assets").at(0); }
    /// Returns the larger p99 of the last stage.
    static double visibleOf(const Outcome& outcome) {
        const Json& error = mapOf(outcome).at("stages").back().at("error");
        return std::max(error.at("diffuse").at("visible").at("p99").get<double>(),
                        error.at("specular").at("visible").at("p99").get<double>());
    }

    SmallScene scene_{SmallScene::Parts::LightMap};
};

TEST_F(VisibleLimit, FailsAMapThatIsOverItAndNamesTheWorstPlace) {
    const Outcome outcome = cook("light_map_layout = \"ratio\"\nmax_visible = 0.01");
    ASSERT_FALSE(outcome.errors.empty());
    EXPECT_EQ(outcome.errors.front().code, ErrorCode::OverLimit);
    EXPECT_THAT(outcome.errors.front().line(), AllOf(HasSubstr("map, stage total, "), HasSubstr("found a visible error of "),
                                                     HasSubstr("(p99), expected at most 0.01 (max_visible); worst at texel ("),
                                                     HasSubstr("normal ("), HasSubstr("): found ("), HasSubstr("a difference of ")));
    EXPECT_FALSE(mapOf(outcome).at("passed").get<bool>());
    EXPECT_EQ(mapOf(outcome).at("limit").at("max_visible"), 0.01);
    EXPECT_GT(mapOf(outcome).at("failures").at(0).at("visible").get<double>(), 0.01);
}

TEST_F(VisibleLimit, GetsTheSmallestLayoutThatKeepsItAndTheLimitOnTheRms) {
    std::uint64_t before = ~std::uint64_t{0};
    for (const double limit : {0.3, 1.0, 4.0}) {
        const Outcome outcome = cook(fmt::format("max_visible = {}", limit));
        for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
        EXPECT_LE(visibleOf(outcome), limit);
        const auto bytes = mapOf(outcome).at("bytes_gpu").get<std::uint64_t>();
        EXPECT_LE(bytes, before) << "a looser limit never takes more";
        before = bytes;
        std::uint64_t smallest = ~std::uint64_t{0};
        for (const Json& candidate : mapOf(outcome).at("trial_candidates"))
            if (std::max(candidate.at("visible_diffuse").get<double>(), candidate.at("visible_specular").get<double>()) <= limit &&
                std::max(candidate.at("diffuse").get<double>(), candidate.at("specular").get<double>()) <= 0.1)
                smallest = std::min(smallest, candidate.at("bytes_gpu").get<std::uint64_t>());
        EXPECT_GE(bytes, smallest) << "places between texels may need a larger one than the trial's texel centres";
    }
}

TEST_F(VisibleLimit, OnTheProvenBoundFailsAMapAndNamesItsPlace) {
    const Outcome outcome = cook("light_map_layout = \"ratio\"\nmax_visible_bound = 0.02");
    ASSERT_FALSE(outcome.errors.empty());
    EXPECT_EQ(outcome.errors.front().code, ErrorCode::OverLimit);
    EXPECT_THAT(outcome.errors.front().line(),
                AllOf(HasSubstr("(proven bound), expected at most 0.02 (max_visible_bound); largest at texel ("), HasSubstr("normal ("),
                      HasSubstr("found (")));
    EXPECT_EQ(mapOf(outcome).at("limit").at("max_visible_bound"), 0.02);
    EXPECT_FALSE(mapOf(outcome).at("limit").contains("max_visible"));
    for (const char* shading : {"diffuse", "specular"}) {
        const Json& visible = mapOf(outcome).at("stages").back().at("error").at(shading).at("visible");
        EXPECT_GE(visible.at("bound").get<double>(), visible.at("max").get<double>());
        EXPECT_TRUE(visible.contains("bound_at"));
    }
    EXPECT_TRUE(cook("light_map_layout = \"ratio\"\nmax_visible_bound = 1e6").errors.empty());
}

using VisibleLimitSoak = VisibleLimit;
/// The verification refutes layouts that the trial takes for fine. Their textures have names that those of the chosen one have too.
TEST_F(VisibleLimitSoak, OnTheProvenBoundLeavesTheTexturesOfTheChosenLayoutHoweverOftenItCooks) {
    for (int run = 0; run < 3; ++run) {
        const Outcome outcome = cook("light_map_layout = \"auto\"\nmax_visible_bound = 0.5");
        ASSERT_TRUE(outcome.report.is_object());
        const auto manifest = loadManifest(scene_ / "out");
        ASSERT_TRUE(manifest.has_value());
        for (const formats::Error& error : checkDigests(scene_ / "out", *manifest)) ADD_FAILURE() << run << ": " << error.line();
    }
}

TEST_F(VisibleLimit, IsFiveForAutoWithoutAnotherLimit) {
    EXPECT_EQ(mapOf(cook("light_map_layout = \"auto\"")).at("limit").at("max_visible"), 5.0);
    EXPECT_FALSE(mapOf(cook("light_map_layout = \"auto\"\nmax_error = 0.02")).at("limit").contains("max_visible"));
    EXPECT_FALSE(mapOf(cook("light_map_layout = \"ratio\"")).at("limit").contains("max_visible"));
}

TEST_F(VisibleLimit, OfALightMapOverridesThatOfTheOutputAndTheCommandLineBoth) {
    scene_.writeSceneFile("light_map_layout = \"ratio\"\nmax_visible = 50");
    std::string text = formats::contentOf(scene_.sceneFile());
    text.replace(text.find("file = \"map.exr\""), 0, "max_visible = 40\n");
    formats::writeContent(scene_.sceneFile(), text);
    CookOptions options = scene_.options();
    EXPECT_EQ(mapOf(cookScene(options, RunState())).at("limit").at("max_visible"), 40.0);
    options.given.set("output.max_visible", 30);
    EXPECT_EQ(mapOf(cookScene(options, RunState())).at("limit").at("max_visible"), 30.0);
}

TEST_F(VisibleLimitSoak, IsJudgedOnTheDisplayOfTheScene) {
    const std::string output = "light_map_layout = \"basis-3\"\nmax_error = 0.9";
    const double usual = visibleOf(cook(output)), dark = visibleOf(cook(output + "\n[display]\nstops = -8")),
                 inALitRoom = visibleOf(cook(output + "\n[display]\nblack = 20")),
                 white = visibleOf(cook(output + "\n[display]\nwhite = 1e4"));
    EXPECT_GT(usual, 0.1);
    EXPECT_LT(dark, 0.5 * usual);
    EXPECT_LT(inALitRoom, usual);
    EXPECT_LT(white, 0.1 * usual);
}

/// Cooks of the scene with a probe and a gradient, of one kind of asset each.
class VisibleLimitOfOthers : public testing::Test {
protected:
    Outcome cook(const std::string& kind, const std::string& output) const {
        scene_.writeSceneFile(output);
        CookOptions options = scene_.options();
        options.onlyKind = kind;
        return cookScene(options, RunState());
    }
    static const Json& specularOf(const Outcome& outcome) {
        return outcome.report.at("assets").at(0).at("stages").back().at("error").at("specular").at("visible");
    }

    SmallScene scene_{SmallScene::Parts::All};
};

TEST_F(VisibleLimitOfOthers, FailsEachKindAndNamesThePlaceAndBothColours) {
    for (const auto& [kind, place] : {std::pair("cubemap", "worst at mip "), std::pair("rsrm", "worst at texel ("),
                                      std::pair("lut", "worst at texel ("), std::pair("dominant", "worst at texel (")}) {
        const Outcome outcome = cook(kind, "light_map_layout = \"ratio\"\nmax_converter_visible = 0.0001");
        ASSERT_FALSE(outcome.errors.empty()) << kind;
        EXPECT_EQ(outcome.errors.front().code, ErrorCode::OverLimit);
        const std::string line = outcome.errors.back().line();
        EXPECT_THAT(line, AllOf(HasSubstr("found a visible error of "), HasSubstr("(p99), expected at most 0.0001 (max_"), HasSubstr(place),
                                HasSubstr(": found ("), HasSubstr("expected ("), HasSubstr("a difference of ")))
            << kind;
        EXPECT_EQ(line.find(", face ") != std::string::npos, kind == std::string("cubemap")) << line;
        EXPECT_EQ(outcome.report.at("assets").at(0).at("limit").at("max_visible"), 0.0001) << kind;
        EXPECT_GT(specularOf(outcome).at("p99").get<double>(), 0.0001) << kind;
        EXPECT_GE(specularOf(outcome).at("bound").get<double>(), specularOf(outcome).at("max").get<double>()) << kind;
        EXPECT_TRUE(specularOf(outcome).contains("bound_at")) << kind;
    }
}

TEST_F(VisibleLimitOfOthers, OnTheProvenBoundFailsEachKind) {
    for (const char* kind : {"cubemap", "rsrm", "lut", "dominant"}) {
        const Outcome outcome = cook(kind, "light_map_layout = \"ratio\"\nmax_converter_visible_bound = 0.0001");
        ASSERT_FALSE(outcome.errors.empty()) << kind;
        EXPECT_EQ(outcome.errors.front().code, ErrorCode::OverLimit);
        EXPECT_THAT(outcome.errors.back().line(),
                    AllOf(HasSubstr("found a visible error of up to "), HasSubstr("(proven bound), expected at most 0.0001 ("),
                          HasSubstr("max_converter_visible_bound); largest at ")))
            << kind;
        EXPECT_EQ(outcome.report.at("assets").at(0).at("limit").at("max_visible_bound"), 0.0001) << kind;
    }
    const Outcome outcome = cook("dominant", "light_map_layout = \"ratio\"\nmax_visible_bound = 0.0001");
    EXPECT_TRUE(outcome.errors.empty()) << "a limit of light maps and meshes";
    EXPECT_FALSE(outcome.report.at("assets").at(0).at("limit").contains("max_visible_bound"));
}

TEST_F(VisibleLimitOfOthers, OfAnAssetOverridesThatOfTheOutputAndTheCommandLineBoth) {
    scene_.writeSceneFile("max_converter_visible = 50");
    std::string text = formats::contentOf(scene_.sceneFile());
    text.replace(text.find("file = \"sky.exr\""), 0, "max_visible = 40\n");
    formats::writeContent(scene_.sceneFile(), text);
    CookOptions options = scene_.options();
    options.onlyKind = "rsrm";
    const auto limit = [&] { return cookScene(options, RunState()).report.at("assets").at(0).at("limit").at("max_visible"); };
    EXPECT_EQ(limit(), 40.0);
    options.given.set("output.max_converter_visible", 30);
    EXPECT_EQ(limit(), 30.0);
    text.replace(text.find("max_visible = 40\n"), 0, "max_visible_bound = 700\n");
    formats::writeContent(scene_.sceneFile(), text);
    const auto bound = [&] { return cookScene(options, RunState()).report.at("assets").at(0).at("limit").at("max_visible_bound"); };
    EXPECT_EQ(bound(), 700.0);
    options.given.set("output.max_visible_bound", 800);
    EXPECT_EQ(bound(), 700.0) << "a limit of light maps and meshes";
    options.given.set("output.max_converter_visible_bound", 900);
    EXPECT_EQ(bound(), 900.0);
}

TEST_F(VisibleLimitOfOthers, IsJudgedOnTheDisplayOfTheScene) {
    const double usual = specularOf(cook("rsrm", "")).at("rms").get<double>(),
                 dark = specularOf(cook("rsrm", "[display]\nstops = -8")).at("rms").get<double>();
    EXPECT_GT(usual, 0.01);
    EXPECT_LT(dark, usual);
}

TEST_F(VisibleLimit, SettingsOutOfRangeAreRefusedByName) {
    const auto lineOf = [&](const std::string& output) {
        const Outcome outcome = cook(output);
        EXPECT_FALSE(outcome.errors.empty()) << output;
        EXPECT_EQ(outcome.errors.at(0).code, ErrorCode::InvalidRequest);
        return outcome.errors.at(0).line();
    };
    EXPECT_THAT(lineOf("max_visible = 0"), HasSubstr("found 0 for output.max_visible, expected a positive number of just noticeable"));
    EXPECT_THAT(lineOf("max_visible = \"2%\""), HasSubstr("for output.max_visible"));
    EXPECT_THAT(lineOf("max_converter_visible = -1"), HasSubstr("found -1 for output.max_converter_visible, expected a positive number"));
    EXPECT_THAT(lineOf("max_visible = 2\n[display]\nblack = 0"), HasSubstr("found 0 for display.black, expected a luminance from 0.005"));
    EXPECT_THAT(lineOf("max_visible = 2\n[display]\nwhite = -1"),
                HasSubstr("found -1 for display.white, expected a positive exit radiance"));
    for (const char* white : {"1e-320", "1e10"})
        EXPECT_THAT(lineOf(fmt::format("max_visible = 2\n[display]\nwhite = {}", white)),
                    HasSubstr("for display.white, expected a positive exit radiance, from 1e-09 to 1e+09"));
    EXPECT_THAT(lineOf("max_visible = 2\n[display]\nstops = 21"),
                HasSubstr("found 21 for display.stops, expected a number from -20 to 20"));
    EXPECT_THAT(lineOf("max_visible = 2\n[display]\nwhit = 1"), HasSubstr("nearest is 'white'"));
}

}  // namespace
}  // namespace lightcook::pipeline

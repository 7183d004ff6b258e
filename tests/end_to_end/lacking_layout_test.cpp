// What a scene needs and a layout lacks counts as error: a flat map of a scene with normal maps or specular materials fails its limit and
// says why, whatever asked for it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/light_map_layout.h"
#include "pipeline/command/converter.h"
#include "pipeline/report/report.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

using testing::HasSubstr;

class LackingLayout : public testing::Test {
protected:
    /// Cooks the light map with an [output] and materials.
    Outcome cook(const std::string& output, const std::string& materials) {
        scene_.writeSceneFile(output, materials);
        const RunState state;
        return cookScene(scene_.options(), state);
    }
    static std::string needs(bool normalMap, bool specular) {
        return fmt::format("[[material]]\nname = \"*\"\nnormal_map = {}\nspecular = {}\n", normalMap, specular);
    }
    /// Returns the figures of the light map's last stage.
    static Json errorOf(const Outcome& outcome) { return outcome.report.at("assets")[0].at("stages").back().at("error"); }

    SmallScene scene_{SmallScene::Parts::LightMap, sunAndSky, 24};
};

TEST_F(LackingLayout, FlatFailsItsLimitWhereMaterialsNeedDirections) {
    for (const auto& [normalMap, specular] : {std::pair(true, true), std::pair(true, false), std::pair(false, true)}) {
        const Outcome outcome = cook("max_error = 0.1\nlight_map_layout = \"flat\"\n", needs(normalMap, specular));
        ASSERT_FALSE(outcome.errors.empty()) << normalMap << specular;
        EXPECT_EQ(outcome.errors.front().code, formats::ErrorCode::OverLimit);
        EXPECT_EQ(outcome.errors.front().line(),
                  "map, layout flat: found a layout without directions: normal maps see one radiance a texel, specular light a grey sky, "
                  "expected a layout that has it, or materials that do not need it (normal_map = false, specular = false)");
        EXPECT_FALSE(outcome.report.at("passed").get<bool>());
        EXPECT_GT(errorOf(outcome).at("diffuse").at("rel_rms").get<double>(), 0.1);
        EXPECT_EQ(errorOf(outcome).at("specular").at("rel_rms").get<double>() > 0.1, specular);
        EXPECT_GT(errorOf(outcome).at("diffuse").at("max_bound").get<double>(),
                  errorOf(outcome).at("diffuse").at("max_sampled").get<double>());
        EXPECT_GT(outcome.report.at("whole").at("rel_rms").get<double>(), 0.1) << "the whole shading counts it, too";
    }
}

TEST_F(LackingLayout, FlatIsExactWhereNothingNeedsDirections) {
    const Outcome outcome = cook("max_error = 0.02\nlight_map_layout = \"flat\"\n", needs(false, false));
    for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
    EXPECT_LT(errorOf(outcome).at("diffuse").at("rel_rms").get<double>(), 0.02);
}

TEST_F(LackingLayout, AutoNeverPicksALayoutWhoseLossItHasNotMeasured) {
    for (const double limit : {0.5, 0.02, 0.004}) {
        const Outcome outcome = cook(fmt::format("max_error = {}\nlight_map_layout = \"auto\"\n", limit), needs(true, true));
        for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
        const std::string layout = outcome.report.at("assets")[0].at("layout");
        EXPECT_NE(layout, "flat");
        EXPECT_LE(errorOf(outcome).at("specular").at("rel_rms").get<double>(), limit);
    }
}

TEST_F(LackingLayout, ABandThatIsMissingIsNamedWhereTheLimitIsMissed) {
    for (const formats::LightMapLayoutInfo& layout : formats::allLightMapLayouts()) {
        if (layout.isFlat() || layout.lacks.empty() || layout.isInTangentSpace) continue;
        const Outcome outcome = cook(fmt::format("max_error = 0.002\nlight_map_layout = \"{}\"\n", layout.name), needs(true, true));
        ASSERT_FALSE(outcome.errors.empty()) << layout.name;
        EXPECT_EQ(outcome.errors.front().code, formats::ErrorCode::OverLimit);
        EXPECT_THAT(outcome.errors.front().line(), HasSubstr(fmt::format("a layout without {}, expected", layout.lacks)));
    }
}

TEST_F(LackingLayout, AutoIsNoAdviceWhereItChose) {
    const Outcome outcome = cook("max_error = 0.002\nlight_map_layout = \"auto\"\nlayouts = [\"sh4\"]\n", needs(true, true));
    ASSERT_FALSE(outcome.errors.empty());
    EXPECT_THAT(outcome.errors.front().line(), HasSubstr("layout sh4: found a layout without band 2"));
    EXPECT_THAT(outcome.errors.front().line(), testing::Not(HasSubstr("auto")));
}

TEST_F(LackingLayout, TheConverterTakesTheNeedsOfTheSurfaces) {
    Conversion options{"lightmap", scene_ / "map.exr", scene_ / "single"};
    options.cook.cache = LIGHTCOOK_TEST_CACHE;
    options.cook.given.set("output.light_map_layout", "flat");
    options.cook.given.set("output.max_error", 0.1);
    const RunState state;
    Outcome outcome = convert(options, state);
    ASSERT_FALSE(outcome.errors.empty());
    EXPECT_EQ(outcome.errors.front().code, formats::ErrorCode::OverLimit);
    EXPECT_THAT(outcome.errors.front().line(), HasSubstr("layout flat: found a layout without directions"));
    for (const char* unneeded : {"material.normal_map", "material.specular"}) options.cook.given.set(unneeded, false);
    outcome = convert(options, state);
    for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
}

}  // namespace
}  // namespace lightcook::pipeline

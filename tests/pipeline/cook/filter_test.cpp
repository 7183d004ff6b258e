// `filter` of a scene: whether the hardware filters light maps, or the shader, after it has decoded them.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "formats/layout_cost.h"
#include "formats/light_map_layout.h"
#include "pipeline/cook/cook.h"
#include "pipeline/manifest/manifest.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

using formats::LightMapFilter;
using testing::HasSubstr;

class SceneFilter : public testing::Test {
protected:
    Outcome cook(const std::string& output) const {
        scene_.writeSceneFile(output);
        return cookScene(scene_.options(), RunState());
    }
    Json manifest() const { return *readManifest(scene_.options().output); }
    static std::string firstError(const Outcome& outcome) { return outcome.errors.empty() ? "" : outcome.errors.front().line(); }

    SmallScene scene_{SmallScene::Parts::LightMap};
};

TEST_F(SceneFilter, ADecodedMapHasACoverageAndErrsNoMoreOnItsSurface) {
    for (const char* layout : {"ratio", "basis-4", "basis-8", "hdr", "lit", "lit-half", "lit-quarter"}) {
        const Outcome outcome = cook(std::string("filter = \"decoded\"\nlight_map_layout = \"") + layout + "\"");
        ASSERT_EQ(firstError(outcome), "") << layout;
        const Json cooked = manifest(), map = cooked.at("assets").at(0);
        EXPECT_EQ(map.at("filter"), "decoded");
        bool hasCoverage = false;
        for (const Json& texture : map.at("textures")) {
            EXPECT_EQ(texture.at("sampler").at("filter"), "nearest") << texture.at("role");
            hasCoverage = hasCoverage || texture.at("role") == "coverage";
        }
        EXPECT_TRUE(hasCoverage);
        const Json& total = outcome.report.at("assets").at(0).at("stages").back();
        const auto relRmsOf = [](const Json& error) { return error.at("diffuse").at("rel_rms").get<double>(); };
        EXPECT_LE(relRmsOf(total.at("error")), relRmsOf(total.at("at_texels"))) << layout;
    }
}

TEST_F(SceneFilter, WithoutItWhatIsNotLinearIsDecodedFirstUnlessFetchesAreDear) {
    const auto filterUnder = [&](const std::string& output) {
        EXPECT_EQ(firstError(cook(output)), "") << output;
        return manifest().at("assets").at(0).at("filter").get<std::string>();
    };
    for (const char* layout : {"ratio", "sh4", "basis-3", "lit-half"})
        EXPECT_EQ(filterUnder(fmt::format("max_error = 0.9\nlight_map_layout = \"{}\"", layout)), "decoded") << layout;
    for (const char* layout : {"raw", "hdr", "godot", "halo3"})
        EXPECT_EQ(filterUnder(fmt::format("max_error = 0.9\nlight_map_layout = \"{}\"", layout)), "hardware") << layout;
    EXPECT_EQ(filterUnder("light_map_layout = \"ratio\"\nmax_fetches = 40"), "decoded");
    EXPECT_EQ(filterUnder("light_map_layout = \"ratio\"\nmax_fetches = 39"), "hardware");
    EXPECT_EQ(filterUnder("light_map_layout = \"ratio\"\nmax_decode_ops = 300"), "hardware");
    EXPECT_EQ(filterUnder("light_map_layout = \"ratio\"\nmips = true"), "hardware") << "a sampler mixes the levels";
    EXPECT_EQ(filterUnder("layouts = [\"ratio\"]\nmax_visible = 5\ncost = \"taps\""), "hardware");
}

TEST_F(SceneFilter, AutoMeasuresTheLayoutsThatHaveIt) {
    const auto candidatesOf = [&](const std::string& output) {
        const Outcome outcome = cook(output);
        EXPECT_EQ(firstError(outcome), "");
        std::vector<std::string> names;
        for (const Json& each : outcome.report.at("assets").at(0).at("trial_candidates")) {
            names.push_back(each.at("layout"));
            if (names.back().find('+') != std::string::npos) continue;  // with detail
            const auto& layout = formats::info(*formats::lightMapLayoutFromName(names.back()));
            formats::DecodeLimits decode;
            if (output.find("filter") != std::string::npos)
                decode.filter = output.find("decoded") != std::string::npos ? LightMapFilter::Decoded : LightMapFilter::Hardware;
            EXPECT_EQ(each.at("fetches").get<int>(), decode.fetchesOf(layout)) << names.back();
        }
        return names;
    };
    // A budget measures all.
    EXPECT_THAT(candidatesOf("budget = \"1 MiB\""), testing::IsSupersetOf({"lit", "lit-half", "lit-quarter", "basis-4"}));
    EXPECT_THAT(candidatesOf("budget = \"1 MiB\"\nfilter = \"hardware\""), testing::Not(testing::Contains("lit-half")));
    EXPECT_THAT(candidatesOf("budget = \"1 MiB\"\nfilter = \"decoded\""),
                testing::IsSupersetOf({"lit", "lit-half", "lit-quarter", "basis-4"}));
}

TEST_F(SceneFilter, ALayoutThatCannotHaveItIsRefused) {
    EXPECT_THAT(firstError(cook("filter = \"decoded\"\nlight_map_layout = \"godot\"")), HasSubstr("found filter decoded for layout godot"));
    EXPECT_THAT(firstError(cook("filter = \"hardware\"\nlight_map_layout = \"lit\"")), HasSubstr("found filter hardware for layout lit"));
    EXPECT_THAT(firstError(cook("filter = \"decoded\"\nmax_error = 0.5\nlayouts = [\"godot\"]")), HasSubstr("found a filter that none of"));
    EXPECT_THAT(firstError(cook("filter = \"trilinear\"")), HasSubstr("hardware"));
}

}  // namespace
}  // namespace lightcook::pipeline

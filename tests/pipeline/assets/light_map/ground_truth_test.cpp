// Traced light beside a light map: its section of the report, and its refusals.
#include "pipeline/assets/light_map/ground_truth.h"

#include <gmock/gmock.h>

#include <cmath>
#include <map>
#include <numbers>

#include "lighting/radiometry.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

using testing::HasSubstr;
using Parts = SmallScene::Parts;

const std::string kHead = "x,y,kind,m,f0,dx,dy,dz,r,g,b\n";

/// Returns the irradiance that a path tracer finds at some texels of light with nine coefficients and no more.
std::string tracedIrradiance(float scale) {
    std::string csv = kHead;
    for (int y = 3; y < SmallScene::kHeight; y += 17)
        for (int x = 3; x < SmallScene::kWidth; x += 2) {
            const lighting::ShRgb sh = shOf(sunAndSky, {(x + 0.5) / SmallScene::kWidth, (y + 0.5) / SmallScene::kHeight});
            const glm::vec3 light = scale * lighting::irradiance(sh, glm::vec3(0, 0, 1)).value;
            csv += fmt::format("{},{},lambert,0,0,0,0,1,{},{},{}\n", x, y, light.x, light.y, light.z);
        }
    return csv;
}

class GroundTruthScene : public testing::Test {
protected:
    Outcome cookWith(const std::string& csv) const { return cookWith(csv, scene_.options()); }
    /// keys  of the light map; "explained" would dim the light of these texels to none
    Outcome cookWith(const std::string& csv, const CookOptions& options, const std::string& keys = "dominant_fit = \"halo3\"\n") const {
        formats::writeContent(scene_ / "truth.csv", csv);
        formats::writeContent(
            scene_.sceneFile(),
            "schema = 1\nname = \"small\"\n[[light_map]]\nname = \"map\"\nfile = \"map.exr\"\nground_truth = \"truth.csv\"\n" + keys);
        const RunState state;
        return cookScene(options, state);
    }
    const Json* truthOf(const Outcome& outcome, const char* asset) const {
        for (const Json& row : outcome.report.at("assets"))
            if (row.at("name") == asset && row.contains("ground_truth")) return &row.at("ground_truth");
        return nullptr;
    }
    const SmallScene scene_{Parts::LightMap};
};

/// Light that nine coefficients hold is not truncated; light a fifth brighter than the bake is, by a sixth, and cooking is what it was.
TEST_F(GroundTruthScene, TruncationIsTheBakesAndQuantizationOurs) {
    for (const float scale : {1.0f, 1.2f}) {
        const Outcome outcome = cookWith(tracedIrradiance(scale));
        ASSERT_TRUE(outcome.errors.empty()) << outcome.errors.front().line();
        const Json* truth = truthOf(outcome, "map");
        ASSERT_NE(truth, nullptr);
        EXPECT_EQ(truth->at("values"), 25);
        const Json& lambert = truth->at("lambert");
        EXPECT_NEAR(lambert.at("truncation").get<double>(), 1 - 1 / scale, 1e-6);
        EXPECT_GT(lambert.at("quantization").get<double>(), 0);
        EXPECT_LT(lambert.at("quantization").get<double>(), 0.01);
        EXPECT_FALSE(truth->contains("area_specular"));
        const Json& visible = lambert.at("visible");
        EXPECT_LT(visible.at("quantization").at("p99").get<double>(), 2);
        EXPECT_EQ(visible.at("total").at("p99").get<double>() > 5, scale > 1) << "a fifth is plain to see";
        EXPECT_EQ(truthOf(outcome, "map_dominant"), nullptr) << "no value of its kind";
    }
}

TEST_F(GroundTruthScene, VerifyAgreesAndOnlyVerificationRunsAgainForAChangedFile) {
    const std::string specular =
        "4,5,spec,0.25,0.04,0.1,0,1,0.5,0.5,0.4\n4,5,spec,0.5,0.6,0,0.2,1,0.5,0.5,0.4\n7,5,spec,0.5,0.6,0,0.2,1,0.6,0.5,0.4\n";
    const CookOptions options = scene_.optionsWithOwnCache();
    const Outcome cooked = cookWith(kHead + specular, options);
    ASSERT_TRUE(cooked.errors.empty()) << cooked.errors.front().line();
    const RunState state;
    const Outcome verified = verifyCooked({scene_ / "out", {}, {}}, state);
    ASSERT_TRUE(verified.errors.empty()) << verified.errors.front().line();
    for (const char* asset : {"map", "map_dominant"}) {
        ASSERT_NE(truthOf(verified, asset), nullptr);
        EXPECT_EQ(*truthOf(verified, asset), *truthOf(cooked, asset));
    }
    const Json& dominant = *truthOf(cooked, "map_dominant");
    EXPECT_EQ(dominant.at("values"), 3);
    EXPECT_EQ(dominant.at("specular").at("by_m").size(), 2u);
    for (const char* part : {"truncation", "fit", "quantization", "total", "two_lights"})
        EXPECT_GT(dominant.at("specular").at(part).get<double>(), 0) << part;
    EXPECT_GT(dominant.at("specular").at("visible").at("total").at("rms").get<double>(), 0);
    EXPECT_EQ(cookWith(kHead + specular, options).actionsRun, 0);
    EXPECT_EQ(cookWith(kHead + specular + "9,9,spec,0.5,0.6,0,0.2,1,0.6,0.5,0.4\n", options).actionsRun, 2)
        << "both are verified, none is cooked";
}

/// A light that the shader derives is judged with its light map, by the same figures as one that is stored as it is.
TEST_F(GroundTruthScene, ADerivedLightIsComparedWithTheLightMap) {
    const SmallScene sun(Parts::LightMap, [](const glm::dvec3& direction, const glm::dvec2& place) {
        const double towards = std::max(0.0, glm::dot(direction, glm::normalize(glm::dvec3(0.3, 0.2, 0.9))));
        return glm::vec3(static_cast<float>((1 + place.x) * std::pow(towards, 20)));
    });
    std::string csv = kHead;
    for (int y = 5; y < 60; y += 9) csv += fmt::format("4,{},spec,0.25,0.04,0.1,0,1,0.5,0.5,0.4\n", y);
    std::map<std::string, Json> found;
    for (const std::string layout : {"full", "derived"}) {
        formats::writeContent(sun / "truth.csv", csv);
        sun.writeSceneFile("target = \"float\"\nlight_map_layout = \"raw\"",
                           "ground_truth = \"truth.csv\"\ndominant_layout = \"" + layout + "\"\n");
        const Outcome outcome = cook(sun.options());
        ASSERT_TRUE(outcome.errors.empty()) << outcome.errors.front().line();
        const Json* truth = truthOf(outcome, layout == "full" ? "map_dominant" : "map");
        ASSERT_NE(truth, nullptr);
        found[layout] = truth->at("specular");
    }
    for (const char* same : {"truncation", "fit", "two_lights"})
        EXPECT_DOUBLE_EQ(found["derived"].at(same).get<double>(), found["full"].at(same).get<double>()) << same;
    EXPECT_LT(found["derived"].at("quantization").get<double>(), 0.01) << "the light of the fit, from coefficients in halves";
    EXPECT_NEAR(found["derived"].at("with_rest").get<double>(), found["full"].at("with_rest").get<double>(), 0.02);
}

TEST_F(GroundTruthScene, RefusesTexelsOutsideTheMapAndViewsBelowTheSurface) {
    const Outcome outside = cookWith(kHead + "12,5,lambert,0,0,0,0,1,1,1,1\n");
    ASSERT_FALSE(outside.errors.empty());
    EXPECT_EQ(outside.errors.front().code, formats::ErrorCode::WrongShape);
    EXPECT_THAT(outside.errors.front().line(),
                HasSubstr("truth.csv, line 2: found texel (12, 5), expected one of the light map's 12 x 72"));
    const Outcome below = cookWith(kHead + "4,5,spec,0.25,0.04,0.1,0,1,1,1,1\n4,5,spec,0.25,0.04,0.1,0,-1,1,1,1\n");
    ASSERT_FALSE(below.errors.empty());
    EXPECT_EQ(below.errors.front().code, formats::ErrorCode::ValueOutOfRange);
    EXPECT_THAT(below.errors.front().line(), HasSubstr("truth.csv, line 3: found a view below the surface at texel (4, 5)"));
    std::filesystem::remove(scene_ / "truth.csv");
    const RunState state;
    const Outcome missing = cookScene(scene_.options(), state);
    ASSERT_FALSE(missing.errors.empty());
    EXPECT_THAT(missing.errors.front().line(), HasSubstr("truth.csv"));
}

TEST(GroundTruthValues, OutsideEveryChartThereIsNothingToCompare) {
    const SmallScene scene(Parts::LightMap);
    formats::writeContent(scene / "truth.csv", kHead + "4,5,lambert,0,0,0,0,1,1,1,1\n6,9,lambert,0,0,0,0,1,1,1,1\n");
    const formats::LightMapDescription description;
    SharedObjects shared;
    const auto bake = shared.get<LightMapSources>().open(scene / "map.exr", description);
    ASSERT_TRUE(bake.has_value());
    const Action action{"", "", "map", {}, {{kGroundTruthRole, scene / "truth.csv"}}, {}};
    const RunState state;
    const auto truth = GroundTruth::open({action, {}, {}, {}, shared, state}, **bake, description.colors);
    ASSERT_TRUE(truth.has_value()) << truth.error().line();
    formats::LightMapStrip band = *(*bake)->stripWithMargin(0, 0, 0);
    EXPECT_EQ(truth->within(band, 0, 9)->size(), 1u);
    EXPECT_EQ(truth->within(band, 5, 5)->size(), 2u);
    band.covered.at(6, 9) = 0;
    EXPECT_EQ(truth->within(band, 0, 9)->size(), 1u);
    const auto refused = truth->within(band, 0, 64);
    ASSERT_FALSE(refused.has_value());
    EXPECT_THAT(refused.error().line(), HasSubstr("truth.csv, line 3: found texel (6, 9) outside every chart"));
}

}  // namespace
}  // namespace lightcook::pipeline

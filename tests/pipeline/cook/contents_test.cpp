#include "pipeline/cook/contents.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "formats/light_map.h"
#include "pipeline/cook/cook.h"
#include "pipeline/cook/plan.h"
#include "pipeline/report/report.h"
#include "tests/pipeline/report_parts.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

using glm::dvec2;
using glm::dvec3;
using glm::vec3;

vec3 black(const dvec3&, const dvec2&) {
    return vec3(0);
}
/// The same sky from above at every place: constant, but not the same from every direction.
vec3 sky(const dvec3& direction, const dvec2&) {
    return vec3(0.3f, 0.4f, 0.6f) * static_cast<float>(1 + 0.5 * direction.z);
}
/// A beam at every place, which is nearly one light.
vec3 beam(const dvec3& direction, const dvec2&) {
    return vec3(1.0f, 0.8f, 0.6f) * static_cast<float>(std::pow(std::max(0.0, glm::dot(direction, dvec3(0.6, 0, 0.8))), 12));
}
/// Light from every direction alike that grows over the map.
vec3 growingFog(const dvec3&, const dvec2& place) {
    return vec3(0.2f, 0.3f, 0.4f) * static_cast<float>(1 + 3 * place.x);
}
/// The same, with light of band 1.
vec3 growingSlope(const dvec3& direction, const dvec2& place) {
    return vec3(0.2f, 0.3f, 0.4f) * static_cast<float>((1 + 3 * place.x) * (1 + 0.5 * direction.z));
}

/// Light of another colour from each axis.
vec3 colouredAxes(const dvec3& direction, const dvec2&) {
    return vec3(glm::dvec3(1, 0.9, 0.8) + direction.x * glm::dvec3(0.21, -0.17, 0.33) + direction.y * glm::dvec3(-0.12, 0.26, 0.07) +
                direction.z * glm::dvec3(0.31, 0.11, -0.23));
}

Outcome cook(const SmallScene& scene, const std::string& output = "", const std::string& materials = "") {
    scene.writeSceneFile(output, materials);
    const RunState state;
    const CookOptions options = scene.options();
    Outcome outcome = cookScene(options, state);
    for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
    return outcome;
}

TEST(Contents, ABlackMapBecomesOneBlockWithoutDominantLight) {
    const SmallScene scene(SmallScene::Parts::LightMap, black);
    const Json report = cook(scene).report;
    const Json& map = assetOf(report, "map");
    EXPECT_EQ(map.at("width"), 4);
    EXPECT_EQ(map.at("height"), 4);
    EXPECT_EQ(map.at("layout"), "flat") << "black has no bands 1 and 2";
    EXPECT_EQ(map.at("bytes_gpu"), 16) << "one block";
    EXPECT_FALSE(hasAsset(report, "map_dominant"));
    EXPECT_EQ(skipOf(report, "texels of light map 'map'").at("bytes_saved"), 9 * 16 * 3 * 18 + 4 * 2 * 18 - 16)
        << "12 x 72 texels are 54 blocks, of ratio in nine layers, and 2 x 18 texels of coverage";
    EXPECT_GT(skipOf(report, "dominant light of 'map'").at("bytes_saved"), 0);
}

TEST(Contents, TheConstantIsReconstructedAtTheSizeOfTheBake) {
    const SmallScene scene(SmallScene::Parts::LightMap, sky);
    const Outcome outcome = cook(scene);
    const RunState state;
    ASSERT_TRUE(reconstructLightMap(outcome.output, "map", scene / "back.exr", 1, state).has_value());
    const auto bake = formats::LightMapReader::open(scene / "map.exr", {}), back = formats::LightMapReader::open(scene / "back.exr", {});
    ASSERT_TRUE(bake.has_value() && back.has_value());
    ASSERT_EQ(back->width(), SmallScene::kWidth);
    ASSERT_EQ(back->height(), SmallScene::kHeight);
    const auto expected = bake->read(0, SmallScene::kHeight), found = back->read(0, SmallScene::kHeight);
    for (int y = 0; y < SmallScene::kHeight; y += 7)
        for (int x = 0; x < SmallScene::kWidth; x += 3)
            for (std::size_t i = 0; i < 9; ++i)
                EXPECT_NEAR(found->sh.at(x, y)[i].g, expected->sh.at(x, y)[i].g, 0.01 * expected->sh.at(x, y)[0].g)
                    << x << ' ' << y << ' ' << i;
}

TEST(Contents, AConstantBeamHasADominantLightOfOneBlock) {
    const SmallScene scene(SmallScene::Parts::LightMap, beam);
    EXPECT_EQ(assetOf(cook(scene).report, "map_dominant").at("width"), 4) << "one light and one normal everywhere";
}

TEST(Contents, ADominantLightThatWouldBeBlackIsLeftOut) {
    for (const auto& light : {sky, growingSlope}) {
        const SmallScene scene(SmallScene::Parts::LightMap, light);
        const Json report = cook(scene).report;
        EXPECT_FALSE(hasAsset(report, "map_dominant"));
        const Json& skip = skipOf(report, "dominant light of 'map'");
        EXPECT_EQ(skip.at("why"), "no single light explains enough of any texel: all specular light is area specular");
        EXPECT_EQ(skip.at("bytes_saved"), 3 * 16 * (3 * 18)) << "three textures of 12 x 72 texels";
    }
    const SmallScene sun(SmallScene::Parts::LightMap, sunAndSky);
    EXPECT_TRUE(hasAsset(cook(sun).report, "map_dominant")) << "some texels have one";
}

TEST(Contents, AConstantThatChangedFailsItsVerification) {
    const SmallScene scene(SmallScene::Parts::LightMap, sky);
    const Outcome outcome = cook(scene);
    const SmallScene other(SmallScene::Parts::LightMap, sunAndSky);
    std::filesystem::copy_file(other / "map.exr", scene / "map.exr", std::filesystem::copy_options::overwrite_existing);
    const RunState state;
    const Outcome verified = verifyCooked({outcome.output, {}, {}}, state);
    ASSERT_FALSE(verified.errors.empty());
    EXPECT_NE(verified.errors[0].line().find("map.exr"), std::string::npos);
}

TEST(Contents, BandsThatAreNotVisibleAreLeftOut) {
    const SmallScene fog(SmallScene::Parts::LightMap, growingFog);
    const Json foggy = cook(fog).report;
    EXPECT_EQ(assetOf(foggy, "map").at("layout"), "flat");
    EXPECT_EQ(skipOf(foggy, "bands of light map 'map'").at("bytes_saved"), 8 * 16 * 54 + 4 * 2 * 18);
    const SmallScene slope(SmallScene::Parts::LightMap, growingSlope);
    EXPECT_NE(assetOf(cook(slope).report, "map").at("layout"), "flat");
}

TEST(ContentsSoak, AutoTriesTheFlatLayoutWhereItMayBeEnough) {
    const SmallScene fog(SmallScene::Parts::LightMap, growingFog);
    const Json foggy = cook(fog, "max_error = 0.02").report;
    EXPECT_EQ(assetOf(foggy, "map").at("layout"), "flat");
    const Json& bands = skipOf(foggy, "bands of light map 'map'");
    EXPECT_EQ(bands.at("bytes_saved"), 8 * 16 * 54 + 4 * 2 * 18) << "as without auto";
    EXPECT_EQ(bands.at("why"), skipOf(cook(fog).report, "bands of light map 'map'").at("why"));
    const SmallScene slope(SmallScene::Parts::LightMap, growingSlope);
    const Json sloped = cook(slope, "max_error = 0.02").report;
    const std::string layout = assetOf(sloped, "map").at("layout");
    EXPECT_NE(layout, "flat");
    EXPECT_EQ(skipOf(sloped, "bands of light map 'map'").is_null(), layout != "sh4");
    const SmallScene sun(SmallScene::Parts::LightMap, sunAndSky);
    EXPECT_TRUE(skipOf(cook(sun, "max_error = 0.5").report, "bands of light map 'map'").is_null()) << "a limit allows more than it lacks";
}

TEST(Contents, WithoutNormalMapsAndSpecularAutoTakesAsManyFlatTexturesAsALimitNeeds) {
    const SmallScene scene(SmallScene::Parts::LightMap, sunAndSky);
    const std::string plain = "[[material]]\nname = \"*\"\nnormal_map = false\nspecular = false\n";
    const auto cooked = [&](const std::string& output) { return assetOf(cook(scene, output, plain).report, "map"); };
    const Json one = cooked("max_error = 0.05");
    EXPECT_EQ(one.at("layout"), "flat");
    for (const char* more : {"", "\nkeep_unused = true"}) {
        const double error = one.at("stages").back().at("error").at("diffuse").at("rel_rms").get<double>();
        const Json two = cooked(fmt::format("max_error = {}{}", 0.7 * error, more));
        EXPECT_EQ(two.at("layout"), "flat-2") << more;
        EXPECT_LT(two.at("bits_per_texel").get<double>(), 18) << more;
        EXPECT_LT(two.at("stages").back().at("error").at("diffuse").at("rel_rms").get<double>(), 0.7 * error) << more;
    }
    EXPECT_EQ(cooked("max_error = 2e-4").at("layout"), "raw");
    EXPECT_EQ(cooked("light_map_layout = \"basis-4\"").at("layout"), "flat") << "the light is the same, in fewer bytes";
    EXPECT_EQ(cooked("light_map_layout = \"flat-2\"").at("layout"), "flat-2");
    EXPECT_EQ(cooked("max_error = 2e-4\nlayouts = [\"flat\", \"hdr-rgb9e5\", \"raw\"]").at("layout"), "raw");
    const SmallScene constant(SmallScene::Parts::LightMap, sky);
    const Json block = assetOf(cook(constant, "max_error = 0.05", plain).report, "map");
    EXPECT_EQ(block.at("layout"), "flat");
    EXPECT_EQ(block.at("bytes_gpu"), 16) << "one block";
}

TEST(Contents, AConstantIsABlockOfEachTexture) {
    const SmallScene slope(SmallScene::Parts::LightMap, sky);
    const Json map = assetOf(cook(slope).report, "map");
    EXPECT_EQ(map.at("bytes_gpu"), 9 * 16);
    EXPECT_EQ(map.at("width"), 4);
    EXPECT_EQ(assetOf(cook(slope, "light_map_layout = \"ratio\"").report, "map").at("layout"), "ratio") << "as named";
}

TEST(Contents, AConstantTakesALayoutWithinItsLimits) {
    const SmallScene scene(SmallScene::Parts::LightMap, sky);
    const Json cheap = assetOf(cook(scene, "max_error = 0.02").report, "map");
    EXPECT_EQ(cheap.at("width"), 4);
    EXPECT_LT(cheap.at("bytes_gpu"), 9 * 128) << "raw is exact, but others keep the limit too";
    const Json few = assetOf(cook(scene, "max_error = 0.02\ncost = \"taps\"").report, "map");
    const auto fetchesOf = [](const Json& map) {
        return formats::info(*formats::lightMapLayoutFromName(map.at("layout").get<std::string>())).fetchCount();
    };
    EXPECT_EQ(few.at("width"), 4);
    EXPECT_LE(fetchesOf(few), fetchesOf(cheap));
    for (const Json& candidate : few.at("trial_candidates"))
        if (std::max(candidate.at("diffuse").get<double>(), candidate.at("specular").get<double>()) <= 0.02) {
            EXPECT_LE(fetchesOf(few), candidate.at("fetches").get<int>()) << candidate.at("layout");
        }
    const std::string bumped = "[[material]]\nname = \"*\"\nnormal_map = true\nspecular = false\n";
    const Json small = assetOf(cook(scene, "budget = \"1 KiB\"", bumped).report, "map");
    EXPECT_EQ(small.at("layout"), "ratio");
    EXPECT_EQ(small.at("bytes_gpu"), 9 * 16);
    for (const double limit : {0.02, 5e-4}) {
        const Json limited = assetOf(cook(scene, fmt::format("max_error = {}\nbudget = \"4 KiB\"", limit), bumped).report, "map");
        const Json unlimited = assetOf(cook(scene, fmt::format("max_error = {}", limit), bumped).report, "map");
        EXPECT_EQ(limited.at("layout"), unlimited.at("layout")) << "a budget that is met changes nothing";
        EXPECT_EQ(limited.at("passed"), true);
    }
    const Json quick = assetOf(cook(scene, "max_error = 0.02\nmax_fetches = 4").report, "map");
    const auto taken = formats::lightMapLayoutFromName(quick.at("layout").get<std::string>());
    ASSERT_TRUE(taken);
    EXPECT_LE(formats::info(*taken).fetchCount(), 4) << quick.at("layout");
}

/// Every code of the second texture is off by half a step there, each in its own direction, with no other block to make up for it.
TEST(Contents, AConstantKeepsTheSecondTextureOfHalo3) {
    const SmallScene scene(SmallScene::Parts::LightMap, colouredAxes);
    EXPECT_EQ(assetOf(cook(scene, "max_error = 0.2\nlight_map_layout = \"halo3\"").report, "map").at("passed"), true);
}

TEST(ContentsSoak, ANamedLayoutAndKeepUnusedOverrideWhatIsNotVisible) {
    const SmallScene fog(SmallScene::Parts::LightMap, growingFog);
    EXPECT_EQ(assetOf(cook(fog, "light_map_layout = \"hdr-2\"").report, "map").at("layout"), "hdr-2");
    for (const char* layout : {"godot", "mono-sh", "bakery", "unreal-hq"})
        EXPECT_EQ(assetOf(cook(fog, fmt::format("light_map_layout = \"{}\"", layout)).report, "map").at("layout"), layout);
    const SmallScene dark(SmallScene::Parts::LightMap, black);
    const Json report = cook(dark, "keep_unused = true").report;
    EXPECT_EQ(assetOf(report, "map").at("width"), SmallScene::kWidth);
    EXPECT_TRUE(hasAsset(report, "map_dominant"));
}

/// Returns the 99th percentile and the bound of the visible error of diffuse light.
std::pair<double, double> visibleOf(const Json& map) {
    const Json& visible = map.at("stages").back().at("error").at("diffuse").at("visible");
    EXPECT_LE(visible.at("max").get<double>(), visible.at("bound").get<double>());
    return {visible.at("p99").get<double>(), visible.at("bound").get<double>()};
}

TEST(Contents, WithoutNormalMapsVisibleErrorsAreOfTheTexelsOwnNormal) {
    const SmallScene scene(SmallScene::Parts::LightMap, sunAndSky);
    const auto materials = [](bool hasNormalMap) {
        return fmt::format("[[material]]\nname = \"*\"\nnormal_map = {}\nspecular = true\n", hasNormalMap);
    };
    const std::string output = "light_map_layout = \"hdr\"";  // it is encoded alike for both
    const Json plain = assetOf(cook(scene, output, materials(false)).report, "map");
    const Json bumpy = assetOf(cook(scene, output, materials(true)).report, "map");
    EXPECT_LT(visibleOf(plain).first, visibleOf(bumpy).first);
    EXPECT_LE(visibleOf(plain).second, visibleOf(bumpy).second);
    EXPECT_EQ(plain.at("stages").back().at("at_texels").at("diffuse").at("rel_rms"),
              bumpy.at("stages").back().at("at_texels").at("diffuse").at("rel_rms"))
        << "rel_rms is of the hemisphere";
}

TEST(Contents, TheCapOfVisibleErrorsIsThatOfNormalMaps) {
    Needs needs;
    EXPECT_EQ(shadingOf({}, needs).normalMapTilt, 60);
    needs.normalMap = false;
    EXPECT_EQ(shadingOf({}, needs).normalMapTilt, 0);
    EXPECT_EQ(shadingOf({}, needs).normalCount, 32);
    needs.specular = false;
    EXPECT_EQ(shadingOf({}, needs).normalCount, 1);
}

TEST(Contents, PositionsOfProbesMayBeInTheSceneFile) {
    const SmallScene folder(SmallScene::Parts::All);
    auto scene = readScene(folder.sceneFile());
    ASSERT_TRUE(scene.has_value());
    const ProbeEntry probe = scene->probes.at(0);
    scene->probes.clear();
    for (int i = 0; i < 6; ++i) {
        scene->probes.push_back(probe);
        scene->probes.back().name = fmt::format("probe{}", i);
        scene->probes.back().place.position = dvec3(i, 1, 2);
    }
    scene->probes[1].sh = folder / "probes.json";
    scene->probes[2].place = {};
    scene->probes[2].sh = folder / "probes.json";
    scene->lightMaps[0].mesh = folder / "room.glb";
    const auto actions = planContents(*scene, {}, {});
    const auto use = std::ranges::find(actions, "probe-use", &Action::id);
    ASSERT_NE(use, actions.end());
    const Json& placed = use->parameters.at("probes");
    ASSERT_EQ(placed.size(), 6u);
    EXPECT_EQ(placed[5].at("position"), Json({5, 1, 2}));
    EXPECT_EQ(placed[1].at("position"), Json({1, 1, 2})) << "it goes before that of the file";
    EXPECT_FALSE(placed[2].contains("position"));
    EXPECT_EQ(use->inputs.at(placed[2].at("role")), folder / "probes.json");
    EXPECT_EQ(use->inputs.size(), 2u) << "the file of one probe, and the mesh";
}

/// Only the contents of assets that are cooked are read: by their name, by that of the entry which they derive from, and by their kind.
TEST(Contents, AreReadOfTheWantedAssetsAlone) {
    const SmallScene folder(SmallScene::Parts::All);
    const auto scene = readScene(folder.sceneFile());
    ASSERT_TRUE(scene.has_value());
    const auto isRead = [&](const PlanOptions& options) { return planContents(*scene, {}, options).size() == 1; };
    EXPECT_TRUE(isRead({}));
    EXPECT_TRUE(isRead({.only = "map", .onlyKind = {}}));
    EXPECT_TRUE(isRead({.only = "map_dominant", .onlyKind = {}}));
    EXPECT_FALSE(isRead({.only = "sky", .onlyKind = {}}));
    EXPECT_TRUE(isRead({.only = {}, .onlyKind = "light-map"}));
    EXPECT_TRUE(isRead({.only = {}, .onlyKind = "dominant"}));
    EXPECT_TRUE(isRead({.only = "map", .onlyKind = "dominant"}));
    EXPECT_FALSE(isRead({.only = {}, .onlyKind = "cubemap"}));
    EXPECT_FALSE(isRead({.only = "sky", .onlyKind = "light-map"}));
}

}  // namespace
}  // namespace lightcook::pipeline

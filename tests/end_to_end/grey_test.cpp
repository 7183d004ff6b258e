// The grey test of "PI or not to PI": radiance 0.5 from everywhere has to give exit radiance 0.5 on a white surface, whatever way it takes
// from file to shaded value. Files are written by the program, read back by the verifier's texture unit, and shaded by the shipped shader.
#include <gmock/gmock.h>

#include <algorithm>

#include "pipeline/assets/cubemap/cubemap.h"
#include "pipeline/assets/dominant/dominant.h"
#include "pipeline/assets/light_map/cooked_light_map.h"
#include "pipeline/assets/rsrm/rsrm.h"
#include "pipeline/assets/textures.h"
#include "pipeline/manifest/manifest.h"
#include "shaders/lightcook_cpp.h"
#include "tests/pipeline/small_scene.h"
#include "verify/texture_unit.h"

namespace lightcook::pipeline {
namespace {

constexpr double kGrey = 0.5, kTolerance = 1e-3 * kGrey;

struct Variant {
    const char* target;
    const char* layout;
    const char* lobe = "beckmann";
};

const CookedAsset& cookedAssetOf(const Manifest& manifest, const std::string& name) {
    for (const CookedAsset& each : manifest.assets)
        if (each.name == name) return each;
    throw std::runtime_error("no asset " + name);
}

class GreyTest : public testing::TestWithParam<Variant> {
protected:
    /// Probe and gradient are the same beside every layout.
    static bool hasAllAssets() { return GetParam().layout == std::string_view("ratio"); }
    GreyTest() : scene_(hasAllAssets() ? SmallScene::Parts::All : SmallScene::Parts::LightMap, grey) {
        scene_.writeSceneFile(fmt::format("target = \"{}\"\nlight_map_layout = \"{}\"", GetParam().target, GetParam().layout), "",
                              fmt::format("lobe = \"{}\"\n", GetParam().lobe));
        const RunState state;
        const Outcome outcome = cookScene(scene_.options(), state);
        for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
        const auto manifest = loadManifest(scene_ / "out");
        if (!manifest) throw std::runtime_error(manifest.error().line());
        manifest_ = *manifest;
        skipped_ = outcome.report.at("skipped");
    }
    const CookedAsset& asset(const std::string& name) const { return cookedAssetOf(manifest_, name); }
    std::filesystem::path folder() const { return scene_ / "out"; }

    void lightMapShadesToGreyForEveryNormal() const;
    void cubemapTimesItsOwnAreaSpecularIsGreyAtEveryMip() const;
    void reflectionMapIsGreyForEveryExponent() const;
    void noDirectionDominatesGreyLight() const;

    SmallScene scene_;
    Manifest manifest_;
    Json skipped_;  ///< of the report
};

void expectGrey(const glm::vec3& value, const std::string& where) {
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(static_cast<double>(value[c]), kGrey, kTolerance) << where << ", channel " << c;
}

void GreyTest::lightMapShadesToGreyForEveryNormal() const {
    const auto cooked = CookedLightMapReader::open(folder(), asset("map"), {.key = kGrey});
    ASSERT_TRUE(cooked.has_value()) << cooked.error().line();
    const auto texels = cooked->read(0, cooked->height());
    ASSERT_TRUE(texels.has_value());
    const auto seen = cooked->verifier().reconstruct(*texels, 0, cooked->height());
    for (int i = 0; i < 200; ++i) {
        shaders::LcSh sh;
        const lighting::ShRgb& texel = seen.texels()[static_cast<std::size_t>(i * 37) % seen.texels().size()];
        for (int c = 0; c < 9; ++c) sh.c[c] = texel[static_cast<std::size_t>(c)];
        expectGrey(shaders::lcExitRadiance(sh, glm::vec3(lighting::cubeTexelDirection(i % 6, i % 5, i % 3, 5))), "light map");
    }
}

void GreyTest::cubemapTimesItsOwnAreaSpecularIsGreyAtEveryMip() const {
    const CookedAsset& cubemap = asset("probe");
    const auto texture = openTexture(folder(), cubemap, "cubemap");
    ASSERT_TRUE(texture.has_value()) << texture.error().line();
    const auto constants = fromJson<CubemapConstants>(cubemap.constants.value_or(Json()), "probe");
    ASSERT_TRUE(constants.has_value()) << constants.error().line();
    shaders::LcSh sh;
    for (std::size_t i = 0; i < 9; ++i) sh.c[i] = constants->windowedSh[i];
    for (int mip = 0; mip < texture->shape().mipCount; ++mip) {
        const lighting::ShBands& bands = constants->mips.at(static_cast<std::size_t>(mip)).bands;
        const glm::vec3 factors(bands[0], bands[1], bands[2]);
        for (int face = 0; face < 6; ++face) {
            const auto image = verify::decodeImage(*texture, {mip, 0, face});
            ASSERT_TRUE(image.has_value());
            for (int y = 0; y < image->height(); y += 3)
                for (int x = 0; x < image->width(); x += 3) {
                    const glm::vec3 direction(lighting::cubeTexelDirection(face, x, y, image->width()));
                    const glm::vec3 stored = glm::vec3(image->at(x, y)) * constants->range;
                    expectGrey(shaders::lcEnvironment(stored, shaders::lcZonalSpecular(sh, direction, factors)),
                               fmt::format("mip {} face {}", mip, face));
                }
        }
    }
}

void GreyTest::reflectionMapIsGreyForEveryExponent() const {
    const CookedAsset& rsrm = asset("sky");
    const auto texture = openTexture(folder(), rsrm, "rsrm");
    ASSERT_TRUE(texture.has_value());
    const auto image = verify::decodeImage(*texture, {});
    const auto constants = fromJson<RsrmConstants>(rsrm.constants.value_or(Json()), "sky");
    ASSERT_TRUE(constants.has_value()) << constants.error().line();
    for (const glm::vec4& texel : image->texels()) expectGrey(shaders::lcRsrm(glm::vec3(texel), constants->color), "RSRM");
}

/// The dominant light would be 0 everywhere, so it is left out.
void GreyTest::noDirectionDominatesGreyLight() const {
    for (const CookedAsset& each : manifest_.assets) EXPECT_NE(each.name, "map_dominant");
    EXPECT_THAT(skipped_.dump(), testing::HasSubstr("dominant light of 'map'"));
}

TEST_P(GreyTest, ComesOutOfEveryAssetAsItWentIn) {
    lightMapShadesToGreyForEveryNormal();
    noDirectionDominatesGreyLight();
    if (!hasAllAssets()) return;
    cubemapTimesItsOwnAreaSpecularIsGreyAtEveryMip();
    reflectionMapIsGreyForEveryExponent();
}

const auto nameOfVariant = [](const auto& variant) {
    std::string layout = variant.param.layout;
    std::ranges::replace(layout, '-', '_');
    return fmt::format("{}_{}_{}", variant.param.target, layout, variant.param.lobe);
};
/// A layout of each family, and each target.
INSTANTIATE_TEST_SUITE_P(EveryFamily, GreyTest,
                         testing::Values(Variant{"bc", "ratio"}, Variant{"float", "halo3"}, Variant{"float", "raw"},
                                         Variant{"astc", "hdr-2"}, Variant{"bc", "sh4"}, Variant{"bc", "godot"}, Variant{"float", "bakery"},
                                         Variant{"bc", "basis-4"}, Variant{"bc", "hdr-rgb9e5"}, Variant{"bc", "flat-2"},
                                         Variant{"bc", "unreal-hq"}),
                         nameOfVariant);
INSTANTIATE_TEST_SUITE_P(Soak, GreyTest,
                         testing::Values(Variant{"bc", "raw"}, Variant{"astc", "ratio"}, Variant{"astc", "sh4"}, Variant{"astc", "godot"},
                                         Variant{"float", "mono-sh"}, Variant{"astc", "bakery"}, Variant{"float", "ratio"},
                                         Variant{"bc", "basis-3"}, Variant{"bc", "basis-12"}, Variant{"astc", "basis-8"},
                                         Variant{"float", "basis-8"}, Variant{"astc", "unreal-hq"}, Variant{"bc", "ratio", "ggx"}),
                         nameOfVariant);

TEST(GreyLight, HasADominantLightOf0WhereItIsKept) {
    const SmallScene scene(SmallScene::Parts::LightMap, grey);
    scene.writeSceneFile("light_map_layout = \"ratio\"\nkeep_unused = true");
    const RunState state;
    const Outcome outcome = cookScene(scene.options(), state);
    for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
    const auto manifest = loadManifest(scene / "out");
    ASSERT_TRUE(manifest.has_value()) << manifest.error().line();
    const CookedAsset& dominant = cookedAssetOf(*manifest, "map_dominant");
    const auto constants = fromJson<DominantConstants>(dominant.constants.value_or(Json()), "map_dominant");
    ASSERT_TRUE(constants.has_value()) << constants.error().line();
    const auto intensity = openTexture(scene / "out", dominant, "intensity");
    ASSERT_TRUE(intensity.has_value());
    const auto image = verify::decodeImage(*intensity, {});
    ASSERT_TRUE(image.has_value()) << image.error().line();
    for (const glm::vec4& texel : image->texels())
        for (int c = 0; c < 3; ++c) EXPECT_LT(texel[c] * constants->intensityRange, 1e-3f);
}

}  // namespace
}  // namespace lightcook::pipeline

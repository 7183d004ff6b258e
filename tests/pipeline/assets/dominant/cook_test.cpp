// A dominant light over a hard shadow: the same bytes at any number of threads, right between texels, and its visible errors.
#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <numbers>

#include "pipeline/graph/digest.h"
#include "tests/pipeline/report_parts.h"
#include "tests/pipeline/rewritten_manifest.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

/// Light of a hard sun on one side of an edge, and a fiftieth of it from another side beyond. The edge crosses the border of strips.
glm::vec3 shadowEdge(const glm::dvec3& direction, const glm::dvec2& place) {
    const bool isLit = place.x < 0.3 + 0.4 * place.y;
    const glm::dvec3 towards = glm::normalize(isLit ? glm::dvec3(0.7, 0.2, 0.6) : glm::dvec3(-0.6, -0.3, 0.6));
    return glm::vec3(static_cast<float>((isLit ? 10 : 0.2) * std::pow(std::max(0.0, glm::dot(direction, towards)), 12)));
}

void writeScene(const SmallScene& scene, const std::string& fit, const std::string& display = "") {
    formats::writeContent(scene.sceneFile(),
                          "schema = 1\nname = \"small\"\n" + display +
                              "[[light_map]]\nname = \"map\"\nfile = \"map.exr\"\ndominant_layout = \"full\"\ndominant_fit = \"" + fit +
                              "\"\n");
}

/// Cooks the dominant light alone.
Outcome cookDominantAlone(CookOptions options) {
    options.only = "map_dominant";
    return cook(options);
}

TEST(CookDominant, SolvesAShadowsEdgeTheSameOnAnyNumberOfThreads) {
    const SmallScene scene(SmallScene::Parts::LightMap, shadowEdge);
    writeScene(scene, "refined");
    std::vector<std::string> bytes;
    for (const int threads : {1, 3}) {
        CookOptions options = scene.optionsWithOwnCache();
        options.force = true;
        tbb::task_arena arena(threads);
        const Outcome outcome = arena.execute([&] { return cookDominantAlone(options); });
        ASSERT_TRUE(outcome.errors.empty()) << outcome.errors.front().line();
        const Json& notes = assetOf(outcome.report, "map_dominant").at("notes");
        EXPECT_GT(notes.at("solved_with_neighbours").get<int>(), 50);
        EXPECT_LT(notes.at("solved_with_neighbours").get<int>(), SmallScene::kWidth * SmallScene::kHeight / 3);
        for (const char* role : {"direction", "residual", "intensity"})
            bytes.push_back(formats::contentOf(scene / "out" / fmt::format("map_dominant_{}.ktx2", role)));
    }
    for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(bytes[i], bytes[i + 3]) << i;
}

/// The paper's fit takes each texel alone: between the texels of the edge its light points to neither side.
TEST(CookDominant, ErrsLessBetweenTexelsThanTexelsAlone) {
    const SmallScene scene(SmallScene::Parts::LightMap, shadowEdge);
    double magnified[2], visible[2];
    for (const int i : {0, 1}) {
        writeScene(scene, i == 0 ? "halo3" : "explained");
        const Outcome outcome = cookDominantAlone(scene.options());
        const Json& stage = assetOf(outcome.report, "map_dominant").at("stages").at(0);
        EXPECT_EQ(stage.at("name"), "magnified");
        const Json& specular = stage.at("error").at("specular");
        magnified[i] = specular.at("rel_rms").get<double>();
        visible[i] = specular.at("visible").at("rms").get<double>();
        EXPECT_FALSE(assetOf(outcome.report, "map_dominant").at("stages").at(0).at("error").at("diffuse").contains("visible"));
    }
    EXPECT_LT(magnified[1], 0.7 * magnified[0]);
    EXPECT_LT(visible[1], 0.8 * visible[0]);
}

/// A display that shows everything darker shows smaller differences.
TEST(CookDominant, VisibleErrorsAreThoseOfTheScenesDisplay) {
    const SmallScene scene(SmallScene::Parts::LightMap, shadowEdge);
    double rms[2];
    for (const int i : {0, 1}) {
        writeScene(scene, "explained", i == 0 ? "" : "[display]\nstops = -8\n");
        const Outcome outcome = cookDominantAlone(scene.options());
        ASSERT_TRUE(outcome.errors.empty()) << outcome.errors.front().line();
        const Json& visible = assetOf(outcome.report, "map_dominant").at("stages").back().at("error").at("specular").at("visible");
        rms[i] = visible.at("rms").get<double>();
        EXPECT_GE(visible.at("max").get<double>(), visible.at("p99").get<double>());
        EXPECT_TRUE(visible.at("max_at").is_object());
    }
    EXPECT_GT(rms[0], 0);
    EXPECT_LT(rms[1], 0.7 * rms[0]);
}

/// Cooks in halves, sets one texel of the intensity to the bits of a half, and verifies.
Outcome verifiedWithWrongTexel(const SmallScene& scene, const glm::ivec2& texel, int height, std::uint16_t half) {
    CookOptions options = scene.options();
    options.given.set("output.target", "float");
    const Outcome outcome = cookDominantAlone(options);
    EXPECT_TRUE(outcome.errors.empty()) << outcome.errors.front().line();
    const std::filesystem::path file = scene / "out" / "map_dominant_intensity.ktx2";
    std::string content = formats::contentOf(file);
    constexpr std::size_t kTexelBytes = 8;
    const auto index = static_cast<std::size_t>(texel.y * SmallScene::kWidth + texel.x);
    const std::size_t at = content.size() - kTexelBytes * static_cast<std::size_t>(SmallScene::kWidth * height) + kTexelBytes * index;
    content[at] = static_cast<char>(half & 0xff);
    content[at + 1] = static_cast<char>(half >> 8);
    formats::writeContent(file, content);
    Json manifest = parseJson(formats::contentOf(scene / "out" / kManifestName));
    for (Json& asset : manifest["assets"])
        for (Json& texture : asset["textures"])
            texture["digest"] = digestOfText(formats::contentOf(scene / "out" / texture.at("file").get<std::string>()));
    writeManifestAndDigests(scene / "out", manifest);
    VerifyOptions verifying;
    verifying.folder = scene / "out";
    const RunState state;
    return verifyCooked(verifying, state);
}

TEST(CookDominant, ATexelThatIsNotFiniteIsNamed) {
    const SmallScene scene(SmallScene::Parts::LightMap, shadowEdge);
    writeScene(scene, "explained");
    const Outcome verified = verifiedWithWrongTexel(scene, {5, 33}, SmallScene::kHeight, 0x7e00);
    ASSERT_FALSE(verified.errors.empty());
    EXPECT_EQ(verified.errors.front().code, formats::ErrorCode::Verification);
    EXPECT_EQ(verified.errors.front().subject, "map_dominant, texture intensity, texel (5, 33)");
}

/// Without blocks one texel may be wrong by itself, wherever it lies.
TEST(CookDominantSoak, OneBrightTexelOfALargeMapIsFound) {
    constexpr int kHeight = 4400;
    static_assert(SmallScene::kWidth * kHeight > 50000);
    const SmallScene scene(SmallScene::Parts::LightMap, sunAndSky, kHeight);
    writeScene(scene, "explained");
    const Outcome verified = verifiedWithWrongTexel(scene, {5, 2001}, kHeight, 0x7bff);
    ASSERT_FALSE(verified.errors.empty());
    EXPECT_NE(verified.errors.front().subject.find("stage total"), std::string::npos) << verified.errors.front().line();
}

}  // namespace
}  // namespace lightcook::pipeline

// Seams of light maps: figures in the report, and the limit on what cooking adds to them.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "formats/image/exr_file.h"
#include "pipeline/cook/cook.h"
#include "pipeline/report/ci_checks.h"
#include "tests/pipeline/rewritten_manifest.h"
#include "tests/pipeline/small_scene.h"
#include "tests/pipeline/walls.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using testing::AllOf;
using testing::HasSubstr;

/// Writes a wall of two quads, each a mesh of its own with another half of the map, which meet at x = 2. The second mesh has its origin
/// elsewhere, and its node takes it to its place.
/// uvs  name of the attribute with the light-map UVs
void writeTwoMeshes(const std::filesystem::path& folder, const std::string& uvs) {
    writeWalls(folder, {.leftUvs = {0.05f, 0, 0.05f, 1, 0.45f, 1, 0.45f, 0},
                        .rightUvs = {0.55f, 0, 0.55f, 1, 0.95f, 1, 0.95f, 0},
                        .right = {1, 6, 5, 1, -1, 5, 3, -1, 5, 3, 6, 5},
                        .rightTranslation = {1, 1, -5},
                        .uvs = uvs});
}

class SeamLimit : public testing::Test {
protected:
    /// entry  lines of [[light_map]] beside its mesh
    Outcome cook(const std::string& output, const std::string& entry = "", const std::string& uvs = "TEXCOORD_1") {
        scene_.writeSceneFile(output + "\ndraco = false");
        writeTwoMeshes(scene_ / "", uvs);
        addToMap("mesh = \"walls.gltf\"\n" + entry);
        return cookScene(options_, RunState());
    }
    void addToMap(const std::string& lines) {
        std::string text = formats::contentOf(scene_.sceneFile());
        text.insert(text.find("file = \"map.exr\""), lines);
        formats::writeContent(scene_.sceneFile(), text);
    }
    std::string mistakeOf(const std::string& output) {
        scene_.writeSceneFile(output);
        const Outcome outcome = cookScene(options_, RunState());
        EXPECT_EQ(outcome.errors.size(), 1u);
        return outcome.errors.empty() ? "" : outcome.errors.front().line();
    }
    static const Json& mapOf(const Outcome& outcome) { return outcome.report.at("assets").at(0); }
    static double addedOf(const Json& map) {
        const Json& last = map.at("seams").at("stages").back();
        return std::max(last.at("diffuse").at("added").at("max").get<double>(), last.at("specular").at("added").at("max").get<double>());
    }

    SmallScene scene_{SmallScene::Parts::LightMap};
    CookOptions options_ = scene_.options();
};

TEST_F(SeamLimit, TheReportHasTheSeamOfTwoMeshes) {
    // Better layouts add no seam that is worth a picture.
    const Outcome outcome = cook("light_map_layout = \"basis-3\"");
    for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
    const Json& seams = mapOf(outcome).at("seams");
    EXPECT_EQ(seams.at("edges"), 1);
    EXPECT_EQ(seams.at("joined_edges"), 2);
    EXPECT_EQ(seams.at("open_edges"), 6);
    EXPECT_EQ(seams.at("places"), 73);
    EXPECT_FALSE(seams.contains("note"));
    ASSERT_EQ(seams.at("stages").size(), 2u);
    // The bake is not the same on both sides; the layout keeps that step but for little.
    const double ofBake = seams.at("bake_diffuse").at("max").get<double>();
    EXPECT_GT(ofBake, 5);
    EXPECT_LT(addedOf(mapOf(outcome)), 0.5 * ofBake);
    const Json& worst = seams.at("worst").at(0);
    EXPECT_EQ(worst.at("added").get<double>(), addedOf(mapOf(outcome)));
    EXPECT_EQ(worst.at("position").at(0), 2.0);
    EXPECT_NEAR(worst.at("texels").at(0).at(0).get<double>(), 0.45 * SmallScene::kWidth - 0.5, 1e-4);
    EXPECT_NEAR(worst.at("texels").at(1).at(0).get<double>(), 0.55 * SmallScene::kWidth - 0.5, 1e-4);
    EXPECT_EQ(worst.at("texels").at(0).at(1), worst.at("texels").at(1).at(1));
    // No step is larger than what the visible errors of both sides allow.
    const Json& error = mapOf(outcome).at("stages").back().at("error");
    for (const char* shading : {"diffuse", "specular"})
        EXPECT_LE(seams.at("stages").back().at(shading).at("added").at("max").get<double>(),
                  2 * error.at(shading).at("visible").at("bound").get<double>());
    EXPECT_EQ(seams.at("places"), 73);
    EXPECT_EQ(seams.at("edges"), 1);
    EXPECT_FALSE(mapOf(outcome).at("preview").at("seams").empty());
}

TEST_F(SeamLimit, FailsAMapThatIsOverItAndNamesTheEdge) {
    const Outcome outcome = cook("light_map_layout = \"ratio\"\nmax_seam = 0.01");
    ASSERT_EQ(outcome.errors.size(), 1u);
    EXPECT_EQ(outcome.errors.front().code, ErrorCode::OverLimit);
    EXPECT_THAT(outcome.errors.front().line(),
                AllOf(HasSubstr("map, seams, "), HasSubstr("found a seam of "),
                      HasSubstr("expected at most 0.01 (max_seam); worst at the edge from (2, "), HasSubstr("normal ("),
                      HasSubstr("a step of "), HasSubstr("at texels ("), HasSubstr("): found ("), HasSubstr("expected (")));
    const Json& map = mapOf(outcome);
    EXPECT_FALSE(map.at("passed").get<bool>());
    EXPECT_EQ(map.at("limit").at("max_seam"), 0.01);
    EXPECT_EQ(map.at("failures").at(0).at("seam").get<double>(), addedOf(map));
    EXPECT_EQ(map.at("failures").at(0).at("seam_at"), map.at("seams").at("worst").at(0));
    // JUnit and SARIF have it as a check of its own.
    const CiRun run = ciRun({"cook", scene_ / "out", scene_.sceneFile(), {}, outcome.report, outcome.errors});
    int seamChecks = 0;
    for (const CiSuite& suite : run.suites)
        for (const CiCheck& check : suite.checks) {
            const bool isSeam = suite.name == "map" && check.rule == CiRule::Seam;
            EXPECT_EQ(check.findings.size(), isSeam ? 1u : 0u) << suite.name;
            seamChecks += isSeam ? 1 : 0;
        }
    EXPECT_EQ(seamChecks, 1);
    // The folder is held to the limit again from its bytes.
    const Outcome verified = verifyCooked({scene_ / "out", {}, {}}, RunState());
    ASSERT_EQ(verified.errors.size(), 1u);
    EXPECT_EQ(verified.errors.front().line(), outcome.errors.front().line());
}

using SeamLimitSoak = SeamLimit;
TEST_F(SeamLimitSoak, OneOfTheLightMapOrTheCommandLineReplacesThatOfTheScene) {
    EXPECT_TRUE(cook("light_map_layout = \"ratio\"\nmax_seam = 0.01", "max_seam = 50\n").errors.empty());
    options_.given.set("output.max_seam", 0.02);
    const Outcome outcome = cookScene(options_, RunState());
    ASSERT_EQ(outcome.errors.size(), 1u);
    EXPECT_EQ(mapOf(outcome).at("limit").at("max_seam"), 0.02);
}

TEST_F(SeamLimit, TheLayoutIsChosenToKeepIt) {
    const Outcome loose = cook("max_seam = 50"), tight = cook("max_seam = 0.5");
    for (const Outcome* outcome : {&loose, &tight})
        for (const formats::Error& error : outcome->errors) ADD_FAILURE() << error.line();
    EXPECT_LE(addedOf(mapOf(tight)), 0.5);
    EXPECT_GT(addedOf(mapOf(loose)), 0.5);
    EXPECT_LT(mapOf(loose).at("bytes_gpu").get<int>(), mapOf(tight).at("bytes_gpu").get<int>());
}

TEST_F(SeamLimit, SeamsThatCannotBeMeasuredHaveANote) {
    const Outcome unmapped = cook("light_map_layout = \"ratio\"", "", "TEXCOORD_0");
    EXPECT_THAT(mapOf(unmapped).at("seams").at("note"), "the mesh has no light-map UVs (TEXCOORD_1)");
    EXPECT_TRUE(mapOf(unmapped).at("passed").get<bool>());
    const Outcome limited = cook("light_map_layout = \"ratio\"\nmax_seam = 1", "", "TEXCOORD_0");
    ASSERT_EQ(limited.errors.size(), 1u);
    EXPECT_THAT(limited.errors.front().line(), HasSubstr("seams: found the mesh has no light-map UVs"));
    scene_.writeSceneFile("light_map_layout = \"ratio\"");
    const Outcome alone = cookScene(options_, RunState());
    EXPECT_THAT(mapOf(alone).at("seams").at("note"), HasSubstr("no mesh"));
}

/// Coverage that ends two texels before the edge: the filter reaches no light of the bake there, and a limit on nothing is not kept.
TEST_F(SeamLimit, FailsWhereNoPlaceOfAnEdgeCanBeMeasured) {
    std::vector<std::string> channels;
    for (int i = 0; i < 9; ++i)
        for (const char channel : {'R', 'G', 'B'}) channels.push_back(fmt::format("sh0{}.{}", i, channel));
    channels.emplace_back("coverage.Y");
    std::vector<float> texels;
    for (int y = 0; y < SmallScene::kHeight; ++y)
        for (int x = 0; x < SmallScene::kWidth; ++x) {
            const lighting::ShRgb sh = shOf(sunAndSky, {(x + 0.5) / SmallScene::kWidth, (y + 0.5) / SmallScene::kHeight});
            for (const glm::vec3& c : sh) texels.insert(texels.end(), {c.x, c.y, c.z});
            texels.push_back(x < 3 || x > 8 ? 1.0f : 0.0f);
        }
    auto writer =
        formats::ExrWriter::create(scene_ / "map.exr", SmallScene::kWidth, SmallScene::kHeight, channels, formats::ExrLayout::ScanLines);
    ASSERT_TRUE(writer.has_value());
    ASSERT_TRUE(writer->append(texels.data(), static_cast<std::ptrdiff_t>(channels.size()) * SmallScene::kWidth, SmallScene::kHeight) &&
                writer->commit());
    const Outcome loose = cook("light_map_layout = \"ratio\"");
    for (const formats::Error& error : loose.errors) ADD_FAILURE() << error.line();
    EXPECT_EQ(mapOf(loose).at("seams").at("places"), 0);
    EXPECT_EQ(mapOf(loose).at("seams").at("dark_places"), 73);
    const Outcome limited = cook("light_map_layout = \"ratio\"\nmax_seam = 50");
    ASSERT_EQ(limited.errors.size(), 1u);
    EXPECT_EQ(limited.errors.front().code, ErrorCode::OverLimit);
    EXPECT_THAT(limited.errors.front().line(), AllOf(HasSubstr("seams: found no place of the 1 edges has a covered texel"),
                                                     HasSubstr("expected coverage that reaches the edges of charts")));
}

/// Seams are measured at the UVs of the source. The mesh that ships may not show others.
TEST_F(SeamLimitSoak, KeepsTheUvsOfTheMeshWhereTheyAreMeasured) {
    const auto cookWith = [&](const std::string& output) {
        scene_.writeSceneFile("light_map_layout = \"ratio\"\nmax_error = 0.9\nmax_visible = 80\n" + output);
        // Corners that lie on no coarse lattice.
        writeWalls(scene_ / "", {.leftUvs = {0.05f, 0, 0.05f, 1, 0.443f, 0.968f, 0.451f, 0.037f},
                                 .rightUvs = {0.55f, 0, 0.56f, 0.977f, 0.95f, 1, 0.93f, 0.029f},
                                 .right = {2, 7, 0, 2, 0, 0, 4, 0, 0, 4, 7, 0}});
        addToMap("mesh = \"walls.gltf\"\n");
        Outcome outcome = cookScene(options_, RunState());
        for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
        return outcome;
    };
    const auto isMesh = [](const Json& asset) { return asset.at("kind") == "mesh"; };
    const auto shiftOf = [&](const Outcome& outcome) {
        const Json& mesh = *std::ranges::find_if(outcome.report.at("assets"), isMesh);
        return SmallScene::kHeight * mesh.at("mesh_error").at("light_map_uv").get<double>();
    };
    const Outcome limited = cookWith("max_seam = 50");
    EXPECT_LE(shiftOf(limited), 1.0 / 64);
    EXPECT_GT(shiftOf(cookWith("")), 1.0 / 64) << "the limits on errors allow that";
    Json manifest = parseJson(formats::contentOf(scene_ / "out" / kManifestName));
    manifest["cooks"][0]["scene"]["output"]["max_seam"] = 50;
    writeManifestAndDigests(scene_ / "out", manifest);
    const Outcome verified = verifyCooked({scene_ / "out", {}, {}}, RunState());
    ASSERT_FALSE(verified.errors.empty());
    std::string lines;
    for (const formats::Error& error : verified.errors) lines += error.line() + "\n";
    EXPECT_THAT(lines, HasSubstr("verify/max_seam: found nothing, expected 50.0 of its scene: cook the scene again"));
    EXPECT_THAT(lines, HasSubstr("at most 0.01562: max_seam is judged at the UVs of the source"));
}

TEST_F(SeamLimit, MistakesAreNamed) {
    EXPECT_THAT(mistakeOf("max_seam = 0"), HasSubstr("found 0 for output.max_seam, expected a positive number of just noticeable"));
    EXPECT_THAT(mistakeOf("max_seam = 1"), HasSubstr("found a limit on seams where no light map has a mesh, expected mesh = \"FILE\""));
    scene_.writeSceneFile("");
    addToMap("max_seam = 1\n");
    const Outcome outcome = cookScene(options_, RunState());
    ASSERT_EQ(outcome.errors.size(), 1u);
    EXPECT_THAT(outcome.errors.front().line(), HasSubstr("found light_map.max_seam without a mesh for 'map', expected mesh = \"FILE\""));
}

}  // namespace
}  // namespace lightcook::pipeline

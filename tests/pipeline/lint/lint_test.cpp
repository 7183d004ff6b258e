// Faults planted one by one in the example scene: each is found under its code, and nothing else is. The scenes as they are have no
// finding.
#include "pipeline/lint/lint.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <numbers>

#include "formats/light_map.h"
#include "lighting/radiometry.h"
#include "pipeline/document/json.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/report/ci_report.h"
#include "pipeline/report/report.h"
#include "tests/pipeline/lint/faults.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Returns the codes of the findings, and the lines of errors that are no findings.
std::vector<std::string> codesOf(const Outcome& outcome) {
    std::vector<std::string> codes;
    for (const Finding& finding : outcome.findings) codes.emplace_back(info(finding.check).name);
    for (const formats::Error& error : outcome.errors)
        if (error.code != ErrorCode::Implausible) codes.push_back(error.line());
    return codes;
}

TEST(Lint, HasNoFindingOnTheExample) {
    const PlantedScene scene;
    const Outcome outcome = scene.lint(true);
    EXPECT_THAT(codesOf(outcome), IsEmpty());
    EXPECT_THAT(outcome.errors, IsEmpty());
}

class LintPublicScene : public testing::TestWithParam<const char*> {};
TEST_P(LintPublicScene, HasNoFinding) {
    const std::filesystem::path data = std::filesystem::path(LIGHTCOOK_SHARED_DATA) / "scenes";
    const std::string name = GetParam();
    if (!std::filesystem::exists(data / (name + "_lightmap.exr"))) GTEST_SKIP() << "no shared data at " << data;
    const formats::TemporaryFolder folder;
    std::string text = fmt::format(
        "schema = 1\nname = \"{0}\"\n[[light_map]]\nname = \"lightmap\"\nfile = \"{1}/{0}_lightmap.exr\"\nmesh = "
        "\"{1}/{0}.glb\"\nground_truth = \"{1}/{0}_reference_a.csv\"\n",
        name, std::filesystem::absolute(data).string());
    for (int i = 0; i < 8; ++i)
        text += fmt::format("[[probe]]\nname = \"probe{2}\"\nfile = \"{1}/{0}_probe{2}.exr\"\nsh = \"{1}/{0}_probes.json\"\n", name,
                            std::filesystem::absolute(data).string(), i);
    formats::writeContent(folder / "scene.toml", text);
    const RunState state;
    const Outcome outcome = lintScene({folder / "scene.toml", folder / "cache", true, false}, state);
    EXPECT_THAT(codesOf(outcome), IsEmpty());
    for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
}
INSTANTIATE_TEST_SUITE_P(All, LintPublicScene, testing::Values("cornell", "interior", "outdoor", "zdm2_sun"),
                         [](const auto& each) { return std::string(each.param); });

// Sign convention and axes

TEST(Lint, NamesTheOtherSignConvention) {
    const PlantedScene scene;
    faults::otherPhase(scene);
    const Outcome outcome = scene.lint();
    ASSERT_THAT(codesOf(outcome), ElementsAre("wrong-phase"));
    EXPECT_THAT(outcome.errors, IsEmpty()) << "a warning";
    EXPECT_THAT(outcome.findings[0].found, HasSubstr("with phase = \"condon-shortley\" it is 0.0 %"));
    EXPECT_GT(outcome.findings[0].figures.at("behind"), 0.5);
    EXPECT_EQ(outcome.findings[0].place.name, "lightmap");
    EXPECT_EQ(outcome.findings[0].place.key, "phase");
    EXPECT_TRUE(outcome.findings[0].line.has_value()) << "the example has the key";
}

TEST(Lint, NamesTheSignConventionThatTheSceneFileHasTooMuch) {
    const PlantedScene scene;
    scene.replaceInScene("phase = \"none\"", "phase = \"condon-shortley\"");
    const Outcome outcome = scene.lint();
    ASSERT_THAT(codesOf(outcome), ElementsAre("wrong-phase"));
    EXPECT_THAT(outcome.findings[0].found, HasSubstr("with phase = \"none\" it is 0.0 %"));
}

TEST(Lint, NamesSwappedAxes) {
    const PlantedScene scene;
    faults::swappedAxes(scene);
    const Outcome outcome = scene.lint();
    ASSERT_THAT(codesOf(outcome), ElementsAre("wrong-axes"));
    EXPECT_THAT(outcome.findings[0].found, HasSubstr("with (x,z,y) of the coefficients as x, y, z it is 0.0 %"));
}

/// A bake without normals takes those of the mesh, which the key does not turn.
TEST(Lint, NamesTheAxesToWrite) {
    const PlantedScene scene;
    faults::swappedAxes(scene);
    scene.editLightMap([](Channels& map) {
        for (const char* name : {"normal.X", "normal.Y", "normal.Z"}) map.values.erase(name);
    });
    const Outcome outcome = scene.lint();
    ASSERT_THAT(codesOf(outcome), ElementsAre("wrong-axes"));
    EXPECT_THAT(outcome.findings[0].found, HasSubstr("with axes = \"x,z,y\" it is 0.0 %"));
    scene.replaceInScene("phase = \"none\"", "phase = \"none\"\naxes = \"-x,y,z\"");
    const Outcome otherwise = scene.lint();
    ASSERT_THAT(codesOf(otherwise), ElementsAre("wrong-axes"));
    EXPECT_THAT(otherwise.findings[0].found, HasSubstr("with axes = \"x,z,y\" it is 0.0 %")) << "from those of the file";
    scene.replaceInScene("axes = \"-x,y,z\"", "axes = \"x,z,y\"");
    EXPECT_THAT(codesOf(scene.lint()), ElementsAre());
    scene.replaceInScene("axes = \"x,z,y\"", "axes = \"x,z,y\"\noutput_axes = \"-x,y,z\"");
    scene.replaceInScene("[output]\n", "[output]\nlight_map_layout = \"bakery\"\n");
    EXPECT_THAT(codesOf(scene.lint()), ElementsAre()) << "the shader that reads the cooked map is not the mesh's matter";
}

TEST(Lint, NamesTheOtherFrame) {
    const PlantedScene scene;
    faults::otherFrame(scene);
    const Outcome outcome = scene.lint();
    ASSERT_THAT(codesOf(outcome), ElementsAre("wrong-frame"));
    EXPECT_THAT(outcome.findings[0].found, HasSubstr("with frame = \"world\" it is 0.0 %"));
}

TEST(Lint, NamesLightFromBehindThatNoConventionExplains) {
    const PlantedScene scene;
    faults::someNormalsTurned(scene);
    EXPECT_THAT(codesOf(scene.lint()), ElementsAre("lit-from-behind"));
}

/// Axes that are there already are no advice.
TEST(Lint, SaysWhereNoOtherAxesLeaveLessLightFromBehind) {
    const PlantedScene scene;
    scene.editLightMap([](Channels& map) {
        for (const char* name : {"normal.X", "normal.Y", "normal.Z"})
            for (std::size_t texel = 0; texel < map.values.at(name).size(); texel += 8) map.values.at(name)[texel] *= -1;
    });
    const Outcome outcome = scene.lint();
    ASSERT_THAT(codesOf(outcome), ElementsAre("lit-from-behind"));
    EXPECT_THAT(outcome.findings[0].found, HasSubstr("; no other axes leave less"));
}

// Quantity, units, curve

TEST(Lint, NamesIrradianceGivenAsRadiance) {
    const PlantedScene scene;
    faults::irradiance(scene);
    const Outcome outcome = scene.lint();
    ASSERT_THAT(codesOf(outcome), ElementsAre("wrong-quantity"));
    EXPECT_THAT(outcome.findings[0].found, HasSubstr("with quantity = \"irradiance\""));
    scene.replaceInScene("quantity = \"radiance\"", "quantity = \"irradiance\"");
    EXPECT_THAT(codesOf(scene.lint()), IsEmpty());
}

TEST(Lint, NamesRadianceGivenAsIrradiance) {
    const PlantedScene scene;
    faults::statedIrradiance(scene);
    const Outcome outcome = scene.lint();
    ASSERT_THAT(codesOf(outcome), ElementsAre("wrong-quantity"));
    EXPECT_THAT(outcome.findings[0].found, HasSubstr("with quantity = \"radiance\""));
}

TEST(Lint, NamesGameUnits) {
    const PlantedScene scene;
    faults::gameUnits(scene);
    const Outcome outcome = scene.lint();
    ASSERT_THAT(codesOf(outcome), ElementsAre("light-units"));
    EXPECT_THAT(outcome.findings[0].found, HasSubstr("with light_units = \"game\""));
    scene.replaceInScene("light_units = \"radiometric\"", "light_units = \"game\"");
    EXPECT_THAT(codesOf(scene.lint()), IsEmpty());
}

TEST(Lint, NamesACurveOnALightMap) {
    const PlantedScene scene;
    faults::gammaCurve(scene);
    EXPECT_THAT(codesOf(scene.lint()), ElementsAre("gamma-curve"));
}

TEST(Lint, NamesPrimariesThatAreNotThoseOfTheSource) {
    const PlantedScene scene;
    faults::otherPrimaries(scene);
    const Outcome outcome = scene.lint();
    ASSERT_THAT(codesOf(outcome), ElementsAre("wrong-primaries"));
    EXPECT_THAT(outcome.errors, IsEmpty()) << "a warning";
    const Finding& finding = outcome.findings[0];
    EXPECT_THAT(finding.found, AllOf(HasSubstr("(0.713, 0.293)"), HasSubstr("as acescg has"), HasSubstr("the source space lin_rec709")));
    EXPECT_GT(finding.figures.at("difference"), 0.1);
    EXPECT_EQ(finding.place.section, "color");
    EXPECT_TRUE(finding.line.has_value()) << "the example has the key";
    scene.replaceInScene("source = \"lin_rec709\"", "source = \"acescg\"");
    EXPECT_THAT(codesOf(scene.lint()), IsEmpty());
    scene.replaceInScene("source = \"acescg\"", "source = \"stated\"");
    EXPECT_THAT(codesOf(scene.lint()), IsEmpty()) << "the remedy that the finding names";
}

constexpr std::array<float, 8> kAcesCg = {0.713f, 0.293f, 0.165f, 0.830f, 0.128f, 0.044f, 0.32168f, 0.33767f};

/// Makes the space of the files ACEScg, and the working one too, in which no texel is negative.
void makeAcesCg(const PlantedScene& scene) {
    for (const std::string key : {"source", "working"}) scene.replaceInScene(key + " = \"lin_rec709\"", key + " = \"acescg\"");
}

TEST(Lint, NamesOtherPrimariesOfAProbeAndAGradientToo) {
    for (const auto& [file, asset] : {std::pair("cornell_probe0.exr", "a probe"), std::pair("clear_sky_256x1.exr", "a gradient")}) {
        const PlantedScene scene;
        scene.statePrimaries(kAcesCg, file);
        const Outcome outcome = scene.lint();
        ASSERT_THAT(codesOf(outcome), ElementsAre("wrong-primaries")) << asset;
        EXPECT_THAT(outcome.findings[0].file, HasSubstr(file));
        EXPECT_THAT(outcome.findings[0].found, AllOf(HasSubstr("as acescg has"), HasSubstr("the source space lin_rec709")));
        makeAcesCg(scene);
        EXPECT_THAT(codesOf(scene.lint()), IsEmpty()) << asset;
    }
}

TEST(Lint, VerificationComparesProbesWithTheSourceOfTheirScene) {
    const PlantedScene scene;
    scene.statePrimaries(kAcesCg, "cornell_probe0.exr");
    CookOptions options;
    options.scene = scene / "scene.toml";
    options.output = scene / "out";
    options.cache = scene / "cache";
    options.only = "probe0";
    options.given.set("output.effort", 0);
    const RunState state;
    EXPECT_THAT(codesOf(cookScene(options, state)), ElementsAre("wrong-primaries"));
    EXPECT_THAT(codesOf(verifyCooked({scene / "out", {}, {}}, state)), ElementsAre("wrong-primaries"));
    makeAcesCg(scene);
    EXPECT_THAT(codesOf(cookScene(options, state)), IsEmpty());
    EXPECT_THAT(codesOf(verifyCooked({scene / "out", {}, {}}, state)), IsEmpty());
}

TEST(Lint, TakesTheStatedPrimariesOfTheSource) {
    const PlantedScene scene;
    scene.statePrimaries({0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f});
    EXPECT_THAT(codesOf(scene.lint()), IsEmpty());
}

TEST(Lint, NamesACurveOnAProbe) {
    const PlantedScene scene;
    faults::gammaCurveOnProbe(scene);
    EXPECT_THAT(codesOf(scene.lint()), ElementsAre("gamma-curve"));
}

TEST(Lint, NamesAProbeOfEightBits) {
    const PlantedScene scene;
    faults::eightBitProbe(scene);
    EXPECT_THAT(codesOf(scene.lint()), ElementsAre("eight-bit-probe"));
}

TEST(Lint, NamesAProbeWhoseLightIsCutAtOne) {
    const PlantedScene scene;
    faults::clippedProbe(scene);
    const Outcome outcome = scene.lint();
    ASSERT_THAT(codesOf(outcome), ElementsAre("clipped-probe"));
    EXPECT_THAT(outcome.findings[0].found, HasSubstr("found a largest value of 1, in "));
}

TEST(Lint, NamesAProbeWithoutLight) {
    const PlantedScene scene;
    faults::blackProbe(scene);
    EXPECT_THAT(codesOf(scene.lint()), ElementsAre("black-probe"));
}

TEST(Lint, NamesAProbeOfAnExposureThatNoTextureHolds) {
    const PlantedScene scene;
    scene.replaceInScene("sh = \"cornell_probes.json\"", "");
    EXPECT_THAT(codesOf(scene.lint()), IsEmpty());
    faults::editProbeValues(scene, [](float value) { return 1e30f * value; });
    const Outcome outcome = scene.lint();
    ASSERT_THAT(codesOf(outcome), ElementsAre("exposure"));
    EXPECT_EQ(outcome.findings[0].place.name, "probe0");
    EXPECT_THAT(outcome.findings[0].found, HasSubstr("mean over the sphere"));
}

TEST(Lint, NamesAGradientWithoutLight) {
    const PlantedScene scene;
    faults::blackGradient(scene);
    EXPECT_THAT(codesOf(scene.lint()), ElementsAre("black-gradient"));
}

TEST(Lint, NamesAProbeWhoseShIsAnother) {
    const PlantedScene scene;
    faults::probeOfAnotherPlace(scene);
    EXPECT_THAT(codesOf(scene.lint()), ElementsAre("probe-sh"));
}

TEST(Lint, NamesAProbeWhoseShIsZero) {
    const PlantedScene scene;
    faults::zeroShOfProbe(scene);
    const Outcome outcome = scene.lint();
    ASSERT_THAT(codesOf(outcome), ElementsAre("probe-sh"));
    EXPECT_THAT(outcome.findings[0].found, HasSubstr("by 100.0 %"));
}

// Coverage and normals

TEST(Lint, RefusesCoverageThatIsNowhereAboveHalf) {
    const PlantedScene scene;
    faults::coverageOfOneHalf(scene);
    const Outcome outcome = scene.lint();
    ASSERT_THAT(codesOf(outcome), ElementsAre("no-coverage"));
    ASSERT_EQ(outcome.errors.size(), 1u);
    EXPECT_EQ(outcome.errors[0].code, ErrorCode::Implausible);
    EXPECT_THAT(outcome.errors[0].line(), AllOf(HasSubstr("cornell_lightmap.exr, no-coverage"), HasSubstr("at most 0.5")));
}

TEST(Lint, NamesMissingCoverage) {
    const PlantedScene scene;
    faults::noCoverageChannel(scene);
    EXPECT_THAT(codesOf(scene.lint()), ElementsAre("missing-coverage")) << "normals tell what is covered";
}

TEST(Lint, NamesMissingCoverageAndNormals) {
    const PlantedScene scene;
    scene.editLightMap([](Channels& map) {
        for (const char* name : {"coverage.Y", "normal.X", "normal.Y", "normal.Z"}) map.values.erase(name);
    });
    EXPECT_THAT(codesOf(scene.lint()), ElementsAre("missing-coverage"));
}

TEST(Lint, NamesNormalsThatNeitherFileNorMeshHas) {
    const PlantedScene scene;
    const auto removeNormals = [](Channels& map) {
        for (const char* name : {"normal.X", "normal.Y", "normal.Z"}) map.values.erase(name);
    };
    scene.editLightMap(removeNormals);
    EXPECT_THAT(codesOf(scene.lint()), ElementsAre()) << "those of the mesh are taken";
    scene.replaceInScene("mesh = \"cornell.glb\"", "");
    EXPECT_THAT(codesOf(scene.lint()), ElementsAre()) << "a layout of all bands needs none";
    scene.replaceInScene("[output]", "[output]\nlight_map_layout = \"godot\"");
    const Outcome outcome = scene.lint();
    ASSERT_THAT(codesOf(outcome), ElementsAre("missing-normals"));
    EXPECT_THAT(outcome.findings[0].found, HasSubstr("expected a mesh or channels normal.X/Y/Z"));
}

TEST(Lint, RefusesCoverageThatIsNotFinite) {
    const PlantedScene scene;
    faults::coverageOfNan(scene);
    const Outcome outcome = scene.lint();
    ASSERT_FALSE(outcome.errors.empty());
    EXPECT_EQ(outcome.errors[0].code, ErrorCode::ValueNotFinite);
    EXPECT_THAT(outcome.errors[0].line(), HasSubstr("cornell_lightmap.exr, channel coverage.Y, texel (100, 7): found nan"));
}

TEST(Lint, RefusesCoverageOutsideItsRange) {
    for (const auto& [fault, found] :
         {std::pair(&faults::coverageOf255, "from 0 to 255"), std::pair(&faults::negativeCoverage, "from -1 to 1")}) {
        const PlantedScene scene;
        fault(scene);
        const Outcome outcome = scene.lint();
        ASSERT_THAT(codesOf(outcome), ElementsAre("coverage-range"));
        EXPECT_EQ(outcome.errors.size(), 1u);
        EXPECT_THAT(outcome.findings[0].found, HasSubstr(found));
    }
}

TEST(Lint, NamesTheRangeOfCoverageThatIsNowhereZero) {
    const PlantedScene scene;
    scene.editLightMap([](Channels& map) { std::ranges::fill(map["coverage.Y"], 255.0f); });
    const Outcome outcome = scene.lint();
    const auto finding = std::ranges::find(outcome.findings, LintCheck::CoverageRange, &Finding::check);
    ASSERT_NE(finding, outcome.findings.end());
    EXPECT_THAT(finding->found, HasSubstr("from 255 to 255"));
}

TEST(Lint, RefusesAProbePositionOfTwoNumbers) {
    const PlantedScene scene;
    Json probes = parseJson(formats::contentOf(scene / "cornell_probes.json"));
    probes.at("probes").at(0)["position"] = {1, 2};
    formats::writeContent(scene / "cornell_probes.json", probes.dump());
    const Outcome outcome = scene.lint();
    ASSERT_FALSE(outcome.errors.empty());
    EXPECT_EQ(outcome.errors[0].code, ErrorCode::WrongShape);
    EXPECT_THAT(outcome.errors[0].line(), HasSubstr("expected three finite numbers"));
}

TEST(Lint, RefusesNormalsThatAreStoredAsColours) {
    const PlantedScene scene;
    faults::encodedNormals(scene);
    const Outcome outcome = scene.lint();
    EXPECT_THAT(codesOf(outcome), ElementsAre("encoded-normals"));
    EXPECT_FALSE(outcome.errors.empty());
}

TEST(Lint, NamesNormalsFarFromUnitLength) {
    const PlantedScene scene;
    faults::longNormals(scene);
    const Outcome outcome = scene.lint();
    ASSERT_THAT(codesOf(outcome), ElementsAre("normal-length"));
    EXPECT_THAT(outcome.findings[0].found, HasSubstr("100.0 % of 43254"));
}

TEST(Lint, RefusesNormalsThatAreAllZero) {
    const PlantedScene scene;
    faults::zeroNormals(scene);
    const Outcome outcome = scene.lint();
    ASSERT_THAT(codesOf(outcome), ElementsAre("zero-normals"));
    EXPECT_EQ(outcome.errors.size(), 1u);
}

TEST(Lint, NamesNormalsThatAreZeroInPlaces) {
    const PlantedScene scene;
    faults::someZeroNormals(scene);
    EXPECT_THAT(codesOf(scene.lint()), ElementsAre("some-zero-normals"));
}

// Light

TEST(Lint, NamesAFireflyAtTheRimOfAChart) {
    const PlantedScene scene;
    std::pair<int, int> place;
    scene.editLightMap([&](Channels& map) { place = faults::rimTexel(map); });
    faults::rimFirefly(scene);
    const Outcome outcome = scene.lint();
    ASSERT_THAT(codesOf(outcome), ElementsAre("rim-firefly"));
    EXPECT_THAT(outcome.findings[0].found, HasSubstr(fmt::format("({}, {}) with 1e+06", place.first, place.second)));
}

TEST(Lint, NamesBlackCharts) {
    const PlantedScene scene;
    faults::blackHalf(scene);
    EXPECT_THAT(codesOf(scene.lint()), ElementsAre("black-charts"));
}

TEST(Lint, NamesAnExposureThatNoScreenShows) {
    const PlantedScene scene;
    faults::faintLight(scene);
    EXPECT_THAT(codesOf(scene.lint()), ElementsAre("exposure"));
}

TEST(Lint, PrintsTheExposureOfTheDarkestLight) {
    const PlantedScene bright, dark;
    faults::faintLight(bright);
    dark.editLightMap([](Channels& map) { map.forEachCoefficient([](int, float& value) { value *= 1e-17f; }); });
    const Outcome expected = bright.lint(), outcome = dark.lint();
    ASSERT_THAT(codesOf(outcome), ElementsAre("exposure"));
    EXPECT_NEAR(outcome.findings[0].figures.at("key") / expected.findings.at(0).figures.at("key"), 1e-10, 1e-12);
}

// Mesh

TEST(Lint, NamesAMeshThatSeveralNodesDraw) {
    const PlantedScene scene;
    faults::drawnTwice(scene);
    const Outcome outcome = scene.lint();
    ASSERT_THAT(codesOf(outcome), ElementsAre("drawn-twice"));
    EXPECT_EQ(outcome.findings[0].figures.at("nodes"), 2);
}

TEST(Lint, NamesAMeshOfWhichANodeDrawsInstances) {
    const PlantedScene scene;
    faults::drawnByInstances(scene);
    const Outcome outcome = scene.lint();
    ASSERT_THAT(codesOf(outcome), ElementsAre("drawn-twice"));
    EXPECT_EQ(outcome.findings[0].figures.at("nodes"), 3);
}

TEST(Lint, RefusesAMeshWithoutArea) {
    const PlantedScene scene;
    faults::flatTriangles(scene);
    const Outcome outcome = scene.lint();
    ASSERT_THAT(codesOf(outcome), ElementsAre("flat-triangles"));
    EXPECT_EQ(outcome.findings[0].figures.at("share"), 1);
    EXPECT_EQ(outcome.errors.size(), 1u);
}

TEST(Lint, NamesNormalsOfAMeshThatAreZero) {
    const PlantedScene scene;
    scene.editMesh([](Glb& glb) {
        // The first primitive's NORMAL is all zeros.
        nlohmann::json& normals = glb.json["accessors"][glb.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"].get<std::size_t>()];
        normals.erase("bufferView");
        normals["sparse"] = {{"count", 0}, {"indices", {{"componentType", 5123}, {"bufferView", 0}}}, {"values", {{"bufferView", 0}}}};
    });
    EXPECT_THAT(codesOf(scene.lint()), ElementsAre("mesh-normals"));
}

TEST(Lint, RefusesAMeshThatNoNodeDraws) {
    const PlantedScene scene;
    faults::noNodes(scene);
    const Outcome outcome = scene.lint();
    ASSERT_EQ(outcome.errors.size(), 1u);
    EXPECT_THAT(outcome.errors[0].line(), HasSubstr("cornell.glb: found no node that draws a mesh of triangles"));
}

TEST(Lint, NamesTheMeshOfAnotherScene) {
    const PlantedScene scene;
    faults::turnedUvs(scene);
    const Outcome outcome = scene.lint();
    ASSERT_THAT(codesOf(outcome), ElementsAre("wrong-mesh"));
    EXPECT_GT(outcome.findings[0].figures.at("uncovered"), 0.05);
}

TEST(Lint, NamesFlippedV) {
    const PlantedScene scene;
    faults::flippedV(scene);
    const Outcome outcome = scene.lint();
    ASSERT_THAT(codesOf(outcome), ElementsAre("flipped-v"));
    EXPECT_THAT(outcome.findings[0].found, HasSubstr("with V upside down it is 0.0 %"));
}

TEST(Lint, NamesUvsOutsideTheMap) {
    const PlantedScene scene;
    faults::uvsOutside(scene);
    EXPECT_THAT(codesOf(scene.lint()), ElementsAre("uv-outside"));
}

TEST(Lint, NamesOverlappingUvs) {
    const PlantedScene scene;
    faults::overlappingUvs(scene);
    EXPECT_THAT(codesOf(scene.lint()), ElementsAre("uv-overlap"));
}

TEST(Lint, MeshesThatNoNodeDrawsDoNotOverlap) {
    const PlantedScene scene;
    faults::undrawnMesh(scene);
    EXPECT_THAT(codesOf(scene.lint()), ElementsAre());
}

TEST(Lint, NamesAMaterialThatNoMeshHas) {
    const PlantedScene scene;
    faults::unknownMaterial(scene);
    const Outcome outcome = scene.lint();
    ASSERT_THAT(codesOf(outcome), ElementsAre("unknown-material"));
    EXPECT_THAT(outcome.findings[0].found, HasSubstr("nearest is '"));
    EXPECT_TRUE(outcome.findings[0].line.has_value());
}

TEST(Lint, NamesAnExtensionOfAMaterialThatIsNotRead) {
    const PlantedScene scene;
    faults::materialExtension(scene);
    const Outcome outcome = scene.lint();
    ASSERT_THAT(codesOf(outcome), ElementsAre("material-extension"));
    EXPECT_THAT(outcome.findings[0].found,
                HasSubstr("found KHR_materials_sheen in material 0 'white', which lightcook does not read; assumed: m = 1"));
    EXPECT_EQ(outcome.findings[0].place.key, "mesh");
    scene.replaceInScene("\nf0 = [0.04, 0.6]", "\n# f0 = [0.04, 0.6]");
    EXPECT_THAT(scene.lint().findings.at(0).found, HasSubstr("assumed: m = 1, f0 = 0.04"));
}

TEST(Lint, NamesNoExtensionOfAMaterialThatTheSceneFileDescribes) {
    const PlantedScene scene;
    faults::materialExtension(scene);
    scene.replaceInScene("\n# m = [0.1, 0.5]", "\nm = [0.1, 0.5]");
    EXPECT_THAT(codesOf(scene.lint()), IsEmpty()) << "it states m and f0 of every material";
    scene.replaceInScene("\nm = [0.1, 0.5]", "\n# m = [0.1, 0.5]");
    scene.replaceInScene("\nspecular = true", "\nspecular = false");
    EXPECT_THAT(codesOf(scene.lint()), IsEmpty()) << "it states that none is specular";
}

TEST(Lint, NamesAMeshThatIsNewerThanItsBake) {
    const PlantedScene scene;
    faults::staleBake(scene);
    const Outcome outcome = scene.lint();
    ASSERT_THAT(codesOf(outcome), ElementsAre("stale-bake"));
    EXPECT_THAT(outcome.findings[0].found, HasSubstr("26.0 hours newer"));
    const auto wordsAfter = [&](int days) {
        const auto bake = std::filesystem::last_write_time(scene / "cornell_lightmap.exr");
        std::filesystem::last_write_time(scene / "cornell.glb", bake + std::chrono::hours(24 * days));
        return scene.lint().findings.at(0).found;
    };
    EXPECT_THAT(wordsAfter(12), HasSubstr("a mesh 12 days newer"));
    EXPECT_THAT(wordsAfter(20454), HasSubstr("a mesh 56 years newer"));
}

// Settings

TEST(Lint, NamesALimitAboveOne) {
    const PlantedScene scene;
    faults::limitAboveOne(scene);
    const Outcome outcome = scene.lint();
    ASSERT_THAT(codesOf(outcome), ElementsAre("limit-above-one"));
    EXPECT_THAT(outcome.findings[0].found, HasSubstr("max_error = 2, which is 200 %"));
}

TEST(Lint, NamesADisplayThatShowsNoErrorOfTheMap) {
    for (const auto& [key, value, words] :
         {std::tuple{"white", "1e6", "e-05 cd/m^2, expected light that is visible beside a black of 0.5"},
          std::tuple{"stops", "-18", "cd/m^2, expected light that is visible beside a black of 0.5"},
          std::tuple{"stops", "20", "'lightmap' shown at 3.83e+07 cd/m^2, expected at most 10000 cd/m^2"}}) {
        SCOPED_TRACE(fmt::format("{} = {}", key, value));
        const PlantedScene scene;
        faults::display(scene, fmt::format("{} = {}", key, value));
        const Outcome outcome = scene.lint();
        ASSERT_THAT(codesOf(outcome), ElementsAre("display-exposure"));
        EXPECT_THAT(outcome.findings[0].found, HasSubstr(words));
        EXPECT_EQ(outcome.findings[0].place.section, "display");
        EXPECT_EQ(outcome.findings[0].place.key, key);
        EXPECT_TRUE(outcome.findings[0].line.has_value());
    }
}

/// Black differs from the map by less than the limit allows: it would pass.
TEST(Lint, NamesADisplayOnWhichBlackKeepsTheLimit) {
    for (const auto& [limit, isFinding] : {std::pair("1", false), std::pair("100", true)}) {
        SCOPED_TRACE(limit);
        const PlantedScene scene;
        faults::display(scene, "white = 64");
        scene.replaceInScene("[output]", fmt::format("[output]\nmax_visible = {}", limit));
        const Outcome outcome = scene.lint();
        EXPECT_EQ(!outcome.findings.empty(), isFinding);
        if (!isFinding) continue;
        EXPECT_THAT(outcome.findings.at(0).found, HasSubstr("beside a black of 0.5 cd/m^2, by more than the limit of 100"));
    }
}

TEST(Lint, ReportsAMissingFileOfTracedLight) {
    const PlantedScene scene;
    scene.replaceInScene("[[light_map]]", "[[light_map]]\nground_truth = \"traced.csv\"");
    const Outcome outcome = scene.lint();
    ASSERT_FALSE(outcome.errors.empty());
    EXPECT_THAT(outcome.errors[0].line(), HasSubstr("traced.csv: found no such file"));
}

/// Traced light of a scene that is right, times a factor.
void traceLight(const PlantedScene& scene, double factor, const char* kind) {
    std::string csv = "x,y,kind,m,f0,dx,dy,dz,r,g,b\n";
    const auto bake = formats::LightMapReader::open(scene / "cornell_lightmap.exr", {});
    ASSERT_TRUE(bake.has_value());
    const auto strip = bake->read(0, bake->height());
    ASSERT_TRUE(strip.has_value());
    for (int y = 0; y < bake->height(); y += 3)
        for (int x = 0; x < bake->width(); x += 3) {
            if (strip->covered.at(x, y) == 0) continue;
            const glm::vec3 normal = strip->normal.at(x, y);
            const bool isLambert = std::string(kind) == "lambert";
            // A rough surface of f0 1 shows about the exit radiance of a white one.
            const glm::dvec3 light =
                factor * (isLambert ? 1 : std::numbers::inv_pi) * glm::dvec3(lighting::irradiance(strip->sh.at(x, y), normal).value);
            csv += fmt::format("{},{},{},{},{},{},{},{},{},{},{}\n", x, y, kind, isLambert ? 0 : 1, isLambert ? 0 : 1, normal.x, normal.y,
                               normal.z, light.x, light.y, light.z);
        }
    formats::writeContent(scene / "traced.csv", csv);
    scene.replaceInScene("[[light_map]]", "[[light_map]]\nground_truth = \"traced.csv\"");
}

void expectOtherUnit(double factor, const char* kind, const char* words) {
    SCOPED_TRACE(fmt::format("{} times {}", kind, factor));
    const PlantedScene scene;
    traceLight(scene, factor, kind);
    const Outcome outcome = scene.lint();
    ASSERT_THAT(codesOf(outcome), ElementsAre("ground-truth-units"));
    EXPECT_THAT(outcome.findings[0].file, testing::EndsWith("traced.csv"));
    EXPECT_THAT(outcome.findings[0].found, HasSubstr(words));
}

TEST(Lint, FindsTracedLightInAnotherUnit) {
    expectOtherUnit(1 / std::numbers::pi, "lambert", "found traced light 0.318 times that of cornell_lightmap.exr");
    expectOtherUnit(1 / std::numbers::pi, "lambert", "at the median of its values, about 1 / pi, expected");
    expectOtherUnit(std::numbers::pi, "lambert", "at the median of its values, about pi, expected");
    for (const char* kind : {"lambert", "spec"})
        for (const double factor : {100.0, 0.01, 0.0}) expectOtherUnit(factor, kind, "at the median of its values, expected");
}

/// Noise, and light that nine coefficients do not hold.
TEST(Lint, HasNoFindingOnTracedLightThatIsALittleOff) {
    for (const double factor : {0.75, 1.0, 1.3}) {
        const PlantedScene scene;
        traceLight(scene, factor, "lambert");
        EXPECT_THAT(codesOf(scene.lint()), IsEmpty()) << factor;
    }
}

TEST(Lint, HasNoFindingOnADisplayOfAnotherExposure) {
    for (const char* display : {"white = 1", "white = 16", "stops = 4", "stops = -4", "black = 5"}) {
        const PlantedScene scene;
        faults::display(scene, display);
        EXPECT_THAT(codesOf(scene.lint()), IsEmpty()) << display;
    }
}

// What becomes of a finding

PlantedScene sceneWithWarning(const std::string& allow) {
    PlantedScene scene;
    faults::flippedV(scene);
    scene.replaceInScene("schema = 1", allow + "\nschema = 1");
    return scene;
}

TEST(LintAllow, SilencesAWarningWithItsReason) {
    const PlantedScene scene = sceneWithWarning("allow = [{ code = \"flipped-v\", reason = \"fixed next week\" }]");
    const Outcome outcome = scene.lint(true);
    EXPECT_THAT(outcome.errors, IsEmpty()) << "also with --strict";
    ASSERT_THAT(codesOf(outcome), ElementsAre("flipped-v"));
    EXPECT_EQ(outcome.findings[0].allowed, "fixed next week");
}

TEST(LintAllow, OfAnotherAssetSilencesNothing) {
    const PlantedScene scene = sceneWithWarning("allow = [{ code = \"flipped-v\", asset = \"probe0\", reason = \"\" }]");
    EXPECT_FALSE(scene.lint().findings.at(0).allowed.has_value());
}

TEST(LintAllow, RefusesWhatIsNoCode) {
    const auto lineOf = [](const std::string& allow) {
        const PlantedScene scene;
        scene.replaceInScene("schema = 1", allow + "\nschema = 1");
        const Outcome outcome = scene.lint();
        EXPECT_EQ(outcome.errors.at(0).code, ErrorCode::InvalidRequest);
        return outcome.errors.at(0).line();
    };
    EXPECT_THAT(lineOf("allow = [\"fliped-v\"]"),
                HasSubstr("found the code 'fliped-v' in allow, expected one of `lightcook lint`; nearest is 'flipped-v'"));
    EXPECT_THAT(lineOf("allow = [\"no-coverage\"]"), HasSubstr("this one is an error, which cannot be allowed"));
    EXPECT_THAT(lineOf("allow = [{ code = \"flipped-v\", raeson = \"\" }]"), HasSubstr("unknown key 'raeson' in allow"));
    EXPECT_THAT(lineOf("allow = [3]"), HasSubstr("found no code in allow"));
    EXPECT_THAT(lineOf("allow = \"flipped-v\""), HasSubstr("expected a list of codes"));
}

TEST(Lint, StrictMakesAWarningAnError) {
    const Outcome outcome = sceneWithWarning("").lint(true);
    ASSERT_EQ(outcome.errors.size(), 1u);
    EXPECT_EQ(outcome.errors[0].code, ErrorCode::Implausible);
}

TEST(Lint, CookRefusesAnErrorAndLeavesNothing) {
    const PlantedScene scene;
    scene.editLightMap([](Channels& map) {
        for (float& value : map["coverage.Y"]) value = 0;
    });
    CookOptions options;
    options.scene = scene / "scene.toml";
    options.output = scene / "out";
    options.cache = scene / "cache";
    const RunState state;
    const Outcome outcome = cookScene(options, state);
    ASSERT_EQ(outcome.errors.size(), 1u);
    EXPECT_EQ(outcome.errors[0].code, ErrorCode::Implausible);
    EXPECT_FALSE(std::filesystem::exists(scene / "out"));
}

/// A warning changes no byte that an engine reads, whether lint or a file time made it; cook, warm cook and verify all report it.
TEST(LintSoak, CookAndVerifyReportAWarning) {
    const PlantedScene scene;
    scene.replaceInScene("max_error = 0.02 ", "light_map_layout = \"ratio\"\nmax_error = 0.9\neffort = 0 ");
    CookOptions options;
    options.scene = scene / "scene.toml";
    options.output = scene / "out";
    options.cache = scene / "cache";
    options.only = "lightmap";
    const RunState state;
    const Outcome plain = cookScene(options, state);
    EXPECT_THAT(plain.findings, IsEmpty());
    const std::string manifest = formats::contentOf(scene / "out" / "cooked.json");

    faults::staleBake(scene);
    for (int i = 0; i < 2; ++i) {
        const Outcome cooked = cookScene(options, state);
        ASSERT_THAT(codesOf(cooked), ElementsAre("stale-bake"));
        EXPECT_EQ(cooked.actionsRun, 0);
        EXPECT_EQ(formats::contentOf(scene / "out" / "cooked.json"), manifest);
        const auto report = loadReport(scene / "out" / "report.json");
        ASSERT_TRUE(report.has_value());
        ASSERT_EQ(report->findings.size(), 1u);
        EXPECT_EQ(report->findings[0].check, LintCheck::StaleBake);
        EXPECT_THAT(formats::contentOf(scene / "out" / "report.html"), HasSubstr("stale-bake"));
    }
    const Outcome verified = verifyCooked({scene / "out", {}, {}}, state);
    EXPECT_THAT(codesOf(verified), ElementsAre("stale-bake"));
    VerifyOptions strict{scene / "out", {}, {}};
    strict.strict = true;
    EXPECT_THAT(verifyCooked(strict, state).errors, IsEmpty()) << "a note: file times prove nothing";
}

TEST(Lint, StrictMakesWarningsErrorsAndLeavesNotes) {
    const PlantedScene scene;
    faults::rimFirefly(scene);
    faults::flippedV(scene);
    const Outcome outcome = scene.lint(true);
    std::vector<std::string> severities;
    for (const Finding& finding : outcome.findings)
        severities.push_back(fmt::format("{} {}", info(finding.check).name, enumNames<LintSeverity>()[std::size_t(finding.severity)]));
    EXPECT_THAT(severities, testing::UnorderedElementsAre("rim-firefly note", "flipped-v error"));
    EXPECT_EQ(outcome.errors.size(), 1u);
    const CiRun run = ciRun({"lint", {}, "scene.toml", {}, outcome.report, outcome.errors, &outcome.findings});
    EXPECT_THAT(junitReport(run), AllOf(HasSubstr("name=\"rim-firefly\" time=\"0\"/>"), HasSubstr("the brightest at")));
    std::vector<std::string> levels;
    const Json sarif = parseJson(sarifReport(run));
    for (const Json& result : sarif["runs"][0]["results"])
        levels.push_back(result["ruleId"].get<std::string>() + " " + result["level"].get<std::string>());
    EXPECT_THAT(levels, testing::UnorderedElementsAre("rim-firefly note", "flipped-v error"));
}

TEST(Lint, JUnitAndSarifHaveTheFindings) {
    const Outcome outcome = sceneWithWarning("").lint();
    const CiRun run = ciRun({"lint", {}, "scene.toml", {}, outcome.report, outcome.errors, &outcome.findings});
    const std::string junit = junitReport(run);
    EXPECT_THAT(junit, AllOf(HasSubstr("name=\"flipped-v\" time=\"0\"/>"), HasSubstr("<system-out>"), HasSubstr("with V upside down")));
    const Json sarif = parseJson(sarifReport(run));
    const Json& driver = sarif["runs"][0]["tool"]["driver"];
    ASSERT_EQ(sarif["runs"][0]["results"].size(), 1u);
    const Json& result = sarif["runs"][0]["results"][0];
    EXPECT_EQ(result["ruleId"], "flipped-v");
    EXPECT_EQ(result["level"], "warning");
    EXPECT_EQ(driver["rules"][result["ruleIndex"].get<std::size_t>()]["id"], "flipped-v");
    EXPECT_GT(result["locations"][0]["physicalLocation"]["region"]["startLine"], 1);
    EXPECT_FALSE(result.contains("suppressions"));

    const Outcome strict = sceneWithWarning("").lint(true);
    const CiRun failed = ciRun({"lint", {}, "scene.toml", {}, strict.report, strict.errors, &strict.findings});
    EXPECT_THAT(junitReport(failed), HasSubstr("<failure type=\"flipped-v\""));
    EXPECT_EQ(parseJson(sarifReport(failed))["runs"][0]["results"].size(), 1u) << "the error is not told twice";
}

TEST(LintPage, ListsTheChecks) {
    const std::string page = formats::contentOf(std::filesystem::path(LIGHTCOOK_SOURCE_DIR) / "docs/guide/lint.md");
    EXPECT_THAT(page, HasSubstr(lintCheckTable()));
}

}  // namespace
}  // namespace lightcook::pipeline

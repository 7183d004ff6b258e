// Hostile surroundings of a cook: names that clash, inputs beside inputs, JSON that somebody has edited.
#include <gmock/gmock.h>

#include "formats/light_map_layout.h"
#include "lighting/radiometry.h"
#include "lighting/sphere.h"
#include "pipeline/cook/integrity.h"
#include "pipeline/cook/plan.h"
#include "pipeline/document/json.h"
#include "pipeline/graph/digest.h"
#include "pipeline/graph/files.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/report/page.h"
#include "tests/formats/read_light_map.h"
#include "tests/pipeline/rewritten_manifest.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using testing::HasSubstr;
using Parts = SmallScene::Parts;

std::vector<std::string> assetNames(const SmallScene& scene) {
    std::vector<std::string> names;
    const auto manifest = readManifest(scene / "out");
    if (!manifest) return names;
    for (const Json& asset : manifest->at("assets")) names.push_back(asset.at("name").get<std::string>());
    return names;
}

void replaceInScene(const SmallScene& scene, const std::string& what, const std::string& with) {
    std::string text = formats::contentOf(scene.sceneFile());
    ASSERT_NE(text.find(what), std::string::npos);
    formats::writeContent(scene.sceneFile(), text.replace(text.find(what), what.size(), with));
}

TEST(Names, ARenamedAssetIsCookedUnderItsNewName) {
    const SmallScene scene(Parts::LightMap);
    ASSERT_TRUE(cook(scene.options()).errors.empty());
    replaceInScene(scene, "name = \"map\"", "name = \"room.v2\"");
    ASSERT_TRUE(cook(scene.options()).errors.empty());
    EXPECT_THAT(assetNames(scene), testing::ElementsAre("room.v2", "room.v2_dominant", "specular"));
    EXPECT_TRUE(std::filesystem::exists(scene / "out" / "room.v2_l0.ktx2"));
    EXPECT_FALSE(std::filesystem::exists(scene / "out" / "map_l0.ktx2"));
}

TEST(Names, AssetsWhoseFilesWouldClashAreRefused) {
    for (const char* name : {"map_dominant", "map_l0", "map_dominant_direction", "specular_c0236"}) {
        const SmallScene scene(Parts::LightMap);
        replaceInScene(scene, "[[light_map]]", fmt::format("[[gradient]]\nname = \"{}\"\nfile = \"x.exr\"\n\n[[light_map]]", name));
        const Outcome outcome = cook(scene.optionsWithOwnCache());
        ASSERT_EQ(outcome.errors.size(), 1u) << name;
        EXPECT_EQ(outcome.errors[0].code, ErrorCode::InvalidRequest);
        EXPECT_THAT(outcome.errors[0].line(), HasSubstr(name));
        EXPECT_FALSE(std::filesystem::exists(scene / "out"));
    }
}

TEST(Names, AMeshUnderTwoLightMapsIsAnAssetForEach) {
    Scene scene;
    scene.output.lightMapLayout = "ratio";
    for (const char* name : {"sun", "sky"}) {
        LightMapEntry entry;
        entry.name = name;
        entry.file = fmt::format("{}.exr", name);
        entry.mesh = "room.glb";
        scene.lightMaps.push_back(entry);
    }
    const auto plan = planScene(scene, Needs{}, {});
    ASSERT_TRUE(plan.has_value());
    EXPECT_THAT(plan->assets, testing::IsSupersetOf({"sun_room_mesh", "sky_room_mesh"}));
    scene.lightMaps.pop_back();
    EXPECT_THAT(planScene(scene, Needs{}, {})->assets, testing::Contains("room_mesh"));
}

TEST(Materials, AMirrorCanBeCooked) {
    const SmallScene scene(Parts::LightMap);
    for (const char* range : {"[0, 0]", "[0, 1]"}) {
        scene.writeSceneFile("effort = 0", fmt::format("[[material]]\nname = \"*\"\nm = {}\nf0 = [0, 1]\n", range));
        const Outcome outcome = cook(scene.options());
        EXPECT_TRUE(outcome.errors.empty()) << outcome.errors.front().line();
    }
}

/// Names of the layouts that need no mesh.
std::vector<std::string> layoutsWithoutMesh() {
    std::vector<std::string> names;
    for (const formats::LightMapLayoutInfo& layout : formats::allLightMapLayouts())
        if (!layout.isInTangentSpace) names.emplace_back(layout.name);
    return names;
}

/// The outcome of one texel in one layout.
struct CookedTexel {
    std::string line;   ///< of the error; empty: it was cooked
    double stated = 0;  ///< error of diffuse light at texel centres, in the report
    double error = 0;   ///< that of the coefficients that a shader's floats decode from the files
};

/// Returns the error of diffuse light over the normals of a hemisphere, RMS over the light's own, of white light that is the same from
/// everywhere.
double diffuseError(const lighting::ShRgb& decoded, float light) {
    constexpr int kNormals = 256;
    double sum = 0;
    for (int i = 0; i < kNormals; ++i) {
        const lighting::ShDouble basis = lighting::evaluateBasis(lighting::fibonacciHemisphere(i, kNormals));
        glm::dvec3 error(-1);
        for (std::size_t c = 0; c < basis.size(); ++c)
            error += lighting::kExitRadianceBands[static_cast<std::size_t>(lighting::kShBand[c])] * basis[c] / basis[0] *
                     (glm::dvec3(decoded[c]) / static_cast<double>(light));
        sum += glm::dot(error, error) / 3;
    }
    return std::sqrt(sum / kNormals);
}

/// Cooks a black map with one texel of `value`, once for each layout.
std::map<std::string, CookedTexel> cookOneTexel(float value) {
    const SmallScene scene(Parts::LightMap);
    formats::Image<lighting::ShRgb> rows(8, 8, lighting::ShRgb{});
    rows.at(5, 3)[0] = glm::vec3(value);
    auto writer = formats::LightMapWriter::create(scene / "map.exr", 8, 8);
    EXPECT_TRUE(writer && writer->append(rows.view()) && writer->commit());
    std::map<std::string, CookedTexel> cooked;
    for (const std::string& layout : layoutsWithoutMesh()) {
        CookedTexel& texel = cooked[layout];
        scene.writeSceneFile(fmt::format("light_map_layout = \"{}\"", layout), "firefly_limit = 0");
        const Outcome outcome = cook(scene.options());
        if (!outcome.errors.empty()) {
            EXPECT_EQ(outcome.errors.front().code, ErrorCode::OverLimit) << layout;
            texel.line = outcome.errors.front().line();
            continue;
        }
        const Json& total = outcome.report.at("assets").at(0).at("stages").back();
        texel.stated = total.at("at_texels").at("diffuse").at("rel_rms").get<double>();
        const auto written = reconstructLightMap(scene / "out", "map", scene / "decoded.exr", 1, RunState());
        EXPECT_TRUE(written.has_value()) << layout << ": " << written.error().line();
        formats::LightMapDescription description;
        description.isCompressed = true;
        texel.error = diffuseError(formats::readAll(scene / "decoded.exr", description).sh.at(5, 3), value);
    }
    return cooked;
}

/// Each layout states the loss of the texel in its report, or is refused by name.
void expectAsStatedOrRefused(const std::string& layout, const CookedTexel& texel) {
    if (texel.line.empty())
        EXPECT_NEAR(texel.error, texel.stated, 0.02 * texel.stated + 1e-6) << layout;
    else
        EXPECT_THAT(texel.line, HasSubstr("map, ")) << layout;
}

/// Light is measured in units of the map's key, which one bright texel in the dark hardly raises: 1e24 is light like other light, but for
/// layouts of engines, whose halves hold light in the engine's unit, or whose ranges multiply. halo3 filters two textures, whose product is
/// far off between two texels one of which is a million times as bright.
TEST(LightSoak, OneTexelFarBeyondTheSunIsCooked) {
    for (const float value : {1e6f, 1e24f})
        for (const auto& [layout, texel] : cookOneTexel(value)) {
            expectAsStatedOrRefused(layout, texel);
            if (formats::info(*formats::lightMapLayoutFromName(layout)).isForEngine) continue;
            EXPECT_EQ(texel.line, "") << layout;
            EXPECT_LT(texel.error, 0.02) << layout;
        }
}

/// So is the largest float, as long as a shader's floats decode it. Where rounding may bring it beyond, a layout is refused by name.
TEST(LightSoak, TheLargestFloatIsCookedWhereShadersDecodeIt) {
    int held = 0;
    for (const auto& [layout, texel] : cookOneTexel(3.4e38f)) {
        expectAsStatedOrRefused(layout, texel);
        held += texel.line.empty() && texel.error < 0.02 ? 1 : 0;
    }
    EXPECT_GE(held, 15);
}

/// A grey map with a firefly in the middle of it and one at the edge of a chart's band of rows, and what cooking it gives.
struct FireflyMap {
    static constexpr int kSize = 80;
    SmallScene scene{Parts::LightMap};

    explicit FireflyMap(float value) {
        formats::Image<lighting::ShRgb> rows(kSize, kSize, lighting::ShRgb{});
        for (lighting::ShRgb& sh : rows.texels()) sh[0] = glm::vec3(0.5f);
        for (const auto& [x, y] : {std::pair(30, 20), std::pair(7, 63), std::pair(70, 64)}) rows.at(x, y)[0].g = value;
        auto writer = formats::LightMapWriter::create(scene / "map.exr", kSize, kSize);
        EXPECT_TRUE(writer && writer->append(rows.view()) && writer->commit());
    }
    Outcome cookWith(const std::string& lightMapKeys, bool repair) const {
        scene.writeSceneFile("light_map_layout = \"ratio\"\nmax_error = 0.9", lightMapKeys);
        CookOptions options = scene.options();
        options.repair = repair;
        return cook(options);
    }
};

TEST(Fireflies, AreRefusedRepairedOnRequestOrKeptBelowALimit) {
    const FireflyMap map(700);
    const Outcome refused = map.cookWith("", false);
    ASSERT_FALSE(refused.errors.empty());
    EXPECT_EQ(refused.errors.front().code, ErrorCode::ValueOutOfRange);
    EXPECT_THAT(refused.errors.front().line(),
                AllOf(HasSubstr("map.exr, channel sh00.G, texel (30, 20)"), HasSubstr("found light of 700"),
                      HasSubstr("expected at most 1000 times that of its brightest neighbour (0.5)"), HasSubstr("firefly_limit")));
    const Outcome repaired = map.cookWith("", true);
    ASSERT_TRUE(repaired.errors.empty()) << repaired.errors.front().line();
    EXPECT_EQ(repaired.report.at("assets").at(0).at("notes").at("repaired_fireflies"), 3);
    const double mended = repaired.report.at("assets").at(0).at("stages").back().at("error").at("diffuse").at("rel_rms").get<double>();
    EXPECT_LT(mended, 0.01) << "the verifier holds it against the repaired map";
    for (const Outcome& believed :
         {map.cookWith("firefly_limit = 0", false), map.cookWith("firefly_limit = 1500", false), FireflyMap(400).cookWith("", false)}) {
        ASSERT_TRUE(believed.errors.empty()) << believed.errors.front().line();
        EXPECT_EQ(believed.report.at("assets").at(0).at("notes").at("repaired_fireflies"), 0);
    }
}

const char* const kTriangle = R"({"asset":{"version":"2.0"},"buffers":[{"uri":"tri%20angle.bin","byteLength":60}],
"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":24}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
{"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_1":1}}]}],"nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}],"scene":0})";

TEST(Inputs, ABufferBesideAMeshCountsAsAnInput) {
    const SmallScene scene(Parts::LightMap);
    std::vector<float> buffer = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1};
    const auto writeBuffer = [&] {
        formats::writeContent(scene / "tri angle.bin", std::string(reinterpret_cast<const char*>(buffer.data()), 60));
    };
    writeBuffer();
    formats::writeContent(scene / "triangle.gltf", kTriangle);
    replaceInScene(scene, "file = \"map.exr\"", "file = \"map.exr\"\nmesh = \"triangle.gltf\"");
    CookOptions options = scene.optionsWithOwnCache();
    options.depfile = scene / "cook.d";
    Outcome outcome = cook(options);
    ASSERT_TRUE(outcome.errors.empty()) << outcome.errors.front().line();
    EXPECT_THAT(formats::contentOf(scene / "cook.d"), HasSubstr("tri\\ angle.bin"));
    EXPECT_EQ(cook(options).actionsRun, 0);
    buffer[3] = 2;
    writeBuffer();
    outcome = cook(options);
    EXPECT_TRUE(outcome.errors.empty());
    EXPECT_GT(outcome.actionsRun, 0);
}

TEST(Inputs, AColourConfigurationCountsAsAnInputAndMayMove) {
    const SmallScene scene(Parts::LightMap);
    const auto writeConfig = [&](double scale) {
        formats::writeContent(scene / "c.ocio", fmt::format("ocio_profile_version: 2\nroles: {{default: w, scene_linear: w}}\n"
                                                            "displays: {{d: [!<View> {{name: v, colorspace: w}}]}}\ncolorspaces:\n"
                                                            "  - !<ColorSpace> {{name: w}}\n"
                                                            "  - !<ColorSpace> {{name: s, to_reference: !<MatrixTransform> {{matrix: "
                                                            "[{0}, 0, 0, 0, 0, {0}, 0, 0, 0, 0, {0}, 0, 0, 0, 0, 1]}}}}\n",
                                                            scale));
    };
    writeConfig(0.5);
    formats::writeContent(scene.sceneFile(),
                          formats::contentOf(scene.sceneFile()) + "\n[color]\nsource = \"s\"\nworking = \"w\"\nconfig = \"c.ocio\"\n");
    Outcome outcome = cook(scene.optionsWithOwnCache());
    ASSERT_TRUE(outcome.errors.empty()) << outcome.errors.front().line();
    writeConfig(0.25);
    outcome = cook(scene.optionsWithOwnCache());
    EXPECT_TRUE(outcome.errors.empty());
    EXPECT_GT(outcome.actionsRun, 0);

    std::filesystem::create_directory(scene / "moved");
    for (const char* file : {"c.ocio", "map.exr"}) std::filesystem::rename(scene / file, scene / "moved" / file);
    const RunState state;
    EXPECT_TRUE(verifyCooked({scene / "out", scene / "moved", {}}, state).errors.empty());
}

TEST(Inputs, AMatrixThatAColourConfigurationRefersToCountsAsAnInputAndMayMove) {
    const SmallScene scene(Parts::LightMap);
    const auto writeMatrix = [&](double scale) {
        formats::writeContent(scene / "m.spimtx", fmt::format("{0} 0 0 0\n0 {0} 0 0\n0 0 {0} 0\n", scale));
    };
    writeMatrix(0.5);
    formats::writeContent(scene / "c.ocio",
                          "ocio_profile_version: 2\nroles: {default: w, scene_linear: w}\n"
                          "displays: {d: [!<View> {name: v, colorspace: w}]}\ncolorspaces:\n"
                          "  - !<ColorSpace> {name: w}\n"
                          "  - !<ColorSpace> {name: s, to_reference: !<FileTransform> {src: m.spimtx}}\n");
    formats::writeContent(scene.sceneFile(),
                          formats::contentOf(scene.sceneFile()) + "\n[color]\nsource = \"s\"\nworking = \"w\"\nconfig = \"c.ocio\"\n");
    CookOptions options = scene.optionsWithOwnCache();
    options.depfile = scene / "cook.d";
    Outcome outcome = cook(options);
    ASSERT_TRUE(outcome.errors.empty()) << outcome.errors.front().line();
    EXPECT_THAT(formats::contentOf(scene / "cook.d"), HasSubstr("m.spimtx"));
    writeMatrix(0.25);
    outcome = cook(options);
    EXPECT_TRUE(outcome.errors.empty());
    EXPECT_GT(outcome.actionsRun, 0);

    std::filesystem::create_directory(scene / "moved");
    for (const char* file : {"c.ocio", "m.spimtx", "map.exr"}) std::filesystem::rename(scene / file, scene / "moved" / file);
    const RunState state;
    EXPECT_TRUE(verifyCooked({scene / "out", scene / "moved", {}}, state).errors.empty());
}

/// The manifest depends on the inputs of every asset that it describes, and of no other.
TEST(Inputs, ADepfileNamesTheInputsOfTheAssetsInTheFolder) {
    const SmallScene scene(Parts::All);
    CookOptions options = scene.options();
    options.depfile = scene / "cook.d";
    options.only = "map";
    const auto depfile = [&] {
        EXPECT_TRUE(cook(options).errors.empty());
        return formats::contentOf(scene / "cook.d");
    };
    EXPECT_THAT(depfile(), testing::AllOf(HasSubstr("map.exr"), testing::Not(HasSubstr("sky.exr")), testing::Not(HasSubstr("probe.exr"))));
    options.only = {};
    EXPECT_THAT(depfile(), testing::AllOf(HasSubstr("map.exr"), HasSubstr("sky.exr"), HasSubstr("probe.exr")));
    options.only = "map";
    EXPECT_THAT(depfile(), testing::AllOf(HasSubstr("map.exr"), HasSubstr("sky.exr"), HasSubstr("probe.exr"))) << "they were left alone";
}

/// Options of a cook of the gradient alone.
CookOptions gradientAlone(const SmallScene& scene) {
    CookOptions options = scene.options();
    options.onlyKind = "rsrm";
    return options;
}

TEST(Inputs, OneInTheOutputFolderIsNotReplacedByAnOutput) {
    for (const char* name : {"lightcook.glsl", "sky.ktx2", "report.html"}) {
        SCOPED_TRACE(name);
        const SmallScene scene(Parts::All);
        const std::filesystem::path place = scene / "out" / name;
        std::filesystem::create_directories(place.parent_path());
        std::filesystem::rename(scene / "sky.exr", place);
        replaceInScene(scene, "\"sky.exr\"", fmt::format("\"out/{}\"", name));
        const std::string before = formats::contentOf(place);
        const Outcome outcome = cook(gradientAlone(scene));
        ASSERT_EQ(outcome.errors.size(), 1u);
        EXPECT_EQ(outcome.errors[0].code, ErrorCode::InvalidRequest);
        EXPECT_EQ(outcome.errors[0].line(),
                  place.string() + ": found a file of the scene in the place of an output, expected another output folder");
        EXPECT_EQ(formats::contentOf(place), before);
        EXPECT_FALSE(std::filesystem::exists(scene / "out" / kManifestName));
    }
}

/// A picture in place of a texture that the new manifest does not name.
TEST(Inputs, OneThatAnEarlierCookWroteIsNotRemoved) {
    const SmallScene scene(Parts::All);
    ASSERT_TRUE(cook(gradientAlone(scene)).errors.empty());
    const std::filesystem::path place = scene / "out" / "sky.ktx2";
    std::filesystem::rename(scene / "sky.exr", place);
    replaceInScene(scene, "\"sky.exr\"", "\"out/sky.ktx2\"");
    replaceInScene(scene, "\"sky\"", "\"dusk\"");
    const Outcome outcome = cook(gradientAlone(scene));
    for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
    EXPECT_TRUE(std::filesystem::exists(place));
    EXPECT_TRUE(std::filesystem::exists(scene / "out" / "dusk.ktx2"));
}

TEST(KeepGoing, AMeshThatCannotBeReadDoesNotStopTheLightMap) {
    const SmallScene scene(Parts::LightMap);
    replaceInScene(scene, "file = \"map.exr\"", "file = \"map.exr\"\nmesh = \"broken.glb\"");
    formats::writeContent(scene / "broken.glb", "glTF");
    CookOptions options = scene.options();
    EXPECT_EQ(cook(options).errors.size(), 1u);
    EXPECT_FALSE(std::filesystem::exists(scene / "out"));
    options.keepGoing = true;
    const Outcome outcome = cook(options);
    ASSERT_EQ(outcome.errors.size(), 1u);
    EXPECT_THAT(outcome.errors[0].line(), HasSubstr("broken.glb"));
    EXPECT_THAT(assetNames(scene), testing::Contains("map"));
}

TEST(Errors, ABadInputIsReportedOnceForAllActionsThatReadIt) {
    const SmallScene scene(Parts::LightMap);
    formats::Image<lighting::ShRgb> rows(8, 8, lighting::ShRgb{glm::vec3(1)});
    rows.at(5, 3)[0].y = -1;
    auto writer = formats::LightMapWriter::create(scene / "map.exr", 8, 8);
    ASSERT_TRUE(writer && writer->append(rows.view()) && writer->commit());
    for (const bool keepGoing : {false, true}) {
        CookOptions options = scene.options();
        options.keepGoing = keepGoing;
        const Outcome outcome = cook(options);
        ASSERT_EQ(outcome.errors.size(), 1u);
        EXPECT_THAT(outcome.errors[0].line(), HasSubstr("(5, 3)"));
    }
}

TEST(Errors, AnInterruptIsReportedOnceAndLeavesNoOutput) {
    const SmallScene scene(Parts::LightMap);
    CookOptions options = scene.optionsWithOwnCache();
    options.output = scene / "deep" / "er" / "out";
    RunState state;
    state.progress = [&](const Action&, const std::string&, double) { state.interrupted = true; };
    const Outcome outcome = cookScene(options, state);
    ASSERT_EQ(outcome.errors.size(), 1u);
    EXPECT_EQ(outcome.errors[0].code, ErrorCode::Interrupted);
    EXPECT_FALSE(std::filesystem::exists(scene / "deep"));
}

TEST(Output, AFolderThatExistsIsCookedIntoWithoutTouchingTheOneAround) {
    const SmallScene scene(Parts::LightMap);
    CookOptions options = scene.options();
    options.output = scene / "around" / "out";
    std::filesystem::create_directories(options.output);
    std::filesystem::permissions(scene / "around", std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
    const auto before = std::filesystem::last_write_time(scene / "around");  // tells for root as well, who may write anywhere
    EXPECT_TRUE(cook(options).errors.empty());
    EXPECT_EQ(std::filesystem::last_write_time(scene / "around"), before);
    std::filesystem::permissions(scene / "around", std::filesystem::perms::owner_all);
    for (const auto& entry : std::filesystem::directory_iterator(options.output))
        EXPECT_NE(entry.path().filename().string().front(), '.') << entry.path();
}

TEST(Digest, AFolderAndADeviceAreRefused) {
    const formats::TemporaryFolder folder;
    EXPECT_FALSE(digestOfFile(folder.path()).has_value());
    EXPECT_FALSE(digestOfFile("/dev/zero").has_value());
}

/// Every value below `json`, as pointers.
void collect(const Json& json, const Json::json_pointer& place, std::vector<Json::json_pointer>& places) {
    places.push_back(place);
    if (json.is_object())
        for (const auto& [key, value] : json.items()) collect(value, place / key, places);
    if (json.is_array() && !json.empty()) collect(json[0], place / std::size_t{0}, places);
}

class EditedJson : public testing::Test {
protected:
    EditedJson() {
        // One material keeps what is verified a hundred times small.
        scene_.writeSceneFile("effort = 0\nmax_error = 0.5",
                              "[[material]]\nname = \"*\"\nnormal_map = true\nspecular = true\nm = [0.3, 0.3]\nf0 = [0.04, 0.04]\n");
        EXPECT_TRUE(cook(scene_.options()).errors.empty());
    }
    /// Calls with every value replaced by something else in turn, in the file.
    template <class Visit>
    void forEachEdit(const char* file, Visit visit) {
        const std::filesystem::path path = scene_ / "out" / file;
        const Json whole = parseJson(formats::contentOf(path));
        std::vector<Json::json_pointer> places;
        collect(whole, Json::json_pointer(), places);
        const std::vector<Json> values = {nullptr, -1, 1e308, "../../x", Json::array(), Json::object({{"x", 1}})};
        std::size_t next = 0;
        for (const auto& place : places) {
            Json edited = whole;
            edited[place] = values[next++ % values.size()];
            formats::writeContent(path, edited.dump());
            SCOPED_TRACE(place.to_string() + " = " + edited[place].dump());
            visit();
        }
        formats::writeContent(path, whole.dump());
    }
    SmallScene scene_{Parts::LightMap};
};

TEST_F(EditedJson, AManifestOfAnyShapeIsVerifiedOrRefused) {
    int refused = 0;
    forEachEdit(kManifestName, [&] {
        const auto manifest = loadManifest(scene_ / "out");
        if (!manifest) {
            ++refused;
            EXPECT_THAT(manifest.error().line(), HasSubstr("expected"));
            return;
        }
        for (const FileRecord& file : filesOf(*manifest)) EXPECT_THAT(file.name, testing::Not(HasSubstr("..")));
        writeManifestAndDigests(scene_ / "out", parseJson(formats::contentOf(scene_ / "out" / kManifestName)));
        const RunState state;
        for (const formats::Error& error : verifyCooked({scene_ / "out", {}, 0}, state).errors)
            EXPECT_NE(error.code, ErrorCode::Internal) << error.line();
    });
    EXPECT_GT(refused, 30);
}

TEST_F(EditedJson, AReportOfAnyShapeIsShownOrRefused) {
    int refused = 0;
    forEachEdit(kReportName, [&] {
        const auto report = loadReport(scene_ / "out" / kReportName);
        if (report)
            EXPECT_THAT(renderReportHtml(*report, scene_ / "out"), HasSubstr("</html>"));
        else
            ++refused;
    });
    EXPECT_GT(refused, 25);
    EXPECT_TRUE(cook(scene_.options()).errors.empty());
}

TEST_F(EditedJson, ACookReplacesWhatItCannotRead) {
    for (const char* file : {kManifestName, kReportName}) {
        formats::writeContent(scene_ / "out" / file, R"({"schema":1,"assets":[{"name":7}],"budget":{}})");
        EXPECT_TRUE(cook(scene_.options()).errors.empty()) << file;
    }
    EXPECT_TRUE(readManifest(scene_ / "out").has_value());
    EXPECT_TRUE(readReport(scene_ / "out" / kReportName).has_value());
}

TEST(CheckDigests, AReportThatCannotBeReadHidesNoChangedTexture) {
    const SmallScene scene(Parts::LightMap);
    ASSERT_TRUE(cook(scene.optionsWithOwnCache()).errors.empty());
    const auto manifest = loadManifest(scene / "out");
    ASSERT_TRUE(manifest.has_value());
    const std::filesystem::path texture = scene / "out" / manifest->assets.front().textures.front().file;
    formats::writeContent(texture, formats::contentOf(texture) + "more");
    std::filesystem::remove(scene / "out" / kReportName);
    std::filesystem::create_directory(scene / "out" / kReportName);
    std::vector<std::string> subjects;
    for (const formats::Error& error : checkDigests(scene / "out", *manifest)) subjects.push_back(error.subject);
    EXPECT_THAT(subjects, testing::ElementsAre(texture.string(), (scene / "out" / kReportName).string()));
}

TEST(ParseJson, DeepNestingIsNoFileOfOurs) {
    EXPECT_TRUE(parseJson(std::string(100000, '[') + std::string(100000, ']')).is_discarded());
    EXPECT_EQ(parseJson(R"({"a":[1,{"b":2}]})").dump(), R"({"a":[1,{"b":2}]})");
}

}  // namespace
}  // namespace lightcook::pipeline

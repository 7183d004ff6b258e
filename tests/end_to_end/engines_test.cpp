// These tests check what an engine reads: manifest and report keep their JSON schemas after every kind of cook; the glTF passes Khronos'
// validator and agrees with the source mesh and the bake.
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>
#include <vector>

#include "formats/gltf_light_map.h"
#include "formats/gltf_scene.h"
#include "formats/gpu_texture.h"
#include "formats/light_map_layout.h"
#include "formats/plain_image.h"
#include "lighting/radiometry.h"
#include "lighting/sphere.h"
#include "pipeline/assets/gltf/gltf.h"
#include "pipeline/command/reference/schemas.h"
#include "pipeline/manifest/contract.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/report/report.h"
#include "tests/end_to_end/command_fixture.h"
#include "tests/formats/surface_fixture.h"
#include "tests/pipeline/report_parts.h"
#include "tests/pipeline/rewritten_manifest.h"
#include "tests/pipeline/shell.h"
#include "verify/texture_unit.h"

namespace lightcook::pipeline {
namespace {

using testing::HasSubstr;

const std::filesystem::path kSource = LIGHTCOOK_SOURCE_DIR;

bool hasJsonSchema() {
    return runShell("python3 -c 'import jsonschema; jsonschema.Draft202012Validator' >/dev/null 2>&1") == 0;
}

/// Validates a document by a JSON schema and returns the messages, one a line. Empty: the document is valid.
std::string objections(const std::filesystem::path& document, const Json& schema) {
    const formats::TemporaryFolder folder;
    formats::writeContent(folder / "schema.json", schema.dump());
    formats::writeContent(folder / "check.py",
                          "import json, jsonschema, sys\n"
                          "schema, document = (json.load(open(name)) for name in sys.argv[1:])\n"
                          "jsonschema.Draft202012Validator.check_schema(schema)\n"
                          "for error in jsonschema.Draft202012Validator(schema).iter_errors(document):\n"
                          "    print('/'.join(map(str, error.absolute_path)), error.message[:300])\n");
    const std::string messages = (folder / "messages").string();
    const int code = runShell(fmt::format("python3 '{}' '{}' '{}' >'{}' 2>&1", (folder / "check.py").string(),
                                          (folder / "schema.json").string(), document.string(), messages));
    return code == 0 ? formats::contentOf(messages) : fmt::format("code {}: {}", code, formats::contentOf(messages));
}

void expectKeepSchemas(const std::filesystem::path& folder) {
    EXPECT_EQ(objections(folder / kManifestName, manifestSchema()), "");
    EXPECT_EQ(objections(folder / kReportName, reportSchema()), "");
}

/// The scene that ships with the program, cooked.
class ShippedScene : public testing::Test {
protected:
    Outcome cook(const std::string& layout, bool gltf, formats::Target target = formats::Target::Bc) const {
        CookOptions options;
        options.scene = kSource / "examples/cornell/scene.toml";
        options.output = out();
        options.cache = LIGHTCOOK_TEST_CACHE;
        options.given.set("output.light_map_layout", layout);
        options.given.set("output.max_error", 1);
        if (target != formats::Target::Float) options.given.set("output.effort", 0);
        options.samples = 0;
        options.given.set("output.target", std::string(formats::info(target).name));
        options.given.set("output.gltf", gltf);
        const RunState state;
        Outcome outcome = cookScene(options, state);
        for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
        return outcome;
    }
    std::filesystem::path out() const { return folder_ / "out"; }
    /// Returns the JSON of a GLB.
    static Json glbJson(const std::filesystem::path& file) {
        const std::string glb = formats::contentOf(file);
        std::uint32_t length = 0;
        std::memcpy(&length, glb.data() + 12, 4);
        return parseJson(glb.substr(20, length));
    }
    /// Returns the bytes of an image of a GLB.
    static std::string imageOf(const std::filesystem::path& file, const Json& document, std::size_t image) {
        const std::string glb = formats::contentOf(file);
        std::uint32_t length = 0;
        std::memcpy(&length, glb.data() + 12, 4);
        const Json& view = document["bufferViews"][document["images"][image]["bufferView"].get<std::size_t>()];
        return glb.substr(28 + length + view.value("byteOffset", std::size_t{0}), view["byteLength"].get<std::size_t>());
    }

    const formats::TemporaryFolder folder_;
};

using ShippedSceneSoak = ShippedScene;
TEST_F(ShippedSceneSoak, KeepsTheSchemasUnderEveryTarget) {
    if (!hasJsonSchema()) GTEST_SKIP() << "python3-jsonschema is not installed";
    for (const auto& [target, layout] : {std::pair(formats::Target::Bc, "basis-8"), std::pair(formats::Target::Astc, "basis-8"),
                                         std::pair(formats::Target::Float, "halo3")}) {
        SCOPED_TRACE(layout);
        cook(layout, true, target);
        expectKeepSchemas(out());
    }
}

TEST_F(ShippedScene, NamesWhatBelongsTogether) {
    cook("basis-8", false, formats::Target::Astc);
    const auto manifest = readManifest(out());
    ASSERT_TRUE(manifest);
    EXPECT_EQ(manifest->at("up_axis"), "y");
    EXPECT_EQ(manifest->at("lobe"), "beckmann");
    EXPECT_FALSE(manifest->contains("gltf"));
    EXPECT_EQ(assetOf(*manifest, "cornell_mesh").at("light_map"), "lightmap");
    EXPECT_EQ(assetOf(*manifest, "lightmap_dominant").at("light_map"), "lightmap");
    EXPECT_EQ(assetOf(*manifest, "sky").at("axis"), Json({0.0, 1.0, 0.0}));
    const Json place = assetOf(*manifest, "probe0").at("probe");
    EXPECT_NEAR(place.at("position")[2].get<double>(), 4.34567928314209, 1e-12) << "from the file of its SH";
    EXPECT_FALSE(place.contains("radius"));
    for (const Json& texture : assetOf(*manifest, "specular").at("textures")) {
        EXPECT_EQ(texture.at("format"), "rgba16f") << "no 16-bit UNORM where ASTC is";
        EXPECT_EQ(texture.at("api_formats"), Json({{"vulkan", 97}, {"dxgi", 10}, {"gl", 0x881A}, {"metal", 115}}));
        EXPECT_EQ(texture.at("array"), false);
    }
    const RunState state;
    for (const formats::Error& error : verifyCooked({out(), {}, {}}, state).errors) ADD_FAILURE() << error.line();
}

TEST_F(ShippedScene, IsGltfThatTheValidatorAccepts) {
    cook("basis-8", true);
    const std::filesystem::path checker = kSource / "tests/formats/gltf_validator", file = out() / "lightmap_scene.glb";
    ASSERT_TRUE(std::filesystem::exists(file));
    if (!std::filesystem::exists(checker / "node_modules/gltf-validator") || runShell("node --version >/dev/null 2>&1") != 0)
        GTEST_SKIP() << "node or tests/formats/gltf_validator/node_modules is not there: run ./dev setup (npm ci)";
    const std::string answer = (folder_ / "answer").string();
    ASSERT_EQ(runShell(fmt::format("cd '{}' && node check.mjs '{}' >'{}'", checker.string(), file.string(), answer)), 0);
    const Json report = parseJson(formats::contentOf(answer))[0];
    EXPECT_EQ(report.at("errors"), 0) << report.at("messages");
    EXPECT_EQ(report.at("warnings"), 0) << report.at("messages");
    for (const char* extension : {"LIGHTCOOK_light_map", "MOZ_lightmap", "EXT_lights_image_based"})
        EXPECT_THAT(report.at("extensions").get<std::vector<std::string>>(), testing::Contains(extension));
    // A validator that accepts everything says nothing.
    std::string broken = formats::contentOf(file);
    broken.replace(broken.find("\"VEC3\""), 6, "\"VEC2\"");
    formats::writeContent(out() / "broken.glb", broken);
    ASSERT_EQ(runShell(fmt::format("cd '{}' && node check.mjs '{}' >'{}'", checker.string(), (out() / "broken.glb").string(), answer)), 0);
    EXPECT_GT(parseJson(formats::contentOf(answer))[0].at("errors").get<int>(), 0);
}

TEST_F(ShippedScene, AsGltfIsHeldAgainstTheManifest) {
    cook("basis-8", true);
    const auto manifest = loadManifest(out());
    ASSERT_TRUE(manifest);
    for (const formats::Error& error : checkContract(out(), *manifest)) ADD_FAILURE() << error.line();
    const std::filesystem::path file = out() / "lightmap_scene.glb";
    const std::string whole = formats::contentOf(file);
    struct Change {
        std::string from, to, word;  ///< of one length, so that the chunks of the file stay in place
    };
    for (const Change& change : {Change{"\"layout\":\"basis-8\"", "\"layout\":\"basis-4\"", "layout"},
                                 Change{"\"range\"", "\"rangf\"", "constants"}, Change{"lightmap_l0.ktx2", "lightmap_l1.ktx2", "textures"},
                                 Change{"\"coordinateScaleBias\":[1,1,0,0]", "\"coordinateScaleBias\":[1,1,0,1]", "node"},
                                 Change{"\"frame\"", "\"frane\"", "frame"}}) {
        std::string changed = whole;
        const std::size_t at = changed.find(change.from);
        ASSERT_NE(at, std::string::npos) << change.from;
        formats::writeContent(file, changed.replace(at, change.from.size(), change.to));
        const std::vector<formats::Error> errors = checkContract(out(), *manifest);
        ASSERT_FALSE(errors.empty()) << change.to;
        std::string lines;
        for (const formats::Error& error : errors) lines += error.line() + "\n";
        EXPECT_THAT(lines, HasSubstr("lightmap_scene.glb"));
        EXPECT_THAT(lines, HasSubstr(change.word));
    }
}

TEST_F(ShippedScene, StatesErrorsAndLimitsThatTheVerificationKnows) {
    cook("basis-8", true);
    const std::filesystem::path file = out() / "lightmap_scene.glb";
    const auto linesOf = [&] {
        const RunState state;
        std::string lines;
        for (const formats::Error& error : verifyCooked({out(), {}, {}}, state).errors) lines += error.line() + "\n";
        return lines;
    };
    EXPECT_EQ(linesOf(), "");
    std::string gltf = formats::contentOf(file);
    const std::string key = "\"rel_rms\":0.";
    const std::size_t at = gltf.find(key, gltf.find("\"bound\":{")) + key.size();
    gltf[at] = gltf[at] == '0' ? '5' : '0';
    formats::writeContent(file, gltf);
    Json manifest = parseJson(formats::contentOf(out() / kManifestName));
    manifest["gltf"][0]["digest"] = digestOfFile(file).value();
    for (Json& asset : manifest["assets"])
        if (asset.at("name") == "lightmap") asset["verify"]["max_error"] = 0.9;
    std::erase_if(manifest["assets"].get_ref<Json::array_t&>(), [](const Json& asset) { return asset.at("name") == "sky"; });
    manifest["target"] = "astc";
    writeManifestAndDigests(out(), manifest);
    Json report = parseJson(formats::contentOf(out() / kReportName));
    for (Json& each : report["files"])
        if (each.at("file") == "lightmap_scene.glb") each["digest"] = manifest["gltf"][0]["digest"];
    formats::writeContent(out() / kReportName, withSelfDigest(report));
    const std::string lines = linesOf();
    EXPECT_THAT(lines, HasSubstr("lightmap_scene.glb, bound/diffuse/rel_rms: found 0."));
    EXPECT_THAT(lines, HasSubstr("lightmap, verify/max_error: found 0.9, expected 1.0 of its scene: cook the scene again"));
    EXPECT_THAT(lines, HasSubstr("cooked.json, target: found \"astc\", expected \"bc\" of its scene"));
    EXPECT_THAT(lines, HasSubstr("cooked.json: found no asset 'sky', expected that of its scene"));
}

TEST_F(ShippedScene, AsGltfKeepsTheMeshAndBindsTheLightMap) {
    cook("basis-8", true);
    const std::filesystem::path file = out() / "lightmap_scene.glb", source = kSource / "examples/cornell/cornell.glb";
    const auto bound = formats::GltfScene::load(file), original = formats::GltfScene::load(source);
    ASSERT_TRUE(bound && original);
    EXPECT_EQ(bound->vertexCount(), original->vertexCount());
    const auto before = original->triangleMeshes(), after = bound->triangleMeshes();
    ASSERT_EQ(before.size(), after.size());
    for (std::size_t i = 0; i < before.size(); ++i)
        for (const char* semantic : {"POSITION", "NORMAL", "TEXCOORD_0", "TEXCOORD_1"}) {
            const auto *expected = before[i]->find(semantic), *found = after[i]->find(semantic);
            ASSERT_EQ(expected == nullptr, found == nullptr) << semantic;
            for (std::size_t vertex = 0; expected != nullptr && vertex < expected->vertexCount(); ++vertex)
                ASSERT_EQ(expected->at(vertex), found->at(vertex)) << semantic;
        }
    const Json json = glbJson(file), sourceJson = glbJson(source), manifest = readManifest(out()).value();
    ASSERT_EQ(json.at("materials").size(), sourceJson.at("materials").size());
    for (std::size_t i = 0; i < json.at("materials").size(); ++i) {
        Json material = json["materials"][i];
        const Json fallback = material.at("extensions").at("MOZ_lightmap");
        EXPECT_EQ(fallback.at("texCoord"), 1);
        material["extensions"].erase("MOZ_lightmap");
        if (material["extensions"].empty()) material.erase("extensions");
        EXPECT_EQ(material, sourceJson["materials"][i]);
    }
    for (const Json& node : json.at("nodes"))
        EXPECT_EQ(node.contains("mesh"), node.contains("extensions") && node["extensions"].contains(formats::kLightMapExtension));
    const Json map = parseJson(formats::boundLightMaps(file).value()).at(0), entry = assetOf(manifest, "lightmap");
    EXPECT_EQ(map.at("layout"), "basis-8");
    EXPECT_EQ(map.at("basis").at("attribute"), formats::kBasisAttribute);
    EXPECT_EQ(map.at("constants").at("range"), entry.at("constants").at("range"));
    ASSERT_EQ(map.at("textures").size(), entry.at("textures").size());
    for (const Json& texture : map.at("textures")) EXPECT_TRUE(formats::TextureReader::open(out() / texture.at("uri").get<std::string>()));
    const std::string shader = formats::contentOf(out() / map.at("shader").at("uri").get<std::string>());
    for (const Json& function : map.at("shader").at("functions")) EXPECT_THAT(shader, HasSubstr(" " + function.get<std::string>() + "("));
    const auto report = loadReport(out() / kReportName);
    ASSERT_TRUE(report);
    const auto row = std::ranges::find(report->assets, "lightmap", &ReportRow::name);
    ASSERT_NE(row, report->assets.end());
    EXPECT_EQ(map.at("bound").at("diffuse").at("rel_rms"), row->verdict.stages.back().diffuse.relRms);
    EXPECT_EQ(manifest.at("gltf").at(0).at("file"), "lightmap_scene.glb");

    // Again: nothing to do. Without --gltf the file goes.
    EXPECT_EQ(cook("basis-8", true).actionsRun, 0);
    cook("basis-8", false);
    EXPECT_FALSE(std::filesystem::exists(file));
}

/// The flat picture times its intensity is the irradiance of the bake at the texels' own normals.
TEST_F(ShippedScene, AsGltfShowsTheIrradianceToOtherViewers) {
    cook("ratio", true);
    const std::filesystem::path file = out() / "lightmap_scene.glb";
    const Json json = glbJson(file);
    const Json fallback = json["materials"][0]["extensions"]["MOZ_lightmap"];
    const std::size_t image = json["textures"][fallback.at("index").get<std::size_t>()]["source"].get<std::size_t>();
    formats::writeContent(folder_ / "flat.png", imageOf(file, json, image));
    const auto flat = formats::readImage(folder_ / "flat.png");
    ASSERT_TRUE(flat) << flat.error().line();
    const auto bake = formats::LightMapReader::open(kSource / "examples/cornell/cornell_lightmap.exr", {});
    ASSERT_TRUE(bake);
    const auto strip = bake->read(0, bake->height());
    ASSERT_TRUE(strip);
    ASSERT_EQ(flat->texels.width(), bake->width());
    const double intensity = fallback.at("intensity").get<double>();
    std::int64_t covered = 0, beyond = 0;
    for (int y = 0; y < bake->height(); ++y)
        for (int x = 0; x < bake->width(); ++x) {
            if (strip->covered.at(x, y) == 0) continue;
            ++covered;
            const glm::vec3 exit = lighting::lambertExitRadiance(strip->sh.at(x, y), strip->normal.at(x, y), glm::vec3(1)).value;
            for (int c = 0; c < 3; ++c) {
                const double expected = std::max(0.0, std::numbers::pi * static_cast<double>(exit[c])),
                             found = intensity * static_cast<double>(flat->texels.at(x, y)[c]);
                if (!(std::abs(found - expected) <= 0.5001 / 255 * intensity)) ++beyond;
            }
        }
    EXPECT_GT(covered, 1000);
    EXPECT_LE(static_cast<double>(beyond), 0.002 * 3 * static_cast<double>(covered)) << "all but the brightest are half a step off";
    // The irradiance of the probe: coefficient 0 of its SH times pi, from the file.
    const Json light = json.at("extensions").at("EXT_lights_image_based").at("lights").at(0);
    EXPECT_NEAR(light.at("irradianceCoefficients")[0][0].get<double>(), std::numbers::pi * 1.1859477766584803, 1e-5);
    EXPECT_EQ(light.at("irradianceCoefficients").size(), 9u);
    ASSERT_EQ(light.at("specularImages").size(), 3u);
    formats::writeContent(folder_ / "face.png", imageOf(file, json, light.at("specularImages")[0][3].get<std::size_t>()));
    const auto face = formats::readImage(folder_ / "face.png");
    ASSERT_TRUE(face);
    EXPECT_EQ(face->texels.width(), 64);
    EXPECT_EQ(face->channelCount, 4) << "RGBD";
    EXPECT_EQ(json.at("scenes")[0].at("extensions").at("EXT_lights_image_based").at("light"), 0);
}

/// Both containers, a scene without a mesh, and each converter alone.
class Engines : public Command {
protected:
    /// command  that cooks the light map, alone or with the rest of the scene
    void expectLayoutKeepsSchemas(const std::string& command, const formats::LightMapLayoutInfo& layout) const {
        SCOPED_TRACE(layout.name);
        const std::string container = layout.isForEngine ? " --container dds" : "";
        std::filesystem::remove_all(scene_ / "out");
        ASSERT_EQ(run(fmt::format("{} --effort 0 --max-error 9 --layout {}{}", command, layout.name, container)).code, 0);
        expectKeepSchemas(scene_ / "out");
    }
};
using EnginesSoak = Engines;

TEST_F(EnginesSoak, ManifestAndReportKeepTheirSchemasForEveryLayout) {
    if (!hasJsonSchema()) GTEST_SKIP() << "python3-jsonschema is not installed";
    for (const formats::LightMapLayoutInfo& layout : formats::allLightMapLayouts())
        if (!layout.isInTangentSpace) expectLayoutKeepsSchemas("cook scene.toml -o out", layout);
    formats::writeSquare(scene_ / "square.glb", {});
    expectLayoutKeepsSchemas("lightmap map.exr out --mesh square.glb", formats::info(formats::LightMapLayout::Rnm));
}

/// The light of a texel by the formula of Unreal's shader, in its own words: Lightmap0 and Lightmap1 are filtered before.
glm::dvec3 shownByUnreal(const glm::dvec4& lightmap0, const glm::dvec4& lightmap1, const Json& constants, const glm::dvec3& normal) {
    const auto four = [&](const char* name) {
        const Json& v = constants.at(name);
        return glm::dvec4(v.at(0).get<double>(), v.at(1).get<double>(), v.at(2).get<double>(), v.at(3).get<double>());
    };
    double logL = lightmap0.w;
    logL += lightmap1.w * (1.0 / 255) - 0.5 / 255;
    logL = logL * four("scale0").w + four("add0").w;
    const glm::dvec3 uvw = glm::dvec3(lightmap0) * glm::dvec3(lightmap0) * glm::dvec3(four("scale0")) + glm::dvec3(four("add0"));
    const glm::dvec4 sh = lightmap1 * four("scale1") + four("add1");
    const double directionality = std::max(0.0, glm::dot(sh, glm::dvec4(normal.y, normal.z, normal.x, 1)));
    return (std::exp2(logL) - 0.01858136) * directionality * uvw;
}

/// An engine that knows nothing of lightcook reads two DDS textures and four constants. It shows what `reconstruct` decodes between texels
/// and, at texels, the bake with the error that the report states.
TEST_F(Engines, UnrealShowsTheLightMapByItsOwnFormula) {
    ASSERT_EQ(run("lightmap map.exr room --layout unreal-hq --container dds --max-error 1").code, 0);
    ASSERT_EQ(run("reconstruct room map fine.exr --supersample 2").code, 0);
    const Json map = readManifest(scene_ / "room").value().at("assets").at(0);
    EXPECT_EQ(map.at("decode_degree"), 0);
    std::vector<formats::Image<glm::vec4>> images;
    for (const Json& texture : map.at("textures")) {
        EXPECT_EQ(texture.at("format"), "bc3");
        const auto opened = formats::TextureReader::open(scene_ / "room" / texture.at("file").get<std::string>());
        ASSERT_TRUE(opened) << opened.error().line();
        auto decoded = verify::decodeImage(*opened, {});
        ASSERT_TRUE(decoded) << decoded.error().line();
        images.push_back(std::move(*decoded));
    }
    ASSERT_EQ(images.size(), 2u);
    const int width = images[0].width(), height = images[0].height();
    const auto bake = formats::LightMapReader::open(scene_ / "map.exr", {}), fine = formats::LightMapReader::open(scene_ / "fine.exr", {});
    ASSERT_TRUE(bake && fine);
    const auto reference = bake->read(0, height), seen = fine->read(0, 2 * height);
    ASSERT_TRUE(reference && seen);
    ASSERT_EQ(seen->sh.width(), 2 * width);
    const auto shown = [](const lighting::ShRgb& sh, const glm::dvec3& n) {
        return glm::dvec3(lighting::lambertExitRadiance(sh, glm::vec3(n), glm::vec3(1)).value);
    };
    // Between texels: place (x + 1/2) / 2 - 1/2 of a texture, filtered here.
    for (int y = 1; y + 1 < 2 * height; ++y)
        for (int x = 1; x + 1 < 2 * width; ++x) {
            const int left = (x - 1) / 2, top = (y - 1) / 2;
            const double u = x % 2 == 1 ? 0.25 : 0.75, v = y % 2 == 1 ? 0.25 : 0.75;
            std::array<glm::dvec4, 2> filtered;
            for (std::size_t i = 0; i < 2; ++i) {
                const auto at = [&](int dx, int dy) { return glm::dvec4(images[i].at(left + dx, top + dy)); };
                filtered[i] = glm::mix(glm::mix(at(0, 0), at(1, 0), u), glm::mix(at(0, 1), at(1, 1), u), v);
            }
            for (int k = 0; k < 5; ++k) {
                const glm::dvec3 n = lighting::fibonacciSphere(k, 5);
                const glm::dvec3 engine = shownByUnreal(filtered[0], filtered[1], map.at("constants"), n),
                                 ours = glm::max(shown(seen->sh.at(x, y), n), 0.0);
                for (int c = 0; c < 3; ++c) ASSERT_NEAR(engine[c], ours[c], 2e-3 * glm::length(ours) + 1e-4) << x << ' ' << y << ' ' << k;
            }
        }
    double errors = 0, squares = 0;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            if (reference->covered.at(x, y) == 0) continue;
            const glm::dmat3 world = lighting::worldFromTangentFrame(glm::dvec3(reference->normal.at(x, y)));
            for (int k = 0; k < 32; ++k) {
                const glm::dvec3 n = world * lighting::fibonacciHemisphere(k, 32), exact = shown(reference->sh.at(x, y), n),
                                 error = shownByUnreal(images[0].at(x, y), images[1].at(x, y), map.at("constants"), n) - exact;
                errors += glm::dot(error, error);
                squares += glm::dot(exact, exact);
            }
        }
    const auto report = loadReport(scene_ / "room" / kReportName);
    ASSERT_TRUE(report);
    const auto& stages = report->assets.front().verdict.stages;
    const double relRms = std::sqrt(errors / squares), stated = stages.at(stages.size() - 2).diffuse.relRms;
    // The engine clamps the directionality at 0, which is nearer to the bake, if anything.
    EXPECT_LE(relRms, stated * 1.01);
    EXPECT_GE(relRms, stated * 0.8);
}

/// The light of a texel by the formula of Bakery's shader, in its own words. y of the basis points down the picture, as greens of its
/// normal maps do after it has negated them.
glm::dvec3 shownByBakery(const std::array<glm::dvec3, 3>& rnm, glm::dvec3 normalTangentSpace) {
    const std::array<glm::dvec3, 3> basis = {glm::dvec3(std::sqrt(2.0 / 3), 0, 1 / std::sqrt(3.0)),
                                             glm::dvec3(-1 / std::sqrt(6.0), 1 / std::sqrt(2.0), 1 / std::sqrt(3.0)),
                                             glm::dvec3(-1 / std::sqrt(6.0), -1 / std::sqrt(2.0), 1 / std::sqrt(3.0))};
    normalTangentSpace.y = -normalTangentSpace.y;
    glm::dvec3 light(0);
    for (std::size_t i = 0; i < 3; ++i) light += std::clamp(glm::dot(basis[i], normalTangentSpace), 0.0, 1.0) * rnm[i];
    return light;
}

/// An engine that knows nothing of lightcook reads three DDS textures and has the tangents of the mesh: it shows the bake with the error
/// that the report states.
TEST_F(Engines, BakeryShowsTheLightMapInTangentSpace) {
    formats::writeSquare(scene_ / "square.glb", {.texture = glm::mat2(0, 1, 1, 0)});
    const std::string command = "lightmap map.exr room --layout rnm --container dds --max-error 1 --no-specular";
    ASSERT_EQ(run(command + " --mesh square.glb").code, 0);
    EXPECT_EQ(run("verify room").code, 0);
    const Json map = readManifest(scene_ / "room").value().at("assets").at(0);
    std::vector<formats::Image<glm::vec4>> images;
    for (const Json& texture : map.at("textures")) {
        EXPECT_EQ(texture.at("format"), "bc6h-uf16");
        const auto opened = formats::TextureReader::open(scene_ / "room" / texture.at("file").get<std::string>());
        ASSERT_TRUE(opened) << opened.error().line();
        images.push_back(verify::decodeImage(*opened, {}).value());
    }
    ASSERT_EQ(images.size(), 3u);
    const auto bake = formats::LightMapReader::open(scene_ / "map.exr", {});
    ASSERT_TRUE(bake);
    const auto reference = bake->read(0, bake->height());
    ASSERT_TRUE(reference);
    // The square faces +y, u grows with z, and v with x, which is down the picture.
    const glm::dmat3 tangents(glm::dvec3(0, 0, 1), glm::dvec3(-1, 0, 0), glm::dvec3(0, 1, 0));
    const glm::dmat3 world = lighting::worldFromTangentFrame(glm::dvec3(0, 1, 0));
    double errors = 0, squares = 0;
    for (int y = 0; y < images[0].height(); ++y)
        for (int x = 0; x < images[0].width(); ++x)
            for (int k = 0; k < 32; ++k) {
                const glm::dvec3 n = world * lighting::fibonacciHemisphere(k, 32),
                                 exact(lighting::lambertExitRadiance(reference->sh.at(x, y), glm::vec3(n), glm::vec3(1)).value);
                std::array<glm::dvec3, 3> rnm;
                for (std::size_t i = 0; i < 3; ++i) rnm[i] = glm::dvec3(glm::vec3(images[i].at(x, y)));
                const glm::dvec3 error = shownByBakery(rnm, glm::transpose(tangents) * n) - exact;
                errors += glm::dot(error, error);
                squares += glm::dot(exact, exact);
            }
    const auto report = loadReport(scene_ / "room" / kReportName);
    ASSERT_TRUE(report);
    const auto& stage = report->assets.front().verdict.stages.front();
    EXPECT_EQ(stage.name, "rnm");
    EXPECT_NEAR(std::sqrt(errors / squares), stage.diffuse.relRms, 1e-3 * stage.diffuse.relRms);

    const Ended without = run("lightmap map.exr other --layout rnm --max-error 1");
    EXPECT_EQ(without.code, 2);
    EXPECT_THAT(without.err, HasSubstr("map.exr: found no mesh, expected mesh = \"FILE\" (--mesh) with light-map UVs"));
    EXPECT_FALSE(std::filesystem::exists(scene_ / "other"));
    const Ended reconstructed = run("reconstruct room map back.exr");
    EXPECT_EQ(reconstructed.code, 2);
    EXPECT_THAT(reconstructed.err, HasSubstr("found layout rnm, expected one that stores SH coefficients"));
}

TEST_F(Engines, TangentsOfAMeshWithoutAnyAreRefused) {
    formats::writeSquare(scene_ / "flat.glb", {.texture = glm::mat2(0)});
    const Ended ended = run("lightmap map.exr other --layout rnm --max-error 1 --mesh flat.glb");
    EXPECT_EQ(ended.code, 3) << ended.err;
    EXPECT_THAT(ended.err, HasSubstr("flat.glb: found no tangents, expected an attribute TANGENT"));
}

TEST_F(EnginesSoak, ManifestAndReportKeepTheirSchemasForEveryConverter) {
    if (!hasJsonSchema()) GTEST_SKIP() << "python3-jsonschema is not installed";
    for (const char* arguments : {"lightmap map.exr out --max-error 1", "dominant map.exr out --max-error 9", "cubemap probe.exr out",
                                  "cubemap probe.exr out --layout prefiltered --max-error 1", "lut out",
                                  "lut out --lobe phong --max-error 1", "rsrm sky.exr out --max-error 1"}) {
        SCOPED_TRACE(arguments);
        std::filesystem::remove_all(scene_ / "out");
        const Ended ended = run(arguments);
        ASSERT_EQ(ended.code, 0) << ended.err;
        expectKeepSchemas(scene_ / "out");
    }
}

TEST_F(Engines, SchemasRefuseWhatTheProgramDoesNotWrite) {
    if (!hasJsonSchema()) GTEST_SKIP() << "python3-jsonschema is not installed";
    ASSERT_EQ(run("cook scene.toml -o out --effort 0").code, 0);
    expectKeepSchemas(scene_ / "out");
    const Json manifest = parseJson(formats::contentOf(scene_ / "out" / kManifestName));
    const auto refuses = [&](const std::function<void(Json&)>& change) {
        Json changed = manifest;
        change(changed);
        formats::writeContent(scene_ / "changed.json", changed.dump());
        return !objections(scene_ / "changed.json", manifestSchema()).empty();
    };
    EXPECT_FALSE(refuses([](Json&) {}));
    EXPECT_TRUE(refuses([](Json& json) { json["up_axis"] = "w"; }));
    EXPECT_TRUE(refuses([](Json& json) { json.erase("shader"); }));
    EXPECT_TRUE(refuses([](Json& json) { json.erase("digest"); }));
    EXPECT_TRUE(refuses([](Json& json) { json["assets"][0]["unknown"] = 1; }));
    EXPECT_TRUE(refuses([](Json& json) { json["assets"][0]["layout"] = "basis-5"; }));
    EXPECT_TRUE(refuses([](Json& json) { json["assets"][0]["constants"]["range"] = "8"; }));
    EXPECT_TRUE(refuses([](Json& json) { json["assets"][0]["textures"][0]["format"] = "bc9"; }));
    EXPECT_TRUE(refuses([](Json& json) { json["assets"][0]["textures"][0]["width"] = 0; }));
}

TEST_F(Engines, JsonOfAFailedCookKeepsTheReportSchema) {
    if (!hasJsonSchema()) GTEST_SKIP() << "python3-jsonschema is not installed";
    ASSERT_EQ(run("cook scene.toml -o out --effort 0 --max-error 1e-7 --json cook.json").code, 4);
    EXPECT_EQ(objections(scene_ / "cook.json", reportSchema()), "");
    Json json = parseJson(formats::contentOf(scene_ / "cook.json"));
    ASSERT_FALSE(json.at("errors").empty());
    json["errors"][0].erase("subject");
    formats::writeContent(scene_ / "changed.json", json.dump());
    EXPECT_NE(objections(scene_ / "changed.json", reportSchema()), "");
}

TEST_F(Engines, GltfNeedsAMeshAndKtx2) {
    expectRefused("cook scene.toml -o out --gltf", 2, {"--gltf", "where no light map has a mesh", "expected mesh = "});
    expectRefused("cook scene.toml -o out --gltf --container dds", 2, {"--gltf", "expected container ktx2"});
    scene_.writeSceneFile("gltf = true\ncontainer = \"dds\"");
    expectRefused("cook scene.toml -o out", 2, {"scene.toml:5", "expected container ktx2"});
}

TEST_F(Engines, AProbeMayStateItsPlaceInTheSceneFile) {
    std::string scene = formats::contentOf(scene_.sceneFile());
    const std::string before = "[[probe]]\n";
    scene.replace(scene.find(before), before.size(), before + "position = [1, 2.5, -3]\nbox = [0, 0, -4, 2, 3, 4]\nradius = 5\n");
    scene.insert(scene.find("[output]"), "up_axis = \"z\"\n");
    formats::writeContent(scene_.sceneFile(), scene);
    const Ended ended = run("cook scene.toml -o out --effort 0");
    ASSERT_EQ(ended.code, 0) << ended.err;
    const Json manifest = readManifest(scene_ / "out").value();
    EXPECT_EQ(manifest.at("up_axis"), "z");
    EXPECT_EQ(assetOf(manifest, "probe").at("probe"),
              Json({{"position", {1.0, 2.5, -3.0}}, {"box", {{0.0, 0.0, -4.0}, {2.0, 3.0, 4.0}}}, {"radius", 5.0}}));
    EXPECT_EQ(assetOf(manifest, "sky").at("axis"), Json({0.0, 0.0, 1.0}));
    for (const auto& [line, expected] :
         {std::pair("radius = 0", "positive radius"), std::pair("box = [0, 0, 0, 1, 1, 0]", "the lowest first"),
          std::pair("box = [0, 0, 0]", "corners"), std::pair("position = [1, 2]", "a place")}) {
        std::string bad = scene;
        bad.replace(bad.find("position = [1, 2.5, -3]\nbox = [0, 0, -4, 2, 3, 4]\nradius = 5\n"),
                    std::string("position = [1, 2.5, -3]\nbox = [0, 0, -4, 2, 3, 4]\nradius = 5\n").size(), std::string(line) + "\n");
        formats::writeContent(scene_.sceneFile(), bad);
        const Ended refused = run("cook scene.toml -o other");
        EXPECT_EQ(refused.code, 2) << line;
        EXPECT_THAT(refused.err, HasSubstr(expected)) << line;
    }
}

}  // namespace
}  // namespace lightcook::pipeline

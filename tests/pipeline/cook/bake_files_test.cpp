// Bakes of other bakers, cooked as a whole: recognised without a key, and cooked again when any of their files changes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <numbers>

#include "formats/plain_image.h"
#include "pipeline/command/info.h"
#include "pipeline/cook/cook.h"
#include "pipeline/manifest/manifest.h"
#include "tests/formats/surface_fixture.h"
#include "tests/formats/temporary_folder.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr int kSide = 16;

/// A folder with a scene of one light map.
class BakeScene {
public:
    std::filesystem::path operator/(const std::string& name) const { return folder_ / name; }

    void writeScene(const std::string& file, const std::string& keys = "", const std::string& output = "") const {
        writeMapKeys(fmt::format("file = \"{}\"\n{}", file, keys), output);
    }
    void writeMapKeys(const std::string& keys, const std::string& output = "") const {
        formats::writeContent(
            folder_ / "scene.toml",
            fmt::format("schema = 1\nname = \"bake\"\n\n[output]\n{}\n\n[[light_map]]\nname = \"map\"\n{}\n", output, keys));
    }

    /// Writes a picture; texel  value of a texel (x, y)
    template <class Texel>
    void writePicture(const std::string& name, int width, int height, int channelCount, Texel&& texel) const {
        formats::Image<glm::vec4> image(width, height);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) image.at(x, y) = texel(x, y);
        const auto written = formats::writeExr(folder_ / name, image.view(), channelCount);
        if (!written) throw std::runtime_error(written.error().line());
    }

    Outcome cook() const {
        CookOptions options;
        options.scene = folder_ / "scene.toml";
        options.output = folder_ / "out";
        options.cache = folder_ / "cache";
        options.depfile = folder_ / "out.d";
        return cookScene(options, state_);
    }

private:
    formats::TemporaryFolder folder_;
    RunState state_;
};

lighting::ShRgb texelOf(int x, int y) {
    return shOf(sunAndSky, {(x + 0.5) / kSide, (y + 0.5) / kSide});
}

/// Layouts that add directions alone would have the bytes of flat and more.
TEST(BakeFiles, AMapWithoutDirectionsIsTriedAsFlatAndInLayoutsThatRefineIt) {
    const BakeScene scene;
    scene.writePicture("hall.exr", kSide, kSide, 3, [](int x, int y) { return glm::vec4(0.1 + 0.02 * x, 0.5, 0.2 + 0.04 * y, 1); });
    const auto triedUnder = [&](const std::string& limit, const std::string& expected) {
        scene.writeScene("hall.exr", "", limit);
        const Outcome outcome = scene.cook();
        for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
        const Json& map = outcome.report.at("assets").at(0);
        if (!expected.empty()) {
            EXPECT_EQ(map.at("layout"), expected);
        }
        std::vector<std::string> layouts;
        for (const Json& candidate : map.at("trial_candidates")) layouts.push_back(candidate.at("layout"));
        return layouts;
    };
    EXPECT_THAT(triedUnder("max_visible = 5", "flat"), testing::ElementsAre("flat", "flat-2")) << "the others cost more than flat";
    EXPECT_THAT(triedUnder("budget = \"1 MiB\"", ""), testing::UnorderedElementsAre("flat", "flat-2", "basis-8", "basis-12", "basis-16",
                                                                                    "basis-20", "basis-24", "hdr-2", "hdr-rgb9e5", "raw"));
}

TEST(BakeFiles, AllFilesOfASplitBakeAreInputs) {
    const BakeScene scene;
    constexpr std::array kNames = {"L0", "L1m1", "L10", "L11", "L2m2", "L2m1", "L20", "L21", "L22"};
    const auto writeCoefficient = [&](std::size_t i, float scale) {
        scene.writePicture(fmt::format("room_{}.exr", kNames.at(i)), kSide, kSide, 3,
                           [&](int x, int y) { return glm::vec4(scale * texelOf(x, y)[i], 1); });
    };
    for (std::size_t i = 0; i < kNames.size(); ++i) writeCoefficient(i, 1);
    scene.writeScene("room_L0.exr");
    const Outcome first = scene.cook();
    ASSERT_TRUE(first.errors.empty()) << first.errors.front().line();
    EXPECT_GT(first.actionsRun, 0);
    const std::string depfile = formats::contentOf(scene / "out.d");
    const std::string manifest = formats::contentOf(scene / "out" / kManifestName);
    for (const char* name : kNames) {
        EXPECT_THAT(depfile, HasSubstr((scene / fmt::format("room_{}.exr", name)).string()));
        EXPECT_THAT(manifest, HasSubstr(fmt::format("room_{}.exr", name)));
    }
    EXPECT_EQ(scene.cook().actionsRun, 0);
    writeCoefficient(8, 0.5f);
    EXPECT_GT(scene.cook().actionsRun, 0) << "the ninth file changed";
    std::filesystem::remove(scene / "room_L21.exr");
    const Outcome missing = scene.cook();
    ASSERT_EQ(missing.errors.size(), 1u);
    EXPECT_EQ(missing.errors.front().code, formats::ErrorCode::WrongShape);
    EXPECT_THAT(missing.errors.front().line(), AllOf(HasSubstr("room_L0.exr"), HasSubstr("room_L21.exr is missing")));
}

TEST(BakeFiles, ListedImagesAreInputsAndAreReadAgainForVerification) {
    const BakeScene scene;
    const auto writeCoefficient = [&](std::size_t i, float scale) {
        scene.writePicture(fmt::format("c{}.exr", i), kSide, kSide, 3,
                           [&](int x, int y) { return glm::vec4(scale * texelOf(x, y)[i], 1); });
    };
    for (std::size_t i = 0; i < 4; ++i) writeCoefficient(i, 1);
    scene.writeMapKeys("files = { sh00 = \"c0.exr\", sh01 = \"c1.exr\", sh02 = \"c2.exr\", sh03 = \"c3.exr\" }");
    const Outcome first = scene.cook();
    ASSERT_TRUE(first.errors.empty()) << first.errors.front().line();
    const Json& row = first.report.at("assets").at(0);
    EXPECT_LT(row.at("bits_per_texel"), 34) << "nothing has band 2: sh4 and its coverage";
    std::uintmax_t bytes = 0;
    for (std::size_t i = 0; i < 4; ++i) bytes += std::filesystem::file_size(scene / fmt::format("c{}.exr", i));
    EXPECT_EQ(row.at("bytes_in").get<std::uintmax_t>(), bytes);
    EXPECT_THAT(formats::contentOf(scene / "out.d"), HasSubstr((scene / "c3.exr").string()));
    VerifyOptions verify;
    verify.folder = scene / "out";
    const Outcome verified = verifyCooked(verify, {});
    EXPECT_TRUE(verified.errors.empty()) << verified.errors.front().line();
    const auto errorsOf = [](const Json& stages) {
        Json errors = Json::array();
        for (const Json& stage : stages) errors.push_back(stage.at("error"));
        return errors;
    };
    EXPECT_EQ(errorsOf(verified.report.at("assets").at(0).at("stages")), errorsOf(row.at("stages")));
    EXPECT_EQ(scene.cook().actionsRun, 0);
    writeCoefficient(3, 0.5f);
    EXPECT_GT(scene.cook().actionsRun, 0);
    LintOptions lint;
    lint.scene = scene / "scene.toml";
    lint.cache = scene / "cache";
    EXPECT_EQ(lintScene(lint, {}).report.at("light_maps")[0].at("evidence"), "the 4 images that the scene lists for sh00.R .. sh03.B");
    std::filesystem::remove(scene / "c2.exr");
    const Outcome missing = scene.cook();
    ASSERT_FALSE(missing.errors.empty());
    EXPECT_EQ(missing.errors.front().code, formats::ErrorCode::FileUnreadable);
    EXPECT_THAT(missing.errors.front().line(), HasSubstr("c2.exr"));
}

TEST(BakeFiles, AFlatMapIsCookedAsOneTextureOfExitRadiance) {
    const BakeScene scene;
    scene.writePicture("room.exr", kSide, kSide, 4, [](int x, int y) {
        return glm::vec4(0.1f + 0.01f * static_cast<float>(x), 0.2f, 0.3f + 0.02f * static_cast<float>(y), x > 0 ? 1.0f : 0.0f);
    });
    scene.writeScene("room.exr");
    const Outcome outcome = scene.cook();
    ASSERT_TRUE(outcome.errors.empty()) << outcome.errors.front().line();
    const auto manifest = readManifest(scene / "out");
    ASSERT_TRUE(manifest) << manifest.error().line();
    const Json& map = manifest->at("assets")[0];
    for (const Json& asset : manifest->at("assets")) EXPECT_NE(asset.at("kind"), "dominant") << "no light has a direction";
    EXPECT_EQ(map.at("layout"), "flat");
    ASSERT_EQ(map.at("textures").size(), 1u);
    EXPECT_EQ(map.at("textures")[0].at("format"), "bc6h-uf16");
}

TEST(BakeFiles, AMapOfGodotIsCookedAndItsImportSettingsAreAnInput) {
    const BakeScene scene;
    // Slices L0, y, z, x; L1 has three quarters of the length of L0.
    scene.writePicture("room.exr", kSide, 4 * kSide, 4, [](int x, int y) {
        const int slice = y / kSide;
        const float light = 0.2f + 0.02f * static_cast<float>(x + y % kSide);
        return slice == 0 ? glm::vec4(light, 0.8f * light, 0.6f * light, 1) : glm::vec4(glm::vec3(slice == 1 ? 0.575f : 0.53f), 1);
    });
    scene.writeScene("room.exr");
    const Outcome ambiguous = scene.cook();
    ASSERT_EQ(ambiguous.errors.size(), 1u);
    EXPECT_THAT(ambiguous.errors.front().line(), HasSubstr("bake = \"godot\""));
    formats::writeContent(scene / "room.exr.import", "importer=\"2d_array_texture\"\nslices/vertical=4\n");
    const Outcome outcome = scene.cook();
    ASSERT_TRUE(outcome.errors.empty()) << outcome.errors.front().line();
    const auto manifest = readManifest(scene / "out");
    ASSERT_TRUE(manifest) << manifest.error().line();
    EXPECT_EQ(manifest->at("assets")[0].at("height"), kSide);
    EXPECT_THAT(formats::contentOf(scene / "out.d"), HasSubstr((scene / "room.exr.import").string()));
    EXPECT_EQ(scene.cook().actionsRun, 0);
    formats::writeContent(scene / "room.exr.import", "importer=\"2d_array_texture\"\nslices/vertical=4\n\n");
    EXPECT_GT(scene.cook().actionsRun, 0);
}

TEST(BakeFiles, TheMeshOfABakeInTangentSpaceIsAnInput) {
    const BakeScene scene;
    for (int map = 0; map < 3; ++map)
        scene.writePicture(fmt::format("room_RNM{}.exr", map), kSide, kSide, 3, [&](int x, int y) {
            return glm::vec4(glm::vec3(0.3f + 0.01f * static_cast<float>(map == 0 ? x : y), 0.3f, 0.2f), 1);
        });
    formats::writeSquare(scene / "square.glb", {});
    scene.writeScene("room_RNM0.exr", "mesh = \"square.glb\"");
    const Outcome first = scene.cook();
    ASSERT_TRUE(first.errors.empty()) << first.errors.front().line();
    EXPECT_THAT(formats::contentOf(scene / "out.d"),
                AllOf(HasSubstr((scene / "room_RNM2.exr").string()), HasSubstr((scene / "square.glb").string())));
    VerifyOptions verify;
    verify.folder = scene / "out";
    const Outcome verified = verifyCooked(verify, {});
    EXPECT_TRUE(verified.errors.empty()) << verified.errors.front().line();
    EXPECT_EQ(scene.cook().actionsRun, 0);
    formats::writeSquare(scene / "square.glb", {.texture = glm::mat2(0, 1, 1, 0)});
    EXPECT_GT(scene.cook().actionsRun, 0) << "the tangents changed";

    LintOptions lint;
    lint.scene = scene / "scene.toml";
    lint.cache = scene / "cache";
    const Outcome linted = lintScene(lint, {});
    EXPECT_TRUE(linted.findings.empty()) << "bands of a fit to the three lobes are not judged: " << linted.findings.front().found;
    const Json reading = linted.report.at("light_maps").at(0);
    EXPECT_EQ(reading.at("bake"), "bakery-rnm");
    EXPECT_EQ(reading.at("evidence"), "the 3 files room_RNM0.exr to room_RNM2.exr");
    EXPECT_THAT(reading.at("assumed")[0].get<std::string>(), HasSubstr("TEXCOORD_0"));
    const auto facts = describeFile(scene / "room_RNM0.exr");
    ASSERT_TRUE(facts) << facts.error().line();
    EXPECT_EQ(facts->at("light_map"), "bakery-rnm");
    EXPECT_THAT(facts->at("needs").get<std::string>(), HasSubstr("without a mesh"));
}

TEST(BakeFiles, OneFileOfASetIsNamed) {
    const BakeScene scene;
    scene.writePicture("room_L1x.exr", kSide, kSide, 3, [](int, int) { return glm::vec4(0.5f); });
    LintOptions lint;
    lint.scene = scene / "scene.toml";
    lint.cache = scene / "cache";
    scene.writeScene("room_L1x.exr");
    const Outcome alone = lintScene(lint, {});
    ASSERT_EQ(alone.findings.size(), 1u);
    EXPECT_EQ(alone.findings[0].check, LintCheck::IncompleteSet);
    EXPECT_THAT(alone.findings[0].found,
                HasSubstr("found 1 of the 4 files of bake format bakery-sh, room_L0 (.exr, .hdr, .tga or .png) and 2 more are missing"));
    scene.writeScene("room_L1x.exr", "bake = \"flat\"");
    EXPECT_TRUE(lintScene(lint, {}).findings.empty());
}

TEST(BakeFiles, AWhiteMapOfDirectionsIsNamed) {
    const BakeScene scene;
    float direction = 1;
    const auto lint = [&] {
        scene.writePicture("room_L0.exr", kSide, kSide, 3, [](int, int) { return glm::vec4(0.5f); });
        scene.writePicture("room_L1.exr", kSide, kSide, 3, [&](int, int) { return glm::vec4(direction); });
        scene.writeScene("room_L0.exr");
        LintOptions options;
        options.scene = scene / "scene.toml";
        options.cache = scene / "cache";
        std::vector<LintCheck> checks;
        for (const Finding& finding : lintScene(options, {}).findings) checks.push_back(finding.check);
        return checks;
    };
    EXPECT_THAT(lint(), testing::Contains(LintCheck::ImpossibleDirections));
    direction = 0.6f;
    EXPECT_THAT(lint(), testing::Not(testing::Contains(LintCheck::ImpossibleDirections)));
}

/// The same bytes under a name that belongs to no set: the facts of the first lint are not those of the second.
TEST(BakeFiles, ARenamedFileIsLookedAtAnew) {
    const BakeScene scene;
    LintOptions lint;
    lint.scene = scene / "scene.toml";
    lint.cache = scene / "cache";
    for (const char* name : {"room_L1x.exr", "hall.exr"}) {
        scene.writePicture(name, kSide, kSide, 3, [](int, int) { return glm::vec4(0.5f); });
        scene.writeScene(name);
        EXPECT_EQ(lintScene(lint, {}).findings.size(), std::string(name) == "hall.exr" ? 0u : 1u) << name;
    }
}

TEST(BakeFiles, CoverageOfAMeshIsForListedImagesToo) {
    const BakeScene scene;
    for (const char* name : {"c0.exr", "c1.exr", "c2.exr", "c3.exr"})
        scene.writePicture(name, kSide, kSide, 3, [&](int, int) { return glm::vec4(name[1] == '0' ? 0.5f : 0.0f); });
    formats::writeSquare(scene / "square.glb", {.lightMap = {0.5f, 1}});
    formats::writeContent(scene / "scene.toml",
                          "schema = 1\nname = \"x\"\n[[light_map]]\nname = \"map\"\nmesh = \"square.glb\"\ncoverage = \"mesh\"\n"
                          "files = { sh00 = \"c0.exr\", sh01 = \"c1.exr\", sh02 = \"c2.exr\", sh03 = \"c3.exr\" }\n");
    const Outcome outcome = scene.cook();
    EXPECT_TRUE(outcome.errors.empty()) << outcome.errors.front().line();
}

TEST(BakeFiles, LintAndInfoSayHowAFileWasRecognised) {
    const BakeScene scene;
    scene.writePicture("room.exr", kSide, kSide, 3, [](int, int) { return glm::vec4(0.5f); });
    scene.writeScene("room.exr");
    LintOptions options;
    options.scene = scene / "scene.toml";
    options.cache = scene / "cache";
    const Outcome outcome = lintScene(options, {});
    ASSERT_TRUE(outcome.errors.empty()) << outcome.errors.front().line();
    ASSERT_EQ(outcome.report.at("light_maps").size(), 1u);
    const Json& reading = outcome.report.at("light_maps")[0];
    EXPECT_EQ(reading.at("light_map"), "map");
    EXPECT_EQ(reading.at("bake"), "flat");
    EXPECT_EQ(reading.at("evidence"), "a picture of 16 x 16 texels");
    EXPECT_EQ(reading.at("assumed")[1], "every texel is covered");
    const auto facts = describeFile(scene / "room.exr");
    ASSERT_TRUE(facts) << facts.error().line();
    EXPECT_EQ(facts->at("maximum"), 0.5) << "as every picture";
    EXPECT_EQ(facts->at("as_light_map").at("light_map"), "flat");
    EXPECT_EQ(facts->at("as_light_map").at("evidence"), reading.at("evidence"));
}

/// A map of 2048 x 2048 texels as Godot baked it. Its certificate once was not done after 2.5 minutes: layouts of a low
/// degree need many cells.
TEST(BakeFilesSoak, AMapOfGodotIsCookedWithNoKeyButItsFile) {
    const std::filesystem::path file =
        std::filesystem::path(LIGHTCOOK_SHARED_DATA) / "engine_lightmaps" / "godot_ragdoll_physics_lightmap.exr";
    if (!std::filesystem::exists(file)) GTEST_SKIP() << "needs the shared test data at " << LIGHTCOOK_SHARED_DATA;
    const BakeScene scene;
    scene.writeScene(std::filesystem::canonical(file).string());
    const Outcome outcome = scene.cook();
    ASSERT_TRUE(outcome.errors.empty()) << outcome.errors.front().line();
    const Json& map = outcome.report.at("assets").at(0);
    EXPECT_EQ(map.at("layout"), "flat");
    EXPECT_EQ(map.at("textures").at(0).at("format"), "bc6h-uf16");
    EXPECT_TRUE(map.at("passed").get<bool>());
    EXPECT_TRUE(std::ranges::any_of(outcome.findings, [](const Finding& finding) { return finding.check == LintCheck::MissingCoverage; }));
}

}  // namespace
}  // namespace lightcook::pipeline

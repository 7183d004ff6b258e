// Probes of every size, pre-divided and plain, with both lobes of a scene: cooked and verified from their files, or refused by name.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <map>
#include <string>

#include "formats/environment.h"
#include "formats/gpu_texture.h"
#include "formats/plain_image.h"
#include "lighting/cube.h"
#include "lighting/sphere.h"
#include "pipeline/assets/cubemap/cubemap.h"
#include "pipeline/command/converter.h"
#include "pipeline/report/exit_codes.h"
#include "shaders/lightcook_cpp.h"
#include "tests/pipeline/rewritten_manifest.h"
#include "tests/pipeline/small_scene.h"
#include "verify/cubemap.h"
#include "verify/texture_unit.h"

namespace lightcook::pipeline {
namespace {

using formats::Image;
using testing::HasSubstr;

class CookCubemap : public testing::Test {
protected:
    void SetUp() override {
        Image<glm::vec4> sky(64, 32);
        for (int y = 0; y < 32; ++y)
            for (int x = 0; x < 64; ++x) {
                const glm::dvec3 d = lighting::directionFromEquirectangular({(x + 0.5) / 64, (y + 0.5) / 32});
                const float sun = d.y > 0.97 ? 40 : 0;
                sky.at(x, y) = glm::vec4(glm::dvec3(1 + 0.5 * d.x, 1.2 + d.y, 1 + 0.9 * d.z * d.z), 1) + glm::vec4(sun, 0.8f * sun, 0, 0);
            }
        ASSERT_TRUE(formats::writeExr(folder_ / "sky.exr", sky.view(), 3));
    }
    Conversion options(int size, const std::string& layout = "pre-divided") {
        Conversion options{"cubemap", folder_ / "sky.exr", folder_ / ("out" + std::to_string(++count_))};
        options.cook.cache = folder_ / "cache";
        options.cook.given.set("probe.size", size);
        options.cook.given.set("probe.layout", layout);
        return options;
    }
    Json asset(const Conversion& options) {
        const Outcome outcome = convert(options, state_);
        for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
        return outcome.report.is_object() ? outcome.report.at("assets").at(0) : Json();
    }
    std::string refusal(const Conversion& options) {
        const Outcome outcome = convert(options, state_);
        EXPECT_FALSE(outcome.errors.empty()) << "expected a refusal";
        EXPECT_FALSE(std::filesystem::exists(options.output / "cooked.json"));
        return outcome.errors.empty() ? "" : outcome.errors[0].line();
    }
    static Json entryOf(const std::filesystem::path& folder) {
        return parseJson(formats::contentOf(folder / kManifestName)).at("assets").at(0);
    }
    /// The figure is that of the worst level, all texels of it. Of float texels it is the filter's own error. Blocks beside the sun have
    /// most of the rest: at size 32, where they are largest, 0.056 (0.048 at effort 9).
    void expectCooked(int size, const std::string& layout, const std::string& target) {
        Conversion wanted = options(size, layout);
        wanted.cook.given.set("output.target", target);
        const Json found = asset(wanted);
        ASSERT_TRUE(found.is_object());
        EXPECT_TRUE(found.at("passed"));
        EXPECT_EQ(found.at("width"), size);
        EXPECT_TRUE(found.contains("preview"));
        const Json& error = found.at("stages").back().at("error").at("specular");
        EXPECT_LT(error.at("rel_rms"), target == "float" ? 0.002 : 0.06) << size << ' ' << target;
        EXPECT_GE(error.at("max_bound"), error.at("max_sampled"));
        const Json entry = entryOf(wanted.output);
        EXPECT_EQ(entry.at("layout"), layout);
        EXPECT_EQ(entry.at("constants").at("mips").size(), static_cast<std::size_t>(std::bit_width(static_cast<unsigned>(size))));
        EXPECT_EQ(entry.at("textures")[0].at("mips"), entry.at("constants").at("mips").size());
    }

    formats::TemporaryFolder folder_;
    RunState state_;
    int count_ = 0;
};

/// A block that the fastest encoders miss is a large part of the light of a level of few texels.
TEST_F(CookCubemap, LevelsOfFewTexelsAreEncodedWithCareAtAnyEffort) {
    std::map<int, std::string> contents;
    for (const int effort : {0, 5, 9}) {
        Conversion wanted = options(32);
        wanted.cook.given.set("output.target", "astc");
        wanted.cook.given.set("output.effort", effort);
        (void)asset(wanted);
        contents[effort] = formats::contentOf(wanted.output / "sky.ktx2");
    }
    EXPECT_EQ(contents[0], contents[5]);
    EXPECT_NE(contents[9], contents[5]) << "a higher effort is as it was";
}

class CookCubemapSoak : public CookCubemap, public testing::WithParamInterface<std::pair<int, const char*>> {};
TEST_P(CookCubemapSoak, HasItsLevelsAndIsVerified) {
    const auto [size, target] = GetParam();
    expectCooked(size, size == 32 || size == 2048 ? "prefiltered" : "pre-divided", target);
}
INSTANTIATE_TEST_SUITE_P(Sizes, CookCubemapSoak,
                         testing::Values(std::pair(16, "bc"), std::pair(16, "float"), std::pair(32, "bc"), std::pair(32, "float"),
                                         std::pair(128, "bc"), std::pair(128, "float"), std::pair(512, "bc"), std::pair(2048, "bc")),
                         [](const auto& instance) { return instance.param.second + std::to_string(instance.param.first); });

TEST_F(CookCubemap, OtherSizesAreRefused) {
    for (const int size : {-16, 0, 1, 8, 48, 100, 4096})
        EXPECT_THAT(refusal(options(size)), HasSubstr(fmt::format("--size: found '{}', expected a power of two from 16 to 2048", size)));
}

TEST_F(CookCubemap, APlainMapIsTheRadianceThroughTheLobe) {
    const auto environment = formats::loadEnvironment(folder_ / "sky.exr", {});
    ASSERT_TRUE(environment);
    for (const auto& [lobe, distribution] : {std::pair(lighting::SpecularLobe::Beckmann, lighting::NormalDistribution::Beckmann),
                                             std::pair(lighting::SpecularLobe::Ggx, lighting::NormalDistribution::Ggx)}) {
        Conversion wanted = options(32, "prefiltered");
        wanted.cook.given.set("lobe", std::string(formats::info(lobe).name));
        wanted.cook.given.set("output.target", "float");
        const Json found = asset(wanted);
        ASSERT_TRUE(found.is_object());
        EXPECT_TRUE(found.at("passed"));
        EXPECT_LT(found.at("stages").back().at("error").at("specular").at("rel_rms"), 0.03);
        EXPECT_FALSE(found.at("notes").contains("window_lambda"));
        const Json entry = entryOf(wanted.output);
        EXPECT_EQ(entry.at("quantity"), "prefiltered radiance");
        for (const char* absent : {"windowed_sh", "window", "window_lambda", "epsilon"})
            EXPECT_FALSE(entry.at("constants").contains(absent)) << absent;
        const auto texture = formats::TextureReader::open(wanted.output / "sky.ktx2");
        ASSERT_TRUE(texture);
        for (int mip = 1; mip < 6; ++mip) {
            const double m = entry.at("constants").at("mips").at(static_cast<std::size_t>(mip)).at("m");
            if (!(m > 0)) continue;
            const verify::PrefilteredLight light(environment->environment, m, distribution);
            for (int face = 0; face < 6; ++face) {
                const auto image = verify::decodeImage(*texture, {mip, 0, face});
                ASSERT_TRUE(image);
                const int middle = image->width() / 2;
                const glm::dvec3 expected = light.towards(lighting::cubeTexelDirection(face, middle, middle, image->width()));
                const glm::vec3 shown =
                    shaders::lcPrefiltered(glm::vec3(image->at(middle, middle)), entry.at("constants").at("range").get<float>());
                for (int channel = 0; channel < 3; ++channel)
                    EXPECT_NEAR(static_cast<double>(shown[channel]) / expected[channel], 1, 0.01) << mip << " " << face;
            }
        }
    }
}

TEST_F(CookCubemap, ThePlainMapIsThePreDividedOneTimesItsS) {
    // Both are cooked from one source and show the same light at the environment's own place.
    Conversion plain = options(16, "prefiltered"), divided = options(16);
    for (Conversion* each : {&plain, &divided}) each->cook.given.set("output.target", "float");
    ASSERT_TRUE(asset(plain).is_object() && asset(divided).is_object());
    const auto a = formats::TextureReader::open(plain.output / "sky.ktx2"), b = formats::TextureReader::open(divided.output / "sky.ktx2");
    ASSERT_TRUE(a && b);
    const Json constants = entryOf(divided.output).at("constants");
    const auto parsed = fromJson<CubemapConstants>(constants, "constants");
    ASSERT_TRUE(parsed);
    EXPECT_TRUE(parsed->isDivided());
    const float range = entryOf(plain.output).at("constants").at("range");
    shaders::LcSh sh;
    for (std::size_t i = 0; i < 9; ++i) sh.c[i] = parsed->windowedSh[i];
    for (int mip = 0; mip < 4; ++mip) {
        const auto first = verify::decodeImage(*a, {mip, 0, 2}), second = verify::decodeImage(*b, {mip, 0, 2});
        ASSERT_TRUE(first && second);
        const lighting::ShBands& bands = parsed->mips[static_cast<std::size_t>(mip)].bands;
        for (int x = 0; x < first->width(); ++x) {
            const glm::vec3 direction(lighting::cubeTexelDirection(2, x, 0, first->width()));
            const glm::vec3 s = shaders::lcZonalSpecular(sh, direction, glm::vec3(glm::dvec3(bands[0], bands[1], bands[2])));
            const glm::vec3 whole = shaders::lcPrefiltered(glm::vec3(first->at(x, 0)), range),
                            product = shaders::lcEnvironment(parsed->range * glm::vec3(second->at(x, 0)), s);
            for (int channel = 0; channel < 3; ++channel) EXPECT_NEAR(product[channel] / whole[channel], 1, 0.003) << mip << " " << x;
        }
    }
}

/// The small scene with materials of m from 0.1, whose probe is not divided and has the size "auto".
class ReadLevels : public testing::Test {
protected:
    void SetUp() override {
        scene_.writeSceneFile("target = \"float\"", "[[material]]\nname = \"*\"\nspecular = true\nm = [0.1, 0.5]\n");
        setSize("\"auto\"\nlayout = \"prefiltered\"");
    }
    void setSize(const std::string& size) const {
        std::string text = formats::contentOf(scene_.sceneFile());
        const std::string file = "file = \"probe.exr\"\n", key = "size = ";
        std::size_t at = text.find(file) + file.size();
        if (text.compare(at, key.size(), key) == 0) text.erase(at, text.find('\n', at) + 1 - at);
        formats::writeContent(scene_.sceneFile(), text.insert(at, fmt::format("{}{}\n", key, size)));
    }
    /// Cooks the probe, and returns its entry of the manifest.
    Json entry(const std::filesystem::path& folder) const {
        CookOptions options = scene_.options();
        options.only = "probe";
        options.output = folder;
        const Outcome outcome = cook(options);
        for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
        return parseJson(formats::contentOf(folder / kManifestName)).at("assets").at(0);
    }

    SmallScene scene_{SmallScene::Parts::All};
};

TEST_F(ReadLevels, AreThoseOfTheWholeChain) {
    const Json read = entry(scene_ / "read");
    setSize("128");
    const Json whole = entry(scene_ / "whole");
    EXPECT_EQ(read.at("width"), 32);
    EXPECT_EQ(read.at("constants").at("first_level"), 2);
    EXPECT_FALSE(whole.at("constants").contains("first_level"));
    const auto a = formats::TextureReader::open(scene_ / "read/probe.ktx2"), b = formats::TextureReader::open(scene_ / "whole/probe.ktx2");
    ASSERT_TRUE(a && b);
    ASSERT_EQ(a->shape().mipCount, 6);
    const double rangeA = read.at("constants").at("range"), rangeB = whole.at("constants").at("range");
    for (int mip = 0; mip < 6; ++mip) {
        const Json& kernel = read.at("constants").at("mips").at(static_cast<std::size_t>(mip));
        EXPECT_NEAR(kernel.at("perceptual_roughness").get<double>() * 7, mip + 2, 1e-9);
        for (int face = 0; face < 6; ++face) {
            const auto found = verify::decodeImage(*a, {mip, 0, face}), expected = verify::decodeImage(*b, {mip + 2, 0, face});
            ASSERT_TRUE(found && expected);
            for (int x = 0; x < found->width(); ++x)
                for (int channel = 0; channel < 3; ++channel)
                    EXPECT_NEAR(rangeA * static_cast<double>(found->at(x, x)[channel]) /
                                    (rangeB * static_cast<double>(expected->at(x, x)[channel])),
                                1, 2e-3)
                        << mip << " " << face << " " << x;
        }
    }
}

/// Leaving the others out is no larger error of the whole shading.
TEST_F(ReadLevels, AloneAreTheLightThatAPixelShows) {
    const auto lightIn = [&](const char* folder) {
        (void)entry(scene_ / folder);
        const Json row = parseJson(formats::contentOf(scene_ / folder / kReportName)).at("assets").at(0);
        return row.at("light").at("specular_rms").get<double>();
    };
    const double read = lightIn("read");
    setSize("128");
    EXPECT_NEAR(lightIn("whole") / read, 1, 1e-3);
}

TEST_F(ReadLevels, AManifestThatNamesOtherLevelsFails) {
    const auto errorOf = [&](const std::function<void(Json&)>& change) {
        (void)entry(scene_ / "out");
        Json manifest = parseJson(formats::contentOf(scene_ / "out" / kManifestName));
        change(manifest["assets"][0]);
        writeManifestAndDigests(scene_ / "out", manifest);
        const RunState state;
        const Outcome outcome = verifyCooked({scene_ / "out", {}, {}}, state);
        std::string lines;
        for (const formats::Error& error : outcome.errors) lines += error.line() + "\n";
        return lines;
    };
    EXPECT_THAT(errorOf([](Json& asset) { asset["constants"]["first_level"] = 1; }), HasSubstr("expected 0.16666"));
    EXPECT_THAT(errorOf([](Json& asset) { asset["constants"].erase("first_level"); }), HasSubstr("perceptual_roughness"));
    EXPECT_THAT(errorOf([](Json& asset) { asset["verify"]["smoothest"] = 0.05; }), HasSubstr("verify/smoothest: found 0.05, expected "));
}

TEST_F(ReadLevels, AnotherWordForTheSizeIsRefused) {
    setSize("\"least\"");
    const auto scene = readScene(scene_.sceneFile());
    ASSERT_FALSE(scene);
    EXPECT_THAT(scene.error().line(), HasSubstr("found 'least' for probe.size, expected a power of two from 16 to 2048, or \"auto\""));
}

TEST(ProbePlace, OfTheManifestIsThatOfTheSceneFileOrOfTheList) {
    const SmallScene scene(SmallScene::Parts::All);
    std::vector<std::vector<double>> sh(9, {0, 0, 0});
    sh[0] = {3, 3, 3};
    formats::writeContent(scene / "probes.json",
                          Json{{"probes", {{{"file", "probe.exr"}, {"sh", sh}, {"position", {1, 2, 3}}, {"radius", 7.5}}}}}.dump());
    std::string text = formats::contentOf(scene.sceneFile());
    const std::string before = "[[probe]]\n";
    text.replace(text.find(before), before.size(), before + "sh = \"probes.json\"\nposition = [4, 5, 6.5]\nbox = [0, 0, 0, 9, 9, 9]\n");
    formats::writeContent(scene.sceneFile(), text);
    CookOptions options = scene.options();
    options.only = "probe";
    for (const formats::Error& error : cook(options).errors) FAIL() << error.line();
    const Json manifest = parseJson(formats::contentOf(scene / "out" / kManifestName));
    const Json expected = {{"position", {4, 5, 6.5}}, {"box", {{0, 0, 0}, {9, 9, 9}}}, {"radius", 7.5}};
    EXPECT_EQ(manifest.at("assets")[0].at("probe"), expected);
    const RunState state;
    EXPECT_THAT(verifyCooked({scene / "out", {}, {}}, state).errors, testing::IsEmpty());
}

TEST_F(CookCubemap, LayoutsThatDoNotFitAreRefused) {
    Conversion wanted = options(16, "prefiltered");
    wanted.cook.given.set("probe.sh", (folder_ / "sky.json").string());
    EXPECT_THAT(refusal(wanted), HasSubstr("--sh: found it with --layout prefiltered, expected --layout pre-divided"));
}

TEST_F(CookCubemap, AManifestWithTheOtherLayoutFails) {
    for (const auto& [layout, other] : {std::pair("pre-divided", "prefiltered"), std::pair("prefiltered", "pre-divided")}) {
        const Conversion wanted = options(16, layout);
        ASSERT_TRUE(asset(wanted).is_object());
        Json manifest = parseJson(formats::contentOf(wanted.output / kManifestName));
        manifest["assets"][0]["layout"] = other;
        writeManifestAndDigests(wanted.output, manifest);
        const Outcome outcome = verifyCooked({wanted.output, {}, {}}, state_);
        ASSERT_FALSE(outcome.errors.empty());
        EXPECT_EQ(exitCode(outcome.errors[0].code), 4);
    }
}

}  // namespace
}  // namespace lightcook::pipeline

// Gradients from every kind of source, in every format, and at the edges: cooked and verified, or refused by name.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <random>

#include "formats/environment.h"
#include "formats/gpu_texture.h"
#include "formats/plain_image.h"
#include "formats/png.h"
#include "formats/read_file.h"
#include "lighting/sphere.h"
#include "pipeline/command/converter.h"
#include "pipeline/graph/files.h"
#include "tests/formats/temporary_folder.h"
#include "tests/pipeline/rewritten_manifest.h"
#include "verify/rsrm.h"
#include "verify/texture_unit.h"

namespace lightcook::pipeline {
namespace {

using testing::HasSubstr;

class Rsrm : public testing::Test {
protected:
    void write(const std::string& name, int width, int height, const std::function<glm::vec3(int x, int y)>& texel) {
        formats::Image<glm::vec4> image(width, height);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) image.at(x, y) = glm::vec4(texel(x, y), 1.0f);
        ASSERT_TRUE(formats::writeExr(folder_ / name, image.view(), 3));
    }
    Conversion options(const std::string& input) {
        Conversion options{"rsrm", folder_ / input, folder_ / ("out" + std::to_string(++count_))};
        options.cook.cache = folder_ / "cache";
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
        return outcome.errors.empty() ? "" : outcome.errors[0].line();
    }

    formats::TemporaryFolder folder_;
    RunState state_;
    int count_ = 0;
};

glm::vec3 warm(int x, int) {
    return (0.2f + 0.01f * static_cast<float>(x)) * glm::vec3(3, 2, 1);
}

TEST_F(Rsrm, EachOfSixFilesAroundAnAxisIsAnInput) {
    for (const char* face : {"px", "nx", "py", "ny", "pz", "nz"}) write(std::string("cube_") + face + ".exr", 8, 8, warm);
    Conversion wanted = options("cube_px.exr");
    wanted.cook.given.set("gradient.axis", "0,1,0");
    asset(wanted);
    EXPECT_EQ(convert(wanted, state_).actionsRun, 0);
    write("cube_ny.exr", 8, 8, [](int x, int y) { return 2.0f * warm(x, y); });
    EXPECT_GT(convert(wanted, state_).actionsRun, 0) << "a file beside the named one changed";
}

TEST_F(Rsrm, EveryFormatAndTheDitherAreVerified) {
    write("warm.exr", 64, 1, warm);
    std::map<std::string, std::uint64_t> bytes;
    for (const char* format : {"rgba8", "bc7", "bc4"}) {
        Conversion wanted = options("warm.exr");
        wanted.cook.given.set("gradient.format", format);
        const Json found = asset(wanted);
        bytes[format] = found.at("bytes_gpu");
        EXPECT_LT(found.at("measures").at("code_error"), std::string(format) == "rgba8" ? 0.56 : 8) << format;
        EXPECT_TRUE(found.contains("preview"));
    }
    EXPECT_EQ(bytes["rgba8"], 8192u);
    EXPECT_EQ(bytes["bc7"], 2048u);
    EXPECT_EQ(bytes["bc4"], 1024u);
    Conversion dithered = options("warm.exr");
    dithered.cook.given.set("gradient.dither", true);
    const Json found = asset(dithered).at("measures");
    EXPECT_LT(found.at("code_error"), 1.06);
    EXPECT_LT(found.at("band_codes"), 0.18);  // an eighth of a code, and what the reference is off
}

TEST_F(Rsrm, AManifestThatCallsRoundedCodesDitheredFails) {
    write("warm.exr", 64, 1, warm);
    for (const char* format : {"rgba8", "bc7"}) {
        Conversion wanted = options("warm.exr");
        wanted.cook.given.set("gradient.format", format);
        asset(wanted);
        const auto verified = [&] { return verifyCooked({wanted.output, folder_.path(), {}}, state_).errors; };
        EXPECT_THAT(verified(), testing::IsEmpty()) << format;
        Json manifest = parseJson(formats::contentOf(wanted.output / kManifestName));
        manifest["assets"][0]["dither"] = true;
        writeManifestAndDigests(wanted.output, manifest);
        const auto errors = verified();
        ASSERT_FALSE(errors.empty()) << format;
        EXPECT_THAT(errors[0].line(), HasSubstr("dither"));
    }
}

TEST_F(Rsrm, FormatsThatDoNotFitAreRefused) {
    write("warm.exr", 64, 1, warm);
    write("many.exr", 64, 1, [](int x, int) { return glm::vec3(1, 0.01f * static_cast<float>(x), 1); });
    Conversion wanted = options("warm.exr");
    wanted.cook.given.set("gradient.format", "bc7");
    wanted.cook.given.set("output.target", "astc");
    EXPECT_THAT(refusal(wanted),
                HasSubstr("found format \"bc7\" with target \"astc\", expected target \"bc\" or a format of \"rgba8\", \"rgb9e5\", "
                          "\"rgba16f\""));
    wanted.cook.given.set("gradient.format", "bc6h");
    EXPECT_THAT(refusal(wanted), HasSubstr("found format \"bc6h\" with target \"astc\""));
    wanted.cook.given.set("output.target", "bc");
    wanted.cook.given.set("gradient.dither", true);
    for (const char* format : {"bc7", "rgb9e5", "auto"}) {
        wanted.cook.given.set("gradient.format", format);
        EXPECT_THAT(refusal(wanted), HasSubstr(fmt::format("found dither with format \"{}\", expected format \"rgba8\"", format)));
    }
    Conversion effort = options("warm.exr");
    effort.cook.given.set("gradient.format", "rgb9e5");
    effort.cook.given.set("output.effort", 3);
    EXPECT_THAT(refusal(effort), HasSubstr("--effort: found it with --format rgb9e5, whose texels are rounded, expected --format bc7, bc4, "
                                           "bc6h, or auto"));
    Conversion grey = options("many.exr");
    grey.cook.given.set("gradient.format", "bc4");
    EXPECT_THAT(refusal(grey), HasSubstr("zone 0: found a colour of its own, expected one colour"));
}

constexpr float kSunRadiance = 60000;

/// A sun of 60000 in the first of 256 zones, above a blue sky of 1.
glm::vec3 sunnySky(int x, int) {
    return x == 0 ? kSunRadiance * glm::vec3(1, 0.9f, 0.7f) : glm::vec3(0.3f, 0.5f, 1);
}

TEST_F(Rsrm, ASunAndItsSkyKeepTheirColours) {
    write("sunny.exr", 256, 1, sunnySky);
    std::vector<glm::vec3> gradient;
    for (int x = 0; x < 256; ++x) gradient.push_back(sunnySky(x, 0));
    // Relative: half a step of halves and the reference's error; a step of 2^-8 of the largest channel, of which red is 0.3 in the sky; a
    // block that the sun shares with its sky.
    const std::map<std::string, double> kSteps = {{"rgba16f", 0x1p-11 + 2e-4}, {"rgb9e5", 0x1p-8 / 0.3}, {"bc6h", 0.1}};
    for (const auto& [format, step] : kSteps) {
        SCOPED_TRACE(format);
        Conversion wanted = options("sunny.exr");
        wanted.cook.given.set("gradient.format", format);
        const Json found = asset(wanted);
        EXPECT_TRUE(found.at("passed"));
        for (const char* shading : {"diffuse", "specular"}) {
            const Json& error = found.at("stages").back().at("error").at(shading);
            EXPECT_LT(error.at("rel_rms"), 0.1);
            EXPECT_GE(error.at("max_bound"), error.at("max_sampled"));
            EXPECT_LT(found.at("stages")[0].at("error").at(shading).at("p99"), format == "bc6h" ? 0.2 : 0.02);
        }
        const auto texture = formats::TextureReader::open(wanted.output / "sunny.ktx2");
        ASSERT_TRUE(texture);
        EXPECT_EQ(formats::info(texture->shape().format).name, format == "bc6h" ? "bc6h-uf16" : format);
        const auto texels = verify::decodeImage(*texture, {});
        ASSERT_TRUE(texels);
        const Json manifest = Json::parse(*formats::readWholeText(wanted.output / "cooked.json", 1 << 20));
        const Json& color = manifest.at("assets")[0].at("constants").at("color");
        EXPECT_EQ(color[0], color[1]);
        EXPECT_EQ(color[0], color[2]) << "one scale, so that hues stay";
        const int row = 7;  // exponent 16384
        for (const int column : {0, texels->width() / 2, texels->width() - 1}) {
            const glm::dvec3 expected = verify::convolvePhong(gradient, 16384, 1 - (2.0 * column + 1) / texels->width());
            for (int channel = 0; channel < 3; ++channel)
                EXPECT_NEAR(static_cast<double>(texels->at(column, row)[channel]) * color[0].get<double>() / expected[channel], 1, step)
                    << column << " " << channel;
        }
    }
}

TEST_F(Rsrm, TheFormatIsTheSmallestThatKeepsTheLimit) {
    write("sunny.exr", 256, 1, sunnySky);
    write("warm.exr", 64, 1, warm);
    const auto formatOf = [&](const Conversion& wanted) { return asset(wanted).at("textures")[0].at("format").get<std::string>(); };
    const auto bytesOf = [&](const Conversion& wanted) { return *formats::readWholeText(wanted.output / "warm.ktx2", 1 << 20); };
    Conversion usual = options("warm.exr"), named = options("warm.exr"), smallest = options("warm.exr");
    named.cook.given.set("gradient.format", "rgba8");
    smallest.cook.given.set("gradient.format", "auto");
    EXPECT_EQ(formatOf(usual), "rgba8-unorm");
    EXPECT_EQ(formatOf(named), "rgba8-unorm");
    EXPECT_EQ(bytesOf(usual), bytesOf(named));
    EXPECT_EQ(formatOf(smallest), "bc4") << "one colour";

    Conversion sunny = options("sunny.exr");
    const Json found = asset(sunny);
    EXPECT_TRUE(found.at("passed"));
    EXPECT_GT(found.at("notes").at("formats_tried").at("rgba8").at("p99"), 0.1) << "the sky is lost in eight bits";
    const std::string format = found.at("textures")[0].at("format");
    EXPECT_TRUE(format == "bc6h-uf16" || format == "rgb9e5") << format;
    sunny = options("sunny.exr");
    sunny.cook.given.set("output.target", "astc");
    EXPECT_EQ(formatOf(sunny), "rgb9e5") << "no blocks of target bc";
    EXPECT_EQ(found.at("width"), 512) << "256 columns are too few between texels";
}

TEST_F(Rsrm, SunsOfBadNumbersAreRefusedInEveryFormat) {
    for (const char* format : {"bc6h", "rgb9e5", "rgba16f", "auto"})
        for (const float sun : {-1.0f, NAN, INFINITY}) {
            write("bad.exr", 64, 1, [sun](int x, int) { return glm::vec3(x == 0 ? sun : 1.0f); });
            Conversion wanted = options("bad.exr");
            wanted.cook.given.set("gradient.format", format);
            EXPECT_THAT(refusal(wanted), HasSubstr("bad.exr, channel R, texel (0, 0): found "));
            EXPECT_FALSE(std::filesystem::exists(wanted.output / "bad.ktx2"));
        }
    std::filesystem::resize_file(folder_ / "bad.exr", std::filesystem::file_size(folder_ / "bad.exr") - 100);
    EXPECT_THAT(refusal(options("bad.exr")), HasSubstr("bad.exr"));
}

TEST_F(Rsrm, FloatsHoldTheWholeRangeOfFloats) {
    for (const float scale : {1e-30f, 1e-6f, 1.0f, 1e30f}) {
        write("scaled.exr", 64, 1, [scale](int x, int) { return scale * glm::vec3(x == 0 ? 1000.0f : 1.0f, 0, 0.5f); });
        for (const char* format : {"bc6h", "rgb9e5", "rgba16f"}) {
            Conversion wanted = options("scaled.exr");
            wanted.cook.given.set("gradient.format", format);
            const Json found = asset(wanted);
            EXPECT_TRUE(found.at("passed")) << scale << " " << format;
            EXPECT_LT(found.at("stages")[0].at("error").at("specular").at("rel_rms"), 0.1) << scale << " " << format;
        }
    }
}

TEST_F(Rsrm, PicturesAreSrgbUnlessSaidOtherwise) {
    formats::Image<glm::u8vec3> painted(32, 1);
    for (int x = 0; x < 32; ++x) painted.at(x, 0) = glm::u8vec3(188);
    const auto png = formats::encodePng(painted.view());
    ASSERT_TRUE(png);
    ASSERT_TRUE(writeFile(folder_ / "grey.png", *png));
    const auto srgb = formats::loadPaintedGradient(folder_ / "grey.png", {}, formats::GradientEncoding::Auto);
    const auto linear = formats::loadPaintedGradient(folder_ / "grey.png", {}, formats::GradientEncoding::Linear);
    ASSERT_TRUE(srgb && linear);
    EXPECT_NEAR(srgb->zones[7].x, 0.5029, 1e-4);  // code 188 of the sRGB curve
    EXPECT_NEAR(linear->zones[7].x, 188.0 / 255, 1e-6);
    EXPECT_LT(asset(options("grey.png")).at("measures").at("code_error"), 0.5);
    write("bright.exr", 8, 1, [](int x, int) { return glm::vec3(static_cast<float>(x)); });
    Conversion wanted = options("bright.exr");
    wanted.cook.given.set("gradient.encoding", "srgb");
    EXPECT_THAT(refusal(wanted), HasSubstr("channel R, texel (2, 0): found 2, expected 0 to 1 under the sRGB curve"));
}

TEST_F(Rsrm, EnvironmentsAreAveragedAroundTheirAxis) {
    // Bright on one side of the world: symmetric around X, not at all around Y.
    write("sky.exr", 64, 32, [](int x, int y) {
        const glm::dvec3 direction = lighting::directionFromEquirectangular({(x + 0.5) / 64, (y + 0.5) / 32});
        return glm::vec3(static_cast<float>(direction.x > 0 ? 3 : 1));
    });
    const auto around = [&](const std::string& axis) {
        Conversion wanted = options("sky.exr");
        wanted.cook.given.set("gradient.axis", axis);
        wanted.cook.given.set("gradient.zones", 64);
        return asset(wanted).at("measures").at("asymmetric_energy").get<double>();
    };
    EXPECT_LT(around("1,0,0"), 0.01);
    EXPECT_NEAR(around("0,1,0"), 0.2, 0.01);  // mean 2 squared of mean square 5
    EXPECT_THAT(refusal(options("sky.exr")), HasSubstr("an environment needs an axis"));
    Conversion wanted = options("sky.exr");
    wanted.cook.given.set("gradient.axis", "0,0,0");
    EXPECT_THAT(refusal(wanted), HasSubstr("axis"));
}

TEST_F(Rsrm, GradientsOfManyDifferentTexelsKeepTheirCodes) {
    for (const int width : {16, 256, 1000, 4096}) {
        std::mt19937 random(11);
        std::uniform_real_distribution<float> unit(0.2f, 1);
        write("random.exr", width, 1, [&](int, int) { return glm::vec3(unit(random), unit(random), unit(random)); });
        Conversion wanted = options("random.exr");
        wanted.cook.given.set("gradient.exponents", "1,4,256");
        wanted.cook.given.set("gradient.format", "rgba8");
        EXPECT_LT(asset(wanted).at("measures").at("code_error"), 0.502) << width;
    }
}

TEST_F(Rsrm, TheEdgesOfNumbersAreCookedOrRefusedByName) {
    const float denormal = std::numeric_limits<float>::denorm_min();
    const auto spike = [](float value) { return [value](int x, int) { return glm::vec3(x == 5 ? value : 1.0f); }; };
    write("black.exr", 256, 1, [](int, int) { return glm::vec3(0); });
    write("one.exr", 1, 1, [](int, int) { return glm::vec3(0.3f, 2, 1000); });
    write("denormal.exr", 64, 1, [&](int x, int) { return glm::vec3(x % 2 == 0 ? denormal : 3 * denormal); });
    write("long.exr", 16384, 1, [](int x, int) { return glm::vec3(1 + std::sin(0.001f * static_cast<float>(x))); });
    write("huge.exr", 64, 1, [](int x, int) { return glm::vec3(x < 32 ? 1e30f : 5e29f); });
    write("spike.exr", 64, 1, spike(1e30f));
    for (const char* name : {"black.exr", "one.exr", "denormal.exr", "long.exr", "huge.exr", "spike.exr"}) {
        SCOPED_TRACE(name);
        Conversion wanted = options(name);
        wanted.cook.given.set("gradient.exponents", "256,4096,65536");
        wanted.cook.given.set("gradient.format", "rgba8");
        const Json found = asset(wanted);
        EXPECT_LT(found.at("measures").at("code_error"), 0.56);
        for (const auto& [figure, value] : found.at("measures").items()) EXPECT_TRUE(std::isfinite(value.get<double>())) << figure;
    }
    write("negative.exr", 64, 1, spike(-1));
    EXPECT_THAT(refusal(options("negative.exr")), HasSubstr("negative.exr, channel R, texel (5, 0): found -1, expected a non-negative"));
    write("nan.exr", 64, 1, spike(NAN));
    EXPECT_THAT(refusal(options("nan.exr")), HasSubstr("nan.exr, channel R, texel (5, 0): found nan, expected a finite"));
    Conversion repaired = options("nan.exr");
    repaired.cook.repair = true;
    const Json mended = asset(repaired);
    EXPECT_LT(mended.at("measures").at("code_error"), 0.56);
    EXPECT_EQ(mended.at("notes").at("repaired_texels"), 1);
}

}  // namespace
}  // namespace lightcook::pipeline

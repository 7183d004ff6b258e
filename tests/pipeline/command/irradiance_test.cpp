#include "pipeline/command/irradiance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "formats/color.h"
#include "formats/environment.h"
#include "formats/gpu_texture.h"
#include "formats/plain_image.h"
#include "tests/formats/exr_attribute.h"
#include "tests/formats/temporary_folder.h"
#include "verify/cubemap.h"
#include "verify/texture_unit.h"

namespace lightcook::pipeline {
namespace {

using formats::Image;

/// Writes a grey panorama with a light source of one texel.
std::filesystem::path writeSky(const formats::TemporaryFolder& folder, float light) {
    Image<glm::vec4> sky(64, 32, glm::vec4(0.5f, 0.5f, 0.5f, 1));
    sky.at(10, 8) += glm::vec4(light, light / 2, 0, 0);
    std::filesystem::path file = folder / "sky.exr";
    EXPECT_TRUE(formats::writeExr(file, sky.view(), 3));
    return file;
}

TEST(IrradianceCommand, GreyStaysGreyThroughEveryTarget) {
    const formats::TemporaryFolder folder;
    const auto sky = writeSky(folder, 0);
    for (const formats::TargetInfo& target : formats::allTargets()) {
        IrradianceCommand command;
        command.input = sky;
        command.output = folder / "out.ktx2";
        command.target = target.id;
        command.size = 8;
        command.wrap = 0.25;
        const auto cooked = cookIrradiance(command);
        ASSERT_TRUE(cooked) << cooked.error().line();
        EXPECT_LT(cooked->at("worst").get<double>(), target.id == formats::Target::Float ? 1e-6 : 1e-3) << target.name;
    }
}

TEST(IrradianceCommand, RefusesDdsWhichCannotHoldTheRange) {
    const formats::TemporaryFolder folder;
    IrradianceCommand command;
    command.input = folder / "nowhere.exr";  // refused before it is read
    command.output = folder / "out.dds";
    const auto refused = cookIrradiance(command);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, formats::ErrorCode::InvalidRequest);
    EXPECT_NE(refused.error().detail.find("expected a .ktx2 file"), std::string::npos) << refused.error().line();
}

TEST(IrradianceCommand, AFailedVerificationKeepsTheEarlierFile) {
    const formats::TemporaryFolder folder;
    IrradianceCommand command;
    command.input = writeSky(folder, 5000);
    command.output = folder / "out.ktx2";
    const auto cooked = cookIrradiance(command);
    ASSERT_TRUE(cooked) << cooked.error().line();
    EXPECT_LT(cooked->at("rel_rms").get<double>(), 0.02);
    const auto before = std::filesystem::last_write_time(command.output);
    command.maxError = 1e-7;
    const auto refused = cookIrradiance(command);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, formats::ErrorCode::Verification);
    EXPECT_EQ(std::filesystem::last_write_time(command.output), before);
    command.output = folder / "out.exr";
    EXPECT_EQ(cookIrradiance(command).error().code, formats::ErrorCode::InvalidRequest);
}

TEST(ShCommand, GreyStaysGreyForEveryWrapAndALightSourceIsItsCoefficients) {
    const formats::TemporaryFolder folder;
    ShCommand command;
    command.input = writeSky(folder, 0);
    command.output = folder / "out.json";
    for (const double wrap : {0.0, 0.25, 1.0}) {
        command.wrap = wrap;
        const auto grey = cookSh(command);
        ASSERT_TRUE(grey) << grey.error().line();
        EXPECT_EQ(Json::parse(std::ifstream(command.output)), *grey) << "the returned object is the written one";
        EXPECT_NEAR(grey->at("exit")[0][1].get<double>() * 0.5 * std::sqrt(1 / std::numbers::pi), 0.5, 1e-6) << "exit radiance";
        for (int i = 1; i < 9; ++i) EXPECT_NEAR(grey->at("exit")[i][0].get<double>(), 0, 1e-7) << i;
    }
    command.input = writeSky(folder, 9000);
    command.wrap = 0.25;
    const auto lit = cookSh(command);
    command.normalize = "d3dx";
    const auto rescaled = cookSh(command);
    ASSERT_TRUE(lit && rescaled);
    constexpr double kBands[] = {1, 1.75 / 3, 0.75 * 0.75 / 4};
    for (int i = 0; i < 9; ++i)
        for (int channel = 0; channel < 3; ++channel) {
            const double sh = lit->at("sh")[i][channel];
            EXPECT_NEAR(lit->at("exit")[i][channel].get<double>(), kBands[i == 0 ? 0 : i < 4 ? 1 : 2] * sh, 1e-6 * std::abs(sh)) << i;
            EXPECT_NEAR(rescaled->at("sh")[i][channel].get<double>(), 16.0 / 17 * sh, 1e-6 * std::abs(sh)) << i;
        }
    EXPECT_GT(lit->at("sh")[0][0].get<double>(), lit->at("sh")[0][2].get<double>()) << "the light source is red";
    command.output = folder / "out.ktx2";
    EXPECT_EQ(cookSh(command).error().code, formats::ErrorCode::InvalidRequest);
}

TEST(ShCommand, ConvertsThePrimariesThatAFileStates) {
    const formats::TemporaryFolder folder;
    const Image<glm::vec4> sky(16, 8, glm::vec4(0.75f, 0.5f, 0.5f, 1));
    ASSERT_TRUE(formats::writeExr(folder / "sky.exr", sky.view(), 3));
    formats::writeContent(folder / "sky.exr",
                          formats::withChromaticities(formats::contentOf(folder / "sky.exr"),
                                                      {0.713f, 0.293f, 0.165f, 0.83f, 0.128f, 0.044f, 0.32168f, 0.33767f}));
    ShCommand command{.input = folder / "sky.exr", .output = folder / "out.json"};
    const auto meanOf = [&](const std::optional<std::string>& source) {
        command.source = source;
        const auto cooked = cookSh(command);
        EXPECT_TRUE(cooked) << cooked.error().line();
        glm::vec3 mean(0);
        for (int c = 0; c < 3; ++c) mean[c] = static_cast<float>(cooked->at("sh")[0][c].get<double>() / std::sqrt(4 * std::numbers::pi));
        return mean;
    };
    const glm::vec3 stored(0.75f, 0.5f, 0.5f),
        expected = formats::linearConversion({"acescg", "lin_rec709", {}})->workingFromSource * stored;
    const glm::vec3 stated = meanOf({}), kept = meanOf("lin_rec709");
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(stated[c], expected[c], 1e-5f);
        EXPECT_NEAR(kept[c], stored[c], 1e-5f);
    }
    IrradianceCommand irradiance;
    irradiance.input = command.input;
    irradiance.output = folder / "out.ktx2";
    irradiance.size = 8;
    irradiance.target = formats::Target::Float;
    const auto cooked = cookIrradiance(irradiance);
    ASSERT_TRUE(cooked) << cooked.error().line();
    const auto texture = formats::TextureReader::open(irradiance.output);
    ASSERT_TRUE(texture) << texture.error().line();
    const auto face = verify::decodeImage(*texture, {0, 0, 3});
    ASSERT_TRUE(face) << face.error().line();
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(face->at(2, 2)[c] * cooked->at("range").get<float>(), expected[c], 1e-3f);
}

TEST(IrradianceCommand, TheVerifierSeesAMissingLightSourceAndAWrongRange) {
    formats::Environment environment{formats::Environment::Projection::CubeStrip, Image<glm::vec3>(8, 48, glm::vec3(0.2f))};
    environment.texels.at(1, 34) = glm::vec3(900);  // towards a corner of +Z
    std::vector<Image<glm::vec4>> faces;
    for (int face = 0; face < 6; ++face) faces.emplace_back(4, 4, glm::vec4(0.2f));
    EXPECT_GT(verify::compareIrradiance(faces, 1, 0, environment).relRms, 0.1) << "the light source is missing";
    environment.texels.at(1, 34) = glm::vec3(0.2f);
    EXPECT_LT(verify::compareIrradiance(faces, 1, 0, environment).worst, 0.03) << "sampled at texel centres only";
    EXPECT_NEAR(verify::compareIrradiance(faces, 2, 0, environment).relRms, 1, 0.05) << "twice the range";
}

}  // namespace
}  // namespace lightcook::pipeline

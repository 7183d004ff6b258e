#include "pipeline/command/irradiance_command.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "formats/environment.h"
#include "pipeline/command/convert.h"
#include "tests/formats/temporary_folder.h"
#include "verify/cubemap.h"

namespace lightcook::pipeline {
namespace {

using formats::Image;

/// Grey, with a lamp that is one texel or none.
std::filesystem::path writeSky(const formats::TemporaryFolder& folder, float lamp) {
    Image<glm::vec4> sky(64, 32, glm::vec4(0.5f, 0.5f, 0.5f, 1));
    sky.at(10, 8) += glm::vec4(lamp, lamp / 2, 0, 0);
    const std::filesystem::path file = folder / "sky.exr";
    EXPECT_TRUE(formats::writeExr(file, sky.view(), 3));
    return file;
}

TEST(IrradianceCommand, GreyStaysGreyThroughEveryTarget) {
    const formats::TemporaryFolder folder;
    const auto sky = writeSky(folder, 0);
    for (const char* target : {"bc", "astc", "float"})
        for (const char* name : {"out.ktx2", "out.dds"}) {
            if (std::string(target) == "astc" && std::string(name) == "out.dds") continue;  // DDS has no ASTC
            IrradianceCommand command;
            command.input = sky;
            command.output = folder / name;
            command.target = target;
            command.size = 8;
            command.wrap = 0.25;
            const auto cooked = cookIrradiance(command);
            ASSERT_TRUE(cooked) << cooked.error().line();
            EXPECT_LT(cooked->at("worst").get<double>(), std::string(target) == "float" ? 1e-6 : 1e-3) << target;
        }
}

TEST(IrradianceCommand, AFailedVerificationLeavesWhatWasThere) {
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

/// A lamp over what is 10^18 times darker: no half holds both, and the report says where.
TEST(Cubemap, LightThatDivisionLosesIsCountedByLevel) {
    const formats::TemporaryFolder folder;
    for (const bool isDark : {false, true}) {
        Image<glm::vec4> sky(16, 8, glm::vec4(isDark ? 1e-12f : 0.5f));
        if (isDark) sky.at(3, 2) = glm::vec4(1e6f);
        ASSERT_TRUE(formats::writeExr(folder / "sky.exr", sky.view(), 3));
        ConvertOptions options;
        options.converter = "cubemap";
        options.input = folder / "sky.exr";
        options.output = folder / (isDark ? "dark" : "calm");
        options.cook.cache = folder / "cache";
        options.cook.target = Target::Float;
        const Outcome outcome = convert(options, RunState());
        ASSERT_TRUE(outcome.report.is_object());
        const Json& notes = outcome.report.at("assets").at(0).at("notes");
        EXPECT_TRUE(notes.at("division_clamped").empty());
        EXPECT_EQ(notes.at("division_lost").empty(), !isDark);
        if (isDark) {
            EXPECT_GT(notes.at("division_lost").at("level 0").get<int>(), 6 * 128 * 128);
        }
    }
}

TEST(ShCommand, GreyStaysGreyForEveryWrapAndALampIsItsCoefficients) {
    const formats::TemporaryFolder folder;
    ShCommand command;
    command.input = writeSky(folder, 0);
    command.output = folder / "out.json";
    for (const double wrap : {0.0, 0.25, 1.0}) {
        command.wrap = wrap;
        const auto grey = cookSh(command);
        ASSERT_TRUE(grey) << grey.error().line();
        EXPECT_EQ(Json::parse(std::ifstream(command.output)), *grey) << "what is returned is what was written";
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
    EXPECT_GT(lit->at("sh")[0][0].get<double>(), lit->at("sh")[0][2].get<double>()) << "the lamp is red";
    command.output = folder / "out.ktx2";
    EXPECT_EQ(cookSh(command).error().code, formats::ErrorCode::InvalidRequest);
}

TEST(IrradianceCommand, TheVerifierSeesAMissingLampAndAWrongRange) {
    formats::Environment environment{formats::Environment::Projection::CubeStrip, Image<glm::vec3>(8, 48, glm::vec3(0.2f))};
    environment.texels.at(1, 34) = glm::vec3(900);  // towards a corner of +Z
    std::vector<Image<glm::vec4>> faces;
    for (int face = 0; face < 6; ++face) faces.emplace_back(4, 4, glm::vec4(0.2f));
    EXPECT_GT(verify::compareIrradiance(faces, 1, 0, environment).relRms, 0.1) << "the lamp is missing";
    environment.texels.at(1, 34) = glm::vec3(0.2f);
    EXPECT_LT(verify::compareIrradiance(faces, 1, 0, environment).worst, 0.03) << "texels in their middles only";
    EXPECT_NEAR(verify::compareIrradiance(faces, 2, 0, environment).relRms, 1, 0.05) << "twice the range";
}

}  // namespace
}  // namespace lightcook::pipeline

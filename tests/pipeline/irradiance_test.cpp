#include "pipeline/irradiance_command.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "formats/environment.h"
#include "tests/formats/temporary_folder.h"
#include "verify/irradiance.h"

namespace pipeline {
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
}  // namespace pipeline

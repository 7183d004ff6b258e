#include "pipeline/texture_commands.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "formats/environment.h"
#include "pipeline/textures.h"
#include "tests/formats/temporary_folder.h"

namespace pipeline {
namespace {

using formats::ErrorCode;
using formats::Image;

Image<glm::vec4> ramp(int width, int height) {
    Image<glm::vec4> image(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            image.at(x, y) = glm::vec4((x + 0.5f) / static_cast<float>(width), (y + 0.5f) / static_cast<float>(height), 0.25f, 0.75f);
    return image;
}

TEST(EncodeTexture, EveryFormatComesBackCloseThroughKtx2AndDds) {
    const formats::TemporaryFolder folder;
    ASSERT_TRUE(formats::writeExr(folder / "in.exr", ramp(37, 22).view(), 4).has_value());
    for (const formats::PixelFormatInfo& format : formats::allPixelFormats())
        for (const char* extension : {".ktx2", ".dds"}) {
            if (format.dxgiFormat == 0 && std::string(extension) == ".dds") continue;
            SCOPED_TRACE(std::string(format.name) + extension);
            EncodeCommand command;
            command.input = folder / "in.exr";
            command.output = folder / ("out" + std::string(extension));
            command.format = format.name;
            const auto facts = encodeTexture(command, 2);
            ASSERT_TRUE(facts.has_value()) << facts.error().line();
            for (const char* key : {"width", "height", "mips", "layers", "faces", "format", "bytes", "encode_seconds", "threads"})
                EXPECT_TRUE(facts->contains(key)) << key;
            EXPECT_EQ(facts->at("bytes"), formats::bytesPerImage(format.format, 37, 22));
            const auto difference = compareFiles(command.input, command.output);
            ASSERT_TRUE(difference.has_value()) << difference.error().line();
            EXPECT_LT(difference->at("rel_rmse").get<double>(), 0.06);
            ASSERT_TRUE(decodeTexture({command.output, folder / "back.exr", 0, 0}).has_value());
            EXPECT_EQ(compareFiles(command.output, folder / "back.exr")->at("max_abs").get<double>(), 0.0);
        }
}

TEST(EncodeTexture, WhatAFormatCannotMeanIsRefusedWithItsPlaceOrRepaired) {
    const formats::TemporaryFolder folder;
    Image<glm::vec4> image = ramp(8, 8);
    EncodeCommand command;
    command.input = folder / "in.exr";
    command.output = folder / "out.ktx2";
    command.format = "bc6h-uf16";
    const std::pair<float, ErrorCode> cases[] = {{std::numeric_limits<float>::quiet_NaN(), ErrorCode::ValueNotFinite},
                                                 {std::numeric_limits<float>::infinity(), ErrorCode::ValueNotFinite},
                                                 {-1.0f, ErrorCode::ValueOutOfRange}};
    for (const auto& [value, code] : cases) {
        image.at(5, 3).y = value;
        ASSERT_TRUE(formats::writeExr(command.input, image.view(), 3).has_value());
        command.repair = false;
        const auto refused = encodeTexture(command, 1);
        ASSERT_FALSE(refused.has_value());
        EXPECT_EQ(refused.error().code, code);
        EXPECT_NE(refused.error().subject.find("channel G, texel (5, 3)"), std::string::npos) << refused.error().line();
        EXPECT_FALSE(std::filesystem::exists(command.output));
        command.repair = true;
        const auto repaired = encodeTexture(command, 1);
        ASSERT_TRUE(repaired.has_value()) << repaired.error().line();
        EXPECT_EQ(repaired->at("repaired"), 1);
        std::filesystem::remove(command.output);
    }
    command.repair = false;
    command.format = "bc6h-sf16";
    EXPECT_TRUE(encodeTexture(command, 1).has_value()) << "a signed format holds -1";
}

TEST(EncodeTexture, WrongRequestsAreRefused) {
    const formats::TemporaryFolder folder;
    ASSERT_TRUE(formats::writeExr(folder / "in.exr", ramp(8, 8).view(), 3).has_value());
    EncodeCommand command{folder / "in.exr", folder / "out.ktx2", "bc6", 5, false, false, false};
    const auto format = encodeTexture(command, 1);
    ASSERT_FALSE(format.has_value());
    EXPECT_EQ(format.error().code, ErrorCode::InvalidRequest);
    EXPECT_NE(format.error().detail.find("nearest is 'bc"), std::string::npos);
    command.format = "bc7";
    command.output = folder / "out.png";
    EXPECT_EQ(encodeTexture(command, 1).error().code, ErrorCode::InvalidRequest);
    command.output = folder / "out.ktx2";
    command.cube = true;
    EXPECT_EQ(encodeTexture(command, 1).error().code, ErrorCode::WrongShape);
    EXPECT_FALSE(std::filesystem::exists(folder / "out.ktx2"));
}

TEST(EncodeTexture, ACubeKeepsItsFaces) {
    const formats::TemporaryFolder folder;
    ASSERT_TRUE(formats::writeExr(folder / "in.exr", ramp(8, 48).view(), 3).has_value());
    const EncodeCommand command{folder / "in.exr", folder / "out.ktx2", "rgba16f", 5, true, true, false};
    const auto facts = encodeTexture(command, 1);
    ASSERT_TRUE(facts.has_value());
    EXPECT_EQ(facts->at("faces"), 6);
    EXPECT_EQ(describeFile(command.output)->at("faces"), 6);
    EXPECT_LT(compareFiles(command.input, command.output)->at("max_abs").get<double>(), 1e-3);
}

TEST(EncodeImage, DoesNotDependOnHowTheRowsWereSpread) {
    const Image<glm::vec4> image = ramp(64, 200);
    compress::EncodeReport report;
    const auto spread = encodeImage(formats::PixelFormat::Bc7, image.view(), {}, {}, report);
    std::vector<std::byte> whole(spread.size());
    compress::encodeRows(formats::PixelFormat::Bc7, image.view(), {}, {}, whole, {});
    EXPECT_EQ(spread, whole);
}

TEST(HdrRange, BringsTheLargestUnderATopThatHalvesHoldWell) {
    for (const float largest : {1e-30f, 1e-5f, 0.9f, 1.0f, 3.0f, 65504.0f, 1e20f}) {
        const float stored = largest / hdrRange(largest);
        EXPECT_GT(stored, 511.0f) << largest;
        EXPECT_LE(stored, 1024.0f) << largest;
    }
    EXPECT_EQ(hdrRange(0), 1.0f);
    EXPECT_GT(hdrRange(std::numeric_limits<float>::denorm_min()), 0.0f);
}

}  // namespace
}  // namespace pipeline

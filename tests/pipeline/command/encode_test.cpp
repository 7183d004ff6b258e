#include "pipeline/command/encode.h"
#include "formats/plain_image.h"
#include "formats/png.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "formats/color.h"
#include "formats/gpu_texture.h"
#include "formats/image/exr_file.h"
#include "pipeline/command/compare.h"
#include "pipeline/command/decode.h"
#include "pipeline/command/info.h"
#include "tests/formats/exr_attribute.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::Image;

Image<glm::vec4> gradientImage(int width, int height) {
    Image<glm::vec4> image(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            image.at(x, y) = glm::vec4((x + 0.5f) / static_cast<float>(width), (y + 0.5f) / static_cast<float>(height), 0.25f, 0.75f);
    return image;
}

formats::Result<Json> differenceOf(const std::filesystem::path& a, const std::filesystem::path& b) {
    const RunState state;
    return compareFiles(a, b, state).map([](const Comparison& compared) { return compared.figures; });
}

TEST(EncodeTexture, EveryFormatComesBackCloseThroughKtx2AndDds) {
    const formats::TemporaryFolder folder;
    ASSERT_TRUE(formats::writeExr(folder / "in.exr", gradientImage(37, 22).view(), 4).has_value());
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
            const auto compared = differenceOf(command.input, command.output);
            ASSERT_TRUE(compared.has_value()) << compared.error().line();
            EXPECT_LT(compared->at("rel_rmse").get<double>(), 0.06);
            ASSERT_TRUE(decodeTexture({command.output, folder / "back.exr", 0, 0}).has_value());
            EXPECT_EQ(differenceOf(command.output, folder / "back.exr")->at("max_abs").get<double>(), 0.0);
        }
}

TEST(EncodeTexture, WhatAFormatCannotMeanIsRefusedWithItsPlaceOrRepaired) {
    const formats::TemporaryFolder folder;
    Image<glm::vec4> image = gradientImage(8, 8);
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
    for (const char* format : {"bc7", "rgb9e5", "r16-unorm"}) {
        image = gradientImage(8, 8);
        image.at(2, 1).x = -0.25f;
        ASSERT_TRUE(formats::writeExr(command.input, image.view(), 3).has_value());
        command.format = format;
        command.repair = false;
        EXPECT_EQ(encodeTexture(command, 1).error().code, ErrorCode::ValueOutOfRange) << format;
        command.repair = true;
        EXPECT_EQ(encodeTexture(command, 1)->at("repaired"), 1) << format;
    }
}

TEST(EncodeTexture, InfiniteLightBecomesTheLargestOfTheFormat) {
    const formats::TemporaryFolder folder;
    for (const auto& [format, largest] : std::initializer_list<std::pair<const char*, float>>{
             {"rgba16f", 65504}, {"bc6h-uf16", 65504}, {"rgb9e5", 65408}, {"r11g11b10f", 64512}, {"rgba16-unorm", 1}}) {
        Image<glm::vec4> image(4, 4, glm::vec4(0.5f, 0.5f, 0.5f, 1));
        image.at(1, 2) = glm::vec4(glm::vec3(std::numeric_limits<float>::infinity()), 1);
        image.at(3, 2).x = std::numeric_limits<float>::quiet_NaN();
        ASSERT_TRUE(formats::writeExr(folder / "in.exr", image.view(), 3).has_value());
        EncodeCommand command{folder / "in.exr", folder / "out.ktx2", format};
        EXPECT_NE(encodeTexture(command, 1).error().line().find("found inf, expected a finite value (--repair makes it "),
                  std::string::npos);
        command.repair = true;
        const auto facts = encodeTexture(command, 1);
        ASSERT_TRUE(facts.has_value()) << facts.error().line();
        EXPECT_EQ(facts->at("repaired"), 4) << format;
        EXPECT_EQ(facts->at("clamped_high"), 0) << format;
        ASSERT_TRUE(decodeTexture({command.output, folder / "back.exr", 0, 0}).has_value());
        const auto back = formats::readImage(folder / "back.exr");
        EXPECT_NEAR(back->texels.at(1, 2).x, largest, 0.01f * largest) << format;
    }
}

TEST(EncodeTexture, TransparencyThatAFormatLacksIsCounted) {
    const formats::TemporaryFolder folder;
    Image<glm::vec4> image = gradientImage(8, 8);  // of alpha 0.75
    image.at(3, 3).a = image.at(4, 3).a = 1;
    ASSERT_TRUE(formats::writeExr(folder / "in.exr", image.view(), 4).has_value());
    const auto countIn = [&](const char* format) {
        const auto facts = encodeTexture({folder / "in.exr", folder / "out.ktx2", format}, 1);
        EXPECT_TRUE(facts.has_value()) << facts.error().line();
        return facts ? facts->at("transparent_texels").get<int>() : -1;
    };
    for (const char* format : {"bc1", "bc4", "bc6h-uf16", "rgb9e5", "rg16-unorm"}) EXPECT_EQ(countIn(format), 62) << format;
    for (const char* format : {"bc3", "bc7", "rgba16f", "rgba8-unorm"}) EXPECT_EQ(countIn(format), 0) << format;
    ASSERT_TRUE(formats::writeExr(folder / "in.exr", image.view(), 3).has_value());
    EXPECT_EQ(countIn("bc1"), 0) << "an image without alpha is opaque";
}

TEST(EncodeTexture, ChannelsOfAnExrAreThoseOfTheirNames) {
    const formats::TemporaryFolder folder;
    const auto writeChannels = [&](const std::vector<std::string>& channels) {
        auto writer = formats::ExrWriter::create(folder / "in.exr", 4, 4, channels, formats::ExrLayout::ScanLines);
        std::vector<float> texels;
        for (int i = 0; i < 16; ++i)
            for (std::size_t c = 0; c < channels.size(); ++c) texels.push_back(static_cast<float>(c + 1) / 8);
        ASSERT_TRUE(writer && writer->append(texels.data(), static_cast<std::ptrdiff_t>(4 * channels.size()), 4) && writer->commit());
    };
    const auto encoded = [&] {
        const auto facts = encodeTexture({folder / "in.exr", folder / "out.ktx2", "rgba16f"}, 1);
        EXPECT_TRUE(facts.has_value()) << facts.error().line();
        EXPECT_TRUE(decodeTexture({folder / "out.ktx2", folder / "back.exr", 0, 0}).has_value());
        return std::pair(facts->at("ignored_channels"), formats::readImage(folder / "back.exr")->texels.at(2, 1));
    };
    writeChannels({"R", "G", "B", "Z"});
    EXPECT_EQ(encoded(), std::pair(Json::array({"Z"}), glm::vec4(0.125f, 0.25f, 0.375f, 1)));
    writeChannels({"Y", "Z"});
    EXPECT_EQ(encoded(), std::pair(Json::array({"Z"}), glm::vec4(0.125f, 0.125f, 0.125f, 1)));
    writeChannels({"R", "G", "B", "A"});
    EXPECT_EQ(encoded(), std::pair(Json::array(), glm::vec4(0.125f, 0.25f, 0.375f, 0.5f)));
}

TEST(EncodeTexture, StatedPrimariesAreConvertedUnlessTheSourceIsNamed) {
    const formats::TemporaryFolder folder;
    const auto writeColour = [&](const glm::vec3& colour) {
        const Image<glm::vec4> image(8, 8, glm::vec4(colour, 1));
        ASSERT_TRUE(formats::writeExr(folder / "in.exr", image.view(), 3).has_value());
        formats::writeContent(folder / "in.exr",
                              formats::withChromaticities(formats::contentOf(folder / "in.exr"),
                                                          {0.713f, 0.293f, 0.165f, 0.83f, 0.128f, 0.044f, 0.32168f, 0.33767f}));
    };
    writeColour({0.75f, 0.5f, 0.5f});
    EncodeCommand command{folder / "in.exr", folder / "out.ktx2", "rgba16f"};
    const auto texel = [&] {
        EXPECT_TRUE(decodeTexture({folder / "out.ktx2", folder / "back.exr", 0, 0}).has_value());
        return formats::readImage(folder / "back.exr")->texels.at(1, 1);
    };
    const auto converted = encodeTexture(command, 1);
    ASSERT_TRUE(converted.has_value()) << converted.error().line();
    EXPECT_EQ(converted->at("converted_from"), "acescg");
    const glm::vec3 expected = formats::linearConversion({"acescg", "lin_rec709", {}})->workingFromSource * glm::vec3(0.75f, 0.5f, 0.5f);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(texel()[c], expected[c], 1e-3f);
    command.source = "lin_rec709";
    const auto kept = encodeTexture(command, 1);
    ASSERT_TRUE(kept.has_value()) << kept.error().line();
    EXPECT_EQ(kept->at("converted_from"), "");
    EXPECT_EQ(texel(), glm::vec4(0.75f, 0.5f, 0.5f, 1));
    // A colour that Rec.709 cannot show.
    writeColour({0, 1, 0});
    command.format = "bc6h-uf16";
    command.source.reset();
    const auto limited = encodeTexture(command, 1);
    ASSERT_TRUE(limited.has_value()) << limited.error().line();
    EXPECT_EQ(limited->at("clamped_negative"), 128) << "red and blue of 8 x 8 texels";
    EXPECT_EQ(texel().x, 0);
    command.source = "acescg";
    const auto refused = encodeTexture(command, 1);
    ASSERT_FALSE(refused.has_value());
    EXPECT_NE(
        refused.error().line().find("(--repair makes it zero; it is one after the conversion from acescg to lin_rec709, which --source "
                                    "lin_rec709 leaves out)"),
        std::string::npos)
        << refused.error().line();
}

TEST(EncodeTexture, FacesOfAnOpenExrCubeAreTurned) {
    const formats::TemporaryFolder folder;
    Image<glm::vec4> faces(4, 24);
    for (int y = 0; y < 24; ++y)
        for (int x = 0; x < 4; ++x) faces.at(x, y) = glm::vec4(x, y % 4, 0, 1);
    ASSERT_TRUE(formats::writeExr(folder / "in.exr", faces.view(), 3).has_value());
    formats::writeContent(folder / "in.exr", formats::withAttribute(formats::contentOf(folder / "in.exr"), "envmap", "envmap", "\1"));
    EncodeCommand command{folder / "in.exr", folder / "out.ktx2", "rgba16f"};
    command.cube = true;
    ASSERT_TRUE(encodeTexture(command, 1).has_value());
    ASSERT_TRUE(decodeTexture({folder / "out.ktx2", folder / "back.exr", 0, 0}).has_value());
    const auto back = formats::readImage(folder / "back.exr");
    for (int face = 0; face < 6; ++face) {
        const bool isPole = face == 2 || face == 3;
        const glm::vec4 texel = back->texels.at(0, 4 * face);  // 3/8 of a step from the edge
        EXPECT_NEAR(texel.r, isPole ? 0.375f : 2.625f, 2e-3f) << face;
        EXPECT_NEAR(texel.g, isPole ? 2.625f : 0.375f, 2e-3f) << face;
    }
}

TEST(EncodeTexture, SignedBlocksComeBackFromBothContainers) {
    const formats::TemporaryFolder folder;
    Image<glm::vec4> image(32, 24);
    for (int y = 0; y < 24; ++y)
        for (int x = 0; x < 32; ++x) image.at(x, y) = glm::vec4(-static_cast<float>(x) / 31, static_cast<float>(y) / 11.5f - 1, 0, 1);
    image.at(3, 4) = glm::vec4(-2, 2, 0, 1);
    ASSERT_TRUE(formats::writeExr(folder / "in.exr", image.view(), 3).has_value());
    for (const char* container : {"out.ktx2", "out.dds"})
        for (const auto& [format, channels] : std::initializer_list<std::pair<const char*, int>>{{"bc4-snorm", 1}, {"bc5-snorm", 2}}) {
            const auto facts = encodeTexture({folder / "in.exr", folder / container, format}, 1);
            ASSERT_TRUE(facts.has_value()) << facts.error().line();
            EXPECT_EQ(facts->at("clamped_high"), channels) << format;
            const auto described = describeFile(folder / container);
            ASSERT_TRUE(described.has_value()) << described.error().line();
            EXPECT_EQ(described->at("format"), format);
            ASSERT_TRUE(decodeTexture({folder / container, folder / "back.exr", 0, 0}).has_value());
            const auto back = formats::readImage(folder / "back.exr");
            ASSERT_TRUE(back.has_value()) << back.error().line();
            for (int y = 0; y < 24; ++y)
                for (int x = 0; x < 32; ++x)
                    for (int c = 0; c < channels; ++c)
                        ASSERT_NEAR(back->texels.at(x, y)[c], std::clamp(image.at(x, y)[c], -1.0f, 1.0f), 0.05f)
                            << format << ' ' << x << ' ' << y;
        }
}

/// The codes of a picture are under the sRGB curve already.
TEST(EncodeTexture, APictureKeepsItsCodesInAnSrgbFormat) {
    const formats::TemporaryFolder folder;
    Image<glm::u8vec3> ramp(16, 16);
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 16; ++x) ramp.at(x, y) = glm::u8vec3(static_cast<glm::uint8>(16 * y + x), 200, 3);
    const auto png = formats::encodePng(std::as_const(ramp).view());
    ASSERT_TRUE(png.has_value());
    formats::writeContent(folder / "ramp.png", std::string(reinterpret_cast<const char*>(png->data()), png->size()));
    EncodeCommand command;
    command.input = folder / "ramp.png";
    command.output = folder / "ramp.ktx2";
    command.format = "rgba8-srgb";
    const auto facts = encodeTexture(command, 1);
    ASSERT_TRUE(facts.has_value()) << facts.error().line();
    const auto texture = formats::TextureReader::open(command.output);
    ASSERT_TRUE(texture.has_value());
    std::vector<std::byte> codes(std::size_t{16} * 16 * 4);
    ASSERT_TRUE(texture->readBlockRows({}, 0, codes).has_value());
    for (std::size_t i = 0; i < 256; ++i) {
        EXPECT_EQ(std::to_integer<std::size_t>(codes[4 * i]), i);
        EXPECT_EQ(std::to_integer<int>(codes[4 * i + 1]), 200);
    }
    EXPECT_LT(differenceOf(command.input, command.output)->at("max_abs").get<double>(), 1e-6);
}

TEST(EncodeTexture, WhatIsTooLargeIsClampedAndCounted) {
    const formats::TemporaryFolder folder;
    Image<glm::vec4> image = gradientImage(8, 8);
    image.at(1, 6).x = 1e9f;
    image.at(7, 7).z = 2e9f;
    ASSERT_TRUE(formats::writeExr(folder / "in.exr", image.view(), 3).has_value());
    for (const auto& [format, largest] : std::initializer_list<std::pair<const char*, double>>{
             {"bc6h-uf16", 65504}, {"bc6h-sf16", 65504}, {"rgb9e5", 65408}, {"r11g11b10f", 65024}, {"bc7", 1}, {"rgba16-unorm", 1}}) {
        EncodeCommand command{folder / "in.exr", folder / "out.ktx2", format};
        const auto facts = encodeTexture(command, 1);
        ASSERT_TRUE(facts.has_value()) << facts.error().line();
        EXPECT_EQ(facts->at("clamped_high"), 2) << format;
        EXPECT_EQ(facts->at("repaired"), 0) << format;
        ASSERT_TRUE(decodeTexture({command.output, folder / "back.exr", 0, 0}).has_value());
        const double brightest = describeFile(folder / "back.exr")->at("maximum").get<double>();
        EXPECT_LE(brightest, largest) << format;
        EXPECT_GE(brightest, 0.9 * largest) << format;
    }
}

/// Smooth light from 2^-5 to 2^5 with a grain of a quarter, the channels apart.
Image<glm::vec4> light(int width, int height) {
    Image<glm::vec4> image(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < 4; ++c) {
                const float octaves =
                    2.5f * (std::sin(0.11f * static_cast<float>(x + 9 * c)) + std::sin(0.07f * static_cast<float>(y - 5 * c)));
                image.at(x, y)[c] = std::exp2(octaves) * (1 + static_cast<float>((x * 37 + y * 101 + c * 53 + x * y * 29) % 32) / 128);
            }
    return image;
}

/// The encoder that minimizes an error reaches a smaller value of it than encoders that minimize other errors.
class EncodeOptionsOfTheCommand : public testing::Test {
protected:
    EncodeOptionsOfTheCommand() { EXPECT_TRUE(formats::writeExr(folder_ / "in.exr", light(64, 64).view(), 4).has_value()); }
    EncodeCommand command(const char* format) const { return {folder_ / "in.exr", folder_ / "out.ktx2", format}; }
    /// Decoded texels.
    Image<glm::vec4> coded(const EncodeCommand& command) const {
        const auto facts = encodeTexture(command, 1);
        EXPECT_TRUE(facts.has_value()) << facts.error().line();
        EXPECT_TRUE(decodeTexture({command.output, folder_ / "back.exr", 0, 0}).has_value());
        return std::move(formats::readImage(folder_ / "back.exr")->texels);
    }
    template <class Error>
    static double sum(const Image<glm::vec4>& texels, const Error& error, const Image<glm::vec4>& reference = light(64, 64)) {
        double total = 0;
        for (int y = 0; y < 64; ++y)
            for (int x = 0; x < 64; ++x)
                for (int c = 0; c < 3; ++c) {
                    const double found = static_cast<double>(texels.at(x, y)[c]), wanted = static_cast<double>(reference.at(x, y)[c]);
                    total += std::pow(error(found, wanted, x, c), 2);
                }
        return total;
    }
    void expectRefused(const EncodeCommand& command, ErrorCode code, const std::string& words) const {
        const auto refused = encodeTexture(command, 1);
        ASSERT_FALSE(refused.has_value());
        EXPECT_EQ(refused.error().code, code) << refused.error().line();
        EXPECT_NE(refused.error().line().find(words), std::string::npos) << refused.error().line();
        EXPECT_FALSE(std::filesystem::exists(command.output));
    }

    formats::TemporaryFolder folder_;
};

TEST_F(EncodeOptionsOfTheCommand, EachMetricAndScaleServesItsOwnError) {
    const std::function<double(double, double, int, int)> errors[] = {
        [](double a, double b, int, int) { return std::log2(1 + a) - std::log2(1 + b); },
        [](double a, double b, int, int) { return std::log2(1 + a / 0.02) - std::log2(1 + b / 0.02); },
        [](double a, double b, int, int) { return a - b; },
        [](double a, double b, int, int) { return (a - b) / (b + 0.01); },
    };
    const std::pair<compress::HdrMetric, float> asked[] = {{compress::HdrMetric::Log, 1.0f},
                                                           {compress::HdrMetric::Log, 0.02f},
                                                           {compress::HdrMetric::Linear, 1.0f},
                                                           {compress::HdrMetric::Relative, 0.01f}};
    double table[4][4];
    for (int i = 0; i < 4; ++i) {
        EncodeCommand each = command("bc6h-uf16");
        each.metric = asked[i].first;
        if (each.metric != compress::HdrMetric::Linear) each.metricScale = asked[i].second;
        const Image<glm::vec4> texels = coded(each);
        for (int j = 0; j < 4; ++j) table[i][j] = sum(texels, errors[j]);
    }
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) {
            if (i == j || (i == 1 && j == 3)) continue;  // those two measure nearly the same
            EXPECT_LT(table[j][j], table[i][j]) << "asked for " << i << ", measured " << j;
        }
}

TEST_F(EncodeOptionsOfTheCommand, WeightsServeTheirChannelAndOnlyRatiosCount) {
    const auto red = [](double a, double b, int, int c) { return c == 0 ? std::log2(1 + a) - std::log2(1 + b) : 0; };
    EncodeCommand plain = command("bc6h-uf16"), weighted = plain, same = plain;
    weighted.channelWeights = {8, 1, 1, 0};
    same.channelWeights = {3, 3, 3, 3};
    const Image<glm::vec4> reference = coded(plain);
    EXPECT_LT(sum(coded(weighted), red), 0.7 * sum(reference, red));
    EXPECT_EQ(coded(same).texels(), reference.texels());
}

TEST_F(EncodeOptionsOfTheCommand, PerceptualWeighsChannelsAsLumaDoes) {
    Image<glm::vec4> image = light(64, 64);
    for (glm::vec4& texel : image.texels()) texel = glm::fract(texel);
    ASSERT_TRUE(formats::writeExr(folder_ / "in.exr", image.view(), 4).has_value());
    const auto error = [](const std::array<double, 3>& weights) {
        return [weights](double a, double b, int, int c) { return c < 3 ? std::sqrt(weights[static_cast<std::size_t>(c)]) * (a - b) : 0; };
    };
    const auto seen = error({0.2126, 0.7152, 0.0722}), plain = error({1, 1, 1});
    for (const char* format : {"bc1", "bc3", "bc7"}) {
        EncodeCommand all = command(format), luma = all, named = all;
        luma.perceptual = true;
        named.channelWeights = {0.2126f, 0.7152f, 0.0722f, 1.0f / 3};
        const Image<glm::vec4> even = coded(all), weighted = coded(luma);
        EXPECT_LT(sum(weighted, seen, image), 0.95 * sum(even, seen, image)) << format;
        EXPECT_GT(sum(weighted, plain, image), sum(even, plain, image)) << format << ": it is no free gain";
        EXPECT_EQ(coded(named).texels(), weighted.texels()) << format;
    }
}

TEST_F(EncodeOptionsOfTheCommand, SignificanceServesTheTexelsThatCount) {
    Image<glm::vec4> image = light(64, 64), weights(64, 64, glm::vec4(0));
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) {
            weights.at(x, y) = glm::vec4(x % 4 < 2 ? 1e20f : 0.0f, 7, 7, 7);
            if (x % 4 >= 2) image.at(x, y) = glm::vec4((x + y) % 3 * 20.0f);
        }
    ASSERT_TRUE(formats::writeExr(folder_ / "in.exr", image.view(), 3).has_value());
    ASSERT_TRUE(formats::writeExr(folder_ / "weights.exr", weights.view(), 3).has_value());
    const auto counted = [](double a, double b, int x, int) { return x % 4 < 2 ? std::log2(1 + a) - std::log2(1 + b) : 0; };
    for (const char* format : {"bc6h-uf16", "astc-4x4-hdr"}) {
        EncodeCommand plain = command(format), weighted = plain;
        weighted.significance = folder_ / "weights.exr";
        EXPECT_LT(sum(coded(weighted), counted), 0.7 * sum(coded(plain), counted)) << format;
    }
}

TEST_F(EncodeOptionsOfTheCommand, MoreErrorInRepeatedBlocksMakesSmallerFiles) {
    // Rows long enough to find something to repeat.
    Image<glm::vec4> image = light(512, 32);
    for (glm::vec4& texel : image.texels()) texel /= 256;
    ASSERT_TRUE(formats::writeExr(folder_ / "in.exr", image.view(), 4).has_value());
    for (const char* format : {"bc1", "bc3", "bc4", "bc5", "bc7", "bc6h-uf16"}) {
        double lastBytes = 1e9;
        for (const double rdo : {0.0, 0.05, 0.5}) {
            EncodeCommand each = command(format);
            each.zstd = true;
            each.rdo = rdo;
            ASSERT_TRUE(encodeTexture(each, 1).has_value());
            const auto bytes = static_cast<double>(std::filesystem::file_size(each.output));
            EXPECT_LT(bytes, 0.99 * lastBytes) << format << ' ' << rdo;
            lastBytes = bytes;
        }
    }
}

TEST_F(EncodeOptionsOfTheCommand, ImpossibleOnesAreRefused) {
    for (const char* format : {"bc4", "bc5"}) {
        EncodeCommand each = command(format);
        each.perceptual = true;
        expectRefused(each, ErrorCode::InvalidRequest, "which holds no colour");
    }
    const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
    EncodeCommand each = command("bc6h-uf16");
    for (const float scale : {0.0f, -1.0f, 1e-7f, 1e6f, nan, infinity}) {
        each.metricScale = scale;
        expectRefused(each, ErrorCode::InvalidRequest, "--metric-scale");
    }
    each = command("bc6h-uf16");
    for (const std::array<float, 4>& weights : {std::array<float, 4>{0, 0, 0, 1}, {1, -1, 1, 1}, {1, 1, nan, 1}, {infinity, 1, 1, 1}}) {
        each.channelWeights = weights;
        expectRefused(each, ErrorCode::InvalidRequest, "--weights");
    }
    each = command("bc7");
    for (const double rdo : {-0.1, 1.5, static_cast<double>(nan)}) {
        each.rdo = rdo;
        expectRefused(each, ErrorCode::InvalidRequest, "--rdo");
    }
    each = command("astc-4x4-hdr");
    each.rdo = 0.1;
    expectRefused(each, ErrorCode::InvalidRequest, "found format astc-4x4-hdr, expected one of BC1 to BC7");
    each = command("bc6h-uf16");
    each.significance = folder_ / "weights.exr";
    expectRefused(each, ErrorCode::FileUnreadable, "weights.exr");
    ASSERT_TRUE(formats::writeExr(each.significance, light(64, 60).view(), 3).has_value());
    expectRefused(each, ErrorCode::WrongShape, "found 64 x 60 texels, expected 64 x 64");
    for (const auto& [value, code] :
         {std::pair(nan, ErrorCode::ValueNotFinite), {infinity, ErrorCode::ValueNotFinite}, {-1.0f, ErrorCode::ValueOutOfRange}}) {
        Image<glm::vec4> weights = light(64, 64);
        weights.at(9, 4).x = value;
        ASSERT_TRUE(formats::writeExr(each.significance, weights.view(), 3).has_value());
        expectRefused(each, code, "weights.exr, texel (9, 4): found a significance");
    }
}

TEST_F(EncodeOptionsOfTheCommand, MetricsWithoutEffectAreRefused) {
    for (const formats::PixelFormatInfo& format : formats::allPixelFormats()) {
        const std::string name(format.name);
        SCOPED_TRACE(name);
        EncodeCommand metric = command(name.c_str()), scale = metric;
        metric.metric = compress::HdrMetric::Log;
        scale.metricScale = 1.0f;
        if (name.starts_with("bc6h") || name == "rgb9e5") {
            EXPECT_TRUE(encodeTexture(metric, 1));
            EXPECT_TRUE(encodeTexture(scale, 1));
        } else {
            const std::string found = fmt::format(
                ": found it with --format {}, whose encoder minimizes an error of its own, expected --format bc6h-uf16, bc6h-sf16 or "
                "rgb9e5",
                name);
            expectRefused(metric, ErrorCode::InvalidRequest, "--metric" + found);
            expectRefused(scale, ErrorCode::InvalidRequest, "--metric-scale" + found);
        }
        std::filesystem::remove(metric.output);
    }
    EncodeCommand linear = command("bc6h-uf16");
    linear.metric = compress::HdrMetric::Linear;
    linear.metricScale = 0.5f;
    expectRefused(linear, ErrorCode::InvalidRequest,
                  "--metric-scale: found it with --metric linear, which has no scale, expected --metric log or relative");
}

/// What is refused with a format does not change its texture; what is taken does.
TEST_F(EncodeOptionsOfTheCommand, WeightsWithoutEffectAreRefused) {
    Image<glm::vec4> image = light(64, 64), weights(64, 64, glm::vec4(0));
    for (glm::vec4& texel : image.texels()) texel = glm::fract(texel);
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) weights.at(x, y) = glm::vec4(x % 4 < 2 ? 1 : 0);
    ASSERT_TRUE(formats::writeExr(folder_ / "in.exr", image.view(), 4).has_value());
    ASSERT_TRUE(formats::writeExr(folder_ / "weights.exr", weights.view(), 3).has_value());
    const std::string together = "bc1, bc3, bc6h-uf16, bc6h-sf16, bc7, astc-4x4-hdr, astc-6x6-hdr, astc-8x8-hdr, astc-4x4-ldr or rgb9e5";
    const std::string blocks =
        "bc1, bc3, bc4, bc4-snorm, bc5, bc5-snorm, bc6h-uf16, bc6h-sf16, bc7, astc-4x4-hdr, astc-6x6-hdr, astc-8x8-hdr or astc-4x4-ldr";
    for (const formats::PixelFormatInfo& format : formats::allPixelFormats()) {
        const std::string name(format.name), found = fmt::format(": found it with --format {}, which codes each ", name);
        SCOPED_TRACE(name);
        const EncodeCommand plain = command(name.c_str());
        EncodeCommand channels = plain, perceptual = plain, texels = plain;
        channels.channelWeights = std::array<float, 4>{8, 1, 1, 1};
        perceptual.perceptual = true;
        texels.significance = folder_ / "weights.exr";
        const Image<glm::vec4> reference = coded(plain);
        if (together.find(name) != std::string::npos) {
            EXPECT_NE(coded(channels).texels(), reference.texels());
            EXPECT_NE(coded(perceptual).texels(), reference.texels());
        } else {
            std::filesystem::remove(plain.output);
            expectRefused(channels, ErrorCode::InvalidRequest, "--weights" + found + "channel by itself, expected --format " + together);
            expectRefused(perceptual, ErrorCode::InvalidRequest,
                          format.channelCount < 3 ? "--perceptual: found format " + name + ", which holds no colour"
                                                  : "--perceptual" + found + "channel by itself, expected --format " + together);
        }
        if (blocks.find(name) != std::string::npos) {
            EXPECT_NE(coded(texels).texels(), reference.texels());
        } else {
            std::filesystem::remove(plain.output);
            expectRefused(texels, ErrorCode::InvalidRequest, "--significance" + found + "texel by itself, expected --format " + blocks);
        }
        std::filesystem::remove(plain.output);
    }
    EncodeCommand rows = command("bc5"), weighted = rows;
    rows.rdo = weighted.rdo = 0.5;
    weighted.channelWeights = std::array<float, 4>{1, 100, 0, 0};
    EXPECT_NE(coded(weighted).texels(), coded(rows).texels()) << "a row is within a bound on the error of both channels";
}

TEST(EncodeTexture, WrongRequestsAreRefused) {
    const formats::TemporaryFolder folder;
    ASSERT_TRUE(formats::writeExr(folder / "in.exr", gradientImage(8, 8).view(), 3).has_value());
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
    ASSERT_TRUE(formats::writeExr(folder / "in.exr", gradientImage(8, 48).view(), 3).has_value());
    const EncodeCommand command{folder / "in.exr", folder / "out.ktx2", "rgba16f", {}, true, true, false};
    const auto facts = encodeTexture(command, 1);
    ASSERT_TRUE(facts.has_value());
    EXPECT_EQ(facts->at("faces"), 6);
    EXPECT_EQ(describeFile(command.output)->at("faces"), 6);
    EXPECT_LT(differenceOf(command.input, command.output)->at("max_abs").get<double>(), 1e-3);
}

}  // namespace
}  // namespace lightcook::pipeline

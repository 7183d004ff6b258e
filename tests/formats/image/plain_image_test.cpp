#include "formats/plain_image.h"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>
#include <bit>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "formats/image/image_module.h"
#include "tests/formats/exr_fixture.h"
#include "tests/formats/picture_fixture.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::formats {
namespace {

TEST(WriteExr, ReadsBackBitForBit) {
    const TemporaryFolder folder;
    Image<glm::vec4> texels(37, 23);
    for (int y = 0; y < 23; ++y) {
        for (int x = 0; x < 37; ++x)
            texels.at(x, y) = {static_cast<float>(x) / 3.0f, -static_cast<float>(y), 1e-30f * static_cast<float>(x), 3e38f};
    }
    for (const int channelCount : {1, 2, 3, 4}) {
        const auto written = writeExr(folder / "a.exr", texels.view(), channelCount);
        ASSERT_TRUE(written) << written.error().line();
        const auto read = readImage(folder / "a.exr");
        ASSERT_TRUE(read) << read.error().line();
        EXPECT_EQ(read->channelCount, channelCount);
        for (int y = 0; y < 23; ++y) {
            for (int x = 0; x < 37; ++x) {
                glm::vec4 expected(0, 0, 0, 1);
                for (int channel = 0; channel < channelCount; ++channel) expected[channel] = texels.at(x, y)[channel];
                ASSERT_EQ(read->texels.at(x, y), expected) << x << ' ' << y << " of " << channelCount;
            }
        }
    }
    EXPECT_FALSE(writeExr(folder / "absent" / "a.exr", texels.view(), 3));
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

TEST(ReadImage, EightBitsBecomeUnitsAndAlphaMultipliesNothing) {
    const TemporaryFolder folder;
    constexpr std::array<int, 4> kBytes = {255, 51, 0, 102};
    writePng(folder / "a.png", 1, 1, 4, [&](int channel, int, int) { return kBytes[static_cast<std::size_t>(channel)]; });
    const auto read = readImage(folder / "a.png");
    ASSERT_TRUE(read) << read.error().line();
    EXPECT_EQ(read->texels.at(0, 0), glm::vec4(1, 0.2f, 0, 0.4f));
}

TEST(ReadImage, GreyIsInRedGreenAndBlue) {
    const TemporaryFolder folder;
    writePng(folder / "grey.png", 2, 1, 1, [](int, int x, int) { return 51 + 102 * x; });
    const auto read = readImage(folder / "grey.png");
    ASSERT_TRUE(read) << read.error().line();
    EXPECT_EQ(read->channelCount, 1);
    for (int x = 0; x < 2; ++x)
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(read->texels.at(x, 0)[c], 0.2f + 0.4f * static_cast<float>(x), 1e-6f);
    EXPECT_EQ(read->texels.at(0, 0).a, 1);
}

/// What differs between the image as read with and without OpenImageIO; empty if nothing does.
std::string differenceToOpenImageIo(const std::filesystem::path& file) {
    const auto own = readImage(file);
    const auto module = imageModule();
    if (!own || !module) return own ? module.error().line() : own.error().line();
    const auto theirs = (*module)->readImage(file);
    if (!theirs) return theirs.error().line();
    if (own->channelCount != theirs->channelCount) return fmt::format("{} and {} channels", own->channelCount, theirs->channelCount);
    if (own->texels.width() != theirs->texels.width() || own->texels.height() != theirs->texels.height()) return "size";
    for (int y = 0; y < own->texels.height(); ++y)
        for (int x = 0; x < own->texels.width(); ++x)
            for (int c = 0; c < 4; ++c) {
                const float a = own->texels.at(x, y)[c], b = theirs->texels.at(x, y)[c];
                // OpenImageIO multiplies codes by a rounded 1 / 255: an ulp.
                if (!(std::abs(a - b) <= 1.2e-7f * std::abs(b))) return fmt::format("{} and {} in channel {} of ({}, {})", a, b, c, x, y);
            }
    return "";
}

TEST(ReadImage, ExrHasTheTexelsThatOpenImageIoReads) {
    const TemporaryFolder folder;
    for (const std::vector<const char*>& channels : std::vector<std::vector<const char*>>{{"R", "G", "B"},
                                                                                          {"R", "G", "B", "A"},
                                                                                          {"R"},
                                                                                          {"R", "A"},
                                                                                          {"G"},
                                                                                          {"A"},
                                                                                          {"R", "G", "B", "Z"},
                                                                                          {"Y"},
                                                                                          {"r", "g", "b"},
                                                                                          {"Y", "A"}})
        for (const bool isHalf : {false, true}) {
            ExrRecipe recipe;
            recipe.isHalf = isHalf;
            recipe.isTiled = channels.size() == 4;
            for (const char* channel : channels)
                recipe.channels[channel] = [channel](int x, int y) { return static_cast<float>((channel[0] - 'M') * (x + 8 * y)) / 4; };
            writeRecipe(folder / "a.exr", recipe);
            EXPECT_EQ(differenceToOpenImageIo(folder / "a.exr"), "") << channels.front() << ' ' << channels.size();
        }
}

TEST(ReadImage, RadianceHasTheTexelsThatOpenImageIoReads) {
    const TemporaryFolder folder;
    const auto output = OIIO::ImageOutput::create("a.hdr");
    std::vector<float> values;
    for (int i = 0; i < 3 * 20 * 5; ++i) values.push_back(std::ldexp(static_cast<float>(i % 17), i % 23 - 11));
    ASSERT_TRUE(output->open((folder / "a.hdr").string(), OIIO::ImageSpec(20, 5, 3, OIIO::TypeDesc::FLOAT)));
    ASSERT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, values.data()) && output->close());
    EXPECT_EQ(differenceToOpenImageIo(folder / "a.hdr"), "");
}

TEST(ReadImage, APngIsKnownByItsContent) {
    const TemporaryFolder folder;
    writePng(folder / "a.tga", 3, 2, 3, [](int channel, int x, int y) { return 20 * x + 5 * y + channel; });
    const auto image = readImage(folder / "a.tga");
    ASSERT_TRUE(image) << image.error().line();
    EXPECT_EQ(image->texels.at(2, 1), glm::vec4(45, 46, 47, 255) / 255.0f);
}

TEST(ReadImage, AFileOfNoImageFormatIsNamedByItsExtension) {
    const TemporaryFolder folder;
    for (const auto& [name, words] : {std::pair{"a.json", "found a file of the extension '.json', whose content is no image, expected an"},
                                      std::pair{"a", "found a file without an extension, whose content is no image, expected an image"},
                                      std::pair{"a.exr", "is not an OpenEXR file"}}) {
        writeContent(folder / name, "{}");
        const auto image = readImage(folder / name);
        ASSERT_FALSE(image) << name;
        EXPECT_EQ(image.error().code, ErrorCode::FileUnreadable);
        EXPECT_THAT(image.error().line(), testing::HasSubstr(words));
    }
}

}  // namespace
}  // namespace lightcook::formats

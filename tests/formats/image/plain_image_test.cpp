#include "formats/plain_image.h"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
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
    const auto theirs = (*module)->readImage(file, nullptr);
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

/// Returns a file whose channels have a value of their own at each texel.
ExrRecipe exrOf(const std::vector<std::string>& channels) {
    ExrRecipe recipe;
    for (std::size_t i = 0; i < channels.size(); ++i)
        recipe.channels[channels[i]] = [i](int x, int y) { return static_cast<float>(100 * (i + 1)) + static_cast<float>(x + 8 * y); };
    return recipe;
}

TEST(ReadImage, ExrHasTheTexelsThatOpenImageIoReads) {
    const TemporaryFolder folder;
    for (const std::vector<std::string>& channels : std::vector<std::vector<std::string>>{
             {"R", "G", "B"}, {"R", "G", "B", "A"}, {"R"}, {"R", "G"}, {"Y"}, {"r", "g", "b"}, {"Y", "A"}})
        for (const bool isHalf : {false, true}) {
            ExrRecipe recipe = exrOf(channels);
            recipe.isHalf = isHalf;
            recipe.isTiled = channels.size() == 4;
            writeRecipe(folder / "a.exr", recipe);
            EXPECT_EQ(differenceToOpenImageIo(folder / "a.exr"), "") << channels.front() << ' ' << channels.size();
        }
}

/// Each channel is 100 times the place of its name in the list.
TEST(ReadImage, ChannelsOfAnExrAreFoundByName) {
    const TemporaryFolder folder;
    struct Case {
        std::vector<std::string> channels;
        glm::vec4 texel;
        int count;
        std::vector<std::string> ignored;
    };
    for (const Case& each :
         {Case{{"R", "G", "B", "Z"}, {100, 200, 300, 1}, 3, {"Z"}},
          Case{{"Z", "R", "A", "B", "G", "id"}, {200, 500, 400, 300}, 4, {"Z", "id"}}, Case{{"Y", "Z"}, {100, 100, 100, 1}, 1, {"Z"}},
          Case{{"A", "Y", "Z"}, {200, 200, 200, 100}, 2, {"Z"}}, Case{{"R", "Y"}, {100, 0, 0, 1}, 1, {"Y"}},
          Case{{"R", "A"}, {100, 0, 0, 200}, 2, {}}, Case{{"G"}, {0, 100, 0, 1}, 1, {}}, Case{{"A"}, {0, 0, 0, 100}, 1, {}},
          Case{{"weight"}, {100, 100, 100, 1}, 1, {}},
          Case{{"B", "G", "R", "normal.X", "normal.Y", "normal.Z"}, {300, 200, 100, 1}, 3, {"normal.X", "normal.Y", "normal.Z"}},
          Case{{"Layer.Combined.R", "Layer.Combined.G", "Layer.Combined.B", "Layer.Combined.A", "Layer.Depth.Z"},
               {100, 200, 300, 400},
               4,
               {"Layer.Depth.Z"}}}) {
        SCOPED_TRACE(each.channels.front());
        writeRecipe(folder / "a.exr", exrOf(each.channels));
        const auto image = readImage(folder / "a.exr");
        ASSERT_TRUE(image) << image.error().line();
        EXPECT_EQ(image->texels.at(0, 0), each.texel);
        EXPECT_EQ(image->channelCount, each.count);
        EXPECT_EQ(image->hasAlpha, std::ranges::find(each.channels, "A") != each.channels.end() || each.count == 4);
        EXPECT_EQ(image->ignored, each.ignored);
    }
}

TEST(ReadImage, ChannelsThatAreNoColoursAreRefusedByName) {
    const TemporaryFolder folder;
    for (const auto& [channels, words] : std::vector<std::pair<std::vector<std::string>, std::string>>{
             {{"X", "Y", "Z"}, "a.exr: found the channels X, Y, Z, expected R, G and B, or Y for grey"},
             {{"Y", "RY", "BY"}, "a.exr: found the channels BY, RY, Y, expected R, G and B"},
             {{"N.x", "N.y"}, "a.exr: found the channels N.x, N.y, expected"},
             {{"beauty.R", "beauty.G", "beauty.B", "mist.R", "mist.G", "mist.B"},
              "a.exr: found the layers beauty, mist, expected the channels R, G and B, or those of one layer. Take one out: oiiotool "
              "in.exr --ch "
              "R=beauty.R,G=beauty.G,B=beauty.B -o out.exr"}}) {
        writeRecipe(folder / "a.exr", exrOf(channels));
        const auto image = readImage(folder / "a.exr");
        ASSERT_FALSE(image) << channels.front();
        EXPECT_EQ(image.error().code, ErrorCode::WrongShape);
        EXPECT_THAT(image.error().line(), testing::HasSubstr(words));
    }
}

std::string littleEndian(std::uint32_t value, int bytes = 4) {
    std::string text;
    for (int i = 0; i < bytes; ++i) text += static_cast<char>(value >> (8 * i) & 0xff);
    return text;
}

/// Returns a BMP of 2 x 1 texels.
/// masks  behind the first 40 bytes of the header
std::string bmpOf(std::uint32_t headerBytes, std::uint32_t bits, std::uint32_t compression, const std::vector<std::uint32_t>& masks,
                  const std::string& texels, std::int32_t height = 1) {
    std::string header = littleEndian(headerBytes) + littleEndian(2) + littleEndian(static_cast<std::uint32_t>(height)) +
                         littleEndian(1, 2) + littleEndian(bits, 2) + littleEndian(compression) + littleEndian(0) + littleEndian(0) +
                         littleEndian(0) + littleEndian(0) + littleEndian(0);
    for (const std::uint32_t mask : masks) header += littleEndian(mask);
    header.resize(std::max<std::size_t>(header.size(), headerBytes), '\0');
    const auto at = static_cast<std::uint32_t>(14 + header.size());
    std::string file =
        "BM" + littleEndian(at + static_cast<std::uint32_t>(texels.size())) + littleEndian(0) + littleEndian(at) + header + texels;
    return file;
}

TEST(ReadImage, ABmpHasTheAlphaOfItsMaskAndNoOther) {
    const TemporaryFolder folder;
    const std::string bgra("\x0a\x14\xc8\0\xff\x00\x33\x66", 8);
    const glm::vec4 first = glm::vec4(200, 20, 10, 255) / 255.0f, second = glm::vec4(51, 0, 255, 255) / 255.0f;
    struct Case {
        const char* name;
        std::string content;
        int channels;
        std::array<glm::vec4, 2> texels;
    };
    const std::vector<std::uint32_t> bgr = {0xff0000, 0xff00, 0xff};
    for (const Case& each :
         {Case{"BI_RGB", bmpOf(40, 32, 0, {}, bgra), 3, {first, second}},
          Case{"BI_RGB of version 5", bmpOf(124, 32, 0, {0xff0000, 0xff00, 0xff, 0xff000000}, bgra), 3, {first, second}},
          Case{"masks behind the header", bmpOf(40, 32, 3, bgr, bgra), 3, {first, second}},
          Case{"version 4 without alpha", bmpOf(108, 32, 3, {0xff0000, 0xff00, 0xff, 0}, bgra), 3, {first, second}},
          Case{"version 4 with alpha",
               bmpOf(108, 32, 3, {0xff0000, 0xff00, 0xff, 0xff000000}, bgra),
               4,
               {glm::vec4(200, 20, 10, 0) / 255.0f, glm::vec4(51, 0, 255, 102) / 255.0f}},
          Case{"another order",
               bmpOf(108, 32, 3, {0xff, 0xff00, 0xff0000, 0xff000000}, bgra),
               4,
               {glm::vec4(10, 20, 200, 0) / 255.0f, glm::vec4(255, 0, 51, 102) / 255.0f}},
          Case{"ten bits",
               bmpOf(108, 32, 3, {0x3ff00000, 0xffc00, 0x3ff, 0xc0000000}, std::string("\xff\x03\0\x40\0\0\0\0", 8)),
               4,
               {glm::vec4(0, 0, 1, 1 / 3.0f), glm::vec4(0)}},
          Case{"16 bits", bmpOf(40, 16, 0, {}, std::string("\x00\x7c\x1f\x80", 4)), 3, {glm::vec4(1, 0, 0, 1), glm::vec4(0, 0, 1, 1)}}}) {
        SCOPED_TRACE(each.name);
        writeContent(folder / "a.bmp", each.content);
        const auto image = readImage(folder / "a.bmp");
        ASSERT_TRUE(image) << image.error().line();
        EXPECT_EQ(image->channelCount, each.channels);
        EXPECT_EQ(image->hasAlpha, each.channels == 4);
        for (int x = 0; x < 2; ++x)
            for (int c = 0; c < 4; ++c)
                EXPECT_NEAR(image->texels.at(x, 0)[c], each.texels[static_cast<std::size_t>(x)][c], 1e-7f) << x << c;
    }
    std::string rows(16, '\0');
    rows[2] = '\xff';  // red of the first texel in the file
    writeContent(folder / "a.bmp", bmpOf(40, 32, 0, {}, rows, 2));
    EXPECT_EQ(readImage(folder / "a.bmp")->texels.at(0, 1).r, 1);
    writeContent(folder / "a.bmp", bmpOf(40, 32, 0, {}, rows, -2));
    EXPECT_EQ(readImage(folder / "a.bmp")->texels.at(0, 0).r, 1);
    writeContent(folder / "a.bmp", bmpOf(124, 32, 0, {}, "four"));
    EXPECT_THAT(readImage(folder / "a.bmp").error().line(), testing::HasSubstr("found 142 bytes, expected a BMP of 146: truncated"));
}

TEST(ReadImage, ATgaHasTheAlphaThatItsHeaderCounts) {
    const TemporaryFolder folder;
    for (const int alphaBits : {0, 8}) {
        std::string content(18, '\0');
        content[2] = 2;  // true colours, not compressed
        content[12] = content[14] = 1;
        content[16] = 32;
        content[17] = static_cast<char>(0x20 | alphaBits);
        writeContent(folder / "a.tga", content + std::string("\x0a\x14\xc8\x33", 4));
        const auto image = readImage(folder / "a.tga");
        ASSERT_TRUE(image) << image.error().line();
        EXPECT_EQ(image->channelCount, alphaBits == 0 ? 3 : 4);
        EXPECT_EQ(image->hasAlpha, alphaBits != 0);
        EXPECT_NEAR(image->texels.at(0, 0).r, 200 / 255.0f, 1e-6f);
        EXPECT_NEAR(image->texels.at(0, 0).a, alphaBits == 0 ? 1 : 0.2f, 1e-6f);
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

/// Refused by the size of the file, before gigabytes are allocated.
TEST(ReadImage, AFileHoldsItsTexels) {
    const TemporaryFolder folder;
    std::string tga(18, '\0');
    tga[2] = 10;                                             // runs of true colours
    tga[12] = tga[14] = '\x40', tga[13] = tga[15] = '\x1f';  // 8000 x 8000
    tga[16] = 32;
    for (const auto& [name, content] : {std::pair<const char*, std::string>("a.tga", tga + std::string(40, '\xff')),
                                        {"a.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 10000 +X 20000\n" + std::string(2000, '\1')}}) {
        writeContent(folder / name, content);
        const auto image = readImage(folder / name);
        ASSERT_FALSE(image);
        EXPECT_THAT(image.error().line(), testing::HasSubstr(fmt::format("{}: found {} bytes, expected more for ", name, content.size())));
    }
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

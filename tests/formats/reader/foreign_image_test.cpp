// Images of OpenImageIO behind the wall: every format that it writes is read as in this process, though its readers open files by name.
#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "formats/foreign_files.h"
#include "formats/image/image_module.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::formats {
namespace {

TEST(ForeignImages, AreThoseOfThisProcess) {
    const TemporaryFolder folder;
    constexpr int kWidth = 70, kHeight = 41;
    std::vector<std::uint8_t> texels;
    for (int i = 0; i < kWidth * kHeight * 3; ++i) texels.push_back(static_cast<std::uint8_t>(i * 7 % 251));
    int readCount = 0;
    for (const std::string extension :
         {"tif", "jpg", "tga", "bmp", "ppm", "sgi", "dpx", "gif", "webp", "jp2", "pnm", "iff", "rla", "cin", "zfile", "txt"}) {
        SCOPED_TRACE(extension);
        const auto file = folder / ("a." + extension);
        const std::string writes = extension == "txt" ? (folder / "a.tif").string() : file.string();  // found by its content
        const auto out = OIIO::ImageOutput::create(writes);
        if (!out || !out->open(writes, OIIO::ImageSpec(kWidth, kHeight, 3, OIIO::TypeDesc::UINT8)) ||
            !out->write_image(OIIO::TypeDesc::UINT8, texels.data()) || !out->close())
            continue;
        if (extension == "txt") std::filesystem::copy_file(writes, file);
        const auto module = imageModule();
        ASSERT_TRUE(module) << module.error().line();
        const auto here = (*module)->readImage(file, nullptr);
        readInChildProcesses({.program = LIGHTCOOK_READ});
        const auto there = readImageByModule(file);
        ASSERT_EQ(here.has_value(), there.has_value()) << (here ? there : here).error().line();
        if (!here) {
            EXPECT_EQ(here.error().line(), there.error().line());
            continue;
        }
        ++readCount;
        EXPECT_EQ(here->texels.texels(), there->texels.texels());
        EXPECT_EQ(here->channelCount, there->channelCount);
        EXPECT_EQ(here->hasAlpha, there->hasAlpha);
    }
    EXPECT_GE(readCount, 9);
}

/// OpenImageIO 2.4.7 of Debian 12 writes past a buffer when it reads an icon whose width is no multiple of 8.
TEST(ForeignImages, IconsHarmTheirReaderAlone) {
    const TemporaryFolder folder;
    const std::string file = (folder / "a.ico").string();
    const auto out = OIIO::ImageOutput::create(file);
    const std::vector<std::uint8_t> texels(70 * 41 * 3);
    ASSERT_TRUE(out && out->open(file, OIIO::ImageSpec(70, 41, 3, OIIO::TypeDesc::UINT8)) &&
                out->write_image(OIIO::TypeDesc::UINT8, texels.data()) && out->close());
    readInChildProcesses({.program = LIGHTCOOK_READ});
    const auto image = readImageByModule(file);
    EXPECT_THAT(image ? "found content on which its reader " : image.error().line(),
                testing::HasSubstr("found content on which its reader "));
}

TEST(ForeignImages, ErrorsAreThoseOfThisProcess) {
    const TemporaryFolder folder;
    const auto module = imageModule();
    ASSERT_TRUE(module) << module.error().line();
    readInChildProcesses({.program = LIGHTCOOK_READ});
    for (const auto& [name, content] :
         {std::pair("a.tif", "II*"), std::pair("a.jpg", "no image"), std::pair("a.dat", "no image"), std::pair("a.tga", "")}) {
        writeContent(folder / name, content);
        const auto here = (*module)->readImage(folder / name, nullptr);
        const auto there = readImageByModule(folder / name);
        ASSERT_FALSE(here || there) << name;
        EXPECT_EQ(here.error().line(), there.error().line());
    }
    EXPECT_EQ(readImageByModule(folder / "none.jpg").error().line(), (*module)->readImage(folder / "none.jpg", nullptr).error().line());
}

}  // namespace
}  // namespace lightcook::formats

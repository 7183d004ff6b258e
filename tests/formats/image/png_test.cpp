#include "formats/png.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "formats/image/image_module.h"
#include "formats/read_file.h"
#include "tests/formats/picture_fixture.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::formats {
namespace {

using testing::HasSubstr;

TEST(EncodePng, DecodesToTheSameTexelsAndTheSameBytesTwice) {
    Image<glm::u8vec3> wide(20, 10);
    for (int y = 0; y < 10; ++y) {
        for (int x = 0; x < 20; ++x) wide.at(x, y) = glm::u8vec3(x * 12, y * 25, x ^ y);
    }
    const ImageView<const glm::u8vec3> part{wide.texels().data() + 20 + 2, 9, 7, 20};  // a view with gaps between its rows
    const auto png = encodePng(part);
    ASSERT_TRUE(png) << png.error().line();
    EXPECT_EQ(*encodePng(part), *png);
    const auto read = decodePng(*png, "a picture");
    ASSERT_TRUE(read) << read.error().line();
    ASSERT_EQ(read->texels.width(), 9);
    ASSERT_EQ(read->texels.height(), 7);
    for (int y = 0; y < 7; ++y) {
        for (int x = 0; x < 9; ++x) {
            for (int channel = 0; channel < 3; ++channel)
                EXPECT_EQ(std::lround(read->texels.at(x, y)[channel] * 255.0f), part.at(x, y)[channel]);
        }
    }
    EXPECT_FALSE(encodePng(ImageView<const glm::u8vec3>{}));
}

/// A kind of PNG that another program may write.
struct PngKind {
    int colourType, bitDepth;
    bool isInterlaced = false, hasTransparentColour = false;
};

/// Writes 13 x 7 texels of seeded bits by libpng.
void writeKind(const std::filesystem::path& file, const PngKind& kind) {
    constexpr int kWidth = 13, kHeight = 7;
    std::FILE* const stream = std::fopen(file.c_str(), "wb");
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png_create_info_struct(png);
    png_init_io(png, stream);
    png_set_IHDR(png, info, kWidth, kHeight, kind.bitDepth, kind.colourType, kind.isInterlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    std::array<png_color, 16> palette{};
    for (std::size_t i = 0; i < palette.size(); ++i)
        palette.at(i) = {static_cast<png_byte>(17 * i), static_cast<png_byte>(255 - 9 * i), static_cast<png_byte>(3 * i)};
    if (kind.colourType == PNG_COLOR_TYPE_PALETTE) png_set_PLTE(png, info, palette.data(), 1 << kind.bitDepth);
    const std::array<png_byte, 4> alphas = {0, 80, 160, 240};
    const png_color_16 colour{.index = 0, .red = 1, .green = 2, .blue = 3, .gray = 1};
    if (kind.hasTransparentColour) png_set_tRNS(png, info, alphas.data(), kind.colourType == PNG_COLOR_TYPE_PALETTE ? 4 : 0, &colour);
    std::vector<std::vector<png_byte>> rows(kHeight, std::vector<png_byte>(kWidth * 8));
    unsigned seed = 1;
    for (auto& row : rows)
        for (png_byte& byte : row) {
            seed = seed * 1664525 + 1013904223;
            byte = static_cast<png_byte>(seed >> 24);
        }
    std::vector<png_bytep> starts;
    for (auto& row : rows) starts.push_back(row.data());
    png_write_info(png, info);
    png_write_image(png, starts.data());
    png_write_end(png, info);
    png_destroy_write_struct(&png, &info);
    std::fclose(stream);
}

TEST(DecodePng, EveryKindHasTheTexelsThatOpenImageIoReads) {
    const TemporaryFolder folder;
    const auto module = imageModule();
    ASSERT_TRUE(module) << module.error().line();
    std::vector<PngKind> kinds;
    for (const int depth : {1, 2, 4, 8, 16}) kinds.push_back({PNG_COLOR_TYPE_GRAY, depth});
    for (const int depth : {1, 2, 4}) kinds.push_back({PNG_COLOR_TYPE_PALETTE, depth});
    for (const int depth : {8, 16})
        for (const int type : {PNG_COLOR_TYPE_GRAY_ALPHA, PNG_COLOR_TYPE_RGB, PNG_COLOR_TYPE_RGB_ALPHA}) kinds.push_back({type, depth});
    kinds.push_back({PNG_COLOR_TYPE_PALETTE, 4, false, true});
    kinds.push_back({PNG_COLOR_TYPE_RGB, 8, false, true});
    kinds.push_back({PNG_COLOR_TYPE_RGB, 16, true});
    kinds.push_back({PNG_COLOR_TYPE_GRAY, 1, true});
    for (const PngKind& kind : kinds) {
        SCOPED_TRACE(fmt::format("colour type {}, {} bits, interlaced {}", kind.colourType, kind.bitDepth, kind.isInterlaced));
        writeKind(folder / "a.png", kind);
        const auto own = decodePng(*readWholeFile(folder / "a.png"), "a.png");
        const auto theirs = (*module)->readImage(folder / "a.png", nullptr);
        ASSERT_TRUE(own) << own.error().line();
        ASSERT_TRUE(theirs) << theirs.error().line();
        EXPECT_EQ(own->channelCount, theirs->channelCount);
        ASSERT_EQ(own->texels.texels().size(), theirs->texels.texels().size());
        for (std::size_t i = 0; i < own->texels.texels().size(); ++i)
            for (int c = 0; c < 4; ++c) ASSERT_NEAR(own->texels.texels()[i][c], theirs->texels.texels()[i][c], 1e-7f) << i << ", " << c;
    }
}

TEST(DecodePng, ADamagedFileIsRefusedInOneLine) {
    const TemporaryFolder folder;
    writeKind(folder / "a.png", {PNG_COLOR_TYPE_RGB_ALPHA, 8});
    const std::vector<std::byte> whole = *readWholeFile(folder / "a.png");
    ASSERT_TRUE(decodePng(whole, "a.png"));
    testing::internal::CaptureStderr();
    for (std::size_t length = 0; length < whole.size(); ++length) {
        const auto image = decodePng(std::span(whole).first(length), "a.png");
        ASSERT_FALSE(image) << length;
        EXPECT_THAT(image.error().line(), testing::MatchesRegex("a\\.png: found .*, expected .*")) << length;
    }
    constexpr std::size_t kSignatureBytes = 8;
    for (std::size_t at = kSignatureBytes; at < whole.size(); ++at) {
        std::vector<std::byte> damaged = whole;
        damaged[at] ^= std::byte{0x20};
        const auto image = decodePng(damaged, "a.png");
        ASSERT_FALSE(image) << at;
        EXPECT_EQ(image.error().code, ErrorCode::FileUnreadable) << at;
    }
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "libpng writes errors there by itself";
}

TEST(DecodePng, AnImageThatIsTooLargeIsRefusedBeforeItsTexelsAreRead) {
    const std::string header = bigEndian(70000) + bigEndian(4) + std::string("\x08\x06\0\0\0", 5);
    const std::string file = "\x89PNG\r\n\x1a\n" + pngChunk("IHDR", header) + pngChunk("IDAT", "x") + pngChunk("IEND", "");
    const auto image = decodePng(std::as_bytes(std::span(file)), "a.png");
    ASSERT_FALSE(image);
    EXPECT_THAT(image.error().line(), HasSubstr("a.png: found 70000 x 4 texels of 4 channels, expected 1 to 65536 a side"));
}

/// A byte of Deflate stands for at most 1032.
TEST(DecodePng, AFileHoldsItsTexels) {
    const auto errorOf = [](std::uint32_t width, std::uint32_t height, char bits, char colours) {
        const std::string header = bigEndian(width) + bigEndian(height) + bits + colours + std::string(3, '\0');
        const std::string file =
            "\x89PNG\r\n\x1a\n" + pngChunk("IHDR", header) + pngChunk("IDAT", std::string(40, 'x')) + pngChunk("IEND", "");
        const auto image = decodePng(std::as_bytes(std::span(file)), "a.png");
        return image ? "" : image.error().line();
    };
    EXPECT_EQ(errorOf(20000, 10000, 16, 6),
              "a.png: found 97 bytes, expected more for 1600000000 bytes of texels: truncated, or a broken header");
    EXPECT_THAT(errorOf(800, 1000, 1, 0), HasSubstr("found a damaged PNG")) << "one bit a texel: it might be black";
}

}  // namespace
}  // namespace lightcook::formats

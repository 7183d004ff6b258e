// Headers of DDS and KTX2 files that other programs write: fields that contradict each other, sizes that do not fit, and formats that
// lightcook does not read.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "formats/gpu_texture.h"
#include "tests/formats/temporary_folder.h"
#include "tests/formats/texture_fixture.h"

namespace lightcook::formats {
namespace {

using testing::HasSubstr;

// Offsets in the header of a DDS file, and flags of its fields.
constexpr std::size_t kFlagsAt = 8, kMipCountAt = 28, kFormatFlagsAt = 80, kFourCcAt = 84, kCaps2At = 112, kDxgiAt = 128,
                      kDimensionAt = 132, kMiscAt = 136, kArraySizeAt = 140;
constexpr std::uint32_t kMipFlag = 0x20000, kDepthFlag = 0x800000, kCubeWithAllFaces = 0xfe00, kVolume = 0x200000;

class ForeignHeaders : public testing::Test {
protected:
    std::filesystem::path file() const { return folder_ / "texture"; }
    void write(const TextureShape& shape, Container container = Container::Dds) {
        TextureFileOptions options;
        options.container = container;
        const Result<void> written = writePattern(file(), shape, options);
        ASSERT_TRUE(written) << written.error().line();
        bytes_ = wholeFile(file());
    }
    std::uint32_t at(std::size_t offset) const {
        std::uint32_t value = 0;
        for (std::size_t i = 4; i-- > 0;) value = value << 8 | std::to_integer<std::uint32_t>(bytes_[offset + i]);
        return value;
    }
    void set(std::size_t offset, std::uint32_t value) {
        for (std::size_t i = 0; i < 4; ++i) bytes_[offset + i] = static_cast<std::byte>(value >> (8 * i) & 0xff);
        putFile(file(), bytes_);
    }
    void setFourCc(std::string_view text) {
        std::uint32_t value = 0;
        for (std::size_t i = 4; i-- > 0;) value = value << 8 | static_cast<unsigned char>(text[i]);
        set(kFourCcAt, value);
    }
    /// Expects the images of writePattern().
    void expectImages(const TextureShape& shape) const {
        const Result<TextureReader> reader = TextureReader::open(file());
        ASSERT_TRUE(reader) << reader.error().line();
        EXPECT_EQ(reader->shape().mipCount, shape.mipCount);
        EXPECT_EQ(reader->shape().faceCount, shape.faceCount);
        EXPECT_EQ(reader->shape().layerCount, shape.layerCount);
        for (const SubImage& image : allImages(shape)) {
            const auto bytes = reader->readImage(image);
            ASSERT_TRUE(bytes) << bytes.error().line();
            EXPECT_TRUE(*bytes == patternImage(shape, image)) << "mip " << image.mip << " layer " << image.layer << " face " << image.face;
        }
    }
    std::string refusal(ErrorCode code) const {
        const Result<TextureReader> reader = TextureReader::open(file());
        EXPECT_FALSE(reader);
        if (reader) return "";
        EXPECT_EQ(reader.error().code, code) << reader.error().line();
        return reader.error().line();
    }

    const TemporaryFolder folder_;
    std::vector<std::byte> bytes_;
};

TEST_F(ForeignHeaders, MipsCountWithoutTheirFlag) {
    for (const TextureShape& shape :
         {TextureShape{PixelFormat::Rgba8Unorm, 8, 8, 4, 1, false, 6}, TextureShape{PixelFormat::Bc7, 20, 9, 5, 3, true, 1},
          TextureShape{PixelFormat::Bc1, 16, 16, 3, 1, false, 6}, TextureShape{PixelFormat::Bc6hUf16, 37, 21, 6, 1, false, 1}}) {
        write(shape);
        ASSERT_NE(at(kFlagsAt) & kMipFlag, 0u);
        set(kFlagsAt, at(kFlagsAt) & ~kMipFlag);
        expectImages(shape);
    }
}

TEST_F(ForeignHeaders, ACountOfMipsThatNoFlagConfirmsMayBeWrong) {
    const TextureShape shape{PixelFormat::Rgba8Unorm, 8, 8, 1, 1, false, 6};
    write(shape);
    set(kMipCountAt, 4);
    expectImages(shape);
    set(kMipCountAt, 0);
    expectImages(shape);
    set(kMipCountAt, 4);
    set(kFlagsAt, at(kFlagsAt) | kMipFlag);
    EXPECT_THAT(refusal(ErrorCode::FileUnreadable),
                HasSubstr("found 1684 bytes, expected 2188 for what its header says: 8 x 8 texels of rgba8-unorm, "
                          "4 mips, 6 faces, 1 layer"));
}

TEST_F(ForeignHeaders, AnyOfTheTwoFieldsMakesACubemap) {
    const TextureShape cube{PixelFormat::Rgba16f, 8, 8, 4, 1, false, 6}, cubes{PixelFormat::Rgba16f, 8, 8, 1, 2, true, 6};
    for (const TextureShape& shape : {cube, cubes}) {
        write(shape);
        ASSERT_EQ(at(kCaps2At), kCubeWithAllFaces);
        set(kMiscAt, 0);
        expectImages(shape);
        set(kMiscAt, 4);
        set(kCaps2At, 0);
        expectImages(shape);
        for (const auto& [misc, caps2] : {std::pair{4u, 0u}, {0u, kCubeWithAllFaces}, {4u, kCubeWithAllFaces}}) {
            set(kMiscAt, misc);
            set(kCaps2At, caps2);
            set(kArraySizeAt, static_cast<std::uint32_t>(6 * shape.layerCount));  // some writers count faces
            expectImages(shape);
        }
    }
}

TEST_F(ForeignHeaders, EveryByteOfAFileIsAccountedFor) {
    const TextureShape shape{PixelFormat::Bc7, 16, 16, 3, 1, false, 6};
    write(shape);
    const std::size_t whole = bytes_.size();
    bytes_.resize(whole + 5);
    putFile(file(), bytes_);
    EXPECT_THAT(
        refusal(ErrorCode::FileUnreadable),
        HasSubstr("found " + std::to_string(whole + 5) + " bytes, expected " + std::to_string(whole) +
                  " for what its header says: 16 x 16 texels of bc7, 3 mips, 6 faces, 1 layer. If the rest is no part of it, cut it "
                  "off: truncate -s " +
                  std::to_string(whole) + " FILE"));
    bytes_.resize(whole - 1);
    putFile(file(), bytes_);
    EXPECT_THAT(refusal(ErrorCode::FileUnreadable), HasSubstr("found " + std::to_string(whole - 1) + " bytes, expected "));
    bytes_.resize(whole);
    set(kMipCountAt, 1);
    EXPECT_THAT(refusal(ErrorCode::FileUnreadable), HasSubstr("3 mips would fill it: correct dwMipMapCount (the 4 bytes at 28)"));
}

TEST_F(ForeignHeaders, OlderNamesOfOurFormatsAreRead) {
    for (const auto& [fourCc, format] : {std::pair{"ATI1", PixelFormat::Bc4},
                                         {"BC4U", PixelFormat::Bc4},
                                         {"BC4S", PixelFormat::Bc4Snorm},
                                         {"BC5U", PixelFormat::Bc5},
                                         {"BC5S", PixelFormat::Bc5Snorm},
                                         {"\x71\0\0\0", PixelFormat::Rgba16f},
                                         {"\x24\0\0\0", PixelFormat::Rgba16Unorm}}) {
        const TextureShape shape{format, 12, 8, 3, 1, false, 1};
        write(shape);
        bytes_.erase(bytes_.begin() + 128, bytes_.begin() + 148);  // the extension of Direct3D 10
        setFourCc(std::string_view(fourCc, 4));
        expectImages(shape);
        EXPECT_EQ(TextureReader::open(file())->shape().format, format);
    }
}

TEST_F(ForeignHeaders, FormatsThatAreNotReadAreNamed) {
    write({PixelFormat::Bc3, 8, 8, 1, 1, false, 1});
    for (const auto& [fourCc, words] : {std::pair{"ATI2", "found ATI2 (3Dc, an older form of BC5), expected DX10, DXT1, "},
                                        {"A2XY", "found A2XY (3Dc"},
                                        {"DXT2", "found DXT2 (BC2, premultiplied alpha)"},
                                        {"DXT3", "found DXT3 (BC2)"},
                                        {"DXT4", "texconv -f BC3_UNORM -alpha"},
                                        {"ETC1", "found ETC1"},
                                        {"\x74\0\0\0", "found A32B32G32R32F"},
                                        {"WXYZ", "found WXYZ"},
                                        {"\x99\1\0\0", "found 409"}}) {
        setFourCc(std::string_view(fourCc, 4));
        EXPECT_THAT(refusal(ErrorCode::FormatUnsupported), HasSubstr(words));
    }
    set(kFormatFlagsAt, 0x41);  // DDPF_RGB, DDPF_ALPHAPIXELS
    set(88, 32);
    EXPECT_THAT(refusal(ErrorCode::FormatUnsupported), HasSubstr("found uncompressed texels of 32 bits with masks of channels"));
    write({PixelFormat::Bc7, 8, 8, 1, 1, false, 1});
    for (const auto& [dxgi, name] : {std::pair{74u, "BC2_UNORM (74)"},
                                     {99u, "BC7_UNORM_SRGB (99)"},
                                     {87u, "B8G8R8A8_UNORM (87)"},
                                     {2u, "R32G32B32A32_FLOAT (2)"},
                                     {115u, "B4G4R4A4_UNORM (115)"},
                                     {4000u, "4000"}}) {
        set(kDxgiAt, dxgi);
        EXPECT_THAT(refusal(ErrorCode::FormatUnsupported),
                    HasSubstr("dxgiFormat: found " + std::string(name) + ", expected a format that"));
    }
}

TEST_F(ForeignHeaders, VolumesAndHalfCubesAreNamed) {
    write({PixelFormat::Bc7, 8, 8, 1, 1, false, 1});
    set(kDimensionAt, 4);
    EXPECT_THAT(refusal(ErrorCode::FormatUnsupported), HasSubstr("found a volume texture (4), expected 3 (2-D textures)"));
    set(kDimensionAt, 3);
    set(kCaps2At, kVolume);
    EXPECT_THAT(refusal(ErrorCode::FormatUnsupported), HasSubstr("found a volume texture, expected a 2-D texture"));
    set(kCaps2At, 0);
    set(kFlagsAt, at(kFlagsAt) | kDepthFlag);
    set(24, 8);
    EXPECT_THAT(refusal(ErrorCode::FormatUnsupported), HasSubstr("found a volume texture"));
    set(24, 1);
    set(kCaps2At, 0x600);
    EXPECT_THAT(refusal(ErrorCode::FormatUnsupported), HasSubstr("found 1 of the six faces of a cubemap, expected all six"));
}

TEST_F(ForeignHeaders, OfKtx2AreNamedWithWhatToDo) {
    write({PixelFormat::Bc7, 8, 8, 1, 1, false, 1}, Container::Ktx2);
    constexpr std::size_t kVkFormatAt = 12, kSchemeAt = 44, kDfdAt = 48;
    for (const auto& [vkFormat, name] : {std::pair{135u, "VK_FORMAT_BC2_UNORM_BLOCK (135)"},
                                         {146u, "VK_FORMAT_BC7_SRGB_BLOCK (146)"},
                                         {151u, "VK_FORMAT_ETC2_R8G8B8A8_UNORM_BLOCK (151)"},
                                         {184u, "VK_FORMAT_ASTC_12x12_SRGB_BLOCK (184)"},
                                         {109u, "VK_FORMAT_R32G32B32A32_SFLOAT (109)"},
                                         {44u, "VK_FORMAT_B8G8R8A8_UNORM (44)"},
                                         {64u, "VK_FORMAT_A2B10G10R10_UNORM_PACK32 (64)"},
                                         {1000066013u, "VK_FORMAT_ASTC_12x12_SFLOAT_BLOCK"},
                                         {77777u, "found 77777,"}}) {
        set(kVkFormatAt, vkFormat);
        EXPECT_THAT(refusal(ErrorCode::FormatUnsupported), HasSubstr(name));
    }
    set(kVkFormatAt, 0);
    EXPECT_THAT(refusal(ErrorCode::FormatUnsupported), HasSubstr("found VK_FORMAT_UNDEFINED (0), expected"));
    const std::size_t model = at(kDfdAt) + 12;
    bytes_[model] = std::byte{166};
    set(kVkFormatAt, 0);
    EXPECT_THAT(refusal(ErrorCode::FormatUnsupported),
                HasSubstr("found UASTC of Basis Universal, expected a format of GPUs. Transcode it first: "
                          "ktx transcode --target rgba8 in.ktx2 out.ktx2"));
    bytes_[model] = std::byte{163};
    set(kVkFormatAt, 0);
    EXPECT_THAT(refusal(ErrorCode::FormatUnsupported), HasSubstr("found ETC1S of Basis Universal"));
    set(kVkFormatAt, 145);
    set(kSchemeAt, 3);
    EXPECT_THAT(refusal(ErrorCode::FormatUnsupported), HasSubstr("found ZLIB (3), expected none (0) or Zstandard (2)"));
    writeContent(file(), "\xabKTX 11\xbb\r\n\x1a\n and more");
    EXPECT_THAT(refusal(ErrorCode::FormatUnsupported), HasSubstr("found a file of KTX 1, expected KTX2 or DDS"));
}

TEST_F(ForeignHeaders, TheContainerSaysWhetherBc1HasAlpha) {
    const TextureShape shape{PixelFormat::Bc1, 8, 8, 1, 1, false, 1};
    write(shape);
    EXPECT_TRUE(TextureReader::open(file())->hasBc1Alpha());
    write(shape, Container::Ktx2);
    EXPECT_FALSE(TextureReader::open(file())->hasBc1Alpha());
    set(12, 133);  // VK_FORMAT_BC1_RGBA_UNORM_BLOCK
    expectImages(shape);
    EXPECT_TRUE(TextureReader::open(file())->hasBc1Alpha());
    write({PixelFormat::Bc3, 8, 8, 1, 1, false, 1});
    EXPECT_FALSE(TextureReader::open(file())->hasBc1Alpha());
}

}  // namespace
}  // namespace lightcook::formats

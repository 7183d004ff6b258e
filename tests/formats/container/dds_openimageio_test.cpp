// Our DDS files, read by OpenImageIO. It takes BC1, BC3 (legacy FourCC), BC4, BC5, BC6H and BC7; plain textures and cubemaps, with mips; of
// arrays only the first slice. verify's tests compare texels; here each image is one grey of its own, which shows order and place.
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <cmath>

#include "formats/file/file_bytes.h"
#include "formats/gpu_texture.h"
#include "tests/formats/temporary_folder.h"
#include "tests/formats/texture_fixture.h"

namespace lightcook::formats {
namespace {

constexpr std::array kReadable = {PixelFormat::Bc1,      PixelFormat::Bc3,      PixelFormat::Bc4, PixelFormat::Bc5,
                                  PixelFormat::Bc6hUf16, PixelFormat::Bc6hSf16, PixelFormat::Bc7};

/// Bits from the lowest up.
class BlockWriter {
public:
    explicit BlockWriter(int bytes) : bytes_(static_cast<std::size_t>(bytes)) {}
    void put(std::uint32_t value, int count) {
        for (int i = 0; i < count; ++i, ++at_)
            if ((value >> i & 1) != 0) bytes_[at_ / 8] |= static_cast<std::byte>(1 << at_ % 8);
    }
    std::vector<std::byte> bytes() const { return bytes_; }

private:
    std::vector<std::byte> bytes_;
    std::size_t at_ = 0;
};

/// A block that is `level` of 31 everywhere: BC1 and BC3 hold that exactly, the others the nearest of their codes.
std::vector<std::byte> greyBlock(PixelFormat format, std::uint32_t level) {
    BlockWriter block(info(format).bytesPerBlock);
    const std::uint32_t in8 = (level * 255 + 15) / 31;
    const auto scalar = [&] { block.put(in8, 8), block.put(in8, 8), block.put(0, 24), block.put(0, 24); };
    const auto colour = [&] {
        const std::uint32_t c565 = level << 11 | (level << 1 | level >> 4) << 5 | level;
        block.put(c565, 16), block.put(c565, 16), block.put(0, 32);
    };
    if (format == PixelFormat::Bc3 || format == PixelFormat::Bc4 || format == PixelFormat::Bc5) scalar();
    if (format == PixelFormat::Bc5) scalar();
    if (format == PixelFormat::Bc1 || format == PixelFormat::Bc3) colour();
    if (format == PixelFormat::Bc6hUf16 || format == PixelFormat::Bc6hSf16) {
        block.put(0b00011, 5);  // one subset, both endpoints of 10 bits
        for (int i = 0; i < 6; ++i) block.put(16 * level, 10);
    }
    if (format == PixelFormat::Bc7) {
        block.put(0b100000, 6), block.put(0, 2);  // mode 5, no rotation
        for (int i = 0; i < 6; ++i) block.put(in8 >> 1, 7);
        for (int i = 0; i < 2; ++i) block.put(in8, 8);
    }
    return block.bytes();
}

std::uint32_t levelOf(SubImage image) {
    return static_cast<std::uint32_t>(4 + 5 * image.mip + image.face);
}

void writeGreys(const std::filesystem::path& file, const TextureShape& shape) {
    TextureFileOptions options;
    options.container = Container::Dds;
    Result<TextureWriter> writer = TextureWriter::create(file, shape, options);
    ASSERT_TRUE(writer) << writer.error().line();
    for (const SubImage& image : allImages(shape)) {
        const std::vector<std::byte> block = greyBlock(shape.format, levelOf(image));
        std::vector<std::byte> bytes;
        while (bytes.size() < shape.imageBytes(image.mip)) bytes.insert(bytes.end(), block.begin(), block.end());
        ASSERT_TRUE(writer->writeBlockRows(image, 0, bytes));
    }
    ASSERT_TRUE(writer->commit());
}

/// Half floats through BC6H's own scale: 10 bits -> 16 bits -> 31/64 or 31/32 of it -> the value of those bits.
float bc6hGrey(std::uint32_t level, bool isSigned) {
    const std::uint32_t q = 16 * level;
    const std::uint32_t wide = isSigned ? (q >= 511 ? 0x7fff : ((q << 15) + 0x4000) >> 9) : ((q << 16) + 0x8000) >> 10;
    const std::uint32_t half = isSigned ? wide * 31 >> 5 : wide * 31 >> 6;
    return std::ldexp(static_cast<float>(1024 + half % 1024), static_cast<int>(half / 1024) - 25);
}

/// The red channel of one mip, as OpenImageIO sees it.
std::vector<float> redOf(OIIO::ImageInput& input, int mip, OIIO::ImageSpec& spec) {
    EXPECT_TRUE(input.seek_subimage(0, mip));
    spec = input.spec();
    std::vector<float> red(static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height));
    EXPECT_TRUE(input.read_image(0, mip, 0, 1, OIIO::TypeDesc::FLOAT, red.data())) << input.geterror();
    return red;
}

TEST(DdsThroughOpenImageIO, PlainTexturesAndTheirMipsAreWhereTheyShouldBe) {
    const TemporaryFolder folder;
    for (const PixelFormat format : kReadable) {
        SCOPED_TRACE(info(format).name);
        const TextureShape shape{format, 40, 24, 4, 1, false, 1};
        writeGreys(folder / "plain.dds", shape);
        const auto input = OIIO::ImageInput::open((folder / "plain.dds").string());
        ASSERT_TRUE(input) << OIIO::geterror();
        for (int mip = 0; mip < shape.mipCount; ++mip) {
            OIIO::ImageSpec spec;
            const std::vector<float> red = redOf(*input, mip, spec);
            ASSERT_EQ(spec.width, shape.mipWidth(mip));
            ASSERT_EQ(spec.height, shape.mipHeight(mip));
            const std::uint32_t level = levelOf({mip, 0, 0});
            for (const float value : red) {
                if (info(format).isFloat)
                    ASSERT_EQ(value, bc6hGrey(level, format == PixelFormat::Bc6hSf16));
                else
                    ASSERT_NEAR(value, static_cast<float>(level) / 31.0f, 1.5f / 255.0f);
            }
        }
        EXPECT_FALSE(input->seek_subimage(0, shape.mipCount));
    }
}

/// OpenImageIO 2.4.7 reports the smaller mips of a cube with the extent of the mip before, so only their first texel is compared.
TEST(DdsThroughOpenImageIO, CubeFacesComeInOrder) {
    const TemporaryFolder folder;
    for (const PixelFormat format : kReadable) {
        SCOPED_TRACE(info(format).name);
        const TextureShape shape{format, 16, 16, 3, 1, false, 6};
        writeGreys(folder / "cube.dds", shape);
        const auto input = OIIO::ImageInput::open((folder / "cube.dds").string());
        ASSERT_TRUE(input) << OIIO::geterror();
        const auto expected = [&](SubImage image) {
            const std::uint32_t level = levelOf(image);
            return info(format).isFloat ? bc6hGrey(level, format == PixelFormat::Bc6hSf16) : static_cast<float>(level) / 31.0f;
        };
        const float tolerance = info(format).isFloat ? 0.0f : 1.5f / 255.0f;
        OIIO::ImageSpec spec;
        const std::vector<float> red = redOf(*input, 0, spec);
        ASSERT_EQ(spec.width, 16);  // a strip, +X on top
        ASSERT_EQ(spec.height, 6 * 16);
        for (std::size_t i = 0; i < red.size(); ++i)
            ASSERT_NEAR(red[i], expected({0, 0, static_cast<int>(i) / 256}), tolerance) << "texel " << i;
        for (int mip = 1; mip < shape.mipCount; ++mip) {
            ASSERT_TRUE(input->seek_subimage(0, mip));
            spec = input->spec();
            std::vector<float> strip(static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height));
            input->read_image(0, mip, 0, 1, OIIO::TypeDesc::FLOAT, strip.data());
            input->geterror();  // "hit end of file", for the extent that it believes in
            EXPECT_NEAR(strip[0], expected({mip, 0, 0}), tolerance) << "mip " << mip;
        }
    }
}

TEST(DdsFile, LegacyFourCcOnlyWhereItSaysEverything) {
    const TemporaryFolder folder;
    const auto fourCc = [&](const TextureShape& shape) {
        TextureFileOptions options;
        options.container = Container::Dds;
        EXPECT_TRUE(writePattern(folder / "texture.dds", shape, options));
        const std::vector<std::byte> bytes = wholeFile(folder / "texture.dds");
        return std::string(reinterpret_cast<const char*>(bytes.data()) + 84, 4);
    };
    EXPECT_EQ(fourCc({PixelFormat::Bc1, 8, 8, 1, 1, false, 1}), "DXT1");
    EXPECT_EQ(fourCc({PixelFormat::Bc3, 8, 8, 1, 1, false, 6}), "DXT5");
    EXPECT_EQ(fourCc({PixelFormat::Bc3, 8, 8, 1, 2, true, 1}), "DX10");
    EXPECT_EQ(fourCc({PixelFormat::Bc7, 8, 8, 1, 1, false, 1}), "DX10");
}

TEST(DdsFile, ArraysKeepWholeMipChainsTogether) {
    const TemporaryFolder folder;
    const TextureShape shape{PixelFormat::Bc3, 16, 16, 3, 2, true, 6};
    TextureFileOptions options;
    options.container = Container::Dds;
    ASSERT_TRUE(writePattern(folder / "texture.dds", shape, options));
    const std::vector<std::byte> bytes = wholeFile(folder / "texture.dds");
    EXPECT_EQ(loadU32(bytes, 128), 77u);
    EXPECT_EQ(loadU32(bytes, 132), 3u);
    EXPECT_EQ(loadU32(bytes, 136), 4u);
    EXPECT_EQ(loadU32(bytes, 140), 2u);  // cubes, not faces
    std::size_t at = 148;
    for (int layer = 0; layer < 2; ++layer)
        for (int face = 0; face < 6; ++face)
            for (int mip = 0; mip < 3; ++mip) {
                const std::vector<std::byte> image = patternImage(shape, {mip, layer, face});
                ASSERT_LE(at + image.size(), bytes.size());
                EXPECT_TRUE(std::equal(image.begin(), image.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at)));
                at += image.size();
            }
    EXPECT_EQ(at, bytes.size());
}

}  // namespace
}  // namespace lightcook::formats

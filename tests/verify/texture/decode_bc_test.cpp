// BC1 to BC7 against OpenImageIO (which bundles a third party's decoder): random and adversarial blocks in large DDS files.
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <random>

#include "compress/block/decode.h"
#include "tests/formats/temporary_folder.h"
#include "tests/soak/soak.h"
#include "verify/texture_unit.h"

namespace lightcook::verify {
namespace {

using formats::PixelFormat;

constexpr int kSize = 2048;  // texels of a side: 262,144 blocks

/// Random bytes; every fourth block has its fields pushed to extremes: all ones, all zeros, one bit, equal endpoints.
std::vector<std::byte> makeBlocks(PixelFormat format, unsigned seed) {
    const std::size_t bytesPerBlock = static_cast<std::size_t>(formats::info(format).bytesPerBlock);
    std::vector<std::byte> bytes(formats::bytesPerImage(format, kSize, kSize));
    std::mt19937_64 random(seed);
    for (std::size_t i = 0; i < bytes.size(); i += 8) {
        const std::uint64_t word = random();
        for (std::size_t k = 0; k < 8; ++k) bytes[i + k] = static_cast<std::byte>(word >> (8 * k));
    }
    for (std::size_t block = 0; block < bytes.size() / bytesPerBlock; ++block) {
        const std::span<std::byte> b = std::span(bytes).subspan(block * bytesPerBlock, bytesPerBlock);
        const std::byte first = b[0];
        switch (block % 16) {
            case 3:
                std::fill(b.begin() + 1, b.end(), std::byte{0xff});
                break;
            case 7:
                std::fill(b.begin() + 1, b.end(), std::byte{0});
                break;
            case 11:
                std::fill(b.begin(), b.begin() + static_cast<std::ptrdiff_t>(bytesPerBlock / 2), first);
                break;
            case 15:
                std::fill(b.begin() + 1, b.end(), std::byte{0});
                b[block / 16 % bytesPerBlock] |= std::byte{1} << static_cast<int>(block / 64 % 8);
                break;
            default:
                break;
        }
        // BC7's mode is the position of the lowest 1 bit: random bytes would hardly ever reach mode 7. Every ninth block is reserved.
        const unsigned mode = static_cast<unsigned>(block % 9);
        if (format == PixelFormat::Bc7)
            b[0] = mode == 8 ? std::byte{0}
                             : (first & ~std::byte{static_cast<unsigned char>((2u << mode) - 1)}) | std::byte{1} << static_cast<int>(mode);
    }
    return bytes;
}

struct Decoded {
    int channelCount = 0;
    std::vector<float> texels;  ///< 8-bit formats as 0..255
};

Decoded throughOpenImageIO(PixelFormat format, std::span<const std::byte> blocks) {
    const formats::TemporaryFolder folder;
    const std::filesystem::path place = folder / "blocks.dds";
    formats::TextureFileOptions options;
    options.container = formats::Container::Dds;
    formats::Result<formats::TextureWriter> writer = formats::TextureWriter::create(place, {format, kSize, kSize, 1, 1, false, 1}, options);
    EXPECT_TRUE(writer && writer->writeBlockRows({}, 0, blocks) && writer->commit());
    const auto input = OIIO::ImageInput::open(place.string());
    EXPECT_TRUE(input) << OIIO::geterror();
    Decoded decoded{input->spec().nchannels, {}};
    const std::size_t count = static_cast<std::size_t>(kSize) * kSize * static_cast<std::size_t>(decoded.channelCount);
    decoded.texels.resize(count);
    if (formats::info(format).isFloat) {
        EXPECT_EQ(input->spec().format, OIIO::TypeDesc::HALF);
        EXPECT_TRUE(input->read_image(0, 0, 0, -1, OIIO::TypeDesc::FLOAT, decoded.texels.data()));
    } else {
        std::vector<unsigned char> bytes(count);
        EXPECT_TRUE(input->read_image(0, 0, 0, -1, OIIO::TypeDesc::UINT8, bytes.data()));
        std::copy(bytes.begin(), bytes.end(), decoded.texels.begin());
    }
    return decoded;
}

/// Calls check(ours, theirs, channel, first byte of the block) for every value that both decode.
template <class Check>
void compare(PixelFormat format, std::span<const std::byte> blocks, const Check& check) {
    const Decoded theirs = throughOpenImageIO(format, blocks);
    formats::Image<glm::vec4> ours(kSize, 4);
    const std::size_t rowBytes = formats::bytesPerBlockRow(format, kSize);
    const float scale = formats::info(format).isFloat ? 1.0f : 255.0f;
    for (int row = 0; row < kSize / 4; ++row) {
        const auto rowBlocks = blocks.subspan(static_cast<std::size_t>(row) * rowBytes, rowBytes);
        decodeRows(format, rowBlocks, ours.view());
        for (int y = 0; y < 4; ++y)
            for (int x = 0; x < kSize; ++x)
                for (int c = 0; c < theirs.channelCount; ++c) {
                    const std::size_t at = (static_cast<std::size_t>(4 * row + y) * kSize + static_cast<std::size_t>(x)) *
                                           static_cast<std::size_t>(theirs.channelCount);
                    const std::size_t block =
                        static_cast<std::size_t>(x / 4) * static_cast<std::size_t>(formats::info(format).bytesPerBlock);
                    check(ours.at(x, y)[c] * scale, theirs.texels[at + static_cast<std::size_t>(c)], c, rowBlocks[block]);
                }
    }
}

template <class Check>
void compare(PixelFormat format, const Check& check) {
    const std::vector<std::byte> blocks = makeBlocks(format, static_cast<unsigned>(format) + 1u);
    compare(format, blocks, check);
}

class Bc6h : public testing::TestWithParam<PixelFormat> {};

TEST_P(Bc6h, ManyBlocksEqualOpenImageIOReservedModesIncluded) {
    std::int64_t different = 0, reserved = 0;
    compare(GetParam(), [&](float ours, float theirs, int, std::byte first) {
        different += !(ours == theirs);
        const int mode = std::to_integer<int>(first) & 31;
        if (mode == 19 || mode == 23 || mode == 27 || mode == 31) {
            ++reserved;
            different += ours != 0;
        }
    });
    EXPECT_EQ(different, 0);
    EXPECT_GT(reserved, 1000000);
}
INSTANTIATE_TEST_SUITE_P(BlockDecoders, Bc6h, testing::Values(PixelFormat::Bc6hUf16, PixelFormat::Bc6hSf16),
                         [](const auto& instance) { return std::string(instance.param == PixelFormat::Bc6hUf16 ? "unsigned" : "signed"); });

TEST(BlockDecoders, ManyBc7BlocksEqualOpenImageIOReservedModeIncluded) {
    std::int64_t different = 0, reserved = 0;
    compare(PixelFormat::Bc7, [&](float ours, float theirs, int, std::byte first) {
        different += std::nearbyint(ours) != theirs || std::abs(ours - theirs) > 1e-4f;
        if (first == std::byte{0}) {
            ++reserved;
            different += ours != 0;
        }
    });
    EXPECT_EQ(different, 0);
    EXPECT_GT(reserved, 1000000);
}

/// Their values are rounded to 8 bits, ours are ideal: they differ by at most a step.
class WithinOneStep : public testing::TestWithParam<PixelFormat> {};

TEST_P(WithinOneStep, ManyBlocksAgreeWithOpenImageIO) {
    double worst = 0;
    compare(GetParam(), [&](float ours, float theirs, int channel, std::byte) {
        // Their BC1 has a transparent black; ours is RGB with alpha 1.
        if (GetParam() == PixelFormat::Bc1 && channel == 3) return;
        worst = std::max(worst, static_cast<double>(std::abs(ours - theirs)));
    });
    EXPECT_LE(worst, 1.0);
    EXPECT_GT(worst, 0.1);  // they round: comparing a decoder with itself would give 0
}
INSTANTIATE_TEST_SUITE_P(BlockDecoders, WithinOneStep,
                         testing::Values(PixelFormat::Bc1, PixelFormat::Bc3, PixelFormat::Bc4, PixelFormat::Bc5),
                         [](const auto& instance) { return std::string(formats::info(instance.param).name); });

/// Returns true if our value equals OpenImageIO's.
bool agrees(PixelFormat format, float ours, float theirs, int channel) {
    if (formats::info(format).isFloat) return ours == theirs;
    if (format == PixelFormat::Bc7) return std::nearbyint(ours) == theirs && std::abs(ours - theirs) <= 1e-4f;
    return (format == PixelFormat::Bc1 && channel == 3) || std::abs(ours - theirs) <= 1;
}

void decodeByCompress(PixelFormat format, const std::byte* block, compress::DecodedBlock& out) {
    switch (format) {
        case PixelFormat::Bc1:
            return compress::decodeBc1(block, false, out);
        case PixelFormat::Bc3:
            return compress::decodeBc3(block, out);
        case PixelFormat::Bc4:
            return compress::decodeBc4(block, out);
        case PixelFormat::Bc5:
            return compress::decodeBc5(block, out);
        case PixelFormat::Bc7:
            return compress::decodeBc7(block, out);
        default:
            return compress::decodeBc6h(block, format == PixelFormat::Bc6hSf16, out);
    }
}

/// Counts values for which the encoders' own decoder differs from this one.
std::int64_t countOtherThanCompress(PixelFormat format, std::span<const std::byte> blocks) {
    const auto bytesPerBlock = static_cast<std::size_t>(formats::info(format).bytesPerBlock);
    const float tolerance = formats::info(format).isFloat ? 0.0f : 1e-6f;
    std::array<glm::vec4, 16> ours;
    compress::DecodedBlock theirs;
    std::int64_t different = 0;
    for (std::size_t at = 0; at < blocks.size(); at += bytesPerBlock) {
        decodeBlock(format, blocks.subspan(at, bytesPerBlock), ours);
        decodeByCompress(format, blocks.data() + at, theirs);
        for (std::size_t t = 0; t < 16; ++t)
            for (int c = 0; c < formats::info(format).channelCount; ++c)
                // A 16-bit endpoint of -32768 is minus infinity in both.
                different += ours[t][c] != theirs[t][c] && !(std::abs(ours[t][c] - theirs[t][c]) <= tolerance);
    }
    return different;
}

class BlockDecodersSoak : public testing::TestWithParam<PixelFormat> {};

TEST_P(BlockDecodersSoak, ReadAnyBytesAsOpenImageIOAndAsTheEncodersDo) {
    test::repeatInSoak("blocks decoded", std::int64_t{kSize / 4} * (kSize / 4), [](std::uint64_t round) {
        const unsigned seed = 1000u * static_cast<unsigned>(round) + static_cast<unsigned>(GetParam());
        const std::vector<std::byte> blocks = makeBlocks(GetParam(), seed);
        std::int64_t different = 0;
        compare(GetParam(), blocks,
                [&](float ours, float theirs, int channel, std::byte) { different += !agrees(GetParam(), ours, theirs, channel); });
        ASSERT_EQ(different, 0) << "values other than OpenImageIO's, seed " << seed;
        ASSERT_EQ(countOtherThanCompress(GetParam(), blocks), 0) << "values other than the encoders' own, seed " << seed;
    });
}
INSTANTIATE_TEST_SUITE_P(BlockDecoders, BlockDecodersSoak,
                         testing::Values(PixelFormat::Bc1, PixelFormat::Bc3, PixelFormat::Bc4, PixelFormat::Bc5, PixelFormat::Bc6hUf16,
                                         PixelFormat::Bc6hSf16, PixelFormat::Bc7),
                         [](const auto& instance) {
                             std::string name(formats::info(instance.param).name);
                             std::replace(name.begin(), name.end(), '-', '_');
                             return name;
                         });

std::vector<glm::vec4> decode(PixelFormat format, std::vector<int> bytes) {
    std::vector<std::byte> block;
    for (const int byte : bytes) block.push_back(static_cast<std::byte>(byte));
    std::vector<glm::vec4> out(16);
    decodeBlock(format, block, out);
    return out;
}

/// By hand from the palette's definition: endpoints 1 and 0, indices 0 to 7 in order.
TEST(BlockDecoders, Bc4PalettesAreTheIdealFractions) {
    // Indices 0..7 twice: 3 bits each, lowest first.
    const std::vector<int> indices = {0x88, 0xc6, 0xfa, 0x88, 0xc6, 0xfa};
    const auto block = [&](int a, int b) {
        std::vector<int> bytes = {a, b};
        bytes.insert(bytes.end(), indices.begin(), indices.end());
        return decode(PixelFormat::Bc4, bytes);
    };
    const std::vector<glm::vec4> eight = block(255, 0), six = block(0, 255);
    const std::array<float, 8> expectedEight = {1, 0, 6 / 7.f, 5 / 7.f, 4 / 7.f, 3 / 7.f, 2 / 7.f, 1 / 7.f};
    const std::array<float, 8> expectedSix = {0, 1, 1 / 5.f, 2 / 5.f, 3 / 5.f, 4 / 5.f, 0, 1};
    for (std::size_t i = 0; i < 16; ++i) {
        EXPECT_FLOAT_EQ(eight[i].r, expectedEight[i % 8]) << i;
        EXPECT_FLOAT_EQ(six[i].r, expectedSix[i % 8]) << i;
        EXPECT_EQ(glm::vec3(eight[i].g, eight[i].b, eight[i].a), glm::vec3(0, 0, 1));
    }
}

TEST(BlockDecoders, Bc1OfEqualEndpointsHasThreeColoursAndBlack) {
    const std::vector<glm::vec4> texels = decode(PixelFormat::Bc1, {0xff, 0xff, 0xff, 0xff, 0xe4, 0xe4, 0xe4, 0xe4});
    for (std::size_t i = 0; i < 16; ++i) EXPECT_EQ(texels[i], i % 4 == 3 ? glm::vec4(0, 0, 0, 1) : glm::vec4(1));
}

/// Of a DDS file, and of a KTX2 file of Vulkan's BC1_RGBA; in one of BC1_RGB the black is opaque.
TEST(BlockDecoders, TheBlackOfBc1IsTransparentWhereItsContainerSaysSo) {
    const formats::TemporaryFolder folder;
    const std::array<unsigned char, 8> block = {0xff, 0xff, 0xff, 0xff, 0xe4, 0xe4, 0xe4, 0xe4};
    for (const auto container : {formats::Container::Dds, formats::Container::Ktx2})
        for (const bool isRgba : {false, true}) {
            formats::TextureFileOptions options;
            options.container = container;
            auto writer = formats::TextureWriter::create(folder / "a", {PixelFormat::Bc1, 4, 4, 1, 1, false, 1}, options);
            ASSERT_TRUE(writer && writer->writeBlockRows({}, 0, std::as_bytes(std::span(block))) && writer->commit());
            if (isRgba && container == formats::Container::Ktx2) {
                std::string content = formats::contentOf(folder / "a");
                content[12] = static_cast<char>(133);
                formats::writeContent(folder / "a", content);
            }
            const auto texture = formats::TextureReader::open(folder / "a");
            ASSERT_TRUE(texture) << texture.error().line();
            const auto texels = decodeImage(*texture, {});
            ASSERT_TRUE(texels) << texels.error().line();
            const float alpha = isRgba || container == formats::Container::Dds ? 0.0f : 1.0f;
            for (int i = 0; i < 16; ++i) EXPECT_EQ(texels->at(i % 4, i / 4), i % 4 == 3 ? glm::vec4(0, 0, 0, alpha) : glm::vec4(1)) << i;
        }
}

TEST(BlockDecoders, PartialBlocksAreCutAtTheEdge) {
    std::vector<std::byte> blocks(4 * 8);
    for (int i = 0; i < 4; ++i) {
        // Four flat blocks of 10, 20, 30, 40 over 255.
        blocks[static_cast<std::size_t>(8 * i)] = blocks[static_cast<std::size_t>(8 * i + 1)] = static_cast<std::byte>(10 * (i + 1));
    }
    formats::Image<glm::vec4> image(7, 5, glm::vec4(-1));
    decodeRows(PixelFormat::Bc4, blocks, image.view());
    for (int y = 0; y < 5; ++y)
        for (int x = 0; x < 7; ++x) EXPECT_FLOAT_EQ(image.at(x, y).r * 255, static_cast<float>(10 * (1 + x / 4 + 2 * (y / 4))));
}

}  // namespace
}  // namespace lightcook::verify

// Our ASTC decoder against libastcenc's: on blocks that libastcenc encoded, and on random bits. Every value must be the same half.
#include <astcenc.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <map>
#include <memory>
#include <random>

#include "tests/soak/soak.h"
#include "verify/texture_unit.h"

namespace lightcook::verify {
namespace {

using formats::PixelFormat;

struct FreeContext {
    void operator()(astcenc_context* context) const { astcenc_context_free(context); }
};
using Context = std::unique_ptr<astcenc_context, FreeContext>;

bool isLdr(PixelFormat format) {
    return format == PixelFormat::Astc4x4Ldr;
}

Context makeContext(PixelFormat format, float quality) {
    const formats::PixelFormatInfo& info = formats::info(format);
    astcenc_config config;
    const unsigned width = static_cast<unsigned>(info.blockWidth), height = static_cast<unsigned>(info.blockHeight);
    EXPECT_EQ(astcenc_config_init(isLdr(format) ? ASTCENC_PRF_LDR : ASTCENC_PRF_HDR, width, height, 1, quality, 0, &config),
              ASTCENC_SUCCESS);
    astcenc_context* context = nullptr;
    EXPECT_EQ(astcenc_context_alloc(&config, 1, &context), ASTCENC_SUCCESS);
    return Context(context);
}

constexpr astcenc_swizzle kPlain = {ASTCENC_SWZ_R, ASTCENC_SWZ_G, ASTCENC_SWZ_B, ASTCENC_SWZ_A};

std::vector<glm::vec4> theirs(astcenc_context* context, std::span<const std::byte> blocks, int width, int height) {
    std::vector<glm::vec4> texels(static_cast<std::size_t>(width * height));
    void* slice = texels.data();
    astcenc_image image{static_cast<unsigned>(width), static_cast<unsigned>(height), 1, ASTCENC_TYPE_F32, &slice};
    EXPECT_EQ(astcenc_decompress_image(context, reinterpret_cast<const std::uint8_t*>(blocks.data()), blocks.size(), &image, &kPlain, 0),
              ASTCENC_SUCCESS);
    EXPECT_EQ(astcenc_decompress_reset(context), ASTCENC_SUCCESS);
    return texels;
}

struct Tally {
    std::int64_t legal = 0, illegal = 0, different = 0;
};

bool isAllNan(const glm::vec4& v) {
    return std::isnan(v.r) && std::isnan(v.g) && std::isnan(v.b) && std::isnan(v.a);
}

bool sameOrBothNan(const glm::vec4& a, const glm::vec4& b) {
    for (int c = 0; c < 4; ++c)
        if (!(a[c] == b[c] || (std::isnan(a[c]) && std::isnan(b[c])))) return false;
    return true;
}

/// In the LDR profile libastcenc returns NaN for an illegal block, and for a partition with HDR endpoints a magenta that went through its
/// interpolation (0xff00 / 0x10000); ours is the specification's (1, 0, 1, 1) in both.
bool isLdrErrorColour(const glm::vec4& v) {
    return isAllNan(v) || v == glm::vec4(0.99609375f, 0, 0.99609375f, 0.99609375f);
}

Tally compare(PixelFormat format, astcenc_context* context, std::span<const std::byte> blocks, int width, int height) {
    const std::vector<glm::vec4> expected = theirs(context, blocks, width, height);
    formats::Image<glm::vec4> found(width, height);
    decodeRows(format, blocks, found.view());
    Tally tally;
    for (std::size_t i = 0; i < expected.size(); ++i) {
        const glm::vec4& ours = found.texels()[i];
        const bool isError = isLdr(format) ? isLdrErrorColour(expected[i]) : isAllNan(expected[i]);
        ++(isError ? tally.illegal : tally.legal);
        const bool isSame = isLdr(format) && isError ? ours == glm::vec4(1, 0, 1, 1) : sameOrBothNan(ours, expected[i]);
        tally.different += !isSame;
    }
    return tally;
}

class Astc : public testing::TestWithParam<PixelFormat> {};

/// Patterns of the test images; each makes the encoder use other modes.
float pattern(int kind, int x, int y, int channel, std::mt19937& random) {
    const float noise = static_cast<float>(random() % 1024) / 1023.0f;
    switch (kind) {
        case 0:
            return noise;  // noise
        case 1:
            return static_cast<float>(x + 2 * y + 5 * channel) / 300.0f;  // gradients
        case 2:
            return 0.25f * static_cast<float>(channel);  // constants: void extents
        case 3:
            return (x / 3 + y / 3) % 2 == 0 ? 0.05f + 0.1f * noise : 0.9f - 0.1f * static_cast<float>(channel);  // two partitions
        case 4:
            return static_cast<float>((x * 7 + y * 3) % 4 * (channel + 1)) / 12.0f;  // four colours
        case 5:
            return channel == 3 ? noise : static_cast<float>(x) / 100.0f;  // alpha apart: dual plane
        case 6:
            return channel == 1 ? noise : static_cast<float>(y) / 100.0f;  // green apart
        default:
            return 0.2f + 0.6f * static_cast<float>((x ^ y) & 1);  // grey
    }
}

TEST_P(Astc, BlocksOfTheEncoderDecodeToTheSameHalfs) {
    const int size = 96;
    for (const float quality : {10.0f, 60.0f}) {
        const Context context = makeContext(GetParam(), quality);
        for (int kind = 0; kind < 8; ++kind)
            for (const float scale : {1.0f, 900.0f}) {
                if (isLdr(GetParam()) && scale != 1) continue;
                std::mt19937 random(static_cast<unsigned>(kind));
                std::vector<float> texels(static_cast<std::size_t>(size * size * 4));
                for (std::size_t i = 0; i < texels.size(); ++i) {
                    const int at = static_cast<int>(i / 4);
                    texels[i] = scale * std::min(1.0f, pattern(kind, at % size, at / size, static_cast<int>(i % 4), random));
                }
                void* slice = texels.data();
                astcenc_image image{static_cast<unsigned>(size), static_cast<unsigned>(size), 1, ASTCENC_TYPE_F32, &slice};
                std::vector<std::byte> blocks(formats::bytesPerImage(GetParam(), size, size));
                ASSERT_EQ(astcenc_compress_image(context.get(), &image, &kPlain, reinterpret_cast<std::uint8_t*>(blocks.data()),
                                                 blocks.size(), 0),
                          ASTCENC_SUCCESS);
                ASSERT_EQ(astcenc_compress_reset(context.get()), ASTCENC_SUCCESS);
                const Tally tally = compare(GetParam(), context.get(), blocks, size, size);
                EXPECT_EQ(tally.different, 0) << "pattern " << kind << " scale " << scale;
                EXPECT_EQ(tally.illegal, 0);
            }
    }
}

struct Bias {
    const char* name;
    unsigned cleared, set;
};
constexpr std::array<Bias, 6> kBiases = {{{"any", 0, 0},
                                          {"one partition", 0x1800, 0},
                                          {"small grids", 0x1a0, 0},
                                          {"two partitions, small grids", 0x19a0, 0x800},
                                          {"three partitions, small grids", 0x19a0, 0x1000},
                                          {"void extents", 0, 0xdfc}}};

/// Random blocks, with bits of the head cleared and set to make legal blocks more frequent.
std::vector<std::byte> randomBlocks(std::size_t count, const Bias& bias, unsigned seed) {
    std::mt19937_64 random(seed);
    std::vector<std::byte> blocks(count * 16);
    for (std::size_t i = 0; i < blocks.size(); i += 8) {
        const std::uint64_t word = random();
        std::memcpy(blocks.data() + i, &word, 8);
    }
    for (std::size_t i = 0; i < blocks.size(); i += 16) {
        std::uint16_t head = 0;
        std::memcpy(&head, blocks.data() + i, 2);
        head = static_cast<std::uint16_t>((head & ~bias.cleared) | bias.set);
        std::memcpy(blocks.data() + i, &head, 2);
    }
    return blocks;
}

/// Random bits cover modes that an encoder never writes.
void expectAlike(PixelFormat format, unsigned seed) {
    const formats::PixelFormatInfo& info = formats::info(format);
    const int across = 256, down = 256, width = across * info.blockWidth, height = down * info.blockHeight;
    const Context context = makeContext(format, 0);
    for (const Bias& bias : kBiases) {
        const Tally tally =
            compare(format, context.get(), randomBlocks(static_cast<std::size_t>(across * down), bias, seed), width, height);
        EXPECT_EQ(tally.different, 0) << bias.name << ", seed " << seed;
        EXPECT_GT(tally.legal, 10000) << bias.name;
        EXPECT_GT(tally.illegal, 10000) << bias.name;
    }
}

TEST_P(Astc, RandomBitsAreLegalOrIllegalAlikeAndDecodeToTheSameHalfs) {
    expectAlike(GetParam(), 7);
}

class AstcSoak : public testing::TestWithParam<PixelFormat> {};
TEST_P(AstcSoak, RandomBitsDecodeAlike) {
    test::repeatInSoak("blocks decoded", std::int64_t{256} * 256 * std::ssize(kBiases),
                       [](std::uint64_t seed) { expectAlike(GetParam(), 100u + static_cast<unsigned>(seed)); });
}

const auto kAstcFormats =
    testing::Values(PixelFormat::Astc4x4Ldr, PixelFormat::Astc4x4Hdr, PixelFormat::Astc6x6Hdr, PixelFormat::Astc8x8Hdr);
std::string nameOf(const testing::TestParamInfo<PixelFormat>& instance) {
    std::string name(formats::info(instance.param).name);
    std::replace(name.begin(), name.end(), '-', '_');
    return name;
}
INSTANTIATE_TEST_SUITE_P(BlockDecoders, Astc, kAstcFormats, nameOf);
INSTANTIATE_TEST_SUITE_P(BlockDecoders, AstcSoak, kAstcFormats, nameOf);

}  // namespace
}  // namespace lightcook::verify

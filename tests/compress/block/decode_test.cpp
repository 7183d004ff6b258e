// The decoders of compress/ agree with the independent ones of verify/ on any bytes.
#include "compress/block/decode.h"

#include <gtest/gtest.h>

#include "tests/compress/codec_images.h"
#include "verify/texture_unit.h"

namespace lightcook::compress::test {
namespace {

using formats::PixelFormat;
using Block16 = std::array<std::byte, 16>;

/// Returns random bytes. Every other BC7 block starts with a uniformly drawn mode, since half of all random blocks have mode 0.
Block16 randomBlock(Random& random, PixelFormat format) {
    Block16 block;
    for (std::byte& byte : block) byte = static_cast<std::byte>(random.bits());
    if (format == PixelFormat::Bc7) {
        const int mode = random.below(9);
        const unsigned kept = std::to_integer<unsigned>(block[0]) << mode << 1;
        block[0] = static_cast<std::byte>(mode == 8 ? 0u : kept | 1u << mode);
    }
    return block;
}

void expectAgreement(PixelFormat format, double tolerance, void (*decode)(const std::byte*, DecodedBlock&)) {
    Random random(61);
    const auto bytesPerBlock = static_cast<std::size_t>(formats::info(format).bytesPerBlock);
    for (int i = 0; i < 100000; ++i) {
        const Block16 block = randomBlock(random, format);
        DecodedBlock ours, theirs;
        decode(block.data(), ours);
        verify::decodeBlock(format, std::span(block).first(bytesPerBlock), theirs);
        for (std::size_t t = 0; t < kTexelCount; ++t)
            for (int c = 0; c < formats::info(format).channelCount; ++c)
                ASSERT_NEAR(ours[t][c], theirs[t][c], tolerance) << formats::info(format).name << " block " << i << " texel " << t;
    }
}

TEST(Decode, AnyBytesOfBc6hAndBc7AgreeExactly) {
    expectAgreement(PixelFormat::Bc6hUf16, 0, [](const std::byte* block, DecodedBlock& out) { decodeBc6h(block, false, out); });
    expectAgreement(PixelFormat::Bc6hSf16, 0, [](const std::byte* block, DecodedBlock& out) { decodeBc6h(block, true, out); });
    expectAgreement(PixelFormat::Bc7, 1e-7, decodeBc7);
}

TEST(Decode, AnyBytesOfBc1ToBc5AgreeToRounding) {
    expectAgreement(PixelFormat::Bc1, 1e-6, [](const std::byte* block, DecodedBlock& out) { decodeBc1(block, false, out); });
    expectAgreement(PixelFormat::Bc3, 1e-6, decodeBc3);
    expectAgreement(PixelFormat::Bc4, 1e-6, decodeBc4);
    expectAgreement(PixelFormat::Bc5, 1e-6, decodeBc5);
    expectAgreement(PixelFormat::Bc4Snorm, 1e-6, decodeBc4Snorm);
    expectAgreement(PixelFormat::Bc5Snorm, 1e-6, decodeBc5Snorm);
}

}  // namespace
}  // namespace lightcook::compress::test

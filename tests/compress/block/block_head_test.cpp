// Heads of BC6H and BC7 blocks: the rest of a block is indices only, as the decoder of verify/ reads them.
#include "compress/block/block_head.h"

#include <gtest/gtest.h>

#include <bit>

#include "compress/bc6h/modes.h"
#include "tests/compress/codec_images.h"
#include "verify/texture_unit.h"

namespace lightcook::compress::test {
namespace {

using formats::PixelFormat;
using Bytes = std::array<std::byte, 16>;
using Indices = std::array<std::array<std::uint8_t, kTexelCount>, 2>;

/// A mode of a format, and the size of its heads by the specification.
struct HeadMode {
    PixelFormat format;
    int number;
    int headBits;
};

std::vector<HeadMode> allHeadModes() {
    constexpr std::array kBc7Bits = {83, 82, 99, 98, 50, 66, 65, 98};
    std::vector<HeadMode> modes;
    for (int mode = 0; mode < 8; ++mode) modes.push_back({PixelFormat::Bc7, mode, kBc7Bits[static_cast<std::size_t>(mode)]});
    for (const PixelFormat format : {PixelFormat::Bc6hUf16, PixelFormat::Bc6hSf16})
        for (int mode = 0; mode < 14; ++mode) modes.push_back({format, mode, mode < 10 ? 82 : 65});
    return modes;
}

/// Returns a block of a mode with random bits.
Bytes blockOfMode(Random& random, const HeadMode& mode) {
    Bytes bytes;
    for (std::byte& each : bytes) each = static_cast<std::byte>(random.below(256));
    const auto low = std::to_integer<unsigned>(bytes[0]);
    if (mode.format == PixelFormat::Bc7) {
        bytes[0] = static_cast<std::byte>(mode.number == 7 ? 0x80u : (low | 1u) << mode.number);
    } else {
        const Bc6hMode& bc6h = kBc6hModes[static_cast<std::size_t>(mode.number)];
        bytes[0] = static_cast<std::byte>(low >> bc6h.headerBits << bc6h.headerBits | bc6h.header);
    }
    return bytes;
}

int indexCount(const BlockHead& head, std::size_t set, std::size_t texel) {
    return 1 << (head.sets[set].bits - (head.sets[set].anchors >> texel & 1));
}

Indices randomIndices(Random& random, const BlockHead& head) {
    Indices indices{};
    for (std::size_t s = 0; s < static_cast<std::size_t>(head.setCount); ++s)
        for (std::size_t t = 0; t < kTexelCount; ++t)
            indices[s][t] = static_cast<std::uint8_t>(random.below(static_cast<std::uint32_t>(indexCount(head, s, t))));
    return indices;
}

TexelImage decoded(PixelFormat format, const Bytes& bytes) {
    TexelImage image(4, 4);
    verify::decodeRows(format, bytes, image.view());
    return image;
}

TEST(BlockHead, SizesAreThoseOfTheSpecification) {
    Random random(1);
    for (const HeadMode& mode : allHeadModes()) {
        const BlockHead head = headOf(mode.format, blockOfMode(random, mode).data());
        EXPECT_EQ(head.bits, mode.headBits);
        int bits = head.bits;
        for (std::size_t s = 0; s < static_cast<std::size_t>(head.setCount); ++s)
            bits += kTexelCount * head.sets[s].bits - std::popcount(head.sets[s].anchors);
        EXPECT_EQ(bits, 128) << mode.number;
    }
    EXPECT_EQ(headOf(PixelFormat::Bc7, Bytes{}.data()).bits, 0);
    EXPECT_EQ(headOf(PixelFormat::Bc6hUf16, Bytes{std::byte{0x13}}.data()).bits, 0);
    EXPECT_EQ(headOf(PixelFormat::Bc5, Bytes{}.data()).bits, 0);
}

TEST(BlockHead, AnIndexRulesItsTexelAndItsChannelsAlone) {
    Random random(2);
    for (const HeadMode& mode : allHeadModes())
        for (int round = 0; round < 100; ++round) {
            Bytes block = blockOfMode(random, mode);
            const BlockHead head = headOf(mode.format, block.data());
            Indices indices = randomIndices(random, head);
            putIndices(head, indices, block.data());
            EXPECT_EQ(headOf(mode.format, block.data()).bits, head.bits);
            const TexelImage before = decoded(mode.format, block);
            const std::size_t set = random.below(static_cast<std::uint32_t>(head.setCount)), texel = random.below(kTexelCount);
            indices[set][texel] = static_cast<std::uint8_t>(random.below(static_cast<std::uint32_t>(indexCount(head, set, texel))));
            putIndices(head, indices, block.data());
            const TexelImage after = decoded(mode.format, block);
            for (std::size_t t = 0; t < kTexelCount; ++t)
                for (int c = 0; c < 4; ++c) {
                    if (t == texel && (head.sets[set].channels >> c & 1)) continue;
                    EXPECT_EQ(after.texels()[t][c], before.texels()[t][c]) << mode.number << ", texel " << t << ", channel " << c;
                }
        }
}

TEST(BlockHead, IndicesOfABlockPutBackGiveTheSameBytes) {
    Random random(3);
    for (const HeadMode& mode : allHeadModes())
        for (int round = 0; round < 50; ++round) {
            const Bytes block = blockOfMode(random, mode);
            const BlockHead head = headOf(mode.format, block.data());
            BitReader bits(block.data(), block.size());
            for (int i = 0; i < head.bits; ++i) bits.get(1);
            Indices indices{};
            for (std::size_t s = 0; s < static_cast<std::size_t>(head.setCount); ++s)
                for (std::size_t t = 0; t < kTexelCount; ++t)
                    indices[s][t] = static_cast<std::uint8_t>(bits.get(head.sets[s].bits - (head.sets[s].anchors >> t & 1)));
            Bytes again = block;
            putIndices(head, indices, again.data());
            EXPECT_EQ(again, block) << mode.number;
        }
}

}  // namespace
}  // namespace lightcook::compress::test

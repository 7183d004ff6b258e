// Heads of BC7 blocks: the rest of a block is indices only, as the decoder of verify/ reads them.
#include "compress/bc7/block_head.h"

#include <gtest/gtest.h>

#include <bit>

#include "tests/compress/codec_images.h"
#include "verify/texture_unit.h"

namespace lightcook::compress::test {
namespace {

using Bytes = std::array<std::byte, 16>;
using Indices = std::array<std::array<std::uint8_t, kTexelCount>, 2>;

/// Returns a block of a mode with random bits.
Bytes randomBlock(Random& random, int mode) {
    Bytes bytes;
    for (std::byte& each : bytes) each = static_cast<std::byte>(random.below(256));
    bytes[0] = static_cast<std::byte>(mode == 7 ? 0x80u : (std::to_integer<unsigned>(bytes[0]) | 1u) << mode);
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

TexelImage decoded(const Bytes& bytes) {
    TexelImage image(4, 4);
    verify::decodeRows(formats::PixelFormat::Bc7, bytes, image.view());
    return image;
}

TEST(BlockHead, SizesAreThoseOfTheSpecification) {
    constexpr std::array kBits = {83, 82, 99, 98, 50, 66, 65, 98};
    Random random(1);
    for (int mode = 0; mode < 8; ++mode) {
        const BlockHead head = headOfBc7(randomBlock(random, mode).data());
        EXPECT_EQ(head.bits, kBits[static_cast<std::size_t>(mode)]);
        int bits = head.bits;
        for (std::size_t s = 0; s < static_cast<std::size_t>(head.setCount); ++s)
            bits += kTexelCount * head.sets[s].bits - std::popcount(head.sets[s].anchors);
        EXPECT_EQ(bits, 128) << mode;
    }
    EXPECT_EQ(headOfBc7(Bytes{}.data()).bits, 0);
}

TEST(BlockHead, AnIndexRulesItsTexelAndItsChannelsAlone) {
    Random random(2);
    for (int mode = 0; mode < 8; ++mode)
        for (int round = 0; round < 200; ++round) {
            Bytes block = randomBlock(random, mode);
            const BlockHead head = headOfBc7(block.data());
            Indices indices = randomIndices(random, head);
            putIndices(head, indices, block.data());
            EXPECT_EQ(headOfBc7(block.data()).bits, head.bits);
            const TexelImage before = decoded(block);
            const std::size_t set = random.below(static_cast<std::uint32_t>(head.setCount)), texel = random.below(kTexelCount);
            indices[set][texel] = static_cast<std::uint8_t>(random.below(static_cast<std::uint32_t>(indexCount(head, set, texel))));
            putIndices(head, indices, block.data());
            const TexelImage after = decoded(block);
            for (std::size_t t = 0; t < kTexelCount; ++t)
                for (int c = 0; c < 4; ++c) {
                    if (t == texel && (head.sets[set].channels >> c & 1)) continue;
                    EXPECT_EQ(after.texels()[t][c], before.texels()[t][c]) << mode << ", texel " << t << ", channel " << c;
                }
        }
}

TEST(BlockHead, IndicesOfABlockPutBackGiveTheSameBytes) {
    Random random(3);
    for (int mode = 0; mode < 8; ++mode)
        for (int round = 0; round < 50; ++round) {
            const Bytes block = randomBlock(random, mode);
            const BlockHead head = headOfBc7(block.data());
            BitReader bits(block.data(), block.size());
            for (int i = 0; i < head.bits; ++i) bits.get(1);
            Indices indices{};
            for (std::size_t s = 0; s < static_cast<std::size_t>(head.setCount); ++s)
                for (std::size_t t = 0; t < kTexelCount; ++t)
                    indices[s][t] = static_cast<std::uint8_t>(bits.get(head.sets[s].bits - (head.sets[s].anchors >> t & 1)));
            Bytes again = block;
            putIndices(head, indices, again.data());
            EXPECT_EQ(again, block) << mode;
        }
}

}  // namespace
}  // namespace lightcook::compress::test

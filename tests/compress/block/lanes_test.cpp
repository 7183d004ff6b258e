// The bytes of a block do not depend on the blocks in other lanes.
#include "compress/block/highway_targets.h"

#include <gtest/gtest.h>

#include "compress/bc1/fit-inl.h"
#include "compress/bc1/rows-inl.h"
#include "compress/bc4/fit-inl.h"
#include "compress/bc4/rows-inl.h"
#include "compress/bc6h/fit-inl.h"
#include "compress/bc7/fast/rows-inl.h"
#include "compress/bc7/full/search-inl.h"
#include "tests/compress/codec_images.h"

// The kernels are compiled for Highway's target, so the code that inlines them must be too.
HWY_BEFORE_NAMESPACE();
namespace lightcook::compress::test {
namespace {

namespace kernel = HWY_NAMESPACE;
using OneLane = kernel::hn::CappedTag<float, 1>;
using AllLanes = kernel::hn::ScalableTag<float>;

/// Returns blocks of every kind, more than a vector has lanes.
std::vector<Block> someBlocks(bool hdr) {
    Random random(51);
    std::vector<Block> blocks(128);
    for (Block& block : blocks) {
        const int kind = random.below(4);
        const float base = hdr ? std::exp2(random.unit() * 24 - 10) : random.unit();
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            block.significance[t] = kind == 2 ? static_cast<float>(random.below(3)) : 1.0f;
            for (auto& channel : block.channel) {
                channel[t] = kind == 0 ? random.unit() : base * (1 + static_cast<float>(t) * 0.05f * random.unit());
                if (kind == 3 && random.below(3) == 0) channel[t] = 0;
                channel[t] = std::min(channel[t], hdr ? 65504.0f : 1.0f);
            }
        }
        block.significance[5] = 1;
    }
    return blocks;
}

/// Returns the results of a kernel for all blocks.
template <class D, class Result, class Fit, class Run>
std::vector<Result> results(const std::vector<Block>& blocks, Fit fit, Run run) {
    const std::size_t lanes = kernel::hn::Lanes(D());
    std::vector<Result> found(blocks.size());
    std::vector<const Block*> pointers;
    for (const Block& block : blocks) pointers.push_back(&block);
    for (std::size_t first = 0; first < blocks.size(); first += lanes) run(fit, pointers.data() + first, found.data() + first);
    return found;
}

template <bool kSigned>
void expectBc6hAlike(int level) {
    const std::vector<Block> blocks = someBlocks(true);
    const EncodeOptions options;
    const auto run = [](auto& fit, const Block* const* at, Bc6hResult* found) { fit.run(at, found); };
    const auto one = results<OneLane, Bc6hResult>(blocks, kernel::Bc6hFit<OneLane, kSigned>(bc6hSearchOf(level), options), run);
    const auto all = results<AllLanes, Bc6hResult>(blocks, kernel::Bc6hFit<AllLanes, kSigned>(bc6hSearchOf(level), options), run);
    for (std::size_t i = 0; i < blocks.size(); ++i) {
        EXPECT_EQ(one[i].mode, all[i].mode) << i;
        EXPECT_EQ(one[i].partition, all[i].partition) << i;
        EXPECT_EQ(one[i].code, all[i].code) << i;
        EXPECT_EQ(one[i].index, all[i].index) << i;
    }
}

TEST(Lanes, OneLaneOfBc6hMatchesAVectorOfThem) {
    for (const int level : {0, 3, 6}) {
        expectBc6hAlike<false>(level);
        expectBc6hAlike<true>(level);
    }
}

/// Returns the results of the full search of BC7 for all blocks.
template <class D>
std::vector<Bc7Result> fullBc7(const std::vector<Block>& blocks, int level) {
    const EncodeOptions options;
    std::vector<const Block*> pointers;
    for (const Block& block : blocks) pointers.push_back(&block);
    std::vector<Bc7Result> found(blocks.size());
    kernel::Bc7FullSearch<D>(bc7SearchOf(level), options).run(pointers, found.data());
    return found;
}

TEST(Lanes, OneLaneOfBc7MatchesAVectorOfThem) {
    std::vector<Block> blocks = someBlocks(false);
    blocks.resize(blocks.size() - 3);  // the last vector is not full
    for (const int level : {0, 4, 6}) {
        const auto one = fullBc7<OneLane>(blocks, level), all = fullBc7<AllLanes>(blocks, level);
        for (std::size_t i = 0; i < blocks.size(); ++i) {
            EXPECT_EQ(one[i].mode, all[i].mode) << i;
            EXPECT_EQ(one[i].partition, all[i].partition) << i;
            EXPECT_EQ(one[i].code, all[i].code) << i;
            EXPECT_EQ(one[i].low, all[i].low) << i;
            EXPECT_EQ(one[i].index, all[i].index) << i;
            EXPECT_EQ(one[i].second, all[i].second) << i;
            EXPECT_EQ(one[i].error, all[i].error) << i;
        }
    }
}

/// Returns the bytes of the fast BC7 kernel. Blocks of one colour become zeros.
template <class D>
std::vector<std::byte> fastBc7(const TexelRows& rows, int level) {
    const auto blockCount = static_cast<std::size_t>((rows.width + 3) / 4 * ((rows.height + 3) / 4));
    const EncodeOptions options;
    const auto oneColour = [](const std::array<float, 4>&, std::byte* out) { std::fill_n(out, 16, std::byte{0}); };
    std::vector<std::byte> bytes(16 * blockCount);
    kernel::Bc7FastRows<D>(bc7FastSearchOf(level), options, oneColour).run(rows, bytes.data());
    return bytes;
}

TEST(Lanes, OneLaneOfTheFastBc7KernelMatchesAVectorOfThem) {
    // A width that leaves part of a vector, opaque blocks beside others, and weights of 1 given or left out.
    constexpr int kWidth = 4 * 37 + 2, kHeight = 34;
    Random random(52);
    std::vector<float> texels, ones(static_cast<std::size_t>(kWidth * kHeight), 1.0f), weights;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            const int kind = (x / 4 + y / 4) % 5;
            for (int c = 0; c < 3; ++c)
                texels.push_back(kind == 0 ? 0.25f : kind == 1 ? random.unit() : 0.3f + 0.02f * random.unit() * static_cast<float>(x % 4));
            texels.push_back(kind == 3 ? random.unit() : kind == 4 ? 0.995f : 1.0f);
            weights.push_back(static_cast<float>(random.below(3)));
        }
    for (const float* significance : std::initializer_list<const float*>{nullptr, ones.data(), weights.data()})
        for (const int level : {0, 1, 2}) {
            const TexelRows rows{texels.data(), 4 * kWidth, significance, kWidth, kWidth, kHeight};
            const auto one = fastBc7<OneLane>(rows, level);
            EXPECT_EQ(one, fastBc7<AllLanes>(rows, level)) << level;
            if (significance == ones.data()) {
                EXPECT_EQ(one, fastBc7<AllLanes>({texels.data(), 4 * kWidth, nullptr, kWidth, kWidth, kHeight}, level)) << level;
            }
        }
}

TEST(Lanes, OneLaneOfBc1AndBc4MatchesAVectorOfThem) {
    const std::vector<Block> blocks = someBlocks(false);
    const EncodeOptions options;
    const auto run1 = [](auto& fit, const Block* const* at, Bc1Result* found) { fit.run(at, found); };
    const auto run4 = [](auto& fit, const Block* const* at, Bc4Result* found) { fit.run(at, 2, found); };
    const auto one1 = results<OneLane, Bc1Result>(blocks, kernel::Bc1Fit<OneLane>(bc1SearchOf(6), options, true), run1);
    const auto all1 = results<AllLanes, Bc1Result>(blocks, kernel::Bc1Fit<AllLanes>(bc1SearchOf(6), options, true), run1);
    const auto one4 = results<OneLane, Bc4Result>(blocks, kernel::Bc4Fit<OneLane>(bc4SearchOf(6)), run4);
    const auto all4 = results<AllLanes, Bc4Result>(blocks, kernel::Bc4Fit<AllLanes>(bc4SearchOf(6)), run4);
    for (std::size_t i = 0; i < blocks.size(); ++i) {
        EXPECT_EQ(one1[i].first, all1[i].first) << i;
        EXPECT_EQ(one1[i].second, all1[i].second) << i;
        EXPECT_EQ(one1[i].threeColours, all1[i].threeColours) << i;
        EXPECT_EQ(one4[i].low, all4[i].low) << i;
        EXPECT_EQ(one4[i].high, all4[i].high) << i;
        EXPECT_EQ(one4[i].sixValues, all4[i].sixValues) << i;
    }
}

/// Returns the words of all blocks of an image from a kernel that reads rows.
template <class D, class Kernel>
std::vector<std::uint32_t> wordsOf(const TexelRows& rows, std::size_t wordsPerBlock, Kernel kernel) {
    HWY_ALIGN std::uint32_t words[4 * kernel::hn::MaxLanes(D())];
    std::vector<std::uint32_t> all;
    kernel::forEachVector<D>(rows, [&](const auto& texels, const auto* weights, std::size_t count) {
        kernel.run(texels, weights, words);
        all.insert(all.end(), words, words + wordsPerBlock * count);
    });
    return all;
}

/// Returns the bytes of BC4 or BC5 blocks of an image from the kernel that reads rows.
template <class D, int kChannels>
std::vector<std::byte> bc4BytesOf(const TexelRows& rows, int level, const Bc4Codes& codes) {
    constexpr std::size_t kBytes = 8 * kChannels;
    const auto across = static_cast<std::size_t>((rows.width + 3) / 4), down = static_cast<std::size_t>((rows.height + 3) / 4);
    std::vector<std::byte> all(kBytes * across * down);
    kernel::Bc4Rows<D, kChannels> fit(bc4SearchOf(level), codes);
    std::byte* out = all.data();
    kernel::forEachVector<D>(rows, [&](const auto& texels, const auto* weights, std::size_t count) {
        fit.run(texels, weights, count, out);
        out += kBytes * count;
    });
    fit.finish();
    return all;
}

/// Blocks whose texels all weigh 1 have another kernel at effort 0 than their neighbours in the same vector.
TEST(Lanes, BlocksOfWeightOneGiveTheSameBytesBesideAnyOthers) {
    Random random(53);
    const int width = 4 * 64, height = 8;
    const TexelImage image = imageOf(width, height, [&](int x, int y) {
        const float base = random.unit(), step = (x / 4 + y / 4) % 3 == 0 ? 0.5f : 0.02f;
        const auto value = [&] { return (x / 4) % 7 == 0 ? 0.4f : std::min(0.5f + step * random.unit() * base, 1.0f); };
        return glm::vec4(value(), value(), value(), value());
    });
    formats::Image<float> significance(width, height, 1.0f);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            if ((x / 4 * 5 + y / 4) % 3 == 0) significance.at(x, y) = 0.5f * static_cast<float>(random.below(3));
    const TexelRows weighted = {
        &image.view().texels->x, 4 * image.view().rowStride, significance.view().texels, significance.view().rowStride, width, height};
    TexelRows even = weighted;
    even.significance = nullptr;
    const auto some = bc4BytesOf<AllLanes, 2>(weighted, 0, kBc4Unorm), all = bc4BytesOf<AllLanes, 2>(even, 0, kBc4Unorm);
    EXPECT_EQ(some, (bc4BytesOf<OneLane, 2>(weighted, 0, kBc4Unorm)));
    EXPECT_EQ(all, (bc4BytesOf<OneLane, 2>(even, 0, kBc4Unorm)));
    int differing = 0;
    for (int block = 0; block < 2 * 64; ++block) {
        const bool isEven = (block % 64 * 5 + block / 64) % 3 != 0;
        const auto at = [&](const std::vector<std::byte>& bytes) {
            return std::vector(bytes.data() + 16 * block, bytes.data() + 16 * block + 16);
        };
        if (isEven)
            EXPECT_EQ(at(some), at(all)) << block;
        else
            differing += at(some) != at(all);
    }
    EXPECT_GT(differing, 20);  // the weights of the others count
}

TEST(Lanes, RowsOfBc1AndBc4GiveTheSameBytesAtEveryWidth) {
    using FourLanes = kernel::hn::CappedTag<float, 4>;
    Random random(52);
    const int width = 150, height = 30;
    const TexelImage image = imageOf(width, height, [&](int x, int y) {
        const float base = static_cast<float>(x / 4 * y / 4 % 9) / 9, step = (x / 4 + y / 4) % 3 == 0 ? 0.9f : 0.03f;
        const auto value = [&] { return base + step * random.unit(); };
        return (x / 4 + y / 4) % 5 == 0 ? glm::vec4(base) : glm::vec4(value(), value(), value(), value());
    });
    formats::Image<float> significance(width, height, 1.0f);
    for (int y = 8; y < 16; ++y)
        for (int x = 0; x < width; ++x) significance.at(x, y) = static_cast<float>(random.below(3)) * 0.7f;
    const TexelRows rows = {
        &image.view().texels->x, 4 * image.view().rowStride, significance.view().texels, significance.view().rowStride, width, height};
    for (int level = 0; level < 9; ++level) {
        const EncodeOptions options = effort(level);
        EXPECT_EQ((wordsOf<FourLanes>(rows, 2, kernel::Bc1Rows<FourLanes, false>(options))),
                  (wordsOf<AllLanes>(rows, 2, kernel::Bc1Rows<AllLanes, false>(options))))
            << level;
        EXPECT_EQ((wordsOf<FourLanes>(rows, 4, kernel::Bc1Rows<FourLanes, true>(options))),
                  (wordsOf<AllLanes>(rows, 4, kernel::Bc1Rows<AllLanes, true>(options))))
            << level;
        EXPECT_EQ((bc4BytesOf<FourLanes, 2>(rows, level, kBc4Snorm)), (bc4BytesOf<AllLanes, 2>(rows, level, kBc4Snorm))) << level;
        EXPECT_EQ((bc4BytesOf<FourLanes, 1>(rows, level, kBc4Unorm)), (bc4BytesOf<AllLanes, 1>(rows, level, kBc4Unorm))) << level;
    }
}

}  // namespace
}  // namespace lightcook::compress::test
HWY_AFTER_NAMESPACE();

// Random and adversarial texels at every effort: nothing crashes, all decoded values are finite, instruction sets agree, and the decoded
// texels of encodeRows are those that the verifier reads. A quarter of a million blocks; in the soak as many as there is time for.
#include "tests/compress/hostile_blocks.h"
#include "tests/compress/against_one_colour.h"
#include "tests/soak/soak.h"

namespace lightcook::compress::test {
namespace {

using formats::PixelFormat;

/// Shares of the blocks for each effort, so that every effort takes about the same time.
constexpr std::array<double, 10> kSoakShares = {0.30, 0.20, 0.15, 0.12, 0.10, 0.06, 0.04, 0.02, 0.008, 0.002};
constexpr int kBlocksAtOnce = 8192;

/// Encodes about blockCount blocks.
void encodeHostile(PixelFormat format, int level, std::int64_t blockCount, std::uint64_t seed) {
    Random random(seed * 131 + static_cast<std::uint64_t>(format) * 17 + static_cast<std::uint64_t>(level));
    while (blockCount > 0) {
        const auto count = static_cast<int>(std::min<std::int64_t>(blockCount, kBlocksAtOnce));
        if (!expectSound(format, makeHostileImage(random, count, level))) return;
        blockCount -= count;
    }
}

/// Gives the texels weights.
void weigh(HostileImage& image, Weights weights, Random& random) {
    formats::Image<float>& significance = image.significance;
    if (weights == Weights::Few) {
        for (float& weight : significance.texels()) weight = static_cast<float>(random.below(4)) / 3;
        return;
    }
    for (int top = 0; top < significance.height(); top += 4)
        for (int left = 0; left < significance.width(); left += 4) {
            const int cut = random.below(4), rowShare = random.below(2), largest = random.below(27);
            for (int t = 0; t < kTexelCount; ++t) {
                const int along = rowShare ? t / 4 : t % 4;
                const float exponent = static_cast<float>(-largest) * (along == 3 ? 0.2f : 1.0f) - random.unit();
                significance.at(left + t % 4, top + t / 4) = along < cut ? 0.0f : std::exp2(exponent);
            }
        }
}

class HostileFormat : public testing::TestWithParam<PixelFormat> {};
std::string nameOf(const testing::TestParamInfo<PixelFormat>& instance) {
    std::string name(formats::info(instance.param).name);
    std::replace(name.begin(), name.end(), '-', '_');
    return name;
}
constexpr auto kBlockFormats = {PixelFormat::Bc1,      PixelFormat::Bc3,      PixelFormat::Bc4,
                                PixelFormat::Bc5,      PixelFormat::Bc4Snorm, PixelFormat::Bc5Snorm,
                                PixelFormat::Bc6hUf16, PixelFormat::Bc6hSf16, PixelFormat::Bc7};

TEST_P(HostileFormat, ManyAreSoundAtCheapEfforts) {
    encodeHostile(GetParam(), 0, 16000, 1);
    encodeHostile(GetParam(), 1, 8000, 1);
    encodeHostile(GetParam(), 3, 4000, 1);
    encodeHostile(GetParam(), 5, 800, 1);
}
INSTANTIATE_TEST_SUITE_P(Encoders, HostileFormat, testing::ValuesIn(kBlockFormats), nameOf);

TEST(HostileBlocks, NoBlockOfUnormFormatsIsWorseThanOneColour) {
    for (const PixelFormat format : {PixelFormat::Bc1, PixelFormat::Bc3, PixelFormat::Bc4, PixelFormat::Bc5, PixelFormat::Bc7})
        for (const int level : {0, 1, 2, 3, 5, 7, 10, 11, 12, 13, 15, 17}) {
            Random random(static_cast<std::uint64_t>(level) + 7);
            HostileImage image = makeHostileImage(random, 2048, level % 10);
            const Weights weights = level < 10 ? Weights::Few : Weights::Wide;
            weigh(image, weights, random);
            const Encoded result = encode(format, image.texels, image.options, image.significance.view());
            int worse = 0;
            for (int y = 0; y < image.texels.height(); y += 4)
                for (int x = 0; x < image.texels.width(); x += 4) {
                    const AgainstOneColour found = againstOneColour(format, image, result.decoded, x, y);
                    if (found.error > mostOf(found.oneColour, weights) && worse++ == 0)
                        ADD_FAILURE() << found.error << " where one colour has " << found.oneColour << "; "
                                      << describeBlock(image, format, x, y);
                }
            EXPECT_EQ(worse, 0) << formats::info(format).name << " effort " << level % 10;
        }
}

TEST(HostileBlocks, NoBlockOfBc6hIsWorseThanOneColour) {
    for (const PixelFormat format : {PixelFormat::Bc6hUf16, PixelFormat::Bc6hSf16})
        for (const int level : {0, 1, 2, 3, 5, 7})
            for (int round = 0; round < 6; ++round) {
                Random random(static_cast<std::uint64_t>(level + 10 * round) + 7);
                HostileImage image = makeHostileImage(random, 1024, level);
                const Weights weights = round < 3 ? Weights::Few : Weights::Wide;
                weigh(image, weights, random);
                const Encoded result = encode(format, image.texels, image.options, image.significance.view());
                int worse = 0;
                for (int y = 0; y < image.texels.height(); y += 4)
                    for (int x = 0; x < image.texels.width(); x += 4) {
                        const AgainstOneColour found = againstOneLight(format, image, result.decoded, x, y);
                        if (found.error > mostOf(found.oneColour, weights) && worse++ == 0)
                            ADD_FAILURE() << found.error << " where one colour has " << found.oneColour << "; "
                                          << describeBlock(image, format, x, y);
                    }
                EXPECT_EQ(worse, 0) << formats::info(format).name << " effort " << level << " round " << round;
            }
}

/// Some branches are taken once for all lanes: mix opaque blocks with others, and hostile blocks with tame ones.
TEST(HostileBlocks, NeighboursDoNotChangeABlock) {
    for (const PixelFormat format : kBlockFormats)
        for (const int level : {1, 3, 6}) {
            Random random(31);
            HostileImage image = makeHostileImage(random, 512, level);
            // Alpha that hardly counts makes modes without alpha good for blocks that are not opaque.
            image.options.channelWeights = {1, 0.25f, 1e-3f, 0.01f};
            for (int y = 0; y < image.texels.height(); ++y)
                for (int x = 0; x < image.texels.width(); ++x) {
                    const int kind = x / 4 % 4;
                    if (kind == 0) continue;
                    for (int c = 0; c < 3; ++c) image.texels.at(x, y)[c] = random.unit();
                    image.texels.at(x, y).a = kind == 1 ? 1.0f : kind == 2 ? 1 - 0.01f * random.unit() : random.unit();
                    image.significance.at(x, y) = 1;
                }
            const std::vector<std::byte> together = encode(format, image.texels, image.options, image.significance.view()).bytes;
            const auto bytesPerBlock = static_cast<std::size_t>(formats::info(format).bytesPerBlock);
            for (std::size_t block = 0; block < together.size() / bytesPerBlock; ++block) {
                const int left = static_cast<int>(block % 64) * 4, top = static_cast<int>(block / 64) * 4;
                HostileImage one{TexelImage(4, 4), formats::Image<float>(4, 4), image.options};
                for (int t = 0; t < kTexelCount; ++t) {
                    one.texels.at(t % 4, t / 4) = image.texels.at(left + t % 4, top + t / 4);
                    one.significance.at(t % 4, t / 4) = image.significance.at(left + t % 4, top + t / 4);
                }
                const std::vector<std::byte> alone = encode(format, one.texels, one.options, one.significance.view()).bytes;
                ASSERT_TRUE(std::equal(alone.begin(), alone.end(), together.begin() + static_cast<std::ptrdiff_t>(block * bytesPerBlock)))
                    << describeBlock(image, format, left, top);
            }
        }
}

TEST(HostileBlocks, SignificanceOfAnySizeGivesTheSameBytes) {
    for (const PixelFormat format : kBlockFormats) {
        Random random(5);
        HostileImage image = makeHostileImage(random, 1024, 4);
        // The first texel of each block has the largest weight, in [1, 2), to which the others are scaled.
        for (int y = 0; y < image.texels.height(); ++y)
            for (int x = 0; x < image.texels.width(); ++x)
                image.significance.at(x, y) = x % 4 == 0 && y % 4 == 0 ? 1.5f : static_cast<float>(random.below(7)) / 4;
        const std::vector<std::byte> bytes = encode(format, image.texels, image.options, image.significance.view()).bytes;
        for (const float scale : {0x1p100f, 0x1p-100f}) {
            formats::Image<float> scaled = image.significance.copy();
            for (float& weight : scaled.texels()) weight *= scale;
            EXPECT_EQ(encode(format, image.texels, image.options, scaled.view()).bytes, bytes)
                << formats::info(format).name << ' ' << scale;
        }
    }
}

class HostileAstc : public testing::TestWithParam<PixelFormat> {};
TEST_P(HostileAstc, ThousandsAreSoundAtCheapEfforts) {
    encodeHostile(GetParam(), 0, 1600, 1);
    encodeHostile(GetParam(), 2, 800, 1);
}
INSTANTIATE_TEST_SUITE_P(Encoders, HostileAstc,
                         testing::Values(PixelFormat::Astc4x4Hdr, PixelFormat::Astc6x6Hdr, PixelFormat::Astc8x8Hdr,
                                         PixelFormat::Astc4x4Ldr),
                         nameOf);

class HostileTexels : public testing::TestWithParam<PixelFormat> {};
TEST_P(HostileTexels, FormatsWithoutBlocksAreSound) {
    encodeHostile(GetParam(), 5, 5000, 1);
}
INSTANTIATE_TEST_SUITE_P(Encoders, HostileTexels,
                         testing::Values(PixelFormat::Rgb9e5, PixelFormat::R11g11b10f, PixelFormat::Rgba16f, PixelFormat::Rgb16f,
                                         PixelFormat::R16Unorm, PixelFormat::Rg16Unorm, PixelFormat::Rgba16Unorm, PixelFormat::Rgba8Unorm,
                                         PixelFormat::Rgba8Srgb),
                         nameOf);

class HostileBlocksSoak : public testing::TestWithParam<PixelFormat> {};
TEST_P(HostileBlocksSoak, EveryEffort) {
    constexpr double kBlocks = 10000;
    lightcook::test::repeatInSoak("blocks encoded", static_cast<std::int64_t>(kBlocks), [](std::uint64_t seed) {
        for (int level = 0; level < 10; ++level)
            encodeHostile(GetParam(), level, std::llround(kBlocks * kSoakShares[static_cast<std::size_t>(level)]), seed);
    });
}
INSTANTIATE_TEST_SUITE_P(Encoders, HostileBlocksSoak, testing::ValuesIn(kBlockFormats), nameOf);

}  // namespace
}  // namespace lightcook::compress::test

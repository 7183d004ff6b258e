// BC4 and BC5 against an exhaustive search over every pair of endpoints.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "compress/block/block.h"
#include "compress/block/decode.h"
#include "tests/compress/codec_images.h"

namespace lightcook::compress::test {
namespace {

using formats::PixelFormat;

double blockError(const std::array<double, 16>& codes, const std::array<double, 8>& palette, int count, double limit) {
    double error = 0;
    for (const double code : codes) {
        double nearest = 1e9;
        for (int i = 0; i < count; ++i) nearest = std::min(nearest, std::abs(code - palette[static_cast<std::size_t>(i)]));
        error += nearest * nearest;
        if (error > limit) break;
    }
    return error;
}

/// Returns the least error of any block [codes^2].
double exhaustiveError(const std::array<double, 16>& codes, double startLimit) {
    double best = startLimit;
    std::array<double, 8> palette{};
    for (int low = 0; low < 256; ++low)
        for (int high = low; high < 256; ++high) {
            for (int i = 0; i < 8; ++i) palette[static_cast<std::size_t>(i)] = low + (high - low) * i / 7.0;
            if (high > low) best = std::min(best, blockError(codes, palette, 8, best));
            for (int i = 0; i < 6; ++i) palette[static_cast<std::size_t>(i)] = low + (high - low) * i / 5.0;
            palette[6] = 0;
            palette[7] = 255;
            best = std::min(best, blockError(codes, palette, 8, best));
        }
    return best;
}

std::array<double, 16> randomCodes(Random& random) {
    std::array<double, 16> codes;
    const double base = static_cast<double>(random.unit()) * 255, range = std::pow(static_cast<double>(random.unit()), 2) * 255;
    const int kind = random.below(4);
    for (double& code : codes) {
        code = std::clamp(base + range * (static_cast<double>(random.unit()) - 0.5), 0.0, 255.0);
        if (kind == 1 && random.below(4) == 0) code = random.below(2) * 255;
        if (kind == 2) code = std::nearbyint(code);
        if (kind == 3) code = static_cast<double>(random.unit()) * 255;
    }
    return codes;
}

TEST(Bc4, HighestEffortEqualsExhaustiveSearch) {
    Random random(21);
    double sumDefault = 0, sumBest = 0;
    for (int block = 0; block < 1000; ++block) {
        const auto codes = randomCodes(random);
        const auto image =
            imageOf(4, 4, [&](int x, int y) { return glm::vec4(codes[static_cast<std::size_t>(y * 4 + x)] / 255, 0, 0, 1); });
        const double error = std::pow(rmsError(encode(PixelFormat::Bc4, image, effort(9)).decoded, image, 1) * 255, 2) * 16;
        const double best = exhaustiveError(codes, error);
        ASSERT_LE(error, best * (1 + 1e-4) + 1e-4) << "block " << block;
        sumBest += best;
        sumDefault += std::pow(rmsError(encode(PixelFormat::Bc4, image, effort(5)).decoded, image, 1) * 255, 2) * 16;
    }
    // Mostly noise, where it is hardest.
    EXPECT_LE(10 * std::log10(sumDefault / sumBest), 0.05);
}

/// Blocks of noise, slopes and clipped slopes.
TEST(Bc4, EveryEffortIsBetterThanTheOneBefore) {
    Random random(24);
    std::vector<std::array<double, 16>> blocks(512);
    for (auto& codes : blocks) codes = randomCodes(random);
    const auto image = imageOf(4 * 512, 4, [&](int x, int y) {
        return glm::vec4(blocks[static_cast<std::size_t>(x / 4)][static_cast<std::size_t>(y * 4 + x % 4)] / 255, 0, 0, 1);
    });
    double before = 1e9;
    for (int level = 0; level <= 9; ++level) {
        const double error = rmsError(encode(PixelFormat::Bc4, image, effort(level)).decoded, image, 1);
        EXPECT_LT(error, before) << "effort " << level;
        before = error;
    }
}

TEST(Bc4, OneValueErrsByAtMostAFourteenthOfACode) {
    Random random(22);
    for (int i = 0; i < 4000; ++i) {
        const float value = i < 256 ? static_cast<float>(i) / 255 : random.unit();
        const auto image = imageOf(4, 4, [&](int, int) { return glm::vec4(value, 0, 0, 1); });
        const Encoded result = encode(PixelFormat::Bc4, image);
        // Sevenths of a code can be reached, so a fourteenth is half a step.
        ASSERT_NEAR(result.decoded.at(2, 2).r * 255, value * 255, 1.0 / 14 + 1e-4) << value;
    }
}

TEST(Bc5, ChannelsAreThoseOfTwoBc4) {
    Random random(23);
    const auto image = imageOf(16, 16, [&](int, int) { return glm::vec4(random.unit(), random.unit(), 0, 1); });
    const auto green = imageOf(16, 16, [&](int x, int y) { return glm::vec4(image.at(x, y).g, 0, 0, 1); });
    const Encoded both = encode(PixelFormat::Bc5, image), first = encode(PixelFormat::Bc4, image), second = encode(PixelFormat::Bc4, green);
    for (std::size_t block = 0; block < 16; ++block)
        for (std::size_t i = 0; i < 8; ++i) {
            EXPECT_EQ(both.bytes[16 * block + i], first.bytes[8 * block + i]);
            EXPECT_EQ(both.bytes[16 * block + 8 + i], second.bytes[8 * block + i]);
        }
}

/// The same kernel reads rows of texels (BC4) and gathered blocks (the alpha of BC3).
/// Gathers the first channel of an image into blocks. Texels beyond the edge repeat it and have significance 0.
std::vector<Block> gatheredBlocks(const TexelImage& image, formats::ImageView<const float> significance) {
    std::vector<Block> blocks;
    for (int top = 0; top < image.height(); top += 4)
        for (int left = 0; left < image.width(); left += 4) {
            Block& block = blocks.emplace_back();
            for (int t = 0; t < kTexelCount; ++t) {
                const int x = left + t % 4, y = top + t / 4;
                const bool inside = x < image.width() && y < image.height();
                block.channel[0][static_cast<std::size_t>(t)] = image.at(std::min(x, image.width() - 1), std::min(y, image.height() - 1)).r;
                block.significance[static_cast<std::size_t>(t)] = !inside ? 0.0f : significance.texels ? significance.at(x, y) : 1.0f;
            }
        }
    return blocks;
}

/// The fast kernel of effort 0 makes the search of the other kernel in 16-bit integers.
TEST(Bc4, TheFastKernelIsAsGoodAsTheOther) {
    Random random(26);
    constexpr int kBlocks = 1024;
    for (const float scale : {1.0f, 0.1f, 0.01f, 0.001f}) {
        std::vector<std::array<double, 16>> blocks(kBlocks);
        for (auto& codes : blocks) codes = randomCodes(random);
        const float offset = (1 - scale) * random.unit();
        const auto image = imageOf(4 * kBlocks, 4, [&](int x, int y) {
            const double code = blocks[static_cast<std::size_t>(x / 4)][static_cast<std::size_t>(y * 4 + x % 4)];
            return glm::vec4(offset + scale * static_cast<float>(code / 255), 0, 0, 1);
        });
        const Encoded fast = encode(PixelFormat::Bc4, image, effort(0));
        const std::vector<Block> gathered = gatheredBlocks(image, {});
        std::vector<std::byte> bytes(8 * gathered.size());
        encodeBc4(gathered, false, effort(0), bytes.data());
        double fastError = 0, error = 0;
        for (int i = 0; i < kBlocks; ++i) {
            DecodedBlock decoded;
            decodeBlock(PixelFormat::Bc4, bytes.data() + 8 * i, decoded);
            for (int t = 0; t < kTexelCount; ++t) {
                const int x = 4 * i + t % 4, y = t / 4;
                fastError += std::pow(fast.decoded.at(x, y).r - image.at(x, y).r, 2);
                error += std::pow(decoded[static_cast<std::size_t>(t)].r - image.at(x, y).r, 2);
            }
        }
        EXPECT_LE(fastError, 1.002 * error) << scale;  // 0.01 dB
    }
}

TEST(Bc4, RowsGiveTheBytesOfBlocks) {
    Random random(25);
    std::vector<std::array<double, 16>> blocks(81);
    for (auto& codes : blocks) codes = randomCodes(random);
    blocks[7].fill(blocks[7][0]);
    const auto image = imageOf(4 * 27 - 2, 4 * 3 - 1, [&](int x, int y) {
        const auto& codes = blocks[static_cast<std::size_t>(y / 4 * 27 + x / 4)];
        const float value = static_cast<float>(codes[static_cast<std::size_t>(y % 4 * 4 + x % 4)] / 255);
        return glm::vec4(value, value, value, value);
    });
    formats::Image<float> significance(image.width(), image.height());
    for (float& weight : significance.texels()) weight = 0.25f * static_cast<float>(1 + random.below(4));
    for (const bool isWeighed : {false, true})
        for (int level = 0; level < 9; ++level) {
            formats::ImageView<const float> weights;
            if (isWeighed) weights = significance.view();
            const Encoded rows = encode(PixelFormat::Bc4, image, effort(level), weights);
            const std::vector<Block> gathered = gatheredBlocks(image, weights);
            std::vector<std::byte> bytes(8 * gathered.size());
            encodeBc4(gathered, false, effort(level), bytes.data());
            for (std::size_t i = 0; i < bytes.size(); ++i) ASSERT_EQ(rows.bytes[i], bytes[i]) << "effort " << level << ", block " << i / 8;
            if (level <= 2) continue;  // where BC3 leaves more of the time to colour
            const Encoded alpha = encode(PixelFormat::Bc3, image, effort(level), weights);
            for (std::size_t i = 0; i < bytes.size(); ++i)
                ASSERT_EQ(alpha.bytes[i / 8 * 16 + i % 8], bytes[i]) << "effort " << level << ", block " << i / 8;
        }
}

}  // namespace
}  // namespace lightcook::compress::test

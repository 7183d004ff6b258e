// Rate-distortion optimization: no row exceeds the allowed error, by an independent metric and the decoders of verify/.
#include "compress/block/rdo.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "compress/block/block_head.h"
#include "tests/compress/codec_images.h"
#include "verify/texture_unit.h"

namespace lightcook::compress::test {
namespace {

using formats::PixelFormat;

constexpr std::array kFormats = {PixelFormat::Bc1,      PixelFormat::Bc3, PixelFormat::Bc4,      PixelFormat::Bc4Snorm, PixelFormat::Bc5,
                                 PixelFormat::Bc5Snorm, PixelFormat::Bc7, PixelFormat::Bc6hUf16, PixelFormat::Bc6hSf16};

std::vector<NamedImage> imagesFor(PixelFormat format) {
    std::vector<NamedImage> images = formats::info(format).isFloat ? lightImages() : unitImages();
    if (formats::info(format).isSigned)
        for (NamedImage& named : images)
            for (glm::vec4& texel : named.image.texels()) texel.x = texel.x > texel.y ? -texel.x : texel.x;
    return images;
}

/// Returns the weighted squared error of each row of blocks.
/// ofValues  of the values, weighted by the roots of the significance, in place of the metric
std::vector<double> rowErrors(PixelFormat format, const TexelImage& image, const formats::Image<float>& significance,
                              const EncodeOptions& options, const std::vector<std::byte>& bytes, bool ofValues) {
    TexelImage read(image.width(), image.height());
    verify::decodeRows(format, bytes, read.view());
    const double scale = static_cast<double>(options.hdrScale);
    const auto mapped = [&](double x) { return std::copysign(std::log2(1 + std::abs(x) / scale), x); };
    const bool hasMetric = formats::info(format).isFloat && !ofValues;
    std::vector<double> errors(static_cast<std::size_t>((image.height() + 3) / 4));
    for (int y = 0; y < image.height(); ++y)
        for (int x = 0; x < image.width(); ++x)
            for (int c = 0; c < formats::info(format).channelCount; ++c) {
                const double wanted = static_cast<double>(image.at(x, y)[c]), found = static_cast<double>(read.at(x, y)[c]);
                const double weight = static_cast<double>(significance.at(x, y));
                double difference = found - wanted;
                if (hasMetric && options.hdrMetric == HdrMetric::Log) difference = mapped(found) - mapped(wanted);
                if (hasMetric && options.hdrMetric == HdrMetric::Relative) difference /= std::abs(wanted) + scale;
                errors[static_cast<std::size_t>(y / 4)] += (ofValues ? std::sqrt(weight) : weight) *
                                                           static_cast<double>(options.channelWeights[static_cast<std::size_t>(c)]) *
                                                           difference * difference;
            }
    return errors;
}

TEST(ReduceRow, NoRowPaysMoreThanItsShare) {
    formats::Image<float> all(64, 64, 1.0f), some(64, 64, 1.0f);
    Random random(5);
    for (float& weight : some.texels()) weight = random.below(4) == 0 ? 0.0f : std::exp2(static_cast<float>(random.below(20) - 10));
    for (const PixelFormat format : kFormats)
        for (const NamedImage& named : imagesFor(format))
            for (const float rdo : {0.02f, 0.3f})
                for (const auto* significance : {&all, &some})
                    for (const HdrMetric metric : {HdrMetric::Log, HdrMetric::Linear, HdrMetric::Relative}) {
                        if (metric != HdrMetric::Log && !formats::info(format).isFloat) continue;
                        EncodeOptions options = effort(1);
                        options.hdrMetric = metric;
                        options.hdrScale = 0.25f;
                        options.channelWeights = {1, 0.5f, 2, 1};
                        const auto plain = encode(format, named.image, options, significance->view()).bytes;
                        options.rdo = rdo;
                        const auto reduced = encode(format, named.image, options, significance->view()).bytes;
                        const double growth = std::pow(1 + static_cast<double>(rdo), 2);
                        for (const bool ofValues : {false, true}) {
                            const bool hasValueError = formats::info(format).isFloat && metric != HdrMetric::Linear;
                            if (ofValues && !hasValueError) continue;
                            const auto before = rowErrors(format, named.image, *significance, options, plain, ofValues);
                            const auto after = rowErrors(format, named.image, *significance, options, reduced, ofValues);
                            for (std::size_t row = 0; row < after.size(); ++row)
                                // The encoder's logarithm is off by up to 2e-5, which counts where there is hardly any error.
                                EXPECT_LE(after[row], 1.001 * growth * before[row] + 1e-6 * *std::max_element(before.begin(), before.end()))
                                    << formats::info(format).name << ' ' << named.name << ' ' << rdo << ", row " << row << ", of values "
                                    << ofValues;
                        }
                    }
}

TEST(ReduceRow, OnlyRatiosOfWeightsCount) {
    Random random(8);
    const auto image = imageOf(256, 4, [&](int, int) { return glm::vec4(random.unit(), random.unit(), random.unit(), random.unit()); });
    for (const PixelFormat format : kFormats) {
        EncodeOptions options = effort(1);
        options.rdo = 0.05f;
        const std::vector<std::byte> plain = encode(format, image, options).bytes;
        for (const float weight : {0x1p-149f, 0x1p-130f, 0x1p-100f, 0x1p127f}) {
            const formats::Image<float> significance(256, 4, weight);
            EXPECT_EQ(encode(format, image, options, significance.view()).bytes, plain) << formats::info(format).name << ' ' << weight;
        }
    }
}

TEST(ReduceRow, CutsBetweenRowsGiveTheSameBytesAndDecodedIsOfTheFinalOnes) {
    Random random(6);
    const auto image = imageOf(53, 23, [&](int x, int) { return glm::vec4(random.unit(), 0.5f, static_cast<float>(x % 7) / 6, 1); });
    EncodeOptions options = effort(2);
    options.rdo = 0.2f;
    for (const PixelFormat format : kFormats) {
        const Encoded whole = encode(format, image, options);
        std::vector<std::byte> cut;
        for (int y = 0; y < image.height(); y += 8) {
            const int count = std::min(8, image.height() - y);
            std::vector<std::byte> part(formats::bytesPerImage(format, image.width(), count));
            encodeRows(format, image.view().rows(y, count), {}, options, part, {});
            cut.insert(cut.end(), part.begin(), part.end());
        }
        EXPECT_EQ(cut, whole.bytes) << formats::info(format).name;
        TexelImage read(image.width(), image.height());
        verify::decodeRows(format, whole.bytes, read.view());
        for (std::size_t i = 0; i < read.texels().size(); ++i)
            for (int c = 0; c < 4; ++c)
                ASSERT_NEAR(whole.decoded.texels()[i][c], read.texels()[i][c], 1e-6) << formats::info(format).name << ' ' << i;
    }
}

TEST(ReduceRow, TexelsWithoutSignificanceAreFreeAndExactOnesStayExact) {
    EncodeOptions options = effort(2);
    options.rdo = 0.05f;
    Random random(7);
    const auto noise = imageOf(64, 8, [&](int, int) { return glm::vec4(random.unit(), random.unit(), random.unit(), random.unit()); });
    const formats::Image<float> nothing(64, 8, 0.0f);
    const auto constant = imageOf(64, 8, [](int, int) { return glm::vec4(1); });
    const auto one = imageOf(1, 1, [](int, int) { return glm::vec4(0.25f); });
    for (const PixelFormat format : kFormats) {
        const std::size_t bytesPerBlock = static_cast<std::size_t>(formats::info(format).bytesPerBlock);
        const Encoded free = encode(format, noise, options, nothing.view());
        for (std::size_t i = bytesPerBlock; i < free.bytes.size() / 2; ++i) ASSERT_EQ(free.bytes[i], free.bytes[i - bytesPerBlock]) << i;
        const Encoded plain = encode(format, constant, effort(2));
        EXPECT_EQ(encode(format, constant, options).decoded.texels(), plain.decoded.texels()) << formats::info(format).name;
        EXPECT_EQ(encode(format, one, options).bytes, encode(format, one, effort(2)).bytes) << formats::info(format).name;
    }
}

/// The largest squared error that a texel of padding adds to its own, over the mean squared error of the texels, both of the plain blocks.
/// Every second block of the row is padding, of noise, with this weight.
double worstGrowthOfPadding(PixelFormat format, float weight, float rdo) {
    constexpr int kWidth = 256;
    Random random(8);
    const auto isPadding = [](int x) { return x / 4 % 2 == 1; };
    const auto image = imageOf(kWidth, 4, [&](int x, int y) {
        const float near = isPadding(x) ? random.unit() : 0.4f + 0.002f * static_cast<float>(x % 4 + y) + 0.02f * random.unit();
        return glm::vec4(near, near * 0.9f, near * 0.8f, 1);
    });
    formats::Image<float> significance(kWidth, 4, 1.0f);
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < kWidth; ++x)
            if (isPadding(x)) significance.at(x, y) = weight;
    EncodeOptions options = effort(3);
    const Encoded plain = encode(format, image, options, significance.view());
    options.rdo = rdo;
    const Encoded reduced = encode(format, image, options, significance.view());
    const auto errorAt = [&](const Encoded& encoded, int x, int y) {
        double sum = 0;
        for (int c = 0; c < formats::info(format).channelCount; ++c)
            sum += std::pow(static_cast<double>(encoded.decoded.at(x, y)[c]) - static_cast<double>(image.at(x, y)[c]), 2);
        return sum;
    };
    double total = 0, totalWeight = 0, worst = 0;
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < kWidth; ++x) {
            total += static_cast<double>(significance.at(x, y)) * errorAt(plain, x, y);
            totalWeight += static_cast<double>(significance.at(x, y));
            if (isPadding(x)) worst = std::max(worst, errorAt(reduced, x, y) - errorAt(plain, x, y));
        }
    return worst * totalWeight / total;
}

TEST(ReduceRow, PaddingThatFiltersReadErrsByALimitedAmount) {
    for (const PixelFormat format : {PixelFormat::Bc1, PixelFormat::Bc4, PixelFormat::Bc7}) {
        const char* const name = formats::info(format).name.data();
        EXPECT_LE(worstGrowthOfPadding(format, 1.0f / 256, 0.2f), 256 * 1.001) << name;
        EXPECT_GT(worstGrowthOfPadding(format, 1.0f / 65536, 0.2f), 2 * 256) << name;  // the second row of padding is free
    }
}

TEST(ReduceRow, Bc1NeverUsesTheIndexThatSomeReadersDecodeToTransparent) {
    // Block 0 has four bright colours, all texels of index 3. Block 1 has three dark ones (first <= second), where index 3 is black to our
    // decoder: the indices of block 0 would cost it little.
    std::vector<std::byte> row;
    for (const int byte : {0xFF, 0xFF, 0x10, 0x84, 0xFF, 0xFF, 0xFF, 0xFF, 0x00, 0x00, 0x01, 0x00, 0x00, 0x08, 0x00, 0x00})
        row.push_back(static_cast<std::byte>(byte));
    TexelImage image(8, 4);
    verify::decodeRows(PixelFormat::Bc1, row, image.view());
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x) image.at(x, y) += glm::vec4(0.01f, 0.01f, 0.01f, 0);  // an error that may grow
    EncodeOptions options;
    options.rdo = 1;
    const std::vector<std::byte> before = row;
    reduceRow(PixelFormat::Bc1, image.view(), {}, options, row);
    EXPECT_EQ(row, before);
}

TEST(ReduceRow, BlocksTakeOverHeadsWithIndicesOfTheirOwn) {
    Random random(9);
    const auto image = imageOf(256, 64, [&](int x, int y) {
        const float ramp = static_cast<float>((x * 7 + y * 13) % 32) / 31, noise = 0.02f * random.unit();
        return glm::vec4(0.2f + 0.4f * ramp + noise, 0.3f + 0.3f * ramp, 0.5f - 0.2f * ramp + noise, 1);
    });
    // Blocks with the whole head of one before them in their row, and other indices.
    const auto headsThatRepeat = [](PixelFormat format, const std::vector<std::byte>& bytes) {
        constexpr std::size_t kBlocksAcross = 64, kReach = 32;
        int count = 0;
        for (std::size_t block = 0; block < bytes.size() / 16; ++block)
            for (std::size_t back = 1; back <= std::min(block % kBlocksAcross, kReach); ++back) {
                const std::byte *own = bytes.data() + 16 * block, *other = own - 16 * back;
                const std::size_t size = static_cast<std::size_t>(headOf(format, own).bits) / 8;
                if (!std::equal(own, own + size, other) || std::equal(own, own + 16, other)) continue;
                ++count;
                break;
            }
        return count;
    };
    for (const PixelFormat format : {PixelFormat::Bc6hUf16, PixelFormat::Bc7}) {
        EncodeOptions options = effort(1);
        const int plain = headsThatRepeat(format, encode(format, image, options).bytes);
        options.rdo = 0.1f;
        EXPECT_GT(headsThatRepeat(format, encode(format, image, options).bytes), plain + 100) << formats::info(format).name;
    }
}

}  // namespace
}  // namespace lightcook::compress::test

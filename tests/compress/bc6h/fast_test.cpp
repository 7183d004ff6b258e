// BC6H's fast kernel: the same bytes at any vector width, and extreme values of light maps.
#include "compress/block/highway_targets.h"

#include <gtest/gtest.h>

#include <hwy/targets.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "compress/bc6h/fast-inl.h"
#include "compress/bc6h/narrow-inl.h"
#include "compress/texel/half.h"
#include "tests/compress/codec_images.h"

// The kernels are compiled for Highway's target, so the code that inlines them must be too.
HWY_BEFORE_NAMESPACE();
namespace lightcook::compress::test {
namespace {

using formats::PixelFormat;
namespace kernel = HWY_NAMESPACE;

constexpr std::array kBothFormats = {PixelFormat::Bc6hUf16, PixelFormat::Bc6hSf16};
constexpr int kRowBlocks = 64;

/// A row of blocks: smooth, noisy, dark beside bright light sources, of one colour; and their significance, 0 throughout some blocks.
struct RowOfBlocks {
    TexelImage texels{4 * kRowBlocks, 4};
    formats::Image<float> significance{4 * kRowBlocks, 4};

    explicit RowOfBlocks(bool withSigns) {
        Random random(61);
        for (int block = 0; block < kRowBlocks; ++block) {
            const int kind = random.below(4), weighing = random.below(4);
            const float base = std::exp2(random.unit() * 30 - 15);
            for (int t = 0; t < kTexelCount; ++t) {
                glm::vec4& texel = texels.at(4 * block + t % 4, t / 4);
                for (int c = 0; c < 4; ++c) {
                    texel[c] = kind == 0 ? base : base * (1 + static_cast<float>(t) * 0.1f * random.unit());
                    if (kind == 2 && random.below(3) == 0) texel[c] = 0;
                    if (kind == 3) texel[c] = 65504 * random.unit();
                    if (withSigns && random.below(2)) texel[c] = -texel[c];
                }
                significance.at(4 * block + t % 4, t / 4) = weighing == 0   ? 0.0f
                                                            : weighing == 1 ? static_cast<float>(random.below(3))
                                                                            : 1.0f;
            }
        }
    }
};

template <class D, bool kSigned>
std::vector<std::uint32_t> fastWordsOf(const RowOfBlocks& row, bool weighted, std::vector<float>& errors) {
    const std::size_t lanes = kernel::hn::Lanes(D());
    std::vector<std::uint32_t> words(4 * kRowBlocks);
    errors.assign(kRowBlocks, -1.0f);
    const EncodeOptions options;
    kernel::Bc6hFast<D, kSigned> fit(options);
    for (std::size_t block = 0; block < kRowBlocks; block += lanes) {
        std::array<const float*, 4> texels, weights;
        for (std::size_t y = 0; y < 4; ++y) {
            texels[y] = &row.texels.texels()[(y * kRowBlocks + block) * 4].x;
            weights[y] = &row.significance.texels()[(y * kRowBlocks + block) * 4];
        }
        fit.run(texels, weighted ? &weights : nullptr, words.data() + 4 * block, errors.data() + block);
    }
    return words;
}

template <bool kSigned>
void expectSameAtAnyWidth() {
    const RowOfBlocks row(kSigned);
    for (const bool weighted : {false, true}) {
        std::vector<float> oneErrors, allErrors;
        const auto one = fastWordsOf<kernel::hn::CappedTag<float, 1>, kSigned>(row, weighted, oneErrors);
        const auto all = fastWordsOf<kernel::hn::ScalableTag<float>, kSigned>(row, weighted, allErrors);
        EXPECT_EQ(one, all);
        EXPECT_EQ(oneErrors, allErrors);
    }
}

TEST(Bc6hFast, OneLaneMatchesAVectorOfThem) {
    expectSameAtAnyWidth<false>();
    expectSameAtAnyWidth<true>();
}

/// Encodes a row by the kernel of narrow blocks. Words of blocks that it leaves become 0.
template <class D>
std::vector<std::uint32_t> narrowWordsOf(const RowOfBlocks& row, bool weighted, const EncodeOptions& options, std::vector<float>& errors) {
    const std::size_t lanes = kernel::hn::Lanes(D());
    std::vector<std::uint32_t> words(4 * kRowBlocks);
    errors.assign(kRowBlocks, 0);
    kernel::Bc6hNarrow<D> fit(options);
    for (std::size_t block = 0; block <= kRowBlocks; block += lanes) {
        std::array<const float*, 4> texels, weights;
        for (std::size_t y = 0; y < 4; ++y) {
            texels[y] = &row.texels.texels()[(y * kRowBlocks + block % kRowBlocks) * 4].x;
            weights[y] = &row.significance.texels()[(y * kRowBlocks + block % kRowBlocks) * 4];
        }
        fit.begin(texels, weighted ? &weights : nullptr);
        if (block > 0) fit.finish(words.data() + 4 * (block - lanes), errors.data() + block - lanes);
        if (block < kRowBlocks) fit.fitLine();
    }
    for (std::size_t block = 0; block < kRowBlocks; ++block)
        if (errors[block] < 0 || std::isinf(errors[block])) std::fill_n(words.data() + 4 * block, 4, 0);
    return words;
}

/// A row of blocks of ranges up to a factor of two, from dark to bright. All texels of a third of them count, and some texels of the
/// others.
RowOfBlocks rowOfNarrowBlocks() {
    Random random(17);
    RowOfBlocks row(false);
    for (int block = 0; block < kRowBlocks; ++block) {
        const float base = std::exp2(random.unit() * 12 - 6), range = random.unit();
        const bool allCount = random.below(3) == 0;
        for (int t = 0; t < kTexelCount; ++t) {
            for (int c = 0; c < 4; ++c)
                row.texels.at(4 * block + t % 4, t / 4)[c] = base * (1 + range * static_cast<float>(t) / 16 + 0.1f * random.unit());
            row.significance.at(4 * block + t % 4, t / 4) = allCount || random.below(3) > 0 ? 1.0f : 0.0f;
        }
    }
    return row;
}

TEST(Bc6hNarrow, FourLanesMatchAVectorOfThem) {
    const RowOfBlocks row = rowOfNarrowBlocks();
    for (const HdrMetric metric : {HdrMetric::Log, HdrMetric::Linear, HdrMetric::Relative})
        for (const bool weighted : {false, true}) {
            EncodeOptions options;
            options.hdrMetric = metric;
            std::vector<float> fourErrors, allErrors;
            const auto four = narrowWordsOf<kernel::hn::CappedTag<float, 4>>(row, weighted, options, fourErrors);
            const auto all = narrowWordsOf<kernel::hn::ScalableTag<float>>(row, weighted, options, allErrors);
            EXPECT_EQ(four, all);
            EXPECT_EQ(fourErrors, allErrors);
            EXPECT_GT(std::count_if(allErrors.begin(), allErrors.end(), [](float error) { return error >= 0 && std::isfinite(error); }),
                      kRowBlocks / 2);
        }
}

TEST(Bc6hFast, EveryInstructionSetGivesTheSameBytes) {
    const std::vector<std::int64_t> targets = hwy::SupportedAndGeneratedTargets();
    if (targets.size() < 2) GTEST_SKIP() << "this machine has one instruction set";
    // An odd width, so that rows of blocks end in the middle of a vector.
    const RowOfBlocks row(true);
    const auto image = imageOf(251, 4, [&](int x, int y) { return row.texels.at(x, y); });
    formats::Image<float> significance(251, 4);
    for (int y = 0; y < 4; ++y) std::copy_n(&row.significance.at(0, y), 251, &significance.at(0, y));
    for (const PixelFormat format : kBothFormats)
        for (const int level : {0, 1, 2}) {
            std::vector<std::byte> first;
            for (const std::int64_t target : targets) {
                hwy::GetChosenTarget().Update(target);
                const std::vector<std::byte> bytes = encode(format, image, effort(level), significance.view()).bytes;
                if (first.empty()) first = bytes;
                EXPECT_EQ(bytes, first) << formats::info(format).name << " effort " << level;
            }
        }
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

TEST(Bc6hFast, EveryColourOfHalvesIsExact) {
    for (int bits = 0; bits < 0x7C00; bits += 7) {
        glm::vec4 colour(0, 0, 0, 1);
        for (int c = 0; c < 3; ++c) colour[c] = floatFromHalf(static_cast<std::uint16_t>(std::min(bits + c, 0x7BFF)));
        const auto image = imageOf(4, 4, [&](int, int) { return colour; });
        ASSERT_EQ(encode(PixelFormat::Bc6hUf16, image, effort(0)).decoded.at(2, 1), colour) << bits;
        ASSERT_EQ(encode(PixelFormat::Bc6hSf16, image, effort(0)).decoded.at(2, 1), colour) << bits;
        const auto negative = imageOf(4, 4, [&](int, int) { return glm::vec4(-colour.r, -colour.g, -colour.b, 1); });
        ASSERT_EQ(encode(PixelFormat::Bc6hSf16, negative, effort(0)).decoded.at(2, 1), negative.at(0, 0)) << bits;
    }
}

TEST(Bc6hFast, NegativeZeroIsZeroAndClampedValuesAreCounted) {
    const auto image = [](const glm::vec4& colour) { return imageOf(4, 4, [&](int, int) { return colour; }); };
    for (const PixelFormat format : kBothFormats) {
        const Encoded zero = encode(format, image({-0.0f, 0.0f, -0.0f, 1}), effort(0));
        EXPECT_EQ(zero.decoded.at(3, 3), glm::vec4(0, 0, 0, 1));
        EXPECT_FALSE(std::signbit(zero.decoded.at(3, 3).r));
        const Encoded beyond = encode(format, image({1e30f, -1e30f, 65504, 1}), effort(0));
        const bool isSigned = format == PixelFormat::Bc6hSf16;
        EXPECT_EQ(beyond.decoded.at(0, 0), glm::vec4(65504, isSigned ? -65504 : 0, 65504, 1));
        EXPECT_EQ(beyond.report.clampedHigh, isSigned ? 32 : 16);
        EXPECT_EQ(beyond.report.clampedNegative, isSigned ? 0 : 16);
    }
}

TEST(Bc6hFast, TexelsThatWeighNothingOrLieBeyondTheEdgeDoNotMatter) {
    const glm::vec4 colour(0.3f, 60000, 0, 1);
    for (const PixelFormat format : kBothFormats) {
        const glm::vec4 clean = encode(format, imageOf(4, 4, [&](int, int) { return colour; }), effort(0)).decoded.at(0, 0);
        const auto dirty = imageOf(7, 6, [&](int x, int y) { return x == 5 || y == 2 ? glm::vec4(65504, 0, 7, 1) : colour; });
        formats::Image<float> significance(7, 6);
        for (int y = 0; y < 6; ++y)
            for (int x = 0; x < 7; ++x) significance.at(x, y) = x == 5 || y == 2 ? 0.0f : 3.0f;
        const Encoded found = encode(format, dirty, effort(0), significance.view());
        for (int y = 0; y < 6; ++y)
            for (int x = 0; x < 7; ++x)
                if (significance.at(x, y) > 0) {
                    EXPECT_EQ(found.decoded.at(x, y), clean) << x << ' ' << y;
                }
    }
}

TEST(Bc6hFast, ABlockThatWeighsNothingIsCodedAsIfItCounted) {
    const RowOfBlocks row(false);
    formats::Image<float> nothing(4 * kRowBlocks, 4, 0.0f);
    EXPECT_EQ(encode(PixelFormat::Bc6hUf16, row.texels, effort(0), nothing.view()).bytes,
              encode(PixelFormat::Bc6hUf16, row.texels, effort(0)).bytes);
}

TEST(Bc6hFast, ExtremesStayFiniteInEveryMetric) {
    Random random(62);
    const auto extreme = [&] {
        constexpr float kSome[] = {0, 3e38f, -3e38f, 1e-45f, 65504, -0.0f, 6e-8f, 6.1e-5f, 1};
        return random.below(2) ? kSome[random.below(9)] : std::ldexp(random.unit() - 0.5f, random.below(60) - 40);
    };
    const auto image = imageOf(128, 64, [&](int, int) { return glm::vec4(extreme(), extreme(), extreme(), extreme()); });
    formats::Image<float> significance(128, 64);
    for (float& weight : significance.texels()) weight = random.below(3) ? std::ldexp(random.unit(), random.below(40) - 20) : 0.0f;
    for (const PixelFormat format : kBothFormats)
        for (const HdrMetric metric : {HdrMetric::Log, HdrMetric::Linear, HdrMetric::Relative})
            for (const int level : {0, 1}) {
                EncodeOptions options = effort(level);
                options.hdrMetric = metric;
                const Encoded found = encode(format, image, options, significance.view());
                for (const glm::vec4& texel : found.decoded.texels())
                    for (int c = 0; c < 3; ++c) ASSERT_LE(std::abs(texel[c]), 65504) << formats::info(format).name;
            }
}

}  // namespace
}  // namespace lightcook::compress::test
HWY_AFTER_NAMESPACE();

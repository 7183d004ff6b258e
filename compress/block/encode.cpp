// encodeRows: chooses the encoder of each format and effort.
//
// BC1, BC3, BC4, BC5 and BC7, and BC6H at low effort, have kernels that read rows of texels. They clamp values themselves, and RangeClamp
// only counts these. The other efforts gather batches of blocks for the full search (block.h). BC6H and BC7 combine both: the full search
// encodes some or all blocks again. Rate-distortion optimization (rdo.h) and decoding follow, row by row. ASTC and formats without blocks
// have encoders in texel/.
#include "compress/encode.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <vector>

#include "compress/bc1/search.h"
#include "compress/bc4/search.h"
#include "compress/bc6h/search.h"
#include "compress/bc7/search.h"
#include "compress/block/block.h"
#include "compress/block/decode.h"
#include "compress/block/rdo.h"
#include "compress/texel/astc.h"
#include "compress/texel/packed_texels.h"

namespace lightcook::compress {
namespace {

using formats::ImageView;
using formats::PixelFormat;

/// Number of blocks that are passed to an encoder at once: a multiple of the lanes of any vector, small enough for the L1 cache.
constexpr int kBatch = 512;

/// Clamps texels into the range of a format and counts the clamped values.
class RangeClamp {
public:
    explicit RangeClamp(PixelFormat format)
        : channelCount_(formats::info(format).channelCount), low_(rangeOf(format).low), high_(rangeOf(format).high) {}

    glm::vec4 operator()(const glm::vec4& texel, bool counts) {
        glm::vec4 clamped = texel;
        for (int c = 0; c < channelCount_; ++c) {
            if (texel[c] > high_[c]) {
                clamped[c] = high_[c];
                report_.clampedHigh += counts;
            } else if (texel[c] < low_[c]) {
                clamped[c] = low_[c];
                // In a signed format a value below the range counts as too large too.
                (low_[c] < 0 ? report_.clampedHigh : report_.clampedNegative) += counts;
            } else if (low_[c] == 0) {
                clamped[c] = texel[c] + 0.0f;  // -0 becomes 0
            }
        }
        return clamped;
    }
    /// Clamps a block. The report counts significant texels only.
    void operator()(Block& block) {
        int outside = 0;
        for (int c = 0; c < channelCount_; ++c) {
            auto& plane = block.channel[static_cast<std::size_t>(c)];
            const float low = low_[c], high = high_[c];
            for (float& value : plane) {
                value += 0.0f;  // -0 becomes 0
                outside |= (value < low) | (value > high);
            }
        }
        if (!outside) return;
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            const glm::vec4 texel(block.channel[0][t], block.channel[1][t], block.channel[2][t], block.channel[3][t]);
            const glm::vec4 clamped = (*this)(texel, block.significance[t] > 0);
            for (int c = 0; c < 4; ++c) block.channel[static_cast<std::size_t>(c)][t] = clamped[c];
        }
    }
    /// Counts the values that a kernel has clamped itself.
    void count(ImageView<const glm::vec4> texels, ImageView<const float> significance) {
        for (int y = 0; y < texels.height; ++y)
            for (int x = 0; x < texels.width; ++x) (*this)(texels.at(x, y), !significance.texels || significance.at(x, y) > 0);
    }
    const EncodeReport& report() const { return report_; }
    int channelCount() const { return channelCount_; }

private:
    int channelCount_;
    glm::vec4 low_, high_;
    EncodeReport report_;
};

/// Scales the significance of a block by a power of two if its largest value is far from 1. Only ratios count, but sums of huge weights
/// overflow, and tiny ones vanish beside the small constants that keep divisions safe. A power of two rounds nothing.
void normalize(std::array<float, kTexelCount>& significance) {
    const float largest = *std::max_element(significance.begin(), significance.end());
    if (largest >= 0x1p-10f && largest <= 0x1p10f) return;
    const int exponent = -std::ilogb(largest);
    for (float& weight : significance) weight = std::ldexp(weight, exponent);
}

/// Gathers the 4x4 texels at (4 blockX, 4 blockY). Texels beyond the edge repeat it and have significance 0.
template <int kChannels>
void gatherChannels(ImageView<const glm::vec4> texels, ImageView<const float> significance, int blockX, int blockY, RangeClamp& clamp,
                    Block& out) {
    const int left = blockX * kBlockSide, top = blockY * kBlockSide;
    const bool whole = left + kBlockSide <= texels.width && top + kBlockSide <= texels.height;
    float total = 0;
    for (int i = 0; i < kTexelCount; ++i) {
        const int x = left + i % kBlockSide, y = top + i / kBlockSide;
        const bool inside = whole || (x < texels.width && y < texels.height);
        const glm::vec4& texel = texels.row(inside ? y : std::min(y, texels.height - 1))[inside ? x : std::min(x, texels.width - 1)];
        const auto t = static_cast<std::size_t>(i);
        for (int c = 0; c < kChannels; ++c) out.channel[static_cast<std::size_t>(c)][t] = texel[c];
        const float weight = !inside ? 0.0f : significance.texels ? significance.row(y)[x] : 1.0f;
        out.significance[t] = weight;
        total += weight;
    }
    clamp(out);
    out.insignificant = !(total > 0);
    if (out.insignificant)
        out.significance.fill(1.0f);
    else
        normalize(out.significance);
}

void gather(ImageView<const glm::vec4> texels, ImageView<const float> significance, int blockX, int blockY, RangeClamp& clamp, Block& out) {
    switch (clamp.channelCount()) {
        case 1:
            return gatherChannels<1>(texels, significance, blockX, blockY, clamp, out);
        case 2:
            return gatherChannels<2>(texels, significance, blockX, blockY, clamp, out);
        case 3:
            return gatherChannels<3>(texels, significance, blockX, blockY, clamp, out);
        default:
            return gatherChannels<4>(texels, significance, blockX, blockY, clamp, out);
    }
}

void encodeBlocks(PixelFormat format, std::span<const Block> blocks, const EncodeOptions& options, std::byte* out) {
    switch (format) {
        case PixelFormat::Bc1:
            return encodeBc1(blocks, options, out);
        case PixelFormat::Bc3:
            return encodeBc3(blocks, options, out);
        case PixelFormat::Bc4:
            return encodeBc4(blocks, false, options, out);
        case PixelFormat::Bc4Snorm:
            return encodeBc4(blocks, true, options, out);
        case PixelFormat::Bc5:
            return encodeBc5(blocks, false, options, out);
        case PixelFormat::Bc5Snorm:
            return encodeBc5(blocks, true, options, out);
        case PixelFormat::Bc6hUf16:
            return encodeBc6h(blocks, false, options, out);
        case PixelFormat::Bc6hSf16:
            return encodeBc6h(blocks, true, options, out);
        case PixelFormat::Bc7:
            return encodeBc7(blocks, options, out);
        default:
            assert(false && "not a format of 4x4 BC blocks");
    }
}

void place(const DecodedBlock& block, int left, int top, ImageView<glm::vec4> out) {
    for (int t = 0; t < kTexelCount; ++t)
        if (left + t % kBlockSide < out.width && top + t / kBlockSide < out.height)
            out.at(left + t % kBlockSide, top + t / kBlockSide) = block[static_cast<std::size_t>(t)];
}

void decodeRows(PixelFormat format, std::span<const std::byte> blocks, ImageView<glm::vec4> out) {
    const std::byte* next = blocks.data();
    DecodedBlock block;
    for (int top = 0; top < out.height; top += kBlockSide)
        for (int left = 0; left < out.width; left += kBlockSide, next += formats::info(format).bytesPerBlock) {
            decodeBlock(format, next, block);
            place(block, left, top, out);
        }
}

EncodeReport encodeBcRows(PixelFormat format, ImageView<const glm::vec4> texels, ImageView<const float> significance,
                          const EncodeOptions& options, std::span<std::byte> out) {
    const int across = formats::blocksAcross(format, texels.width), down = formats::blocksDown(format, texels.height);
    const auto bytesPerBlock = static_cast<std::size_t>(formats::info(format).bytesPerBlock);
    RangeClamp clamp(format);
    std::vector<Block> batch(kBatch);
    const int blockCount = across * down;
    for (int first = 0; first < blockCount; first += kBatch) {
        const int count = std::min(kBatch, blockCount - first);
        for (int i = 0; i < count; ++i)
            gather(texels, significance, (first + i) % across, (first + i) / across, clamp, batch[static_cast<std::size_t>(i)]);
        std::byte* target = out.data() + static_cast<std::size_t>(first) * bytesPerBlock;
        encodeBlocks(format, {batch.data(), static_cast<std::size_t>(count)}, options, target);
    }
    return clamp.report();
}

TexelRows rowsOf(ImageView<const glm::vec4> texels, ImageView<const float> significance) {
    return {&texels.texels->x, 4 * texels.rowStride, significance.texels, significance.rowStride, texels.width, texels.height};
}

/// Encodes BC4 and BC5 by the kernel that reads rows, at all efforts but the exhaustive one.
EncodeReport encodeBc4Fast(PixelFormat format, ImageView<const glm::vec4> texels, ImageView<const float> significance,
                           const EncodeOptions& options, std::span<std::byte> out) {
    const formats::PixelFormatInfo& info = formats::info(format);
    RangeClamp clamp(format);
    if (encodeBc4Rows(rowsOf(texels, significance), info.channelCount, info.isSigned, options.effort, out.data()))
        clamp.count(texels, significance);
    return clamp.report();
}

/// Encodes BC1 and BC3 by the kernel that reads rows, at all efforts but the highest.
EncodeReport encodeBc1Fast(PixelFormat format, ImageView<const glm::vec4> texels, ImageView<const float> significance,
                           const EncodeOptions& options, std::span<std::byte> out) {
    RangeClamp clamp(format);
    if (encodeBc1Rows(rowsOf(texels, significance), format == PixelFormat::Bc3, options, out.data())) clamp.count(texels, significance);
    return clamp.report();
}

/// Encodes BC6H at low effort: the fast kernels, then the full search for blocks above fastKernelMaxError. These are gathered after each
/// strip, while its texels are in the cache.
EncodeReport encodeBc6hFast(PixelFormat format, ImageView<const glm::vec4> texels, ImageView<const float> significance,
                            const EncodeOptions& options, std::span<std::byte> out) {
    constexpr int kStripTexels = 1 << 14;
    const int across = formats::blocksAcross(format, texels.width);
    const int stripHeight = kBlockSide * std::max(1, kStripTexels / (kBlockSide * texels.width));
    const float maxError = bc6hSearchOf(options.effort).fastKernelMaxError;
    RangeClamp clamp(format), uncounted(format);
    std::vector<Block> batch(kBatch);
    std::vector<std::size_t> inBatch;  // indices of its blocks
    const auto encodeAgain = [&] {
        std::array<std::byte, 16 * kBatch> bytes;
        encodeBlocks(format, {batch.data(), inBatch.size()}, options, bytes.data());
        for (std::size_t i = 0; i < inBatch.size(); ++i) std::copy_n(bytes.data() + 16 * i, 16, out.data() + 16 * inBatch[i]);
        inBatch.clear();
    };
    std::vector<float> errors;
    for (int top = 0; top < texels.height; top += stripHeight) {
        const int height = std::min(stripHeight, texels.height - top);
        const ImageView<const glm::vec4> strip = texels.rows(top, height);
        const ImageView<const float> stripSignificance = significance.texels ? significance.rows(top, height) : significance;
        const std::size_t first = static_cast<std::size_t>(top / kBlockSide) * static_cast<std::size_t>(across);
        errors.resize(static_cast<std::size_t>(across) * static_cast<std::size_t>(formats::blocksDown(format, height)));
        if (encodeBc6hRows(rowsOf(strip, stripSignificance), format == PixelFormat::Bc6hSf16, options, out.data() + 16 * first,
                           errors.data()))
            clamp.count(strip, stripSignificance);
        for (std::size_t i = 0; i < errors.size(); ++i) {
            if (!(errors[i] > maxError * maxError)) continue;
            const int block = static_cast<int>(i);
            gather(strip, stripSignificance, block % across, block / across, uncounted, batch[inBatch.size()]);
            inBatch.push_back(first + i);
            if (inBatch.size() == kBatch) encodeAgain();
        }
    }
    if (!inBatch.empty()) encodeAgain();
    return clamp.report();
}

/// Encodes BC7 at low effort by the kernel that reads rows.
EncodeReport encodeBc7Fast(PixelFormat format, ImageView<const glm::vec4> texels, ImageView<const float> significance,
                           const EncodeOptions& options, std::span<std::byte> out) {
    RangeClamp clamp(format);
    if (encodeBc7Rows(rowsOf(texels, significance), options, out.data())) clamp.count(texels, significance);
    return clamp.report();
}

/// Returns the function that encodes rows of a format: one that reads rows if there is one, else one that gathers blocks.
auto rowEncoderOf(PixelFormat format, int effort) {
    const bool isBc6h = format == PixelFormat::Bc6hUf16 || format == PixelFormat::Bc6hSf16;
    if (isBc6h && bc6hSearchOf(effort).fastKernelMaxError > 0) return encodeBc6hFast;
    const bool isBc4 = format == PixelFormat::Bc4 || format == PixelFormat::Bc4Snorm;
    const bool isBc5 = format == PixelFormat::Bc5 || format == PixelFormat::Bc5Snorm;
    if ((isBc4 || isBc5) && !bc4SearchOf(effort).exhaustive) return encodeBc4Fast;
    if ((format == PixelFormat::Bc1 || format == PixelFormat::Bc3) && !bc1SearchOf(effort).twoColours) return encodeBc1Fast;
    if (format == PixelFormat::Bc7 && effort <= kBc7FastEfforts) return encodeBc7Fast;
    return encodeBcRows;
}

/// Encodes any BC format, optimizes the rows (rdo), and decodes them.
EncodeReport encodeBlockRows(PixelFormat format, ImageView<const glm::vec4> texels, ImageView<const float> significance,
                             const EncodeOptions& options, std::span<std::byte> out, ImageView<glm::vec4> decoded) {
    const EncodeReport report = rowEncoderOf(format, options.effort)(format, texels, significance, options, out);
    const std::size_t rowBytes = formats::bytesPerBlockRow(format, texels.width);
    for (int top = 0; options.rdo > 0 && top < texels.height; top += kBlockSide) {
        const int count = std::min(kBlockSide, texels.height - top);
        reduceRow(format, texels.rows(top, count), significance.texels ? significance.rows(top, count) : significance, options,
                  out.subspan(static_cast<std::size_t>(top / kBlockSide) * rowBytes, rowBytes));
    }
    if (decoded.texels) decodeRows(format, out, decoded);
    return report;
}

EncodeReport encodeTexelRows(PixelFormat format, ImageView<const glm::vec4> texels, ImageView<const float> significance,
                             const EncodeOptions& options, std::span<std::byte> out, ImageView<glm::vec4> decoded) {
    const auto bytesPerTexel = static_cast<std::size_t>(formats::info(format).bytesPerBlock);
    RangeClamp clamp(format);
    std::byte* target = out.data();
    for (int y = 0; y < texels.height; ++y)
        for (int x = 0; x < texels.width; ++x, target += bytesPerTexel) {
            const bool counts = !significance.texels || significance.at(x, y) > 0;
            const glm::vec4 result = encodeTexel(format, clamp(texels.at(x, y), counts), options, target);
            if (decoded.texels) decoded.at(x, y) = result;
        }
    return clamp.report();
}

EncodeReport encodeAstcRows(PixelFormat format, ImageView<const glm::vec4> texels, ImageView<const float> significance,
                            const EncodeOptions& options, std::span<std::byte> out, ImageView<glm::vec4> decoded) {
    RangeClamp clamp(format);
    formats::Image<glm::vec4> inRange(texels.width, texels.height);
    for (int y = 0; y < texels.height; ++y)
        for (int x = 0; x < texels.width; ++x) inRange.at(x, y) = clamp(texels.at(x, y), !significance.texels || significance.at(x, y) > 0);
    encodeAstc(format, inRange.view(), significance, options, out, decoded);
    return clamp.report();
}

}  // namespace

// The lists decide which search encodeBc6h() and encodeBc7() run on a block.
BlockSorter::BlockSorter(std::span<const Block> blocks, std::size_t channelCount) {
    for (const Block& block : blocks) {
        std::size_t counting = 0;
        while (!(block.significance[counting] > 0)) ++counting;
        int different = 0;
        for (std::size_t c = 0; c < channelCount; ++c) {
            const float value = block.channel[c][counting];
            for (std::size_t t = 0; t < kTexelCount; ++t) different |= int{block.channel[c][t] != value} & int{block.significance[t] > 0};
        }
        if (!different)
            constant.emplace_back(&block, counting);
        else
            (block.insignificant ? insignificant : varied).push_back(&block);
    }
}

EncodeReport encodeRows(PixelFormat format, ImageView<const glm::vec4> texels, ImageView<const float> significance,
                        const EncodeOptions& options, std::span<std::byte> out, ImageView<glm::vec4> decoded) {
    assert(out.size() == formats::bytesPerImage(format, texels.width, texels.height));
    assert(!significance.texels || (significance.width == texels.width && significance.height == texels.height));
    assert(!decoded.texels || (decoded.width == texels.width && decoded.height == texels.height));
    if (texels.width == 0 || texels.height == 0) return {};
    if (supportsRdo(format)) return encodeBlockRows(format, texels, significance, options, out, decoded);
    switch (format) {
        case PixelFormat::Astc4x4Hdr:
        case PixelFormat::Astc6x6Hdr:
        case PixelFormat::Astc8x8Hdr:
        case PixelFormat::Astc4x4Ldr:
            return encodeAstcRows(format, texels, significance, options, out, decoded);
        default:
            return encodeTexelRows(format, texels, significance, options, out, decoded);
    }
}

}  // namespace lightcook::compress

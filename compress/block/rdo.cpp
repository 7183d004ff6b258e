#include "compress/rdo.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <glm/common.hpp>
#include <limits>
#include <vector>

#include "compress/bc6h/search.h"
#include "compress/bc7/block_head.h"
#include "compress/block/decode.h"
#include "compress/texel/packed_texels.h"

namespace lightcook::compress {

namespace {

using formats::ImageView;
using formats::PixelFormat;

constexpr int kBlockSide = 4;
/// How far to the left a block looks for one to repeat whole; in part, which has to be decoded anew; in its head, with indices of its own.
constexpr std::size_t kWholeReach = 128, kPartReach = 24, kHeadReach = 32;

// What Zstandard spends, in bits, about: a byte that no match covers; a match, by what it costs to say where it lies.
constexpr double kLiteralBits = 7.6, kMatchBits = 20, kRepeatedOffsetBits = 11, kContinuedMatchBits = 1;

/// A range of a block's bytes that a copy takes over.
struct Range {
    std::size_t begin, end;
};

/// Whole blocks first; then the parts of each format that mean something alone: ends or indices, one channel of two.
std::span<const Range> rangesOf(PixelFormat format) {
    static constexpr std::array kBc1 = {Range{0, 8}, Range{0, 4}, Range{4, 8}};
    static constexpr std::array kBc4 = {Range{0, 8}, Range{2, 8}};
    static constexpr std::array kTwice = {Range{0, 16}, Range{0, 8}, Range{8, 16}, Range{2, 8}, Range{10, 16}};
    static constexpr std::array kBc3 = {Range{0, 16}, Range{0, 8}, Range{8, 16}, Range{2, 8}, Range{12, 16}};
    // BC7's ends and modes without the indices are taken as heads; BC6H's are not, see headAt().
    static constexpr std::array kBc7 = {Range{0, 16}, Range{8, 16}, Range{10, 16}, Range{12, 16}};
    static constexpr std::array kLong = {Range{0, 16}, Range{0, 8}, Range{8, 16}, Range{10, 16}};
    switch (format) {
        case PixelFormat::Bc1:
            return kBc1;
        case PixelFormat::Bc4:
        case PixelFormat::Bc4Snorm:
            return kBc4;
        case PixelFormat::Bc5:
        case PixelFormat::Bc5Snorm:
            return kTwice;
        case PixelFormat::Bc3:
            return kBc3;
        case PixelFormat::Bc7:
            return kBc7;
        default:
            return kLong;
    }
}

/// Sixteen texels in planes, in the space of the metric.
using Planes = std::array<std::array<float, kTexelCount>, 4>;

/// The encoder's error as a weighted squared difference: values go through `map`, differences are multiplied by a texel's factors.
class RowMetric {
public:
    RowMetric(PixelFormat format, const EncodeOptions& options)
        : range_(rangeOf(format)),
          channelCount_(static_cast<std::size_t>(formats::info(format).channelCount)),
          metric_(formats::info(format).isFloat ? options.hdrMetric : HdrMetric::Linear),
          scale_(options.hdrScale) {}

    std::size_t channelCount() const { return channelCount_; }
    glm::vec4 inRange(const glm::vec4& texel) const { return glm::clamp(texel, range_.low, range_.high); }
    /// Where the metric is that of a logarithm, into it.
    void map(Planes& planes) const {
        if (metric_ != HdrMetric::Log) return;
        for (std::size_t c = 0; c < channelCount_; ++c)
            for (float& value : planes[c]) value = std::copysign(log2OfOneAnd(std::abs(value) / scale_), value);
    }
    /// What a squared difference at this value weighs, beside the options' weights.
    float factor(float value) const {
        if (metric_ != HdrMetric::Relative) return 1;
        const float slope = 1 / (std::abs(value) + scale_);
        return slope * slope;
    }

private:
    /// log2(1 + x), x >= 0, to 2e-5, by the polynomial of the encoders: no library's rounding decides about bytes.
    static float log2OfOneAnd(float x) {
        const std::uint32_t bits = std::bit_cast<std::uint32_t>(x + 1);
        const float m = std::bit_cast<float>((bits & 0x7FFFFFu) | 0x3F800000u) - 1;
        float p = kBc6hLog2[4];
        for (std::size_t i = 4; i-- > 0;) p = p * m + kBc6hLog2[i];
        return static_cast<float>(static_cast<int>(bits >> 23) - 127) + m * p;
    }

    ChannelRange range_;
    std::size_t channelCount_;
    HdrMetric metric_;
    float scale_;
};

class RowReducer {
public:
    RowReducer(PixelFormat format, ImageView<const glm::vec4> texels, ImageView<const float> significance, const EncodeOptions& options,
               std::span<std::byte> row)
        : format_(format),
          ranges_(rangesOf(format)),
          blockBytes_(static_cast<std::size_t>(formats::info(format).bytesPerBlock)),
          metric_(format, options),
          options_(options),
          row_(row),
          original_(row.begin(), row.end()),
          blocks_(row.size() / blockBytes_) {
        scaleWeights(significance);
        for (std::size_t j = 0; j < blocks_.size(); ++j) gather(texels, significance, static_cast<int>(j));
    }

    void run() {
        double before = 0;
        for (const RowBlock& block : blocks_) before += block.error;
        if (!std::isfinite(before)) return;  // values and scale so far apart that no budget can be told
        heads_.resize(std::min(kHeadReach, blocks_.size()));
        for (std::size_t j = 0; j < blocks_.size(); ++j) findCandidates(j);
        const double growth = 1 + static_cast<double>(options_.rdo), allowed = before * growth * growth;
        Choices best = choose(0);
        // The largest price of a bit whose choices stay inside the budget; octaves around the mean error of a bit, then finer.
        const double unit = std::max(before, 1e-300) / (kLiteralBits * static_cast<double>(row_.size()));
        double exponent = -40;
        for (const double step : {16.0, 4.0, 1.0, 0.25, 0.0625})
            for (; exponent < 40; exponent += step) {
                Choices tried = choose(unit * std::exp2(exponent + step));
                if (!(tried.error <= allowed)) break;
                if (tried.bits <= best.bits) best = std::move(tried);
            }
        write(best);
    }

private:
    struct Candidate {
        std::size_t source;
        std::size_t range;  ///< of ranges_; kHeadOnly: the head, with indices of its own
        double error;
    };
    using Indices = std::array<std::array<std::uint8_t, kTexelCount>, 2>;
    /// A block's head, and what texels show with each index.
    struct Head {
        BlockHead form{};
        std::array<Planes, 16> shown{};
        std::array<std::array<float, kTexelCount>, 2> barred{};  ///< of each set: infinite where the upper half of indices cannot be stored
    };
    struct RowBlock {
        Planes wanted{};   ///< in the metric's space
        Planes weights{};  ///< of squared differences
        Planes shown{};    ///< what the encoder made of it
        double error = 0;
        std::vector<Candidate> candidates{};
    };
    /// A candidate for each block, or none (-1).
    struct Choices {
        std::vector<int> ofBlock;
        double error = 0, bits = 0;
    };

    /// Only ratios count: powers of two bring the largest weights near 1, so that no sum overflows or drowns in subnormals.
    void scaleWeights(ImageView<const float> significance) {
        float largest = significance.texels ? 0.0f : 1.0f;
        for (int y = 0; y < significance.height; ++y)
            for (int x = 0; x < significance.width; ++x) largest = std::max(largest, significance.at(x, y));
        significanceExponent_ = largest > 0 ? -std::ilogb(largest) : 0;
        const float channel = *std::max_element(options_.channelWeights.begin(), options_.channelWeights.end());
        channelExponent_ = channel > 0 ? -std::ilogb(channel) : 0;
    }

    const std::byte* blockAt(std::size_t j) const { return original_.data() + j * blockBytes_; }

    void gather(ImageView<const glm::vec4> texels, ImageView<const float> significance, int j) {
        RowBlock& block = blocks_[static_cast<std::size_t>(j)];
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            const int x = kBlockSide * j + static_cast<int>(t) % kBlockSide, y = static_cast<int>(t) / kBlockSide;
            if (x >= texels.width || y >= texels.height) continue;
            const glm::vec4 texel = metric_.inRange(texels.at(x, y));
            const float weight = std::ldexp(significance.texels ? significance.at(x, y) : 1.0f, significanceExponent_);
            for (std::size_t c = 0; c < metric_.channelCount(); ++c) {
                const float value = texel[static_cast<int>(c)];
                block.wanted[c][t] = value;
                block.weights[c][t] = weight * std::ldexp(options_.channelWeights[c], channelExponent_) * metric_.factor(value);
            }
        }
        metric_.map(block.wanted);
        decode(blockAt(static_cast<std::size_t>(j)), block.shown);
        block.error = errorOf(block, block.shown);
    }

    /// False for a block that no encoder of ours would write: not finite, or of BC1's index that is transparent to some readers.
    bool decode(const std::byte* bytes, Planes& planes) const {
        DecodedBlock decoded;
        decodeBlock(format_, bytes, decoded);
        bool isOurs = true;
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            for (std::size_t c = 0; c < metric_.channelCount(); ++c) {
                planes[c][t] = decoded[t][static_cast<int>(c)];
                isOurs = isOurs && std::isfinite(planes[c][t]);
            }
            isOurs = isOurs && !(format_ == PixelFormat::Bc1 && decoded[t].w < 1);
        }
        metric_.map(planes);
        return isOurs;
    }

    double errorOf(const RowBlock& block, const Planes& planes) const {
        std::array<float, kTexelCount> sums{};
        for (std::size_t c = 0; c < metric_.channelCount(); ++c)
            for (std::size_t t = 0; t < kTexelCount; ++t) {
                const float difference = planes[c][t] - block.wanted[c][t];
                sums[t] += block.weights[c][t] * difference * difference;
            }
        double sum = 0;
        for (const float each : sums) sum += static_cast<double>(each);
        return sum;
    }

    void findCandidates(std::size_t j) {
        RowBlock& block = blocks_[j];
        for (std::size_t back = 1; back <= std::min<std::size_t>(j, kWholeReach); ++back)
            block.candidates.push_back({j - back, 0, errorOf(block, blocks_[j - back].shown)});
        std::array<std::byte, 16> mixed;
        Planes planes{};
        for (std::size_t back = 1; back <= std::min<std::size_t>(j, kPartReach); ++back)
            for (std::size_t r = 1; r < ranges_.size(); ++r) {
                mix(j, {j - back, r, 0}, mixed.data());
                if (decode(mixed.data(), planes)) block.candidates.push_back({j - back, r, errorOf(block, planes)});
            }
        for (std::size_t back = 1; back <= std::min<std::size_t>(j, kHeadReach); ++back) {
            const Head& head = heads_[(j - back) % heads_.size()];
            if (head.form.bits) block.candidates.push_back({j - back, kHeadOnly, errorWith(block, head, nullptr)});
        }
        heads_[j % heads_.size()] = headAt(j);
        headBits_.push_back(heads_[j % heads_.size()].form.bits);
        std::erase_if(block.candidates, [](const Candidate& candidate) { return !std::isfinite(candidate.error); });
    }

    /// What the head of block j can show. BC6H goes without: beside lamps a logarithm's small errors are large light.
    Head headAt(std::size_t j) const {
        Head head;
        if (format_ == PixelFormat::Bc7) head.form = headOfBc7(blockAt(j));
        if (!head.form.bits) return head;
        int most = 0;
        for (std::size_t s = 0; s < 2; ++s) {
            most = std::max(most, head.form.sets[s].bits);
            for (std::size_t t = 0; t < kTexelCount; ++t)
                head.barred[s][t] = head.form.sets[s].anchors >> t & 1 ? std::numeric_limits<float>::infinity() : 0;
        }
        std::array<std::byte, 16> bytes;
        for (int i = 0; i < 1 << most; ++i) {
            Indices indices{};
            for (std::size_t s = 0; s < static_cast<std::size_t>(head.form.setCount); ++s)
                for (std::size_t t = 0; t < kTexelCount; ++t) {
                    const int count = 1 << (head.form.sets[s].bits - (head.form.sets[s].anchors >> t & 1));
                    indices[s][t] = static_cast<std::uint8_t>(std::min(i, count - 1));
                }
            std::memcpy(bytes.data(), blockAt(j), blockBytes_);
            putIndices(head.form, indices, bytes.data());
            decode(bytes.data(), head.shown[static_cast<std::size_t>(i)]);
        }
        return head;
    }

    /// Least error of a block that has this head, and the indices that give it.
    double errorWith(const RowBlock& block, const Head& head, Indices* indices) const {
        std::array<float, kTexelCount> sums{};
        for (std::size_t s = 0; s < static_cast<std::size_t>(head.form.setCount); ++s) {
            const IndexSet& set = head.form.sets[s];
            const std::size_t count = std::size_t{1} << set.bits;
            std::array<float, kTexelCount> best;
            std::array<std::int32_t, kTexelCount> which{};
            best.fill(std::numeric_limits<float>::infinity());
            for (std::size_t i = 0; i < count; ++i) {
                std::array<float, kTexelCount> error{};
                if (i >= count / 2) error = head.barred[s];
                for (std::size_t c = 0; c < metric_.channelCount(); ++c) {
                    if (!(set.channels >> c & 1)) continue;
                    for (std::size_t t = 0; t < kTexelCount; ++t) {
                        const float difference = head.shown[i][c][t] - block.wanted[c][t];
                        error[t] += block.weights[c][t] * difference * difference;
                    }
                }
                for (std::size_t t = 0; t < kTexelCount; ++t) {
                    which[t] = error[t] < best[t] ? static_cast<std::int32_t>(i) : which[t];
                    best[t] = error[t] < best[t] ? error[t] : best[t];
                }
            }
            for (std::size_t t = 0; t < kTexelCount; ++t) sums[t] += best[t];
            for (std::size_t t = 0; indices && t < kTexelCount; ++t) (*indices)[s][t] = static_cast<std::uint8_t>(which[t]);
        }
        double sum = 0;
        for (const float each : sums) sum += static_cast<double>(each);
        return sum;
    }

    /// Block j with what the candidate takes from its source.
    void mix(std::size_t j, const Candidate& candidate, std::byte* out) const {
        if (candidate.range == kHeadOnly) {
            const Head head = headAt(candidate.source);
            Indices indices{};
            errorWith(blocks_[j], head, &indices);
            std::memcpy(out, blockAt(candidate.source), blockBytes_);
            putIndices(head.form, indices, out);
            return;
        }
        const Range range = ranges_[candidate.range];
        std::memcpy(out, blockAt(j), blockBytes_);
        std::memcpy(out + range.begin, blockAt(candidate.source) + range.begin, range.end - range.begin);
    }

    /// The least error + price * bits, block after block. What is copied are blocks as they were encoded. Without a price the fewest bits
    /// that cost no error in any block.
    Choices choose(double price) const {
        Choices choices;
        choices.ofBlock.assign(blocks_.size(), -1);
        // Where the bytes of block j last stood whole, and where its head did: there, or in the latest copy. None once they were changed
        // and not copied before.
        std::vector<std::size_t> holder(blocks_.size()), headHolder(blocks_.size());
        std::size_t distance = 0;
        bool isMatchOpen = false;  // the last match reached the end of its block
        for (std::size_t j = 0; j < blocks_.size(); ++j) {
            const RowBlock& block = blocks_[j];
            double bestBits = kLiteralBits * static_cast<double>(blockBytes_), bestError = block.error;
            for (std::size_t i = 0; i < block.candidates.size(); ++i) {
                const Candidate& candidate = block.candidates[i];
                const std::size_t from = (candidate.range == kHeadOnly ? headHolder : holder)[candidate.source];
                if (from == kNowhere) continue;
                const double bits = bitsOf(rangeOfCandidate(candidate), j - from, distance, isMatchOpen);
                const bool isBetter = price > 0 ? candidate.error + price * bits < bestError + price * bestBits
                                                : candidate.error <= block.error && bits < bestBits;
                if (!isBetter) continue;
                bestBits = bits;
                bestError = candidate.error;
                choices.ofBlock[j] = static_cast<int>(i);
            }
            choices.bits += bestBits;
            choices.error += bestError;
            isMatchOpen = false;
            holder[j] = headHolder[j] = j;
            if (choices.ofBlock[j] < 0) continue;
            const Candidate& chosen = block.candidates[static_cast<std::size_t>(choices.ofBlock[j])];
            const Range range = rangeOfCandidate(chosen);
            distance = j - (chosen.range == kHeadOnly ? headHolder : holder)[chosen.source];
            isMatchOpen = range.end == blockBytes_;
            if (chosen.range == kHeadOnly ||
                std::memcmp(blockAt(j) + range.begin, blockAt(chosen.source) + range.begin, range.end - range.begin) != 0)
                holder[j] = headHolder[j] = kNowhere;
            if (chosen.range == kHeadOnly || chosen.range == 0) headHolder[chosen.source] = j;
            if (chosen.range == 0) holder[chosen.source] = j;
        }
        return choices;
    }

    Range rangeOfCandidate(const Candidate& candidate) const {
        if (candidate.range != kHeadOnly) return ranges_[candidate.range];
        return {0, static_cast<std::size_t>(headBits_[candidate.source]) / 8};
    }

    double bitsOf(const Range& range, std::size_t distance, std::size_t lastDistance, bool isMatchOpen) const {
        const double literals = kLiteralBits * static_cast<double>(blockBytes_ - (range.end - range.begin));
        if (distance != lastDistance) return literals + kMatchBits;
        return literals + (isMatchOpen && range.begin == 0 ? kContinuedMatchBits : kRepeatedOffsetBits);
    }

    void write(const Choices& choices) const {
        std::array<std::byte, 16> mixed;
        for (std::size_t j = 0; j < blocks_.size(); ++j) {
            if (choices.ofBlock[j] < 0) continue;
            mix(j, blocks_[j].candidates[static_cast<std::size_t>(choices.ofBlock[j])], mixed.data());
            std::memcpy(row_.data() + j * blockBytes_, mixed.data(), blockBytes_);
        }
    }

    static constexpr std::size_t kNowhere = ~std::size_t{0}, kHeadOnly = ~std::size_t{0};

    PixelFormat format_;
    std::span<const Range> ranges_;
    std::size_t blockBytes_;
    RowMetric metric_;
    const EncodeOptions& options_;
    std::span<std::byte> row_;
    std::vector<std::byte> original_;
    int significanceExponent_ = 0, channelExponent_ = 0;  ///< powers of two that weights are multiplied by
    std::vector<RowBlock> blocks_;
    std::vector<Head> heads_;    ///< of the last blocks, in a ring
    std::vector<int> headBits_;  ///< of each block
};

}  // namespace

bool canReduce(PixelFormat format) {
    switch (format) {
        case PixelFormat::Bc1:
        case PixelFormat::Bc3:
        case PixelFormat::Bc4:
        case PixelFormat::Bc4Snorm:
        case PixelFormat::Bc5:
        case PixelFormat::Bc5Snorm:
        case PixelFormat::Bc6hUf16:
        case PixelFormat::Bc6hSf16:
        case PixelFormat::Bc7:
            return true;
        default:
            return false;
    }
}

void reduceRow(PixelFormat format, ImageView<const glm::vec4> texels, ImageView<const float> significance, const EncodeOptions& options,
               std::span<std::byte> row) {
    assert(canReduce(format) && texels.height >= 1 && texels.height <= kBlockSide);
    assert(row.size() == formats::bytesPerBlockRow(format, texels.width));
    RowReducer(format, texels, significance, options, row).run();
}

}  // namespace lightcook::compress

#include "compress/block/rdo_candidates.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "compress/block/decode.h"

namespace lightcook::compress {
namespace {

using formats::ImageView;
using formats::PixelFormat;

/// Maximum distance of the source, in blocks: of a whole block; of a part, which has to be decoded; of a head, which needs new indices.
constexpr std::size_t kWholeReach = 128, kPartReach = 24, kHeadReach = 32;

/// Weights of padding, over the largest of the row: below the first, and at least the second. Texels of lower weight are read by no filter.
constexpr float kPaddingWeight = 0.5f, kReadWeight = 0x1p-10f;
/// A texel of padding may exceed its error by this many times the mean of the row, of the squared errors of its texels.
constexpr float kPaddingGrowth = 256;

/// Returns the byte ranges of a format that can be copied: the whole block first, then its independent parts (endpoints, indices, one of
/// two channels).
std::span<const ByteRange> rangesOf(PixelFormat format) {
    static constexpr std::array kBc1 = {ByteRange{0, 8}, ByteRange{0, 4}, ByteRange{4, 8}};
    static constexpr std::array kBc4 = {ByteRange{0, 8}, ByteRange{2, 8}};
    static constexpr std::array kBc5 = {ByteRange{0, 16}, ByteRange{0, 8}, ByteRange{8, 16}, ByteRange{2, 8}, ByteRange{10, 16}};
    static constexpr std::array kBc3 = {ByteRange{0, 16}, ByteRange{0, 8}, ByteRange{8, 16}, ByteRange{2, 8}, ByteRange{12, 16}};
    // BC6H and BC7 copy the mode and the endpoints as a head.
    static constexpr std::array kBc7 = {ByteRange{0, 16}, ByteRange{8, 16}, ByteRange{10, 16}, ByteRange{12, 16}};
    static constexpr std::array kBc6h = {ByteRange{0, 16}, ByteRange{8, 16}, ByteRange{10, 16}};
    switch (format) {
        case PixelFormat::Bc1:
            return kBc1;
        case PixelFormat::Bc4:
        case PixelFormat::Bc4Snorm:
            return kBc4;
        case PixelFormat::Bc5:
        case PixelFormat::Bc5Snorm:
            return kBc5;
        case PixelFormat::Bc3:
            return kBc3;
        case PixelFormat::Bc7:
            return kBc7;
        default:
            return kBc6h;
    }
}

/// Returns true if a BC1 block uses index 3 of the three-colour mode: black for some readers, transparent for others. encodeBc1 never does,
/// but endpoints of one block with the indices of another may.
bool usesTransparentIndex(const std::byte* block) {
    BitReader bits(block, 8);
    const std::uint32_t first = bits.get(16), second = bits.get(16), indices = bits.get(32);
    return first <= second && (indices & indices >> 1 & 0x55555555u) != 0;
}

double sum(const std::array<float, kTexelCount>& values) {
    double total = 0;
    for (const float each : values) total += static_cast<double>(each);
    return total;
}

}  // namespace

RowCandidates::RowCandidates(PixelFormat format, ImageView<const glm::vec4> texels, ImageView<const float> significance,
                             const EncodeOptions& options, std::span<const std::byte> row)
    : format_(format),
      ranges_(rangesOf(format)),
      blockBytes_(static_cast<std::size_t>(formats::info(format).bytesPerBlock)),
      metric_(format, options),
      options_(options),
      original_(row.begin(), row.end()),
      hasValueError_(!metric_.isLinear()),
      blocks_(row.size() / blockBytes_) {
    scaleWeights(significance);
    for (std::size_t j = 0; j < blocks_.size(); ++j) {
        gather(texels, significance, static_cast<int>(j));
        total_ += blocks_[j].error;
    }
    const auto inverse = [](double error) { return error > 0 ? std::min(1 / error, 1e30) : 1; };
    scale_ = {inverse(total_.metric), inverse(total_.value)};
    if (metric_.isLinear()) limitPadding();
}

void RowCandidates::find() {
    heads_.resize(std::min(kHeadReach, blocks_.size()));
    for (std::size_t j = 0; j < blocks_.size(); ++j) findFor(j);
}

void RowCandidates::apply(std::size_t j, const CopyCandidate& candidate, std::byte* out) const {
    if (candidate.range == CopyCandidate::kHeadOnly) {
        const Head head = headAt(candidate.source);
        Indices indices{};
        errorWith(blocks_[j], head, &indices);
        std::memcpy(out, blockAt(candidate.source), blockBytes_);
        putIndices(head.form, indices, out);
        return;
    }
    const ByteRange range = ranges_[candidate.range];
    std::memcpy(out, blockAt(j), blockBytes_);
    std::memcpy(out + range.begin, blockAt(candidate.source) + range.begin, range.end - range.begin);
}

/// Sets the powers of two that bring the largest weights near 1. Only ratios count, and no sum must overflow or lose precision in
/// subnormals.
void RowCandidates::scaleWeights(ImageView<const float> significance) {
    float largest = 1;
    if (significance.texels != nullptr) {
        largest = 0;
        for (int y = 0; y < significance.height; ++y)
            for (int x = 0; x < significance.width; ++x) largest = std::max(largest, significance.at(x, y));
    }
    significanceExponent_ = largest > 0 ? -std::ilogb(largest) : 0;
    const float channel = *std::max_element(options_.channelWeights.begin(), options_.channelWeights.end());
    channelExponent_ = channel > 0 ? -std::ilogb(channel) : 0;
}

/// Sets the limits of the texels that weigh little beside the heaviest of the row, but are read by filters: padding.
void RowCandidates::limitPadding() {
    const auto weightOf = [&](const RowBlock& block, std::size_t t) {
        float weight = 0;
        for (std::size_t c = 0; c < metric_.channelCount(); ++c) weight += block.weights.metric[c][t];
        return weight;
    };
    float largest = 0;
    double totalWeight = 0;
    for (const RowBlock& block : blocks_)
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            const float weight = weightOf(block, t);
            largest = std::max(largest, weight);
            totalWeight += static_cast<double>(weight);
        }
    const auto mean = static_cast<float>(totalWeight > 0 ? total_.metric / totalWeight : 0);
    for (RowBlock& block : blocks_) {
        TexelErrors own = errorsOf(block.decoded.metric, block.wanted.metric, block.weights.metric);
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            const float weight = weightOf(block, t);
            if (weight < kPaddingWeight * largest && weight >= kReadWeight * largest)
                block.limits[t] = own[t] + kPaddingGrowth * mean * weight;
        }
    }
}

/// Makes the error of each texel beyond its limit infinite.
void RowCandidates::applyLimits(const RowBlock& block, TexelErrors& errors) {
    for (std::size_t t = 0; t < kTexelCount; ++t)
        errors[t] = errors[t] > block.limits[t] ? std::numeric_limits<float>::infinity() : errors[t];
}

/// Reads the texels and the encoded block j.
void RowCandidates::gather(ImageView<const glm::vec4> texels, ImageView<const float> significance, int j) {
    RowBlock& block = blocks_[static_cast<std::size_t>(j)];
    for (std::size_t t = 0; t < kTexelCount; ++t) {
        const int x = kBlockSide * j + static_cast<int>(t) % kBlockSide, y = static_cast<int>(t) / kBlockSide;
        if (x >= texels.width || y >= texels.height) continue;
        const glm::vec4 texel = metric_.inRange(texels.at(x, y));
        const float weight = std::ldexp(significance.texels ? significance.at(x, y) : 1.0f, significanceExponent_);
        for (std::size_t c = 0; c < metric_.channelCount(); ++c) {
            const float value = texel[static_cast<int>(c)], channelWeight = std::ldexp(options_.channelWeights[c], channelExponent_);
            block.wanted.value[c][t] = value;
            block.weights.metric[c][t] = weight * channelWeight * metric_.factor(value);
            block.weights.value[c][t] = std::sqrt(weight) * channelWeight;
        }
    }
    block.wanted.metric = block.wanted.value;
    metric_.map(block.wanted.metric);
    decode(blockAt(static_cast<std::size_t>(j)), block.decoded);
    block.error = errorOf(block, block.decoded);
}

/// Decodes a block. Returns false for blocks that the encoders never write: values that are not finite, and the index of BC1 that some
/// readers decode to transparent (decodeBlock decodes it to opaque black).
bool RowCandidates::decode(const std::byte* bytes, Texels& texels) const {
    DecodedBlock decoded;
    decodeBlock(format_, bytes, decoded);
    bool isOurs = format_ != PixelFormat::Bc1 || !usesTransparentIndex(bytes);
    for (std::size_t t = 0; t < kTexelCount; ++t)
        for (std::size_t c = 0; c < metric_.channelCount(); ++c) {
            texels.metric[c][t] = decoded[t][static_cast<int>(c)];
            isOurs = isOurs && std::isfinite(texels.metric[c][t]);
        }
    if (hasValueError_) texels.value = texels.metric;
    metric_.map(texels.metric);
    return isOurs;
}

/// Returns the weighted squared error of each texel.
RowCandidates::TexelErrors RowCandidates::errorsOf(const Planes& found, const Planes& wanted, const Planes& weights) const {
    TexelErrors sums{};
    for (std::size_t c = 0; c < metric_.channelCount(); ++c)
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            const float difference = found[c][t] - wanted[c][t];
            sums[t] += weights[c][t] * difference * difference;
        }
    return sums;
}

RowError RowCandidates::errorOf(const RowBlock& block, const Texels& texels) const {
    TexelErrors metric = errorsOf(texels.metric, block.wanted.metric, block.weights.metric);
    applyLimits(block, metric);
    return {sum(metric), hasValueError_ ? sum(errorsOf(texels.value, block.wanted.value, block.weights.value)) : 0};
}

/// Finds the candidates of block j. Blocks must be visited in order, because heads_ keeps the heads of the last ones.
void RowCandidates::findFor(std::size_t j) {
    RowBlock& block = blocks_[j];
    for (std::size_t back = 1; back <= std::min<std::size_t>(j, kWholeReach); ++back)
        block.candidates.push_back({j - back, 0, errorOf(block, blocks_[j - back].decoded)});
    std::array<std::byte, 16> mixed;
    Texels mixedTexels{};
    for (std::size_t back = 1; back <= std::min<std::size_t>(j, kPartReach); ++back)
        for (std::size_t r = 1; r < ranges_.size(); ++r) {
            apply(j, {j - back, r, {}}, mixed.data());
            if (decode(mixed.data(), mixedTexels)) block.candidates.push_back({j - back, r, errorOf(block, mixedTexels)});
        }
    for (std::size_t back = 1; back <= std::min<std::size_t>(j, kHeadReach); ++back) {
        const Head& head = heads_[(j - back) % heads_.size()];
        if (head.form.bits) block.candidates.push_back({j - back, CopyCandidate::kHeadOnly, errorWith(block, head, nullptr)});
    }
    heads_[j % heads_.size()] = headAt(j);
    headBits_.push_back(heads_[j % heads_.size()].form.bits);
    std::erase_if(block.candidates, [](const CopyCandidate& candidate) { return !candidate.error.isFinite(); });
}

/// Returns the head of block j and the values that each of its indices decodes to.
RowCandidates::Head RowCandidates::headAt(std::size_t j) const {
    Head head;
    head.form = headOf(format_, blockAt(j));
    if (!head.form.bits) return head;
    int most = 0;
    for (std::size_t s = 0; s < 2; ++s) {
        most = std::max(most, head.form.sets[s].bits);
        for (std::size_t t = 0; t < kTexelCount; ++t)
            head.penalty[s][t] = head.form.sets[s].anchors >> t & 1 ? std::numeric_limits<float>::infinity() : 0;
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
        decode(bytes.data(), head.decoded[static_cast<std::size_t>(i)]);
    }
    return head;
}

/// Returns the errors of a block with this head and the indices that cost least. indices, if not null, receives these.
RowError RowCandidates::errorWith(const RowBlock& block, const Head& head, Indices* indices) const {
    using Sums = TexelErrors;
    const auto scale = static_cast<float>(scale_.metric), valueScale = static_cast<float>(scale_.value);
    Sums metricSums{}, valueSums{};
    for (std::size_t s = 0; s < static_cast<std::size_t>(head.form.setCount); ++s) {
        const IndexSet& set = head.form.sets[s];
        const std::size_t count = std::size_t{1} << set.bits;
        Sums best, metricOfBest, valueOfBest;
        std::array<std::int32_t, kTexelCount> which{};
        for (Sums* each : {&best, &metricOfBest, &valueOfBest}) each->fill(std::numeric_limits<float>::infinity());
        for (std::size_t i = 0; i < count; ++i) {
            Sums metric{}, value{}, cost;
            if (i >= count / 2) metric = head.penalty[s];
            const auto add = [&](const Planes& found, const Planes& wanted, const Planes& weights, Sums& error) {
                for (std::size_t c = 0; c < metric_.channelCount(); ++c) {
                    if (!(set.channels >> c & 1)) continue;
                    for (std::size_t t = 0; t < kTexelCount; ++t) {
                        const float difference = found[c][t] - wanted[c][t];
                        error[t] += weights[c][t] * difference * difference;
                    }
                }
            };
            add(head.decoded[i].metric, block.wanted.metric, block.weights.metric, metric);
            cost = metric;
            if (hasValueError_) {
                add(head.decoded[i].value, block.wanted.value, block.weights.value, value);
                for (std::size_t t = 0; t < kTexelCount; ++t) cost[t] = metric[t] * scale + value[t] * valueScale;
            }
            for (std::size_t t = 0; t < kTexelCount; ++t) {
                const bool isBetter = cost[t] < best[t];
                which[t] = isBetter ? static_cast<std::int32_t>(i) : which[t];
                metricOfBest[t] = isBetter ? metric[t] : metricOfBest[t];
                valueOfBest[t] = isBetter ? value[t] : valueOfBest[t];
                best[t] = isBetter ? cost[t] : best[t];
            }
        }
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            metricSums[t] += metricOfBest[t];
            valueSums[t] += valueOfBest[t];
        }
        for (std::size_t t = 0; indices && t < kTexelCount; ++t) (*indices)[s][t] = static_cast<std::uint8_t>(which[t]);
    }
    applyLimits(block, metricSums);
    return {sum(metricSums), sum(valueSums)};
}

}  // namespace lightcook::compress

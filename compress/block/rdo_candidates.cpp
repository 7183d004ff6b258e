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

/// Returns the byte ranges of a format that can be copied: the whole block first, then its independent parts (endpoints, indices, one of
/// two channels).
std::span<const ByteRange> rangesOf(PixelFormat format) {
    static constexpr std::array kBc1 = {ByteRange{0, 8}, ByteRange{0, 4}, ByteRange{4, 8}};
    static constexpr std::array kBc4 = {ByteRange{0, 8}, ByteRange{2, 8}};
    static constexpr std::array kBc5 = {ByteRange{0, 16}, ByteRange{0, 8}, ByteRange{8, 16}, ByteRange{2, 8}, ByteRange{10, 16}};
    static constexpr std::array kBc3 = {ByteRange{0, 16}, ByteRange{0, 8}, ByteRange{8, 16}, ByteRange{2, 8}, ByteRange{12, 16}};
    // BC7 copies the mode and the endpoints as a head. BC6H does not: see headAt().
    static constexpr std::array kBc7 = {ByteRange{0, 16}, ByteRange{8, 16}, ByteRange{10, 16}, ByteRange{12, 16}};
    static constexpr std::array kBc6h = {ByteRange{0, 16}, ByteRange{0, 8}, ByteRange{8, 16}, ByteRange{10, 16}};
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

}  // namespace

RowCandidates::RowCandidates(PixelFormat format, ImageView<const glm::vec4> texels, ImageView<const float> significance,
                             const EncodeOptions& options, std::span<const std::byte> row)
    : format_(format),
      ranges_(rangesOf(format)),
      blockBytes_(static_cast<std::size_t>(formats::info(format).bytesPerBlock)),
      metric_(format, options),
      options_(options),
      original_(row.begin(), row.end()),
      blocks_(row.size() / blockBytes_) {
    scaleWeights(significance);
    for (std::size_t j = 0; j < blocks_.size(); ++j) gather(texels, significance, static_cast<int>(j));
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

/// Reads the texels and the encoded block j.
void RowCandidates::gather(ImageView<const glm::vec4> texels, ImageView<const float> significance, int j) {
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
    decode(blockAt(static_cast<std::size_t>(j)), block.decoded);
    block.error = errorOf(block, block.decoded);
}

/// Decodes a block. Returns false for blocks that the encoders never write: values that are not finite, and the index of BC1 that some
/// readers decode to transparent (decodeBlock decodes it to opaque black).
bool RowCandidates::decode(const std::byte* bytes, Planes& planes) const {
    DecodedBlock decoded;
    decodeBlock(format_, bytes, decoded);
    bool isOurs = format_ != PixelFormat::Bc1 || !usesTransparentIndex(bytes);
    for (std::size_t t = 0; t < kTexelCount; ++t)
        for (std::size_t c = 0; c < metric_.channelCount(); ++c) {
            planes[c][t] = decoded[t][static_cast<int>(c)];
            isOurs = isOurs && std::isfinite(planes[c][t]);
        }
    metric_.map(planes);
    return isOurs;
}

double RowCandidates::errorOf(const RowBlock& block, const Planes& planes) const {
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

/// Finds the candidates of block j. Blocks must be visited in order, because heads_ keeps the heads of the last ones.
void RowCandidates::findFor(std::size_t j) {
    RowBlock& block = blocks_[j];
    for (std::size_t back = 1; back <= std::min<std::size_t>(j, kWholeReach); ++back)
        block.candidates.push_back({j - back, 0, errorOf(block, blocks_[j - back].decoded)});
    std::array<std::byte, 16> mixed;
    Planes planes{};
    for (std::size_t back = 1; back <= std::min<std::size_t>(j, kPartReach); ++back)
        for (std::size_t r = 1; r < ranges_.size(); ++r) {
            apply(j, {j - back, r, 0}, mixed.data());
            if (decode(mixed.data(), planes)) block.candidates.push_back({j - back, r, errorOf(block, planes)});
        }
    for (std::size_t back = 1; back <= std::min<std::size_t>(j, kHeadReach); ++back) {
        const Head& head = heads_[(j - back) % heads_.size()];
        if (head.form.bits) block.candidates.push_back({j - back, CopyCandidate::kHeadOnly, errorWith(block, head, nullptr)});
    }
    heads_[j % heads_.size()] = headAt(j);
    headBits_.push_back(heads_[j % heads_.size()].form.bits);
    std::erase_if(block.candidates, [](const CopyCandidate& candidate) { return !std::isfinite(candidate.error); });
}

/// Returns the head of block j and the values that each of its indices decodes to. Only BC7 has heads. In BC6H, with its logarithmic scale,
/// new indices for the head of another block make large errors of light beside bright texels.
RowCandidates::Head RowCandidates::headAt(std::size_t j) const {
    Head head;
    if (format_ == PixelFormat::Bc7) head.form = headOfBc7(blockAt(j));
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

/// Returns the least error of a block with this head. indices, if not null, receives the best indices.
double RowCandidates::errorWith(const RowBlock& block, const Head& head, Indices* indices) const {
    std::array<float, kTexelCount> sums{};
    for (std::size_t s = 0; s < static_cast<std::size_t>(head.form.setCount); ++s) {
        const IndexSet& set = head.form.sets[s];
        const std::size_t count = std::size_t{1} << set.bits;
        std::array<float, kTexelCount> best;
        std::array<std::int32_t, kTexelCount> which{};
        best.fill(std::numeric_limits<float>::infinity());
        for (std::size_t i = 0; i < count; ++i) {
            std::array<float, kTexelCount> error{};
            if (i >= count / 2) error = head.penalty[s];
            for (std::size_t c = 0; c < metric_.channelCount(); ++c) {
                if (!(set.channels >> c & 1)) continue;
                for (std::size_t t = 0; t < kTexelCount; ++t) {
                    const float difference = head.decoded[i][c][t] - block.wanted[c][t];
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

}  // namespace lightcook::compress

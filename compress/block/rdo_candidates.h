// Rate-distortion optimization, first part: the copies that may replace each block of a row or a part of it, and the error of each.
//
// A block may repeat an earlier block of its row, up to kWholeReach blocks back; or a byte range of one, such as its endpoints or its
// indices (up to kPartReach); or, in BC6H and BC7, the head of one, everything before the indices, with the best indices for it (up to
// kHeadReach).
//
// With a metric that is not linear a block has a second error, of the values themselves, weighted by the roots of the weights. It protects
// the padding beside charts: a sampler mixes these texels into the charts, in linear light, though they hardly weigh. With a linear metric,
// where such an error would cost 4 to 7 % of the bytes, each texel of padding has a limit instead: no candidate is taken in which it errs
// by far more than the texels of the row do on average.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "compress/block/block_head.h"
#include "compress/block/row_metric.h"
#include "compress/encode_options.h"
#include "formats/image.h"
#include "formats/pixel_format.h"

namespace lightcook::compress {

/// A byte range of a block.
struct ByteRange {
    std::size_t begin, end;
};

/// Squared errors of a block or a row.
struct RowError {
    double metric = 0;  ///< in the encoder's metric, weighted
    double value = 0;   ///< of the values, weighted by the roots of the weights; 0 if the metric is linear
    RowError& operator+=(const RowError& other) {
        metric += other.metric;
        value += other.value;
        return *this;
    }
    bool isFinite() const { return std::isfinite(metric) && std::isfinite(value); }
};

/// A copy that may replace a block or a part of it.
struct CopyCandidate {
    static constexpr std::size_t kHeadOnly = ~std::size_t{0};
    std::size_t source;  ///< block to the left
    std::size_t range;   ///< number of the byte range, 0 for the whole block; kHeadOnly: the head, with new indices
    RowError error;      ///< of the block with the copy
};

class RowCandidates {
public:
    /// Arguments as for reduceRow. Copies the encoded blocks and computes their errors.
    RowCandidates(formats::PixelFormat format, formats::ImageView<const glm::vec4> texels, formats::ImageView<const float> significance,
                  const EncodeOptions& options, std::span<const std::byte> row);

    /// Finds the candidates of all blocks.
    void find();

    std::size_t count() const { return blocks_.size(); }
    std::size_t blockBytes() const { return blockBytes_; }
    /// Returns the bytes of a block as they were encoded.
    const std::byte* blockAt(std::size_t j) const { return original_.data() + j * blockBytes_; }
    const RowError& errorOf(std::size_t j) const { return blocks_[j].error; }
    /// Returns the errors of all blocks as they were encoded.
    const RowError& total() const { return total_; }
    /// Returns the sum of both errors, each as a share of that of the row.
    /// valueWeight  weight of RowError::value
    double costOf(const RowError& error, double valueWeight) const {
        return error.metric * scale_.metric + valueWeight * (error.value * scale_.value);
    }
    bool hasValueError() const { return hasValueError_; }  ///< the metric is not linear
    /// Returns the candidates of a block; those with an infinite error are left out.
    const std::vector<CopyCandidate>& candidatesOf(std::size_t j) const { return blocks_[j].candidates; }
    /// Returns the bytes that a candidate copies. A head is rounded down to whole bytes.
    ByteRange bytesOf(const CopyCandidate& candidate) const {
        if (candidate.range != CopyCandidate::kHeadOnly) return ranges_[candidate.range];
        return {0, static_cast<std::size_t>(headBits_[candidate.source]) / 8};
    }
    /// Writes block j with the copy of a candidate to out.
    void apply(std::size_t j, const CopyCandidate& candidate, std::byte* out) const;

private:
    using Indices = std::array<std::array<std::uint8_t, kTexelCount>, 2>;
    using TexelErrors = std::array<float, kTexelCount>;
    static constexpr TexelErrors unlimited() {
        TexelErrors limits{};
        limits.fill(std::numeric_limits<float>::infinity());
        return limits;
    }
    /// Sixteen texels as they are and in the space of the metric. `value` is used only if hasValueError_.
    struct Texels {
        Planes metric{}, value{};
    };
    /// The head of a block, and the values that its indices decode to.
    struct Head {
        BlockHead form{};
        std::array<Texels, 16> decoded{};                         ///< for each index, all texels
        std::array<std::array<float, kTexelCount>, 2> penalty{};  ///< of the upper half of indices of each set: infinite at anchors
    };
    struct RowBlock {
        Texels wanted{};
        Texels weights{};  ///< weights of squared differences
        Texels decoded{};  ///< the encoded block
        RowError error{};
        TexelErrors limits = unlimited();  ///< the weighted squared error that each texel may have in a candidate
        std::vector<CopyCandidate> candidates{};
    };

    void scaleWeights(formats::ImageView<const float> significance);
    void gather(formats::ImageView<const glm::vec4> texels, formats::ImageView<const float> significance, int j);
    bool decode(const std::byte* bytes, Texels& texels) const;
    void limitPadding();
    static void applyLimits(const RowBlock& block, TexelErrors& errors);
    TexelErrors errorsOf(const Planes& found, const Planes& wanted, const Planes& weights) const;
    RowError errorOf(const RowBlock& block, const Texels& texels) const;
    void findFor(std::size_t j);
    Head headAt(std::size_t j) const;
    RowError errorWith(const RowBlock& block, const Head& head, Indices* indices) const;

    formats::PixelFormat format_;
    std::span<const ByteRange> ranges_;
    std::size_t blockBytes_;
    RowMetric metric_;
    const EncodeOptions& options_;
    std::vector<std::byte> original_;
    bool hasValueError_;                                  ///< the metric is not linear
    int significanceExponent_ = 0, channelExponent_ = 0;  ///< powers of two by which weights are scaled
    RowError total_{}, scale_{};                          ///< of the row as it was encoded; their inverses, 1 for an error of 0
    std::vector<RowBlock> blocks_;
    std::vector<Head> heads_;    ///< of the last blocks, in a ring buffer
    std::vector<int> headBits_;  ///< size of the head of each block
};

}  // namespace lightcook::compress

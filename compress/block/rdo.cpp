// Method: Lagrangian optimization with a greedy choice. For every block, candidates are copies of blocks to its left (rdo_candidates.h).
// With a price per bit (the Lagrange multiplier), each block in turn takes the candidate with the least cost + price * bits, where bits
// are an estimate of what Zstandard will spend. The row is tried with rising prices; of those whose errors are within the allowed growth,
// the choices with the fewest bits win. The cost is the error in the encoder's metric, plus none, a quarter or all of the error of the
// values (RowError), each as a share of that of the row: which of the two reaches its limit first differs from row to row.
#include "compress/block/rdo.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include "compress/block/rdo_candidates.h"
#include "compress/encode.h"

namespace lightcook::compress {
namespace {

using formats::ImageView;
using formats::PixelFormat;

// Estimated cost in Zstandard [bits].
constexpr double kLiteralBits = 7.6;        // a byte that no match covers
constexpr double kMatchBits = 20;           // a match with a new offset
constexpr double kRepeatedOffsetBits = 11;  // a match with the offset of the last one
constexpr double kContinuedMatchBits = 1;   // the continuation of a match into the next block

/// Estimates the bits of a row, block after block, as the blocks are replaced by copies.
class MatchModel {
public:
    explicit MatchModel(const RowCandidates& row) : row_(row), holder_(row.count()), headHolder_(row.count()) {}

    double literalBits() const { return kLiteralBits * static_cast<double>(row_.blockBytes()); }
    /// Returns the bits of block j with this copy, or infinity if the copied bytes are no longer in the row.
    double bitsOf(std::size_t j, const CopyCandidate& candidate) const {
        const std::size_t from = holderOf(candidate);
        if (from == kNowhere) return std::numeric_limits<double>::infinity();
        const ByteRange range = row_.bytesOf(candidate);
        const double literals = kLiteralBits * static_cast<double>(row_.blockBytes() - (range.end - range.begin));
        if (j - from != distance_) return literals + kMatchBits;
        return literals + (isMatchOpen_ && range.begin == 0 ? kContinuedMatchBits : kRepeatedOffsetBits);
    }
    /// Continues with block j as it was encoded.
    void keep(std::size_t j) {
        isMatchOpen_ = false;
        holder_[j] = headHolder_[j] = j;
    }
    /// Continues with block j replaced by a copy.
    void copy(std::size_t j, const CopyCandidate& candidate) {
        keep(j);
        const ByteRange range = row_.bytesOf(candidate);
        const bool isHead = candidate.range == CopyCandidate::kHeadOnly;
        distance_ = j - holderOf(candidate);
        isMatchOpen_ = range.end == row_.blockBytes();
        if (isHead ||
            std::memcmp(row_.blockAt(j) + range.begin, row_.blockAt(candidate.source) + range.begin, range.end - range.begin) != 0)
            holder_[j] = headHolder_[j] = kNowhere;
        if (isHead || candidate.range == 0) headHolder_[candidate.source] = j;
        if (candidate.range == 0) holder_[candidate.source] = j;
    }

private:
    static constexpr std::size_t kNowhere = ~std::size_t{0};

    std::size_t holderOf(const CopyCandidate& candidate) const {
        return (candidate.range == CopyCandidate::kHeadOnly ? headHolder_ : holder_)[candidate.source];
    }

    const RowCandidates& row_;
    /// The block that last held all bytes, or the head, of each encoded block: itself or its latest copy; kNowhere if it was changed and
    /// had not been copied before.
    std::vector<std::size_t> holder_, headHolder_;
    std::size_t distance_ = 0;  ///< offset of the last match, in blocks
    bool isMatchOpen_ = false;  ///< the last match reached the end of its block
};

/// The number of the chosen candidate of each block, or -1, and the totals of the row.
struct Choices {
    std::vector<int> ofBlock;
    RowError error{};
    double bits = 0;
};

/// Chooses the candidate with the least cost + price * bits for each block in turn. Price 0 chooses the fewest bits that cost no error in
/// any block.
/// valueWeight  as for RowCandidates::costOf
Choices choose(const RowCandidates& row, double price, double valueWeight) {
    Choices choices;
    choices.ofBlock.assign(row.count(), -1);
    MatchModel model(row);
    for (std::size_t j = 0; j < row.count(); ++j) {
        const std::vector<CopyCandidate>& candidates = row.candidatesOf(j);
        const RowError& own = row.errorOf(j);
        RowError bestError = own;
        double bestBits = model.literalBits();
        for (std::size_t i = 0; i < candidates.size(); ++i) {
            const RowError& error = candidates[i].error;
            const double bits = model.bitsOf(j, candidates[i]);
            const bool isBetter =
                price > 0 ? row.costOf(error, valueWeight) + price * bits < row.costOf(bestError, valueWeight) + price * bestBits
                          : error.metric <= own.metric && error.value <= own.value && bits < bestBits;
            if (!isBetter) continue;
            bestBits = bits;
            bestError = error;
            choices.ofBlock[j] = static_cast<int>(i);
        }
        choices.bits += bestBits;
        choices.error += bestError;
        if (choices.ofBlock[j] < 0)
            model.keep(j);
        else
            model.copy(j, candidates[static_cast<std::size_t>(choices.ofBlock[j])]);
    }
    return choices;
}

/// Returns the choices with the fewest bits whose errors are at most `allowed` times those of the row. Prices rise from 2^-40 of the mean
/// cost per bit, first in steps of sixteen octaves, then in finer ones down to a sixteenth of an octave.
Choices chooseWithin(const RowCandidates& row, double allowed) {
    Choices best = choose(row, 0, 0);
    const double unit = 1 / (kLiteralBits * static_cast<double>(row.count() * row.blockBytes()));
    constexpr int kPerOctave = 16, kOctaves = 40;  // exponents count sixteenths of an octave
    for (const double valueWeight : {0.0, 0.25, 1.0}) {
        int exponent = -kOctaves * kPerOctave;
        for (const int step : {256, 64, 16, 4, 1})
            for (; exponent < kOctaves * kPerOctave; exponent += step) {
                Choices tried = choose(row, unit * std::exp2(static_cast<double>(exponent + step) / kPerOctave), valueWeight);
                if (!(tried.error.metric <= allowed * row.total().metric && tried.error.value <= allowed * row.total().value)) break;
                if (tried.bits <= best.bits) best = std::move(tried);
            }
        if (!row.hasValueError()) break;
    }
    return best;
}

}  // namespace

bool supportsRdo(PixelFormat format) {
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
    assert(supportsRdo(format) && texels.height >= 1 && texels.height <= kBlockSide);
    assert(row.size() == formats::bytesPerBlockRow(format, texels.width));
    RowCandidates candidates(format, texels, significance, options, row);
    if (!candidates.total().isFinite()) return;  // values are so far from the scale that the error cannot be bounded
    candidates.find();
    const double growth = 1 + static_cast<double>(options.rdo);
    const Choices choices = chooseWithin(candidates, growth * growth);
    for (std::size_t j = 0; j < candidates.count(); ++j)
        if (choices.ofBlock[j] >= 0)
            candidates.apply(j, candidates.candidatesOf(j)[static_cast<std::size_t>(choices.ofBlock[j])],
                             row.data() + j * candidates.blockBytes());
}

}  // namespace lightcook::compress

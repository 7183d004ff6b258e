#include "verify/block_errors.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace lightcook::verify {

namespace {

/// Share of the map's mean square that is added to a block's reference.
constexpr double kMeanShare = 0.1;

}  // namespace

BlockErrors::BlockErrors(int width, int rowCount, int firstRow)
    : across_((width + kSize - 1) / kSize),
      firstRow_(firstRow),
      blocks_(static_cast<std::size_t>(across_) * static_cast<std::size_t>((rowCount + kSize - 1) / kSize)) {
    assert(firstRow % kSize == 0);
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
        const int index = static_cast<int>(i);
        blocks_[i].x = index % across_ * kSize;
        blocks_[i].y = firstRow + index / across_ * kSize;
    }
}

void BlockErrors::add(int x, int y, double squaredError, double squaredReference) {
    Sums& sums = blocks_[static_cast<std::size_t>((y - firstRow_) / kSize) * static_cast<std::size_t>(across_) +
                         static_cast<std::size_t>(x / kSize)];
    sums.error += std::isfinite(squaredError) ? squaredError : std::numeric_limits<double>::infinity();
    sums.reference += squaredReference;
    ++sums.texelCount;
}

void BlockErrors::count(const Sums& block) {
    reference_ += block.reference;
    texels_ += block.texelCount;
    fullest_ = std::max(fullest_, block.texelCount);
}

void BlockErrors::merge(const BlockErrors& rows) {
    for (const Sums& block : rows.blocks_) count(block);
    reference_ += rows.reference_;
    texels_ += rows.texels_;
    fullest_ = std::max(fullest_, rows.fullest_);
    std::vector<Sums> all = std::move(candidates_);
    all.insert(all.end(), rows.candidates_.begin(), rows.candidates_.end());
    all.insert(all.end(), rows.blocks_.begin(), rows.blocks_.end());
    // A block with no more error and no less light than another is not the worst, whatever is added to the references.
    std::ranges::stable_sort(
        all, [](const Sums& a, const Sums& b) { return a.error != b.error ? a.error > b.error : a.reference < b.reference; });
    candidates_.clear();
    for (const Sums& block : all)
        if (candidates_.empty() || block.reference < candidates_.back().reference) candidates_.push_back(block);
}

double BlockErrors::meanSquare() const {
    BlockErrors whole(across_ * kSize, 0);
    whole.merge(*this);
    return whole.texels_ > 0 ? whole.reference_ / whole.texels_ : 0;
}

std::optional<BlockErrors::Block> BlockErrors::worst(double leastMean) const {
    BlockErrors whole(across_ * kSize, 0);
    whole.merge(*this);
    if (!(whole.reference_ > 0)) return std::nullopt;
    const double floor = kMeanShare * std::max(leastMean, whole.reference_ / whole.texels_) * whole.fullest_;
    Block worst;
    for (const Sums& block : whole.candidates_) {
        const double relative = std::sqrt(block.error / (block.reference + floor));
        if (relative > worst.error) worst = {block.x, block.y, std::min(relative, std::numeric_limits<double>::max())};
    }
    return worst;
}

double BlockErrors::allowed(double maxError) {
    return std::max(0.7, 7 * maxError);
}

}  // namespace lightcook::verify

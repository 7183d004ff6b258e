#include "verify/block_errors.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace verify {

namespace {

/// Of the map's mean square, added to a block's.
constexpr double kMeanShare = 0.1;

}  // namespace

BlockErrors::BlockErrors(int width, int height)
    : across_((width + kSize - 1) / kSize),
      blocks_(static_cast<std::size_t>(across_) * static_cast<std::size_t>((height + kSize - 1) / kSize)) {}

void BlockErrors::add(int x, int y, double squaredError, double squaredReference) {
    Sums& sums = blocks_[static_cast<std::size_t>(y / kSize) * static_cast<std::size_t>(across_) + static_cast<std::size_t>(x / kSize)];
    sums.error += squaredError;
    sums.reference += squaredReference;
    ++sums.texelCount;
}

std::optional<BlockErrors::Block> BlockErrors::worst() const {
    double reference = 0, texels = 0;
    int fullest = 0;
    for (const Sums& sums : blocks_) {
        reference += sums.reference;
        texels += sums.texelCount;
        fullest = std::max(fullest, sums.texelCount);
    }
    if (!(reference > 0)) return std::nullopt;
    const double floor = kMeanShare * reference / texels * fullest;
    Block worst;
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
        const double relative = std::sqrt(blocks_[i].error / (blocks_[i].reference + floor));
        if (relative <= worst.error) continue;
        const int index = static_cast<int>(i);
        worst = {index % across_ * kSize, index / across_ * kSize, std::min(relative, std::numeric_limits<double>::max())};
        if (std::isnan(relative)) worst.error = std::numeric_limits<double>::max();
    }
    return worst;
}

double BlockErrors::allowed(double maxError) {
    return std::max(0.7, 7 * maxError);
}

}  // namespace verify

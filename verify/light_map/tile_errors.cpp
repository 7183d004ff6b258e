#include "verify/tile_errors.h"

#include <algorithm>
#include <cassert>

namespace lightcook::verify {

TileErrors::TileErrors(std::vector<float> limits, std::size_t firstTile, std::size_t tiles)
    : limits_(std::move(limits)), firstTile_(firstTile), counts_(tiles * kKinds * limits_.size()) {
    assert(std::ranges::is_sorted(limits_));
}

void TileErrors::add(std::size_t tile, Kind kind, std::span<const float> differences) {
    if (limits_.empty()) return;
    std::uint32_t* const counts = counts_.data() + indexOf(tile, kind);
    for (const float difference : differences)
        for (std::size_t i = 0; i < limits_.size() && difference > limits_[i]; ++i) ++counts[i];
}

void TileErrors::merge(const TileErrors& other) {
    if (other.tiles() == 0) return;
    if (tiles() == 0) {
        *this = other;
        return;
    }
    assert(limits_ == other.limits_);
    const std::size_t first = std::min(firstTile_, other.firstTile_),
                      end = std::max(firstTile_ + tiles(), other.firstTile_ + other.tiles()), each = kKinds * limits_.size();
    counts_.insert(counts_.begin(), (firstTile_ - first) * each, 0);
    counts_.resize((end - first) * each);
    firstTile_ = first;
    for (std::size_t i = 0; i < other.counts_.size(); ++i) counts_[(other.firstTile_ - first) * each + i] += other.counts_[i];
}

std::int64_t TileErrors::over(std::size_t tile, Kind kind, std::size_t limit) const {
    if (tile < firstTile_ || tile >= firstTile_ + tiles()) return 0;
    return counts_[indexOf(tile, kind) + limit];
}

}  // namespace lightcook::verify

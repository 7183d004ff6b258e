#include "verify/tile_errors.h"

#include <algorithm>
#include <cassert>
#include <iterator>

namespace lightcook::verify {

TileErrors::TileErrors(std::vector<float> limits, std::size_t firstTile, std::size_t tiles) : limits_(std::move(limits)) {
    assert(std::ranges::is_sorted(limits_));
    if (!limits_.empty() && tiles > 0) runs_.push_back({firstTile, tiles, std::vector<std::uint32_t>(tiles * kKinds * limits_.size())});
}

void TileErrors::add(std::size_t tile, Kind kind, std::span<const float> differences) {
    if (limits_.empty()) return;
    Run& run = runs_.back();  // what samples are added to is one run
    std::uint32_t* const counts = run.counts.data() + indexOf(run, tile, kind);
    for (const float difference : differences)
        for (std::size_t i = 0; i < limits_.size() && difference > limits_[i]; ++i) ++counts[i];
}

void TileErrors::merge(const TileErrors& other) {
    if (limits_.empty()) limits_ = other.limits_;
    assert(other.limits_.empty() || limits_ == other.limits_);
    for (const Run& run : other.runs_) merge(run);
}

/// Adds a run to the one that it touches, or between two.
void TileErrors::merge(const Run& run) {
    const std::size_t each = kKinds * limits_.size();
    auto at = std::ranges::find_if(runs_, [&](const Run& known) { return known.end() >= run.firstTile; });
    if (at == runs_.end() || run.end() < at->firstTile) {
        runs_.insert(at, run);
        return;
    }
    const std::size_t first = std::min(at->firstTile, run.firstTile);
    at->counts.insert(at->counts.begin(), (at->firstTile - first) * each, 0);
    at->tiles = std::max(at->end(), run.end()) - first;
    at->firstTile = first;
    at->counts.resize(at->tiles * each);
    for (std::size_t i = 0; i < run.counts.size(); ++i) at->counts[(run.firstTile - first) * each + i] += run.counts[i];
    if (const auto next = std::next(at); next != runs_.end() && next->firstTile <= at->end()) {
        const Run after = std::move(*next);
        runs_.erase(next);
        merge(after);
    }
}

std::int64_t TileErrors::over(std::size_t tile, Kind kind, std::size_t limit) const {
    const auto run = std::ranges::lower_bound(runs_, tile, {}, [](const Run& each) { return each.end() - 1; });
    return run == runs_.end() || tile < run->firstTile ? 0 : run->counts[indexOf(*run, tile, kind) + limit];
}

}  // namespace lightcook::verify

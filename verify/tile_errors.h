// Visible errors of a light map by tile: how many of the samples of a tile err by more than some limits. What detail would save
// (formats/light_map_detail.h) follows from these counts.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace lightcook::verify {

/// Counts of samples by tile, kind of light and limit. Tiles are numbered row by row, those of formats::coverageSize().
class TileErrors {
public:
    enum class Kind { Diffuse, Specular };
    static constexpr std::size_t kKinds = 2;

    TileErrors() = default;
    /// limits  ascending [Delta E ITP]; none: nothing is counted
    /// tiles   that counts are kept of: [firstTile, firstTile + tiles)
    TileErrors(std::vector<float> limits, std::size_t firstTile, std::size_t tiles);

    bool isEmpty() const { return limits_.empty(); }
    const std::vector<float>& limits() const { return limits_; }
    /// Adds the errors of samples of a tile.
    void add(std::size_t tile, Kind kind, std::span<const float> differences);
    void merge(const TileErrors& other);
    /// Returns the number of samples over a limit; 0 for tiles that nothing was added to.
    std::int64_t over(std::size_t tile, Kind kind, std::size_t limit) const;

private:
    /// Tiles beside each other.
    struct Run {
        std::size_t firstTile = 0, tiles = 0;
        std::vector<std::uint32_t> counts = {};  ///< [tile][kind][limit]
        std::size_t end() const { return firstTile + tiles; }
    };
    std::size_t indexOf(const Run& run, std::size_t tile, Kind kind) const {
        return ((tile - run.firstTile) * kKinds + static_cast<std::size_t>(kind)) * limits_.size();
    }
    void merge(const Run& run);

    std::vector<float> limits_;
    std::vector<Run> runs_;  ///< ascending, apart from each other: a trial has bands of rows
};

}  // namespace lightcook::verify

// The rows of a light map that a trial measures, in levels: each level halves the distance between bands of rows, until all are measured.
//
// Bands are kRowAlignment rows high. The first level has every n-th of them, kFirstBands at least; the next one those halfway between; the
// last one all the rest, as far as kTrialTexels go. Errors of the last level are those of the map. Those of a level before it are a
// sample's: its 99th percentile is rarely more than margin() above that of the map (docs/lab/pipeline.md).
#pragma once

#include <vector>

#include "pipeline/assets/light_map/source.h"

namespace lightcook::pipeline {

/// Rows of a map, all of one strip of its source.
struct TrialRows {
    int strip = 0, firstRow = 0, rowCount = 0;
};

class TrialLevels {
public:
    explicit TrialLevels(const LightMapSource& source);

    int last() const { return static_cast<int>(levels_.size()) - 1; }
    /// Returns the rows of levels [first, end), from top to bottom.
    std::vector<TrialRows> rows(int first, int end) const;
    /// Returns the part of the map that levels [0, level] have.
    double share(int level) const;
    /// Returns the relative error that the 99th percentile of levels [0, level] is trusted to. 0 for the last one.
    double margin(int level) const;

    static constexpr int kFirstBands = 8;
    /// Texels of the last level, and of those before it, at most.
    static constexpr std::int64_t kTrialTexels = std::int64_t{1} << 20;

private:
    const LightMapSource& source_;
    int bands_;
    std::vector<int> levels_;  ///< [level] distance between bands
};

}  // namespace lightcook::pipeline

// A treemap of memory for report.html: areas are bytes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/report/html.h"

namespace lightcook::pipeline {

struct TreemapTile {
    std::string name;    ///< shown where it fits
    std::string detail;  ///< of the tooltip, after name and bytes
    std::string color;   ///< of CSS
    std::string link;    ///< href; empty: none
    std::uint64_t bytes = 0;
    std::vector<TreemapTile> parts = {};  ///< drawn inside; their bytes add up to those of the tile
};

/// A rectangle [units of the SVG].
struct TreemapArea {
    double x = 0, y = 0, width = 0, height = 0;
};

/// Divides an area among values, largest first, into rectangles whose areas are as the values. Values of 0 get empty rectangles.
/// Source: Bruls, Huizing and van Wijk 2000, Squarified Treemaps.
/// values   not increasing
std::vector<TreemapArea> squarified(const TreemapArea& area, const std::vector<double>& values);

/// Returns the tiles as SVG, the largest first: once for wide screens and paper, once for narrow screens. Empty without bytes.
/// label  words for readers who do not see it
Html treemap(std::vector<TreemapTile> tiles, const std::string& label);

}  // namespace lightcook::pipeline

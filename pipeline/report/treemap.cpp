#include "pipeline/report/treemap.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "pipeline/report/plot.h"

namespace lightcook::pipeline {
namespace {

constexpr double kLetter = 6.4, kLine = 16;  ///< width of a letter and height of a line at 12 px, the size of labels

/// Returns the largest ratio of sides in a strip of some values along a side.
double worstRatio(double sum, double least, double most, double side) {
    return std::max(side * side * most / (sum * sum), sum * sum / (side * side * least));
}

/// Returns as much of a name as fits, with an ellipsis; empty if fewer than six letters fit.
std::string fitted(const std::string& name, double width) {
    const auto letters = static_cast<std::size_t>(std::max(0.0, width - 8) / kLetter);
    if (name.size() <= letters) return name;
    if (letters < 6) return "";
    std::size_t end = letters - 1;
    while (end > 0 && (static_cast<unsigned char>(name[end]) & 0xc0) == 0x80) --end;  // not inside a character of UTF-8
    return name.substr(0, end) + "…";
}

Html rectangle(const char* kind, const TreemapArea& area, const std::string& color) {
    return element("rect",
                   {{"class", kind},
                    {"x", place(area.x)},
                    {"y", place(area.y)},
                    {"width", place(area.width)},
                    {"height", place(area.height)},
                    {"style", "fill:" + color}},
                   {});
}

/// Returns the name, and the bytes below it, as far as they fit.
Html labelOf(const TreemapTile& tile, const TreemapArea& area) {
    Html out;
    const std::string name = fitted(tile.name, area.width), bytes = humanBytes(tile.bytes);
    if (area.height < kLine + 2 || name.empty()) return out;
    out += label("name", area.x + 4, area.y + 13, name);
    if (area.height >= 2 * kLine + 2 && fitted(bytes, area.width) == bytes) out += label("bytes", area.x + 4, area.y + 13 + kLine, bytes);
    return out;
}

Html linked(const TreemapTile& tile, const Html& content) {
    const std::string title = tile.name + ": " + humanBytes(tile.bytes) + (tile.detail.empty() ? "" : ", " + tile.detail);
    const Html whole = element("title", text(title)) + content;
    return tile.link.empty() ? element("g", whole) : element("a", {{"href", tile.link}}, whole);
}

std::vector<TreemapArea> areasOf(const std::vector<TreemapTile>& tiles, const TreemapArea& area) {
    std::vector<double> values;
    for (const TreemapTile& tile : tiles) values.push_back(static_cast<double>(tile.bytes));
    return squarified(area, values);
}

void sortTiles(std::vector<TreemapTile>& tiles) {
    std::erase_if(tiles, [](const TreemapTile& tile) { return tile.bytes == 0; });
    std::ranges::stable_sort(tiles, [](const TreemapTile& a, const TreemapTile& b) { return a.bytes > b.bytes; });
    for (TreemapTile& tile : tiles) sortTiles(tile.parts);
}

Html drawn(const TreemapTile& tile, const TreemapArea& area) {
    constexpr double kRoomForHead = 44;
    if (tile.parts.size() < 2) return linked(tile, rectangle("tile", area, tile.color) + labelOf(tile, area));
    if (area.height < kRoomForHead || area.width < kRoomForHead) {
        // Too small for words on each part: colours alone, under one link.
        Html parts = rectangle("tile", area, tile.color);
        const std::vector<TreemapArea> areas = areasOf(tile.parts, area);
        constexpr double kLeastSide = 3;  // a page of hundreds of scenes opens faster without slivers
        for (std::size_t i = 0; i < areas.size(); ++i)
            if (std::min(areas[i].width, areas[i].height) >= kLeastSide) parts += rectangle("fill", areas[i], tile.parts[i].color);
        return linked(tile, parts + labelOf(tile, area));
    }
    const std::string head = fitted(tile.name + "  " + humanBytes(tile.bytes), area.width);
    Html out = linked(tile, rectangle("tile", area, tile.color) + (head.empty() ? Html() : label("name", area.x + 4, area.y + 13, head)));
    const TreemapArea inner = {area.x + 2, area.y + kLine + 2, area.width - 4, area.height - kLine - 4};
    const std::vector<TreemapArea> areas = areasOf(tile.parts, inner);
    for (std::size_t i = 0; i < areas.size(); ++i)
        out += linked(tile.parts[i], rectangle("part", areas[i], tile.parts[i].color) + labelOf(tile.parts[i], areas[i]));
    return out;
}

Html drawing(const std::vector<TreemapTile>& tiles, const char* kind, double width, double height, const std::string& words) {
    const std::vector<TreemapArea> areas = areasOf(tiles, {0, 0, width, height});
    Html content;
    for (std::size_t i = 0; i < tiles.size(); ++i) content += drawn(tiles[i], areas[i]);
    return element("svg",
                   {{"class", std::string("treemap ") + kind},
                    {"viewBox", fmt::format("0 0 {} {}", width, height)},
                    {"role", "img"},
                    {"aria-label", words}},
                   content);
}

}  // namespace

std::vector<TreemapArea> squarified(const TreemapArea& area, const std::vector<double>& values) {
    std::vector<TreemapArea> areas(values.size(), {area.x, area.y, 0, 0});
    const double total = std::accumulate(values.begin(), values.end(), 0.0);
    if (total <= 0) return areas;
    const double scale = area.width * area.height / total;
    TreemapArea rest = area;
    for (std::size_t first = 0; first < values.size() && values[first] > 0;) {
        const double side = std::min(rest.width, rest.height);
        if (side <= 0) break;
        // A strip along the shorter side takes values for as long as that makes its rectangles squarer.
        double sum = scale * values[first];
        std::size_t end = first + 1;
        for (; end < values.size() && values[end] > 0; ++end) {
            const double next = scale * values[end];
            const double most = scale * values[first];
            if (worstRatio(sum + next, next, most, side) > worstRatio(sum, scale * values[end - 1], most, side)) break;
            sum += next;
        }
        const bool isColumn = rest.width >= rest.height;
        const double depth = sum / side;
        double at = isColumn ? rest.y : rest.x;
        for (std::size_t i = first; i < end; ++i) {
            const double length = scale * values[i] / depth;
            areas[i] = isColumn ? TreemapArea{rest.x, at, depth, length} : TreemapArea{at, rest.y, length, depth};
            at += length;
        }
        (isColumn ? rest.x : rest.y) += depth;
        (isColumn ? rest.width : rest.height) -= depth;
        first = end;
    }
    return areas;
}

Html treemap(std::vector<TreemapTile> tiles, const std::string& words) {
    sortTiles(tiles);
    if (tiles.empty()) return {};
    return drawing(tiles, "wide", 1100, 380, words) + drawing(tiles, "narrow", 360, 420, words);
}

}  // namespace lightcook::pipeline

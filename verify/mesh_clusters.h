// Whether the vertices of a cooked mesh read the basis that the light map was coded with.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "formats/chart_clusters.h"
#include "formats/light_map.h"

namespace lightcook::verify {

/// Which texels of a map are covered, a bit each.
class CoveredTexels {
public:
    /// [texels]
    CoveredTexels(int width, int height);
    /// Rows [firstRow, firstRow + rowCount) of the map, which the band must hold. Different rows may be added from several threads.
    void add(const formats::LightMapStrip& band, int firstRow, int rowCount);
    bool at(int x, int y) const { return ((bits_[byteOf(x, y)] >> (x % 8)) & 1) != 0; }
    int width() const { return width_; }
    int height() const { return height_; }

private:
    std::size_t byteOf(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>((width_ + 7) / 8) + static_cast<std::size_t>(x / 8);
    }
    int width_, height_;
    std::vector<std::uint8_t> bits_;
};

/// Asks triangle by triangle: its corners bear one cluster, and that is the one of every texel whose centre lies inside it, and of every
/// covered texel that a bilinear filter at a point of it would read. Looks as much less far as its light-map UVs may have moved (inset
/// [texels]). A sentence about the first triangle where that is not so. Takes every texel of a triangle's bounding box.
/// covered  as large as the map
std::optional<std::string> clusterMistake(const formats::TriangleMesh& mesh, const formats::ClusterMap& map, const CoveredTexels& covered,
                                          double inset);

}  // namespace lightcook::verify

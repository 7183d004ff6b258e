// Texels of a light map that the triangles of a mesh read, by their light-map UVs: a texel is read if its centre lies inside a triangle,
// at least kEdge from its edges, so that neighbouring triangles do not share texels. Texels that a triangle only touches are known too.
// Memory: three bits a texel.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <vector>

namespace lightcook::pipeline {

/// One bit for each texel of a map.
class TexelSet {
public:
    TexelSet(int width, int height)
        : width_(width), height_(height), bits_((static_cast<std::size_t>(width) * static_cast<std::size_t>(height) + 63) / 64, 0) {}
    int width() const { return width_; }
    int height() const { return height_; }
    bool has(int x, int y) const { return (bits_[index(x, y) / 64] >> (index(x, y) % 64) & 1) != 0; }
    void add(int x, int y) { bits_[index(x, y) / 64] |= std::uint64_t{1} << (index(x, y) % 64); }
    std::int64_t count() const;

private:
    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
    }
    int width_, height_;
    std::vector<std::uint64_t> bits_;
};

class UvRaster {
public:
    static constexpr double kEdge = 1e-3;  ///< [texels]

    UvRaster(int width, int height) : read_(width, height), shared_(width, height), touched_(width, height) {}
    /// Adds a triangle by its UVs, V down. Texels outside the map are left out.
    void add(const std::array<glm::dvec2, 3>& uvs);
    const TexelSet& read() const { return read_; }      ///< by one triangle at least
    const TexelSet& shared() const { return shared_; }  ///< by two triangles at least
    /// Returns the texels that a triangle reads or whose square its edges cross.
    const TexelSet& touched() const { return touched_; }
    /// Returns the number of texels that were visited: a mesh whose triangles overlap many times visits far more than the map has.
    std::int64_t visits() const { return visits_; }

private:
    void addEdge(const glm::dvec2& from, const glm::dvec2& to);

    TexelSet read_, shared_, touched_;
    std::int64_t visits_ = 0;
};

}  // namespace lightcook::pipeline

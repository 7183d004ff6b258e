// Verification of a cooked mesh against the light map that it is shaded with: texture coordinates and normals move by at most the measured
// quantization error, and every triangle reads texels of one learned basis only.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/chart_clusters.h"
#include "formats/light_map.h"
#include "verify/figures.h"

namespace lightcook::verify {

// Quantization of positions, UVs and normals.

/// Largest distances between the vertices of a cooked mesh and those of its source.
struct MeshShift {
    double uTexels = 0, vTexels = 0;  ///< light-map UV, in texels of the map
    double normalRadians = 0;
};

/// Receives every sample of addMeshShiftErrors, named by the first texel (x, y) of its quad. Called concurrently for different rows.
using MeshShiftSeen = std::function<void(int x, int y, const glm::vec3& reference, const glm::vec3& result)>;

/// Adds the visible errors that `shift` causes, of the samples of addMeshShiftErrors. The light of a pixel also moves with the surface:
/// positionTexels is the largest distance that positions moved, in texels of the light map, and adds to both of the shift's distances.
void addMeshShiftVisible(const formats::LightMapStrip& strip, int firstRow, int rowCount, const MeshShift& shift, double positionTexels,
                         VisiblePairs& errors);

/// Adds an upper bound of the visible errors that `shift` causes, and its place: of every place of such a quad, moved at
/// most as far as addMeshShiftVisible moves it, into another one, and shaded at the normal of any of its texels, turned by at most
/// the shift's angle. The light of a quad lies between that of its corners; it changes by at most the slopes (addMeshShiftErrors) of the
/// quad and of those around it. Nothing but the display bounds a shift of more than one texel. The strip also holds a row above and two
/// below.
void addMeshShiftVisibleBound(const formats::LightMapStrip& strip, int firstRow, int rowCount, const MeshShift& shift,
                              double positionTexels, const Viewing& viewing, VisiblePairs& errors);

/// Returns the mean number of texels of a light map across a unit of length of a mesh's surface: the root of the area of its triangles in
/// the map over that of the triangles themselves. 0 without either.
double texelsPerUnit(std::span<const formats::TriangleMesh* const> meshes, int width, int height);

/// Sets the triangle of a place: the first one that the place lies in by light-map UV, or none.
/// meshes  in the order of the file; width, height: of the light map [texels]
void findTriangle(std::span<const formats::TriangleMesh* const> meshes, int width, int height, VisiblePlace& place);

/// Adds the errors that `shift` causes in the exit radiance of a white surface, for quads that begin in rows [firstRow, firstRow +
/// rowCount). Only quads of four covered texels of one chart count. The strip also holds the row below.
///
/// Samples: the centre of each quad, moved by the whole shift into each of four directions, its normal turned about two axes.
/// Bound: bilinear filtering changes coefficients by at most (edge difference) * (shift). Exit radiance of band l has a gradient over the
/// sphere of at most sqrt(l (l + 1) (2 l + 1) / 4 pi) * |coefficients of band l| (addition theorem), times the angle of the normal.
void addMeshShiftErrors(const formats::LightMapStrip& strip, int firstRow, int rowCount, const MeshShift& shift, double key,
                        ErrorAccumulator& errors, const MeshShiftSeen& seen = {});

/// The bound of addMeshShiftErrors as an RMS over the map, for any shift. A quad's bound is linear in the three components of a shift, so
/// six sums of products hold the RMS of all quads.
class MeshShiftBound {
public:
    /// Adds quads that begin in rows [firstRow, firstRow + rowCount) of the strip, which also holds the row below.
    void add(const formats::LightMapStrip& strip, int firstRow, int rowCount);
    void merge(const MeshShiftBound& other);
    /// Returns the RMS of the bounds over the RMS of the exit radiance at the quads' centres; 0 without quads or without light.
    /// shift  at most half a texel
    double relRms(const MeshShift& shift) const;

private:
    double uu_ = 0, vv_ = 0, nn_ = 0, uv_ = 0, un_ = 0, vn_ = 0, reference_ = 0;
};

// Clusters: which learned basis each triangle reads.

/// The coverage of a map, one bit a texel.
class CoveredTexels {
public:
    /// [texels]
    CoveredTexels(int width, int height);
    /// Adds rows [firstRow, firstRow + rowCount) of the map, which the strip must hold. Safe to call concurrently for different rows.
    void add(const formats::LightMapStrip& strip, int firstRow, int rowCount);
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

/// Checks that the corners of every triangle name one cluster, and that every texel the triangle reads was encoded with it. Returns a
/// sentence about the first triangle that fails.
///
/// A triangle reads each texel whose centre is inside it, and each covered texel within reach of a bilinear filter at one of its points.
/// covered  of the size of the map
/// inset    how far light-map UVs may have moved by quantization [texels]; the reach is smaller by this distance
std::optional<std::string> clusterMistake(const formats::TriangleMesh& mesh, const formats::ClusterMap& map, const CoveredTexels& covered,
                                          double inset);

}  // namespace lightcook::verify

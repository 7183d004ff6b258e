// What a mesh's quantization does to shading: light-map UVs and normals that moved by no more than was measured, on the light map's own
// gradient.
#pragma once

#include <functional>

#include "formats/light_map.h"
#include "verify/figures.h"

namespace lightcook::verify {

/// How far the vertices of a cooked mesh are from those of its source, at the most.
struct MeshShift {
    double uTexels = 0, vTexels = 0;  ///< light-map UV, in texels of the map
    double normalRadians = 0;
};

/// Adds errors of exit radiance of a white surface at the centres of texel quads whose four texels are covered, in rows [firstRow, firstRow
/// + rowCount) of the band, which also holds the row below: the sample moved by the whole shift into each of the four corners, the normal
/// turned by the whole angle about two axes. The bound: bilinear filtering moves by at most the quad's edge differences times the shift;
/// band l of the exit radiance has a gradient of at most sqrt(l (l + 1) (2l + 1) / 4 pi) times the norm of its coefficients (the addition
/// theorem of gradients), and the polynomial's value changes by at most that times the angle.
/// seen  if given: every sample, by the first texel of its quad; may be called from several threads at once, for rows of their own
using MeshShiftSeen = std::function<void(int x, int y, const glm::vec3& reference, const glm::vec3& result)>;
void addMeshShiftErrors(const formats::LightMapStrip& band, int firstRow, int rowCount, const MeshShift& shift, double key,
                        ErrorAccumulator& errors, const MeshShiftSeen& seen = {});

/// The same bound as an RMS over the map, for any shift at once: a quad's bound is linear in the three parts of a shift, so that six sums
/// of products tell the RMS of all quads.
class MeshShiftBound {
public:
    /// Quads that begin in rows [firstRow, firstRow + rowCount) of the band, which also holds the row below.
    void add(const formats::LightMapStrip& band, int firstRow, int rowCount);
    void merge(const MeshShiftBound& other);
    /// RMS of the bounds over the RMS of the exit radiance at the quads' centres; valid for shifts of at most half a texel. 0 without
    /// quads or without light.
    double relRms(const MeshShift& shift) const;

private:
    double uu_ = 0, vv_ = 0, nn_ = 0, uv_ = 0, un_ = 0, vn_ = 0, reference_ = 0;
};

}  // namespace lightcook::verify

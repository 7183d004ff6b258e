// The surface of a mesh under the texels of a light map: normal and tangents at the place of each texel, for bakes in tangent space.
//
// A texel takes the point of the triangle, in light-map UVs (TEXCOORD_1), that is closest to its centre, if that point lies in the texel's
// square. Normals and tangents are interpolated as a rasterizer does; the tangent is made perpendicular to the normal.
// Tangents are those of attribute TANGENT, which baker and engine had too. Without it they follow the texture coordinates of the normal
// map, TEXCOORD_0 (glTF 2.0, section 3.7.2.1: a client computes them from the coordinates of the normal texture); a mesh without those is
// taken to have its normal maps in TEXCOORD_1. As in MikkTSpace, the corners at a vertex whose triangles are turned the same way in UVs
// share the mean of the triangles' tangents, weighted by the corner's angle. The bitangent points to where v is less, the top of a picture.
#pragma once

#include <array>
#include <filesystem>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "formats/bake_axes.h"
#include "formats/error.h"
#include "formats/image.h"
#include "formats/light_map_places.h"

namespace lightcook::formats {

/// Unit vectors in world axes; all zero where no triangle lies.
struct SurfaceFrame {
    glm::vec3 tangent{0}, bitangent{0}, normal{0};
    bool isSurface() const { return normal != glm::vec3(0); }
};

class SurfaceFrames {
public:
    /// Loads the triangles of a glTF that have light-map UVs. Fails if none has.
    /// width, height  of the light map [texels]
    /// lmbake, places  see GltfScene::load
    static Result<SurfaceFrames> load(const std::filesystem::path& mesh, int width, int height, const std::filesystem::path& lmbake = {},
                                      const std::vector<NodePlace>& places = {});

    /// Returns true if a triangle has tangents: an attribute, or texture coordinates that span an area.
    bool hasTangents() const;

    /// Gives all vectors in other axes.
    void turn(const BakeAxes& axes);

    /// Returns the frames of the rows [firstRow, firstRow + rowCount). Safe to call from several threads.
    /// margin  depth that a triangle must reach into the square of a texel [texels]
    Image<SurfaceFrame> rows(int firstRow, int rowCount, double margin = 0) const;

private:
    struct Corner {
        glm::vec2 place{0};  ///< [texels]
        glm::vec3 normal{0}, tangent{0};
    };
    struct Triangle {
        std::array<Corner, 3> corners;
        float sign = 1;  ///< bitangent = sign cross(normal, tangent)
    };
    SurfaceFrames(std::vector<Triangle> triangles, int width) : triangles_(std::move(triangles)), width_(width) {}

    static SurfaceFrame frameAt(const Triangle& triangle, const glm::dvec3& weights);

    friend class SurfaceBuilder;
    std::vector<Triangle> triangles_;
    int width_ = 0;
};

}  // namespace lightcook::formats

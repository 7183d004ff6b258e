// Seams of light maps: edges that two triangles share in space but not in a map. Each side of such an edge reads texels of its own, so
// that light steps from one side to the other (docs/theory/visible.md).
//
// Use:
//   1. SeamFinder over the triangles of the mesh                      -> SplitEdges
//   2. LightMapVerifier::lightAt on both sides of each place of them  -> LitSeamPlace
//   3. LightMapVerifier::seamErrors, merged in a fixed order          -> SeamErrors
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "lighting/sh.h"
#include "verify/visible.h"

namespace lightcook::verify {

/// A triangle of a lit surface, in the world.
struct SurfaceTriangle {
    std::array<glm::dvec3, 3> position;
    std::array<glm::vec3, 3> normal;  ///< (0, 0, 0): that of the triangle
    std::array<glm::dvec2, 3> uv;     ///< of the light map: (0, 0) is the first corner of the first texel
};

/// An edge whose two sides read different places of a light map.
struct SplitEdge {
    std::array<glm::dvec3, 2> position;           ///< [end]
    std::array<std::array<glm::dvec2, 2>, 2> uv;  ///< [side][end]
    std::array<glm::vec3, 2> normal;              ///< [end] unit; mean of both sides
    /// Returns the place of one side at a fraction of the edge [texels]; integers are texel centres.
    glm::dvec2 texelAt(std::size_t side, double along, const glm::dvec2& size) const;
    glm::dvec3 positionAt(double along) const;
    glm::vec3 normalAt(double along) const;
    /// Returns the number of places that are measured: both ends, and at least one place for each texel of the longer side.
    /// size  of the light map [texels]
    int placeCount(const glm::dvec2& size) const;
};

struct SplitEdges {
    std::vector<SplitEdge> edges;
    std::int64_t joined = 0;  ///< edges whose sides read the same texels
    std::int64_t hard = 0;    ///< edges whose sides have different normals
    std::int64_t open = 0;    ///< edges of one triangle alone
};

/// Matches the edges of triangles.
///
/// Triangles share an edge if both ends have the same positions, bit for bit. Edges that find no partner are matched once more, with
/// positions within kWeldTolerance of the largest coordinate. An edge is hard, and no seam, if the normals of its sides differ by more than
/// kHardAngle at an end, or if both triangles lie on the same side of it. Takes linear time, and memory for edges that wait for a partner.
class SeamFinder {
public:
    static constexpr double kHardAngle = 10;  ///< [degrees]
    static constexpr double kWeldTolerance = 4e-6;
    /// UVs this close read the same light, because filtered light is continuous [texels].
    static constexpr double kSameTexels = 1.0 / 64;

    /// size  of the light map [texels]
    explicit SeamFinder(const glm::dvec2& size);
    SeamFinder(SeamFinder&&) noexcept;
    SeamFinder& operator=(SeamFinder&&) noexcept;
    ~SeamFinder();
    void add(const SurfaceTriangle& triangle);
    /// Returns the edges, in the order in which their second triangles were added.
    SplitEdges finish() &&;

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Both sides of a place of a split edge.
struct LitSeamPlace {
    std::uint32_t edge = 0;
    double along = 0;
    glm::vec3 normal{0};
    std::array<glm::dvec2, 2> texel{};
    /// Light of each side, of LightMapVerifier::lightAt.
    std::array<std::span<const lighting::ShRgb>, 2> light;
};

/// The step of light at a place of an edge, for one normal or view.
struct SeamStep {
    std::uint32_t edge = 0;
    double along = 0;  ///< fraction of the edge
    std::array<glm::dvec2, 2> texel{};
    glm::dvec3 normal{0}, view{0};  ///< view: specular light only, as are m and f0
    double m = 0, f0 = 0;
    std::array<glm::dvec3, 2> bake{}, cooked{};  ///< light of each side
    double bakeStep = -1, cookedStep = -1;       ///< Delta E ITP between both sides; negative: no step is known
    double added = -1;                           ///< max(0, cookedStep - bakeStep)
    bool isKnown() const { return bakeStep >= 0; }
};

/// Steps of light over places of split edges. A place counts once, with its worst normal or view.
class SeamErrors {
public:
    /// Steps of one kind of shading.
    struct Kind {
        VisibleAccumulator added, cooked;
    };
    struct Stage {
        std::string name;
        Kind diffuse, specular;
    };
    explicit SeamErrors(std::vector<Stage> empty = {}) : stages(std::move(empty)) {}
    void merge(const SeamErrors& other);

    std::vector<Stage> stages;  ///< in the order of encoding
    VisibleAccumulator bakeDiffuse, bakeSpecular;
    SeamStep worstBakeDiffuse, worstBakeSpecular;  ///< largest steps of the bake itself
    /// Edges with the largest added steps of the last stage, the worst first: at most kKept.
    std::vector<SeamStep> worstDiffuse, worstSpecular;
    static constexpr std::size_t kKept = 64;
};

}  // namespace lightcook::verify

// What a cooked environment cubemap is worth: stored texels times S, as the shipped shader multiplies them, against a prefilter by brute
// force over every texel of the source. It shares nothing with the fit that made the map.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <vector>

#include "formats/environment.h"
#include "formats/image.h"
#include "lighting/sh.h"
#include "verify/figures.h"

namespace lightcook::verify {

/// A pre-divided cubemap as its manifest describes it, decoded. Kernel: Beckmann with n = v = r (lighting-math section 5).
struct CookedCubemap {
    struct Mip {
        double m = 0;                                  ///< 0: mean over the texel's footprint
        lighting::ShBands bands{1, 1, 1};              ///< S = sum_i bands_l(i) windowedSh_i Y_i
        std::vector<formats::Image<glm::vec4>> faces;  ///< six, +X -X +Y -Y +Z -Z, of one size
    };
    float range = 1;  ///< stored values are over it
    lighting::ShRgb windowedSh{};
    std::vector<Mip> mips;
};

/// The source as points: what every brute-force reference sums over. Building it costs a pass over the texels; sharing it is safe.
class CubemapReference {
public:
    /// The environment must outlive this.
    explicit CubemapReference(const formats::Environment& environment);
    /// Mean over the sphere, by exact solid angles.
    const glm::dvec3& mean() const { return mean_; }
    const glm::dvec3& smallest() const { return smallest_; }  ///< of any texel, per channel
    const glm::dvec3& largest() const { return largest_; }
    /// Radiance through the normalised Beckmann kernel around a unit direction, m in (0, 1]: every texel weighs by its solid angle, split
    /// into pieces so that one standard deviation of the kernel holds at least piecesPerWidth of them.
    glm::dvec3 prefiltered(const glm::dvec3& direction, double m, double piecesPerWidth = 8) const;
    /// Mean over the square of one texel's size (faces of size x size) around the direction, in the plane of its face: the source looked up
    /// at places x places points, weighted by solid angle.
    glm::dvec3 footprintMean(const glm::dvec3& direction, int size, int places) const;

private:
    /// Up to 32 x 32 texels of one face, and a cap that holds their centres.
    struct Tile {
        int left = 0, top = 0, width = 0, height = 0;  ///< in the image
        std::size_t first = 0;                         ///< of its texels in radiance_
        glm::dvec3 centre{0};
        double radius = 0, cosine = 1, sine = 0;  ///< [rad], and of it
    };
    /// Sines and cosines of evenly spaced angles.
    struct Angles {
        std::vector<double> sine, cosine;
    };
    struct Lobe;
    struct Columns;
    struct Workspace;
    void addTile(int left, int top, int width, int height);
    glm::dvec3 directionOf(int x, int y) const;
    double solidAngleOf(int x, int y) const;
    glm::dvec3 radianceAt(const glm::dvec3& direction) const;
    void fillColumns(const Tile& tile, const Lobe& lobe, int pieces, Columns& columns) const;
    void meetRow(const Lobe& lobe, const Tile& tile, int pieceY, int pieces, std::size_t begin, std::size_t end, Columns& columns) const;
    static void addWeights(const Lobe& lobe, const Columns& columns, std::size_t begin, std::size_t end, std::vector<double>& weights);
    void addRadiance(const Tile& tile, int y, std::size_t begin, std::size_t end, Workspace& workspace) const;
    void gatherTile(const Lobe& lobe, const Tile& tile, int pieces, Workspace& workspace) const;

    const formats::Environment& environment_;
    bool isPanorama_;
    std::vector<Tile> tiles_;                     ///< all texels, once each
    Angles longitudes_, colatitudes_;             ///< of a panorama's texels
    std::vector<double> faceSolidAngles_;         ///< [sr] of the texels of one face of a strip
    std::vector<double> faceInverseLengths_;      ///< 1 / |major + u right + v down| of their centres
    std::array<std::vector<float>, 3> radiance_;  ///< by channel; tile by tile, so that a tile lies in one piece
    double texelWidth_ = 0;                       ///< [rad] of the widest
    glm::dvec3 mean_{0}, smallest_{0}, largest_{0};
};

struct CubemapSampling {
    std::uint64_t seed = 1;
    int texelsPerMip = 96;      ///< at most; a level with fewer texels is sampled whole
    int directionsPerMip = 32;  ///< anywhere on the sphere, through the seamless filter
};
/// One place where map and reference are compared.
struct CubemapSample {
    int mip = 0;
    bool isTexel = false;        ///< a texel's centre; otherwise a filtered direction
    int face = 0, x = 0, y = 0;  ///< of a texel
    glm::dvec3 direction{0};     ///< unit
};
/// The same list for the same map and sampling, mip by mip.
std::vector<CubemapSample> cubemapSamples(const CookedCubemap& map, const CubemapSampling& sampling);

/// Band factors of Beckmann's kernel with n = v = r, by quadrature: the integrals of its product with the Legendre polynomials over its
/// own. 1, 1, 1 for m = 0. What a mip's factors have to be, within kBandTolerance: with others, which divide and multiply just as well, a
/// pixel would be given another energy than its own.
lighting::ShBands kernelBands(double m);
inline constexpr double kBandTolerance = 1e-3;

/// What the shader shows of a stored value (as fetched) in a unit direction: radiance.
glm::dvec3 shadeCubemap(const CookedCubemap& map, int mip, const glm::vec3& stored, const glm::dvec3& direction);

struct CubemapResult {
    glm::dvec3 reference{0}, cooked{0};
};
/// Pure and safe on several threads: samples may be worked on in any order.
CubemapResult compareCubemap(const CookedCubemap& map, const CubemapReference& reference, const CubemapSample& sample);

/// Stages "divide" (texel centres), "filter" (between them) and "total": rms and percentile of the texels, largest of both. All of it is
/// specular. results: one for each sample, in their order. Key: the luminance of the mean radiance. A map whose S is not positive
/// everywhere (exact minimum), or not finite, gets figures that pass no limit.
std::vector<StageError> cubemapStages(const CookedCubemap& map, const CubemapReference& reference, std::span<const CubemapSample> samples,
                                      std::span<const CubemapResult> results,
                                      const glm::vec3& luminanceWeights = lighting::kRec709Luminance);

}  // namespace lightcook::verify

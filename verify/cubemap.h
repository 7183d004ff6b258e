// Verification of cubemaps: of a prefiltered environment cubemap (stored texels, of a pre-divided one times S, as the shipped shader
// multiplies them) and of an irradiance cubemap, both against brute-force integrals over every texel of the source. Nothing is shared with
// fit/. docs/theory/lighting.md, "Pre-divided cubemaps", describes the division by S.
//
// Use: cubemapSamples -> compareCubemap for each -> cubemapStages. Irradiance: compareIrradiance.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <optional>
#include <span>
#include <vector>

#include "formats/environment.h"
#include "formats/image.h"
#include "lighting/brdf.h"
#include "lighting/sh.h"
#include "verify/figures.h"
#include "verify/sampler_tolerance.h"

namespace lightcook::verify {

/// A prefiltered cubemap as its manifest describes it, decoded. The kernel is D(NoH) c of the lobe with n = v = r.
struct CookedCubemap {
    struct Mip {
        double m = 0;                                  ///< 0: mean over the texel's footprint
        lighting::ShBands bands{1, 1, 1};              ///< S = sum_i bands_l(i) windowedSh_i Y_i
        std::vector<formats::Image<glm::vec4>> faces;  ///< six, +X -X +Y -Y +Z -Z, of one size
    };
    float range = 1;        ///< stored values are over it
    bool isDivided = true;  ///< by S; otherwise S is 1
    lighting::ShRgb windowedSh{};
    std::vector<Mip> mips;
    lighting::NormalDistribution lobe = lighting::NormalDistribution::Beckmann;
    FormatTolerance tolerance;  ///< of samplers, for the texture's format; default: ideal samplers
};

/// First moments of light over the sphere.
struct LightMoments {
    glm::dvec3 mean{0};                 ///< of the radiance, by channel
    std::array<glm::dvec3, 3> first{};  ///< [channel] mean of the radiance times its direction
    void add(const glm::dvec3& radiance, const glm::dvec3& direction, double solidAngle);
    void scale(double factor);
};

/// The texels of the source environment as points of known direction, solid angle and radiance, over which every reference integral sums.
/// Construction costs one pass over the texels. Safe to share between threads.
class CubemapReference {
public:
    /// The environment must outlive this.
    explicit CubemapReference(const formats::Environment& environment);
    /// Returns the mean radiance over the sphere, by exact solid angles.
    const glm::dvec3& mean() const { return moments_.mean; }
    const LightMoments& moments() const { return moments_; }
    /// Returns the key that a display shows the environment's own light with (docs/theory/visible.md): displayKeyOf the exit radiance of
    /// white Lambert surfaces that it lights, by its first nine coefficients, for kKeyNormals normals spread evenly over the sphere.
    double displayKey(const glm::vec3& luminanceWeights) const;
    static constexpr int kKeyNormals = 256;
    /// Returns the nine SH coefficients of the incident radiance, for a probe whose SH is not given. Texels of a small environment are
    /// split, so that a face has at least 64 pieces across and a panorama 256 rows: integrals over their squares then err by less than 2e-4
    /// of the largest coefficient.
    std::array<glm::dvec3, lighting::kShCount> incidentSh() const;
    const glm::dvec3& smallest() const { return smallest_; }  ///< texel value, per channel
    const glm::dvec3& largest() const { return largest_; }
    /// The value of a texel in one channel, and its solid angle [sr].
    struct Weighted {
        float radiance;
        double solidAngle;
    };
    /// Returns all texels of a channel, from dark to bright.
    std::vector<Weighted> sorted(int channel) const;
    /// Returns radiance through the normalized kernel of a lobe around a unit direction. Texels are weighted by solid angle, and split into
    /// pieces such that one standard deviation of Beckmann's kernel holds at least piecesPerWidth of them. The tail of GGX reaches over the
    /// whole hemisphere: away from its peak, where the kernel changes over a width in proportion to the angle, pieces are as large.
    /// m  in (0, 1]
    glm::dvec3 prefiltered(const glm::dvec3& direction, double m, double piecesPerWidth = 8,
                           lighting::NormalDistribution lobe = lighting::NormalDistribution::Beckmann) const;
    /// Returns the mean over a square around the direction, in the plane of its face, of the size of a texel of size x size faces.
    /// By solid angle, with the parts of source texels that it has: within 1e-3 of the differences between them. Around a direction whose
    /// square leaves the face of a strip the source is looked up at points, within a hundredth.
    glm::dvec3 footprintMean(const glm::dvec3& direction, int size) const;
    /// Returns the means over the squares of all texels of a face of size x size texels, as footprintMean() of their centres.
    formats::Image<glm::vec3> footprintMeans(int face, int size) const;

private:
    /// Up to 32 x 32 texels of one face, and a spherical cap that contains their centres.
    struct Tile {
        int left = 0, top = 0, width = 0, height = 0;  ///< in the image
        std::size_t first = 0;                         ///< index of its texels in radiance_
        glm::dvec3 centre{0};
        double radius = 0, cosine = 1, sine = 0;  ///< [rad], and its cosine and sine
    };
    /// Tables of sines and cosines at even steps.
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
    void visitRow(const Lobe& lobe, const Tile& tile, int pieceY, int pieces, std::size_t begin, std::size_t end, Columns& columns) const;
    static void addWeights(const Lobe& lobe, const Columns& columns, std::size_t begin, std::size_t end, std::vector<double>& weights);
    void addRadiance(const Tile& tile, int y, std::size_t begin, std::size_t end, Workspace& workspace) const;
    void gatherTile(const Lobe& lobe, const Tile& tile, int pieces, Workspace& workspace) const;

    const formats::Environment& environment_;
    bool isPanorama_;
    std::vector<Tile> tiles_;                     ///< together all texels, each once
    Angles longitudes_, colatitudes_;             ///< angles of a panorama's texels
    std::vector<double> faceSolidAngles_;         ///< [sr] texels of one face of a cube strip
    std::vector<double> faceInverseLengths_;      ///< 1 / |major + u right + v down| of their centres
    std::array<std::vector<float>, 3> radiance_;  ///< [channel], tile after tile, so a tile is contiguous
    double texelWidth_ = 0;                       ///< largest [rad]
    LightMoments moments_;
    glm::dvec3 smallest_{0}, largest_{0};
};

/// Returns an environment with larger texels, whose values are means by solid angle: as large as `width` [rad] allows. Prefiltered light of
/// a kernel that is much wider is nearly the same, and takes a fraction of the time. Empty if the environment's own texels are that large.
std::optional<formats::Environment> reducedEnvironment(const formats::Environment& environment, double width);

struct CubemapSampling {
    std::uint64_t seed = 1;
    int texelsPerMip = 96;      ///< at most; mips with fewer texels are sampled whole
    int directionsPerMip = 32;  ///< anywhere on the sphere, through the seamless filter
};
/// A place where map and reference are compared.
struct CubemapSample {
    int mip = 0;
    bool isTexel = false;        ///< a texel's centre; otherwise a filtered direction
    int face = 0, x = 0, y = 0;  ///< of the texel
    glm::dvec3 direction{0};     ///< unit
};
/// Returns the samples, mip by mip: the same list for the same map and sampling.
std::vector<CubemapSample> cubemapSamples(const CookedCubemap& map, const CubemapSampling& sampling);

/// Returns the band factors of a lobe's kernel with n = v = r by quadrature: integrals of its products with Legendre polynomials over its
/// own integral; 1, 1, 1 for m = 0. The factors of a mip must agree with them within kBandTolerance: other factors would divide and
/// multiply just as well, but change the energy of every pixel.
lighting::ShBands kernelBands(double m, lighting::NormalDistribution lobe = lighting::NormalDistribution::Beckmann);
inline constexpr double kBandTolerance = 1e-3;

/// Returns the radiance that the shader computes from a fetched value in a unit direction.
glm::dvec3 shadeCubemap(const CookedCubemap& map, int mip, const glm::vec3& stored, const glm::dvec3& direction);

struct CubemapResult {
    glm::dvec3 reference{0}, cooked{0};
};
/// Pure and safe on several threads: samples may be worked on in any order.
CubemapResult compareCubemap(const CookedCubemap& map, const CubemapReference& reference, const CubemapSample& sample);

/// Returns the moments of the radiance that the shader computes at the texels of a mip, by their solid angles. Those of a correct map are
/// the moments of the source: the mean as it is, the first ones times band 1 of the mip's kernel.
LightMoments cubemapMoments(const CookedCubemap& map, int mip);

/// Returns the part of prefiltered light that a surface of F0 1 reflects when it is seen along its normal, as the prefilter assumes: the
/// directional albedo of the energy-conserving Cook-Torrance lobe. 1 for m below 1e-4.
double cubemapReflectance(double m, lighting::NormalDistribution lobe);

/// Returns stages "divide" (texel centres), "filter" (between them) and "total" (RMS and percentile of the texels, maxima of both), all
/// specular. The key is the luminance of the mean radiance. A map whose S is not finite or not positive everywhere (by its exact minimum),
/// or whose texels are not all finite, gets figures that pass no limit.
/// results  one for each sample, in their order
/// viewing  display for visible errors, of the light times cubemapReflectance of its mip; empty: none
std::vector<StageError> cubemapStages(const CookedCubemap& map, const CubemapReference& reference, std::span<const CubemapSample> samples,
                                      std::span<const CubemapResult> results,
                                      const glm::vec3& luminanceWeights = lighting::kRec709Luminance,
                                      const std::optional<Viewing>& viewing = std::nullopt);

struct IrradianceFigures {
    int texelCount = 0;
    double relRms = 0;  ///< RMS of the error over RMS of the references
    double worst = 0;   ///< largest |error| / (reference + 2 % of the mean radiance) of a channel
};
/// Compares an irradiance cubemap at up to 96 evenly spread texels with integral of L max(0, n.l + wrap) / (pi (1 + wrap)^2), summed over
/// every source texel's centre by solid angle and divided by the sum of the weights. Both figures are the largest double if one of these
/// texels is not finite.
/// faces  six of one size, decoded, over `range`
IrradianceFigures compareIrradiance(std::span<const formats::Image<glm::vec4>> faces, float range, double wrap,
                                    const formats::Environment& environment);

}  // namespace lightcook::verify

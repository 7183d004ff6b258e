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

/// The texels of the source environment as points of known direction, solid angle and radiance, over which every reference integral sums.
/// Construction costs one pass over the texels. Safe to share between threads.
class CubemapReference {
public:
    /// The environment must outlive this.
    explicit CubemapReference(const formats::Environment& environment);
    /// Returns the mean radiance over the sphere, by exact solid angles.
    const glm::dvec3& mean() const { return mean_; }
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
    /// Returns the mean over a square around the direction, in the plane of its face, of the size of a texel of size x size faces.
    /// By solid angle, with the parts of source texels that it has: within 1e-3 of the differences between them. Around a direction whose
    /// square leaves the face of a strip the source is looked up at points, within a hundredth.
    glm::dvec3 footprintMean(const glm::dvec3& direction, int size) const;
    /// Returns the means over the squares of all texels of a face of size x size texels, as footprintMean() of their centres.
    formats::Image<glm::vec3> footprintMeans(int face, int size) const;

private:
    glm::dvec3 directionOf(int x, int y) const;
    double solidAngleOf(int x, int y) const;
    glm::dvec3 radianceAt(const glm::dvec3& direction) const;

    const formats::Environment& environment_;
    bool isPanorama_;
    std::vector<double> faceSolidAngles_;  ///< [sr] texels of one face of a cube strip
    glm::dvec3 mean_{0};
    glm::dvec3 smallest_{0}, largest_{0};
};

/// The light of an environment through the normalized kernel of one lobe and roughness. Texels of the source are squares of even radiance.
/// Construction costs a pass over them; a direction then takes microseconds, whatever the size of the source. assets/prefiltered_light.cpp
/// describes the method; its error is about 1e-3 of the largest prefiltered light at most. Safe to share between threads.
class PrefilteredLight {
public:
    /// The environment must outlive this.
    /// m      in (0, 1]
    /// other  of the same environment, which need not outlive this: its integrals are taken where they are the same
    PrefilteredLight(const formats::Environment& environment, double m,
                     lighting::NormalDistribution lobe = lighting::NormalDistribution::Beckmann, const PrefilteredLight* other = nullptr);
    PrefilteredLight(PrefilteredLight&&) noexcept;
    ~PrefilteredLight();
    /// direction  unit
    glm::dvec3 towards(const glm::dvec3& direction) const;

private:
    struct Point;
    struct Grid;
    struct Sums;
    struct TileIndex {
        int face, x, y;
    };
    double edge(const Grid& grid, bool isRow, int tile) const;
    glm::dvec3 directionAt(int face, double x, double y) const;
    void integrateGrids();
    void place(Grid& grid) const;
    void setReach(Grid& grid) const;
    std::vector<std::vector<Point>> pointsOf(const Grid& grid, bool isRow, int texels) const;
    void integrate(Grid& grid) const;
    void join(const Grid& fine, Grid& coarse) const;
    static std::size_t indexOf(const Grid& grid, int face, int x, int y);
    template <lighting::NormalDistribution kLobe>
    void addNodes(const Grid& grid, const TileIndex& at, const glm::dvec3& direction, Sums& sums) const;
    template <lighting::NormalDistribution kLobe>
    void visit(std::size_t level, const TileIndex& at, const glm::dvec3& direction, Sums& sums) const;
    template <lighting::NormalDistribution kLobe>
    glm::dvec3 sum(const glm::dvec3& direction) const;

    const formats::Environment& environment_;
    bool isPanorama_;
    double m_;
    lighting::NormalDistribution lobe_;
    double support_;           ///< [rad]
    double narrow_ = 0;        ///< largest extent of a tile at the kernel's peak [rad]
    double brightest_ = 0;     ///< texel value, which the sums are over
    std::vector<Grid> grids_;  ///< from fine to coarse
};

/// A direction between texels where map and reference are compared, through the seamless filter.
struct CubemapSample {
    int mip = 0;
    glm::dvec3 direction{0};  ///< unit
};
/// Returns `count` random directions for each mip, spread evenly over the sphere: the same list for the same seed.
std::vector<CubemapSample> cubemapSamples(const CookedCubemap& map, int count, std::uint64_t seed = 1);

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
/// Returns the filtered radiance of a sample beside its reference. Pure and safe on several threads.
CubemapResult compareCubemap(const CookedCubemap& map, const CubemapSample& sample, const glm::dvec3& reference);

/// Errors of texels of a level, each by its solid angle in squares; percentiles count texels.
struct CubemapErrors {
    ErrorAccumulator energy;
    std::optional<VisiblePairs> visible;
    ErrorAccumulator ratios;  ///< of light over S

    /// viewing  empty: visible errors are not measured
    CubemapErrors(double key, const std::optional<Viewing>& viewing);
    /// Merge faces in a fixed order for reproducible bits.
    void merge(const CubemapErrors& other);
};
/// Compares all texels of a face of a level.
/// references  light of the source at the texels
/// key         luminance of the mean radiance
CubemapErrors compareCubemapFace(const CookedCubemap& map, int mip, int face, formats::ImageView<const glm::vec3> references, double key,
                                 const std::optional<Viewing>& viewing = std::nullopt);

/// Returns the part of prefiltered light that a surface of F0 1 reflects when it is seen along its normal, as the prefilter assumes: the
/// directional albedo of the energy-conserving Cook-Torrance lobe. 1 for m below 1e-4.
double cubemapReflectance(double m, lighting::NormalDistribution lobe);

/// Returns stages "divide" (texel centres), "filter" (between them) and "total" (figures of the texels, maxima of both), all specular. Each
/// level is the light of surfaces of one roughness and has figures of its own; those of the map are the largest of its levels. A map whose
/// S is not finite or not positive everywhere (by its exact minimum), or whose texels are not all finite, gets figures that pass no limit.
/// levels   errors of all texels of each mip
/// results  one for each sample, in their order
/// viewing  display for visible errors, of the light times cubemapReflectance of its mip; empty: none
std::vector<StageError> cubemapStages(const CookedCubemap& map, const CubemapReference& reference, std::span<const CubemapErrors> levels,
                                      std::span<const CubemapSample> samples, std::span<const CubemapResult> results,
                                      const glm::vec3& luminanceWeights = lighting::kRec709Luminance,
                                      const std::optional<Viewing>& viewing = std::nullopt);

struct IrradianceFigures {
    int texelCount = 0;
    double relRms = 0;  ///< RMS of the error over RMS of the references
    double worst = 0;   ///< largest |error| / (reference + 2 % of the mean radiance) of a channel
};
/// Compares every texel of an irradiance cubemap with the integral of L max(0, n.l + wrap) / (pi (1 + wrap)^2), summed over every source
/// texel's centre by solid angle and divided by the sum of the weights. Both figures are the largest double if a texel is not finite.
/// faces  six of one size, decoded, over `range`
IrradianceFigures compareIrradiance(std::span<const formats::Image<glm::vec4>> faces, float range, double wrap,
                                    const formats::Environment& environment);

}  // namespace lightcook::verify

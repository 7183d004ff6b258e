// Ranges of shading as balls of kernels, which a search cuts into smaller ones (visible_search.h). Private to verify/.
//
// Light c is shaded to the sum of kernel_i c_i. In the frame of a texel a kernel is one of the x-z plane, its profile, turned about the
// normal by an azimuth. The profiles of diffuse light are those of the tilts of a normal map; those of specular light are those of the
// views, m and F0 of the scene. A tree holds ranges of profiles, and each range has a centre P, tangents T_i and a radius r_l by band:
//   every profile of the range is P + sum_i x_i T_i + a rest of band lengths at most r_l, for some x_i in [-1, 1].
// - Diffuse: profiles are k_l Y_l(angle). The one tangent is the derivative times the half width h; the rest is at most
//   h^2/2 l^2 |k_l Y_l|, since a rotation's generator has the eigenvalues -l .. l times i.
// - Specular: kernels on a grid of view and m, linear in F0; between grid points they are multilinear, up to an error that second
//   differences bound (scanned_kernels.h). The tangents are half the differences across the box of view, m and F0; the rest is largest at
//   a grid point or a corner of the box.
// An azimuth within h of phi turns the kernel by Taylor's formula in the same way; for a range wider than that is good for, the centre is
// the part that no azimuth changes, and all else counts as radius.
#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <vector>

#include "lighting/sh.h"
#include "verify/light_map/scanned_kernels.h"

namespace lightcook::verify {

/// Tangents of a range of profiles: along the angle of normal or view, m and F0.
inline constexpr std::size_t kProfileTangents = 3;
using ProfileTangents = std::array<lighting::ShDouble, kProfileTangents>;

/// Kernels centre + sum of x_i alongProfile_i + y alongAzimuth + rest: x_i and y in [-1, 1], band lengths of the rest at most the sum of
/// both radii.
struct KernelCell {
    lighting::ShDouble centre{}, alongAzimuth{};
    ProfileTangents alongProfile{};
    lighting::ShBands profileRadius{}, azimuthRadius{};
    lighting::ShBands lengths{};              ///< largest length of each band
    std::size_t tangents = kProfileTangents;  ///< that are not 0
    bool isDiffuse = false;
    /// Diffuse light: all normals of the range are within the sum of both angles [rad] of this one.
    glm::dvec3 normal{0, 0, 1};
    double profileAngle = 0, azimuthAngle = 0;
};

/// A range of profiles.
struct ProfileRange {
    lighting::ShDouble centre{};
    ProfileTangents tangents{};
    lighting::ShBands radius{};
    int first = -1, second = -1;  ///< its halves; -1: a leaf
    double angle = 0;             ///< of the normal or the view from the texel's normal, in the middle [rad]
    double halfAngle = 0;         ///< diffuse light only: half of the range of angles [rad]
    double m = 0, f0 = 0;         ///< specular light only
    bool isLeaf() const { return first < 0; }
};

/// All profiles of a kind of shading; range 0 is all of them.
class KernelTree {
public:
    /// Returns the exit radiance of a white surface at every normal up to `tilt` degrees from the texel's own.
    static KernelTree diffuse(double tilt);
    /// Returns area specular of every view and of the ranges of m and F0.
    static KernelTree specular(const LightMapShading& shading, const ScannedKernels& scanned);

    const ProfileRange& range(int index) const { return ranges_[static_cast<std::size_t>(index)]; }
    std::size_t size() const { return ranges_.size(); }
    bool isSpecular() const { return isSpecular_; }
    /// Returns the kernels of a range, turned by an azimuth within `half` of `azimuth` [rad].
    KernelCell cell(int range, double azimuth, double half) const;
    /// Azimuths of this half width or less are turned by Taylor's formula.
    static constexpr double kNarrow = 0.5;

private:
    int addDiffuse(double low, double high, int depth);
    struct SpecularGrid;
    /// low, high  view, roughness [steps of the grid] and F0
    static ProfileRange specularRange(const SpecularGrid& grid, const glm::dvec3& low, const glm::dvec3& high);
    int addSpecular(const SpecularGrid& grid, const glm::dvec3& low, const glm::dvec3& high, double brightest);

    std::vector<ProfileRange> ranges_;
    bool isSpecular_ = false;
};

/// Balls that cover the kernels of a tree. Those of specular light cover each kernel times a factor of at least 1 that makes its band 0 as
/// long as that of the brightest: a number in [0, 1] of VisibleMetric::coarseBound makes the kernel of it again.
struct CoarseKernels {
    std::vector<lighting::ShDouble> centres;
    std::vector<lighting::ShBands> radii;
    lighting::ShBands lengths{};  ///< largest length of each band

    static CoarseKernels diffuse(const KernelTree& tree);
    static CoarseKernels specular(const KernelTree& tree);

private:
    /// Adds the kernels within a ball, in all azimuths.
    void addTurned(const lighting::ShDouble& profile, const lighting::ShBands& radius);
};

}  // namespace lightcook::verify

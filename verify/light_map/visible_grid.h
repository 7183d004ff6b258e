// Upper bound of the visible error of a quarter of a quad under all kernels at once, on a grid of control kernels. Private to verify/.
//
// Every kernel of the grid's kind is a mean of neighbouring control kernels K_i, and of none at all where the kind has dimmer kernels, up
// to a rest of known band lengths. Light under a kernel at a place is a mean of control vectors (visible_search.h). So the light of a
// reference R and of what is found F is a mean of R_ij = K_i . r_j and F_ij, with the same weights, up to a rest.
//
// Let q(z) = 1 / PQ'(z). It is concave up to 449.6 cd/m^2; beyond, a line under it takes its place. The secant of the curve between X and Y
// is s(X, Y) = integral over t in [0, 1] of 1 / q(X + t (Y - X)). Its inverse is a harmonic mean of a concave, positive function of (X, Y),
// hence concave itself. For a mean with weights w_j, and any convex function u of the error that is 0 at 0 and homogeneous,
//   s(F, R) u(e) <= (sum of w_j u(e_j)) / (sum of w_j / s(F_j, R_j)) <= max_j s(F_j, R_j) u(e_j),
// so that each control is bounded against its own reference. With D_k the difference in L, M or S, s_k = a_k s_L and a_k in an interval
// (VisibleMetric::secantRatio), |sum_k itp_k s_k D_k| <= s_L u(e), where
//   u = |sum_k itp_k mean(a_k) D_k| + sum_k |itp_k| halfWidth(a_k) |D_k|.
// The interval has to hold for all means of a control with its neighbours; so do the signs of the channels. A channel c that may be
// negative is clamped, which multiplies its error by a number in [0, 1]: u is largest where that is 0 or 1. It may be 0 in the light: then
// L without it is a lower bound.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "verify/error/visible_any_light.h"
#include "verify/error/visible_metric.h"
#include "verify/light_map/kernel_cells.h"
#include "verify/light_map/scanned_kernels.h"
#include "verify/light_map/visible_search.h"

namespace lightcook::verify {

/// Control kernels in the frame of a texel: azimuths, the fastest, around the normal; angles of the normal or the view; roughnesses.
struct KernelGrid {
    static constexpr std::size_t kLanes = 8;  ///< `azimuths` is a multiple of it
    std::size_t azimuths = 0, angles = 0, shapes = 0;
    std::array<std::vector<float>, lighting::kShCount> kernels;  ///< [coefficient][kernel]
    /// Lengths of the bands, [band][kernel], rounded up: of what a mean of this kernel and its neighbours may lack, and of all these
    /// kernels.
    std::array<std::vector<float>, 3> rest, lengths;
    bool isDimmed = false;  ///< kernels are means of these, times a number in [0, 1]

    std::size_t count() const { return azimuths * angles * shapes; }
    /// Returns the exit radiance of a white surface at every normal up to `tilt` degrees from the texel's own.
    /// fineness  1 or more: kernels along each axis, relative to the coarsest grid
    static KernelGrid diffuse(double tilt, int fineness);
    /// Returns area specular of every view and of the ranges of m and F0.
    static KernelGrid specular(const LightMapShading& shading, const ScannedKernels& scanned, int fineness);

private:
    using Row = lighting::ShDouble;  ///< a kernel of the x-z plane
    /// Adds the kernels of a row in all azimuths.
    void addRow(const Row& profile, const lighting::ShBands& rest, const lighting::ShBands& lengths);
};

/// A coarse grid, for errors alone, and a fine one.
struct KernelGrids {
    KernelGrid coarse, fine;
};

/// Bounds light under all kernels of a grid.
class GridBound {
public:
    GridBound(const VisibleMetric& metric, const AnyLightBound& anyLight, const KernelGrids& grids)
        : metric_(metric), anyLight_(anyLight), grids_(grids) {}
    /// Returns an upper bound [Delta E ITP]; infinite where nothing is proven: of light that is not finite, beyond the curve, in tangent
    /// space, or whose channels may lower L, M or S.
    /// threshold  a bound below it need not be tight
    double bound(const CellLight& light, double threshold, bool isFine);
    /// Returns the work of the last bound [cells of one control vector].
    double work() const { return work_; }

private:
    class Bounding;

    const VisibleMetric& metric_;
    const AnyLightBound& anyLight_;
    const KernelGrids& grids_;
    std::vector<float> planes_;
    double work_ = 0;
};

}  // namespace lightcook::verify

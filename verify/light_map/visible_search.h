// Upper bound of the visible error of a quarter of a quad under every kernel of a tree, by branch and bound. Private to verify/.
//
// A cell is a rectangle of places and a range of kernels (kernel_cells.h). Over the rectangle, error e and reference r are means, with the
// same weights, of control vectors e_j and r_j. For a sum f = sum_c w_c e_c of channels, kernel K = centre + x T + y A + rest gives
//   f in hull_j [centre . f_j -+ (|T . f_j| + |A . f_j| + sum_l radius_l |f_j|_l)] -+ slack.
// From such intervals of r_c, e_c and of L, M, S of both follow those of the codes and of I, T and P (visible_metric.h): once from the
// codes, and once as one sum of channels with the mean slopes of the curve, to which |slope - mean slope| |difference| is added. Where a
// channel may be negative its difference is that of the clamped values, an interval of its own: |max(a, 0) - max(b, 0)| <= |a - b|.
//
// The search splits the cell with the largest bound: along places, profile or azimuth, whichever widens the bound most. Narrow cells try
// places and kernels one at a time. The search ends when the largest bound is at most 1.25 times the bound of that cell's middle place and
// kernel alone, or after 24 to 384 cells, times the effort; a decode of low degree may have more of them. The caller may allow fewer
// (SearchBudget): any cells at all prove a bound. The result depends on the quarter and the number of cells alone, unless it is no more
// than the caller's threshold.
#pragma once

#include <algorithm>
#include <array>
#include <functional>
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <memory>
#include <vector>

#include "verify/error/visible_metric.h"
#include "verify/light_map/kernel_cells.h"
#include "verify/light_map/vectors.h"

namespace lightcook::verify {

/// A rectangle of places, in fractions of a quad.
struct PlaceRectangle {
    glm::vec2 low{0}, size{1};
    glm::vec2 middle() const { return low + 0.5f * size; }
};

/// Vectors of light, in lanes, and the largest length of each band by channel.
class LightVectors {
public:
    static constexpr std::size_t kLanes = 4;
    void add(const std::array<lighting::Sh, 3>& light);
    std::size_t count() const { return count_; }
    std::size_t stride() const { return (count_ + kLanes - 1) / kLanes * kLanes; }
    /// Returns the value of coefficient i of a channel of each vector; the lanes beyond the last vector repeat it.
    const double* values(std::size_t channel, std::size_t i) const { return values_[channel][i].data(); }
    double value(std::size_t vector, std::size_t channel, std::size_t i) const { return values_[channel][i][vector]; }
    const lighting::ShBands& largest(std::size_t channel) const { return largest_[channel]; }
    static constexpr std::size_t kMost = 28;

private:
    std::size_t count_ = 0;
    std::array<std::array<std::array<double, kMost>, lighting::kShCount>, 3> values_;
    lightmap::ChannelSlack largest_{};
};

/// Control vectors of light over a rectangle, in the frame of the texel and in units of the key.
struct CellLight {
    LightVectors errors, references, found;  ///< found: the sums of both
    lightmap::ChannelSlack errorSlack{}, referenceSlack{};
    /// Vectors that may be added to any error, each times a number of its own in [-1, 1].
    LightVectors deviations;
    /// Layouts in tangent space: light of their directions, as coefficients 0 to 2, which diffuse kernels show beside the errors
    /// (rnm_residual.h), in a right-handed frame whose x is the tangent. As many vectors as `errors` has; others have none.
    LightVectors directions;
    bool isFinite = true;  ///< false: nothing can be proven
};

/// Light of a place, or the control vectors of a rectangle with a size.
using LightOver = std::function<CellLight(const PlaceRectangle&)>;

/// The largest bound of some light, and the place where it is reached.
struct VisibleMaximum {
    double bound = 0;  ///< Delta E ITP
    VisiblePlace place;
    bool isFinal = true;  ///< false: more cells may lower it
};

/// Work that the searches of some rows may do together, so that their time is bounded whatever the light.
class SearchBudget {
public:
    /// work  [cells of one control vector]; less than 1 is none
    explicit SearchBudget(double work) : left_(work) {}
    bool isSpent() const { return left_ < 1; }
    /// Returns how many cells the next search may have, at least 1.
    /// controls  control vectors of a cell
    int cells(std::size_t controls) const {
        constexpr double kMost = 1e6;
        return static_cast<int>(std::clamp(left_ / workOf(controls), 1.0, kMost));
    }
    void spend(double work) { left_ -= work; }
    /// Pays for a search with so many cells, and for its control vectors.
    void spend(int cells, std::size_t controls) { spend(cells * workOf(controls) + static_cast<double>(controls) / 4); }

private:
    /// Returns the work of a cell: most of it does not depend on the number of control vectors.
    static double workOf(std::size_t controls) { return 1 + static_cast<double>(controls) / 16; }
    double left_;
};

class VisibleSearch {
public:
    /// A bound within this factor of what is reached ends a search.
    static constexpr double kConvergedFactor = 1.25;

    VisibleSearch(const VisibleMetric& metric, const KernelTree& tree) : metric_(metric), tree_(tree) {}

    /// Returns a bound for a rectangle of places. `place` has x and y in fractions of the quad, directions in the frame of the texel, and
    /// light in the units of lightOver.
    /// threshold  a bound below it need not be tight, and has no place
    /// budget     pays for the cells
    /// effort     how many times the usual number of cells it may have
    VisibleMaximum bound(const PlaceRectangle& whole, const LightOver& lightOver, double threshold, SearchBudget& budget, int effort) const;
    /// Returns the bound of one cell.
    double cellBound(const CellLight& light, const KernelCell& kernels) const;

private:
    const VisibleMetric& metric_;
    const KernelTree& tree_;
};

}  // namespace lightcook::verify

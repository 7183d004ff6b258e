// Comparison of bounds with the largest bound found so far. Private to verify/.
//
// A map's bound is the maximum over all its texels and quads. A texel or quad whose cheap upper bound cannot exceed the current maximum is
// skipped, so the maximum stays exact while few exact bounds are computed. From cheapest to exact:
//   1. ErrorBound: band lengths times the largest response of each band, in floats
//   2. BoundEvaluator::cannotExceed(Squares, ChannelSlack): the same from control vectors, in doubles
//   3. verify::cannotExceed (bound.h): a test of quadratics on the sphere
//   4. localErrorBound (bound.h): the bound itself
// Under even light all texels and quads are alike, and no test tells them apart. So the exact bounds of a strip have a budget; when it is
// spent, 2 takes the place of 3 and 4: the bound is looser, but proven, and the time does not depend on the light.
#pragma once

#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "verify/figures.h"
#include "verify/light_map/bound.h"
#include "verify/light_map/shading.h"
#include "verify/light_map/vectors.h"
#include "verify/light_map/visible_bound_setup.h"
#include "verify/sampler_tolerance.h"

namespace lightcook::verify {

/// Shading and bounding of a map, for all layouts.
struct ShadingSetup {
    ShadingMatrices matrices;
    std::vector<Response> responses;           ///< area specular, for the bounds
    lighting::ShBands largestResponse{};       ///< largest norm of each band over the responses
    std::vector<FormatTolerance> tolerance;    ///< of each layer; empty: an ideal sampler
    std::optional<VisibleBoundSetup> visible;  ///< empty: no bounds of visible errors
    bool hasSpecular() const { return !responses.empty(); }
};

namespace lightmap {

/// The largest bound so far for one kind of shading, and its place.
struct LargestBound {
    double bound = 0;
    ErrorPlace place;
    lighting::ShBands bands{};  ///< of the response that reached the bound
    /// Raises the bound to `candidate` at `at`. Ties go to the smaller (y, x, channel), so the result does not depend on evaluation order.
    void raise(double candidate, const ErrorPlace& at, const lighting::ShBands& response);
};
struct LargestBounds {
    LargestBound diffuse, specular;
    double work = 0;  ///< done for exact bounds: control vectors times responses
    double mostWork = std::numeric_limits<double>::infinity();
    /// Returns true if no further exact bounds are computed.
    bool isSpent() const { return work >= mostWork; }
};

/// Upper bounds of the shaded error, in units of the key.
struct ErrorBound {
    float diffuse = 0, specular = 0;
    void raise(const ErrorBound& other) {
        // Written so that NaN stays: every comparison with it is false.
        diffuse = other.diffuse <= diffuse ? diffuse : other.diffuse;
        specular = other.specular <= specular ? specular : other.specular;
    }
};

/// Positions of the pairs of a bound: a single texel at (x, y), or the control vectors of a square of side `size` from (x, y), in rows of
/// `nodes`.
struct PairPlaces {
    double x, y, size = 0;
    std::size_t nodes = 1;
    int channel = 0;
};

/// Bounds the shaded error under every shading of a map, and compares bounds with the largest so far.
class BoundEvaluator {
public:
    /// perKey  1 / key: converts light to units of the key
    BoundEvaluator(const ShadingSetup& setup, float perKey);
    const ShadingSetup& setup() const { return setup_; }

    /// Conservative test: true only if the error provably cannot exceed the current maximum. Takes the largest length of each band,
    /// whichever control vector it comes from.
    bool cannotExceed(const LargestBounds& largest, const Squares& error, const ChannelSlack& slack) const;
    /// The same test for an upper bound of the error.
    static bool cannotExceed(const LargestBounds& largest, const ErrorBound& bound) {
        // Not ">": an error that is NaN must be refined.
        return static_cast<double>(bound.diffuse) <= kFloor * largest.diffuse.bound &&
               static_cast<double>(bound.specular) <= kFloor * largest.specular.bound;
    }
    /// Returns an upper bound of the shaded error of one channel, or of all, from the lengths of its bands.
    ErrorBound errorBound(const BandLengths& lengths, std::size_t channel) const;
    ErrorBound errorBound(const BandLengths& lengths) const;
    /// Returns the bound relative to the light of coefficient 0: an estimate of the local error, used only to order evaluations.
    ErrorBound relativeToLight(const ErrorBound& bound, float light) const;
    /// Raises the largest bounds to the exact bound of the pairs of one channel; to that of raiseByLengths if the budget is spent.
    void raise(LargestBounds& largest, std::span<const ErrorPair> pairs, const lighting::ShBands& slack, const PairPlaces& places) const;
    /// Raises the largest bounds to the band lengths of the errors, against no light. The place is that of the longest error, with a normal
    /// along its band 1.
    void raiseByLengths(LargestBounds& largest, std::span<const ErrorPair> pairs, const lighting::ShBands& slack,
                        const PairPlaces& places) const;
    /// Returns the work of an exact bound of so many control vectors.
    double workOf(std::size_t pairs) const { return static_cast<double>(pairs * (1 + setup_.responses.size())); }
    /// Returns the place of a bound in map coordinates, and its light in the units of the map.
    ErrorPlace placeOf(const BoundPlace& found, double bound, const PairPlaces& places) const;

private:
    const ShadingSetup& setup_;
    double unit_;
    std::array<float, 3> exitNorms_, glossyNorms_;  ///< rounded up
};

/// Factor of the current maximum below which a candidate must be proven to lie before its exact bound is skipped: of two equal bounds, the
/// tie rule of LargestBound::raise decides, not the rounding of a test. BoundEvaluator::cannotExceed() compares with the full maximum: it
/// may also skip a candidate that would tie with it.
inline constexpr double kTieFactor = 1 - 1e-9;

}  // namespace lightmap
}  // namespace lightcook::verify

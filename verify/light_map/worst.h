// The largest proven errors so far, and what may raise them. Private to verify/.
#pragma once

#include <span>
#include <vector>

#include "verify/figures.h"
#include "verify/light_map/bound.h"
#include "verify/light_map/shading.h"
#include "verify/light_map/vectors.h"
#include "verify/sampler_tolerance.h"

namespace lightcook::verify {

/// How a map is shaded and bounded, whatever its layout.
struct ShadingSetup {
    ShadingMatrix diffuse, specular;
    std::vector<Response> responses;      ///< area specular, for the bounds
    lighting::ShBands largestResponse{};  ///< their norms, each at its largest
    std::vector<FormatFreedom> freedom;   ///< of each layer; empty: an ideal sampler
    bool hasSpecular() const { return !responses.empty(); }
};

namespace lightmap {

/// Of one kind of shading.
struct WorstBound {
    double bound = 0;
    ErrorPlace place;
    /// Of bounds alike the one further up, then further left, so that the order of looking does not show.
    void raise(double by, const ErrorPlace& at);
};
/// What cannot exceed them by a cheap bound is not looked at more closely: the maximum stays exact.
struct Worst {
    WorstBound diffuse, specular;
};

/// The most that errors can be, from above; in units of the key.
struct Most {
    float diffuse = 0, specular = 0;
    void raise(const Most& other) {
        // What is not a number stays: no comparison with it is true.
        diffuse = other.diffuse <= diffuse ? diffuse : other.diffuse;
        specular = other.specular <= specular ? specular : other.specular;
    }
};

/// Where the pairs of a bound lie: of a texel alone at (x, y), of the control vectors of a square in rows of `nodes`, from (x, y) on.
struct PairPlaces {
    double x, y, size = 0;
    std::size_t nodes = 1;
    int channel = 0;
};

/// Decides what can be the worst, under all that a map is shaded with.
class BoundJudge {
public:
    /// perKey  light in units of the key
    BoundJudge(const ShadingSetup& setup, float perKey);
    const ShadingSetup& setup() const { return setup_; }

    /// A cheap yes, for most texels and quads: the largest norms of each band together, whichever controls they come from, are under the
    /// worst so far.
    bool isCertainlyWithin(const Worst& worst, const Squares& error, const ChannelSlack& slack) const;
    /// The same of the most that errors can be.
    static bool isCertainlyWithin(const Worst& worst, const Most& most) {
        // Not "greater": what is not a number has to be looked at.
        return static_cast<double>(most.diffuse) <= kFloor * worst.diffuse.bound &&
               static_cast<double>(most.specular) <= kFloor * worst.specular.bound;
    }
    Most mostOf(const BandLengths& lengths, std::size_t channel) const;
    Most mostOf(const BandLengths& lengths) const;
    /// As a part of about the light that there is, coefficient 0 being `light`: only for the order in which to look.
    Most besideLight(const Most& most, float light) const;
    /// Takes the pairs of one channel into the worst so far.
    void raise(Worst& worst, std::span<const ErrorPair> pairs, const lighting::ShBands& slack, const PairPlaces& places) const;
    /// The place of a bound, as a user is told of it.
    ErrorPlace placeOf(const BoundPlace& found, double bound, const PairPlaces& places) const;

private:
    const ShadingSetup& setup_;
    double unit_;
    std::array<float, 3> exitNorms_, glossyNorms_;  ///< rounded up
};

/// What is left out is clearly under the worst: which of two bounds alike is found first must not show in the last bit.
inline constexpr double kClearly = 1 - 1e-9;

}  // namespace lightmap
}  // namespace lightcook::verify

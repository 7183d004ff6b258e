// Error figures of every verified asset, and the accumulator that computes them. docs/theory/error.md defines the metrics.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lighting/radiometry.h"
#include "verify/visible.h"

namespace lightcook::verify {

/// The place and the values of a largest error: enough to find it again. Unknown while both x and mip are negative.
/// Cubemaps: `normal` is the direction. Reflection maps: x runs along the angle, y is the row, `normal` is the reflected direction about
/// +Z. Tables: shaded in the frame of their surface, where `normal` is +Z and view.z is NoV.
struct ErrorPlace {
    double x = -1, y = -1;           ///< [texels] integers are texel centres
    int mip = -1, face = -1;         ///< of a cubemap's texel; mip alone: a bound of the whole mip
    std::optional<int> channel = 0;  ///< red, green, blue; empty: all channels together
    glm::dvec3 normal{0};  ///< unit shading normal; of a specular bound the lobe's axis, as the bound covers all views and materials
    glm::dvec3 view{0};    ///< unit, to the viewer; specular samples only
    double m = 0, f0 = 0;  ///< specular samples only
    double reference = 0;  ///< light of the reference
    double found = 0;      ///< light of the cooked asset
    double local = 0;      ///< local relative error; for a bound, the bound itself, sampler tolerance included
    bool isKnown() const { return x >= 0 || mip >= 0; }
    /// Returns the largest |found - reference| whose local relative error is within `limit`.
    double allowed(double limit, double key) const {
        return limit * ((reference < 0 ? -reference : reference) + lighting::kLocalErrorFloor * key);
    }
};

/// Errors of shaded exit radiance of a white surface against the float reference, as fractions.
struct ErrorFigures {
    double relRms = 0;      ///< RMS of the error over RMS of the reference, over texels, directions and channels
    double p99 = 0;         ///< 99th percentile of the local relative error |error| / (|reference| + 0.02 key)
    double maxSampled = 0;  ///< largest local relative error of the samples
    /// Proven upper bound of the local relative error for every normal, view, material and position; empty: none is known.
    std::optional<double> maxBound = 0;
    /// Places of maxSampled and maxBound, for assets that record them. Ties go to the first row, column, channel and direction.
    ErrorPlace sampledAt, boundAt;
    std::optional<VisibleFigures> visible;  ///< of the same light on a display; empty where none was asked for
};

/// Raises maxSampled, maxBound and the visible errors of `figures` to those of `other`, with their places: for a stage that summarizes
/// others.
void takeLarger(ErrorFigures& figures, const ErrorFigures& other);
/// Raises maxSampled, maxBound and the largest visible error of `figures` to those of `other`, with their places: for figures of the same
/// asset at other places.
void takeLargerMaxima(ErrorFigures& figures, const ErrorFigures& other);

/// Errors at the texel centres, beside those on the surface.
struct CentreFigures {
    ErrorFigures diffuse, specular;
};

/// Errors of one compression stage of an asset. Errors are 0 for a kind of shading that the asset does not affect.
struct StageError {
    std::string name;
    ErrorFigures diffuse, specular;
    double seconds = 0;
    std::optional<CentreFigures> atTexels = std::nullopt;  ///< where diffuse and specular are those of the surface
};

/// Accumulates one kind of error. Merge strips in a fixed order for reproducible bits.
/// The 99th percentile comes from a histogram of 256 equal bins an octave (0.2 to 0.4 % wide) with exact counts. The figure is the upper
/// edge of its bin, at most maxSampled. Results that are not finite count as the largest double, so that they pass no limit.
class ErrorAccumulator {
public:
    explicit ErrorAccumulator(double key = 0);
    /// weight  of the squares in relRms; 1 in the mean over all samples
    void add(double reference, double result, double weight = 1);
    /// Adds an error with its place. placeOf() is called only if the error is the largest so far.
    template <class PlaceOf>
    void add(double reference, double result, const PlaceOf& placeOf, double weight = 1) {
        const double before = maxSampled_;
        add(reference, result, weight);
        if (!(maxSampled_ > before)) return;
        sampledAt_ = placeOf();
        sampledAt_.reference = reference;
        sampledAt_.found = result;
        sampledAt_.local = maxSampled_;
    }
    /// Adds a batch of float samples, given as reference and error = result - reference of the same length: the inner loop of light maps.
    void addErrors(std::span<const float> reference, std::span<const float> error);
    static constexpr std::size_t kLanes = 16;
    /// Adds the first `count` samples. Both spans are padded with zeros up to a multiple of kLanes.
    void addPaddedErrors(std::span<const float> reference, std::span<const float> error, std::size_t count);
    /// Adds `count` samples of no light, without an error.
    void addDark(std::size_t count);
    /// Raises maxBound to a proven bound of local relative errors.
    void addBound(double bound, const ErrorPlace& place = {});
    /// Sets the place of the largest sample, after an add that raised maxSampled().
    void setSampledAt(const ErrorPlace& place) { sampledAt_ = place; }
    void merge(const ErrorAccumulator& other);
    ErrorFigures figures() const;
    std::int64_t sampleCount() const { return sampleCount_; }
    double maxSampled() const { return maxSampled_; }
    /// Returns the RMS of the references, the denominator of relRms; 0 without samples.
    double referenceRms() const;

    /// Lists the members, in terms of formats/archive.h.
    template <class Archive, class Self>
    static void members(Archive& archive, Self& self) {
        archive(self.key_, self.squaredError_, self.squaredReference_, self.maxSampled_, self.maxBound_, self.sampledAt_, self.boundAt_,
                self.sampleCount_);
        archive.sparse(self.histogram_);
    }

private:
    static constexpr int kBinsPerOctave = 256;
    static constexpr int kLowestExponent = -40, kHighestExponent = 24;
    static constexpr int kBinCount =
        (kHighestExponent - kLowestExponent) * kBinsPerOctave + 2;  ///< and one bin each for smaller and larger values
    static std::size_t binOf(double local);
    static std::int32_t floatBinOf(float local);
    void addPiece(const float* reference, const float* error, std::size_t count);

    double key_;
    double squaredError_ = 0, squaredReference_ = 0, maxSampled_ = 0, maxBound_ = 0;
    ErrorPlace sampledAt_, boundAt_;
    std::int64_t sampleCount_ = 0;
    std::vector<std::int64_t> histogram_;
};

}  // namespace lightcook::verify

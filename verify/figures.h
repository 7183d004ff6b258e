// The figures in which every error is told (product.md, "The error that counts"), and how they are gathered.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "lighting/radiometry.h"

namespace lightcook::verify {

/// Where the worst of some errors is, and what it is: enough to find it again. Not known: neither x nor mip.
/// Cubemaps have the direction as `normal`. Reflection maps (x along the angle, y the row) have the reflected direction, about +Z, as
/// `normal`. Tables are shaded in the frame of their surface: `normal` is +Z, view.z is NoV.
struct ErrorPlace {
    double x = -1, y = -1;    ///< [texels] whole at the centre of a texel; fractions lie between texels
    int mip = -1, face = -1;  ///< of a cubemap's texel; a mip alone where its bound holds for all of it
    int channel = 0;          ///< red, green, blue; -1 where there are none
    glm::dvec3 normal{0};     ///< of the shading, unit; of a specular bound the axis of the lobe, as it holds for all views and materials
    glm::dvec3 view{0};       ///< to the viewer, unit; of specular samples only
    double m = 0, f0 = 0;     ///< of specular samples only
    double reference = 0;     ///< the light that ought to be there
    double found = 0;         ///< the light that is
    double local = 0;         ///< the local relative error; of a bound what is proven, with all that a sampler is free to do
    bool isKnown() const { return x >= 0 || mip >= 0; }
    /// How far `found` may be from `reference` for a local relative error of `limit`.
    double allowed(double limit, double key) const {
        return limit * ((reference < 0 ? -reference : reference) + lighting::kLocalErrorFloor * key);
    }
};

/// Errors of shaded exit radiance on a white surface against the float reference. All are fractions, not percent.
struct ErrorFigures {
    double relRms = 0;      ///< RMS of the error over RMS of the reference, over texels, directions and channels
    double p99 = 0;         ///< 99th percentile of the local relative error |error| / (|reference| + 0.02 key)
    double maxSampled = 0;  ///< largest local relative error that a sample met
    double maxBound = 0;    ///< no normal, view, material or sub-texel position can exceed this local relative error
    /// Of maxSampled and maxBound, where the asset tells of it; the first of those alike, by row, column, channel, direction.
    ErrorPlace sampledAt, boundAt;
};

/// Takes over the larger of the worst samples, and of the bounds, with their places: of a stage that stands for others too.
void takeLarger(ErrorFigures& figures, const ErrorFigures& other);

/// One stage of one asset. A kind of shading that the asset takes no part in has error 0.
struct StageError {
    std::string name;
    ErrorFigures diffuse, specular;
    double seconds = 0;
};

/// Gathers one kind of error. Order of adding matters only within one accumulator: merge bands in a fixed order for the same bits.
/// The 99th percentile comes from a histogram of 256 equal bins an octave (0.2 to 0.4 % wide) with exact counts; the figure is its bin's
/// upper edge, never above maxSampled. Results that are not finite count as the largest double, so that they can pass no limit.
class ErrorAccumulator {
public:
    explicit ErrorAccumulator(double key = 0);
    void add(double reference, double result);
    /// The same where placeOf() tells of the place of this sample: asked for if it is the worst so far.
    template <class PlaceOf>
    void add(double reference, double result, const PlaceOf& placeOf) {
        const double before = maxSampled_;
        add(reference, result);
        if (!(maxSampled_ > before)) return;
        sampledAt_ = placeOf();
        sampledAt_.reference = reference;
        sampledAt_.found = result;
        sampledAt_.local = maxSampled_;
    }
    /// A batch of float samples given as reference and error = result - reference: the inner loop of light maps. Same lengths.
    void addErrors(std::span<const float> reference, std::span<const float> error);
    /// The same of the first `count`, in place: up to the next multiple of kLanes both hold zeros.
    static constexpr std::size_t kLanes = 16;
    void addPaddedErrors(std::span<const float> reference, std::span<const float> error, std::size_t count);
    /// A proven bound on local relative errors, for maxBound only.
    void addBound(double bound, const ErrorPlace& place = {});
    /// Where the largest sample so far was met; for what has just been added.
    void setSampledAt(const ErrorPlace& place) { sampledAt_ = place; }
    void merge(const ErrorAccumulator& other);
    ErrorFigures figures() const;
    std::int64_t sampleCount() const { return sampleCount_; }
    double maxSampled() const { return maxSampled_; }
    /// RMS of the references: the light that relRms is a part of. 0 without samples.
    double referenceRms() const;

private:
    static constexpr int kBinsPerOctave = 256;
    static constexpr int kLowestExponent = -40, kHighestExponent = 24;
    static constexpr int kBinCount =
        (kHighestExponent - kLowestExponent) * kBinsPerOctave + 2;  ///< with one for smaller and one for larger
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

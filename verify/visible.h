// Visible error: the difference between an asset's light and its reference's as a display shows both, in units of a just noticeable
// difference (Delta E ITP, ITU-R BT.2124; docs/theory/visible.md).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "lighting/display.h"

namespace lightcook::verify {

/// A triangle of a mesh: its primitive, and its index there. Both count from 0 in the order of the file.
struct MeshTriangle {
    std::int64_t primitive, index;
    bool operator==(const MeshTriangle&) const = default;
};

/// The place and the two colours of a largest visible error. Unknown while x is negative.
struct VisiblePlace {
    double x = -1, y = -1;                      ///< [texels] integers are texel centres
    int mip = -1, face = -1;                    ///< of a cubemap
    std::optional<MeshTriangle> triangle = {};  ///< of a mesh
    glm::dvec3 normal{0};                       ///< unit shading normal, or the reflected direction of cubemaps and reflection maps
    glm::dvec3 view{0};                         ///< unit, to the viewer; specular light only
    double m = 0, f0 = 0;                       ///< specular light only
    glm::dvec3 reference{0};                    ///< light of the reference
    glm::dvec3 found{0};                        ///< light of the cooked asset
    double difference = 0;                      ///< Delta E ITP
    bool isKnown() const { return x >= 0; }
};

/// Visible errors of shaded light: Delta E ITP.
struct VisibleFigures {
    double rms = 0, p50 = 0, p95 = 0, p99 = 0, p999 = 0;
    double max = 0;  ///< of the samples
    VisiblePlace maxAt;
    /// Numbers of samples: below 2^kLowestOctave, in each octave from there on, and from 2^kHighestOctave up. Empty without samples.
    std::vector<std::int64_t> histogram;
    static constexpr int kLowestOctave = -3, kHighestOctave = 9;
    /// Proven upper bound for every place, normal or view, and allowed sampler (docs/theory/bounds.md). Empty: none was
    /// computed.
    std::optional<double> bound;
    /// Place of the bound; its difference is the bound, and its light that of an ideal sampler there.
    VisiblePlace boundAt;
};

/// Raises each figure to that of `other`, and the place with the largest.
void takeLarger(VisibleFigures& figures, const VisibleFigures& other);

/// A display, and the matrix to its primaries: linear BT.2020 from the working ones.
struct Viewing {
    lighting::Display display;
    glm::dmat3 bt2020FromWorking = lighting::bt2020FromRec709();
};

/// Converts light to I, T and P of BT.2124, scaled so that a distance of 1 is a just noticeable difference. Float arithmetic in lanes:
/// differences are within 0.003 of lighting::visibleDifference plus 0.01 %, for every finite light. (With primaries
/// that lower L, M or S, up to 1e33 cd/m^2: infinities would cancel. The curve's 2e-7 in each code of both
/// lights are up to 0.0027.) L, M and S below 2^-8 cd/m^2 count as that. A display's black is above it, so that only light of primaries
/// beyond those of the display is there.
class DisplayTransform {
public:
    static constexpr std::size_t kLanes = 16;

    /// unit  light of the scene for each unit of the samples
    DisplayTransform(const Viewing& viewing, double unit);
    /// Converts `count` samples, a multiple of kLanes. Light that is not finite becomes NaN.
    /// rgb, itp  three planes of `count` values
    void apply(const float* rgb, std::size_t count, float* itp) const;

private:
    std::array<std::array<float, 3>, 3> lms_;  ///< [row][channel]: LMS [cd/m^2] for each unit of a sample
    float black_;
};

/// Writes the differences of `count` converted samples, a multiple of kLanes: the largest float where one is not finite.
/// reference, found  three planes of `count` values, of DisplayTransform
void visibleDifferences(const float* reference, const float* found, std::size_t count, float* differences);

/// Returns the key that a display is exposed for: the log-average of max(Y, mean(Y) / 1024) over luminances Y of the exit radiance of white
/// surfaces, so that black ones do not brighten the picture without limit. 0 where the mean is below kBlackMean.
double displayKeyOf(std::span<const double> luminances);
inline constexpr double kDarkestShare = 1.0 / 1024, kBlackMean = 1e-9;

/// Accumulates visible errors. Percentiles come from a histogram of 256 bins an octave (0.2 to 0.4 % wide) with exact counts.
class VisibleAccumulator {
public:
    VisibleAccumulator();
    void add(std::span<const float> differences);
    /// Adds `count` differences of 0.
    void addExact(std::size_t count);
    /// Sets the place of the largest difference, after an add that raised largest().
    void setMaxAt(const VisiblePlace& place) { maxAt_ = place; }
    /// Merge strips in a fixed order for reproducible bits.
    void merge(const VisibleAccumulator& other);
    /// Raises the proven bound, which is unknown before the first one.
    void addBound(double bound, const VisiblePlace& place);
    double largest() const { return largest_; }
    /// Returns the place of the largest difference.
    const VisiblePlace& maxAt() const { return maxAt_; }
    std::int64_t sampleCount() const { return sampleCount_; }
    VisibleFigures figures() const;

    /// Lists the members, in terms of formats/archive.h.
    template <class Archive, class Self>
    static void members(Archive& archive, Self& self) {
        archive(self.squares_, self.largest_, self.bound_, self.maxAt_, self.boundAt_, self.sampleCount_);
        archive.sparse(self.histogram_);
    }

private:
    static constexpr int kBinsPerOctave = 256;
    static constexpr int kLowestExponent = -12, kHighestExponent = 10;
    static constexpr int kBinCount = (kHighestExponent - kLowestExponent) * kBinsPerOctave + 2;  ///< and one each below and above
    static std::size_t binOf(float difference);
    /// Returns VisibleFigures::histogram.
    std::vector<std::int64_t> octaves() const;
    /// Returns the value that a share of the samples does not exceed.
    double quantile(double share) const;

    double squares_ = 0, largest_ = 0;
    std::optional<double> bound_;  ///< empty: none was added
    VisiblePlace maxAt_, boundAt_;
    std::int64_t sampleCount_ = 0;
    std::vector<std::int64_t> histogram_;
};

/// Measures pairs of colours, one after the other, and keeps the place of the largest difference. Every asset whose samples do not come in
/// planes is measured by it. Ties go to the first pair.
class VisiblePairs {
public:
    explicit VisiblePairs(const Viewing& viewing) : transform_(viewing, 1) {}
    /// Adds a pair of lights. A place without colours is enough.
    void add(const glm::dvec3& reference, const glm::dvec3& found, const VisiblePlace& place);
    /// Raises the proven bound, which is unknown before the first one; its place has the colours there.
    void addBound(double bound, VisiblePlace place);
    /// Merge strips in a fixed order for reproducible bits. Pairs are measured on the same display.
    void merge(const VisiblePairs& other);
    /// Returns nothing without pairs.
    std::optional<VisibleFigures> figures() const;

private:
    static constexpr std::size_t kLanes = DisplayTransform::kLanes;
    using Planes = std::array<float, 3 * kLanes>;
    /// Measures the pairs that wait for a full batch.
    void flush();

    DisplayTransform transform_;
    VisibleAccumulator errors_;
    std::array<VisiblePlace, kLanes> waiting_;  ///< with their colours
    std::size_t count_ = 0;
};

}  // namespace lightcook::verify

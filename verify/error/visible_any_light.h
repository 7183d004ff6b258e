// Upper bound of the visible error (Delta E ITP) of an error of light, whatever the light is. Private to verify/.
//
// Light goes from x to y, both above a grey light, channel by channel: y - x is a sum of steps of single channels, each at some light z
// above the grey. I is the mean of concave, rising codes, so that it changes most at the grey light itself, by all steps up or by all steps
// down. T and P are sums w_L L' + w_M M' + w_S S', and a step of channel c changes them by sum_k w_k D_k(Z_k),
//   D_k(Z) = PQ(grey + Z + step m_kc) - PQ(grey + Z),
// which falls with Z_k, the luminance of z above the grey light. For any Z_L and Z_M the change is largest where Z_S is as small or as
// large as it can be: where z has no more than two channels. Tables of the extrema over all z of two channels are made once, from places so
// close that what lies between them is within a margin.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "verify/error/visible_metric.h"

namespace lightcook::verify {

class AnyLightBound {
public:
    explicit AnyLightBound(const VisibleMetric& metric);
    /// Returns an upper bound of the difference of two lights whose channels are at least `low`, and at least 0, where each channel of
    /// their difference is between 0 and a number in `error`; at most the largest difference of the display.
    double bound(double low, const Intervals& error) const;

private:
    /// Steps are the floats with three bits of mantissa, as shares of black: eight an octave.
    static constexpr int kMantissa = 20;
    static constexpr std::uint32_t kFinest = std::bit_cast<std::uint32_t>(0x1p-6f) >> kMantissa,
                                   kCoarsest = std::bit_cast<std::uint32_t>(0x1p14f) >> kMantissa;
    static constexpr std::size_t kLevels = 9;  ///< of grey light: powers of two times black
    /// Changes of T and P by a step of one channel.
    using Changes = std::array<Interval, 2>;
    struct Places;
    void addChanges(double black, const Places& places, std::size_t channel, std::vector<Changes>& out) const;

    VisibleMetric metric_;
    std::array<float, 3> shares_{};                             ///< of black, for each unit of a channel
    std::vector<std::array<std::vector<Changes>, 3>> changes_;  ///< [level][channel][step]
};

}  // namespace lightcook::verify

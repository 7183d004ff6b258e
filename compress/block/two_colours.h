// Blocks of two colours, the part that BC6H and BC7 share: the best integer ends for texels of two colours whose indices are chosen.
//
// Both formats interpolate v = (a (64 - share) + b share + 32) >> 6, share the interpolation weight of the index. Once the indices are
// chosen, channels are independent, and each channel is a search over two integers. It is pruned by intervals: a bound of the error limits
// the interpolated value of each load to a range, and these ranges limit the two ends. Scalar code: every instruction set gives the same
// bytes.
//
// Words: an end is an endpoint; a code is its stored integer, and its value the integer that is interpolated; a load is the set of the
// texels of one colour that have the same index.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "compress/block/block.h"

namespace lightcook::compress {

/// A colour with at most this share of its weight in a region is left out of the region's bound.
inline constexpr double kFloorShare = 1.0 / 32;
inline constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// The two colours of a block.
struct TwoColours {
    std::array<std::array<float, 4>, 2> colour{};
    std::array<std::uint32_t, 2> texels{};  ///< bit t is set if texel t is significant and has this colour
};
/// Returns true if the significant texels of a block have exactly two colours.
bool hasTwoColours(const Block& block, std::size_t channelCount, TwoColours& two);

/// The values of the codes of an end, rising from code 0.
class EndValues {
public:
    /// firstUsable  codes below it are never chosen
    explicit EndValues(std::vector<int> values, int firstUsable = 0);
    int count() const { return static_cast<int>(values_.size()); }
    int firstUsable() const { return firstUsable_; }
    int operator[](int code) const { return values_[static_cast<std::size_t>(code)]; }
    int firstAtLeast(int value) const;  ///< returns count() if there is none
    int lastAtMost(int value) const;    ///< returns firstUsable() - 1 if there is none

private:
    std::vector<int> values_;
    int firstUsable_;
    double codesPerValue_;
};

/// The error of one channel: weight (metric[v] - target)^2 for each of the two colours.
struct ChannelError {
    const double* metric = nullptr;  ///< of v in lowest .. highest, rising
    int lowest = 0, highest = 0;
    std::array<double, 2> weight{}, target{};
    std::array<double, 2> least{};  ///< smallest error over all v
    std::array<int, 2> nearest{};   ///< the v of the smallest error

    double at(int colour, int value) const {
        const auto i = static_cast<std::size_t>(colour);
        const double miss = metric[value] - target[i];
        return weight[i] * miss * miss;
    }
    void findLeast();  ///< sets least and nearest
};

/// The texels of one colour that have the same index.
struct Load {
    int colour;     ///< 0 or 1
    double weight;  ///< total significance of its texels
};

/// An interval of codes on a circle: the code after the last one is the first.
struct Arc {
    int from, count;
};
/// The allowed codes of a pair of ends: the first in an arc; the second in another arc, absolute or relative to the first end.
struct Window {
    Arc first, second;
    bool secondFollowsFirst = false;  ///< second.from is relative to the first end
};

/// Codes of both ends of one channel, and the error with them.
struct Ends {
    int first = 0, second = 0;
    double error = 0;
};

/// Returns the value between two ends, as the decoders of BC6H and BC7 compute it.
inline int interpolated(int a, int b, int share) {
    return (a * (64 - share) + b * share + 32) >> 6;
}

/// Searches for the ends of a region with given loads.
class RegionSearch {
public:
    RegionSearch(std::span<const ChannelError> channels, std::vector<Load> loads);

    const std::vector<Load>& loads() const { return loads_; }
    double least() const { return least_; }  ///< lower bound of the error with any ends
    double least(std::size_t channel) const { return leastOf_[channel]; }

    /// Restricts the following calls to ends with an error below the bound.
    void limit(double bound);
    /// Finds the best ends of each channel for loads with these interpolation weights. Returns the error, or infinity if it is not below
    /// the bound.
    double place(const int* shares, const EndValues& first, const EndValues& second, std::span<const Window> windows, double bound,
                 Ends* ends) const;
    /// Returns the best ends of one channel; their error is infinite if it is not below the bound.
    Ends best(std::size_t channel, const int* shares, const EndValues& first, const EndValues& second, const Window& window,
              double bound) const;
    /// Returns false if no ends with second - first in spread +- tolerance (values) can have an error below the bound.
    bool allowsSpread(std::size_t channel, const int* shares, int spread, int tolerance) const {
        return allowsSpread(range_[channel], shares, spread, tolerance);
    }
    /// Returns the best second end for each first end, where the error is below the bound, sorted by error.
    std::vector<Ends> bestOfEachFirst(std::size_t channel, const int* shares, const EndValues& values, const Window& window,
                                      double bound) const;

    /// Returns the lower convex hull of the points (error of load 0, error of load 1), for unit weights, over all ends within the bound:
    /// the possible trade-offs between the two loads. Corners rise in the first and fall in the second error.
    std::vector<std::array<double, 2>> tradeOffs(std::size_t channel, const int* shares, const EndValues& first, const EndValues& second,
                                                 const Window& window) const;

private:
    struct Range {
        int low, high;
    };
    using Ranges = std::array<Range, 3>;
    /// A pair of ends to be found in one channel.
    struct Task {
        std::size_t channel;
        const int* shares;
        const EndValues &first, &second;
        const Window& window;
        Ranges ranges;  ///< interpolated values that each load may have
    };
    bool allowsSpread(const Ranges& range, const int* shares, int spread, int tolerance) const;
    Range firstEnds(const Task& task) const;
    std::array<Range, 3> firstRuns(const Task& task) const;
    Range secondEnds(const Task& task, int firstValue) const;
    Range within(const ChannelError& channel, const Load& load, double budget) const;
    Ranges rangesBelow(std::size_t channel, double bound) const;
    double errorOf(const Task& task, int code, int other) const;
    void probe(const Task& task, Range codes, double& bound, Ends& found) const;
    template <class Visit>
    void eachFirst(const Task& task, const std::array<Range, 3>& runs, Visit&& visit) const;
    template <class Visit>
    void eachSecond(const Task& task, int code, Visit&& visit) const;

    std::span<const ChannelError> channels_;
    std::vector<Load> loads_;
    std::array<double, 4> leastOf_{};
    double least_ = 0, bound_ = std::numeric_limits<double>::quiet_NaN();
    std::array<Ranges, 4> range_{};                 ///< interpolated values that the bound allows in each channel
    std::array<std::size_t, 4> order_{0, 1, 2, 3};  ///< channels, those with the fewest allowed values first
};

/// Lower bounds of the error of a region for any weights of its colours: the least error that the precision and the windows of its ends
/// allow, if there were no other region. Computed once for each mode, from the trade-offs of each pair of indices.
class RegionBounds {
public:
    /// floor  a colour with a smaller weight is treated as absent
    /// bound  errors above it need not be distinguished
    RegionBounds(std::span<const ChannelError> channels, int indexBits, const EndValues& first, const EndValues& second,
                 std::span<const Window> windows, const std::array<double, 2>& floor, double bound);
    /// Returns a lower bound of the error, or some value above the constructor's bound.
    double least(const std::array<double, 2>& weight) const;
    /// Returns a lower bound of the error of colours with these indices.
    double least(int firstIndex, int secondIndex, const std::array<double, 2>& weight) const;

private:
    using TradeOffs = std::vector<std::array<double, 2>>;
    int count_;  ///< number of indices
    std::array<double, 2> floor_;
    std::array<double, 2> alone_{};  ///< error of each colour on its own, for unit weight
    /// For each pair of indices, the first in the lower half, and each channel. Empty if no ends are below the bound.
    std::vector<std::vector<TradeOffs>> tradeOffs_;
};

/// Relative differences of errors below this are ties: searches stop when they cannot gain more.
inline constexpr double kTieMargin = 1e-9;

}  // namespace lightcook::compress

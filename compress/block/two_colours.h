// Blocks of two colours, the part that BC6H and BC7 share: the best whole ends for texels that have two colours and chosen places between
// these ends. Both formats interpolate v = (a (64 - share) + b share + 32) >> 6, so once the places are chosen channels have nothing to do
// with one another, and every channel is a search over two whole numbers. Plain code: the same bytes from every instruction set.
//
// Words: a code is what is stored of an end; its value is what the interpolator sees; a load is texels of one colour at one place.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "compress/block/block.h"

namespace lightcook::compress {

/// The colours of a block that has two where it counts.
struct TwoColours {
    std::array<std::array<float, 4>, 2> colour{};
    std::array<std::uint32_t, 2> texels{};  ///< bit t is set where texel t counts and has this colour
};
bool hasTwoColours(const Block& block, std::size_t channelCount, TwoColours& two);

/// What the codes of an end stand for, rising from code 0 on.
class EndValues {
public:
    /// firstUsable: codes below are never chosen
    explicit EndValues(std::vector<int> values, int firstUsable = 0);
    int count() const { return static_cast<int>(values_.size()); }
    int firstUsable() const { return firstUsable_; }
    int operator[](int code) const { return values_[static_cast<std::size_t>(code)]; }
    int firstAtLeast(int value) const;  ///< count() where there is none
    int lastAtMost(int value) const;    ///< firstUsable() - 1 where there is none

private:
    std::vector<int> values_;
    int firstUsable_;
    double codesPerValue_;
};

/// The error of one channel: weight (metric[v] - target)^2 for each of the two colours.
struct ChannelError {
    const double* metric = nullptr;  ///< of v, lowest .. highest, rising
    int lowest = 0, highest = 0;
    std::array<double, 2> weight{}, target{}, least{};  ///< least: the smallest error over all v
    std::array<int, 2> nearest{};                       ///< the v that has it

    double at(int colour, int value) const {
        const auto i = static_cast<std::size_t>(colour);
        const double miss = metric[value] - target[i];
        return weight[i] * miss * miss;
    }
    void findLeast();  ///< from the rest
};

struct Load {
    int colour;     ///< 0 or 1
    double weight;  ///< of all its texels
};

/// Codes from, from + 1 .. on a circle, where the one after the last is the first.
struct Arc {
    int from, count;
};
/// Where ends may lie: the first on an arc, the second on another or that far from the first.
struct Window {
    Arc first, second;
    bool secondFollowsFirst = false;  ///< second.from is counted from the first end
};

struct Ends {
    int first = 0, second = 0;
    double error = 0;
};

inline int interpolated(int a, int b, int share) {
    return (a * (64 - share) + b * share + 32) >> 6;
}

/// The loads that share a pair of ends.
class RegionSearch {
public:
    RegionSearch(std::span<const ChannelError> channels, std::vector<Load> loads);

    const std::vector<Load>& loads() const { return loads_; }
    double least() const { return least_; }  ///< no ends at all have a smaller error
    double least(std::size_t channel) const { return leastOf_[channel]; }

    /// From here on only ends matter whose error is below the bound.
    void limit(double bound);
    /// The best ends of each channel for loads at these shares of the way; returns the error, or infinity if it is not below the bound.
    double place(const int* shares, const EndValues& first, const EndValues& second, std::span<const Window> windows, double bound,
                 Ends* ends) const;
    /// The best ends of one channel; the error is infinite if none is below the bound.
    Ends best(std::size_t channel, const int* shares, const EndValues& first, const EndValues& second, const Window& window,
              double bound) const;
    /// False where no ends are below the bound whose values, second less first, are about that far apart.
    bool allowsSpread(std::size_t channel, const int* shares, int spread, int tolerance) const {
        return allowsSpread(range_[channel], shares, spread, tolerance);
    }
    /// For each first end the best second one, where that is below the bound; rising errors.
    std::vector<Ends> bestOfEachFirst(std::size_t channel, const int* shares, const EndValues& values, const Window& window,
                                      double bound) const;

    /// What the two loads can trade of one another's error, for a weight of one, within the bound: corners of the lower hull, falling in
    /// the second as they rise in the first.
    std::vector<std::array<double, 2>> trades(std::size_t channel, const int* shares, const EndValues& first, const EndValues& second,
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
        Ranges ranges;  ///< interpolated values that each load may take
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
    std::array<Ranges, 4> range_{};                 ///< what the bound allows in each channel
    std::array<std::size_t, 4> order_{0, 1, 2, 3};  ///< channels, those that allow the least first
};

/// The least error of a region whatever its colours weigh: what its ends' precision and reach allow, as if there were no other region.
class RegionBounds {
public:
    /// Colours that weigh less than the floor are taken to weigh nothing; errors above the bound need not be told apart.
    RegionBounds(std::span<const ChannelError> channels, int indexBits, const EndValues& first, const EndValues& second,
                 std::span<const Window> windows, const std::array<double, 2>& floor, double bound);
    /// No ends have a smaller error, or none below the bound that was given.
    double least(const std::array<double, 2>& weight) const;
    /// The same with the colours at these indices.
    double least(int firstIndex, int secondIndex, const std::array<double, 2>& weight) const;

private:
    using Trades = std::vector<std::array<double, 2>>;
    int count_;                              ///< of indices
    std::array<double, 2> floor_, alone_{};  ///< alone: error for a weight of one of each colour on its own
    std::vector<std::vector<Trades>>
        trades_;  ///< for each pair of indices, the first in the lower half, of each channel: none if it cannot be
};

/// What is taken for no improvement, as a share of the error: searches end where less is to be had.
constexpr double kTwoColoursHair = 1e-9;

}  // namespace lightcook::compress

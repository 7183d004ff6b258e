#include "compress/block/two_colours.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "compress/block/partitions.h"

namespace lightcook::compress {
namespace {

int floorDiv(int a, int b) {
    const int quotient = a / b;
    return quotient * b > a ? quotient - 1 : quotient;
}
int ceilDiv(int a, int b) {
    return -floorDiv(-a, b);
}

/// Calls visit(code) for the codes in low .. high that are on the arc of a circle of count codes, until it returns false.
template <class Visit>
bool eachOn(const Arc& arc, int count, int low, int high, Visit&& visit) {
    int from = arc.from, end = arc.from + arc.count;
    if (arc.count >= count) {
        from = 0;
        end = count;
    } else if (from < 0) {
        from += count;
        end += count;
    } else if (from >= count) {
        from -= count;
        end -= count;
    }
    for (int code = std::max(low, from); code <= std::min(high, std::min(end, count) - 1); ++code)
        if (!visit(code)) return false;
    for (int code = low; code <= std::min(high, end - count - 1); ++code)
        if (!visit(code)) return false;
    return true;
}

}  // namespace

bool hasTwoColours(const Block& block, std::size_t channelCount, TwoColours& two) {
    std::size_t count = 0;
    for (std::size_t t = 0; t < kTexelCount; ++t) {
        if (!(block.significance[t] > 0)) continue;
        std::array<float, 4> colour{};
        for (std::size_t c = 0; c < channelCount; ++c) colour[c] = block.channel[c][t];
        std::size_t i = 0;
        while (i < count && two.colour[i] != colour) ++i;
        if (i == 2) return false;
        if (i == count) two.colour[count++] = colour;
        two.texels[i] |= 1u << t;
    }
    return count == 2;
}

EndValues::EndValues(std::vector<int> values, int firstUsable)
    : values_(std::move(values)),
      firstUsable_(firstUsable),
      codesPerValue_(static_cast<double>(values_.size() - 1) / (values_.back() - values_.front())) {}

int EndValues::firstAtLeast(int value) const {
    const int last = count() - 1;
    if (value > values_.back()) return count();
    if (value <= values_.front()) return firstUsable_;
    // Values are nearly equidistant: a linear guess is off by a code or two.
    int code = std::clamp(static_cast<int>((value - values_.front()) * codesPerValue_), 0, last);
    while ((*this)[code] < value) ++code;
    while (code > 0 && (*this)[code - 1] >= value) --code;
    return std::max(code, firstUsable_);
}
int EndValues::lastAtMost(int value) const {
    return value >= values_.back() ? count() - 1 : firstAtLeast(value + 1) - 1;
}

void ChannelError::findLeast() {
    for (int colour = 0; colour < 2; ++colour) {
        const auto i = static_cast<std::size_t>(colour);
        const double* above = std::lower_bound(metric + lowest, metric + highest, target[i]);
        const int value = static_cast<int>(above - metric), under = std::max(value - 1, lowest);
        nearest[i] = at(colour, under) < at(colour, value) ? under : value;
        least[i] = at(colour, nearest[i]);
    }
}

RegionSearch::RegionSearch(std::span<const ChannelError> channels, std::vector<Load> loads)
    : channels_(channels), loads_(std::move(loads)) {
    for (std::size_t c = 0; c < channels_.size(); ++c) {
        for (const Load& load : loads_) leastOf_[c] += load.weight * channels_[c].least[static_cast<std::size_t>(load.colour)];
        least_ += leastOf_[c];
    }
}

/// Returns the interpolated values with which the error of a load does not exceed the budget.
RegionSearch::Range RegionSearch::within(const ChannelError& channel, const Load& load, double budget) const {
    const auto i = static_cast<std::size_t>(load.colour);
    const double weight = load.weight * channel.weight[i];
    if (!(weight > 0) || budget == kInfinite) return {channel.lowest, channel.highest};
    const double reach = std::sqrt(std::max(budget, 0.0) / weight) * (1 + 1e-12);
    const double *begin = channel.metric + channel.lowest, *end = channel.metric + channel.highest + 1;
    const double* low = std::lower_bound(begin, end, channel.target[i] - reach);
    const double* high = std::upper_bound(low, end, channel.target[i] + reach);
    return {static_cast<int>(low - channel.metric), static_cast<int>(high - channel.metric) - 1};
}

/// Returns the interpolated values of each load with which the error of a channel can be below the bound.
RegionSearch::Ranges RegionSearch::rangesBelow(std::size_t channel, double bound) const {
    Ranges ranges{};
    for (std::size_t g = 0; g < loads_.size(); ++g) {
        const double own = loads_[g].weight * channels_[channel].least[static_cast<std::size_t>(loads_[g].colour)];
        ranges[g] = within(channels_[channel], loads_[g], bound - (leastOf_[channel] - own));
    }
    return ranges;
}

void RegionSearch::limit(double bound) {
    if (bound == bound_) return;
    bound_ = bound;
    std::array<double, 4> room{};
    for (std::size_t c = 0; c < channels_.size(); ++c) {
        range_[c] = rangesBelow(c, bound - (least_ - leastOf_[c]));
        room[c] = 1;
        for (std::size_t g = 0; g < loads_.size(); ++g) room[c] *= range_[c][g].high - range_[c][g].low + 1;
    }
    std::stable_sort(order_.begin(), order_.begin() + static_cast<std::ptrdiff_t>(channels_.size()),
                     [&](std::size_t a, std::size_t b) { return room[a] < room[b]; });
}

/// Returns the codes of the first end for which each load, and each pair of loads, has a second end that brings it within its range.
RegionSearch::Range RegionSearch::firstEnds(const Task& task) const {
    const EndValues &first = task.first, &second = task.second;
    int low = first[first.firstUsable()], high = first[first.count() - 1];
    const int secondLow = second[second.firstUsable()], secondHigh = second[second.count() - 1];
    const auto blendLow = [&](std::size_t g) { return 64 * task.ranges[g].low - 32; };
    const auto blendHigh = [&](std::size_t g) { return 64 * task.ranges[g].high + 31; };
    for (std::size_t g = 0; g < loads_.size(); ++g) {
        const int s = task.shares[g];
        if (s < 64) {
            low = std::max(low, ceilDiv(blendLow(g) - s * secondHigh, 64 - s));
            high = std::min(high, floorDiv(blendHigh(g) - s * secondLow, 64 - s));
        }
        for (std::size_t h = 0; h < loads_.size(); ++h) {
            const int further = task.shares[h] - s;
            if (further <= 0) continue;
            low = std::max(low, ceilDiv(task.shares[h] * blendLow(g) - s * blendHigh(h), 64 * further));
            high = std::min(high, floorDiv(task.shares[h] * blendHigh(g) - s * blendLow(h), 64 * further));
        }
    }
    return {first.firstAtLeast(low), first.lastAtMost(high)};
}

/// Returns the codes of the second end that bring every load within its range.
RegionSearch::Range RegionSearch::secondEnds(const Task& task, int firstValue) const {
    const EndValues& second = task.second;
    int low = second[second.firstUsable()], high = second[second.count() - 1];
    for (std::size_t g = 0; g < loads_.size(); ++g) {
        const int s = task.shares[g], rest = firstValue * (64 - s);
        const Range& range = task.ranges[g];
        if (s == 0) {
            if (firstValue < range.low || firstValue > range.high) return {0, -1};
            continue;
        }
        low = std::max(low, ceilDiv(64 * range.low - 32 - rest, s));
        high = std::min(high, floorDiv(64 * range.high + 31 - rest, s));
    }
    if (low > high) return {0, -1};
    return {second.firstAtLeast(low), second.lastAtMost(high)};
}

/// Returns the intervals of codes of the first end for which some second end may bring every load within its range. Up to three, because
/// the window of the second end may cross the gap of the circle of codes; unused ones are empty.
std::array<RegionSearch::Range, 3> RegionSearch::firstRuns(const Task& task) const {
    constexpr Range kNone = {0, -1};
    const Range codes = firstEnds(task);
    const Arc& second = task.window.second;
    const int count = task.first.count(), reach = std::max(-second.from, second.from + second.count - 1);
    if (!task.window.secondFollowsFirst || 4 * reach >= count) return {codes, kNone, kNone};
    // A second end within reach keeps the first end close to every load, except for ends on both sides of the gap of the circle.
    Range near = {std::max(codes.low, reach), std::min(codes.high, count - reach - 1)};
    for (std::size_t g = 0; g < loads_.size(); ++g) {
        near.low = std::max(near.low, task.first.firstAtLeast(task.ranges[g].low) - reach);
        near.high = std::min(near.high, task.first.lastAtMost(task.ranges[g].high) + reach);
    }
    // It also keeps the loads close to each other.
    const int step = (task.first[count - 1] - task.first[0]) / (count - 1) + 1;
    if (near.low <= near.high && !allowsSpread(task.ranges, task.shares, 0, (reach + 2) * step)) near = kNone;
    return {Range{codes.low, std::min(codes.high, reach - 1)}, near, Range{std::max(codes.low, count - reach), codes.high}};
}

/// Calls visit(code) for each first end in these intervals that the window allows, until it returns false.
template <class Visit>
void RegionSearch::eachFirst(const Task& task, const std::array<Range, 3>& runs, Visit&& visit) const {
    for (const Range& run : runs)
        if (!eachOn(task.window.first, task.first.count(), run.low, run.high, visit)) return;
}

double RegionSearch::errorOf(const Task& task, int code, int other) const {
    double error = 0;
    for (std::size_t g = 0; g < loads_.size(); ++g)
        error += loads_[g].weight *
                 channels_[task.channel].at(loads_[g].colour, interpolated(task.first[code], task.second[other], task.shares[g]));
    return error;
}

/// Calls visit(second code) for each second end that brings every load within its range, until it returns false.
template <class Visit>
void RegionSearch::eachSecond(const Task& task, int code, Visit&& visit) const {
    const Range codes = secondEnds(task, task.first[code]);
    if (codes.low > codes.high) return;
    Arc arc = task.window.second;
    if (task.window.secondFollowsFirst) arc.from += code;
    eachOn(arc, task.second.count(), codes.low, codes.high, visit);
}

/// Tries a few ends that are likely to be good, to reduce the bound before a search over many ends.
void RegionSearch::probe(const Task& task, Range codes, double& bound, Ends& found) const {
    constexpr int kPlaces = 16;
    const ChannelError& channel = channels_[task.channel];
    const auto tryFirst = [&](int code) {
        eachOn(task.window.first, task.first.count(), code, code, [&](int from) {
            Arc arc = task.window.second;
            if (task.window.secondFollowsFirst) arc.from += from;
            for (std::size_t g = 0; g < loads_.size(); ++g) {
                const int s = std::max(task.shares[g], 1), v = channel.nearest[static_cast<std::size_t>(loads_[g].colour)];
                int other = task.second.firstAtLeast((64 * v - task.first[from] * (64 - s)) / s);
                if (arc.count < task.second.count()) other = std::clamp(other, arc.from, arc.from + arc.count - 1);
                other = std::clamp(other, task.second.firstUsable(), task.second.count() - 1);
                eachOn(arc, task.second.count(), other, other, [&](int to) {
                    const double error = errorOf(task, from, to);
                    if (error < bound) found = {from, to, error};
                    bound = std::min(bound, error);
                    return true;
                });
            }
            return true;
        });
    };
    const auto nearestCode = [&](std::size_t g) {
        return task.first.firstAtLeast(channel.nearest[static_cast<std::size_t>(loads_[g].colour)]);
    };
    const int from = nearestCode(0), to = nearestCode(loads_.size() - 1);
    for (int i = 0; i <= kPlaces; ++i) tryFirst(std::clamp(from + (to - from) * i / kPlaces, codes.low, codes.high));
    for (std::size_t h = 1; h < loads_.size(); ++h) {
        const int s = task.shares[0], further = task.shares[h] - s;
        if (further == 0) continue;
        const int a = channel.nearest[static_cast<std::size_t>(loads_[0].colour)],
                  b = channel.nearest[static_cast<std::size_t>(loads_[h].colour)];
        const int ideal = task.first.firstAtLeast((task.shares[h] * a - s * b) / further);
        for (int code = ideal - 2; code < ideal + 2; ++code) tryFirst(std::clamp(code, codes.low, codes.high));
    }
}

Ends RegionSearch::best(std::size_t channel, const int* shares, const EndValues& first, const EndValues& second, const Window& window,
                        double bound) const {
    constexpr int kMany = 48;  // first ends: more are worth probing for a better bound first
    Task task{channel, shares, first, second, window, range_[channel]};
    Ends found{0, 0, kInfinite};
    const double enough = leastOf_[channel] + (bound_ < kInfinite ? kTieMargin * bound_ : 0);
    std::array<Range, 3> runs = firstRuns(task);
    Range codes = {first.count(), -1};
    int total = 0;
    for (const Range& run : runs) {
        if (run.low > run.high) continue;
        total += run.high - run.low + 1;
        codes = {std::min(codes.low, run.low), std::max(codes.high, run.high)};
    }
    const bool many = total > kMany && !loads_.empty();
    if (many) {
        probe(task, codes, bound, found);
        if (bound <= enough) return found;
        task.ranges = rangesBelow(channel, bound);
        runs = firstRuns(task);
    }
    double narrowed = bound;
    eachFirst(task, runs, [&](int code) {
        eachSecond(task, code, [&](int other) {
            const double error = errorOf(task, code, other);
            if (error < bound) {
                bound = error;
                found = {code, other, error};
            }
            return bound > enough;
        });
        if (many && bound < narrowed / 4) {
            task.ranges = rangesBelow(channel, bound);
            narrowed = bound;
        }
        return bound > enough;
    });
    return found;
}

bool RegionSearch::allowsSpread(const Ranges& range, const int* shares, int spread, int tolerance) const {
    for (std::size_t g = 0; g < loads_.size(); ++g)
        for (std::size_t h = 0; h < loads_.size(); ++h) {
            const int further = shares[h] - shares[g];
            if (further < 0) continue;
            const int least = (spread - tolerance) * further - 64, most = (spread + tolerance) * further + 64;
            if (64 * (range[h].high - range[g].low) < least || 64 * (range[h].low - range[g].high) > most) return false;
        }
    return true;
}

std::vector<Ends> RegionSearch::bestOfEachFirst(std::size_t channel, const int* shares, const EndValues& values, const Window& window,
                                                double bound) const {
    const Task task{channel, shares, values, values, window, rangesBelow(channel, bound)};
    std::vector<Ends> list;
    eachFirst(task, firstRuns(task), [&](int code) {
        Ends found{code, 0, bound};
        eachSecond(task, code, [&](int other) {
            const double error = errorOf(task, code, other);
            if (error < found.error) found = {code, other, error};
            return true;
        });
        if (found.error < bound) list.push_back(found);
        return true;
    });
    std::sort(list.begin(), list.end(),
              [](const Ends& a, const Ends& b) { return a.error != b.error ? a.error < b.error : a.first < b.first; });
    return list;
}

std::vector<std::array<double, 2>> RegionSearch::tradeOffs(std::size_t channel, const int* shares, const EndValues& first,
                                                           const EndValues& second, const Window& window) const {
    // Beyond these limits of first ends and of points, the two smallest errors alone are a valid, weaker bound.
    constexpr int kMany = 1024;
    constexpr std::size_t kMost = 4096;
    const ChannelError& error = channels_[channel];
    const Task task{channel, shares, first, second, window, range_[channel]};
    const std::array<Range, 3> runs = firstRuns(task);
    for (const Range& run : runs)
        if (run.high - run.low > kMany) return {{error.least[0], error.least[1]}};
    std::vector<std::array<double, 2>> points;
    eachFirst(task, runs, [&](int code) {
        eachSecond(task, code, [&](int other) {
            const auto of = [&](std::size_t g) { return error.at(loads_[g].colour, interpolated(first[code], second[other], shares[g])); };
            points.push_back({of(0), of(1)});
            return points.size() < kMost;
        });
        return points.size() < kMost;
    });
    if (points.size() >= kMost) return {{error.least[0], error.least[1]}};
    std::sort(points.begin(), points.end());
    std::vector<std::array<double, 2>> hull;  // monotone chain (Andrew 1979)
    for (const auto& point : points) {
        if (!hull.empty() && point[1] >= hull.back()[1]) continue;
        while (hull.size() > 1) {
            const auto &a = hull[hull.size() - 2], &b = hull.back();
            if ((b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0]) > 0) break;
            hull.pop_back();
        }
        hull.push_back(point);
    }
    return hull;
}

RegionBounds::RegionBounds(std::span<const ChannelError> channels, int indexBits, const EndValues& first, const EndValues& second,
                           std::span<const Window> windows, const std::array<double, 2>& floor, double bound)
    : count_(1 << indexBits), floor_(floor) {
    const int half = count_ / 2;
    std::array<Ends, 4> ends;
    for (const int colour : {0, 1}) {
        double& least = alone_[static_cast<std::size_t>(colour)];
        const double weight = floor[static_cast<std::size_t>(colour)];
        RegionSearch search(channels, {{colour, weight}});
        least = bound;
        for (int i = 0; i < half; ++i) {
            search.limit(least);
            const int share = weightOf(indexBits, i);
            least = std::min(least, search.place(&share, first, second, windows, least, ends.data()));
        }
        least /= weight;
    }
    RegionSearch search(channels, {{0, floor[0]}, {1, floor[1]}});
    search.limit(bound);
    for (int i = 0; i < half; ++i)
        for (int j = 0; j < count_; ++j) {
            const std::array<int, 2> shares = {weightOf(indexBits, i), weightOf(indexBits, j)};
            std::vector<TradeOffs>& of = tradeOffs_.emplace_back();
            for (std::size_t c = 0; c < channels.size(); ++c) {
                of.push_back(search.tradeOffs(c, shares.data(), first, second, windows[c]));
                if (!of.back().empty()) continue;
                of.clear();
                break;
            }
        }
}

double RegionBounds::least(const std::array<double, 2>& weight) const {
    const bool first = weight[0] >= floor_[0], second = weight[1] >= floor_[1];
    if (!first || !second) return first ? weight[0] * alone_[0] : second ? weight[1] * alone_[1] : 0;
    double least = kInfinite;
    for (int i = 0; i < count_ / 2; ++i)
        for (int j = 0; j < count_; ++j) least = std::min(least, this->least(i, j, weight));
    return least;
}

double RegionBounds::least(int i, int j, const std::array<double, 2>& weight) const {
    if (weight[0] < floor_[0] || weight[1] < floor_[1]) return 0;
    // Swapping the ends mirrors the indices.
    const int mirrored = i < count_ / 2 ? i * count_ + j : (count_ - 1 - i) * count_ + count_ - 1 - j;
    const std::vector<TradeOffs>& of = tradeOffs_[static_cast<std::size_t>(mirrored)];
    if (of.empty()) return kInfinite;
    double sum = 0;
    for (const TradeOffs& channel : of) {
        double best = kInfinite;
        for (const auto& trade : channel) best = std::min(best, weight[0] * trade[0] + weight[1] * trade[1]);
        sum += best;
    }
    return sum;
}

double RegionSearch::place(const int* shares, const EndValues& first, const EndValues& second, std::span<const Window> windows,
                           double bound, Ends* ends) const {
    double error = 0, left = least_;
    for (std::size_t i = 0; i < channels_.size(); ++i) {
        const std::size_t c = order_[i];
        left -= leastOf_[c];
        ends[c] = best(c, shares, first, second, windows[c], bound - error - left);
        error += ends[c].error;
        if (!(error + left < bound)) return kInfinite;
    }
    return error;
}

}  // namespace lightcook::compress

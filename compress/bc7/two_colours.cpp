#include "compress/bc7/two_colours.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "compress/bc7/modes.h"
#include "compress/block/partitions.h"

namespace lightcook::compress {
namespace {

constexpr Window kAnywhere = {{0, 256}, {0, 256}, false};
constexpr std::array<Window, 4> kAllAnywhere = {kAnywhere, kAnywhere, kAnywhere, kAnywhere};

/// Returns the metric of every interpolated value: the value itself, since errors are measured in 0 .. 255.
const std::array<double, 256>& codeMetric() {
    static const std::array<double, 256> metric = [] {
        std::array<double, 256> values;
        for (std::size_t v = 0; v < 256; ++v) values[v] = static_cast<double>(v);
        return values;
    }();
    return metric;
}

/// Returns the values of all codes.
/// lowBit  -1: the mode has none
const EndValues& endValues(int bits, int lowBit) {
    static const auto tables = [] {
        std::vector<EndValues> made;
        for (int b = 4; b <= 8; ++b)
            for (int low = -1; low <= 1; ++low) {
                std::vector<int> values;
                for (int code = 0; code < 1 << b; ++code)
                    values.push_back(low < 0 || b == 8 ? expandTo8(code, b) : expandTo8(code << 1 | low, b + 1));
                made.emplace_back(std::move(values));
            }
        return made;
    }();
    return tables[static_cast<std::size_t>(3 * (bits - 4) + lowBit + 1)];
}

/// Returns all combinations of the low bits of two ends.
std::vector<std::array<int, 2>> lowBitsOf(int perPair) {
    if (perPair == 0) return {{-1, -1}};
    if (perPair == 1) return {{0, 0}, {1, 1}};
    return {{0, 0}, {0, 1}, {1, 0}, {1, 1}};
}
int lowBitsPerPair(const Bc7Mode& mode) {
    return mode.endpointLowBits ? 2 : mode.sharedLowBits;
}
std::size_t channelCountOf(const Bc7Mode& mode) {
    return mode.alphaBits ? 4 : 3;
}
std::vector<Load> loadsOf(const std::array<double, 2>& weight) {
    std::vector<Load> loads;
    for (const int colour : {0, 1})
        if (weight[static_cast<std::size_t>(colour)] > 0) loads.push_back({colour, weight[static_cast<std::size_t>(colour)]});
    return loads;
}

}  // namespace

Bc7TwoColours::Bc7TwoColours(const EncodeOptions& options) {
    for (std::size_t c = 0; c < 4; ++c) {
        channels_[c].metric = codeMetric().data();
        channels_[c].highest = 255;
        channels_[c].weight.fill(static_cast<double>(options.channelWeights[c]));
    }
}

Bc7TwoColours::Weights Bc7TwoColours::weightOf(int regionCount, int partition, int region) const {
    Weights weight{};
    for (std::size_t i = 0; i < 2; ++i)
        for (int t = 0; t < kTexelCount; ++t)
            if ((two_->texels[i] >> t & 1) && regionOf(regionCount, partition, t) == region)
                weight[i] += static_cast<double>(block_->significance[static_cast<std::size_t>(t)]);
    return weight;
}

Bc7Result Bc7TwoColours::fit(const Block& block, const TwoColours& two) {
    block_ = &block;
    two_ = &two;
    best_ = {};
    bestError_ = kInfinite;
    bounds_ = {};
    total_ = weightOf(1, 0, 0);
    least_ = opaqueError_ = 0;
    for (std::size_t c = 0; c < 4; ++c) {
        for (std::size_t i = 0; i < 2; ++i) channels_[c].target[i] = 255 * static_cast<double>(two.colour[i][c]);
        channels_[c].findLeast();
        for (std::size_t i = 0; i < 2; ++i) least_ += total_[i] * channels_[c].least[i];
    }
    for (std::size_t i = 0; i < 2; ++i) opaqueError_ += total_[i] * channels_[3].at(static_cast<int>(i), 255);

    for (int rotation = 0; rotation < 4 && !foundAll(); ++rotation) tryRotation(5, rotation, false);
    if (!foundAll()) tryOneRegion(6);
    for (int rotation = 0; rotation < 4; ++rotation)
        for (const bool selection : {false, true})
            if (!foundAll()) tryRotation(4, rotation, selection);
    if (foundAll()) return best_;
    for (const Partition& partition : partitions())
        for (const int mode : {3, 1, 7, 2, 0})
            if (kBc7Modes[static_cast<std::size_t>(mode)].regionCount == partition.regionCount && !foundAll())
                tryPartition(mode, partition.number);
    return best_;
}

bool Bc7TwoColours::foundAll() const {
    return bestError_ <= least_ * (1 + kTieMargin);
}

/// Returns the partitions in the order in which they are searched: those that separate the colours best first, because a small error found
/// early prunes more. Also sets floor_.
std::vector<Bc7TwoColours::Partition> Bc7TwoColours::partitions() {
    std::vector<Partition> list;
    floor_ = total_;
    for (const int regionCount : {2, 3})
        for (int p = 0; p < 64; ++p) {
            Partition partition{0, regionCount, p};
            for (int r = 0; r < regionCount; ++r) {
                const Weights weight = weightOf(regionCount, p, r);
                partition.both += std::min(weight[0], weight[1]);
                for (std::size_t i = 0; i < 2; ++i)
                    if (weight[i] > total_[i] * kFloorShare) floor_[i] = std::min(floor_[i], weight[i]);
            }
            list.push_back(partition);
        }
    std::stable_sort(list.begin(), list.end(), [](const Partition& a, const Partition& b) { return a.both < b.both; });
    return list;
}

Bc7TwoColours::Coded Bc7TwoColours::code(std::span<const ChannelError> channels, const Weights& weight, const Coding& coding,
                                         double bound) const {
    Coded best;
    RegionSearch search(channels, loadsOf(weight));
    const std::vector<Load>& loads = search.loads();
    if (loads.empty()) return best;
    best.error = kInfinite;
    const int count = 1 << coding.indexBits;
    for (const auto& low : lowBitsOf(coding.lowBitsPerPair))
        // Swapping the ends mirrors the indices, so the first colour can stay in the lower half.
        for (int i = 0; i < count / 2; ++i)
            for (int j = 0; j < (loads.size() > 1 ? count : 1); ++j) {
                search.limit(bound);
                const int shares[] = {compress::weightOf(coding.indexBits, i), compress::weightOf(coding.indexBits, j)};
                std::array<Ends, 4> ends;
                const double error =
                    search.place(shares, endValues(coding.bits, low[0]), endValues(coding.bits, low[1]), kAllAnywhere, bound, ends.data());
                if (!(error < bound)) continue;
                bound = best.error = error;
                best.ends = ends;
                for (std::size_t e = 0; e < 2; ++e) best.low[e] = static_cast<std::uint8_t>(std::max(low[e], 0));
                best.index[static_cast<std::size_t>(loads[0].colour)] = static_cast<std::uint8_t>(i);
                if (loads.size() > 1) best.index[1] = static_cast<std::uint8_t>(j);
                if (error <= search.least() * (1 + kTieMargin)) return best;
            }
    return best;
}

void Bc7TwoColours::setRegion(int regionCount, int partition, int region, std::size_t firstChannel, std::size_t channelCount,
                              const Coded& coded) {
    const auto first = static_cast<std::size_t>(2 * region);
    for (std::size_t c = 0; c < channelCount; ++c) {
        best_.code[first][firstChannel + c] = static_cast<std::uint8_t>(coded.ends[c].first);
        best_.code[first + 1][firstChannel + c] = static_cast<std::uint8_t>(coded.ends[c].second);
    }
    for (std::size_t e = 0; e < 2; ++e) best_.low[first + e] = coded.low[e];
    auto& indices = firstChannel == 3 ? best_.second : best_.index;
    for (int t = 0; t < kTexelCount; ++t)
        if (regionOf(regionCount, partition, t) == region) indices[static_cast<std::size_t>(t)] = coded.index[two_->texels[1] >> t & 1];
}

void Bc7TwoColours::tryOneRegion(int mode) {
    const Bc7Mode& of = kBc7Modes[static_cast<std::size_t>(mode)];
    const Coded coded = code(channels_, total_, {of.colourBits, lowBitsPerPair(of), of.indexBits}, bestError_);
    if (!(coded.error < bestError_)) return;
    bestError_ = coded.error;
    best_ = {};
    best_.mode = mode;
    setRegion(1, 0, 0, 0, 4, coded);
}

/// Tries mode 4 or 5, in which one channel has indices of its own.
void Bc7TwoColours::tryRotation(int mode, int rotation, bool indexSelection) {
    const Bc7Mode& of = kBc7Modes[static_cast<std::size_t>(mode)];
    std::array<ChannelError, 4> rotated = channels_;
    if (rotation > 0) std::swap(rotated[3], rotated[static_cast<std::size_t>(rotation - 1)]);
    const int colourIndexBits = indexSelection ? of.secondIndexBits : of.indexBits;
    const std::span<const ChannelError> colours(rotated.data(), 3), alone(rotated.data() + 3, 1);
    const double leastAlone = total_[0] * alone[0].least[0] + total_[1] * alone[0].least[1];
    const Coded colour = code(colours, total_, {of.colourBits, 0, colourIndexBits}, bestError_ - leastAlone);
    if (colour.error == kInfinite) return;
    const Coded other =
        code(alone, total_, {of.alphaBits, 0, of.indexBits + of.secondIndexBits - colourIndexBits}, bestError_ - colour.error);
    if (!(colour.error + other.error < bestError_)) return;
    bestError_ = colour.error + other.error;
    best_ = {};
    best_.mode = mode;
    best_.rotation = rotation;
    best_.indexSelection = indexSelection;
    setRegion(1, 0, 0, 0, 3, colour);
    setRegion(1, 0, 0, 3, 1, other);
}

/// Returns a lower bound of the error of a region in a mode.
double Bc7TwoColours::leastOf(int mode, const Weights& weight) {
    const Bc7Mode& of = kBc7Modes[static_cast<std::size_t>(mode)];
    auto& bounds = bounds_[static_cast<std::size_t>(mode)];
    if (bounds.empty())
        for (const auto& low : lowBitsOf(lowBitsPerPair(of)))
            bounds.emplace_back(std::span(channels_).first(channelCountOf(of)), of.indexBits, endValues(of.colourBits, low[0]),
                                endValues(of.colourBits, low[1]), kAllAnywhere, floor_, bestError_);
    double least = kInfinite;
    for (const RegionBounds& choice : bounds) least = std::min(least, choice.least(weight));
    return least;
}

/// Tries a mode with several regions. Regions are independent, so each is searched with the error that the others leave to it.
void Bc7TwoColours::tryPartition(int mode, int partition) {
    const Bc7Mode& of = kBc7Modes[static_cast<std::size_t>(mode)];
    if (partition >= 1 << of.partitionBits) return;
    const double opaque = of.alphaBits ? 0 : opaqueError_;
    if (!(opaque < bestError_)) return;
    std::array<Weights, 3> weight;
    std::array<double, 3> cost{};
    double error = opaque;
    for (int r = 0; r < of.regionCount; ++r) {
        const auto at = static_cast<std::size_t>(r);
        weight[at] = weightOf(of.regionCount, partition, r);
        cost[at] = leastOf(mode, weight[at]);
        error += cost[at];
    }
    std::array<Coded, 3> coded;
    for (int r = 0; r < of.regionCount; ++r) {
        if (!(error < bestError_)) return;
        const auto at = static_cast<std::size_t>(r);
        const double others = error - cost[at];
        coded[at] = code(std::span(channels_).first(channelCountOf(of)), weight[at], {of.colourBits, lowBitsPerPair(of), of.indexBits},
                         bestError_ - others);
        error = others + coded[at].error;
    }
    if (!(error < bestError_)) return;
    bestError_ = error;
    best_ = {};
    best_.mode = mode;
    best_.partition = partition;
    for (int r = 0; r < of.regionCount; ++r)
        setRegion(of.regionCount, partition, r, 0, channelCountOf(of), coded[static_cast<std::size_t>(r)]);
}

}  // namespace lightcook::compress

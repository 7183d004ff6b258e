#include "compress/bc6h/two_colours.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "compress/bc6h/modes.h"
#include "compress/block/partitions.h"
#include "compress/texel/half.h"

namespace lightcook::compress {
namespace {

constexpr int kStartMode = kBc6hOneRegionModes.front();  ///< without deltas, so that any ends are valid

/// Returns log2(1 + x), x >= 0, nearly to double precision. Own code, because the bytes must not depend on the rounding of a library.
double log2OfOneAnd(double x) {
    int exponent = 0;
    double above = x;  // mantissa - 1
    if (x > 0.4) {
        above = 2 * std::frexp(1 + x, &exponent) - 1;
        --exponent;
        if (above > 0.4) {
            above = (above - 1) / 2;
            ++exponent;
        }
    }
    // ln((1 + z) / (1 - z)) = 2 (z + z^3 / 3 + z^5 / 5 ..), z^2 < 1/32
    const double z = above / (2 + above), squared = z * z;
    double sum = 0;
    for (int power = 23; power > 0; power -= 2) sum = sum * squared + 1.0 / power;
    constexpr double kPerLn2 = 1.4426950408889634074;
    return exponent + 2 * kPerLn2 * z * sum;
}

/// Returns the values of all codes of a precision. In the signed format code 0 is the most negative one; with 16 bits it decodes to minus
/// infinity and is never used.
EndValues makeValues(int bits, bool isSigned) {
    const int count = 1 << bits, smallest = isSigned ? -count / 2 : 0;
    std::vector<int> values(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) values[static_cast<std::size_t>(i)] = bc6hUnquantize(smallest + i, bits, isSigned);
    return EndValues(std::move(values), isSigned && bits == 16);
}
const EndValues& endValues(int bits, bool isSigned) {
    static const auto tables = [] {
        std::vector<EndValues> made;
        for (const bool negative : {false, true})
            for (int b = 6; b <= 16; ++b) made.push_back(makeValues(b, negative));
        return made;
    }();
    return tables[static_cast<std::size_t>(bits - 6 + (isSigned ? 11 : 0))];
}

/// Returns the metric of every interpolated value, from the smallest up. The reference is valid until the same thread calls with other
/// options.
const std::vector<double>& metricOfValues(bool isSigned, const EncodeOptions& options) {
    struct MetricTable {
        bool isLog = false;
        float scale = 0;
        std::vector<double> values;
    };
    thread_local std::array<MetricTable, 2> tables;
    MetricTable& table = tables[isSigned];
    const bool isLog = options.hdrMetric == HdrMetric::Log;
    if (!table.values.empty() && table.isLog == isLog && table.scale == options.hdrScale) return table.values;
    const int largest = isSigned ? 0x7FFF : 0xFFFF, smallest = isSigned ? -largest : 0;
    table.isLog = isLog;
    table.scale = options.hdrScale;
    table.values.resize(static_cast<std::size_t>(largest - smallest + 1));
    double* zero = table.values.data() - smallest;
    for (int value = 0, lastHalf = -1; value <= largest; ++value) {
        const int half = bc6hFinish(value, isSigned);
        const auto x = static_cast<double>(floatFromHalf(static_cast<std::uint16_t>(half)));
        if (half == lastHalf)
            zero[value] = zero[value - 1];
        else
            zero[value] = isLog ? log2OfOneAnd(x / static_cast<double>(options.hdrScale)) : x;
        if (isSigned) zero[-value] = -zero[value];
        lastHalf = half;
    }
    return table.values;
}

/// Returns true if a code is within the reach of the first end, on the circle of all codes.
bool isWithin(int reach, int first, int code, int count) {
    const int away = code - first + reach;
    return 2 * reach >= count || (away < 0 ? away + count : away >= count ? away - count : away) < 2 * reach;
}
/// Returns the window of the ends of region 0.
Window windowOfFirst(int reach) {
    return {{0, std::numeric_limits<int>::max() / 2}, {-reach, 2 * reach}, true};
}
/// Returns the window of the ends of region 1 when region 0 is not known yet.
Window windowOfSecond(int reach) {
    return {{0, std::numeric_limits<int>::max() / 2}, {1 - 2 * reach, 4 * reach - 1}, true};
}

/// Returns the weights of the colours without the anchor.
std::array<double, 2> weightsOfRest(std::array<double, 2> weight, int anchorColour, double anchorWeight) {
    if (anchorColour >= 0) weight[static_cast<std::size_t>(anchorColour)] -= anchorWeight;
    return weight;
}
std::vector<Load> mergedLoads(const std::array<double, 2>& weight) {
    std::vector<Load> loads;
    for (int colour = 0; colour < 2; ++colour)
        if (weight[static_cast<std::size_t>(colour)] > 0) loads.push_back({colour, weight[static_cast<std::size_t>(colour)]});
    return loads;
}
/// Returns the loads for an anchor that parts: the rest of its colour, the other colour if the region has it, the anchor.
std::vector<Load> partedLoads(const std::array<double, 2>& weight, int anchorColour, double anchorWeight) {
    if (anchorColour < 0) return {};
    std::vector<Load> loads = {{anchorColour, weight[static_cast<std::size_t>(anchorColour)] - anchorWeight}};
    if (const double other = weight[static_cast<std::size_t>(1 - anchorColour)]; other > 0) loads.push_back({1 - anchorColour, other});
    loads.push_back({anchorColour, anchorWeight});
    return loads;
}

}  // namespace

Bc6hTwoColours::Searches::Searches(std::span<const ChannelError> channels, const Region& of)
    : region(of),
      merged(channels, mergedLoads(of.weight)),
      parted(channels, partedLoads(of.weight, of.anchorColour, of.anchorWeight)),
      rest(channels, mergedLoads(weightsOfRest(of.weight, of.anchorColour, of.anchorWeight))),
      canPart(of.anchorColour >= 0 && of.weight[static_cast<std::size_t>(of.anchorColour)] > of.anchorWeight) {}

Bc6hTwoColours::Bc6hTwoColours(bool isSigned, const EncodeOptions& options) : isSigned_(isSigned), options_(options) {
    const int largest = isSigned ? 0x7FFF : 0xFFFF, smallest = isSigned ? -largest : 0;
    const std::vector<double>& metric = metricOfValues(isSigned, options);
    for (ChannelError& channel : channels_) {
        channel.metric = metric.data() - smallest;
        channel.lowest = smallest;
        channel.highest = largest;
    }
}

void Bc6hTwoColours::measure(const TwoColours& two) {
    const auto scale = static_cast<double>(options_.hdrScale);
    for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t i = 0; i < 2; ++i) {
            const auto x = static_cast<double>(two.colour[i][c]), magnitude = std::abs(x);
            const bool isLog = options_.hdrMetric == HdrMetric::Log;
            channels_[c].target[i] = isLog ? std::copysign(log2OfOneAnd(magnitude / scale), x) : x;
            const double unit = options_.hdrMetric == HdrMetric::Relative ? magnitude + scale : 1;
            channels_[c].weight[i] = static_cast<double>(options_.channelWeights[c]) / (unit * unit);
        }
        channels_[c].findLeast();
    }
}

Bc6hTwoColours::Region Bc6hTwoColours::regionOf(std::uint32_t texels, int anchor) const {
    Region region;
    for (std::size_t i = 0; i < 2; ++i)
        for (int t = 0; t < kTexelCount; ++t) {
            if (!(two_->texels[i] & texels & 1u << t)) continue;
            const auto weight = static_cast<double>(block_->significance[static_cast<std::size_t>(t)]);
            region.weight[i] += weight;
            if (t != anchor) continue;
            region.anchorColour = static_cast<int>(i);
            region.anchorWeight = weight;
        }
    return region;
}

Bc6hTwoColours::Mode Bc6hTwoColours::modeOf(int number) const {
    const Bc6hMode& of = kBc6hModes[static_cast<std::size_t>(number)];
    Mode mode;
    mode.number = number;
    mode.regionCount = of.regionCount;
    mode.indexBits = of.regionCount == 1 ? 4 : 3;
    mode.transformed = of.transformed;
    mode.values = &endValues(of.endpointBits, isSigned_);
    for (std::size_t c = 0; c < 3; ++c) {
        mode.reach[c] = of.transformed ? 1 << (of.deltaBits[c] - 1) : mode.values->count();
        mode.firstWindows[c] = windowOfFirst(mode.reach[c]);
        mode.secondWindows[c] = windowOfSecond(mode.reach[c]);
    }
    return mode;
}

/// Returns the partitions in the order in which they are searched: those that separate the colours best first, because a small error found
/// early prunes more. Of partitions that divide the colours in the same way only one is kept; the anchor of region 1 makes no difference,
/// since its ends can be swapped.
std::vector<Bc6hTwoColours::Partition> Bc6hTwoColours::partitions() const {
    std::vector<Partition> list;
    for (int p = 0; p < 32; ++p) {
        const std::uint32_t second = kTwoRegions[static_cast<std::size_t>(p)];
        Partition partition{p, 0, {regionOf(~second, 0), regionOf(second, anchorOf(2, p, 1))}};
        for (const Region& region : partition.regions) partition.both += std::min(region.weight[0], region.weight[1]);
        const auto isAlike = [&](const Partition& other) {
            const auto &a = other.regions, &b = partition.regions;
            return a[0].weight == b[0].weight && a[1].weight == b[1].weight && a[0].anchorColour == b[0].anchorColour &&
                   a[0].anchorWeight == b[0].anchorWeight;
        };
        if (std::none_of(list.begin(), list.end(), isAlike)) list.push_back(partition);
    }
    std::stable_sort(list.begin(), list.end(), [](const Partition& a, const Partition& b) { return a.both < b.both; });
    return list;
}

Bc6hResult Bc6hTwoColours::fit(const Block& block, const TwoColours& two) {
    block_ = &block;
    two_ = &two;
    best_ = {};
    bestError_ = kInfinite;
    bounds_ = {};
    measure(two);
    start();
    for (const int number : kBc6hOneRegionModes)
        if (!foundAll()) tryOneRegion(modeOf(number));
    const std::vector<Partition> all = partitions();
    const std::array<double, 2> total = regionOf(0xFFFF, 0).weight;
    floor_ = total;
    for (const Partition& partition : all)
        for (const Region& region : partition.regions)
            for (std::size_t i = 0; i < 2; ++i)
                if (region.weight[i] > total[i] * kFloorShare) floor_[i] = std::min(floor_[i], region.weight[i]);
    for (const Partition& partition : all)
        if (!foundAll()) tryPartition(partition);
    best_.error = static_cast<float>(bestError_);
    return best_;
}

void Bc6hTwoColours::tryPartition(const Partition& partition) {
    std::array<Searches, 2> searches = {Searches(channels_, partition.regions[0]), Searches(channels_, partition.regions[1])};
    for (const int number : kBc6hTwoRegionModes) {
        if (foundAll()) return;
        const Mode mode = modeOf(number);
        auto& bounds = bounds_[static_cast<std::size_t>(number)];
        if (partition.both > 0) {
            if (!bounds) bounds.emplace(channels_, mode.indexBits, *mode.values, *mode.values, mode.secondWindows, floor_, bestError_);
            const double least = bounds->least(searches[0].region.weight) + bounds->least(searches[1].region.weight);
            if (!(least < bestError_)) continue;
        }
        tryTwoRegions(mode, partition.number, bounds ? &*bounds : nullptr, searches);
    }
}

bool Bc6hTwoColours::foundAll() const {
    return bestError_ <= least_ * (1 + kTieMargin);
}

/// Sets a first result: each colour at one end, in a mode without deltas.
void Bc6hTwoColours::start() {
    const EndValues& values = endValues(kBc6hModes[kStartMode].endpointBits, isSigned_);
    const Region region = regionOf(0xFFFF, 0);
    Placement placement;
    placement.index = {0, 15};
    double error = 0;
    least_ = 0;
    for (std::size_t c = 0; c < 3; ++c) {
        std::array<int, 2> code{};
        for (std::size_t i = 0; i < 2; ++i) {
            double least = kInfinite;
            for (int k = 0; k < values.count(); ++k) {
                const double miss = channels_[c].at(static_cast<int>(i), values[k]);
                if (miss < least) code[i] = k;
                least = std::min(least, miss);
            }
            error += region.weight[i] * least;
            least_ += region.weight[i] * channels_[c].least[i];
        }
        placement.ends[c] = {code[0], code[1], 0};
    }
    const Mode mode = modeOf(kStartMode);
    const Placement* const only[] = {&placement};
    keep(error, mode, 0, only, &placement.ends);
}

/// Finds the best ends of a placement and adds it to the list if its error is below the bound. Without deltas regions are independent, so
/// only the best placement stays in the list.
void Bc6hTwoColours::keepPlacement(RegionSearch& search, const Mode& mode, bool isFirst, Placement placement, double& bound,
                                   std::vector<Placement>& list) const {
    placement.search = &search;
    placement.error = search.place(placement.shares.data(), *mode.values, *mode.values, isFirst ? mode.firstWindows : mode.secondWindows,
                                   bound, placement.ends.data());
    if (!(placement.error < bound)) return;
    if (mode.regionCount == 1 || !mode.transformed) {
        list.clear();
        bound = placement.error;
        search.limit(bound);
    }
    list.push_back(placement);
}

std::vector<Bc6hTwoColours::Placement> Bc6hTwoColours::placements(Searches& searches, const Mode& mode, bool isFirst,
                                                                  const RegionBounds* bounds, double bound) const {
    searches.merged.limit(bound);
    std::vector<Placement> list;
    const int count = 1 << mode.indexBits, half = count / 2;
    const auto& loads = searches.merged.loads();
    // The ends of a region can be swapped, except in region 0 of transformed modes, where the first end is the base of all deltas.
    const bool turns = !(isFirst && mode.transformed);
    const auto shareOf = [&](int index) { return weightOf(mode.indexBits, index); };
    const auto isLow = [&](std::size_t load, int index) {
        if (turns) return load > 0 || index < half;
        return loads[load].colour != searches.region.anchorColour || index < half;
    };
    for (int i = 0; i < count; ++i)
        for (int j = 0; j < count; ++j) {
            if ((loads.size() < 2 && j > 0) || (loads.empty() && i > 0)) break;
            if ((!loads.empty() && !isLow(0, i)) || (loads.size() > 1 && !isLow(1, j))) continue;
            if (bounds && loads.size() > 1 && !(bounds->least(i, j, searches.region.weight) < bound)) continue;
            Placement placement;
            if (!loads.empty()) placement.index[static_cast<std::size_t>(loads[0].colour)] = i;
            if (loads.size() > 1) placement.index[static_cast<std::size_t>(loads[1].colour)] = j;
            placement.shares = {shareOf(i), shareOf(j), 0};
            keepPlacement(searches.merged, mode, isFirst, placement, bound, list);
        }
    if (!turns && searches.canPart) partPlacements(searches, mode, bound, list);
    return list;
}

/// Returns true if ends that cannot be swapped may have an error below the bound: ends whose second is the full reach below the first in
/// some channel. All other ends can be swapped, and then the anchor does not need to part from its colour.
bool Bc6hTwoColours::needsOrder(const RegionSearch& search, const Mode& mode, const int* shares) {
    const EndValues& values = *mode.values;
    const int count = values.count(), step = values[count / 4 * 3 + 1] - values[count / 4 * 3];
    for (std::size_t c = 0; c < 3; ++c)
        for (const int codes : {-mode.reach[c], count - mode.reach[c]})  // the second: across the gap of the circle
            if (search.allowsSpread(c, shares, codes * step, 2 * step)) return true;
    return false;
}

/// Adds the placements of region 0 in which the anchor parts from its colour, whose index is in the upper half.
void Bc6hTwoColours::partPlacements(Searches& searches, const Mode& mode, double bound, std::vector<Placement>& list) const {
    const int count = 1 << mode.indexBits, half = count / 2;
    const auto own = static_cast<std::size_t>(searches.region.anchorColour);
    const bool both = searches.rest.loads().size() == 2;
    const double anchorLeast = searches.parted.least() - searches.rest.least();
    searches.parted.limit(bound);
    searches.rest.limit(bound - anchorLeast);
    for (int i = half; i < count; ++i)
        for (int j = 0; j < (both ? count : 1); ++j) {
            Placement placement;
            placement.index[own] = i;
            placement.index[1 - own] = j;
            std::array<int, 2> shares = {weightOf(mode.indexBits, i), weightOf(mode.indexBits, j)};
            const int ownShare = shares[0];
            if (both && own == 1) std::swap(shares[0], shares[1]);  // the loads of `rest` are in the order of the colours
            if (mode.regionCount == 1 && !needsOrder(searches.rest, mode, shares.data())) continue;
            // Most pairs exceed the bound even without the anchor.
            if (!(searches.rest.place(shares.data(), *mode.values, *mode.values, mode.firstWindows, bound - anchorLeast,
                                      placement.ends.data()) < bound - anchorLeast))
                continue;
            for (int k = 0; k < half; ++k) {
                const int anchorShare = weightOf(mode.indexBits, k);
                placement.anchorIndex = k;
                placement.shares = {ownShare, both ? weightOf(mode.indexBits, j) : anchorShare, anchorShare};
                keepPlacement(searches.parted, mode, true, placement, bound, list);
            }
        }
}

void Bc6hTwoColours::tryOneRegion(const Mode& mode) {
    Searches searches(channels_, regionOf(0xFFFF, 0));
    for (const Placement& placement : placements(searches, mode, true, nullptr, bestError_)) {
        const Placement* const only[] = {&placement};
        keep(placement.error, mode, 0, only, &placement.ends);
    }
}

void Bc6hTwoColours::tryTwoRegions(const Mode& mode, int partition, const RegionBounds* bounds, std::array<Searches, 2>& searches) {
    std::array<std::vector<Placement>, 2> lists;
    for (std::size_t r = 0; r < 2; ++r) {
        const double rest = r == 0 ? searches[1].merged.least() : lists[0].front().error;
        lists[r] = placements(searches[r], mode, r == 0, bounds, bestError_ - rest);
        if (lists[r].empty()) return;
        std::stable_sort(lists[r].begin(), lists[r].end(), [](const Placement& a, const Placement& b) { return a.error < b.error; });
    }
    for (const Placement& first : lists[0])
        for (const Placement& second : lists[1]) {
            if (!(first.error + second.error < bestError_)) break;
            std::array<std::array<Ends, 3>, 2> ends;
            const Placement* const both[] = {&first, &second};
            const double error = couple(mode, first, second, ends[0], ends[1]);
            if (error < bestError_) keep(error, mode, partition, both, ends.data());
        }
}

/// Finds the best ends for both regions together, channel by channel. If the deltas can hold the best ends of each region alone, these are
/// the result. Else it tries every first end of region 0, with the best other ends for it. Returns infinity if the error is not below the
/// best so far.
double Bc6hTwoColours::couple(const Mode& mode, const Placement& first, const Placement& second, std::array<Ends, 3>& firstEnds,
                              std::array<Ends, 3>& secondEnds) const {
    const int count = mode.values->count();
    double error = first.error + second.error;
    for (std::size_t c = 0; c < 3; ++c) {
        const int reach = mode.reach[c];
        Ends &a = firstEnds[c], &b = secondEnds[c];
        a = first.ends[c];
        b = second.ends[c];
        // A region without significant texels takes any codes that the deltas can hold.
        if (second.search->loads().empty()) b.first = b.second = a.first;
        if (first.search->loads().empty() && mode.transformed) {
            const bool rises = (b.second - b.first + count) % count < 2 * reach;
            a.first = a.second = ((rises ? b.first : b.second) + reach) % count;
        }
        if (isWithin(reach, a.first, b.first, count) && isWithin(reach, a.first, b.second, count)) continue;
        const double alone = a.error + b.error, others = error - alone;
        double best = bestError_ - others;
        bool found = false;
        for (const Ends& start :
             first.search->bestOfEachFirst(c, first.shares.data(), *mode.values, windowOfFirst(reach), best - b.error)) {
            if (!(start.error + second.ends[c].error < best)) break;
            const Arc arc{start.first - reach, 2 * reach};
            const Ends rest =
                second.search->best(c, second.shares.data(), *mode.values, *mode.values, {arc, arc, false}, best - start.error);
            if (!(start.error + rest.error < best)) continue;
            best = start.error + rest.error;
            a = start;
            b = rest;
            found = true;
        }
        if (!found) return kInfinite;
        error = others + best;
    }
    return error;
}

void Bc6hTwoColours::keep(double error, const Mode& mode, int partition, const Placement* const* placements,
                          const std::array<Ends, 3>* ends) {
    if (!(error < bestError_)) return;
    bestError_ = error;
    best_ = {};
    best_.mode = mode.number;
    best_.partition = partition;
    const int smallest = isSigned_ ? -mode.values->count() / 2 : 0;
    for (int r = 0; r < mode.regionCount; ++r) {
        for (std::size_t c = 0; c < 3; ++c) {
            best_.code[static_cast<std::size_t>(2 * r)][c] = ends[r][c].first + smallest;
            best_.code[static_cast<std::size_t>(2 * r + 1)][c] = ends[r][c].second + smallest;
        }
        setIndices(r, mode, partition, *placements[r]);
    }
}

/// Sets the indices of a region. Insignificant texels get the index of colour 0. If the index of the anchor is in the upper half, the ends
/// are swapped; the search has made sure that this is allowed.
void Bc6hTwoColours::setIndices(int region, const Mode& mode, int partition, const Placement& placement) {
    const int last = (1 << mode.indexBits) - 1, anchor = anchorOf(mode.regionCount, partition, region);
    const auto colourOf = [&](int t) -> std::size_t { return two_->texels[1] >> t & 1; };
    const bool anchorCounts = ((two_->texels[0] | two_->texels[1]) >> anchor & 1) != 0;
    const bool turned = anchorCounts && placement.anchorIndex < 0 && placement.index[colourOf(anchor)] > last / 2;
    if (turned) std::swap(best_.code[static_cast<std::size_t>(2 * region)], best_.code[static_cast<std::size_t>(2 * region + 1)]);
    for (int t = 0; t < kTexelCount; ++t) {
        if (compress::regionOf(mode.regionCount, partition, t) != region) continue;
        int index = placement.index[colourOf(t)];
        if (t == anchor && placement.anchorIndex >= 0) index = placement.anchorIndex;
        if (turned) index = last - index;
        if (t == anchor && !anchorCounts) index = std::min(index, last / 2);
        best_.index[static_cast<std::size_t>(t)] = static_cast<std::uint8_t>(index);
    }
}

}  // namespace lightcook::compress

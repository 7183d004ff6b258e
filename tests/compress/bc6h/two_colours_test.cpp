// BC6H blocks of two colours at effort 9 against an exhaustive search over every mode, partition, pair of ends and index, written from the
// specification of the format (the tables of partitions and index weights are covered by the tests of the decoders). The only pruning: if
// a part of a block alone costs more than the best error, the rest is skipped.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <iostream>

#include "compress/block/partitions.h"
#include "compress/texel/half.h"
#include "tests/compress/hostile_blocks.h"

namespace lightcook::compress::test {
namespace {

using formats::PixelFormat;

struct Mode {
    int regions, bits;
    std::array<int, 3> deltaBits;  ///< 0: no deltas
};
constexpr Mode kModes[] = {{2, 10, {5, 5, 5}}, {2, 7, {6, 6, 6}},  {2, 11, {5, 4, 4}}, {2, 11, {4, 5, 4}}, {2, 11, {4, 4, 5}},
                           {2, 9, {5, 5, 5}},  {2, 8, {6, 5, 5}},  {2, 8, {5, 6, 5}},  {2, 8, {5, 5, 6}},  {2, 6, {0, 0, 0}},
                           {1, 10, {0, 0, 0}}, {1, 11, {9, 9, 9}}, {1, 12, {8, 8, 8}}, {1, 16, {4, 4, 4}}};

/// A block of two colours, the significance of its texels, and the error metric.
struct Block2 {
    glm::dvec3 colour[2];
    std::uint32_t second = 0;
    std::array<double, 16> weight;
    bool isSigned = false;
    EncodeOptions options;

    int colourOf(int t) const { return static_cast<int>(second >> t & 1); }
    double metric(double x) const {
        if (options.hdrMetric != HdrMetric::Log) return x;
        return std::copysign(std::log1p(std::abs(x) / static_cast<double>(options.hdrScale)) / std::log(2.0), x);
    }
    double errorOf(int which, int c, double x) const {
        const double target = colour[which][c];
        double miss = metric(x) - metric(target);
        if (options.hdrMetric == HdrMetric::Relative) miss /= std::abs(target) + static_cast<double>(options.hdrScale);
        return static_cast<double>(options.channelWeights[static_cast<std::size_t>(c)]) * miss * miss;
    }
};

Encoded encoded(const Block2& block) {
    const TexelImage image = imageOf(4, 4, [&](int x, int y) { return glm::vec4(block.colour[block.colourOf(4 * y + x)], 1); });
    formats::Image<float> significance(4, 4);
    for (int t = 0; t < 16; ++t) significance.at(t % 4, t / 4) = static_cast<float>(block.weight[static_cast<std::size_t>(t)]);
    return encode(block.isSigned ? PixelFormat::Bc6hSf16 : PixelFormat::Bc6hUf16, image, block.options, significance.view());
}
double errorOf(const Block2& block, const TexelImage& decoded) {
    double sum = 0;
    for (int t = 0; t < 16; ++t)
        for (int c = 0; c < 3; ++c)
            sum += block.weight[static_cast<std::size_t>(t)] *
                   block.errorOf(block.colourOf(t), c, static_cast<double>(decoded.at(t % 4, t / 4)[c]));
    return sum;
}

/// Exhaustive search over the blocks of the format with an error below a limit.
class BruteForce {
public:
    BruteForce(const Block2& block, double limit) : block_(block), limit_(limit) {
        for (int which = 0; which < 2; ++which)
            for (int c = 0; c < 3; ++c) {
                std::vector<double>& table = error_[which][c];
                table.assign(1 << 17, INFINITY);
                for (int v = block.isSigned ? -32767 : 0; v <= (block.isSigned ? 32767 : 65535); ++v) {
                    const int magnitude = block.isSigned ? (std::abs(v) * 31) >> 5 : (v * 31) >> 6;
                    const auto x = static_cast<double>(floatFromHalf(static_cast<std::uint16_t>(magnitude)));
                    table[static_cast<std::size_t>(v + kZero)] = block.errorOf(which, c, v < 0 ? -x : x);
                    int& nearest = nearest_[which][c];
                    if (table[static_cast<std::size_t>(v + kZero)] < table[static_cast<std::size_t>(nearest + kZero)]) nearest = v;
                }
            }
    }
    /// Returns the least error, or the limit if none is below it.
    double run() {
        // Channels whose colours are far apart cost the most, and leave others the least.
        std::sort(order_.begin(), order_.end(), [&](int a, int b) { return apart(a) > apart(b); });
        for (const Mode& mode : kModes) {
            prepare(mode);
            for (int p = 0; p < (mode.regions == 2 ? 32 : 1); ++p) tryPartition(mode, p);
        }
        return limit_;
    }

private:
    static constexpr int kZero = 32768;
    double apart(int c) const { return block_.errorOf(0, c, block_.colour[1][c]) + block_.errorOf(1, c, block_.colour[0][c]); }
    struct Pair {
        int first, second;
        double error;
    };
    /// The three sorts of texels of a region, by the constraint on their index: first colour, second colour, anchor.
    struct Region {
        std::array<double, 3> weight{};
        int anchorColour = 0;
    };
    /// The pairs of ends of each channel, for one index of each sort.
    struct Indexed {
        std::array<std::vector<Pair>, 3> pairs;
        std::array<double, 3> least = {INFINITY, INFINITY, INFINITY};
        double sum = 0;  ///< error of the channels that were searched
        double total() const { return least[0] + least[1] + least[2]; }
    };

    void prepare(const Mode& mode) {
        count_ = 1 << mode.bits;
        value_.resize(static_cast<std::size_t>(count_));
        for (int code = 0; code < count_; ++code) {
            int v = code;
            if (block_.isSigned) {
                const int whole = code < count_ / 2 ? code : code - count_, magnitude = std::abs(whole);
                v = magnitude == 0                            ? 0
                    : mode.bits == 16                         ? magnitude
                    : magnitude >= (1 << (mode.bits - 1)) - 1 ? 0x7FFF
                                                              : ((magnitude << 15) + 0x4000) >> (mode.bits - 1);
                v = whole < 0 ? -v : v;
            } else if (mode.bits < 15 && code > 0) {
                v = code == count_ - 1 ? 0xFFFF : ((code << 16) + 0x8000) >> mode.bits;
            }
            value_[static_cast<std::size_t>(code)] = v;
        }
        // A most negative code of sixteen bits means minus infinity: no encoder may write it.
        isForbidden_ = block_.isSigned && mode.bits == 16 ? count_ / 2 : -1;
    }
    bool reaches(int from, int to, int bits) const {
        if (bits == 0) return true;
        const int away = (to - from + (1 << (bits - 1))) & (count_ - 1);
        return away < 1 << bits;
    }

    Region regionOf(const Mode& mode, int partition, int which) const {
        Region region;
        for (int t = 0; t < 16; ++t) {
            if (compress::regionOf(mode.regions, partition, t) != which) continue;
            const bool isAnchor = t == anchorOf(mode.regions, partition, which);
            if (isAnchor) region.anchorColour = block_.colourOf(t);
            region.weight[static_cast<std::size_t>(isAnchor ? 2 : block_.colourOf(t))] += block_.weight[static_cast<std::size_t>(t)];
        }
        return region;
    }

    /// Returns, for every index of each sort, all pairs of ends with an error below the limit.
    std::vector<Indexed> search(const Mode& mode, const Region& region, bool isFirst, double limit) const {
        const int bits = mode.regions == 1 ? 4 : 3, indices = 1 << bits;
        std::vector<Indexed> found(static_cast<std::size_t>(indices * indices * indices / 2));
        for (const int c : order_) {
            const auto channel = static_cast<std::size_t>(c);
            double before = INFINITY;
            for (const Indexed& at : found) before = std::min(before, at.sum);
            if (!(before < limit)) break;
            const std::vector<double>* tables[3] = {&error_[0][c], &error_[1][c], &error_[region.anchorColour][c]};
            std::array<int, 3> low, high;
            for (std::size_t s = 0; s < 3; ++s) {
                const int nearest = nearest_[s < 2 ? s : static_cast<std::size_t>(region.anchorColour)][c];
                rangeBelow(*tables[s], nearest, region.weight[s], limit - before, low[s], high[s]);
            }
            const int deltaBits = mode.deltaBits[channel];
            for (int x = 0; x < count_; ++x) {
                if (x == isForbidden_) continue;
                // Ends of the second region are at most twice a delta apart.
                const int reach = deltaBits == 0 ? count_ : isFirst ? 1 << (deltaBits - 1) : (1 << deltaBits) - 1;
                const int steps = std::min(2 * reach + 1, count_);
                if (steps < count_ && isFarFrom(x, reach, region, low, high)) continue;
                for (int step = 0; step < steps; ++step) {
                    const int y = deltaBits == 0 ? step : (x - reach + step) & (count_ - 1);
                    if (y == isForbidden_ || (isFirst && !reaches(x, y, deltaBits))) continue;
                    const int a = value_[static_cast<std::size_t>(x)], b = value_[static_cast<std::size_t>(y)];
                    const int least = std::min(a, b), most = std::max(a, b);
                    bool meets = true;
                    for (std::size_t s = 0; s < 3; ++s) meets &= !(region.weight[s] > 0) || (least <= high[s] && most >= low[s]);
                    if (meets) addIndices(region, tables, a, b, x, y, bits, limit, channel, found);
                }
            }
            for (Indexed& at : found) at.sum += at.least[channel];
        }
        return found;
    }
    /// Returns true if no ends within reach can bring some sort of texels below the limit. Across the gap of the circle of codes any value
    /// is possible.
    bool isFarFrom(int x, int reach, const Region& region, const std::array<int, 3>& low, const std::array<int, 3>& high) const {
        const int mask = count_ - 1, rank = block_.isSigned ? (x + count_ / 2) & mask : x;
        if (rank < reach || rank + reach >= count_) return false;
        const int least = value_[static_cast<std::size_t>((x - reach) & mask)], most = value_[static_cast<std::size_t>((x + reach) & mask)];
        for (std::size_t s = 0; s < 3; ++s)
            if (region.weight[s] > 0 && (most < low[s] || least > high[s])) return true;
        return false;
    }
    /// Returns the interpolated values with an error below the limit. Errors rise on both sides of the least one.
    void rangeBelow(const std::vector<double>& table, int nearest, double weight, double limit, int& low, int& high) const {
        const auto isBelow = [&](int v) {
            return v >= (block_.isSigned ? -32767 : 0) && v <= (block_.isSigned ? 32767 : 65535) &&
                   weight * table[static_cast<std::size_t>(v + kZero)] < limit;
        };
        low = nearest + 1, high = nearest;
        while (isBelow(low - 1)) --low;
        while (isBelow(high + 1)) ++high;
    }
    static void addIndices(const Region& region, const std::vector<double>* const* tables, int a, int b, int x, int y, int bits,
                           double limit, std::size_t channel, std::vector<Indexed>& found) {
        const int indices = 1 << bits;
        double error[3][16];
        for (int i = 0; i < indices; ++i) {
            const int w = weightOf(bits, i), v = (a * (64 - w) + b * w + 32) >> 6;
            for (std::size_t s = 0; s < 3; ++s) error[s][i] = region.weight[s] * (*tables[s])[static_cast<std::size_t>(v + kZero)];
        }
        // A sort without texels needs one index only.
        const int last[3] = {region.weight[0] > 0 ? indices : 1, region.weight[1] > 0 ? indices : 1,
                             region.weight[2] > 0 ? indices / 2 : 1};
        for (int i = 0; i < last[0]; ++i) {
            if (!(error[0][i] < limit)) continue;
            for (int j = 0; j < last[1]; ++j) {
                if (!(error[0][i] + error[1][j] < limit)) continue;
                for (int k = 0; k < last[2]; ++k) {
                    const double sum = error[0][i] + error[1][j] + error[2][k];
                    Indexed& at = found[static_cast<std::size_t>((i * indices + j) * (indices / 2) + k)];
                    if (!(at.sum + sum < limit)) continue;
                    if (bits == 3) at.pairs[channel].push_back({x, y, sum});  // with one region nothing else asks for them
                    at.least[channel] = std::min(at.least[channel], sum);
                }
            }
        }
    }

    void tryPartition(const Mode& mode, int partition) {
        const std::vector<Indexed> first = search(mode, regionOf(mode, partition, 0), true, limit_);
        double leastFirst = INFINITY;
        for (const Indexed& a : first) leastFirst = std::min(leastFirst, a.total());
        if (mode.regions == 1) {
            limit_ = std::min(limit_, leastFirst);
            return;
        }
        if (!(leastFirst < limit_)) return;
        const std::vector<Indexed> second = search(mode, regionOf(mode, partition, 1), false, limit_ - leastFirst);
        for (const Indexed& a : first)
            for (const Indexed& b : second)
                if (a.total() + b.total() < limit_) limit_ = std::min(limit_, both(mode, a, b));
    }
    /// Combines the ends of both regions: the first end of region 0 is the base of all deltas.
    double both(const Mode& mode, const Indexed& a, const Indexed& b) const {
        double total = 0;
        for (std::size_t c = 0; c < 3; ++c) {
            double least = INFINITY;
            for (const Pair& one : a.pairs[c])
                for (const Pair& other : b.pairs[c])
                    if (one.error + other.error < least && reaches(one.first, other.first, mode.deltaBits[c]) &&
                        reaches(one.first, other.second, mode.deltaBits[c]))
                        least = one.error + other.error;
            total += least;
        }
        return total;
    }

    const Block2& block_;
    double limit_;
    std::vector<double> error_[2][3];  ///< error of every interpolated value
    int nearest_[2][3] = {};           ///< value with the least error
    std::array<int, 3> order_ = {0, 1, 2};
    std::vector<int> value_;
    int count_ = 0, isForbidden_ = -1;
};

/// Moves the second colour to just within or just beyond the reach of the deltas of some mode, where the order of the ends matters.
void placeAtReach(Random& random, Block2& block) {
    constexpr std::array<int, 4> kReaches = {8, 128 * 16, 256 * 32, 16 * 32};
    const int reach = kReaches[static_cast<std::size_t>(random.below(4))];
    for (int c = 0; c < 3; ++c) {
        const float first = static_cast<float>(block.colour[0][c]);
        const int half = halfFromFloat(std::abs(first)), away = reach * 31 / (block.isSigned ? 32 : 64) + random.below(3) - 1;
        const int other = std::clamp(half + (random.below(2) ? away : -away), 0, 0x7BFF);
        const auto moved = static_cast<double>(floatFromHalf(static_cast<std::uint16_t>(other)));
        block.colour[1][c] = std::copysign(moved, static_cast<double>(first));
    }
}

/// Returns two colours of any levels, similar ones, greys, zeros and bright light sources, in patterns that match a partition, nearly
/// match, or do not.
Block2 twoLights(Random& random, int number, bool isSigned) {
    Block2 block;
    block.isSigned = isSigned;
    block.options = effort(9);
    constexpr std::array kMetrics = {HdrMetric::Log, HdrMetric::Linear, HdrMetric::Relative};
    block.options.hdrMetric = kMetrics[static_cast<std::size_t>(number % 3)];
    if (number % 5 == 4) block.options.channelWeights = {1, 0.25f, 2, 1};
    const double level = std::exp2(static_cast<double>(random.unit()) * 14 - 6);
    constexpr std::array<double, 6> kExtremes = {0, 65504, 0x1p-24, 1, 0.5, 60000};
    for (int c = 0; c < 3; ++c)
        for (int which = 0; which < 2; ++which) {
            double x = level * static_cast<double>(random.unit());
            if (number % 4 == 1) x = level * (1 + static_cast<double>(c) * 0.3 + which * 0.2 * static_cast<double>(random.unit()));
            if (number % 4 == 2) x = level * (which ? 1 : 8 * static_cast<double>(random.unit()));
            if (number % 8 == 3) x = kExtremes[static_cast<std::size_t>(random.below(6))];
            if (isSigned && random.below(3) == 0) x = -x;
            block.colour[which][c] = static_cast<double>(static_cast<float>(x));
        }
    if (number % 8 == 7) placeAtReach(random, block);
    block.second = random.bits() & 0xFFFF;
    if (number % 3 != 2) block.second = kTwoRegions[static_cast<std::size_t>(random.below(64))];
    if (number % 3 == 1) block.second ^= 1u << random.below(16);
    if (block.second == 0 || block.second == 0xFFFF) block.second = 0x0F3C;
    block.weight.fill(1);
    if (number % 2)
        for (double& weight : block.weight) weight = 0.25 * random.below(8);
    if (number % 16 == 7) block.weight[0] = 0.0625;
    return block;
}

struct Above {
    double worst = 0, mean = 0, seconds = 0;
    int count = 0, exact = 0;
};
/// Compares the RMS errors of blocks with the least ones.
void compare(const Block2& block, Above& above, const std::string& what) {
    double weight = 0;
    for (const double w : block.weight) weight += w;
    if (!(weight > 0)) return;
    const auto before = std::chrono::steady_clock::now();
    const TexelImage decoded = encoded(block).decoded;
    above.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
    const double found = errorOf(block, decoded);
    const double least = found > 0 ? BruteForce(block, found).run() : 0;
    const double away = (std::sqrt(found) - std::sqrt(least)) / std::sqrt(3 * weight);
    above.worst = std::max(above.worst, away);
    above.mean += away;
    above.count += 1;
    above.exact += found <= least * (1 + 1e-7);
    EXPECT_LE(found, least * (1 + 1e-7)) << what << ": " << away;
}

/// extremes  includes blocks that take the exhaustive search half a minute each
void compareMany(int count, bool extremes, std::uint64_t seed) {
    for (const bool isSigned : {false, true}) {
        Random random(seed);
        Above above[3];
        for (int i = 0; i < count; ++i) {
            const Block2 block = twoLights(random, i, isSigned);
            if (extremes || i % 8 != 3) compare(block, above[i % 3], (isSigned ? "signed " : "unsigned ") + std::to_string(i));
        }
        for (int metric = 0; metric < 3; ++metric)
            std::cout << (isSigned ? "signed" : "unsigned") << " metric " << metric << ": " << above[metric].count << " blocks, exact "
                      << above[metric].exact << ", mean " << above[metric].mean / above[metric].count << ", worst " << above[metric].worst
                      << ", ms/block " << 1e3 * above[metric].seconds / above[metric].count << "\n";
    }
}

TEST(TwoColoursBc6h, EqualEveryBlockOfTheFormat) {
    compareMany(24, false, 98);
}
TEST(TwoColoursBc6hSoak, EqualEveryBlockOfTheFormat) {
    const char* asked = std::getenv("LIGHTCOOK_TWO_COLOURS");
    compareMany(asked ? std::atoi(asked) : 400, true, 99);
}

}  // namespace
}  // namespace lightcook::compress::test

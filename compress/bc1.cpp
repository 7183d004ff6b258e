// BC1, and the colour of BC3: two colours of 5, 6 and 5 bits, four values on the line between them, or (BC1 only) three.
// The fourth index of the three-colour layout, black to some readers and transparent to others, is never used.
#include <algorithm>
#include <cmath>

#include "compress/block.h"

namespace compress {
namespace {

using Plane = std::array<float, kTexelCount>;

/// Colours in [0, 1], each channel scaled by the root of its weight, so that plain squared distance is the error.
struct Colours {
    alignas(64) std::array<Plane, 3> value;
    alignas(64) Plane weight;
    std::array<float, 3> scale;  ///< root of the channel's weight
};

struct Rgb {
    float c[3];
};

constexpr std::array<int, 3> kLargestCode = {31, 63, 31};

struct Candidate {
    std::array<int, 3> first{}, second{};  ///< 565 codes
    bool threeColours = false;
    float error = INFINITY;
};

float sum16(const Plane& terms) {
    float partial[8];
    for (std::size_t i = 0; i < 8; ++i) partial[i] = terms[i] + terms[i + 8];
    return ((partial[0] + partial[4]) + (partial[2] + partial[6])) + ((partial[1] + partial[5]) + (partial[3] + partial[7]));
}

Rgb valueOf(const Colours& colours, const std::array<int, 3>& code) {
    Rgb value;
    for (std::size_t c = 0; c < 3; ++c) value.c[c] = colours.scale[c] * static_cast<float>(code[c]) / static_cast<float>(kLargestCode[c]);
    return value;
}

std::array<int, 3> nearestCode(const Colours& colours, const Rgb& value) {
    std::array<int, 3> code{};
    for (std::size_t c = 0; c < 3; ++c) {
        const float largest = static_cast<float>(kLargestCode[c]);
        const float unit = colours.scale[c] > 0 ? value.c[c] / colours.scale[c] * largest : 0.0f;
        code[c] = static_cast<int>(std::clamp(unit, 0.0f, largest) + 0.5f);
    }
    return code;
}

/// Places every texel at the nearest of the steps + 1 values from a to b; positions in [0, 1]. Returns the error.
float project(const Colours& colours, const Rgb& a, const Rgb& b, float steps, Plane& position) {
    float axis[3], lengthSquared = 0;
    for (int c = 0; c < 3; ++c) {
        axis[c] = b.c[c] - a.c[c];
        lengthSquared += axis[c] * axis[c];
    }
    const float scale = lengthSquared > 0 ? steps / lengthSquared : 0.0f, step = 1 / steps;
    alignas(64) Plane terms;
    for (std::size_t t = 0; t < kTexelCount; ++t) {
        const float r = colours.value[0][t] - a.c[0], g = colours.value[1][t] - a.c[1], bl = colours.value[2][t] - a.c[2];
        float along = (r * axis[0] + g * axis[1] + bl * axis[2]) * scale;
        along = along < 0 ? 0 : along;
        along = along > steps ? steps : along;
        const float nearest = static_cast<float>(static_cast<int>(along + 0.5f)) * step;
        const float dr = r - nearest * axis[0], dg = g - nearest * axis[1], db = bl - nearest * axis[2];
        terms[t] = colours.weight[t] * (dr * dr + dg * dg + db * db);
        position[t] = nearest;
    }
    return sum16(terms);
}

bool improve(const Colours& colours, const std::array<int, 3>& first, const std::array<int, 3>& second, bool threeColours, Candidate& best,
             Plane& position) {
    Plane trial;
    const float error = project(colours, valueOf(colours, first), valueOf(colours, second), threeColours ? 2.0f : 3.0f, trial);
    if (!(error < best.error)) return false;
    best = {first, second, threeColours, error};
    position = trial;
    return true;
}

/// Ends of least squares for texels placed at `position`; false where the positions cannot tell them apart.
bool leastSquares(const Colours& colours, const Plane& position, Rgb& a, Rgb& b) {
    float aa = 0, ab = 0, bb = 0;
    Rgb sumA{}, sumB{};
    for (std::size_t t = 0; t < kTexelCount; ++t) {
        const float v = position[t], u = 1 - v, w = colours.weight[t];
        aa += w * u * u;
        ab += w * u * v;
        bb += w * v * v;
        for (std::size_t c = 0; c < 3; ++c) {
            sumA.c[c] += w * u * colours.value[c][t];
            sumB.c[c] += w * v * colours.value[c][t];
        }
    }
    const float determinant = aa * bb - ab * ab;
    if (!(determinant > 1e-6f * (aa + bb) * (aa + bb))) return false;
    for (int c = 0; c < 3; ++c) {
        a.c[c] = (bb * sumA.c[c] - ab * sumB.c[c]) / determinant;
        b.c[c] = (aa * sumB.c[c] - ab * sumA.c[c]) / determinant;
    }
    return true;
}

void refit(const Colours& colours, int iterations, Candidate& best, Plane& position) {
    for (int i = 0; i < iterations; ++i) {
        Rgb a, b;
        if (!leastSquares(colours, position, a, b)) return;
        if (!improve(colours, nearestCode(colours, a), nearestCode(colours, b), best.threeColours, best, position)) return;
    }
}

/// Weighted mean and principal axis (by power iteration: a few steps from the longest row are enough for a start).
void principalAxis(const Colours& colours, Rgb& mean, Rgb& axis) {
    float total = 0;
    mean = {};
    for (std::size_t t = 0; t < kTexelCount; ++t) {
        total += colours.weight[t];
        for (std::size_t c = 0; c < 3; ++c) mean.c[c] += colours.weight[t] * colours.value[c][t];
    }
    for (float& value : mean.c) value /= total;
    float m[3][3] = {};
    for (std::size_t t = 0; t < kTexelCount; ++t) {
        const float d[3] = {colours.value[0][t] - mean.c[0], colours.value[1][t] - mean.c[1], colours.value[2][t] - mean.c[2]};
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) m[i][j] += colours.weight[t] * d[i] * d[j];
    }
    const int longest = m[0][0] >= m[1][1] ? (m[0][0] >= m[2][2] ? 0 : 2) : (m[1][1] >= m[2][2] ? 1 : 2);
    axis = {{m[longest][0], m[longest][1], m[longest][2]}};
    for (int iteration = 0; iteration < 5; ++iteration) {
        Rgb next{};
        float largest = 0;
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) next.c[i] += m[i][j] * axis.c[j];
            largest = std::max(largest, std::abs(next.c[i]));
        }
        if (!(largest > 1e-30f)) return;
        for (int i = 0; i < 3; ++i) axis.c[i] = next.c[i] / largest;
    }
}

/// Cluster fit: texels in order along the axis, every way of cutting them into runs for the `steps` + 1 values, least squares for each.
/// Source: Simon Brown, squish; the sums over a run come from prefix sums.
class ClusterFit {
public:
    ClusterFit(const Colours& colours, const Rgb& axis) {
        std::array<int, kTexelCount> order;
        Plane along;
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            order[t] = static_cast<int>(t);
            along[t] = colours.value[0][t] * axis.c[0] + colours.value[1][t] * axis.c[1] + colours.value[2][t] * axis.c[2];
        }
        std::stable_sort(order.begin(), order.end(),
                         [&](int i, int j) { return along[static_cast<std::size_t>(i)] < along[static_cast<std::size_t>(j)]; });
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            const auto source = static_cast<std::size_t>(order[t]);
            sums_[t + 1].weight = sums_[t].weight + colours.weight[source];
            for (std::size_t c = 0; c < 3; ++c)
                sums_[t + 1].value.c[c] = sums_[t].value.c[c] + colours.weight[source] * colours.value[c][source];
        }
    }

    /// Calls visit(a, b) with the least-squares ends of each clustering.
    template <class Visit>
    void four(Visit visit) const {
        for (std::size_t i = 0; i <= kTexelCount; ++i)
            for (std::size_t j = i; j <= kTexelCount; ++j)
                for (std::size_t k = j; k <= kTexelCount; ++k) {
                    const std::size_t cuts[5] = {0, i, j, k, kTexelCount};
                    solve(cuts, 3, visit);
                }
    }
    template <class Visit>
    void three(Visit visit) const {
        for (std::size_t i = 0; i <= kTexelCount; ++i)
            for (std::size_t j = i; j <= kTexelCount; ++j) {
                const std::size_t cuts[4] = {0, i, j, kTexelCount};
                solve(cuts, 2, visit);
            }
    }

private:
    struct Sum {
        float weight = 0;
        Rgb value{};
    };
    template <class Visit>
    void solve(const std::size_t* cuts, int steps, Visit visit) const {
        float aa = 0, ab = 0, bb = 0;
        Rgb sumA{}, sumB{};
        for (int s = 0; s <= steps; ++s) {
            const float v = static_cast<float>(s) / static_cast<float>(steps), u = 1 - v;
            const Sum &from = sums_[cuts[s]], &to = sums_[cuts[s + 1]];
            const float weight = to.weight - from.weight;
            aa += weight * u * u;
            ab += weight * u * v;
            bb += weight * v * v;
            for (int c = 0; c < 3; ++c) {
                const float value = to.value.c[c] - from.value.c[c];
                sumA.c[c] += u * value;
                sumB.c[c] += v * value;
            }
        }
        const float determinant = aa * bb - ab * ab;
        if (!(determinant > 1e-6f * (aa + bb) * (aa + bb))) return;
        Rgb a, b;
        float gain = 0;  // the squared error is a constant less this
        for (int c = 0; c < 3; ++c) {
            a.c[c] = (bb * sumA.c[c] - ab * sumB.c[c]) / determinant;
            b.c[c] = (aa * sumB.c[c] - ab * sumA.c[c]) / determinant;
            gain += a.c[c] * sumA.c[c] + b.c[c] * sumB.c[c];
        }
        visit(a, b, gain);
    }

    std::array<Sum, kTexelCount + 1> sums_;
};

/// Best of `keep` clusterings by their ideal error, each then rounded and refitted.
void clusterFit(const Colours& colours, const Rgb& axis, bool threeColours, std::size_t keep, Candidate& best, Plane& position) {
    struct Kept {
        float gain = -INFINITY;
        Rgb a{}, b{};
    };
    std::array<Kept, 16> kept;
    const auto visit = [&](const Rgb& a, const Rgb& b, float gain) {
        if (!(gain > kept[keep - 1].gain)) return;
        std::size_t place = keep - 1;
        for (; place > 0 && gain > kept[place - 1].gain; --place) kept[place] = kept[place - 1];
        kept[place] = {gain, a, b};
    };
    const ClusterFit clusters(colours, axis);
    if (threeColours)
        clusters.three(visit);
    else
        clusters.four(visit);
    for (std::size_t i = 0; i < keep && kept[i].gain > -INFINITY; ++i) {
        Candidate candidate;
        Plane trial;
        improve(colours, nearestCode(colours, kept[i].a), nearestCode(colours, kept[i].b), threeColours, candidate, trial);
        refit(colours, 3, candidate, trial);
        if (candidate.error < best.error) {
            best = candidate;
            position = trial;
        }
    }
}

/// Single steps of each of the six codes, and of a channel of both ends together, as long as one helps.
void descend(const Colours& colours, int passes, Candidate& best, Plane& position) {
    constexpr std::array<std::array<int, 2>, 8> kSteps = {{{-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, 1}, {-1, 1}, {1, -1}}};
    for (int pass = 0; pass < passes; ++pass) {
        bool improved = false;
        for (std::size_t c = 0; c < 3; ++c)
            for (const auto& step : kSteps) {
                auto first = best.first, second = best.second;
                first[c] = std::clamp(first[c] + step[0], 0, kLargestCode[c]);
                second[c] = std::clamp(second[c] + step[1], 0, kLargestCode[c]);
                improved |= improve(colours, first, second, best.threeColours, best, position);
            }
        if (!improved) return;
    }
}

/// One colour: the pair of codes whose value at `share` (a third or a half of the way) is nearest, channel by channel.
void fitConstant(const Colours& colours, const Rgb& colour, bool mayUseThree, Candidate& best, Plane& position) {
    for (const bool threeColours : {false, true}) {
        if (threeColours && !mayUseThree) continue;
        const double share = threeColours ? 0.5 : 1.0 / 3.0;
        std::array<int, 3> first{}, second{};
        for (std::size_t c = 0; c < 3; ++c) {
            const int largest = kLargestCode[c];
            const double target = colours.scale[c] > 0 ? static_cast<double>(colour.c[c] / colours.scale[c]) * largest : 0;
            double bestMiss = INFINITY;
            for (int a = 0; a <= largest; ++a) {
                const int b = static_cast<int>(std::clamp((target - (1 - share) * a) / share, 0.0, static_cast<double>(largest)) + 0.5);
                const double miss = std::abs((1 - share) * a + share * b - target);
                // Of equal ones the pair closest together: hardware rounds the interpolation in its own way.
                if (miss < bestMiss - 1e-9 || (miss < bestMiss + 1e-9 && std::abs(a - b) < std::abs(first[c] - second[c]))) {
                    bestMiss = std::min(miss, bestMiss);
                    first[c] = a;
                    second[c] = b;
                }
            }
        }
        improve(colours, first, second, threeColours, best, position);
    }
}

void fitLine(const Colours& colours, int effort, bool mayUseThree, Candidate& best, Plane& position) {
    Rgb mean, axis;
    principalAxis(colours, mean, axis);
    float low = INFINITY, high = -INFINITY, lengthSquared = 0;
    for (const float a : axis.c) lengthSquared += a * a;
    for (std::size_t t = 0; t < kTexelCount; ++t) {
        if (!(colours.weight[t] > 0)) continue;
        float along = 0;
        for (std::size_t c = 0; c < 3; ++c) along += (colours.value[c][t] - mean.c[c]) * axis.c[c];
        low = std::min(low, along);
        high = std::max(high, along);
    }
    Rgb a, b;
    for (int c = 0; c < 3; ++c) {
        a.c[c] = lengthSquared > 0 ? mean.c[c] + axis.c[c] * (low / lengthSquared) : mean.c[c];
        b.c[c] = lengthSquared > 0 ? mean.c[c] + axis.c[c] * (high / lengthSquared) : mean.c[c];
    }
    improve(colours, nearestCode(colours, a), nearestCode(colours, b), false, best, position);
    refit(colours, effort == 0 ? 1 : effort < 3 ? 2 : 4, best, position);
    if (effort >= 6) clusterFit(colours, axis, false, effort >= 9 ? 16 : effort >= 8 ? 6 : effort >= 7 ? 3 : 1, best, position);
    if (effort >= 4) descend(colours, effort >= 8 ? 8 : effort >= 5 ? 2 : 1, best, position);
    if (mayUseThree && effort >= 3) {
        Candidate three;
        Plane threePosition;
        improve(colours, nearestCode(colours, a), nearestCode(colours, b), true, three, threePosition);
        refit(colours, 3, three, threePosition);
        if (effort >= 7) clusterFit(colours, axis, true, effort >= 9 ? 8 : 2, three, threePosition);
        if (effort >= 5) descend(colours, effort >= 8 ? 8 : 1, three, threePosition);
        if (three.error < best.error) {
            best = three;
            position = threePosition;
        }
    }
}

std::uint32_t packed565(const std::array<int, 3>& code) {
    return static_cast<std::uint32_t>(code[0] << 11 | code[1] << 5 | code[2]);
}

void pack(const Candidate& fitted, const Plane& position, bool orderTellsLayout, std::byte* out) {
    std::uint32_t first = packed565(fitted.first), second = packed565(fitted.second);
    // A rising pair means three colours; equal ones do too, but then every index below 3 is the same colour.
    const bool swap = orderTellsLayout && (fitted.threeColours ? first > second : first < second);
    const bool equal = first == second;
    if (swap) std::swap(first, second);
    const int steps = fitted.threeColours ? 2 : 3;
    BitWriter bits;
    bits.put(first, 16);
    bits.put(second, 16);
    for (std::size_t t = 0; t < kTexelCount; ++t) {
        int step = static_cast<int>(position[t] * static_cast<float>(steps) + 0.5f);
        if (swap) step = steps - step;
        if (equal) step = 0;
        bits.put(static_cast<std::uint32_t>(step == 0 ? 0 : step == steps ? 1 : step + 1), 2);
    }
    bits.store(out, 8);
}

void encodeColour(const Block& block, const EncodeOptions& options, bool isBc1, std::byte* out) {
    Colours colours;
    colours.weight = block.significance;
    bool constant = true;
    std::size_t firstSignificant = kTexelCount;
    for (std::size_t t = kTexelCount; t-- > 0;)
        if (block.significance[t] > 0) firstSignificant = t;
    for (std::size_t c = 0; c < 3; ++c) {
        colours.scale[c] = std::sqrt(options.channelWeights[c]);
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            colours.value[c][t] = colours.scale[c] * block.channel[c][t];
            constant &= !(block.significance[t] > 0) || block.channel[c][t] == block.channel[c][firstSignificant];
        }
    }
    Candidate best;
    Plane position{};
    if (constant)
        fitConstant(colours, {{colours.value[0][firstSignificant], colours.value[1][firstSignificant], colours.value[2][firstSignificant]}},
                    isBc1, best, position);
    else
        fitLine(colours, block.insignificant ? 0 : options.effort, isBc1, best, position);
    pack(best, position, isBc1, out);
}

}  // namespace

void encodeBc1(std::span<const Block> blocks, const EncodeOptions& options, std::byte* out) {
    for (const Block& block : blocks) {
        encodeColour(block, options, true, out);
        out += 8;
    }
}

void encodeBc3(std::span<const Block> blocks, const EncodeOptions& options, std::byte* out) {
    for (const Block& block : blocks) {
        encodeBc4Channel(block, 3, options.effort, out);
        encodeColour(block, options, false, out + 8);
        out += 16;
    }
}

}  // namespace compress

// BC1: the texels of as many blocks as a vector has lanes, and the error that a pair of endpoints leaves.
//
// Words: values count from the block's first significant texel (the origin), so that blocks far from black lose no digits. A palette has
// kSteps + 1 colours on a line; k is the place of a texel's colour on it, counted in steps from the first endpoint. Codes are the integers
// of 5, 6 and 5 bits.
//
// Every sum has one term per texel and channel weights come in afterwards, so that an assignment costs eleven operations per texel: three
// for the place on the line, three to round it, five for the sums of k, k^2 and k v. From these sums follow the least-squares endpoints
// and, in closed form, the error of any other pair of endpoints with the same assignment (Bc1Line).
#if defined(LIGHTCOOK_COMPRESS_BC1_TEXELS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC1_TEXELS_INL_H_
#undef LIGHTCOOK_COMPRESS_BC1_TEXELS_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC1_TEXELS_INL_H_
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "compress/bc1/search.h"
#include "compress/block/block.h"
#include "compress/block/lanes-inl.h"
#include "compress/block/principal_axis-inl.h"
#include "compress/block/weights-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// A pair of endpoints and its weighted squared error.
template <class D>
struct Bc1Candidate {
    hn::Vec<D> error, code[2][3];

    /// Returns a where the mask is set, else b.
    static HWY_INLINE Bc1Candidate choose(hn::Mask<D> mask, const Bc1Candidate& a, const Bc1Candidate& b) {
        Bc1Candidate chosen;
        chosen.error = hn::IfThenElse(mask, a.error, b.error);
        for (int e = 0; e < 2; ++e)
            for (int c = 0; c < 3; ++c) chosen.code[e][c] = hn::IfThenElse(mask, a.code[e][c], b.code[e][c]);
        return chosen;
    }
};

/// The optimum of one assignment of texels to palette entries: the ideal endpoints, in codes, and the error of any others, which grows by
/// a x^2 + 2 b x y + c y^2 in each channel if the ends differ from the ideal ones by (x, y).
template <class D>
struct Bc1Line {
    hn::Vec<D> a, b, c;
    hn::Vec<D> slope;  ///< b / c: the best second end moves back by so much as the first one moves
    hn::Vec<D> left;   ///< error of the ideal endpoints
    hn::Vec<D> ideal[2][3];
};

template <class D>
class Bc1Texels : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::M;
    using Lanes<D>::set, Lanes<D>::zero, Lanes<D>::clamp;

public:
    using Candidate = Bc1Candidate<D>;
    using Line = Bc1Line<D>;
    /// Places on a line: k = g . v + offset.
    struct Places {
        F g[3], offset;
    };

    F value[3][kTexelCount], weight[kTexelCount];

    explicit Bc1Texels(const EncodeOptions& options) {
        // Not 0, which would divide by zero.
        for (std::size_t c = 0; c < 3; ++c) channelWeight_[c] = std::max(options.channelWeights[c], 1e-12f);
    }

    static constexpr float largestCode(int c) { return c == 1 ? 63.0f : 31.0f; }
    M isConstant() const { return squares_ == zero(); }

    /// Gathers Lanes(d) blocks.
    void load(const Block* const* blocks) {
        const D d;
        HWY_ALIGN float buffer[hn::MaxLanes(D())];
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) buffer[lane] = blocks[lane]->significance[t];
            weight[t] = hn::Load(d, buffer);
            for (std::size_t c = 0; c < 3; ++c) {
                for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) buffer[lane] = blocks[lane]->channel[c][t];
                value[c][t] = hn::Load(d, buffer);
            }
        }
        measure(false);
    }

    /// Prepares the searches. `value` holds colours in [0, 1] before, and colours that count from the origin after.
    /// weightsAreOne  all weights are known to be 1
    void measure(bool weightsAreOne) {
        isUniform_ = weightsAreOne || areUnitWeights(D(), weight);
        if (isUniform_)
            measureWith(Ones{});
        else
            measureWith(Weights{weight});
    }

    /// Projects the texels onto their principal axis.
    /// along      receives the place of each texel on the axis
    /// low, high  receive the outermost places of significant texels
    void project(int iterations, F (&along)[kTexelCount], F& low, F& high) const {
        if (isUniform_)
            projectWith(Ones{}, iterations, along, low, high);
        else
            projectWith(Weights{weight}, iterations, along, low, high);
    }

    /// Assigns each texel to the nearest step between two places on the principal axis, and solves for the endpoints.
    template <int kSteps>
    HWY_INLINE Line lineOf(const F (&along)[kTexelCount], F from, F to) const {
        const F scale = set(static_cast<float>(kSteps)) / hn::Max(to - from, set(1e-12f)), offset = zero() - from * scale;
        const auto place = [&](std::size_t t) { return hn::MulAdd(along[t], scale, offset); };
        return isUniform_ ? lineWith<kSteps>(Ones{}, place) : lineWith<kSteps>(Weights{weight}, place);
    }

    /// Assigns each texel to the nearest palette entry of a candidate, and solves for the endpoints.
    template <int kSteps>
    HWY_INLINE Line lineOf(const Candidate& candidate) const {
        const Places places = placesOf(candidate, set(static_cast<float>(kSteps)));
        const auto place = [&](std::size_t t) { return placeOf(places, t); };
        return isUniform_ ? lineWith<kSteps>(Ones{}, place) : lineWith<kSteps>(Weights{weight}, place);
    }

    /// Returns the error of endpoints with the assignment of a line.
    HWY_INLINE F errorOf(const Line& line, const Candidate& candidate) const {
        F error = line.left;
        for (int c = 0; c < 3; ++c) {
            const F x = candidate.code[0][c] - line.ideal[0][c], y = candidate.code[1][c] - line.ideal[1][c];
            error = hn::MulAdd(set(perSquaredCode(c)), more(line, x, y), error);
        }
        return error;
    }

    /// Rounds the ends of a line to codes. The first end takes the codes on both sides of the ideal one; the second takes the best code for
    /// that first one.
    HWY_INLINE Candidate rounded(const Line& line) const {
        Candidate best;
        best.error = line.left;
        for (int c = 0; c < 3; ++c) {
            const F most = set(largestCode(c)), below = hn::Floor(clamp(line.ideal[0][c], zero(), most));
            const F above = hn::Min(below + set(1.0f), most);
            F highOfBelow, highOfAbove;
            const F errorOfBelow = bestSecond(line, below, c, highOfBelow), errorOfAbove = bestSecond(line, above, c, highOfAbove);
            const M better = errorOfAbove < errorOfBelow;
            best.code[0][c] = hn::IfThenElse(better, above, below);
            best.code[1][c] = hn::IfThenElse(better, highOfAbove, highOfBelow);
            const F least = hn::Min(errorOfAbove, errorOfBelow);
            best.error = hn::MulAdd(set(perSquaredCode(c)), least, best.error);
        }
        return best;
    }

    /// Returns the endpoints with the palette entry nearest to the mean colour one step from the first endpoint. Every multiple of 1 /
    /// kSteps of a code is such an entry between codes side by side.
    template <int kSteps>
    Candidate oneColour() const {
        Candidate candidate;
        candidate.error = squares_;
        for (int c = 0; c < 3; ++c) {
            constexpr float kUnits = static_cast<float>(kSteps);
            const F target = clamp(hn::MulAdd(sum_[c], perTotal_, origin_[c]), zero(), set(1.0f)) * set(kUnits * largestCode(c));
            const F nearest = hn::Round(target), miss = nearest - target;
            // kSteps - 1 parts of the first and one part of the second: floor((n + 1) / 3) or floor(n / 2), halves added against rounding.
            const F first = hn::Floor((nearest + set(kSteps == 3 ? 1.5f : 0.5f)) * set(1 / kUnits));
            candidate.code[0][c] = first;
            candidate.code[1][c] = hn::NegMulAdd(first, set(kUnits - 1), nearest);
            candidate.error = hn::MulAdd(total_ * miss * miss, set(perSquaredCode(c) / (kUnits * kUnits)), candidate.error);
        }
        return candidate;
    }

    /// Returns the error of a candidate, with each texel at its nearest palette entry. The squared distance of a texel from entry k is that
    /// from the first end, less k (2 s - k) squared steps, with s its place on the line.
    template <int kSteps>
    HWY_INLINE F errorOf(const Candidate& candidate) const {
        F fromFirst = squares_, length = zero();
        for (int c = 0; c < 3; ++c) {
            const F mean = hn::MulAdd(sum_[c], perTotal_, origin_[c]), a = candidate.code[0][c] * set(1 / largestCode(c));
            const F d = (candidate.code[1][c] - candidate.code[0][c]) * set(1 / largestCode(c));
            const F weighted = set(channelWeight_[static_cast<std::size_t>(c)]);
            fromFirst = hn::MulAdd(weighted * total_ * (mean - a), mean - a, fromFirst);
            length = hn::MulAdd(weighted * d, d, length);
        }
        const Places places = placesOf(candidate, set(static_cast<float>(kSteps)));
        const F saved = isUniform_ ? savedWith<kSteps>(Ones{}, places) : savedWith<kSteps>(Weights{weight}, places);
        return hn::NegMulAdd(saved, length * set(1.0f / (kSteps * kSteps)), fromFirst);
    }

    /// Returns the line on which a texel's place is its nearest step to a candidate's palette, in steps.
    HWY_INLINE Places placesOf(const Candidate& candidate, F steps) const {
        Places places;
        F length = set(1e-20f);
        for (int c = 0; c < 3; ++c) {
            const F d = (candidate.code[1][c] - candidate.code[0][c]) * set(1 / largestCode(c));
            places.g[c] = set(channelWeight_[static_cast<std::size_t>(c)]) * d;
            length = hn::MulAdd(places.g[c], d, length);
        }
        const F scale = steps / length;
        places.offset = zero();
        for (int c = 0; c < 3; ++c) {
            places.g[c] = places.g[c] * scale;
            const F a = hn::NegMulAdd(candidate.code[0][c], set(1 / largestCode(c)), origin_[c]);
            places.offset = hn::MulAdd(a, places.g[c], places.offset);
        }
        return places;
    }
    HWY_INLINE F placeOf(const Places& places, std::size_t t) const {
        return hn::MulAdd(value[0][t], places.g[0],
                          hn::MulAdd(value[1][t], places.g[1], hn::MulAdd(value[2][t], places.g[2], places.offset)));
    }

private:
    using Ones = UnitWeights<D>;
    using Weights = TexelWeights<D>;

    float perSquaredCode(int c) const { return channelWeight_[static_cast<std::size_t>(c)] / (largestCode(c) * largestCode(c)); }

    template <class W>
    void measureWith(const W& weights) {
        for (int c = 0; c < 3; ++c) {
            F origin = value[c][kTexelCount - 1];
            for (std::size_t t = kTexelCount - 1; t-- > 0;) origin = weights.ifCounts(t, value[c][t], origin);
            origin_[c] = origin;
        }
        total_ = zero();
        for (F& s : sum_) s = zero();
        F products[6];
        for (F& p : products) p = zero();
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            const F x = value[0][t] - origin_[0], y = value[1][t] - origin_[1], z = value[2][t] - origin_[2];
            value[0][t] = x, value[1][t] = y, value[2][t] = z;
            const F wx = weights.times(t, x), wy = weights.times(t, y), wz = weights.times(t, z);
            total_ = total_ + weights.times(t, set(1.0f));
            sum_[0] = sum_[0] + wx, sum_[1] = sum_[1] + wy, sum_[2] = sum_[2] + wz;
            products[0] = hn::MulAdd(wx, x, products[0]);
            products[1] = hn::MulAdd(wx, y, products[1]);
            products[2] = hn::MulAdd(wx, z, products[2]);
            products[3] = hn::MulAdd(wy, y, products[3]);
            products[4] = hn::MulAdd(wy, z, products[4]);
            products[5] = hn::MulAdd(wz, z, products[5]);
        }
        perTotal_ = set(1.0f) / total_;
        constexpr int kRow[6] = {0, 0, 0, 1, 1, 2}, kColumn[6] = {0, 1, 2, 1, 2, 2};
        for (int i = 0; i < 6; ++i) {
            const auto row = static_cast<std::size_t>(kRow[i]), column = static_cast<std::size_t>(kColumn[i]);
            const float scale = std::sqrt(channelWeight_[row]) * std::sqrt(channelWeight_[column]);
            covariance_[i] = hn::NegMulAdd(sum_[row] * perTotal_, sum_[column], products[i]) * set(scale);
        }
        squares_ = hn::Max(covariance_[0], zero()) + hn::Max(covariance_[3], zero()) + hn::Max(covariance_[5], zero());
        // Rounding must not make a varied block constant.
        const F any = products[0] + products[3] + products[5];
        squares_ = hn::IfThenElse(any > zero(), hn::Max(squares_, set(1e-30f)), zero());
    }

    template <class W>
    void projectWith(const W& weights, int iterations, F (&along)[kTexelCount], F& low, F& high) const {
        F axis[3];
        principalAxis<D>(covariance_, iterations, axis);
        for (std::size_t c = 0; c < 3; ++c) axis[c] = axis[c] * set(std::sqrt(channelWeight_[c]));
        low = set(1e30f), high = set(-1e30f);
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            along[t] = hn::MulAdd(value[0][t], axis[0], hn::MulAdd(value[1][t], axis[1], value[2][t] * axis[2]));
            low = weights.ifCounts(t, hn::Min(low, along[t]), low);
            high = weights.ifCounts(t, hn::Max(high, along[t]), high);
        }
    }

    template <int kSteps, class W, class Place>
    HWY_INLINE Line lineWith(const W& weights, const Place& place) const {
        constexpr float kLast = static_cast<float>(kSteps);
        F sumK = zero(), sumKk = zero(), x = zero(), y = zero(), z = zero();
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            const F k = hn::Round(clamp(place(t), zero(), set(kLast)));
            const F weighted = weights.times(t, k);
            sumK = sumK + weighted;
            sumKk = hn::MulAdd(weighted, k, sumKk);
            x = hn::MulAdd(weighted, value[0][t], x);
            y = hn::MulAdd(weighted, value[1][t], y);
            z = hn::MulAdd(weighted, value[2][t], z);
        }
        const F sumKv[3] = {x, y, z};
        Line line;
        const F meanK = sumK * perTotal_, kk = hn::NegMulAdd(meanK, sumK, sumKk);
        const F perKk = hn::IfThenElseZero(kk > total_ * set(1e-5f), set(1.0f) / hn::Max(kk, set(1e-30f)));
        line.left = squares_;
        for (int c = 0; c < 3; ++c) {
            const F kv = hn::NegMulAdd(meanK, sum_[c], sumKv[c]), slope = kv * perKk;
            line.left = hn::NegMulAdd(slope * set(channelWeight_[static_cast<std::size_t>(c)]), kv, line.left);
            const F mean = hn::MulAdd(sum_[c], perTotal_, origin_[c]);
            line.ideal[0][c] = hn::NegMulAdd(slope, meanK, mean) * set(largestCode(c));
            line.ideal[1][c] = hn::MulAdd(slope, set(kLast * largestCode(c)), line.ideal[0][c]);
        }
        line.c = sumKk * set(1 / (kLast * kLast));
        line.b = hn::MulSub(sumK, set(1 / kLast), line.c);
        line.a = total_ - line.b - line.b - line.c;
        line.slope = line.b / hn::Max(line.c, set(1e-30f));
        return line;
    }

    /// Finds the best second end for a first end of channel c. Returns what they add to the error, in squared codes.
    static HWY_INLINE F bestSecond(const Line& line, F first, int c, F& second) {
        const F x = first - line.ideal[0][c];
        second = hn::Round(clamp(hn::NegMulAdd(line.slope, x, line.ideal[1][c]), zero(), set(largestCode(c))));
        return more(line, x, second - line.ideal[1][c]);
    }

    static HWY_INLINE F more(const Line& line, F x, F y) {
        return hn::MulAdd(hn::MulAdd(line.a, x, line.b * y + line.b * y), x, line.c * y * y);
    }

    template <int kSteps, class W>
    HWY_INLINE F savedWith(const W& weights, const Places& places) const {
        F saved = zero();
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            const F s = placeOf(places, t), k = hn::Round(clamp(s, zero(), set(static_cast<float>(kSteps))));
            saved = hn::MulAdd(weights.times(t, k), s + s - k, saved);
        }
        return saved;
    }

    std::array<float, 3> channelWeight_;
    bool isUniform_ = false;
    F origin_[3], sum_[3], total_, perTotal_;
    F covariance_[6];  ///< of colours scaled by the roots of the channel weights: xx xy xz yy yz zz
    F squares_;        ///< weighted squared distances from the mean; 0 only if all significant texels are equal
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif

// BC7, closed forms: moments of a region, its principal axis, least-squares ends in closed form, and their rounding to codes.
//
// With fixed indices the squared error is a quadratic form of the two ends, whose coefficients are sums over the texels. So the ends that
// minimize it, and the error of any rounding of them, follow from these sums without another pass over the texels.
#if defined(LIGHTCOOK_COMPRESS_BC7_CLOSED_FORM_LEAST_SQUARES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC7_CLOSED_FORM_LEAST_SQUARES_INL_H_
#undef LIGHTCOOK_COMPRESS_BC7_CLOSED_FORM_LEAST_SQUARES_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC7_CLOSED_FORM_LEAST_SQUARES_INL_H_
#endif

#include <hwy/highway.h>

#include <cstddef>

#include "compress/bc7/closed_form/texels-inl.h"
#include "compress/bc7/modes.h"
#include "compress/block/lanes-inl.h"
#include "compress/block/principal_axis-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Number of products of two of n channels.
constexpr int productsOf(int channels) {
    return channels * (channels + 1) / 2;
}

/// Weighted moments of the texels of a region: weight, sum of each channel, sum of each product (xx xy .. yy ..).
template <class D, int kChannels>
struct Bc7Moments {
    hn::Vec<D> n, sum[kChannels], product[productsOf(kChannels)];
};

/// Sums of a region over its texels, for the least-squares line of positions k in [0, 1]: k, k^2 and k times each channel.
template <class D, int kChannels>
struct Bc7PositionSums {
    hn::Vec<D> k, kk, kx[kChannels];
};

/// Rounded ends of a region: codes without low bits, low bits, and decoded values in the scale of the texels.
template <class D>
struct Bc7RoundedEnds {
    hn::Vec<D> code[2][4], low[2], value[2][4];
    hn::Vec<D> ideal[2][4];  ///< not rounded, in the scale of the texels
};

template <class D>
class Bc7LeastSquares : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::M;
    using Lanes<D>::set, Lanes<D>::zero, Lanes<D>::clamp, Lanes<D>::select;

public:
    using Ends = Bc7RoundedEnds<D>;
    enum class LowBits { None, PerEnd, PerRegion };

    /// Turns sums of products into sums about the mean, in place. Returns their trace.
    template <int kChannels>
    static HWY_INLINE F centered(const Bc7Moments<D, kChannels>& m, F (&covariance)[productsOf(kChannels)]) {
        const F perN = inverse(m.n);
        F trace = zero();
        for (int i = 0, at = 0; i < kChannels; ++i)
            for (int j = i; j < kChannels; ++j, ++at) {
                covariance[at] = hn::NegMulAdd(m.sum[i] * perN, m.sum[j], m.product[at]);
                if (i == j) {
                    covariance[at] = hn::Max(covariance[at], zero());
                    trace = trace + covariance[at];
                }
            }
        return trace;
    }
    static HWY_INLINE F inverse(F n) { return set(1.0f) / hn::Max(n, set(1e-20f)); }

    /// Finds the dominant eigenvector by power iteration that starts with the row of the largest diagonal element. Its length is 1, or 0 if
    /// the matrix is 0. Returns the eigenvalue.
    template <int kChannels>
    static F axisOf(const F (&covariance)[productsOf(kChannels)], int iterations, F (&axis)[kChannels]) {
        const auto at = [&](int i, int j) {
            return covariance[i <= j ? i * kChannels - i * (i - 1) / 2 + j - i : j * kChannels - j * (j - 1) / 2 + i - j];
        };
        F largest = at(0, 0);
        for (int c = 0; c < kChannels; ++c) axis[c] = at(0, c);
        for (int i = 1; i < kChannels; ++i) {
            const M longer = at(i, i) > largest;
            largest = hn::Max(largest, at(i, i));
            for (int c = 0; c < kChannels; ++c) axis[c] = select(longer, at(i, c), axis[c]);
        }
        const auto times = [&](F(&to)[kChannels]) {
            for (int i = 0; i < kChannels; ++i) {
                to[i] = at(i, 0) * axis[0];
                for (int j = 1; j < kChannels; ++j) to[i] = hn::MulAdd(at(i, j), axis[j], to[i]);
            }
        };
        F next[kChannels];
        for (int iteration = 0; iteration < iterations; ++iteration) {
            F norm = set(1e-30f);
            for (const F& a : axis) norm = hn::Max(norm, hn::Abs(a));
            const F scale = roughInverse<D>(norm);
            for (F& a : axis) a = a * scale;
            times(next);
            for (int c = 0; c < kChannels; ++c) axis[c] = next[c];
        }
        F norm = set(1e-30f), square = zero();
        for (const F& a : axis) norm = hn::Max(norm, hn::Abs(a));
        const F scale = roughInverse<D>(norm);
        for (F& a : axis) {
            a = a * scale;
            square = hn::MulAdd(a, a, square);
        }
        const F unit = set(1.0f) / hn::Sqrt(hn::Max(square, set(1e-20f)));
        for (F& a : axis) a = a * unit;
        times(next);
        F value = zero();
        for (int c = 0; c < kChannels; ++c) value = hn::MulAdd(next[c], axis[c], value);
        return value;
    }

    /// Solves for the ends and rounds them to codes, with the low bits of least error.
    /// n, sum   moments of the region: weight, and sum of each channel
    /// trace    sum of squares about the mean of the region
    /// s        sums for the positions of the texels
    /// channel  number of each channel in the texels
    /// bits     of a code without low bit
    /// Returns the error for the given positions, without the rounding of interpolated values.
    template <int kChannels>
    static F endsOf(const Bc7ScaledTexels<D>& texels, F n, const F* sum, F trace, const Bc7PositionSums<D, kChannels>& s,
                    const std::size_t (&channel)[kChannels], int bits, LowBits lowBits, Ends& out) {
        const F perN = inverse(n), kk = hn::NegMulAdd(s.k * perN, s.k, s.kk);
        const F perKk = hn::IfThenElseZero(kk > n * set(1e-6f), set(1.0f) / hn::Max(kk, set(1e-30f)));
        const F meanK = s.k * perN;
        F error = trace;
        auto& ideal = out.ideal;
        for (int i = 0; i < kChannels; ++i) {
            const F mean = sum[i] * perN, covariance = hn::NegMulAdd(s.k, mean, s.kx[i]), slope = covariance * perKk;
            error = hn::NegMulAdd(slope, covariance, error);
            ideal[0][i] = hn::NegMulAdd(slope, meanK, mean + texels.mean[channel[i]]);
            ideal[1][i] = ideal[0][i] + slope;
        }
        error = hn::Max(error, zero());
        // Coefficients of the quadratic form of the ends' deviations from the ideal ones.
        const F c = s.kk, b = s.k - s.kk, a = n - s.k - b;
        if (lowBits == LowBits::None) {
            F aa = zero(), bb = zero(), ab = zero();
            for (int i = 0; i < kChannels; ++i) {
                for (int e = 0; e < 2; ++e) roundPlain(ideal[e][i], bits, texels, channel[i], out.code[e][i], out.value[e][i]);
                const F first = out.value[0][i] - ideal[0][i], second = out.value[1][i] - ideal[1][i];
                aa = hn::MulAdd(first, first, aa);
                bb = hn::MulAdd(second, second, bb);
                ab = hn::MulAdd(first, second, ab);
            }
            out.low[0] = out.low[1] = zero();
            return hn::MulAdd(a, aa, hn::MulAdd(b + b, ab, hn::MulAdd(c, bb, error)));
        }
        F code[2][2][kChannels], value[2][2][kChannels], miss[2][2][kChannels], own[2][2];
        for (int e = 0; e < 2; ++e)
            for (int low = 0; low < 2; ++low) {
                own[e][low] = zero();
                for (int i = 0; i < kChannels; ++i) {
                    round(ideal[e][i], bits, low, texels, channel[i], code[e][low][i], value[e][low][i]);
                    miss[e][low][i] = value[e][low][i] - ideal[e][i];
                    own[e][low] = hn::MulAdd(miss[e][low][i], miss[e][low][i], own[e][low]);
                }
            }
        F best = set(1e30f);
        out.low[0] = out.low[1] = zero();
        for (int first = 0; first < 2; ++first)
            for (int second = 0; second < 2; ++second) {
                if (lowBits == LowBits::PerRegion && first != second) continue;
                F cross = zero();
                for (int i = 0; i < kChannels; ++i) cross = hn::MulAdd(miss[0][first][i], miss[1][second][i], cross);
                const F trial = hn::MulAdd(a, own[0][first], hn::MulAdd(b + b, cross, c * own[1][second]));
                const M better = trial < best;
                best = hn::Min(best, trial);
                out.low[0] = select(better, set(static_cast<float>(first)), out.low[0]);
                out.low[1] = select(better, set(static_cast<float>(second)), out.low[1]);
            }
        for (int e = 0; e < 2; ++e) {
            const M high = out.low[e] > zero();
            for (int i = 0; i < kChannels; ++i) {
                out.code[e][i] = select(high, code[e][1][i], code[e][0][i]);
                out.value[e][i] = select(high, value[e][1][i], value[e][0][i]);
            }
        }
        return error + best;
    }

    /// Rounds an end to the nearest code with this low bit.
    static HWY_INLINE void round(F ideal, int bits, int low, const Bc7ScaledTexels<D>& texels, std::size_t channel, F& code, F& value) {
        const float perStep = static_cast<float>((2 << bits) - 1) / 510.0f * texels.perScale[channel];
        const F scaled = hn::MulAdd(ideal, set(perStep), set(-0.5f * static_cast<float>(low)));
        code = hn::Round(clamp(scaled, zero(), set(static_cast<float>((1 << bits) - 1))));
        value = expand(code + code + set(static_cast<float>(low)), bits + 1) * set(texels.scale[channel]);
    }

private:
    /// Expands a value of 4 .. 8 bits to eight: the high bits are repeated below.
    static HWY_INLINE F expand(F value, int bits) {
        if (bits == 8) return value;
        const F high = value * set(static_cast<float>(1 << (8 - bits)));
        return high + hn::Floor(value * set(1.0f / static_cast<float>(1 << (2 * bits - 8))));
    }
    static HWY_INLINE void roundPlain(F ideal, int bits, const Bc7ScaledTexels<D>& texels, std::size_t channel, F& code, F& value) {
        const auto largest = static_cast<float>((1 << bits) - 1);
        code = hn::Round(clamp(ideal * set(largest / 255.0f * texels.perScale[channel]), zero(), set(largest)));
        value = expand(code, bits) * set(texels.scale[channel]);
    }
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif

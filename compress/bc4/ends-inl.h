// BC4: local search for the endpoints of one mode.
//
// 1. Each start (kBc4Starts) is a real pair of ends between `from` and `to`. propose() assigns the texels to their nearest steps, solves
//    the least-squares ends for these steps and rounds them to codes.
// 2. Texels that scatter have many local optima, depending on how the steps fall on them. So the starts are cut into groups, and the best
//    pair of each group is polished:
// 3. polish() repeats propose() from the current pair (refits), then descends over the neighbouring pairs of codes (passes), each step
//    judged by the exact error.
#if defined(LIGHTCOOK_COMPRESS_BC4_ENDS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC4_ENDS_INL_H_
#undef LIGHTCOOK_COMPRESS_BC4_ENDS_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC4_ENDS_INL_H_
#endif

#include <hwy/highway.h>

#include <algorithm>

#include "compress/bc4/search.h"
#include "compress/bc4/texels-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D>
class Bc4EndSearch : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::M;
    using Lanes<D>::set, Lanes<D>::clamp;
    using Texels = Bc4Texels<D>;
    using Candidate = Bc4Candidate<D>;
    using Moments = typename Texels::Moments;

public:
    Bc4EndSearch(const Bc4Search& search, const Texels& texels) : search_(search), texels_(texels) {}

    /// Searches with starts between the values from and to, and keeps the result in best where it is better.
    /// weight, moments  the texels that the equidistant entries have to serve
    template <bool kSix>
    void fitBetween(const F* weight, const Moments& moments, F from, F to, int starts, Candidate& best) const {
        const F range = to - from;
        for (int start = 0; start < starts;) {
            Candidate proposed = texels_.nothing();
            for (const int end = std::min(start + search_.startsPerDescent, starts); start < end; ++start) {
                const F in = set(kBc4Starts[static_cast<std::size_t>(start)][0]), out = set(kBc4Starts[static_cast<std::size_t>(start)][1]);
                propose<kSix>(weight, moments, hn::MulAdd(range, in, from), hn::NegMulAdd(range, out, to), proposed);
            }
            Candidate candidate = proposed;
            if (isCompared()) candidate.error = texels_.template errorOf<kSix>(proposed.low, proposed.high);
            if (!kSix || search_.polishEach) polish<kSix>(candidate);
            best = Candidate::choose(candidate.error < best.error, candidate, best);
        }
    }

    /// Improves a candidate by refits and by descent.
    template <bool kSix>
    void polish(Candidate& candidate) const {
        for (int i = 0; i < search_.refits; ++i) refit<kSix>(candidate);
        for (int pass = 0; pass < search_.passes; ++pass)
            if (!descend<kSix>(candidate)) break;
    }

private:
    /// Returns false if nothing follows the only group of starts, so that the upper bound of its error is good enough.
    bool isCompared() const {
        return search_.sixValues || search_.refits > 0 || search_.passes > 0 || search_.starts > search_.startsPerDescent;
    }

    /// Keeps a pair where it is valid and better. The eight-value mode needs low < high: equal bytes select the six-value mode.
    template <bool kSix>
    HWY_INLINE M take(F low, F high, F error, Candidate& best) const {
        const M possible = hn::And(hn::And(low >= set(0.0f), high <= texels_.largest()), kSix ? low <= high : low < high);
        const M better = hn::And(error < best.error, possible);
        best = Candidate::choose(better, {error, low, high}, best);
        return better;
    }

    template <bool kSix>
    HWY_INLINE M improve(F low, F high, Candidate& best) const {
        return take<kSix>(low, high, texels_.template errorOf<kSix>(low, high), best);
    }

    /// Assigns each texel its nearest step between two ends, which need not be codes, and keeps the best codes for these steps where their
    /// error is smaller. The error is an upper bound: with the new ends a texel may be nearer to another step.
    template <bool kSix>
    HWY_INLINE void propose(const F* weight, const Moments& m, F from, F to, Candidate& best) const {
        constexpr float kSteps = Texels::template steps<kSix>();
        F sumK, sumKk, sumKv;
        texels_.template sumSteps<kSix>(weight, from, to, sumK, sumKk, sumKv);
        const F kk = hn::NegMulAdd(sumK * m.perTotal, sumK, sumKk), kv = hn::NegMulAdd(sumK, m.meanV, sumKv);
        const M solvable = kk > m.total * set(1e-4f);
        const F slope = hn::IfThenElseZero(solvable, kv / hn::Max(kk, set(1e-35f)));
        const F lowBest = hn::NegMulAdd(slope, sumK * m.perTotal, m.meanV + texels_.lowest);
        const F highBest = hn::MulAdd(slope, set(kSteps), lowBest);
        // Ends that differ by (x, y) from the optimum add the error a x^2 + 2 b x y + c y^2. Round the low end first, move the high end
        // to its optimum given the rounded low one, then round it too.
        const F c = sumKk * set(1 / (kSteps * kSteps)), b = hn::MulSub(sumK, set(1 / kSteps), c), a = m.total - b - b - c;
        F low = hn::Round(clamp(lowBest, set(0.0f), texels_.largest()));
        F high = hn::Round(clamp(hn::NegMulAdd(b / hn::Max(c, set(1e-35f)), low - lowBest, highBest), set(0.0f), texels_.largest()));
        if constexpr (!kSix) {
            high = hn::IfThenElse(high > low, high, low + set(1.0f));
            const M beyond = high > texels_.largest();
            low = hn::IfThenElse(beyond, texels_.largest() - set(1.0f), low);
            high = hn::IfThenElse(beyond, texels_.largest(), high);
        } else {
            high = hn::Max(high, low);
        }
        const F x = low - lowBest, y = high - highBest;
        const F more = hn::MulAdd(hn::MulAdd(a, x, b * y + b * y), x, c * y * y);
        const F error = hn::NegMulAdd(slope, kv, m.vv) + m.left + more;
        best = Candidate::choose(error < best.error, {error, low, high}, best);
    }

    /// Proposes the codes that are best for the steps that the texels have now, and keeps them where they are better.
    template <bool kSix>
    void refit(Candidate& best) const {
        Candidate proposed = texels_.nothing();
        if constexpr (kSix) {
            const F range = best.high - best.low, scale = set(5.0f) / hn::Max(range, set(0.5f)), unit = range * set(1.0f / 5);
            F weight[kTexelCount];
            for (std::size_t t = 0; t < kTexelCount; ++t) {
                F miss;
                texels_.template place<true>(best.low, unit, scale, t, miss);
                weight[t] = hn::IfThenElseZero(hn::Abs(miss) <= texels_.nearEnd[t], texels_.weight[t]);
            }
            propose<true>(weight, texels_.momentsOf(weight), best.low, best.high, proposed);
        } else {
            propose<false>(texels_.weight, texels_.all, best.low, best.high, proposed);
        }
        improve<kSix>(proposed.low, proposed.high, best);
    }

    /// Tries all pairs within reach of the candidate and keeps the best. Returns false if no lane improved.
    template <bool kSix>
    bool descend(Candidate& best) const {
        const Candidate from = best;
        bool improved = false;
        for (int low = -search_.reach; low <= search_.reach; ++low)
            for (int high = -search_.reach; high <= search_.reach; ++high)
                if (low != 0 || high != 0)
                    improved |= !hn::AllFalse(
                        D(), improve<kSix>(from.low + set(static_cast<float>(low)), from.high + set(static_cast<float>(high)), best));
        return improved;
    }

    const Bc4Search& search_;
    const Texels& texels_;
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif

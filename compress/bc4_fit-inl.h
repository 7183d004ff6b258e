// The kernel of BC4, BC5 and BC3's alpha: one channel on a line between two bytes, as many blocks as a vector has lanes side by side.
// No lane ever meets another, and every step is a plain IEEE operation: the same bits at any width. Values are in codes, 0 ..
// codes_.largest.
#if defined(LIGHTCOOK_COMPRESS_BC4_FIT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC4_FIT_INL_H_
#undef LIGHTCOOK_COMPRESS_BC4_FIT_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC4_FIT_INL_H_
#endif

#include <hwy/highway.h>
#include <algorithm>
#include <cstdint>

#include "compress/bc4_search.h"
#include "compress/block.h"

HWY_BEFORE_NAMESPACE();
namespace compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D>
class Bc4Fit {
    using F = hn::Vec<D>;
    using DI = hn::RebindToSigned<D>;
    using M = hn::Mask<D>;

public:
    explicit Bc4Fit(const Bc4Search& search, const Bc4Codes& codes = kBc4Unorm) : search_(search), codes_(codes) {}

    void run(const Block* const* blocks, std::size_t channel, Bc4Result* found) {
        load(blocks, channel);
        Candidate eight = nothing(), six = nothing();
        fit<false>(eight);
        if (search_.sixSteps) fit<true>(six);
        const M sixIsBetter = six.error < eight.error;
        const Candidate best = choose(sixIsBetter, six, eight);
        store(best, sixIsBetter, found);
    }

private:
    static constexpr float kNear = 12.0f;  ///< codes from an extreme

    struct Candidate {
        F error, low, high;
    };
    static HWY_INLINE F set(float value) { return hn::Set(D(), value); }
    static HWY_INLINE F clamp(F value, F low, F high) { return hn::Min(hn::Max(value, low), high); }
    HWY_INLINE F largest() const { return set(codes_.largest); }
    Candidate nothing() const { return {set(1e30f), set(0.0f), largest()}; }
    static HWY_INLINE Candidate choose(M first, const Candidate& a, const Candidate& b) {
        return {hn::IfThenElse(first, a.error, b.error), hn::IfThenElse(first, a.low, b.low), hn::IfThenElse(first, a.high, b.high)};
    }

    void load(const Block* const* blocks, std::size_t channel) {
        const D d;
        HWY_ALIGN float buffer[hn::MaxLanes(D())];
        lowest_ = largest();
        highest_ = set(0.0f);
        total_ = set(1e-30f);
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) buffer[lane] = blocks[lane]->channel[channel][t];
            value_[t] = hn::Load(d, buffer) * set(codes_.scale) + set(codes_.offset);
            for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) buffer[lane] = blocks[lane]->significance[t];
            weight_[t] = hn::Load(d, buffer);
            total_ = total_ + weight_[t];
            nearEnd_[t] = hn::Min(value_[t], largest() - value_[t]);
            const M counts = weight_[t] > set(0.0f);
            lowest_ = hn::IfThenElse(counts, hn::Min(lowest_, value_[t]), lowest_);
            highest_ = hn::IfThenElse(counts, hn::Max(highest_, value_[t]), highest_);
        }
    }

    template <bool kSix>
    static constexpr float steps() {
        return kSix ? 5.0f : 7.0f;
    }

    /// Nearest step of a texel between the ends, and its distance. Fused where that saves an operation.
    template <bool kSix>
    HWY_INLINE F place(F low, F unit, F scale, std::size_t t, F& miss) const {
        const F above = value_[t] - low;
        const F step = hn::Round(clamp(above * scale, set(0.0f), set(steps<kSix>())));
        miss = hn::NegMulAdd(step, unit, above);
        return step;
    }

    template <bool kSix>
    HWY_INLINE F errorOf(F low, F high) const {
        const F range = high - low, scale = set(steps<kSix>()) / hn::Max(range, set(0.5f)), unit = range * set(1.0f / steps<kSix>());
        F error = set(0.0f);
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            F miss;
            place<kSix>(low, unit, scale, t, miss);
            if constexpr (kSix) miss = hn::Min(hn::Abs(miss), nearEnd_[t]);
            error = hn::MulAdd(weight_[t] * miss, miss, error);
        }
        return error;
    }

    /// Takes the ends where they are better. Eight steps need two different ends, or the bytes would mean the other layout.
    template <bool kSix>
    HWY_INLINE M take(F low, F high, F error, Candidate& best) const {
        const M possible = hn::And(hn::And(low >= set(0.0f), high <= largest()), kSix ? low <= high : low < high);
        const M better = hn::And(error < best.error, possible);
        best = choose(better, {error, low, high}, best);
        return better;
    }

    template <bool kSix>
    HWY_INLINE M improve(F low, F high, Candidate& best) const {
        return take<kSix>(low, high, errorOf<kSix>(low, high), best);
    }

    /// Takes the ends where they are better, and moves them to the least-squares ends for the steps that texels have at them;
    /// texels that 0 or 1 serve better are left out.
    template <bool kSix>
    HWY_INLINE void improveAndRefit(F& low, F& high, Candidate& best) const {
        const F range = high - low, scale = set(steps<kSix>()) / hn::Max(range, set(0.5f)), unit = range * set(1.0f / steps<kSix>());
        F error = set(0.0f), total = kSix ? set(1e-30f) : total_;
        F sumK = set(0.0f), sumV = set(0.0f), sumKk = set(0.0f), sumKv = set(0.0f);
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            F miss, weight = weight_[t];
            const F k = place<kSix>(low, unit, scale, t, miss), v = value_[t] - low;
            if constexpr (kSix) {
                miss = hn::Abs(miss);
                weight = hn::IfThenElseZero(miss <= nearEnd_[t], weight);
                total = total + weight;
                miss = hn::Min(miss, nearEnd_[t]);
            }
            error = hn::MulAdd(weight_[t] * miss, miss, error);
            const F weighted = weight * k;
            sumK = sumK + weighted;
            sumV = hn::MulAdd(weight, v, sumV);
            sumKk = hn::MulAdd(weighted, k, sumKk);
            sumKv = hn::MulAdd(weighted, v, sumKv);
        }
        take<kSix>(low, high, error, best);
        const F share = set(1.0f) / total, meanK = sumK * share, meanV = sumV * share;
        const F kk = hn::NegMulAdd(meanK, sumK, sumKk), kv = hn::NegMulAdd(meanK, sumV, sumKv);
        const M solvable = kk > total * set(1e-4f);
        const F slope = kv / hn::Max(kk, set(1e-35f)), base = hn::NegMulAdd(slope, meanK, low + meanV);
        low = hn::IfThenElse(solvable, hn::Round(clamp(base, set(0.0f), largest())), low);
        high = hn::IfThenElse(solvable, hn::Round(clamp(hn::MulAdd(slope, set(steps<kSix>()), base), set(0.0f), largest())), high);
    }

    /// What lies between the texels that the least or the largest code serves to within so many codes, or all where nothing does.
    HWY_INLINE void rangeWithin(float near, F& from, F& to) const {
        F low = largest(), high = set(0.0f);
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            const M counts = weight_[t] > set(0.0f);
            const M offZero = hn::And(counts, value_[t] >= set(near)), offOne = hn::And(counts, value_[t] <= largest() - set(near));
            low = hn::IfThenElse(offZero, hn::Min(low, value_[t]), low);
            high = hn::IfThenElse(offOne, hn::Max(high, value_[t]), high);
        }
        const M some = low <= high;
        from = hn::IfThenElse(some, low, lowest_);
        to = hn::IfThenElse(some, high, highest_);
    }

    template <bool kSix>
    void fit(Candidate& best) const {
        if constexpr (!kSix) {
            fitBetween<false>(lowest_, highest_, search_.starts, best);
        } else {
            F from, to, nearFrom, nearTo;
            rangeWithin(0.5f, from, to);
            fitBetween<true>(from, to, search_.starts, best);
            if (search_.nearStarts == 0) return;
            // Texels near the extremes may be left to them, off as they are, so that the others have the steps for themselves.
            rangeWithin(kNear, nearFrom, nearTo);
            const M differs = hn::Or(nearFrom != from, nearTo != to);
            if (hn::AllFalse(D(), differs)) return;
            Candidate other = nothing();
            fitBetween<true>(nearFrom, nearTo, search_.nearStarts, other);
            best = choose(hn::And(differs, other.error < best.error), other, best);
        }
    }

    /// Texels that scatter have many local optima, by how the steps fall on them: from each group of starts the best goes on.
    template <bool kSix>
    void fitBetween(F from, F to, int starts, Candidate& best) const {
        const F range = to - from;
        for (int start = 0; start < starts;) {
            Candidate candidate = nothing();
            const int end = std::min(start + search_.startsPerDescent, starts);
            for (; start < end; ++start) {
                const F in = set(kBc4Starts[static_cast<std::size_t>(start)][0]), out = set(kBc4Starts[static_cast<std::size_t>(start)][1]);
                F low = hn::Max(hn::Min(hn::Round(hn::MulAdd(range, in, from)), largest() - set(1.0f)), set(0.0f));
                F high = hn::Min(hn::Max(hn::Round(hn::NegMulAdd(range, out, to)), low + set(1.0f)), largest());
                for (int i = 0; i < search_.refits; ++i) improveAndRefit<kSix>(low, high, candidate);
                improve<kSix>(low, high, candidate);
            }
            for (int pass = 0; pass < search_.passes; ++pass)
                if (!descend<kSix>(candidate)) break;
            best = choose(candidate.error < best.error, candidate, best);
        }
    }

    /// The best of the neighbours within reach, at both ends. False when no lane found one.
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

    /// Indices of half a block, three bits each. Places rise from low to high; the order of the ends tells the layout: falling for eight.
    hn::Vec<DI> indicesOf(const Candidate& best, M six, std::size_t first) const {
        const DI di;
        const F steps = hn::IfThenElse(six, set(5.0f), set(7.0f)), range = best.high - best.low;
        const F scale = steps / hn::Max(range, set(0.5f)), unit = range / steps;
        auto bits = hn::Zero(di);
        for (std::size_t t = first + kTexelCount / 2; t-- > first;) {
            const F above = value_[t] - best.low;
            const F step = hn::Round(clamp(above * scale, set(0.0f), steps));
            const F miss = hn::Abs(hn::NegMulAdd(step, unit, above)), fromOne = largest() - value_[t];
            const F fromFirst = hn::IfThenElse(six, step, steps - step);
            F index =
                hn::IfThenElse(fromFirst == set(0.0f), fromFirst, hn::IfThenElse(fromFirst == steps, set(1.0f), fromFirst + set(1.0f)));
            index = hn::IfThenElse(hn::And(six, value_[t] < miss), set(6.0f), index);
            index = hn::IfThenElse(hn::And(six, hn::And(fromOne < miss, fromOne < value_[t])), set(7.0f), index);
            bits = hn::Or(hn::ShiftLeft<3>(bits), hn::ConvertTo(di, index));
        }
        return bits;
    }

    void store(const Candidate& best, M six, Bc4Result* found) const {
        const D d;
        const DI di;
        HWY_ALIGN float error[hn::MaxLanes(D())];
        HWY_ALIGN std::int32_t words[6][hn::MaxLanes(D())];
        hn::Store(best.error, d, error);
        hn::Store(hn::ConvertTo(di, best.low), di, words[0]);
        hn::Store(hn::ConvertTo(di, best.high), di, words[1]);
        hn::Store(hn::ConvertTo(di, hn::IfThenElseZero(six, set(1.0f))), di, words[2]);
        hn::Store(hn::ConvertTo(di, hn::IfThenElseZero(lowest_ >= highest_, set(1.0f))), di, words[3]);
        hn::Store(indicesOf(best, six, 0), di, words[4]);
        hn::Store(indicesOf(best, six, kTexelCount / 2), di, words[5]);
        for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) {
            const auto half = [&](std::size_t which) { return static_cast<std::uint64_t>(words[which][lane]); };
            found[lane] = {words[0][lane], words[1][lane], words[2][lane] != 0, error[lane], half(4) | half(5) << 24, words[3][lane] != 0};
        }
    }

    const Bc4Search& search_;
    const Bc4Codes codes_;
    F value_[kTexelCount], weight_[kTexelCount];
    F nearEnd_[kTexelCount];  ///< distance to the nearer of the least and the largest code
    F total_;                 ///< weight
    F lowest_, highest_;      ///< of the texels that count
};

}  // namespace HWY_NAMESPACE
}  // namespace compress
HWY_AFTER_NAMESPACE();
#endif

// The kernel of BC4, BC5 and BC3's alpha: one channel on a line between two bytes, as many blocks as a vector has lanes side by side.
// No lane ever meets another, and every step is a plain IEEE operation: the same bits at any width. Values are in codes, 0 .. 255.
#if defined(LIGHTCOOK_COMPRESS_BC4_FIT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC4_FIT_INL_H_
#undef LIGHTCOOK_COMPRESS_BC4_FIT_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC4_FIT_INL_H_
#endif

#include <hwy/highway.h>

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
    explicit Bc4Fit(const Bc4Search& search) : search_(search) {}

    void run(const Block* const* blocks, std::size_t channel, Bc4Result* found) {
        load(blocks, channel);
        Candidate eight = nothing(), six = nothing();
        fit<false>(eight);
        if (search_.sixSteps) fit<true>(six);
        const M sixIsBetter = six.error < eight.error;
        store(hn::IfThenElse(sixIsBetter, six.low, eight.low), hn::IfThenElse(sixIsBetter, six.high, eight.high),
              hn::IfThenElseZero(sixIsBetter, set(1.0f)), hn::Min(six.error, eight.error), found);
    }

private:
    struct Candidate {
        F error, low, high;
    };
    static HWY_INLINE F set(float value) { return hn::Set(D(), value); }
    static HWY_INLINE F clamp(F value, F low, F high) { return hn::Min(hn::Max(value, low), high); }
    static Candidate nothing() { return {set(1e30f), set(0.0f), set(255.0f)}; }

    void load(const Block* const* blocks, std::size_t channel) {
        const D d;
        HWY_ALIGN float buffer[hn::MaxLanes(D())];
        lowest_ = innerLowest_ = set(255.0f);
        highest_ = innerHighest_ = set(0.0f);
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) buffer[lane] = blocks[lane]->channel[channel][t];
            value_[t] = hn::Load(d, buffer) * set(255.0f);
            for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) buffer[lane] = blocks[lane]->significance[t];
            weight_[t] = hn::Load(d, buffer);
            const M counts = weight_[t] > set(0.0f);
            lowest_ = hn::IfThenElse(counts, hn::Min(lowest_, value_[t]), lowest_);
            highest_ = hn::IfThenElse(counts, hn::Max(highest_, value_[t]), highest_);
            const M offZero = hn::And(counts, value_[t] >= set(0.5f)), offOne = hn::And(counts, value_[t] <= set(254.5f));
            innerLowest_ = hn::IfThenElse(offZero, hn::Min(innerLowest_, value_[t]), innerLowest_);
            innerHighest_ = hn::IfThenElse(offOne, hn::Max(innerHighest_, value_[t]), innerHighest_);
        }
    }

    template <bool kSix>
    static constexpr float steps() {
        return kSix ? 5.0f : 7.0f;
    }

    /// Nearest step of each texel between the ends, and its distance.
    template <bool kSix>
    HWY_INLINE F place(F low, F range, F scale, std::size_t t, F& miss) const {
        const F step = hn::Round(clamp((value_[t] - low) * scale, set(0.0f), set(steps<kSix>())));
        miss = low + step * range * set(1.0f / steps<kSix>()) - value_[t];
        return step;
    }

    template <bool kSix>
    F errorOf(F low, F high) const {
        const F range = high - low, scale = set(steps<kSix>()) / hn::Max(range, set(0.5f));
        F error = set(0.0f);
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            F miss;
            place<kSix>(low, range, scale, t, miss);
            miss = hn::Abs(miss);
            if constexpr (kSix) miss = hn::Min(miss, hn::Min(value_[t], set(255.0f) - value_[t]));
            error = error + weight_[t] * miss * miss;
        }
        return error;
    }

    /// Takes the ends where they are better. Eight steps need two different ends, or the bytes would mean the other layout.
    template <bool kSix>
    M improve(F low, F high, Candidate& best) const {
        const F error = errorOf<kSix>(low, high);
        M better = error < best.error;
        const M possible = hn::And(hn::And(low >= set(0.0f), high <= set(255.0f)), kSix ? low <= high : low < high);
        better = hn::And(better, possible);
        best.error = hn::IfThenElse(better, error, best.error);
        best.low = hn::IfThenElse(better, low, best.low);
        best.high = hn::IfThenElse(better, high, best.high);
        return better;
    }

    /// Least-squares ends for the steps that texels have now; texels that 0 or 1 serve better are left out.
    template <bool kSix>
    void refit(F& low, F& high) const {
        const F range = high - low, scale = set(steps<kSix>()) / hn::Max(range, set(0.5f));
        F total = set(1e-30f), meanK = set(0.0f), meanV = set(0.0f), kk = set(0.0f), kv = set(0.0f);
        F weight[kTexelCount], position[kTexelCount];
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            F miss;
            position[t] = place<kSix>(low, range, scale, t, miss) * set(1.0f / steps<kSix>());
            weight[t] = weight_[t];
            if constexpr (kSix) weight[t] = hn::IfThenElseZero(hn::Abs(miss) <= hn::Min(value_[t], set(255.0f) - value_[t]), weight[t]);
            total = total + weight[t];
            meanK = meanK + weight[t] * position[t];
            meanV = meanV + weight[t] * value_[t];
        }
        const F share = set(1.0f) / total;
        meanK = meanK * share;
        meanV = meanV * share;
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            const F k = position[t] - meanK;
            kk = kk + weight[t] * k * k;
            kv = kv + weight[t] * k * (value_[t] - meanV);
        }
        const M solvable = kk > total * set(1e-6f);
        const F slope = kv / hn::Max(kk, set(1e-35f));
        low = hn::IfThenElse(solvable, hn::Round(clamp(meanV - slope * meanK, set(0.0f), set(255.0f))), low);
        high = hn::IfThenElse(solvable, hn::Round(clamp(meanV + slope * (set(1.0f) - meanK), set(0.0f), set(255.0f))), high);
    }

    template <bool kSix>
    void fit(Candidate& best) const {
        F from = lowest_, to = highest_;
        if constexpr (kSix) {
            const M some = innerLowest_ <= innerHighest_;
            from = hn::IfThenElse(some, innerLowest_, from);
            to = hn::IfThenElse(some, innerHighest_, to);
        }
        const F range = to - from;
        for (int start = 0; start < search_.starts; ++start) {
            // Ends drawn in, one more than the other: where texels scatter, the best line leaves the outermost outside.
            const F in = set(kBc4Starts[static_cast<std::size_t>(start)][0]), out = set(kBc4Starts[static_cast<std::size_t>(start)][1]);
            F low = hn::Min(hn::Round(from + range * in), set(254.0f));
            F high = hn::Max(hn::Round(to - range * out), low + set(1.0f));
            Candidate candidate = nothing();
            improve<kSix>(low, high, candidate);
            for (int i = 0; i < search_.refits; ++i) {
                refit<kSix>(low, high);
                improve<kSix>(low, high, candidate);
            }
            for (int pass = 0; pass < search_.passes; ++pass)
                if (!descend<kSix>(candidate)) break;
            const M better = candidate.error < best.error;
            best.error = hn::IfThenElse(better, candidate.error, best.error);
            best.low = hn::IfThenElse(better, candidate.low, best.low);
            best.high = hn::IfThenElse(better, candidate.high, best.high);
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

    void store(F low, F high, F six, F error, Bc4Result* found) const {
        const D d;
        HWY_ALIGN float buffer[4][hn::MaxLanes(D())];
        hn::Store(low, d, buffer[0]);
        hn::Store(high, d, buffer[1]);
        hn::Store(six, d, buffer[2]);
        hn::Store(error, d, buffer[3]);
        for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane)
            found[lane] = {static_cast<int>(buffer[0][lane]), static_cast<int>(buffer[1][lane]), buffer[2][lane] != 0, buffer[3][lane]};
    }

    const Bc4Search& search_;
    F value_[kTexelCount], weight_[kTexelCount];
    F lowest_, highest_;            ///< of the texels that count
    F innerLowest_, innerHighest_;  ///< of those that 0, or 1, does not already serve
};

}  // namespace HWY_NAMESPACE
}  // namespace compress
HWY_AFTER_NAMESPACE();
#endif

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

#include "compress/bc4/search.h"
#include "compress/block/block.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D>
class Bc4Fit {
    using F = hn::Vec<D>;
    using DI = hn::RebindToSigned<D>;
    using DU = hn::RebindToUnsigned<D>;
    using U = hn::Vec<DU>;
    using M = hn::Mask<D>;

public:
    explicit Bc4Fit(const Bc4Search& search, const Bc4Codes& codes = kBc4Unorm) : search_(search), codes_(codes) {}

    void run(const Block* const* blocks, std::size_t channel, Bc4Result* found) {
        load(blocks, channel);
        const Candidate best = search();
        store(best, found);
    }

    /// Blocks that lie in lanes already: their values in the format's own range, what each counts, at least one above 0 in each lane.
    /// Returns the low and the high word of each block.
    void run(const F (&value)[kTexelCount], const F (&weight)[kTexelCount], U& lowWord, U& highWord) {
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            value_[t] = value[t] * set(codes_.scale) + set(codes_.offset);
            weight_[t] = weight[t];
        }
        pack(search(), lowWord, highWord);
    }

private:
    struct Candidate {
        F error, low, high;
    };
    /// Sums over the texels that the steps have to serve; values count from the block's lowest.
    struct Moments {
        F total, perTotal, meanV, vv;  ///< vv about the mean
        F left;                        ///< error of the texels that the least and the largest code serve
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
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) buffer[lane] = blocks[lane]->channel[channel][t];
            value_[t] = hn::Load(d, buffer) * set(codes_.scale) + set(codes_.offset);
            for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) buffer[lane] = blocks[lane]->significance[t];
            weight_[t] = hn::Load(d, buffer);
        }
    }

    void measure() {
        lowest_ = largest();
        highest_ = set(0.0f);
        leastNear_ = set(1e30f);
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            const M counts = weight_[t] > set(0.0f);
            nearEnd_[t] = hn::Min(value_[t], largest() - value_[t]);
            lowest_ = hn::IfThenElse(counts, hn::Min(lowest_, value_[t]), lowest_);
            highest_ = hn::IfThenElse(counts, hn::Max(highest_, value_[t]), highest_);
            leastNear_ = hn::IfThenElse(counts, hn::Min(leastNear_, weight_[t] * nearEnd_[t] * nearEnd_[t]), leastNear_);
        }
        M isOne = lowest_ == lowest_;
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            above_[t] = value_[t] - lowest_;
            isOne = hn::And(isOne, weight_[t] == set(1.0f));
        }
        isUniform_ = hn::AllTrue(D(), isOne);
    }

    Candidate search() {
        measure();
        all_ = momentsOf(weight_);
        Candidate eight = nothing(), six = nothing();
        const M isConstant = lowest_ >= highest_;
        if (!hn::AllFalse(D(), isConstant)) {
            fitConstant<false>(isConstant, eight);
            fitConstant<true>(isConstant, six);
        }
        fitBetween<false>(weight_, all_, lowest_, highest_, search_.starts, eight);
        if (search_.sixSteps) fitSix(eight.error, six);
        isSix_ = six.error < eight.error;
        return choose(isSix_, six, eight);
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

    /// A texel's weight times x. Most blocks weigh all texels alike: Ones saves them the product, and every bit is the same.
    struct Ones {
        HWY_INLINE F times(std::size_t, F x) const { return x; }
    };
    struct Weights {
        const F* weight;
        HWY_INLINE F times(std::size_t t, F x) const { return weight[t] * x; }
    };

    template <bool kSix>
    HWY_INLINE F errorOf(F low, F high) const {
        return isUniform_ ? errorWith<kSix>(Ones{}, low, high) : errorWith<kSix>(Weights{weight_}, low, high);
    }
    /// Distances are in steps until the end.
    template <bool kSix, class W>
    HWY_INLINE F errorWith(const W& weights, F low, F high) const {
        constexpr float kSteps = steps<kSix>();
        const F range = hn::Max(high - low, set(0x1p-20f)), scale = set(kSteps) / range, unit = range * set(1 / kSteps);
        const F offset = (lowest_ - low) * scale;
        F error = set(0.0f);
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            const F at = hn::MulAdd(above_[t], scale, offset);
            F miss = at - hn::Round(clamp(at, set(0.0f), set(kSteps)));
            if constexpr (kSix) miss = hn::Min(hn::Abs(miss), nearEnd_[t] * scale);
            error = hn::MulAdd(weights.times(t, miss), miss, error);
        }
        return error * unit * unit;
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

    /// Of a single value: ends side by side reach every seventh of a code, and every fifth.
    template <bool kSix>
    void fitConstant(M isConstant, Candidate& best) const {
        const F low = hn::Min(hn::Floor(hn::Round(lowest_ * set(steps<kSix>())) / set(steps<kSix>())), largest() - set(1.0f));
        const F error = errorOf<kSix>(low, low + set(1.0f));
        best = choose(isConstant, {error, low, low + set(1.0f)}, best);
    }

    Moments momentsOf(const F* weight) const {
        Moments m = {set(1e-30f), set(0.0f), set(0.0f), set(0.0f), set(0.0f)};
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            m.total = m.total + weight[t];
            m.meanV = hn::MulAdd(weight[t], above_[t], m.meanV);
        }
        m.perTotal = set(1.0f) / m.total;
        m.meanV = m.meanV * m.perTotal;
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            const F v = above_[t] - m.meanV;
            m.vv = hn::MulAdd(weight[t] * v, v, m.vv);
        }
        return m;
    }

    /// Of each texel's step k between two ends, and its value v above the lowest.
    template <bool kSix, class W>
    HWY_INLINE void sumSteps(const W& weights, F from, F to, F& sumK, F& sumKk, F& sumKv) const {
        const F scale = set(steps<kSix>()) / hn::Max(to - from, set(0.0625f)), offset = (lowest_ - from) * scale;
        sumK = sumKk = sumKv = set(0.0f);
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            const F k = hn::Round(clamp(hn::MulAdd(above_[t], scale, offset), set(0.0f), set(steps<kSix>())));
            const F weighted = weights.times(t, k);
            sumK = sumK + weighted;
            sumKk = hn::MulAdd(weighted, k, sumKk);
            sumKv = hn::MulAdd(weighted, above_[t], sumKv);
        }
    }

    /// Gives each texel its step between two ends, which need not be codes, and takes the codes that serve those steps best where their
    /// error is less. Texels may be nearer to another step of the new ends: the error is at most what is reckoned here.
    template <bool kSix>
    HWY_INLINE void propose(const F* weight, const Moments& m, F from, F to, Candidate& best) const {
        constexpr float kSteps = steps<kSix>();
        F sumK, sumKk, sumKv;
        if (isUniform_ && weight == weight_)
            sumSteps<kSix>(Ones{}, from, to, sumK, sumKk, sumKv);
        else
            sumSteps<kSix>(Weights{weight}, from, to, sumK, sumKk, sumKv);
        const F kk = hn::NegMulAdd(sumK * m.perTotal, sumK, sumKk), kv = hn::NegMulAdd(sumK, m.meanV, sumKv);
        const M solvable = kk > m.total * set(1e-4f);
        const F slope = hn::IfThenElseZero(solvable, kv / hn::Max(kk, set(1e-35f)));
        const F lowBest = hn::NegMulAdd(slope, sumK * m.perTotal, m.meanV + lowest_), highBest = hn::MulAdd(slope, set(kSteps), lowBest);
        // Error of ends off by (x, y) from these: a x^2 + 2 b x y + c y^2 more. One end is rounded, the other follows before it is rounded
        // too.
        const F c = sumKk * set(1 / (kSteps * kSteps)), b = hn::MulSub(sumK, set(1 / kSteps), c), a = m.total - b - b - c;
        F low = hn::Round(clamp(lowBest, set(0.0f), largest()));
        F high = hn::Round(clamp(hn::NegMulAdd(b / hn::Max(c, set(1e-35f)), low - lowBest, highBest), set(0.0f), largest()));
        if constexpr (!kSix) {
            high = hn::IfThenElse(high > low, high, low + set(1.0f));
            const M beyond = high > largest();
            low = hn::IfThenElse(beyond, largest() - set(1.0f), low);
            high = hn::IfThenElse(beyond, largest(), high);
        } else {
            high = hn::Max(high, low);
        }
        const F x = low - lowBest, y = high - highBest;
        const F more = hn::MulAdd(hn::MulAdd(a, x, b * y + b * y), x, c * y * y);
        const F error = hn::NegMulAdd(slope, kv, m.vv) + m.left + more;
        best = choose(error < best.error, {error, low, high}, best);
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

    /// Six steps alone serve some blocks better than eight. The least and the largest code can only be of use where a texel is nearer to
    /// one of them than all texels together are to the eight; other lanes keep what they have, whatever their neighbours do.
    void fitSix(F errorOfEight, Candidate& best) const {
        Candidate found = nothing();
        fitBetween<true>(weight_, all_, lowest_, highest_, search_.plainStarts, found);
        const M hasExtremes = leastNear_ < errorOfEight;
        if (!hn::AllFalse(D(), hasExtremes)) {
            const Candidate plain = found;
            for (int i = 0; i < search_.nears; ++i) {
                // Texels near the extremes are left to them, off as they are, so that the others have the steps for themselves.
                F from, to, weight[kTexelCount];
                rangeWithin(kBc4Nears[static_cast<std::size_t>(i)], from, to);
                for (std::size_t t = 0; t < kTexelCount; ++t)
                    weight[t] = hn::IfThenElseZero(hn::And(value_[t] >= from, value_[t] <= to), weight_[t]);
                Moments moments = momentsOf(weight);
                for (std::size_t t = 0; t < kTexelCount; ++t)
                    moments.left = hn::MulAdd((weight_[t] - weight[t]) * nearEnd_[t], nearEnd_[t], moments.left);
                fitBetween<true>(weight, moments, from, to, search_.nearStarts, found);
            }
            found = choose(hasExtremes, found, plain);
        }
        if (!search_.polishEach) polish<true>(found);
        best = choose(found.error < best.error, found, best);
    }

    /// Texels that scatter have many local optima, by how the steps fall on them: from each group of starts the best goes on.
    template <bool kSix>
    void fitBetween(const F* weight, const Moments& moments, F from, F to, int starts, Candidate& best) const {
        const F range = to - from;
        for (int start = 0; start < starts;) {
            Candidate proposed = nothing();
            for (const int end = std::min(start + search_.startsPerDescent, starts); start < end; ++start) {
                const F in = set(kBc4Starts[static_cast<std::size_t>(start)][0]), out = set(kBc4Starts[static_cast<std::size_t>(start)][1]);
                propose<kSix>(weight, moments, hn::MulAdd(range, in, from), hn::NegMulAdd(range, out, to), proposed);
            }
            Candidate candidate = {errorOf<kSix>(proposed.low, proposed.high), proposed.low, proposed.high};
            if (!kSix || search_.polishEach) polish<kSix>(candidate);
            best = choose(candidate.error < best.error, candidate, best);
        }
    }

    template <bool kSix>
    void polish(Candidate& candidate) const {
        for (int i = 0; i < search_.refits; ++i) refit<kSix>(candidate);
        for (int pass = 0; pass < search_.passes; ++pass)
            if (!descend<kSix>(candidate)) break;
    }

    /// The codes that serve best the steps that texels have now, where they are better.
    template <bool kSix>
    void refit(Candidate& best) const {
        Candidate proposed = nothing();
        if constexpr (kSix) {
            const F range = best.high - best.low, scale = set(5.0f) / hn::Max(range, set(0.5f)), unit = range * set(1.0f / 5);
            F weight[kTexelCount];
            for (std::size_t t = 0; t < kTexelCount; ++t) {
                F miss;
                place<true>(best.low, unit, scale, t, miss);
                weight[t] = hn::IfThenElseZero(hn::Abs(miss) <= nearEnd_[t], weight_[t]);
            }
            propose<true>(weight, momentsOf(weight), best.low, best.high, proposed);
        } else {
            propose<false>(weight_, all_, best.low, best.high, proposed);
        }
        improve<kSix>(proposed.low, proposed.high, best);
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

    /// A block's bytes: the ends, whose order tells the layout, and 48 bits of indices.
    void pack(const Candidate& best, U& lowWord, U& highWord) const {
        const DI di;
        const DU du;
        const auto byteOf = [&](F code) { return hn::And(hn::ConvertTo(di, code - set(codes_.offset)), hn::Set(di, 0xff)); };
        const F first = hn::IfThenElse(isSix_, best.low, best.high), second = hn::IfThenElse(isSix_, best.high, best.low);
        const auto ends = hn::Or(byteOf(first), hn::ShiftLeft<8>(byteOf(second)));
        const auto front = indicesOf(best, isSix_, 0), back = indicesOf(best, isSix_, kTexelCount / 2);
        lowWord = hn::BitCast(du, hn::Or(ends, hn::ShiftLeft<16>(front)));
        highWord = hn::BitCast(du, hn::Or(hn::ShiftRight<16>(front), hn::ShiftLeft<8>(back)));
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

    void store(const Candidate& best, Bc4Result* found) const {
        const D d;
        const DI di;
        HWY_ALIGN float error[hn::MaxLanes(D())];
        HWY_ALIGN std::int32_t words[6][hn::MaxLanes(D())];
        hn::Store(best.error, d, error);
        hn::Store(hn::ConvertTo(di, best.low), di, words[0]);
        hn::Store(hn::ConvertTo(di, best.high), di, words[1]);
        hn::Store(hn::ConvertTo(di, hn::IfThenElseZero(isSix_, set(1.0f))), di, words[2]);
        hn::Store(hn::ConvertTo(di, hn::IfThenElseZero(lowest_ >= highest_, set(1.0f))), di, words[3]);
        hn::Store(indicesOf(best, isSix_, 0), di, words[4]);
        hn::Store(indicesOf(best, isSix_, kTexelCount / 2), di, words[5]);
        for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) {
            const auto half = [&](std::size_t which) { return static_cast<std::uint64_t>(words[which][lane]); };
            found[lane] = {words[0][lane], words[1][lane], words[2][lane] != 0, error[lane], half(4) | half(5) << 24, words[3][lane] != 0};
        }
    }

    const Bc4Search& search_;
    const Bc4Codes codes_;
    F value_[kTexelCount], weight_[kTexelCount];
    F above_[kTexelCount];    ///< the lowest
    F nearEnd_[kTexelCount];  ///< distance to the nearer of the least and the largest code
    F lowest_, highest_;      ///< of the texels that count
    F leastNear_;             ///< error of the one that the least or the largest code serves best
    Moments all_;             ///< of all texels
    bool isUniform_;          ///< every weight is 1
    M isSix_;                 ///< what was found has the layout of six steps
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif

// BC6H: modes, and the codes of a line's ends in them, in lanes.
#if defined(LIGHTCOOK_COMPRESS_BC6H_CODES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC6H_CODES_INL_H_
#undef LIGHTCOOK_COMPRESS_BC6H_CODES_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC6H_CODES_INL_H_
#endif

#include <hwy/highway.h>

#include "compress/bc6h/modes.h"
#include "compress/bc6h/regions-inl.h"
#include "compress/bc6h/values-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D, bool kSigned>
class Bc6hCodes {
    using F = hn::Vec<D>;
    using DI = hn::RebindToSigned<D>;
    using I = hn::Vec<DI>;
    using M = hn::Mask<D>;
    using Values = Bc6hValues<D, kSigned>;
    using Line = Bc6hLine<D>;

public:
    /// The steps of a mode's precision, lane by lane.
    struct Scale {
        F step, inverseStep, largestCode;
        M exact;  ///< 16 bits: the code is v itself
    };
    /// What a mode asks of the codes, lane by lane.
    struct ModeLanes : Scale {
        I index;
        F deltaLimit[3];
    };

    static ModeLanes modeLanes(int modeIndex) {
        const Bc6hMode& mode = kBc6hModes[static_cast<std::size_t>(modeIndex)];
        ModeLanes lanes;
        lanes.index = hn::Set(DI(), modeIndex);
        lanes.step = set(static_cast<float>(1 << (16 - mode.endpointBits)));
        lanes.inverseStep = set(1.0f) / lanes.step;
        lanes.largestCode = set(static_cast<float>((1 << (mode.endpointBits - kSigned)) - 1));
        for (std::size_t c = 0; c < 3; ++c)
            lanes.deltaLimit[c] = set(mode.transformed ? static_cast<float>(1 << (mode.deltaBits[c] - 1)) : 1e6f);
        lanes.exact = set(static_cast<float>(mode.endpointBits)) > set(15.5f);
        return lanes;
    }
    static void overrideWhere(M mask, const ModeLanes& with, ModeLanes& lanes) {
        lanes.index = hn::IfThenElse(hn::RebindMask(DI(), mask), with.index, lanes.index);
        lanes.step = select(mask, with.step, lanes.step);
        lanes.inverseStep = select(mask, with.inverseStep, lanes.inverseStep);
        lanes.largestCode = select(mask, with.largestCode, lanes.largestCode);
        for (int c = 0; c < 3; ++c) lanes.deltaLimit[c] = select(mask, with.deltaLimit[c], lanes.deltaLimit[c]);
        lanes.exact = hn::Or(hn::AndNot(mask, lanes.exact), hn::And(mask, with.exact));
    }

    /// Code whose value is nearest to v: values lie in the middle of their step, but those of 0 and of the largest code at the very ends.
    static HWY_INLINE F codeOf(F v, const Scale& mode) {
        const F scaled = hn::Abs(v) * mode.inverseStep;
        F code = hn::Floor(scaled);
        code = select(hn::And(code == zero(), scaled >= set(0.75f)), set(1.0f), code);
        code = select(hn::And(code >= mode.largestCode, scaled < mode.largestCode + set(0.25f)), mode.largestCode - set(1.0f), code);
        code = select(mode.exact, hn::Round(scaled), hn::Min(code, mode.largestCode));
        return kSigned ? hn::CopySign(code, v) : code;
    }
    static HWY_INLINE F valueOf(F code, const Scale& mode) {
        const F magnitude = kSigned ? hn::Abs(code) : code;
        F v = (magnitude + set(0.5f)) * mode.step;
        v = select(magnitude == zero(), zero(), v);
        v = select(magnitude >= mode.largestCode, set(Values::kLargest), v);
        // At sixteen bits there is nothing to scale.
        v = select(mode.exact, magnitude, v);
        return kSigned ? hn::CopySign(v, code) : v;
    }

    template <class Regions>
    static void codesOf(const Regions&, const Line* lines, const ModeLanes& mode, F (*code)[3]) {
        for (int r = 0; r < Regions::kCount; ++r)
            for (int c = 0; c < 3; ++c) {
                code[2 * r][c] = codeOf(lines[r].a[c], mode);
                code[2 * r + 1][c] = codeOf(lines[r].a[c] + lines[r].d[c], mode);
            }
    }
    template <class Regions>
    static M deltasFit(const Regions&, const F (*code)[3], const ModeLanes& mode) {
        M fits = zero() == zero();
        for (int c = 0; c < 3; ++c)
            for (int e = 1; e < 2 * Regions::kCount; ++e) {
                const F delta = code[e][c] - code[0][c];
                fits = hn::And(fits, hn::And(delta >= zero() - mode.deltaLimit[c], delta < mode.deltaLimit[c]));
            }
        return fits;
    }
    template <class Regions>
    static void clampDeltas(const Regions&, const ModeLanes& mode, F (*code)[3]) {
        const F low = kSigned ? zero() - mode.largestCode : zero();
        for (int c = 0; c < 3; ++c)
            for (int e = 1; e < 2 * Regions::kCount; ++e) {
                const F bounded = clamp(code[e][c], code[0][c] - mode.deltaLimit[c], code[0][c] + mode.deltaLimit[c] - set(1.0f));
                code[e][c] = clamp(bounded, low, mode.largestCode);
            }
    }
    template <class Regions>
    static void linesOf(const Regions&, const F (*code)[3], const ModeLanes& mode, Line* lines) {
        for (int r = 0; r < Regions::kCount; ++r)
            for (int c = 0; c < 3; ++c) {
                lines[r].a[c] = valueOf(code[2 * r][c], mode);
                lines[r].d[c] = valueOf(code[2 * r + 1][c], mode) - lines[r].a[c];
            }
    }

    /// The finest mode whose deltas hold these lines, lane by lane.
    template <class Regions>
    static ModeLanes finestMode(const Regions& regions, const Line* lines) {
        // From coarse to fine; the first needs no deltas and always holds.
        constexpr int kOne[] = {10, 11, 12, 13}, kTwo[] = {9, 1, 6, 7, 8, 5, 0, 2, 3, 4};
        const std::span<const int> order = Regions::kCount == 1 ? std::span<const int>(kOne) : std::span<const int>(kTwo);
        ModeLanes mode = modeLanes(order[0]);
        F code[4][3];
        int codedBits = 0;
        for (const int m : order.subspan(1)) {
            const ModeLanes finer = modeLanes(m);
            const int bits = kBc6hModes[static_cast<std::size_t>(m)].endpointBits;
            if (bits != codedBits) codesOf(regions, lines, finer, code);
            codedBits = bits;
            overrideWhere(deltasFit(regions, code, finer), finer, mode);
        }
        return mode;
    }

private:
    static HWY_INLINE F set(float value) { return hn::Set(D(), value); }
    static HWY_INLINE F zero() { return hn::Zero(D()); }
    static HWY_INLINE F clamp(F value, F low, F high) { return hn::Min(hn::Max(value, low), high); }
    static HWY_INLINE F select(M mask, F yes, F no) { return hn::IfThenElse(mask, yes, no); }
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif

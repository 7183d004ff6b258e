// BC6H: endpoints as codes of a mode, and back to v. Lanes may have different modes.
//
// A mode stores the first endpoint in endpointBits and, if transformed, the others as differences from it (deltas), which have to fit into
// fewer bits. finestMode picks the mode of the highest precision whose deltas can hold the given lines.
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
#include "compress/block/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D, bool kSigned>
class Bc6hCodes : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::M, typename Lanes<D>::DI, typename Lanes<D>::I;
    using Lanes<D>::set, Lanes<D>::zero, Lanes<D>::clamp, Lanes<D>::select;
    using Values = Bc6hValues<D, kSigned>;
    using Line = Bc6hLine<D>;

public:
    /// Quantization of the endpoints.
    struct Scale {
        F step, inverseStep, largestCode;
        M exact;  ///< 16 bits: the code is v itself
    };
    /// The mode of each lane.
    struct ModeLanes : Scale {
        I index;          ///< of kBc6hModes
        F deltaLimit[3];  ///< deltas are at least -limit and below the limit
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
    /// Replaces the mode where the mask is set.
    static void overrideWhere(M mask, const ModeLanes& with, ModeLanes& lanes) {
        lanes.index = hn::IfThenElse(hn::RebindMask(DI(), mask), with.index, lanes.index);
        lanes.step = select(mask, with.step, lanes.step);
        lanes.inverseStep = select(mask, with.inverseStep, lanes.inverseStep);
        lanes.largestCode = select(mask, with.largestCode, lanes.largestCode);
        for (int c = 0; c < 3; ++c) lanes.deltaLimit[c] = select(mask, with.deltaLimit[c], lanes.deltaLimit[c]);
        lanes.exact = hn::Or(hn::AndNot(mask, lanes.exact), hn::And(mask, with.exact));
    }

    /// Returns the code whose value is nearest to v. Values lie in the middle of their step, except for code 0 and the largest code, whose
    /// values are the ends of the scale.
    static HWY_INLINE F codeOf(F v, const Scale& mode) {
        const F scaled = hn::Abs(v) * mode.inverseStep;
        F code = hn::Floor(scaled);
        code = select(hn::And(code == zero(), scaled >= set(0.75f)), set(1.0f), code);
        code = select(hn::And(code >= mode.largestCode, scaled < mode.largestCode + set(0.25f)), mode.largestCode - set(1.0f), code);
        code = select(mode.exact, hn::Round(scaled), hn::Min(code, mode.largestCode));
        return kSigned ? hn::CopySign(code, v) : code;
    }
    /// Returns the v that a code stands for.
    static HWY_INLINE F valueOf(F code, const Scale& mode) {
        const F magnitude = kSigned ? hn::Abs(code) : code;
        F v = (magnitude + set(0.5f)) * mode.step;
        v = select(magnitude == zero(), zero(), v);
        v = select(magnitude >= mode.largestCode, set(Values::kLargest), v);
        v = select(mode.exact, magnitude, v);
        return kSigned ? hn::CopySign(v, code) : v;
    }

    /// Rounds the ends of the lines to codes. code[2r] and code[2r + 1] are the ends of region r.
    template <class Regions>
    static void codesOf(const Regions&, const Line* lines, const ModeLanes& mode, F (*code)[3]) {
        for (int r = 0; r < Regions::kCount; ++r)
            for (int c = 0; c < 3; ++c) {
                code[2 * r][c] = codeOf(lines[r].a[c], mode);
                code[2 * r + 1][c] = codeOf(lines[r].a[c] + lines[r].d[c], mode);
            }
    }
    /// Returns the lanes whose deltas the mode can store.
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
    /// Clamps the endpoints so that the mode can store their deltas.
    template <class Regions>
    static void clampDeltas(const Regions&, const ModeLanes& mode, F (*code)[3]) {
        const F low = kSigned ? zero() - mode.largestCode : zero();
        for (int c = 0; c < 3; ++c)
            for (int e = 1; e < 2 * Regions::kCount; ++e) {
                const F bounded = clamp(code[e][c], code[0][c] - mode.deltaLimit[c], code[0][c] + mode.deltaLimit[c] - set(1.0f));
                code[e][c] = clamp(bounded, low, mode.largestCode);
            }
    }
    /// Computes the lines that the codes stand for.
    template <class Regions>
    static void linesOf(const Regions&, const F (*code)[3], const ModeLanes& mode, Line* lines) {
        for (int r = 0; r < Regions::kCount; ++r)
            for (int c = 0; c < 3; ++c) {
                lines[r].a[c] = valueOf(code[2 * r][c], mode);
                lines[r].d[c] = valueOf(code[2 * r + 1][c], mode) - lines[r].a[c];
            }
    }

    /// Returns the modes with this number of regions, coarse to fine.
    template <class Regions>
    static std::span<const int> modesByPrecision() {
        return Regions::kCount == 1 ? std::span<const int>(kBc6hOneRegionModes) : std::span<const int>(kBc6hTwoRegionModes);
    }

    /// Returns for each lane the mode that lies `away` places further in modesByPrecision(), cyclically.
    template <class Regions>
    static ModeLanes modeBeside(const Regions&, const ModeLanes& mode, int away) {
        const std::span<const int> order = modesByPrecision<Regions>();
        const int count = static_cast<int>(order.size());
        const auto at = [&](int place) { return order[static_cast<std::size_t>((place + count) % count)]; };
        ModeLanes beside = modeLanes(at(away));
        for (int place = 1; place < count; ++place)
            overrideWhere(hn::RebindMask(D(), mode.index == hn::Set(DI(), at(place))), modeLanes(at(place + away)), beside);
        return beside;
    }

    /// Returns the finest mode whose deltas hold these lines, for each lane.
    template <class Regions>
    static ModeLanes finestMode(const Regions& regions, const Line* lines) {
        const std::span<const int> order = modesByPrecision<Regions>();
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
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif

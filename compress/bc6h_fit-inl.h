// The BC6H encoder's kernel: as many blocks as a vector has lanes, side by side. No lane ever meets another, and every step is a plain
// IEEE operation, so a block gets the same bits at any width.
//
// Words: v is the format's own scale, on which it interpolates: 0 .. 65535, or -32767 .. 32767 if signed. Nearly the bits of a half,
// times 64/31 (or 32/31), so nearly the logarithm of light. A code is an endpoint's stored integer. All of them fit a float exactly.
#if defined(LIGHTCOOK_COMPRESS_BC6H_FIT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC6H_FIT_INL_H_
#undef LIGHTCOOK_COMPRESS_BC6H_FIT_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC6H_FIT_INL_H_
#endif

#include <hwy/highway.h>

#include <cstring>

#include "compress/bc6h_modes.h"
#include "compress/bc6h_search.h"
#include "compress/block.h"
#include "compress/partitions.h"

HWY_BEFORE_NAMESPACE();
namespace compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D, bool kSigned>
class Bc6hFit {
    using F = hn::Vec<D>;
    using DI = hn::RebindToSigned<D>;
    using I = hn::Vec<DI>;
    using M = hn::Mask<D>;
    using Texels = F[kTexelCount];

public:
    Bc6hFit(const Bc6hSearch& search, const EncodeOptions& options) : search_(search), options_(options) {
        scale_ = options.hdrScale;
        isLog_ = options.hdrMetric == HdrMetric::Log;
    }

    /// Codes Lanes(d) blocks; results go to found, one after the other.
    void run(const Block* const* blocks, Bc6hResult* found) {
        load(blocks);
        clearBest();
        tryOneRegion();
        if (search_.partitions > 0) tryTwoRegions();
        descend();
        store(found);
    }

private:
    void clearBest() {
        best_.error = set(1e30f);
        best_.mode = best_.partition = hn::Zero(DI());
        for (auto& end : best_.code)
            for (F& code : end) code = zero();
        for (F& index : best_.index) index = zero();
    }

    /// The line between the two ends of a region, in v: from a to a + d.
    struct Line {
        F a[3], d[3];
    };
    /// What a mode asks of the codes, lane by lane.
    struct ModeLanes {
        I index;
        F step, inverseStep, largestCode, deltaLimit[3];
        M exact;  ///< 16 bits: the code is v itself
    };
    struct Candidate {
        F error;
        I mode, partition;
        F code[4][3];
        F index[kTexelCount];
    };
    /// Texels of region 1, and where its anchor is.
    struct Regions {
        M second[kTexelCount];
        M anchorAt[3];
    };
    static constexpr float kNear = 64.0f;
    static constexpr int kAnchors[3] = {2, 8, 15};  // of the first 32 partitions, and no other

    static HWY_INLINE F set(float value) { return hn::Set(D(), value); }
    static HWY_INLINE F zero() { return hn::Zero(D()); }
    static HWY_INLINE F clamp(F value, F low, F high) { return hn::Min(hn::Max(value, low), high); }
    static HWY_INLINE F select(M mask, F yes, F no) { return hn::IfThenElse(mask, yes, no); }
    static HWY_INLINE I bitsOf(F value) { return hn::BitCast(DI(), value); }
    static HWY_INLINE F floatOf(I bits) { return hn::BitCast(D(), bits); }

    // ---- The metric -------------------------------------------------------------------------------------------------------------

    /// log2(z) for z >= 1 to 2e-5: exponent, and a polynomial in the mantissa.
    static HWY_INLINE F log2(F z) {
        const I bits = bitsOf(z);
        const F exponent = hn::ConvertTo(D(), hn::ShiftRight<23>(bits) - hn::Set(DI(), 127));
        const F m = floatOf(hn::Or(hn::And(bits, hn::Set(DI(), 0x7FFFFF)), hn::Set(DI(), 0x3F800000))) - set(1.0f);
        F p = set(kBc6hLog2[4]);
        for (int i = 3; i >= 0; --i) p = p * m + set(kBc6hLog2[i]);
        return exponent + m * p;
    }
    /// The value whose squared differences are minimised, of light x.
    HWY_INLINE F metric(F x) const {
        if (!isLog_) return x;
        if constexpr (!kSigned) return log2(x * set(1.0f / scale_) + set(1.0f));
        return hn::CopySign(log2(hn::Abs(x) * set(1.0f / scale_) + set(1.0f)), x);
    }
    /// Light that an interpolated, whole v decodes to.
    static HWY_INLINE F lightOf(F v) {
        const I whole = hn::ConvertTo(DI(), kSigned ? hn::Abs(v) : v);
        const I half = hn::ShiftRight < kSigned ? 5 : 6 > (hn::ShiftLeft<5>(whole) - whole);
        const F x = floatOf(hn::ShiftLeft<13>(half)) * set(0x1p112f);
        return kSigned ? hn::CopySign(x, v) : x;
    }
    static constexpr float largestV() { return kSigned ? 32767.0f : 65535.0f; }
    static constexpr float smallestV() { return kSigned ? -32767.0f : 0.0f; }

    /// Middle of the vs that decode to the half nearest to x.
    static HWY_INLINE F vOf(F x) {
        const F magnitude = hn::Abs(x);
        const I bits = bitsOf(magnitude);
        const I odd = hn::And(hn::ShiftRight<13>(bits), hn::Set(DI(), 1));
        const I normal = hn::ShiftRight<13>(bits + hn::Set(DI(), 0x0FFF - 0x38000000) + odd);
        const I denormal = bitsOf(magnitude + set(0.5f)) - hn::Set(DI(), 0x3F000000);
        const I half = hn::IfThenElse(hn::RebindMask(DI(), magnitude < set(0x1p-14f)), denormal, normal);
        const F v = (hn::ConvertTo(D(), half) + set(0.5f)) * set(kSigned ? 32.0f / 31 : 64.0f / 31);
        const F signedV = kSigned ? hn::CopySign(v, x) : v;
        return select(hn::RebindMask(D(), half == hn::Zero(DI())), zero(), signedV);
    }

    // ---- Texels into lanes ------------------------------------------------------------------------------------------------------

    void load(const Block* const* blocks) {
        const D d;
        const std::size_t lanes = hn::Lanes(d);
        HWY_ALIGN float buffer[hn::MaxLanes(D())];
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            for (std::size_t lane = 0; lane < lanes; ++lane) buffer[lane] = blocks[lane]->significance[t];
            significance_[t] = hn::Load(d, buffer);
            for (std::size_t c = 0; c < 3; ++c) {
                for (std::size_t lane = 0; lane < lanes; ++lane) buffer[lane] = blocks[lane]->channel[c][t];
                // Adding zero turns -0 into 0, whose bits an unsigned block can hold.
                light_[c][t] = hn::Load(d, buffer) + zero();
            }
        }
        for (int c = 0; c < 3; ++c) {
            F low = set(1e30f), high = set(-1e30f);
            for (int t = 0; t < kTexelCount; ++t) {
                const M counts = significance_[t] > zero();
                target_[c][t] = vOf(light_[c][t]);
                value_[c][t] = metric(light_[c][t]);
                low = select(counts, hn::Min(low, target_[c][t]), low);
                high = select(counts, hn::Max(high, target_[c][t]), high);
            }
            weigh(c, high - low);
        }
        normalizeWeights();
    }

    /// Weights of a squared error in v: the slope of the metric, squared, measured across the error that is to be expected. The slope at
    /// the texel itself would be next to nothing at 0, and leave the dark beside a light to chance.
    void weigh(int c, F range) {
        const F reach = hn::Max(range * set(search_.slopeReach), set(64.0f));
        const F channelWeight = set(options_.channelWeights[static_cast<std::size_t>(c)]);
        for (int t = 0; t < kTexelCount; ++t) {
            const F below = clamp(target_[c][t] - reach, set(smallestV()), set(largestV()));
            const F above = clamp(target_[c][t] + reach, set(smallestV()), set(largestV()));
            const F slope = (metric(lightOf(hn::Floor(above))) - metric(lightOf(hn::Floor(below)))) / (above - below);
            F weight = significance_[t] * channelWeight;
            if (options_.hdrMetric == HdrMetric::Relative) {
                const F unit = hn::Abs(light_[c][t]) + set(scale_);
                weight = weight / (unit * unit);
            }
            errorWeight_[c][t] = weight;
            fitWeight_[c][t] = weight * slope * slope;
        }
    }

    /// Only ratios matter to a fit; the largest becomes 1 so that no product falls below what a float holds.
    void normalizeWeights() {
        F largest = set(1e-30f);
        for (int c = 0; c < 3; ++c)
            for (int t = 0; t < kTexelCount; ++t) largest = hn::Max(largest, fitWeight_[c][t]);
        weightScale_ = set(1.0f) / largest;
        for (int c = 0; c < 3; ++c)
            for (int t = 0; t < kTexelCount; ++t) fitWeight_[c][t] = fitWeight_[c][t] * weightScale_;
    }

    // ---- Lines through texels ---------------------------------------------------------------------------------------------------

    /// Weight of a texel in region r, zero outside.
    template <int kRegions>
    HWY_INLINE F inRegion(const Regions& regions, int r, int t, F weight) const {
        if constexpr (kRegions == 1) return weight;
        return r ? hn::IfThenElseZero(regions.second[t], weight) : hn::IfThenZeroElse(regions.second[t], weight);
    }
    template <int kRegions>
    HWY_INLINE F pick(const Regions& regions, int t, F first, F second) const {
        if constexpr (kRegions == 1) return first;
        return select(regions.second[t], second, first);
    }

    /// First positions, in [0, 1]: along the principal axis of each region, in the metric's own space.
    template <int kRegions>
    void startPositions(const Regions& regions, Texels& position) const {
        for (int r = 0; r < kRegions; ++r) {
            F total = set(1e-30f), mean[3] = {zero(), zero(), zero()};
            for (int t = 0; t < kTexelCount; ++t) {
                const F w = inRegion<kRegions>(regions, r, t, axisWeight_[t]);
                total = total + w;
                for (int c = 0; c < 3; ++c) mean[c] = mean[c] + w * axisSpace_[c][t];
            }
            const F share = set(1.0f) / total;
            for (int c = 0; c < 3; ++c) mean[c] = mean[c] * share;
            F m[6] = {zero(), zero(), zero(), zero(), zero(), zero()};  // xx xy xz yy yz zz
            for (int t = 0; t < kTexelCount; ++t) {
                const F w = inRegion<kRegions>(regions, r, t, axisWeight_[t]);
                const F x = axisSpace_[0][t] - mean[0], y = axisSpace_[1][t] - mean[1], z = axisSpace_[2][t] - mean[2];
                const F wx = w * x, wy = w * y;
                m[0] = m[0] + wx * x;
                m[1] = m[1] + wx * y;
                m[2] = m[2] + wx * z;
                m[3] = m[3] + wy * y;
                m[4] = m[4] + wy * z;
                m[5] = m[5] + w * z * z;
            }
            F axis[3];
            principalAxis(m, axis);
            F low = set(1e30f), high = set(-1e30f), along[kTexelCount];
            for (int t = 0; t < kTexelCount; ++t) {
                along[t] = (axisSpace_[0][t] - mean[0]) * axis[0] + (axisSpace_[1][t] - mean[1]) * axis[1] +
                           (axisSpace_[2][t] - mean[2]) * axis[2];
                const M counts = inRegion<kRegions>(regions, r, t, significance_[t]) > zero();
                low = select(counts, hn::Min(low, along[t]), low);
                high = select(counts, hn::Max(high, along[t]), high);
            }
            const F range = high - low;
            const F perRange = set(1.0f) / hn::Max(range, set(1e-20f));
            for (int t = 0; t < kTexelCount; ++t) {
                const F placed = clamp((along[t] - low) * perRange, zero(), set(1.0f));
                position[t] = r == 0 ? placed : pick<kRegions>(regions, t, position[t], placed);
            }
        }
    }

    /// Dominant eigenvector, largest component about 1, by power iteration from the row of the largest diagonal.
    static void principalAxis(const F (&m)[6], F (&axis)[3]) {
        const M yFirst = m[3] > m[0];
        for (int c = 0; c < 3; ++c) axis[c] = select(yFirst, c == 0 ? m[1] : c == 1 ? m[3] : m[4], m[c]);
        const M zFirst = m[5] > hn::Max(m[0], m[3]);
        axis[0] = select(zFirst, m[2], axis[0]);
        axis[1] = select(zFirst, m[4], axis[1]);
        axis[2] = select(zFirst, m[5], axis[2]);
        for (int iteration = 0; iteration < 4; ++iteration) {
            const F largest = hn::Max(hn::Max(hn::Abs(axis[0]), hn::Abs(axis[1])), hn::Max(hn::Abs(axis[2]), set(1e-30f)));
            const F scale = set(1.0f) / largest;
            const F x = axis[0] * scale, y = axis[1] * scale, z = axis[2] * scale;
            axis[0] = m[0] * x + m[1] * y + m[2] * z;
            axis[1] = m[1] * x + m[3] * y + m[4] * z;
            axis[2] = m[2] * x + m[4] * y + m[5] * z;
        }
        const F largest = hn::Max(hn::Max(hn::Abs(axis[0]), hn::Abs(axis[1])), hn::Max(hn::Abs(axis[2]), set(1e-30f)));
        for (F& a : axis) a = a / largest;
    }

    /// Least-squares lines for texels at these positions, channel by channel because each has weights of its own.
    template <int kRegions>
    void leastSquares(const Regions& regions, const Texels& position, const F (&weight)[3][kTexelCount], Line* lines) const {
        for (int r = 0; r < kRegions; ++r)
            for (int c = 0; c < 3; ++c) {
                // In terms of the mean and the deviation from it: no cancellation, and a constant falls out right.
                F total = set(1e-30f), meanK = zero(), meanT = zero();
                for (int t = 0; t < kTexelCount; ++t) {
                    const F w = inRegion<kRegions>(regions, r, t, weight[c][t]);
                    total = total + w;
                    meanK = meanK + w * position[t];
                    meanT = meanT + w * target_[c][t];
                }
                const F share = set(1.0f) / total;
                meanK = meanK * share;
                meanT = meanT * share;
                F kk = zero(), kt = zero();
                for (int t = 0; t < kTexelCount; ++t) {
                    const F w = inRegion<kRegions>(regions, r, t, weight[c][t]);
                    const F k = position[t] - meanK;
                    const F wk = w * k;
                    kk = kk + wk * k;
                    kt = kt + wk * (target_[c][t] - meanT);
                }
                const M distinct = kk > total * set(1e-12f);
                const F slope = hn::IfThenElseZero(distinct, kt / hn::Max(kk, set(1e-35f)));
                const F a = clamp(meanT - slope * meanK, set(smallestV()), set(largestV()));
                const F b = clamp(meanT + slope * (set(1.0f) - meanK), set(smallestV()), set(largestV()));
                lines[r].a[c] = a;
                lines[r].d[c] = b - a;
            }
    }

    /// Position of a texel along its line, unbounded: the nearest point in the weighted sense.
    HWY_INLINE F positionOn(const F (&a)[3], const F (&d)[3], int t) const {
        F along = zero(), length = set(1e-20f);
        for (int c = 0; c < 3; ++c) {
            const F wd = fitWeight_[c][t] * d[c];
            along = along + wd * (target_[c][t] - a[c]);
            length = length + wd * d[c];
        }
        return along / length;
    }
    template <int kRegions>
    HWY_INLINE void lineAt(const Regions& regions, const Line* lines, int t, F (&a)[3], F (&d)[3]) const {
        for (int c = 0; c < 3; ++c) {
            a[c] = pick<kRegions>(regions, t, lines[0].a[c], lines[kRegions - 1].a[c]);
            d[c] = pick<kRegions>(regions, t, lines[0].d[c], lines[kRegions - 1].d[c]);
        }
    }

    /// Turns lines round where their anchor lies beyond the middle: its index is stored without the highest bit.
    template <int kRegions>
    void orient(const Regions& regions, Line* lines) const {
        turnWhere(positionOn(lines[0].a, lines[0].d, 0) > set(0.5f), lines[0]);
        if constexpr (kRegions == 2) {
            F position = zero();
            for (int i = 0; i < 3; ++i) position = select(regions.anchorAt[i], positionOn(lines[1].a, lines[1].d, kAnchors[i]), position);
            turnWhere(position > set(0.5f), lines[1]);
        }
    }
    static HWY_INLINE void turnWhere(M mask, Line& line) {
        for (int c = 0; c < 3; ++c) {
            line.a[c] = select(mask, line.a[c] + line.d[c], line.a[c]);
            line.d[c] = select(mask, zero() - line.d[c], line.d[c]);
        }
    }

    template <int kRegions>
    static constexpr float steps() {
        return kRegions == 1 ? 15.0f : 7.0f;
    }

    /// Nearest index of each texel. Anchors keep to the lower half.
    template <int kRegions>
    void chooseIndices(const Regions& regions, const Line* lines, Texels& index) const {
        constexpr float kSteps = steps<kRegions>();
        for (int t = 0; t < kTexelCount; ++t) {
            F a[3], d[3];
            lineAt<kRegions>(regions, lines, t, a, d);
            index[t] = hn::Round(clamp(positionOn(a, d, t) * set(kSteps), zero(), set(kSteps)));
        }
        keepAnchorsLow<kRegions>(regions, index);
    }
    template <int kRegions>
    void keepAnchorsLow(const Regions& regions, Texels& index) const {
        const F half = set((steps<kRegions>() - 1) / 2);
        index[0] = hn::Min(index[0], half);
        if constexpr (kRegions == 2)
            for (int i = 0; i < 3; ++i)
                index[kAnchors[i]] = select(regions.anchorAt[i], hn::Min(index[kAnchors[i]], half), index[kAnchors[i]]);
    }

    /// The format's weights are these, rounded: 64 i / 7 and 64 i / 15.
    template <int kRegions>
    static HWY_INLINE F weightOfIndex(F index) {
        return hn::Round(index * set(64.0f / steps<kRegions>()));
    }
    /// What the format's interpolator makes of whole ends: floor((64 a + w d + 32) / 64), exact in a float.
    static HWY_INLINE F interpolate(F a, F d, F weight) {
        const F v = (a * set(64.0f) + d * weight + set(32.0f)) * set(1.0f / 64);
        return hn::Floor(v);
    }

    /// Error of whole-numbered lines in the metric, to the bit as a decoder sees them.
    template <int kRegions, bool kReweigh = true>
    F errorOf(const Regions& regions, const Line* lines, const Texels& index) {
        F error = zero();
        for (int t = 0; t < kTexelCount; ++t) {
            F a[3], d[3];
            lineAt<kRegions>(regions, lines, t, a, d);
            const F weight = weightOfIndex<kRegions>(index[t]);
            for (int c = 0; c < 3; ++c) {
                const F v = interpolate(a[c], d[c], weight);
                const F miss = metric(lightOf(v)) - value_[c][t];
                const F squared = errorWeight_[c][t] * miss * miss;
                error = error + squared;
                if constexpr (kReweigh) {
                    const F away = v - target_[c][t];
                    const F secant = squared * weightScale_ / hn::Max(away * away, set(kNear * kNear));
                    refitWeight_[c][t] = fitWeight_[c][t] * set(0.3f) + secant * set(0.7f);
                }
            }
        }
        return error;
    }

    // ---- Codes ------------------------------------------------------------------------------------------------------------------

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
    static HWY_INLINE F codeOf(F v, const ModeLanes& mode) {
        const F scaled = hn::Abs(v) * mode.inverseStep;
        F code = hn::Floor(scaled);
        code = select(hn::And(code == zero(), scaled >= set(0.75f)), set(1.0f), code);
        code = select(hn::And(code >= mode.largestCode, scaled < mode.largestCode + set(0.25f)), mode.largestCode - set(1.0f), code);
        code = select(mode.exact, hn::Round(scaled), hn::Min(code, mode.largestCode));
        return kSigned ? hn::CopySign(code, v) : code;
    }
    static HWY_INLINE F valueOf(F code, const ModeLanes& mode) {
        const F magnitude = kSigned ? hn::Abs(code) : code;
        F v = (magnitude + set(0.5f)) * mode.step;
        v = select(magnitude == zero(), zero(), v);
        v = select(magnitude >= mode.largestCode, set(largestV()), v);
        // At sixteen bits there is nothing to scale.
        v = select(mode.exact, magnitude, v);
        return kSigned ? hn::CopySign(v, code) : v;
    }

    template <int kRegions>
    static void codesOf(const Line* lines, const ModeLanes& mode, F (*code)[3]) {
        for (int r = 0; r < kRegions; ++r)
            for (int c = 0; c < 3; ++c) {
                code[2 * r][c] = codeOf(lines[r].a[c], mode);
                code[2 * r + 1][c] = codeOf(lines[r].a[c] + lines[r].d[c], mode);
            }
    }
    template <int kRegions>
    static M deltasFit(const F (*code)[3], const ModeLanes& mode) {
        M fits = zero() == zero();
        for (int c = 0; c < 3; ++c)
            for (int e = 1; e < 2 * kRegions; ++e) {
                const F delta = code[e][c] - code[0][c];
                fits = hn::And(fits, hn::And(delta >= zero() - mode.deltaLimit[c], delta < mode.deltaLimit[c]));
            }
        return fits;
    }
    template <int kRegions>
    static void clampDeltas(const ModeLanes& mode, F (*code)[3]) {
        const F low = kSigned ? zero() - mode.largestCode : zero();
        for (int c = 0; c < 3; ++c)
            for (int e = 1; e < 2 * kRegions; ++e) {
                const F bounded = clamp(code[e][c], code[0][c] - mode.deltaLimit[c], code[0][c] + mode.deltaLimit[c] - set(1.0f));
                code[e][c] = clamp(bounded, low, mode.largestCode);
            }
    }
    template <int kRegions>
    static void linesOf(const F (*code)[3], const ModeLanes& mode, Line* lines) {
        for (int r = 0; r < kRegions; ++r)
            for (int c = 0; c < 3; ++c) {
                lines[r].a[c] = valueOf(code[2 * r][c], mode);
                lines[r].d[c] = valueOf(code[2 * r + 1][c], mode) - lines[r].a[c];
            }
    }

    /// The finest mode whose deltas hold these lines, lane by lane.
    template <int kRegions>
    ModeLanes finestMode(const Line* lines) const {
        // From coarse to fine; the first needs no deltas and always holds.
        constexpr int kOne[] = {10, 11, 12, 13}, kTwo[] = {9, 1, 6, 7, 8, 5, 0, 2, 3, 4};
        const std::span<const int> order = kRegions == 1 ? std::span<const int>(kOne) : std::span<const int>(kTwo);
        ModeLanes mode = modeLanes(order[0]);
        F code[4][3];
        int codedBits = 0;
        for (const int m : order.subspan(1)) {
            const ModeLanes finer = modeLanes(m);
            const int bits = kBc6hModes[static_cast<std::size_t>(m)].endpointBits;
            if (bits != codedBits) codesOf<kRegions>(lines, finer, code);
            codedBits = bits;
            overrideWhere(deltasFit<kRegions>(code, finer), finer, mode);
        }
        return mode;
    }

    // ---- Search -----------------------------------------------------------------------------------------------------------------

    /// Rounds the lines to codes of the mode, and keeps them where they beat the best so far. index receives the texels' indices.
    template <int kRegions>
    F tryCodes(const Regions& regions, I partition, const ModeLanes& mode, F (*code)[3], Texels& index) {
        Line whole[2];
        linesOf<kRegions>(code, mode, whole);
        chooseIndices<kRegions>(regions, whole, index);
        const F error = errorOf<kRegions>(regions, whole, index);
        keepWhere<kRegions>(error < best_.error, error, partition, mode, code, index);
        return error;
    }
    template <int kRegions>
    void keepWhere(M better, F error, I partition, const ModeLanes& mode, const F (*code)[3], const Texels& index) {
        if (hn::AllFalse(D(), better)) return;
        const auto betterI = hn::RebindMask(DI(), better);
        best_.error = select(better, error, best_.error);
        best_.mode = hn::IfThenElse(betterI, mode.index, best_.mode);
        best_.partition = hn::IfThenElse(betterI, partition, best_.partition);
        for (int e = 0; e < 2 * kRegions; ++e)
            for (int c = 0; c < 3; ++c) best_.code[e][c] = select(better, code[e][c], best_.code[e][c]);
        for (int t = 0; t < kTexelCount; ++t) best_.index[t] = select(better, index[t], best_.index[t]);
    }

    /// Fits lines in these regions, picks the mode, and refits to what the codes made of them.
    template <int kRegions>
    void tryRegions(const Regions& regions, I partition, bool everyMode) {
        Texels position, index;
        Line lines[2];
        startPositions<kRegions>(regions, position);
        leastSquares<kRegions>(regions, position, fitWeight_, lines);
        std::memcpy(refitWeight_, fitWeight_, sizeof(fitWeight_));
        for (int i = 0; i < search_.freeRefits; ++i) refitFree<kRegions>(regions, index, lines);
        orient<kRegions>(regions, lines);
        const ModeLanes mode = finestMode<kRegions>(lines);
        F code[4][3];
        codesOf<kRegions>(lines, mode, code);
        clampDeltas<kRegions>(mode, code);
        tryCodes<kRegions>(regions, partition, mode, code, index);
        for (int i = 0; i < search_.codedRefits; ++i) {
            refit<kRegions>(regions, index, lines);
            codesOf<kRegions>(lines, mode, code);
            clampDeltas<kRegions>(mode, code);
            tryCodes<kRegions>(regions, partition, mode, code, index);
        }
        if (!everyMode) return;
        // A finer mode that has to cut a delta short, or a coarser one whose codes happen to lie better.
        for (int m = kRegions == 1 ? 10 : 0; m < (kRegions == 1 ? 14 : 10); ++m) {
            const ModeLanes other = modeLanes(m);
            codesOf<kRegions>(lines, other, code);
            clampDeltas<kRegions>(other, code);
            tryCodes<kRegions>(regions, partition, other, code, index);
        }
    }
    template <int kRegions>
    void refitFree(const Regions& regions, Texels& index, Line* lines) const {
        constexpr float kSteps = steps<kRegions>();
        for (int t = 0; t < kTexelCount; ++t) {
            F a[3], d[3];
            lineAt<kRegions>(regions, lines, t, a, d);
            index[t] = hn::Round(clamp(positionOn(a, d, t) * set(kSteps), zero(), set(kSteps)));
        }
        refit<kRegions>(regions, index, lines);
    }
    template <int kRegions>
    void refit(const Regions& regions, const Texels& index, Line* lines) const {
        Texels position;
        for (int t = 0; t < kTexelCount; ++t) position[t] = weightOfIndex<kRegions>(index[t]) * set(1.0f / 64);
        leastSquares<kRegions>(regions, position, refitWeight_, lines);
    }

    void tryOneRegion() {
        estimateSpace();
        axisSpace();
        const Regions everything{};
        tryRegions<1>(everything, hn::Zero(DI()), search_.everyMode > 0);
    }

    /// The space in which axes and partitions are judged: the metric's, channels scaled by the root of their weight, around the mean.
    void estimateSpace() {
        F total = zero(), mean[3] = {zero(), zero(), zero()};
        for (int t = 0; t < kTexelCount; ++t) {
            estimateWeight_[t] = significance_[t];
            if (options_.hdrMetric == HdrMetric::Relative) {
                const F unit = (hn::Abs(light_[0][t]) + hn::Abs(light_[1][t]) + hn::Abs(light_[2][t])) * set(1.0f / 3) + set(scale_);
                estimateWeight_[t] = significance_[t] / (unit * unit);
            }
            total = total + estimateWeight_[t];
            for (std::size_t c = 0; c < 3; ++c) {
                estimate_[c][t] = value_[c][t] * set(std::sqrt(options_.channelWeights[c]));
                mean[c] = mean[c] + estimateWeight_[t] * estimate_[c][t];
            }
        }
        const F share = set(1.0f) / total;
        for (int c = 0; c < 3; ++c)
            for (int t = 0; t < kTexelCount; ++t) estimate_[c][t] = estimate_[c][t] - mean[c] * share;
    }

    /// The space in which lines start: v, channels scaled by the root of their share of the weight.
    void axisSpace() {
        F total = set(1e-30f), share[3], mean[3];
        for (int c = 0; c < 3; ++c) share[c] = mean[c] = zero();
        for (int t = 0; t < kTexelCount; ++t) {
            axisWeight_[t] = fitWeight_[0][t] + fitWeight_[1][t] + fitWeight_[2][t];
            total = total + axisWeight_[t];
            for (int c = 0; c < 3; ++c) {
                share[c] = share[c] + fitWeight_[c][t];
                mean[c] = mean[c] + axisWeight_[t] * target_[c][t];
            }
        }
        for (int c = 0; c < 3; ++c) {
            const F scale = hn::Sqrt(share[c] / total);
            for (int t = 0; t < kTexelCount; ++t) axisSpace_[c][t] = (target_[c][t] - mean[c] / total) * scale;
        }
    }

    struct Moments {
        F v[10];  ///< w, wx, wy, wz, wxx, wxy, wxz, wyy, wyz, wzz
    };
    /// Error that is left of texels with these moments on their best line of kSteps + 1 values: what lies off the axis, and the width of a
    /// step. The largest eigenvalue is taken as the norm of the matrix: right where one direction rules, which is where it matters.
    static HWY_INLINE F estimateError(const F (&m)[10], float quantizationShare) {
        const F share = set(1.0f) / hn::Max(m[0], set(1e-30f));
        const F xx = m[4] - m[1] * m[1] * share, xy = m[5] - m[1] * m[2] * share, xz = m[6] - m[1] * m[3] * share;
        const F yy = m[7] - m[2] * m[2] * share, yz = m[8] - m[2] * m[3] * share, zz = m[9] - m[3] * m[3] * share;
        const F norm = hn::Sqrt(xx * xx + yy * yy + zz * zz + set(2.0f) * (xy * xy + xz * xz + yz * yz));
        return hn::Max(xx + yy + zz - norm, zero()) + norm * set(quantizationShare);
    }

    static constexpr int kMostPartitions = 32;
    /// Of the variance along the axis that seven steps leave: a little less than the 1/49 of even steps over even texels, measured.
    static constexpr float kStepShare = 1.0f / 200;
    void tryTwoRegions() {
        Moments moment[kTexelCount], total;
        for (F& v : total.v) v = zero();
        for (int t = 0; t < kTexelCount; ++t) {
            const F w = estimateWeight_[t], x = estimate_[0][t], y = estimate_[1][t], z = estimate_[2][t];
            const F wx = w * x, wy = w * y, wz = w * z;
            const F all[10] = {w, wx, wy, wz, wx * x, wx * y, wx * z, wy * y, wy * z, wz * z};
            for (int i = 0; i < 10; ++i) {
                moment[t].v[i] = all[i];
                total.v[i] = total.v[i] + all[i];
            }
        }
        const int keep = std::min(search_.partitions, kMostPartitions);
        F score[kMostPartitions];
        I kept[kMostPartitions];
        for (int i = 0; i < keep; ++i) {
            score[i] = set(1e30f);
            kept[i] = hn::Zero(DI());
        }
        for (int p = 0; p < kMostPartitions; ++p) {
            F first[10], second[10];
            for (int i = 0; i < 10; ++i) {
                F sum = zero();
                for (int t = 0; t < kTexelCount; ++t)
                    if ((kTwoRegions[static_cast<std::size_t>(p)] >> t) & 1) sum = sum + moment[t].v[i];
                second[i] = sum;
                first[i] = total.v[i] - sum;
            }
            F error = estimateError(first, kStepShare) + estimateError(second, kStepShare);
            I candidate = hn::Set(DI(), p);
            for (int i = 0; i < keep; ++i) {  // insertion: what is pushed out moves on
                const M better = error < score[i];
                const auto betterI = hn::RebindMask(DI(), better);
                const F lost = select(better, score[i], error);
                const I lostCandidate = hn::IfThenElse(betterI, kept[i], candidate);
                score[i] = hn::Min(score[i], error);
                kept[i] = hn::IfThenElse(betterI, candidate, kept[i]);
                error = lost;
                candidate = lostCandidate;
            }
        }
        for (int i = 0; i < keep; ++i) {
            const Regions regions = regionsOf(kept[i]);
            if (i >= search_.polished) {
                tryRegions<2>(regions, kept[i], i < search_.everyMode);
                continue;
            }
            // The best of each partition is stepped to its end before they are compared.
            const Candidate others = best_;
            clearBest();
            tryRegions<2>(regions, kept[i], i < search_.everyMode);
            for (int pass = 0; pass < search_.descents; ++pass)
                if (!descendOnce<2>(regions)) break;
            const M better = others.error < best_.error;
            best_.error = select(better, others.error, best_.error);
            best_.mode = hn::IfThenElse(hn::RebindMask(DI(), better), others.mode, best_.mode);
            best_.partition = hn::IfThenElse(hn::RebindMask(DI(), better), others.partition, best_.partition);
            for (int e = 0; e < 4; ++e)
                for (int c = 0; c < 3; ++c) best_.code[e][c] = select(better, others.code[e][c], best_.code[e][c]);
            for (int t = 0; t < kTexelCount; ++t) best_.index[t] = select(better, others.index[t], best_.index[t]);
        }
    }

    /// Mode of each lane's own best, and which lanes have this many regions.
    template <int kRegions>
    ModeLanes bestMode(M& mask) const {
        constexpr int kFirst = kRegions == 1 ? 10 : 0, kEnd = kRegions == 1 ? 14 : 10;
        ModeLanes mode = modeLanes(kFirst);
        mask = hn::RebindMask(D(), best_.mode == hn::Set(DI(), kFirst));
        for (int m = kFirst + 1; m < kEnd; ++m) {
            const M here = hn::RebindMask(D(), best_.mode == hn::Set(DI(), m));
            overrideWhere(here, modeLanes(m), mode);
            mask = hn::Or(mask, here);
        }
        return mode;
    }

    /// Steps of single codes of the best so far, for as long as they help.
    void descend() {
        for (int pass = 0; pass < search_.descents; ++pass) {
            const bool one = descendOnce<1>(Regions{});
            const bool two = search_.partitions > 0 && descendOnce<2>(regionsOf(best_.partition));
            if (!one && !two) return;
        }
    }
    template <int kRegions>
    bool descendOnce(const Regions& regions) {
        M mask;
        const ModeLanes mode = bestMode<kRegions>(mask);
        if (hn::AllFalse(D(), mask)) return false;
        // Of the first and the second end of a region: single steps, and both ends together or apart.
        constexpr float kMoves[8][2] = {{-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, 1}, {-1, 1}, {1, -1}};
        bool improved = false;
        for (int r = 0; r < kRegions; ++r)
            for (int c = 0; c < 3; ++c)
                for (int move = 0; move < (search_.pairs ? 8 : 4); ++move)
                    improved |= step<kRegions>(regions, mode, mask, r, c, kMoves[move][0], kMoves[move][1]);
        return improved;
    }
    template <int kRegions>
    bool step(const Regions& regions, const ModeLanes& mode, M mask, int r, int c, float first, float second) {
        F code[4][3];
        std::memcpy(code, best_.code, sizeof(code));
        const F low = kSigned ? zero() - mode.largestCode : zero();
        code[2 * r][c] = clamp(code[2 * r][c] + set(first), low, mode.largestCode);
        code[2 * r + 1][c] = clamp(code[2 * r + 1][c] + set(second), low, mode.largestCode);
        Line whole[2];
        Texels index;
        linesOf<kRegions>(code, mode, whole);
        chooseIndices<kRegions>(regions, whole, index);
        const F error = errorOf<kRegions, false>(regions, whole, index);
        const M better = hn::And(hn::And(mask, deltasFit<kRegions>(code, mode)), error < best_.error);
        keepWhere<kRegions>(better, error, best_.partition, mode, code, index);
        return !hn::AllFalse(D(), better);
    }

    /// Regions of each lane's own partition.
    static Regions regionsOf(I partition) {
        const D d;
        const DI di;
        HWY_ALIGN std::int32_t number[hn::MaxLanes(D())], shape[hn::MaxLanes(D())], anchor[hn::MaxLanes(D())];
        hn::Store(partition, di, number);
        for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) {
            shape[lane] = kTwoRegions[static_cast<std::size_t>(number[lane])];
            anchor[lane] = kTwoRegionsAnchor[static_cast<std::size_t>(number[lane])];
        }
        const I shapes = hn::Load(di, shape), anchors = hn::Load(di, anchor);
        Regions regions;
        for (int t = 0; t < kTexelCount; ++t) regions.second[t] = hn::RebindMask(d, hn::TestBit(shapes, hn::Set(di, 1 << t)));
        for (int i = 0; i < 3; ++i) regions.anchorAt[i] = hn::RebindMask(d, anchors == hn::Set(di, kAnchors[i]));
        return regions;
    }

    void store(Bc6hResult* found) const {
        const D d;
        const DI di;
        HWY_ALIGN std::int32_t buffer[hn::MaxLanes(D())];
        const std::size_t lanes = hn::Lanes(d);
        const auto each = [&](I value, auto assign) {
            hn::Store(value, di, buffer);
            for (std::size_t lane = 0; lane < lanes; ++lane) assign(found[lane], buffer[lane]);
        };
        each(best_.mode, [](Bc6hResult& r, std::int32_t v) { r.mode = v; });
        each(best_.partition, [](Bc6hResult& r, std::int32_t v) { r.partition = v; });
        for (std::size_t e = 0; e < 4; ++e)
            for (std::size_t c = 0; c < 3; ++c)
                each(hn::ConvertTo(di, best_.code[e][c]), [e, c](Bc6hResult& r, std::int32_t v) { r.code[e][c] = v; });
        for (std::size_t t = 0; t < kTexelCount; ++t)
            each(hn::ConvertTo(di, best_.index[t]), [t](Bc6hResult& r, std::int32_t v) { r.index[t] = static_cast<std::uint8_t>(v); });
    }

    const Bc6hSearch& search_;
    const EncodeOptions& options_;
    float scale_;
    bool isLog_;
    F light_[3][kTexelCount];        ///< as given
    F target_[3][kTexelCount];       ///< in v
    F value_[3][kTexelCount];        ///< in the metric
    F errorWeight_[3][kTexelCount];  ///< of a squared error in the metric
    F fitWeight_[3][kTexelCount];    ///< of a squared error in v
    F refitWeight_[3][kTexelCount];
    F weightScale_;
    F significance_[kTexelCount];
    F estimate_[3][kTexelCount];
    F axisSpace_[3][kTexelCount];
    F axisWeight_[kTexelCount];
    F estimateWeight_[kTexelCount];
    Candidate best_;
};

}  // namespace HWY_NAMESPACE
}  // namespace compress
HWY_AFTER_NAMESPACE();
#endif

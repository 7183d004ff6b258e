// BC6H at low effort: from rows of texels to packed blocks without leaving the lanes, as many neighbouring blocks as a vector has lanes.
// One region only. No lane ever meets another and every step is a plain IEEE operation, so a block gets the same bits at any width.
#if defined(LIGHTCOOK_COMPRESS_BC6H_FAST_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC6H_FAST_INL_H_
#undef LIGHTCOOK_COMPRESS_BC6H_FAST_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC6H_FAST_INL_H_
#endif

#include <hwy/highway.h>

#include <limits>

#include "compress/bc6h/values-inl.h"
#include "compress/block/block.h"
#include "compress/block/principal_axis-inl.h"
#include "compress/block/texel_rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D, bool kSigned>
class Bc6hFast {
    using F = hn::Vec<D>;
    using DI = hn::RebindToSigned<D>;
    using DU = hn::RebindToUnsigned<D>;
    using I = hn::Vec<DI>;
    using U = hn::Vec<DU>;
    using M = hn::Mask<D>;
    using Values = Bc6hValues<D, kSigned>;
    static constexpr std::size_t kLanes = hn::MaxLanes(D());
    /// In octaves of v, where all of a half's denormals are one: what a channel may span within a block, and in the dark.
    static constexpr float kWide = 4, kWideElsewhere = 1, kDark = 2, kDarkRange = 1.0f / 64;

public:
    explicit Bc6hFast(const EncodeOptions& options) : options_(options), isLinear_(options.hdrMetric == HdrMetric::Linear) {}

    /// Codes Lanes(d) blocks side by side.
    /// texels   four rows of 4 Lanes(d) texels of four floats
    /// weights  four rows of significance, or null for 1 everywhere
    /// out      four words a block
    /// errors   receives the mean square error that each block is left with, about in octaves, or is null. Infinity where it cannot
    ///          be told: see errorLeft
    /// Returns whether a value lay outside the format's range, and was clamped.
    bool run(const std::array<const float*, 4>& texels, const std::array<const float*, 4>* weights, std::uint32_t* out, float* errors) {
        const bool clamped = load(texels);
        if (weights)
            loadSignificance(*weights);
        else
            countAll();
        weigh();
        startLine();
        chooseIndices();
        for (int t = 0; t < kTexelCount; ++t) position_[t] = index_[t] * set(1.0f / 15);
        leastSquares();
        code();
        pack(out);
        if (errors) hn::StoreU(errorLeft(), D(), errors);
        return clamped;
    }

private:
    static HWY_INLINE F set(float value) { return hn::Set(D(), value); }
    static HWY_INLINE F zero() { return hn::Zero(D()); }
    static HWY_INLINE F clamp(F value, F low, F high) { return hn::Min(hn::Max(value, low), high); }
    static HWY_INLINE F select(M mask, F yes, F no) { return hn::IfThenElse(mask, yes, no); }
    static HWY_INLINE I bitsOf(F value) { return hn::BitCast(DI(), value); }
    static HWY_INLINE F floatOf(I bits) { return hn::BitCast(D(), bits); }
    // ---- Texels into lanes ------------------------------------------------------------------------------------------------------

    /// Four consecutive floats of each lane's, into four vectors.
    static HWY_INLINE void byFours(const float* from, F& a, F& b, F& c, F& d) { hn::LoadInterleaved4(D(), from, a, b, c, d); }

    bool load(const std::array<const float*, 4>& texels) {
        const D d;
        HWY_ALIGN float plane[3][4 * kLanes];
        F lowest = zero(), highest = zero();
        for (std::size_t y = 0; y < 4; ++y) {
            for (std::size_t part = 0; part < 4; ++part) {
                F x[4];
                byFours(texels[y] + part * 4 * hn::Lanes(d), x[0], x[1], x[2], x[3]);
                for (std::size_t c = 0; c < 3; ++c) {
                    lowest = hn::Min(lowest, x[c]);
                    highest = hn::Max(highest, x[c]);
                    hn::Store(vOf(x[c]), d, plane[c] + part * hn::Lanes(d));
                }
            }
            for (std::size_t c = 0; c < 3; ++c) byFours(plane[c], v_[c][4 * y], v_[c][4 * y + 1], v_[c][4 * y + 2], v_[c][4 * y + 3]);
        }
        const M below = lowest < set(kSigned ? -65504.0f : 0.0f);
        return !hn::AllFalse(d, hn::Or(below, highest > set(65504.0f)));
    }
    /// Of a value within the range or beyond: see Bc6hValues::vOf. Zero is half a step off here, which decodes to zero all the same.
    static HWY_INLINE F vOf(F x) {
        const F magnitude = hn::Min(kSigned ? hn::Abs(x) : hn::Max(x, zero()), set(65504.0f));
        // 2^-112 moves the exponent to a half's, denormals and all; the bits above the thirteenth are then the half, rounded like one.
        const F half = hn::Round(hn::ConvertTo(D(), bitsOf(magnitude * set(0x1p-112f))) * set(0x1p-13f));
        const F v = hn::MulAdd(half, set(Values::kPerHalf), set(Values::kPerHalf / 2));
        return kSigned ? hn::CopySign(v, x + zero()) : v;
    }

    void countAll() {
        for (F& s : significance_) s = set(1.0f);
        nothing_ = set(1.0f) < zero();
    }
    /// Texels that weigh nothing take the place of one that counts; blocks that weigh nothing count throughout.
    void loadSignificance(const std::array<const float*, 4>& weights) {
        loadWeights<D>(weights, significance_, nothing_);
        M all = zero() == zero();
        for (const F& s : significance_) all = hn::And(all, s > zero());
        if (hn::AllTrue(D(), all)) return;
        F stand[3] = {zero(), zero(), zero()};
        for (int t = 0; t < kTexelCount; ++t)
            for (int c = 0; c < 3; ++c) stand[c] = select(significance_[t] > zero(), v_[c][t], stand[c]);
        for (int t = 0; t < kTexelCount; ++t)
            for (int c = 0; c < 3; ++c) v_[c][t] = select(significance_[t] > zero(), v_[c][t], stand[c]);
    }

    /// Weights of a squared error in v: the square of the metric's slope. It is taken a little above the texel, for the slope at the texel
    /// itself would be next to nothing at 0, and leave the dark beside a light to chance.
    void weigh() {
        for (int c = 0; c < 3; ++c) {
            low_[c] = high_[c] = v_[c][0];
            for (int t = 1; t < kTexelCount; ++t) {
                low_[c] = hn::Min(low_[c], v_[c][t]);
                high_[c] = hn::Max(high_[c], v_[c][t]);
            }
            const F reach = hn::MulAdd(high_[c] - low_[c], set(1.0f / 16), set(64.0f));
            const F channelWeight = set(options_.channelWeights[static_cast<std::size_t>(c)]);
            for (int t = 0; t < kTexelCount; ++t) {
                const F above = hn::Min((kSigned ? hn::Abs(v_[c][t]) : v_[c][t]) + reach, set(Values::kLargest));
                const F x = floatOf(hn::ConvertTo(DI(), above * set(8192 / Values::kPerHalf))) * set(0x1p112f);
                const F slope = isLinear_ ? x * set(1.0f / 65504) : x * roughInverse<D>(x + set(options_.hdrScale));
                weight_[c][t] = significance_[t] * channelWeight * (slope * slope);
            }
        }
    }

    // ---- The line ---------------------------------------------------------------------------------------------------------------

    /// Along the principal axis of v, channels scaled by the root of their share of the weight.
    void startLine() {
        F total = set(1e-30f), share[3] = {zero(), zero(), zero()}, mean[3] = {zero(), zero(), zero()};
        F texel[kTexelCount];
        for (int t = 0; t < kTexelCount; ++t) {
            texel[t] = weight_[0][t] + weight_[1][t] + weight_[2][t];
            for (int c = 0; c < 3; ++c) {
                share[c] = share[c] + weight_[c][t];
                mean[c] = hn::MulAdd(texel[t], v_[c][t], mean[c]);
            }
        }
        total = total + (share[0] + share[1] + share[2]);
        const F perTotal = set(1.0f) / total;
        F scale[3];
        for (int c = 0; c < 3; ++c) {
            mean[c] = mean[c] * perTotal;
            scale[c] = hn::Sqrt(share[c] * perTotal);
        }
        F m[6] = {zero(), zero(), zero(), zero(), zero(), zero()};  // xx xy xz yy yz zz
        for (int t = 0; t < kTexelCount; ++t) {
            const F x = v_[0][t] - mean[0], y = v_[1][t] - mean[1], z = v_[2][t] - mean[2];
            const F wx = texel[t] * x, wy = texel[t] * y, wz = texel[t] * z;
            m[0] = hn::MulAdd(wx, x, m[0]);
            m[1] = hn::MulAdd(wx, y, m[1]);
            m[2] = hn::MulAdd(wx, z, m[2]);
            m[3] = hn::MulAdd(wy, y, m[3]);
            m[4] = hn::MulAdd(wy, z, m[4]);
            m[5] = hn::MulAdd(wz, z, m[5]);
        }
        constexpr int kRow[6] = {0, 0, 0, 1, 1, 2}, kColumn[6] = {0, 1, 2, 1, 2, 2};
        for (int i = 0; i < 6; ++i) m[i] = m[i] * (scale[kRow[i]] * scale[kColumn[i]]);
        F axis[3];
        principalAxis<D>(m, 3, axis);
        for (int c = 0; c < 3; ++c) axis[c] = axis[c] * scale[c];
        F low = set(1e30f), high = set(-1e30f);
        for (int t = 0; t < kTexelCount; ++t) {
            const F x = v_[0][t] - mean[0], y = v_[1][t] - mean[1], z = v_[2][t] - mean[2];
            position_[t] = hn::MulAdd(x, axis[0], hn::MulAdd(y, axis[1], z * axis[2]));
            low = hn::Min(low, position_[t]);
            high = hn::Max(high, position_[t]);
        }
        const F perRange = set(1.0f) / hn::Max(high - low, set(1e-20f));
        for (F& p : position_) p = (p - low) * perRange;
        leastSquares();
    }

    /// Least-squares line for texels at these positions, channel by channel because each has weights of its own.
    void leastSquares() {
        for (int c = 0; c < 3; ++c) {
            // In terms of the mean and the deviation from it: no cancellation, and a constant falls out right.
            F total = set(1e-30f), meanK = zero(), meanV = zero();
            for (int t = 0; t < kTexelCount; ++t) {
                const F w = weight_[c][t];
                total = total + w;
                meanK = hn::MulAdd(w, position_[t], meanK);
                meanV = hn::MulAdd(w, v_[c][t], meanV);
            }
            const F share = set(1.0f) / total;
            meanK = meanK * share;
            meanV = meanV * share;
            F kk = zero(), kv = zero();
            for (int t = 0; t < kTexelCount; ++t) {
                const F k = position_[t] - meanK;
                const F wk = weight_[c][t] * k;
                kk = hn::MulAdd(wk, k, kk);
                kv = hn::MulAdd(wk, v_[c][t] - meanV, kv);
            }
            const F slope = hn::IfThenElseZero(kk > total * set(1e-12f), kv / hn::Max(kk, set(1e-35f)));
            // Ends far outside of what the block holds serve rounding errors; where it holds one value they are that value.
            const F slack = (high_[c] - low_[c]) * set(0.25f);
            const F least = hn::Max(low_[c] - slack, set(Values::kSmallest)), most = hn::Min(high_[c] + slack, set(Values::kLargest));
            a_[c] = clamp(hn::NegMulAdd(slope, meanK, meanV), least, most);
            d_[c] = clamp(hn::MulAdd(slope, set(1.0f) - meanK, meanV), least, most) - a_[c];
        }
    }

    /// Nearest of the sixteen places on the line for each texel.
    void chooseIndices() {
        for (int t = 0; t < kTexelCount; ++t) {
            F along = zero(), length = set(1e-20f);
            for (int c = 0; c < 3; ++c) {
                const F wd = weight_[c][t] * d_[c];
                along = hn::MulAdd(wd, v_[c][t] - a_[c], along);
                length = hn::MulAdd(wd, d_[c], length);
            }
            index_[t] = hn::Round(clamp(along * roughInverse<D>(length) * set(15.0f), zero(), set(15.0f)));
        }
    }

    // ---- Codes ------------------------------------------------------------------------------------------------------------------

    /// Rounds the line's ends to codes of the finest mode that holds them, makes it the line that they decode to, and picks indices.
    void code() {
        F end[2][3], spread = zero(), spread11 = zero(), spread12 = zero();
        for (int c = 0; c < 3; ++c) {
            end[0][c] = a_[c];
            end[1][c] = a_[c] + d_[c];
            spread = hn::Max(spread, hn::Abs(hn::Round(end[0][c]) - hn::Round(end[1][c])));
            spread12 = hn::Max(spread12, hn::Abs(hn::Floor(end[0][c] * set(1.0f / 16)) - hn::Floor(end[1][c] * set(1.0f / 16))));
            spread11 = hn::Max(spread11, hn::Abs(hn::Floor(end[0][c] * set(1.0f / 32)) - hn::Floor(end[1][c] * set(1.0f / 32))));
        }
        // One less than a delta holds, for codes at the very ends may move by one, and the ends must be free to change places.
        is16_ = spread < set(7.5f);
        is12_ = hn::AndNot(is16_, spread12 < set(126.5f));
        is11_ = hn::AndNot(hn::Or(is16_, is12_), spread11 < set(254.5f));
        const F step = select(is12_, set(16.0f), select(is11_, set(32.0f), set(64.0f)));
        const F inverse = select(is12_, set(1.0f / 16), select(is11_, set(1.0f / 32), set(1.0f / 64)));
        const F largest = hn::MulAdd(inverse, set(kSigned ? 32768.0f : 65536.0f), set(-1.0f));
        F value[2][3];
        for (int e = 0; e < 2; ++e)
            for (int c = 0; c < 3; ++c) {
                const F scaled = hn::Abs(end[e][c]) * inverse;
                // Values lie in the middle of their step, but those of 0 and of the largest code at the very ends.
                F code = hn::Floor(scaled);
                code = select(hn::And(code == zero(), scaled >= set(0.75f)), set(1.0f), code);
                code = select(hn::And(code >= largest, scaled < largest + set(0.25f)), largest - set(1.0f), code);
                code = hn::Min(code, largest);
                F v = hn::MulAdd(code, step, step * set(0.5f));
                v = select(code == zero(), zero(), v);
                v = select(code >= largest, set(Values::kLargest), v);
                const F exact = hn::Round(hn::Abs(end[e][c]));
                code = select(is16_, exact, code);
                v = select(is16_, exact, v);
                code_[e][c] = kSigned ? hn::CopySign(code, end[e][c]) : code;
                value[e][c] = kSigned ? hn::CopySign(v, end[e][c]) : v;
            }
        for (int c = 0; c < 3; ++c) {
            a_[c] = value[0][c];
            d_[c] = value[1][c] - value[0][c];
        }
        chooseIndices();
    }

    /// Mean square of what the indices miss, about in octaves; 0 of blocks that weigh nothing. Infinity, of any block, where slopes
    /// of the metric tell nothing, and where one colour would miss less.
    F errorLeft() const {
        F error = zero(), oneColour = zero(), range = zero(), darkest = set(Values::kLargest), total = zero();
        for (const F& s : significance_) total = total + s;
        for (int c = 0; c < 3; ++c) {
            F sum = zero(), squares = zero(), weights = set(1e-30f);
            for (int t = 0; t < kTexelCount; ++t) {
                const F away = hn::NegMulAdd(d_[c], index_[t] * set(1.0f / 15), v_[c][t] - a_[c]);
                error = hn::MulAdd(weight_[c][t] * away, away, error);
                const F beside = v_[c][t] - low_[c], weighted = weight_[c][t] * beside;
                weights = weights + weight_[c][t];
                sum = sum + weighted;
                squares = hn::MulAdd(weighted, beside, squares);
            }
            oneColour = oneColour + hn::NegMulAdd(sum, sum / weights, squares);
            range = hn::Max(range, high_[c] - low_[c]);
            // How near to 0 the channel comes: 0 itself where signs differ. Where time is not all that counts, what is negative is left to
            // the slower kernel too, which is better at it by 0.1 dB.
            const F nearest = hn::Max(hn::Max(low_[c], zero() - high_[c]), zero());
            darkest = hn::Min(darkest, kSigned && options_.effort == 0 ? nearest : low_[c]);
        }
        constexpr float kOctave = 1024 * Values::kPerHalf;
        const M dark = hn::And(darkest<set(kDark * kOctave), range> set(kDarkRange * kOctave));
        const float wide = (options_.hdrMetric == HdrMetric::Log ? kWide : kWideElsewhere) * kOctave;
        const M doubtful = hn::Or(hn::Or(dark, range > set(wide)), hn::And(error > oneColour, range > zero()));
        error = hn::IfThenZeroElse(nothing_, error / (total * set(3 * kOctave * kOctave)));
        return select(doubtful, set(std::numeric_limits<float>::infinity()), error);
    }

    /// A code's bits go up; those of the first end's that do not fit its ten bits lie in the second's field, highest first.
    void pack(std::uint32_t* out) const {
        const DI di;
        const M turned = index_[0] > set(7.5f);
        I word[4];
        word[0] = byMode(0x03, 0x07, 0x0B, 0x0F);
        word[1] = word[2] = word[3] = hn::Zero(di);
        const I deltaMask = byMode(0x3FF, 0x1FF, 0xFF, 0xF), highMask = byMode(0, 1, 3, 63);
        const auto isDelta = hn::RebindMask(di, hn::Or(is16_, hn::Or(is12_, is11_)));
        I field[2][3];
        for (int c = 0; c < 3; ++c) {
            const I first = hn::ConvertTo(di, select(turned, code_[1][c], code_[0][c]));
            const I second = hn::ConvertTo(di, select(turned, code_[0][c], code_[1][c]));
            field[0][c] = hn::And(first, hn::Set(di, 0x3FF));
            const I stored = hn::IfThenElse(isDelta, second - first, second);
            const I high = hn::And(hn::ShiftRight<10>(first), highMask);
            field[1][c] = hn::Or(hn::And(stored, deltaMask), hn::ShiftLeft<4>(reversed6(high)));
        }
        word[0] =
            hn::Or(hn::Or(word[0], hn::ShiftLeft<5>(field[0][0])), hn::Or(hn::ShiftLeft<15>(field[0][1]), hn::ShiftLeft<25>(field[0][2])));
        word[1] = hn::Or(hn::Or(hn::ShiftRight<7>(field[0][2]), hn::ShiftLeft<3>(field[1][0])),
                         hn::Or(hn::ShiftLeft<13>(field[1][1]), hn::ShiftLeft<23>(field[1][2])));
        const F start = hn::IfThenElseZero(turned, set(15.0f));
        const auto indexAt = [&](int t) { return hn::ConvertTo(di, hn::Abs(index_[t] - start)); };
        word[2] = hn::Or(hn::ShiftRight<9>(field[1][2]), hn::ShiftLeft<1>(indexAt(0)));
        word[2] = hn::Or(
            hn::Or(hn::Or(word[2], hn::ShiftLeft<4>(indexAt(1))), hn::Or(hn::ShiftLeft<8>(indexAt(2)), hn::ShiftLeft<12>(indexAt(3)))),
            hn::Or(hn::Or(hn::ShiftLeft<16>(indexAt(4)), hn::ShiftLeft<20>(indexAt(5))),
                   hn::Or(hn::ShiftLeft<24>(indexAt(6)), hn::ShiftLeft<28>(indexAt(7)))));
        word[3] = hn::Or(
            hn::Or(hn::Or(indexAt(8), hn::ShiftLeft<4>(indexAt(9))), hn::Or(hn::ShiftLeft<8>(indexAt(10)), hn::ShiftLeft<12>(indexAt(11)))),
            hn::Or(hn::Or(hn::ShiftLeft<16>(indexAt(12)), hn::ShiftLeft<20>(indexAt(13))),
                   hn::Or(hn::ShiftLeft<24>(indexAt(14)), hn::ShiftLeft<28>(indexAt(15)))));
        const DU du;
        hn::StoreInterleaved4(hn::BitCast(du, word[0]), hn::BitCast(du, word[1]), hn::BitCast(du, word[2]), hn::BitCast(du, word[3]), du,
                              out);
    }
    HWY_INLINE I byMode(int ten, int eleven, int twelve, int sixteen) const {
        const DI di;
        const I upTo11 = hn::IfThenElse(hn::RebindMask(di, is11_), hn::Set(di, eleven), hn::Set(di, ten));
        const I upTo12 = hn::IfThenElse(hn::RebindMask(di, is12_), hn::Set(di, twelve), upTo11);
        return hn::IfThenElse(hn::RebindMask(di, is16_), hn::Set(di, sixteen), upTo12);
    }
    /// Six bits in the other order.
    static HWY_INLINE I reversed6(I x) {
        const DI di;
        const auto only = [&](int bit) { return hn::And(x, hn::Set(di, 1 << bit)); };
        const I up = hn::Or(hn::ShiftLeft<5>(only(0)), hn::Or(hn::ShiftLeft<3>(only(1)), hn::ShiftLeft<1>(only(2))));
        const I down = hn::Or(hn::ShiftRight<1>(only(3)), hn::Or(hn::ShiftRight<3>(only(4)), hn::ShiftRight<5>(only(5))));
        return hn::Or(up, down);
    }

    const EncodeOptions& options_;
    bool isLinear_;
    F significance_[kTexelCount];
    F v_[3][kTexelCount], low_[3], high_[3];
    F weight_[3][kTexelCount];  ///< of a squared error in v
    F position_[kTexelCount], index_[kTexelCount];
    F a_[3], d_[3];  ///< the line, in v: from a to a + d
    F code_[2][3];
    M is16_, is12_, is11_;
    M nothing_;  ///< blocks whose texels all weigh nothing
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif

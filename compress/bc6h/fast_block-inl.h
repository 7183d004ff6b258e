// BC6H, fast kernel: endpoint codes of the four one-region modes, and the bits of a block.
#if defined(LIGHTCOOK_COMPRESS_BC6H_FAST_BLOCK_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC6H_FAST_BLOCK_INL_H_
#undef LIGHTCOOK_COMPRESS_BC6H_FAST_BLOCK_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC6H_FAST_BLOCK_INL_H_
#endif

#include <hwy/highway.h>

#include <cstdint>

#include "compress/bc6h/values-inl.h"
#include "compress/block/lanes-inl.h"
#include "compress/block/pairs-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// A line, in v, from a to a + d.
template <class D>
struct Bc6hFastLineEnds {
    hn::Vec<D> a[3], d[3];
};

template <class D, bool kSigned>
class Bc6hFastBlock : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::M, typename Lanes<D>::DI, typename Lanes<D>::DU, typename Lanes<D>::I;
    using Lanes<D>::set, Lanes<D>::zero, Lanes<D>::select;
    using Values = Bc6hValues<D, kSigned>;
    using Line = Bc6hFastLineEnds<D>;
    using S = typename Pairs<D>::S;

public:
    /// Rounds the ends of the line to codes of the finest mode that holds them, and replaces the line by the one that these codes decode
    /// to.
    void quantize(Line& line) {
        F end[2][3], spread = zero(), spread11 = zero(), spread12 = zero();
        for (int c = 0; c < 3; ++c) {
            end[0][c] = line.a[c];
            end[1][c] = line.a[c] + line.d[c];
            spread = hn::Max(spread, hn::Abs(hn::Round(end[0][c]) - hn::Round(end[1][c])));
            spread12 = hn::Max(spread12, hn::Abs(hn::Floor(end[0][c] * set(1.0f / 16)) - hn::Floor(end[1][c] * set(1.0f / 16))));
            spread11 = hn::Max(spread11, hn::Abs(hn::Floor(end[0][c] * set(1.0f / 32)) - hn::Floor(end[1][c] * set(1.0f / 32))));
        }
        // Limits are one less than a delta holds: codes at the ends of the scale may move by one, and the ends may have to swap places.
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
                // Values lie in the middle of their step, except for code 0 and the largest code: see Bc6hCodes::codeOf.
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
            line.a[c] = value[0][c];
            line.d[c] = value[1][c] - value[0][c];
        }
    }

    /// Packs the codes and the indices of the texels into four words per block.
    /// Fields of the one-region modes: mode (5 bits); the low 10 bits of the first end, by channel; then by channel the second end or its
    /// delta, followed by the bits of the first end above the tenth, highest first, in the rest of the 10-bit field; the indices. Texel 0
    /// is the anchor: its index has three bits, so the ends are swapped where it is above 7.
    void pack(const F (&index)[kTexelCount], std::uint32_t* out) const {
        const DI di;
        const M turned = index[0] > set(7.5f);
        I word[4];
        packHead(turned, word);
        const F start = hn::IfThenElseZero(turned, set(15.0f));
        const auto indexAt = [&](int t) { return hn::ConvertTo(di, hn::Abs(index[t] - start)); };
        word[2] = hn::Or(word[2], hn::ShiftLeft<1>(indexAt(0)));
        word[2] = hn::Or(
            hn::Or(hn::Or(word[2], hn::ShiftLeft<4>(indexAt(1))), hn::Or(hn::ShiftLeft<8>(indexAt(2)), hn::ShiftLeft<12>(indexAt(3)))),
            hn::Or(hn::Or(hn::ShiftLeft<16>(indexAt(4)), hn::ShiftLeft<20>(indexAt(5))),
                   hn::Or(hn::ShiftLeft<24>(indexAt(6)), hn::ShiftLeft<28>(indexAt(7)))));
        word[3] = hn::Or(
            hn::Or(hn::Or(indexAt(8), hn::ShiftLeft<4>(indexAt(9))), hn::Or(hn::ShiftLeft<8>(indexAt(10)), hn::ShiftLeft<12>(indexAt(11)))),
            hn::Or(hn::Or(hn::ShiftLeft<16>(indexAt(12)), hn::ShiftLeft<20>(indexAt(13))),
                   hn::Or(hn::ShiftLeft<24>(indexAt(14)), hn::ShiftLeft<28>(indexAt(15)))));
        store(word, out);
    }
    /// The same for indices of texels t and t + 4 in a lane, rows 0 and 1 first.
    void packIndices(const S (&index)[kTexelCount / 2], std::uint32_t* out) const {
        const DI di;
        const auto join = [&](const S* row) {
            const S all = hn::Or(hn::Or(row[0], hn::ShiftLeft<4>(row[1])), hn::Or(hn::ShiftLeft<8>(row[2]), hn::ShiftLeft<12>(row[3])));
            return hn::BitCast(di, all);
        };
        const I front = join(index), back = join(index + 4);
        const auto isTurned = hn::TestBit(front, hn::Set(di, 8));
        const I flip = hn::VecFromMask(di, isTurned), indices = hn::Xor(front, flip);
        I word[4];
        packHead(hn::RebindMask(D(), isTurned), word);
        word[2] = hn::Or(word[2], indices + hn::And(indices, hn::Set(di, 7)));
        word[3] = hn::Xor(back, flip);
        store(word, out);
    }

private:
    /// Sets the mode, the ends, and the first bit of the third word.
    HWY_INLINE void packHead(M turned, I (&word)[4]) const {
        const DI di;
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
        const I mode = byMode(0x03, 0x07, 0x0B, 0x0F);
        word[0] =
            hn::Or(hn::Or(mode, hn::ShiftLeft<5>(field[0][0])), hn::Or(hn::ShiftLeft<15>(field[0][1]), hn::ShiftLeft<25>(field[0][2])));
        word[1] = hn::Or(hn::Or(hn::ShiftRight<7>(field[0][2]), hn::ShiftLeft<3>(field[1][0])),
                         hn::Or(hn::ShiftLeft<13>(field[1][1]), hn::ShiftLeft<23>(field[1][2])));
        word[2] = hn::ShiftRight<9>(field[1][2]);
    }
    static HWY_INLINE void store(const I (&word)[4], std::uint32_t* out) {
        const DU du;
        hn::StoreInterleaved4(hn::BitCast(du, word[0]), hn::BitCast(du, word[1]), hn::BitCast(du, word[2]), hn::BitCast(du, word[3]), du,
                              out);
    }
    /// Selects by the precision of each lane's mode: 10, 11, 12 or 16 bits.
    HWY_INLINE I byMode(int ten, int eleven, int twelve, int sixteen) const {
        const DI di;
        const I upTo11 = hn::IfThenElse(hn::RebindMask(di, is11_), hn::Set(di, eleven), hn::Set(di, ten));
        const I upTo12 = hn::IfThenElse(hn::RebindMask(di, is12_), hn::Set(di, twelve), upTo11);
        return hn::IfThenElse(hn::RebindMask(di, is16_), hn::Set(di, sixteen), upTo12);
    }
    /// Reverses the order of six bits.
    static HWY_INLINE I reversed6(I x) {
        const DI di;
        const auto only = [&](int bit) { return hn::And(x, hn::Set(di, 1 << bit)); };
        const I up = hn::Or(hn::ShiftLeft<5>(only(0)), hn::Or(hn::ShiftLeft<3>(only(1)), hn::ShiftLeft<1>(only(2))));
        const I down = hn::Or(hn::ShiftRight<1>(only(3)), hn::Or(hn::ShiftRight<3>(only(4)), hn::ShiftRight<5>(only(5))));
        return hn::Or(up, down);
    }

    F code_[2][3];
    M is16_, is12_, is11_;  ///< lanes whose mode has 16, 12 or 11 bits; all others have 10
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif

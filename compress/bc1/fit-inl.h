// The BC1 kernel (BC1, and the colour of BC3), one block in each lane. Colours are in [0, 1], each channel scaled by the square root of its
// weight, so that a squared distance is a weighted squared error.
//
// Method, for the four-colour mode and, in BC1, the three-colour mode:
// 1. Start endpoints lie on the principal axis of the texels, at the outermost projections. Several starts move them inwards by fixed
//    shares of the range (kBc1Starts), because outermost endpoints waste palette entries on single texels.
// 2. Each start is refined by alternating two steps: assign every texel to its nearest palette entry, then solve the least-squares
//    endpoints for these assignments and round them to 5, 6 and 5 bits. (As in stb_dxt's stb__RefineBlock.)
// 3. Coordinate descent on the integer endpoint codes: single steps of each code, at higher effort also of both codes of a channel,
//    for as long as the exact error falls.
// The best candidate of all starts and both modes wins.
#if defined(LIGHTCOOK_COMPRESS_BC1_FIT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC1_FIT_INL_H_
#undef LIGHTCOOK_COMPRESS_BC1_FIT_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC1_FIT_INL_H_
#endif

#include <hwy/highway.h>

#include <cmath>

#include "compress/bc1/search.h"
#include "compress/block/block.h"
#include "compress/block/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D>
class Bc1Fit : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::M;
    using Lanes<D>::set, Lanes<D>::zero, Lanes<D>::clamp;

public:
    Bc1Fit(const Bc1Search& search, const EncodeOptions& options, bool mayUseThree) : search_(search), mayUseThree_(mayUseThree) {
        for (std::size_t c = 0; c < 3; ++c) {
            scale_[c] = std::sqrt(options.channelWeights[c]);
            // Avoid divisions by zero for a channel of weight 0.
            scale_[c] = scale_[c] > 1e-6f ? scale_[c] : 1e-6f;
        }
    }

    /// Encodes Lanes(d) blocks.
    void run(const Block* const* blocks, Bc1Result* found) {
        load(blocks);
        startEnds();
        Candidate four = nothing(), three = nothing();
        fit<3>(four);
        if (mayUseThree_ && search_.threeColours) fit<2>(three);
        const M threeIsBetter = three.error < four.error;
        keepWhere(threeIsBetter, three, four);
        store(four, threeIsBetter, found);
    }

private:
    struct Candidate {
        F error;
        F code[2][3];
    };
    static constexpr float largestCode(int c) { return c == 1 ? 63.0f : 31.0f; }
    static Candidate nothing() {
        Candidate candidate;
        candidate.error = set(1e30f);
        for (auto& end : candidate.code)
            for (F& code : end) code = zero();
        return candidate;
    }
    static void keepWhere(M better, const Candidate& candidate, Candidate& best) {
        best.error = hn::IfThenElse(better, candidate.error, best.error);
        for (int e = 0; e < 2; ++e)
            for (int c = 0; c < 3; ++c) best.code[e][c] = hn::IfThenElse(better, candidate.code[e][c], best.code[e][c]);
    }

    void load(const Block* const* blocks) {
        const D d;
        HWY_ALIGN float buffer[hn::MaxLanes(D())];
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) buffer[lane] = blocks[lane]->significance[t];
            weight_[t] = hn::Load(d, buffer);
            for (std::size_t c = 0; c < 3; ++c) {
                for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) buffer[lane] = blocks[lane]->channel[c][t];
                value_[c][t] = hn::Load(d, buffer) * set(scale_[c]);
            }
        }
    }

    /// Sets start_ to the outermost projections of the texels onto their principal axis. The axis is found by power iteration on the
    /// covariance matrix, starting with the matrix row of the largest diagonal element.
    void startEnds() {
        F total = zero(), mean[3] = {zero(), zero(), zero()};
        for (int t = 0; t < kTexelCount; ++t) {
            total = total + weight_[t];
            for (int c = 0; c < 3; ++c) mean[c] = mean[c] + weight_[t] * value_[c][t];
        }
        for (F& m : mean) m = m / total;
        F m[3][3];
        for (auto& row : m)
            for (F& v : row) v = zero();
        for (int t = 0; t < kTexelCount; ++t)
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < 3; ++j) m[i][j] = m[i][j] + weight_[t] * (value_[i][t] - mean[i]) * (value_[j][t] - mean[j]);
        F axis[3] = {m[0][0], m[0][1], m[0][2]}, longest = m[0][0];
        for (int i = 1; i < 3; ++i) {
            const M longer = m[i][i] > longest;
            longest = hn::Max(longest, m[i][i]);
            for (int c = 0; c < 3; ++c) axis[c] = hn::IfThenElse(longer, m[i][c], axis[c]);
        }
        F length = set(1e-30f);
        for (int iteration = 0; iteration < 5; ++iteration) {
            const F norm = set(1.0f) / hn::Max(hn::Max(hn::Abs(axis[0]), hn::Abs(axis[1])), hn::Max(hn::Abs(axis[2]), set(1e-30f)));
            const F x = axis[0] * norm, y = axis[1] * norm, z = axis[2] * norm;
            if (iteration == 4) {
                axis[0] = x, axis[1] = y, axis[2] = z;
                length = hn::Max(x * x + y * y + z * z, set(1e-30f));
                break;
            }
            for (int i = 0; i < 3; ++i) axis[i] = m[i][0] * x + m[i][1] * y + m[i][2] * z;
        }
        F low = set(1e30f), high = set(-1e30f);
        for (int t = 0; t < kTexelCount; ++t) {
            const F along = (value_[0][t] - mean[0]) * axis[0] + (value_[1][t] - mean[1]) * axis[1] + (value_[2][t] - mean[2]) * axis[2];
            const M counts = weight_[t] > zero();
            low = hn::IfThenElse(counts, hn::Min(low, along), low);
            high = hn::IfThenElse(counts, hn::Max(high, along), high);
        }
        for (int c = 0; c < 3; ++c) {
            start_[0][c] = mean[c] + axis[c] * (low / length);
            start_[1][c] = mean[c] + axis[c] * (high / length);
        }
    }

    HWY_INLINE F codeOf(F value, int c) const {
        const float largest = largestCode(c);
        return hn::Round(clamp(value * set(largest / scale_[c]), zero(), set(largest)));
    }
    HWY_INLINE void line(const Candidate& candidate, F (&a)[3], F (&d)[3]) const {
        for (int c = 0; c < 3; ++c) {
            const F unit = set(scale_[c] / largestCode(c));
            a[c] = candidate.code[0][c] * unit;
            d[c] = candidate.code[1][c] * unit - a[c];
        }
    }

    /// Computes the error of a candidate, with each texel at the nearest of kSteps + 1 palette entries. position, if not null, receives
    /// the entry of each texel as a position on the line in [0, 1].
    template <int kSteps>
    void evaluate(Candidate& candidate, F* position) const {
        F a[3], d[3];
        line(candidate, a, d);
        const F scale = set(static_cast<float>(kSteps)) / hn::Max(d[0] * d[0] + d[1] * d[1] + d[2] * d[2], set(1e-20f));
        const F dx = d[0] * scale, dy = d[1] * scale, dz = d[2] * scale;
        F error = zero();
        for (int t = 0; t < kTexelCount; ++t) {
            const F x = value_[0][t] - a[0], y = value_[1][t] - a[1], z = value_[2][t] - a[2];
            const F step = hn::Round(clamp(x * dx + y * dy + z * dz, zero(), set(static_cast<float>(kSteps)))) * set(1.0f / kSteps);
            const F missX = x - step * d[0], missY = y - step * d[1], missZ = z - step * d[2];
            error = error + weight_[t] * (missX * missX + missY * missY + missZ * missZ);
            if (position) position[t] = step;
        }
        candidate.error = error;
    }

    /// Computes the least-squares endpoints for texels at these positions, rounded to codes.
    void refit(const F* position, Candidate& candidate) const {
        F total = set(1e-30f), meanK = zero(), mean[3] = {zero(), zero(), zero()};
        for (int t = 0; t < kTexelCount; ++t) {
            total = total + weight_[t];
            meanK = meanK + weight_[t] * position[t];
            for (int c = 0; c < 3; ++c) mean[c] = mean[c] + weight_[t] * value_[c][t];
        }
        const F share = set(1.0f) / total;
        meanK = meanK * share;
        F kk = zero(), kv[3] = {zero(), zero(), zero()};
        for (int t = 0; t < kTexelCount; ++t) {
            const F k = position[t] - meanK, wk = weight_[t] * k;
            kk = kk + wk * k;
            for (int c = 0; c < 3; ++c) kv[c] = kv[c] + wk * (value_[c][t] - mean[c] * share);
        }
        const F perKk = hn::IfThenElseZero(kk > total * set(1e-6f), set(1.0f) / hn::Max(kk, set(1e-35f)));
        for (int c = 0; c < 3; ++c) {
            const F slope = kv[c] * perKk;
            candidate.code[0][c] = codeOf(mean[c] * share - slope * meanK, c);
            candidate.code[1][c] = codeOf(mean[c] * share + slope * (set(1.0f) - meanK), c);
        }
    }

    /// Searches the mode of kSteps + 1 colours.
    template <int kSteps>
    void fit(Candidate& best) const {
        for (int start = 0; start < search_.starts; ++start) {
            Candidate candidate = nothing(), trial = nothing();
            const F in = set(kBc1Starts[static_cast<std::size_t>(start)][0]), out = set(kBc1Starts[static_cast<std::size_t>(start)][1]);
            for (int c = 0; c < 3; ++c) {
                const F range = start_[1][c] - start_[0][c];
                trial.code[0][c] = codeOf(start_[0][c] + range * in, c);
                trial.code[1][c] = codeOf(start_[1][c] - range * out, c);
            }
            F position[kTexelCount];
            evaluate<kSteps>(trial, position);
            keepWhere(trial.error < candidate.error, trial, candidate);
            for (int i = 0; i < search_.refits; ++i) {
                refit(position, trial);
                evaluate<kSteps>(trial, position);
                keepWhere(trial.error < candidate.error, trial, candidate);
            }
            for (int pass = 0; pass < search_.passes; ++pass)
                if (!descend<kSteps>(candidate)) break;
            keepWhere(candidate.error < best.error, candidate, best);
        }
    }

    /// Runs one pass of coordinate descent. Returns false if no lane improved.
    template <int kSteps>
    bool descend(Candidate& best) const {
        constexpr float kMoves[8][2] = {{-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, 1}, {-1, 1}, {1, -1}};
        bool improved = false;
        for (int c = 0; c < 3; ++c)
            for (int move = 0; move < (search_.diagonals ? 8 : 4); ++move) {
                Candidate trial = best;
                for (int e = 0; e < 2; ++e) trial.code[e][c] = clamp(trial.code[e][c] + set(kMoves[move][e]), zero(), set(largestCode(c)));
                evaluate<kSteps>(trial, nullptr);
                const M better = trial.error < best.error;
                improved |= !hn::AllFalse(D(), better);
                keepWhere(better, trial, best);
            }
        return improved;
    }

    void store(const Candidate& best, M threeColours, Bc1Result* found) const {
        const D d;
        HWY_ALIGN float buffer[hn::MaxLanes(D())];
        const std::size_t lanes = hn::Lanes(d);
        for (std::size_t e = 0; e < 2; ++e)
            for (std::size_t c = 0; c < 3; ++c) {
                hn::Store(best.code[e][c], d, buffer);
                for (std::size_t lane = 0; lane < lanes; ++lane)
                    (e ? found[lane].second : found[lane].first)[c] = static_cast<std::uint8_t>(buffer[lane]);
            }
        hn::Store(hn::IfThenElseZero(threeColours, set(1.0f)), d, buffer);
        for (std::size_t lane = 0; lane < lanes; ++lane) found[lane].threeColours = buffer[lane] != 0;
    }

    const Bc1Search& search_;
    bool mayUseThree_;
    float scale_[3];
    F value_[3][kTexelCount], weight_[kTexelCount];
    F start_[2][3];  ///< endpoints on the principal axis
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif

#include "compress/light_map/basis/code_solver.h"

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace lightcook::compress {

namespace {

// Coefficients 1 to 8 of three channels are 24 numbers: three registers of eight lanes, or six of four. No dynamic dispatch: lanes hold
// parts of one sum here, which is added in the same order on every machine.
namespace hn = hwy::HWY_NAMESPACE;
constexpr hn::CappedTag<float, 8> kTag;
using Lanes = hn::Vec<decltype(kTag)>;
constexpr std::size_t kWidth = hn::MaxLanes(kTag), kParts = 24 / kWidth;

struct Numbers {
    Lanes part[kParts];
};

Numbers load(const HigherByChannel& values) {
    Numbers out;
    for (std::size_t p = 0; p < kParts; ++p) out.part[p] = hn::LoadU(kTag, values[0].data() + p * kWidth);
    return out;
}
HigherByChannel stored(const Numbers& numbers) {
    HigherByChannel out;
    for (std::size_t p = 0; p < kParts; ++p) hn::StoreU(numbers.part[p], kTag, out[0].data() + p * kWidth);
    return out;
}
/// Returns in + factor * values.
Numbers plus(const Numbers& in, Lanes factor, const HigherByChannel& values) {
    const Numbers v = load(values);
    Numbers out;
    for (std::size_t p = 0; p < kParts; ++p) out.part[p] = hn::MulAdd(factor, v.part[p], in.part[p]);
    return out;
}
Numbers zero() {
    Numbers out;
    for (Lanes& part : out.part) part = hn::Zero(kTag);
    return out;
}
/// Returns lanes 0 to 3 plus lanes 4 to 7 of eight, which are one register or two.
template <std::size_t kRegisters>
HWY_INLINE auto sumOfHalves(const Lanes (&eight)[kRegisters]) {
    if constexpr (kRegisters == 1) {
        constexpr hn::Half<decltype(kTag)> kHalf;
        return hn::Add(hn::LowerHalf(kHalf, eight[0]), hn::UpperHalf(kHalf, eight[0]));
    } else {
        return hn::Add(eight[0], eight[1]);
    }
}
float product(const Numbers& a, const Numbers& b) {
    constexpr std::size_t kRegisters = 8 / kWidth;
    Lanes sum[kRegisters];
    for (std::size_t p = 0; p < kRegisters; ++p) sum[p] = hn::Mul(a.part[p], b.part[p]);
    for (std::size_t p = kRegisters; p < kParts; ++p) sum[p % kRegisters] = hn::MulAdd(a.part[p], b.part[p], sum[p % kRegisters]);
    const auto four = sumOfHalves(sum), two = hn::Add(four, hn::Shuffle1032(four));
    return hn::GetLane(hn::Add(two, hn::Shuffle0321(two)));
}

struct Jacobian {
    Numbers by[4];
};
/// Sets j to dP / dcode. Monomials: 1 a b c aa ab ac bb bc cc d ad bd cd dd.
HWY_INLINE void setJacobian(const CodeTable& t, int codeChannels, const glm::vec4& u, Jacobian& j) {
    const Lanes a = hn::Set(kTag, u.x), b = hn::Set(kTag, u.y), c = hn::Set(kTag, u.z), d = hn::Set(kTag, u.w);
    const Lanes twoA = hn::Add(a, a), twoB = hn::Add(b, b), twoC = hn::Add(c, c), twoD = hn::Add(d, d);
    j.by[0] = plus(plus(plus(load(t[1]), twoA, t[4]), b, t[5]), c, t[6]);
    j.by[1] = plus(plus(plus(load(t[2]), a, t[5]), twoB, t[7]), c, t[8]);
    j.by[2] = plus(plus(plus(load(t[3]), a, t[6]), b, t[8]), twoC, t[9]);
    j.by[3] = zero();
    if (codeChannels == 3) return;
    j.by[0] = plus(j.by[0], d, t[11]);
    j.by[1] = plus(j.by[1], d, t[12]);
    j.by[2] = plus(j.by[2], d, t[13]);
    j.by[3] = plus(plus(plus(plus(load(t[10]), a, t[11]), b, t[12]), c, t[13]), twoD, t[14]);
}
/// Returns P(u) from the derivative J already computed at u: P(u) = P(0) + sum_k u_k (J_k(0) + J_k(u)) / 2, exact for a quadratic.
HWY_INLINE Numbers valueOf(const CodeTable& t, const Jacobian& j, const glm::vec4& u) {
    constexpr std::array<std::size_t, 4> kLinear = {1, 2, 3, 10};
    Numbers out = load(t[0]);
    for (std::size_t k = 0; k < 4; ++k) {
        const Numbers linear = load(t[kLinear[k]]);
        const Lanes half = hn::Set(kTag, 0.5f * u[static_cast<int>(k)]);
        for (std::size_t p = 0; p < kParts; ++p) out.part[p] = hn::MulAdd(half, hn::Add(linear.part[p], j.by[k].part[p]), out.part[p]);
    }
    return out;
}

/// Normal equations of four unknowns: a symmetric matrix and the right-hand side.
struct Equations {
    std::array<std::array<float, 4>, 4> matrix;  ///< the lower triangle
    std::array<float, 4> right;

    float trace() const { return matrix[0][0] + matrix[1][1] + matrix[2][2] + matrix[3][3]; }
    /// Returns the solution with `damping` added to the diagonal, by L D L'; not finite if the matrix is singular.
    std::array<float, 4> solved(float damping) const {
        std::array<std::array<float, 4>, 4> l{};
        std::array<float, 4> d{}, x = right;
        for (std::size_t i = 0; i < 4; ++i) {
            std::array<float, 4> row{};  // l d
            float pivot = matrix[i][i] + damping;
            for (std::size_t k = 0; k < i; ++k) {
                row[k] = matrix[i][k];
                for (std::size_t j = 0; j < k; ++j) row[k] -= row[j] * l[k][j];
                l[i][k] = row[k] * d[k];
                pivot -= row[k] * l[i][k];
                x[i] -= l[i][k] * x[k];
            }
            d[i] = 1 / pivot;
        }
        for (std::size_t i = 4; i-- > 0;) {
            x[i] *= d[i];
            for (std::size_t k = i + 1; k < 4; ++k) x[i] -= l[k][i] * x[k];
        }
        return x;
    }
};

/// out[n] = Q in[n]: columns of the form are loaded once for all vectors.
template <std::size_t kVectors>
HWY_INLINE void multiply(const RatioCost& cost, const Numbers* in, Numbers* out) {
    alignas(32) std::array<std::array<float, RatioCost::kUnknowns>, kVectors> v;
    for (std::size_t n = 0; n < kVectors; ++n) {
        for (std::size_t p = 0; p < kParts; ++p) hn::StoreU(in[n].part[p], kTag, v[n].data() + p * kWidth);
        out[n] = zero();
    }
    for (std::size_t j = 0; j < RatioCost::kUnknowns; ++j)
        for (std::size_t p = 0; p < kParts; ++p) {
            const Lanes column = hn::LoadU(kTag, cost.higher[j].data() + p * kWidth);
            for (std::size_t n = 0; n < kVectors; ++n) out[n].part[p] = hn::MulAdd(hn::Set(kTag, v[n][j]), column, out[n].part[p]);
        }
}

/// The least-squares problem of one texel. The error of a code is e'Qe + 2 e'b plus a constant, e the error of the unknowns and b that of
/// coefficient 0 times its columns. Errors are reported with the constant.
class Problem {
public:
    Problem(const CodeTable& table, const BasisShape& shape, const BasisTarget& target)
        : linear_(zero()), table_(table), shape_(shape), cost_(target.cost) {
        HigherByChannel wanted;
        for (std::size_t c = 0; c < 3; ++c) {
            std::copy(target.ratio[c].begin() + 1, target.ratio[c].end(), wanted[c].begin());
            const float left = target.ratio[c][0] - 1;  // the decode gives exactly 1
            for (std::size_t p = 0; p < kParts; ++p)
                linear_.part[p] = hn::MulAdd(hn::Set(kTag, left), hn::LoadU(kTag, cost_.zero[c].data() + p * kWidth), linear_.part[p]);
            for (std::size_t d = 0; d < 3; ++d) constant_ += left * cost_.zeroZero[c][d] * (target.ratio[d][0] - 1);
        }
        wanted_ = load(wanted);
    }

    /// Error and derivatives at a code.
    struct Place {
        Numbers pull;  ///< Q e + b
        Jacobian slopes;
        float error;
    };
    void evaluate(const glm::vec4& code, Place& place) const {
        setJacobian(table_, shape_.codeChannels, code, place.slopes);
        place.error = errorOf(valueOf(table_, place.slopes, code), place.pull);
    }
    /// Returns the error of a code that decodes to `value`.
    float errorOf(const HigherByChannel& value) const {
        Numbers pull;
        return errorOf(load(value), pull);
    }

    Equations equationsAt(const Place& place) const {
        Jacobian weighted;
        multiply<4>(cost_, place.slopes.by, weighted.by);
        Equations out;
        for (std::size_t k = 0; k < 4; ++k) {
            out.right[k] = product(place.slopes.by[k], place.pull);
            for (std::size_t l = 0; l <= k; ++l) out.matrix[k][l] = product(place.slopes.by[k], weighted.by[l]);
        }
        return out;
    }

    /// Runs Levenberg-Marquardt from a code; the constants are explained at the head of code_solver.h.
    SolvedCode descend(const glm::vec4& start) const {
        constexpr int kSteps = 8;
        constexpr float kEnough = 1e-4f;
        glm::vec4 code = start;
        // Half a kilobyte each: pointers to them are swapped.
        std::array<Place, 2> places;
        Place *place = &places[0], *tried = &places[1];
        evaluate(code, *place);
        Equations equations = equationsAt(*place);
        float damping = 1e-3f;
        for (int step = 0; step < kSteps && place->error > 0; ++step) {
            const std::array<float, 4> d = equations.solved(damping * (equations.trace() / 4 + 1e-30f) + 1e-30f);
            if (!std::isfinite(d[0] + d[1] + d[2] + d[3])) break;
            glm::vec4 next = glm::clamp(code + glm::vec4(d[0], d[1], d[2], d[3]), 0.0f, 1.0f);
            if (shape_.codeChannels == 3) next.w = 1;
            evaluate(next, *tried);
            if (tried->error < place->error) {
                const bool isEnough = place->error - tried->error < kEnough * place->error;
                code = next;
                std::swap(place, tried);
                damping *= 0.2f;
                if (isEnough) break;
                equations = equationsAt(*place);
            } else {
                damping *= 10;
                if (damping > 1e3f) break;
            }
        }
        return {code, place->error};
    }

private:
    float errorOf(const Numbers& value, Numbers& pull) const {
        Numbers error;
        for (std::size_t p = 0; p < kParts; ++p) error.part[p] = hn::Sub(wanted_.part[p], value.part[p]);
        multiply<1>(cost_, &error, &pull);
        for (std::size_t p = 0; p < kParts; ++p) pull.part[p] = hn::Add(pull.part[p], linear_.part[p]);
        // e'Qe + 2 e'b = e'(Qe + b) + e'b
        return product(error, pull) + product(error, linear_) + constant_;
    }

    Numbers wanted_, linear_;  // first, since they are aligned like vectors
    const CodeTable& table_;
    const BasisShape& shape_;
    const RatioCost& cost_;
    float constant_ = 0;
};

}  // namespace

CodeSpace::CodeSpace(const CodeTable& table, const BasisShape& shape, std::span<const glm::vec4> seeds) : shape_(shape) {
    std::copy_n(table.begin(), shape.monomialCount(), table_.begin());
    candidates_ = {glm::vec4(0.5f, 0.5f, 0.5f, shape_.codeChannels == 3 ? 1.0f : 0.5f)};
    candidates_.insert(candidates_.end(), seeds.begin(), seeds.end());
    for (const glm::vec4& code : candidates_) {
        Jacobian slopes;
        setJacobian(table_, shape_.codeChannels, code, slopes);
        decoded_.push_back(stored(valueOf(table_, slopes, code)));
    }
}

SolvedCode CodeSpace::solve(const BasisTarget& target, const glm::vec4& start) const {
    return Problem(table_, shape_, target).descend(start);
}

SolvedCode CodeSpace::search(const BasisTarget& target) const {
    const Problem problem(table_, shape_, target);
    std::size_t best = 0;
    float least = problem.errorOf(decoded_[0]);
    for (std::size_t i = 1; i < decoded_.size(); ++i)
        if (const float error = problem.errorOf(decoded_[i]); error < least) {
            best = i;
            least = error;
        }
    return problem.descend(candidates_[best]);
}

glm::vec4 CodeSpace::sensitivity(const BasisTarget& target, const glm::vec4& code) const {
    const Problem problem(table_, shape_, target);
    Problem::Place place;
    problem.evaluate(code, place);
    const Equations equations = problem.equationsAt(place);
    return glm::vec4(equations.matrix[0][0], equations.matrix[1][1], equations.matrix[2][2], equations.matrix[3][3]);
}

}  // namespace lightcook::compress

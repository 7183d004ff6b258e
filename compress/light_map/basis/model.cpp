#include "compress/light_map/basis/model.h"

#include <hwy/highway.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <glm/common.hpp>

#include "compress/texel/half.h"

namespace lightcook::compress {

namespace {

/// Coefficient 0 of a texel is pulled towards its own value by this share of its weight, so that neighbours stay alike, and changes at most
/// by a factor of kLargestChange.
constexpr float kPullToLight = 0.1f, kLargestChange = 4;
/// Share of the mean diagonal that is added to the equations of a residual texel.
constexpr float kRidge = 1e-3f;

using Matrix4 = Eigen::Matrix<float, 4, 4>;
using Vector4 = Eigen::Matrix<float, 4, 1>;

float dot(const WeightedRatios& weighted, const ByChannel& v) {
    float sum = 0;
    for (std::size_t c = 0; c < 3; ++c) {
        sum += weighted.zero[c] * v[c][0];
        for (std::size_t i = 0; i < 8; ++i) sum += weighted.higher[c][i] * v[c][i + 1];
    }
    return sum;
}

// No dynamic dispatch: lanes hold different coefficients.
namespace hn = hwy::HWY_NAMESPACE;

/// Returns the sum of the rows of a matrix, each times a factor, in the order of the rows. Coefficients 0 to 7 lie in lanes: GCC unrolls
/// loops of nine into scalars.
std::array<float, kCoefficientCount> sumOfRows(const std::array<std::array<float, kCoefficientCount>, kCoefficientCount>& rows,
                                               const std::array<float, kCoefficientCount>& factors) {
    constexpr hn::CappedTag<float, 8> tag;
    constexpr std::size_t kLanesOfRow = hn::MaxLanes(tag), kPartsOfRow = 8 / kLanesOfRow;
    hn::Vec<decltype(tag)> sum[kPartsOfRow];
    for (auto& part : sum) part = hn::Zero(tag);
    float last = 0;
    for (std::size_t j = 0; j < kCoefficientCount; ++j) {
        const auto factor = hn::Set(tag, factors[j]);
        for (std::size_t p = 0; p < kPartsOfRow; ++p)
            sum[p] = hn::Add(sum[p], hn::Mul(hn::LoadU(tag, rows[j].data() + p * kLanesOfRow), factor));
        last += rows[j][kCoefficientCount - 1] * factors[j];
    }
    std::array<float, kCoefficientCount> out;
    for (std::size_t p = 0; p < kPartsOfRow; ++p) hn::StoreU(sum[p], tag, out.data() + p * kLanesOfRow);
    out[kCoefficientCount - 1] = last;
    return out;
}

/// out += factor * in
void accumulate(HigherByChannel& out, float factor, const HigherByChannel& in) {
    for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t i = 0; i < 8; ++i) out[c][i] += factor * in[c][i];
}

}  // namespace

WeightedRatios times(const RatioCost& cost, const ByChannel& v) {
    std::array<float, RatioCost::kUnknowns> sum{};
    WeightedRatios out;
    for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t i = 0; i < 8; ++i)
            for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += v[c][i + 1] * cost.higher[8 * c + i][k];
        for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += v[c][0] * cost.zero[c][k];
        out.zero[c] = 0;
        for (std::size_t d = 0; d < 3; ++d) {
            out.zero[c] += cost.zeroZero[c][d] * v[d][0];
            for (std::size_t i = 0; i < 8; ++i) out.zero[c] += cost.zero[c][8 * d + i] * v[d][i + 1];
        }
    }
    for (std::size_t k = 0; k < sum.size(); ++k) out.higher[k / 8][k % 8] = sum[k];
    return out;
}

float roundedToHalf(double value) {
    constexpr double kLargest = 65504;
    return floatFromHalf(halfFromFloat(static_cast<float>(std::clamp(value, -kLargest, kLargest))));
}

std::size_t BasisModel::tableBytes() const {
    const std::size_t codeTable = kFactorBytes * 8 * static_cast<std::size_t>(shape.monomialCount());
    return code.size() * (codeTable + static_cast<std::size_t>(shape.residualLayers) * kResidualTableBytes);
}

HigherByChannel evaluateCode(const CodeTable& table, int monomialCount, const glm::vec4& u) {
    const std::array<float, kCodeMonomials> monomials = {1,         u.x,       u.y, u.z,       u.x * u.x, u.x * u.y, u.x * u.z, u.y * u.y,
                                                         u.y * u.z, u.z * u.z, u.w, u.x * u.w, u.y * u.w, u.z * u.w, u.w * u.w};
    HigherByChannel out = table[0];
    for (std::size_t m = 1; m < static_cast<std::size_t>(monomialCount); ++m) accumulate(out, monomials[m], table[m]);
    return out;
}

void addResidual(const ResidualTable& table, const glm::vec4& texel, ByChannel& ratio) {
    for (std::size_t k = 0; k < 4; ++k) {
        const float factor = texel[static_cast<int>(k)] - kResidualNeutral;
        for (std::size_t c = 0; c < 3; ++c)
            for (std::size_t i = 0; i < kCoefficientCount; ++i) ratio[c][i] += factor * table[k][c][i];
    }
}

void subtractCode(const HigherByChannel& decoded, ByChannel& ratio) {
    for (std::size_t c = 0; c < 3; ++c) {
        ratio[c][0] -= 1;
        for (std::size_t i = 0; i < 8; ++i) ratio[c][i + 1] -= decoded[c][i];
    }
}

void subtractResidual(const ResidualTable& table, const glm::vec4& texel, ByChannel& ratio) {
    ByChannel sum{};
    addResidual(table, texel, sum);
    for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t i = 0; i < kCoefficientCount; ++i) ratio[c][i] -= sum[c][i];
}

RatioCost::RatioCost(const ErrorForm& form, const glm::vec3& decodedDc) {
    const glm::vec3 dc = glm::max(decodedDc, 0.0f);
    for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t d = 0; d < 3; ++d) {
            const auto& part = form.of(c, d);
            const float scale = dc[static_cast<int>(c)] * dc[static_cast<int>(d)];
            zeroZero[c][d] = scale * part[0][0];
            for (std::size_t j = 0; j < 8; ++j) zero[c][8 * d + j] = scale * part[0][j + 1];
            for (std::size_t i = 0; i < 8; ++i)
                for (std::size_t j = 0; j < 8; ++j) higher[8 * c + i][8 * d + j] = scale * part[i + 1][j + 1];
        }
}

std::array<float, 3> RatioCost::channelWeights() const {
    std::array<float, 3> out{};
    for (std::size_t k = 0; k < kUnknowns; ++k) out[k / 8] += higher[k][k] / 8;
    return out;
}

std::array<float, 3> channelWeightsOf(const PackedForm& form, const glm::vec3& decodedDc) {
    std::array<float, 3> out{};
    for (std::size_t c = 0; c < 3; ++c) {
        const float dc = std::max(decodedDc[static_cast<int>(c)], 0.0f), scale = dc * dc;
        for (std::size_t i = 1; i < kCoefficientCount; ++i) out[c] += scale * form.part[c][PackedForm::diagonal(i)] / 8;
    }
    return out;
}

glm::vec3 solveDc(const ErrorForm& form, std::span<const glm::vec3> light, const HigherByChannel& ratios) {
    Eigen::Matrix3f matrix;
    Eigen::Vector3f right = Eigen::Vector3f::Zero();
    for (std::size_t c = 0; c < 3; ++c) {
        std::array<float, kCoefficientCount> ratio{1};
        std::ranges::copy(ratios[c], ratio.begin() + 1);
        for (std::size_t d = 0; d < 3; ++d) {
            const std::array<float, kCoefficientCount> weighted = sumOfRows(form.of(c, d), ratio);
            float sum = weighted[0];
            for (std::size_t i = 0; i < 8; ++i) sum += weighted[i + 1] * ratios[d][i];
            matrix(static_cast<int>(c), static_cast<int>(d)) = sum;
            for (std::size_t i = 0; i < kCoefficientCount; ++i) right(static_cast<int>(c)) += weighted[i] * light[i][static_cast<int>(d)];
        }
    }
    const glm::vec3 own = glm::max(light[0], 0.0f);
    for (int c = 0; c < 3; ++c) {
        const float pull = kPullToLight * matrix(c, c) + 1e-30f;
        matrix(c, c) += pull;
        right(c) += pull * own[c];
    }
    const Eigen::Vector3f found = matrix.ldlt().solve(right);
    if (!found.allFinite()) return own;
    return glm::clamp(glm::vec3(found(0), found(1), found(2)), own / kLargestChange, own * kLargestChange);
}

glm::vec4 solveResidual(const ResidualTable& table, const BasisTarget& target) {
    Matrix4 matrix = Matrix4::Zero();
    Vector4 right = Vector4::Zero();
    for (int k = 0; k < 4; ++k) {
        const WeightedRatios weighted = times(target.cost, table[static_cast<std::size_t>(k)]);
        right(k) = dot(weighted, target.ratio);
        for (int l = 0; l <= k; ++l) matrix(k, l) = dot(weighted, table[static_cast<std::size_t>(l)]);
    }
    matrix.triangularView<Eigen::StrictlyUpper>() = matrix.transpose();
    const float mean = matrix.trace() / 4 + 1e-30f;
    for (int k = 0; k < 4; ++k) matrix(k, k) += kRidge * mean;
    const Vector4 found = matrix.ldlt().solve(right);
    if (!found.allFinite()) return glm::vec4(kResidualNeutral);
    return glm::clamp(glm::vec4(found(0), found(1), found(2), found(3)) + kResidualNeutral, 0.0f, 1.0f);
}

glm::vec4 residualSensitivity(const ResidualTable& table, const BasisTarget& target) {
    glm::vec4 sum(0);
    for (std::size_t k = 0; k < 4; ++k) sum[static_cast<int>(k)] = dot(times(target.cost, table[k]), table[k]);
    return sum;
}

}  // namespace lightcook::compress

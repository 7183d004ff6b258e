#include "compress/light_map/basis/model.h"

#include <Eigen/Cholesky>

#include "compress/texel/half.h"

namespace lightcook::compress {

namespace {

constexpr std::size_t kCount = lighting::kShCount;

using Quartet = Eigen::Matrix<float, 4, 4>;
using Four = Eigen::Matrix<float, 4, 1>;

std::array<float, kCount> timesAll(const Metric& metric, const std::array<float, kCount>& v) {
    std::array<float, kCount> out{};
    for (std::size_t j = 0; j < kCount; ++j)
        for (std::size_t i = 0; i < kCount; ++i) out[i] += metric[j][i] * v[j];
    return out;
}
template <std::size_t kSize>
float dot(const std::array<float, kSize>& a, const std::array<float, kSize>& b) {
    std::array<float, kSize> products;
    for (std::size_t i = 0; i < kSize; ++i) products[i] = a[i] * b[i];
    float sum = 0;
    for (const float product : products) sum += product;
    return sum;
}

/// out += factor * in
void accumulate(HigherByChannel& out, float factor, const HigherByChannel& in) {
    for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t i = 0; i < 8; ++i) out[c][i] += factor * in[c][i];
}

}  // namespace

float roundedToHalf(double value) {
    return floatFromHalf(halfFromFloat(static_cast<float>(value)));
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
            for (std::size_t i = 0; i < kCount; ++i) ratio[c][i] += factor * table[k][c][i];
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
        for (std::size_t i = 0; i < kCount; ++i) ratio[c][i] -= sum[c][i];
}

glm::vec4 solveResidual(const ResidualTable& table, const BasisTarget& target) {
    Quartet matrix = Quartet::Zero();
    Four right = Four::Zero();
    for (std::size_t c = 0; c < 3; ++c)
        for (int k = 0; k < 4; ++k) {
            std::array<float, kCount> weighted = timesAll(*target.metric, table[static_cast<std::size_t>(k)][c]);
            for (float& value : weighted) value *= target.weight[c];
            right(k) += dot(weighted, target.ratio[c]);
            for (int l = 0; l <= k; ++l) matrix(k, l) += dot(weighted, table[static_cast<std::size_t>(l)][c]);
        }
    matrix.triangularView<Eigen::StrictlyUpper>() = matrix.transpose();
    const float mean = matrix.trace() / 4 + 1e-30f;
    for (int k = 0; k < 4; ++k) matrix(k, k) += 1e-5f * mean;
    const Four found = matrix.ldlt().solve(right);
    if (!found.allFinite()) return glm::vec4(kResidualNeutral);
    return glm::clamp(glm::vec4(found(0), found(1), found(2), found(3)) + kResidualNeutral, 0.0f, 1.0f);
}

glm::vec4 residualSensitivity(const ResidualTable& table, const BasisTarget& target) {
    glm::vec4 sum(0);
    for (std::size_t k = 0; k < 4; ++k)
        for (std::size_t c = 0; c < 3; ++c)
            sum[static_cast<int>(k)] += target.weight[c] * dot(table[k][c], timesAll(*target.metric, table[k][c]));
    return sum;
}

}  // namespace lightcook::compress

#include "compress/basis_model.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "lighting/brdf.h"
#include "lighting/radiometry.h"
#include "lighting/sphere.h"

namespace compress {

namespace {

constexpr std::size_t kCount = lighting::kShCount;

/// Rows whose outer products add up to the metric in the frame whose z is the normal.
std::vector<lighting::ShDouble> localRows() {
    std::vector<lighting::ShDouble> rows;
    constexpr int kNormals = 16, kViews = 6;
    for (int i = 0; i < kNormals; ++i) {
        lighting::ShDouble row = lighting::evaluateBasis(lighting::fibonacciHemisphere(i, kNormals));
        for (std::size_t c = 0; c < kCount; ++c)
            row[c] *= lighting::kExitRadianceBands[static_cast<std::size_t>(lighting::kShBand[c])] / std::sqrt(double{kNormals});
        rows.push_back(row);
    }
    for (int i = 0; i < kViews; ++i) {
        const glm::dvec3 view = lighting::fibonacciHemisphere(i, kViews);
        const double cosine = view.x / std::hypot(view.x, view.y), sine = view.y / std::hypot(view.x, view.y);
        const lighting::ShRotation turn(glm::dmat3(glm::dvec3(cosine, sine, 0), glm::dvec3(-sine, cosine, 0), glm::dvec3(0, 0, 1)));
        for (const double m : {0.1, 0.25, 0.5}) {
            const lighting::AreaSpecularKernel kernel = lighting::integrateAreaSpecular(view.z, m, lighting::NormalDistribution::Beckmann,
                                                                                        lighting::CookTorranceNormalization::Energy, 48);
            for (const double f0 : {0.04, 0.6}) {
                lighting::ShDouble row;
                for (std::size_t c = 0; c < kCount; ++c) row[c] = f0 * kernel.c[c] + (1 - f0) * kernel.d[c];
                row = turn.apply(row);
                // A material of 4 % shows little light and is asked for no less: each counts by its own answer to constant light.
                const double unit = std::max(row[0], 1e-3) / lighting::kShConstant * std::sqrt(6.0 * kViews);
                for (double& value : row) value /= unit;
                rows.push_back(row);
            }
        }
    }
    return rows;
}

/// The same metric as nine rows: the rows of its Cholesky factor, transposed.
std::array<lighting::ShDouble, kCount> localFactor() {
    Eigen::Matrix<double, 9, 9> sum = Eigen::Matrix<double, 9, 9>::Zero();
    for (const lighting::ShDouble& row : localRows()) {
        const Eigen::Map<const Eigen::Matrix<double, 9, 1>> r(row.data());
        sum += r * r.transpose();
    }
    const Eigen::Matrix<double, 9, 9> factor = sum.llt().matrixL();
    std::array<lighting::ShDouble, kCount> columns{};
    for (int c = 0; c < 9; ++c)
        for (int r = 0; r < 9; ++r) columns[static_cast<std::size_t>(c)][static_cast<std::size_t>(r)] = factor(r, c);
    return columns;
}

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

using Jacobian = std::array<HigherByChannel, 4>;

/// dP / dcode. Monomials: 1 a b c aa ab ac bb bc cc d ad bd cd dd.
Jacobian jacobianOf(const CodeTable& t, int codeChannels, const glm::vec4& u) {
    Jacobian j = {t[1], t[2], t[3], HigherByChannel{}};
    accumulate(j[0], 2 * u.x, t[4]);
    accumulate(j[0], u.y, t[5]);
    accumulate(j[0], u.z, t[6]);
    accumulate(j[1], u.x, t[5]);
    accumulate(j[1], 2 * u.y, t[7]);
    accumulate(j[1], u.z, t[8]);
    accumulate(j[2], u.x, t[6]);
    accumulate(j[2], u.y, t[8]);
    accumulate(j[2], 2 * u.z, t[9]);
    if (codeChannels == 3) return j;
    accumulate(j[0], u.w, t[11]);
    accumulate(j[1], u.w, t[12]);
    accumulate(j[2], u.w, t[13]);
    j[3] = t[10];
    accumulate(j[3], u.x, t[11]);
    accumulate(j[3], u.y, t[12]);
    accumulate(j[3], u.z, t[13]);
    accumulate(j[3], 2 * u.w, t[14]);
    return j;
}

float sumOf(const std::array<float, 8>& values) {
    float sum = 0;
    for (const float value : values) sum += value;
    return sum;
}

/// A texel's problem in the space where squared differences are costs: the root of its metric and of its weights go through the table and
/// the target once, and no step has to know them.
class CodeProblem {
public:
    CodeProblem(const CodeTable& table, const BasisShape& shape, const BasisTarget& target) : shape_(shape) {
        for (std::size_t c = 0; c < 3; ++c) {
            std::array<float, 8> ratio;
            std::copy(target.ratio[c].begin() + 1, target.ratio[c].end(), ratio.begin());
            const float root = std::sqrt(target.weight[c]);
            wanted_[c] = turned(*target.metric, root, ratio);
            for (std::size_t m = 0; m < static_cast<std::size_t>(shape.monomialCount()); ++m)
                table_[m][c] = turned(*target.metric, root, table[m][c]);
        }
    }

    struct Left {
        HigherByChannel values;
        float error;
    };
    Left leftOf(const glm::vec4& code) const {
        Left left{evaluateCode(table_, shape_.monomialCount(), code), 0};
        std::array<float, 8> squares{};
        for (std::size_t c = 0; c < 3; ++c)
            for (std::size_t i = 0; i < 8; ++i) {
                left.values[c][i] = wanted_[c][i] - left.values[c][i];
                squares[i] += left.values[c][i] * left.values[c][i];
            }
        left.error = sumOf(squares);
        return left;
    }

    struct Normal {
        Quartet matrix;
        Four right;
    };
    Normal normalEquations(const glm::vec4& code, const HigherByChannel& left) const {
        const Jacobian j = jacobianOf(table_, shape_.codeChannels, code);
        Normal normal;
        for (int k = 0; k < 4; ++k) {
            const HigherByChannel& row = j[static_cast<std::size_t>(k)];
            normal.right(k) = product(row, left);
            for (int l = 0; l <= k; ++l) normal.matrix(k, l) = normal.matrix(l, k) = product(row, j[static_cast<std::size_t>(l)]);
        }
        return normal;
    }

private:
    static std::array<float, 8> turned(const Metric& metric, float root, const std::array<float, 8>& v) {
        std::array<float, 8> out{};
        for (std::size_t j = 0; j < 8; ++j)
            for (std::size_t i = 0; i < 8; ++i) out[i] += metric.higherRoot[j][i] * v[j];
        for (float& value : out) value *= root;
        return out;
    }
    static float product(const HigherByChannel& a, const HigherByChannel& b) {
        std::array<float, 8> sums{};
        for (std::size_t c = 0; c < 3; ++c)
            for (std::size_t i = 0; i < 8; ++i) sums[i] += a[c][i] * b[c][i];
        return sumOf(sums);
    }

    BasisShape shape_;
    CodeTable table_;
    HigherByChannel wanted_;
};

SolvedCode solve(const CodeProblem& problem, const BasisShape& shape, const glm::vec4& start) {
    constexpr int kSteps = 8;
    constexpr float kEnough = 1e-4f;
    glm::vec4 code = start;
    CodeProblem::Left left = problem.leftOf(code);
    float damping = 1e-3f;
    for (int step = 0; step < kSteps && left.error > 0; ++step) {
        CodeProblem::Normal normal = problem.normalEquations(code, left.values);
        const float mean = normal.matrix.trace() / 4 + 1e-30f;
        for (int k = 0; k < 4; ++k) normal.matrix(k, k) += damping * mean + 1e-30f;
        const Four delta = normal.matrix.ldlt().solve(normal.right);
        if (!delta.allFinite()) break;
        glm::vec4 next = glm::clamp(code + glm::vec4(delta(0), delta(1), delta(2), delta(3)), 0.0f, 1.0f);
        if (shape.codeChannels == 3) next.w = 1;
        const CodeProblem::Left tried = problem.leftOf(next);
        if (tried.error < left.error) {
            const bool isEnough = left.error - tried.error < kEnough * left.error;
            code = next;
            left = tried;
            damping *= 0.2f;
            if (isEnough) break;
        } else {
            damping *= 10;
            if (damping > 1e3f) break;
        }
    }
    return {code, left.error};
}

}  // namespace

std::size_t BasisModel::tableBytes() const {
    const std::size_t codeTable = 2 * 24 * static_cast<std::size_t>(shape.monomialCount());
    return code.size() * (codeTable + static_cast<std::size_t>(shape.residualLayers) * kResidualTableBytes) + clusterOfBlock.size();
}

const Metric& ShadingMetric::at(const glm::vec3& normal) {
    if (normal == normal_) return metric_;
    static const std::array<lighting::ShDouble, kCount> factor = localFactor();
    normal_ = normal;
    const lighting::ShRotation turn(lighting::worldFromTangentFrame(glm::dvec3(normal)));
    metric_ = {};
    for (const lighting::ShDouble& column : factor) {
        const lighting::ShDouble world = turn.apply(column);
        for (std::size_t i = 0; i < kCount; ++i)
            for (std::size_t j = 0; j < kCount; ++j) metric_.matrix[i][j] += static_cast<float>(world[i] * world[j]);
    }
    Eigen::Matrix<float, 8, 8> higher;
    for (int i = 0; i < 8; ++i)
        for (int j = 0; j < 8; ++j) higher(i, j) = metric_[static_cast<std::size_t>(i) + 1][static_cast<std::size_t>(j) + 1];
    const Eigen::Matrix<float, 8, 8> root = higher.llt().matrixU();
    for (int i = 0; i < 8; ++i)
        for (int j = 0; j < 8; ++j) metric_.higherRoot[static_cast<std::size_t>(j)][static_cast<std::size_t>(i)] = root(i, j);
    return metric_;
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

SolvedCode solveCode(const CodeTable& table, const BasisShape& shape, const BasisTarget& target, const glm::vec4& start) {
    return solve(CodeProblem(table, shape, target), shape, start);
}

SolvedCode searchCode(const BasisModel& model, std::size_t cluster, const BasisTarget& target) {
    const CodeProblem problem(model.code[cluster], model.shape, target);
    SolvedCode best{glm::vec4(0.5f, 0.5f, 0.5f, model.shape.codeChannels == 3 ? 1.0f : 0.5f), 0};
    best.error = problem.leftOf(best.code).error;
    for (const glm::vec4& seed : model.seeds[cluster])
        if (const float error = problem.leftOf(seed).error; error < best.error) best = {seed, error};
    return solve(problem, model.shape, best.code);
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

glm::vec4 codeSensitivity(const CodeTable& table, const BasisShape& shape, const BasisTarget& target, const glm::vec4& code) {
    const CodeProblem::Normal normal = CodeProblem(table, shape, target).normalEquations(code, HigherByChannel{});
    return glm::vec4(normal.matrix(0, 0), normal.matrix(1, 1), normal.matrix(2, 2), normal.matrix(3, 3));
}

glm::vec4 residualSensitivity(const ResidualTable& table, const BasisTarget& target) {
    glm::vec4 sum(0);
    for (std::size_t k = 0; k < 4; ++k)
        for (std::size_t c = 0; c < 3; ++c)
            sum[static_cast<int>(k)] += target.weight[c] * dot(table[k][c], timesAll(*target.metric, table[k][c]));
    return sum;
}

}  // namespace compress

// The learned decode of layouts "basis-K", and how a residual's numbers are found for it (those of the code: basis_codes.h).
// Coefficients 1 to 8 over the decoded coefficient 0 are a quadratic polynomial of three or four numbers in [0, 1]; each layer of the
// residual adds a linear basis of four more. Private to compress/.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <vector>

#include "lighting/sh.h"

namespace lightcook::compress {

inline constexpr int kCodeMonomials = 15;
/// What a residual channel holds where nothing is left: 8 bits have it exactly.
inline constexpr float kResidualNeutral = 128.0f / 255.0f;

struct BasisShape {
    int codeChannels = 4;    ///< 3 or 4
    int residualLayers = 0;  ///< of four channels each
    int monomialCount() const { return codeChannels == 3 ? 10 : kCodeMonomials; }
};

/// Nine numbers a colour channel: [r, g, b][coefficient].
using ByChannel = std::array<std::array<float, lighting::kShCount>, 3>;
/// Eight a channel, coefficients 1 to 8: one vector register.
using HigherByChannel = std::array<std::array<float, 8>, 3>;
/// Factors of each monomial, in the order of lcBasisMonomials.
using CodeTable = std::array<HigherByChannel, kCodeMonomials>;
/// What each channel of a residual texel adds.
using ResidualTable = std::array<ByChannel, 4>;

struct BasisModel {
    BasisShape shape;
    std::vector<CodeTable> code;                       ///< [cluster]
    std::vector<std::vector<ResidualTable>> residual;  ///< [layer][cluster]
    std::vector<std::vector<glm::vec4>> seeds;         ///< [cluster] codes to start a search from
    glm::vec4 codeWeights{1};                          ///< what a squared error of each channel costs, on average
    std::vector<glm::vec4> residualWeights;            ///< [layer]
    int blocksAcross = 0;
    std::vector<std::uint8_t> clusterOfBlock;  ///< [4 x 4 block of the map]

    std::size_t clusterCount() const { return code.size(); }
    std::size_t clusterAt(int x, int y) const {
        return clusterOfBlock[static_cast<std::size_t>(y / 4) * static_cast<std::size_t>(blocksAcross) + static_cast<std::size_t>(x / 4)];
    }
    static constexpr std::size_t kResidualTableBytes = 2 * 4 * 27;  ///< of one layer and cluster
    std::size_t tableBytes() const;                                 ///< of all bases, as 16-bit floats in GPU memory
    std::size_t indexBytes() const { return clusterOfBlock.size(); }
};

/// What an error of the nine coefficients costs: mean squares of exit radiance over normals of the hemisphere and of area specular over
/// views and materials, each over its value for a constant light. A symmetric matrix in world coordinates.
struct Metric {
    std::array<std::array<float, lighting::kShCount>, lighting::kShCount> matrix{};
    /// Columns of the upper triangle U whose U'U is the matrix of coefficients 1 to 8: |U e|^2 is what their error costs.
    std::array<std::array<float, 8>, 8> higherRoot{};

    const std::array<float, lighting::kShCount>& operator[](std::size_t row) const { return matrix[row]; }
};
class ShadingMetric {
public:
    /// Around a unit normal. Remembers the last one: charts are mostly flat.
    const Metric& at(const glm::vec3& normal);

private:
    glm::vec3 normal_{0};
    Metric metric_{};
};

/// A texel to be coded.
struct BasisTarget {
    ByChannel ratio;              ///< true coefficients over the decoded coefficient 0
    std::array<float, 3> weight;  ///< of each channel: squared decoded coefficient 0
    const Metric* metric = nullptr;
};

/// P(code): coefficients 1 to 8 over coefficient 0.
HigherByChannel evaluateCode(const CodeTable& table, int monomialCount, const glm::vec4& code);
/// Adds sum_k (texel_k - neutral) R_k.
void addResidual(const ResidualTable& table, const glm::vec4& texel, ByChannel& ratio);

/// The residual texel in [0, 1]^4 nearest to what `target.ratio` now holds: what is left.
glm::vec4 solveResidual(const ResidualTable& table, const BasisTarget& target);

/// How the error grows with each channel: the metric of its direction, summed over colours.
glm::vec4 residualSensitivity(const ResidualTable& table, const BasisTarget& target);

}  // namespace lightcook::compress

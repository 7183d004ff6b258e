// The learned decode of the layouts basis-K.
//
// A texel stores n = 3 or 4 numbers u in [0, 1] (the code), and optionally layers of four more (the residual). With lambda_0 decoded:
//   lambda_i / lambda_0 = P_i(u) + sum_k (residual_k - neutral) R_ki,  i = 1 to 8; the residual corrects coefficient 0, too
// P_i is a quadratic polynomial with 10 or 15 monomials for each colour channel, R a linear basis. Both are fitted to the map, for each
// cluster of charts. Private to compress/.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec4.hpp>
#include <span>
#include <vector>

#include "compress/light_map/shading_form.h"
#include "lighting/sh.h"

namespace lightcook::compress {

inline constexpr int kCodeMonomials = 15;
/// Value of a residual channel that adds nothing; 8 bits hold it exactly.
inline constexpr float kResidualNeutral = 128.0f / 255.0f;

struct BasisShape {
    int codeChannels = 4;    ///< 3 or 4
    int residualLayers = 0;  ///< of four channels each
    int monomialCount() const { return codeChannels == 3 ? 10 : kCodeMonomials; }
};

/// Nine coefficients a colour channel: [r, g, b][coefficient].
using ByChannel = std::array<std::array<float, lighting::kShCount>, 3>;
/// Coefficients 1 to 8 of each channel: one vector register a channel.
using HigherByChannel = std::array<std::array<float, 8>, 3>;
/// Factors of the monomials 1 a b c aa ab ac bb bc cc d ad bd cd dd of a code (a, b, c, d), in the order of lcBasisMonomials.
using CodeTable = std::array<HigherByChannel, kCodeMonomials>;
/// Coefficients that each channel of a residual texel adds.
using ResidualTable = std::array<ByChannel, 4>;

struct BasisModel {
    BasisShape shape;
    std::vector<CodeTable> code;                       ///< [cluster]
    std::vector<std::vector<ResidualTable>> residual;  ///< [layer][cluster]
    std::vector<std::vector<glm::vec4>> seeds;         ///< [cluster] codes to start a search from
    glm::vec4 codeWeights{1};                          ///< mean cost of a squared error of each channel
    std::vector<glm::vec4> residualWeights;            ///< [layer] the same
    double lightSquare = 0;                            ///< mean square of coefficient 0 of the map, over the range of texture "l0"
    int blockSide = 4, blocksAcross = 0;               ///< of the blocks that have a cluster each [texels], and their number in a row
    std::vector<std::uint8_t> clusterOfBlock;          ///< [block]

    std::size_t clusterCount() const { return code.size(); }
    std::size_t clusterAt(int x, int y) const {
        return clusterOfBlock[static_cast<std::size_t>(y / blockSide) * static_cast<std::size_t>(blocksAcross) +
                              static_cast<std::size_t>(x / blockSide)];
    }
    /// GPU memory of an RGB factor: a texel of RGBA16F. Halves hold the factors exactly: they are fitted as such.
    static constexpr std::size_t kFactorBytes = 8;
    static constexpr std::size_t kResidualTableBytes = kFactorBytes * 4 * 9;  ///< of one layer and cluster
    std::size_t tableBytes() const;                                           ///< of all bases

    template <class Archive, class Self>
    static void members(Archive& archive, Self& self) {
        archive(self.shape, self.code, self.residual, self.seeds, self.codeWeights, self.residualWeights, self.lightSquare, self.blockSide,
                self.blocksAcross, self.clusterOfBlock);
    }
};

/// The cost of an error of ratios: the form of a texel's shading, each channel times the decoded coefficient 0. Whole registers for the
/// solvers: unknowns are coefficients 1 to 8 of r, g and b; coefficient 0 has columns of its own.
struct RatioCost {
    static constexpr std::size_t kUnknowns = 24;
    std::array<std::array<float, kUnknowns>, kUnknowns> higher;  ///< symmetric
    std::array<std::array<float, kUnknowns>, 3> zero;            ///< [channel] products of its coefficient 0 with the unknowns
    std::array<std::array<float, 3>, 3> zeroZero;                ///< products of coefficients 0

    RatioCost() = default;
    RatioCost(const ErrorForm& form, const glm::vec3& decodedDc);
    /// Returns the mean diagonal of each channel's unknowns: the weight of a squared error.
    std::array<float, 3> channelWeights() const;
};

/// Returns RatioCost(form, decodedDc).channelWeights(), with less work.
std::array<float, 3> channelWeightsOf(const PackedForm& form, const glm::vec3& decodedDc);

/// Returns the coefficient 0 of each channel for which coefficient 0 times `ratios` costs least: weighted least squares of three unknowns.
/// A channel whose coefficient 0 is not positive gets 0.
/// light  nine coefficients of the reference
glm::vec3 solveDc(const ErrorForm& form, std::span<const glm::vec3> light, const HigherByChannel& ratios);

/// The form times ratios.
struct WeightedRatios {
    HigherByChannel higher;
    std::array<float, 3> zero;
};
WeightedRatios times(const RatioCost& cost, const ByChannel& ratios);

/// A texel to be coded.
struct BasisTarget {
    ByChannel ratio;  ///< true coefficients over the decoded coefficient 0
    RatioCost cost;
};

/// Returns P(code): coefficients 1 to 8 over coefficient 0.
HigherByChannel evaluateCode(const CodeTable& table, int monomialCount, const glm::vec4& code);
/// Adds sum_k (texel_k - neutral) R_k.
void addResidual(const ResidualTable& table, const glm::vec4& texel, ByChannel& ratio);

/// Subtracts 1 from coefficient 0 and a decoded code from the others: the residual is left.
void subtractCode(const HigherByChannel& decoded, ByChannel& ratio);
/// Subtracts sum_k (texel_k - neutral) R_k: the next residual is left.
void subtractResidual(const ResidualTable& table, const glm::vec4& texel, ByChannel& ratio);

/// Returns the residual texel whose sum is nearest to target.ratio, clamped to [0, 1]^4: weighted least squares of four unknowns.
glm::vec4 solveResidual(const ResidualTable& table, const BasisTarget& target);

/// Returns the second derivative of the error with each residual channel (halved): R_k' M R_k, summed over colours.
glm::vec4 residualSensitivity(const ResidualTable& table, const BasisTarget& target);

/// Returns the value as a 16-bit float holds it, at most 65504. Tables are fitted as the GPU will have them.
float roundedToHalf(double value);

}  // namespace lightcook::compress

// The cost of an error in the light of a texel, as the shading of its surface shows it: a quadratic form of nine SH coefficients in three
// channels. Private to compress/.
//
// Shading k turns light into the colour E_k = sum_i row_ki light_i. An error e of the light costs the mean over shadings of |J_k e_k|^2,
// where e_k is the error of the shaded colour, and J_k is
//   objective visible  the Jacobian of 720 (I, T, P) of ITU-R BT.2124 at the reference's colour E_k: squared distances are then squared
//                      visible errors, as long as these are small (docs/theory/visible.md)
//   objective energy   the identity
// Shadings are normals around the texel's own, and views and materials of area specular light at its own normal. Since J_k does not depend
// on coefficients and row_k not on channels, the form is sum_k (J_k' J_k) x (row_k row_k'): six products of channels times 45 products of
// coefficients. Products of rows are computed once for a normal, since charts are mostly flat.
#pragma once

#include <array>
#include <cstddef>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "compress/light_map.h"
#include "lighting/sh.h"

namespace lightcook::compress {

inline constexpr std::size_t kCoefficientCount = lighting::kShCount;

/// A symmetric form Q: an error e costs the sum over channels c, d and coefficients i, j of e_ci Q_cidj e_dj. Each pair of channels is
/// symmetric in the coefficients.
struct ErrorForm {
    static constexpr std::size_t kPairs = 6;  ///< rr, gg, bb, rg, rb, gb
    static constexpr std::size_t pairOf(std::size_t c, std::size_t d) { return c == d ? c : c + d + 2; }

    std::array<std::array<std::array<float, lighting::kShCount>, lighting::kShCount>, kPairs> part;

    const std::array<std::array<float, lighting::kShCount>, lighting::kShCount>& of(std::size_t c, std::size_t d) const {
        return part[pairOf(c, d)];
    }
};

/// The same in 60 % of the memory: the lower triangle of each pair, row by row.
struct PackedForm {
    static constexpr std::size_t kProducts = 45;
    std::array<std::array<float, kProducts>, ErrorForm::kPairs> part{};

    /// Returns the place of the square of coefficient i.
    static constexpr std::size_t diagonal(std::size_t i) { return i * (i + 3) / 2; }
    ErrorForm unpacked() const;
};

class ShadingForm {
public:
    /// objective    empty: energy
    /// unit         light of the map for each unit of the light that is given: squares of it must not overflow
    /// lightSquare  mean square of the map's coefficient 0, in units of the given light: visible errors have a share of energy; 0: none
    ShadingForm(const std::optional<LightMapObjective>& objective, double unit, double lightSquare = 0);
    /// Returns the form of a surface around a unit normal.
    /// light  nine coefficients of the reference
    PackedForm at(std::span<const glm::vec3> light, const glm::vec3& normal);

private:
    /// Rows and products are padded by zeros, so that loops run in whole vectors.
    static constexpr std::size_t kLanes = 8, kProducts = (PackedForm::kProducts + kLanes - 1) / kLanes * kLanes;
    void turnTo(const glm::vec3& normal);
    void shade(std::span<const glm::vec3> light);
    void weighColours();
    /// Sets the products of kTogether pairs of channels from `first` on.
    template <std::size_t kTogether>
    void sumProducts(std::size_t first, PackedForm& form) const;

    using PerShading = std::vector<float>;
    bool isVisible_;
    std::size_t count_ = 0;                      ///< shadings, padded
    std::vector<lighting::ShDouble> local_;      ///< rows in the frame whose z is the normal
    std::array<std::array<float, 3>, 3> lms_{};  ///< [row][channel]: LMS [cd/m^2] of light
    /// [pair of channels][row][row]: factors of the products of two slopes in J' J
    std::array<std::array<std::array<float, 3>, 3>, ErrorForm::kPairs> factors_{};
    float energyCost_ = 0;                                ///< of a squared error of coefficient 0
    float black_ = 0;                                     ///< [cd/m^2]
    glm::vec3 normal_{0};                                 ///< of the rows and products below
    std::array<PerShading, lighting::kShCount> rows_;     ///< [coefficient], in the world
    std::vector<std::array<float, kProducts>> products_;  ///< [shading]
    std::array<PerShading, 3> colours_, seen_;            ///< [channel]
    std::array<PerShading, ErrorForm::kPairs> weights_;   ///< J' J
};

}  // namespace lightcook::compress

// How far the decode of a layout can be from its ideal at any place of a quad, when each texel is off by what a sampler is free to do: of
// each coefficient and channel, by the decode's largest derivatives over the quad's texels (a Lipschitz bound; products of deviations are
// inside, as every factor is taken at its largest with its own). Private to verify/.
#pragma once

#include <glm/vec3.hpp>

#include "verify/light_map/layouts.h"
#include "verify/sampler_tolerance.h"

namespace lightcook::verify::layouts {

template <std::size_t kLayers>
using Boxes = std::array<TexelBox, kLayers>;

/// By coefficient and channel: at most `absolute`, and beside it, for each group, a sum of its four vectors, each times a number in [-1, 1]
/// (a texel's four channels; the vectors have signs, and often cancel).
template <std::size_t kGroups>
struct Deviation {
    shaders::LcSh absolute{};
    std::array<std::array<shaders::LcSh, 4>, kGroups> groups{};
};

namespace detail {

inline glm::vec3 rgb(const glm::vec4& v) {
    return {v.x, v.y, v.z};
}

/// Coefficient 0 and `count` more as scaled ratios to it.
template <std::size_t kLayers, class Constants>
shaders::LcSh ratioDeviation(const Boxes<kLayers>& t, const Constants& k, std::size_t count) {
    shaders::LcSh out{};
    const glm::vec3 l0 = rgb(t[0].largest()), off = rgb(t[0].freedom);
    out.c[0] = k.range * off;
    for (std::size_t i = 0; i < count; ++i) {
        const TexelBox& ratio = t[1 + i];
        const float scale = std::abs(k.scale[i]);
        const glm::vec3 value = glm::abs(k.scale[i] * rgb(ratio.centre) + k.bias[i]) + scale * rgb(ratio.half + ratio.freedom);
        out.c[i + 1] = k.range * (off * value + l0 * (scale * rgb(ratio.freedom)));
    }
    return out;
}

/// The first `count` layers of luvw_first, luvw_second.
template <std::size_t kLayers, class Constants>
shaders::LcSh luvwDeviation(const Boxes<kLayers>& t, const Constants& k) {
    constexpr std::size_t kCount = kLayers / 2;
    shaders::LcSh out{};
    const glm::vec3 centre = rgb(k.neutral);
    for (std::size_t i = 0; i < kCount; ++i) {
        const TexelBox &first = t[i], &second = t[kCount + i];
        const float span = std::abs(2 * k.span[i]);
        const glm::vec3 off = 2.0f * rgb(first.freedom) + span * rgb(second.freedom);
        const glm::vec3 value = glm::abs(2.0f * rgb(first.centre) - 1.0f + 2 * k.span[i] * (rgb(second.centre) - centre)) +
                                2.0f * rgb(first.half) + span * rgb(second.half) + off;
        const float a0 = first.largest().w, a1 = second.largest().w;
        out.c[i] = std::abs(k.range[i]) * (a0 * a1 * off + (a0 * second.freedom.w + a1 * first.freedom.w) * value);
    }
    return out;
}

}  // namespace detail

inline shaders::LcSh deviationOf(const Raw& layout, const Boxes<9>& t) {
    shaders::LcSh out{};
    for (std::size_t i = 0; i < t.size(); ++i) out.c[i] = std::abs(layout.k.range) * detail::rgb(t[i].freedom);
    return out;
}
inline shaders::LcSh deviationOf(const Flat& layout, const Boxes<1>& t) {
    shaders::LcSh out{};
    out.c[0] = std::abs(layout.k.range) / Flat::kY0 * detail::rgb(t[0].freedom);
    return out;
}
inline shaders::LcSh deviationOf(const Ratio& layout, const Boxes<9>& t) {
    return detail::ratioDeviation(t, layout.k, 8);
}
inline shaders::LcSh deviationOf(const Luvw& layout, const Boxes<18>& t) {
    return detail::luvwDeviation(t, layout.k);
}
/// Of bands(): the zonal coefficient in c[4].
inline shaders::LcSh deviationOf(const Zh3& layout, const Boxes<5>& t) {
    return detail::ratioDeviation(t, layout.k, 4);
}
inline shaders::LcSh deviationOf(const LuvwLinear& layout, const Boxes<10>& t) {
    shaders::LcSh out = detail::luvwDeviation(t, layout.k);
    out.c[4] *= 0.63078314f;  // as lcLuvwLinearBands, rounded up
    return out;
}

/// The polynomial's part of a basis over a box of codes, by coefficient from 1 up.
struct CodeRange {
    std::array<glm::vec3, 8> largest;               ///< |P_i|
    std::array<std::array<glm::vec3, 8>, 4> slope;  ///< [code] of P_i in the middle of the box
    std::array<std::array<glm::vec3, 8>, 4> bend;   ///< [code] what it changes towards the box's sides
};
template <int kCodes>
CodeRange codeRange(const glm::vec3* v, const TexelBox& code) {
    // Where the factors of the products of codes j and k lie; see lcBasisMonomials.
    constexpr int kSquare[4][4] = {{4, 5, 6, 11}, {5, 7, 8, 12}, {6, 8, 9, 13}, {11, 12, 13, 14}};
    constexpr int kLinear[4] = {1, 2, 3, 10};
    const glm::vec4 half = code.half + code.freedom;
    CodeRange out{};
    for (std::size_t i = 0; i < 8; ++i) {
        glm::vec3 value = v[i], spread(0);
        for (int j = 0; j < kCodes; ++j) {
            // P = P(0) + sum_j c_j (g_j(0) + g_j(c)) / 2, g the gradient: of a quadratic that is exact.
            const glm::vec3 first = v[static_cast<std::size_t>(8 * kLinear[j]) + i];
            glm::vec3 slope = first, bend(0);
            for (int l = 0; l < kCodes; ++l) {
                const glm::vec3 second = (j == l ? 2.0f : 1.0f) * v[static_cast<std::size_t>(8 * kSquare[j][l]) + i];
                slope += code.centre[l] * second;
                bend += half[l] * glm::abs(second);
            }
            value += 0.5f * code.centre[j] * (first + slope);
            spread += half[j] * (glm::abs(slope) + bend);
            out.slope[static_cast<std::size_t>(j)][i] = slope;
            out.bend[static_cast<std::size_t>(j)][i] = bend;
        }
        out.largest[i] = glm::abs(value) + spread;
    }
    return out;
}

template <int kCodes, std::size_t kResiduals>
Deviation<1 + kResiduals> deviationOf(const typename Basis<kCodes, kResiduals>::Decode& decode, const Boxes<2 + kResiduals>& t) {
    const BasisTables& tables = *decode.tables;
    const glm::vec3* v = kCodes == 3 ? tables.first3[decode.cluster].v : tables.first4[decode.cluster].v;
    const CodeRange code = codeRange<kCodes>(v, t[1]);
    const glm::vec3 range(std::abs(tables.range));
    const glm::vec3 l0 = range * detail::rgb(t[0].largest()), l0Off = range * detail::rgb(t[0].freedom);
    Deviation<1 + kResiduals> out;
    std::array<glm::vec3, 9> largest{glm::vec3(1)};
    for (std::size_t i = 0; i < 8; ++i) {
        largest[i + 1] = code.largest[i];
        for (std::size_t j = 0; j < 4; ++j) {
            const float freedom = t[1].freedom[static_cast<int>(j)];
            out.groups[0][j].c[i + 1] = freedom * l0 * code.slope[j][i];
            out.absolute.c[i + 1] += freedom * l0 * code.bend[j][i];
        }
    }
    for (std::size_t layer = 0; layer < kResiduals; ++layer) {
        const shaders::LcBasisResidual& basis = tables.residual[layer][decode.cluster];
        const TexelBox& residual = t[2 + layer];
        const glm::vec4 reach = glm::abs(residual.centre - tables.neutral) + residual.half + residual.freedom;
        for (std::size_t j = 0; j < 4; ++j)
            for (std::size_t i = 0; i < 9; ++i) {
                const glm::vec3& factor = basis.v[9 * j + i];
                largest[i] += reach[static_cast<int>(j)] * glm::abs(factor);
                out.groups[1 + layer][j].c[i] = residual.freedom[static_cast<int>(j)] * l0 * factor;
            }
    }
    for (std::size_t i = 0; i < 9; ++i) out.absolute.c[i] += l0Off * largest[i];
    return out;
}

}  // namespace lightcook::verify::layouts

// Deviation of a decode: upper bounds of the change of each decoded coefficient if every texel of a box is changed within the sampler
// tolerance. Private to verify/.
//
// A Lipschitz bound by the largest derivatives over the box. For a product of factors, |ab - a'b'| <= |a| |b - b'| + |b'| |a - a'|: each
// factor is taken at its largest value with its own deviation, so products of deviations are covered. The learned layouts have polynomials
// of four codes, whose derivatives often cancel between coefficients: they keep signed vectors (lightmap::Deviation::groups) instead of
// lengths.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <numbers>
#include <span>
#include <vector>

#include "verify/light_map/layouts.h"
#include "verify/light_map/map_decoder.h"
#include "verify/light_map/rounding.h"
#include "verify/sampler_tolerance.h"

namespace lightcook::verify::layouts {

/// Boxes of the layers, one each.
template <std::size_t kLayers>
using Boxes = std::span<const TexelBox, kLayers>;

namespace detail {

inline glm::vec3 rgb(const glm::vec4& v) {
    return {v.x, v.y, v.z};
}

}  // namespace detail

inline shaders::LcSh deviationOf(const Raw& layout, const Boxes<9>& t) {
    shaders::LcSh out{};
    for (std::size_t i = 0; i < t.size(); ++i) out.c[i] = std::abs(layout.k.range) * detail::rgb(t[i].tolerance);
    return out;
}
inline shaders::LcSh deviationOf(const Flat& layout, const Boxes<1>& t) {
    shaders::LcSh out{};
    out.c[0] = std::abs(layout.k.range) / Flat::kY0 * detail::rgb(t[0].tolerance);
    return out;
}
inline shaders::LcSh deviationOf(const Flat2& layout, const Boxes<2>& t) {
    shaders::LcSh out{};
    const glm::vec3 off =
        std::abs(1 - layout.k.share) * detail::rgb(t[0].tolerance) + std::abs(layout.k.share) * detail::rgb(t[1].tolerance);
    out.c[0] = std::abs(layout.k.range) / Flat::kY0 * off;
    return out;
}

/// hdr: v_i = range sh_i or range mix(sh_i, second_i, share), c_i = v_i + bias_i v_0.
template <HdrFamily Layout>
shaders::LcSh deviationOf(const Layout& layout, const Boxes<Layout::kLayers>& t) {
    const auto& k = layout.k;
    shaders::LcSh out{};
    for (std::size_t i = 0; i < 9; ++i) {
        glm::vec3 off = detail::rgb(t[i].tolerance);
        if constexpr (requires { k.share; }) off = std::abs(1 - k.share) * off + std::abs(k.share) * detail::rgb(t[9 + i].tolerance);
        out.c[i] = std::abs(k.range) * off;
        if (i > 0) out.c[i] += std::abs(k.bias[i - 1]) * out.c[0];
    }
    return out;
}

/// Changes of a coefficient of the light alone: |I| and |Y_i| at most, with their changes. A direction whose octahedral components are off
/// by t is off by at most 17 t: |d n| <= sqrt(6^2 + 6^2 + 4^2) t before its length, at least 1 / sqrt 3, is divided by.
inline float basisDeviation(std::size_t i, const glm::vec4& direction) {
    constexpr std::array<float, 3> kSteepest = {0, 0.489f, 1.9f};  // |gradient| of the basis functions of a band
    return 17 * std::max(direction.x, direction.y) * kSteepest[static_cast<std::size_t>(lighting::kShBand[i])];
}

/// One light and the rest: c_0 = range l0, c_i = rest (scale_i rest_i + bias_i) + I Y_i(d), rest = c_0 - Y_0 I, where l0 and the intensity
/// are exact in every format that holds them.
template <DecodedBeforeFilter Layout>
shaders::LcSh deviationOf(const Layout& layout, const Boxes<Layout::kLayers>& t) {
    const auto& k = layout.k;
    shaders::LcSh out{};
    const glm::vec3 l0 = k.range * detail::rgb(t[0].largest()), light = k.range * detail::rgb(t[1].largest());
    for (std::size_t i = 0; i + 1 < lighting::kShCount; ++i)
        out.c[i + 1] = std::abs(k.scale[i]) * l0 * detail::rgb(t[3 + i].tolerance) + basisDeviation(i + 1, t[2].tolerance) * light;
    return out;
}

/// Ratios: c_0 = range l0, c_i = range l0 (scale_i ratio_i + bias_i).
template <RatioFamily Layout>
shaders::LcSh deviationOf(const Layout& layout, const Boxes<Layout::kLayers>& t) {
    const auto& k = layout.k;
    shaders::LcSh out{};
    const glm::vec3 l0 = detail::rgb(t[0].largest()), off = detail::rgb(t[0].tolerance);
    out.c[0] = k.range * off;
    for (std::size_t i = 0; i < Layout::kRatioCount; ++i) {
        const TexelBox& ratio = t[1 + i];
        const float scale = std::abs(k.scale[i]);
        const glm::vec3 value =
            glm::abs(k.scale[i] * detail::rgb(ratio.centre) + k.bias[i]) + scale * detail::rgb(ratio.half + ratio.tolerance);
        out.c[i + 1] = k.range * (off * value + l0 * (scale * detail::rgb(ratio.tolerance)));
    }
    return out;
}

/// Linear exit radiance: c_0 = first L0, c_i = slope L0 (u_i - 1/2).
template <LinearExitLayout Layout>
shaders::LcSh deviationOf(const Layout&, const Boxes<Layout::kLayers>& t) {
    Texels<Layout::kLayers> centre, reach, tolerance;
    for (std::size_t layer = 0; layer < t.size(); ++layer) {
        centre[layer] = t[layer].centre;
        tolerance[layer] = t[layer].tolerance;
        reach[layer] = t[layer].half + t[layer].tolerance;
    }
    const glm::vec3 l0 = detail::rgb(t[0].largest()), off = detail::rgb(t[0].tolerance);
    shaders::LcSh out{};
    out.c[0] = Layout::kFirst * off;
    for (std::size_t i = 1; i < 4; ++i) {
        const glm::vec3 value = glm::abs(Layout::unit(centre, i) - 0.5f) + Layout::unit(reach, i);
        out.c[i] = Layout::kSlope * (off * value + l0 * Layout::unit(tolerance, i));
    }
    return out;
}

/// halo3: c_i = range_i a0 a1 uvw, where a0, a1 are the alphas and uvw = 2 (rgb0 + rgb1 - 1).
inline shaders::LcSh deviationOf(const Halo3& layout, const Boxes<18>& t) {
    using detail::rgb;
    shaders::LcSh out{};
    for (std::size_t i = 0; i < 9; ++i) {
        const TexelBox &first = t[i], &second = t[9 + i];
        const glm::vec3 off = 2.0f * (rgb(first.tolerance) + rgb(second.tolerance));
        const glm::vec3 value = 2.0f * (glm::abs(rgb(first.centre) + rgb(second.centre) - 1.0f) + rgb(first.half) + rgb(second.half)) + off;
        const float a0 = first.largest().w, a1 = second.largest().w;
        out.c[i] = std::abs(layout.k.range[i]) * (a0 * a1 * off + (a0 * second.tolerance.w + a1 * first.tolerance.w) * value);
    }
    return out;
}

/// The largest factors of Unreal's decode over boxes of its two texels.
struct UnrealFactors {
    float exponential, luminance;  ///< 2^E, |2^E - kBlack|
    glm::vec3 root, color;         ///< |root|, |root^2 scale + add|
    glm::vec4 sh;

    UnrealFactors(const UnrealHq& layout, const Texels<2>& low, const Texels<2>& high) {
        const auto& k = layout.k;
        const auto exponentialOf = [&](const Texels<2>& t) { return std::exp2(fractionOf(t.data()) * k.scale0.w + k.add0.w); };
        const float first = exponentialOf(low), second = exponentialOf(high);
        exponential = lightmap::kOutwardUnreal * std::max(first, second);
        luminance = std::max(std::abs(first - UnrealHq::kBlack), std::abs(second - UnrealHq::kBlack)) +
                    (lightmap::kOutwardUnreal - 1) * exponential;
        const glm::vec3 lowRoot = detail::rgb(low[0]), highRoot = detail::rgb(high[0]), scale = detail::rgb(k.scale0),
                        add = detail::rgb(k.add0);
        root = glm::max(glm::abs(lowRoot), glm::abs(highRoot));
        const glm::vec3 least = glm::max(glm::max(lowRoot, -highRoot), 0.0f);
        color = glm::max(glm::abs(root * root * scale + add), glm::abs(least * least * scale + add)) +
                (lightmap::kOutwardUnreal - 1) * (root * root * glm::abs(scale) + glm::abs(add));
        sh = glm::max(glm::abs(low[1] * k.scale1 + k.add1), glm::abs(high[1] * k.scale1 + k.add1));
    }
    /// Returns the fraction in E = fraction scale0.a + add0.a.
    static float fractionOf(const glm::vec4* t) { return t[0].w + (t[1].w - 0.5f) / 255; }
    /// Relative error of a float evaluation of 2^E. Vulkan allows exp2(x) an error of 3 + 2 |x| units in the last place; x is rounded too.
    static float exponentialRounding(const UnrealHq& layout) {
        return 1.2e-7f * (3 + 3 * (std::abs(layout.k.scale0.w) + std::abs(layout.k.add0.w)));
    }
    /// Sets the four coefficients from the components of SH, of the same change of each.
    static shaders::LcSh coefficients(const std::array<glm::vec3, 4>& ofComponent) {
        shaders::LcSh out{};
        for (std::size_t i = 0; i < 4; ++i) out.c[(i + 1) % 4] = (i == 3 ? UnrealHq::kFirst : UnrealHq::kLinear) * ofComponent[i];
        return out;
    }
};

inline shaders::LcSh deviationOf(const UnrealHq& layout, const Boxes<2>& t) {
    const auto& k = layout.k;
    Texels<2> low, high;
    for (std::size_t i = 0; i < 2; ++i) {
        const glm::vec4 reach = t[i].half + t[i].tolerance;
        low[i] = t[i].centre - reach;
        high[i] = t[i].centre + reach;
    }
    const UnrealFactors largest(layout, low, high);
    const float exponent = std::numbers::ln2_v<float> * std::abs(k.scale0.w) * (t[0].tolerance.w + t[1].tolerance.w / 255);
    const float luminance = largest.exponential * (exponent + UnrealFactors::exponentialRounding(layout));
    const glm::vec3 color = 2.0f * glm::abs(detail::rgb(k.scale0)) * largest.root * detail::rgb(t[0].tolerance);
    const glm::vec4 sh = glm::abs(k.scale1) * t[1].tolerance;
    std::array<glm::vec3, 4> off;
    for (int i = 0; i < 4; ++i)
        off[static_cast<std::size_t>(i)] =
            (luminance * largest.color + largest.luminance * color) * largest.sh[i] + largest.luminance * sh[i] * largest.color;
    return UnrealFactors::coefficients(off);
}

/// Returns the length of coefficient 0 that shows an exit radiance under every normal, rounded up.
inline glm::vec3 constantOfExit(const glm::vec3& exitRadiance) {
    return exitRadiance / 0.282094f;
}

/// Returns an upper bound of the difference between what a layout in tangent space shows and what its coefficients show, as a change of
/// coefficient 0.
inline glm::vec3 besideOf(const Rnm&, const Texels<3>& largest) {
    return constantOfExit(Rnm::kResidual * (detail::rgb(largest[0]) + detail::rgb(largest[1]) + detail::rgb(largest[2])));
}

/// Directions in tangent space: linear in the texels. What is shown beside the coefficients counts as a change of coefficient 0.
inline shaders::LcSh deviationOf(const Rnm& layout, std::size_t cluster, const Boxes<3>& t) {
    const Rnm::Decode decode = layout.at(cluster);
    shaders::LcSh out{};
    Texels<3> tolerance;
    for (std::size_t i = 0; i < t.size(); ++i) {
        tolerance[i] = t[i].tolerance;
        Texels<3> one{};
        one[i] = t[i].tolerance;
        const shaders::LcSh off = decode.decode(one);
        for (std::size_t k = 0; k < 9; ++k) out.c[k] += glm::abs(off.c[k]);
    }
    out.c[0] += besideOf(layout, tolerance);
    return out;
}

/// Places of the polynomial's factors in lcBasisMonomials: of each code, and of each product of two codes.
inline constexpr int kLinearMonomial[4] = {1, 2, 3, 10};
inline constexpr int kProductMonomial[4][4] = {{4, 5, 6, 11}, {5, 7, 8, 12}, {6, 8, 9, 13}, {11, 12, 13, 14}};

/// The polynomials P_i of a learned layout over a box of codes, for coefficients 1 .. 8.
struct CodeRange {
    std::array<glm::vec3, 8> largest;                   ///< |P_i|
    std::array<std::array<glm::vec3, 8>, 4> slope;      ///< [code], derivative of P_i at the centre of the box
    std::array<std::array<glm::vec3, 8>, 4> curvature;  ///< [code], largest change of the derivative within the box
};
template <int kCodes>
CodeRange codeRange(const glm::vec3* v, const TexelBox& code) {
    const glm::vec4 half = code.half + code.tolerance;
    CodeRange out{};
    for (std::size_t i = 0; i < 8; ++i) {
        glm::vec3 value = v[i], spread(0);
        for (int j = 0; j < kCodes; ++j) {
            // P = P(0) + sum_j c_j (g_j(0) + g_j(c)) / 2 with the gradient g: exact for a quadratic.
            const glm::vec3 first = v[static_cast<std::size_t>(8 * kLinearMonomial[j]) + i];
            glm::vec3 slope = first, curvature(0);
            for (int l = 0; l < kCodes; ++l) {
                const glm::vec3 second = (j == l ? 2.0f : 1.0f) * v[static_cast<std::size_t>(8 * kProductMonomial[j][l]) + i];
                slope += code.centre[l] * second;
                curvature += half[l] * glm::abs(second);
            }
            value += 0.5f * code.centre[j] * (first + slope);
            spread += half[j] * (glm::abs(slope) + curvature);
            out.slope[static_cast<std::size_t>(j)][i] = slope;
            out.curvature[static_cast<std::size_t>(j)][i] = curvature;
        }
        out.largest[i] = glm::abs(value) + spread;
    }
    return out;
}

/// Learned layouts: c = range l0 (1, P(code)) + range l0 sum of residuals, P quadratic, residuals linear. The first group is the code, the
/// others are the residual layers.
template <int kCodes>
lightmap::Deviation deviationOf(const BasisTables& tables, std::size_t cluster, std::span<const TexelBox> t) {
    const std::size_t residuals = t.size() - 2;
    const glm::vec3* v = kCodes == 3 ? tables.first3[cluster].v : tables.first4[cluster].v;
    const CodeRange code = codeRange<kCodes>(v, t[1]);
    const glm::vec3 range(std::abs(tables.range));
    const glm::vec3 l0 = range * detail::rgb(t[0].largest()), l0Off = range * detail::rgb(t[0].tolerance);
    lightmap::Deviation out{{}, std::vector<std::array<shaders::LcSh, 4>>(1 + residuals)};
    std::array<glm::vec3, 9> largest{glm::vec3(1)};
    for (std::size_t i = 0; i < 8; ++i) {
        largest[i + 1] = code.largest[i];
        for (std::size_t j = 0; j < 4; ++j) {
            const float tolerance = t[1].tolerance[static_cast<int>(j)];
            out.groups[0][j].c[i + 1] = tolerance * l0 * code.slope[j][i];
            out.absolute.c[i + 1] += tolerance * l0 * code.curvature[j][i];
        }
    }
    for (std::size_t layer = 0; layer < residuals; ++layer) {
        const shaders::LcBasisResidual& basis = tables.residual[layer][cluster];
        const TexelBox& residual = t[2 + layer];
        const glm::vec4 reach = glm::abs(residual.centre - tables.neutral) + residual.half + residual.tolerance;
        for (std::size_t j = 0; j < 4; ++j)
            for (std::size_t i = 0; i < 9; ++i) {
                const glm::vec3& factor = basis.v[9 * j + i];
                largest[i] += reach[static_cast<int>(j)] * glm::abs(factor);
                out.groups[1 + layer][j].c[i] = residual.tolerance[static_cast<int>(j)] * l0 * factor;
            }
    }
    for (std::size_t i = 0; i < 9; ++i) out.absolute.c[i] += l0Off * largest[i];
    return out;
}

}  // namespace lightcook::verify::layouts

// Curvature of a decode that is no polynomial of the texels: how far it is from the bilinear blend of its values at the corners of a
// rectangle of places. Private to verify/.
//
// Over a unit square, with any f and its bilinear blend b of the corners,
//   |f - b| <= (max |f_uu| + max |f_vv|) / 8
// since linear interpolation errs by at most max |f''| / 8 along an axis. For a product of three factors,
//   (LUS)'' = L''US + LU''S + LUS'' + 2 (L'U'S + L'US' + LU'S')
// where each factor is taken at its largest value over the rectangle. Filtered texels are bilinear, so that their derivatives along an axis
// are at most their differences along two edges. For Unreal, with E, root and S linear along an axis,
//   L = 2^E - kBlack: L' = ln2 E' 2^E, L'' = (ln2 E')^2 2^E;   U = root^2 scale + add: U' = 2 scale root root', U'' = 2 scale root'^2.
// Halving a rectangle divides the curvature by four.
#pragma once

#include "verify/light_map/deviation.h"

namespace lightcook::verify::layouts {

using lightmap::QuadTexels;

namespace detail {

/// Returns the larger of |a| and |b|, by component. glm::abs calls a function for each component, which GCC does not inline.
inline float largerSize(float a, float b) {
    const float first = std::abs(a), second = std::abs(b);
    return first < second ? second : first;
}
inline glm::vec4 largerSize(const glm::vec4& a, const glm::vec4& b) {
    return {largerSize(a.x, b.x), largerSize(a.y, b.y), largerSize(a.z, b.z), largerSize(a.w, b.w)};
}
/// Returns the largest difference along an axis, 0 or 1, of values at the corners.
template <class Value>
Value step(const std::array<Value, 4>& at, int axis) {
    return axis == 0 ? largerSize(at[1] - at[0], at[3] - at[2]) : largerSize(at[2] - at[0], at[3] - at[1]);
}
template <class Value>
Value largestOf(const std::array<Value, 4>& at) {
    return largerSize(largerSize(at[0], at[1]), largerSize(at[2], at[3]));
}
inline std::array<glm::vec4, 4> layerAt(const QuadTexels& t, std::size_t layer) {
    return {t[0][layer], t[1][layer], t[2][layer], t[3][layer]};
}

}  // namespace detail

/// Returns upper bounds of |decode - bilinear blend of the decodes at the corners|, rounding of the exponential included.
inline shaders::LcSh curvatureOf(const UnrealHq& layout, const QuadTexels& ends) {
    const auto& k = layout.k;
    Texels<2> low, high;
    for (std::size_t i = 0; i < 2; ++i) {
        const auto at = detail::layerAt(ends, i);
        low[i] = glm::min(glm::min(at[0], at[1]), glm::min(at[2], at[3]));
        high[i] = glm::max(glm::max(at[0], at[1]), glm::max(at[2], at[3]));
    }
    const UnrealFactors largest(layout, low, high);
    const float luminance = largest.luminance, exponential = largest.exponential;
    const glm::vec3 scale = glm::abs(detail::rgb(k.scale0));
    std::array<glm::vec3, 4> off;
    for (int i = 0; i < 4; ++i)
        off[static_cast<std::size_t>(i)] = UnrealFactors::exponentialRounding(layout) * exponential * largest.sh[i] * largest.color;
    std::array<float, 4> fraction;
    for (std::size_t corner = 0; corner < 4; ++corner) fraction[corner] = UnrealFactors::fractionOf(ends[corner]);
    for (int axis = 0; axis < 2; ++axis) {
        const float exponent = std::numbers::ln2_v<float> * std::abs(k.scale0.w) * detail::step(fraction, axis);
        const glm::vec3 root = detail::rgb(detail::step(detail::layerAt(ends, 0), axis));
        const float luminance1 = exponent * exponential, luminance2 = exponent * luminance1;
        const glm::vec3 color1 = 2.0f * scale * largest.root * root, color2 = 2.0f * scale * root * root;
        const glm::vec4 sh1 = glm::abs(k.scale1) * detail::step(detail::layerAt(ends, 1), axis);
        const glm::vec3 both2 = luminance2 * largest.color + luminance * color2 + 2.0f * luminance1 * color1,
                        both1 = 2.0f * (luminance1 * largest.color + luminance * color1);
        for (int i = 0; i < 4; ++i) off[static_cast<std::size_t>(i)] += 0.125f * (largest.sh[i] * both2 + sh1[i] * both1);
    }
    return UnrealFactors::coefficients(off);
}

}  // namespace lightcook::verify::layouts

// The PQ curve in floats, for loops that run in vector lanes. Fused multiplications are called by name, so that every instruction set
// rounds alike. Private to verify/.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <utility>

namespace lightcook::verify {

/// Returns log2 of a normal, positive number: the mantissa m in [sqrt(1/2), sqrt 2) by the series of artanh((m - 1)/(m + 1)). Within 6e-7
/// from 2^-16 to 2^16, and within 4.5e-6 elsewhere, where the exponent leaves fewer digits to the fraction.
inline float log2Of(float x) {
    constexpr std::int32_t kRootHalf = 0x3f3504f3;
    const auto bits = std::bit_cast<std::int32_t>(x);
    const std::int32_t exponent = (bits - kRootHalf) >> 23;
    const auto mantissa = std::bit_cast<float>(bits - exponent * (1 << 23));
    const float s = (mantissa - 1) / (mantissa + 1), square = s * s;
    const float series = std::fma(square, std::fma(square, std::fma(square, 0.412198583f, 0.577078016f), 0.961796694f), 2.885390082f);
    return std::fma(s, series, static_cast<float>(exponent));
}

/// The curve's code over u, the logarithm of the luminance scaled to [-1, 1] from 2^-8 to 10000 cd/m^2: a polynomial of degree 12,
/// interpolated at the Chebyshev points. It is within 2e-7 of the curve, and its slope within 0.01 %.
inline constexpr std::array kPerceptualQuantizer = {0.263920428f,   0.541255862f,     0.32387875f,     -0.0581648655f,  -0.104593237f,
                                                    0.0148444869f,  0.0291957965f,    -0.00634778856f, -0.00689679671f, 0.00216951081f,
                                                    0.00124764763f, -0.000379635896f, -0.00013018319f};
inline constexpr float kPerHalfRange = 1 / 10.6438562f;

/// Returns the place of a luminance on the polynomial's axis; it is clamped to [2^-8, 10000] cd/m^2.
inline float perceptualPlaceOf(float nits) {
    // Positive numbers are in the order of their bits, and integers are clamped without branches, which would keep a loop scalar.
    constexpr auto kLowest = std::bit_cast<std::int32_t>(0x1p-8f), kHighest = std::bit_cast<std::int32_t>(10000.0f);
    constexpr float kMiddle = 2.64385619f;
    const std::int32_t clamped = std::min(std::max(std::bit_cast<std::int32_t>(nits), kLowest), kHighest);
    return (log2Of(std::bit_cast<float>(clamped)) - kMiddle) * kPerHalfRange;
}
/// Returns lighting::perceptualQuantizer of a luminance, which is clamped to [2^-8, 10000] cd/m^2.
inline float perceptualQuantizerOf(float nits) {
    const float u = perceptualPlaceOf(nits);
    float sum = kPerceptualQuantizer.back();
    // Written out: in an inner loop, GCC unrolls too late for its vectorizer.
    [&]<std::size_t... kSteps>(std::index_sequence<kSteps...>) {
        ((sum = std::fma(sum, u, kPerceptualQuantizer[kPerceptualQuantizer.size() - 2 - kSteps])), ...);
    }
    (std::make_index_sequence<kPerceptualQuantizer.size() - 1>());
    return sum;
}
/// Returns the derivative of the curve by the natural logarithm of the luminance.
inline float perceptualSlopeOf(float nits) {
    const float u = perceptualPlaceOf(nits);
    float sum = 0;
    for (std::size_t i = kPerceptualQuantizer.size() - 1; i > 0; --i)
        sum = std::fma(sum, u, static_cast<float>(i) * kPerceptualQuantizer[i]);
    return sum * (kPerHalfRange * 1.44269504f);
}

}  // namespace lightcook::verify

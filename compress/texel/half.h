// Conversion between float and the bits of a half (binary16).
#pragma once

#include <bit>
#include <cstdint>

namespace lightcook::compress {

constexpr float kLargestHalf = 65504.0f;
constexpr int kLargestHalfBits = 0x7BFF;

/// Returns the half nearest to a finite value, ties to even; values beyond +-65504 become +-65504.
inline std::uint16_t halfFromFloat(float value) {
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(value);
    const std::uint32_t sign = (bits >> 16) & 0x8000u;
    const std::uint32_t magnitude = bits & 0x7FFFFFFFu;
    std::uint32_t half;
    if (magnitude >= 0x477FE000u) {  // 65504
        half = kLargestHalfBits;
    } else if (magnitude >= 0x38800000u) {  // 2^-14, the smallest normal
        const std::uint32_t rebased = magnitude - 0x38000000u;
        half = (rebased + 0x0FFFu + ((rebased >> 13) & 1u)) >> 13;
    } else {
        // Adding 0.5 rounds to multiples of 2^-24, the denormal step of a half.
        half = std::bit_cast<std::uint32_t>(std::bit_cast<float>(magnitude) + 0.5f) - 0x3F000000u;
    }
    return static_cast<std::uint16_t>(sign | half);
}

inline float floatFromHalf(std::uint16_t half) {
    const std::uint32_t sign = static_cast<std::uint32_t>(half & 0x8000u) << 16;
    const std::uint32_t magnitude = half & 0x7FFFu;
    // 2^112 moves the exponent of the half to that of the float. The product is exact, for denormals too.
    const float value = std::bit_cast<float>(magnitude << 13) * std::bit_cast<float>(0x77800000u);
    return std::bit_cast<float>(std::bit_cast<std::uint32_t>(value) | sign);
}

}  // namespace lightcook::compress

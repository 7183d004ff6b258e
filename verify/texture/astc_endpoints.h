// ASTC's sixteen ways to store a pair of endpoint colours. Source: Khronos Data Format 1.3, chapter 23, LDR and HDR endpoint decoding.
#pragma once

#include <array>
#include <span>

namespace lightcook::verify {

struct AstcEndpoints {
    std::array<int, 4> low{}, high{};  ///< at weight 0 and 64; LDR channels 0..255, HDR ones 0..4095
    bool isHdrRgb = false, isHdrAlpha = false;
};

/// Returns the number of stored values of a mode: 2, 4, 6 or 8.
constexpr int astcEndpointValueCount(int mode) {
    return 2 * (mode / 4 + 1);
}

/// Decodes a pair of endpoints.
/// mode    0..15
/// values  at least astcEndpointValueCount(mode), each 0..255
AstcEndpoints astcDecodeEndpoints(int mode, std::span<const int> values);

}  // namespace lightcook::verify

// A peer for the tests of bench/peer_encoders.h: gives each block the colour of its first texel. It reads bytes for BC4, floats for BC1 and
// halfs for BC6H. Compiled several times, sound and with one fault each.
#include <cmath>
#include <cstring>
#include <string_view>

#include "bench/encoder_peer.h"

#ifdef TINY_PEER_WITHOUT_ENCODE
#define lightcook_peer_encode lightcook_peer_encode_renamed
#endif

namespace {

/// A block of BC1 whose two ends are the colour.
void encodeBc1(const float* texel, unsigned char* block) {
    const auto part = [](float value, float steps) { return static_cast<unsigned>(std::lround(value * steps)); };
    const unsigned colour = part(texel[0], 31) << 11 | part(texel[1], 63) << 5 | part(texel[2], 31);
    for (int end = 0; end < 2; ++end) {
        block[2 * end] = static_cast<unsigned char>(colour & 255);
        block[2 * end + 1] = static_cast<unsigned char>(colour >> 8);
    }
    std::memset(block + 4, 0, 4);
}

void encodeBc4(const std::uint8_t* texel, unsigned char* block) {
    block[0] = block[1] = texel[0];
    std::memset(block + 2, 0, 6);
}

/// A block of BC6H in the mode of ten bits without deltas: header 00011, six codes of ten bits, indices of 0.
void encodeBc6h(const std::uint16_t* texel, unsigned char* block) {
    std::memset(block, 0, 16);
    const auto put = [block](unsigned value, int first, int count) {
        for (int i = 0; i < count; ++i)
            if (value >> i & 1) block[(first + i) / 8] = static_cast<unsigned char>(block[(first + i) / 8] | 1u << (first + i) % 8);
    };
    put(3, 0, 5);
    for (int i = 0; i < 6; ++i) put(texel[i % 3] / 31u, 5 + 10 * i, 10);
}

}  // namespace

// NOLINTBEGIN(readability-identifier-naming): the names of the interface
extern "C" {

int32_t lightcook_peer_interface(void) {
#ifdef TINY_PEER_OLD
    return LIGHTCOOK_PEER_INTERFACE + 1;
#else
    return LIGHTCOOK_PEER_INTERFACE;
#endif
}

const char* lightcook_peer_name(void) {
    return "tiny <peer>";
}

const char* lightcook_peer_profile(const char* format, int32_t profile) {
    const std::string_view name = format;
    if (name != "bc1" && name != "bc4" && name != "bc6h-uf16") return nullptr;
    return profile == 0 ? "first texel" : profile == 1 ? "again" : nullptr;
}

int32_t lightcook_peer_texels(const char* format) {
#ifdef TINY_PEER_TYPE
    return 77 + (*format == 0);
#else
    const std::string_view name = format;
    return name == "bc1" ? LIGHTCOOK_PEER_RGBA32F : name == "bc4" ? LIGHTCOOK_PEER_RGBA8 : LIGHTCOOK_PEER_RGBA16F;
#endif
}

int32_t lightcook_peer_encode(const char* format, int32_t profile, const void* texels, int32_t width, int32_t height, void* blocks) {
#ifdef TINY_PEER_FAILS
    if (profile == 1) return 42;
#endif
    if (!lightcook_peer_profile(format, profile)) return 1;
    const std::string_view name = format;
    auto* block = static_cast<unsigned char*>(blocks);
    for (int32_t y = 0; y < height; y += 4)
        for (int32_t x = 0; x < width; x += 4) {
            const auto first = 4 * (static_cast<std::ptrdiff_t>(y) * width + x);
            if (name == "bc1")
                encodeBc1(static_cast<const float*>(texels) + first, block);
            else if (name == "bc4")
                encodeBc4(static_cast<const std::uint8_t*>(texels) + first, block);
            else
                encodeBc6h(static_cast<const std::uint16_t*>(texels) + first, block);
            block += name == "bc6h-uf16" ? 16 : 8;
        }
    return 0;
}
}
// NOLINTEND(readability-identifier-naming)

// Decoders of single blocks, one source file for each family of formats; others call texture_unit.h. Written from the formats' public
// specifications, independently of compress/, so that an encoder's misunderstanding of a format is detected.
//
// Texels are in row order. Missing channels are 0, a missing alpha is 1.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <glm/vec4.hpp>
#include <span>

namespace lightcook::verify {

using Block8 = std::span<const std::byte, 8>;
using Block16 = std::span<const std::byte, 16>;
using Texels4x4 = std::span<glm::vec4, 16>;

/// Ideal real-valued interpolation between endpoints r/31, g/63, b/31 (Direct3D 11.3 functional specification 19.5). Hardware may differ
/// within verify/sampler_tolerance.h. The fourth colour of three is opaque black in BC1 without alpha, transparent black with alpha.
void decodeBc1(Block8 block, Texels4x4 out);
void decodeBc1Alpha(Block8 block, Texels4x4 out);
void decodeBc3(Block16 block, Texels4x4 out);
void decodeBc4(Block8 block, Texels4x4 out);
void decodeBc5(Block16 block, Texels4x4 out);
/// Signed blocks: endpoints are bytes over 127, where -128 means -1 as -127 does. The palette follows from the order of the bytes as stored
/// (EXT_texture_compression_rgtc leaves the order of -127 and -128 open; hardware may differ there).
void decodeBc4Snorm(Block8 block, Texels4x4 out);
void decodeBc5Snorm(Block16 block, Texels4x4 out);

/// Decodes to exact half floats. Reserved modes give (0, 0, 0, 1).
void decodeBc6h(Block16 block, bool isSigned, Texels4x4 out);
/// Decodes to exact 8-bit values over 255. The reserved mode (first byte 0) gives (0, 0, 0, 0).
void decodeBc7(Block16 block, Texels4x4 out);

/// ASTC, two-dimensional, any block size up to 12 x 12. out: width * height texels. Values are those of an FP16 decoder (Khronos Data
/// Format 1.3, chapter 23). Illegal blocks give the error colour: opaque magenta (1, 0, 1, 1) in the LDR profile, NaN in all channels in
/// the HDR one.
void decodeAstc(Block16 block, int width, int height, bool isHdrProfile, std::span<glm::vec4> out);

/// Decoders of single texels, little endian.
glm::vec4 decodeRgb9e5(std::span<const std::byte, 4> texel);
glm::vec4 decodeR11g11b10f(std::span<const std::byte, 4> texel);
/// channelCount halves, 16-bit unorms, or 8-bit unorms; sRGB applies to R, G, B.
glm::vec4 decodeHalfs(std::span<const std::byte> texel, int channelCount);
glm::vec4 decodeUnorm16(std::span<const std::byte> texel, int channelCount);
glm::vec4 decodeUnorm8(std::span<const std::byte, 4> texel);
glm::vec4 decodeSrgb8(std::span<const std::byte, 4> texel);

/// Returns the exact value of a half. Infinities and NaN are kept.
inline float floatFromHalf(std::uint16_t half) {
    const std::uint32_t magnitude = half & 0x7fffu, sign = static_cast<std::uint32_t>(half & 0x8000u) << 16;
    if (magnitude >= 0x7c00) return std::bit_cast<float>(sign | 0x7f800000u | (magnitude & 0x3ff) << 13);
    // In a float's place the exponent is 112 too small, also for subnormals. One exact product corrects it.
    const float value = std::bit_cast<float>(magnitude << 13) * 0x1p112f;
    return std::bit_cast<float>(std::bit_cast<std::uint32_t>(value) | sign);
}

/// Reads the bits of a block from the lowest up.
class BlockBits {
public:
    explicit BlockBits(Block16 block) {
        for (std::size_t i = 8; i-- > 0;) {
            low_ = low_ << 8 | std::to_integer<std::uint64_t>(block[i]);
            high_ = high_ << 8 | std::to_integer<std::uint64_t>(block[i + 8]);
        }
    }
    /// Returns the next `count` bits, 0 to 32. Bits beyond 127 are 0.
    std::uint32_t take(int count) {
        if (count == 0) return 0;
        const std::uint32_t value = static_cast<std::uint32_t>(low_ & ((std::uint64_t{1} << count) - 1));
        low_ = low_ >> count | high_ << (64 - count);
        high_ >>= count;
        return value;
    }
    std::uint64_t low() const { return low_; }
    std::uint64_t high() const { return high_; }

private:
    std::uint64_t low_ = 0, high_ = 0;
};

/// A partition of BC6H and BC7 (the 32 of BC6H are the first of BC7's 64): the subset of each texel, and the anchor texels, whose index has
/// an implied highest bit.
struct Partition {
    std::uint32_t subsets;    ///< two bits a texel, texel 0 lowest
    std::uint8_t anchors[3];  ///< of subset 0, 1, 2; 0 is the first texel
    int subset(int texel) const { return static_cast<int>(subsets >> (2 * texel) & 3); }
};
const Partition& bptcPartition(int subsetCount, int index);

/// Interpolation weights of BC6H and BC7 in 64ths, for indices of 2, 3 and 4 bits.
std::span<const std::uint8_t> bptcWeights(int indexBits);

}  // namespace lightcook::verify

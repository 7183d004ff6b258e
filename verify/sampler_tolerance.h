// What a sampler is free to do with a texture, beside what our own texture unit sees.
//
// OpenGL, Vulkan and Direct3D leave open:
//   - the filter's fractions: at least 8 bits, rounded or cut, so that a sample is that of a place up to 1/256 texel away along each axis;
//   - the filter's arithmetic on formats of 8 bits: may itself be in 8 bits (Mesa's is), each of two blends off by less than a code;
//     on formats of 16 bits likewise in 16; on halves by a rounding each;
//   - the interpolated texels of BC1 to BC5: off by 0.03 of the difference of the block's ends and by 1/255 (Direct3D 11.3 functional
//     specification, 19.5.2 "Error Tolerance"; BC4 and BC5 by less than 1/255 there, but Mesa keeps 8 bits of them too). The values that
//     the specification reckons with are themselves rounded to 8 bits, so that it is two codes from the ideal ones. Khronos' specifications
//     say nothing. GPUs do use it: one maker multiplies by 48/65535 where 1/(5 255) is meant, 0.027 of the difference off
//     (fgiesen.wordpress.com/2021/10/04/gpu-bcn-decoding, held against this in tests/verify/texture/sampler_tolerance_test.cpp);
//   - of ASTC's LDR profile, which may be decoded to 8 bits: a code.
#pragma once

#include <cstddef>
#include <glm/common.hpp>
#include <glm/vec4.hpp>
#include <span>

#include "formats/gpu_texture.h"
#include "formats/image.h"

namespace lightcook::verify {

inline constexpr float kFractionFreedom = 1.0f / 256;  ///< [texels] along each axis

/// Of one texture format: a filtered value is within absolute + relative |largest texel| of the ideal filter's of texels that are within
/// `decoded` + perSpan (difference of the block's ends) of ours.
struct FormatFreedom {
    float absolute = 0, relative = 0;
    glm::vec4 decoded{0};
    glm::vec4 perSpan{0};
    bool hasSpans() const { return perSpan != glm::vec4(0); }
};
FormatFreedom freedomOf(formats::PixelFormat format);

/// Differences of the ends of every block's channels, one texel a block; no image for formats without perSpan.
/// blocks  whole rows of blocks of an image `width` texels wide
formats::Image<glm::vec4> blockSpans(formats::PixelFormat format, std::span<const std::byte> blocks, int width);

/// A layer's filtered texels over a quad: everything between its corners, and how far a sampler may be off there.
struct TexelBox {
    glm::vec4 centre{0}, half{0};  ///< the corners lie within centre +- half
    glm::vec4 freedom{0};
    glm::vec4 largest() const { return glm::abs(centre) + half + freedom; }
};

}  // namespace lightcook::verify

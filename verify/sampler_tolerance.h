// Sampler tolerance: how far the texture sampling of a conforming GPU may differ from our own texture unit.
//
// OpenGL, Vulkan and Direct3D leave open:
//   - the filter's fractions have at least 8 bits, rounded or truncated: a sample is that of a position up to 1/256 texel away on each
//   axis;
//   - the filter's arithmetic on 8-bit formats may have 8 bits (as in Mesa), where each of two blends is off by less than a code. The same
//     holds for 16 bits; on halves each blend may round once;
//   - the interpolated texels of BC1 to BC5: off by 0.03 of the difference of the block's endpoints and by 1/255 (Direct3D 11.3 functional
//     specification, 19.5.2 "Error Tolerance"). For BC4 and BC5 the specification allows less than 1/255, but Mesa decodes them to 8 bits.
//     The specification's own values are rounded to 8 bits, hence two codes from the ideal ones. Khronos' specifications give no numbers.
//     GPUs use the tolerance: one vendor multiplies by 48/65535 instead of 1/(5 255), 0.027 of the difference off
//     (fgiesen.wordpress.com/2021/10/04/gpu-bcn-decoding; tests/verify/texture/sampler_tolerance_test.cpp checks it);
//   - ASTC's LDR profile may be decoded to 8 bits: one code.
// docs/theory/bounds.md, "Sampler tolerance", describes how the bounds use it.
#pragma once

#include <cstddef>
#include <glm/common.hpp>
#include <glm/vec4.hpp>
#include <span>

#include "formats/gpu_texture.h"
#include "formats/image.h"

namespace lightcook::verify {

inline constexpr float kFractionTolerance = 1.0f / 256;  ///< [texels] along each axis

/// Tolerance of one texture format. A decoded texel is within `decoded` + perSpan * (difference of the block's endpoints) of ours. A
/// filtered value is within absolute + relative * |largest texel| of the ideal filter's value of such texels.
struct FormatTolerance {
    float absolute = 0, relative = 0;
    glm::vec4 decoded{0};
    glm::vec4 perSpan{0};
    bool hasSpans() const { return perSpan != glm::vec4(0); }
};
/// Returns the tolerance of a format.
FormatTolerance toleranceOf(formats::PixelFormat format);

/// Returns the difference of the two endpoints of every block by channel, one texel for each block; an empty image for formats without
/// perSpan.
/// blocks  whole rows of blocks of an image `width` texels wide
formats::Image<glm::vec4> blockSpans(formats::PixelFormat format, std::span<const std::byte> blocks, int width);

/// The range of a layer's filtered texels over a quad, and the largest sampler error there.
struct TexelBox {
    glm::vec4 centre{0}, half{0};  ///< the corners are within centre +- half
    glm::vec4 tolerance{0};
    glm::vec4 largest() const { return glm::abs(centre) + half + tolerance; }
};

}  // namespace lightcook::verify

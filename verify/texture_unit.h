// A software texture unit: independent decoders for every format that lightcook writes, and a GPU's filters. No code is shared with
// compress/.
#pragma once

#include <cstddef>
#include <filesystem>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <vector>

#include "formats/error.h"
#include "formats/gpu_texture.h"
#include "formats/image.h"

namespace lightcook::verify {

/// Decodes one block of the format into blockWidth * blockHeight texels, row by row. Missing channels are 0, a missing alpha is 1.
/// BC6H decodes to exact half floats, BC1 (without alpha) to BC5 by ideal real-valued interpolation, ASTC to the halves of an FP16 decoder.
/// Invalid blocks, which no encoder writes: reserved modes of BC6H and BC7 decode to zero, as Direct3D's specification demands. Illegal
/// ASTC blocks give the error colour: opaque magenta for the LDR format, NaN in every channel for the HDR formats. Texels of all other
/// blocks are finite, but for those that store such a number: formats of floats without blocks, ASTC HDR blocks of one colour, and
/// signed BC6H, of which an endpoint -32768 of 16 bits is minus infinity.
void decodeBlock(formats::PixelFormat format, std::span<const std::byte> block, std::span<glm::vec4> out);

/// Decodes the rows of blocks that cover out.height rows of texels.
void decodeRows(formats::PixelFormat format, std::span<const std::byte> blocks, formats::ImageView<glm::vec4> out);

/// Reads and decodes one image of a texture file. BC1 has the alpha that its container gives it: see formats::TextureReader::hasBc1Alpha().
formats::Result<formats::Image<glm::vec4>> decodeImage(const formats::TextureReader& texture, formats::SubImage image);

enum class Wrap { Clamp, Repeat };
/// Returns the bilinear sample at uv in [0, 1]^2, with texel centres at (i + 0.5) / size and unrounded fractions.
glm::vec4 sampleBilinear(formats::ImageView<const glm::vec4> image, glm::dvec2 uv, Wrap wrapX = Wrap::Clamp, Wrap wrapY = Wrap::Clamp);
/// Returns the seamless cubemap sample: filters across face edges as GL_TEXTURE_CUBE_MAP_SEAMLESS does. The missing fourth texel at a
/// corner of the cube is the mean of the other three.
/// faces      six square images of one size, +X -X +Y -Y +Z -Z
/// direction  any length but 0
glm::vec4 sampleCube(std::span<const formats::Image<glm::vec4>> faces, glm::dvec3 direction);

}  // namespace lightcook::verify

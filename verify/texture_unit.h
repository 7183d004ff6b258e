// A software texture unit: decoders of our own for every format we write, and the filters of a GPU. It shares nothing with compress/.
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

/// Decodes one block of the format into blockWidth * blockHeight texels, row by row. Channels that the format has not are 0, alpha 1.
/// Any bytes give finite or format-given values: reserved BC6H and BC7 modes decode to zero, as Direct3D's specification asks.
/// BC6H as half floats, exact; BC1 to BC5 by the ideal real-valued interpolation; ASTC as the halfs of an FP16 decoder. Illegal ASTC
/// blocks, which no encoder writes, give the error colour: opaque magenta for the LDR format, NaN in every channel for the HDR ones.
void decodeBlock(formats::PixelFormat format, std::span<const std::byte> block, std::span<glm::vec4> out);

/// Decodes rows of blocks that cover rows of texels out.height() high.
void decodeRows(formats::PixelFormat format, std::span<const std::byte> blocks, formats::ImageView<glm::vec4> out);

/// One image of a texture file, decoded.
formats::Result<formats::Image<glm::vec4>> decodeImage(const formats::TextureReader& texture, formats::SubImage image);

enum class Wrap { Clamp, Repeat };
/// Bilinear sample at uv in [0, 1]^2, texel centres at (i + 0.5) / size; exact fractions (no 8-bit rounding of them).
glm::vec4 sampleBilinear(formats::ImageView<const glm::vec4> image, glm::dvec2 uv, Wrap wrapX = Wrap::Clamp, Wrap wrapY = Wrap::Clamp);
/// Seamless cubemap sample (filters across face edges as GL_TEXTURE_CUBE_MAP_SEAMLESS; a corner's missing texel is the mean of its three).
/// faces  six square images of one size, +X -X +Y -Y +Z -Z; direction need not be unit
glm::vec4 sampleCube(std::span<const formats::Image<glm::vec4>> faces, glm::dvec3 direction);

}  // namespace lightcook::verify

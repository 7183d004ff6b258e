// Block decoders for the encoders' own use. verify/ has independent decoders, which share no code with these.
#pragma once

#include <array>
#include <cstddef>
#include <glm/vec4.hpp>

#include "compress/block/block.h"
#include "formats/pixel_format.h"

namespace lightcook::compress {

using DecodedBlock = std::array<glm::vec4, kTexelCount>;

// BC1 to BC5 are interpolated in real numbers, in [0, 1] or [-1, 1]; index 3 of BC1's three-colour mode is opaque black. BC6H gives exact
// halves, and minus infinity for endpoints of -32768. Reserved modes of BC6H and BC7 decode to 0.
void decodeBc1(const std::byte* block, bool alwaysFourColours, DecodedBlock& out);
void decodeBc3(const std::byte* block, DecodedBlock& out);
/// Decodes one channel, values in [0, 1].
std::array<float, kTexelCount> decodeBc4Channel(const std::byte* block);
void decodeBc4(const std::byte* block, DecodedBlock& out);
void decodeBc5(const std::byte* block, DecodedBlock& out);
void decodeBc4Snorm(const std::byte* block, DecodedBlock& out);
void decodeBc5Snorm(const std::byte* block, DecodedBlock& out);
void decodeBc6h(const std::byte* block, bool isSigned, DecodedBlock& out);
void decodeBc7(const std::byte* block, DecodedBlock& out);
/// Decodes a block of any of these formats; BC1 with its three-colour mode.
void decodeBlock(formats::PixelFormat format, const std::byte* block, DecodedBlock& out);

}  // namespace lightcook::compress

// Packs a block of the fast BC7 kernel, whose fields are already gathered in words.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace lightcook::compress {

struct Bc7Words {
    int mode = 6, partition = 0;
    std::array<std::uint32_t, 4> code{};    ///< of each channel: the codes of all ends from the lowest bit upwards, without low bits
    std::uint32_t low = 0;                  ///< low bits of all ends, or of all regions
    std::array<std::uint32_t, 2> index{};   ///< of texels 0 to 7 and 8 to 15, from the lowest bit upwards; of the colour in mode 5
    std::array<std::uint32_t, 2> second{};  ///< indices of alpha in mode 5
};

/// Writes 16 bytes. Ends are swapped where the anchor of their region would need the highest bit of its index, which is not stored.
/// Modes 1, 3, 5 (without rotation), 6 and 7 are supported.
void packBc7(const Bc7Words& words, std::byte* out);

/// Encodes a block of one colour, four values in 0 .. 255.
using Bc7OneColour = void(const std::array<float, 4>& colour, std::byte* out);

}  // namespace lightcook::compress

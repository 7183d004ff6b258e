// What every block encoder of this room starts from: sixteen texels, channel by channel, and how much each of them counts.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "compress/encode.h"

namespace lightcook::compress {

constexpr int kTexelCount = 16;  ///< of a 4x4 block

/// A 4x4 block, texel y * 4 + x, in planes. Missing texels repeat the edge and weigh nothing.
struct Block {
    alignas(64) std::array<std::array<float, kTexelCount>, 4> channel;
    alignas(64) std::array<float, kTexelCount> significance;  ///< >= 0, at least one above 0
    bool insignificant = false;                               ///< nothing counted: significance was set to 1, any cheap coding will do
};

/// Rows of texels as the kernels read them that need no blocks.
struct TexelRows {
    const float* texels;                ///< four a texel
    std::ptrdiff_t rowStride;           ///< [floats]
    const float* significance;          ///< one a texel, or null: 1 everywhere
    std::ptrdiff_t significanceStride;  ///< [floats]
    int width, height;                  ///< [texels]
};

/// Packs fields of a block from its lowest bit upwards.
class BitWriter {
public:
    void put(std::uint32_t value, int bitCount) {
        const std::uint64_t field = value & ((std::uint64_t{1} << bitCount) - 1);
        const int word = position_ >> 6, shift = position_ & 63;
        words_[static_cast<std::size_t>(word)] |= field << shift;
        if (shift + bitCount > 64) words_[1] |= field >> (64 - shift);
        position_ += bitCount;
    }
    /// The first byteCount bytes, little endian.
    void store(std::byte* out, std::size_t byteCount) const {
        for (std::size_t i = 0; i < byteCount; ++i) out[i] = static_cast<std::byte>(words_[i >> 3] >> (8 * (i & 7)));
    }

private:
    std::array<std::uint64_t, 2> words_ = {0, 0};
    int position_ = 0;
};

/// Reads what BitWriter wrote.
class BitReader {
public:
    BitReader(const std::byte* bytes, std::size_t byteCount) {
        for (std::size_t i = 0; i < byteCount; ++i) words_[i >> 3] |= static_cast<std::uint64_t>(bytes[i]) << (8 * (i & 7));
    }
    std::uint32_t get(int bitCount) {
        const std::size_t word = static_cast<std::size_t>(position_ >> 6);
        const int shift = position_ & 63;
        std::uint64_t field = words_[word] >> shift;
        if (shift + bitCount > 64) field |= words_[1] << (64 - shift);
        position_ += bitCount;
        return static_cast<std::uint32_t>(field & ((std::uint64_t{1} << bitCount) - 1));
    }

private:
    std::array<std::uint64_t, 2> words_ = {0, 0};
    int position_ = 0;
};

/// Blocks by the care that they need. Lists keep the order of the blocks.
struct BlockSorter {
    std::vector<std::pair<const Block*, std::size_t>> constant;  ///< one value wherever it counts, and a texel that has it
    std::vector<const Block*> varied, insignificant;
    BlockSorter(std::span<const Block> blocks, std::size_t channelCount);
};

// The encoders, block by block into consecutive places of out.
void encodeBc1(std::span<const Block> blocks, const EncodeOptions& options, std::byte* out);
void encodeBc3(std::span<const Block> blocks, const EncodeOptions& options, std::byte* out);
/// Channels are in [0, 1], or in [-1, 1] where signed.
void encodeBc4(std::span<const Block> blocks, bool isSigned, const EncodeOptions& options, std::byte* out);
/// One channel of each block into 8 bytes, stride bytes apart: unsigned BC4, half of BC5, the alpha of BC3.
void encodeBc4Channel(std::span<const Block> blocks, std::size_t channel, int effort, std::byte* out, std::size_t stride);
void encodeBc5(std::span<const Block> blocks, bool isSigned, const EncodeOptions& options, std::byte* out);
/// Whole rows of blocks of BC4 or BC5 at any effort but the exact 9; returns whether a value was clamped into the format's range.
bool encodeBc4Rows(const TexelRows& rows, int channelCount, bool isSigned, int effort, std::byte* out);
/// Channels are finite and in the format's range.
void encodeBc6h(std::span<const Block> blocks, bool isSigned, const EncodeOptions& options, std::byte* out);
void encodeBc7(std::span<const Block> blocks, const EncodeOptions& options, std::byte* out);

}  // namespace lightcook::compress

// The input of every block encoder: sixteen texels in planes, and the significance (error weight) of each; block I/O; the encoders.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "compress/encode_options.h"

namespace lightcook::compress {

inline constexpr int kBlockSide = 4, kTexelCount = kBlockSide * kBlockSide;

/// A 4x4 block in planes; the index of a texel is y * 4 + x. Texels beyond the edge of the image repeat the edge and have significance 0.
struct Block {
    alignas(64) std::array<std::array<float, kTexelCount>, 4> channel;
    alignas(64) std::array<float, kTexelCount> significance;  ///< >= 0, at least one above 0
    bool insignificant = false;  ///< all significances were 0 and have been set to 1; encoders use their fastest search
};

/// An image as the row kernels read it, without gathering blocks.
struct TexelRows {
    const float* texels;                ///< four floats per texel
    std::ptrdiff_t rowStride;           ///< [floats]
    const float* significance;          ///< one float per texel; null: 1 everywhere
    std::ptrdiff_t significanceStride;  ///< [floats]
    int width, height;                  ///< [texels]
};

/// Writes the bit fields of a block from its lowest bit upwards.
class BitWriter {
public:
    void put(std::uint32_t value, int bitCount) {
        const std::uint64_t field = value & ((std::uint64_t{1} << bitCount) - 1);
        const int word = position_ >> 6, shift = position_ & 63;
        words_[static_cast<std::size_t>(word)] |= field << shift;
        if (shift + bitCount > 64) words_[1] |= field >> (64 - shift);
        position_ += bitCount;
    }
    /// Writes the first byteCount bytes, little endian.
    void store(std::byte* out, std::size_t byteCount) const {
        for (std::size_t i = 0; i < byteCount; ++i) out[i] = static_cast<std::byte>(words_[i >> 3] >> (8 * (i & 7)));
    }

private:
    std::array<std::uint64_t, 2> words_ = {0, 0};
    int position_ = 0;
};

/// Reads the bit fields of a block from its lowest bit upwards.
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

/// Sorts blocks by the search that they need. Every list keeps the order of the blocks.
struct BlockSorter {
    /// Blocks whose significant texels are all equal, and the index of one of these texels.
    std::vector<std::pair<const Block*, std::size_t>> constant;
    std::vector<const Block*> varied;         ///< all others that have significant texels
    std::vector<const Block*> insignificant;  ///< all others
    BlockSorter(std::span<const Block> blocks, std::size_t channelCount);
};

// The encoders write one block after the other to out. Values are in the range of the format.
void encodeBc1(std::span<const Block> blocks, const EncodeOptions& options, std::byte* out);
void encodeBc3(std::span<const Block> blocks, const EncodeOptions& options, std::byte* out);
/// Encodes channel 0.
void encodeBc4(std::span<const Block> blocks, bool isSigned, const EncodeOptions& options, std::byte* out);
/// Encodes one channel of each block as unsigned BC4, 8 bytes every stride bytes: for BC4, a half of BC5, or the alpha of BC3.
void encodeBc4Channel(std::span<const Block> blocks, std::size_t channel, int effort, std::byte* out, std::size_t stride);
void encodeBc5(std::span<const Block> blocks, bool isSigned, const EncodeOptions& options, std::byte* out);
/// Encodes whole rows of blocks as BC1 or, with alpha, BC3, at any effort but 9, whose searches need whole blocks. Returns true if a value
/// was clamped into [0, 1].
bool encodeBc1Rows(const TexelRows& rows, bool hasAlpha, const EncodeOptions& options, std::byte* out);
/// Encodes whole rows of blocks as BC4 or BC5, at any effort but 9, which is exhaustive. Returns true if a value was clamped into the
/// range of the format.
bool encodeBc4Rows(const TexelRows& rows, int channelCount, bool isSigned, int effort, std::byte* out);
void encodeBc6h(std::span<const Block> blocks, bool isSigned, const EncodeOptions& options, std::byte* out);
/// Encodes whole rows of blocks as BC7 by the fast kernel, at efforts 0 to 2. Returns true if a value was clamped into the range of the
/// format.
bool encodeBc7Rows(const TexelRows& rows, const EncodeOptions& options, std::byte* out);
/// Encodes blocks as BC7 by the full search.
void encodeBc7(std::span<const Block> blocks, const EncodeOptions& options, std::byte* out);

}  // namespace lightcook::compress

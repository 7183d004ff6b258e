// Pictures of 8 and 16 bits made number by number, with or without alpha, for the tests of bake formats.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "tests/formats/temporary_folder.h"

namespace lightcook::formats {

/// The byte of a channel (0 to 3: R, G, B, A) at texel (x, y).
using ByteValue = std::function<int(int channel, int x, int y)>;

/// Returns `value` as four bytes, the most significant first.
inline std::string bigEndian(std::uint32_t value) {
    std::string bytes;
    for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 0xff);
    return bytes;
}

/// Returns a chunk of a PNG file: length, name, content and CRC-32.
inline std::string pngChunk(const std::string& name, const std::string& content) {
    const std::string named = name + content;
    std::uint32_t crc = 0xffffffff;
    for (const char byte : named) {
        crc ^= static_cast<std::uint8_t>(byte);
        for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ ((crc & 1) != 0 ? 0xedb88320u : 0u);
    }
    return bigEndian(static_cast<std::uint32_t>(content.size())) + named + bigEndian(~crc);
}

/// Writes a PNG of 8 or 16 bits a channel, not compressed: a deflate block of stored bytes a row.
/// channelCount  1 (grey), 2 (grey and alpha), 3 or 4
inline void writePngOf(int bits, const std::filesystem::path& file, int width, int height, int channelCount, const ByteValue& value) {
    std::string stream = "\x78\x01";
    std::uint32_t low = 1, high = 0;  // of Adler-32
    for (int y = 0; y < height; ++y) {
        std::string row(1, '\0');  // the filter "none"
        for (int x = 0; x < width; ++x)
            for (int channel = 0; channel < channelCount; ++channel) {
                const int number = value(channel, x, y);
                if (bits == 16) row += static_cast<char>(number >> 8 & 0xff);
                row += static_cast<char>(number & 0xff);
            }
        const auto size = static_cast<std::uint32_t>(row.size());
        stream += static_cast<char>(y + 1 == height);
        for (const std::uint32_t length : {size, ~size})
            for (const int shift : {0, 8}) stream += static_cast<char>(length >> shift & 0xff);
        stream += row;
        for (const char byte : row) {
            low = (low + static_cast<std::uint8_t>(byte)) % 65521;
            high = (high + low) % 65521;
        }
    }
    stream += bigEndian(high << 16 | low);
    std::string header = bigEndian(static_cast<std::uint32_t>(width)) + bigEndian(static_cast<std::uint32_t>(height));
    constexpr std::array kColourTypes = {0, 0, 4, 2, 6};  // of 1 to 4 channels
    for (const int byte : {bits, kColourTypes.at(static_cast<std::size_t>(channelCount)), 0, 0, 0}) header += static_cast<char>(byte);
    writeContent(file, "\x89PNG\r\n\x1a\n" + pngChunk("IHDR", header) + pngChunk("IDAT", stream) + pngChunk("IEND", ""));
}
inline void writePng(const std::filesystem::path& file, int width, int height, int channelCount, const ByteValue& value) {
    writePngOf(8, file, width, height, channelCount, value);
}
/// value  0 to 65535
inline void writePng16(const std::filesystem::path& file, int width, int height, int channelCount, const ByteValue& value) {
    writePngOf(16, file, width, height, channelCount, value);
}

}  // namespace lightcook::formats

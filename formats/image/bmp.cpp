#include "formats/image/bmp.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "formats/file/file_bytes.h"
#include "formats/image/image_claims.h"

namespace lightcook::formats {
namespace {

// Offsets from the start of the file: BITMAPFILEHEADER has 14 bytes, then the information header begins.
constexpr std::size_t kTexelsAt = 10, kHeaderAt = 14, kWidthAt = 18, kHeightAt = 22, kBitsAt = 28, kCompressionAt = 30, kMasksAt = 54;
constexpr std::size_t kMostHeaderBytes = kMasksAt + 4 * sizeof(std::uint32_t);
/// biCompression, and the sizes of the headers from which on masks of colours and of alpha are in every file.
constexpr std::uint32_t kRgb = 0, kBitFields = 3, kAlphaBitFields = 6, kBytesOfV1 = 40, kBytesOfV3 = 56;

struct BmpHeader {
    int width = 0, height = 0;
    bool isTopDown = false;
    std::uint32_t bits = 0;                ///< of a texel: 16 or 32
    std::uint64_t texelsAt = 0;            ///< [bytes]
    std::array<std::uint32_t, 4> masks{};  ///< of R, G, B and A; 0: there is none
};

/// Returns the header of a picture that this file reads. Empty: of another one.
std::optional<BmpHeader> readHeader(const FileBytes& file) {
    std::array<std::byte, kMostHeaderBytes> bytes{};
    const std::size_t count = std::min<std::size_t>(file.size(), bytes.size());
    if (count < kMasksAt || !file.readAt(0, std::span(bytes).first(count))) return std::nullopt;
    if (bytes[0] != std::byte{'B'} || bytes[1] != std::byte{'M'}) return std::nullopt;
    const std::uint32_t headerBytes = loadU32(bytes, kHeaderAt), compression = loadU32(bytes, kCompressionAt);
    BmpHeader header;
    header.bits = loadU32(bytes, kBitsAt) & 0xffff;
    if (headerBytes < kBytesOfV1 || (header.bits != 16 && header.bits != 32)) return std::nullopt;
    const auto width = std::bit_cast<std::int32_t>(loadU32(bytes, kWidthAt)),
               height = std::bit_cast<std::int32_t>(loadU32(bytes, kHeightAt));
    if (width < 1 || width > kLargestExtent || height == 0 || height < -kLargestExtent || height > kLargestExtent) return std::nullopt;
    header.width = width;
    header.height = std::abs(height);
    header.isTopDown = height < 0;
    header.texelsAt = loadU32(bytes, kTexelsAt);
    if (compression == kRgb) {
        header.masks = header.bits == 16 ? std::array{0x7c00u, 0x03e0u, 0x001fu, 0u} : std::array{0xff0000u, 0x00ff00u, 0x0000ffu, 0u};
        return header;
    }
    if (compression != kBitFields && compression != kAlphaBitFields) return std::nullopt;
    const bool hasAlpha = headerBytes >= kBytesOfV3 || compression == kAlphaBitFields;
    for (std::size_t i = 0; i < (hasAlpha ? 4u : 3u); ++i) header.masks[i] = loadU32(bytes, kMasksAt + 4 * i);
    return header;
}

Result<PlainImage> readTexels(const FileBytes& file, const BmpHeader& header) {
    const Subject subject(file.path());
    LC_CHECK(checkExtent(header.width, header.height, 4, 8, subject));
    const std::size_t texelBytes = header.bits / 8, rowBytes = (static_cast<std::size_t>(header.width) * texelBytes + 3) / 4 * 4;
    const std::uint64_t end = header.texelsAt + std::uint64_t{rowBytes} * static_cast<std::uint64_t>(header.height);
    if (file.size() < end)
        return failure(ErrorCode::FileUnreadable, subject,
                       fmt::format("found {} bytes, expected a BMP of {}: truncated", file.size(), end));
    PlainImage image{.texels = Image<glm::vec4>(header.width, header.height, glm::vec4(0, 0, 0, 1)),
                     .channelCount = header.masks[3] != 0 ? 4 : 3,
                     .hasAlpha = header.masks[3] != 0};
    std::vector<std::byte> row(rowBytes);
    for (int y = 0; y < header.height; ++y) {
        LC_CHECK(file.readAt(header.texelsAt + static_cast<std::uint64_t>(y) * rowBytes, row));
        glm::vec4* const out = image.texels.view().row(header.isTopDown ? y : header.height - 1 - y);
        for (int x = 0; x < header.width; ++x) {
            std::uint32_t texel = 0;
            for (std::size_t i = texelBytes; i-- > 0;)
                texel = texel << 8 | std::to_integer<std::uint32_t>(row[static_cast<std::size_t>(x) * texelBytes + i]);
            for (std::size_t i = 0; i < 4; ++i) {
                const std::uint32_t mask = header.masks[i];
                if (mask == 0) continue;
                const int shift = std::countr_zero(mask);
                out[x][static_cast<glm::length_t>(i)] =
                    static_cast<float>(static_cast<double>((texel & mask) >> shift) / static_cast<double>(mask >> shift));
            }
        }
    }
    return image;
}

}  // namespace

std::optional<Result<PlainImage>> readMaskedBmp(const std::filesystem::path& file) {
    const auto opened = FileBytes::openForReading(file);
    if (!opened) return std::nullopt;
    const auto header = readHeader(*opened);
    return header ? std::optional(readTexels(*opened, *header)) : std::nullopt;
}

}  // namespace lightcook::formats

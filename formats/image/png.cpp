#include "formats/png.h"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "formats/file/one_line.h"
#include "formats/image/image_module.h"

namespace lightcook::formats {
namespace {

constexpr std::string_view kSignature = "\x89PNG\r\n\x1a\n";

/// Returns the remainders of the bytes 0 to 255 for CRC-32.
constexpr std::array<std::uint32_t, 256> crcTable() {
    std::array<std::uint32_t, 256> table{};
    for (std::uint32_t byte = 0; byte < table.size(); ++byte) {
        std::uint32_t remainder = byte;
        for (int bit = 0; bit < 8; ++bit) remainder = remainder >> 1 ^ ((remainder & 1) != 0 ? 0xedb88320u : 0u);
        table.at(byte) = remainder;
    }
    return table;
}

/// Returns the CRC-32 of PNG (ISO 3309).
std::uint32_t crcOf(std::span<const std::byte> bytes) {
    static constexpr std::array kTable = crcTable();
    std::uint32_t crc = 0xffffffff;
    for (const std::byte byte : bytes) crc = crc >> 8 ^ kTable.at((crc ^ std::to_integer<std::uint32_t>(byte)) & 0xff);
    return ~crc;
}

/// Returns four bytes as a number, the most significant first.
std::uint32_t numberAt(std::span<const std::byte> bytes, std::size_t at) {
    std::uint32_t number = 0;
    for (const std::byte byte : bytes.subspan(at, 4)) number = number << 8 | std::to_integer<std::uint32_t>(byte);
    return number;
}

/// Describes the fault of the chunks after the signature of a PNG: length, name, content and checksum each, IHDR first, then IDAT among
/// others, IEND last. libpng prints a line of its own for most faults.
std::optional<std::string> faultOfChunks(std::span<const std::byte> chunks) {
    constexpr std::size_t kHead = 8, kChecksum = 4;
    bool isFirst = true, hasTexels = false;
    while (chunks.size() >= kHead + kChecksum) {
        const std::size_t length = numberAt(chunks, 0);
        if (length > chunks.size() - kHead - kChecksum) break;
        const std::string_view name(reinterpret_cast<const char*>(chunks.data()) + 4, 4);
        if (crcOf(chunks.subspan(4, 4 + length)) != numberAt(chunks, kHead + length))
            return fmt::format("a PNG whose chunk \"{}\" has another checksum", oneLine(name));
        if (isFirst && name != "IHDR") return fmt::format("a PNG whose first chunk is \"{}\"", oneLine(name));
        if (name == "IEND") return hasTexels ? std::nullopt : std::optional<std::string>("a PNG without texels");
        isFirst = false;
        hasTexels = hasTexels || name == "IDAT";
        chunks = chunks.subspan(kHead + length + kChecksum);
    }
    return "a PNG without its end";
}

}  // namespace

Result<PlainImage> decodePng(std::span<const std::byte> png, const std::string& subject) {
    if (!std::string_view(reinterpret_cast<const char*>(png.data()), png.size()).starts_with(kSignature))
        return failure(ErrorCode::FormatUnsupported, subject, "found an image of another kind, expected PNG");
    if (const auto fault = faultOfChunks(png.subspan(kSignature.size())))
        return failure(ErrorCode::FileUnreadable, subject, fmt::format("found {}, expected a whole image file", *fault));
    const auto module = imageModule();
    return module ? (*module)->decodePng(png, subject) : tl::make_unexpected(module.error());
}

}  // namespace lightcook::formats

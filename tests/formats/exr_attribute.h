// Attributes put into the header of an OpenEXR file that is there already, without OpenEXR.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>

namespace lightcook::formats {

/// Returns a file of scan lines with one more attribute.
/// value  its bytes
inline std::string withAttribute(std::string exr, const std::string& name, const std::string& type, const std::string& value) {
    const auto bytesOf = [](auto number) {
        std::string bytes(sizeof number, '\0');
        std::memcpy(bytes.data(), &number, sizeof number);
        return bytes;
    };
    const std::string attribute = name + '\0' + type + '\0' + bytesOf(static_cast<std::uint32_t>(value.size())) + value;
    std::size_t end = 8;  // of the header: behind the last attribute
    while (exr[end] != '\0') {
        for (int text = 0; text < 2; ++text) end = exr.find('\0', end) + 1;  // name and type
        std::uint32_t size = 0;
        std::memcpy(&size, exr.data() + end, sizeof size);
        end += sizeof size + size;
    }
    // The places of the chunks, in a table between header and first chunk.
    const auto numberAt = [&](std::size_t at) {
        std::uint64_t number = 0;
        std::memcpy(&number, exr.data() + at, sizeof number);
        return number;
    };
    const std::uint64_t firstChunk = numberAt(end + 1);
    for (std::size_t at = end + 1; at < firstChunk; at += sizeof(std::uint64_t))
        exr.replace(at, sizeof(std::uint64_t), bytesOf(numberAt(at) + attribute.size()));
    return exr.insert(end, attribute);
}

/// Returns a file of scan lines with the attribute `chromaticities`: CIE x, y of red, green, blue and white.
inline std::string withChromaticities(std::string exr, const std::array<float, 8>& xy) {
    std::string value(sizeof xy, '\0');
    std::memcpy(value.data(), xy.data(), sizeof xy);
    return withAttribute(std::move(exr), "chromaticities", "chromaticities", value);
}

}  // namespace lightcook::formats

// The container of binary glTF, for tests that write one.
#pragma once

#include <cstddef>
#include <string>

namespace lightcook::formats {

/// Returns a GLB file with a JSON chunk and a BIN chunk, each padded to four bytes (glTF 2.0, "GLB File Format Specification").
inline std::string glbOf(std::string json, std::string binary) {
    json.resize((json.size() + 3) / 4 * 4, ' ');
    binary.resize((binary.size() + 3) / 4 * 4, '\0');
    std::string glb = "glTF";
    const auto word = [&glb](std::size_t value) {
        for (int byte = 0; byte < 4; ++byte) glb += static_cast<char>(value >> (8 * byte));
    };
    word(2);
    word(12 + 8 + json.size() + 8 + binary.size());
    word(json.size());
    glb += "JSON" + json;
    word(binary.size());
    return glb + std::string("BIN\0", 4) + binary;
}

}  // namespace lightcook::formats
